//! A state under a strategy, in the JSON and the text of `strategy`.

use schemars::JsonSchema;
use serde::Serialize;

use super::choose::{Attains, Choosing};
use super::cycle::Cycle;
use super::reason::Words;
use meliora_model::preference::{Change, ObjectiveSet};
use meliora_model::valuation::Valuation;
use meliora_planning::explain::{Action, Successor, Verdict};
use meliora_planning::{Explanation, InducedModel, Rank, StrategyKind};
use meliora_quantities::Choose;

/// The explanation of a state, with the words for its results.
pub struct StateReport<'a> {
    /// The texts of the model and the preferences.
    pub words: Words<'a>,
    /// The state and its actions.
    pub at: Explanation,
    /// The number of guaranteed (SASI) and of possible (SPI) improvements.
    pub ranks: [Rank; 2],
    /// The choice among permitted actions.
    pub choosing: Choosing,
    /// The value that the strategy attains, if the choice depends on values.
    pub attains: Option<Attains>,
    /// The paths under the progress strategy, if they were computed.
    pub unfolded: Option<InducedModel>,
    /// The cycle behind an unbounded rank of the kind of the strategy, if it was computed.
    pub cycle: Option<Cycle>,
    /// The place of the state in a table of the whole strategy.
    pub place: Option<Place>,
}

/// The place of a state with memory in a table of the whole strategy.
pub struct Place {
    /// The number of the node.
    pub node: usize,
    /// True if paths that start in the state start in this node.
    pub is_start: bool,
    /// The nodes after each action, by its successors; `None` where the strategy does not take it.
    pub next: Vec<Vec<Option<usize>>>,
}

impl StateReport<'_> {
    /// Returns the action that the strategy takes; `None` at level 0.
    pub(crate) fn picked_action(&self) -> Option<&Action> {
        self.at.actions.get(self.at.pick?)
    }

    /// Returns the first action that makes progress; `None` at level 0.
    pub(crate) fn progress_action(&self) -> Option<&Action> {
        self.at.actions.iter().find(|action| action.progress)
    }

    /// Returns the reason why an action is permitted or not.
    pub(crate) fn reason(&self, action: &Action) -> String {
        match action.verdict {
            Verdict::NothingAhead if self.is_only_kept() => {
                "safe, but no improvement is certain if a dropped branch happens".to_owned()
            }
            _ => self.words.reason(&self.at, action),
        }
    }

    /// Returns whether improvements are guaranteed only where no dropped branch happens, so that a choice by
    /// values has none that is certain.
    pub(crate) fn is_only_kept(&self) -> bool {
        let [sasi, _] = self.ranks;
        let is_sasi = self.words.kind == StrategyKind::Sasi && self.choosing.choose != Choose::First;
        is_sasi && sasi != Rank::Finite(0) && self.at.memory.level == Rank::Finite(0)
    }

    /// Returns whether the strategy commits to an objective that is still to be achieved.
    pub(crate) fn commits(&self) -> bool {
        self.at.commits() && !self.at.is_achieved()
    }

    /// Returns the objectives that the next step of the strategy may give up.
    pub(crate) fn gives_up(&self) -> ObjectiveSet {
        self.picked_action().map(|action| self.at.given_up(action)).unwrap_or_default()
    }

    /// Returns the JSON object of the state.
    pub(crate) fn json(&self) -> StateJson {
        let (words, at, [sasi_rank, spi_rank]) = (self.words, &self.at, self.ranks);
        let name = |action: Option<&Action>| action.map(|action| action.name.clone());
        StateJson {
            state: Valuation::new(words.program, &at.state),
            owner: at.is_theirs().then_some("opponent"),
            player: words.player(at).map(str::to_owned),
            most_preferred: words.names(&at.most_preferred),
            sasi_rank,
            spi_rank,
            taken: (!at.is_theirs()).then(|| TakenJson {
                progress_action: name(self.progress_action()),
                chosen_action: name(self.picked_action()),
            }),
            attains: self.attains.clone(),
            actions: (0..at.actions.len()).map(|position| self.action(position)).collect(),
            longest_play: self.unfolded.as_ref().and_then(InducedModel::longest_path),
            cycle: self.cycle.clone(),
            aims: words.kind.achieves().then(|| AimsJson {
                pursues: words.pursued(at),
                left: words.names(&at.left),
                achieved: words.names(&at.achieved),
                commits: self.commits(),
                gives_up: words.names(&self.gives_up()),
            }),
            is_unsafe: at.is_unsafe,
            place: self.place.as_ref().map(|place| PlaceJson {
                node: place.node,
                start: place.is_start,
                level: at.memory.level,
                reference: words.names(&at.reference),
            }),
        }
    }

    fn action(&self, position: usize) -> ActionJson {
        let action = &self.at.actions[position];
        let &Action { kept, permitted, progress, .. } = action;
        let node = |branch: usize| self.place.as_ref().and_then(|place| place.next[position][branch]);
        ActionJson {
            name: action.name.clone(),
            judged: (!self.at.is_theirs()).then_some(JudgedJson { kept, permitted, progress }),
            verdict: action.verdict.name(),
            reason: self.reason(action),
            successors: action
                .successors
                .iter()
                .zip(0..)
                .map(|(s, at)| self.successor(s, node(at)))
                .collect(),
        }
    }

    fn successor(&self, successor: &Successor, node: Option<usize>) -> SuccessorJson {
        let words = self.words;
        SuccessorJson {
            state: Valuation::new(words.program, &successor.state),
            probability: successor.probability,
            most_preferred: words.names(&successor.most_preferred),
            change: successor.change.name(),
            gained: words.names(&successor.gained),
            lost: words.names(&successor.lost),
            rank: successor.rank,
            dropped: successor.dropped,
            goal: successor.goal,
            is_unsafe: successor.is_unsafe,
            node,
        }
    }
}

/// A state in JSON.
#[derive(Serialize, JsonSchema)]
pub(crate) struct StateJson {
    /// The values of the state.
    state: Valuation,
    /// `opponent`: in this state of a game the opponent chooses; absent for other states.
    #[serde(skip_serializing_if = "Option::is_none")]
    owner: Option<&'static str>,
    /// The player who chooses in this state of a game; absent for other models, and in deadlocks.
    #[serde(skip_serializing_if = "Option::is_none")]
    player: Option<String>,
    /// The most preferred outcomes.
    most_preferred: Vec<String>,
    /// The rank by SASI.
    sasi_rank: Rank,
    /// The rank by SPI.
    spi_rank: Rank,
    #[serde(flatten)]
    taken: Option<TakenJson>,
    /// The value of the strategy from this state; `null` with `first`, and in an unsafe state.
    attains: Option<Attains>,
    /// All enabled actions.
    actions: Vec<ActionJson>,
    /// The most steps of a path under the progress strategy; `null` if unbounded, at rank 0, with
    /// `--rank`, or with `--all`.
    longest_play: Option<usize>,
    /// Steps that improve again and again: the reason for an unbounded rank of the kind of the
    /// strategy; absent for other ranks, with `--rank` and `--all`, and if there are more than 1000.
    #[serde(skip_serializing_if = "Option::is_none")]
    cycle: Option<Cycle>,
    #[serde(flatten)]
    aims: Option<AimsJson>,
    /// `true`: no strategy keeps the requirements from it; absent for other states.
    #[serde(rename = "unsafe", skip_serializing_if = "std::ops::Not::not")]
    is_unsafe: bool,
    #[serde(flatten)]
    place: Option<PlaceJson>,
}

/// The place of a state in the whole strategy, in JSON; absent without `--all`.
#[derive(Serialize, JsonSchema)]
struct PlaceJson {
    /// The number of this state with its memory, from 0; absent without `--all`.
    node: usize,
    /// The strategy begins here when it begins in this state; absent without `--all`.
    start: bool,
    /// The number of improvements that are still aimed at, a part of the memory; absent without `--all`.
    level: Rank,
    /// The outcomes that steps are compared with, a part of the memory; absent without `--all`.
    reference: Vec<String>,
}

/// The actions that a strategy takes in a state, in JSON; absent if the opponent chooses there.
#[derive(Serialize, JsonSchema)]
struct TakenJson {
    /// The first of `actions` with `progress`: the action of the progress strategy; `null` if no
    /// action makes progress; absent if the opponent chooses.
    #[schemars(extend("nullable" = true))]
    progress_action: Option<String>,
    /// The action that the strategy takes: with `first`, and while an objective is pursued, the
    /// `progress_action`; with `likely` and `cheap`, one with the best value; `null` where the
    /// strategy ends: nothing is left to improve or to achieve, or the pursued objective is
    /// achieved; absent if the opponent chooses.
    #[schemars(extend("nullable" = true))]
    chosen_action: Option<String>,
}

/// The objective that a strategy pursues from a state, in JSON; absent for `sasi` and `spi`.
#[derive(Serialize, JsonSchema)]
struct AimsJson {
    /// The objective that the strategy pursues, or several as `C and D`; `null` while it improves; absent
    /// for `sasi` and `spi`.
    #[schemars(extend("nullable" = true))]
    pursues: Option<String>,
    /// The pursued objectives that are not achieved yet: several if they are pursued together; absent for
    /// `sasi` and `spi`.
    left: Vec<String>,
    /// The objectives that are achieved in the state; absent for `sasi` and `spi`.
    achieved: Vec<String>,
    /// The plan commits to the objective that it pursues: kept actions alone do not achieve it;
    /// absent for `sasi` and `spi`.
    commits: bool,
    /// The most preferred outcomes that its next step may then lose; absent for `sasi` and `spi`.
    gives_up: Vec<String>,
}

/// An action in JSON.
#[derive(Serialize, JsonSchema)]
struct ActionJson {
    /// Its name.
    name: String,
    #[serde(flatten)]
    judged: Option<JudgedJson>,
    /// The first of the verdicts that applies.
    verdict: &'static str,
    /// The verdict in words.
    reason: String,
    /// Its successors.
    successors: Vec<SuccessorJson>,
}

/// The judgement of a strategy on an action, in JSON; absent for actions of the opponent.
#[derive(Serialize, JsonSchema)]
struct JudgedJson {
    /// The safety mode keeps it; absent for actions of the opponent.
    kept: bool,
    /// The permissive strategy permits it; absent for actions of the opponent.
    permitted: bool,
    /// It is permitted and comes closer to an improvement with positive probability; absent for actions of
    /// the opponent.
    progress: bool,
}

/// A successor in JSON.
#[derive(Serialize, JsonSchema)]
struct SuccessorJson {
    /// The values of the state.
    state: Valuation,
    /// The probability.
    probability: f64,
    /// The most preferred outcomes.
    most_preferred: Vec<String>,
    /// The effect of the step, compared with the reference.
    #[schemars(with = "Change")]
    change: &'static str,
    /// Its outcomes that are preferred to one of the reference.
    gained: Vec<String>,
    /// The outcomes of the reference that are preferred to one of its own.
    lost: Vec<String>,
    /// The rank of the `kind` asked for.
    rank: Rank,
    /// `--safety transition` removes this transition.
    dropped: bool,
    /// The transition is an improvement that the strategy counts on.
    goal: bool,
    /// `true`: no strategy keeps the requirements from it; absent for other states.
    #[serde(rename = "unsafe", skip_serializing_if = "std::ops::Not::not")]
    is_unsafe: bool,
    /// The node after this successor; absent without `--all`, and for actions that the strategy does not
    /// take.
    #[serde(skip_serializing_if = "Option::is_none")]
    node: Option<usize>,
}
