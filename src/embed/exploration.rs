//! A model with its explored states.

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

/// The states and choices of a model's scope, in either engine.
#[derive(Clone)]
pub struct Exploration {
    engine: AnyEngine,
}

impl Exploration {
    pub(super) fn of(engine: AnyEngine) -> Self {
        Exploration { engine }
    }

    /// Returns the engine.
    pub fn engine(&self) -> &AnyEngine {
        &self.engine
    }

    /// Returns the flat program.
    pub fn program(&self) -> &Arc<Program> {
        self.engine.program()
    }

    /// Counts the states, choices, transitions and so on. Cost: no image.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn counts(&self) -> Result<ModelCounts> {
        ModelCounts::of(&self.engine)
    }

    /// Returns the resources used by the engine so far.
    pub fn usage(&self) -> Usage {
        self.engine.usage()
    }

    /// Returns all states of the scope.
    pub fn states(&self) -> States {
        States::of(&self.engine, self.engine.all_states())
    }

    /// Returns the initial states.
    pub fn initial(&self) -> States {
        States::of(&self.engine, self.engine.initial_states())
    }

    /// Returns the states without an enabled command.
    pub fn deadlocks(&self) -> States {
        States::of(&self.engine, self.engine.deadlock_states())
    }

    /// Returns the states that satisfy a condition in the model's language: `x = 3 & "goal"`.
    ///
    /// # Errors
    /// The condition is invalid (errors have places), or has no value in some state; a limit is
    /// reached.
    pub fn states_where(&self, condition: &str) -> Result<States> {
        let source = SourceFile::new("condition", condition);
        let mut program = Program::clone(self.program());
        let tree = lang::parse_expression(&source)?;
        let condition = lang::lower_target(&mut program, &source, &tree)?;
        let engine = self.engine.reading(Arc::new(program))?;
        Ok(States::of(&self.engine, engine.states_where(condition)?))
    }

    /// Returns the set of one state; empty if the state is not in the scope.
    ///
    /// # Errors
    /// The state does not have one value per variable; a limit is reached.
    pub fn singleton(&self, state: &[i64]) -> Result<States> {
        let variables = self.program().variables.len();
        if state.len() != variables {
            return Err(Error::Usage(format!("a state has {variables} values here, not {}", state.len())));
        }
        Ok(States::of(&self.engine, self.engine.singleton(state)?))
    }

    /// Computes the states from which some strategy, and from which every strategy, reaches a
    /// target with probability 1, and with positive probability. Cost: that of the four
    /// [`crate::engine::regions`].
    ///
    /// # Errors
    /// The target belongs to another exploration; a limit is reached.
    pub fn reach(&self, target: &States) -> Result<Regions<States>> {
        let found = regions(&self.engine, target.set())?;
        let of = |set| States::of(&self.engine, set);
        Ok(Regions {
            pmax_one: of(found.pmax_one),
            pmax_positive: of(found.pmax_positive),
            pmin_one: of(found.pmin_one),
            pmin_positive: of(found.pmin_positive),
        })
    }

    /// Prepares an analysis under the preferences of a text, without computing anything. With
    /// `history = play`, the model is explored anew in product with its monitors.
    ///
    /// # Errors
    /// The text is invalid; each error has its place. A limit is reached in the new exploration.
    pub fn prefer(&self, source: &Arc<SourceFile>, options: Options) -> Result<Planning> {
        let mut program = Program::clone(self.program());
        let preferences: Preferences = lang::load_preferences(source, &mut program)?;
        let program = Arc::new(program);
        // Monitors add variables, so the product has states of its own.
        let engine = match preferences.history {
            History::State => self.engine.reading(program)?,
            History::Play => AnyEngine::new(program, self.engine.settings().clone())?,
        };
        Ok(Planning::of(engine, preferences, source.name.as_str(), options))
    }
}
