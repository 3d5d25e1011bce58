//! What a temporal formula asks of the plays of a program that its monitors watch.
//!
//! Monitors run beside the model: one variable each, which every choice updates alike by what holds in the
//! present state. They mark some steps; what a formula asks is that marks come, or stay away.

use super::expr::ExprId;
use super::{Program, VarId};

/// More disjuncts than this are refused: each is a search of its own.
pub const MOST_DISJUNCTS: usize = 64;

/// What a formula asks of the marks of one monitor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Asks {
    /// Some step is marked, and then all later ones are: a co-safe formula.
    Accept,
    /// No step is marked, where all steps behind a marked one are: a safe formula.
    Avoid,
    /// Steps are marked again and again: a recurrence.
    Again,
    /// From some step on none is marked: a persistence.
    Settle,
}

impl Asks {
    /// What the negation asks.
    pub fn opposite(self) -> Asks {
        match self {
            Asks::Accept => Asks::Avoid,
            Asks::Avoid => Asks::Accept,
            Asks::Again => Asks::Settle,
            Asks::Settle => Asks::Again,
        }
    }

    /// The kind of the leaf, in words.
    pub fn name(self) -> &'static str {
        match self {
            Asks::Accept => "co-safe",
            Asks::Avoid => "safe",
            Asks::Again => "recurrence",
            Asks::Settle => "persistence",
        }
    }
}

/// A Boolean combination of what is asked of marks. A mark is an expression: the states whose steps are marked.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Condition {
    /// All plays, or none.
    Constant(bool),
    /// What is asked of a mark.
    Leaf(Asks, ExprId),
    /// All of these.
    All(Vec<Condition>),
    /// One of these.
    Any(Vec<Condition>),
}

/// One way to satisfy a condition: from some step on always this, and again and again that.
#[derive(Debug, Clone, PartialEq, Eq, Default, PartialOrd, Ord)]
pub struct Disjunct {
    /// Marks with the sign that they keep for ever.
    pub always: Vec<(ExprId, bool)>,
    /// Marks that come again and again.
    pub again: Vec<ExprId>,
}

impl Condition {
    /// The negation.
    pub fn negated(&self) -> Condition {
        let all = |parts: &[Condition]| parts.iter().map(Condition::negated).collect();
        match self {
            Condition::Constant(value) => Condition::Constant(!value),
            Condition::Leaf(asks, mark) => Condition::Leaf(asks.opposite(), *mark),
            Condition::All(parts) => Condition::Any(all(parts)),
            Condition::Any(parts) => Condition::All(all(parts)),
        }
    }

    /// The marks that it speaks of.
    pub fn marks(&self) -> Vec<ExprId> {
        match self {
            Condition::Constant(_) => Vec::new(),
            Condition::Leaf(_, mark) => vec![*mark],
            Condition::All(parts) | Condition::Any(parts) => {
                parts.iter().flat_map(Condition::marks).collect()
            }
        }
    }

    /// The disjunctive normal form, without disjuncts that ask more than another one; none where there are
    /// more than [`MOST_DISJUNCTS`].
    pub fn disjuncts(&self) -> Option<Vec<Disjunct>> {
        match self {
            Condition::Constant(true) => Some(vec![Disjunct::default()]),
            Condition::Constant(false) => Some(Vec::new()),
            Condition::Leaf(asks, mark) => {
                let always = match asks {
                    Asks::Accept => vec![(*mark, true)],
                    Asks::Avoid | Asks::Settle => vec![(*mark, false)],
                    Asks::Again => Vec::new(),
                };
                let again = if *asks == Asks::Again { vec![*mark] } else { Vec::new() };
                Some(vec![Disjunct { always, again }])
            }
            Condition::Any(parts) => {
                let mut all = Vec::new();
                for part in parts {
                    all.extend(part.disjuncts()?);
                    all = least(all)?;
                }
                Some(all)
            }
            Condition::All(parts) => {
                let mut all = vec![Disjunct::default()];
                for part in parts {
                    let other = part.disjuncts()?;
                    all = least(all.iter().flat_map(|d| other.iter().map(|o| d.and(o))).collect())?;
                }
                Some(all)
            }
        }
    }
}

impl Disjunct {
    fn and(&self, other: &Disjunct) -> Disjunct {
        let mut both = self.clone();
        both.always.extend(&other.always);
        both.again.extend(&other.again);
        both.always.sort_unstable();
        both.always.dedup();
        both.again.sort_unstable();
        both.again.dedup();
        both
    }

    fn asks_all_of(&self, other: &Disjunct) -> bool {
        other.always.iter().all(|a| self.always.contains(a))
            && other.again.iter().all(|a| self.again.contains(a))
    }
}

/// Those that ask no more than another one, each once.
fn least(mut all: Vec<Disjunct>) -> Option<Vec<Disjunct>> {
    all.sort_unstable_by_key(|d| (d.always.len() + d.again.len(), d.clone()));
    let mut kept: Vec<Disjunct> = Vec::new();
    for disjunct in all {
        if !kept.iter().any(|k| disjunct.asks_all_of(k)) {
            kept.push(disjunct);
        }
    }
    (kept.len() <= MOST_DISJUNCTS).then_some(kept)
}

/// The monitors of a program.
#[derive(Debug, Clone)]
pub struct Monitors {
    /// Their variables.
    pub variables: Vec<VarId>,
    /// The module that stands for all of them, a position in [`super::Program::modules`].
    pub module: usize,
    /// Its command that takes part in every synchronisation, a position in [`super::Program::commands`].
    pub command: usize,
    /// Where no command of the model is enabled: there the monitors step alone.
    pub deadlock: Option<ExprId>,
    /// Where the model begins, whatever monitors have seen.
    pub initial: ExprId,
    /// Where monitors are fresh: they have read nothing yet.
    pub fresh: ExprId,
    /// Where they may begin.
    pub begin: Begin,
}

impl Program {
    /// The same program without its monitors.
    pub fn without_monitors(&self) -> Program {
        let mut program = self.clone();
        let Some(monitors) = program.monitors.take() else { return program };
        program.initial = monitors.initial;
        program.variables.truncate(program.variables.len() - monitors.variables.len());
        program.modules.truncate(monitors.module);
        program.commands.truncate(monitors.command);
        if monitors.deadlock.is_some() {
            program.synchronisations.pop();
            program.actions.pop();
        }
        program.synchronisations.iter_mut().for_each(|s| drop(s.factors.pop()));
        program
    }
}

/// Where monitors may begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Begin {
    /// Where plays begin.
    Initially,
    /// In every state of the scope: formulas are judged from each of them on.
    Everywhere,
}
