//! Quantities: how likely improvements are, how soon they come, and at what cost.
//!
//! - [`Values`]: the results of a finished analysis, as intervals or fractions.
//! - [`Cost`]: what a step costs, by default one ([`Steps`]).
//! - [`Chooser`]: lets a strategy choose by value.
//! - [`sought`]: the number that an operator asks for, such as `Pmax=? [ F x=3 ]`, in some states.
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
//! | folder | contents |
//! | --- | --- |
//! | [`equations`] | from states to equations: graphs with exact probabilities, costs, the equations of each quantity |
//! | `solvers` | components, and the methods that solve their equations |
//! | [`answers`] | the uses of the solutions: values, strategies, properties, certificates |
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
//!    states outside of it have the best values.
//! 8. *Steps.* Bounds on the number of steps are steps backward over vectors.
//!
//! `benches/tuning.md` has figures for the methods.
//!
//! The levels give qualitative facts for free: P_k > 0 on level k of SPI, and P_k = 1 on level k of
//! SASI (under `transition`: of SASI under `action`). Only states between the two have equations.
//! If at most one improvement is possible, N = P_1.
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
//! use meliora_engine::{ExplicitEngine, Settings};
//! use meliora_base::error::SourceFile;
//! use meliora_planning::{Analysis, Options};
//! use meliora_quantities::{ValueOptions, Steps, Values};
//!
//! let model = "mdp module m x : [0..2] init 0; [] x=0 -> 1/4: (x'=1) + 3/4: (x'=2); [] x>0 -> true; endmodule";
//! let wishes = "objective Lucky = F x=1;";
//! let none = SourceFile::new("--const", "");
//! let program = meliora_lang::load(&SourceFile::new("m.prism", model), &none)?.program;
//! let meliora_lang::Task { program, preferences } = meliora_lang::load_preferences(&SourceFile::new("m.pref", wishes), program)?;
//! let program = Arc::new(program);
//! let engine = ExplicitEngine::new(Arc::clone(&program), Settings::default())?;
//! let mut analysis = Analysis::new(&Arc::new(engine), &Arc::new(preferences), Options::default());
//! analysis.run(&mut |_| ())?;
//! let options = ValueOptions { levels: 1, exact: false, within: None };
//! let values = Values::compute(options, &analysis, &program, &[vec![0]], &Steps)?;
//! let start = values.start(&[0]).unwrap();
//! assert_eq!(values.probability(start, 1).interval.lower, 0.25);
//! # Ok::<(), meliora_base::error::Error>(())
//! ```

pub mod answers;
pub mod equations;
mod solvers;

pub use answers::{
    actions, all_states, by_goal, choose, confirmed, exploration, followed, optimal, outlook, path_values,
    several, sought, state_values, values, vector,
};
pub use choose::{Achiever, Choose, Chooser, ValuedRule};
pub use cost::{Cost, Earned, Steps};
pub use equations::cost;
pub use exploration::Exploration;
pub use meliora_base::interval::{Bounds, Interval, PRECISION};
pub use values::{Aim, ChoiceValues, Node, ValueOptions, Values};
