//! Shares of the time limit, one for each property of a list: a dear one never costs the others their answers.

use meliora_base::error::{Error, Limit};
use meliora_engine::ProgressSink;

use super::progress::TerminalSink;

/// The reason for a property that is not answered in its share.
const NO_TIME: &str = "its share of the time limit ended; `--timeout` gives more time, and `--only NAME` all of it to one property";

/// The shares of some pieces of work that follow one another.
pub(super) struct Shares<'a> {
    sink: &'a TerminalSink,
    left: usize,
    is_alone: bool,
}

impl<'a> Shares<'a> {
    /// Divides the remaining time among some pieces of work.
    pub(super) fn of(sink: &'a TerminalSink, pieces: usize) -> Self {
        Shares { sink, left: pieces, is_alone: pieces < 2 }
    }

    /// Does the next piece of work. A piece that needs less than its share leaves more to the others. Returns the reason
    /// if a limit ends this piece alone.
    ///
    /// # Errors
    /// The errors of the work; a limit of all of it.
    pub(super) fn next<T>(
        &mut self,
        work: impl FnOnce() -> Result<T, Error>,
    ) -> Result<Result<T, String>, Error> {
        self.left = self.left.saturating_sub(1);
        if self.left > 0 {
            self.sink.share(Some(self.left));
        }
        let found = work();
        self.sink.share(None);
        match found {
            Err(Error::Limit(limit)) if !self.is_alone && self.sink.stop().is_none() => {
                let reason = match &limit {
                    Limit::Share(_) => NO_TIME.to_owned(),
                    other => other.to_string(),
                };
                self.sink.end_share(limit);
                Ok(Err(reason))
            }
            found => found.map(Ok),
        }
    }
}
