//! Edits of layers and rounds: their order, their members and their trends.

use meliora::dump::manifest::File;
use meliora::model::trend::Trend;
use rand::seq::{IndexedRandom, IteratorRandom};

use super::edits::{Edit, proof, root, toggled};
use crate::common::prelude::*;

/// The edits of layers and rounds.
pub(super) const EDITS: &[(&str, Edit)] = &[
    ("a layer or round has another trend", |d, r| {
        let roots = proof(d).0.roots.iter_mut().filter(|root| is_step(&root.name));
        let Some(root) = roots.choose(r) else { return false };
        root.trend = *[None, Some(Trend::Falling), Some(Trend::Rising)].choose(r).unwrap();
        true
    }),
    ("a region has a trend", |d, r| {
        let file = if r.random_bool(0.5) { &mut d.manifest.regions } else { proof(d).0 };
        root(file, r).trend = Some(Trend::Falling);
        true
    }),
    ("all trends are turned around", |d, _| {
        let roots = proof(d).0.roots.iter_mut();
        roots.for_each(|root| {
            root.trend = root.trend.map(|t| match t {
                Trend::Falling => Trend::Rising,
                Trend::Rising => Trend::Falling,
            })
        });
        true
    }),
    ("the variables are in another order", |d, r| {
        let file = proof(d).0;
        let order = if r.random_bool(0.5) { &mut file.order } else { &mut file.order_of_rounds };
        let at = r.random_range(0..order.len().max(1));
        match (order.get_mut(at), r.random_range(0..10)) {
            (None, _) => return false,
            (Some(digit), 6) => digit.steady = !digit.steady,
            (Some(digit), 7) => digit.values.reverse(),
            (Some(digit), 8) => drop(digit.values.pop()),
            (Some(digit), 9) => digit.values.extend([0]),
            (_, 0) => order.clear(),
            (_, 1) => drop(order.pop()),
            (Some(digit), 2) => digit.variable = "z".to_owned(),
            (Some(digit), 3) => digit.reversed = !digit.reversed,
            (_, 4) => order.extend(order.first().cloned()),
            _ => order.reverse(),
        }
        true
    }),
    ("layers and rounds have each other's order", |d, _| {
        let file = proof(d).0;
        std::mem::swap(&mut file.order, &mut file.order_of_rounds);
        file.order != file.order_of_rounds
    }),
    ("a layer or round is left out, and the later ones move up", |d, r| {
        let file = proof(d).0;
        let Some((start, number)) = step(file, r) else { return false };
        file.roots.retain(|root| root.name != format!("{start}{number}"));
        (number + 1..)
            .map_while(|k| rename(file, &format!("{start}{k}"), &format!("{start}{}", k - 1)))
            .count();
        true
    }),
    ("a layer or round comes before the one before it", |d, r| {
        let file = proof(d).0;
        let Some((start, number)) = step(file, r).filter(|(_, number)| *number > 0) else { return false };
        let (first, second) = (format!("{start}{}", number - 1), format!("{start}{number}"));
        rename(file, &first, "between").and_then(|()| rename(file, &second, &first));
        rename(file, "between", &second).is_some()
    }),
    ("a layer or round has a state of the next one", |d, r| {
        let (file, diagram) = proof(d);
        let Some((start, number)) = step(file, r) else { return false };
        let [own, next] = [number, number + 1].map(|k| position(file, &format!("{start}{k}")));
        let (Some(own), Some(next)) = (own, next) else { return false };
        let moved = first_member(diagram, file.roots[next].node);
        let choice_bits = diagram.variables.iter().filter(|v| v.starts_with("choice@")).count() as u32;
        for at in [own, next] {
            file.roots[at].node = toggled(diagram, file.roots[at].node, choice_bits, moved);
        }
        true
    }),
];

fn is_step(name: &str) -> bool {
    name.starts_with("layers:") || name.starts_with("refuted:")
}

/// The name of a layer or round without its number, and the number.
fn step(file: &File, random: &mut ChaCha8Rng) -> Option<(String, usize)> {
    let name = &file.roots.iter().filter(|root| is_step(&root.name)).choose(random)?.name;
    let (start, number) = name.rsplit_once(':')?;
    Some((format!("{start}:"), number.parse().ok()?))
}

fn position(file: &File, name: &str) -> Option<usize> {
    file.roots.iter().position(|root| root.name == name)
}

fn rename(file: &mut File, from: &str, to: &str) -> Option<()> {
    let at = position(file, from)?;
    file.roots[at].name = to.to_owned();
    Some(())
}

/// The bits of some member of a set of states.
fn first_member(diagram: &Diagram, from: Edge) -> u64 {
    let (mut at, mut bits) = (from, 0);
    for level in 0..diagram.variables.len() as u32 {
        let (then, otherwise) = diagram.cofactors(at, level);
        bits |= u64::from(otherwise == Edge::FALSE) << level;
        at = if otherwise == Edge::FALSE { then } else { otherwise };
    }
    bits
}
