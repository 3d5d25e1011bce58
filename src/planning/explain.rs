//! Explanations why an action is permitted or not permitted in a state.

use strum::IntoStaticStr;

use super::achieve::Manner;
use super::finite_memory::{FiniteMemoryStrategy, Memory, StrategyKind};
use super::improvement::Safety;
use super::levels::{Kind, Rank};
use meliora_engine::{Engine, position};
use meliora_model::error::Result;
use meliora_model::preference::{Change, ObjectiveSet, Preferences};
use meliora_model::step::Step;
use meliora_model::{State, fault};

/// The reason why an action is permitted or not; successors are given by their positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "kebab-case")]
pub enum Verdict {
    /// Permitted: every kept successor is reached by a goal edge of the level.
    Improves,
    /// Permitted: some successor is reached by a goal edge of the level.
    MayImprove,
    /// Permitted: some successor is one layer closer to a goal edge.
    Approaches,
    /// Permitted, but makes no progress.
    Stays,
    /// Not kept: this successor weakens.
    Weakens(usize),
    /// Not kept under `prefix`: after this successor, weakening cannot be avoided forever. `None`
    /// if this is the case in the state itself.
    Unsafe(Option<usize>),
    /// Not possible under the requirements: this successor is unsafe. `None` if the state itself is
    /// unsafe.
    Violates(Option<usize>),
    /// Kept, but this successor leaves the states from which the improvements are certain.
    Strays(usize),
    /// Kept, but no goal edge of the level can follow.
    Hopeless,
    /// Kept, but the state has rank 0: no improvement is possible.
    NothingAhead,
    /// Permitted: every successor achieves the pursued objective.
    Achieves,
    /// Permitted: some successor achieves the pursued objective.
    MayAchieve,
    /// Permitted: some successor is closer to the pursued objective.
    Nears,
    /// Permitted: the pursued objective remains certain, but comes no closer.
    Keeps,
    /// Not permitted: after this successor the pursued objective is no longer certain or, before a
    /// commitment, the kept choices no longer suffice for it.
    Forfeits(usize),
    /// Not permitted: no strategy achieves the objective almost surely from here.
    Unachievable,
}

impl Verdict {
    /// Returns the name in reports.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// The explanation of a state under a strategy.
#[derive(Debug, Clone, PartialEq)]
pub struct Explanation {
    /// The state.
    pub state: State,
    /// The strategy's memory in the state.
    pub memory: Memory,
    /// True if no strategy keeps the requirements from the state.
    pub is_unsafe: bool,
    /// MP(s), the most preferred objectives of the state; empty if it is unsafe.
    pub most_preferred: ObjectiveSet,
    /// The objectives that steps are compared with: MP(s), or MP of the reference class under
    /// `prefix`.
    pub reference: ObjectiveSet,
    /// The objectives that are achieved in the state; empty if the strategy achieves none.
    pub achieved: ObjectiveSet,
    /// All enabled actions in the order of the program.
    pub actions: Vec<Action>,
    /// The position of the action that a deterministic strategy takes: the first one that makes
    /// progress, or that of the decision rule; `None` where the strategy ends.
    pub pick: Option<usize>,
}

impl Explanation {
    /// Returns the objective that the strategy pursues.
    pub fn pursued(&self) -> Option<usize> {
        self.memory.pursuit.map(|pursuit| pursuit.objective)
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

    /// Returns whether the pursued objective is achieved; a run ends here.
    pub fn is_achieved(&self) -> bool {
        self.pursued().is_some_and(|objective| self.achieved.contains(objective))
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
    /// True if the step is a goal edge of the level, or achieves the pursued objective. A goal edge
    /// belongs to a kept action; an action that violates the requirements has none.
    pub goal: bool,
    /// True if the successor is a winning state of the level or stage, so that the strategy can
    /// continue there.
    pub stays: bool,
    /// The memory after the step.
    pub next: Memory,
    /// True if the step is an improvement, of this level or another.
    pub improves: bool,
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
        let reference = self.reference(memory, state)?;
        let is_unsafe = self.is_unsafe(state)?;
        let mut actions = Vec::with_capacity(steps.len());
        for step in steps {
            actions.push(self.action(state, memory, &reference, step)?);
        }
        let mut at = Explanation {
            is_unsafe,
            most_preferred: self.most_preferred(state)?,
            achieved: self.achieved(state)?,
            pick: None,
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
        Ok(at)
    }

    fn action(
        &mut self,
        state: &[i64],
        memory: Memory,
        reference: &ObjectiveSet,
        step: Step,
    ) -> Result<Action> {
        let Step { choice, name, successors } = step;
        let (engine, kind) = (self.engine.clone(), self.levels.kind);
        let has = |set: &E::Choices| engine.contains_choice(set, state, &choice);
        let kept = self.arena(memory).map_or(Ok(false), |arena| has(&arena.choices))?;
        let counts = if memory.pursuit.is_some() { has(&engine.all_choices())? } else { kept };
        let one = |(to, p)| {
            let found = self.successor(state, memory, reference, to, p)?;
            Ok(Successor { goal: found.goal && counts, ..found })
        };
        let successors: Vec<Successor> = successors.into_iter().map(one).collect::<Result<_>>()?;
        let level = match self.strategy(memory)? {
            Some(strategy) => Some((has(&strategy.permissive)?, has(&strategy.progress)?)),
            None => None,
        };
        let (permitted, progress) = level.unwrap_or((false, false));
        let verdict = match level {
            Some(_) if memory.pursuit.is_some() => match permitted {
                true => pursuing(&successors, progress),
                false => self.forfeiting((state, memory), kept, &successors)?,
            },
            None if self.kind == StrategyKind::Achieve && !self.is_unsafe(state)? => Verdict::Unachievable,
            _ if !kept => self.refused(state, memory, &successors)?,
            None => Verdict::NothingAhead,
            Some((true, _)) => allowed(&successors, progress),
            Some((false, _)) => forbidden(kind, &successors),
        };
        Ok(Action { name, kept, permitted, progress, verdict, successors })
    }

    fn successor(
        &self,
        from: &[i64],
        memory: Memory,
        reference: &ObjectiveSet,
        to: State,
        p: f64,
    ) -> Result<Successor> {
        let class = self.classes.of(&*self.engine, &to)?.map(|class| &self.classes.list[class]);
        let is_unsafe = class.is_none();
        let most_preferred = class.map_or_else(ObjectiveSet::new, |class| class.most_preferred.clone());
        // Unsafe states belong to no class, so they are compared with nothing.
        let compared = !is_unsafe && !self.is_unsafe(from)?;
        let if_compared = |set: ObjectiveSet| if compared { set } else { ObjectiveSet::new() };
        let change = self.change(memory, from, &to)?;
        let (next, improves) = self.after(memory, from, &to)?;
        let (goal, stays) = match (self.game(memory), memory.pursuit, &self.achieving) {
            (_, Some(pursuit), Some(achieving)) => (
                achieving.achieved(&to)?.contains(pursuit.objective),
                achieving.is_sure(pursuit, memory.arena, &to)?,
            ),
            (Some(game), ..) => (
                super::strategy::is_goal(&*self.engine, game, from, &to)?,
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
            dropped: self.improvement.safety == Safety::Transition && change == Change::Weakening,
            most_preferred,
            state: to,
            change,
            goal,
            stays,
            next,
            improves,
        })
    }

    /// Returns the reason why a choice is not permitted while an objective is pursued. A plan that has
    /// not committed takes only kept choices, and of these none with a branch that weakens.
    fn forfeiting(
        &self,
        (state, memory): (&[i64], Memory),
        kept: bool,
        successors: &[Successor],
    ) -> Result<Verdict> {
        let weakens = successors.iter().any(|s| s.change == Change::Weakening);
        let keeps_all = memory.pursuit.is_some_and(|pursuit| pursuit.manner == Manner::Kept);
        if keeps_all && (!kept || weakens) {
            return self.refused(state, memory, successors);
        }
        let lost = successors.iter().position(|s| !s.stays);
        Ok(match (self.is_unsafe(state)?, successors.iter().position(|s| s.is_unsafe), lost) {
            (true, ..) => Verdict::Violates(None),
            (_, Some(index), _) => Verdict::Violates(Some(index)),
            (_, None, Some(index)) => Verdict::Forfeits(index),
            (_, None, None) => Verdict::Unachievable,
        })
    }

    /// Returns the reason why a choice is not kept.
    fn refused(&self, state: &[i64], memory: Memory, successors: &[Successor]) -> Result<Verdict> {
        if self.is_unsafe(state)? {
            return Ok(Verdict::Violates(None));
        }
        if let Some(index) = successors.iter().position(|s| s.is_unsafe) {
            return Ok(Verdict::Violates(Some(index)));
        }
        let weakening = successors.iter().position(|s| s.change == Change::Weakening);
        Ok(match (weakening, self.arena(memory)) {
            (Some(index), _) => Verdict::Weakens(index),
            (None, Some(arena)) => Verdict::Unsafe(position(successors, |s| {
                Ok(!self.engine.contains(&arena.states, &s.state)?)
            })?),
            (None, None) => Verdict::Unsafe(None),
        })
    }
}

/// Returns the reason why a choice is permitted while an objective is pursued.
fn pursuing(successors: &[Successor], progress: bool) -> Verdict {
    match (successors.iter().filter(|s| s.goal).count(), progress) {
        (0, true) => Verdict::Nears,
        (0, false) => Verdict::Keeps,
        (n, _) if n == successors.len() => Verdict::Achieves,
        _ => Verdict::MayAchieve,
    }
}

/// Returns the reason why a choice is permitted.
fn allowed(successors: &[Successor], progress: bool) -> Verdict {
    let mut kept = successors.iter().filter(|s| !s.dropped);
    if kept.clone().all(|s| s.goal) {
        Verdict::Improves
    } else if kept.any(|s| s.goal) {
        Verdict::MayImprove
    } else if progress {
        Verdict::Approaches
    } else {
        Verdict::Stays
    }
}

/// Returns the reason why a kept choice is not permitted.
fn forbidden(kind: Kind, successors: &[Successor]) -> Verdict {
    let strays = |s: &Successor| !s.dropped && !s.goal && !s.stays;
    match (kind, successors.iter().position(strays)) {
        (Kind::Sasi, Some(index)) => Verdict::Strays(index),
        _ => Verdict::Hopeless,
    }
}

/// Returns { j ∈ `to` : j is strictly preferred to a member of `from` }. If `from` is empty and any
/// gain improves, returns all of `to`.
fn gained(preferences: &Preferences, from: &ObjectiveSet, to: &ObjectiveSet) -> ObjectiveSet {
    if from.is_empty() && preferences.improves(from, to) {
        return to.clone();
    }
    let order = &preferences.order;
    to.iter().filter(|&j| from.iter().any(|i| order.strictly(j, i))).collect()
}

/// Returns { i ∈ `from` : i is strictly preferred to a member of `to` }. If `to` is empty and
/// losing everything weakens, returns all of `from`.
pub(super) fn lost(preferences: &Preferences, from: &ObjectiveSet, to: &ObjectiveSet) -> ObjectiveSet {
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

    fn successor(dropped: bool, goal: bool, stays: bool) -> Successor {
        Successor {
            state: Vec::new(),
            probability: 0.25,
            is_unsafe: false,
            most_preferred: ObjectiveSet::new(),
            rank: Rank::Finite(0),
            change: Change::Lateral,
            gained: ObjectiveSet::new(),
            lost: ObjectiveSet::new(),
            dropped,
            goal,
            stays,
            next: Memory { level: Rank::Finite(0), arena: None, pursuit: None },
            improves: false,
        }
    }

    #[test]
    fn what_strays_is_there_and_neither_improves_nor_stays() {
        let fine =
            [successor(true, false, false), successor(false, true, false), successor(false, false, true)];
        assert_eq!(forbidden(Kind::Sasi, &fine), Verdict::Hopeless);
        let [first, second, third] = fine;
        let all = [first, second, third, successor(false, false, false)];
        assert_eq!(forbidden(Kind::Sasi, &all), Verdict::Strays(3));
        assert_eq!(forbidden(Kind::Spi, &all), Verdict::Hopeless);
    }

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
