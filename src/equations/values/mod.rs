//! The values of states, from the solutions of their equations.
//!
//! | module | contents |
//! | --- | --- |
//! | [`vector`] | numbers of all states of an arena, or of another game; choices by the number of steps |
//! | [`several`] | several objectives at once |
//! | `quantities` | P_k, C_k and N of a graph with ranks |
//! | `confirmed` | bounds of all levels that one step confirms |
//! | `likely` | the probability to achieve an objective, and the choices that attain it |
//! | `value` | a number of a state, or infinity |

pub(crate) mod confirmed;
pub(crate) mod likely;
pub(crate) mod quantities;
pub mod several;
pub(crate) mod value;
pub mod vector;
