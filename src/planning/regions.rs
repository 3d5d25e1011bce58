//! All regions of an analysis by name, in one order for all engines.

use super::analysis::Analysis;
use super::levels::Kind;
use crate::engine::Engine;

/// The regions that are known so far: `target:A`, `almost-sure:A`, `positive:A`, `class:A+B`, `sasi:1`,
/// `spi:unbounded`, …
pub fn regions<'a, E: Engine>(analysis: &'a Analysis<'_, E>) -> Vec<(String, &'a E::States)> {
    let mut regions = Vec::new();
    let preferences = analysis.preferences();
    for (index, objective) in preferences.objectives.iter().enumerate() {
        if let Some(outcome) = analysis.outcomes().and_then(|o| o.get(index)) {
            regions.push((format!("target:{}", objective.name), &outcome.target));
            regions.push((format!("almost-sure:{}", objective.name), &outcome.almost_sure));
            regions.push((format!("positive:{}", objective.name), &outcome.positive));
        }
    }
    for class in analysis.classes().iter().flat_map(|c| &c.list) {
        let names = preferences.names(&class.most_preferred).join("+");
        let name = if names.is_empty() { "nothing" } else { &names };
        regions.push((format!("class:{name}"), &class.states));
    }
    for (kind, name) in [(Kind::Sasi, "sasi"), (Kind::Spi, "spi")] {
        let levels = analysis.levels(kind);
        for (index, level) in levels.found.iter().enumerate() {
            regions.push((format!("{name}:{}", index + 1), &level.states));
        }
        if let Some(level) = levels.unbounded() {
            regions.push((format!("{name}:unbounded"), &level.states));
        }
    }
    regions
}
