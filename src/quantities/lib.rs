//! Quantities: how likely improvements are, how soon they come, and at what cost.
//!
//! - [`Values`]: the results of a finished analysis, as intervals or fractions.
//! - [`Cost`]: what a step costs, by default one ([`Steps`]).
//! - [`Chooser`]: lets a strategy choose by value.
//! - [`sought`]: the number that an operator asks for, such as `Pmax=? [ F x=3 ]`, in some states.
//!
//! | quantity | meaning |
//! | --- | --- |
//! | P_k | the greatest probability of k improvements |
//! | C_k | where P_k = 1: the least expected cost until the k-th improvement |
//! | N | the largest expected number of improvements |
//! | P_k^n | the greatest probability of k improvements within n steps |
//!
//! The choices are those that the safety mode keeps. Under `transition`, a successor that weakens is
//! lost: its probability counts as failure.
//!
//! # Modules
//!
//! | module | contents |
//! | --- | --- |
//! | [`exploration`], `facts`, `explore`, `places`, [`cost`] | from an [`Analysis`](meliora_planning::Analysis) to a graph: the states that kept choices reach, with exact probabilities and costs |
//! | [`values`], [`state_values`], [`all_states`] | the results of an analysis: [`Values`], also as plain data |
//! | [`choose`] | strategies that attain the values |
//! | [`by_goal`] | how likely the first improvement gains each objective |
//! | [`outlook`] | what a strategy promises |
//! | [`confirmed`] | bounds that one step confirms, for certificates |
//! | [`sought`] | probabilities of formulas and rewards until a target, without preferences |
//! | [`optimal`], [`followed`], `chain` | strategies that attain the optimum of one operator; strategies, followed |
//! | [`actions`] | the value after each action, from those of all states |
//!
//! The equations and their solvers are those of [`meliora_equations`].
//!
//! The levels give qualitative facts for free: P_k > 0 on level k of SPI, and P_k = 1 on level k of
//! SASI (under `transition`: of SASI under `action`). Only states between the two have equations.
//! If at most one improvement is possible, N = P_1.
//!
//! # An example
//!
//! ```
//! use std::sync::Arc;
//!
//! use meliora_engine::{ExplicitEngine, Settings};
//! use meliora_base::error::SourceFile;
//! use meliora_planning::{Analysis, Options};
//! use meliora_quantities::{ValueOptions, Steps, Values};
//!
//! let model = "mdp module m x : [0..2] init 0; [] x=0 -> 1/4: (x'=1) + 3/4: (x'=2); [] x>0 -> true; endmodule";
//! let wishes = "objective Lucky = F x=1;";
//! let none = SourceFile::new("--const", "");
//! let program = meliora_lang::load(&SourceFile::new("m.prism", model), &none)?.program;
//! let meliora_lang::Task { program, preferences } = meliora_lang::load_preferences(&SourceFile::new("m.pref", wishes), program)?;
//! let program = Arc::new(program);
//! let engine = ExplicitEngine::new(Arc::clone(&program), Settings::default())?;
//! let mut analysis = Analysis::new(&Arc::new(engine), &Arc::new(preferences), Options::default());
//! analysis.run(&mut |_| ())?;
//! let options = ValueOptions { levels: 1, exact: false, within: None };
//! let values = Values::compute(options, &analysis, &program, &[vec![0]], &Steps)?;
//! let start = values.start(&[0]).unwrap();
//! assert_eq!(values.probability(start, 1).interval.lower, 0.25);
//! # Ok::<(), meliora_base::error::Error>(())
//! ```

pub mod actions;
pub mod all_states;
pub mod by_goal;
mod chain;
pub mod choose;
pub mod confirmed;
pub mod cost;
mod distances;
pub mod exploration;
mod explore;
mod facts;
pub mod followed;
pub mod optimal;
pub mod outlook;
mod places;
pub mod sought;
pub mod state_values;
pub mod values;

pub use choose::{Achiever, Choose, Chooser, ValuedRule};
pub use cost::{Cost, Earned, Steps};
pub use exploration::Exploration;
pub use meliora_base::interval::{Bounds, Interval, PRECISION};
pub use values::{Aim, ChoiceValues, Node, ValueOptions, Values};
