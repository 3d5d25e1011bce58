//! Limits of the solver: memory, time and the user.

use meliora_base::error::{Error, Limit, Result};
use meliora_base::progress::{Poll, ProgressSink};
use meliora_engine::Engine;

/// The number of small pieces of work after which the progress is shown.
const SHOWN: usize = 1 << 8;

/// Counts the bytes of the solver's arrays, and asks the progress sink whether to go on.
pub struct Meter<'o> {
    poll: Poll<'o>,
    bytes: u64,
    limit: u64,
}

impl<'o> Meter<'o> {
    /// Creates a meter for what an engine leaves of its memory.
    pub fn new<E: Engine>(engine: &'o E) -> Self {
        Meter::within(engine.settings().memory, engine)
    }

    /// Creates a meter for what an engine leaves of all memory, for work that costs the same on each way of a race.
    pub fn settled<E: Engine>(engine: &'o E) -> Self {
        Meter::within(engine.settings().settle(), engine)
    }

    fn within<E: Engine>(memory: u64, engine: &'o E) -> Self {
        let limit = memory.saturating_sub(engine.usage().bytes).max(memory / 4);
        Meter { poll: Poll::new(&*engine.settings().sink), bytes: 0, limit }
    }

    /// Creates a meter for some bytes.
    pub(crate) fn with(limit: u64, sink: &'o dyn ProgressSink) -> Self {
        Meter { poll: Poll::new(sink), bytes: 0, limit }
    }

    /// Creates a meter without a limit.
    #[cfg(test)]
    pub(crate) fn unlimited(sink: &'o dyn ProgressSink) -> Self {
        Meter { poll: Poll::new(sink), bytes: 0, limit: u64::MAX }
    }

    /// Counts bytes that are kept.
    ///
    /// # Errors
    /// The memory limit is reached, or the work is cancelled.
    #[inline]
    pub fn take(&mut self, bytes: usize) -> Result<()> {
        self.bytes += bytes as u64;
        if self.bytes > self.limit {
            let what = format!("the quantities would exceed {} bytes", self.limit);
            return Err(Limit::Memory { what }.into());
        }
        self.step()
    }

    /// Gives bytes back.
    pub fn release(&mut self, bytes: usize) {
        self.bytes = self.bytes.saturating_sub(bytes as u64);
    }

    /// Returns the bytes that are kept.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes as usize
    }

    /// Returns the bytes that are left.
    pub(crate) fn left(&self) -> u64 {
        self.limit.saturating_sub(self.bytes)
    }

    /// Gives all but these bytes back.
    pub(crate) fn release_to(&mut self, bytes: usize) {
        self.bytes = bytes as u64;
    }

    /// Counts one of many small steps.
    ///
    /// # Errors
    /// The work is cancelled.
    #[inline]
    pub fn step(&mut self) -> Result<()> {
        Ok(self.poll.step()?)
    }

    /// Converts a position.
    ///
    /// # Errors
    /// The position does not fit 32 bits.
    pub(crate) fn number(&self, position: usize) -> Result<u32> {
        // The greatest number has a meaning of its own.
        match u32::try_from(position) {
            Ok(number) if number < u32::MAX => Ok(number),
            _ => {
                Err(Limit::Size { what: "the quantities need more than 2^32 nodes or edges".to_owned() }
                    .into())
            }
        }
    }

    /// Reports the progress of one of many small pieces of work, by its number: not of all of them, since to report
    /// takes longer than the work.
    pub fn progress_at(&self, number: usize, detail: &dyn Fn() -> String) {
        if number.is_multiple_of(SHOWN) {
            self.progress(detail);
        }
    }

    /// Reports the progress.
    pub(crate) fn progress(&self, detail: &dyn Fn() -> String) {
        self.poll.sink().progress("quantities", detail);
    }
}

/// The reason why a method has no bounds.
#[derive(Debug)]
pub(crate) enum Stop {
    /// The budget is used up; the method may go on.
    Later,
    /// The method finds none.
    Never,
    /// A limit is reached.
    Limit(Error),
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Stop::Limit(error)
    }
}

/// The result of a method after a turn.
pub(crate) type Turn<T> = std::result::Result<T, Stop>;

/// Takes some work from the rest of a turn.
///
/// # Errors
/// More is needed: later.
pub(crate) fn spend(left: &mut usize, work: usize) -> Turn<()> {
    *left = left.checked_sub(work).ok_or(Stop::Later)?;
    Ok(())
}
