//! The progress sink of a run: a line on the terminal, and messages with `-v`.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use meliora::supervise::{Supervisor, lock};
use meliora_base::error::{Diagnostic, Limit};
use meliora_base::escape;
use meliora_engine::ProgressSink;
use meliora_question::Warning;

use super::options::ShownArgs;
use super::progress_line::ProgressLine;
use super::terminal;

/// Progress is shown after this time.
const QUIET_AT_FIRST: Duration = Duration::from_secs(1);

/// Shows the progress of a supervised run.
pub(super) struct TerminalSink {
    pub(super) supervisor: Arc<Supervisor>,
    /// The phase of the library that was reported last.
    reported: Mutex<&'static str>,
    /// The phases that have begun and not ended, each inside of the one before, with the ends of the phases before them.
    open: Mutex<Vec<(&'static str, Instant)>>,
    /// The end of the last phase; before the first one, the start.
    last_end: Mutex<Instant>,
    line: Mutex<Option<ProgressLine>>,
    quiet: bool,
    verbose: u8,
    /// The end of the share of the time that the work has now.
    share: Mutex<Option<Instant>>,
    /// The limit that ended a share of the work.
    ended: Mutex<Option<Limit>>,
    /// The warnings of a way that is not shown, and the texts of those that were written.
    held: Mutex<Vec<Warning>>,
    warned: Mutex<Vec<String>>,
    /// The place of the sink in a race.
    lane: Lane,
}

/// The place of a sink in a race.
enum Lane {
    /// It is the sink of the whole run; with the way whose progress and messages are shown, once there is one.
    Whole(Mutex<Option<usize>>),
    /// It is the sink of a way of this run.
    Way(Arc<TerminalSink>, usize),
}

impl TerminalSink {
    pub(super) fn new(supervisor: &Arc<Supervisor>, shown: &ShownArgs) -> Self {
        TerminalSink {
            supervisor: Arc::clone(supervisor),
            reported: Mutex::default(),
            open: Mutex::default(),
            last_end: Mutex::new(Instant::now()),
            line: Mutex::default(),
            quiet: shown.quiet,
            verbose: shown.verbose,
            share: Mutex::default(),
            ended: Mutex::default(),
            held: Mutex::default(),
            warned: Mutex::default(),
            lane: Lane::Whole(Mutex::default()),
        }
    }

    /// Returns the sink of a way of a race. Its messages are kept until the way is shown.
    pub(super) fn of_way(self: &Arc<Self>, way: usize) -> Self {
        TerminalSink {
            supervisor: Arc::clone(&self.supervisor),
            reported: Mutex::default(),
            open: Mutex::new(lock(&self.open).clone()),
            last_end: Mutex::new(self.last_end()),
            line: Mutex::default(),
            quiet: self.quiet,
            verbose: self.verbose,
            share: Mutex::new(*lock(&self.share)),
            ended: Mutex::default(),
            held: Mutex::default(),
            warned: Mutex::default(),
            lane: Lane::Way(Arc::clone(self), way),
        }
    }

    /// Shows the progress and the messages of one way from now on, or of all if there is none.
    pub(super) fn show(&self, way: Option<&TerminalSink>) {
        let Lane::Whole(shown) = &self.lane else { return };
        *lock(shown) = way.and_then(|way| if let Lane::Way(_, way) = way.lane { Some(way) } else { None });
        let Some(way) = way else { return };
        *lock(&self.last_end) = way.last_end();
        lock(&self.open).clone_from(&lock(&way.open));
        let held = std::mem::take(&mut *lock(&way.held));
        held.into_iter().for_each(|message| self.tell(message));
        if let Some(limit) = lock(&way.ended).take() {
            self.end_share(limit);
        }
    }

    /// Returns the sink of the run if this one is shown: that itself, or that of its way. Before a way is shown, the
    /// progress of all is.
    fn shown(&self, is_progress: bool) -> Option<&TerminalSink> {
        let Lane::Way(whole, own) = &self.lane else { return Some(self) };
        let Lane::Whole(shown) = &whole.lane else { return None };
        let is_shown = lock(shown).map_or(is_progress, |shown| shown == *own);
        is_shown.then_some(whole)
    }

    /// Checks for cancellation, for work outside of the library's loops.
    ///
    /// # Errors
    /// The limit that ends the work.
    pub(super) fn check(&self) -> Result<(), Limit> {
        self.stop().map_or(Ok(()), Err)
    }

    /// Limits the work that follows to its share of the remaining time, if `parts` such parts are left and one more;
    /// `None` ends this limit.
    pub(super) fn share(&self, parts: Option<usize>) {
        *lock(&self.share) = parts.and_then(|parts| self.supervisor.share(parts));
    }

    /// Notes that a share of the work has ended by a limit.
    pub(super) fn end_share(&self, limit: Limit) {
        lock(&self.ended).get_or_insert(limit);
    }

    /// Returns the limit that has ended the first share of the work.
    pub(super) fn ended_share(&self) -> Option<Limit> {
        lock(&self.ended).take()
    }

    /// Shows that a part of a phase begins; without a part, the phase.
    pub(super) fn report(&self, phase: &'static str, part: String) {
        if self.verbose > 1 && !part.is_empty() {
            self.say_with_time(&part);
        }
        if let Some(shown) = self.shown(true) {
            shown.supervisor.set_position(phase, part);
            shown.refresh();
        }
    }

    /// Shows that a phase begins.
    pub(super) fn enter(&self, phase: &'static str) {
        let start = self.last_end();
        lock(&self.open).push((phase, start));
        self.report(phase, String::new());
    }

    /// Shows the phase around one that has ended, if there is one.
    fn leave(&self, phase: &str) {
        let mut open = lock(&self.open);
        if let Some(at) = open.iter().rposition(|(own, _)| *own == phase) {
            open.truncate(at);
            if let Some(&(outer, _)) = open.last() {
                self.report(outer, String::new());
            }
        }
    }

    /// Shows that a phase has ended, with its seconds. They count from the end of the last phase, so that all
    /// phases add up to the whole run; of a phase with parts, only the rest is shown. Returns them.
    pub(super) fn finished(&self, phase: &str) -> f64 {
        let now = Instant::now();
        let last = std::mem::replace(&mut *lock(&self.last_end), now);
        let seconds = now.duration_since(last).as_secs_f64();
        if self.verbose > 0 {
            self.say(&format!("{phase}: {seconds:.3} s"));
        }
        self.leave(phase);
        seconds
    }

    /// Returns the end of the phase before one that has begun: what lies between them prepares it.
    pub(super) fn start(&self, phase: &str) -> Instant {
        let known = lock(&self.open).iter().rev().find(|(own, _)| *own == phase).map(|(_, start)| *start);
        known.unwrap_or_else(|| self.last_end())
    }

    /// Returns the end of the last phase.
    pub(super) fn last_end(&self) -> Instant {
        *lock(&self.last_end)
    }

    /// Writes a warning to stderr.
    pub(super) fn warn(&self, text: &str) {
        self.tell(Warning::Text(text.to_owned()));
    }

    /// Writes warnings that point into a text.
    pub(super) fn warn_at(&self, warnings: &[Diagnostic]) {
        if !warnings.is_empty() {
            self.tell(Warning::Pointed(warnings.to_vec()));
        }
    }

    /// Writes a warning, unless another way has done so; keeps it if this way is not shown.
    pub(super) fn tell(&self, message: Warning) {
        let Some(shown) = self.shown(false) else { return lock(&self.held).push(message) };
        let text = format!("{message:?}");
        if shown.quiet || lock(&shown.warned).contains(&text) {
            return;
        }
        match &message {
            Warning::Text(text) => {
                let warning = terminal::stderr_style().warn("warning");
                shown.say(&format!("{warning}: {text}"));
            }
            Warning::Pointed(warnings) => shown.beside_line(|| terminal::point(warnings)),
        }
        lock(&shown.warned).push(text);
    }

    /// Writes a note for `-v`.
    pub(super) fn note(&self, text: &str) {
        if self.verbose > 0 {
            self.say(&format!("note: {text}"));
        }
    }

    fn say(&self, text: &str) {
        if let Some(shown) = self.shown(true) {
            shown.beside_line(|| terminal::message(text));
        }
    }

    /// Hides the progress line while something else is written.
    fn beside_line(&self, write: impl FnOnce()) {
        let mut line = lock(&self.line);
        if let Some(line) = &mut *line {
            line.clear();
        }
        write();
    }

    fn say_with_time(&self, text: &str) {
        self.say(&format!("{:9.3} s  {text}", self.supervisor.elapsed().as_secs_f64()));
    }

    /// Describes how far the work got.
    pub(super) fn position(&self) -> Option<String> {
        let position = self.supervisor.position();
        match (position.phase, position.words()) {
            ("", _) => None,
            (phase, words) if words.is_empty() => Some(format!("stopped in the phase `{phase}`")),
            (phase, words) => Some(format!("stopped in the phase `{phase}` ({words})")),
        }
    }

    /// Shows progress once the work has taken a while.
    pub(super) fn tick(&self) {
        if !self.quiet && self.supervisor.elapsed() > QUIET_AT_FIRST {
            lock(&self.line).get_or_insert_with(ProgressLine::new);
        }
        self.refresh();
    }

    fn refresh(&self) {
        if let Some(line) = &mut *lock(&self.line) {
            line.draw(self.supervisor.elapsed(), &escape::line(&self.supervisor.position().line()));
        }
    }

    /// Removes the progress from the terminal.
    pub(super) fn clear(&self) {
        if let Some(mut line) = lock(&self.line).take() {
            line.clear();
        }
    }
}

impl ProgressSink for TerminalSink {
    fn stop(&self) -> Option<Limit> {
        let is_late = || lock(&self.share).is_some_and(|end| end <= Instant::now());
        self.supervisor.stop().or_else(|| is_late().then(|| self.supervisor.late()))
    }

    fn clock(&self) -> Duration {
        self.supervisor.clock()
    }

    fn progress(&self, phase: &'static str, detail: &dyn Fn() -> String) {
        // The first message of each phase is always shown, so that short work shows some too.
        let Some(shown) = self.shown(true) else { return };
        let is_new = self.verbose > 1 && std::mem::replace(&mut *lock(&shown.reported), phase) != phase;
        if !self.supervisor.wants_detail() && !is_new {
            return;
        }
        let detail = format!("{phase}: {}", detail());
        if self.verbose > 1 {
            self.say_with_time(&detail);
        }
        self.supervisor.set_detail(detail);
    }
}
