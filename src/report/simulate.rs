//! The report of `meliora simulate`.

use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};
use serde_json::json;

use super::choose::{Attains, Choosing, Comparison};
use super::envelope::Envelope;
use super::header::Header;
use super::reason::Words;
use meliora_model::Program;
use meliora_model::preference::Preferences;
use meliora_model::valuation::Valuation;
use meliora_planning::tally::{Commitment, Tally, Trace, Turn, Wait};
use meliora_planning::{Kind, Rank, Scheduler, Setup, StrategyKind};
use meliora_quantities::choose::Attained;

/// The results of the runs, in the order of the JSON fields.
#[derive(Debug, Clone, Serialize)]
pub struct SimulateFindings {
    /// `sasi`, `spi`, `plan` or `achieve`.
    pub kind: StrategyKind,
    /// The choice among permitted actions.
    #[serde(flatten)]
    pub choosing: Choosing,
    /// `permissive` or `progress`.
    pub strategy: Scheduler,
    /// Number of runs from each start.
    pub runs: u64,
    /// Maximum number of steps of a run.
    pub steps: u64,
    /// The seed.
    pub seed: u64,
    /// One entry per start.
    #[serde(rename = "plays")]
    pub starts: Vec<RunsReport>,
}

/// The report with times and memory.
pub type SimulateReport = Envelope<SimulateFindings>;

/// The runs from one state.
#[derive(Debug, Clone)]
pub struct RunsReport {
    /// The state where they start.
    pub state: Valuation,
    /// Their statistics.
    pub tally: Tally,
    /// The value that the strategy attains, next to what was measured.
    pub value: Option<Comparison>,
    /// The objectives that runs achieved, in the order of declaration; `None` if the strategy achieves
    /// none.
    pub achieved: Option<Vec<AchievedReport>>,
    /// The commitments of runs; `None` if the strategy is not a plan.
    pub commits: Option<Vec<CommitReport>>,
    /// The first run that weakened, or else the first run.
    pub trace: TraceReport,
    /// True if no improvement is possible from this state.
    pub is_hopeless: bool,
}

/// An objective that runs achieved.
#[derive(Debug, Clone, Serialize)]
pub struct AchievedReport {
    /// Its name.
    pub objective: String,
    /// The number of steps until then.
    #[serde(flatten)]
    pub wait: Wait,
}

/// A commitment of runs.
#[derive(Debug, Clone, Serialize)]
pub struct CommitReport {
    /// The objective that they then pursue.
    pub objective: String,
    /// The other most preferred objectives that they lose afterwards.
    pub gives_up: Vec<String>,
    /// The number of these runs.
    pub runs: u64,
}

/// One run in full.
#[derive(Debug, Clone, Serialize)]
pub struct TraceReport {
    /// The number of the run, from 1.
    #[serde(rename = "play")]
    pub run: u64,
    /// The objectives that are achieved in its start state.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub achieved: Vec<String>,
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
    /// True if the state entered is unsafe.
    #[serde(skip)]
    pub is_unsafe: bool,
    /// True if the step weakens the state before, and the run has not committed.
    pub weakens_step: bool,
    /// True if the state entered weakens the start, and the run has not committed.
    pub weakens_start: bool,
    /// The objective to which the run commits before this step.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub commits: Option<String>,
    /// The objectives that the step gives up, for the first time since the commitment.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gives_up: Vec<String>,
    /// The objectives that are achieved for the first time in the state entered.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub achieved: Vec<String>,
    /// The values that change, for the text output.
    #[serde(skip)]
    pub changed: String,
}

impl RunsReport {
    /// Creates the report of a tally of runs under a strategy of this kind.
    pub fn new(program: &Program, preferences: &Preferences, kind: StrategyKind, tally: Tally) -> Self {
        let state = Valuation::of(program, &tally.start);
        let trace = TraceReport::new(program, preferences, &tally.start, &tally.trace);
        let name = |objective: usize| preferences.objectives[objective].name.clone();
        let achieved = tally.achieved.as_ref().map(|achieved| {
            let entry = |(&o, &wait)| AchievedReport { objective: name(o), wait };
            achieved.waits.iter().map(entry).collect()
        });
        let commit = |(Commitment { objective, gives_up }, &runs): (&Commitment, &u64)| CommitReport {
            objective: name(*objective),
            gives_up: preferences.owned_names(gives_up),
            runs,
        };
        let plans = kind == StrategyKind::Plan;
        let commits = plans.then(|| tally.commitments.iter().map(commit).collect());
        RunsReport { state, tally, value: None, achieved, commits, trace, is_hopeless: false }
    }

    /// Adds whether no improvement is possible from the state.
    #[must_use]
    pub fn hopeless(self, is_hopeless: bool) -> Self {
        RunsReport { is_hopeless, ..self }
    }

    /// Adds the value that the strategy attains, if it is known.
    #[must_use]
    pub fn compared(self, attained: Option<Attained>) -> Self {
        let attained = attained.as_ref().map(Attains::new);
        let value = attained.zip(self.tally.sample.clone());
        RunsReport { value: value.map(|(value, sample)| Comparison { value, sample }), ..self }
    }
}

impl Serialize for RunsReport {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let tally = &self.tally;
        let often = |(times, runs): (&usize, &u64)| json!({"times": times, "plays": runs});
        let mut fields = serializer.serialize_struct("RunsReport", 18)?;
        fields.serialize_field("state", &self.state)?;
        match tally.is_unsafe {
            true => fields.serialize_field("unsafe", &true)?,
            false => fields.skip_field("unsafe")?,
        }
        fields.serialize_field("rank", &tally.rank)?;
        fields.serialize_field("improvements", &tally.improvements.iter().map(often).collect::<Vec<_>>())?;
        fields.serialize_field("steps_to", &tally.waits)?;
        match (&self.achieved, &tally.achieved) {
            (Some(objectives), Some(achieved)) => {
                fields.serialize_field("achieved", objectives)?;
                fields.serialize_field("achieved_runs", &achieved.runs)?;
                fields.serialize_field("kept_runs", &achieved.kept)?;
            }
            _ => ["achieved", "achieved_runs", "kept_runs"]
                .iter()
                .try_for_each(|name| fields.skip_field(name))?,
        }
        match &self.commits {
            Some(commits) => fields.serialize_field("commits", commits)?,
            None => fields.skip_field("commits")?,
        }
        fields.serialize_field("settled", &tally.settled)?;
        fields.serialize_field("given_up", &tally.given_up)?;
        fields.serialize_field("undecided", &tally.undecided)?;
        fields.serialize_field("fewer_than_rank", &tally.fewer_than_rank())?;
        fields.serialize_field("weakened_step", &tally.weakened_step)?;
        fields.serialize_field("weakened_reference", &tally.weakened_reference)?;
        fields.serialize_field("weakened_start", &tally.weakened_start)?;
        fields.serialize_field("entered_unsafe", &tally.entered_unsafe)?;
        fields.serialize_field("value", &self.value)?;
        fields.serialize_field("trace", &self.trace)?;
        fields.end()
    }
}

impl TraceReport {
    /// Creates the report of a run from a state.
    pub fn new(program: &Program, preferences: &Preferences, start: &[i64], trace: &Trace) -> Self {
        // The kind does not occur in these texts.
        let words = Words { program, preferences, kind: StrategyKind::Sasi, levels: Kind::Sasi };
        let mut before = start;
        let mut turns = Vec::with_capacity(trace.turns.len());
        for t in &trace.turns {
            turns.push(turn(words, before, t));
            before = &t.state;
        }
        TraceReport { run: trace.run, achieved: words.names(&trace.achieved), turns }
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
        is_unsafe: turn.is_unsafe,
        weakens_step: turn.weakens_step,
        weakens_start: turn.weakens_start,
        commits: turn.commits.map(|objective| words.preferences.objectives[objective].name.clone()),
        gives_up: words.names(&turn.gives_up),
        achieved: words.names(&turn.achieved),
        changed: words.changed(before, &turn.state),
    }
}

impl SimulateReport {
    /// Creates a report without results.
    pub fn of_setup(header: Header, (kind, choosing): (StrategyKind, Choosing), setup: Setup) -> Self {
        let Setup { scheduler: strategy, runs, steps, seed } = setup;
        Envelope::of(
            header,
            SimulateFindings { kind, choosing, strategy, runs, steps, seed, starts: Vec::new() },
        )
    }
}
