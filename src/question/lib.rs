//! Properties of a model, from the text to the answer.
//!
//! - [`goal`]: the goal of the paths, a target or a condition on monitors, and the requirements.
//! - [`asking`]: a question about the initial states.
//! - [`plan`]: the requests that properties need.
//! - [`under`]: the answers to requests under requirements.
//! - [`evaluate`]: properties as expressions over states.

pub mod asking;
pub mod evaluate;
pub mod goal;
pub mod plan;
mod start;
mod stopping;
pub mod under;

pub use asking::{Asking, only_query};
pub use goal::{Goal, Required, Target};
pub use start::check_start;
pub use stopping::Stopping;
pub use under::Under;
