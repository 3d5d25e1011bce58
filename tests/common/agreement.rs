//! Compares every operation of an engine with the reference implementation.

use meliora::model::value::Value;

use super::brute::{Brute, Set};
use crate::common::prelude::*;

/// Compares an engine with the reference, on sets drawn from `predicates`.
pub(crate) fn check<E: Engine>(engine: &E, program: &Program, brute: &Brute, predicates: &[ExprId]) {
    let both = Both { engine, brute };
    both.states("all", &engine.all_states(), &brute.all_states());
    both.states("none", &engine.no_states(), &Set::new());
    both.states("initial", &engine.initial_states(), &brute.initial);
    both.states("deadlocks", &engine.deadlock_states(), &brute.deadlocks);
    both.drawing(program);
    both.choices("all", &engine.all_choices(), &brute.all_choices());
    both.choices("none", &engine.no_choices(), &Set::new());
    let sets: Vec<(E::States, Set)> = predicates
        .iter()
        .map(|&e| (engine.states_where(&program.predicate(e)).unwrap(), brute.states_where(program, e)))
        .collect();
    for (x, brute_x) in &sets {
        both.states("where", x, brute_x);
        both.images(x, brute_x);
        for y in &sets {
            both.pair((x, brute_x), (&y.0, &y.1));
        }
    }
}

struct Both<'a, E: Engine> {
    engine: &'a E,
    brute: &'a Brute,
}

impl<E: Engine> Both<'_, E> {
    fn states(&self, what: &str, x: &E::States, expected: &Set) {
        let (engine, brute) = (self.engine, self.brute);
        let listed: Vec<_> = expected.iter().map(|&s| brute.states[s].clone()).collect();
        assert_eq!(engine.list_states(x, usize::MAX).unwrap(), listed, "states: {what}");
        let some = listed.len() / 2;
        assert_eq!(engine.list_states(x, some).unwrap(), listed[..some], "first states: {what}");
        assert_eq!(engine.count(x).unwrap(), expected.len().into(), "{what}");
        assert_eq!(engine.is_empty(x).unwrap(), expected.is_empty(), "{what}");
        let mut union = engine.no_states();
        for (number, state) in brute.states.iter().enumerate() {
            let is_in = expected.contains(&number);
            assert_eq!(engine.contains(x, state).unwrap(), is_in, "{what}: {state:?}");
            if is_in {
                union = engine.union(&union, &engine.singleton(state).unwrap()).unwrap();
            }
        }
        assert!(engine.same(x, &union).unwrap(), "{what}");
    }

    /// The states of a `dtmc` in which several choices are enabled, if the engine has counted them.
    fn drawing(&self, program: &Program) {
        let Some(found) = self.engine.drawing_states() else { return };
        let overlap = program.overlap();
        let draws = |s: &usize| overlap.eval(&self.brute.states[*s]) == Ok(Value::Bool(true));
        let draws = self.brute.all_states().into_iter().filter(draws).count();
        assert_eq!(found, if program.kind == ModelKind::Dtmc { draws } else { 0 }.into(), "drawing");
    }

    fn choices(&self, what: &str, c: &E::Choices, expected: &Set) {
        let (engine, brute) = (self.engine, self.brute);
        for (number, pair) in brute.pairs.iter().enumerate() {
            let state = &brute.states[pair.state];
            let found = engine.contains_choice(c, state, &pair.choice).unwrap();
            assert_eq!(found, expected.contains(&number), "choices: {what}: {state:?} {:?}", pair.choice);
        }
        assert_eq!(engine.count(c).unwrap(), expected.len().into(), "choices: {what}");
        self.states(what, &engine.sources(c).unwrap(), &brute.sources(expected));
        self.states(what, &engine.can_choose(c).unwrap(), &brute.sources(expected));
        self.states(what, &engine.post(c).unwrap(), &brute.post(expected));
        let all = (engine.all_states(), brute.all_states());
        let count = engine.count_transitions(c, &all.0).unwrap();
        assert_eq!(count, brute.count_transitions(expected, &all.1).into(), "transitions: {what}");
    }

    fn images(&self, x: &E::States, brute_x: &Set) {
        let (engine, brute) = (self.engine, self.brute);
        let some = engine.pre(&engine.all_choices(), x).unwrap();
        self.choices("pre", &some, &brute.pre(&brute.all_choices(), brute_x));
        let every = engine.pre_within(&engine.all_choices(), x).unwrap();
        self.choices("pre_within", &every, &brute.pre_within(&brute.all_choices(), brute_x));
        let within = engine.choices_in(&engine.all_choices(), x).unwrap();
        self.choices("in", &within, &brute.choices_in(&brute.all_choices(), brute_x));
    }

    fn pair(&self, (x, brute_x): (&E::States, &Set), (y, brute_y): (&E::States, &Set)) {
        let (engine, brute) = (self.engine, self.brute);
        self.states("union", &engine.union(x, y).unwrap(), &(brute_x | brute_y));
        self.states("intersection", &engine.intersection(x, y).unwrap(), &(brute_x & brute_y));
        self.states("difference", &engine.difference(x, y).unwrap(), &(brute_x - brute_y));
        assert_eq!(engine.same(x, y).unwrap(), brute_x == brute_y);
        // Two sets of choices of some variety.
        let c = engine.pre(&engine.all_choices(), x).unwrap();
        let d = engine.choices_in(&engine.all_choices(), y).unwrap();
        let brute_c = brute.pre(&brute.all_choices(), brute_x);
        let brute_d = brute.choices_in(&brute.all_choices(), brute_y);
        let within = engine.union(&c, &d).unwrap();
        let brute_within = &brute_c | &brute_d;
        self.choices("union", &within, &brute_within);
        let stuck = engine.cannot_choose(y, &within).unwrap();
        self.states("cannot choose", &stuck, &(brute_y - &brute.sources(&brute_within)));
        self.choices("common", &engine.intersection(&c, &d).unwrap(), &(&brute_c & &brute_d));
        self.choices("without", &engine.difference(&c, &d).unwrap(), &(&brute_c - &brute_d));
        for (pairs, brute_pairs) in [(&within, &brute_within), (&d, &brute_d)] {
            self.choices("pre", &engine.pre(pairs, x).unwrap(), &brute.pre(brute_pairs, brute_x));
            let entering = brute.sources(&brute.pre(brute_pairs, brute_x));
            self.states("can_enter", &engine.can_enter(pairs, x).unwrap(), &entering);
            let staying = engine.pre_within(pairs, x).unwrap();
            self.choices("pre_within", &staying, &brute.pre_within(brute_pairs, brute_x));
        }
        let count = engine.count_transitions(&within, x).unwrap();
        assert_eq!(count, brute.count_transitions(&brute_within, brute_x).into(), "transitions into x");
        self.fixpoints((x, brute_x), (y, brute_y), (&within, &brute_within));
        self.games((x, brute_x), (y, brute_y), (&within, &brute_within));
    }

    /// Games on edges: steps from Y into X, and from the rest into both, win. Other steps from Y out of Y are
    /// plain, dropped, or their choices are barred.
    fn games(
        &self,
        (x, brute_x): (&E::States, &Set),
        (y, brute_y): (&E::States, &Set),
        (within, brute_within): (&E::Choices, &Set),
    ) {
        let (engine, brute) = (self.engine, self.brute);
        let (all, none) = (engine.all_choices(), engine.no_states());
        let rest = engine.difference(&engine.all_states(), y).unwrap();
        let brute_rest = &brute.all_states() - brute_y;
        let (other, brute_other) = (engine.difference(&rest, x).unwrap(), &brute_rest - brute_x);
        let both = engine.intersection(x, y).unwrap();
        let labels = |dropped: &E::States, barred: Vec<(E::States, E::States)>| {
            let first = EdgeLabels::new(y.clone(), x.clone(), dropped.clone());
            [EdgeLabels { barred, ..first }, EdgeLabels::new(rest.clone(), both.clone(), none.clone())]
        };
        let brute_labels = |dropped: &Set| {
            let first = EdgeLabels::new(brute_y.clone(), brute_x.clone(), dropped.clone());
            [first, EdgeLabels::new(brute_rest.clone(), brute_x & brute_y, Set::new())]
        };
        let (plain, brute_plain) = (labels(&none, Vec::new()), brute_labels(&Set::new()));
        let barring = labels(&none, vec![(y.clone(), other.clone())]);
        let without = |gone| engine.difference(&all, &engine.choices_in(&gone, y).unwrap()).unwrap();
        let brute_without = |gone| &brute.all_choices() - &brute.choices_in(&gone, brute_y);
        let barred = without(engine.pre(&all, &other).unwrap());
        let brute_barred = brute_without(brute.pre(&brute.all_choices(), &brute_other));
        let kept = without(engine.pre_within(&all, &other).unwrap());
        let brute_kept = brute_without(brute.pre_within(&brute.all_choices(), &brute_other));
        let one = [EdgeLabels::new(engine.all_states(), x.clone(), none.clone())];
        let brute_one = [EdgeLabels::new(brute.all_states(), brute_x.clone(), Set::new())];
        let dropping = labels(&other, Vec::new());
        let brute_dropping = brute_labels(&brute_other);
        for (what, c, labels, brute_c, brute_labels) in [
            ("win", &all, &plain[..], &brute.all_choices(), &brute_plain[..]),
            ("win by some", within, &plain, brute_within, &brute_plain),
            ("win in one set", &all, &one, &brute.all_choices(), &brute_one),
            ("win in one set by some", within, &one, brute_within, &brute_one),
            ("win, barred", &barred, &barring, &brute_barred, &brute_plain),
            ("win, dropped", &kept, &dropping, &brute_kept, &brute_dropping),
        ] {
            let start = Region { states: engine.all_states(), choices: c.clone() };
            let won = engine.almost_surely_win(start, labels).unwrap();
            let (states, choices, possible) = brute.almost_surely_win(brute_c, brute_labels);
            self.states(what, &won.region.states, &states);
            self.choices(what, &won.region.choices, &choices);
            won.possible.iter().for_each(|found| self.states(what, found, &possible));
            let stuck = engine.difference(&engine.all_states(), &engine.sources(c).unwrap()).unwrap();
            let outside = engine.difference(x, y).unwrap();
            let lost = engine.union(&stuck, &outside).unwrap();
            let left = engine.difference(&engine.all_states(), &lost).unwrap();
            let left = Region { states: left, choices: c.clone() };
            let brute_lost = &(&brute.all_states() - &brute.sources(brute_c)) | &(brute_x - brute_y);
            let (nothing, without_labels) = (Set::new(), (&[][..], &[][..]));
            for ((labels, brute_labels), won, brute_won) in [
                ((labels, brute_labels), &none, &nothing),
                ((labels, brute_labels), y, brute_y),
                (without_labels, &none, &nothing),
                (without_labels, y, brute_y),
            ] {
                let left = engine.remove_attractor(left.clone(), c, won, labels, lost.clone()).unwrap();
                let (states, choices) =
                    brute.without_attractor(&brute_lost, brute_won, (brute_c, brute_labels));
                self.states(what, &left.states, &states);
                // Of states that are lost, any pairs may remain.
                let left = engine.choices_in(&left.choices, &left.states).unwrap();
                self.choices(what, &left, &brute.choices_in(&choices, &states));
            }
        }
    }

    fn fixpoints(
        &self,
        (x, brute_x): (&E::States, &Set),
        (y, brute_y): (&E::States, &Set),
        (within, brute_within): (&E::Choices, &Set),
    ) {
        let (engine, brute) = (self.engine, self.brute);
        let rest = engine.difference(&engine.all_states(), y).unwrap();
        let brute_rest = &brute.all_states() - brute_y;
        let none = engine.no_states();
        let dropping =
            |from: &E::States, into: &E::States| EdgeLabels::new(from.clone(), none.clone(), into.clone());
        let dropped = [dropping(y, x), dropping(&rest, y)];
        let brute_dropped = [(brute_y.clone(), brute_x.clone()), (brute_rest, brute_y.clone())];
        for (c, brute_c) in [(within, brute_within), (&engine.all_choices(), &brute.all_choices())] {
            let reach = engine.can_reach(x, c, &[]).unwrap();
            self.states("can reach", &reach, &brute.can_reach(brute_x, brute_c, &[]));
            let reach = engine.can_reach(x, c, &dropped).unwrap();
            self.states("can reach, dropped", &reach, &brute.can_reach(brute_x, brute_c, &brute_dropped));
            let region = engine.stay_within(x, c).unwrap();
            let (states, choices) = brute.stay_within(brute_x, brute_c);
            self.states("stay", &region.states, &states);
            self.choices("stay", &region.choices, &choices);
            self.states("surely staying", &engine.surely_staying(x, c).unwrap(), &states);
            let region = engine.almost_surely_reach(x, c).unwrap();
            let (states, choices) = brute.almost_surely_reach(brute_x, brute_c);
            self.states("almost surely", &region.states, &states);
            self.choices("almost surely", &region.choices, &choices);
        }
    }
}
