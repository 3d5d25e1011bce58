//! Relevance: what the goals depend on, through any number of actions.

use super::{Fact, Ground, GroundTask};

impl GroundTask {
    /// Leaves out the facts on which no goal or preference depends, and the actions that change none of
    /// the others. No goal depends on the measures.
    pub(crate) fn keep_relevant(&mut self) {
        self.measures.clear();
        self.actions.iter_mut().for_each(|action| action.earned.clear());
        let is_relevant = self.relevant();
        let mut number = 0;
        let new: Vec<Fact> = is_relevant.iter().map(|is| (number, number += u32::from(*is)).0).collect();
        let kept = |fact: Fact| is_relevant[fact as usize];
        for outcome in self.actions.iter_mut().flat_map(|action| &mut action.outcomes) {
            outcome.effects.retain(|effect| kept(effect.fact));
        }
        self.actions.retain(|action| action.outcomes.iter().any(|outcome| !outcome.effects.is_empty()));
        for action in &mut self.actions {
            action.precondition.renumber(&new);
            for effect in action.outcomes.iter_mut().flat_map(|outcome| &mut outcome.effects) {
                effect.fact = new[effect.fact as usize];
                effect.condition.renumber(&new);
            }
        }
        self.goal.iter_mut().for_each(|goal| goal.renumber(&new));
        self.preferences.iter_mut().for_each(|(_, condition)| condition.renumber(&new));
        // Derived facts that depend on other facts are not used any more.
        for (_, condition) in &mut self.derived {
            let mut depends = Vec::new();
            condition.facts(&mut |ground| depends.extend(ground.fact()));
            match depends.iter().all(|&fact| kept(fact)) {
                true => condition.renumber(&new),
                false => *condition = Ground::False,
            }
        }
        let mut keep = is_relevant.iter();
        self.facts.retain(|_| keep.next() == Some(&true));
        for start in &mut self.starts {
            let mut keep = is_relevant.iter();
            start.retain(|_| keep.next() == Some(&true));
        }
        self.starts.sort_unstable();
        self.starts.dedup();
    }

    /// Returns for each fact whether a condition depends on it in the same state, also through derived facts.
    pub(crate) fn read_by(&self, condition: &Ground) -> Vec<bool> {
        let mut is_read = vec![false; self.facts.len()];
        let mut is_used = vec![false; self.derived.len()];
        let mut open = vec![condition];
        while let Some(condition) = open.pop() {
            condition.facts(&mut |literal| match literal {
                Ground::Fact(fact, _) => is_read[*fact as usize] = true,
                Ground::Derived(derived, _) if !std::mem::replace(&mut is_used[*derived as usize], true) => {
                    open.push(&self.derived[*derived as usize].1);
                }
                _ => {}
            });
        }
        is_read
    }

    /// Returns for each fact whether a goal depends on it.
    fn relevant(&self) -> Vec<bool> {
        let mut changing: Vec<Vec<(usize, &Ground)>> = vec![Vec::new(); self.facts.len()];
        for (number, action) in self.actions.iter().enumerate() {
            for effect in action.outcomes.iter().flat_map(|outcome| &outcome.effects) {
                changing[effect.fact as usize].push((number, &effect.condition));
            }
        }
        let mut is_relevant = vec![false; self.facts.len()];
        let mut is_used = vec![false; self.derived.len()];
        let mut is_taken = vec![false; self.actions.len()];
        let mut open: Vec<&Ground> =
            self.goal.iter().chain(self.preferences.iter().map(|(_, condition)| condition)).collect();
        let first = |seen: &mut bool| !std::mem::replace(seen, true);
        while let Some(condition) = open.pop() {
            condition.facts(&mut |literal| match literal {
                Ground::Fact(fact, _) if first(&mut is_relevant[*fact as usize]) => {
                    for &(action, condition) in &changing[*fact as usize] {
                        open.push(condition);
                        if first(&mut is_taken[action]) {
                            open.push(&self.actions[action].precondition);
                        }
                    }
                }
                Ground::Derived(derived, _) if first(&mut is_used[*derived as usize]) => {
                    open.push(&self.derived[*derived as usize].1);
                }
                _ => {}
            });
        }
        is_relevant
    }
}

impl Ground {
    /// Calls a function for each fact and derived fact of a condition.
    fn facts<'g>(&'g self, then: &mut impl FnMut(&'g Ground)) {
        let mut open = vec![self];
        while let Some(condition) = open.pop() {
            match condition {
                Ground::And(parts) | Ground::Or(parts) => open.extend(parts),
                literal => then(literal),
            }
        }
    }

    fn fact(&self) -> Option<Fact> {
        match self {
            Ground::Fact(fact, _) => Some(*fact),
            _ => None,
        }
    }

    /// Gives the facts new numbers in the same order, so that parts stay sorted.
    fn renumber(&mut self, new: &[Fact]) {
        match self {
            Ground::Fact(fact, _) => *fact = new[*fact as usize],
            Ground::And(parts) | Ground::Or(parts) => parts.iter_mut().for_each(|part| part.renumber(new)),
            Ground::True | Ground::False | Ground::Derived(..) => {}
        }
    }
}
