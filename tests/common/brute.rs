//! A reference implementation of the engine interface: sets as ordered sets of numbers, nested fixpoints.

use meliora::model::value::Value;

use crate::common::prelude::*;

/// A set of states or of choices, by number.
pub(crate) type Set = BTreeSet<usize>;

/// A choice of a state.
pub(crate) struct Pair {
    pub(crate) state: usize,
    pub(crate) choice: Choice,
    pub(crate) successors: Set,
}

/// All states of a scope in the order of their values, with all their choices.
pub(crate) struct Brute {
    pub(crate) states: Vec<State>,
    pub(crate) pairs: Vec<Pair>,
    pub(crate) initial: Set,
    pub(crate) deadlocks: Set,
}

/// All valuations, the first variable slowest.
pub(crate) fn valuations(program: &Program) -> Vec<State> {
    let mut states = vec![vec![]];
    for v in &program.variables {
        let longer = |s: &State| (v.low..=v.high).map(|x| [s.clone(), vec![x]].concat()).collect::<Vec<_>>();
        states = states.iter().flat_map(longer).collect();
    }
    states
}

impl Brute {
    /// Explores a scope by [`Program::steps`]. The error names a state in which something has no meaning.
    pub(crate) fn new(program: &Program, scope: Scope) -> Result<Self, String> {
        let everywhere = valuations(program);
        let starts = |s: &&State| program.pool.eval(program.initial, s) == Ok(Value::Bool(true));
        let initial: BTreeSet<State> = everywhere.iter().filter(starts).cloned().collect();
        let mut work: Vec<State> = match scope {
            Scope::Reachable => initial.iter().cloned().collect(),
            Scope::All => everywhere,
        };
        let mut seen: BTreeSet<State> = work.iter().cloned().collect();
        let mut steps = BTreeMap::new();
        while let Some(state) = work.pop() {
            program.pool.eval(program.initial, &state).map_err(|e| format!("{state:?}: {e:?}"))?;
            let found = program.steps(&state).map_err(|e| format!("{state:?}: {e:?}"))?;
            for (successor, _) in found.iter().flat_map(|s| &s.successors) {
                if seen.insert(successor.clone()) {
                    work.push(successor.clone());
                }
            }
            steps.insert(state, found);
        }
        let states: Vec<State> = seen.into_iter().collect();
        let number = |s: &State| states.binary_search(s).unwrap();
        let mut pairs = Vec::new();
        for (state, found) in &steps {
            for step in found {
                let successors = step.successors.iter().map(|(s, _)| number(s)).collect();
                pairs.push(Pair { state: number(state), choice: step.choice.clone(), successors });
            }
        }
        let deadlocks = pairs.iter().filter(|p| p.choice == Choice::Deadlock).map(|p| p.state).collect();
        Ok(Brute { initial: initial.iter().map(number).collect(), deadlocks, pairs, states })
    }

    /// A model that lists the successors of each state and choice, without initial states.
    pub(crate) fn of_graph(choices: &[Vec<Vec<usize>>]) -> Self {
        let pairs_of = |(state, list): (usize, &Vec<Vec<usize>>)| {
            let pair = |successors: &Vec<usize>| Pair {
                state,
                choice: Choice::Uniform,
                successors: successors.iter().copied().collect(),
            };
            list.iter().map(pair).collect::<Vec<_>>()
        };
        Brute {
            states: (0..choices.len()).map(|s| vec![s as i64]).collect(),
            pairs: choices.iter().enumerate().flat_map(pairs_of).collect(),
            initial: Set::new(),
            deadlocks: Set::new(),
        }
    }

    pub(crate) fn all_states(&self) -> Set {
        (0..self.states.len()).collect()
    }

    pub(crate) fn all_choices(&self) -> Set {
        (0..self.pairs.len()).collect()
    }

    pub(crate) fn states_where(&self, program: &Program, e: ExprId) -> Set {
        let holds = |&s: &usize| program.pool.eval(e, &self.states[s]) == Ok(Value::Bool(true));
        self.all_states().into_iter().filter(holds).collect()
    }

    fn pairs_where(&self, c: &Set, holds: impl Fn(&Pair) -> bool) -> Set {
        c.iter().copied().filter(|&p| holds(&self.pairs[p])).collect()
    }

    pub(crate) fn choices_in(&self, c: &Set, x: &Set) -> Set {
        self.pairs_where(c, |p| x.contains(&p.state))
    }

    pub(crate) fn sources(&self, c: &Set) -> Set {
        c.iter().map(|&p| self.pairs[p].state).collect()
    }

    pub(crate) fn pre(&self, c: &Set, x: &Set) -> Set {
        self.pairs_where(c, |p| !p.successors.is_disjoint(x))
    }

    pub(crate) fn pre_within(&self, c: &Set, y: &Set) -> Set {
        self.pairs_where(c, |p| p.successors.is_subset(y))
    }

    pub(crate) fn post(&self, c: &Set) -> Set {
        c.iter().flat_map(|&p| self.pairs[p].successors.iter().copied()).collect()
    }

    pub(crate) fn count_transitions(&self, c: &Set, x: &Set) -> usize {
        c.iter().map(|&p| self.pairs[p].successors.intersection(x).count()).sum()
    }

    /// The limit of `f`, f(f), … from `x`.
    fn fixpoint(mut x: Set, f: impl Fn(&Set) -> Set) -> Set {
        loop {
            let next = f(&x);
            if next == x {
                return x;
            }
            x = next;
        }
    }

    /// μX. T ∪ { s : some (s,a) ∈ C has an edge into X that is not dropped }
    pub(crate) fn can_reach(&self, target: &Set, within: &Set, dropped: &[(Set, Set)]) -> Set {
        let enters = |p: &Pair, x: &Set| {
            let is_dropped =
                |to: &usize| dropped.iter().any(|(from, into)| from.contains(&p.state) && into.contains(to));
            p.successors.intersection(x).any(|to| !is_dropped(to))
        };
        Self::fixpoint(Set::new(), |x| &self.sources(&self.pairs_where(within, |p| enters(p, x))) | target)
    }

    /// νZ. X ∩ { s : some (s,a) ∈ C has all successors in Z }, with those pairs.
    pub(crate) fn stay_within(&self, x: &Set, within: &Set) -> (Set, Set) {
        let good = |z: &Set| self.choices_in(&self.pre_within(within, z), z);
        let states = Self::fixpoint(x.clone(), |z| &self.sources(&good(z)) & x);
        let choices = good(&states);
        (states, choices)
    }

    /// The kept edges of a pair: to the targets of goal edges, and to all others.
    fn kept(&self, pair: &Pair, labels: &[EdgeLabels<Set>]) -> [Set; 2] {
        let own = labels.iter().find(|labels| labels.from.contains(&pair.state)).unwrap();
        let kept = &pair.successors - &own.dropped;
        [&kept & &own.goal, &kept - &own.goal]
    }

    /// νY. μX. { s : some (s,a) ∈ C has only goal edges and edges into Y, and a goal edge or an edge into X }
    /// without dropped edges, with the pairs of C that stay inside; and the X of the first Y, all states.
    pub(crate) fn almost_surely_win(&self, within: &Set, labels: &[EdgeLabels<Set>]) -> (Set, Set, Set) {
        let staying = |y: &Set| {
            let stays = |p: &Pair| self.kept(p, labels)[1].is_subset(y);
            self.choices_in(&self.pairs_where(within, stays), y)
        };
        let wins = |p: &Pair, x: &Set| {
            let [goal, plain] = self.kept(p, labels);
            !goal.is_empty() || !plain.is_disjoint(x)
        };
        let inner = |y: &Set| {
            let staying = staying(y);
            Self::fixpoint(Set::new(), |x| self.sources(&self.pairs_where(&staying, |p| wins(p, x))))
        };
        let states = Self::fixpoint(self.all_states(), inner);
        (states.clone(), staying(&states), inner(&self.all_states()))
    }

    /// The states outside of the least X ⊇ L that has every state outside of W of which each pair of C has a plain edge
    /// into X, with the pairs of C that have no such edge.
    pub(crate) fn without_attractor(
        &self,
        lost: &Set,
        won: &Set,
        (within, labels): (&Set, &[EdgeLabels<Set>]),
    ) -> (Set, Set) {
        let plain =
            |p: &Pair| if labels.is_empty() { p.successors.clone() } else { self.kept(p, labels)[1].clone() };
        let avoiding = |x: &Set| self.pairs_where(within, |p| plain(p).is_disjoint(x));
        let stuck = |x: &Set| &(&self.all_states() - &self.sources(&avoiding(x))) - won;
        let lost = Self::fixpoint(lost.clone(), |x| x | &stuck(x));
        (&self.all_states() - &lost, avoiding(&lost))
    }

    /// νY. μX. T ∪ { s : some (s,a) ∈ C has all successors in Y and one in X }, with the pairs of C
    /// outside T that stay inside.
    pub(crate) fn almost_surely_reach(&self, target: &Set, within: &Set) -> (Set, Set) {
        let step = |y: &Set, x: &Set| {
            let good = self.pre(&self.pre_within(within, y), x);
            &self.sources(&good) | target
        };
        let states = Self::fixpoint(self.all_states(), |y| Self::fixpoint(Set::new(), |x| step(y, x)));
        let staying = self.pre_within(within, &states);
        let choices = self.choices_in(&staying, &(&states - target));
        (states, choices)
    }
}
