//! An engine over [`Brute`]: sets of numbers, and each operator as the book defines it.

use meliora::engine::Usage;
use meliora::error::Result;
use meliora::model::value::Value;

use crate::common::brute::Set;
use crate::common::prelude::*;

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

/// The pairs of a state and a choice are numbered in the order of the states.
#[derive(Clone)]
pub(crate) struct Tiny {
    brute: Arc<Brute>,
    states: Set,
    choices: Set,
    targets: Vec<Set>,
    names: Vec<Predicate>,
    settings: Settings,
}

impl Tiny {
    pub(crate) fn new(mdp: &Mdp, targets: &[Vec<usize>]) -> Self {
        // Any expressions will do as names of the targets.
        let mut pool = ExprPool::default();
        let names: Vec<_> = (0..targets.len()).map(|i| pool.value(Value::Int(i as i64))).collect();
        let pool = Predicates::new(pool.into());
        let names = names.into_iter().map(|name| pool.get(name)).collect();
        let targets = targets.iter().map(|t| t.iter().copied().collect()).collect();
        let brute = Brute::of_graph(&mdp.0);
        let (states, choices) = (brute.all_states(), brute.all_choices());
        Tiny { brute: brute.into(), states, choices, targets, names, settings: Settings::default() }
    }

    /// Sets who can cancel the work: at fixpoints, and when sets are counted.
    pub(crate) fn with_sink(self, sink: Arc<dyn ProgressSink>) -> Self {
        Tiny { settings: Settings { sink, ..self.settings }, ..self }
    }

    pub(crate) fn target(&self, objective: usize) -> Predicate {
        self.names[objective].clone()
    }

    /// The positions of the choices of each state that are in a set.
    pub(crate) fn rows(&self, c: &Set) -> Vec<Vec<usize>> {
        let mut rows = vec![Vec::new(); self.brute.states.len()];
        let (mut state, mut first) = (0, 0);
        for (number, pair) in self.brute.pairs.iter().enumerate() {
            if pair.state != state {
                (state, first) = (pair.state, number);
            }
            if c.contains(&number) {
                rows[state].push(number - first);
            }
        }
        rows
    }
}

impl Algebra<Set> for Tiny {
    fn union(&self, x: &Set, y: &Set) -> Result<Set> {
        Ok(x | y)
    }
    fn intersection(&self, x: &Set, y: &Set) -> Result<Set> {
        Ok(x & y)
    }
    fn difference(&self, x: &Set, y: &Set) -> Result<Set> {
        Ok(x - y)
    }
    fn is_empty(&self, x: &Set) -> Result<bool> {
        Ok(x.is_empty())
    }
    fn same(&self, x: &Set, y: &Set) -> Result<bool> {
        Ok(x == y)
    }
    fn count(&self, x: &Set) -> Result<Count> {
        if let Some(limit) = self.settings.sink.stop() {
            return Err(limit.into());
        }
        Ok(Count::from(x.len()))
    }
}

impl Engine for Tiny {
    type States = Set;
    type Choices = Set;

    fn all_states(&self) -> Set {
        self.states.clone()
    }
    fn no_states(&self) -> Set {
        Set::new()
    }
    fn initial_states(&self) -> Set {
        Set::from([0])
    }
    fn deadlock_states(&self) -> Set {
        Set::new()
    }
    fn states_where(&self, predicate: &Predicate) -> Result<Set> {
        Ok(&self.targets[predicate.id().index()] & &self.states)
    }
    fn all_choices(&self) -> Set {
        self.choices.clone()
    }
    fn restricted_to(&self, region: &Region<Set, Set>) -> Result<Self> {
        Ok(Tiny { states: region.states.clone(), choices: region.choices.clone(), ..self.clone() })
    }
    fn no_choices(&self) -> Set {
        Set::new()
    }

    fn choices_in(&self, c: &Set, x: &Set) -> Result<Set> {
        Ok(self.brute.choices_in(c, x))
    }
    fn sources(&self, c: &Set) -> Result<Set> {
        Ok(self.brute.sources(c))
    }
    fn pre(&self, c: &Set, x: &Set) -> Result<Set> {
        Ok(self.brute.pre(c, x))
    }
    fn pre_within(&self, c: &Set, y: &Set) -> Result<Set> {
        Ok(self.brute.pre_within(c, y))
    }
    fn post(&self, c: &Set) -> Result<Set> {
        Ok(self.brute.post(c))
    }
    fn can_reach(&self, target: &Set, within: &Set, labels: &[EdgeLabels<Set>]) -> Result<Set> {
        let dropped: Vec<_> = labels.iter().map(|m| (m.from.clone(), m.dropped.clone())).collect();
        Ok(self.brute.can_reach(target, within, &dropped))
    }

    fn count_model_states(&self, _x: &Set) -> Result<Option<Count>> {
        Ok(None)
    }
    fn count_transitions(&self, c: &Set, x: &Set) -> Result<Count> {
        Ok(Count::from(self.brute.count_transitions(c, x)))
    }

    fn list_states(&self, x: &Set, limit: usize) -> Result<Vec<State>> {
        Ok(x.iter().take(limit).map(|&s| vec![s as i64]).collect())
    }
    fn singleton(&self, state: &[i64]) -> Result<Set> {
        Ok(self.states.iter().copied().filter(|&s| s as i64 == state[0]).collect())
    }
    fn slice(&self, fixed: &[(VarId, i64)]) -> Result<Set> {
        let fits = |s: &usize| fixed.iter().all(|&(_, value)| value == *s as i64);
        Ok(self.states.iter().copied().filter(fits).collect())
    }
    fn contains(&self, x: &Set, state: &[i64]) -> Result<bool> {
        Ok(usize::try_from(state[0]).is_ok_and(|s| x.contains(&s)))
    }
    fn contains_choice(&self, c: &Set, state: &[i64], choice: &Choice) -> Result<bool> {
        Ok(match choice {
            Choice::Combination { synchronisation, .. } => {
                self.rows(c)[state[0] as usize].contains(synchronisation)
            }
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
