//! The syntax tree of a model file, close to the text.
//!
//! A model file is an outline, in which expressions and commands are places. Expressions and
//! commands themselves are read one by one ([`Expr`], `Command`).

use crate::property::Operator;
pub use meliora_base::span::Span;
use meliora_base::value::{Type, Value};
use meliora_model::ModelKind;
use meliora_model::expr::ExprId;

/// A name with its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ident {
    /// The name, without quotes or prime.
    pub name: String,
    /// Place in the text.
    pub span: Span,
}

/// An expression, as the list of its nodes in post-order: operands come before their operator, and
/// the root is last. A fold over it is a loop with a stack, so its depth does not matter.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Expr {
    /// Nodes in post-order.
    pub nodes: Vec<Node>,
}

impl Expr {
    /// Creates an expression of a single node.
    pub(crate) fn new(kind: NodeKind, span: Span) -> Self {
        Expr { nodes: vec![Node { kind, span }] }
    }

    /// Returns the place of the whole expression.
    pub(crate) fn span(&self) -> Span {
        self.nodes.last().map_or(Span::default(), |root| root.span)
    }
}

/// A node of an expression with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Form of the node.
    pub kind: NodeKind,
    /// Place in the text, without enclosing brackets.
    pub span: Span,
}

/// The forms of nodes. Operators have as many operands as [`NodeKind::operands`] says.
#[derive(Debug, Clone, PartialEq)]
pub enum NodeKind {
    /// `true`, `7`, `0.5`; numbers are finite and, in PRISM's language, never negative.
    Literal(Value),
    /// A variable, a constant, a formula or a parameter.
    Name(Box<str>),
    /// `"name"`: a label.
    Label(Box<str>),
    /// `!e`
    Not,
    /// `-e`
    Neg,
    /// `e op e`, with any operator but `&` and `|`.
    Binary(BinaryOp),
    /// `e & e & …` or `e | e | …`, with the number of operands.
    Join(BinaryOp, u32),
    /// `c ? e : e`
    Ite,
    /// `f(e, …)` with a function that the model names, and the number of arguments.
    Call(Box<Ident>, u32),
    /// A built-in function that the format names, and the number of arguments.
    Apply(Function, u32),
    /// An operator of properties, which is a condition or a number; only in properties.
    Operator(Box<Operator>),
    /// An expression in the pool of a program; only in properties of JANI models.
    Known(ExprId),
    /// `a[i]`; only in JANI, as the next two.
    Element,
    /// An array of values, with their number.
    Array(u32),
    /// An array of the values of an expression for all indices.
    Comprehension(Box<Comprehension>),
}

/// An array constructor.
#[derive(Debug, Clone, PartialEq)]
pub struct Comprehension {
    /// The name of the index.
    pub(crate) variable: Ident,
    /// The length, a constant.
    pub(crate) length: Expr,
    /// The value of an element.
    pub(crate) body: Expr,
}

impl NodeKind {
    /// Returns the number of operands.
    pub fn operands(&self) -> usize {
        match self {
            NodeKind::Literal(_)
            | NodeKind::Name(_)
            | NodeKind::Label(_)
            | NodeKind::Operator(_)
            | NodeKind::Known(_)
            | NodeKind::Comprehension(_) => 0,
            NodeKind::Not | NodeKind::Neg => 1,
            NodeKind::Binary(_) | NodeKind::Element => 2,
            NodeKind::Ite => 3,
            NodeKind::Join(_, n) | NodeKind::Call(_, n) | NodeKind::Apply(_, n) | NodeKind::Array(n) => {
                *n as usize
            }
        }
    }
}

/// The built-in functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    /// The minimum of at least two numbers.
    Min,
    /// The maximum of at least two numbers.
    Max,
    /// The largest integer that is not greater.
    Floor,
    /// The smallest integer that is not less.
    Ceil,
    /// The nearest integer.
    Round,
    /// The power of a base and an exponent.
    Pow,
    /// The remainder of a division of integers.
    Mod,
    /// The logarithm of a number to a base.
    Log,
    /// The absolute value; only in JANI.
    Abs,
    /// The sign, -1, 0 or 1; only in JANI.
    Sign,
    /// The integer part, rounded towards 0; only in JANI.
    Truncate,
}

/// The functions of PRISM's language with their names.
const FUNCTIONS: [(Function, &str); 8] = [
    (Function::Min, "min"),
    (Function::Max, "max"),
    (Function::Floor, "floor"),
    (Function::Ceil, "ceil"),
    (Function::Round, "round"),
    (Function::Pow, "pow"),
    (Function::Mod, "mod"),
    (Function::Log, "log"),
];

impl Function {
    /// Returns the function of PRISM's language with this name.
    pub(crate) fn named(name: &str) -> Option<Function> {
        FUNCTIONS.iter().find(|f| f.1 == name).map(|f| f.0)
    }

    /// Returns the name for messages.
    pub fn name(self) -> &'static str {
        FUNCTIONS.iter().find(|f| f.0 == self).map_or("a function", |f| f.1)
    }
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
        self.form().0
    }

    /// Returns the operator as written.
    pub fn symbol(self) -> &'static str {
        self.form().1
    }

    fn form(self) -> (u8, &'static str) {
        match self {
            BinaryOp::Implies => (0, "=>"),
            BinaryOp::Iff => (1, "<=>"),
            BinaryOp::Or => (2, "|"),
            BinaryOp::And => (3, "&"),
            BinaryOp::Eq => (5, "="),
            BinaryOp::Ne => (5, "!="),
            BinaryOp::Lt => (6, "<"),
            BinaryOp::Le => (6, "<="),
            BinaryOp::Gt => (6, ">"),
            BinaryOp::Ge => (6, ">="),
            BinaryOp::Add => (7, "+"),
            BinaryOp::Sub => (7, "-"),
            BinaryOp::Mul => (8, "*"),
            BinaryOp::Div => (8, "/"),
            BinaryOp::Pow => (10, "^"),
        }
    }
}

/// A model file. Of expressions and commands it has only the places: a tree needs many times the
/// memory of its text, and a model may have millions of commands. Each is parsed again when it is
/// needed.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// Model type with its place, if it is given.
    pub kind: Option<(ModelKind, Span)>,
    /// All other parts, in the order of the text.
    pub items: Vec<Item>,
}

/// A part of a model file. Parts that may occur millions of times are small; the others are boxed.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// `const …;`
    Const(ConstDef),
    /// `formula f = e;`
    Formula(NamedExpr),
    /// `label "l" = e;`
    Label(NamedExpr),
    /// `global x : …;`
    Global(Box<VarDecl>),
    /// `module … endmodule`
    Module(Box<Module>),
    /// `module … = … [ … ] endmodule`
    Renamed(Box<RenamedModule>),
    /// `rewards … endrewards`
    Rewards(Box<Rewards>),
    /// `init … endinit`
    Init(Span),
    /// `system … endsystem`
    System(Box<System>),
    /// `player … endplayer`
    Player(Box<Player>),
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
    pub(crate) fn ty(self) -> Type {
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
    /// Type.
    pub ty: ConstType,
    /// Name.
    pub name: Ident,
    /// Value; `None` for a constant that is defined on the command line.
    pub value: Option<Span>,
}

/// A formula, or a label with its condition.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedExpr {
    /// Name without quotes.
    pub name: Ident,
    /// Expression that the name stands for.
    pub body: Span,
}

/// A variable.
#[derive(Debug, Clone, PartialEq)]
pub struct VarDecl {
    /// Name.
    pub name: Ident,
    /// Range; `None` for `bool`.
    pub range: Option<(Span, Span)>,
    /// `init e`
    pub init: Option<Span>,
    /// Place of the whole declaration.
    pub span: Span,
}

/// A module.
#[derive(Debug, Clone, PartialEq)]
pub struct Module {
    /// Name.
    pub name: Ident,
    /// Variables.
    pub variables: Vec<VarDecl>,
    /// Commands.
    pub commands: Vec<Span>,
}

/// A command.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Command {
    /// Action label, if there is one.
    pub action: Option<Ident>,
    /// Guard.
    pub guard: Expr,
    /// Branches; at least one.
    pub branches: Vec<Branch>,
    /// Place of the whole command.
    pub span: Span,
}

/// A branch of a command.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Branch {
    /// Probability; `None` for 1.
    pub probability: Option<Expr>,
    /// Assignments; empty for `true`.
    pub updates: Vec<Assignment>,
    /// Place of the whole branch.
    pub span: Span,
}

/// `(x' = e)`
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Assignment {
    /// The variable.
    pub variable: Ident,
    /// Its new value.
    pub value: Expr,
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
pub struct Rewards {
    /// Name without quotes.
    pub name: Option<Ident>,
    /// Reward items.
    pub items: Vec<RewardItem>,
    /// Place of the whole structure.
    pub span: Span,
}

/// One item of a reward structure.
#[derive(Debug, Clone, PartialEq)]
pub struct RewardItem {
    /// `[a]` or `[]`; `None` for a state reward.
    pub action: Option<Option<Ident>>,
    /// Condition for the states that earn the reward.
    pub guard: Span,
    /// Value of the reward.
    pub value: Span,
}

/// A player of a game.
#[derive(Debug, Clone, PartialEq)]
pub struct Player {
    /// Name.
    pub name: Ident,
    /// The modules and actions that it owns.
    pub items: Vec<PlayerItem>,
}

/// A part of a model that a player owns.
#[derive(Debug, Clone, PartialEq)]
pub enum PlayerItem {
    /// `m`: the unlabelled commands of a module.
    Module(Ident),
    /// `[a]`: all choices with an action.
    Action(Ident),
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
