//! The syntax tree of a model file, close to the text.
//!
//! Chains of operators of one precedence level are flat lists, so that the height of a tree is
//! bounded by the nesting that the parser allows and recursion over it is safe.

use std::ops::Range;

use crate::model::value::Type;

/// A byte range of the text. Any two spans are equal, so that equality of trees is about content.
#[derive(Debug, Clone, Copy, Default)]
pub struct Span {
    /// The first byte.
    pub start: usize,
    /// The byte after the last one.
    pub end: usize,
}

impl Span {
    /// The span as a range of bytes.
    pub fn range(self) -> Range<usize> {
        self.start..self.end
    }

    /// From the start of `self` to the end of `other`.
    pub fn to(self, other: Span) -> Span {
        Span { start: self.start, end: other.end }
    }
}

impl PartialEq for Span {
    fn eq(&self, _: &Span) -> bool {
        true
    }
}

impl Eq for Span {}

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

/// A model file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Model {
    /// The model type with its place, if it is given.
    pub kind: Option<(ModelType, Span)>,
    /// Everything else, in the order of the text.
    pub items: Vec<Item>,
}

/// A part of a model file.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// `const …;`
    Const(ConstDef),
    /// `formula f = e;`
    Formula(FormulaDef),
    /// `label "l" = e;`
    Label(LabelDef),
    /// `global x : …;`
    Global(VarDecl),
    /// `module … endmodule`
    Module(Module),
    /// `module … = … [ … ] endmodule`
    Renamed(RenamedModule),
    /// `rewards … endrewards`
    Rewards(Rewards),
    /// `init … endinit`
    Init(Expr),
    /// `system … endsystem`
    System(System),
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
pub struct ConstDef {
    /// Its type.
    pub ty: ConstType,
    /// Its name.
    pub name: Ident,
    /// Its value; none for a constant to be defined on the command line.
    pub value: Option<Expr>,
}

/// A formula.
#[derive(Debug, Clone, PartialEq)]
pub struct FormulaDef {
    /// Its name.
    pub name: Ident,
    /// What it stands for.
    pub body: Expr,
}

/// A label.
#[derive(Debug, Clone, PartialEq)]
pub struct LabelDef {
    /// Its name without quotes.
    pub name: Ident,
    /// Where it holds.
    pub body: Expr,
}

/// A variable.
#[derive(Debug, Clone, PartialEq)]
pub struct VarDecl {
    /// Its name.
    pub name: Ident,
    /// Its range; none for `bool`.
    pub range: Option<(Expr, Expr)>,
    /// `init e`
    pub init: Option<Expr>,
    /// The whole declaration.
    pub span: Span,
}

/// A module.
#[derive(Debug, Clone, PartialEq)]
pub struct Module {
    /// Its name.
    pub name: Ident,
    /// Its variables.
    pub variables: Vec<VarDecl>,
    /// Its commands.
    pub commands: Commands,
}

/// The commands of a module.
#[derive(Debug, Clone, PartialEq)]
pub enum Commands {
    /// As trees.
    Trees(Vec<Command>),
    /// Where they stand in the text. A tree takes many times the memory of its text, so a model that is
    /// only to be flattened has one at a time, read again when its turn comes.
    Places(Vec<Span>),
}

impl Commands {
    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Commands::Trees(trees) => trees.len(),
            Commands::Places(places) => places.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Adds one, in the form that the others have.
    pub(crate) fn push(&mut self, command: Command) {
        match self {
            Commands::Trees(trees) => trees.push(command),
            Commands::Places(places) => places.push(command.span),
        }
    }
}

/// A command.
#[derive(Debug, Clone, PartialEq)]
pub struct Command {
    /// The action label, if there is one.
    pub action: Option<Ident>,
    /// When it is enabled.
    pub guard: Expr,
    /// The branches; at least one.
    pub branches: Vec<Branch>,
    /// The whole command.
    pub span: Span,
}

/// A branch of a command.
#[derive(Debug, Clone, PartialEq)]
pub struct Branch {
    /// Its probability; none for 1.
    pub probability: Option<Expr>,
    /// The assignments; none for `true`.
    pub updates: Vec<Assignment>,
    /// The whole branch.
    pub span: Span,
}

/// `(x' = e)`
#[derive(Debug, Clone, PartialEq)]
pub struct Assignment {
    /// The variable.
    pub variable: Ident,
    /// Its new value.
    pub value: Expr,
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
pub struct Rewards {
    /// Its name without quotes.
    pub name: Option<Ident>,
    /// Its lines.
    pub items: Vec<RewardItem>,
    /// The whole structure.
    pub span: Span,
}

/// A line of a reward structure.
#[derive(Debug, Clone, PartialEq)]
pub struct RewardItem {
    /// `[a]` or `[]`; none for a state reward.
    pub action: Option<Option<Ident>>,
    /// Where it is earned.
    pub guard: Expr,
    /// How much.
    pub value: Expr,
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
