//! Preference files over a finished program: targets, names of objectives, the preorder.

use std::borrow::Borrow;
use std::sync::Arc;

use ahash::AHashMap;

use super::check::{MAX_ERRORS, lower_condition};
use crate::ast::{Ident, Span};
use crate::ltl::{self, Formula, Monitoring};
use crate::players;
use crate::pref::{self, Chain};
use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_model::Program;
use meliora_model::expr::{ExprId, ExprPool};
use meliora_model::planning;
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

/// A task of planning: a model and the preferences about its states.
#[derive(Debug, Clone)]
pub struct Task<P = Program> {
    /// The model as the preferences see it: the product with the monitors of whole paths, the game in which the
    /// coalition is ours, or else the given program.
    pub program: P,
    /// The preferences.
    pub preferences: Preferences,
}

/// Parses a preference file, and checks it: targets refer to names of the model, objectives are known
/// and declared once, and the order has no contradiction. Targets have pools of their own. Returns the
/// preferences with the program that they are about: with monitors, as for `history = play`, it is the
/// product with them; with a coalition, the game in which these players are ours.
///
/// # Errors
/// Returns as many errors as can be distinguished: syntax errors, or else errors of meaning, each with
/// its place; a contradiction with the statements of its cycle.
pub fn load_preferences<P: Borrow<Program> + From<Program>>(
    source: &Arc<SourceFile>,
    program: P,
) -> Result<Task<P>> {
    let (preferences, replaced) = lower_preferences(source, program.borrow())?;
    Ok(Task { program: replaced.map_or(program, P::from), preferences })
}

/// Returns the preferences of a file and, for whole paths or a coalition, the program that replaces the
/// given one: the product that judges paths, the game in which the coalition is ours.
fn lower_preferences(source: &Arc<SourceFile>, program: &Program) -> Result<(Preferences, Option<Program>)> {
    let tree = &pref::parse_preferences(source)?;
    let has_capitals = program.planning.is_none();
    let mut checker = Checker { source, known: AHashMap::new(), has_capitals, diagnostics: Vec::new() };
    let history = checker.history(tree);
    let coalition = checker.coalition(program, tree)?;
    let mut watching = Monitoring::new(program);
    let mut goals = checker.goals(tree, |objective| match history {
        History::State => target(program, watching.predicates.pool(), source, objective),
        History::Play => watched(&mut watching, source, objective),
    })?;
    let implied = implied(program, tree)?;
    for (objective, source) in &implied {
        checker.known.insert(&objective.name.name, (goals.len(), Span::default()));
        goals.push(match history {
            History::State => target(program, watching.predicates.pool(), source, objective)?,
            History::Play => watched(&mut watching, source, objective)?,
        });
    }
    checker.expect_some(goals.len());
    let requirements = checker.requirements(tree, |formulas| {
        let all = formulas.iter().map(|formula| (source, formula));
        let required = watching.require(all, REQUIREMENT)?;
        if history == History::State { without_monitors(source, required, formulas) } else { Ok(required) }
    })?;
    let order = checker.order(tree)?;
    let empty = tree.empty.map_or_else(Empty::default, |(empty, _)| empty);
    let (predicates, product) = match history {
        History::State => (watching.without_monitors(), None),
        History::Play => {
            let product = watching.finish(Begin::Initially)?;
            (product.predicates(), Some(product))
        }
    };
    let replaced = match coalition {
        Some(coalition) => {
            let mut game = product.unwrap_or_else(|| program.clone());
            game.play_as(&coalition);
            Some(game)
        }
        None => product,
    };
    let of = |id| predicates.get(id);
    let declared = tree.objectives.iter().map(|declared| (declared, Some(declared.span.range())));
    let all = declared.chain(implied.iter().map(|(implied, _)| (implied, None))).zip(goals);
    let objective = |((declared, span), goal): ((&pref::Objective, _), Goal<ExprId>)| Objective {
        name: declared.name.name.clone(),
        goal: goal.map(&of),
        span,
    };
    let objectives = all.map(objective).collect();
    let requirements = requirements.into_iter().map(|requirement| requirement.map(&of)).collect();
    Ok((Preferences { objectives, order, empty, history, requirements }, replaced))
}

/// Returns the objectives of a planning problem that a preference file does not declare itself, each
/// with the text of its formula.
fn implied(program: &Program, tree: &pref::Preferences) -> Result<Vec<(pref::Objective, Arc<SourceFile>)>> {
    let all = implied_objectives(program).into_iter();
    all.filter(|(name, _)| is_new(tree, name)).map(|(name, formula)| parsed(name, formula)).collect()
}

/// Returns whether a preference file declares no objective with a name of a planning problem.
fn is_new(tree: &pref::Preferences, name: &str) -> bool {
    tree.objectives.iter().all(|own| !own.name.name.eq_ignore_ascii_case(name))
}

fn parsed(name: String, formula: String) -> Result<(pref::Objective, Arc<SourceFile>)> {
    let source = SourceFile::new("the problem", formula);
    let formula = ltl::parse_formula(&source)?;
    let (name, span) = (Ident { name, span: Span::default() }, Span::default());
    Ok((pref::Objective { name, formula, span }, source))
}

/// Returns the objectives of a planning problem with their formulas: to reach the goal, or a state of the goal
/// in which a preference holds. A problem without a goal ends anywhere. None for other models.
pub fn implied_objectives(program: &Program) -> Vec<(String, String)> {
    let names = program.planning.iter().flat_map(|planning| &planning.objectives);
    let has_goal = names.clone().any(|name| name == planning::GOAL);
    let formula = |name: &String| match has_goal && name != planning::GOAL {
        true => format!("F (\"goal\" & \"{name}\")"),
        false => format!("F \"{name}\""),
    };
    names.map(|name| (name.clone(), formula(name))).collect()
}

/// Parses a preference file without a model; the names in its formulas are not checked.
///
/// # Errors
/// Returns all other errors that can be distinguished: syntax errors, or else errors of the order.
pub fn outline_preferences(source: &Arc<SourceFile>) -> Result<Outline> {
    outline_preferences_for(source, &[])
}

/// Does the same for a planning problem with these objectives, which the file need not declare: see
/// [`implied_objectives`].
///
/// # Errors
/// The errors of [`outline_preferences`].
pub fn outline_preferences_for(source: &Arc<SourceFile>, implied: &[(String, String)]) -> Result<Outline> {
    let tree = pref::parse_preferences(source)?;
    let has_capitals = implied.is_empty();
    let mut checker = Checker { source, known: AHashMap::new(), has_capitals, diagnostics: Vec::new() };
    for (index, objective) in tree.objectives.iter().enumerate().take(MOST_OBJECTIVES + 1) {
        checker.declare(index, objective);
    }
    let formula = |f: &Formula| source.text[f.span.range()].to_owned();
    let mut objectives: Vec<(String, String)> =
        tree.objectives.iter().map(|o| (o.name.name.clone(), formula(&o.formula))).collect();
    for (name, formula) in implied.iter().filter(|(name, _)| is_new(&tree, name)) {
        checker.known.insert(name, (objectives.len(), Span::default()));
        objectives.push((name.clone(), formula.clone()));
    }
    checker.expect_some(objectives.len());
    Ok(Outline {
        history: checker.history(&tree),
        order: checker.order(&tree)?,
        objectives,
        requirements: tree.requirements.iter().map(formula).collect(),
        empty: tree.empty.map_or_else(Empty::default, |(empty, _)| empty),
    })
}

/// Returns an objective as a target over a program.
///
/// # Errors
/// The formula is wrong, or not of the form `F condition`.
fn target(
    program: &Program,
    pool: &mut ExprPool,
    source: &Arc<SourceFile>,
    objective: &pref::Objective,
) -> Result<Goal<ExprId>> {
    match objective.formula.reachability() {
        Some(target) => Ok(Goal::Reach(lower_condition(program, pool, source, target)?)),
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
) -> Result<Goal<ExprId>> {
    let condition = watching.watch(source, &objective.formula, &objective.name.name)?;
    let (decided, monitor) = (watching.decided(&condition), watching.states_of(&condition));
    Ok(Goal::Satisfy { condition, decided, monitor })
}

/// Checks that requirements need no monitor: `G condition`.
///
/// # Errors
/// A formula needs a monitor; each with its place.
fn without_monitors(
    source: &Arc<SourceFile>,
    required: Vec<Requirement<ExprId>>,
    formulas: &[Formula],
) -> Result<Vec<Requirement<ExprId>>> {
    let wrong = |(_, formula): (&Requirement<ExprId>, &Formula)| {
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
    /// False if capitals do not count in names, as in planning problems.
    has_capitals: bool,
    diagnostics: Vec<Diagnostic>,
}

impl<'a> Checker<'a> {
    /// Returns the players that the file makes ours, an entry for each; `None` if it names none.
    fn coalition(&mut self, program: &Program, tree: &pref::Preferences) -> Result<Option<Vec<bool>>> {
        let Some((names, span)) = &tree.coalition else { return Ok(None) };
        match players::coalition(program, self.source, names, *span) {
            Err(Error::Input(wrong)) => wrong.into_iter().for_each(|diagnostic| self.report(diagnostic)),
            known => return known.map(Some),
        }
        Ok(None)
    }

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

    /// Returns the goals of the objectives; errors in them are recorded.
    fn goals(
        &mut self,
        tree: &'a pref::Preferences,
        mut goal: impl FnMut(&pref::Objective) -> Result<Goal<ExprId>>,
    ) -> Result<Vec<Goal<ExprId>>> {
        let mut goals = Vec::new();
        for (index, objective) in tree.objectives.iter().enumerate() {
            if !self.declare(index, objective) {
                break;
            }
            match goal(objective) {
                Ok(goal) => goals.push(goal),
                Err(Error::Input(wrong)) => wrong.into_iter().for_each(|d| self.report(d)),
                Err(other) => return Err(other),
            }
        }
        Ok(goals)
    }

    /// Returns the requirements; errors in them are recorded.
    fn requirements(
        &mut self,
        tree: &pref::Preferences,
        required: impl FnOnce(&[Formula]) -> Result<Vec<Requirement<ExprId>>>,
    ) -> Result<Vec<Requirement<ExprId>>> {
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

    fn expect_some(&mut self, objectives: usize) {
        if objectives == 0 && self.diagnostics.is_empty() {
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
        Preorder::new(self.known.len().max(tree.objectives.len()), &statements)
            .map_err(|found| contradiction(self.source, &self.named(), &found, &statements, &spans))
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
            match self.named_as(name) {
                // Repeated names are ignored: on both sides they would multiply.
                Some(index) if !said.insert(index) => {}
                Some(index) => side.push(index),
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

    /// Returns the position of the objective with a name, exact if there is one.
    fn named_as(&self, name: &str) -> Option<usize> {
        let exact = self.known.get(name).map(|(index, _)| *index);
        let alike = || {
            let same = self.known.iter().filter(|(known, _)| known.eq_ignore_ascii_case(name));
            same.map(|(_, (index, _))| *index).min()
        };
        exact.or_else(|| if self.has_capitals { None } else { alike() })
    }

    /// Returns the names of the objectives in their order.
    fn named(&self) -> Vec<&'a str> {
        let mut known: Vec<(usize, &str)> = self.known.iter().map(|(name, (i, _))| (*i, *name)).collect();
        known.sort_unstable();
        known.into_iter().map(|(_, name)| name).collect()
    }

    fn names(&self) -> String {
        self.named().iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
    }
}

/// Returns the error for a contradiction: it shows the cycle, `B > A >= C > B`, at the statement
/// that cannot hold.
fn contradiction(
    source: &Arc<SourceFile>,
    objectives: &[&str],
    found: &Contradiction,
    statements: &[Statement],
    spans: &[Span],
) -> Error {
    let name = |i: usize| objectives.get(i).copied().unwrap_or("?");
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
