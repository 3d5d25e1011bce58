//! The flat program that both engines read: variables, commands, synchronisations, targets.
//!
//! Nothing here knows of diagrams or of state arrays.

pub mod expr;
pub mod fault;
pub mod hasse;
mod overlap;
pub mod preference;
pub(crate) mod rounding;
pub mod step;
pub mod temporal;
pub mod value;

use std::ops::Range;
use std::sync::Arc;

use crate::error::SourceFile;
use crate::span::Span;
use expr::{ExprId, ExprPool};
use smallvec::SmallVec;
use value::{Type, Value};

/// A variable of a [`Program`]: its position in [`Program::variables`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct VarId(pub u32);

impl VarId {
    /// The position in [`Program::variables`] and in a [`State`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A command of a [`Program`]: its position in [`Program::commands`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct CommandId(pub u32);

impl CommandId {
    /// The position in [`Program::commands`].
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A state: one value a variable in the order of [`Program::variables`], Booleans as 0 and 1.
pub type State = Vec<i64>;

/// How several enabled commands are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelKind {
    /// Every enabled combination of commands is a choice of its own.
    Mdp,
    /// All enabled combinations make one choice, drawn uniformly.
    Dtmc,
}

/// A program of the PRISM language, flattened: no constants, formulas, renamings or compositions.
#[derive(Debug, Clone)]
pub struct Program {
    /// The text that all spans of this program point into.
    pub source: Arc<SourceFile>,
    /// `mdp` or `dtmc`.
    pub kind: ModelKind,
    /// All constants with their values, in the order of declaration.
    pub constants: Vec<(String, Value)>,
    /// The constants whose values came from `--const`.
    pub given_constants: Vec<String>,
    /// The pool that all expressions of the program live in.
    pub pool: ExprPool,
    /// All variables in the order of declaration (globals where they stand in the text).
    pub variables: Vec<Variable>,
    /// The names of the modules in the order of declaration.
    pub modules: Vec<String>,
    /// What holds in the initial states, and nowhere else.
    pub initial: ExprId,
    /// The names of the action labels.
    pub actions: Vec<String>,
    /// All commands, module by module.
    pub commands: Vec<Command>,
    /// What may happen in a step; see [`Synchronisation`].
    pub synchronisations: Vec<Synchronisation>,
    /// The labels by name, the built-in ones ("init", "deadlock") not among them.
    pub labels: Vec<(String, ExprId)>,
    /// Formulas by name, for targets that use them: those that could be given a meaning of their own.
    pub formulas: Vec<(String, ExprId)>,
    /// What watches plays for temporal formulas, as the last module.
    pub monitors: Option<temporal::Monitors>,
}

/// A variable with its range.
#[derive(Debug, Clone)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// `Type::Bool` (range 0 to 1) or `Type::Int`.
    pub ty: Type,
    /// The smallest value.
    pub low: i64,
    /// The largest value.
    pub high: i64,
    /// The module that owns it; none for a global.
    pub module: Option<usize>,
    /// The value in the initial state; none where `init … endinit` says it.
    pub initial: Option<i64>,
    /// The names of its values from `low` on, where they have names, as locations do.
    pub values: Vec<String>,
    /// Where it is declared.
    pub span: Range<usize>,
}

impl Variable {
    /// How many bits hold `value - low`; 0 for a range of one value.
    pub fn bits(&self) -> u32 {
        let width = self.high.wrapping_sub(self.low) as u64;
        u64::BITS - width.leading_zeros()
    }
}

/// A command: `[action] guard -> branches`.
#[derive(Debug, Clone)]
pub struct Command {
    /// The module it stands in.
    pub module: usize,
    /// Its label, a position in [`Program::actions`]; none for an unlabelled command.
    pub action: Option<usize>,
    /// From 1: the how-manieth command of its module with this label (or without one).
    pub number: usize,
    /// When it is enabled.
    pub guard: ExprId,
    /// What it may do; exactly one happens.
    pub branches: Branches,
    /// The whole command in the text.
    pub span: Span,
}

/// The branches of a command. Programs of a million commands are taken, and most of these have one branch
/// with one or two updates: such commands need no memory but their own.
pub type Branches = SmallVec<[Branch; 1]>;

/// The new values that a branch gives; see [`Branch::updates`].
pub type Updates = SmallVec<[(VarId, ExprId); 2]>;

/// One branch of a command.
#[derive(Debug, Clone)]
pub struct Branch {
    /// Its probability, of type `Real`; a branch of probability 0 is not there.
    pub probability: ExprId,
    /// New values; a variable occurs at most once, all right sides read the old state. The right
    /// side has the type of the variable.
    pub updates: Updates,
}

/// A set of combinations of commands, one out of each factor, that move together.
///
/// The choices are the members of the Cartesian product whose guards all hold. Factors belong to
/// different modules and write different variables. The unlabelled commands of a module are one
/// synchronisation with a single factor.
#[derive(Debug, Clone)]
pub struct Synchronisation {
    /// The label, a position in [`Program::actions`]; none where it is unlabelled or hidden.
    pub action: Option<usize>,
    /// The alternatives of each participant.
    pub factors: Vec<Vec<CommandId>>,
}

impl Program {
    /// All variables in the order of declaration.
    pub fn variable_ids(&self) -> impl Iterator<Item = VarId> + use<> {
        (0..self.variables.len() as u32).map(VarId)
    }

    /// The variable called `name`.
    pub fn variable(&self, name: &str) -> Option<VarId> {
        let index = self.variables.iter().position(|v| v.name == name)?;
        u32::try_from(index).ok().map(VarId)
    }

    /// Whether this is another program with more expressions: what those of the other say, they say here.
    pub fn extends(&self, other: &Program) -> bool {
        let ranges = |p: &Program| p.variables.iter().map(|v| (v.low, v.high)).collect::<Vec<_>>();
        std::ptr::eq(self, other)
            || (Arc::ptr_eq(&self.source, &other.source)
                && self.constants == other.constants
                && ranges(self) == ranges(other)
                && self.pool.starts_with(&other.pool))
    }

    /// `x=1,b=false` for a state.
    pub fn show_state(&self, state: &[i64]) -> String {
        let mut text = String::new();
        for (variable, &value) in self.variables.iter().zip(state) {
            if !text.is_empty() {
                text.push(',');
            }
            text.push_str(&variable.name);
            text.push('=');
            text.push_str(&variable.show(value));
        }
        text
    }
}

impl Variable {
    /// A value of this variable as PRISM writes it, or its name.
    pub fn show(&self, value: i64) -> String {
        if let Some(name) = self.value_name(value) {
            return name.to_owned();
        }
        match self.ty {
            Type::Bool => (value != 0).to_string(),
            _ => value.to_string(),
        }
    }

    /// The name of a value, where values have names.
    pub fn value_name(&self, value: i64) -> Option<&str> {
        let index = usize::try_from(value.checked_sub(self.low)?).ok()?;
        self.values.get(index).map(String::as_str)
    }
}
