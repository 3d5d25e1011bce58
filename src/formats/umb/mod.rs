//! The unified Markov binary format (UMB), version 1: models state by state as a tar archive of a
//! JSON index and binary arrays.
//!
//! [`index`] has the index, [`archive`] the files, and [`binary`] the arrays in them.
//! `formats/table/umb.rs` reads models from these, and `export/explicit/umb.rs` writes them. The
//! specification is at <https://github.com/pmc-tools/umb>.

pub mod archive;
pub mod binary;
pub mod index;
mod unpacked;

/// The index, the first file of the archive.
pub const INDEX: &str = "index.json";
/// For each state, the number of its first choice; last, the number of choices.
pub const STATE_TO_CHOICES: &str = "state-to-choices.bin";
/// For each state of a game, its player.
pub const STATE_TO_PLAYER: &str = "state-to-player.bin";
/// The set of initial states.
pub const STATE_IS_INITIAL: &str = "state-is-initial.bin";
/// For each choice, the number of its first branch; last, the number of branches.
pub const CHOICE_TO_BRANCHES: &str = "choice-to-branches.bin";
/// For each branch, its target.
pub const BRANCH_TO_TARGET: &str = "branch-to-target.bin";
/// For each branch, its probability.
pub const BRANCH_TO_PROBABILITY: &str = "branch-to-probability.bin";
/// For each choice, the number of its action.
pub const ACTION_OF_CHOICE: &str = "actions/choices/values.bin";
/// The folder of the names of actions.
pub const ACTION_NAMES: &str = "actions/choices";
/// The folder of the values of state variables.
pub const STATE_VALUATIONS: &str = "valuations/states";

/// Returns the folder of an annotation of states, choices or branches.
pub fn annotation(group: &str, id: &str, of: &str) -> String {
    format!("annotations/{group}/{id}/{of}")
}
