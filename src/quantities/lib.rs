//! Quantities: how likely improvements are, how soon they come, and at what cost.
//!
//! - [`Values`]: the results of a finished analysis, as intervals or fractions.
//! - [`Cost`]: what a step costs, by default one ([`Steps`]).
//! - [`Chooser`]: lets a strategy choose by value.
//! - [`answer`]: answers to properties such as `Pmax=? [ F x=3 ]`.
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
//! | `facts`, `listing`, `explore` | from an [`Analysis`](meliora_planning::Analysis) to a graph: the states that kept choices reach, with exact probabilities |
//! | `codes`, `blocks`, `places` | states in few bytes, and their nodes |
//! | `graph`, `narrow` | numbered nodes, choices, edges, in few bytes |
//! | [`cost`] | what a step costs: steps, or a reward structure |
//! | `system`, `solve`, `solution`, `solved` | the equations of each quantity and level, solved component by component |
//! | `components`, `groups` | strongly connected components, and the end components in them |
//! | `order`, `feedback` | the order of a graph whose cycles all pass through a few nodes, and policy iteration on these |
//! | `component`, `eliminate` | the optimum of a small component: policy iteration, elimination of states |
//! | `doubles` | the same in doubles for larger ones, with bounds that one step confirms |
//! | `iterate`, `pace`, `sparse`, `repeated` | bounds of a large component: optimistic value iteration over compressed rows |
//! | `horizon` | success within n steps |
//! | `number` | intervals with outward rounding, and fractions |
//! | [`values`] | the results: [`Values`] |
//! | [`choose`] | strategies that attain the values |
//! | [`confirmed`], `inductive` | bounds that one step confirms, for certificates |
//! | [`path_values`] | probabilities of formulas and rewards until a target, without preferences |
//! | `reached`, `by_number`, `by_code` | the graph of their states: by the numbers of an engine that stores states one by one, or by code |
//!
//! # Methods
//!
//! Every value is an interval that contains the true value of the model as it is written.
//! Probabilities are exact fractions ([`Program::exact_steps`](meliora_model::Program::exact_steps)).
//! Components are solved after those that they reach. Most models are almost acyclic: most
//! components are single states, whose best action is computed directly.
//!
//! *Small components*, up to 100 groups, are solved by policy iteration with elimination of states.
//! Value iteration needs as many rounds as a component takes steps to be left: with a probability of 1e-12
//! per round, it never ends. Elimination does not depend on this. It adds, multiplies and divides numbers
//! that are not negative, so intervals have a relative width of some 1e-16 per operation, however
//! rare an event is. Where bounds are wide nevertheless, because no certificate was found for the
//! side that the policy does not give, they are computed again with fractions.
//!
//! *Components up to 1000 groups* are solved in the same way with doubles, several times faster; then one step
//! rounded outwards confirms bounds near the solution. If it does not, intervals are used, then iteration,
//! and the narrower bounds count.
//!
//! *Large components*, and those in which a group has many edges, are solved by optimistic value iteration
//! if that takes few sweeps, as the first ones predict. Random walks take hundreds or thousands. Then doubles are
//! tried in components of any size, as long as elimination fills in little: one policy of most models has a chain that
//! is nearly acyclic. If rows fill in, as on walks in the plane, where the time of elimination grows with n^1.5,
//! iteration may take more sweeps, and elimination, which was faster there up to some ten thousand states, comes
//! last.
//!
//! *Around a few nodes:* where all cycles of a large component pass through at most eight nodes, such as the charger of
//! a robot, policy iteration on the values of these comes first. Each round takes a few sweeps.
//! `docs/tuning.md` has figures for each method.
//!
//! *The order:* where all cycles of the graph pass through at most 64 nodes, all nodes are ordered once by the length of
//! the paths to the next one of these. Components follow from two sweeps in this order, in which nodes of one length have
//! successors that are near to each other; a depth-first search waits for memory in each step.
//!
//! *Threads:* several threads list the states and their choices. Nodes get their numbers in the same order with each
//! number of threads, and so the values are the same.
//!
//! The levels give qualitative facts for free: P_k > 0 on level k of SPI, and P_k = 1 on level k of
//! SASI (under `transition`: of SASI under `action`). Only states between the two have equations.
//! Where at most one improvement is possible, N = P_1.
//!
//! Sources: A. Hartmanns and B. Kaminski, "Optimistic value iteration" (CAV 2020); S. Haddad and B.
//! Monmege, "Interval iteration algorithm for MDPs and IMDPs" (end components); A. Hartmanns, S. Junges, T. Quatmann, M. Weininger, "A practitioner's guide to MDP
//! model checking algorithms" (TACAS 2023); K. Chatterjee et al., "Fixed point certificates for
//! reachability and expected rewards in MDPs" (TACAS 2025).
//!
//! # An example
//!
//! ```
//! use std::sync::Arc;
//!
//! use meliora_engine::{ExplicitEngine, Settings};
//! use meliora_model::error::SourceFile;
//! use meliora_planning::{Analysis, Options};
//! use meliora_quantities::{ValueOptions, Steps, Values};
//!
//! let model = "mdp module m x : [0..2] init 0; [] x=0 -> 1/4: (x'=1) + 3/4: (x'=2); [] x>0 -> true; endmodule";
//! let wishes = "objective Lucky = F x=1;";
//! let none = SourceFile::new("--const", "");
//! let mut program = meliora_lang::load(&SourceFile::new("m.prism", model), &none)?.program;
//! let preferences = meliora_lang::load_preferences(&SourceFile::new("m.pref", wishes), &mut program)?;
//! let program = Arc::new(program);
//! let engine = ExplicitEngine::new(Arc::clone(&program), Settings::default())?;
//! let mut analysis = Analysis::new(&Arc::new(engine), &Arc::new(preferences), Options::default());
//! analysis.run(&mut |_| ())?;
//! let options = ValueOptions { levels: 1, exact: false, within: None };
//! let values = Values::compute(options, &analysis, &program, &[vec![0]], &Steps)?;
//! let start = values.start(&[0]).unwrap();
//! assert_eq!(values.probability(start, 1).interval.lower, 0.25);
//! # Ok::<(), meliora_model::error::Error>(())
//! ```

pub mod all_states;
pub mod answer;
mod blocks;
mod by_code;
mod by_number;
pub mod choose;
mod codes;
mod component;
mod components;
pub mod confirmed;
pub mod cost;
mod doubles;
mod eliminate;
mod explore;
mod facts;
mod feedback;
mod graph;
mod groups;
mod horizon;
mod inductive;
mod iterate;
mod listing;
mod meter;
mod narrow;
mod number;
mod order;
pub mod outlook;
mod pace;
pub mod path_values;
mod places;
mod reached;
mod repeated;
mod solution;
mod solve;
mod solved;
mod sparse;
pub mod state_values;
mod system;
#[cfg(test)]
mod tests;
mod ties;
pub mod values;

pub use choose::{Achiever, Choose, Chooser, ValuedRule};
pub use cost::{Cost, Earned, Steps};
pub use number::{Bounds, Interval};
pub use values::{Aim, ChoiceValues, Node, ValueOptions, Values};
