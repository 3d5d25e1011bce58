//! Quantities: how likely improvements are, how soon they come, and at what cost.
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
//! | `explore` | from an [`Analysis`](crate::planning::Analysis) to a graph: the states that kept choices reach, with exact probabilities |
//! | `graph` | numbered nodes, choices, edges |
//! | [`cost`] | what a step costs: steps, or a reward structure |
//! | `solve`, `solved` | the equations of each quantity and level, solved component by component |
//! | `components` | strongly connected components, end components |
//! | `component` | the optimum of one component: policy iteration and certificates |
//! | `eliminate` | the values of one policy: elimination of states |
//! | `horizon` | success within n steps |
//! | `number` | intervals with outward rounding, and fractions |
//! | [`values`] | the results: [`Values`] |
//! | [`choose`] | strategies that attain the values |
//! | [`reach`] | probabilities of formulas and rewards until a target, without preferences |
//!
//! # Why policy iteration
//!
//! Every value is an interval that contains the true value of the model as it is written.
//! Probabilities are exact fractions ([`Program::exact_steps`](crate::model::Program::exact_steps)).
//! Value iteration needs as many rounds as the slowest part of a model takes steps: with a
//! probability of 1e-12 per round, it never ends. Policy iteration with elimination of states does
//! not depend on this. Elimination adds, multiplies and divides numbers that are not negative, so
//! intervals have a relative width of some 1e-16 per operation, however rare an event is. Most
//! models are almost acyclic, and then each component is a single state.
//!
//! The levels give qualitative facts for free: P_k > 0 on level k of SPI, and P_k = 1 on level k of
//! SASI (under `transition`: of SASI under `action`). Only states between the two have equations.
//!
//! Sources: S. Haddad and B. Monmege, "Interval iteration algorithm for MDPs and IMDPs" (end
//! components); A. Hartmanns, S. Junges, T. Quatmann, M. Weininger, "A practitioner's guide to MDP
//! model checking algorithms" (TACAS 2023); K. Chatterjee et al., "Fixed point certificates for
//! reachability and expected rewards in MDPs" (TACAS 2025).

pub mod choose;
mod component;
mod components;
pub mod cost;
mod eliminate;
mod explore;
mod graph;
mod horizon;
mod meter;
mod number;
pub mod reach;
mod solve;
mod solved;
pub mod values;

pub use choose::{Choose, Chooser};
pub use cost::{Cost, Earned, Steps};
pub use number::{Bounds, Interval};
pub use values::{Aim, ChoiceValues, Node, Setup, Values};
