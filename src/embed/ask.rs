//! Properties of a model, answered as the command does.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use super::Model;
use super::model::lock;
use meliora_base::error::{Error, Limit, Result};
use meliora_base::progress::ProgressSink;
use meliora_engine::{Selection, Settings, Usage};
use meliora_model::Program;
use meliora_quantities::PRECISION;
use meliora_question::answers::PropertyAnswer;
use meliora_question::plan::Planned;
use meliora_question::{
    Answers, Listener, Options, Questions, Strategies, Wanted, Warning, list, pipeline, race,
};

/// Requirements and wishes next to properties, and the engine that answers these.
#[derive(Debug, Clone)]
pub struct Ask {
    /// Safe formulas that every strategy must keep: `G p`.
    pub require: Vec<String>,
    /// The largest width of a number, relative to the number above 1.
    pub precision: f64,
    /// The strategies that are wanted of the only property.
    pub strategies: Wanted,
    /// The engine; [`Selection::open`] lets several ways race.
    pub engine: Selection,
}

impl Default for Ask {
    fn default() -> Self {
        let (require, strategies) = Default::default();
        Ask { require, precision: PRECISION, strategies, engine: Selection::open() }
    }
}

/// The answers to properties.
#[derive(Debug)]
pub struct Asked {
    /// The answers, as far as they are known.
    pub answers: Answers,
    /// The strategies that were asked for.
    pub strategies: Strategies,
    /// The warnings.
    pub warnings: Vec<Warning>,
    /// The resources that the engine has used.
    pub usage: Option<Usage>,
    /// The limit that has ended the work before all properties had an answer.
    pub limit: Option<Limit>,
}

impl Model {
    /// Returns the question of a planning problem: whether a plan reaches its goal almost surely; `None` if there is no
    /// goal that must hold.
    pub fn goal_property(&self) -> Option<&'static str> {
        list::of_goal(self.program())
    }

    /// Answers properties, each a text or a name of the model's: conditions on states, whose operators ask for
    /// probabilities, rewards, several objectives. Requests about the initial states are answered before all states are
    /// known where one of several ways can do so. Properties share their regions. One that is not answered has a reason if
    /// it is one of several; see [`Answers`].
    ///
    /// ```
    /// use meliora::{Ask, Model, Settings};
    ///
    /// let model = Model::parse("mdp
    ///     module walk
    ///       x : [0..3] init 0;
    ///       [left] x=0 -> 1/4: (x'=1) + 3/4: (x'=3);
    ///       [right] x=0 -> (x'=2);
    ///       [stay] x>0 -> true;
    ///     endmodule", "")?;
    /// let asked = ["Pmax=? [ F x=1 ]", "!(Pmax>=1 [ F x=1 ]) & Pmax>=1 [ F x=2 ]"];
    /// let found = model.ask(&asked, &Ask::default(), Settings::default())?.answers;
    /// let value = found.properties[0].value.clone().flatten().unwrap();
    /// assert!(value.lower <= 0.25 && 0.25 <= value.upper);
    /// assert_eq!(found.properties[1].holds, Some(true));
    /// # Ok::<(), meliora::Error>(())
    /// ```
    ///
    /// # Errors
    /// A text is wrong, each error with its place; the only property cannot be answered; the errors of
    /// [`Model::explore`], save that a limit leaves the answers so far.
    pub fn ask(&self, properties: &[&str], ask: &Ask, settings: Settings) -> Result<Asked> {
        let program = Program::clone(self.program());
        let required = list::required("require", ask.require.iter().map(String::as_str))?;
        let texts = ("property", properties.iter().copied());
        let plan = list::planned((&program, &self.properties), texts, &required, false)?;
        let questions = Questions::new(program, plan, required, false);
        let options = Options {
            selected: ask.engine.clone(),
            precision: ask.precision,
            is_one: properties.len() == 1,
            regions: false,
            strategies: ask.strategies,
            settings,
        };
        answered(&questions, &options)
    }
}

/// Answers questions; a limit leaves the answers so far.
fn answered(questions: &Questions, options: &Options) -> Result<Asked> {
    let open = |property: &Planned| PropertyAnswer::open(None, property.text.clone(), None);
    let properties = questions.plan.properties.iter().map(open).collect();
    let state = State { answers: Answers { properties, ..Answers::default() }, ..State::default() };
    let sink = Arc::clone(&options.settings.sink);
    let limit = sink.remaining();
    let kept = Kept { state: Arc::new(Mutex::new(state)), sink: Arc::new(Shared::new(sink, limit, None)) };
    let (strategies, limit) = match pipeline::answer(&kept, options, questions) {
        Ok(strategies) => (strategies, None),
        Err(Error::Limit(limit)) => (Strategies::default(), Some(limit)),
        Err(error) => return Err(error),
    };
    let State { answers, warnings, usage, .. } = lock(&kept.state).clone();
    Ok(Asked { answers, strategies, warnings, usage, limit })
}

/// Answers that are kept while others are found, for a way of a race.
struct Kept {
    state: Arc<Mutex<State>>,
    sink: Arc<Shared>,
}

#[derive(Clone, Default)]
struct State {
    answers: Answers,
    warnings: Vec<Warning>,
    usage: Option<Usage>,
    /// The limit that has ended the first share of the work.
    ended: Option<Limit>,
}

/// The sink of the caller, with the end of a share of the time.
struct Shared {
    sink: Arc<dyn ProgressSink>,
    /// The time that all of the work has.
    limit: Option<Duration>,
    /// The end of the share on the clock of the caller.
    end: Mutex<Option<Duration>>,
}

impl Shared {
    fn new(sink: Arc<dyn ProgressSink>, limit: Option<Duration>, end: Option<Duration>) -> Self {
        Shared { sink, limit, end: Mutex::new(end) }
    }
}

impl ProgressSink for Shared {
    fn stop(&self) -> Option<Limit> {
        let is_late = || lock(&self.end).is_some_and(|end| end <= self.sink.clock());
        let late = || is_late().then(|| Limit::Share(self.limit.unwrap_or_default()));
        self.sink.stop().or_else(late)
    }

    fn advance(&self, steps: u64) {
        self.sink.advance(steps);
    }

    fn clock(&self) -> Duration {
        self.sink.clock()
    }

    fn remaining(&self) -> Option<Duration> {
        self.sink.remaining()
    }

    fn progress(&self, phase: &'static str, detail: &dyn Fn() -> String) {
        self.sink.progress(phase, detail);
    }
}

impl race::Job for Kept {
    fn copy(&self) -> Self {
        let state = Arc::new(Mutex::new(lock(&self.state).clone()));
        Kept { state, sink: Arc::clone(&self.sink) }
    }

    fn of_way(&self, _: usize) -> Self {
        let Shared { sink, limit, end } = &*self.sink;
        let sink = Shared::new(Arc::clone(sink), *limit, *lock(end));
        Kept { sink: Arc::new(sink), ..self.copy() }
    }

    fn sink(&self) -> Arc<dyn ProgressSink> {
        Arc::clone(&self.sink) as _
    }

    fn begin(&self) {}

    fn built(&self, _: &Selection) {}

    fn leave_to(&self, way: Self) -> Self {
        Kept { state: Arc::clone(&self.state), sink: way.sink }
    }

    fn take(&self, other: &Self) {
        if !Arc::ptr_eq(&self.state, &other.state) {
            let state = lock(&other.state).clone();
            *lock(&self.state) = state;
        }
    }
}

impl Listener for Kept {
    fn change(&self, change: &mut dyn FnMut(&mut Answers)) {
        change(&mut lock(&self.state).answers);
    }

    fn used(&self, usage: Usage) {
        let known = &mut lock(&self.state).usage;
        *known = Some(match *known {
            Some(known) if known.peak_nodes > usage.peak_nodes => known,
            _ => usage,
        });
    }

    fn begin(&self, _: &'static str) {}

    fn end(&self, _: &'static str, _: &'static str) {}

    fn warn(&self, warning: Warning) {
        lock(&self.state).warnings.push(warning);
    }

    fn stop(&self) -> Option<Limit> {
        self.sink.sink.stop()
    }

    fn share(&self, parts: Option<usize>) {
        let parts = parts.and_then(|parts| u32::try_from(parts).ok()?.checked_add(1));
        let left = parts.and_then(|parts| Some(self.sink.remaining()? / parts));
        *lock(&self.sink.end) = left.map(|left| self.sink.clock() + left);
    }

    fn end_share(&self, limit: Limit) {
        lock(&self.state).ended.get_or_insert(limit);
    }

    fn ended_share(&self) -> Option<Limit> {
        lock(&self.state).ended.take()
    }
}
