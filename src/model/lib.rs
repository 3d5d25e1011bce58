//! The flat program that both engines read, and the preorder of preferences.
//!
//! - [`Program`]: variables, commands, synchronisations, labels and formulas, independent of
//!   diagrams and state arrays.
//! - [`preference::Preferences`]: objectives and the preorder on them.
//! - [`property::PropertyKind`]: questions about the paths of a model.
//!
//! ```
//! use meliora_model::expr::ExprPool;
//! use meliora_base::value::{Binary, Value};
//!
//! let mut pool = ExprPool::default();
//! let [tenth, fifth] = [0.1, 0.2].map(|x| pool.value(Value::Real(x)));
//! let sum = pool.binary(Binary::Add, tenth, fifth);
//! assert_eq!(pool.literal(sum), Some(Value::Real(0.3)));
//! ```

mod evaluation;
pub mod expr;
pub mod fault;
pub mod hasse;
mod overlap;
pub mod planning;
pub mod players;
pub mod predicate;
pub mod preference;
pub mod property;
pub mod region;
pub mod rewards;
pub mod step;
mod stop;
pub mod temporal;
pub mod trend;
pub mod valuation;
mod weight;

use std::ops::Range;
use std::sync::Arc;

use smallvec::SmallVec;
use strum::IntoStaticStr;

use expr::{ExprId, ExprPool};
use meliora_base::error::{Diagnostic, SourceFile};
use meliora_base::escape;
use meliora_base::exact::Exact;
use meliora_base::span::Span;
use meliora_base::value::{Binary, Type};
use players::Players;
use rewards::RewardStructure;

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

/// A state: one value per variable in the order of [`Program::variables`], Booleans as 0 and 1.
pub type State = Vec<i64>;

/// The meaning of several enabled commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, schemars::JsonSchema)]
#[strum(serialize_all = "lowercase")]
#[schemars(rename_all = "lowercase")]
pub enum ModelKind {
    /// Every enabled combination of commands is a choice of its own.
    Mdp,
    /// All enabled combinations form a single choice, which selects one of them uniformly.
    Dtmc,
    /// A turn-based game: choices are those of an `mdp`, and each state belongs to one player.
    Smg,
}

/// The extreme of a value over all strategies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Optimum {
    /// The least value.
    Min,
    /// The greatest value.
    Max,
}

/// A program of the PRISM language, flattened: no constants, formulas, renamings or compositions.
#[derive(Debug, Clone)]
pub struct Program {
    /// The text that all spans of this program point into.
    pub source: Arc<SourceFile>,
    /// `mdp`, `dtmc` or `smg`.
    pub kind: ModelKind,
    /// All constants with their values, in the order of declaration.
    pub constants: Vec<(String, Exact)>,
    /// The constants whose values came from `--const`.
    pub given_constants: Vec<String>,
    /// The pool of all expressions of the program. Conditions of questions have pools of their
    /// own; see [`predicate`].
    pub pool: Arc<ExprPool>,
    /// All variables in the order of declaration (globals at their position in the text).
    pub variables: Vec<Variable>,
    /// The names of the modules in the order of declaration.
    pub modules: Vec<String>,
    /// A predicate that is true exactly in the initial states.
    pub initial: ExprId,
    /// The names of the action labels.
    pub actions: Vec<String>,
    /// All commands, module by module.
    pub commands: Vec<Command>,
    /// The synchronisations, which define the possible steps; see [`Synchronisation`].
    pub synchronisations: Vec<Synchronisation>,
    /// The labels by name, without the built-in ones ("init", "deadlock").
    pub labels: Vec<(String, ExprId)>,
    /// The formulas by name, for use in targets; only those that have a meaning of their own.
    pub formulas: Vec<(String, ExprId)>,
    /// The reward structures, in the order of declaration.
    pub rewards: Vec<RewardStructure>,
    /// The first expression for whose exact value a double counts; see [`meliora_base::real`].
    pub inexact: Option<Diagnostic>,
    /// The monitors for temporal formulas, which are the last module.
    pub monitors: Option<temporal::Monitors>,
    /// The players of a game (`smg`); `None` for all other models.
    pub players: Option<Players>,
    /// The command of the states that are not left; see [`Program::stopping_at`].
    pub stop: Option<CommandId>,
    /// The names of the planning problem that it was made from; `None` for all other models.
    pub planning: Option<Arc<planning::Planning>>,
}

impl Program {
    /// Lets reports name an expression of some conditions that is not exact, if all of the model are.
    pub fn note_inexact<'p>(&mut self, mut conditions: impl Iterator<Item = &'p predicate::Predicate>) {
        if self.inexact.is_none() {
            self.inexact = conditions.find_map(predicate::Predicate::inexact).cloned();
        }
    }

    /// Returns a program without variables, commands and names, to which others are added. `initial` is an
    /// expression of the pool.
    pub fn empty(source: Arc<SourceFile>, kind: ModelKind, pool: Arc<ExprPool>, initial: ExprId) -> Self {
        Program {
            source,
            kind,
            constants: Vec::new(),
            given_constants: Vec::new(),
            pool,
            variables: Vec::new(),
            modules: Vec::new(),
            initial,
            actions: Vec::new(),
            commands: Vec::new(),
            synchronisations: Vec::new(),
            labels: Vec::new(),
            formulas: Vec::new(),
            rewards: Vec::new(),
            inexact: None,
            monitors: None,
            players: None,
            stop: None,
            planning: None,
        }
    }
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
    /// The module that owns it; `None` for a global.
    pub module: Option<usize>,
    /// The value in the initial state; `None` if `init … endinit` defines the initial states.
    pub initial: Option<i64>,
    /// The names of its values from `low` on, if values have names, as locations do; else empty.
    pub values: Vec<String>,
    /// The position of its declaration.
    pub span: Range<usize>,
}

impl Variable {
    /// Returns the number of bits that store `value - low`; 0 for a range of one value.
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
    /// Its label, a position in [`Program::actions`]; `None` for an unlabelled command.
    pub action: Option<usize>,
    /// The number, from 1, of this command among its module's commands with this label (or without
    /// one).
    pub number: usize,
    /// The player of its choices in a game, if no player lists its action or its module.
    pub unlisted: Option<players::Unlisted>,
    /// The condition under which it is enabled.
    pub guard: ExprId,
    /// The branches, exactly one of which is taken.
    pub branches: Branches,
    /// The position of the whole command.
    pub span: Span,
}

/// The branches of a command. Programs can have millions of commands, most with one branch and one
/// or two updates: such commands need no separate allocation.
pub type Branches = SmallVec<[Branch; 1]>;

/// The new values that a branch assigns; see [`Branch::updates`].
pub type Updates = SmallVec<[(VarId, ExprId); 2]>;

/// One branch of a command.
#[derive(Debug, Clone)]
pub struct Branch {
    /// The probability, of type `Real`; a branch of probability 0 is ignored.
    pub probability: ExprId,
    /// The new values. A variable occurs at most once, and all right sides read the old state. The
    /// right side has the type of the variable.
    pub updates: Updates,
}

/// A set of combinations of commands, one from each factor, that are executed together.
///
/// The choices are the members of the Cartesian product whose guards are all true. Factors belong
/// to different modules and write different variables. The unlabelled commands of a module form one
/// synchronisation with a single factor.
#[derive(Debug, Clone)]
pub struct Synchronisation {
    /// The label, a position in [`Program::actions`]; `None` if it is unlabelled or hidden.
    pub action: Option<usize>,
    /// The alternative commands of each participant.
    pub factors: Vec<Vec<CommandId>>,
}

impl Synchronisation {
    /// Returns the condition under which some combination of the commands is enabled.
    pub fn enabled_where(&self, pool: &mut ExprPool, commands: &[Command]) -> ExprId {
        let guards = |factor: &Vec<CommandId>| factor.iter().map(|c| commands[c.index()].guard).collect();
        let factors = self.factors.iter().map(|factor| pool.joined(Binary::Or, guards(factor))).collect();
        pool.joined(Binary::And, factors)
    }
}

impl Program {
    /// Returns all variables in the order of declaration.
    pub fn variable_ids(&self) -> impl Iterator<Item = VarId> + use<> {
        (0..self.variables.len() as u32).map(VarId)
    }

    /// Returns the variable called `name`.
    pub fn variable(&self, name: &str) -> Option<VarId> {
        let index = self.variables.iter().position(|v| v.name == name)?;
        u32::try_from(index).ok().map(VarId)
    }

    /// Formats a state, for example as `x=1,b=false`, which is read back as this state.
    pub fn show_state(&self, state: &[i64]) -> String {
        self.show_values(state, ",")
    }

    /// Formats the values of a state, separated by a text.
    pub fn show_values(&self, state: &[i64], separator: &str) -> String {
        if self.variables.is_empty() {
            return valuation::NO_VARIABLES.to_owned();
        }
        let values = self.variables.iter().zip(state);
        values.map(|(variable, &value)| variable.equation(value)).collect::<Vec<_>>().join(separator)
    }
}

impl Variable {
    /// Formats a value of this variable: its name, or the notation of PRISM.
    pub fn show(&self, value: i64) -> String {
        if let Some(name) = self.value_name(value) {
            return name.to_owned();
        }
        match self.ty {
            Type::Bool => (value != 0).to_string(),
            _ => value.to_string(),
        }
    }

    /// Formats `x=1` for a value, with quotes around a name that needs them to be read back.
    pub fn equation(&self, value: i64) -> String {
        let shown = self.value_name(value).map(escape::value);
        format!("{}={}", self.name, shown.unwrap_or_else(|| self.show(value).into()))
    }

    /// Returns the name of a value, if values have names.
    pub fn value_name(&self, value: i64) -> Option<&str> {
        let index = usize::try_from(value.checked_sub(self.low)?).ok()?;
        self.values.get(index).map(String::as_str)
    }
}
