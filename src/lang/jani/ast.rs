//! The tree of a JANI model, close to its text; every part has its place.

use crate::lang::ast::{BinaryOp, Ident, ModelType, Span};
use crate::lang::property::Extreme;
use crate::model::value::{Type, Value};

/// An expression with its place.
#[derive(Debug, Clone)]
pub(super) struct Expr {
    pub(super) kind: ExprKind,
    pub(super) span: Span,
}

/// The forms of expressions.
#[derive(Debug, Clone)]
pub(super) enum ExprKind {
    Literal(Value),
    /// A variable, a constant or a parameter.
    Name(String),
    /// An operator with the right number of operands; nested conjunctions, and nested disjunctions,
    /// are flat.
    Op(Op, Vec<Expr>),
    /// A call of a function of the model.
    Call(Ident, Vec<Expr>),
}

/// The operators.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Op {
    Binary(BinaryOp),
    Not,
    Ite,
    /// A function of the modelling language: min, max, floor, ceil, pow, mod, log.
    Function(&'static str),
    Abs,
    Sgn,
    Trc,
}

/// A model.
pub(super) struct Model {
    pub(super) kind: ModelType,
    pub(super) constants: Vec<Constant>,
    pub(super) variables: Vec<Variable>,
    pub(super) functions: Vec<Function>,
    pub(super) actions: Vec<Ident>,
    pub(super) automata: Vec<Automaton>,
    pub(super) system: System,
    /// `restrict-initial`
    pub(super) restrict: Option<Expr>,
    pub(super) properties: Vec<Property>,
}

/// The type of a constant, a variable or a parameter.
#[derive(Debug, Clone)]
pub(super) struct TypeOf {
    pub(super) ty: Type,
    /// The given bounds of a bounded type.
    pub(super) low: Option<Expr>,
    pub(super) high: Option<Expr>,
    pub(super) span: Span,
}

pub(super) struct Constant {
    pub(super) name: Ident,
    pub(super) ty: TypeOf,
    pub(super) value: Option<Expr>,
}

pub(super) struct Variable {
    pub(super) name: Ident,
    pub(super) ty: TypeOf,
    pub(super) transient: bool,
    pub(super) initial: Option<Expr>,
}

pub(super) struct Function {
    pub(super) name: Ident,
    pub(super) ty: TypeOf,
    pub(super) parameters: Vec<(Ident, TypeOf)>,
    pub(super) body: Expr,
}

pub(super) struct Automaton {
    pub(super) name: Ident,
    pub(super) variables: Vec<Variable>,
    pub(super) functions: Vec<Function>,
    pub(super) locations: Vec<Location>,
    pub(super) initial: Vec<Ident>,
    pub(super) restrict: Option<Expr>,
    pub(super) edges: Vec<Edge>,
}

pub(super) struct Location {
    pub(super) name: Ident,
    /// Values of transient variables in this location.
    pub(super) values: Vec<(Ident, Expr)>,
}

pub(super) struct Edge {
    pub(super) location: Ident,
    pub(super) action: Option<Ident>,
    pub(super) guard: Option<Expr>,
    pub(super) destinations: Vec<Destination>,
    pub(super) span: Span,
}

pub(super) struct Destination {
    pub(super) location: Ident,
    pub(super) probability: Option<Expr>,
    pub(super) assignments: Vec<Assignment>,
    pub(super) span: Span,
}

pub(super) struct Assignment {
    pub(super) variable: Ident,
    pub(super) value: Expr,
    pub(super) index: i64,
}

/// The automata that run in parallel, and their synchronisation.
pub(super) struct System {
    pub(super) elements: Vec<Ident>,
    /// `None` if the model has no vectors.
    pub(super) vectors: Option<Vec<Vector>>,
    pub(super) span: Span,
}

/// A synchronisation vector: for each element an action, or none.
pub(super) struct Vector {
    pub(super) actions: Vec<Option<Ident>>,
    pub(super) result: Option<Ident>,
    pub(super) span: Span,
}

/// A named property.
pub(super) struct Property {
    pub(super) name: Ident,
    /// The question, or the reason why the property is not about reaching a state set.
    pub(super) asks: Result<Reach, String>,
}

/// A question about reaching a target.
pub(super) struct Reach {
    pub(super) target: Expr,
    pub(super) extreme: Extreme,
    /// The expected reward until the target is reached; `None` for the probability to reach it.
    pub(super) reward: Option<Reward>,
    /// The comparison with a number, if there is one.
    pub(super) bound: Option<(BinaryOp, f64)>,
}

/// A reward that is accumulated.
pub(super) struct Reward {
    pub(super) value: Expr,
    /// With every step: the value after its assignments.
    pub(super) steps: bool,
    /// When a state is left: the value in the state.
    pub(super) exit: bool,
}
