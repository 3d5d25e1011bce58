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

/// What came of the plays, in the order in which JSON has it.
#[derive(Debug, Clone, Serialize)]
pub struct SimulateFindings {
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
    /// `permissive` or `progress`.
    pub strategy: Scheduler,
    /// How many plays from each state.
    pub runs: u64,
    /// A play is given up after so many steps.
    pub steps: u64,
    /// The seed.
    pub seed: u64,
    /// One entry a starting state.
    pub plays: Vec<PlaysReport>,
}

/// The report with what it took.
pub type SimulateReport = Envelope<SimulateFindings>;

/// The plays from one state.
#[derive(Debug, Clone, Serialize)]
pub struct PlaysReport {
    /// Where they start.
    pub state: Map<String, Json>,
    /// Its rank: so many improvements are promised, surely or possibly.
    pub rank: Rank,
    /// How many plays improved how often.
    pub improvements: Vec<ImprovementsReport>,
    /// The steps that the first, the second, … improvement took, counted from the start.
    pub steps_to: Vec<StepsReport>,
    /// Plays that ended where the strategy has no improvement left to aim for.
    pub settled: u64,
    /// Plays that were given up.
    pub given_up: u64,
    /// Those among them that had not yet improved as often as the rank says.
    pub undecided: u64,
    /// Plays that improved less often than the rank says; null where the rank is unbounded.
    pub fewer_than_rank: Option<u64>,
    /// Plays with a step that weakens the state before it.
    pub weakened_step: u64,
    /// Plays with a step that weakens what the strategy measures against: under `prefix` the state
    /// where planning started or the last improvement after it, else the state before.
    pub weakened_reference: u64,
    /// Plays with a state that weakens the state they started in.
    pub weakened_start: u64,
    /// The first play that weakened, or else the first play.
    pub trace: TraceReport,
}

/// So many plays improved so often.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct ImprovementsReport {
    /// How often.
    pub times: u64,
    /// How many plays.
    pub plays: u64,
}

/// The steps that an improvement took.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StepsReport {
    /// In how many plays it came.
    pub plays: u64,
    /// The fewest steps.
    pub least: u64,
    /// The average.
    pub mean: f64,
    /// The most steps.
    pub most: u64,
}

impl From<&Wait> for StepsReport {
    fn from(wait: &Wait) -> Self {
        StepsReport { plays: wait.plays, least: wait.least, mean: wait.mean(), most: wait.most }
    }
}

/// A play in full.
#[derive(Debug, Clone, Serialize)]
pub struct TraceReport {
    /// Which play, from 1.
    pub play: u64,
    /// Its steps.
    pub turns: Vec<TurnReport>,
}

/// A step of a play.
#[derive(Debug, Clone, Serialize)]
pub struct TurnReport {
    /// The action taken.
    pub action: String,
    /// The state entered.
    pub state: Map<String, Json>,
    /// How likely that was under the action.
    pub probability: f64,
    /// The most preferred outcomes of the state entered.
    pub most_preferred: Vec<String>,
    /// Its rank.
    pub rank: Rank,
    /// `improving`, `weakening` or `lateral`, against what the strategy measures against.
    pub change: &'static str,
    /// Whether the step was an improvement of the play.
    pub improves: bool,
    /// What is preferred to something had before.
    pub gained: Vec<String>,
    /// What the state before had that is preferred to something had now.
    pub lost: Vec<String>,
    /// Whether it weakens the state before.
    pub weakens_step: bool,
    /// Whether it weakens the state where the play started.
    pub weakens_start: bool,
    /// The values that change, for people.
    #[serde(skip)]
    pub changed: String,
}

impl PlaysReport {
    /// The plays that a tally counts.
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
    /// A play from a state.
    pub fn new(program: &Program, preferences: &Preferences, start: &[i64], trace: &Trace) -> Self {
        // The kind matters to no word that is used here.
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
    /// A report of which nothing but the question is known.
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
