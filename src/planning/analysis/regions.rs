//! The named regions of an analysis, in the same order for all engines.

use super::levels::Kind;
use super::run::Analysis;
use meliora_engine::Engine;
use meliora_model::region::{LevelNumber, RegionName, members};

/// Returns the regions that are known so far: `unsafe` (under requirements), `target:A`, `almost-sure:A`, `positive:A`,
/// `class:A+B`, `bad` (of a game under `action`), `sasi:1`, `spi:unbounded`, …
pub fn regions<E: Engine>(analysis: &Analysis<E>) -> Vec<(RegionName, &E::States)> {
    let mut regions = Vec::new();
    let preferences = analysis.preferences();
    if let Some(requirements) = analysis.requirements() {
        regions.push((RegionName::Unsafe, &requirements.unsafe_states));
    }
    for (index, objective) in preferences.objectives.iter().enumerate() {
        let name = || objective.name.clone();
        if let Some(outcome) = analysis.outcomes().and_then(|o| o.get(index)) {
            regions.push((RegionName::Target(name()), &outcome.target));
            regions.push((RegionName::AlmostSure(name()), &outcome.almost_sure));
            regions.push((RegionName::Positive(name()), &outcome.positive));
        }
    }
    for class in analysis.classes().iter().flat_map(|c| &c.list) {
        let name = members(&preferences.names(&class.most_preferred));
        regions.push((RegionName::Class(name), &class.states));
    }
    if let Some(bad) = analysis.bad() {
        regions.push((RegionName::Bad, bad));
    }
    for &kind in Kind::ALL {
        let levels = analysis.levels(kind);
        for (number, level) in (1..).zip(&levels.found) {
            regions.push((RegionName::Level(kind, LevelNumber::Finite(number)), &level.states));
        }
        if let Some(level) = levels.unbounded() {
            regions.push((RegionName::Level(kind, LevelNumber::Unbounded), &level.states));
        }
    }
    regions
}
