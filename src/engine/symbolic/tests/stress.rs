//! Tests of the limits of a store, of cancellation, and of tables that several threads share.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use oxidd::{Function, Manager};

use super::exhaustive::function;
use crate::settings::Settings;
use crate::symbolic::encoding::translate::Translator;
use crate::symbolic::fixpoints::parts::Part;
use crate::symbolic::relations::lists::Lists;
use crate::symbolic::relations::partial_relation::PartialRelation;
use crate::symbolic::relations::support::Support;
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::Bdd;
use crate::symbolic::store::thresholds::Thresholds;
use crate::symbolic::store::walk::PATIENCE;
use crate::symbolic::{Encoding, Order};
use meliora_base::error::{Error, Limit, Result, SourceFile};
use meliora_base::progress::ProgressSink;
use meliora_lang as lang;

/// Stops the work once it has been asked as often as allowed.
struct Patience {
    allowed: AtomicU64,
}

impl ProgressSink for Patience {
    fn stop(&self) -> Option<Limit> {
        let left = self.allowed.fetch_update(Relaxed, Relaxed, |left| left.checked_sub(1));
        left.is_err().then_some(Limit::Interrupted)
    }
}

fn settings(memory: u64) -> Settings {
    Settings { memory, ..Settings::default() }
}

fn small_store() -> Store {
    Store::new(16, &settings(1 << 20)).unwrap()
}

/// Returns pseudo-random numbers, the same in each run.
fn numbers(mut seed: u64) -> impl FnMut() -> u64 {
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        seed >> 20 ^ seed >> 41
    }
}

/// Returns a random function of some levels, whose diagram is about as large as possible.
fn random(store: &Store, levels: &[u32], next: &mut impl FnMut() -> u64) -> Bdd {
    if levels.len() <= 6 {
        return function(store, levels, next() ^ next() << 32);
    }
    let (set, clear) = (random(store, &levels[1..], next), random(store, &levels[1..], next));
    store.ite(&store.literal(levels[0], true).unwrap(), &set, &clear).unwrap()
}

/// Returns the set with one state, given as the number of its bits. Starts with the last bit, so that
/// no node becomes garbage.
fn cube(store: &Store, state: u64) -> Result<Bdd> {
    let literal = |bit: u32| store.literal(2 * bit, state >> bit & 1 == 1);
    (0..16).rev().try_fold(store.one(), |cube, bit| store.and(&cube, &literal(bit)?))
}

#[track_caller]
fn out_of_memory<T>(result: Result<T>) {
    assert!(matches!(result, Err(Error::Limit(Limit::Memory { .. }))), "{:?}", result.err());
}

#[test]
fn list_numbers_do_not_wrap_while_lists_are_in_use() {
    let store = small_store();
    let first = u32::MAX - 7;
    store.next_key.store(first, Relaxed);
    let known = Lists::new(&store);
    let entry = |bit: u32| PartialRelation {
        relation: store.literal(2 * bit, true).unwrap(),
        support: Support::new([bit]),
    };
    let lists: Vec<_> = (0..3).map(|bit| known.of(&store, vec![entry(bit)]).unwrap()).collect();
    assert_eq!(lists.iter().map(|l| l.number).collect::<Vec<_>>(), [first, first + 2, first + 4]);
    let more = known.of(&store, vec![entry(3)]);
    assert!(matches!(more, Err(Error::Limit(Limit::Size { .. }))));
    // Known lists are still found.
    assert_eq!(known.of(&store, vec![entry(1)]).unwrap().number, first + 2);
}

#[test]
fn the_collector_of_oxidd_never_runs_next_to_ours() {
    let store = small_store();
    let mut next = numbers(1);
    let mut kept = Vec::new();
    let full = loop {
        match cube(&store, next()) {
            Ok(cube) => kept.push(cube),
            Err(error) => break error,
        }
        // Every third set is dropped.
        if next().is_multiple_of(3) {
            kept.pop();
        }
    };
    assert!(matches!(full, Error::Limit(Limit::Memory { .. })), "{full}");
    let collections = store.work.collections.load(Relaxed);
    assert!(collections > 3, "{collections}");
    assert_eq!(store.shared(|m| m.gc_count()), collections);
    // Once the sets are gone, their memory is used again.
    drop(kept);
    for state in 0..100 {
        cube(&store, state).unwrap();
    }
}

#[test]
fn collections_that_free_little_end_the_work() {
    let store = small_store();
    let mut next = numbers(2);
    let mut kept = Vec::new();
    let full = loop {
        match cube(&store, next()) {
            Ok(cube) => kept.push(cube),
            Err(error) => break Err(error),
        }
    };
    out_of_memory::<()>(full);
    // The first one at half of the table, and the futile ones.
    let collections = store.work.collections.load(Relaxed);
    assert!((3..10).contains(&collections), "{collections}");
}

#[test]
fn a_single_operation_ends_at_most_1024_steps_after_a_cancellation() {
    let sink = Arc::new(Patience { allowed: u64::MAX.into() });
    let store = Store::new(16, &Settings { sink: sink.clone(), ..settings(64 << 20) }).unwrap();
    let (levels, mut next) = (Vec::from_iter((0..16).map(|bit| 2 * bit)), numbers(3));
    let [f, g, h] = [(); 3].map(|()| random(&store, &levels, &mut next));
    let bits =
        (1..16).try_fold(store.one(), |all, bit| store.and(&all, &store.literal(2 * bit, true)?)).unwrap();
    type Operation<'a> = Box<dyn Fn() -> Result<Bdd> + 'a>;
    let operations: [(&str, Operation<'_>); 6] = [
        ("and", Box::new(|| store.and(&f, &g))),
        ("minus", Box::new(|| store.minus(&f, &h))),
        ("xor", Box::new(|| store.xor(&g, &h))),
        ("iff", Box::new(|| store.iff(&f, &g))),
        ("ite", Box::new(|| store.ite(&f, &g, &h))),
        ("exists", Box::new(|| store.exists(&f, &bits))),
    ];
    for (name, operation) in operations {
        for checks in [1, 2] {
            let before = store.work.steps.load(Relaxed);
            sink.allowed.store(checks, Relaxed);
            let stopped = operation();
            assert!(matches!(stopped, Err(Error::Limit(Limit::Interrupted))), "{name}");
            let steps = store.work.steps.load(Relaxed) - before;
            assert!(steps <= checks * PATIENCE, "{name}: {steps} steps after {checks} checks");
        }
        sink.allowed.store(u64::MAX, Relaxed);
        operation().unwrap();
    }
}

#[test]
fn relation_lists_count_as_memory_until_they_are_dropped() {
    let store = small_store();
    let lists = Lists::new(&store);
    let literal = |bit: u32| PartialRelation {
        relation: store.literal(2 * bit, true).unwrap(),
        support: Support::new([bit]),
    };
    let literals: Vec<PartialRelation> = (0..16).map(literal).collect();
    let mut kept = Vec::new();
    let full = (0..1u32 << 16).try_for_each(|chosen| {
        let chosen = (0..16).filter(|&bit| chosen >> bit & 1 == 1).map(|bit| literals[bit].clone());
        kept.push(lists.of(&store, chosen.collect())?);
        store.and(&store.one(), &store.one()).map(|_| ())
    });
    out_of_memory(full);
    assert!(kept.len() < 10_000, "{} lists", kept.len());
    // The names keep the other lists only as long as the memory suffices.
    drop(kept);
    store.not(&store.one()).unwrap();
    assert_eq!(store.charges.now(), 0);
}

#[test]
fn the_tables_of_recursions_count_as_memory() {
    let store = small_store();
    let lists = Lists::new(&store);
    let same = store.iff(&store.literal(4, true).unwrap(), &store.literal(7, true).unwrap()).unwrap();
    let relation = PartialRelation { relation: same, support: Support::new([3]) };
    let list = lists.of(&store, vec![relation]).unwrap();
    let part = Part { allowed: store.one(), except: store.zero(), list };
    let (before, state) = (store.charges.now(), cube(&store, 77).unwrap());
    store.reach_by(&state, &[part], u64::MAX).unwrap().unwrap();
    let after = store.charges.now();
    let tables = store.charges.peak() - after;
    assert!(tables >= 8 * size_of::<(Bdd, Bdd)>() as u64, "{before} {after} {tables}");
}

#[test]
fn the_values_of_expressions_count_as_memory() {
    let text = "mdp module m x : [0..9]; y : [0..9]; [] x * y + x > 12 & x / 3 < 2.5 -> true; endmodule";
    let source = SourceFile::new("m", text);
    let program = lang::load(&source, &SourceFile::new("constants", "")).unwrap().program;
    let encoding = Encoding::new(&program, Order::Declared.bits(&program).unwrap());
    let store = small_store();
    let translator = Translator::new(&program, &encoding, &store);
    translator.condition(program.commands[0].guard).unwrap();
    assert!(store.charges.now() > 1_000, "{}", store.charges.now());
    drop(translator);
    assert_eq!(store.charges.now(), 0);
}

/// Runs random operations on functions of six variables, each next to its truth table.
fn exercise(store: &Store, seed: u64, rounds: usize) {
    let (levels, mut next) = (Vec::from_iter((0..6).map(|bit| 2 * bit)), numbers(seed));
    let mut known: Vec<(Bdd, u64)> =
        (0..6).map(|_| next()).map(|table| (function(store, &levels, table), table)).collect();
    for _ in 0..rounds {
        let [i, j, k] = [(); 3].map(|()| next() as usize % known.len());
        let ((f, x), (g, y), (h, z)) = (&known[i], &known[j], &known[k]);
        let (made, table) = match next() % 6 {
            0 => (store.and(f, g), x & y),
            1 => (store.or(f, g), x | y),
            2 => (store.xor(f, g), x ^ y),
            3 => (store.minus(f, g), x & !y),
            4 => (store.not(f), !x),
            _ => (store.ite(f, g, h), x & y | !x & z),
        };
        let made = made.unwrap();
        assert!(made == function(store, &levels, table), "{table:x}");
        known[k] = if table == 0 || !table == 0 {
            let table = next();
            (function(store, &levels, table), table)
        } else {
            (made, table)
        };
    }
}

#[test]
fn tables_that_many_threads_share_stay_right() {
    let thresholds = Thresholds { first_collection: 300, cache: 1 << 10, ..Thresholds::default() };
    let store = Store::new(6, &Settings { thresholds, ..settings(64 << 20) }).unwrap();
    std::thread::scope(|scope| {
        for seed in 0..4 {
            let store = &store;
            scope.spawn(move || exercise(store, seed, 400));
        }
    });
    let collections = store.work.collections.load(Relaxed);
    assert!(collections > 20, "{collections}");
    assert!(store.zero().with_manager_shared(|m, _| m.gc_count()) == collections);
}

#[test]
fn copies_into_another_store_are_the_same_functions_in_any_order_and_can_be_cancelled() {
    let sink = Arc::new(Patience { allowed: u64::MAX.into() });
    let store = Store::new(16, &Settings { sink: sink.clone(), ..settings(64 << 20) }).unwrap();
    let other = Store::new(16, &Settings { sink: sink.clone(), ..settings(64 << 20) }).unwrap();
    let (levels, mut next) = (Vec::from_iter((0..16).map(|bit| 2 * bit)), numbers(5));
    let original = [random(&store, &levels, &mut next), store.one(), store.zero()];
    let orders: [fn(u32) -> u32; 3] = [|level| level, |level| 30 - level, |level| (level + 10) % 32];
    let back: [fn(u32) -> u32; 3] = [|level| level, |level| 30 - level, |level| (level + 22) % 32];
    for (order, back) in orders.into_iter().zip(back) {
        let mut copies = original.clone();
        other.adopt_all(&store, order, copies.iter_mut()).unwrap();
        assert!(copies.iter().all(|copy| other.owns(copy) && !store.owns(copy)));
        assert_eq!(other.count(&copies[0], 0).unwrap(), store.count(&original[0], 0).unwrap());
        let mut again = copies.clone();
        store.adopt_all(&other, back, again.iter_mut()).unwrap();
        assert!(again == original);
    }
    sink.allowed.store(0, Relaxed);
    let cancelled = other.adopt_all(&store, |level| level, original.clone().iter_mut());
    assert!(matches!(cancelled, Err(Error::Limit(Limit::Interrupted))));
}
