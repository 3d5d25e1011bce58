//! From arguments to what the library works on: files, programs, preferences, engines.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use meliora::engine::explicit::ExplicitEngine;
use meliora::engine::symbolic::{SymbolicEngine, order};
use meliora::engine::{Count, Settings};
use meliora::error::{Error, Limit, SourceFile};
use meliora::lang;
use meliora::lang::property::{Bound, Strategies};
use meliora::model::Program;
use meliora::model::expr::ExprId;
use meliora::model::preference::{Empty, Preferences};
use meliora::output::Number;

use super::options::{ModelArgs, PreferenceArgs};
use super::watch::Watch;

/// No text file of a sane model is larger; a device or a pipe without an end is.
const LARGEST_FILE: u64 = 256 << 20;

/// A model with preferences over it.
pub(super) struct Question {
    /// The model, with the targets in its pool.
    pub(super) program: Arc<Program>,
    /// The preferences.
    pub(super) preferences: Preferences,
}

/// A model with a target.
pub(super) struct Target {
    /// The model, with the target in its pool.
    pub(super) program: Arc<Program>,
    /// The target.
    pub(super) expression: ExprId,
    /// What `--property` asks of the initial states.
    pub(super) property: Option<(Strategies, Bound)>,
}

/// Reads a text file.
///
/// # Errors
/// It cannot be read, is too large or no UTF-8.
fn read(path: &Path) -> Result<Arc<SourceFile>, Error> {
    let name = path.display().to_string();
    let failed = |message: String| Error::Io { path: name.clone(), message };
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|f| f.take(LARGEST_FILE + 1).read_to_end(&mut bytes));
    read.map_err(|e| failed(e.to_string()))?;
    if bytes.len() as u64 > LARGEST_FILE {
        let what = format!("{name} has more than {} MiB", LARGEST_FILE >> 20);
        return Err(Limit::Size { what }.into());
    }
    match String::from_utf8(bytes) {
        Ok(text) => Ok(SourceFile::new(name, text)),
        Err(e) => {
            let at = e.utf8_error().valid_up_to();
            Err(failed(format!("this is no UTF-8 text: byte {at} does not belong there")))
        }
    }
}

fn parsed(args: &ModelArgs, watch: &Watch) -> Result<Program, Error> {
    let constants = SourceFile::new("--const", args.constants());
    let checked = lang::load(&read(&args.model)?, &constants)?;
    watch.warn_of(&checked.warnings);
    if checked.ignored_rewards > 0 {
        watch.note("rewards are read and ignored");
    }
    Ok(checked.program)
}

/// Reads the model.
///
/// # Errors
/// The file or the constants are wrong.
pub(super) fn program(args: &ModelArgs, watch: &Watch) -> Result<Arc<Program>, Error> {
    parsed(args, watch).map(Arc::new)
}

/// Reads the model and the preferences.
///
/// # Errors
/// A file or the constants are wrong.
pub(super) fn question(model: &ModelArgs, args: &PreferenceArgs, watch: &Watch) -> Result<Question, Error> {
    let mut program = parsed(model, watch)?;
    let source = read(&args.preferences)?;
    let preferences = temporary(&source, &mut program)?;
    Ok(Question { program: Arc::new(program), preferences })
}

/// Reads the model, and the target or the property.
///
/// # Errors
/// The file, the constants or the expression are wrong.
pub(super) fn target(
    args: &ModelArgs,
    target: Option<&str>,
    property: Option<&str>,
    watch: &Watch,
) -> Result<Target, Error> {
    let mut program = parsed(args, watch)?;
    let (source, tree, property) = match property {
        Some(text) => {
            let source = SourceFile::new("--property", text);
            let property = lang::parse_property(&source)?;
            (source, property.target, Some((property.strategies, property.bound)))
        }
        None => {
            let source = SourceFile::new("--target", target.unwrap_or_default());
            let tree = lang::parse_expression(&source)?;
            (source, tree, None)
        }
    };
    let expression = lang::lower_target(&mut program, &source, &tree)?;
    Ok(Target { program: Arc::new(program), expression, property })
}

/// What an engine is created with.
pub(super) fn settings(args: &ModelArgs, watch: &Arc<Watch>) -> Settings {
    Settings { scope: args.scope.into(), memory: args.memory(), observer: Arc::clone(watch) as _ }
}

/// The symbolic engine with the order that `--order` asks for.
///
/// # Errors
/// The order is wrong; the model has no meaning in some state; a limit.
pub(super) fn symbolic(
    program: &Arc<Program>,
    args: &ModelArgs,
    settings: Settings,
) -> Result<SymbolicEngine, Error> {
    let order = match args.order.as_str() {
        "auto" => order::auto(program),
        "declared" => order::declared(program),
        file => order::parse(program, &read(Path::new(file))?)?,
    };
    SymbolicEngine::new(Arc::clone(program), order, u32::from(args.threads), settings)
}

/// The explicit engine.
///
/// # Errors
/// The model has no meaning in some state; a limit.
pub(super) fn explicit(program: &Arc<Program>, settings: Settings) -> Result<ExplicitEngine, Error> {
    SymbolicEngine::new(Arc::clone(program), order::auto(program), 1, settings)
}

/// The name in reports.
pub(super) fn empty_name(empty: Empty) -> &'static str {
    match empty {
        Empty::Bottom => "bottom",
        Empty::Gain => "gain",
        Empty::Incomparable => "incomparable",
    }
}

/// Tells of states in which nothing is enabled.
pub(super) fn warn_of_deadlocks(watch: &Watch, deadlocks: &Count) {
    if *deadlocks != Count::ZERO {
        let count = Number(deadlocks.clone()).grouped();
        let noun = if count == "1" { "state is a deadlock: it" } else { "states are deadlocks: each" };
        watch.warn(&format!("{count} {noun} gets a self-loop"));
    }
}

fn temporary(source: &Arc<SourceFile>, program: &mut Program) -> Result<Preferences, Error> {
    use meliora::model::preference as p;
    let tree = lang::parse_preferences(source)?;
    let mut objectives = Vec::new();
    for o in &tree.objectives {
        let target = lang::lower_target(program, source, &o.target)?;
        objectives.push(p::Objective { name: o.name.name.clone(), target, span: Some(o.span.range()) });
    }
    let find = |n: &lang::ast::Ident| tree.objectives.iter().position(|o| o.name.name == n.name).unwrap();
    let mut statements = Vec::new();
    for chain in &tree.statements {
        let mut left = &chain.first;
        for (relation, right) in &chain.links {
            for l in left {
                for r in right {
                    let relation = match relation {
                        lang::pref::Relation::Strict => p::Relation::Strict,
                        lang::pref::Relation::Weak => p::Relation::Weak,
                        lang::pref::Relation::Indifferent => p::Relation::Indifferent,
                    };
                    statements.push(p::Statement { left: find(l), relation, right: find(r) });
                }
            }
            left = right;
        }
    }
    let order = p::Preorder::new(objectives.len(), &statements).unwrap();
    let empty = match tree.empty {
        Some((lang::pref::Empty::Gain, _)) => Empty::Gain,
        Some((lang::pref::Empty::Incomparable, _)) => Empty::Incomparable,
        _ => Empty::Bottom,
    };
    Ok(Preferences { objectives, order, empty })
}
