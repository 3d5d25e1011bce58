//! A model with its explored states.

use std::sync::Arc;

use super::{Analysis, States};
use meliora_base::error::{Error, Result, SourceFile};
use meliora_engine::regions::{Regions, regions};
use meliora_engine::{AnyEngine, Engine, Usage};
use meliora_lang as lang;
use meliora_model::players::{Player, Players};
use meliora_model::preference::History;
use meliora_model::step::Step;
use meliora_model::{Program, fault};
use meliora_planning::result::ModelCounts;
use meliora_planning::{self as planning, Options};
use meliora_quantities::PRECISION;
use meliora_quantities::state_values::Bound;
use meliora_question::{Asking, Computing, Under};

/// The states and choices of a model's scope, in either engine.
#[derive(Clone)]
pub struct Exploration {
    engine: AnyEngine,
    /// The coalition of [`super::Model::with_coalition`], which preference files do not change.
    named: Option<Vec<bool>>,
}

/// The answer to a question about paths.
#[derive(Clone)]
pub struct Reached {
    /// The states of the target; for another temporal formula, the states from which it can be
    /// satisfied from then on, almost surely.
    pub target: States,
    /// The four regions; with monitors, their states where the monitors are fresh.
    pub regions: Regions<States>,
    /// For a property, true if it is true in all initial states; `None` if it only asks for a number,
    /// or if the bounds of the number do not decide it.
    pub holds: Option<bool>,
    /// For a property about a number, its bounds over the initial states: in each of them, the
    /// probability or the expected reward lies between them.
    pub value: Option<Bound>,
    /// The exploration of the regions: this one, or the product with the monitors of the formula.
    pub exploration: Exploration,
}

impl Reached {
    /// Answers a question about a program; the engine is that of its goal.
    pub(super) fn new(
        asking: &Asking,
        program: &Arc<Program>,
        engine: AnyEngine,
        precision: f64,
        named: Option<Vec<bool>>,
    ) -> Result<Self> {
        let goal = &asking.goal;
        let engine = asking.played(&engine)?.unwrap_or(engine);
        let of = |set| States::new(&engine, set);
        let mut search = goal.search(&engine)?;
        let target = of(search.goal()?);
        let found = search.all()?;
        let known = found.clone().map(Some);
        let computing = Computing { optima: None, precision, settles: false };
        let answer = Under::new(&engine, program, goal)?.answer(asking, program, &known, &computing)?;
        answer.end?;
        Ok(Reached {
            target,
            holds: answer.holds,
            value: answer.value,
            regions: goal.restricted(&engine, found)?.map(of),
            exploration: Exploration::new(engine.clone(), named),
        })
    }
}

impl Exploration {
    pub(super) fn new(engine: AnyEngine, named: Option<Vec<bool>>) -> Self {
        Exploration { engine, named }
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
    pub fn counts(&self) -> Result<ModelCounts> {
        ModelCounts::count(&self.engine)
    }

    /// Returns the resources used by the engine so far.
    pub fn usage(&self) -> Usage {
        self.engine.usage()
    }

    /// Returns all states of the scope.
    pub fn states(&self) -> States {
        States::new(&self.engine, self.engine.all_states())
    }

    /// Returns the initial states.
    pub fn initial(&self) -> States {
        States::new(&self.engine, self.engine.initial_states())
    }

    /// Returns the states without an enabled command.
    pub fn deadlocks(&self) -> States {
        States::new(&self.engine, self.engine.deadlock_states())
    }

    /// Returns the players of a game, each with the states in which it chooses; empty for other models.
    /// A deadlock belongs to nobody. Cost: explicitly one test per state and player.
    pub fn players(&self) -> Vec<(Player, States)> {
        let names = self.program().players.iter().flat_map(|players| &players.list);
        let states = self.engine.player_states().into_iter().map(|own| States::new(&self.engine, own));
        let of = |((player, ours), own): ((&Player, bool), States)| {
            (Player { name: player.name.clone(), ours }, own)
        };
        names.zip(self.engine.coalition()).zip(states).map(of).collect()
    }

    /// Returns the states of a game in which the opponent chooses; ∅ for other models.
    pub fn theirs(&self) -> States {
        States::new(&self.engine, self.engine.theirs().unwrap_or_else(|| self.engine.no_states()))
    }

    /// Returns the player that chooses in a state of the scope; `None` for deadlocks, and if the model is not
    /// a game. Cost: no image.
    ///
    /// # Errors
    /// The errors of [`Exploration::steps`].
    pub fn owner(&self, state: &[i64]) -> Result<Option<Player>> {
        let (program, steps) = (self.program(), self.steps(state)?);
        let Some(players) = &program.players else { return Ok(None) };
        let found = steps.iter().find_map(|step| program.player_of_choice(&step.choice));
        let found = found.map(|at| (at, players.list[at].name.clone()));
        Ok(found.map(|(at, name)| Player { name, ours: self.engine.coalition()[at] }))
    }

    /// Returns the enabled choices of a state of the scope, each with its name and its successors with
    /// their probabilities. Cost: no image.
    ///
    /// # Errors
    /// [`Error::Usage`] if the state is not in the scope; a command has no meaning in it.
    pub fn steps(&self, state: &[i64]) -> Result<Vec<Step>> {
        let program = self.program();
        if !self.states().contains(state)? {
            let shown = program.show_state(state);
            return Err(Error::Usage(format!("{shown} is not a state of the scope")));
        }
        program.steps(state).map_err(|fault| fault::error(program, &fault, state))
    }

    /// Returns the states that satisfy a condition in the model's language: `x = 3 & "goal"`.
    ///
    /// # Errors
    /// The condition is invalid (errors have places), or has no value in some state; a limit is
    /// reached.
    pub fn states_where(&self, condition: &str) -> Result<States> {
        let source = SourceFile::new("condition", condition);
        let tree = lang::parse_expression(&source)?;
        let condition = lang::lower_target(self.program(), &source, &tree)?;
        Ok(States::new(&self.engine, self.engine.states_where(&condition)?))
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
        Ok(States::new(&self.engine, self.engine.singleton(state)?))
    }

    /// Computes the states from which some strategy, and from which every strategy, reaches a
    /// target with probability 1, and with positive probability. Cost: that of the four
    /// [`meliora_engine::regions`].
    ///
    /// # Errors
    /// The target belongs to another exploration; a limit is reached.
    pub fn reach(&self, target: &States) -> Result<Regions<States>> {
        let found = regions(&self.engine, target.set())?;
        Ok(found.map(|set| States::new(&self.engine, set)))
    }

    /// Answers a question about paths: a target `x = 3`, a formula `F x = 3`, or a property
    /// `P>=1 [ F x = 3 ]`, `Pmax=? [ F x = 3 ]`, `R{"cost"}min=? [ F x = 3 ]`. For a temporal formula
    /// other than `F target`, the model is explored anew in product with its monitors. The bounds of
    /// a number are [`PRECISION`] wide at most.
    ///
    /// # Errors
    /// The text is invalid; each error has its place. A limit is reached.
    pub fn reach_where(&self, question: &str) -> Result<Reached> {
        self.reach_within(question, PRECISION)
    }

    /// Does the same as [`Exploration::reach_where`]; the bounds of a number are at most this wide,
    /// relative to the number above 1.
    ///
    /// # Errors
    /// The errors of [`Exploration::reach_where`].
    pub fn reach_within(&self, question: &str, precision: f64) -> Result<Reached> {
        let source = SourceFile::new("condition", question);
        let program = self.program();
        let asking = Asking::parse(program, &source)?;
        let engine = match &asking.goal.watched {
            None => self.engine.clone(),
            Some(watched) => AnyEngine::new(Arc::clone(&watched.program), self.engine.settings().clone())?,
        };
        Reached::new(&asking, program, engine, precision, self.named.clone())
    }

    /// Prepares an analysis under the preferences of a text, without computing anything. With
    /// `history = play`, the model is explored anew in product with its monitors. In a game we are the
    /// coalition that the text names, unless [`super::Model::with_coalition`] named one.
    ///
    /// # Errors
    /// The text is invalid; each error has its place. A limit is reached in the new exploration.
    pub fn prefer(&self, source: &Arc<SourceFile>, options: Options) -> Result<Analysis> {
        let program = self.own_program();
        let lang::Task { program, preferences } = lang::load_preferences(source, program)?;
        let named = program.players.as_ref().map(Players::coalition);
        // Monitors add variables, so the product has states of its own.
        let engine = match preferences.history {
            History::State => self.engine.clone(),
            History::Play => AnyEngine::new(program, self.engine.settings().clone())?,
        };
        let coalition = self.named.as_ref().or(named.as_ref());
        let engine = match coalition.filter(|coalition| **coalition != engine.coalition()) {
            Some(coalition) => engine.with_coalition(coalition)?,
            None => engine,
        };
        let found = planning::Analysis::new(&Arc::new(engine), &Arc::new(preferences), options);
        let mut analysis = Analysis::from(found);
        analysis.named.clone_from(&self.named);
        Ok(analysis)
    }

    /// Returns the program in which we are the coalition of the engine.
    pub(super) fn own_program(&self) -> Arc<Program> {
        let (mut program, own) = (Arc::clone(self.program()), self.engine.coalition());
        if program.players.as_ref().is_some_and(|players| players.coalition() != own) {
            Arc::make_mut(&mut program).play_as(&own);
        }
        program
    }
}
