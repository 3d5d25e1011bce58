//! Dumps of the regions of questions about paths, without preferences and without a certificate.

use super::{Named, file, regions};
use crate::describe::{self, Inputs};
use meliora_base::error::Result;
use meliora_dump::Dump;
use meliora_dump::manifest::{self, Question, SafetyMode};
use meliora_engine::Engine;
use meliora_engine::symbolic::{StateSet, SymbolicEngine};
use meliora_model::preference::{Empty, History, Preferences, Preorder, Requirement};
use meliora_model::region::RegionName;

/// A question with the regions that were computed for it.
pub struct Answered {
    /// Its number, from 1.
    pub number: usize,
    /// Its name in a property file.
    pub name: Option<String>,
    /// The target or the property as written.
    pub text: String,
    /// The target, if the question is to reach one.
    pub target: Option<StateSet>,
    /// The regions with their names.
    pub regions: Vec<(&'static str, StateSet)>,
    /// The coalition that a question about a game names, by player; `None` for that of the engine.
    pub coalition: Option<Vec<bool>>,
}

/// The requirements that every strategy keeps.
pub struct Kept<'a> {
    /// The requirements.
    pub requirements: &'a [Requirement],
    /// The states from which no strategy keeps them.
    pub unsafe_states: Option<&'a StateSet>,
}

/// Builds the dump of the regions of questions about one model, whose path and SHA-256 are given. A
/// single question has the regions `target`, `pmax_one`, …; of several, the regions of that with the number n are
/// called `target:n`, `pmax_one:n`, …. Cost: no image.
///
/// # Errors
/// A limit is reached.
pub fn export_regions(
    engine: &SymbolicEngine,
    model: (String, String),
    kept: &Kept<'_>,
    questions: Vec<Answered>,
) -> Result<Dump> {
    let mut named = vec![
        Named::states(RegionName::Reachable, &engine.all_states()),
        Named::states(RegionName::Initial, &engine.initial_states()),
        Named::states(RegionName::Deadlock, &engine.deadlock_states()),
    ];
    named.extend(regions::players(engine));
    named.extend(kept.unsafe_states.map(|states| Named::states(RegionName::Unsafe, states)));
    let several = questions.len() > 1;
    let (players, ours) = describe::players(engine);
    let mut described = Vec::new();
    for question in questions {
        let number = question.number;
        let written = |region: &str| if several { format!("{region}:{number}") } else { region.to_owned() };
        let name = |region: &str| RegionName::from(written(region).as_str());
        let target = question.target.iter().map(|states| Named::states(name("target"), states));
        let found = question.regions.iter().map(|(which, states)| Named::states(name(which), states));
        let own: Vec<Named> = target.chain(found).collect();
        let regions = own.iter().map(|named| named.name.to_string()).collect();
        let named_ones = |coalition: Vec<bool>| describe::members(&players, &coalition);
        let coalition = question.coalition.map_or_else(|| ours.clone(), named_ones);
        described.push(Question { name: question.name, text: question.text, regions, coalition });
        named.extend(own);
    }
    let choices = describe::choices(engine, false);
    let (regions, diagram) = file(engine, manifest::REGIONS, &named, &choices.order)?;
    let preferences = Preferences {
        objectives: Vec::new(),
        order: Preorder::default(),
        empty: Empty::Bottom,
        history: History::State,
        requirements: kept.requirements.to_vec(),
    };
    let inputs = Inputs { model, preferences: (String::new(), String::new()) };
    // Only choices that weaken depend on the safety mode; without preferences there are none.
    let (safety, max_level) = (SafetyMode::Action, None);
    let subject = describe::Subject { engine, preferences: &preferences, inputs: &inputs, safety, max_level };
    let mut manifest = subject.manifest(choices, regions, None);
    manifest.questions = described;
    Ok(Dump { manifest, regions: diagram, certificate: None, values: None })
}
