//! Regions and ranks as labels of states.

use std::collections::BTreeMap;

use crate::engine::Engine;
use crate::model::State;
use crate::planning::levels::Rank;
use crate::planning::regions::regions;
use crate::planning::{Analysis, Kind};

/// The regions of an analysis, as labels of states.
pub(super) struct Regions<'a, E: Engine> {
    analysis: &'a Analysis<E>,
    named: Vec<(String, &'a E::States)>,
}

impl<'a, E: Engine> Regions<'a, E> {
    pub(super) fn of(analysis: &'a Analysis<E>) -> Self {
        Regions { analysis, named: regions(analysis) }
    }

    /// Returns each region with its states, and for each kind of strategy the states of each rank.
    pub(super) fn all(&self, states: &[State]) -> Vec<(String, Vec<usize>)> {
        let engine = self.analysis.engine();
        let mut labels = Vec::new();
        for (name, region) in &self.named {
            let own = states.iter().enumerate().filter(|(_, s)| engine.contains(region, s));
            labels.push((name.clone(), own.map(|(number, _)| number).collect()));
        }
        for &kind in Kind::ALL {
            labels.extend(self.ranks(kind, states));
        }
        labels
    }

    fn ranks(&self, kind: Kind, states: &[State]) -> Vec<(String, Vec<usize>)> {
        let mut ranks: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for (number, state) in states.iter().enumerate() {
            let rank = match self.analysis.levels(kind).rank(self.analysis.engine(), state) {
                Rank::Finite(k) => k.to_string(),
                Rank::AtLeast(k) => format!("at_least_{k}"),
                Rank::Unbounded => "unbounded".to_owned(),
            };
            ranks.entry(format!("{}_rank_{rank}", kind.name())).or_default().push(number);
        }
        ranks.into_iter().collect()
    }
}

/// Returns a name that both formats accept: letters, digits and `_`.
pub(super) fn identifier(name: &str) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let mut identifier: String = name.chars().map(letter).collect();
    if identifier.is_empty() || identifier.starts_with(|c: char| c.is_ascii_digit()) {
        identifier.insert(0, '_');
    }
    identifier
}
