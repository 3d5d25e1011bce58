//! Groups of facts of which at most one holds in every reachable state, after Helmert, "Concise
//! finite-domain representations for PDDL planning tasks" (AIJ 2009), and a choice of groups that
//! become variables.
//!
//! A candidate is a set of atoms over common parameters, at most one argument of each is counted: for
//! `at(x, *)` and `in(x, *)`, each object `x` is in at most one place. It is verified on all ground
//! actions: each added fact of a group comes with a deleted one that held before.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use ahash::{AHashMap, AHashSet};
use smallvec::SmallVec;

use crate::ground::{Fact, Ground, GroundAction, GroundEffect, GroundTask, Outcome};
use crate::task::Object;
use meliora_base::error::Limit;
use meliora_base::progress::{Poll, ProgressSink};

/// Maximum number of candidates that are tried: refinements multiply with the number of predicates.
const MOST_CANDIDATES: usize = 10_000;

/// The objects of the parameters of a group.
type Key = SmallVec<[Object; 4]>;

/// The atoms of a predicate in a candidate.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct Part {
    predicate: usize,
    /// For each parameter of the candidate, the argument that it is.
    order: Vec<usize>,
    /// The argument that is counted.
    counted: Option<usize>,
}

/// Atoms over common parameters, sorted by predicate.
type Candidate = Vec<Part>;

/// Facts that become the values of one variable.
#[derive(Debug)]
pub(crate) struct Group {
    pub(crate) facts: Vec<Fact>,
    /// The predicates of the group, and the objects of its parameters.
    pub(crate) predicates: Vec<usize>,
    pub(crate) parameters: Vec<Object>,
    /// For a group of one predicate, the argument that tells its facts apart.
    pub(crate) counted: Option<usize>,
    /// True if none of the facts may hold in some state.
    pub(crate) has_none: bool,
}

impl Part {
    fn key(&self, arguments: &[Object]) -> Key {
        self.order.iter().map(|&at| arguments[at]).collect()
    }
}

struct Search<'t> {
    task: &'t GroundTask,
    /// For each predicate, the outcomes that add one of its facts.
    adding: AHashMap<usize, Vec<(u32, u32)>>,
    /// The facts of each predicate.
    of: AHashMap<usize, Vec<Fact>>,
    open: VecDeque<Candidate>,
    seen: AHashSet<Candidate>,
}

/// Returns a partition of all facts into groups.
///
/// # Errors
/// A limit.
pub(crate) fn groups(task: &GroundTask, sink: &dyn ProgressSink) -> Result<Vec<Group>, Limit> {
    sink.progress("invariants", &|| format!("{} facts", task.facts.len()));
    let mut poll = Poll::new(sink);
    let mut search = Search::new(task);
    let mut found = Vec::new();
    while let Some(candidate) = search.open.pop_front() {
        if search.verified(&candidate, &mut poll)? {
            found.extend(search.instances(&candidate));
        }
    }
    let mut groups = cover(task, found);
    let mut group_of = vec![0; task.facts.len()];
    for (number, group) in groups.iter().enumerate() {
        group.facts.iter().for_each(|&fact| group_of[fact as usize] = number);
    }
    mark_none(task, &group_of, &mut groups);
    Ok(groups)
}

impl<'t> Search<'t> {
    fn new(task: &'t GroundTask) -> Self {
        let mut adding: AHashMap<usize, Vec<(u32, u32)>> = AHashMap::new();
        for (action, number) in task.actions.iter().zip(0..) {
            for (outcome, which) in action.outcomes.iter().zip(0..) {
                for effect in outcome.effects.iter().filter(|effect| effect.is_added) {
                    let all = adding.entry(task.facts[effect.fact as usize].0).or_default();
                    if all.last() != Some(&(number, which)) {
                        all.push((number, which));
                    }
                }
            }
        }
        let mut of: AHashMap<usize, Vec<Fact>> = AHashMap::new();
        for ((predicate, _), fact) in task.facts.iter().zip(0..) {
            of.entry(*predicate).or_default().push(fact);
        }
        let mut search = Search { task, adding, of, open: VecDeque::new(), seen: AHashSet::new() };
        let mut first: Vec<(usize, usize)> =
            search.of.iter().map(|(&p, facts)| (p, task.facts[facts[0] as usize].1.len())).collect();
        first.sort_unstable();
        for (predicate, arity) in first {
            for counted in (0..arity).map(Some).chain([None]) {
                let order = (0..arity).filter(|&at| Some(at) != counted).collect();
                search.propose(vec![Part { predicate, order, counted }]);
            }
        }
        search
    }

    /// Adds a candidate, with its parameters in the order of the first part.
    fn propose(&mut self, mut candidate: Candidate) {
        candidate.sort_unstable();
        let mut order: Vec<usize> = (0..candidate[0].order.len()).collect();
        order.sort_by_key(|&parameter| candidate[0].order[parameter]);
        for part in &mut candidate {
            part.order = order.iter().map(|&parameter| part.order[parameter]).collect();
        }
        if self.seen.len() < MOST_CANDIDATES && self.seen.insert(candidate.clone()) {
            self.open.push_back(candidate);
        }
    }

    fn covered(&self, candidate: &Candidate, fact: Fact) -> Option<Key> {
        let (predicate, arguments) = &self.task.facts[fact as usize];
        let part = candidate.iter().find(|part| part.predicate == *predicate)?;
        Some(part.key(arguments))
    }

    /// Returns whether no action makes two facts of a group true. At the first one that may do so,
    /// proposes candidates with a further predicate that the action deletes.
    fn verified(&mut self, candidate: &Candidate, poll: &mut Poll<'_>) -> Result<bool, Limit> {
        let mut outcomes: Vec<(u32, u32)> = Vec::new();
        for part in candidate {
            outcomes.extend(self.adding.get(&part.predicate).into_iter().flatten());
        }
        outcomes.sort_unstable();
        outcomes.dedup();
        for (number, which) in outcomes {
            poll.step()?;
            let action = &self.task.actions[number as usize];
            let outcome = &action.outcomes[which as usize];
            match self.fault(candidate, action, outcome) {
                None => {}
                Some(Fault::TooHeavy) => return Ok(false),
                Some(Fault::Unbalanced(add, key)) => {
                    let refined = self.refined(candidate, action, outcome, (add, &key));
                    refined.into_iter().for_each(|candidate| self.propose(candidate));
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    fn fault(&self, candidate: &Candidate, action: &GroundAction, outcome: &Outcome) -> Option<Fault> {
        let covered = |effect: &GroundEffect| Some((self.covered(candidate, effect.fact)?, effect.clone()));
        let (adds, deletes): (Vec<_>, Vec<_>) =
            outcome.effects.iter().filter_map(covered).partition(|(_, effect)| effect.is_added);
        for (at, (key, add)) in adds.iter().enumerate() {
            let same = |(other, effect): &&(Key, GroundEffect)| other == key && effect.fact != add.fact;
            let others = adds[at + 1..].iter().filter(same);
            if others.clone().any(|(_, other)| !excludes(&add.condition, &other.condition)) {
                return Some(Fault::TooHeavy);
            }
            let is_kept = requires(action, add, add.fact);
            let is_balanced = |(_, delete): &(Key, GroundEffect)| balances(action, add, delete);
            if !is_kept && !deletes.iter().filter(same).any(is_balanced) {
                return Some(Fault::Unbalanced(add.clone(), key.clone()));
            }
        }
        None
    }

    /// Returns the candidate with each predicate that could balance an added fact.
    fn refined(
        &self,
        candidate: &Candidate,
        action: &GroundAction,
        outcome: &Outcome,
        (add, key): (GroundEffect, &Key),
    ) -> Vec<Candidate> {
        let mut refined = Vec::new();
        for delete in outcome.effects.iter().filter(|e| !e.is_added && balances(action, &add, e)) {
            let (predicate, arguments) = &self.task.facts[delete.fact as usize];
            if candidate.iter().any(|part| part.predicate == *predicate) || arguments.len() > key.len() + 1 {
                continue;
            }
            let mut orders = Vec::new();
            assignments(key, arguments, &mut Vec::new(), &mut orders);
            for order in orders {
                let counted = (0..arguments.len()).find(|at| !order.contains(at));
                let mut candidate = candidate.clone();
                candidate.push(Part { predicate: *predicate, order, counted });
                refined.push(candidate);
            }
        }
        refined
    }

    /// Returns the groups of a candidate of which at most one fact holds initially.
    fn instances(&self, candidate: &Candidate) -> Vec<Group> {
        let mut groups: AHashMap<Key, Vec<Fact>> = AHashMap::new();
        for part in candidate {
            for &fact in self.of.get(&part.predicate).into_iter().flatten() {
                let (_, arguments) = &self.task.facts[fact as usize];
                groups.entry(part.key(arguments)).or_default().push(fact);
            }
        }
        let is_group = |(_, facts): &(Key, Vec<Fact>)| {
            let holding = |start: &Vec<bool>| facts.iter().filter(|&&fact| start[fact as usize]).count();
            facts.len() > 1 && self.task.starts.iter().all(|start| holding(start) < 2)
        };
        let group = |(key, mut facts): (Key, Vec<Fact>)| {
            facts.sort_unstable();
            let counted = if candidate.len() == 1 { candidate[0].counted } else { None };
            let predicates = candidate.iter().map(|part| part.predicate).collect();
            Group { facts, predicates, parameters: key.to_vec(), counted, has_none: false }
        };
        let mut all: Vec<_> = groups.into_iter().filter(is_group).collect();
        all.sort_unstable();
        all.into_iter().map(group).collect()
    }
}

/// A reason against a candidate.
enum Fault {
    /// An action adds two facts of a group.
    TooHeavy,
    /// An action adds a fact of a group, and deletes none for it.
    Unbalanced(GroundEffect, Key),
}

/// Returns whether a fact holds whenever an effect applies.
fn requires(action: &GroundAction, effect: &GroundEffect, fact: Fact) -> bool {
    action.precondition.required().chain(effect.condition.required()).any(|required| required == fact)
}

/// Returns whether a deletion happens whenever an addition does, and its fact held before.
fn balances(action: &GroundAction, add: &GroundEffect, delete: &GroundEffect) -> bool {
    let is_given =
        |part: &Ground| action.precondition.parts().contains(part) || add.condition.parts().contains(part);
    requires(action, add, delete.fact) && delete.condition.parts().iter().all(is_given)
}

/// Returns whether two conditions contain opposite facts.
fn excludes(one: &Ground, other: &Ground) -> bool {
    one.parts().iter().any(|part| match part {
        Ground::Fact(fact, holds) => other.parts().contains(&Ground::Fact(*fact, !holds)),
        _ => false,
    })
}

/// Lists the ways in which the parameters are arguments of an atom, with at most one argument left.
fn assignments(key: &[Object], arguments: &[Object], order: &mut Vec<usize>, all: &mut Vec<Vec<usize>>) {
    let Some(&object) = key.get(order.len()) else {
        if arguments.len() <= key.len() + 1 {
            all.push(order.clone());
        }
        return;
    };
    for at in (0..arguments.len()).filter(|&at| arguments[at] == object) {
        if !order.contains(&at) {
            order.push(at);
            assignments(key, arguments, order, all);
            order.pop();
        }
    }
}

/// Chooses the largest group again and again; the facts that are left get a group of their own.
fn cover(task: &GroundTask, mut found: Vec<Group>) -> Vec<Group> {
    let mut heap: BinaryHeap<(usize, Reverse<(usize, usize)>)> = found
        .iter()
        .enumerate()
        .map(|(at, group)| (group.facts.len(), Reverse((group.predicates.len(), at))))
        .collect();
    let mut is_covered = vec![false; task.facts.len()];
    let mut groups = Vec::new();
    while let Some((size, Reverse((parts, at)))) = heap.pop() {
        let group = &mut found[at];
        group.facts.retain(|&fact| !is_covered[fact as usize]);
        let left = group.facts.len();
        if left == size {
            group.facts.iter().for_each(|&fact| is_covered[fact as usize] = true);
            let facts = std::mem::take(&mut group.facts);
            groups.push(Group {
                facts,
                predicates: group.predicates.clone(),
                parameters: group.parameters.clone(),
                ..*group
            });
        } else if left > 1 {
            heap.push((left, Reverse((parts, at))));
        }
    }
    for (fact, _) in (0..).zip(&is_covered).filter(|(_, is)| !**is) {
        let (predicate, arguments) = task.facts[fact as usize].clone();
        groups.push(Group {
            facts: vec![fact],
            predicates: vec![predicate],
            parameters: arguments,
            counted: None,
            has_none: false,
        });
    }
    // In the order of the facts, which is that of the text.
    groups.sort_unstable_by_key(|group| group.facts[0]);
    groups
}

/// Finds the groups of which no fact may hold: initially, or after a deletion without an addition.
fn mark_none(task: &GroundTask, group_of: &[usize], groups: &mut [Group]) {
    for group in groups.iter_mut() {
        let holds = |start: &Vec<bool>| group.facts.iter().any(|&fact| start[fact as usize]);
        group.has_none = !task.starts.iter().all(holds);
    }
    let mut adds: AHashMap<usize, Vec<&Ground>> = AHashMap::new();
    for outcome in task.actions.iter().flat_map(|action| &action.outcomes) {
        adds.clear();
        for add in outcome.effects.iter().filter(|effect| effect.is_added) {
            adds.entry(group_of[add.fact as usize]).or_default().push(&add.condition);
        }
        for delete in outcome.effects.iter().filter(|effect| !effect.is_added) {
            let number = group_of[delete.fact as usize];
            let replaces = |add: &&Ground| **add == Ground::True || **add == delete.condition;
            let is_replaced = adds.get(&number).is_some_and(|adds| adds.iter().any(replaces));
            groups[number].has_none |= !is_replaced;
        }
    }
}
