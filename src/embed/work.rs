//! Long work, with a report that grows: the results so far are there whenever the work ends.

use std::sync::Arc;

use super::kept::Kept;
use meliora_base::error::Result;
use meliora_base::progress::ProgressSink;
use meliora_question::Warning;

/// Keeps the report `R` of some work while it grows, and hears of the work.
pub trait Work<R>: Sync {
    /// Changes the report.
    fn change(&self, change: &mut dyn FnMut(&mut R));

    /// Hears that a piece of work with a name begins.
    fn begin(&self, name: &'static str);

    /// Hears that it has ended. Returns its seconds.
    fn end(&self, name: &'static str) -> f64;

    /// Hears that a part of it begins.
    fn part(&self, name: &'static str, part: &str);

    /// Hears of something that the user may not expect.
    fn warn(&self, warning: Warning);

    /// Hears of something that is as expected, and that not all users want to know.
    fn note(&self, text: &str);

    /// Limits the work that follows to its share of the remaining time, if `parts` such parts are left and one more;
    /// `None` ends this limit.
    fn share(&self, parts: Option<usize>);

    /// Returns the sink of the progress.
    fn sink(&self) -> Arc<dyn ProgressSink>;
}

impl<R> dyn Work<R> + '_ {
    /// Changes the report.
    pub(super) fn update(&self, change: impl FnOnce(&mut R)) {
        let mut change = Some(change);
        self.change(&mut |report| {
            if let Some(change) = change.take() {
                change(report);
            }
        });
    }

    /// Does a piece of work that has a name. `note` notes its seconds in the report.
    ///
    /// # Errors
    /// The errors of the work.
    pub(super) fn timed<T>(
        &self,
        name: &'static str,
        work: impl FnOnce() -> Result<T>,
        note: impl FnOnce(&mut R, f64),
    ) -> Result<T> {
        self.begin(name);
        let found = work()?;
        let seconds = self.end(name);
        self.update(|r| note(r, seconds));
        Ok(found)
    }

    /// Warns with a sentence.
    pub(super) fn say(&self, text: impl Into<String>) {
        self.warn(Warning::Text(text.into()));
    }

    /// Checks for cancellation.
    ///
    /// # Errors
    /// The limit that ends the work.
    pub(super) fn check(&self) -> Result<()> {
        self.sink().stop().map_or(Ok(()), |limit| Err(limit.into()))
    }
}

impl<R: Send> Work<R> for Kept<R> {
    fn change(&self, change: &mut dyn FnMut(&mut R)) {
        Kept::change(self, change);
    }

    fn begin(&self, _: &'static str) {}

    fn end(&self, _: &'static str) -> f64 {
        0.0
    }

    fn part(&self, _: &'static str, _: &str) {}

    fn warn(&self, warning: Warning) {
        Kept::warn(self, warning);
    }

    fn note(&self, _: &str) {}

    fn share(&self, parts: Option<usize>) {
        Kept::share(self, parts);
    }

    fn sink(&self) -> Arc<dyn ProgressSink> {
        Kept::sink(self)
    }
}
