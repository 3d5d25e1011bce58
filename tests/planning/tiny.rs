//! An engine of plain vectors, each operator word by word as the trait states it.

use std::sync::Arc;

use meliora::engine::{Algebra, Count, EdgeLabels, Engine, ProgressSink, Region, Settings, Usage};
use meliora::error::Result;
use meliora::model::expr::ExprPool;
use meliora::model::predicate::{Predicate, Predicates};
use meliora::model::step::Choice;
use meliora::model::value::Value;
use meliora::model::{State, VarId};

/// For each state and choice the successors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Mdp(pub(crate) Vec<Vec<Vec<usize>>>);

impl Mdp {
    /// Sorts successors, drops doubles, gives deadlock states their self-loop.
    pub(crate) fn new(mut choices: Vec<Vec<Vec<usize>>>) -> Self {
        for (s, list) in choices.iter_mut().enumerate() {
            for successors in list.iter_mut() {
                successors.sort_unstable();
                successors.dedup();
            }
            if list.is_empty() {
                list.push(vec![s]);
            }
        }
        Mdp(choices)
    }
}

#[derive(Clone)]
pub(crate) struct Tiny {
    pub(crate) mdp: Mdp,
    states: Bits,
    choices: Pairs,
    targets: Vec<Vec<bool>>,
    names: Vec<Predicate>,
    settings: Settings,
}

type Bits = Vec<bool>;
type Pairs = Vec<Vec<bool>>;

impl Tiny {
    pub(crate) fn new(mdp: Mdp, targets: &[Vec<usize>]) -> Self {
        let n = mdp.0.len();
        // Any expressions will do as names of the targets.
        let mut pool = ExprPool::default();
        let names: Vec<_> = (0..targets.len()).map(|i| pool.value(Value::Int(i as i64))).collect();
        let pool = Predicates::of(pool.into());
        let names = names.into_iter().map(|name| pool.get(name)).collect();
        let targets = targets.iter().map(|t| (0..n).map(|s| t.contains(&s)).collect()).collect();
        let choices = mdp.0.iter().map(|list| vec![true; list.len()]).collect();
        Tiny { states: vec![true; n], choices, mdp, targets, names, settings: Settings::default() }
    }

    /// Sets who can cancel the work: at fixpoints, and when states are counted.
    pub(crate) fn with_sink(self, sink: Arc<dyn ProgressSink>) -> Self {
        Tiny { settings: Settings { sink, ..self.settings }, ..self }
    }

    pub(crate) fn target(&self, objective: usize) -> Predicate {
        self.names[objective].clone()
    }

    fn choices_where(&self, holds: impl Fn(usize, usize) -> bool) -> Pairs {
        let row = |(s, list): (usize, &Vec<Vec<usize>>)| (0..list.len()).map(|a| holds(s, a)).collect();
        self.mdp.0.iter().enumerate().map(row).collect()
    }

    fn successors_of(&self, s: usize, a: usize) -> &[usize] {
        &self.mdp.0[s][a]
    }
}

fn zip(x: &Bits, y: &Bits, op: impl Fn(bool, bool) -> bool) -> Bits {
    x.iter().zip(y).map(|(&x, &y)| op(x, y)).collect()
}

impl Algebra<Bits> for Tiny {
    fn union(&self, x: &Bits, y: &Bits) -> Result<Bits> {
        Ok(zip(x, y, |x, y| x || y))
    }
    fn intersection(&self, x: &Bits, y: &Bits) -> Result<Bits> {
        Ok(zip(x, y, |x, y| x && y))
    }
    fn difference(&self, x: &Bits, y: &Bits) -> Result<Bits> {
        Ok(zip(x, y, |x, y| x && !y))
    }
    fn is_empty(&self, x: &Bits) -> Result<bool> {
        Ok(!x.contains(&true))
    }
    fn same(&self, x: &Bits, y: &Bits) -> Result<bool> {
        Ok(x == y)
    }
    fn count(&self, x: &Bits) -> Result<Count> {
        if let Some(limit) = self.settings.sink.stop() {
            return Err(limit.into());
        }
        Ok(Count::from(x.iter().filter(|&&b| b).count()))
    }
}

impl Algebra<Pairs> for Tiny {
    fn union(&self, c: &Pairs, d: &Pairs) -> Result<Pairs> {
        Ok(self.choices_where(|s, a| c[s][a] || d[s][a]))
    }
    fn intersection(&self, c: &Pairs, d: &Pairs) -> Result<Pairs> {
        Ok(self.choices_where(|s, a| c[s][a] && d[s][a]))
    }
    fn difference(&self, c: &Pairs, d: &Pairs) -> Result<Pairs> {
        Ok(self.choices_where(|s, a| c[s][a] && !d[s][a]))
    }
    fn is_empty(&self, c: &Pairs) -> Result<bool> {
        Ok(!c.iter().flatten().any(|&b| b))
    }
    fn same(&self, c: &Pairs, d: &Pairs) -> Result<bool> {
        Ok(c == d)
    }
    fn count(&self, c: &Pairs) -> Result<Count> {
        Ok(Count::from(c.iter().flatten().filter(|&&b| b).count()))
    }
}

impl Engine for Tiny {
    type States = Bits;
    type Choices = Pairs;

    fn all_states(&self) -> Bits {
        self.states.clone()
    }
    fn no_states(&self) -> Bits {
        vec![false; self.mdp.0.len()]
    }
    fn initial_states(&self) -> Bits {
        (0..self.mdp.0.len()).map(|s| s == 0).collect()
    }
    fn deadlock_states(&self) -> Bits {
        self.no_states()
    }
    fn states_where(&self, predicate: &Predicate) -> Result<Bits> {
        Ok(zip(&self.targets[predicate.id().index()], &self.states, |x, y| x && y))
    }
    fn all_choices(&self) -> Pairs {
        self.choices.clone()
    }
    fn restricted_to(&self, region: &Region<Bits, Pairs>) -> Result<Self> {
        Ok(Tiny { states: region.states.clone(), choices: region.choices.clone(), ..self.clone() })
    }
    fn no_choices(&self) -> Pairs {
        self.choices_where(|_, _| false)
    }

    fn choices_in(&self, c: &Pairs, x: &Bits) -> Result<Pairs> {
        Ok(self.choices_where(|s, a| c[s][a] && x[s]))
    }
    fn sources(&self, c: &Pairs) -> Result<Bits> {
        Ok(c.iter().map(|row| row.contains(&true)).collect())
    }

    fn pre(&self, c: &Pairs, x: &Bits) -> Result<Pairs> {
        Ok(self.choices_where(|s, a| c[s][a] && self.successors_of(s, a).iter().any(|&t| x[t])))
    }
    fn pre_within(&self, c: &Pairs, y: &Bits) -> Result<Pairs> {
        Ok(self.choices_where(|s, a| c[s][a] && self.successors_of(s, a).iter().all(|&t| y[t])))
    }
    fn post(&self, c: &Pairs) -> Result<Bits> {
        let mut entered = self.no_states();
        for (s, row) in c.iter().enumerate() {
            for a in (0..row.len()).filter(|&a| row[a]) {
                self.successors_of(s, a).iter().for_each(|&t| entered[t] = true);
            }
        }
        Ok(entered)
    }

    fn can_reach(&self, target: &Bits, within: &Pairs, edge_labels: &[EdgeLabels<Bits>]) -> Result<Bits> {
        let is_dropped = |s: usize, t: usize| edge_labels.iter().any(|m| m.from[s] && m.dropped[t]);
        let mut reached = target.clone();
        loop {
            let enters = |s: usize, a: usize| {
                within[s][a] && self.successors_of(s, a).iter().any(|&t| reached[t] && !is_dropped(s, t))
            };
            let more: Bits = (0..reached.len())
                .map(|s| reached[s] || (0..within[s].len()).any(|a| enters(s, a)))
                .collect();
            if more == reached {
                return Ok(reached);
            }
            reached = more;
        }
    }

    fn count_model_states(&self, _x: &Bits) -> Result<Option<Count>> {
        Ok(None)
    }
    fn count_transitions(&self, c: &Pairs, x: &Bits) -> Result<Count> {
        let mut count = 0usize;
        for (s, row) in c.iter().enumerate() {
            for a in (0..row.len()).filter(|&a| row[a]) {
                count += self.successors_of(s, a).iter().filter(|&&t| x[t]).count();
            }
        }
        Ok(Count::from(count))
    }

    fn list_states(&self, x: &Bits, limit: usize) -> Result<Vec<State>> {
        Ok((0..x.len()).filter(|&s| x[s]).take(limit).map(|s| vec![s as i64]).collect())
    }
    fn singleton(&self, state: &[i64]) -> Result<Bits> {
        Ok((0..self.mdp.0.len()).map(|s| self.states[s] && s as i64 == state[0]).collect())
    }
    fn slice(&self, fixed: &[(VarId, i64)]) -> Result<Bits> {
        let fits = |s: usize| fixed.iter().all(|&(_, value)| value == s as i64);
        Ok((0..self.mdp.0.len()).map(|s| self.states[s] && fits(s)).collect())
    }
    fn contains(&self, x: &Bits, state: &[i64]) -> Result<bool> {
        Ok(usize::try_from(state[0]).is_ok_and(|s| x.get(s) == Some(&true)))
    }
    fn contains_choice(&self, c: &Pairs, state: &[i64], choice: &Choice) -> Result<bool> {
        Ok(match choice {
            Choice::Combination { synchronisation, .. } => c[state[0] as usize][*synchronisation],
            _ => false,
        })
    }

    fn usage(&self) -> Usage {
        Usage::default()
    }
    fn settings(&self) -> &Settings {
        &self.settings
    }
}
