//! The outcomes of an effect: all combinations of its alternatives. A part whose condition the
//! facts exclude that no action changes has no effect.

use std::rc::Rc;

use ahash::AHashMap;
use num_traits::{One, Zero};

use super::reach::{every, may_hold};
use super::{Atoms, GroundAtom};
use crate::task::{Condition, Effect, Object, Term};
use meliora_base::exact::Ratio;

/// Maximum number of outcomes of an action. Combinations of alternatives multiply, so a short text can
/// ask for any number.
pub(super) const MOST_OUTCOMES: usize = 1 << 16;

/// The addition or deletion of a ground atom under conditions.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Change {
    pub(super) atom: GroundAtom,
    pub(super) is_added: bool,
    /// Without free variables, their quantified ones numbered from 0. Shared by all changes under them.
    pub(super) conditions: Rc<Vec<Condition>>,
}

/// The outcomes of an effect.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Outcomes {
    all: Vec<Vec<Rc<Change>>>,
    /// Their probabilities; `None` if all are equal.
    weights: Option<Vec<Ratio>>,
}

impl Outcomes {
    /// Returns the outcomes of an effect; `None` if there are too many.
    pub(super) fn new(
        atoms: &Atoms,
        effect: &Effect,
        values: &mut Vec<Object>,
        conditions: &Rc<Vec<Condition>>,
    ) -> Option<Self> {
        match effect {
            Effect::Literal(atom, is_added) => {
                let arguments = atom.arguments.iter().map(|term| term.object(values)).collect();
                let (atom, is_added) = ((atom.predicate, arguments), *is_added);
                let conditions = Rc::clone(conditions);
                Some(Self::one(vec![Rc::new(Change { atom, is_added, conditions })]))
            }
            Effect::Earn(_) => Some(Self::one(Vec::new())),
            Effect::And(parts) => {
                let mut product = Self::one(Vec::new());
                for part in parts {
                    product = product.times(Self::new(atoms, part, values, conditions)?)?;
                }
                Some(product.distinct())
            }
            Effect::When(condition, _) if atoms.excludes(condition, values) => Some(Self::one(Vec::new())),
            Effect::When(condition, inner) => {
                let mut both = Vec::clone(conditions);
                let objects: Vec<Term> = values.iter().copied().map(Term::Object).collect();
                match condition.with(&objects, 0) {
                    Condition::And(parts) => both.extend(parts),
                    other => both.push(other),
                }
                both.sort_unstable();
                both.dedup();
                Self::new(atoms, inner, values, &Rc::new(both))
            }
            Effect::All(domains, inner) => {
                let mut product = Some(Self::one(Vec::new()));
                every(domains, values, &mut |values| {
                    let part = Self::new(atoms, inner, &mut values.to_vec(), conditions);
                    product = product.take().and_then(|product| product.times(part?));
                });
                product.map(Self::distinct)
            }
            Effect::OneOf(parts) => {
                let parts: Option<Vec<Self>> =
                    parts.iter().map(|part| Self::new(atoms, part, values, conditions)).collect();
                Self::one_of(parts?)
            }
            Effect::Probably(parts) => Self::probably(atoms, parts, values, conditions),
        }
    }

    fn one(changes: Vec<Rc<Change>>) -> Self {
        Outcomes { all: vec![changes], weights: None }
    }

    /// Returns the outcomes with their probabilities.
    pub(super) fn with_probabilities(self) -> impl Iterator<Item = (Ratio, Vec<Rc<Change>>)> {
        let weights = self.probabilities();
        weights.into_iter().zip(self.all)
    }

    fn probabilities(&self) -> Vec<Ratio> {
        match &self.weights {
            Some(weights) => weights.clone(),
            None => vec![Ratio::new(1.into(), self.all.len().into()); self.all.len()],
        }
    }

    /// Returns all combinations with other outcomes.
    fn times(mut self, other: Self) -> Option<Self> {
        if let ([only], None) = (other.all.as_slice(), &other.weights) {
            self.all.iter_mut().for_each(|changes| changes.extend_from_slice(only));
            return Some(self);
        }
        if self.all.len().saturating_mul(other.all.len()) > MOST_OUTCOMES {
            return None;
        }
        let is_uniform = self.weights.is_none() && other.weights.is_none();
        let weights = (!is_uniform).then(|| {
            let (left, right) = (self.probabilities(), other.probabilities());
            left.iter().flat_map(|x| right.iter().map(move |y| x * y)).collect()
        });
        let joined =
            |left: &Vec<Rc<Change>>, right: &Vec<Rc<Change>>| left.iter().chain(right).cloned().collect();
        let all = self.all.iter().flat_map(|left| other.all.iter().map(move |right| joined(left, right)));
        Some(Outcomes { all: all.collect(), weights })
    }

    /// Sorts the changes of each outcome; equal outcomes count once, or with the sum of their weights.
    fn distinct(mut self) -> Self {
        for changes in &mut self.all {
            changes.sort_unstable();
            changes.dedup();
        }
        if self.all.len() < 2 {
            return self;
        }
        let mut known: AHashMap<Vec<Rc<Change>>, usize> = AHashMap::new();
        let (mut all, mut sums) = (Vec::new(), Vec::new());
        let weights = self.weights.as_ref().map(|_| self.probabilities());
        for (at, changes) in self.all.into_iter().enumerate() {
            let next = known.len();
            let position = *known.entry(changes.clone()).or_insert(next);
            if position == next {
                all.push(changes);
                sums.push(Ratio::zero());
            }
            if let Some(weights) = &weights {
                sums[position] += &weights[at];
            }
        }
        Outcomes { all, weights: weights.map(|_| sums) }
    }

    /// Returns the union; each outcome, or each part with probabilities of its own, is equally likely.
    fn one_of(parts: Vec<Self>) -> Option<Self> {
        let mut distinct: Vec<Self> = Vec::new();
        for part in parts.into_iter().map(Self::distinct) {
            if !distinct.contains(&part) {
                distinct.push(part);
            }
        }
        if distinct.iter().map(|part| part.all.len()).sum::<usize>() > MOST_OUTCOMES {
            return None;
        }
        let share = Ratio::new(1.into(), distinct.len().into());
        let is_uniform = distinct.iter().all(|part| part.weights.is_none());
        let weights = (!is_uniform)
            .then(|| distinct.iter().flat_map(Self::probabilities).map(|weight| weight * &share).collect());
        let all = distinct.into_iter().flat_map(|part| part.all).collect();
        Some(Outcomes { all, weights }.distinct())
    }

    /// Returns the effects with their probabilities; with what remains of 1 nothing changes.
    fn probably(
        atoms: &Atoms,
        parts: &[(Ratio, Effect)],
        values: &mut Vec<Object>,
        conditions: &Rc<Vec<Condition>>,
    ) -> Option<Self> {
        let (mut all, mut weights, mut rest) = (Vec::new(), Vec::new(), Ratio::one());
        for (probability, effect) in parts.iter().filter(|(probability, _)| !probability.is_zero()) {
            let part = Self::new(atoms, effect, values, conditions)?;
            rest -= probability;
            weights.extend(part.probabilities().into_iter().map(|weight| weight * probability));
            all.extend(part.all);
        }
        if !rest.is_zero() {
            all.push(Vec::new());
            weights.push(rest);
        }
        (all.len() <= MOST_OUTCOMES).then(|| Outcomes { all, weights: Some(weights) }.distinct())
    }
}

impl Atoms {
    /// Returns whether a condition never holds, by the facts that nothing changes.
    fn excludes(&self, condition: &Condition, values: &mut Vec<Object>) -> bool {
        !may_hold(condition, values, &|predicate, row, is_positive| {
            self.changes[predicate] || self.get(predicate, row).is_some() == is_positive
        })
    }
}
