//! The syntax tree of a model file, close to the text.
//!
//! Chains of operators of one precedence level are flat lists. So the height of a tree is bounded
//! by the nesting that the parser permits, and recursion over it is safe.

use crate::model::value::Type;
pub use crate::span::Span;

/// A name with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ident {
    /// The name, without quotes or prime.
    pub name: String,
    /// Place in the text.
    pub span: Span,
}

/// An expression with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Expr {
    /// Form of the expression.
    pub kind: ExprKind,
    /// Place in the text, without enclosing brackets.
    pub span: Span,
}

/// The forms of expressions.
#[derive(Debug, Clone, PartialEq)]
pub enum ExprKind {
    /// `true`, `false`
    Bool(bool),
    /// An integer literal, never negative.
    Int(i64),
    /// A real literal, finite and never negative.
    Real(f64),
    /// A variable, a constant or a formula.
    Name(String),
    /// `"name"`: a label.
    Label(String),
    /// `!e`
    Not(Box<Expr>),
    /// `-e`
    Neg(Box<Expr>),
    /// `e op e op e …`: operators of one level, from left to right; the list is not empty.
    Chain(Box<Expr>, Vec<(BinaryOp, Expr)>),
    /// `c ? e : c ? e : … e`; the list is not empty.
    Ite(Vec<(Expr, Expr)>, Box<Expr>),
    /// `f(e, …)`
    Call(Box<Ident>, Vec<Expr>),
}

/// Operators between two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BinaryOp {
    /// `=>`
    Implies,
    /// `<=>`
    Iff,
    /// `|`
    Or,
    /// `&`
    And,
    /// `=`
    Eq,
    /// `!=`
    Ne,
    /// `<`
    Lt,
    /// `<=`
    Le,
    /// `>`
    Gt,
    /// `>=`
    Ge,
    /// `+`
    Add,
    /// `-`
    Sub,
    /// `*`
    Mul,
    /// `/`
    Div,
    /// `^`
    Pow,
}

/// Precedence level of `!`; see [`BinaryOp::level`].
pub const NOT_LEVEL: u8 = 4;
/// Precedence level of unary minus; see [`BinaryOp::level`].
pub const NEG_LEVEL: u8 = 9;
/// Precedence level of an expression that never needs brackets.
pub const ATOM_LEVEL: u8 = 11;

impl BinaryOp {
    /// Returns the precedence level: higher binds tighter. `?:` has no level and binds least.
    pub fn level(self) -> u8 {
        match self {
            BinaryOp::Implies => 0,
            BinaryOp::Iff => 1,
            BinaryOp::Or => 2,
            BinaryOp::And => 3,
            BinaryOp::Eq | BinaryOp::Ne => 5,
            BinaryOp::Lt | BinaryOp::Le | BinaryOp::Gt | BinaryOp::Ge => 6,
            BinaryOp::Add | BinaryOp::Sub => 7,
            BinaryOp::Mul | BinaryOp::Div => 8,
            BinaryOp::Pow => 10,
        }
    }

    /// Returns the operator as written.
    pub fn symbol(self) -> &'static str {
        match self {
            BinaryOp::Implies => "=>",
            BinaryOp::Iff => "<=>",
            BinaryOp::Or => "|",
            BinaryOp::And => "&",
            BinaryOp::Eq => "=",
            BinaryOp::Ne => "!=",
            BinaryOp::Lt => "<",
            BinaryOp::Le => "<=",
            BinaryOp::Gt => ">",
            BinaryOp::Ge => ">=",
            BinaryOp::Add => "+",
            BinaryOp::Sub => "-",
            BinaryOp::Mul => "*",
            BinaryOp::Div => "/",
            BinaryOp::Pow => "^",
        }
    }
}

/// The supported types of model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelType {
    /// `mdp`, `nondeterministic`, or no keyword.
    Mdp,
    /// `dtmc`, `probabilistic`
    Dtmc,
}

/// A model file. `E` and `C` represent its expressions and commands: trees, or other types that a
/// parser makes.
#[derive(Debug, Clone, PartialEq)]
pub struct Model<E = Expr, C = Command<E>> {
    /// Model type with its place, if it is given.
    pub kind: Option<(ModelType, Span)>,
    /// All other parts, in the order of the text.
    pub items: Vec<Item<E, C>>,
}

/// A part of a model file. Parts that may occur millions of times are small; the others are boxed.
#[derive(Debug, Clone, PartialEq)]
pub enum Item<E = Expr, C = Command<E>> {
    /// `const …;`
    Const(ConstDef<E>),
    /// `formula f = e;`
    Formula(FormulaDef<E>),
    /// `label "l" = e;`
    Label(LabelDef<E>),
    /// `global x : …;`
    Global(Box<VarDecl<E>>),
    /// `module … endmodule`
    Module(Box<Module<E, C>>),
    /// `module … = … [ … ] endmodule`
    Renamed(Box<RenamedModule>),
    /// `rewards … endrewards`
    Rewards(Box<Rewards<E>>),
    /// `init … endinit`
    Init(E),
    /// `system … endsystem`
    System(Box<System>),
}

/// The declared type of a constant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConstType {
    /// `int`, also if no type is given.
    Int,
    /// `double`, and the old keywords `rate` and `prob`.
    Double,
    /// `bool`
    Bool,
}

impl ConstType {
    /// Returns the type of its values.
    pub fn ty(self) -> Type {
        match self {
            ConstType::Int => Type::Int,
            ConstType::Double => Type::Real,
            ConstType::Bool => Type::Bool,
        }
    }
}

/// A constant.
#[derive(Debug, Clone, PartialEq)]
pub struct ConstDef<E = Expr> {
    /// Type.
    pub ty: ConstType,
    /// Name.
    pub name: Ident,
    /// Value; `None` for a constant that is defined on the command line.
    pub value: Option<E>,
}

/// A formula.
#[derive(Debug, Clone, PartialEq)]
pub struct FormulaDef<E = Expr> {
    /// Name.
    pub name: Ident,
    /// Expression that the name stands for.
    pub body: E,
}

/// A label.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelDef<E = Expr> {
    /// Name without quotes.
    pub name: Ident,
    /// Condition for the states that have the label.
    pub body: E,
}

/// A variable.
#[derive(Debug, Clone, PartialEq)]
pub struct VarDecl<E = Expr> {
    /// Name.
    pub name: Ident,
    /// Range; `None` for `bool`.
    pub range: Option<(E, E)>,
    /// `init e`
    pub init: Option<E>,
    /// Place of the whole declaration.
    pub span: Span,
}

/// A module.
#[derive(Debug, Clone, PartialEq)]
pub struct Module<E = Expr, C = Command<E>> {
    /// Name.
    pub name: Ident,
    /// Variables.
    pub variables: Vec<VarDecl<E>>,
    /// Commands.
    pub commands: Vec<C>,
}

/// A command.
#[derive(Debug, Clone, PartialEq)]
pub struct Command<E = Expr> {
    /// Action label, if there is one.
    pub action: Option<Ident>,
    /// Guard.
    pub guard: E,
    /// Branches; at least one.
    pub branches: Vec<Branch<E>>,
    /// Place of the whole command.
    pub span: Span,
}

/// A branch of a command.
#[derive(Debug, Clone, PartialEq)]
pub struct Branch<E = Expr> {
    /// Probability; `None` for 1.
    pub probability: Option<E>,
    /// Assignments; empty for `true`.
    pub updates: Vec<Assignment<E>>,
    /// Place of the whole branch.
    pub span: Span,
}

/// `(x' = e)`
#[derive(Debug, Clone, PartialEq)]
pub struct Assignment<E = Expr> {
    /// The variable.
    pub variable: Ident,
    /// Its new value.
    pub value: E,
}

/// A module made from another one by renaming.
#[derive(Debug, Clone, PartialEq)]
pub struct RenamedModule {
    /// Name.
    pub name: Ident,
    /// The module that it copies.
    pub base: Ident,
    /// Pairs of an old and a new name.
    pub renames: Vec<(Ident, Ident)>,
}

/// A reward structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Rewards<E = Expr> {
    /// Name without quotes.
    pub name: Option<Ident>,
    /// Reward items.
    pub items: Vec<RewardItem<E>>,
    /// Place of the whole structure.
    pub span: Span,
}

/// One item of a reward structure.
#[derive(Debug, Clone, PartialEq)]
pub struct RewardItem<E = Expr> {
    /// `[a]` or `[]`; `None` for a state reward.
    pub action: Option<Option<Ident>>,
    /// Condition for the states that earn the reward.
    pub guard: E,
    /// Value of the reward.
    pub value: E,
}

/// A composition of modules.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// Form of the composition.
    pub kind: SystemKind,
    /// Place in the text.
    pub span: Span,
}

/// The forms of compositions.
#[derive(Debug, Clone, PartialEq)]
pub enum SystemKind {
    /// A module.
    Module(String),
    /// `a || b || …`: synchronisation on all common actions.
    Full(Vec<System>),
    /// `a ||| b ||| …`: no synchronisation.
    Interleaved(Vec<System>),
    /// `a |[x,y]| b`: synchronisation on the given actions.
    Parallel(Box<System>, Vec<Ident>, Box<System>),
    /// `a / {x,y}`
    Hide(Box<System>, Vec<Ident>),
    /// `a {x<-y}`
    Rename(Box<System>, Vec<(Ident, Ident)>),
}
