//! Tests of the recursions against tables of states. Exhaustive: all functions of few bits as
//! relation, set and bound, all supports, both directions. Random: relations of more bits.

use std::sync::Arc;

use proptest::prelude::*;

use crate::settings::Settings;
use crate::symbolic::fixpoints::parts::Part;
use crate::symbolic::relations::lists::Lists;
use crate::symbolic::relations::partial_relation::PartialRelation;
use crate::symbolic::relations::support::Support;
use crate::symbolic::relations::tuples::ListTuples;
use crate::symbolic::store::Store;
use crate::symbolic::store::diagram::Bdd;
use crate::symbolic::store::thresholds::Thresholds;
use crate::symbolic::store::walk::{Direction, Pass, Walk};

/// A set of states, or of pairs of a state and the next values of the support bits: bit k is set if
/// element k is in the set.
type Table = u64;

fn store(width: usize, thresholds: Thresholds) -> (Store, Arc<Lists>) {
    let settings = Settings { memory: 64 << 20, thresholds, ..Settings::default() };
    let store = Store::new(width, &settings).unwrap();
    let lists = Lists::new(&store);
    (store, lists)
}

/// Returns thresholds with which work of any size uses every method.
fn least() -> Thresholds {
    Thresholds { first_turn: 3, ..Thresholds::default() }
}

/// Returns a bit of a state's number; bit 0 is the most significant.
fn bit_of(state: usize, bit: usize, width: usize) -> bool {
    state >> (width - 1 - bit) & 1 == 1
}

/// Returns the function of the levels whose value at the k-th assignment is bit k of the table.
pub(in crate::symbolic) fn function(store: &Store, levels: &[u32], table: Table) -> Bdd {
    let Some((&level, rest)) = levels.split_first() else {
        return if table & 1 == 1 { store.one() } else { store.zero() };
    };
    let half = 1 << rest.len();
    let (clear, set) = (function(store, rest, table), function(store, rest, table >> half));
    store.ite(&store.literal(level, true).unwrap(), &set, &clear).unwrap()
}

fn set(store: &Store, width: usize, table: Table) -> Bdd {
    function(store, &Vec::from_iter((0..width as u32).map(|b| 2 * b)), table)
}

type Edges = Vec<(usize, usize)>;

/// A relation and its edges.
struct Relation {
    steps: PartialRelation,
    edges: Edges,
}

impl Relation {
    /// Creates the relation with this table, over all bits and the next copies of the support bits.
    fn new(store: &Store, width: usize, support: usize, table: Table) -> Self {
        let touches = |bit: usize| support >> bit & 1 == 1;
        let after = Vec::from_iter((0..width).filter(|&b| touches(b)));
        let mut levels = Vec::from_iter((0..width as u32).map(|b| 2 * b));
        levels.extend(after.iter().map(|&b| 2 * b as u32 + 1));
        let mut edges = Vec::new();
        for from in 0..1 << width {
            for values in 0..1 << after.len() {
                if table >> (from << after.len() | values) & 1 == 1 {
                    let mut to: usize = from;
                    for (place, &bit) in after.iter().enumerate() {
                        let mask = 1 << (width - 1 - bit);
                        to = if bit_of(values, place, after.len()) { to | mask } else { to & !mask };
                    }
                    edges.push((from, to));
                }
            }
        }
        let support = Support::new(after.iter().map(|&b| b as u32));
        Relation { steps: PartialRelation { relation: function(store, &levels, table), support }, edges }
    }
}

/// Computes the states that one step joins with a set, within a bound.
fn step(edges: &[(usize, usize)], direction: Direction, x: Table, bound: Table) -> Table {
    let mut found = 0;
    for &(from, to) in edges {
        let (near, far) = if direction == Direction::Forward { (from, to) } else { (to, from) };
        found |= (x >> near & 1) << far;
    }
    found & bound
}

fn reached(edges: &[(usize, usize)], direction: Direction, x: Table, bound: Table) -> Table {
    let mut all = x;
    loop {
        let next = all | step(edges, direction, all, bound);
        if next == all {
            return all;
        }
        all = next;
    }
}

fn check((store, lists): &(Store, Arc<Lists>), width: usize, relations: &[Relation], x: Table, bound: Table) {
    let edges = Vec::from_iter(relations.iter().flat_map(|r| r.edges.iter().copied()));
    let list = lists.of(store, relations.iter().map(|r| r.steps.clone()).collect()).unwrap();
    let (from, within) = (set(store, width, x), set(store, width, bound));
    let start = store.and(&from, &within).unwrap();
    for direction in [Direction::Forward, Direction::Backward] {
        let found = store.step(direction, &list, &from, &within).unwrap();
        let stepping = step(&edges, direction, x, bound);
        assert!(found == set(store, width, stepping), "step {direction:?}");
        let spare = |w: &Walk<'_, '_>| w.own(|w| w.spare(w.edge(&from), w.edge(&within), &list));
        let found = store.walk_to_the_end(Pass { direction, phase: None }, spare).unwrap();
        assert!(found == set(store, width, bound & !stepping), "spare {direction:?}");
        let expected = set(store, width, reached(&edges, direction, x & bound, bound));
        // All methods share the operation cache, so mostly only the first one computes. The operands
        // choose it.
        let by_saturation = (x ^ bound) % 2 == 1;
        let found =
            store.fixpoint(by_saturation, Pass { direction, phase: None }, u64::MAX, &list, &start, &within);
        assert!(found.unwrap().unwrap() == expected, "by saturation: {by_saturation}, {direction:?}");
        let found = store.reach(Pass { direction, phase: Some("test") }, &list, &start, &within).unwrap();
        assert!(found == expected, "either {direction:?}");
    }
}

#[test]
fn operations_are_right_on_all_relations_of_two_bits_that_touch_one_or_none() {
    for support in [0, 1, 2] {
        let store = store(2, Thresholds::default());
        let tables: Table = if support == 0 { 1 << 4 } else { 1 << 8 };
        for table in 0..tables {
            let relation = [Relation::new(&store.0, 2, support, table)];
            for (x, bound) in (0..16).flat_map(|x| (0..16).map(move |b| (x, b))) {
                check(&store, 2, &relation, x, bound);
            }
        }
    }
}

#[test]
fn operations_are_right_on_all_relations_of_two_bits_that_touch_both() {
    let store = store(2, Thresholds::default());
    for table in 0..1 << 16 {
        let relation = [Relation::new(&store.0, 2, 3, table)];
        // All pairs of a set and a bound occur, each with 256 relations.
        let (x, bound) = (table & 15, (table >> 4 ^ table >> 12) & 15);
        check(&store, 2, &relation, x, bound);
    }
}

#[test]
fn all_sets_of_three_bits_are_primed() {
    let (store, _) = store(3, Thresholds::default());
    for (support, table) in (0..8).flat_map(|t| (0..256).map(move |x| (t, x))) {
        let bits = Support::new((0..3).filter(|b| support >> b & 1 == 1));
        let levels = Vec::from_iter((0..3).map(|b| 2 * b + (support >> b & 1)));
        let found = store.primed(&bits, &set(&store, 3, table)).unwrap();
        assert!(found == function(&store, &levels, table), "{support} {table}");
    }
}

/// Computes the expected result of a loss: the lost states and the allowed states of each part.
fn lost(parts: &[(Edges, Table, Table)], new: Table) -> (Table, Vec<Table>) {
    let mut lost = new;
    let mut allowed = Vec::from_iter(parts.iter().map(|p| p.1 & !new));
    loop {
        let mut hit = 0;
        for ((edges, _, safe), allowed) in parts.iter().zip(&mut allowed) {
            let gone = step(edges, Direction::Backward, lost & !safe, *allowed);
            *allowed &= !gone;
            hit |= gone;
        }
        let stuck = hit & !allowed.iter().fold(0, |all, a| all | a);
        if stuck == 0 {
            return (lost, allowed);
        }
        lost |= stuck;
    }
}

/// Computes the candidates of which every group with an edge has one into a lost state, and so on.
fn attractor(groups: &[Edges], lost: Table, candidates: Table) -> Table {
    let mut all = lost;
    loop {
        let keeps = |state: usize, edges: &Edges| {
            let mut own = edges.iter().filter(|(from, _)| *from == state).peekable();
            own.peek().is_some() && own.all(|(_, to)| all >> to & 1 == 0)
        };
        let is_lost = |state: &usize| !groups.iter().any(|edges| keeps(*state, edges));
        let states = (0..64).filter(|state| candidates >> state & 1 == 1);
        let more = states.filter(is_lost).fold(all, |all, state| all | 1 << state);
        if more == all {
            return all;
        }
        all = more;
    }
}

/// Computes the states that can reach X by some parts.
fn reached_by(parts: &[(Edges, Table, Table)], x: Table) -> Table {
    let mut all = x;
    loop {
        let enter = |(edges, allowed, except): &(Edges, Table, Table)| {
            step(edges, Direction::Backward, all & !except, *allowed)
        };
        let more = parts.iter().fold(all, |all, part| all | enter(part));
        if more == all {
            return all;
        }
        all = more;
    }
}

/// A random relation: its support as a bit mask, and its table.
fn relation(width: usize) -> impl Strategy<Value = (usize, Table)> {
    (0..1usize << width, any::<u64>(), any::<u64>()).prop_map(|(support, a, b)| (support, a & b))
}

proptest! {
    #![proptest_config(meliora_amount::random(2_000))]

    #[test]
    fn operations_are_right_on_lists_of_relations_of_three_bits(relations in prop::collection::vec(relation(3), 0..4), x: u8, bound: u8, small: bool) {
        let store = store(3, if small { least() } else { Thresholds::default() });
        let relations = Vec::from_iter(relations.into_iter().map(|(support, t)| Relation::new(&store.0, 3, support, t)));
        check(&store, 3, &relations, x.into(), bound.into());
    }

    #[test]
    fn attractors_are_right_on_three_bits(
        groups in prop::collection::vec(prop::collection::vec(relation(3), 1..3), 0..4),
        lost: u8,
        candidates: u8,
        small: bool,
    ) {
        let (store, lists) = store(3, if small { least() } else { Thresholds::default() });
        let (lost, candidates) = (Table::from(lost), Table::from(candidates & !lost));
        let (mut given, mut edges) = (Vec::new(), Vec::new());
        for group in groups {
            let new = |(support, table)| Relation::new(&store, 3, support, table);
            let relations = Vec::from_iter(group.into_iter().map(new));
            given.push(lists.of(&store, relations.iter().map(|r| r.steps.clone()).collect()).unwrap());
            edges.push(Vec::from_iter(relations.into_iter().flat_map(|r| r.edges)));
        }
        let groups = ListTuples::new(&store).of_lists(&store, &given).unwrap();
        let expected = set(&store, 3, attractor(&edges, lost, candidates));
        let (lost, candidates) = (set(&store, 3, lost), set(&store, 3, candidates));
        prop_assert!(store.lose(&lost, &candidates, &groups, u64::MAX).unwrap() == (expected.clone(), true));
        for steps in 0..40 {
            // The states found before the steps were used up lie between the two sets.
            let (found, done) = store.lose(&lost, &candidates, &groups, steps).unwrap();
            prop_assert!(!done || found == expected);
            prop_assert!(store.is_zero(&store.minus(&lost, &found).unwrap()));
            prop_assert!(store.is_zero(&store.minus(&found, &expected).unwrap()));
        }
    }

    #[test]
    fn parts_are_right_on_three_bits(
        parts in prop::collection::vec((relation(3), any::<u8>(), any::<u8>()), 0..4),
        won: u8,
        new: u8,
    ) {
        let (store, lists) = store(3, Thresholds::default());
        let new = Table::from(new);
        let mut expected = Vec::new();
        let mut given = Vec::new();
        for ((support, table), allowed, safe) in parts {
            let relation = Relation::new(&store, 3, support, table);
            let (allowed, safe) = (Table::from(allowed) & !new, Table::from(safe));
            let list = lists.of(&store, vec![relation.steps]).unwrap();
            given.push(Part { allowed: set(&store, 3, allowed), except: set(&store, 3, safe), list });
            expected.push((relation.edges, allowed, safe));
        }
        let reached = set(&store, 3, reached_by(&expected, new));
        prop_assert!(store.reach_by(&set(&store, 3, new), &given, u64::MAX).unwrap().unwrap() == reached);
        prop_assert!(store.reach_by(&set(&store, 3, new), &given, 0).unwrap().is_none_or(|r| r == reached));
        let list = lists.of(&store, Vec::new()).unwrap();
        let won = Table::from(won) & !new;
        given.push(Part { allowed: set(&store, 3, won), except: store.zero(), list });
        expected.push((Vec::new(), won, 0));
        let found = store.remove_attractor(&set(&store, 3, new), &given, u64::MAX).unwrap().unwrap();
        let (lost, allowed) = lost(&expected, new);
        prop_assert!(found.lost == set(&store, 3, lost));
        for (found, expected) in found.allowed.iter().zip(allowed) {
            prop_assert!(*found == set(&store, 3, expected));
        }
        prop_assert!(store.remove_attractor(&set(&store, 3, new), &given, 0).unwrap().is_none_or(|l| l.lost == found.lost));
    }
}
