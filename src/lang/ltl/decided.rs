//! The states in which the path so far satisfies a formula, whatever follows.

use std::collections::BTreeSet;

use super::install::{Installed, Monitoring, Values};
use meliora_base::value::Value;
use meliora_ltl::{Joint, Monitor};
use meliora_model::expr::{Binary, ExprId};
use meliora_model::temporal::{Asks, Condition};

impl Monitoring<'_> {
    /// Returns the condition that the path so far, with the present state, satisfies a condition
    /// whatever follows. It is derived leaf by leaf and, where several leaves together are satisfied, as in
    /// `(F a) | (G !a)`, from the joint states of their monitors; if these are too many, leaf by leaf only.
    pub(crate) fn decided(&mut self, condition: &Condition<ExprId>) -> ExprId {
        let known = self.leaves_decided(condition);
        match self.jointly_decided(condition) {
            Some(more) => self.predicates.pool().binary(Binary::Or, known, more),
            None => known,
        }
    }

    /// Returns the condition that the monitors are in a joint state from which every word satisfies a
    /// condition, but no leaf decides it; `None` without such states, or if the joint states are too many.
    fn jointly_decided(&mut self, condition: &Condition<ExprId>) -> Option<ExprId> {
        let marks: Vec<ExprId> = condition.marks().into_iter().collect::<BTreeSet<_>>().into_iter().collect();
        if marks.len() == condition.marks().len() && marks.len() < 2 {
            return None;
        }
        let own = |mark: &ExprId| self.installed.iter().position(|w| w.mark == *mark);
        let places = marks.iter().map(own).collect::<Option<Vec<_>>>()?;
        let monitors: Vec<&Monitor> = places.iter().map(|&place| &self.installed[place].monitor).collect();
        let joint = Joint::explore(&monitors)?;
        let position = |mark: &ExprId| marks.iter().position(|known| known == mark);
        let mut open = vec![false; joint.states.len()];
        for case in condition.negated().disjuncts().ok()? {
            let [on, off] = [true, false].map(|sign| {
                let kept = case.always.iter().filter(move |(_, on)| *on == sign);
                kept.filter_map(|(mark, _)| position(mark)).collect::<Vec<_>>()
            });
            let again: Vec<usize> = on.into_iter().chain(case.again.iter().filter_map(position)).collect();
            let may = joint.may(&again, &off);
            open.iter_mut().zip(may).for_each(|(open, may)| *open |= may);
        }
        let settled: Vec<[Vec<bool>; 2]> =
            monitors.iter().map(|monitor| [true, false].map(|marked| monitor.settled(marked))).collect();
        let by_leaves = |state: &[usize]| {
            let value = |asks: Asks, mark: &ExprId| {
                let place = position(mark).unwrap_or_default();
                let wanted = usize::from(matches!(asks, Asks::Avoid | Asks::Settle));
                settled[place][wanted][state[place]]
            };
            condition.holds(&value)
        };
        let decided = joint.states.iter().zip(&open).filter(|(state, open)| !**open && !by_leaves(state));
        let decided: Vec<&Vec<usize>> = decided.map(|(state, _)| state).collect();
        self.in_one_of(&places, &decided)
    }

    /// Returns the condition that the step leads to one of some joint states of installed monitors; `None` if
    /// there are none.
    fn in_one_of(&mut self, places: &[usize], states: &[&Vec<usize>]) -> Option<ExprId> {
        let pool = self.predicates.pool();
        let mut any = None;
        for state in states {
            let mut all = pool.value(Value::Bool(true));
            for (&place, &wanted) in places.iter().zip(*state) {
                let Installed { monitor, variable, .. } = &self.installed[place];
                let only: Vec<bool> = (0..monitor.states.len()).map(|s| s == wanted).collect();
                let here = Values { pool: &mut *pool, monitor, variable: *variable }.settled(&only);
                all = pool.binary(Binary::And, all, here);
            }
            any = Some(any.map_or(all, |any| pool.binary(Binary::Or, any, all)));
        }
        any
    }

    /// Returns [`Monitoring::decided`], derived leaf by leaf.
    fn leaves_decided(&mut self, condition: &Condition<ExprId>) -> ExprId {
        let (op, parts) = match condition {
            Condition::Constant(value) => return self.predicates.pool().value(Value::Bool(*value)),
            Condition::Leaf(asks, mark) => return self.leaf_decided(*asks, *mark),
            Condition::All(parts) => (Binary::And, parts),
            Condition::Any(parts) => (Binary::Or, parts),
        };
        let mut whole = self.predicates.pool().value(Value::Bool(op == Binary::And));
        for part in parts {
            let part = self.leaves_decided(part);
            whole = self.predicates.pool().binary(op, whole, part);
        }
        whole
    }

    /// Returns [`Monitoring::decided`] for one leaf: a co-safe formula is decided by a mark, the
    /// others when all later steps have marks, or none has one.
    fn leaf_decided(&mut self, asks: Asks, mark: ExprId) -> ExprId {
        let pool = self.predicates.pool();
        let wanted = match asks {
            Asks::Accept => return mark,
            Asks::Again => true,
            Asks::Avoid | Asks::Settle => false,
        };
        match self.installed.iter().find(|w| w.mark == mark) {
            Some(Installed { monitor, variable, .. }) => {
                Values { pool, monitor, variable: *variable }.settled(&monitor.settled(wanted))
            }
            None => pool.value(Value::Bool(false)),
        }
    }
}
