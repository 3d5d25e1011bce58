//! Conditions over a program. Their expressions have pools of their own, so that a question neither
//! changes nor copies the program.

use std::cmp::Ordering;
use std::fmt;
use std::sync::Arc;

use ahash::{AHashMap, AHashSet, RandomState};

use super::Program;
use super::expr::{ExprId, ExprPool, Node};
use meliora_base::error::{Diagnostic, Error, Result};
use meliora_base::value::{EvalError, Value};

/// A condition on the states of a program: an expression together with its pool, so that its number
/// cannot be read in another pool.
#[derive(Clone)]
pub struct Predicate {
    of: Predicates,
    id: ExprId,
}

impl Predicate {
    /// Returns the pool of the expression.
    pub fn pool(&self) -> &ExprPool {
        &self.of.pool
    }

    /// Returns the expression, a node of [`Predicate::pool`].
    pub fn id(&self) -> ExprId {
        self.id
    }

    /// Returns the first expression of the pool for whose exact value a double counts; those of the
    /// program left out.
    pub fn inexact(&self) -> Option<&Diagnostic> {
        self.of.pool.inexact.as_ref()
    }

    /// Evaluates the condition in a state of the program.
    ///
    /// # Errors
    /// The expression has no value in this state.
    pub fn eval(&self, state: &[i64]) -> std::result::Result<Value, EvalError> {
        self.of.pool.eval(self.id, state)
    }

    /// Returns whether this is the same expression over the same program as another condition, whose
    /// pool may be another one. Two different expressions can still hold in the same states.
    pub fn is_same(&self, other: &Predicate) -> bool {
        if !Arc::ptr_eq(&self.of.program, &other.of.program) {
            return false;
        }
        let (mut open, mut seen) = (vec![(self.id, other.id)], AHashSet::new());
        while let Some((one, two)) = open.pop() {
            let is_shared = one == two && one.index() < self.of.program.len();
            if is_shared || !seen.insert((one, two)) {
                continue;
            }
            let is_equal = match (self.pool().node(one), other.pool().node(two)) {
                (Node::Unary(a, x), Node::Unary(b, y)) if a == b => {
                    open.push((x, y));
                    true
                }
                (Node::Binary(a, x, u), Node::Binary(b, y, v)) if a == b => {
                    open.extend([(x, y), (u, v)]);
                    true
                }
                (Node::Ite(a, x, u), Node::Ite(b, y, v)) => {
                    open.extend([(a, b), (x, y), (u, v)]);
                    true
                }
                (a, b) => a == b && self.pool().fraction(one) == other.pool().fraction(two),
            };
            if !is_equal {
                return false;
            }
        }
        true
    }

    /// Returns a number that is equal for conditions that [are the same](Predicate::is_same). Cost: one
    /// visit per expression that is not of the program.
    pub fn fingerprint(&self) -> u64 {
        let (hasher, program) = (RandomState::with_seeds(0, 1, 2, 3), self.of.program.len());
        let (mut known, mut stack): (AHashMap<ExprId, u64>, _) = (AHashMap::new(), vec![self.id]);
        let own = |e: ExprId| (e.index() < program).then(|| hasher.hash_one(e));
        while let Some(&e) = stack.last() {
            let of = |known: &AHashMap<ExprId, u64>, e: ExprId| own(e).or_else(|| known.get(&e).copied());
            let open = stack.len();
            stack.extend(self.pool().operands(e).filter(|&a| of(&known, a).is_none()));
            if stack.len() > open {
                continue;
            }
            stack.pop();
            let operands: Vec<Option<u64>> = self.pool().operands(e).map(|a| of(&known, a)).collect();
            let node = match self.pool().node(e) {
                leaf @ (Node::Literal(_) | Node::Var(_)) => hasher.hash_one(leaf),
                Node::Unary(op, _) => hasher.hash_one((op, operands)),
                Node::Binary(op, ..) => hasher.hash_one((op, operands)),
                Node::Ite(..) => hasher.hash_one(operands),
            };
            known.insert(e, own(e).unwrap_or(node));
        }
        known.get(&self.id).copied().unwrap_or(0)
    }

    /// Checks that the condition has a meaning in the states of a program: it was made for this
    /// program, or for the one to which monitors were added.
    ///
    /// # Errors
    /// [`Error::Usage`] if it was made for another program.
    pub fn check(&self, program: &Program) -> Result<()> {
        match program.pool.rests_on(&self.of.program) {
            true => Ok(()),
            false => Err(Error::Usage("the condition was made for another program".to_owned())),
        }
    }
}

/// Equal numbers in the same pool.
impl PartialEq for Predicate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Predicate {}

impl PartialOrd for Predicate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The order of the numbers; the order of pools has no meaning.
impl Ord for Predicate {
    fn cmp(&self, other: &Self) -> Ordering {
        let place = |p: &Predicate| (p.id, Arc::as_ptr(&p.of.pool));
        place(self).cmp(&place(other))
    }
}

impl fmt::Debug for Predicate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Predicate").field(&self.id).finish()
    }
}

/// Conditions of a program, in a pool that rests on that of the program. Clones share the pool.
#[derive(Clone)]
pub struct Predicates {
    /// The pool of the program.
    program: Arc<ExprPool>,
    pool: Arc<ExprPool>,
}

impl Predicates {
    /// Starts a pool for conditions of a program, in which the expressions of the program keep their
    /// numbers.
    pub fn over(program: &Program) -> Self {
        let pool = ExprPool::over(&program.pool).into();
        Predicates { program: Arc::clone(&program.pool), pool }
    }

    /// Returns the expressions of a program's pool as conditions.
    pub fn new(pool: Arc<ExprPool>) -> Self {
        Predicates { program: Arc::clone(&pool), pool }
    }

    /// Returns the pool, to add conditions. If some have been handed out, they keep the pool as it was
    /// then.
    pub fn pool(&mut self) -> &mut ExprPool {
        Arc::make_mut(&mut self.pool)
    }

    /// Returns the pool with the conditions added so far.
    pub fn into_pool(self) -> Arc<ExprPool> {
        self.pool
    }

    /// Returns an expression of the pool as a condition.
    pub fn get(&self, id: ExprId) -> Predicate {
        Predicate { of: self.clone(), id }
    }
}

impl fmt::Debug for Predicates {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Predicates").field(&self.pool.len()).finish()
    }
}

impl Program {
    /// Returns the expressions of this program as conditions.
    pub fn predicates(&self) -> Predicates {
        Predicates::new(Arc::clone(&self.pool))
    }

    /// Returns an expression of this program as a condition.
    pub fn predicate(&self, id: ExprId) -> Predicate {
        self.predicates().get(id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VarId;
    use meliora_base::value::{Binary, Type};

    #[test]
    fn conditions_that_are_the_same_have_one_fingerprint_whatever_their_pools() {
        let mut below = ExprPool::default();
        let x = below.var(VarId(0), Type::Int);
        let below = Arc::new(below);
        let conditions = |numbers: &[i64]| {
            let mut own = Predicates::new(Arc::clone(&below));
            own.pool = ExprPool::over(&below).into();
            let at_least = |own: &mut Predicates, &number: &i64| {
                let number = own.pool().value(Value::Int(number));
                own.pool().binary(Binary::Le, number, x)
            };
            let ids: Vec<ExprId> = numbers.iter().map(|number| at_least(&mut own, number)).collect();
            ids.into_iter().map(|id| own.get(id)).collect::<Vec<_>>()
        };
        let (one, other) = (conditions(&[1, 2, 3]), conditions(&[3, 2]));
        assert!(one[2].is_same(&other[0]) && one[1].is_same(&other[1]) && !one[0].is_same(&other[0]));
        assert_eq!(one[2].fingerprint(), other[0].fingerprint());
        assert_eq!(one[1].fingerprint(), other[1].fingerprint());
        assert_ne!(one[0].fingerprint(), other[0].fingerprint());
    }
}
