//! Why an action is permitted in a state, or is not.

use super::finite_memory::{FiniteMemoryStrategy, Memory};
use super::improvement::Safety;
use super::levels::{Kind, Rank};
use crate::engine::Engine;
use crate::error::Result;
use crate::model::preference::{Change, ObjectiveSet, Preferences};
use crate::model::step::Step;
use crate::model::{State, fault};

/// What there is to say of an action; successors are named by their positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Permitted: every kept successor is an improvement that the level asks for.
    Improves,
    /// Permitted: some successor is such an improvement.
    MayImprove,
    /// Permitted: some successor is one layer closer to an improvement.
    Approaches,
    /// Permitted, and makes no progress.
    Stays,
    /// Not kept: this successor weakens.
    Weakens(usize),
    /// Not kept under `prefix`: after this successor a weakening can not be avoided for ever. None
    /// where that is so in the state itself.
    Unsafe(Option<usize>),
    /// Kept, but this successor leaves the states from which the improvements are sure.
    Strays(usize),
    /// Kept, but no improvement that the level asks for can follow.
    Hopeless,
    /// Kept, but the state has rank 0: there is nothing to plan for.
    NothingAhead,
}

/// A state under a strategy.
#[derive(Debug, Clone, PartialEq)]
pub struct Explanation {
    /// The state.
    pub state: State,
    /// What the play remembers there.
    pub memory: Memory,
    /// MP(s)
    pub most_preferred: ObjectiveSet,
    /// What the actions are measured against: MP(s), or that of the reference under `prefix`.
    pub reference: ObjectiveSet,
    /// All enabled actions in the order of the program.
    pub actions: Vec<Action>,
    /// The action of the progress strategy, by its position; none at rank 0.
    pub pick: Option<usize>,
}

/// An action that is enabled.
#[derive(Debug, Clone, PartialEq)]
pub struct Action {
    /// Its name.
    pub name: String,
    /// Whether the improvement MDP has it.
    pub kept: bool,
    /// Whether the permissive strategy permits it.
    pub permitted: bool,
    /// Whether it moves one layer closer with positive probability.
    pub progress: bool,
    /// Why.
    pub verdict: Verdict,
    /// Where it leads.
    pub successors: Vec<Successor>,
}

/// Where an action may lead.
#[derive(Debug, Clone, PartialEq)]
pub struct Successor {
    /// The state.
    pub state: State,
    /// How likely.
    pub probability: f64,
    /// MP(s')
    pub most_preferred: ObjectiveSet,
    /// rank(s')
    pub rank: Rank,
    /// What the step is, measured against the reference.
    pub change: Change,
    /// { j ∈ MP(s') : j is strictly preferred to a member of the reference }
    pub gained: ObjectiveSet,
    /// { i in the reference : i is strictly preferred to a member of MP(s') }
    pub lost: ObjectiveSet,
    /// Whether the improvement MDP does without this branch; the real system may take it.
    pub dropped: bool,
    /// Whether it is an improvement that the level asks for.
    pub goal: bool,
    /// Whether the level has the state: it can be played on there.
    pub stays: bool,
    /// The memory after the step.
    pub next: Memory,
    /// Whether the step is an improvement, of this level or another.
    pub improves: bool,
}

impl<E: Engine> FiniteMemoryStrategy<'_, E> {
    /// All that is to be said of a state in which a play has the given memory.
    ///
    /// # Errors
    /// A limit of the engine, or a command without a meaning in the state. Cost: that of
    /// [`FiniteMemoryStrategy::strategy`]; then no image.
    pub fn explain(&mut self, state: &[i64], memory: Memory) -> Result<Explanation> {
        if let Some(limit) = self.engine.settings().sink.stop() {
            return Err(limit.into());
        }
        let steps = self.program.steps(state).map_err(|f| fault::error(&self.program, &f, state))?;
        let reference = self.reference(memory, state);
        let mut actions = Vec::with_capacity(steps.len());
        for step in steps {
            actions.push(self.action(state, memory, &reference, step)?);
        }
        Ok(Explanation {
            most_preferred: self.most_preferred(state),
            pick: actions.iter().position(|a| a.progress),
            state: state.to_vec(),
            memory,
            reference,
            actions,
        })
    }

    fn action(
        &mut self,
        state: &[i64],
        memory: Memory,
        reference: &ObjectiveSet,
        step: Step,
    ) -> Result<Action> {
        let Step { choice, name, successors } = step;
        let (engine, kind) = (self.engine.clone(), self.kind());
        let one = |(to, p)| self.successor(state, memory, reference, to, p);
        let successors: Vec<Successor> = successors.into_iter().map(one).collect();
        let kept = self.arena(memory).is_some_and(|a| engine.contains_choice(&a.choices, state, &choice));
        let level = self.strategy(memory)?.map(|strategy| {
            let permitted = engine.contains_choice(&strategy.permissive, state, &choice);
            (permitted, permitted && engine.contains_choice(&strategy.progress, state, &choice))
        });
        let (permitted, progress) = level.unwrap_or((false, false));
        let verdict = match level {
            _ if !kept => self.refused(memory, &successors),
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
    ) -> Successor {
        let most_preferred = self.most_preferred(&to);
        let change = self.preferences.change(reference, &most_preferred);
        let (next, improves) = self.after(memory, from, &to);
        let (goal, stays) = self.game(memory).map_or((false, false), |game| {
            let goal = super::strategy::is_goal(&*self.engine, game, from, &to);
            (goal, self.engine.contains(&game.states, &to))
        });
        Successor {
            probability: p,
            rank: self.rank(&to),
            gained: gained(&self.preferences, reference, &most_preferred),
            lost: lost(&self.preferences, reference, &most_preferred),
            dropped: self.improvement.safety == Safety::Transition && change == Change::Weakening,
            most_preferred,
            state: to,
            change,
            goal,
            stays,
            next,
            improves,
        }
    }

    /// Why a choice is not kept.
    fn refused(&self, memory: Memory, successors: &[Successor]) -> Verdict {
        match (successors.iter().position(|s| s.change == Change::Weakening), self.arena(memory)) {
            (Some(index), _) => Verdict::Weakens(index),
            (None, Some(arena)) => Verdict::Unsafe(
                successors.iter().position(|s| !self.engine.contains(&arena.states, &s.state)),
            ),
            (None, None) => Verdict::Unsafe(None),
        }
    }
}

/// Why a choice is permitted.
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

/// Why a kept choice is not permitted.
fn forbidden(kind: Kind, successors: &[Successor]) -> Verdict {
    let strays = |s: &Successor| !s.dropped && !s.goal && !s.stays;
    match (kind, successors.iter().position(strays)) {
        (Kind::Sasi, Some(index)) => Verdict::Strays(index),
        _ => Verdict::Hopeless,
    }
}

/// { j ∈ `to` : j is strictly preferred to a member of `from` }; all of `to` where gaining anything
/// improves on an empty side.
fn gained(preferences: &Preferences, from: &ObjectiveSet, to: &ObjectiveSet) -> ObjectiveSet {
    if from.is_empty() && preferences.improves(from, to) {
        return to.clone();
    }
    let order = &preferences.order;
    to.iter().filter(|&j| from.iter().any(|i| order.strictly(j, i))).collect()
}

/// { i ∈ `from` : i is strictly preferred to a member of `to` }; all of `from` where losing
/// everything weakens.
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
    use crate::model::preference::{Empty, Preorder, Relation, Statement};

    fn successor(dropped: bool, goal: bool, stays: bool) -> Successor {
        Successor {
            state: Vec::new(),
            probability: 0.25,
            most_preferred: ObjectiveSet::new(),
            rank: Rank::Finite(0),
            change: Change::Lateral,
            gained: ObjectiveSet::new(),
            lost: ObjectiveSet::new(),
            dropped,
            goal,
            stays,
            next: Memory { level: Rank::Finite(0), arena: None },
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
            Preferences { objectives: Vec::new(), order, empty, history: Default::default() }
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
