//! The regions, classes and objectives of a result: their names and their order.

use std::fmt::Debug;
use std::str::FromStr;

use meliora::planning::regions::regions;

use crate::common::brute::Set;
use crate::common::prelude::*;
use crate::planning::examples::circle;
use crate::planning::tiny::Mdp;
use crate::planning::{Case, analyse};

fn states(text: &str, n: usize) -> Set {
    (0..n).filter(|s| text.contains(&s.to_string())).collect()
}

#[test]
fn each_region_has_its_name_and_its_states() {
    let case = circle(&[3]);
    let engine = case.engine();
    let preferences = case.preferences(&engine, Empty::Bottom);
    let analysis = analyse(&engine, &preferences, Safety::Action);
    let mut expected = Vec::new();
    for (objective, [target, almost_sure, positive]) in [
        ("o0", ["0", "0", "012"]),
        ("o1", ["1", "1", "012"]),
        ("o2", ["1", "1", "012"]),
        ("o3", ["2", "2", "012"]),
        ("o4", ["2", "2", "012"]),
        ("o5", ["0", "0", "012"]),
        // Trying again and again almost surely ends in the sink.
        ("o6", ["3", "0123", "0123"]),
    ] {
        expected.push((format!("target:{objective}"), target));
        expected.push((format!("almost-sure:{objective}"), almost_sure));
        expected.push((format!("positive:{objective}"), positive));
    }
    for (name, states) in [
        ("class:o0+o5+o6", "0"),
        ("class:o1+o2+o6", "1"),
        ("class:o3+o4+o6", "2"),
        ("class:o6", "3"),
        // A try may end in the sink, so no improvement is almost sure. On the circle there is always
        // another one.
        ("spi:1", "012"),
        ("spi:unbounded", "012"),
    ] {
        expected.push((name.to_owned(), states));
    }
    let found = regions(&analysis).into_iter().map(|(name, x)| (name.to_string(), x.clone()));
    let expected = expected.into_iter().map(|(name, x)| (name, states(x, 4)));
    assert_eq!(found.collect::<Vec<_>>(), expected.collect::<Vec<_>>());
}

/// One absorbing state per row, with the objectives that it achieves.
fn apart(reached: &[&[usize]], objectives: usize) -> Case {
    let mdp = Mdp::new(vec![Vec::new(); reached.len()]);
    let target = |i: usize| (0..reached.len()).filter(|&s| reached[s].contains(&i)).collect();
    Case { mdp, targets: (0..objectives).map(target).collect(), statements: Vec::new() }
}

#[test]
fn classes_are_listed_by_their_members_and_nothing_last() {
    let case = apart(&[&[], &[2], &[1, 2], &[0, 2], &[0], &[0, 1, 2], &[0, 1], &[1]], 3);
    let engine = case.engine();
    let preferences = case.preferences(&engine, Empty::Bottom);
    let analysis = analyse(&engine, &preferences, Safety::Action);
    let classes = analysis.result().classes.as_ref().unwrap();
    let members: Vec<&Vec<String>> = classes.iter().map(|c| &c.most_preferred).collect();
    let name = |&i: &usize| preferences.objectives[i].name.clone();
    let expected: [&[usize]; 8] = [&[0], &[0, 1], &[0, 1, 2], &[0, 2], &[1], &[1, 2], &[2], &[]];
    let expected = expected.map(|members| members.iter().map(name).collect::<Vec<_>>());
    assert_eq!(members, expected.each_ref());
}

#[test]
fn objectives_are_listed_as_declared_though_the_largest_target_comes_first() {
    let case = apart(&[&[0, 1, 2], &[1, 2], &[1]], 3);
    let engine = case.engine();
    let preferences = case.preferences(&engine, Empty::Bottom);
    let analysis = analyse(&engine, &preferences, Safety::Action);
    let listed = analysis.result().objectives.iter();
    let listed: Vec<_> = listed.map(|o| (o.objective, o.target.clone())).collect();
    assert_eq!(listed, [(0, 1u32.into()), (1, 3u32.into()), (2, 2u32.into())]);
}

fn found_by_name<T: Copy + PartialEq + Debug + FromStr>(all: &[T], name: fn(T) -> &'static str) {
    for &one in all {
        assert_eq!(name(one).parse().ok(), Some(one));
    }
    assert_eq!("none of them".parse::<T>().ok(), None);
}

#[test]
fn options_are_found_by_their_names() {
    found_by_name(Safety::ALL, Safety::name);
    found_by_name(Kind::ALL, Kind::name);
    found_by_name(Scheduler::ALL, Scheduler::name);
    found_by_name(Empty::ALL, Empty::name);
}
