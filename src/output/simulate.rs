//! The report of `meliora simulate`.

use serde::Serialize;
use serde_json::{Map, Value as Json};

use super::Style;
use super::envelope::{Envelope, Findings};
use super::reason::Words;
use super::report::{ModelSummary, json_state};
use super::simulate_text;
use super::strategy::{PlanTime, change_word};
use crate::engine::Scope;
use crate::model::Program;
use crate::model::preference::Preferences;
use crate::planning::simulate::{Tally, Trace, Turn, Wait};
use crate::planning::{Kind, Rank, Scheduler, Setup};

/// The results of the runs, in the order of the JSON fields.
#[derive(Debug, Clone, Serialize)]
pub struct SimulateFindings {
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
    /// `permissive` or `progress`.
    pub strategy: Scheduler,
    /// Number of runs from each start.
    pub runs: u64,
    /// Maximum number of steps of a run.
    pub steps: u64,
    /// The seed.
    pub seed: u64,
    /// One entry per start.
    pub plays: Vec<PlaysReport>,
}

/// The report with times and memory.
pub type SimulateReport = Envelope<SimulateFindings>;

/// The runs from one state.
#[derive(Debug, Clone, Serialize)]
pub struct PlaysReport {
    /// The state where they start.
    pub state: Map<String, Json>,
    /// Its rank: the number of guaranteed or possible improvements.
    pub rank: Rank,
    /// The number of runs for each number of improvements.
    pub improvements: Vec<ImprovementsReport>,
    /// The steps until the first, the second, … improvement, counted from the start.
    pub steps_to: Vec<StepsReport>,
    /// Number of runs that ended where the strategy aims for no further improvement.
    pub settled: u64,
    /// Number of runs that were stopped after the maximum number of steps.
    pub given_up: u64,
    /// Number of these that had made fewer improvements than the rank says.
    pub undecided: u64,
    /// Number of runs with fewer improvements than the rank says; null if the rank is unbounded.
    pub fewer_than_rank: Option<u64>,
    /// Number of runs with a step that weakens the state before it.
    pub weakened_step: u64,
    /// Number of runs with a step that weakens the reference of the strategy: under `prefix` the
    /// start or the state after the last improvement, else the state before.
    pub weakened_reference: u64,
    /// Number of runs with a state that weakens the start.
    pub weakened_start: u64,
    /// The first run that weakened, or else the first run.
    pub trace: TraceReport,
}

/// The number of runs with one number of improvements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ImprovementsReport {
    /// The number of improvements.
    pub times: u64,
    /// The number of runs.
    pub plays: u64,
}

/// The steps until an improvement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StepsReport {
    /// The number of runs with this improvement.
    pub plays: u64,
    /// The minimum number of steps.
    pub least: u64,
    /// The mean number of steps.
    pub mean: f64,
    /// The maximum number of steps.
    pub most: u64,
}

impl From<&Wait> for StepsReport {
    fn from(wait: &Wait) -> Self {
        StepsReport { plays: wait.plays, least: wait.least, mean: wait.mean(), most: wait.most }
    }
}

/// One run in full.
#[derive(Debug, Clone, Serialize)]
pub struct TraceReport {
    /// The number of the run, from 1.
    pub play: u64,
    /// Its steps.
    pub turns: Vec<TurnReport>,
}

/// A step of a run.
#[derive(Debug, Clone, Serialize)]
pub struct TurnReport {
    /// The action taken.
    pub action: String,
    /// The state entered.
    pub state: Map<String, Json>,
    /// The probability of the successor under the action.
    pub probability: f64,
    /// The most preferred objectives of the state entered.
    pub most_preferred: Vec<String>,
    /// Its rank.
    pub rank: Rank,
    /// `improving`, `weakening` or `lateral`, compared with the reference of the strategy.
    pub change: &'static str,
    /// True if the step is counted as an improvement.
    pub improves: bool,
    /// The objectives that are preferred to one of the state before.
    pub gained: Vec<String>,
    /// The objectives of the state before that are preferred to one of the state entered.
    pub lost: Vec<String>,
    /// True if the step weakens the state before.
    pub weakens_step: bool,
    /// True if the state entered weakens the start.
    pub weakens_start: bool,
    /// The values that change, for the text output.
    #[serde(skip)]
    pub changed: String,
}

impl PlaysReport {
    /// Creates the report of a tally.
    pub fn new(program: &Program, preferences: &Preferences, tally: &Tally) -> Self {
        let rank = tally.rank;
        let fewer_than_rank = match rank {
            Rank::Finite(k) | Rank::AtLeast(k) => Some(tally.fewer_than(k)),
            Rank::Unbounded => None,
        };
        let often = |(&times, &plays): (&usize, &u64)| ImprovementsReport { times: times as u64, plays };
        PlaysReport {
            state: json_state(program, &tally.start),
            rank,
            improvements: tally.improvements.iter().map(often).collect(),
            steps_to: tally.waits.iter().map(StepsReport::from).collect(),
            settled: tally.settled,
            given_up: tally.given_up,
            undecided: tally.undecided,
            fewer_than_rank,
            weakened_step: tally.weakened_step,
            weakened_reference: tally.weakened_reference,
            weakened_start: tally.weakened_start,
            trace: TraceReport::new(program, preferences, &tally.start, &tally.trace),
        }
    }
}

impl TraceReport {
    /// Creates the report of a run from a state.
    pub fn new(program: &Program, preferences: &Preferences, start: &[i64], trace: &Trace) -> Self {
        // The kind does not occur in these texts.
        let words = Words { program, preferences, kind: Kind::Sasi };
        let mut before = start;
        let mut turns = Vec::with_capacity(trace.turns.len());
        for t in &trace.turns {
            turns.push(turn(words, before, t));
            before = &t.state;
        }
        TraceReport { play: trace.play, turns }
    }
}

fn turn(words: Words<'_>, before: &[i64], turn: &Turn) -> TurnReport {
    TurnReport {
        action: turn.action.clone(),
        state: json_state(words.program, &turn.state),
        probability: turn.probability,
        most_preferred: words.names(&turn.most_preferred),
        rank: turn.rank,
        change: change_word(turn.change),
        improves: turn.improves,
        gained: words.names(&turn.gained),
        lost: words.names(&turn.lost),
        weakens_step: turn.weakens_step,
        weakens_start: turn.weakens_start,
        changed: words.changed(before, &turn.state),
    }
}

impl SimulateReport {
    /// Creates a report without results.
    pub fn new(
        model: &str,
        preferences: &str,
        engine: &'static str,
        scope: Scope,
        safety: &'static str,
        kind: Kind,
        setup: Setup,
    ) -> Self {
        Envelope::of(SimulateFindings {
            model: ModelSummary::of_path(model),
            preferences: preferences.to_owned(),
            engine,
            scope,
            safety,
            empty: None,
            kind,
            strategy: setup.scheduler,
            runs: setup.runs,
            steps: setup.steps,
            seed: setup.seed,
            plays: Vec::new(),
        })
    }
}

impl Findings for SimulateFindings {
    const SCHEMA: &str = "meliora.simulate/1";
    type Time = PlanTime;

    fn text(report: &SimulateReport, style: Style) -> String {
        simulate_text::render(report, style)
    }
}
