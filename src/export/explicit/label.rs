//! Regions and ranks as labels of states.

use std::collections::{BTreeMap, BTreeSet};

use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::State;
use meliora_model::region::RegionName;
use meliora_planning::levels::Rank;
use meliora_planning::regions::regions;
use meliora_planning::{Analysis, Kind};

/// The regions of an analysis, as labels of states.
pub(super) struct Regions<'a, E: Engine> {
    analysis: &'a Analysis<E>,
    named: Vec<(RegionName, &'a E::States)>,
}

impl<'a, E: Engine> Regions<'a, E> {
    pub(super) fn of(analysis: &'a Analysis<E>) -> Self {
        Regions { analysis, named: regions(analysis) }
    }

    /// Returns each region with its states, and for each kind of strategy the states of each rank.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub(super) fn all(&self, states: &[State]) -> Result<Vec<(String, Vec<usize>)>> {
        let engine = self.analysis.engine();
        let mut labels = Vec::new();
        for (name, region) in &self.named {
            labels.push((identifier(&name.to_string()), members(engine, region, states)?));
        }
        for &kind in Kind::ALL {
            labels.extend(self.ranks(kind, states)?);
        }
        Ok(labels)
    }

    fn ranks(&self, kind: Kind, states: &[State]) -> Result<Vec<(String, Vec<usize>)>> {
        let mut ranks: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for (number, state) in states.iter().enumerate() {
            // Unsafe states have no rank.
            if self.analysis.is_unsafe(state)? {
                continue;
            }
            let rank = match self.analysis.levels(kind).rank(self.analysis.engine(), state)? {
                Rank::Finite(k) => k.to_string(),
                Rank::AtLeast(k) => format!("at_least_{k}"),
                Rank::Unbounded => "unbounded".to_owned(),
            };
            ranks.entry(format!("{}_rank_{rank}", kind.name())).or_default().push(number);
        }
        Ok(ranks.into_iter().collect())
    }
}

/// Returns the positions of the states that are in X.
///
/// # Errors
/// The errors of [`Engine::contains`].
pub(super) fn members<E: Engine>(engine: &E, x: &E::States, states: &[State]) -> Result<Vec<usize>> {
    let mut members = Vec::new();
    for (number, state) in states.iter().enumerate() {
        if engine.contains(x, state)? {
            members.push(number);
        }
    }
    Ok(members)
}

/// Makes names distinct by numbers; none is empty or reserved.
pub(super) fn unique<'n>(names: impl Iterator<Item = &'n str>, reserved: &[&str]) -> Vec<String> {
    let mut taken: BTreeSet<String> = reserved.iter().map(|&name| name.to_owned()).collect();
    let distinct = |name: &str| {
        let wanted = if name.is_empty() { "_" } else { name };
        let (mut name, mut number) = (wanted.to_owned(), 2);
        while !taken.insert(name.clone()) {
            name = format!("{wanted}_{number}");
            number += 1;
        }
        name
    };
    names.map(distinct).collect()
}

/// Returns the name of a region as all readers of the formats accept it: letters, digits and `_`.
fn identifier(name: &str) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let mut identifier: String = name.chars().map(letter).collect();
    if identifier.is_empty() || identifier.starts_with(|c: char| c.is_ascii_digit()) {
        identifier.insert(0, '_');
    }
    identifier
}
