//! Expressions: a pool of hash-consed, typed nodes over the variables of a program.
//!
//! A formula that occurs a thousand times is one node, so that nested formulas do not blow up and
//! both engines can remember what they computed for a node.

use std::num::NonZeroU32;

use ahash::RandomState;
use hashbrown::HashTable;

use super::VarId;
use super::value::{self, EvalError, Type, Value};
pub use super::value::{Binary, Unary};

/// A node of an [`ExprPool`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ExprId(NonZeroU32);

impl ExprId {
    /// The position of the node in its pool: operands come before the nodes that use them.
    pub fn index(self) -> usize {
        self.0.get() as usize - 1
    }

    fn at(index: usize) -> Self {
        ExprId(NonZeroU32::MIN.saturating_add(u32::try_from(index).unwrap_or(u32::MAX)))
    }
}

/// A node: operands are ids of the same pool.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Node {
    /// A literal.
    Literal(Value),
    /// The value of a variable in the present state.
    Var(VarId),
    /// One operand.
    Unary(Unary, ExprId),
    /// Two operands of the same type.
    Binary(Binary, ExprId, ExprId),
    /// `condition ? then : otherwise`; both branches have the same type.
    Ite(ExprId, ExprId, ExprId),
}

/// A pool of expressions. Equal expressions have equal ids; literals are folded, except where the
/// result has no value: such a node stays and fails where it is evaluated.
#[derive(Debug, Clone, Default)]
pub struct ExprPool {
    nodes: Vec<Node>,
    /// What is known of each node.
    known: Vec<Known>,
    /// The nodes by their content, which is looked up in `nodes`.
    index: HashTable<ExprId>,
    hasher: RandomState,
}

/// What is known of a node.
#[derive(Debug, Clone, Copy)]
struct Known {
    ty: Type,
    /// A truth value that the node has in no state.
    never: Option<bool>,
}

impl ExprPool {
    /// The node of `id`.
    pub fn node(&self, id: ExprId) -> Node {
        self.nodes[id.index()]
    }

    /// The type of `id`.
    pub fn ty(&self, id: ExprId) -> Type {
        self.known[id.index()].ty
    }

    /// Whether all nodes of another pool are here too, under the same ids.
    pub(super) fn starts_with(&self, other: &ExprPool) -> bool {
        self.nodes.starts_with(&other.nodes)
    }

    /// How many nodes there are.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// All nodes, operands before the nodes that use them.
    pub fn ids(&self) -> impl Iterator<Item = ExprId> + use<> {
        (0..self.nodes.len()).map(ExprId::at)
    }

    /// Whether there is no node.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// The value, if `id` is a literal.
    pub fn literal(&self, id: ExprId) -> Option<Value> {
        match self.node(id) {
            Node::Literal(v) => Some(v),
            _ => None,
        }
    }

    /// A literal.
    pub fn value(&mut self, v: Value) -> ExprId {
        self.intern(Node::Literal(v), v.ty())
    }

    /// A variable of the given type.
    pub fn var(&mut self, v: VarId, ty: Type) -> ExprId {
        self.intern(Node::Var(v), ty)
    }

    /// `op(a)`; the caller has checked the types. Folds literals.
    pub fn unary(&mut self, op: Unary, a: ExprId) -> ExprId {
        if let Some(Ok(v)) = self.literal(a).map(|v| value::unary(op, v)) {
            return self.value(v);
        }
        if let (Unary::Not, Node::Unary(Unary::Not, b)) = (op, self.node(a)) {
            return b;
        }
        let ty = value::unary_type(op, self.ty(a));
        self.intern(Node::Unary(op, a), ty)
    }

    /// `a op b`; the caller has checked the types and made both sides the same. Folds literals, the
    /// units of `&` and `|`, and these where `b` is never evaluated.
    pub fn binary(&mut self, op: Binary, a: ExprId, b: ExprId) -> ExprId {
        match (op, self.literal(a), self.literal(b)) {
            (Binary::And, Some(Value::Bool(true)), _) | (Binary::Or, Some(Value::Bool(false)), _) => {
                return b;
            }
            (Binary::And, _, Some(Value::Bool(true))) | (Binary::Or, _, Some(Value::Bool(false))) => {
                return a;
            }
            (Binary::And, ..) if self.never(a) == Some(true) => return a,
            (Binary::Or, ..) if self.never(a) == Some(false) => return a,
            (_, Some(x), Some(y)) => {
                if let Ok(v) = value::binary(op, x, y) {
                    return self.value(v);
                }
            }
            _ => {}
        }
        if a == b && matches!(op, Binary::And | Binary::Or | Binary::Min | Binary::Max) {
            return a;
        }
        let ty = value::binary_type(op, self.ty(a));
        self.intern(Node::Binary(op, a, b), ty)
    }

    /// `condition ? then : otherwise`; the branches have one type. Folds a literal condition.
    pub fn ite(&mut self, condition: ExprId, then: ExprId, otherwise: ExprId) -> ExprId {
        match self.literal(condition) {
            Some(Value::Bool(true)) => return then,
            Some(Value::Bool(false)) => return otherwise,
            _ => {}
        }
        if then == otherwise && self.literal(then).is_some() && self.is_total(condition) {
            return then;
        }
        let ty = self.ty(then);
        self.intern(Node::Ite(condition, then, otherwise), ty)
    }

    /// A truth value that `id` has in no state, as far as its operands show.
    fn never(&self, id: ExprId) -> Option<bool> {
        self.known[id.index()].never
    }

    fn never_of(&self, node: Node) -> Option<bool> {
        match node {
            Node::Literal(Value::Bool(b)) => Some(!b),
            Node::Unary(Unary::Not, a) => self.never(a).map(|b| !b),
            Node::Binary(op @ (Binary::And | Binary::Or), a, b) => {
                // One operand that never has this value keeps the whole from having it.
                let decisive = Some(op == Binary::And);
                let (a, b) = (self.never(a), self.never(b));
                if a == decisive || b == decisive { decisive } else { a.and(b) }
            }
            Node::Ite(_, a, b) if self.never(a) == self.never(b) => self.never(a),
            _ => None,
        }
    }

    /// Why `id` has a value in no state, where that is visible in the node itself.
    pub fn fault(&self, id: ExprId) -> Option<EvalError> {
        match self.node(id) {
            Node::Unary(op, a) => value::unary(op, self.literal(a)?).err(),
            // The second operand alone decides.
            Node::Binary(Binary::Mod, _, n) => {
                value::binary(Binary::Mod, Value::Int(0), self.literal(n)?).err()
            }
            Node::Binary(op, a, b) => value::binary(op, self.literal(a)?, self.literal(b)?).err(),
            Node::Literal(_) | Node::Var(_) | Node::Ite(..) => None,
        }
    }

    /// The operands of `id` that some state may need, in the order of evaluation.
    pub fn needed(&self, id: ExprId) -> impl Iterator<Item = ExprId> + use<> {
        let operands = match self.node(id) {
            Node::Literal(_) | Node::Var(_) => [None; 3],
            Node::Unary(_, a) => [Some(a), None, None],
            Node::Binary(_, a, b) => [Some(a), Some(b), None],
            Node::Ite(c, a, b) => match self.never(c) {
                Some(true) => [Some(c), Some(b), None],
                Some(false) => [Some(c), Some(a), None],
                None => [Some(c), Some(a), Some(b)],
            },
        };
        operands.into_iter().flatten()
    }

    /// Whether evaluating `id` cannot fail for a reason visible in the node itself.
    fn is_total(&self, id: ExprId) -> bool {
        matches!(self.node(id), Node::Literal(_) | Node::Var(_))
    }

    /// The value of `id` in a state: the reference meaning of expressions.
    ///
    /// `state` holds one value a variable, Booleans as 0 and 1, integers as themselves. Takes the
    /// branches that PRISM would take: `&`, `|` and `?:` evaluate only what they need.
    ///
    /// # Errors
    /// An operation without a value, such as an overflow or `mod` by zero.
    pub fn eval(&self, id: ExprId, state: &[i64]) -> Result<Value, EvalError> {
        match self.node(id) {
            Node::Literal(v) => Ok(v),
            Node::Var(v) => Ok(match self.ty(id) {
                Type::Bool => Value::Bool(state[v.index()] != 0),
                _ => Value::Int(state[v.index()]),
            }),
            Node::Unary(op, a) => value::unary(op, self.eval(a, state)?),
            Node::Binary(op, a, b) => {
                let x = self.eval(a, state)?;
                match (op, x) {
                    (Binary::And, Value::Bool(false)) | (Binary::Or, Value::Bool(true)) => Ok(x),
                    _ => value::binary(op, x, self.eval(b, state)?),
                }
            }
            Node::Ite(c, a, b) => match self.eval(c, state)? {
                Value::Bool(false) => self.eval(b, state),
                _ => self.eval(a, state),
            },
        }
    }

    /// The variables that occur in `id`, sorted, each once.
    pub fn support(&self, id: ExprId) -> Vec<VarId> {
        let (mut stack, mut seen, mut vars) = (vec![id], ahash::AHashSet::new(), Vec::new());
        while let Some(e) = stack.pop() {
            if !seen.insert(e) {
                continue;
            }
            match self.node(e) {
                Node::Literal(_) => {}
                Node::Var(v) => vars.push(v),
                Node::Unary(_, a) => stack.push(a),
                Node::Binary(_, a, b) => stack.extend([a, b]),
                Node::Ite(c, a, b) => stack.extend([c, a, b]),
            }
        }
        vars.sort_unstable();
        vars.dedup();
        vars
    }

    fn intern(&mut self, node: Node, ty: Type) -> ExprId {
        let hash = self.hasher.hash_one(node);
        if let Some(&id) = self.index.find(hash, |id| self.nodes[id.index()] == node) {
            return id;
        }
        let id = ExprId::at(self.nodes.len());
        self.known.push(Known { ty, never: self.never_of(node) });
        self.nodes.push(node);
        let (nodes, hasher) = (&self.nodes, &self.hasher);
        self.index.insert_unique(hash, id, |id| hasher.hash_one(nodes[id.index()]));
        id
    }
}
