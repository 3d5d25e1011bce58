//! The named regions of an analysis, in the same order for all engines.

use super::levels::Kind;
use super::run::Analysis;
use meliora_engine::Engine;
use meliora_model::names;

/// Returns the regions that are known so far: `unsafe` (under requirements), `target:A`, `almost-sure:A`, `positive:A`,
/// `class:A+B`, `bad` (of a game under `action`), `sasi:1`, `spi:unbounded`, …
pub fn regions<E: Engine>(analysis: &Analysis<E>) -> Vec<(String, &E::States)> {
    let mut regions = Vec::new();
    let preferences = analysis.preferences();
    if let Some(requirements) = analysis.requirements() {
        regions.push((names::UNSAFE.to_owned(), &requirements.unsafe_states));
    }
    for (index, objective) in preferences.objectives.iter().enumerate() {
        let name = &objective.name;
        if let Some(outcome) = analysis.outcomes().and_then(|o| o.get(index)) {
            regions.push((names::target(name), &outcome.target));
            regions.push((names::almost_sure(name), &outcome.almost_sure));
            regions.push((names::positive(name), &outcome.positive));
        }
    }
    for class in analysis.classes().iter().flat_map(|c| &c.list) {
        let name = names::members(&preferences.names(&class.most_preferred));
        regions.push((names::class(&name), &class.states));
    }
    if let Some(bad) = analysis.bad() {
        regions.push((names::BAD.to_owned(), bad));
    }
    for &kind in Kind::ALL {
        let levels = analysis.levels(kind);
        for (index, level) in levels.found.iter().enumerate() {
            regions.push((names::level(kind.name(), index + 1), &level.states));
        }
        if let Some(level) = levels.unbounded() {
            regions.push((names::level(kind.name(), names::UNBOUNDED), &level.states));
        }
    }
    regions
}
