//! Sets of states and of choices: the interface between the algorithms and the two engines.
//!
//! - [`Engine`]: the operations on sets. Its doc comments give their formulas.
//! - [`SymbolicEngine`]: sets are binary decision diagrams (OxiDD).
//! - [`ExplicitEngine`]: states are stored one by one.
//! - [`AnyEngine`]: either of them, selected at run time by [`Settings`].
//! - [`Selection`]: where nothing names the engine, several ways to the answer of a whole [`RacedQuestion`] race (`race`): the
//!   explicit engine, diagrams in several orders of the bits, and for the initial states alone diagrams over all
//!   valuations and a guided search ([`Guided`]).
//!
//! Modules: [`mod@any`] (either engine), [`edge_labels`] (games on goal, dropped and plain edges), [`explicit`],
//! [`membership`] (tests of many states), `race` (ways in turns, on several threads), [`regions`] (the four regions of a
//! target), `schedule` (methods of a fixpoint in turns), `selection` (the ways to an answer), `settings`, [`symbolic`],
//! [`until`] (one temporal operator over sets), and `diagrams` (sets for dumps).
//!
//! An engine has two sorts of sets: sets of states and sets of *choices*. A choice set contains
//! pairs (s, a) of a state s of the scope and an enabled choice a. All algorithms of planning use
//! only these operations; iteration over states is not part of the interface.
//!
//! ```
//! use meliora_engine::{Algebra, Engine, Settings, SymbolicEngine, regions::regions};
//! use meliora_base::error::SourceFile;
//!
//! let model = "mdp module m x : [0..3] init 0; [] x<2 -> (x'=x+1); endmodule";
//! let none = SourceFile::new("--const", "");
//! let program = meliora_lang::load(&SourceFile::new("m.prism", model), &none)?.program;
//! let engine = SymbolicEngine::new(program.into(), Settings::default())?;
//! let sure = regions(&engine, &engine.singleton(&[2])?)?.pmin_one;
//! assert!(engine.is_empty(&engine.difference(&engine.initial_states(), &sure)?)?);
//! # Ok::<(), meliora_base::error::Error>(())
//! ```

pub mod any;
mod diagrams;
pub mod edge_labels;
mod engine;
pub mod explicit;
pub mod membership;
mod race;
pub mod regions;
mod schedule;
mod selection;
mod settings;
pub mod symbolic;
pub mod until;

pub use any::AnyEngine;
pub use diagrams::Dumpable;
pub use edge_labels::EdgeLabels;
pub use engine::{Algebra, Engine, Region, Won, position};
pub use explicit::{ExplicitEngine, Guided, Guiding};
pub use meliora_base::progress::{NoProgress, ProgressSink};
pub use selection::{BySearch, OverAll, RacedQuestion, Racer, Selection};
pub use settings::{Count, Scope, Settings, Storage, Usage};
pub use symbolic::{Order, SymbolicEngine};
