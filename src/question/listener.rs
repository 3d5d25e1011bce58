//! The listener to the work: it keeps the answers while they are found.

use crate::answers::Answers;
use crate::warnings::Warning;
use meliora_base::error::{Error, Limit, Result};
use meliora_engine::Usage;

/// Keeps the answers while they are found, and hears of the work. Partial answers are there whenever the work ends.
pub trait Listener: Sync {
    /// Changes the answers.
    fn change(&self, change: &mut dyn FnMut(&mut Answers));

    /// Hears of the resources that an engine has used so far.
    fn used(&self, usage: Usage);

    /// Hears that a piece of work with a name begins.
    fn begin(&self, name: &'static str);

    /// Hears that it has ended. Its time is a part of that of a phase.
    fn end(&self, name: &'static str, phase: &'static str);

    /// Hears of something that the user may not expect.
    fn warn(&self, warning: Warning);

    /// Returns the limit that all of the work has reached.
    fn stop(&self) -> Option<Limit>;

    /// Limits the work that follows to its share of the remaining time, if `parts` such parts are left and one more;
    /// `None` ends this limit.
    fn share(&self, parts: Option<usize>);

    /// Notes that a share of the work has ended by a limit.
    fn end_share(&self, limit: Limit);

    /// Returns the limit that has ended the first such share.
    fn ended_share(&self) -> Option<Limit>;
}

impl dyn Listener + '_ {
    /// Changes the answers.
    pub(crate) fn update(&self, change: impl FnOnce(&mut Answers)) {
        let mut change = Some(change);
        self.change(&mut |answers| {
            if let Some(change) = change.take() {
                change(answers);
            }
        });
    }

    /// Does a piece of work that has a name, as a part of a phase.
    ///
    /// # Errors
    /// The errors of the work.
    pub(crate) fn timed<T>(
        &self,
        (name, phase): (&'static str, &'static str),
        work: impl FnOnce() -> Result<T>,
    ) -> Result<T> {
        self.begin(name);
        let found = work()?;
        self.end(name, phase);
        Ok(found)
    }
}

/// The reason for a property that is not answered in its share.
const NO_TIME: &str = "its share of the time limit ended; `--timeout` gives more time, and `--only NAME` all of it to one property";

/// The shares of the time limit of some pieces of work that follow one another: a dear one never costs the others their
/// answers.
pub(crate) struct Shares<'a> {
    listener: &'a dyn Listener,
    left: usize,
    is_alone: bool,
}

impl<'a> Shares<'a> {
    /// Divides the remaining time among some pieces of work.
    pub(crate) fn of(listener: &'a dyn Listener, pieces: usize) -> Self {
        Shares { listener, left: pieces, is_alone: pieces < 2 }
    }

    /// Does the next piece of work. A piece that needs less than its share leaves more to the others. Returns the reason
    /// if a limit ends this piece alone.
    ///
    /// # Errors
    /// The errors of the work; a limit of all of it.
    pub(crate) fn next<T>(&mut self, work: impl FnOnce() -> Result<T>) -> Result<Result<T, String>> {
        self.left = self.left.saturating_sub(1);
        if self.left > 0 {
            self.listener.share(Some(self.left));
        }
        let found = work();
        self.listener.share(None);
        match found {
            Err(Error::Limit(limit)) if !self.is_alone && self.listener.stop().is_none() => {
                let reason = match &limit {
                    Limit::Share(_) => NO_TIME.to_owned(),
                    other => other.to_string(),
                };
                self.listener.end_share(limit);
                Ok(Err(reason))
            }
            found => found.map(Ok),
        }
    }
}
