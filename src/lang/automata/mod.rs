//! Deterministic automata for temporal formulas.
//!
//! A formula in negation normal form ([`Normal`]) is a Boolean combination of leaves ([`leaves`]), each co-safe, safe,
//! a recurrence or a persistence. Each leaf has a [`Monitor`], built by progression and made minimal. The room knows
//! neither the syntax of formulas nor engines: state formulas are expressions of the program's pool.

mod functions;
mod leaves;
mod minimal;
mod monitor;
mod normal;
mod progression;

pub(crate) use leaves::{Refused, Tree, leaves};
pub(crate) use minimal::{Settled, steps};
pub(crate) use monitor::{Decision, DecisionId, Monitor};
pub(crate) use normal::{Form, Normal, Window};
