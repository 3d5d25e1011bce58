//! Re-checks a dump as a certificate: by one-step conditions, without any fixpoint.
//!
//! Only the transition relation is rebuilt. Each region is compared with what one step of it must
//! satisfy; that it is neither too large nor too small follows by induction over the layers and
//! rounds that the dump carries. Nothing of [`crate::planning`] is used here.
//!
//! | Region | not too large | not too small |
//! | --- | --- | --- |
//! | `reachable` | layers from the initial states | closed under all choices |
//! | `positive:A` | layers towards the target | no choice enters it from outside |
//! | `almost-sure:A` | closed under its strategy, layers towards the target | rounds of lost states |
//! | `class:C` | equal to what the regions say | |
//! | `sasi:k` | closed under its strategy, layers towards a goal edge | rounds of lost states |
//! | `spi:k` | layers towards a goal edge | no kept choice enters it from outside |

mod arena;
mod checker;
mod levels;
mod outcomes;

use std::sync::Arc;

use crate::dump::Dump;
use crate::engine::Settings;
use crate::error::Result;
use crate::model::preference::Preferences;
use crate::model::{Program, State};
use checker::{Checker, Stop};

/// What was found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verdict {
    /// The regions that were checked, in order.
    pub checked: Vec<Checked>,
    /// The first condition that does not hold; none where all do.
    pub violation: Option<Violation>,
}

/// A region that was checked.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Checked {
    /// Its name.
    pub region: String,
    /// Whether it was shown to be not too large.
    pub inside: bool,
    /// Whether it was shown to be not too small.
    pub outside: bool,
}

/// A condition that does not hold.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// The condition.
    pub condition: String,
    /// A state for which it fails.
    pub state: Option<State>,
}

/// Checks a dump against the program and the preferences that it is said to be made from.
///
/// `model` and `preferences_hash` are the SHA-256 of the texts as they are now.
///
/// # Errors
/// A limit; commands without a meaning in a state of the dump. Cost: two images a layer or round.
pub fn verify(
    program: &Arc<Program>,
    preferences: &Preferences,
    hashes: (&str, &str),
    dump: &Dump,
    settings: Settings,
) -> Result<Verdict> {
    let mut checked = Vec::new();
    match run(program, preferences, hashes, dump, settings, &mut checked) {
        Ok(()) => Ok(Verdict { checked, violation: None }),
        Err(Stop::Violation(violation)) => Ok(Verdict { checked, violation: Some(violation) }),
        Err(Stop::Error(error)) => Err(error),
    }
}

fn run(
    program: &Arc<Program>,
    preferences: &Preferences,
    hashes: (&str, &str),
    dump: &Dump,
    settings: Settings,
    checked: &mut Vec<Checked>,
) -> Result<(), Stop> {
    same_inputs(program, preferences, hashes, dump)?;
    let mut checker = Checker::new(program, preferences, dump, settings)?;
    checker.scope()?;
    checker.counts()?;
    let result = outcomes::check(&mut checker).and_then(|()| levels::check(&mut checker));
    checked.append(&mut checker.checked);
    result
}

/// The texts, the constants and the variables are those of the dump.
fn same_inputs(
    program: &Program,
    preferences: &Preferences,
    (model, prefs): (&str, &str),
    dump: &Dump,
) -> Result<(), Stop> {
    let manifest = &dump.manifest;
    let same = |what: &str, now: &str, then: &str| {
        let condition =
            || format!("{what} is the one that the dump was made from: it is {now}, the dump says {then}");
        if now == then { Ok(()) } else { Err(Stop::violated(condition(), None)) }
    };
    same("the SHA-256 of the model", model, &manifest.model.sha256)?;
    same("the SHA-256 of the preferences", prefs, &manifest.preferences.sha256)?;
    same("`empty`", &preferences.empty.to_string(), &manifest.empty)?;
    let objectives: Vec<&str> = preferences.objectives.iter().map(|o| o.name.as_str()).collect();
    same("the list of objectives", &objectives.join(", "), &manifest.objectives.join(", "))?;
    for (name, value) in &program.constants {
        let then =
            manifest.constants.get(name).map(|v| v.as_str().map_or_else(|| v.to_string(), str::to_owned));
        same(&format!("the constant `{name}`"), &value.to_string(), &then.unwrap_or_default())?;
    }
    let range = |name: &str, low: i64, high: i64| format!("{name} {low}..{high}");
    let now: Vec<String> = program.variables.iter().map(|v| range(&v.name, v.low, v.high)).collect();
    let then: Vec<String> =
        manifest.encoding.variables.iter().map(|v| range(&v.name, v.low, v.high)).collect();
    same("the list of variables", &now.join(", "), &then.join(", "))
}
