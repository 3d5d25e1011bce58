//! Temporal formulas as conditions on the marks of monitors.
//!
//! Monitors run in parallel with the model. Each monitor has one variable, which every choice
//! updates in the same way, depending on the present state. Monitors mark some steps; a formula
//! requires that marks occur or do not occur.

use std::collections::BTreeSet;

use strum::IntoStaticStr;

use super::expr::ExprId;
use super::predicate::Predicate;
use super::{Program, VarId};
use meliora_base::error::{Limit, Result};

/// Maximum number of disjuncts: each needs a search.
pub const MOST_DISJUNCTS: usize = 64;

/// The requirement of a formula on the marks of one monitor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, IntoStaticStr)]
pub enum Asks {
    /// Some step is marked, and all later ones are then marked too: the formula is co-safe.
    #[strum(serialize = "co-safe")]
    Accept,
    /// Every step is unmarked; after a marked step, all steps are marked: a safe formula.
    #[strum(serialize = "safe")]
    Avoid,
    /// Infinitely many steps are marked: a recurrence formula.
    #[strum(serialize = "recurrence")]
    Again,
    /// Every step from some step on is unmarked: a persistence formula.
    #[strum(serialize = "persistence")]
    Settle,
}

impl Asks {
    /// Returns the requirement of the negation.
    pub fn opposite(self) -> Asks {
        match self {
            Asks::Accept => Asks::Avoid,
            Asks::Avoid => Asks::Accept,
            Asks::Again => Asks::Settle,
            Asks::Settle => Asks::Again,
        }
    }
}

/// A Boolean combination of requirements on marks. A mark is a condition for the states whose steps
/// are marked; as long as monitors are being added, it is the number of an expression.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Condition<M = Predicate> {
    /// All paths, or no path.
    Constant(bool),
    /// A requirement on a mark.
    Leaf(Asks, M),
    /// All parts.
    All(Vec<Self>),
    /// At least one part.
    Any(Vec<Self>),
}

impl<M> Condition<M> {
    /// Returns whether every leaf asks the same of its mark.
    pub fn only_asks(&self, asks: Asks) -> bool {
        match self {
            Condition::Constant(_) => true,
            Condition::Leaf(own, _) => *own == asks,
            Condition::All(parts) | Condition::Any(parts) => parts.iter().all(|part| part.only_asks(asks)),
        }
    }
}

/// One way to satisfy a condition: some marks never change their sign from some step on, others
/// occur infinitely often.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Disjunct<M = Predicate> {
    /// The marks with the sign that they keep forever.
    pub always: Vec<(M, bool)>,
    /// The marks that occur infinitely often.
    pub again: Vec<M>,
}

impl<M: Clone + Ord> Condition<M> {
    /// Returns the same condition on other marks.
    pub fn map<N>(&self, mark: &impl Fn(M) -> N) -> Condition<N> {
        let all = |parts: &[Self]| parts.iter().map(|part| part.map(mark)).collect();
        match self {
            Condition::Constant(value) => Condition::Constant(*value),
            Condition::Leaf(asks, of) => Condition::Leaf(*asks, mark(of.clone())),
            Condition::All(parts) => Condition::All(all(parts)),
            Condition::Any(parts) => Condition::Any(all(parts)),
        }
    }

    /// Returns the negation.
    pub fn negated(&self) -> Self {
        let all = |parts: &[Self]| parts.iter().map(Self::negated).collect();
        match self {
            Condition::Constant(value) => Condition::Constant(!value),
            Condition::Leaf(asks, mark) => Condition::Leaf(asks.opposite(), mark.clone()),
            Condition::All(parts) => Condition::Any(all(parts)),
            Condition::Any(parts) => Condition::All(all(parts)),
        }
    }

    /// Returns whether the condition holds if some leaves hold.
    pub fn holds(&self, leaf: &impl Fn(Asks, &M) -> bool) -> bool {
        match self {
            Condition::Constant(value) => *value,
            Condition::Leaf(asks, mark) => leaf(*asks, mark),
            Condition::All(parts) => parts.iter().all(|part| part.holds(leaf)),
            Condition::Any(parts) => parts.iter().any(|part| part.holds(leaf)),
        }
    }

    /// Returns the marks of all leaves.
    pub fn marks(&self) -> Vec<M> {
        match self {
            Condition::Constant(_) => Vec::new(),
            Condition::Leaf(_, mark) => vec![mark.clone()],
            Condition::All(parts) | Condition::Any(parts) => parts.iter().flat_map(Self::marks).collect(),
        }
    }

    /// Returns whether some leaf has a requirement.
    pub fn asks(&self, requirement: Asks) -> bool {
        match self {
            Condition::Constant(_) => false,
            Condition::Leaf(asks, _) => *asks == requirement,
            Condition::All(parts) | Condition::Any(parts) => parts.iter().any(|part| part.asks(requirement)),
        }
    }

    /// Returns the marks of the leaves that no finite prefix of a path decides, of recurrence and
    /// persistence; each once.
    pub fn undecided(&self) -> Vec<M> {
        let mut all = match self {
            Condition::Leaf(Asks::Again | Asks::Settle, mark) => vec![mark.clone()],
            Condition::Constant(_) | Condition::Leaf(..) => Vec::new(),
            Condition::All(parts) | Condition::Any(parts) => parts.iter().flat_map(Self::undecided).collect(),
        };
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Returns whether it suffices to reach a state from which one disjunct can be kept, and to keep it,
    /// whatever an opponent does: the states from which we satisfy the condition almost surely are those
    /// that almost surely reach such a state. Otherwise the opponent may choose, again and again, how the
    /// condition is satisfied.
    ///
    /// This is so without persistence, if disjuncts differ in marks of co-safe formulas only. Consider a
    /// path under a strategy that satisfies the condition almost surely; it stays in states from which
    /// this is possible. It almost surely comes to a state where the marks of some disjunct are set. They
    /// stay set, and the strategy keeps the rest, which is that of all disjuncts, from the start.
    ///
    /// # Errors
    /// There are more than [`MOST_DISJUNCTS`].
    pub fn reaching_suffices(&self) -> Result<bool> {
        let rest = |d: &Disjunct<M>| {
            let off = d.always.iter().filter(|(_, set)| !set);
            (off.cloned().collect::<Vec<_>>(), d.again.clone())
        };
        let rests = self.disjuncts()?.iter().map(rest).collect::<BTreeSet<_>>();
        Ok(!self.asks(Asks::Settle) && rests.len() < 2)
    }

    /// Returns the disjunctive normal form without disjuncts that are stronger than another one or
    /// that contradict themselves.
    ///
    /// # Errors
    /// There are more than [`MOST_DISJUNCTS`].
    pub fn disjuncts(&self) -> Result<Vec<Disjunct<M>>> {
        match self {
            Condition::Constant(true) => Ok(vec![Disjunct::free()]),
            Condition::Constant(false) => Ok(Vec::new()),
            Condition::Leaf(asks, mark) => {
                let always = match asks {
                    Asks::Accept => vec![(mark.clone(), true)],
                    Asks::Avoid | Asks::Settle => vec![(mark.clone(), false)],
                    Asks::Again => Vec::new(),
                };
                let again = if *asks == Asks::Again { vec![mark.clone()] } else { Vec::new() };
                Ok(vec![Disjunct { always, again }])
            }
            Condition::Any(parts) => {
                let mut all = Vec::new();
                for part in parts {
                    all.extend(part.disjuncts()?);
                    all = least(all)?;
                }
                Ok(all)
            }
            Condition::All(parts) => {
                let mut all = vec![Disjunct::free()];
                for part in parts {
                    let other = part.disjuncts()?;
                    all = least(all.iter().flat_map(|d| other.iter().filter_map(|o| d.and(o))).collect())?;
                }
                Ok(all)
            }
        }
    }
}

impl<M: Clone + Ord> Disjunct<M> {
    /// Returns the disjunct without requirements.
    fn free() -> Self {
        Disjunct { always: Vec::new(), again: Vec::new() }
    }

    /// Returns the conjunction, `None` if no path satisfies it: a mark keeps one sign only, and one
    /// that keeps off does not recur.
    fn and(&self, other: &Self) -> Option<Self> {
        let mut both = self.clone();
        both.always.extend(other.always.iter().cloned());
        both.again.extend(other.again.iter().cloned());
        both.always.sort_unstable();
        both.always.dedup();
        both.again.sort_unstable();
        both.again.dedup();
        let off = |mark: &M| both.always.iter().any(|(other, on)| other == mark && !on);
        let contradicts = both.again.iter().any(off) || both.always.iter().any(|(mark, on)| *on && off(mark));
        (!contradicts).then_some(both)
    }

    fn asks_all_of(&self, other: &Self) -> bool {
        other.always.iter().all(|a| self.always.contains(a))
            && other.again.iter().all(|a| self.again.contains(a))
    }
}

/// Returns the weakest disjuncts, each once.
///
/// # Errors
/// There are more than [`MOST_DISJUNCTS`].
fn least<M: Clone + Ord>(mut all: Vec<Disjunct<M>>) -> Result<Vec<Disjunct<M>>> {
    all.sort_unstable_by_key(|d| (d.always.len() + d.again.len(), d.clone()));
    let mut kept: Vec<Disjunct<M>> = Vec::new();
    for disjunct in all {
        if !kept.iter().any(|k| disjunct.asks_all_of(k)) {
            kept.push(disjunct);
        }
    }
    if kept.len() > MOST_DISJUNCTS {
        let what = format!("a temporal formula with more than {MOST_DISJUNCTS} cases");
        return Err(Limit::Size { what }.into());
    }
    Ok(kept)
}

/// The monitors of a program.
#[derive(Debug, Clone)]
pub struct Monitors {
    /// The variables of the monitors.
    pub variables: Vec<VarId>,
    /// The module of all monitors, a position in [`super::Program::modules`].
    pub module: usize,
    /// The module's command, which takes part in every synchronisation, a position in
    /// [`super::Program::commands`].
    pub command: usize,
    /// The states in which no command of the model is enabled and the monitors step alone; `None`
    /// if there are none.
    pub deadlock: Option<ExprId>,
    /// The initial states of the model, for any state of the monitors.
    pub initial: ExprId,
    /// The states in which all monitors are fresh, that is, have read nothing yet.
    pub fresh: ExprId,
    /// The states in which monitors may begin.
    pub begin: Begin,
}

impl Program {
    /// Returns the same program without its monitors.
    pub fn without_monitors(&self) -> Program {
        let mut program = self.clone();
        let Some(monitors) = program.monitors.take() else { return program };
        program.initial = monitors.initial;
        program.variables.truncate(program.variables.len() - monitors.variables.len());
        program.modules.truncate(monitors.module);
        program.commands.truncate(monitors.command);
        if monitors.deadlock.is_some() {
            program.synchronisations.pop();
            program.actions.pop();
        }
        program.synchronisations.iter_mut().for_each(|s| drop(s.factors.pop()));
        program
    }
}

/// The states in which monitors may begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Begin {
    /// The initial states.
    Initially,
    /// Every state of the scope: formulas are judged from each of them on.
    Everywhere,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::ExprPool;
    use meliora_base::error::Error;
    use meliora_base::value::Type;

    #[test]
    fn a_condition_with_too_many_cases_is_a_limit_and_not_false() {
        let mut pool = ExprPool::default();
        let mut leaf = |n| Condition::Leaf(Asks::Accept, pool.var(VarId(n), Type::Bool));
        let either = Vec::from_iter((0..7).map(|n| Condition::Any(vec![leaf(2 * n), leaf(2 * n + 1)])));
        let cases = |factors| Condition::All(either[..factors].to_vec()).disjuncts();
        assert_eq!(cases(6).unwrap().len(), MOST_DISJUNCTS);
        assert!(matches!(cases(7), Err(Error::Limit(Limit::Size { .. }))));
    }
}
