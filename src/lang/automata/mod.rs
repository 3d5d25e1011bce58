//! Deterministic automata for temporal formulas.
//!
//! A formula in negation normal form ([`Formulas`]) is divided into leaves ([`leaves`]);
//! formulas that no leaf covers are normalised first. Each leaf has a [`Monitor`], built by progression and made
//! minimal. The room knows neither the syntax of formulas nor engines: state formulas are expressions
//! of the program's pool.

mod formulas;
mod functions;
mod joint;
mod leaves;
mod minimal;
mod monitor;
mod normalisation;
mod progression;
mod simplification;

pub(crate) use formulas::{Form, FormulaId, Formulas, Window};
pub(crate) use joint::Joint;
pub(crate) use leaves::{Leaf, TooLarge, Tree, leaves};
pub(crate) use minimal::{Settled, steps};
pub(crate) use monitor::{Decision, DecisionId, Monitor};
