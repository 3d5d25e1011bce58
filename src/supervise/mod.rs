//! Long work on a worker thread, with cancellation, limits on time and memory, and progress
//! (feature `supervise`).
//!
//! A [`Supervisor`] is shared by the worker thread and the thread that waits for it. It is the
//! cancellation token and the progress sink of the library: give it to an engine as
//! [`crate::Settings::sink`]. [`spawn`] starts the work; [`Worker::wait`] returns its result, or the
//! reason why it was cancelled.
//!
//! This is the only module of the library that keeps threads for its callers, and that reads the
//! clock and the memory of the process and of the machine.

mod duration;
pub mod memory;
mod supervisor;
mod worker;

pub use duration::parse_duration;
pub use supervisor::{Interval, Position, Supervisor, TimeLimit, lock};
pub use worker::{Failure, Reporter, Worker, spawn};
