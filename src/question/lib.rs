//! Properties of a model, from the text to the answer.
//!
//! - [`goal`]: the goal of the paths, a target or a condition on monitors, and the requirements.
//! - [`asking`]: a question about the initial states.
//! - [`plan`]: the requests that properties need.
//! - [`pipeline`]: all requests are answered, each by the first of several ways to end ([`race`]); a [`Listener`] has
//!   the [`answers`] so far.
//! - `answering`: requests with one engine, [`under`] requirements; [`answer`]: the verdict or the number.
//! - [`evaluate`], `states`: other properties, as expressions over states.
//! - [`shield`]: permitted actions by the probabilities after them.
//! - [`regions`]: the regions of properties, as diagrams.

pub mod answer;
mod answering;
pub mod answers;
pub mod asking;
pub mod evaluate;
pub mod goal;
pub mod list;
pub mod listener;
pub mod number;
pub mod pipeline;
pub mod plan;
pub mod questions;
pub mod race;
pub mod regions;
pub mod shield;
mod start;
mod states;
mod stopping;
pub mod strategies;
pub mod under;
pub mod warnings;

pub use answer::{Answer, Computing};
pub use answers::Answers;
pub use asking::{Asking, only_query};
pub use goal::{PathGoal, Required, Target};
pub use listener::Listener;
pub use number::Number;
pub use questions::{Options, PolicyKind, Questions, Strategies, WantedStrategies};
pub use race::{Job, started};
pub use start::check_start;
pub use stopping::Stopping;
pub use under::Under;
pub use warnings::Warning;
