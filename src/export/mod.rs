//! From an analysis to a dump: regions, strategies, and the certificate that `verify` checks.
//!
//! | Roots of `certificate.dddmp` | what they are |
//! | --- | --- |
//! | `layers:R:j` | the states of region R by their distance from its goal; layer 0 is at the goal |
//! | `refuted:R:j` | the states outside R in the rounds in which they are found to be lost |
//! | `safe:C` | under `prefix`, the states from which class C need never be weakened |
//! | `sasi:k@C`, `strategy:sasi:k@C` | under `prefix`, level k with C as the reference class |

mod certificate;
mod describe;
mod regions;

use crate::dump::manifest::{File, Kind, Root};
use crate::dump::{Diagram, Dump};
use crate::engine::symbolic::{Set, SymbolicEngine};
use crate::engine::{Count, Engine};
use crate::error::{Error, Result};
use crate::planning::Analysis;

/// The texts that an analysis was made from.
#[derive(Debug, Clone)]
pub struct Inputs {
    /// The model: its path, and the SHA-256 of its bytes.
    pub model: (String, String),
    /// The preferences: their path, and the SHA-256 of their bytes.
    pub preferences: (String, String),
}

/// What to put into a dump.
pub struct Selection<'a> {
    /// Which regions, by name; `reachable` and `initial` are always there.
    pub wanted: &'a dyn Fn(&str) -> bool,
    /// Whether the certificate is wanted; needs all regions.
    pub certificate: bool,
}

/// A set with its name.
pub(crate) struct Named {
    pub(crate) name: String,
    pub(crate) set: Set,
}

impl Named {
    fn states(name: impl Into<String>, x: &crate::engine::symbolic::StateSet) -> Self {
        Named { name: name.into(), set: Set::States(x.clone()) }
    }

    fn choices(name: impl Into<String>, c: &crate::engine::symbolic::ChoiceSet) -> Self {
        Named { name: name.into(), set: Set::Choices(c.clone()) }
    }
}

/// The dump of a finished analysis.
///
/// # Errors
/// Nothing has the names wanted; a limit. Cost: for the certificate, an image a layer of each region.
pub fn export(
    engine: &SymbolicEngine,
    analysis: &Analysis<'_, SymbolicEngine>,
    inputs: &Inputs,
    selection: &Selection<'_>,
) -> Result<Dump> {
    let mut named = regions::all(engine, analysis)?;
    let always = |name: &str| matches!(name, "reachable" | "initial");
    named.retain(|n| always(&n.name) || (selection.wanted)(&n.name));
    if !named.iter().any(|n| (selection.wanted)(&n.name)) {
        return Err(Error::Usage("no region has a name that `--region` matches".to_owned()));
    }
    if named.iter().any(|n| n.name.starts_with("strategy:")) {
        // What a strategy leaves out can only be told from all that is enabled.
        if !named.iter().any(|n| n.name == "choices") {
            named.push(Named::choices("choices", &engine.all_choices()));
        }
    }
    let certificate = if selection.certificate { Some(certificate::all(engine, analysis)?) } else { None };
    let mut sets = named.iter().chain(certificate.iter().flatten());
    let paired = sets.any(|n| matches!(n.set, Set::Choices(_)));
    let choices = describe::choices(engine, paired);
    let (regions, diagram) = file(engine, "regions.dddmp", &named, &choices.order)?;
    let certified = certificate.map(|named| file(engine, "certificate.dddmp", &named, &choices.order));
    let (certificate, layers) = certified.transpose()?.unzip();
    let manifest = describe::manifest(engine, analysis, inputs, choices, regions, certificate);
    Ok(Dump { manifest, regions: diagram, certificate: layers })
}

/// The labels of the choices by their numbers, or their commands where they have none; the self-loop of
/// deadlocks is last.
pub(crate) fn choice_labels(engine: &SymbolicEngine) -> Vec<String> {
    let numbers = describe::choices(engine, false).numbers;
    numbers.into_iter().map(|n| n.action.unwrap_or(n.name)).collect()
}

/// Named sets as a diagram, and what the manifest says of it but the hash.
fn file(engine: &SymbolicEngine, path: &str, named: &[Named], bits: &[String]) -> Result<(File, Diagram)> {
    let sets: Vec<Set> = named.iter().map(|n| n.set.clone()).collect();
    let diagram = engine.diagram(&sets, bits)?;
    let mut roots = Vec::with_capacity(named.len());
    for (position, (named, edge)) in named.iter().zip(&diagram.roots).enumerate() {
        let (kind, count) = match &named.set {
            Set::States(x) => (Kind::States, engine.count_states(x)?),
            Set::Choices(c) => (Kind::Choices, engine.count_choices(c)?),
        };
        roots.push(root(&named.name, kind, position, edge.number(), &count, &diagram));
    }
    let file = File { path: path.to_owned(), sha256: String::new(), nodes: diagram.nodes.len() + 1, roots };
    Ok((file, diagram))
}

fn root(name: &str, kind: Kind, position: usize, node: i32, count: &Count, diagram: &Diagram) -> Root {
    let edge = diagram.roots.get(position).copied();
    let nodes = edge.map_or(0, |e| diagram.size(e));
    Root { name: name.to_owned(), kind, root: position, node, nodes, count: count.to_string(), dot: None }
}
