//! Costs of choices.

use num_traits::One;

use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_engine::Engine;
use meliora_equations::check_rewards;
use meliora_model::predicate::Predicate;
use meliora_model::rewards::RewardStructure;
use meliora_model::step::Combination;
use meliora_model::{Program, State};

/// A cost for each step: what a choice costs in a state, at least 0.
///
/// For a reward structure, this is the sum of its state rewards in the state and of its transition
/// rewards for the action of the choice.
pub trait Cost: Sync {
    /// Returns the cost of a choice in a state, which draws from these combinations of commands.
    ///
    /// # Errors
    /// The cost is negative or has no value in this state.
    fn of(&self, state: &State, combinations: &[Combination]) -> Result<Ratio>;

    /// Returns the cost of every step, if all have the same.
    fn constant(&self) -> Option<Ratio> {
        None
    }
}

/// The number of steps: every step costs 1.
#[derive(Debug, Clone, Copy, Default)]
pub struct Steps;

impl Steps {
    /// The name of this cost in options and reports.
    pub const NAME: &str = "steps";
}

impl Cost for Steps {
    fn of(&self, _: &State, _: &[Combination]) -> Result<Ratio> {
        Ok(Ratio::one())
    }

    fn constant(&self) -> Option<Ratio> {
        Some(Ratio::one())
    }
}

/// The rewards of a reward structure.
#[derive(Debug, Clone, Copy)]
pub struct Earned<'p> {
    /// The model.
    pub program: &'p Program,
    /// One of its reward structures.
    pub structure: &'p RewardStructure,
}

impl Cost for Earned<'_> {
    fn of(&self, state: &State, combinations: &[Combination]) -> Result<Ratio> {
        self.program.reward_of(self.structure, state, combinations)
    }
}

/// The cost of a step, by its name.
#[derive(Debug, Clone)]
pub enum Costs {
    /// Every step costs 1.
    Steps,
    /// A reward structure of the model.
    Rewards {
        /// Its position.
        structure: usize,
        /// The predicate of the states with wrong rewards; see `Program::wrong_rewards`.
        wrong: Predicate,
    },
}

impl Costs {
    /// Finds the number of steps, or a reward structure; `None` if the name is unknown. `steps` is
    /// the number of steps even if a structure has this name; see [`Costs::is_hidden`].
    pub fn named(program: &Program, name: &str) -> Option<Self> {
        if name == Steps::NAME {
            return Some(Costs::Steps);
        }
        let structure = program.reward_structure(Some(name))?;
        Some(Costs::Rewards { structure, wrong: program.wrong_rewards(structure) })
    }

    /// Returns whether the model has a reward structure with this name that is not the cost of this
    /// name.
    pub fn is_hidden(program: &Program, name: &str) -> bool {
        name == Steps::NAME && program.reward_structure(Some(name)).is_some()
    }

    /// Returns all names for a model.
    pub fn names(program: &Program) -> impl Iterator<Item = &str> {
        let named = program.rewards.iter().filter_map(|r| r.name.as_deref());
        std::iter::once(Steps::NAME).chain(named.filter(|name| *name != Steps::NAME))
    }

    /// Returns the cost, after checking it in all states of the scope.
    ///
    /// # Errors
    /// A reward is negative or has no value in some state; a limit is reached.
    pub fn check<'p, E: Engine>(&self, engine: &E, program: &'p Program) -> Result<Box<dyn Cost + 'p>> {
        let Costs::Rewards { structure, wrong } = self else { return Ok(Box::new(Steps)) };
        let structure = &program.rewards[*structure];
        check_rewards(engine, program, structure, wrong)?;
        Ok(Box::new(Earned { program, structure }))
    }
}
