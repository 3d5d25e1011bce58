//! Planning problems in PDDL: fully observable nondeterministic (FOND) and probabilistic (PPDDL) tasks
//! become flat programs, which all of Meliora can analyse.
//!
//! [`load`] reads a domain and a problem, grounds them, groups facts by invariants, and returns a
//! [`Planned`] program: one variable for each group, one command for each ground action.
//!
//! ```
//! use meliora_base::error::SourceFile;
//! use meliora_base::progress::NoProgress;
//!
//! let domain = "(define (domain d) (:predicates (at ?x))
//!     (:action go :parameters (?x ?y) :precondition (at ?x) :effect (oneof (and) (and (not (at ?x)) (at ?y)))))";
//! let problem = "(define (problem p) (:objects hall attic) (:init (at hall)) (:goal (at attic)))";
//! let sources = [SourceFile::new("domain.pddl", domain), SourceFile::new("problem.pddl", problem)];
//! let program = meliora_pddl::load(&sources, &NoProgress)?.program;
//! assert_eq!(program.variables[0].equation(1), "at=attic");
//! assert_eq!(program.actions, ["go(hall,hall)", "go(hall,attic)", "go(attic,hall)", "go(attic,attic)"]);
//! # Ok::<(), meliora_base::error::Error>(())
//! ```

mod check;
mod ground;
mod invariants;
mod lower;
mod measures;
mod recursion;
mod syntax;
mod task;

use std::sync::Arc;

use meliora_base::error::{Diagnostic, Result, SourceFile};
use meliora_base::progress::ProgressSink;
use meliora_model::Program;

/// A planning problem as a program.
#[derive(Debug, Clone)]
pub struct Planned {
    /// The program; its field `planning` has the names of the problem.
    pub program: Program,
    /// Notes, such as features that `:requirements` does not declare.
    pub warnings: Vec<Diagnostic>,
}

/// Returns whether a text is a planning problem, or a part of one: it begins with `(define`.
pub fn is_pddl(text: &str) -> bool {
    syntax::is_pddl(text)
}

/// The parts of a planning problem in a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Parts {
    /// True if it contains a domain.
    pub domain: bool,
    /// True if it contains a problem.
    pub problem: bool,
}

/// Returns the parts of a planning problem that begin in a text, none for other texts. Their lists need not
/// be complete.
pub fn parts(text: &str) -> Parts {
    if is_pddl(text) { syntax::parts(text) } else { Parts::default() }
}

/// Returns a domain and a problem as one text.
pub fn joined(sources: &[Arc<SourceFile>]) -> Arc<SourceFile> {
    match sources {
        [only] => Arc::clone(only),
        _ => {
            let names: Vec<&str> = sources.iter().map(|source| source.name.as_str()).collect();
            let texts: Vec<&str> = sources.iter().map(|source| source.text.as_str()).collect();
            SourceFile::new(names.join(" "), texts.join("\n"))
        }
    }
}

/// Reads a planning problem from the texts of its domain and its problem, or from one text with both.
///
/// # Errors
/// The texts are wrong: as many errors as can be distinguished, each with its place. A limit.
pub fn load(sources: &[Arc<SourceFile>], sink: &dyn ProgressSink) -> Result<Planned> {
    read(sources, false, sink)
}

/// Same as [`load`], without the facts on which no goal and no preference of the problem depends, and
/// without the actions that change only such facts. Conditions can name the facts that are left.
///
/// # Errors
/// See [`load`].
pub fn load_for_goals(sources: &[Arc<SourceFile>], sink: &dyn ProgressSink) -> Result<Planned> {
    read(sources, true, sink)
}

fn read(sources: &[Arc<SourceFile>], for_goals: bool, sink: &dyn ProgressSink) -> Result<Planned> {
    let mut nodes = Vec::new();
    for source in sources {
        let before = nodes.len();
        nodes.extend(syntax::parse(source, sink)?);
        if nodes.len() == before {
            let wrong = Diagnostic::new(source, 0..0, "the file contains no list");
            return Err(wrong
                .help("expected `(define (domain NAME) …)` or `(define (problem NAME) …)`")
                .into());
        }
    }
    let (task, warnings) = check::check(sources, &joined(sources), &nodes)?;
    drop(nodes);
    let mut ground = ground::ground(&task, sink)?;
    // An action that is left out may have the name of another one.
    if for_goals && !task.may_double_names() {
        ground.keep_relevant();
    }
    let groups = invariants::groups(&ground, sink)?;
    Ok(Planned { program: lower::lower(&task, &ground, &groups, sink)?, warnings })
}

#[cfg(test)]
mod tests;
