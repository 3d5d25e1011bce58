//! Markov decision processes and games of two players as graphs, and their equations: probabilities, rewards and averages,
//! for one objective or several, and numbers of improvements.
//!
//! | part | contents |
//! | --- | --- |
//! | [`Arena`], [`GameGraph`], [`Builder`], [`Rewards`] | a model or a game on numbered states, with owners, choices, exact probabilities and rewards |
//! | [`vector`] | the values of all states: probabilities, rewards, long-run averages, and choices by the number of steps |
//! | [`several`] | several objectives at once, and strategies for them |
//! | [`Graph`], [`Quantities`] | a game whose nodes have [ranks](Rank): P_k, C_k, N, the choices that attain them, [bounds that one step confirms](Confirmed) |
//! | [`Likely`] | the probability to achieve an objective, until it is almost sure or impossible |
//! | [`Choices::end_components`], [`GameGraph::toward`], [`GameGraph::reaching`] | parts of a graph, and the ways to a set |
//!
//! # Modules
//!
//! | folder | contents |
//! | --- | --- |
//! | `graphs` | numbered nodes, choices, edges, in few bytes; states as nodes; the limits of memory and time |
//! | `solvers` | the equations of each quantity, components, and the methods that solve them |
//! | `values` | the uses of the solutions |
//!
//! # Methods
//!
//! Every value is an interval that contains the true value of the model as it is written.
//! Probabilities are exact fractions ([`Program::exact_steps`](meliora_model::Program::exact_steps)).
//!
//! 1. *Graph.* States are explored by their codes into one kind of graph: choices in compressed rows, with exact
//!    probabilities and costs.
//! 2. *Equations.* A quantity gives a system: the extreme that each state looks for, costs or none, and values of the level
//!    below where a step counts. States in which the value is 0, 1 or infinite have no equation. Several objectives are a
//!    weighted sum.
//! 3. *Components.* Strongly connected components are solved after those that they reach; one state is solved directly. In
//!    a larger one, end components of one side without gain or cost become one group; the rows of the groups remain.
//! 4. *Bounds.* Optimistic value iteration and policy iteration with doubles take turns at the rows, with budgets that
//!    double. Both claim only bounds that one step, rounded outwards, confirms. Up to 1000 groups policy iteration comes first,
//!    since its bounds are narrower.
//! 5. *Fractions.* Where doubles have too few digits, the same policy iteration continues with fractions. `--exact` uses them
//!    everywhere.
//! 6. *Games.* A game is a system in which some states look for the greatest value and others for the least one. Both
//!    methods solve its components; policy iteration changes the policy of the side that has to leave a component where
//!    another choice is better than the best answer to it.
//! 7. *Parts.* For the values of some states, a part of the graph may be enough: one in which the best choices end even if all
//!    states outside of it have the best values. Where few steps to an improvement are lost is explored first; from states
//!    outside, choices with the fewest steps are followed until they end in the part.
//! 8. *Steps.* Bounds on the number of steps are steps backward over vectors.
//!
//! `benches/tuning.md` has figures for the methods.
//!
//! Sources: A. Hartmanns and B. Kaminski, "Optimistic value iteration" (CAV 2020); S. Haddad and B.
//! Monmege, "Interval iteration algorithm for MDPs and IMDPs" (end components); A. Hartmanns, S. Junges, T. Quatmann, M. Weininger, "A practitioner's guide to MDP
//! model checking algorithms" (TACAS 2023); K. Chatterjee et al., "Fixed point certificates for
//! reachability and expected rewards in MDPs" (TACAS 2025); A. Hoffman and R. Karp, "On nonterminating stochastic games"
//! (1966); V. Forejt, M. Kwiatkowska, D. Parker, "Pareto curves for probabilistic model checking" (ATVA 2012).
//!
//! # An example
//!
//! ```
//! use std::sync::Arc;
//!
//! use bitvec::vec::BitVec;
//! use meliora_base::error::SourceFile;
//! use meliora_engine::{ExplicitEngine, Settings};
//! use meliora_equations::vector::{Asked, Until};
//! use meliora_equations::{Arena, Extremes};
//! use meliora_model::Optimum;
//!
//! let model = "mdp module m x : [0..2] init 0; [] x=0 -> 1/4: (x'=1) + 3/4: (x'=2); [] x>0 -> true; endmodule";
//! let program = meliora_lang::load(&SourceFile::new("m.prism", model), &SourceFile::new("--const", ""))?.program;
//! let engine = ExplicitEngine::new(Arc::new(program.clone()), Settings::default())?;
//! let arena = Arena::new(&engine, &program)?;
//! let target: BitVec = (0..arena.states()).map(|state| arena.state(state) == [1]).collect();
//! let until = Until::unbounded(BitVec::repeat(true, arena.states()), target);
//! let found = Asked::all(&arena, Extremes::all(Optimum::Max), 1e-6).probability(&until)?;
//! assert_eq!(found.values[arena.number(&vec![0])].interval().lower, 0.25);
//! # Ok::<(), meliora_base::error::Error>(())
//! ```

mod graphs;
mod solvers;
mod values;

pub use graphs::arena::{Arena, Members};
pub use graphs::builder::Builder;
pub use graphs::choices::Choices;
pub use graphs::codes::Codes;
pub use graphs::earnings::check_rewards;
pub use graphs::game_graph::{Edge, Extremes, GameGraph, LOST, NONE, Rewards};
pub use graphs::graph::{EVERY, Graph, Rank};
pub use graphs::meter::Meter;
pub use graphs::narrow::Narrow;
pub use solvers::back::Stage;
pub use solvers::components::{EndComponents, bottoms};
pub use solvers::inductive::Inductive;
pub use solvers::long_run::{AVERAGE_WIDTH, SWEEP_PART};
pub use solvers::system::Quantity;
pub use values::confirmed::Confirmed;
pub use values::likely::Likely;
pub use values::quantities::Quantities;
pub use values::value::{Answer, Value};
pub use values::{several, vector};
