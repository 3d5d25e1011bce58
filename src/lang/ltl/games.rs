//! Temporal formulas in games: at most one monitor whose formula no finite prefix of a path decides.

use std::sync::Arc;

use super::formula::Formula;
use meliora_base::error::{Diagnostic, Error, Result, Severity, SourceFile};
use meliora_ltl::{FormulaId, Formulas, Leaf, Tree};
use meliora_model::temporal::Asks;

/// Returns leaves of the same formula for a game: next to co-safe and safe leaves, those of one monitor.
///
/// A Boolean combination of formulas of the class Π2 belongs to Π2, too. So leaves of recurrence are
/// joined with the co-safe and safe ones into a single leaf of recurrence. By duality, the same is true
/// of persistence.
///
/// # Errors
/// The formula combines recurrence and persistence of several monitors; the error points at one of each.
pub(super) fn in_a_game(
    all: &mut Formulas,
    source: &Arc<SourceFile>,
    formula: &Formula,
    tree: Tree,
) -> Result<Tree> {
    let mut undecided = Vec::new();
    collect(&tree, &mut undecided);
    let Some(first) = undecided.first().copied() else { return Ok(tree) };
    if undecided.iter().all(|leaf| leaf.watched == first.watched) {
        return Ok(tree);
    }
    if let Some(other) = undecided.iter().find(|leaf| leaf.asks != first.asks) {
        return Err(combined(source, &first, other));
    }
    let whole = joined(all, &tree);
    let watched = if first.asks == Asks::Again { whole } else { all.negated(whole) };
    Ok(Tree::Leaf(Leaf { asks: first.asks, watched, span: formula.span }))
}

/// Adds the leaves that no finite prefix decides.
fn collect(tree: &Tree, undecided: &mut Vec<Leaf>) {
    match tree {
        Tree::Leaf(leaf) if matches!(leaf.asks, Asks::Again | Asks::Settle) => undecided.push(*leaf),
        Tree::Leaf(_) | Tree::Constant(_) => {}
        Tree::All(parts) | Tree::Any(parts) => parts.iter().for_each(|part| collect(part, undecided)),
    }
}

/// Returns the formula of some leaves.
fn joined(all: &mut Formulas, tree: &Tree) -> FormulaId {
    match tree {
        Tree::Constant(value) => Formulas::constant(*value),
        Tree::Leaf(leaf) => match leaf.asks {
            Asks::Accept | Asks::Again => leaf.watched,
            Asks::Avoid | Asks::Settle => all.negated(leaf.watched),
        },
        Tree::All(parts) | Tree::Any(parts) => {
            let joint: Vec<FormulaId> = parts.iter().map(|part| joined(all, part)).collect();
            all.join(matches!(tree, Tree::All(_)), joint)
        }
    }
}

/// Returns the error for a formula of a game that combines recurrence and persistence.
fn combined(source: &Arc<SourceFile>, first: &Leaf, other: &Leaf) -> Error {
    let kind = |leaf: &Leaf| match leaf.asks {
        Asks::Again => "recurrence: something happens infinitely often",
        _ => "persistence: something holds from some step on",
    };
    let message = "a temporal formula of a game that combines recurrence and persistence is not supported";
    let diagnostic = Diagnostic::new(source, first.span.range(), message).severity(Severity::Unsupported);
    let help = "supported are combinations of one of them with formulas that a finite part of a path decides";
    diagnostic.label(kind(first)).related(other.span.range(), kind(other)).help(help).into()
}
