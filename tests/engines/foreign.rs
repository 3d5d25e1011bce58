//! Every operation refuses the sets of another engine, even of the same model and kind.

use meliora::advanced::symbolic::Set;
use meliora::error::Result;

use crate::common::prelude::*;

fn program() -> Arc<Program> {
    let text =
        "mdp module m x : [0..5] init 0; [a] x<4 -> 1/2:(x'=x+1) + 1/2:(x'=0); [b] x=2 -> (x'=5); endmodule";
    Arc::new(parsed(text))
}

#[track_caller]
fn refused<T>(what: &str, result: Result<T>) {
    match result {
        Err(Error::ForeignSet) => {}
        Err(other) => panic!("{what}: {other}"),
        Ok(_) => panic!("{what}: the foreign set is accepted"),
    }
}

/// Checks the Boolean operations on one sort of sets with a set of each engine.
fn algebra<E: Algebra<X>, X>(sort: &str, engine: &E, own: &X, foreign: &X) {
    for (x, y) in [(own, foreign), (foreign, own), (foreign, foreign)] {
        refused(&format!("{sort}: union"), engine.union(x, y));
        refused(&format!("{sort}: intersection"), engine.intersection(x, y));
        refused(&format!("{sort}: difference"), engine.difference(x, y));
        refused(&format!("{sort}: same"), engine.same(x, y));
    }
    refused(&format!("{sort}: is_empty"), engine.is_empty(foreign));
    refused(&format!("{sort}: count"), engine.count(foreign));
}

/// Checks the operations with one set.
fn images<E: Engine>(engine: &E, x: &E::States, c: &E::Choices) {
    let (states, choices) = (engine.all_states(), engine.all_choices());
    refused("choices_in", engine.choices_in(c, &states));
    refused("choices_in", engine.choices_in(&choices, x));
    refused("sources", engine.sources(c));
    refused("pre", engine.pre(c, &states));
    refused("pre", engine.pre(&choices, x));
    refused("can_enter", engine.can_enter(c, &states));
    refused("can_enter", engine.can_enter(&choices, x));
    refused("can_choose", engine.can_choose(c));
    refused("cannot_choose", engine.cannot_choose(x, &choices));
    refused("cannot_choose", engine.cannot_choose(&states, c));
    refused("pre_within", engine.pre_within(c, &states));
    refused("pre_within", engine.pre_within(&choices, x));
    refused("post", engine.post(c));
    refused("count_model_states", engine.count_model_states(x));
    refused("count_transitions", engine.count_transitions(c, &states));
    refused("count_transitions", engine.count_transitions(&choices, x));
    refused("list_states", engine.list_states(x, 1));
    refused("list_states", engine.list_states(x, 0));
    refused("contains", engine.contains(x, &[0]));
    refused("contains", engine.contains(x, &[7]));
    let choice = &program().choices(&[0]).unwrap()[0].0;
    refused("contains_choice", engine.contains_choice(c, &[0], choice));
    refused("contains_choice", engine.contains_choice(c, &[7], choice));
}

/// Checks the fixpoints with one foreign set in each place.
fn fixpoints<E: Engine>(engine: &E, x: &E::States, c: &E::Choices) {
    let (states, none, choices) = (engine.all_states(), engine.no_states(), engine.all_choices());
    refused("stay_within", engine.stay_within(x, &choices));
    refused("stay_within", engine.stay_within(&states, c));
    refused("surely_staying", engine.surely_staying(x, &choices));
    refused("surely_staying", engine.surely_staying(&states, c));
    refused("almost_surely_reach", engine.almost_surely_reach(x, &choices));
    refused("almost_surely_reach", engine.almost_surely_reach(&states, c));
    refused("can_reach", engine.can_reach(x, &choices, &[]));
    refused("can_reach", engine.can_reach(&states, c, &[]));
    let region = |x: &E::States, c: &E::Choices| Region { states: x.clone(), choices: c.clone() };
    let label = |from: &E::States, goal: &E::States, dropped: &E::States| {
        vec![EdgeLabels::new(from.clone(), goal.clone(), dropped.clone())]
    };
    let barred = |from: &E::States, into: &E::States| {
        let barred = vec![(from.clone(), into.clone())];
        vec![EdgeLabels { barred, ..label(&none, &none, &none).remove(0) }]
    };
    let foreign = [label(x, &none, &none), label(&none, x, &none), label(&none, &none, x)];
    for labels in foreign.into_iter().chain([barred(x, &none), barred(&none, x)]) {
        refused("can_reach", engine.can_reach(&states, &choices, &labels));
        refused("almost_surely_win", engine.almost_surely_win(region(&states, &choices), &labels));
        let left = region(&states, &choices);
        refused("remove_attractor", engine.remove_attractor(left, &choices, &none, &labels, none.clone()));
    }
    let labels = label(&states, &none, &none);
    for start in [region(x, &choices), region(&states, c)] {
        refused("almost_surely_win", engine.almost_surely_win(start.clone(), &labels));
        refused("remove_attractor", engine.remove_attractor(start, &choices, &none, &labels, none.clone()));
    }
    let left = || region(&states, &choices);
    refused("remove_attractor", engine.remove_attractor(left(), c, &none, &labels, none.clone()));
    refused("remove_attractor", engine.remove_attractor(left(), &choices, x, &labels, none.clone()));
    refused("remove_attractor", engine.remove_attractor(left(), &choices, &none, &labels, x.clone()));
}

/// Checks all operations of an engine with the constants and a proper subset of another.
fn check<E: Engine>(engine: &E, other: &E) {
    let (all, choices) = (other.all_states(), other.all_choices());
    let some = other.initial_states();
    for x in [&all, &other.no_states(), &some, &other.deadlock_states()] {
        algebra("states", engine, &engine.initial_states(), x);
        for c in [&choices, &other.no_choices(), &other.pre(&other.all_choices(), &some).unwrap()] {
            algebra("choices", engine, &engine.all_choices(), c);
            images(engine, x, c);
            fixpoints(engine, x, c);
        }
    }
    // The operations on sets of its own still work.
    assert!(engine.same(&engine.all_states(), &engine.all_states()).unwrap());
}

#[test]
fn the_symbolic_engine_refuses_foreign_sets() {
    let [one, other] = [(); 2].map(|()| SymbolicEngine::new(program(), Settings::default()).unwrap());
    check(&one, &other);
    for (x, c) in [(other.all_states(), other.all_choices()), (other.no_states(), other.no_choices())] {
        refused("has_nodes", one.has_nodes(&x, 1));
        refused("size", one.size(&x));
        refused("numbered", one.numbered(&c, 0));
        refused("projection", one.projection(&x, &[]));
        refused("repeated", one.repeated(&x, 1));
        refused("listing", one.listing(&x).map(drop));
        refused("next_listed", one.next_listed(&mut other.listing(&x).unwrap()));
        refused("diagram", one.diagram(&[Set::States(x)], &[]));
        refused("diagram", one.diagram(&[Set::Choices(c)], &[]));
    }
}

#[test]
fn the_explicit_engine_refuses_foreign_sets() {
    let [one, other] = [(); 2].map(|()| ExplicitEngine::new(program(), Settings::default()).unwrap());
    check(&one, &other);
    for x in [other.all_states(), other.no_states()] {
        refused("listing", one.listing(&x).map(drop));
        refused("visit", one.visit(&x, &mut |_| ()));
        refused("filter", one.filter(&x, &mut |_| true).map(drop));
        refused("members_at", one.members_at(&x, &[0]));
    }
}

#[test]
fn an_engine_of_either_kind_refuses_foreign_sets() {
    let of = |storage| AnyEngine::new(program(), Settings { storage, ..Settings::default() }).unwrap();
    for storage in [Storage::Symbolic, Storage::Explicit] {
        for other in [Storage::Symbolic, Storage::Explicit] {
            check(&of(storage), &of(other));
        }
    }
}

#[test]
fn a_clone_accepts_the_sets_of_its_engine() {
    for storage in [Storage::Symbolic, Storage::Explicit] {
        let engine = AnyEngine::new(program(), Settings { storage, ..Settings::default() }).unwrap();
        let own = engine.clone();
        assert!(own.same(&engine.all_states(), &own.all_states()).unwrap());
        assert!(own.same(&engine.no_choices(), &own.no_choices()).unwrap());
    }
}
