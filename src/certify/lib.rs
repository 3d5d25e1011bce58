//! Re-checks a dump as a certificate: by one-step conditions, without any fixpoint. It uses neither
//! planning nor quantities nor the export, so a mistake there is not repeated here.
//!
//! - [`verify`]: checks a dump against a model and its preferences.
//! - [`Verdict`]: the sets that were checked, and the [`Violation`] if there is one.
//! - [`policy`]: checks of policies, state by state, without an engine.
//!
//! ```
//! use std::sync::Arc;
//!
//! use meliora_certify::{Hashes, verify};
//! use meliora_dump::Dump;
//! use meliora_engine::Settings;
//! use meliora_base::error::Result;
//! use meliora_model::{Program, preference::Preferences};
//!
//! fn is_right(dump: &Dump, program: &Arc<Program>, preferences: &Preferences) -> Result<bool> {
//!     let hashes = Hashes { model: "0123…", preferences: "4567…" };
//!     let verdict = verify(program, preferences, hashes, dump, Settings::default())?;
//!     Ok(verdict.is_accepted())
//! }
//! ```
//!
//! Layers and rounds may have a *trend*. A state is read as a number, its variables in the order
//! that the manifest names, the first one most significant; greater values of a reversed variable
//! make it smaller, and the values of a variable may have an order of their own. Rising steps read the
//! steady variables in the other direction, and rounds may have an order of their own: any total order of
//! the states will do. A step s → t falls if t < s. Let Y_0 = T, and let each state of a falling layer
//! Y_j have a permitted choice with a falling step into Y_0 ∪ … ∪ Y_j. By induction over the number
//! of a state within its layer, each reaches T: its step enters an earlier layer, or a smaller
//! state of the same layer. Let each choice of each state of a falling round L_j have a step into
//! L_0 ∪ … ∪ L_{j-1}, or a falling step into L_j. Then no L_j has a state of the region W: in the
//! first one that had, the choice of a winning strategy in its least state of W would lead into W
//! only, so neither into an earlier round nor to a smaller state of L_j. For rising ones, read
//! *greater*. One pre-image thus checks a layer, however long its paths are.
//!
//! In a game, every condition is read with the player who chooses ([`Engine::can_choose`]): what some
//! choice does at our states, every choice does at the states of the opponent, and what each choice
//! does in a round at our states, some choice does at those of the opponent. A step into an earlier
//! layer then counts in a layer with a trend, too, because different choices of the opponent may lead
//! on in different ways.
//!
//! [`Engine::can_choose`]: meliora_engine::Engine::can_choose
//!
//! Only the transition relation is rebuilt. A second evaluation, which shares no arithmetic with
//! the first, confirms constants, and the choices and successors of some states. Each region is
//! checked against a condition on one step. Induction over the layers and rounds of the dump then
//! shows that the region is neither too large nor too small.
//!
//! After the check of `unsafe`, all conditions are about the model that the requirements leave.
//!
//! All fields of the manifest are derived anew and compared. A set that no check uses is refused,
//! in either file. `docs/dumps.md` says what an accepted dump guarantees.
//!
//! | Region | not too large | not too small |
//! | --- | --- | --- |
//! | `reachable` | layers from the initial states | closed under all choices |
//! | `player:p` | the states in which the choices of this player are enabled | |
//! | `bad` | layers towards a weakening choice of the opponent | no choice of the opponent enters it from outside |
//! | `unsafe` | removal rounds | the other states violate nothing, and have a choice that stays among them |
//! | `secured:A:d` | closed under its strategy, layers towards each mark that recurs | removal rounds |
//! | `positive:A` | layers towards the target | no choice enters it from outside |
//! | `almost-sure:A` | closed under its strategy, layers towards the target | removal rounds |
//! | `initial`, `deadlock`, `choices`, `target:A`, `class:C`, strategies | equal to what the model and the regions say | |
//! | `sasi:k` | closed under its strategy, layers towards a goal edge | removal rounds |
//! | `spi:k` | layers towards a goal edge | no kept choice enters it from outside |
//!
//! A certificate may say that it does not prove some regions: those on which a limit ended the work. They are
//! not checked, nor is anything that depends on them; all other conditions are.
//!
//! The bounds of quantities in `values.csv` are confirmed by one step per state, and by ranks.

mod arena;
mod bellman;
mod bounds;
mod checker;
mod condition;
mod description;
mod error;
mod evaluation;
mod levels;
mod manifest_check;
mod outcomes;
pub mod policy;
mod safe;
mod safety;
mod sample;
mod sets;
mod table;
mod temporal;
mod transitions;
mod trends;

use std::path::Path;
use std::sync::Arc;

use serde::Serialize;

use checker::Checker;
pub use condition::Condition;
use error::CheckError;
pub use manifest_check::INFORMATIVE;
use meliora_base::error::{Error, Result};
use meliora_dump::directory::read_directory;
use meliora_dump::manifest::{FILE, VALUES};
use meliora_dump::{Dump, dot};
use meliora_engine::{ProgressSink, Settings};
use meliora_model::preference::Preferences;
use meliora_model::region::RegionName;
use meliora_model::{Program, State};

/// The result of [`verify`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Verdict {
    /// The checked regions, in order.
    pub checked: Vec<Checked>,
    /// The first condition that is violated; none if all are satisfied.
    pub violation: Option<Violation>,
    /// The names of the regions, and of `values.csv`, that the certificate does not prove and says so. Nothing is
    /// known of them, except for `reachable`, which has all reachable states then.
    pub uncertified: Vec<String>,
}

impl Verdict {
    /// Returns whether all conditions are satisfied, and all regions proved.
    pub fn is_accepted(&self) -> bool {
        self.violation.is_none() && self.uncertified.is_empty()
    }
}

/// A region that was checked.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Checked {
    /// Its name.
    pub region: String,
    /// True if it was shown to have no state too many.
    pub inside: bool,
    /// True if it was shown to have no state too few.
    pub outside: bool,
}

/// A violated condition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Violation {
    /// The condition.
    pub condition: Condition,
    /// A state that violates it, if the condition is about states.
    pub state: Option<State>,
}

/// The SHA-256 of the present texts of model and preferences, in hexadecimal digits.
#[derive(Debug, Clone, Copy)]
pub struct Hashes<'a> {
    /// The SHA-256 of the model.
    pub model: &'a str,
    /// The SHA-256 of the preferences.
    pub preferences: &'a str,
}

/// Reads the dump in a directory once, for all checks. Returns it with the fault of its pictures, if
/// there is one. Cost: no image.
///
/// # Errors
/// A file cannot be read, or is not that of a dump; the work is cancelled.
pub fn read(directory: &Path, sink: &dyn ProgressSink) -> Result<(Dump, Option<Violation>)> {
    let mut dump = read_directory(directory, true, sink)?;
    loop {
        let picture = pictures(directory, &dump, sink)?;
        let again = picture.as_ref().map(|_| read_directory(directory, true, sink)).transpose()?;
        match again.filter(|again| again.manifest != dump.manifest) {
            Some(again) => dump = again,
            None => return Ok((dump, picture)),
        }
    }
}

/// Checks a dump against the program and the preferences that it claims to be made from.
///
/// Cost: at most two images per layer or round and part of its edges; for each trend that occurs,
/// the relations with its steps.
///
/// # Errors
/// A limit is reached; a command has no meaning in a state of the dump.
pub fn verify(
    program: &Arc<Program>,
    preferences: &Preferences,
    hashes: Hashes<'_>,
    dump: &Dump,
    settings: Settings,
) -> Result<Verdict> {
    let mut verdict = Verdict { checked: Vec::new(), violation: None, uncertified: Vec::new() };
    match run(program, preferences, hashes, dump, settings, &mut verdict) {
        Ok(()) => Ok(verdict),
        Err(CheckError::Violation(violation)) => Ok(Verdict { violation: Some(violation), ..verdict }),
        Err(CheckError::Error(error)) => Err(error),
    }
}

/// Checks that the DOT files named by a manifest are the pictures of its regions.
pub fn pictures(directory: &Path, dump: &Dump, sink: &dyn ProgressSink) -> Result<Option<Violation>> {
    let file = &dump.manifest.regions;
    let found = dot::false_picture(file, &dump.regions, directory, sink);
    let wrong = found.map_err(|e| sink.stop().map_or(Error::writing(directory, &e), Error::from))?;
    let named = dump.manifest.certificate.iter().flat_map(|f| &f.roots).find(|r| r.dot.is_some());
    let wrong = wrong.or(named.map(|root| root.name.as_str()));
    Ok(wrong.map(|name| Violation { condition: Condition::Picture { name: name.to_owned() }, state: None }))
}

fn run(
    program: &Arc<Program>,
    preferences: &Preferences,
    hashes: Hashes<'_>,
    dump: &Dump,
    settings: Settings,
    verdict: &mut Verdict,
) -> Result<(), CheckError> {
    let manifest = &dump.manifest;
    manifest_check::inputs(manifest, hashes)?;
    manifest.check_file(FILE, &manifest.regions, &dump.regions)?;
    if let (Some(file), Some(diagram)) = (&manifest.certificate, &dump.certificate) {
        manifest.check_file(FILE, file, diagram)?;
    }
    let mut checker = Checker::new(program, preferences, dump, settings)?;
    manifest_check::players(program, manifest)?;
    manifest_check::all(&checker.engine, preferences, hashes, manifest)?;
    manifest_check::is_supported(&checker.engine, preferences, manifest)?;
    checker.scope()?;
    checker.counts()?;
    transitions::check(&checker)?;
    let result = regions(&mut checker);
    verdict.checked.append(&mut checker.checked);
    verdict.uncertified.append(&mut checker.uncertified);
    if !result? && dump.values.is_some() {
        verdict.uncertified.push(VALUES.to_owned());
    }
    Ok(())
}

/// Checks all regions that the certificate proves, each after those that it depends on, and the bounds.
/// Returns whether the bounds were checked.
fn regions(checker: &mut Checker<'_>) -> Result<bool, CheckError> {
    let proved = proved(checker)?;
    checker.nothing_else()?;
    let Some((arenas, levels)) = proved else { return Ok(false) };
    bounds::check(checker, &arenas, &levels).map(|()| true)
}

/// Checks the regions that the certificate proves. Returns the arenas and levels if these are all.
fn proved(checker: &mut Checker<'_>) -> Result<Option<levels::Proved>, CheckError> {
    if checker.lacks(|name| *name == RegionName::Unsafe) {
        return Ok(None);
    }
    safe::requirements(checker)?;
    let Some(classes) = outcomes::check(checker)? else { return Ok(None) };
    levels::check(checker, classes)
}
