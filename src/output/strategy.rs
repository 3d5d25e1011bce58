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

/// The results of `strategy`, in the order of the JSON fields.
#[derive(Debug, Clone, Serialize)]
pub struct StrategyFindings {
    /// The model.
    pub model: ModelSummary,
    /// The preference file as the user named it.
    #[serde(skip)]
    pub preferences: String,
    /// The name of the engine.
    pub engine: &'static str,
    /// The valuations that are states.
    pub scope: Scope,
    /// The name of the safety filter.
    pub safety: &'static str,
    /// The value of nothing: the `empty` statement of the preferences.
    pub empty: Option<&'static str>,
    /// `sasi` or `spi`.
    pub kind: Kind,
    /// With `--rank` or by default the number of states; those past the limit are not listed.
    pub asked: Option<Number>,
    /// The requested states.
    pub states: Vec<Shown>,
    /// The DOT graph, which replaces the text report.
    #[serde(skip)]
    pub drawing: Option<String>,
    /// True if CSV rows were already written.
    #[serde(skip)]
    pub streamed: bool,
}

/// The report with times and memory.
pub type StrategyReport = Envelope<StrategyFindings>;

/// A state in its final form. There may be millions, and this form takes a fraction of the memory
/// of a [`StateReport`].
#[derive(Debug, Clone, Serialize)]
#[serde(untagged)]
pub enum Shown {
    /// For the JSON output.
    Json(Box<RawValue>),
    /// For the text output.
    Text(String),
}

/// A state under the strategy.
#[derive(Debug, Clone, Serialize)]
pub struct StateReport {
    /// Its values by variable.
    pub state: Map<String, Json>,
    /// The most preferred objectives that are sure there.
    pub most_preferred: Vec<String>,
    /// Number of guaranteed improvements.
    pub sasi_rank: Rank,
    /// Number of possible improvements.
    pub spi_rank: Rank,
    /// The action of the progress strategy; `None` at rank 0.
    pub progress_action: Option<String>,
    /// All enabled actions, in the order of the program.
    pub actions: Vec<ActionReport>,
    /// The maximum length of a path under the progress strategy; `None` if it is unbounded or was
    /// not computed.
    pub longest_play: Option<usize>,
    /// The paths under the progress strategy, for the text output.
    #[serde(skip)]
    pub course: Option<Vec<CourseLine>>,
}

/// An enabled action.
#[derive(Debug, Clone, Serialize)]
pub struct ActionReport {
    /// Its name.
    pub name: String,
    /// True if the safety filter keeps the action.
    pub kept: bool,
    /// True if the permissive strategy permits the action.
    pub permitted: bool,
    /// True if it comes closer to an improvement with positive probability.
    pub progress: bool,
    /// The reason as one word.
    pub verdict: &'static str,
    /// The reason as text.
    pub reason: String,
    /// The successors.
    pub successors: Vec<SuccessorReport>,
}

/// A successor of an action.
#[derive(Debug, Clone, Serialize)]
pub struct SuccessorReport {
    /// Its values by variable.
    pub state: Map<String, Json>,
    /// Its probability.
    pub probability: f64,
    /// Its most preferred objectives.
    pub most_preferred: Vec<String>,
    /// `improving`, `weakening` or `lateral`.
    pub change: &'static str,
    /// The objectives that are preferred to one of the state before.
    pub gained: Vec<String>,
    /// The objectives of the state before that are preferred to one of this state.
    pub lost: Vec<String>,
    /// Its rank, of the requested kind.
    pub rank: Rank,
    /// True if `--safety transition` drops the branch.
    pub dropped: bool,
    /// True if it is an improvement that the strategy relies on.
    pub goal: bool,
    /// The values that change, for the text output.
    #[serde(skip)]
    pub changed: String,
}

/// A node of the induced model, for the text output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CourseLine {
    /// The values that differ from the start; for the start itself, `start`.
    pub place: String,
    /// The most preferred objectives.
    pub most_preferred: String,
    /// The level: the number of improvements that the strategy aims for.
    pub ahead: String,
    /// The action and its successors.
    pub then: String,
}

/// Seconds by phase; `None` for an unfinished phase.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct PlanTime {
    /// Reading the model, the preferences and the states.
    pub parse: Option<f64>,
    /// Encoding the model and finding the reachable states.
    pub build: Option<f64>,
    /// Outcomes, improvement MDP and levels.
    pub levels: Option<f64>,
    /// The explanations, or the simulation.
    pub answer: Option<f64>,
    /// The total.
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
    /// Creates the report of a state with its SASI and SPI ranks.
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

    /// Adds the paths under the progress strategy.
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
    /// Creates a report without results.
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
    /// Adds a state: as text if there is a style, else as JSON.
    pub fn push(&mut self, state: &StateReport, style: Option<Style>) {
        let shown = match style {
            Some(style) => Shown::Text(strategy_text::one(self.kind, state, style)),
            // The keys are strings and the values plain, so the conversion cannot fail.
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
