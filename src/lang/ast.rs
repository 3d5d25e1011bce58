//! The syntax tree of a model file, close to the text.
//!
//! Chains of operators of one precedence level are flat lists, so that the height of a tree is
//! bounded by the nesting that the parser allows and recursion over it is safe.

use crate::model::value::Type;
pub use crate::span::Span;

/// A name at a place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ident {
    /// The name, without quotes or prime.
    pub name: String,
    /// Where it stands.
    pub span: Span,
}

/// An expression at a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Expr {
    /// What it is.
    pub kind: ExprKind,
    /// Where it stands, without enclosing brackets.
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

/// How tightly `!` binds; see [`BinaryOp::level`].
pub const NOT_LEVEL: u8 = 4;
/// How tightly unary minus binds; see [`BinaryOp::level`].
pub const NEG_LEVEL: u8 = 9;
/// The level of what needs no brackets anywhere.
pub const ATOM_LEVEL: u8 = 11;

impl BinaryOp {
    /// How tightly it binds: higher binds tighter. `?:` has none, it binds least of all.
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

    /// As it is written.
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

/// The types of model that are supported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelType {
    /// `mdp`, `nondeterministic`, or no word at all.
    Mdp,
    /// `dtmc`, `probabilistic`
    Dtmc,
}

/// A model file. Its expressions and commands are trees, or what else is made of them when it is read.
#[derive(Debug, Clone, PartialEq)]
pub struct Model<E = Expr, C = Command<E>> {
    /// The model type with its place, if it is given.
    pub kind: Option<(ModelType, Span)>,
    /// Everything else, in the order of the text.
    pub items: Vec<Item<E, C>>,
}

/// A part of a model file. Parts of which there may be millions are small, so the others are boxed.
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
    /// `int`, also where no type is given.
    Int,
    /// `double`, and the old words `rate` and `prob`.
    Double,
    /// `bool`
    Bool,
}

impl ConstType {
    /// The type of its values.
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
    /// Its type.
    pub ty: ConstType,
    /// Its name.
    pub name: Ident,
    /// Its value; none for a constant to be defined on the command line.
    pub value: Option<E>,
}

/// A formula.
#[derive(Debug, Clone, PartialEq)]
pub struct FormulaDef<E = Expr> {
    /// Its name.
    pub name: Ident,
    /// What it stands for.
    pub body: E,
}

/// A label.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelDef<E = Expr> {
    /// Its name without quotes.
    pub name: Ident,
    /// Where it holds.
    pub body: E,
}

/// A variable.
#[derive(Debug, Clone, PartialEq)]
pub struct VarDecl<E = Expr> {
    /// Its name.
    pub name: Ident,
    /// Its range; none for `bool`.
    pub range: Option<(E, E)>,
    /// `init e`
    pub init: Option<E>,
    /// The whole declaration.
    pub span: Span,
}

/// A module.
#[derive(Debug, Clone, PartialEq)]
pub struct Module<E = Expr, C = Command<E>> {
    /// Its name.
    pub name: Ident,
    /// Its variables.
    pub variables: Vec<VarDecl<E>>,
    /// Its commands.
    pub commands: Vec<C>,
}

/// A command.
#[derive(Debug, Clone, PartialEq)]
pub struct Command<E = Expr> {
    /// The action label, if there is one.
    pub action: Option<Ident>,
    /// When it is enabled.
    pub guard: E,
    /// The branches; at least one.
    pub branches: Vec<Branch<E>>,
    /// The whole command.
    pub span: Span,
}

/// A branch of a command.
#[derive(Debug, Clone, PartialEq)]
pub struct Branch<E = Expr> {
    /// Its probability; none for 1.
    pub probability: Option<E>,
    /// The assignments; none for `true`.
    pub updates: Vec<Assignment<E>>,
    /// The whole branch.
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
    /// Its name.
    pub name: Ident,
    /// The module it copies.
    pub base: Ident,
    /// Old and new names.
    pub renames: Vec<(Ident, Ident)>,
}

/// A reward structure; checked for syntax and otherwise ignored.
#[derive(Debug, Clone, PartialEq)]
pub struct Rewards<E = Expr> {
    /// Its name without quotes.
    pub name: Option<Ident>,
    /// Its lines.
    pub items: Vec<RewardItem<E>>,
    /// The whole structure.
    pub span: Span,
}

/// A line of a reward structure.
#[derive(Debug, Clone, PartialEq)]
pub struct RewardItem<E = Expr> {
    /// `[a]` or `[]`; none for a state reward.
    pub action: Option<Option<Ident>>,
    /// Where it is earned.
    pub guard: E,
    /// How much.
    pub value: E,
}

/// A composition of modules.
#[derive(Debug, Clone, PartialEq)]
pub struct System {
    /// What it is.
    pub kind: SystemKind,
    /// Where it stands.
    pub span: Span,
}

/// The forms of compositions.
#[derive(Debug, Clone, PartialEq)]
pub enum SystemKind {
    /// A module.
    Module(String),
    /// `a || b || …`: synchronise on all common actions.
    Full(Vec<System>),
    /// `a ||| b ||| …`: no synchronisation.
    Interleaved(Vec<System>),
    /// `a |[x,y]| b`: synchronise on the actions given.
    Parallel(Box<System>, Vec<Ident>, Box<System>),
    /// `a / {x,y}`
    Hide(Box<System>, Vec<Ident>),
    /// `a {x<-y}`
    Rename(Box<System>, Vec<(Ident, Ident)>),
}
