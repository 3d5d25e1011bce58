//! A condition as a net of operations over variables, which can be reduced to what a box leaves open.
//!
//! Chains of `&`, `|` and `+` are single operations with many operands, so that those that are decided
//! can be left out.

use std::collections::hash_map::Entry;

use ahash::{AHashMap, AHashSet};

use crate::values::{self, Values};
use meliora_base::error::Result;
use meliora_base::exact::Exact;
use meliora_base::progress::{Poll, ProgressSink};
use meliora_base::value::{EvalError, Type};
use meliora_model::Program;
use meliora_model::expr::{Binary, ExprId, ExprPool, Node, Unary};

/// The first and the last value of each variable.
pub(super) type Ranges = [(i64, i64)];

/// The position of an item in its net.
pub(super) type Place = u32;

/// An operation.
#[derive(Debug, Clone)]
pub(super) enum Op {
    /// An expression whose values are known.
    Known(Values),
    Var(usize),
    /// A conjunction (false) or a disjunction (true), with the operands in the order of evaluation.
    List(bool, Vec<Place>),
    /// Σ factor · operand + constant. No part of it leaves 64 bits, whatever the operands are.
    Sum(Vec<(i64, Place)>, i64),
    Unary(Unary, Place),
    Binary(Binary, Place, Place),
    Ite(Place, Place, Place),
}

/// An operation with the type of its result.
#[derive(Debug, Clone)]
pub(super) struct Item {
    pub(super) op: Op,
    pub(super) ty: Type,
}

/// A condition: operands come before the items that use them, and the condition is the last item.
#[derive(Debug, Clone)]
pub(super) struct Net {
    pub(super) items: Vec<Item>,
}

/// The kinds of operations that take in operands of the same kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Chain {
    And,
    Or,
    Sum,
}

impl Chain {
    fn of(pool: &ExprPool, e: ExprId) -> Option<Chain> {
        match pool.node(e) {
            Node::Binary(Binary::And, a, _) if pool.ty(a) == Type::Bool => Some(Chain::And),
            Node::Binary(Binary::Or, a, _) if pool.ty(a) == Type::Bool => Some(Chain::Or),
            _ if pool.ty(e) != Type::Int => None,
            Node::Binary(Binary::Add | Binary::Sub, ..) | Node::Unary(Unary::Neg, _) => Some(Chain::Sum),
            Node::Binary(Binary::Mul, a, b) if factor_of(pool, a, b).is_some() => Some(Chain::Sum),
            _ => None,
        }
    }
}

/// Returns the factor and the operand of a product with a literal.
fn factor_of(pool: &ExprPool, a: ExprId, b: ExprId) -> Option<(i64, ExprId)> {
    match (pool.exact_literal(a), pool.exact_literal(b)) {
        (Some(Exact::Int(factor)), _) => Some((factor, b)),
        (_, Some(Exact::Int(factor))) => Some((factor, a)),
        _ => None,
    }
}

impl Net {
    /// Translates a condition over the variables of a program.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(super) fn new(program: &Program, condition: ExprId, sink: &dyn ProgressSink) -> Result<Self> {
        let ranges: Vec<_> = program.variables.iter().map(|v| (v.low, v.high)).collect();
        let (pool, poll, net) = (&*program.pool, Poll::new(sink), Net { items: Vec::new() });
        let mut build =
            Build { pool, poll, ranges: &ranges, net, places: AHashMap::new(), values: Vec::new() };
        let (parts, inner) = build.parts(condition)?;
        for &e in parts.iter().filter(|e| !inner.contains(e)) {
            build.add(e, &inner)?;
        }
        Ok(build.net)
    }

    /// Computes the values of each item in a box.
    pub(super) fn evaluate(&self, ranges: &Ranges, into: &mut Vec<Values>) {
        into.clear();
        for item in &self.items {
            let values = self.values_of(item, ranges, into);
            into.push(values);
        }
    }

    /// Returns the values of an item, given those of its operands.
    fn values_of(&self, item: &Item, ranges: &Ranges, of: &[Values]) -> Values {
        let at = |operand: Place| &of[operand as usize];
        let ty = |operand: Place| self.items[operand as usize].ty;
        match &item.op {
            Op::Known(values) => values.clone(),
            &Op::Var(v) => Values::whole(ranges[v].0, ranges[v].1),
            Op::List(decisive, operands) => values::list(*decisive, operands.iter().map(|&a| at(a))),
            Op::Sum(terms, constant) => {
                values::sum(terms.iter().map(|&(factor, a)| (factor, at(a))), *constant)
            }
            &Op::Unary(op, a) => values::unary(op, ty(a), at(a)),
            &Op::Binary(op, a, b) => values::binary(op, ty(a), at(a), at(b)),
            &Op::Ite(c, a, b) => values::choice(at(c), at(a), at(b)),
        }
    }

    /// Returns for each item whether the condition still depends on it, given the values of all.
    pub(super) fn open(&self, values: &[Values]) -> Vec<bool> {
        let mut open = vec![false; self.items.len()];
        if let (Some(last), Some(known)) = (open.last_mut(), values.last()) {
            *last = !known.is_known();
        }
        for (place, item) in self.items.iter().enumerate().rev() {
            if open[place] {
                item.each_open(values, |operand| open[operand as usize] = true);
            }
        }
        open
    }

    /// Returns the condition without its decided parts, given the values of all items and which are open.
    pub(super) fn reduced(&self, values: &[Values], open: &[bool]) -> Net {
        let places = vec![Place::MAX; self.items.len()];
        let mut reduction = Reduction { old: self, values, places, net: Net { items: Vec::new() } };
        for (place, item) in self.items.iter().enumerate().filter(|(place, _)| open[*place]) {
            let op = reduction.reduced(&item.op);
            reduction.places[place] = reduction.net.push(op, item.ty);
        }
        reduction.net
    }

    fn push(&mut self, op: Op, ty: Type) -> Place {
        self.items.push(Item { op, ty });
        self.items.len() as Place - 1
    }
}

impl Item {
    /// Calls `f` with the operands that decide the value of this item and are not known.
    fn each_open(&self, values: &[Values], mut f: impl FnMut(Place)) {
        let known = |a: Place| values[a as usize].is_known();
        let mut open = |a: Place| {
            if !known(a) {
                f(a)
            }
        };
        match &self.op {
            Op::Known(_) | Op::Var(_) => {}
            Op::List(decisive, operands) => {
                let ends = |a: Place| known(a) && values[a as usize].may_hold() == *decisive;
                operands.iter().take_while(|&&a| !ends(a)).for_each(|&a| open(a));
            }
            Op::Sum(terms, _) => terms.iter().for_each(|&(_, a)| open(a)),
            &Op::Unary(_, a) => open(a),
            &Op::Binary(_, a, b) => [a, b].into_iter().for_each(open),
            &Op::Ite(c, a, b) if !known(c) => [c, a, b].into_iter().for_each(open),
            &Op::Ite(c, a, b) => open(if values[c as usize].may_hold() { a } else { b }),
        }
    }
}

/// A reduction in progress.
struct Reduction<'a> {
    old: &'a Net,
    values: &'a [Values],
    /// For each old item its new place, if it has one.
    places: Vec<Place>,
    net: Net,
}

impl Reduction<'_> {
    fn reduced(&mut self, op: &Op) -> Op {
        match op {
            Op::Known(_) | Op::Var(_) => op.clone(),
            Op::List(decisive, operands) => Op::List(*decisive, self.list(*decisive, operands)),
            Op::Sum(terms, constant) => self.sum(terms, *constant),
            &Op::Unary(op, a) => Op::Unary(op, self.at(a)),
            &Op::Binary(op, a, b) => Op::Binary(op, self.at(a), self.at(b)),
            &Op::Ite(c, a, b) => Op::Ite(self.at(c), self.at(a), self.at(b)),
        }
    }

    /// Returns the new place of an operand. One that is not open becomes its values.
    fn at(&mut self, operand: Place) -> Place {
        let place = operand as usize;
        if self.places[place] == Place::MAX {
            let known = Op::Known(self.values[place].clone());
            self.places[place] = self.net.push(known, self.old.items[place].ty);
        }
        self.places[place]
    }

    /// Returns the operands of a list up to the first that ends the evaluation for sure.
    fn list(&mut self, decisive: bool, operands: &[Place]) -> Vec<Place> {
        let mut kept = Vec::new();
        for &a in operands {
            let values = &self.values[a as usize];
            let is_known = values.is_known();
            if is_known && values.may_hold() != decisive {
                continue;
            }
            kept.push(self.at(a));
            if is_known {
                break;
            }
        }
        kept
    }

    fn sum(&mut self, terms: &[(i64, Place)], mut constant: i64) -> Op {
        let mut kept = Vec::new();
        for &(factor, a) in terms {
            match self.values[a as usize].known(Type::Int) {
                Some(Exact::Int(value)) => constant += factor * value,
                _ => kept.push((factor, self.at(a))),
            }
        }
        Op::Sum(kept, constant)
    }
}

/// A translation in progress.
struct Build<'a> {
    pool: &'a ExprPool,
    poll: Poll<'a>,
    /// The ranges of the variables.
    ranges: &'a Ranges,
    net: Net,
    places: AHashMap<ExprId, Place>,
    /// The values of the items in the box of all states.
    values: Vec<Values>,
}

impl Build<'_> {
    /// Returns the parts of a condition, operands first, and those that belong to a chain: their only use
    /// is an operation of the same kind.
    fn parts(&mut self, condition: ExprId) -> Result<(Vec<ExprId>, AHashSet<ExprId>)> {
        let (mut uses, mut stack) = (AHashMap::from_iter([(condition, None)]), vec![condition]);
        while let Some(e) = stack.pop() {
            self.poll.step()?;
            let kind = Chain::of(self.pool, e);
            for operand in self.pool.operands(e) {
                // Several uses are as one of another kind.
                match uses.entry(operand) {
                    Entry::Occupied(mut known) => drop(known.insert(None)),
                    Entry::Vacant(new) => {
                        new.insert(kind);
                        stack.push(operand);
                    }
                }
            }
        }
        let is_inner = |(&e, &user): (&ExprId, &Option<Chain>)| {
            (user.is_some() && user == Chain::of(self.pool, e)).then_some(e)
        };
        let inner = uses.iter().filter_map(is_inner).collect();
        let mut parts: Vec<ExprId> = uses.into_keys().collect();
        parts.sort_unstable();
        Ok((parts, inner))
    }

    /// Adds an expression whose operands are in the net, or belong to its chain.
    fn add(&mut self, e: ExprId, inner: &AHashSet<ExprId>) -> Result<()> {
        let op = match Chain::of(self.pool, e) {
            Some(Chain::Sum) => match self.sum(e, inner)? {
                Some(sum) => sum,
                None => return self.add_alone(e, inner),
            },
            Some(chain) => Op::List(chain == Chain::Or, self.list(e, inner)?),
            None => self.alone(e),
        };
        self.place(e, op);
        Ok(())
    }

    /// Adds the parts of a chain one by one.
    fn add_alone(&mut self, e: ExprId, inner: &AHashSet<ExprId>) -> Result<()> {
        let (mut chain, mut stack) = (Vec::new(), vec![e]);
        while let Some(e) = stack.pop() {
            self.poll.step()?;
            chain.push(e);
            stack.extend(self.pool.operands(e).filter(|a| inner.contains(a)));
        }
        chain.sort_unstable();
        for e in chain {
            let op = self.alone(e);
            self.place(e, op);
        }
        Ok(())
    }

    fn place(&mut self, e: ExprId, op: Op) {
        let place = self.net.push(op, self.pool.ty(e));
        let values = self.net.values_of(&self.net.items[place as usize], self.ranges, &self.values);
        self.values.push(values);
        self.places.insert(e, place);
    }

    fn at(&self, e: ExprId) -> Place {
        self.places.get(&e).copied().unwrap_or(Place::MAX)
    }

    /// Returns an operation without a chain.
    fn alone(&self, e: ExprId) -> Op {
        match self.pool.node(e) {
            Node::Literal(_) => Op::Known(Values::of(self.pool.exact_literal(e).ok_or(EvalError::NotFinite))),
            Node::Var(v) => Op::Var(v.index()),
            Node::Unary(op, a) => Op::Unary(op, self.at(a)),
            Node::Binary(op, a, b) => Op::Binary(op, self.at(a), self.at(b)),
            Node::Ite(c, a, b) => Op::Ite(self.at(c), self.at(a), self.at(b)),
        }
    }

    /// Returns the operands of a chain of `&` or `|`, in the order of evaluation.
    fn list(&mut self, e: ExprId, inner: &AHashSet<ExprId>) -> Result<Vec<Place>> {
        let (mut operands, mut stack) = (Vec::new(), vec![e]);
        while let Some(part) = stack.pop() {
            self.poll.step()?;
            if part == e || inner.contains(&part) {
                let from = stack.len();
                stack.extend(self.pool.operands(part));
                stack[from..].reverse();
            } else {
                operands.push(self.at(part));
            }
        }
        Ok(operands)
    }

    /// Returns a chain of sums and products with literals; `None` if a part of it may leave 64 bits, or is
    /// multiplied by 0.
    fn sum(&mut self, e: ExprId, inner: &AHashSet<ExprId>) -> Result<Option<Op>> {
        let (mut terms, mut constant, mut stack) = (Vec::new(), 0i64, vec![(1i64, e)]);
        // The largest absolute value of a part.
        let mut most = 0i64;
        while let Some((factor, part)) = stack.pop() {
            self.poll.step()?;
            let operands = match self.pool.node(part) {
                _ if part != e && !inner.contains(&part) => {
                    let (low, high) = self.values[self.at(part) as usize].range();
                    let size = low.checked_abs().zip(high.checked_abs()).map(|(a, b)| a.max(b));
                    let sum = size.and_then(|n| n.checked_mul(factor.checked_abs()?)?.checked_add(most));
                    let Some(sum) = sum else { return Ok(None) };
                    most = sum;
                    match self.pool.exact_literal(part) {
                        Some(Exact::Int(value)) => constant += factor * value,
                        _ => terms.push((factor, self.at(part))),
                    }
                    continue;
                }
                Node::Binary(Binary::Mul, a, b) => {
                    factor_of(self.pool, a, b).map(|(by, a)| [Some((by, a)), None])
                }
                Node::Binary(Binary::Sub, a, b) => Some([Some((1, a)), Some((-1, b))]),
                Node::Binary(_, a, b) => Some([Some((1, a)), Some((1, b))]),
                Node::Unary(_, a) => Some([Some((-1, a)), None]),
                _ => None,
            };
            for (by, operand) in operands.into_iter().flatten().flatten() {
                let product = factor.checked_mul(by).filter(|&product| product != 0);
                let Some(factor) = product else { return Ok(None) };
                stack.push((factor, operand));
            }
        }
        Ok(Some(Op::Sum(terms, constant)))
    }
}
