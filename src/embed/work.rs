//! Long work, with a report that grows: the results so far are there whenever the work ends.

use std::sync::{Arc, Mutex};

use meliora_base::error::Result;
use meliora_base::progress::ProgressSink;
use meliora_base::sync::lock;
use meliora_question::{Warning, race};

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

/// A report that is kept while it grows, without times; its ways may race. The warnings are kept with it.
pub struct Kept<R> {
    state: Arc<Mutex<(R, Vec<Warning>)>>,
    sink: Arc<dyn ProgressSink>,
}

impl<R> Kept<R> {
    /// Begins with a report.
    pub fn new(report: R, sink: Arc<dyn ProgressSink>) -> Self {
        Kept { state: Arc::new(Mutex::new((report, Vec::new()))), sink }
    }
}

impl<R: Clone> Kept<R> {
    /// Returns the report so far, and the warnings.
    pub fn known(&self) -> (R, Vec<Warning>) {
        lock(&self.state).clone()
    }
}

impl<R: Send> Work<R> for Kept<R> {
    fn change(&self, change: &mut dyn FnMut(&mut R)) {
        change(&mut lock(&self.state).0);
    }

    fn begin(&self, _: &'static str) {}

    fn end(&self, _: &'static str) -> f64 {
        0.0
    }

    fn part(&self, _: &'static str, _: &str) {}

    fn warn(&self, warning: Warning) {
        lock(&self.state).1.push(warning);
    }

    fn note(&self, _: &str) {}

    fn share(&self, _: Option<usize>) {}

    fn sink(&self) -> Arc<dyn ProgressSink> {
        Arc::clone(&self.sink)
    }
}

impl<R: Clone + Send> race::Job for Kept<R> {
    fn copy(&self) -> Self {
        Kept { state: Arc::new(Mutex::new(self.known())), sink: Arc::clone(&self.sink) }
    }

    fn sink(&self) -> Arc<dyn ProgressSink> {
        Arc::clone(&self.sink)
    }

    fn leave_to(&self, way: Self) -> Self {
        Kept { state: Arc::clone(&self.state), sink: way.sink }
    }

    fn take(&self, other: &Self) {
        if !Arc::ptr_eq(&self.state, &other.state) {
            let known = other.known();
            *lock(&self.state) = known;
        }
    }
}
