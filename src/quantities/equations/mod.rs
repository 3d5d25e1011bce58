//! From states to equations.
//!
//! | module | contents |
//! | --- | --- |
//! | `facts`, `explore` | from an [`Analysis`](meliora_planning::Analysis) to a graph: the states that kept choices reach, with exact probabilities |
//! | [`arena`] | all states of a scope, with their choices and owners |
//! | `source`, `earnings` | the states of an engine by number, with their choices, and the rewards of these |
//! | `codes`, `places` | states in few bytes, and their nodes |
//! | [`game_graph`] | a game as the solvers see it: states with owners, choices, probabilities |
//! | `graph`, `narrow` | numbered nodes, choices, edges, in few bytes |
//! | [`cost`] | what a step costs: steps, or a reward structure |
//! | `system`, `solution` | the one form of equations, for each quantity and level, and their solutions |
//! | `reached` | the graph of the states that some states reach |

pub mod arena;
pub(crate) mod choices;
pub(crate) mod codes;
pub mod cost;
mod earnings;
pub(crate) mod explore;
pub(crate) mod facts;
pub mod game_graph;
pub(crate) mod graph;
pub(crate) mod meter;
pub(crate) mod narrow;
pub(crate) mod places;
pub(crate) mod reached;
pub(crate) mod solution;
pub(crate) mod source;
pub(crate) mod system;
