//! A parsed model.

use std::borrow::Borrow;
use std::path::Path;
use std::sync::{Arc, Mutex};

use super::{Analysis, Exploration, Reached};
use meliora_base::error::{Diagnostic, Error, Limit, Result, SourceFile};
use meliora_base::progress::{NoProgress, ProgressSink};
use meliora_base::sync::lock;
use meliora_base::value::{Type, Value};
use meliora_engine::{AnyEngine, RacedQuestion, Racer, Scope, Selection, Settings};
use meliora_formats::Document;
use meliora_lang::named::Property;
use meliora_lang::{self as lang, Checked, Given};
use meliora_model::players::Player;
use meliora_model::{ModelKind, Program, State};
use meliora_planning::{Event, Options};
use meliora_quantities::PRECISION;
use meliora_question::race::{Early, Job, Raced};
use meliora_question::{Asking, Stopping, check_start};

/// A model, checked and flat, but not explored. It is read from a text in PRISM's language or in
/// JANI, or from a list of its states: UMB, DRN, or PRISM's explicit files.
#[derive(Debug, Clone)]
pub struct Model {
    program: Arc<Program>,
    warnings: Vec<Diagnostic>,
    /// The properties that it names.
    pub(super) properties: Vec<Property>,
    /// The coalition of [`Model::with_coalition`].
    pub(super) named: Option<Vec<bool>>,
}

impl Model {
    /// Reads a file. `constants` gives values to undefined constants: `K=4,N=3`, or the empty text.
    ///
    /// # Errors
    /// The file cannot be read, or is invalid; each error has its place.
    pub fn open(path: impl AsRef<Path>, constants: &str) -> Result<Self> {
        Self::of(&Document::open(path.as_ref())?, constants)
    }

    /// Parses a text, as [`Model::open`] reads a file.
    ///
    /// # Errors
    /// The text is invalid; each error has its place.
    pub fn parse(text: impl Into<String>, constants: &str) -> Result<Self> {
        Self::of(&Document::new(SourceFile::new("model", text)), constants)
    }

    fn of(document: &Document, constants: &str) -> Result<Self> {
        let constants = SourceFile::new("constants", constants);
        let given = Given::constants_only(&constants);
        Self::loaded(document, &given, &NoProgress)
    }

    /// Parses a text with values for its constants and bounds for its variables; `sink` may cancel
    /// the work.
    ///
    /// # Errors
    /// A text is invalid (each error has its place); a limit is reached.
    pub fn given(source: &Arc<SourceFile>, given: &Given, sink: &dyn ProgressSink) -> Result<Self> {
        Self::loaded(&Document::new(Arc::clone(source)), given, sink)
    }

    /// Reads a document with values for its constants and bounds for its variables, as
    /// [`Model::given`] reads a text.
    ///
    /// # Errors
    /// See [`Model::given`].
    pub fn loaded(document: &Document, given: &Given, sink: &dyn ProgressSink) -> Result<Self> {
        let checked = document.load(given, sink)?;
        let Checked { program, warnings, properties, .. } = checked;
        Ok(Model { program: Arc::new(program), warnings, properties, named: None })
    }

    /// Returns the game in which we are these players, each given by its name or its number from 1 on; all
    /// others are the opponent. Without this, we are those that a preference file names, else the first
    /// player.
    ///
    /// # Errors
    /// The model is not a game, or has no such player; the error has its place in the names, joined by
    /// commas.
    pub fn with_coalition(&self, players: &[impl Borrow<str>]) -> Result<Self> {
        let names: Vec<&str> = players.iter().map(Borrow::borrow).collect();
        self.clone().played_by(&SourceFile::new("coalition", names.join(",")))
    }

    /// Does the same as [`Model::with_coalition`] for the text of the names, joined by commas.
    ///
    /// # Errors
    /// See [`Model::with_coalition`].
    pub fn played_by(mut self, names: &Arc<SourceFile>) -> Result<Self> {
        let coalition = lang::parse_coalition(&self.program, names)?;
        Arc::make_mut(&mut self.program).play_as(&coalition);
        Ok(Model { named: Some(coalition), ..self })
    }

    /// Returns the players of a game, each with whether it is one of us; empty for other models.
    pub fn players(&self) -> &[Player] {
        self.program.players.as_ref().map_or(&[], |players| &players.list)
    }

    /// Returns the flat program.
    pub fn program(&self) -> &Arc<Program> {
        &self.program
    }

    /// Returns the flat program as a value of its own.
    pub fn into_program(self) -> Program {
        Arc::unwrap_or_clone(self.program)
    }

    /// Returns the flat program, and the properties that the model names.
    pub fn into_parts(self) -> (Program, Vec<Property>) {
        (Arc::unwrap_or_clone(self.program), self.properties)
    }

    /// Returns the warnings about the text.
    pub fn warnings(&self) -> &[Diagnostic] {
        &self.warnings
    }

    /// Returns the kind: `mdp`, `dtmc` or `smg`.
    pub fn kind(&self) -> ModelKind {
        self.program.kind
    }

    /// Explores the states of the scope with the engine of the settings.
    ///
    /// # Errors
    /// A limit is reached; an expression has no value in a state of the scope (the error shows an
    /// example); the variable order is invalid; the model has no initial state.
    pub fn explore(&self, settings: Settings) -> Result<Exploration> {
        self.explored(AnyEngine::new(Arc::clone(&self.program), settings)?)
    }

    /// Explores the states of the scope with the engine that is the first to know all of them: the explicit one, or
    /// diagrams in one of several orders. With one thread, every run takes the same.
    ///
    /// # Errors
    /// The errors of [`Model::explore`].
    pub fn explore_by_any(&self, settings: Settings) -> Result<Exploration> {
        self.explored(Selection::open().build(&self.program, settings)?)
    }

    /// Answers a question by the first of several ways to end: the explicit engine, or diagrams in one of several orders.
    /// Each way explores the states and asks alone; as many of them run at once as the settings have threads.
    /// The answer must not depend on the way. With one thread, every run takes the same.
    ///
    /// # Errors
    /// The errors of [`Model::explore`] and of the question.
    pub fn ask_by_any<T: Send>(
        &self,
        settings: Settings,
        ask: &(dyn Fn(&Exploration) -> Result<T> + Sync),
    ) -> Result<T> {
        let by_states = |_: &Racer, engine: AnyEngine| ask(&self.explored(engine)?);
        Selection::open().answer(&self.program, settings, &RacedQuestion::new(&by_states))
    }

    /// Runs a whole analysis by the first of several ways to end, as [`Model::ask_by_any`]. The listener hears the
    /// events of the way that leads. Returns the analysis, and the limit that has ended it, if one has.
    ///
    /// # Errors
    /// The errors of [`Exploration::prefer`] and [`Analysis::run`](meliora_planning::Analysis::run), except for a
    /// limit that leaves partial results.
    pub fn check_by_any(
        &self,
        preferences: &Arc<SourceFile>,
        options: Options,
        settings: Settings,
        listener: &(dyn Fn(Event<'_>) + Sync),
    ) -> Result<(Analysis, Option<Limit>)> {
        let partial = Partial { found: Arc::default(), sink: Arc::clone(&settings.sink), leads: false };
        let by_states = |own: &Partial, engine: &Arc<AnyEngine>| {
            let explored = Exploration::new(AnyEngine::clone(engine), self.named.clone());
            let mut analysis = explored.prefer(preferences, options)?;
            let heard = &mut |event: Event<'_>| {
                if own.leads {
                    listener(event);
                }
            };
            match analysis.run(heard) {
                Ok(()) => Ok(analysis),
                Err(error) => {
                    *lock(&own.found) = Some(analysis);
                    Err(error)
                }
            }
        };
        let (program, selected, early) = (&self.program, Selection::open(), Early::default());
        let raced =
            Raced { program, settings: &settings, selected, lists_states: false, early, answer: &by_states };
        match (raced.run(&partial), lock(&partial.found).take()) {
            (Ok(analysis), _) => Ok((analysis, None)),
            (Err(Error::Limit(limit)), Some(analysis)) => Ok((analysis, Some(limit))),
            (Err(error), _) => Err(error),
        }
    }

    fn explored(&self, engine: AnyEngine) -> Result<Exploration> {
        check_start(&engine, &self.program)?;
        Ok(Exploration::new(engine, self.named.clone()))
    }

    /// Answers a question about paths, as [`Exploration::reach_where`], in the part of the model that
    /// decides it: the states behind those that decide the question are not explored. In the initial
    /// states the answer is that for the whole model; the regions are those of the part.
    ///
    /// # Errors
    /// The errors of [`Model::explore`] and [`Exploration::reach_where`]; no state decides the question;
    /// the scope has every valuation.
    pub fn reach_stopping(&self, question: &str, settings: Settings) -> Result<Reached> {
        let (program, asking) = self.stopping(question, settings.scope)?;
        let engine = AnyEngine::new(Arc::clone(asking.goal.program(&program)), settings)?;
        self.stopped(&program, &asking, engine)
    }

    /// Does the same as [`Model::reach_stopping`] by the first of several ways to end; see [`Model::ask_by_any`].
    ///
    /// # Errors
    /// The errors of [`Model::reach_stopping`].
    pub fn reach_stopping_by_any(&self, question: &str, settings: Settings) -> Result<Reached> {
        let (program, asking) = self.stopping(question, settings.scope)?;
        let by_states = |_: &Racer, engine: AnyEngine| self.stopped(&program, &asking, engine);
        Selection::open().answer(asking.goal.program(&program), settings, &RacedQuestion::new(&by_states))
    }

    /// Returns the part of the model that decides a question, and the question about it.
    fn stopping(&self, question: &str, scope: Scope) -> Result<(Arc<Program>, Asking)> {
        if scope == Scope::All {
            let message = "paths can stop at a target only where the reachable states are explored, not where \
                           every valuation is a state";
            return Err(Error::Usage(message.to_owned()));
        }
        let Stopping { program, asking } =
            Stopping::parse(&self.program, &SourceFile::new("condition", question))?;
        Ok((Arc::new(program), asking))
    }

    fn stopped(&self, program: &Arc<Program>, asking: &Asking, engine: AnyEngine) -> Result<Reached> {
        check_start(&engine, &self.program)?;
        Reached::new(asking, program, engine, PRECISION, self.named.clone())
    }

    /// Parses a state: `r=2,c=2,d=false`. Missing variables get their initial values.
    ///
    /// # Errors
    /// Unknown variables and values out of range, each with its place.
    pub fn state(&self, text: &str) -> Result<State> {
        lang::parse_state(&SourceFile::new("state", text), &self.program)
    }

    /// Returns the values of a state with the names of their variables, in the order of
    /// declaration.
    pub fn values<'s>(&'s self, state: &'s [i64]) -> impl Iterator<Item = (&'s str, Value)> {
        self.program.variables.iter().zip(state).map(|(variable, &value)| {
            let value = if variable.ty == Type::Bool { Value::Bool(value != 0) } else { Value::Int(value) };
            (variable.name.as_str(), value)
        })
    }
}

/// The partial results of a way of [`Model::check_by_any`].
struct Partial {
    found: Arc<Mutex<Option<Analysis>>>,
    sink: Arc<dyn ProgressSink>,
    /// True for the way whose events the listener hears.
    leads: bool,
}

impl Job for Partial {
    fn copy(&self) -> Self {
        Partial { found: Arc::default(), sink: Arc::clone(&self.sink), leads: false }
    }

    fn sink(&self) -> Arc<dyn ProgressSink> {
        Arc::clone(&self.sink)
    }

    fn leave_to(&self, way: Self) -> Self {
        Partial { found: Arc::clone(&self.found), sink: way.sink, leads: true }
    }

    fn take(&self, other: &Self) {
        if !Arc::ptr_eq(&self.found, &other.found) {
            let found = lock(&other.found).take();
            *lock(&self.found) = found;
        }
    }
}
