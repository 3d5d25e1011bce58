//! The meaning of names: globally, and inside each automaton of the system.

use ahash::AHashMap;

use super::super::read::model::{Automaton, Edge, Function, Location, Variable};
use super::arrays::Parts;
use crate::ast::{Expr, Ident};
use meliora_base::error::Diagnostic;
use meliora_base::value::Type;
use meliora_model::VarId;
use meliora_model::expr::ExprId;
use meliora_model::rewards::RewardItem;

/// The meaning of a name.
#[derive(Debug, Clone, Copy)]
pub(super) enum Meaning {
    Constant(ExprId),
    Variable(VarId, Type),
    /// Its position in [`super::Lowering::transients`].
    Transient(usize),
    /// Its position in [`super::Lowering::arrays`].
    Array(usize),
}

/// Names of one level.
#[derive(Default)]
pub(super) struct Level<'a> {
    pub(super) names: AHashMap<&'a str, (Meaning, &'a Ident)>,
    /// Positions in [`super::Lowering::functions`].
    pub(super) functions: AHashMap<&'a str, usize>,
}

/// An automaton as an element of the system.
pub(super) struct Instance<'a> {
    pub(super) automaton: &'a Automaton,
    pub(super) name: String,
    pub(super) level: Level<'a>,
    /// The variable of its location; `None` if there is only one location.
    pub(super) location: Option<VarId>,
    /// The positions of its locations.
    pub(super) locations: AHashMap<&'a str, usize>,
}

/// A variable whose value follows from the locations.
pub(super) struct Transient<'a> {
    pub(super) variable: &'a Variable,
    /// The element that declares it; `None` for a global one.
    pub(super) instance: Option<usize>,
    /// The locations that give it a value: element, location, value.
    pub(super) given: Vec<(usize, &'a Location, &'a Expr)>,
    pub(super) state: Known,
    /// For an element of an array, its initial value.
    pub(super) element: Option<ExprId>,
}

/// A function with its declaring element.
pub(super) struct Declared<'a> {
    pub(super) function: &'a Function,
    pub(super) instance: Option<usize>,
    /// True while it is being read.
    pub(super) is_open: bool,
}

/// Reading state of a definition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Known {
    New,
    Open,
    Done(Option<ExprId>),
}

/// A variable, transient or not, as the target of assignments.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Slot {
    Variable(VarId),
    Transient(usize),
}

/// Context of an expression.
#[derive(Clone, Copy, Default)]
pub(super) struct Place<'c> {
    /// Element whose names are known in addition to the global ones.
    pub(super) instance: Option<usize>,
    /// The values of parameters.
    pub(super) parameters: Option<&'c AHashMap<&'c str, Parts>>,
    /// Values after assignments of smaller index.
    pub(super) current: Option<&'c AHashMap<Slot, ExprId>>,
}

impl Place<'_> {
    /// Returns the context of an element of the system.
    pub(super) fn new(instance: usize) -> Self {
        Place { instance: Some(instance), ..Place::default() }
    }
}

/// An edge of an element of the system.
pub(super) type EdgeOf<'a> = (usize, &'a Edge);

/// The rewards of steps, and the errors in them, by transient variable.
#[derive(Default)]
pub(super) struct Earned {
    pub(super) items: Vec<(usize, RewardItem)>,
    pub(super) errors: Vec<(usize, Diagnostic)>,
}
