//! The report of `meliora simulate`.

use schemars::JsonSchema;
use serde::Serialize;

use super::choose::{Attains, Choosing, Comparison};
use super::envelope::Envelope;
use super::header::Header;
use super::reason::Words;
use meliora_model::Program;
use meliora_model::players::Player;
use meliora_model::preference::{Change, Preferences};
use meliora_model::valuation::Valuation;
use meliora_planning::tally::{Commitment, Tally, Trace, Turn, Wait};
use meliora_planning::{Kind, Opponent, Rank, Scheduler, Setup, StrategyKind};
use meliora_quantities::choose::Attained;

/// The results of the runs, in the order of the JSON fields.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[schemars(rename = "simulate")]
pub struct SimulateFindings {
    /// The kind of the strategy.
    pub kind: StrategyKind,
    /// The choice among permitted actions.
    #[serde(flatten)]
    pub choosing: Choosing,
    /// The actions that the paths take.
    pub strategy: Scheduler,
    /// The number of paths per starting state.
    pub runs: u64,
    /// The number of steps after which a path is given up.
    pub steps: u64,
    /// The seed of the random numbers.
    pub seed: u64,
    /// The choices of the opponent; absent if the model is not a game.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opponent: Option<Opponent>,
    /// The results, one per starting state; empty before the first ends.
    #[serde(rename = "plays")]
    pub starts: Vec<RunsReport>,
}

/// The report with times and memory.
pub type SimulateReport = Envelope<SimulateFindings>;

/// The runs from one state.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(into = "Runs")]
#[schemars(with = "Runs")]
pub struct RunsReport {
    /// The state where they start.
    pub state: Valuation,
    /// Their statistics.
    pub tally: Tally,
    /// The value that the strategy attains, next to the measured one.
    pub value: Option<Comparison>,
    /// The objectives that runs achieved, in the order of declaration; `None` if the strategy achieves
    /// none.
    pub achieved: Option<Vec<AchievedReport>>,
    /// The players, with the steps that they chose; empty if the model is not a game.
    pub players: Vec<MovesReport>,
    /// The commitments of runs; empty if none commits, `None` if the strategy is not a plan.
    pub commits: Option<Vec<CommitReport>>,
    /// MP of the starting state.
    pub most_preferred: Vec<String>,
    /// The objectives that runs gained over the starting state, in the order of declaration.
    pub gained: Vec<GainReport>,
    /// The first run that weakened, or else the first run.
    pub trace: TraceReport,
    /// True if no improvement is possible from this state.
    pub is_hopeless: bool,
}

/// An objective that runs achieved.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct AchievedReport {
    /// Its name.
    pub objective: String,
    /// The number of steps until then.
    #[serde(flatten)]
    pub wait: Wait,
}

/// A player of a game, with the steps that it chose.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct MovesReport {
    /// Its name.
    pub name: String,
    /// It is one of us.
    pub ours: bool,
    /// The number of steps of all paths that it chose.
    pub steps: u64,
}

/// A commitment of runs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct CommitReport {
    /// The objective that the paths then pursued.
    pub objective: String,
    /// The other most preferred outcomes that they lost afterwards; empty if they lost none.
    pub gives_up: Vec<String>,
    /// The number of paths with this commitment.
    pub runs: u64,
}

/// An objective that runs gained over the starting state.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct GainReport {
    /// Its name.
    pub objective: String,
    /// The number of paths that gained it.
    pub runs: u64,
}

/// One run in full.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct TraceReport {
    /// Its number, from 1.
    #[serde(rename = "play")]
    pub run: u64,
    /// The objectives that are achieved in the starting state; absent if there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub achieved: Vec<String>,
    /// Its steps; empty if the path ends where it starts.
    pub turns: Vec<TurnReport>,
}

/// A step of a run.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct TurnReport {
    /// `opponent`: the opponent chose the action; absent otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub owner: Option<&'static str>,
    /// The player who chose it; absent if the model is not a game, and in deadlocks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub player: Option<String>,
    /// The action taken.
    pub action: String,
    /// The state entered.
    pub state: Valuation,
    /// The probability of the successor under the action.
    pub probability: f64,
    /// The most preferred outcomes of the state entered.
    pub most_preferred: Vec<String>,
    /// Its rank.
    pub rank: Rank,
    /// The effect of the step, compared with the reference.
    #[schemars(with = "Change")]
    pub change: &'static str,
    /// The step counts as an improvement of the path.
    pub improves: bool,
    /// The outcomes that are preferred to one of the reference.
    pub gained: Vec<String>,
    /// The outcomes of the state before that are preferred to one of the state entered.
    pub lost: Vec<String>,
    /// True if the state entered is unsafe.
    #[serde(skip)]
    pub is_unsafe: bool,
    /// The step weakens the state before, and the path has not committed.
    pub weakens_step: bool,
    /// The step weakens the starting state, and the path has not committed.
    pub weakens_start: bool,
    /// The objective to which the path commits before this step; absent without a new commitment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub commits: Option<String>,
    /// The objectives that the step gives up, for the first time since the commitment; absent if
    /// there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gives_up: Vec<String>,
    /// The objectives that are achieved for the first time in the state entered; absent if there are
    /// none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub achieved: Vec<String>,
    /// The values that change, for the text output.
    #[serde(skip)]
    pub changed: String,
}

impl RunsReport {
    /// Creates the report of a tally of runs under a strategy of this kind.
    pub fn new(program: &Program, preferences: &Preferences, kind: StrategyKind, tally: Tally) -> Self {
        let state = Valuation::new(program, &tally.start);
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
        let players = program.players.iter().flat_map(|players| &players.list).enumerate();
        let moves = |(at, player): (usize, &Player)| MovesReport {
            name: player.name.clone(),
            ours: player.ours,
            steps: tally.steps_of.get(&at).copied().unwrap_or_default(),
        };
        let players = players.map(moves).collect();
        let gain = |(&o, &runs): (&usize, &u64)| GainReport { objective: name(o), runs };
        RunsReport {
            state,
            value: None,
            achieved,
            players,
            commits,
            most_preferred: preferences.owned_names(&tally.first),
            gained: tally.gained.iter().map(gain).collect(),
            trace,
            is_hopeless: false,
            tally,
        }
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

/// The runs from one state in JSON.
#[derive(Serialize, JsonSchema)]
struct Runs {
    /// The starting state.
    state: Valuation,
    /// `true`: no strategy keeps the requirements from it, and its paths have no step; absent for
    /// other states.
    #[serde(rename = "unsafe", skip_serializing_if = "std::ops::Not::not")]
    is_unsafe: bool,
    /// Its rank.
    rank: Rank,
    /// The distribution of the number of improvements.
    improvements: Vec<Often>,
    /// The steps from the start to the first, second, … improvement; empty if no path improved.
    steps_to: Vec<Wait>,
    /// The objectives that paths achieved, in the order of declaration; absent for `sasi` and `spi`.
    #[serde(skip_serializing_if = "Option::is_none")]
    achieved: Option<Vec<AchievedReport>>,
    /// The paths that ended because they had achieved the objective that they pursued; absent for
    /// `sasi` and `spi`.
    #[serde(skip_serializing_if = "Option::is_none")]
    achieved_runs: Option<u64>,
    /// The other paths that kept the objective that they pursued: no step achieves it, and the path
    /// can go on to satisfy it; absent for `sasi` and `spi`.
    #[serde(skip_serializing_if = "Option::is_none")]
    kept_runs: Option<u64>,
    /// The players, with the steps that they chose; absent if the model is not a game.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    players: Vec<MovesReport>,
    /// The commitments of paths: kept actions alone achieved no most preferred outcome; empty if
    /// no path commits; absent except for `plan`.
    #[serde(skip_serializing_if = "Option::is_none")]
    commits: Option<Vec<CommitReport>>,
    /// The paths that ended where the strategy has nothing left to improve or to achieve, or stays
    /// forever.
    settled: u64,
    /// The paths that were given up after `steps` steps.
    given_up: u64,
    /// The paths among them with fewer improvements than the rank.
    undecided: u64,
    /// The paths with fewer improvements than the rank; `null` if the rank is unbounded.
    fewer_than_rank: Option<u64>,
    /// The paths with a step that weakens the state before it; steps after a commitment are not
    /// counted, here and below.
    weakened_step: u64,
    /// The paths that weaken the reference: under `prefix` the start or the last improvement,
    /// otherwise the state before.
    weakened_reference: u64,
    /// The paths that weaken the starting state.
    weakened_start: u64,
    /// The paths with a state that improves on the starting state.
    better_than_start: u64,
    /// The objectives that paths gained over the starting state, in the order of declaration.
    gained: Vec<GainReport>,
    /// The paths that entered a state where no strategy keeps the requirements; always 0.
    entered_unsafe: u64,
    /// The value that the strategy attains, computed and measured; `null` with `first`.
    value: Option<Comparison>,
    /// One path in full: the first that weakened, otherwise the first.
    trace: TraceReport,
}

/// A number of improvements.
#[derive(Serialize, JsonSchema)]
struct Often {
    /// The number.
    times: usize,
    /// The paths with this number.
    plays: u64,
}

impl From<RunsReport> for Runs {
    fn from(of: RunsReport) -> Self {
        let (tally, fewer_than_rank) = (&of.tally, of.tally.fewer_than_rank());
        let (achieved, counted) = of.achieved.zip(tally.achieved.as_ref()).unzip();
        Runs {
            state: of.state,
            is_unsafe: tally.is_unsafe,
            rank: tally.rank,
            improvements: tally.improvements.iter().map(|(&times, &plays)| Often { times, plays }).collect(),
            steps_to: tally.waits.clone(),
            achieved,
            achieved_runs: counted.map(|counted| counted.runs),
            kept_runs: counted.map(|counted| counted.kept),
            players: of.players,
            commits: of.commits,
            settled: tally.settled,
            given_up: tally.given_up,
            undecided: tally.undecided,
            fewer_than_rank,
            weakened_step: tally.weakened_step,
            weakened_reference: tally.weakened_reference,
            weakened_start: tally.weakened_start,
            better_than_start: tally.better_than_start,
            gained: of.gained,
            entered_unsafe: tally.entered_unsafe,
            value: of.value,
            trace: of.trace,
        }
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
        owner: turn.owner.filter(|owner| !owner.ours).map(|_| "opponent"),
        player: turn.owner.map(|owner| words.name_of(owner.player).to_owned()),
        action: turn.action.clone(),
        state: Valuation::new(words.program, &turn.state),
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
    pub fn of_setup(header: Header, kind: StrategyKind, choosing: Choosing, setup: Setup) -> Self {
        let Setup { scheduler: strategy, runs, steps, seed } = setup;
        Envelope::with(
            header,
            SimulateFindings {
                kind,
                choosing,
                strategy,
                runs,
                steps,
                seed,
                opponent: None,
                starts: Vec::new(),
            },
        )
    }
}
