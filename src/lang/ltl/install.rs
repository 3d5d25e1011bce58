//! Formulas over a program, and their monitors as variables of the program.

use std::collections::BTreeSet;
use std::sync::Arc;

use ahash::AHashMap;

use super::formula::Formula;
use super::games;
use super::normaliser::{Meaning, Normaliser};
use super::wording::{Purpose, text_of, wording};
use crate::ast::{Expr, NodeKind, Span};
use crate::check::{lower_condition, lower_value};
use crate::names::Names;
use meliora_base::error::{Diagnostic, Error, Limit, Result, Severity, SourceFile};
use meliora_base::value::{Type, Value};
use meliora_ltl::{Decision, Form, FormulaId, Formulas, Monitor, TooLarge, Tree, leaves};
use meliora_model::expr::{Binary, ExprId, ExprPool, Node, Unary};
use meliora_model::predicate::Predicates;
use meliora_model::temporal::{Asks, Begin, Condition, MOST_DISJUNCTS, Monitors};
use meliora_model::{Branch, Command, CommandId, Program, Synchronisation, VarId, Variable};

/// Maximum number of state formulas that one monitor reads.
const MOST_ATOMS: usize = 100;

/// Monitors that are being added to a program.
pub struct Monitoring<'p> {
    pub(super) program: &'p Program,
    /// The conditions made so far.
    pub(crate) predicates: Predicates,
    pub(super) formulas: Formulas,
    pub(super) installed: Vec<Installed>,
    /// The marks of the formulas that have a monitor.
    marks: AHashMap<FormulaId, ExprId>,
    texts: AHashMap<(ExprId, bool), String>,
}

/// A monitor with its place in the program.
pub(super) struct Installed {
    pub(super) monitor: Monitor,
    /// Its variable, `None` for a monitor of one state.
    pub(super) variable: Option<VarId>,
    pub(super) mark: ExprId,
    name: String,
    words: Vec<String>,
}

impl<'p> Monitoring<'p> {
    /// Starts without monitors.
    pub fn new(program: &'p Program) -> Self {
        Monitoring {
            program,
            predicates: Predicates::over(program),
            formulas: Formulas::new(),
            installed: Vec::new(),
            marks: AHashMap::new(),
            texts: AHashMap::new(),
        }
    }

    /// Returns the condition of a formula, and adds the monitors that it needs; they are called
    /// `name`.
    ///
    /// # Errors
    /// Unknown names and wrong types; a limit on the size of normal forms and monitors or on the
    /// number of cases, with the part of the formula; in a game, a combination of recurrence and
    /// persistence.
    pub fn watch(
        &mut self,
        source: &Arc<SourceFile>,
        formula: &Formula,
        name: &str,
    ) -> Result<Condition<ExprId>> {
        let normal = self.normal(source, formula)?;
        let mut tree = leaves(&mut self.formulas, normal).map_err(|found| too_large(source, found))?;
        if self.program.players.is_some() {
            tree = games::in_a_game(&mut self.formulas, source, formula, tree)?;
        }
        let condition = self.condition(&tree, name).map_err(|found| too_large(source, found))?;
        for (which, condition) in [("formula", &condition), ("negation of the formula", &condition.negated())]
        {
            if condition.disjuncts().is_err() {
                let monitors = condition.marks().into_iter().collect::<BTreeSet<_>>().len();
                let message =
                    format!("the {which} has more than {MOST_DISJUNCTS} cases over its {monitors} monitors");
                let diagnostic =
                    Diagnostic::new(source, formula.span.range(), message).severity(Severity::Unsupported);
                return Err(diagnostic.label("too many ways to satisfy it").into());
            }
        }
        Ok(condition)
    }

    /// Returns the normal form of a formula.
    ///
    /// # Errors
    /// Unknown names and wrong types.
    pub(super) fn normal(&mut self, source: &Arc<SourceFile>, formula: &Formula) -> Result<FormulaId> {
        let pool = self.predicates.pool();
        let mut reader = Conditions { program: self.program, pool, source, texts: &mut self.texts };
        Normaliser::new(&mut reader, &mut self.formulas).build(formula, true)
    }

    /// Returns the number of joint states of the monitors of a condition (the product of their
    /// sizes).
    pub(crate) fn states_of(&self, condition: &Condition<ExprId>) -> u64 {
        let marks = condition.marks();
        let own = self.installed.iter().filter(|w| marks.contains(&w.mark));
        own.fold(1, |all, w| all.saturating_mul(w.monitor.states.len() as u64))
    }

    fn condition(&mut self, tree: &Tree, name: &str) -> std::result::Result<Condition<ExprId>, TooLarge> {
        let mut all = |parts: &[Tree]| {
            parts.iter().map(|p| self.condition(p, name)).collect::<std::result::Result<Vec<_>, _>>()
        };
        Ok(match tree {
            Tree::Constant(value) => Condition::Constant(*value),
            Tree::All(parts) => Condition::All(all(parts)?),
            Tree::Any(parts) => Condition::Any(all(parts)?),
            Tree::Leaf(leaf) => {
                let mark = self.mark(leaf.watched, leaf.asks, name);
                Condition::Leaf(leaf.asks, mark.map_err(|limit| TooLarge { span: leaf.span, limit })?)
            }
        })
    }

    /// Returns the mark of the monitor of a formula, which is added unless an equal one is installed.
    pub(super) fn mark(&mut self, watched: FormulaId, asks: Asks, name: &str) -> Result<ExprId> {
        if let Some(&known) = self.marks.get(&watched) {
            return Ok(known);
        }
        let monitor = Monitor::owing(&self.formulas, watched)?;
        let purpose = Purpose { asks, owes: !self.formulas.only_lasts(watched) };
        let mark = self.install(monitor, purpose, name)?;
        self.marks.insert(watched, mark);
        Ok(mark)
    }

    fn install(&mut self, monitor: Monitor, purpose: Purpose, name: &str) -> Result<ExprId> {
        if let Some(same) = self.installed.iter().find(|w| w.monitor.is_same(&monitor)) {
            return Ok(same.mark);
        }
        if monitor.atoms.len() > MOST_ATOMS {
            let what =
                format!("a monitor over {} state formulas, more than {MOST_ATOMS}", monitor.atoms.len());
            return Err(Limit::Size { what }.into());
        }
        let variables = self.installed.iter().filter(|w| w.variable.is_some()).count();
        let variable = (monitor.states.len() > 1)
            .then(|| VarId(u32::try_from(self.program.variables.len() + variables).unwrap_or(u32::MAX)));
        let mark = Values { pool: self.predicates.pool(), monitor: &monitor, variable }.mark();
        let words = wording(&monitor, purpose, &self.texts);
        self.installed.push(Installed { monitor, variable, mark, name: name.to_owned(), words });
        Ok(mark)
    }

    /// Returns the conditions made so far, of which none needs a monitor.
    pub fn without_monitors(self) -> Predicates {
        self.predicates
    }

    /// Returns the product of the program with the monitors: a program of its own, with all conditions
    /// made so far.
    ///
    /// They form a module whose command takes part in every synchronisation, and steps alone in
    /// deadlocks. A variable has the value `0` before anything is read.
    ///
    /// # Errors
    /// The condition for deadlocks cannot be built, which does not happen for a finished program.
    pub fn finish(self, begin: Begin) -> Result<Program> {
        let Monitoring { program, mut predicates, installed, .. } = self;
        let pool = predicates.pool();
        let deadlock = deadlock(program, pool)?;
        let mut program = program.clone();
        let mut names = Names::default();
        program.variables.iter().for_each(|v| drop(names.add(&v.name)));
        let (mut updates, mut variables) = (Vec::new(), Vec::new());
        let mut fresh = pool.value(Value::Bool(true));
        let module = program.modules.len();
        for watcher in installed {
            let Some(variable) = watcher.variable else { continue };
            let next =
                Values { pool: &mut *pool, monitor: &watcher.monitor, variable: Some(variable) }.next();
            updates.push((variable, next));
            variables.push(variable);
            let (own, start) = (pool.var(variable, Type::Int), pool.value(Value::Int(0)));
            let at_start = pool.binary(Binary::Eq, own, start);
            fresh = pool.binary(Binary::And, fresh, at_start);
            program.variables.push(Variable {
                name: names.add(&watcher.name),
                ty: Type::Int,
                low: 0,
                high: watcher.monitor.states.len() as i64 - 1,
                module: Some(module),
                initial: Some(0),
                values: watcher.words,
                span: 0..0,
            });
        }
        let initial = program.initial;
        program.initial = pool.binary(Binary::And, initial, fresh);
        let command = join_in(&mut program, pool, module, &updates, deadlock);
        program.monitors = Some(Monitors { variables, module, command, deadlock, initial, fresh, begin });
        program.inexact = program.inexact.or(pool.inexact.take());
        program.pool = predicates.into_pool();
        Ok(program)
    }
}

/// Returns the condition that nothing is enabled, `None` if something is enabled everywhere.
fn deadlock(program: &Program, pool: &mut ExprPool) -> Result<Option<ExprId>> {
    let label = Expr::new(NodeKind::Label("deadlock".into()), Span::default());
    let deadlock = lower_condition(program, pool, &SourceFile::new("deadlock", ""), &label)?;
    Ok((pool.literal(deadlock) != Some(Value::Bool(false))).then_some(deadlock))
}

/// Adds the module of monitors, and returns the position of its command.
fn join_in(
    program: &mut Program,
    pool: &mut ExprPool,
    module: usize,
    updates: &[(VarId, ExprId)],
    deadlock: Option<ExprId>,
) -> usize {
    program.modules.push("observers".to_owned());
    let probability = pool.value(Value::Real(1.0));
    let command = |action: Option<usize>, guard: ExprId| Command {
        module,
        action,
        number: 1,
        unlisted: None,
        guard,
        branches: [Branch { probability, updates: updates.into() }].into(),
        span: Span::default(),
    };
    let (position, always) = (program.commands.len(), pool.value(Value::Bool(true)));
    program.commands.push(command(None, always));
    for synchronisation in &mut program.synchronisations {
        synchronisation.factors.push(vec![CommandId(position as u32)]);
    }
    if let Some(deadlock) = deadlock {
        let action = Some(program.actions.len());
        program.actions.push("deadlock".to_owned());
        program.commands.push(command(action, deadlock));
        program
            .synchronisations
            .push(Synchronisation { action, factors: vec![vec![CommandId(position as u32 + 1)]] });
    }
    position
}

/// Builds expressions for the transition function of a monitor.
pub(super) struct Values<'a> {
    pub(super) pool: &'a mut ExprPool,
    pub(super) monitor: &'a Monitor,
    pub(super) variable: Option<VarId>,
}

impl Values<'_> {
    /// Returns the expression of the next state.
    fn next(&mut self) -> ExprId {
        let ends = |pool: &mut ExprPool, next: usize, _| pool.value(Value::Int(next as i64));
        let of = self.decisions(ends);
        self.select(&of, 0, self.monitor.states.len())
    }

    /// Returns the condition that the step is marked.
    fn mark(&mut self) -> ExprId {
        let of = self.decisions(|pool, _, mark| pool.value(Value::Bool(mark)));
        self.select(&of, 0, self.monitor.states.len())
    }

    /// Returns the condition that the step leads to one of the given states.
    pub(super) fn settled(&mut self, states: &[bool]) -> ExprId {
        let of = self.decisions(|pool, next, _| pool.value(Value::Bool(states[next])));
        self.select(&of, 0, self.monitor.states.len())
    }

    /// Returns an expression for each decision.
    fn decisions(&mut self, end: impl Fn(&mut ExprPool, usize, bool) -> ExprId) -> Vec<ExprId> {
        let mut made: Vec<ExprId> = Vec::with_capacity(self.monitor.decisions.all.len());
        for &decision in &self.monitor.decisions.all {
            let new = match decision {
                Decision::Go { next, mark } => end(self.pool, next, mark),
                Decision::Test { atom, no, yes } => {
                    choose(self.pool, self.monitor.atoms[atom as usize], made[yes], made[no])
                }
            };
            made.push(new);
        }
        made
    }

    /// Selects by the state of the monitor in a binary search, which keeps the nesting logarithmic.
    fn select(&mut self, of: &[ExprId], from: usize, to: usize) -> ExprId {
        let Some(variable) = self.variable.filter(|_| to - from > 1) else {
            return of[self.monitor.states[from]];
        };
        let middle = from + (to - from) / 2;
        let (low, high) = (self.select(of, from, middle), self.select(of, middle, to));
        let (own, last) =
            (self.pool.var(variable, Type::Int), self.pool.value(Value::Int(middle as i64 - 1)));
        let is_low = self.pool.binary(Binary::Le, own, last);
        choose(self.pool, is_low, low, high)
    }
}

/// Returns `condition ? yes : no`, written with `&` and `|` where one side is a constant.
fn choose(pool: &mut ExprPool, condition: ExprId, yes: ExprId, no: ExprId) -> ExprId {
    let truth = |e| match pool.literal(e) {
        Some(Value::Bool(b)) => Some(b),
        _ => None,
    };
    match (truth(yes), truth(no)) {
        _ if yes == no => yes,
        (Some(true), _) => pool.binary(Binary::Or, condition, no),
        (_, Some(false)) => pool.binary(Binary::And, condition, yes),
        (Some(false), _) => {
            let not = pool.unary(Unary::Not, condition);
            pool.binary(Binary::And, not, no)
        }
        (_, Some(true)) => {
            let not = pool.unary(Unary::Not, condition);
            pool.binary(Binary::Or, not, yes)
        }
        (None, None) => pool.ite(condition, yes, no),
    }
}

/// Reads state formulas of a program into a pool.
struct Conditions<'a> {
    program: &'a Program,
    pool: &'a mut ExprPool,
    source: &'a Arc<SourceFile>,
    texts: &'a mut AHashMap<(ExprId, bool), String>,
}

impl Conditions<'_> {
    /// Returns an atom and its sign.
    fn atom(&self, mut e: ExprId, mut positive: bool) -> (ExprId, bool) {
        while let Node::Unary(Unary::Not, inner) = self.pool.node(e) {
            (e, positive) = (inner, !positive);
        }
        (e, positive)
    }
}

impl Meaning for Conditions<'_> {
    fn state(&mut self, e: &Expr) -> Result<ExprId> {
        lower_condition(self.program, self.pool, self.source, e)
    }

    fn name(&mut self, e: ExprId, span: Span) {
        let atom = self.atom(e, true);
        self.texts.entry(atom).or_insert_with(|| self.source.on_one_line(span.range()).replace('"', ""));
    }

    fn bound(&mut self, e: &Expr) -> Result<u64> {
        let id = lower_value(self.program, self.pool, self.source, e)?;
        let wrong = |message: &str| Diagnostic::new(self.source, e.span().range(), message);
        match self.pool.literal(id) {
            Some(Value::Int(n)) if n >= 0 => Ok(n as u64),
            Some(Value::Int(n)) => {
                Err(wrong("a number of steps cannot be negative").label(format!("this is {n}")).into())
            }
            Some(_) => Err(wrong("a number of steps must be an integer").into()),
            None => Err(wrong("a bound on the number of steps must be a constant")
                .label("depends on the state")
                .help("constants of the model and arithmetic on them are allowed")
                .into()),
        }
    }

    fn literal(&mut self, e: ExprId, positive: bool) -> Form {
        match self.pool.literal(e) {
            Some(Value::Bool(value)) => Form::Constant(value == positive),
            _ => {
                let (e, positive) = self.atom(e, positive);
                Form::Literal(e, positive)
            }
        }
    }

    fn fold(&mut self, conjunction: bool, literals: &[(ExprId, bool)]) -> Form {
        let text = |&(e, positive): &(ExprId, bool)| text_of(self.texts, e, positive);
        let joined =
            literals.iter().map(text).collect::<Vec<_>>().join(if conjunction { " & " } else { " | " });
        let pool = &mut *self.pool;
        let signed = |&(e, positive): &(ExprId, bool)| (e, positive);
        let mut row: Vec<ExprId> = Vec::with_capacity(literals.len());
        for (e, positive) in literals.iter().map(signed) {
            row.push(if positive { e } else { pool.unary(Unary::Not, e) });
        }
        let op = if conjunction { Binary::And } else { Binary::Or };
        // Joined in pairs, which keeps the nesting logarithmic.
        while row.len() > 1 {
            row = row.chunks(2).map(|p| if let [a, b] = *p { pool.binary(op, a, b) } else { p[0] }).collect();
        }
        let whole = self.literal(row[0], true);
        if let Form::Literal(e, positive) = whole {
            self.texts.entry((e, positive)).or_insert(joined);
        }
        whole
    }

    fn source(&self) -> &Arc<SourceFile> {
        self.source
    }
}

/// Names the part of a formula that exceeds a limit.
fn too_large(source: &Arc<SourceFile>, TooLarge { span, limit }: TooLarge) -> Error {
    match limit {
        Error::Limit(Limit::Size { what }) => {
            let part = source.on_one_line(span.range());
            Limit::Size { what: format!("the temporal formula `{part}` needs {what}") }.into()
        }
        other => other,
    }
}
