//! Explanations why an action is permitted or not permitted in a state.

use super::achieve::Manner;
use super::finite_memory::{FiniteMemoryStrategy, Memory, StrategyKind};
use super::threat::Threat;
use super::verdict::Case;
pub use super::verdict::Verdict;
use crate::analysis::levels::Rank;
use meliora_base::error::Result;
use meliora_engine::{Engine, position};
use meliora_model::players::Owner;
use meliora_model::preference::{Change, ObjectiveSet, Preferences};
use meliora_model::step::Step;
use meliora_model::{State, fault};

/// The explanation of a state under a strategy.
#[derive(Debug, Clone, PartialEq)]
pub struct Explanation {
    /// The state.
    pub state: State,
    /// The strategy's memory in the state.
    pub memory: Memory,
    /// The player who chooses in the state; `None` if the model is not a game, and in deadlocks.
    pub owner: Option<Owner>,
    /// True if no strategy keeps the requirements from the state.
    pub is_unsafe: bool,
    /// MP(s), the most preferred objectives of the state; empty if it is unsafe.
    pub most_preferred: ObjectiveSet,
    /// The objectives that steps are compared with: MP(s), or MP of the reference class under
    /// `prefix`.
    pub reference: ObjectiveSet,
    /// The objectives that are achieved in the state; empty if the strategy achieves none.
    pub achieved: ObjectiveSet,
    /// The objectives that the strategy pursues, together if there are several; empty while it improves.
    pub aims: ObjectiveSet,
    /// The objectives of `aims` that the path has not achieved.
    pub left: ObjectiveSet,
    /// All enabled actions in the order of the program.
    pub actions: Vec<Action>,
    /// The position of the action that a deterministic strategy takes: the first one that makes
    /// progress, or that of the decision rule; `None` where the strategy ends, and in states of the
    /// opponent.
    pub pick: Option<usize>,
    /// The position of the opponent's action that is worst for the values of the decision rule; `None` in
    /// our states, and if the rule says nothing about the state.
    pub worst: Option<usize>,
}

impl Explanation {
    /// Returns whether the opponent of a game chooses in the state: no action is permitted or forbidden.
    pub fn is_theirs(&self) -> bool {
        self.owner.is_some_and(|owner| !owner.ours)
    }

    /// Returns whether the strategy has nothing left to improve or to achieve; a run ends here.
    pub fn is_over(&self) -> bool {
        match self.memory.pursuit {
            Some(_) => self.is_achieved(),
            None => self.memory.level == Rank::Finite(0),
        }
    }

    /// Returns the objective that the strategy pursues; `None` if there are several or none.
    pub fn pursued(&self) -> Option<usize> {
        self.aims.iter().next().filter(|_| self.aims.len() == 1)
    }

    /// Returns whether the strategy has committed to the objective that it pursues: it takes all
    /// choices with which the objective stays sure, and gives up the objectives that they lose.
    pub fn commits(&self) -> bool {
        self.memory.pursuit.is_some_and(|pursuit| pursuit.manner == Manner::Committed)
    }

    /// Returns whether the strategy is a plan that achieves its objective by kept choices alone.
    pub fn keeps(&self) -> bool {
        self.memory.pursuit.is_some_and(|pursuit| pursuit.manner == Manner::Kept)
    }

    /// Permits the action that a rule takes to achieve an objective that is not almost sure, and no
    /// other one.
    fn permit_pick(&mut self) {
        for (position, action) in self.actions.iter_mut().enumerate() {
            action.permitted = self.pick == Some(position);
            action.progress = action.permitted;
            let is_unsafe = action.successors.iter().position(|step| step.is_unsafe);
            action.verdict = match (self.pick, is_unsafe) {
                (Some(_), _) if action.permitted => Verdict::Likeliest,
                (_, Some(index)) => Verdict::Violates(Some(index)),
                (Some(_), None) => Verdict::PassedOver,
                (None, None) => Verdict::Impossible,
            };
        }
    }

    /// Returns the objectives that an action may give up.
    pub fn given_up(&self, action: &Action) -> ObjectiveSet {
        let mut all = ObjectiveSet::new();
        action.successors.iter().for_each(|step| all.extend_with(&self.gives_up(step)));
        all
    }

    /// Returns the objectives that a step gives up: those lost after a commitment.
    pub fn gives_up(&self, step: &Successor) -> ObjectiveSet {
        if self.commits() { step.lost.clone() } else { ObjectiveSet::new() }
    }

    /// Returns whether all pursued objectives are achieved; a run ends here.
    pub fn is_achieved(&self) -> bool {
        !self.aims.is_empty() && self.left.is_empty()
    }
}

/// An action that is enabled.
#[derive(Debug, Clone, PartialEq)]
pub struct Action {
    /// Its name.
    pub name: String,
    /// True if the improvement MDP keeps it.
    pub kept: bool,
    /// True if the permissive strategy permits it.
    pub permitted: bool,
    /// True if it moves one layer closer with positive probability.
    pub progress: bool,
    /// The reason.
    pub verdict: Verdict,
    /// For an action of a game after which the opponent can weaken ([`Verdict::Exposes`], [`Verdict::Unsafe`]), how it
    /// can; `None` for others, and if the way is too long to be searched for.
    pub threat: Option<Threat>,
    /// For an action of the opponent, the distance of the nearest successor from the level's goal or the
    /// pursued objective: 0 for a goal edge, i + 1 for a successor in layer i. `None` if the goal cannot
    /// follow, and for our actions.
    pub distance: Option<usize>,
    /// The possible successors.
    pub successors: Vec<Successor>,
}

/// A possible successor of an action.
#[derive(Debug, Clone, PartialEq)]
pub struct Successor {
    /// The state.
    pub state: State,
    /// The probability.
    pub probability: f64,
    /// True if no strategy keeps the requirements from the successor.
    pub is_unsafe: bool,
    /// MP(s'), the most preferred objectives of the successor; empty if it is unsafe.
    pub most_preferred: ObjectiveSet,
    /// rank(s').
    pub rank: Rank,
    /// The effect of the step, compared with the reference.
    pub change: Change,
    /// The set { j ∈ MP(s') : j is strictly preferred to a member of the reference }.
    pub gained: ObjectiveSet,
    /// The set { i in the reference : i is strictly preferred to a member of MP(s') }.
    pub lost: ObjectiveSet,
    /// True if the improvement MDP drops this branch; the real system may still take it.
    pub dropped: bool,
    /// True if the step is a goal edge of the level, or achieves a pursued objective. A goal edge
    /// belongs to a kept action; an action that violates the requirements has none.
    pub goal: bool,
    /// The pursued objectives that the step achieves.
    pub achieves: ObjectiveSet,
    /// True if the successor is a winning state of the level or stage, so that the strategy can
    /// continue there.
    pub stays: bool,
    /// The memory after the step.
    pub next: Memory,
    /// True if the step is an improvement, of this level or another.
    pub improves: bool,
}

/// The state that is explained.
struct Here<'a> {
    state: &'a [i64],
    memory: Memory,
    reference: &'a ObjectiveSet,
    is_unsafe: bool,
    /// True if the opponent chooses in it.
    theirs: bool,
}

impl<E: Engine> FiniteMemoryStrategy<E> {
    /// Explains a state in which the strategy has the given memory. Cost: that of
    /// [`FiniteMemoryStrategy::strategy`], then no image.
    ///
    /// # Errors
    /// A limit of the engine is reached, or a command has no meaning in the state.
    pub fn explain(&mut self, state: &[i64], memory: Memory) -> Result<Explanation> {
        if let Some(limit) = self.engine.settings().sink.stop() {
            return Err(limit.into());
        }
        let steps = self.program.steps(state).map_err(|f| fault::error(&self.program, &f, state))?;
        let owner = steps.first().and_then(|step| self.owner_of(&step.choice));
        let (reference, is_unsafe) = (self.reference(memory, state)?, self.is_unsafe(state)?);
        let theirs = owner.is_some_and(|owner| !owner.ours);
        let here = Here { state, memory, reference: &reference, is_unsafe, theirs };
        let actions = steps.into_iter().map(|step| self.action(&here, step)).collect::<Result<_>>()?;
        let mut at = Explanation {
            owner,
            is_unsafe,
            most_preferred: self.most_preferred(state)?,
            achieved: self.achieved(state)?,
            aims: self.pursued(memory),
            left: self.left(memory, state)?,
            pick: None,
            worst: None,
            state: state.to_vec(),
            memory,
            reference,
            actions,
        };
        at.pick = match &self.rule {
            _ if at.is_achieved() => None,
            Some(rule) if memory.pursuit.is_none() => rule.pick(memory, state),
            _ => at.actions.iter().position(|a| a.progress),
        };
        if theirs {
            at.worst = at.pick.take().filter(|_| self.rule.is_some() && memory.pursuit.is_none());
        } else if self.is_likely(memory) && !is_unsafe {
            at.permit_pick();
        }
        Ok(at)
    }

    /// Explains a choice of a state.
    fn action(&mut self, here: &Here<'_>, step: Step) -> Result<Action> {
        let Step { choice, name, successors } = step;
        let &Here { state, memory, is_unsafe, theirs, .. } = here;
        let (engine, kind) = (self.engine.clone(), self.levels.kind);
        let has = |set: &E::Choices| engine.contains_choice(set, state, &choice);
        let kept = self.arena(memory).map_or(Ok(false), |arena| has(&arena.choices))?;
        let counts = if memory.pursuit.is_some() { has(&engine.all_choices())? } else { kept };
        let one = |(to, p)| {
            let found = self.successor(here, (to, p))?;
            Ok(Successor { goal: found.goal && counts, ..found })
        };
        let successors: Vec<Successor> = successors.into_iter().map(one).collect::<Result<_>>()?;
        let level = match self.strategy(memory)? {
            Some(strategy) => Some((has(&strategy.permissive)?, has(&strategy.progress)?)),
            None => None,
        };
        let outside = match self.safe_states(here)? {
            Some(safe) if !kept => position(&successors, |s| Ok(!engine.contains(safe, &s.state)?))?,
            _ => None,
        };
        let exposed = match kept || self.program.players.is_none() {
            true => None,
            false => self.exposed(successors.iter().map(|s| &s.state))?,
        };
        let case = Case {
            pursuit: memory.pursuit.map(|pursuit| pursuit.manner),
            achieves: self.kind == StrategyKind::Achieve,
            is_unsafe,
            kind,
            kept,
            level,
            outside,
            exposed,
        };
        let (permitted, progress) = level.unwrap_or((false, false));
        let verdict = if theirs { case.answer(&successors) } else { case.verdict(&successors) };
        let threat = match verdict {
            Verdict::Exposes(index) => self.threat(memory, None, &successors[index].state)?,
            Verdict::Unsafe(Some(index)) if self.program.players.is_some() => {
                self.threat(memory, self.safe_states(here)?, &successors[index].state)?
            }
            _ => None,
        };
        let distance = if theirs { self.distance(memory, &successors)? } else { None };
        Ok(Action { name, kept, permitted, progress, verdict, threat, distance, successors })
    }

    /// Returns the states that paths may visit: those of the arena or, at a state of the opponent of which the
    /// class has none, those from which nothing needs to weaken the class.
    fn safe_states(&self, here: &Here<'_>) -> Result<Option<&E::States>> {
        if let Some(arena) = self.arena(here.memory) {
            return Ok(Some(&arena.states));
        }
        let Some(class) = self.class_of(here.state)?.filter(|_| here.theirs) else {
            return Ok(None);
        };
        let known = &self.improvement.unsafe_classes;
        Ok(known.iter().find(|(unsafe_class, _)| *unsafe_class == class).map(|(_, safe)| safe))
    }

    /// Returns [`Action::distance`] of an action of the opponent. Cost: no image once the strategy is
    /// known.
    fn distance(&mut self, memory: Memory, successors: &[Successor]) -> Result<Option<usize>> {
        if successors.iter().any(|s| s.goal) {
            return Ok(Some(0));
        }
        let engine = self.engine.clone();
        let Some(strategy) = self.strategy(memory)? else { return Ok(None) };
        let reached =
            |layer: &E::States| Ok(position(successors, |s| engine.contains(layer, &s.state))?.is_some());
        Ok(position(&strategy.layers, reached)?.map(|layer| layer + 1))
    }

    fn successor(&self, here: &Here<'_>, (to, p): (State, f64)) -> Result<Successor> {
        let &Here { state: from, is_unsafe: from_unsafe, memory, reference, .. } = here;
        let class = self.class_of(&to)?.map(|class| &self.classes.list[class]);
        let is_unsafe = class.is_none();
        let most_preferred = class.map_or_else(ObjectiveSet::new, |class| class.most_preferred.clone());
        // Unsafe states belong to no class, so they are compared with nothing.
        let compared = !is_unsafe && !from_unsafe;
        let if_compared = |set: ObjectiveSet| if compared { set } else { ObjectiveSet::new() };
        let change = self.change(memory, from, &to)?;
        let (next, improves) = self.after_change(memory, from, &to, change)?;
        let mut achieves = ObjectiveSet::new();
        let (goal, stays) = match (self.game(memory), memory.pursuit, &self.achieving) {
            (_, Some(pursuit), Some(achieving)) => {
                achieves = achieving.achieves(pursuit, from, &to)?;
                (!achieves.is_empty(), achieving.is_sure(pursuit, memory.arena, &to)?)
            }
            (Some(game), ..) => (
                // Goal edges improve.
                change == Change::Improving && super::strategy::is_goal(&*self.engine, game, from, &to)?,
                self.engine.contains(&game.states, &to)?,
            ),
            (None, ..) => (false, false),
        };
        Ok(Successor {
            probability: p,
            rank: self.rank(&to)?,
            gained: if_compared(gained(&self.preferences, reference, &most_preferred)),
            lost: if_compared(lost(&self.preferences, reference, &most_preferred)),
            is_unsafe,
            dropped: self.improvement.safety.drops_successors() && change == Change::Weakening,
            most_preferred,
            state: to,
            change,
            goal,
            achieves,
            stays,
            next,
            improves,
        })
    }
}

/// Returns { j ∈ `to` : j is strictly preferred to a member of `from` }. If `from` is empty and any
/// gain improves, returns all of `to`.
pub(crate) fn gained(preferences: &Preferences, from: &ObjectiveSet, to: &ObjectiveSet) -> ObjectiveSet {
    if from.is_empty() && preferences.improves(from, to) {
        return to.clone();
    }
    let order = &preferences.order;
    to.iter().filter(|&j| from.iter().any(|i| order.strictly(j, i))).collect()
}

/// Returns { i ∈ `from` : i is strictly preferred to a member of `to` }. If `to` is empty and
/// losing everything weakens, returns all of `from`.
pub(crate) fn lost(preferences: &Preferences, from: &ObjectiveSet, to: &ObjectiveSet) -> ObjectiveSet {
    if to.is_empty() && preferences.weakens(from, to) {
        return from.clone();
    }
    let order = &preferences.order;
    from.iter().filter(|&i| to.iter().any(|j| order.strictly(i, j))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_model::preference::{Empty, Preorder, Relation, Statement};

    #[test]
    fn only_what_is_better_is_gained_and_what_is_worse_lost() {
        let better = Statement { left: 1, right: 0, relation: Relation::Strict };
        let of = |empty| {
            let order = Preorder::new(3, &[better]).unwrap();
            Preferences {
                objectives: Vec::new(),
                order,
                empty,
                history: Default::default(),
                requirements: Vec::new(),
            }
        };
        let (none, low, high) =
            (ObjectiveSet::new(), [0].into_iter().collect(), [1, 2].into_iter().collect());
        let [bottom, incomparable] = [Empty::Bottom, Empty::Incomparable].map(of);
        assert_eq!(gained(&bottom, &low, &high), [1].into_iter().collect());
        assert_eq!(lost(&bottom, &high, &low), [1].into_iter().collect());
        assert_eq!(
            (gained(&bottom, &none, &high), lost(&bottom, &high, &none)),
            (high.clone(), high.clone())
        );
        assert_eq!(gained(&incomparable, &none, &high), none);
        assert_eq!(lost(&incomparable, &high, &none), none);
    }
}
