//! The report of `meliora strategy`.

use serde::Serialize;
use serde_json::value::{RawValue, to_raw_value};
use serde_json::{Map, Value as Json};

use super::envelope::{Envelope, Findings, Time};
use super::reason::Words;
use super::report::{ModelSummary, json_state};
use super::{Number, Style, strategy_text};
use crate::engine::Scope;
use crate::model::Program;
use crate::model::preference::{Change, Preferences};
use crate::planning::explain::{self, Explanation, Verdict};
use crate::planning::{InducedModel, Kind, Rank};

/// What `strategy` found, in the order in which JSON has it.
#[derive(Debug, Clone, Serialize)]
pub struct StrategyFindings {
    /// The model.
    pub model: ModelSummary,
    /// The preference file as the user named it.
    #[serde(skip)]
    pub preferences: String,
    /// The name of the engine.
    pub engine: &'static str,
    /// Which valuations are states.
    pub scope: Scope,
    /// The name of the safety filter.
    pub safety: &'static str,
    /// What an empty set of outcomes is worth.
    pub empty: Option<&'static str>,
    /// `sasi` or `spi`.
    pub kind: Kind,
    /// With `--rank` or by default: how many states there are; those past the limit are not listed.
    pub asked: Option<Number>,
    /// The states asked for.
    pub states: Vec<Shown>,
    /// Text that stands in place of the report for people: DOT.
    #[serde(skip)]
    pub drawing: Option<String>,
    /// Whether the rows were written already: CSV.
    #[serde(skip)]
    pub streamed: bool,
}

/// The report with what it took.
pub type StrategyReport = Envelope<StrategyFindings>;

/// A state in the form in which it is shown at the end: there may be millions of them, and this takes a
/// fraction of what a [`StateReport`] does.
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum Shown {
    /// For programs.
    Json(Box<RawValue>),
    /// For people.
    Text(String),
}

/// A state under the strategy.
#[derive(Debug, Clone, Serialize)]
pub struct StateReport {
    /// Its values by variable.
    pub state: Map<String, Json>,
    /// The most preferred outcomes it has already.
    pub most_preferred: Vec<String>,
    /// How often it improves almost surely.
    pub sasi_rank: Rank,
    /// How often it improves with positive probability.
    pub spi_rank: Rank,
    /// What the progress strategy does there; none at rank 0.
    pub progress_action: Option<String>,
    /// All enabled actions, in the order of the program.
    pub actions: Vec<ActionReport>,
    /// The most steps that a play under the progress strategy can take from there; none where there
    /// is no bound, or where it was not searched for.
    pub longest_play: Option<usize>,
    /// How such a play goes, for people.
    #[serde(skip)]
    pub course: Option<Vec<CourseLine>>,
}

/// An enabled action.
#[derive(Debug, Clone, Serialize)]
pub struct ActionReport {
    /// Its name.
    pub name: String,
    /// Whether it is safe to take.
    pub kept: bool,
    /// Whether the permissive strategy permits it.
    pub permitted: bool,
    /// Whether it comes closer to an improvement with positive probability.
    pub progress: bool,
    /// Why, in one word.
    pub verdict: &'static str,
    /// Why, in words.
    pub reason: String,
    /// Where it may lead.
    pub successors: Vec<SuccessorReport>,
}

/// A successor of an action.
#[derive(Debug, Clone, Serialize)]
pub struct SuccessorReport {
    /// Its values by variable.
    pub state: Map<String, Json>,
    /// How likely it is.
    pub probability: f64,
    /// Its most preferred outcomes.
    pub most_preferred: Vec<String>,
    /// `improving`, `weakening` or `lateral`.
    pub change: &'static str,
    /// What is preferred to something had before.
    pub gained: Vec<String>,
    /// What was had before and is preferred to something had there.
    pub lost: Vec<String>,
    /// Its rank, of the kind asked for.
    pub rank: Rank,
    /// Whether `--safety transition` leaves the branch out of account.
    pub dropped: bool,
    /// Whether it is an improvement that the strategy counts on.
    pub goal: bool,
    /// The values that change, for people.
    #[serde(skip)]
    pub changed: String,
}

/// A place in a play, for people.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CourseLine {
    /// What differs from the state where the play starts; there, `the start`.
    pub place: String,
    /// The most preferred outcomes.
    pub most_preferred: String,
    /// The improvements ahead.
    pub ahead: String,
    /// The action, and where it leads.
    pub then: String,
}

/// Seconds by phase; none for a phase that was not finished.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct PlanTime {
    /// Reading the model, the preferences and the states.
    pub parse: Option<f64>,
    /// Encoding the model and finding the reachable states.
    pub build: Option<f64>,
    /// Outcomes, improvement MDP and levels.
    pub levels: Option<f64>,
    /// What was asked for: explaining, or playing.
    pub answer: Option<f64>,
    /// Everything.
    pub total: f64,
}

impl Time for PlanTime {
    fn total(&mut self) -> &mut f64 {
        &mut self.total
    }
}

fn verdict_word(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Improves => "improves",
        Verdict::MayImprove => "may-improve",
        Verdict::Approaches => "approaches",
        Verdict::Stays => "stays",
        Verdict::Weakens(_) => "weakens",
        Verdict::Unsafe(_) => "unsafe",
        Verdict::Strays(_) => "strays",
        Verdict::Hopeless => "hopeless",
        Verdict::NothingAhead => "nothing-ahead",
    }
}

/// `improving`, `weakening` or `lateral`.
pub(super) fn change_word(change: Change) -> &'static str {
    match change {
        Change::Improving => "improving",
        Change::Weakening => "weakening",
        Change::Lateral => "lateral",
    }
}

impl StateReport {
    /// What is to be said of a state, whose ranks by SASI and SPI are given.
    pub fn new(
        program: &Program,
        preferences: &Preferences,
        kind: Kind,
        at: &Explanation,
        [sasi, spi]: [Rank; 2],
    ) -> Self {
        let words = Words { program, preferences, kind };
        StateReport {
            state: json_state(program, &at.state),
            most_preferred: words.names(&at.most_preferred),
            sasi_rank: sasi,
            spi_rank: spi,
            progress_action: at.pick.and_then(|p| at.actions.get(p)).map(|a| a.name.clone()),
            actions: at.actions.iter().map(|a| action(words, at, a)).collect(),
            longest_play: None,
            course: None,
        }
    }

    /// Adds what can come of a play.
    pub fn set_course(
        &mut self,
        program: &Program,
        preferences: &Preferences,
        kind: Kind,
        course: &InducedModel,
    ) {
        self.longest_play = course.longest_play();
        self.course = Some(strategy_text::course(Words { program, preferences, kind }, course));
    }
}

fn action(words: Words<'_>, at: &Explanation, action: &explain::Action) -> ActionReport {
    let successor = |s: &explain::Successor| SuccessorReport {
        state: json_state(words.program, &s.state),
        probability: s.probability,
        most_preferred: words.names(&s.most_preferred),
        change: change_word(s.change),
        gained: words.names(&s.gained),
        lost: words.names(&s.lost),
        rank: s.rank,
        dropped: s.dropped,
        goal: s.goal,
        changed: words.changed(&at.state, &s.state),
    };
    ActionReport {
        name: action.name.clone(),
        kept: action.kept,
        permitted: action.permitted,
        progress: action.progress,
        verdict: verdict_word(action.verdict),
        reason: words.reason(at, action),
        successors: action.successors.iter().map(successor).collect(),
    }
}

impl StrategyReport {
    /// A report of which nothing but the question is known.
    pub fn new(
        model: &str,
        preferences: &str,
        engine: &'static str,
        scope: Scope,
        safety: &'static str,
        kind: Kind,
    ) -> Self {
        Envelope::of(StrategyFindings {
            model: ModelSummary::of_path(model),
            preferences: preferences.to_owned(),
            engine,
            scope,
            safety,
            empty: None,
            kind,
            asked: None,
            states: Vec::new(),
            drawing: None,
            streamed: false,
        })
    }
}

impl StrategyFindings {
    /// Adds a state: for people in a style, for programs without.
    pub fn push(&mut self, state: &StateReport, style: Option<Style>) {
        let shown = match style {
            Some(style) => Shown::Text(strategy_text::one(self.kind, state, style)),
            // Keys are strings and values plain: this has a form in JSON.
            None => Shown::Json(to_raw_value(state).unwrap_or_default()),
        };
        self.states.push(shown);
    }
}

impl Findings for StrategyFindings {
    const SCHEMA: &str = "meliora.strategy/1";
    type Time = PlanTime;

    fn text(report: &StrategyReport, style: Style) -> String {
        match &report.drawing {
            Some(drawing) => drawing.clone(),
            None if report.streamed => String::new(),
            None => strategy_text::render(report, style),
        }
    }
}
