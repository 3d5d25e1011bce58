//! Planning: winning regions, improvement MDP, levels and strategies, written once for all engines.
//!
//! - [`Analysis`]: runs all phases one after the other and keeps its results when a limit is
//!   reached.
//! - [`Levels`]: the states with one, two, … improvements.
//! - [`FiniteMemoryStrategy`]: what to do in a state, and why ([`Explanation`]).
//!
//! | The paper | here |
//! | --- | --- |
//! | (beyond the paper) requirements | [`requirements`] |
//! | outcomes, MP(s) | [`winning_regions`], [`classes`] |
//! | Definition "Improvement MDP" | [`improvement`] |
//! | Algorithm "Level set", rank | [`levels`] |
//! | SPI and SASI strategies | [`strategy`], [`finite_memory`] |
//!
//! [`Analysis`] runs them one after the other and keeps its results when a limit is reached.
//! [`explain`] says why an action is permitted, [`induced_model`] computes the states that a
//! strategy may visit, [`simulate`] draws random runs, and [`shield`] makes a table of permitted
//! actions.
//!
//! # An example
//!
//! ```
//! use std::sync::Arc;
//!
//! use meliora_engine::{Settings, SymbolicEngine};
//! use meliora_base::error::SourceFile;
//! use meliora_planning::{Analysis, Kind, Options, Rank};
//!
//! let model = "mdp module m x : [0..2] init 0; [] x<2 -> (x'=x+1); [] x=2 -> true; endmodule";
//! let wishes = "objective Near = F x=1; objective Far = F x=2; prefer Far > Near;";
//! let none = SourceFile::new("--const", "");
//! let program = meliora_lang::load(&SourceFile::new("m.prism", model), &none)?.program;
//! let meliora_lang::Task { program, preferences } = meliora_lang::load_preferences(&SourceFile::new("m.pref", wishes), program)?;
//! let engine = SymbolicEngine::new(Arc::new(program), Settings::default())?;
//! let mut analysis = Analysis::new(&Arc::new(engine), &Arc::new(preferences), Options::default());
//! analysis.run(&mut |_| ())?;
//! assert_eq!(analysis.most_preferred(&[0])?, ["Far"]);
//! assert_eq!(analysis.rank(Kind::Sasi, &[0])?, Rank::Finite(0));
//! # Ok::<(), meliora_base::error::Error>(())
//! ```

mod analysis;
pub mod shield;
mod simulation;
mod strategies;

pub use analysis::{
    classes, improvement, joint, levels, region_search, regions, requirements, result, temporal,
    winning_regions,
};
pub use simulation::{estimate, induced_model, simulate, tally};
pub use strategies::{explain, finite_memory, lasso, policy, strategy};

pub use analysis::{Analysis, Event, Options, Phase, Safety};
pub use classes::{Class, Classes};
pub use estimate::Sample;
pub use explain::Explanation;
pub use finite_memory::{FiniteMemoryStrategy, Memory, StrategyKind};
pub use improvement::Improvement;
pub use induced_model::{InducedModel, Scheduler};
pub use lasso::Lasso;
pub use levels::{Kind, Levels, Rank, improvable};
pub use region_search::RegionSearch;
pub use requirements::Requirements;
pub use result::AnalysisResult;
pub use shield::{Shield, ShieldAction, ShieldNode, ShieldVariable, ValueRule};
pub use simulate::{Setup, Simulation};
pub use simulation::Opponent;
pub use strategies::{DecisionRule, Threat};
