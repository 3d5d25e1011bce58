//! From an analysis to files: dumps with certificates, values, shields, and models state by state;
//! and projections of regions to two variables, for maps.
//!
//! - [`export()`] builds a [`Dump`] of the regions that its [`DumpContent`] names.
//! - [`explicit::Graph`]: states and choices one by one, in several formats.
//! - [`projections::Projections`]: regions over two variables.
//!
//! | Roots of `certificate.dddmp` | meaning |
//! | --- | --- |
//! | `layers:R:j` | the states of region R in layers that lead to its goal; layer 0 is at the goal |
//! | `layers:secured:A:d:i:j` | the states of `secured:A:d` in layers that lead to the i-th mark that recurs |
//! | `refuted:R:j` | the states outside of R, in the rounds that remove them; the rounds cover all such states |
//! | `refuted:unsafe:j` | the states of `unsafe`, in the rounds that remove them |
//! | `safe:C` | under `prefix`, the states from which a strategy avoids weakening class C forever |
//! | `sasi:k@C`, `strategy:sasi:k@C` | under `prefix`, level k with reference class C; for the level after the last one, a superset of the states that win it |
//!
//! # An example
//!
//! ```
//! use std::sync::Arc;
//!
//! use meliora_engine::{Settings, SymbolicEngine};
//! use meliora_export::{Inputs, DumpContent, export};
//! use meliora_base::error::SourceFile;
//! use meliora_planning::{Analysis, Options};
//!
//! let model = "mdp module m x : [0..2] init 0; [] x<2 -> (x'=x+1); [] x=2 -> true; endmodule";
//! let wishes = "objective Near = F x=1; objective Far = F x=2; prefer Far > Near;";
//! let none = SourceFile::new("--const", "");
//! let program = meliora_lang::load(&SourceFile::new("m.prism", model), &none)?.program;
//! let meliora_lang::Task { program, preferences } = meliora_lang::load_preferences(&SourceFile::new("m.pref", wishes), program)?;
//! let engine = SymbolicEngine::new(Arc::new(program), Settings::default())?;
//! let mut analysis = Analysis::new(&Arc::new(engine), &Arc::new(preferences), Options::default());
//! analysis.run(&mut |_| ())?;
//! let inputs = Inputs { model: ("m.prism".into(), "…".into()), preferences: ("m.pref".into(), "…".into()) };
//! let all = DumpContent { wanted: &|_| true, certificate: true };
//! let dump = export(&analysis, &inputs, &all)?;
//! assert_eq!(dump.manifest.regions.root("reachable").unwrap().count, "3");
//! # Ok::<(), meliora_base::error::Error>(())
//! ```

pub mod bounds;
mod certificate;
mod describe;
pub mod explicit;
mod layers;
pub mod projections;
pub mod questions;
mod regions;
mod removal;
mod shield;
mod whole_paths;

use certificate::Certificate;
pub use describe::Inputs;
use meliora_base::error::{Error, Limit, Result};
use meliora_dump::manifest::{self, File, Root, RootKind, SafetyMode};
use meliora_dump::{Diagram, Dump};
use meliora_engine::symbolic::{Set, SymbolicEngine};
use meliora_engine::{Algebra, Engine};
use meliora_model::preference::{Goal, Objective};
use meliora_model::region::{NOTHING, RegionName};
use meliora_model::trend::{Digit, Trend};
use meliora_planning::levels::End;
use meliora_planning::{Analysis, Kind, Safety};
pub use shield::{read_shield, write_shield};

/// The content of a dump.
pub struct DumpContent<'a> {
    /// Selects regions by name; `reachable` and `initial` are always in the dump.
    pub wanted: &'a dyn Fn(&RegionName) -> bool,
    /// True if the dump gets a certificate; this needs all regions.
    pub certificate: bool,
}

/// A set with its name.
pub(crate) struct Named {
    pub(crate) name: RegionName,
    pub(crate) set: Set,
    pub(crate) trend: Option<Trend>,
}

impl Named {
    fn states(name: RegionName, x: &meliora_engine::symbolic::StateSet) -> Self {
        Named { name, set: Set::States(x.clone()), trend: None }
    }

    fn choices(name: RegionName, c: &meliora_engine::symbolic::ChoiceSet) -> Self {
        Named { name, set: Set::Choices(c.clone()), trend: None }
    }

    /// A layer or round.
    fn proof(name: RegionName, x: meliora_engine::symbolic::StateSet, trend: Option<Trend>) -> Self {
        Named { name, set: Set::States(x), trend }
    }
}

/// Builds the dump of a finished analysis. Cost: for the certificate, that of [`certify()`].
///
/// # Errors
/// The content matches no region; an objective is called `nothing`; an objective of a game is temporal; a limit is
/// reached.
pub fn export(
    analysis: &Analysis<SymbolicEngine>,
    inputs: &Inputs,
    content: &DumpContent<'_>,
) -> Result<Dump> {
    let over_paths = |o: &Objective| matches!(o.goal, Goal::Satisfy { .. });
    if analysis.whole_engine().is_game() && analysis.preferences().objectives.iter().any(over_paths) {
        let message = "a dump of a game with temporal objectives, or with `history = play`, is not supported; \
            `--format umb` writes its model";
        return Err(Error::Usage(message.to_owned()));
    }
    if analysis.preferences().objectives.iter().any(|o| o.name == NOTHING) {
        let message =
            "in a dump, the objective `nothing` cannot be distinguished from the class `nothing`; rename it";
        return Err(Error::Usage(message.to_owned()));
    }
    let engine = analysis.whole_engine();
    let mut named = regions::all(analysis)?;
    let always = |name: &RegionName| matches!(name, RegionName::Reachable | RegionName::Initial);
    named.retain(|n| always(&n.name) || (content.wanted)(&n.name));
    if !named.iter().any(|n| (content.wanted)(&n.name)) {
        return Err(Error::Usage("no region is selected: `--region` matches no name".to_owned()));
    }
    if named.iter().any(|n| n.name.is_strategy()) {
        // A reader can tell what a strategy leaves out only if all enabled choices are in the dump.
        if !named.iter().any(|n| n.name == RegionName::Choices) {
            named.push(Named::choices(RegionName::Choices, &engine.all_choices()));
        }
    }
    let paired = named.iter().any(|n| matches!(n.set, Set::Choices(_)));
    let choices = describe::choices(engine, paired);
    let (regions, diagram) = file(engine, manifest::REGIONS, &named, &choices.order)?;
    let options = analysis.options();
    let cut = |&kind: &Kind| matches!(analysis.levels(kind).end, Some(End::Cut));
    let subject = describe::Subject {
        engine,
        preferences: analysis.preferences(),
        inputs,
        safety: mode(options.safety),
        max_level: options.max_level.filter(|_| Kind::ALL.iter().any(cut)),
    };
    let manifest = subject.manifest(choices, regions, None);
    let mut dump = Dump { manifest, regions: diagram, certificate: None, values: None };
    let limit = if content.certificate { certify(&mut dump, analysis, &mut |_| ())? } else { None };
    limit.map_or(Ok(dump), |limit| Err(limit.into()))
}

/// Adds the certificate to the dump of a finished analysis, which has all regions. Calls `share(n)` before each
/// part, where n parts are left with this one, and `share(None)` after it, so that the caller can limit each part.
/// A limit that ends a part, but not the work, leaves out the sets of this part; the manifest names the regions
/// that are not proved for this reason. Returns the first such limit.
///
/// Cost: one fixpoint per layer or round of each region.
///
/// # Errors
/// A limit that ends the work.
pub fn certify(
    dump: &mut Dump,
    analysis: &Analysis<SymbolicEngine>,
    share: &mut dyn FnMut(Option<usize>),
) -> Result<Option<Limit>> {
    let regions = Vec::from_iter(dump.manifest.regions.roots.iter().map(|root| root.name.clone()));
    let certificate = Certificate::new(analysis, &regions, share)?;
    let (file, diagram) = proof(analysis.whole_engine(), &certificate, &dump.manifest.choices.order)?;
    (dump.manifest.certificate, dump.certificate) = (Some(file), Some(diagram));
    Ok(certificate.limit)
}

/// Returns the mode of a manifest.
fn mode(safety: Safety) -> SafetyMode {
    match safety {
        Safety::Action => SafetyMode::Action,
        Safety::Transition => SafetyMode::Transition,
        Safety::Prefix => SafetyMode::Prefix,
    }
}

/// Builds the diagram of a certificate, and its entry in the manifest without the hash. An order is in
/// it if some set has a trend of this order.
fn proof(
    engine: &SymbolicEngine,
    Certificate { named, trends, uncertified, .. }: &Certificate,
    bits: &[String],
) -> Result<(File, Diagram)> {
    let (mut certificate, diagram) = file(engine, manifest::CERTIFICATE, named, bits)?;
    let variables = &engine.program().variables;
    let digit = |digit: &Digit| {
        let variable = &variables[digit.variable.index()];
        let value = |offset: &u64| variable.low.wrapping_add_unsigned(*offset);
        manifest::Digit {
            variable: variable.name.clone(),
            reversed: digit.reversed,
            steady: digit.steady,
            values: digit.values.iter().map(value).collect(),
        }
    };
    certificate.uncertified.clone_from(uncertified);
    let written = |trends: &layers::Trends| trends.order.iter().map(digit).collect::<Vec<_>>();
    let mut with_trend = named.iter().filter(|set| set.trend.is_some());
    if let Some(rounds) = trends.apart().filter(|_| with_trend.clone().any(|set| set.name.is_round())) {
        certificate.order_of_rounds = written(rounds);
    }
    if with_trend.next().is_some() {
        certificate.order = written(trends);
    }
    Ok((certificate, diagram))
}

/// Builds the diagram of named sets, and its entry in the manifest without the hash.
fn file(engine: &SymbolicEngine, path: &str, named: &[Named], bits: &[String]) -> Result<(File, Diagram)> {
    let sets: Vec<Set> = named.iter().map(|n| n.set.clone()).collect();
    let diagram = engine.diagram(&sets, bits)?;
    let sizes = diagram.sizes(&diagram.roots);
    let mut roots = Vec::with_capacity(named.len());
    for (position, (named, edge)) in named.iter().zip(&diagram.roots).enumerate() {
        let (kind, count) = match &named.set {
            Set::States(x) => (RootKind::States, engine.count(x)?),
            Set::Choices(c) => (RootKind::Choices, engine.count(c)?),
        };
        roots.push(Root {
            name: named.name.to_string(),
            kind,
            root: position,
            node: *edge,
            nodes: sizes[position],
            count: count.to_string(),
            dot: None,
            trend: named.trend,
        });
    }
    let nodes = diagram.nodes.len() + 1;
    Ok((File { path: path.to_owned(), nodes, roots, ..File::default() }, diagram))
}
