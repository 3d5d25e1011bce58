//! Deterministic automata for temporal formulas.
//!
//! A formula in negation normal form ([`Formulas`]) is divided into leaves ([`leaves()`]);
//! formulas that no leaf covers are normalised first. Each leaf has a [`Monitor`], built by progression
//! and made minimal. The crate knows neither the syntax of formulas nor engines: state formulas are
//! expressions of the program's pool.
//!
//! ```
//! use meliora_base::value::Type;
//! use meliora_ltl::{Form, Formulas, Leaf, Monitor, Tree, Window, leaves};
//! use meliora_model::VarId;
//! use meliora_model::expr::ExprPool;
//!
//! // G F a: the monitor has one state, and marks the steps that read a.
//! let mut pool = ExprPool::default();
//! let a = pool.var(VarId(0), Type::Bool);
//! let mut all = Formulas::new();
//! let a = all.add(Form::Literal(a, true));
//! let eventually = all.add(Form::Until(Window::ALWAYS, Formulas::TRUE, a));
//! let again = all.add(Form::Release(Window::ALWAYS, Formulas::FALSE, eventually));
//! let Ok(Tree::Leaf(Leaf { watched, .. })) = leaves(&mut all, again) else { unreachable!() };
//! assert_eq!(Monitor::owing(&all, watched)?.states.len(), 1);
//! # Ok::<(), meliora_base::error::Error>(())
//! ```

mod breakpoints;
mod formulas;
mod functions;
mod joint;
mod leaves;
mod minimal;
mod monitor;
mod normalisation;
mod progression;
mod simplification;

pub use formulas::{Form, FormulaId, Formulas, Window};
pub use joint::Joint;
pub use leaves::{Leaf, TooLarge, Tree, leaves};
pub use minimal::Settled;
pub use monitor::{Decision, DecisionId, Decisions, Monitor};
