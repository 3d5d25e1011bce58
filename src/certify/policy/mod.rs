//! Checks of policies by the one-step semantics of the model, state by state, without an engine and without planning.
//!
//! - [`rules`]: lists of rules, which reach one goal.
//! - [`nodes`]: policies with memory, which make improvements or achieve objectives.
//!
//! Both lead to a finite graph of what a policy visits, in which the promise is decided.

mod graph;
mod levels;
pub mod nodes;
mod pursuits;
pub mod rules;
mod runs;
mod space;

pub use nodes::{Accepted, Aim, Node, NodePolicy, Promise, Taking};
pub use runs::NodeRun;
