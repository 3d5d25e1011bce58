//! A pool of hash-consed, typed expressions over the variables of a program.
//!
//! A formula that occurs a thousand times is a single node. Nested formulas therefore do not blow
//! up, and both engines can cache one result per node.
//!
//! A pool can rest on another one, which it shares: the conditions of a question need only their own
//! nodes, however large the program is.

use std::num::NonZeroU32;
use std::sync::Arc;

use ahash::{AHashMap, RandomState};
use hashbrown::HashTable;

use super::VarId;
use meliora_base::error::Diagnostic;
use meliora_base::exact::{self, Exact, Ratio, Real};
use meliora_base::value::{self, EvalError, Type, Value};
pub use meliora_base::value::{Binary, Unary};

/// The identifier of a node of an [`ExprPool`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ExprId(NonZeroU32);

impl ExprId {
    /// Returns the position of the node in its pool: operands come before the nodes that use them.
    pub fn index(self) -> usize {
        self.0.get() as usize - 1
    }

    fn at(index: usize) -> Self {
        ExprId(NonZeroU32::MIN.saturating_add(u32::try_from(index).unwrap_or(u32::MAX)))
    }
}

/// A node; its operands are ids of the same pool.
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

/// A pool of expressions. Equal expressions have equal ids. Operations on literals are folded,
/// unless the result has no value: such a node stays and fails when it is evaluated.
#[derive(Debug, Clone, Default)]
pub struct ExprPool {
    /// The pool that this one rests on: its nodes come first, under the same ids.
    base: Option<Arc<ExprPool>>,
    /// The number of nodes of the base.
    first: usize,
    /// The nodes that follow those of the base.
    nodes: Vec<Node>,
    /// The type and the constant properties of each of these nodes.
    known: Vec<Known>,
    /// A hash index of these nodes; their content is in `nodes`.
    index: HashTable<ExprId>,
    hasher: RandomState,
    /// The exact values of the finite real literals. Two literals with the same double may differ
    /// here.
    exact: AHashMap<ExprId, Ratio>,
    /// The literals that operations on literals were folded to.
    folds: AHashMap<Node, ExprId>,
    /// The first expression, of those not in the base, for whose exact value a double counts.
    pub inexact: Option<Diagnostic>,
}

/// The type and the constant properties of a node.
#[derive(Debug, Clone, Copy)]
struct Known {
    ty: Type,
    /// A truth value that the node has in no state, if known.
    never: Option<bool>,
    /// The number of operators, counted once per use.
    operators: u32,
}

impl ExprPool {
    /// Creates a pool without nodes of its own that rests on another one.
    pub fn over(base: &Arc<ExprPool>) -> Self {
        ExprPool {
            base: Some(Arc::clone(base)),
            first: base.len(),
            hasher: base.hasher.clone(),
            ..ExprPool::default()
        }
    }

    /// Returns this pool, the one that it rests on, and so on.
    fn layers(&self) -> impl Iterator<Item = &ExprPool> {
        std::iter::successors(Some(self), |pool| pool.base.as_deref())
    }

    /// Returns whether this pool is `other`, or rests on it: all ids of `other` mean the same here.
    pub fn rests_on(&self, other: &Arc<ExprPool>) -> bool {
        self.layers().any(|pool| std::ptr::eq(pool, &**other))
    }

    /// Returns the node of `id`.
    pub fn node(&self, id: ExprId) -> Node {
        match &self.base {
            Some(base) if id.index() < self.first => base.node(id),
            _ => self.nodes[id.index() - self.first],
        }
    }

    fn known(&self, id: ExprId) -> Known {
        match &self.base {
            Some(base) if id.index() < self.first => base.known(id),
            _ => self.known[id.index() - self.first],
        }
    }

    /// Returns the type of `id`.
    pub fn ty(&self, id: ExprId) -> Type {
        self.known(id).ty
    }

    /// Returns the number of nodes.
    pub fn len(&self) -> usize {
        self.first + self.nodes.len()
    }

    /// Returns all nodes, operands before the nodes that use them.
    pub fn ids(&self) -> impl Iterator<Item = ExprId> + use<> {
        (0..self.len()).map(ExprId::at)
    }

    /// Returns whether the pool is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the value if `id` is a literal.
    pub fn literal(&self, id: ExprId) -> Option<Value> {
        match self.node(id) {
            Node::Literal(v) => Some(v),
            _ => None,
        }
    }

    /// Returns the node of a literal. A real stands for the shortest decimal that rounds to it.
    pub fn value(&mut self, v: Value) -> ExprId {
        let exact = match v {
            Value::Bool(b) => Exact::Bool(b),
            Value::Int(i) => Exact::Int(i),
            Value::Real(x) => Exact::Real(Real::shortest(x)),
        };
        self.exact_value(exact)
    }

    /// Returns the node of a literal with an exact value.
    pub fn exact_value(&mut self, value: Exact) -> ExprId {
        let v = value.rounded();
        let exact = match value {
            Exact::Real(Real::Finite(exact)) => Some(exact),
            _ => None,
        };
        let id = self.intern_exact(Node::Literal(v), v.ty(), exact.as_ref());
        if let Some(exact) = exact.filter(|_| id.index() >= self.first) {
            self.exact.insert(id, exact);
        }
        id
    }

    /// Returns the operations on literals that were folded, each with the literal of its value. All
    /// other literals stand in the text.
    pub fn folds(&self) -> impl Iterator<Item = (Node, ExprId)> {
        self.layers().flat_map(|pool| pool.folds.iter().map(|(node, id)| (*node, *id)))
    }

    fn fold(&mut self, node: Node, value: Exact) -> ExprId {
        let id = self.exact_value(value);
        self.folds.insert(node, id);
        id
    }

    /// Returns the exact value of a real literal; `None` if it is not finite, or not a real.
    pub(super) fn fraction(&self, id: ExprId) -> Option<&Ratio> {
        self.layers().find(|pool| id.index() >= pool.first)?.exact.get(&id)
    }

    /// Returns the node of a variable of the given type.
    pub fn var(&mut self, v: VarId, ty: Type) -> ExprId {
        self.intern(Node::Var(v), ty)
    }

    /// Returns the node of `op(a)`; the caller has checked the types. Folds literals.
    pub fn unary(&mut self, op: Unary, a: ExprId) -> ExprId {
        if let Some(Ok(v)) = self.exact_literal(a).map(|v| exact::unary(op, v)) {
            return self.fold(Node::Unary(op, a), v);
        }
        if let (Unary::Not, Node::Unary(Unary::Not, b)) = (op, self.node(a)) {
            return b;
        }
        let ty = value::unary_type(op, self.ty(a));
        self.intern(Node::Unary(op, a), ty)
    }

    /// Returns the node of `a op b`; the caller has checked the types and converted both sides to
    /// the same type. Folds literals, the neutral elements of `&` and `|`, and `&` and `|` if `b`
    /// is never evaluated.
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
            (_, Some(_), Some(_)) => {
                if let Some(Ok(v)) = self.folded(op, a, b) {
                    return self.fold(Node::Binary(op, a, b), v);
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

    /// Joins conditions by `&` or `|`, pair by pair, so that the height is the logarithm of their number; without any,
    /// returns the neutral element.
    pub fn joined(&mut self, op: Binary, mut row: Vec<ExprId>) -> ExprId {
        while row.len() > 1 {
            let join = |pair: &[ExprId]| match *pair {
                [a, b] => self.binary(op, a, b),
                _ => pair[0],
            };
            row = row.chunks(2).map(join).collect();
        }
        row.first().copied().unwrap_or_else(|| self.value(Value::Bool(op == Binary::And)))
    }

    /// Returns the value of `a op b` on two literals.
    fn folded(&self, op: Binary, a: ExprId, b: ExprId) -> Option<Result<Exact, EvalError>> {
        Some(exact::binary(op, &self.exact_literal(a)?, &self.exact_literal(b)?))
    }

    /// Returns the node of `condition ? then : otherwise`; the branches have the same type. Folds a
    /// literal condition.
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

    /// Returns the number of operators of an expression, counted once per use.
    pub(super) fn operators(&self, id: ExprId) -> u32 {
        self.known(id).operators
    }

    /// Returns a truth value that `id` has in no state, as far as its operands show.
    fn never(&self, id: ExprId) -> Option<bool> {
        self.known(id).never
    }

    fn never_of(&self, node: Node) -> Option<bool> {
        match node {
            Node::Literal(Value::Bool(b)) => Some(!b),
            Node::Unary(Unary::Not, a) => self.never(a).map(|b| !b),
            Node::Binary(op @ (Binary::And | Binary::Or), a, b) => {
                // If one operand never has this value, the whole never has it.
                let decisive = Some(op == Binary::And);
                let (a, b) = (self.never(a), self.never(b));
                if a == decisive || b == decisive { decisive } else { a.and(b) }
            }
            Node::Ite(_, a, b) if self.never(a) == self.never(b) => self.never(a),
            _ => None,
        }
    }

    /// Returns the reason why `id` has no value in any state, if the node itself shows it.
    pub fn fault(&self, id: ExprId) -> Option<EvalError> {
        match self.node(id) {
            Node::Unary(op, a) => exact::unary(op, self.exact_literal(a)?).err(),
            // The second operand alone decides.
            Node::Binary(Binary::Mod, _, n) => {
                exact::binary(Binary::Mod, &Exact::Int(0), &self.exact_literal(n)?).err()
            }
            Node::Binary(op, a, b) => self.folded(op, a, b)?.err(),
            Node::Literal(_) | Node::Var(_) | Node::Ite(..) => None,
        }
    }

    /// Returns the operands of `id`.
    pub fn operands(&self, id: ExprId) -> impl Iterator<Item = ExprId> + use<> {
        let operands = match self.node(id) {
            Node::Literal(_) | Node::Var(_) => [None; 3],
            Node::Unary(_, a) => [Some(a), None, None],
            Node::Binary(_, a, b) => [Some(a), Some(b), None],
            Node::Ite(c, a, b) => [Some(c), Some(a), Some(b)],
        };
        operands.into_iter().flatten()
    }

    /// Returns the operands of `id` that some state may need, in the order of evaluation.
    pub fn needed(&self, id: ExprId) -> impl Iterator<Item = ExprId> + use<> {
        let unused = match self.node(id) {
            Node::Ite(c, ..) => self.never(c).map(|never| if never { 1 } else { 2 }),
            _ => None,
        };
        self.operands(id).enumerate().filter(move |&(place, _)| Some(place) != unused).map(|(_, e)| e)
    }

    /// Returns whether the node itself shows that the evaluation of `id` cannot fail.
    fn is_total(&self, id: ExprId) -> bool {
        matches!(self.node(id), Node::Literal(_) | Node::Var(_))
    }

    /// Evaluates `id` in a state. This is the reference semantics of expressions; a real is rounded
    /// in the end.
    ///
    /// `state` contains one value per variable: Booleans as 0 and 1, integers as they are. As in
    /// PRISM, `&`, `|` and `?:` evaluate only the operands they need.
    ///
    /// # Errors
    /// An operation has no value, for example an overflow or `mod` by zero.
    pub fn eval(&self, id: ExprId, state: &[i64]) -> Result<Value, EvalError> {
        self.exact(id, state).map(|value| value.rounded())
    }

    /// Returns the variables that occur in `id`, sorted, each once.
    pub fn support(&self, id: ExprId) -> Vec<VarId> {
        let (mut stack, mut seen, mut vars) = (vec![id], ahash::AHashSet::new(), Vec::new());
        while let Some(e) = stack.pop() {
            if !seen.insert(e) {
                continue;
            }
            match self.node(e) {
                Node::Var(v) => vars.push(v),
                _ => stack.extend(self.operands(e)),
            }
        }
        vars.sort_unstable();
        vars.dedup();
        vars
    }

    fn intern(&mut self, node: Node, ty: Type) -> ExprId {
        self.intern_exact(node, ty, None)
    }

    fn intern_exact(&mut self, node: Node, ty: Type, exact: Option<&Ratio>) -> ExprId {
        // All layers have the same hasher.
        let hash = self.hasher.hash_one(node);
        let find = |pool: &ExprPool| {
            let is_it =
                |id: &ExprId| pool.nodes[id.index() - pool.first] == node && pool.exact.get(id) == exact;
            pool.index.find(hash, is_it).copied()
        };
        if let Some(id) = self.layers().find_map(find) {
            return id;
        }
        let id = ExprId::at(self.len());
        self.nodes.push(node);
        let operators = match node {
            Node::Literal(_) | Node::Var(_) => 0,
            _ => self.operands(id).fold(1u32, |all, e| all.saturating_add(self.operators(e))),
        };
        self.known.push(Known { ty, never: self.never_of(node), operators });
        let (nodes, first, hasher) = (&self.nodes, self.first, &self.hasher);
        self.index.insert_unique(hash, id, |id| hasher.hash_one(nodes[id.index() - first]));
        id
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pool_on_top_of_another_shares_its_nodes_and_leaves_it_alone() {
        let mut below = ExprPool::default();
        let x = below.var(VarId(0), Type::Int);
        let two = below.value(Value::Int(2));
        let tenth = below.exact_value(Exact::Real(Real::shortest(0.1)));
        let below = Arc::new(below);
        let (mut middle, nodes) = (ExprPool::over(&below), below.len());
        let small = middle.binary(Binary::Le, x, two);
        let middle = Arc::new(middle);
        let mut top = ExprPool::over(&middle);
        // Nodes below are found there.
        assert_eq!([top.var(VarId(0), Type::Int), top.value(Value::Int(2))], [x, two]);
        assert_eq!(top.exact_value(Exact::Real(Real::shortest(0.1))), tenth);
        assert_eq!(top.binary(Binary::Le, x, two), small);
        assert_eq!(top.len(), middle.len());
        // New nodes get the next numbers.
        let large = top.unary(Unary::Not, small);
        assert_eq!([small.index(), large.index()], [nodes, nodes + 1]);
        let four = top.binary(Binary::Add, two, two);
        assert_eq!(top.literal(four), Some(Value::Int(4)));
        assert_eq!(top.folds().map(|(_, literal)| literal).collect::<Vec<_>>(), [four]);
        assert_eq!((below.len(), middle.len(), top.ids().count()), (nodes, nodes + 1, nodes + 3));
        for (id, ty) in [(x, Type::Int), (tenth, Type::Real), (small, Type::Bool), (large, Type::Bool)] {
            assert_eq!(top.ty(id), ty);
        }
        assert_eq!(top.exact_literal(tenth), below.exact_literal(tenth));
        assert_eq!([2, 3].map(|x| top.eval(large, &[x])), [false, true].map(|b| Ok(Value::Bool(b))));
        assert!(top.rests_on(&below) && top.rests_on(&middle) && !middle.rests_on(&Arc::new(top)));
    }
}
