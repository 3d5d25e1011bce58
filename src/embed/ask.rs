//! Properties of a model, answered as the command does.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use super::Model;
use meliora_base::error::{Error, Limit, Result, SourceFile};
use meliora_base::progress::ProgressSink;
use meliora_base::sync::lock;
use meliora_engine::{Selection, Settings, Usage};
use meliora_lang as lang;
use meliora_model::Program;
use meliora_quantities::PRECISION;
use meliora_question::answers::{OneQuestion, PropertyAnswer};
use meliora_question::list::Listed;
use meliora_question::plan::Planned;
use meliora_question::{
    Answers, Listener, Options, Questions, Strategies, WantedStrategies, Warning, list, pipeline, race,
};

/// The properties that are asked.
#[derive(Debug, Clone, Copy)]
pub enum Properties<'a> {
    /// Texts, and names of those that the model names.
    Texts(&'a [&'a str]),
    /// The same, where one that cannot be read has a reason, as in a file.
    Each(&'a [&'a str]),
    /// All of a property file in PRISM's language, with values for its constants: `K=4`, or the empty text.
    File(&'a Arc<SourceFile>, &'a str),
    /// All that the model names.
    Named,
}

/// Requirements and wishes next to properties, and the engine that answers these.
#[derive(Debug, Clone)]
pub struct Ask {
    /// Safe formulas that every strategy must keep: `G p`.
    pub require: Vec<String>,
    /// The largest width of a number, relative to the number above 1.
    pub precision: f64,
    /// The strategies that are wanted of the only property.
    pub strategies: WantedStrategies,
    /// The engine; [`Selection::open`] lets several ways race.
    pub engine: Selection,
}

impl Default for Ask {
    fn default() -> Self {
        let (require, strategies) = Default::default();
        Ask { require, precision: PRECISION, strategies, engine: Selection::open() }
    }
}

/// The answers to properties.
#[derive(Debug)]
pub struct AskResult {
    /// The answers, as far as they are known.
    pub answers: Answers,
    /// The strategies that were asked for.
    pub strategies: Strategies,
    /// The warnings.
    pub warnings: Vec<Warning>,
    /// The resources that the engine has used.
    pub usage: Option<Usage>,
    /// The limit that has ended the work before all properties had an answer.
    pub limit: Option<Limit>,
    /// The model, with the constants of a property file.
    pub program: Arc<Program>,
    /// The text of the only property.
    pub text: String,
}

#[cfg(feature = "output")]
impl AskResult {
    /// Returns the policy, or the strategies of `multi`, as JSON: what `meliora reach --policy` writes and `verify` checks.
    /// `None` if there are none, or they are not asked for.
    ///
    /// # Errors
    /// A command has no meaning in some state.
    pub fn policy_json(&self) -> Result<Option<String>> {
        match &self.strategies {
            Strategies { policy: Some(found), .. } => {
                meliora_report::policy::json(found, &self.program).map(Some)
            }
            Strategies { mix: Some(found), .. } if !found.strategies.is_empty() => {
                meliora_report::mix::json(&self.text, found, &self.program).map(Some)
            }
            Strategies { optimal: Some(found), .. } => {
                meliora_report::property_policy::json(&self.text, found, &self.program).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// Returns the strategy of the opponent as [`AskResult::policy_json`] does.
    ///
    /// # Errors
    /// A command has no meaning in some state.
    pub fn opponent_json(&self) -> Result<Option<String>> {
        let text = |found| meliora_report::property_policy::json(&self.text, found, &self.program);
        self.strategies.opponent.as_ref().map(text).transpose()
    }
}

impl Model {
    /// Returns the question of a planning problem: whether a plan reaches its goal almost surely; `None` if there is no
    /// goal that must hold.
    pub fn goal_property(&self) -> Option<&'static str> {
        list::of_goal(self.program())
    }

    /// Answers properties: conditions on states, whose operators ask for
    /// probabilities, rewards, several objectives. Requests about the initial states are answered before all states are
    /// known where one of several ways can do so. Properties share their regions. One that is not answered has a reason if
    /// it is one of several; see [`Answers`].
    ///
    /// ```
    /// use meliora::{Ask, Model, Properties, Settings};
    ///
    /// let model = Model::parse("mdp
    ///     module walk
    ///       x : [0..3] init 0;
    ///       [left] x=0 -> 1/4: (x'=1) + 3/4: (x'=3);
    ///       [right] x=0 -> (x'=2);
    ///       [stay] x>0 -> true;
    ///     endmodule", "")?;
    /// let asked = Properties::Texts(&["Pmax=? [ F x=1 ]", "!(Pmax>=1 [ F x=1 ]) & Pmax>=1 [ F x=2 ]"]);
    /// let found = model.ask(asked, &Ask::default(), Settings::default())?.answers;
    /// let value = found.properties[0].value.clone().flatten().unwrap();
    /// assert!(value.lower <= 0.25 && 0.25 <= value.upper);
    /// assert_eq!(found.properties[1].holds, Some(true));
    /// # Ok::<(), meliora::Error>(())
    /// ```
    ///
    /// # Errors
    /// A text is wrong, each error with its place; the only property cannot be answered; the errors of
    /// [`Model::explore`], save that a limit leaves the answers so far.
    pub fn ask(&self, properties: Properties<'_>, ask: &Ask, settings: Settings) -> Result<AskResult> {
        let (questions, entries) = self.questions(properties, &ask.require)?;
        questions.check(ask.strategies)?;
        let options = Options {
            selected: ask.engine.clone(),
            precision: ask.precision,
            is_one: matches!(properties, Properties::Texts([_]) | Properties::Each([_])),
            regions: false,
            strategies: ask.strategies,
            settings,
        };
        answered(&questions, entries, &options)
    }

    /// Returns the names of the properties that the model names.
    pub fn properties(&self) -> impl Iterator<Item = &str> {
        self.properties.iter().map(|property| property.name.as_str())
    }

    fn questions(
        &self,
        properties: Properties<'_>,
        require: &[String],
    ) -> Result<(Questions, Vec<PropertyAnswer>)> {
        let mut program = Program::clone(self.program());
        let required = list::required("require", require.iter().map(String::as_str))?;
        let all = match properties {
            Properties::Texts(texts) => {
                let named = (&program, &self.properties[..]);
                let plan = list::planned(named, ("property", texts.iter().copied()), &required, false)?;
                let open = |property: &Planned| PropertyAnswer::open(None, property.text.clone(), None);
                let entries = plan.properties.iter().map(open).collect();
                return Ok((Questions::new(program, plan, required, false), entries));
            }
            Properties::File(source, constants) => {
                let constants = SourceFile::new("constants", constants);
                let stated = lang::parse_properties(source, &constants, &mut program)?;
                Vec::from_iter(stated.into_iter().map(Listed::from))
            }
            Properties::Each(texts) => list::each((&program, &self.properties), ("property", texts)),
            Properties::Named => list::named(&program, &self.properties),
        };
        let (plan, entries) = list::list(&program, &required, false, all.into_iter())?;
        Ok((Questions::new(program, plan, required, true), entries))
    }
}

/// Answers questions; a limit leaves the answers so far.
fn answered(questions: &Questions, properties: Vec<PropertyAnswer>, options: &Options) -> Result<AskResult> {
    let one = options.is_one.then(OneQuestion::default);
    let answers = Answers { one, properties, ..Answers::default() };
    let state = State { answers, ..State::default() };
    let sink = Arc::clone(&options.settings.sink);
    let limit = sink.remaining();
    let kept = Kept { state: Arc::new(Mutex::new(state)), sink: Arc::new(Shared::new(sink, limit, None)) };
    let (strategies, limit) = match pipeline::answer(&kept, options, questions) {
        Ok(strategies) => (strategies, None),
        Err(Error::Limit(limit)) => (Strategies::default(), Some(limit)),
        Err(error) => return Err(error),
    };
    let State { answers, warnings, usage, .. } = lock(&kept.state).clone();
    let (program, text) = (Arc::clone(&questions.program), questions.text());
    Ok(AskResult { answers, strategies, warnings, usage, limit, program, text })
}

/// Answers that are kept while others are found, for a way of a race.
struct Kept {
    state: Arc<Mutex<State>>,
    sink: Arc<Shared>,
}

#[derive(Clone, Default)]
struct State {
    answers: Answers,
    warnings: Vec<Warning>,
    usage: Option<Usage>,
    /// The limit that has ended the first share of the work.
    ended: Option<Limit>,
}

/// The sink of the caller, with the end of a share of the time.
struct Shared {
    sink: Arc<dyn ProgressSink>,
    /// The time that all of the work has.
    limit: Option<Duration>,
    /// The end of the share on the clock of the caller.
    end: Mutex<Option<Duration>>,
}

impl Shared {
    fn new(sink: Arc<dyn ProgressSink>, limit: Option<Duration>, end: Option<Duration>) -> Self {
        Shared { sink, limit, end: Mutex::new(end) }
    }
}

impl ProgressSink for Shared {
    fn stop(&self) -> Option<Limit> {
        let is_late = || lock(&self.end).is_some_and(|end| end <= self.sink.clock());
        let late = || is_late().then(|| Limit::Share(self.limit.unwrap_or_default()));
        self.sink.stop().or_else(late)
    }

    fn advance(&self, steps: u64) {
        self.sink.advance(steps);
    }

    fn clock(&self) -> Duration {
        self.sink.clock()
    }

    fn remaining(&self) -> Option<Duration> {
        self.sink.remaining()
    }

    fn progress(&self, phase: &'static str, detail: &dyn Fn() -> String) {
        self.sink.progress(phase, detail);
    }
}

impl race::Job for Kept {
    fn copy(&self) -> Self {
        let state = Arc::new(Mutex::new(lock(&self.state).clone()));
        Kept { state, sink: Arc::clone(&self.sink) }
    }

    fn of_way(&self, _: usize) -> Self {
        let Shared { sink, limit, end } = &*self.sink;
        let sink = Shared::new(Arc::clone(sink), *limit, *lock(end));
        Kept { sink: Arc::new(sink), ..self.copy() }
    }

    fn sink(&self) -> Arc<dyn ProgressSink> {
        Arc::clone(&self.sink) as _
    }

    fn leave_to(&self, way: Self) -> Self {
        Kept { state: Arc::clone(&self.state), sink: way.sink }
    }

    fn take(&self, other: &Self) {
        if !Arc::ptr_eq(&self.state, &other.state) {
            let state = lock(&other.state).clone();
            *lock(&self.state) = state;
        }
    }
}

impl Listener for Kept {
    fn change(&self, change: &mut dyn FnMut(&mut Answers)) {
        change(&mut lock(&self.state).answers);
    }

    fn used(&self, usage: Usage) {
        let known = &mut lock(&self.state).usage;
        *known = Some(match *known {
            Some(known) if known.peak_nodes > usage.peak_nodes => known,
            _ => usage,
        });
    }

    fn begin(&self, _: &'static str) {}

    fn end(&self, _: &'static str, _: &'static str) {}

    fn warn(&self, warning: Warning) {
        lock(&self.state).warnings.push(warning);
    }

    fn stop(&self) -> Option<Limit> {
        self.sink.sink.stop()
    }

    fn share(&self, parts: Option<usize>) {
        let parts = parts.and_then(|parts| u32::try_from(parts).ok()?.checked_add(1));
        let left = parts.and_then(|parts| Some(self.sink.remaining()? / parts));
        *lock(&self.sink.end) = left.map(|left| self.sink.clock() + left);
    }

    fn end_share(&self, limit: Limit) {
        lock(&self.state).ended.get_or_insert(limit);
    }

    fn ended_share(&self) -> Option<Limit> {
        lock(&self.state).ended.take()
    }
}
