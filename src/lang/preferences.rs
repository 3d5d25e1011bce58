//! Preference files over a finished program: targets, names of objectives, the preorder.

use std::sync::Arc;

use ahash::AHashMap;

use super::check::{MAX_ERRORS, lower_target};
use crate::ast::{Ident, Span};
use crate::ltl::{Formula, Monitoring};
use crate::players;
use crate::pref::{self, Chain};
use meliora_model::Program;
use meliora_model::error::{Diagnostic, Error, Result, SourceFile};
use meliora_model::preference::{
    Contradiction, Empty, Goal, History, Objective, Outline, Preferences, Preorder, Relation, Requirement,
    Statement,
};
use meliora_model::temporal::Begin;

/// The name of the monitors of requirements.
const REQUIREMENT: &str = "require";
/// Maximum number of objectives of a preference file.
const MOST_OBJECTIVES: usize = 1_000;
/// Maximum number of pairs of objectives that the statements of a preference file relate.
const MOST_PAIRS: usize = 1_000_000;

/// Parses a preference file and lowers its targets into the pool of the program.
///
/// # Errors
/// Returns as many errors as can be distinguished: syntax errors, or else errors of meaning.
pub fn load_preferences(source: &Arc<SourceFile>, program: &mut Program) -> Result<Preferences> {
    lower_preferences(&pref::parse_preferences(source)?, source, program)
}

/// Checks a preference file: targets refer to names of the model, objectives are known and declared
/// once, and the order has no contradiction.
///
/// # Errors
/// All errors, each with its place; a contradiction with the statements of its cycle.
pub(crate) fn lower_preferences(
    tree: &pref::Preferences,
    source: &Arc<SourceFile>,
    program: &mut Program,
) -> Result<Preferences> {
    let mut checker = Checker { source, known: AHashMap::new(), diagnostics: Vec::new() };
    let history = checker.history(tree);
    if let Some((names, span)) = &tree.coalition {
        match players::coalition(program, source, names, *span) {
            Ok(coalition) => program.players.iter_mut().for_each(|players| players.take(&coalition)),
            Err(Error::Input(wrong)) => wrong.into_iter().for_each(|d| checker.report(d)),
            Err(other) => return Err(other),
        }
    }
    let (objectives, requirements) = match history {
        History::State => {
            let objectives = checker.objectives(tree, |o| target(program, source, o))?;
            (objectives, checker.requirements(tree, |formulas| invariants(program, source, formulas))?)
        }
        History::Play => {
            let mut watching = Monitoring::new(program);
            let objectives = checker.objectives(tree, |o| watched(&mut watching, source, o))?;
            let requirements = checker.requirements(tree, |formulas| {
                watching.require(formulas.iter().map(|formula| (source, formula)), REQUIREMENT)
            })?;
            if checker.diagnostics.is_empty() {
                watching.finish(Begin::Initially)?;
            }
            (objectives, requirements)
        }
    };
    let order = checker.order(tree)?;
    let empty = tree.empty.map_or_else(Empty::default, |(empty, _)| empty);
    Ok(Preferences { objectives, order, empty, history, requirements })
}

/// Parses a preference file without a model; the names in its formulas are not checked.
///
/// # Errors
/// Returns all other errors that can be distinguished: syntax errors, or else errors of the order.
pub fn outline_preferences(source: &Arc<SourceFile>) -> Result<Outline> {
    let tree = pref::parse_preferences(source)?;
    let mut checker = Checker { source, known: AHashMap::new(), diagnostics: Vec::new() };
    for (index, objective) in tree.objectives.iter().enumerate().take(MOST_OBJECTIVES + 1) {
        checker.declare(index, objective);
    }
    checker.expect_some(&tree);
    let formula = |f: &Formula| source.text[f.span.range()].to_owned();
    Ok(Outline {
        history: checker.history(&tree),
        order: checker.order(&tree)?,
        objectives: tree.objectives.iter().map(|o| (o.name.name.clone(), formula(&o.formula))).collect(),
        requirements: tree.requirements.iter().map(formula).collect(),
        empty: tree.empty.map_or_else(Empty::default, |(empty, _)| empty),
    })
}

/// Returns an objective as a target in a program.
///
/// # Errors
/// The formula is wrong, or not of the form `F condition`.
fn target(program: &mut Program, source: &Arc<SourceFile>, objective: &pref::Objective) -> Result<Goal> {
    match objective.formula.reachability() {
        Some(target) => Ok(Goal::Reach(lower_target(program, source, target)?)),
        None => {
            let message = "`history = state` accepts only reachability formulas, `F condition`";
            let diagnostic = Diagnostic::new(source, objective.formula.span.range(), message);
            let help = "`history = play;` judges whole paths and accepts temporal formulas";
            Err(diagnostic.label("not of the form `F condition`").help(help).into())
        }
    }
}

/// Returns an objective as a condition on monitors.
///
/// # Errors
/// The formula is wrong or not supported.
fn watched(
    watching: &mut Monitoring<'_>,
    source: &Arc<SourceFile>,
    objective: &pref::Objective,
) -> Result<Goal> {
    let condition = watching.watch(source, &objective.formula, &objective.name.name)?;
    let (decided, monitor) = (watching.decided(&condition), watching.states_of(&condition));
    Ok(Goal::Satisfy { condition, decided, monitor })
}

/// Returns requirements `G condition` as the states in which the conditions are true.
///
/// # Errors
/// A formula is wrong, or needs a monitor; each with its place.
fn invariants(
    program: &mut Program,
    source: &Arc<SourceFile>,
    formulas: &[Formula],
) -> Result<Vec<Requirement>> {
    let all = formulas.iter().map(|formula| (source, formula));
    let required = Monitoring::new(program).require(all, REQUIREMENT)?;
    let wrong = |(_, formula): (&Requirement, &Formula)| {
        let message = "only requirements of the form `G condition` are accepted here";
        let help = "`history = play;` in a preference file judges whole paths and accepts every safe formula";
        let diagnostic = Diagnostic::new(source, formula.span.range(), message);
        diagnostic.label("not of the form `G condition`").help(help)
    };
    let watched = required.iter().zip(formulas).filter(|(requirement, _)| requirement.monitor.is_some());
    let wrong: Vec<Diagnostic> = watched.map(wrong).collect();
    if wrong.is_empty() { Ok(required) } else { Err(Error::Input(wrong)) }
}

struct Checker<'a> {
    source: &'a Arc<SourceFile>,
    /// Position and place of each objective.
    known: AHashMap<&'a str, (usize, Span)>,
    diagnostics: Vec<Diagnostic>,
}

impl<'a> Checker<'a> {
    /// Returns the part of a path that counts: by default all of it if some objective is more than
    /// a reachability.
    fn history(&self, tree: &pref::Preferences) -> History {
        let temporal = tree.objectives.iter().any(|o| o.formula.reachability().is_none());
        match tree.history {
            Some((history, _)) => history,
            None if temporal => History::Play,
            None => History::State,
        }
    }

    /// Returns the objectives with their goals; errors in them are recorded.
    fn objectives(
        &mut self,
        tree: &'a pref::Preferences,
        mut goal: impl FnMut(&pref::Objective) -> Result<Goal>,
    ) -> Result<Vec<Objective>> {
        let mut objectives = Vec::new();
        for (index, objective) in tree.objectives.iter().enumerate() {
            if !self.declare(index, objective) {
                break;
            }
            match goal(objective) {
                Ok(goal) => {
                    let (name, span) = (objective.name.name.clone(), Some(objective.span.range()));
                    objectives.push(Objective { name, goal, span });
                }
                Err(Error::Input(wrong)) => wrong.into_iter().for_each(|d| self.report(d)),
                Err(other) => return Err(other),
            }
        }
        self.expect_some(tree);
        Ok(objectives)
    }

    /// Returns the requirements; errors in them are recorded.
    fn requirements(
        &mut self,
        tree: &pref::Preferences,
        required: impl FnOnce(&[Formula]) -> Result<Vec<Requirement>>,
    ) -> Result<Vec<Requirement>> {
        match required(&tree.requirements) {
            Err(Error::Input(wrong)) => {
                wrong.into_iter().for_each(|d| self.report(d));
                Ok(Vec::new())
            }
            known => known,
        }
    }

    /// Records the name of an objective; returns false if there are too many.
    fn declare(&mut self, index: usize, objective: &'a pref::Objective) -> bool {
        let Ident { name, span } = &objective.name;
        if index == MOST_OBJECTIVES {
            let message = format!("there are more than {MOST_OBJECTIVES} objectives");
            self.report(Diagnostic::new(self.source, span.range(), message));
            return false;
        }
        if let Some((_, first)) = self.known.get(name.as_str()) {
            let message = format!("the objective `{name}` is declared twice");
            let diagnostic = Diagnostic::new(self.source, span.range(), message).label("declared again");
            self.report(diagnostic.related(first.range(), "declared here first"));
        } else {
            self.known.insert(name, (index, *span));
        }
        true
    }

    fn expect_some(&mut self, tree: &pref::Preferences) {
        if tree.objectives.is_empty() {
            let diagnostic = Diagnostic::new(self.source, 0..0, "the file declares no objective");
            self.report(diagnostic.help("write `objective NAME = F (condition);`"));
        }
    }

    /// Returns the order that the statements generate, unless there are errors so far.
    fn order(mut self, tree: &'a pref::Preferences) -> Result<Preorder> {
        let (statements, spans) = self.statements(tree);
        if !self.diagnostics.is_empty() {
            return Err(Error::Input(self.diagnostics));
        }
        Preorder::new(tree.objectives.len(), &statements)
            .map_err(|found| contradiction(self.source, &tree.objectives, &found, &statements, &spans))
    }

    fn report(&mut self, diagnostic: Diagnostic) {
        if self.diagnostics.len() < MAX_ERRORS {
            self.diagnostics.push(diagnostic);
        }
    }

    /// Returns every pair related by a link of a chain, with the place of the chain.
    fn statements(&mut self, tree: &'a pref::Preferences) -> (Vec<Statement>, Vec<Span>) {
        let (mut statements, mut spans) = (Vec::new(), Vec::new());
        for chain in &tree.statements {
            for (left, relation, right) in self.pairs(chain) {
                statements.push(Statement { left, relation, right });
                spans.push(chain.span);
            }
            if statements.len() > MOST_PAIRS {
                let message = format!("the preferences compare more than {MOST_PAIRS} pairs");
                self.report(Diagnostic::new(self.source, chain.span.range(), message));
                break;
            }
        }
        (statements, spans)
    }

    fn pairs(&mut self, chain: &'a Chain) -> Vec<(usize, Relation, usize)> {
        let mut pairs = Vec::new();
        let mut left = self.side(&chain.first);
        for &(relation, ref names) in &chain.links {
            let right = self.side(names);
            for &x in &left {
                pairs.extend(right.iter().map(|&y| (x, relation, y)));
            }
            if pairs.len() > MOST_PAIRS {
                break;
            }
            left = right;
        }
        pairs
    }

    fn side(&mut self, names: &'a [Ident]) -> Vec<usize> {
        let (mut side, mut said) = (Vec::new(), ahash::AHashSet::new());
        for Ident { name, span } in names {
            match self.known.get(name.as_str()) {
                // Repeated names are ignored: on both sides they would multiply.
                Some((index, _)) if !said.insert(*index) => {}
                Some((index, _)) => side.push(*index),
                // The list of all names is long, so it is not built for errors that are never
                // shown.
                None if self.diagnostics.len() >= MAX_ERRORS => {}
                None => {
                    let message = format!("unknown objective `{name}`");
                    let diagnostic =
                        Diagnostic::new(self.source, span.range(), message).label("not declared");
                    let diagnostic = diagnostic.help(format!("the objectives are {}", self.names()));
                    self.report(diagnostic);
                }
            }
        }
        side
    }

    fn names(&self) -> String {
        let mut known: Vec<(usize, &str)> = self.known.iter().map(|(name, (i, _))| (*i, *name)).collect();
        known.sort_unstable();
        known.iter().map(|(_, name)| format!("`{name}`")).collect::<Vec<_>>().join(", ")
    }
}

/// Returns the error for a contradiction: it shows the cycle, `B > A >= C > B`, at the statement
/// that cannot hold.
fn contradiction(
    source: &Arc<SourceFile>,
    objectives: &[pref::Objective],
    found: &Contradiction,
    statements: &[Statement],
    spans: &[Span],
) -> Error {
    let name = |i: usize| objectives.get(i).map_or("?", |o| o.name.name.as_str());
    let mut cycle = String::new();
    for (&objective, &statement) in found.cycle.iter().zip(&found.statements) {
        let relation = statements.get(statement).map_or(Relation::Weak, |s| s.relation);
        cycle.push_str(&format!("{} {relation} ", name(objective)));
    }
    let first = found.cycle.first().map_or("?", |&i| name(i));
    let message = format!("the preferences contradict each other: {cycle}{first}");
    let place = |s: &usize| spans.get(*s).map_or(0..0, |span| span.range());
    let strict = found.statements.first().map_or(0..0, place);
    let mut diagnostic = Diagnostic::new(source, strict.clone(), message)
        .label(format!("`{first}` cannot be strictly better than itself"))
        .help("remove one of these statements, or change all of them to `>=` or `~`");
    for span in found.statements.iter().map(place) {
        if span != strict && !diagnostic.related.iter().any(|(other, _)| *other == span) {
            diagnostic = diagnostic.related(span, "together with this");
        }
    }
    diagnostic.into()
}
