//! A model whose states are known.

use std::sync::Arc;

use super::{Planning, States};
use crate::engine::regions::{Regions, regions};
use crate::engine::{AnyEngine, Engine, Usage};
use crate::error::{Error, Result, SourceFile};
use crate::lang;
use crate::model::Program;
use crate::model::preference::{History, Preferences};
use crate::planning::Options;
use crate::planning::result::ModelCounts;

/// The states of a model's scope with what may happen in them, in either engine.
#[derive(Clone)]
pub struct Exploration {
    engine: AnyEngine,
}

impl Exploration {
    pub(super) fn of(engine: AnyEngine) -> Self {
        Exploration { engine }
    }

    /// The engine.
    pub fn engine(&self) -> &AnyEngine {
        &self.engine
    }

    /// The flat program.
    pub fn program(&self) -> &Arc<Program> {
        self.engine.program()
    }

    /// How many states, choices, transitions, … there are.
    ///
    /// # Errors
    /// A limit. Cost: no image.
    pub fn counts(&self) -> Result<ModelCounts> {
        ModelCounts::of(&self.engine)
    }

    /// What the engine used so far.
    pub fn usage(&self) -> Usage {
        self.engine.usage()
    }

    /// All states of the scope.
    pub fn states(&self) -> States {
        States::of(&self.engine, self.engine.all_states())
    }

    /// The initial states.
    pub fn initial(&self) -> States {
        States::of(&self.engine, self.engine.initial_states())
    }

    /// The states in which nothing is enabled.
    pub fn deadlocks(&self) -> States {
        States::of(&self.engine, self.engine.deadlock_states())
    }

    /// The states in which a condition in the model's language holds: `x = 3 & "goal"`.
    ///
    /// # Errors
    /// What is wrong with the condition, with its place; it has no value in some state; a limit.
    pub fn states_where(&self, condition: &str) -> Result<States> {
        let source = SourceFile::new("condition", condition);
        let mut program = Program::clone(self.program());
        let tree = lang::parse_expression(&source)?;
        let condition = lang::lower_target(&mut program, &source, &tree)?;
        let engine = self.engine.reading(Arc::new(program))?;
        Ok(States::of(&self.engine, engine.states_where(condition)?))
    }

    /// The set of one state; empty where it is not in the scope.
    ///
    /// # Errors
    /// A limit; a state that has not one value a variable.
    pub fn singleton(&self, state: &[i64]) -> Result<States> {
        let variables = self.program().variables.len();
        if state.len() != variables {
            return Err(Error::Usage(format!("a state has {variables} values here, not {}", state.len())));
        }
        Ok(States::of(&self.engine, self.engine.singleton(state)?))
    }

    /// From where some, and from where every strategy reaches a target surely, and possibly.
    ///
    /// # Errors
    /// A limit; the target is of another exploration. Cost: that of the four
    /// [`crate::engine::regions`].
    pub fn reach(&self, target: &States) -> Result<Regions<States>> {
        let found = regions(&self.engine, target.within(&self.engine)?)?;
        let of = |set| States::of(&self.engine, set);
        Ok(Regions {
            pmax_one: of(found.pmax_one),
            pmax_positive: of(found.pmax_positive),
            pmin_one: of(found.pmin_one),
            pmin_positive: of(found.pmin_positive),
        })
    }

    /// An analysis under the preferences of a text, of which nothing is computed yet. Where whole plays count
    /// (`history = play`), the model is explored anew beside its monitors.
    ///
    /// # Errors
    /// What is wrong in the text, each with its place.
    pub fn prefer(&self, source: &Arc<SourceFile>, options: Options) -> Result<Planning> {
        let mut program = Program::clone(self.program());
        let preferences: Preferences = lang::load_preferences(source, &mut program)?;
        let program = Arc::new(program);
        // Monitors are variables of their own: with them there are other states.
        let engine = match preferences.history {
            History::State => self.engine.reading(program)?,
            History::Play => AnyEngine::new(program, self.engine.settings().clone())?,
        };
        Ok(Planning::of(engine, preferences, source.name.as_str(), options))
    }
}
