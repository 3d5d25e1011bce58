//! Graphs with exact probabilities.
//!
//! | module | contents |
//! | --- | --- |
//! | `game_graph`, `choices` | a game on numbered states: owners, choices, probabilities, and rewards |
//! | `builder` | a game that is made state by state |
//! | `arena` | all states of a scope, or those that some states reach, as such a game |
//! | `graph` | a game whose nodes have ranks: the numbers of improvements that are possible and certain |
//! | `reached` | the graph of the states that some states reach |
//! | `source`, `earnings` | the states of an engine by number, with their choices, and the rewards of these |
//! | `codes`, `narrow` | states and numbers in few bytes |
//! | `meter` | the limits of memory and time |

pub(crate) mod arena;
pub(crate) mod builder;
pub(crate) mod choices;
pub(crate) mod codes;
pub(crate) mod earnings;
pub(crate) mod game_graph;
pub(crate) mod graph;
pub(crate) mod meter;
pub(crate) mod narrow;
pub(crate) mod reached;
pub(crate) mod source;
