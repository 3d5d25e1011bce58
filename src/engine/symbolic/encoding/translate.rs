//! Expressions as diagrams: their values in all states at once.

use std::cell::RefCell;

use ahash::AHashMap;

use super::Encoding;
use super::partition::Partition;
use super::symbolic_integer::SymbolicInteger;
use crate::symbolic::store::Store;
use crate::symbolic::store::charge::{BYTES_OF_TABLE, Charge};
use crate::symbolic::store::diagram::Bdd;
use meliora_base::error::Result;
use meliora_base::exact::{self, Exact};
use meliora_base::value::{self, Type};
use meliora_model::Program;
use meliora_model::expr::{Binary, ExprId, ExprPool, Node, Unary};

/// The value of an expression in every state.
#[derive(Clone)]
pub(in crate::symbolic) enum Meaning {
    /// The states in which a Boolean expression is true.
    Bool(Bdd),
    /// An integer.
    Int(SymbolicInteger),
    /// A real.
    Real(Partition),
}

/// A value together with the states in which evaluation fails.
#[derive(Clone)]
pub(in crate::symbolic) struct Symbolic {
    /// The value; arbitrary in the states in which evaluation fails.
    pub(in crate::symbolic) meaning: Meaning,
    /// The states in which an evaluated operation has no value.
    pub(in crate::symbolic) fails: Bdd,
    /// The bit patterns that are values of the variables that occur. Other variables are not
    /// restricted, so that the diagram depends on as few bits as the expression.
    pub(in crate::symbolic) within: Bdd,
}

impl Symbolic {
    /// Returns the bytes of the value in the table of a translator.
    fn bytes(&self) -> usize {
        let meaning = match &self.meaning {
            Meaning::Bool(_) => 0,
            Meaning::Int(bits) => bits.len() * size_of::<Bdd>(),
            Meaning::Real(partition) => partition.len() * size_of::<(Exact, Bdd)>(),
        };
        meaning + BYTES_OF_TABLE * size_of::<(ExprId, Symbolic)>()
    }
}

/// Translates the expressions of one program and remembers every node.
pub(in crate::symbolic) struct Translator<'a> {
    program: &'a Program,
    pool: &'a ExprPool,
    encoding: &'a Encoding,
    store: &'a Store,
    known: RefCell<AHashMap<ExprId, Symbolic>>,
    charge: RefCell<Charge>,
}

impl<'a> Translator<'a> {
    /// Creates a translator without results.
    pub(in crate::symbolic) fn new(program: &'a Program, encoding: &'a Encoding, store: &'a Store) -> Self {
        Self::of(program, &program.pool, encoding, store)
    }

    /// Creates a translator of a pool over the variables of a program.
    pub(in crate::symbolic) fn of(
        program: &'a Program,
        pool: &'a ExprPool,
        encoding: &'a Encoding,
        store: &'a Store,
    ) -> Self {
        let charge = store.charge().into();
        Translator { program, pool, encoding, store, known: RefCell::default(), charge }
    }

    /// Returns the states in which a Boolean expression is true, and those in which it has no
    /// value.
    pub(in crate::symbolic) fn condition(&self, e: ExprId) -> Result<(Bdd, Bdd)> {
        let symbolic = self.translate(e)?;
        Ok((self.truth(&symbolic.meaning)?, symbolic.fails))
    }

    /// Returns the values of a numeric expression, and the states in which it has none.
    pub(in crate::symbolic) fn values(&self, e: ExprId) -> Result<(Partition, Bdd)> {
        let symbolic = self.translate(e)?;
        Ok((self.partition(&symbolic)?, symbolic.fails))
    }

    /// Returns an integer expression (or a Boolean one, as 0 and 1), and the states in which it has
    /// no value.
    pub(in crate::symbolic) fn integer(&self, e: ExprId) -> Result<(SymbolicInteger, Bdd)> {
        let symbolic = self.translate(e)?;
        let bits = match symbolic.meaning {
            Meaning::Int(bits) => bits,
            Meaning::Bool(f) => SymbolicInteger::from_bits(vec![f, self.store.zero()], 0, 1),
            Meaning::Real(p) => p.to_bits(self.store)?,
        };
        Ok((bits, symbolic.fails))
    }

    fn translate(&self, root: ExprId) -> Result<Symbolic> {
        // Without recursion, because expressions may be deeply nested. Operands precede the nodes
        // using them.
        let mut stack = vec![root];
        while let Some(&e) = stack.last() {
            if self.known.borrow().contains_key(&e) {
                stack.pop();
                continue;
            }
            let missing: Vec<ExprId> =
                self.operands(e).filter(|o| !self.known.borrow().contains_key(o)).collect();
            if missing.is_empty() {
                let within = self.patterns(e)?;
                let symbolic = Symbolic { within, ..self.node(e)? };
                self.charge.borrow_mut().add(symbolic.bytes());
                self.known.borrow_mut().insert(e, symbolic);
                stack.pop();
            } else {
                stack.extend(missing);
            }
        }
        Ok(self.get(root))
    }

    fn operands(&self, e: ExprId) -> impl Iterator<Item = ExprId> + use<> {
        let operands = match self.pool.node(e) {
            Node::Literal(_) | Node::Var(_) => [None; 3],
            Node::Unary(_, a) => [Some(a), None, None],
            Node::Binary(_, a, b) => [Some(a), Some(b), None],
            Node::Ite(c, a, b) => [Some(c), Some(a), Some(b)],
        };
        operands.into_iter().flatten()
    }

    /// Returns the bit patterns that are values of the variables of an expression.
    pub(in crate::symbolic) fn within(&self, e: ExprId) -> Result<Bdd> {
        Ok(self.translate(e)?.within)
    }

    /// Returns the bit patterns that are values of the variables of a node, from those of its
    /// operands.
    fn patterns(&self, e: ExprId) -> Result<Bdd> {
        if let Node::Var(v) = self.pool.node(e) {
            return self.encoding.values_of(self.store, v);
        }
        let mut operands = self.operands(e).map(|o| self.get(o).within);
        operands.try_fold(self.store.one(), |all, one| self.store.and(&all, &one))
    }

    /// Creates a symbolic value before its bit patterns (`within`) are known.
    fn symbolic(&self, meaning: Meaning, fails: Bdd) -> Symbolic {
        Symbolic { meaning, fails, within: self.store.one() }
    }

    fn get(&self, e: ExprId) -> Symbolic {
        self.known.borrow()[&e].clone()
    }

    fn node(&self, e: ExprId) -> Result<Symbolic> {
        let sure = |meaning| Ok(self.symbolic(meaning, self.store.zero()));
        match self.pool.node(e) {
            Node::Literal(_) => sure(self.literal(e)),
            Node::Var(v) => {
                let bits = self.encoding.positions(v).iter().map(|&p| self.store.literal(2 * p, true));
                let bits = bits.collect::<Result<Vec<_>>>()?;
                let variable = &self.program.variables[v.index()];
                match (variable.ty, bits.first()) {
                    (Type::Bool, Some(bit)) => sure(Meaning::Bool(bit.clone())),
                    _ => sure(Meaning::Int(SymbolicInteger::offset(
                        self.store,
                        bits,
                        variable.low,
                        variable.high,
                    )?)),
                }
            }
            Node::Unary(op, a) => self.unary(op, &self.get(a)),
            Node::Binary(op, a, b) => self.binary(op, &self.get(a), &self.get(b)),
            Node::Ite(c, a, b) => self.ite(&self.get(c), &self.get(a), &self.get(b)),
        }
    }

    fn literal(&self, e: ExprId) -> Meaning {
        match self.pool.exact_literal(e) {
            Some(Exact::Bool(true)) => Meaning::Bool(self.store.one()),
            Some(Exact::Bool(false)) | None => Meaning::Bool(self.store.zero()),
            Some(Exact::Int(i)) => Meaning::Int(SymbolicInteger::constant(self.store, i)),
            Some(real) => Meaning::Real(Partition::constant(self.store, real)),
        }
    }

    fn unary(&self, op: Unary, a: &Symbolic) -> Result<Symbolic> {
        let same = |meaning| self.symbolic(meaning, a.fails.clone());
        match (op, &a.meaning) {
            (Unary::Not, m) => Ok(same(Meaning::Bool(self.store.not(&self.truth(m)?)?))),
            (Unary::Neg, Meaning::Int(bits)) => match bits.neg(self.store)? {
                Some(bits) => Ok(same(Meaning::Int(bits))),
                None => self.mapped(op, a),
            },
            (Unary::Floor | Unary::Ceil | Unary::Round, Meaning::Int(_)) => Ok(a.clone()),
            _ => self.mapped(op, a),
        }
    }

    /// Applies a unary operator value by value.
    fn mapped(&self, op: Unary, a: &Symbolic) -> Result<Symbolic> {
        let (result, failed) = self.partition(a)?.map(self.store, |v| exact::unary(op, v.clone()))?;
        let meaning = match op {
            Unary::Floor | Unary::Ceil | Unary::Round => Meaning::Int(result.to_bits(self.store)?),
            Unary::Neg if matches!(a.meaning, Meaning::Int(_)) => Meaning::Int(result.to_bits(self.store)?),
            _ => Meaning::Real(result),
        };
        Ok(self.symbolic(meaning, self.store.or(&a.fails, &failed)?))
    }

    fn binary(&self, op: Binary, a: &Symbolic, b: &Symbolic) -> Result<Symbolic> {
        if let (Meaning::Bool(f), Meaning::Bool(g)) = (&a.meaning, &b.meaning) {
            return self.logical(op, (f, &a.fails), (g, &b.fails));
        }
        let fails = self.store.or(&a.fails, &b.fails)?;
        if let (Meaning::Int(x), Meaning::Int(y)) = (&a.meaning, &b.meaning)
            && let Some(meaning) = self.arithmetic(op, x, y)?
        {
            return Ok(self.symbolic(meaning, fails));
        }
        let (x, y) = (self.partition(a)?, self.partition(b)?);
        let (result, failed) = x.combine(self.store, &y, |v, w| exact::binary(op, v, w))?;
        let ints = matches!((&a.meaning, &b.meaning), (Meaning::Int(_), Meaning::Int(_)));
        let ty = value::binary_type(op, if ints { Type::Int } else { Type::Real });
        let meaning = match ty {
            Type::Bool => Meaning::Bool(result.states_where(self.store, |v| *v == Exact::Bool(true))?),
            Type::Int => Meaning::Int(result.to_bits(self.store)?),
            Type::Real => Meaning::Real(result),
        };
        Ok(self.symbolic(meaning, self.store.or(&fails, &failed)?))
    }

    /// Applies an operator to Booleans; `&` and `|` evaluate the right side only if they need it.
    fn logical(
        &self,
        op: Binary,
        (f, f_fails): (&Bdd, &Bdd),
        (g, g_fails): (&Bdd, &Bdd),
    ) -> Result<Symbolic> {
        let store = self.store;
        let (value, right_fails) = match op {
            Binary::And => (store.and(f, g)?, store.and(f, g_fails)?),
            Binary::Or => (store.or(f, g)?, store.minus(g_fails, f)?),
            Binary::Lt => (store.minus(g, f)?, g_fails.clone()),
            Binary::Le => (store.or(&store.not(f)?, g)?, g_fails.clone()),
            _ => (store.iff(f, g)?, g_fails.clone()),
        };
        Ok(self.symbolic(Meaning::Bool(value), store.or(f_fails, &right_fails)?))
    }

    /// Applies an operator to integers; `None` if symbolic integers do not support it.
    fn arithmetic(&self, op: Binary, x: &SymbolicInteger, y: &SymbolicInteger) -> Result<Option<Meaning>> {
        let store = self.store;
        let int = |bits: Option<SymbolicInteger>| Ok(bits.map(Meaning::Int));
        match op {
            Binary::Eq => Ok(Some(Meaning::Bool(x.eq(store, y)?))),
            Binary::Lt => Ok(Some(Meaning::Bool(x.lt(store, y)?))),
            Binary::Le => Ok(Some(Meaning::Bool(x.le(store, y)?))),
            Binary::Add => int(x.add(store, y)?),
            Binary::Sub => match y.neg(store)? {
                Some(minus) => int(x.add(store, &minus)?),
                None => Ok(None),
            },
            Binary::Mul => int(x.mul(store, y)?),
            Binary::Min => {
                int(Some(x.select(store, &x.le(store, y)?, y)?.bounded(i64::MIN, x.high.min(y.high))))
            }
            Binary::Max => {
                int(Some(y.select(store, &x.le(store, y)?, x)?.bounded(x.low.max(y.low), i64::MAX)))
            }
            Binary::Mod if y.low == y.high && y.low > 0 => int(x.modulo(store, y.low)?),
            _ => Ok(None),
        }
    }

    fn ite(&self, c: &Symbolic, a: &Symbolic, b: &Symbolic) -> Result<Symbolic> {
        let store = self.store;
        let condition = self.truth(&c.meaning)?;
        let meaning = match (&a.meaning, &b.meaning) {
            (Meaning::Bool(f), Meaning::Bool(g)) => Meaning::Bool(store.ite(&condition, f, g)?),
            (Meaning::Int(x), Meaning::Int(y)) => Meaning::Int(x.select(store, &condition, y)?),
            _ => Meaning::Real(self.partition(a)?.select(store, &condition, &self.partition(b)?)?),
        };
        let branch_fails = store.ite(&condition, &a.fails, &b.fails)?;
        Ok(self.symbolic(meaning, store.or(&c.fails, &branch_fails)?))
    }

    fn truth(&self, meaning: &Meaning) -> Result<Bdd> {
        match meaning {
            Meaning::Bool(f) => Ok(f.clone()),
            Meaning::Int(bits) => {
                self.store.not(&bits.eq(self.store, &SymbolicInteger::constant(self.store, 0))?)
            }
            Meaning::Real(p) => p.states_where(self.store, |v| !v.clone().into_real().is_zero()),
        }
    }

    fn partition(&self, symbolic: &Symbolic) -> Result<Partition> {
        match &symbolic.meaning {
            Meaning::Bool(f) => Partition::of_bool(self.store, f),
            Meaning::Int(bits) if bits.low == bits.high => {
                Ok(Partition::constant(self.store, Exact::Int(bits.low)))
            }
            Meaning::Int(bits) => Partition::of_bits(self.store, bits, &symbolic.within),
            Meaning::Real(p) => Ok(p.clone()),
        }
    }
}
