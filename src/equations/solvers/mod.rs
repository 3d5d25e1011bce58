//! The methods that solve equations.
//!
//! | module | contents |
//! | --- | --- |
//! | `system`, `solution` | the one form of equations, for each quantity and level, and their solutions |
//! | `solve`, `solved` | the equations of each quantity and level, solved component by component |
//! | `components`, `groups` | strongly connected components, and the end components in them |
//! | `part` | bounds from a part of the graph |
//! | `turns` | the two methods for a component, with budgets that double, and fractions |
//! | `rows` | the equations of a component, in doubles that are rounded outwards or in fractions |
//! | `iterate` | optimistic value iteration |
//! | `policies` | policy iteration, with bounds that one step confirms, or with fractions |
//! | `chain`, `eliminate` | the equations of a policy, component by component, and elimination of states |
//! | `horizon` | success within n steps |
//! | `sides` | the states from which a set is reached possibly, almost surely, or again and again, in a game |
//! | `reaching` | the values of all states of an arena, also of games |
//! | `if_reached` | rewards that are lost where the target is not reached |
//! | `back` | steps backward over all states of an arena |
//! | `long_run` | averages over the long run |
//! | `weighted`, `pairs` | weighted sums of several objectives |
//! | `strategy` | their strategies, node by node |
//! | `hull`, `outer` | the points that they show, and the vertices of the half-spaces |
//! | `inductive` | bounds that one step confirms |
//! | `ties` | of several best choices, those with the least expected number of steps |

pub(crate) mod back;
pub(crate) mod chain;
pub(crate) mod components;
pub(crate) mod eliminate;
pub(crate) mod groups;
pub(crate) mod horizon;
pub(crate) mod hull;
pub(crate) mod if_reached;
pub(crate) mod inductive;
pub(crate) mod iterate;
pub(crate) mod long_run;
pub(crate) mod outer;
pub(crate) mod pairs;
pub(crate) mod part;
pub(crate) mod policies;
pub(crate) mod reaching;
pub(crate) mod rows;
pub(crate) mod sides;
pub(crate) mod solution;
pub(crate) mod solve;
pub(crate) mod solved;
pub(crate) mod strategy;
pub(crate) mod system;
pub(crate) mod ties;
pub(crate) mod turns;
pub(crate) mod weighted;

#[cfg(test)]
mod tests;
