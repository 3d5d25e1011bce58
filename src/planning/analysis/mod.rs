//! The analysis: winning regions, classes, the improvement MDP and its levels, phase by phase.

pub mod classes;
pub mod improvement;
pub mod joint;
pub(crate) mod level_search;
pub mod levels;
mod phases;
mod prospects;
pub mod region_search;
pub mod regions;
pub mod requirements;
pub mod result;
mod run;
mod safety;
pub mod temporal;
pub(crate) mod temporal_game;
pub mod winning_regions;

pub use run::{Analysis, Event, Options, Phase};
pub use safety::Safety;
