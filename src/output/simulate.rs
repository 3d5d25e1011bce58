//! The report of `meliora simulate`.

use serde::Serialize;

use super::envelope::Envelope;
use super::header::Header;
use super::reason::Words;
use crate::model::Program;
use crate::model::preference::Preferences;
use crate::model::valuation::Valuation;
use crate::planning::simulate::{Tally, Trace, Turn, Wait};
use crate::planning::{Kind, Rank, Scheduler, Setup};

/// The results of the runs, in the order of the JSON fields.
#[derive(Debug, Clone, Serialize)]
pub struct SimulateFindings {
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
    pub state: Valuation,
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
    pub state: Valuation,
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
            state: Valuation::of(program, &tally.start),
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
        state: Valuation::of(words.program, &turn.state),
        probability: turn.probability,
        most_preferred: words.names(&turn.most_preferred),
        rank: turn.rank,
        change: turn.change.name(),
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
    pub fn of_setup(header: Header, kind: Kind, setup: Setup) -> Self {
        let Setup { scheduler: strategy, runs, steps, seed } = setup;
        Envelope::of(header, SimulateFindings { kind, strategy, runs, steps, seed, plays: Vec::new() })
    }
}
