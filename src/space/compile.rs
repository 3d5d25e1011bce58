//! The compiler from expressions to code for the [`super::machine`].
//!
//! Conditions become jumps, so that `&`, `|` and `?:` evaluate only the operands they need, in the
//! order of [`ExprPool::eval`]. Some nodes become routines whose results are kept (`share`), so
//! that nested formulas are neither copied nor computed again.

use ahash::AHashMap;

use super::bounds::Bounds;
use super::machine::{Code, Entry, Memo, Op, Reg, Routine, Table, Valuations};
use super::needs::{Ways, operands};
use super::share::{self, Kept, WORTH_SHARING};
use meliora_base::error::Result;
use meliora_base::exact::Exact;
use meliora_base::progress::Poll;
use meliora_base::stack;
use meliora_base::value::Type;
use meliora_model::Program;
use meliora_model::expr::{Binary, ExprId, ExprPool, Node, Unary};

/// The compiler for the expressions of a program.
pub struct Compiler<'a> {
    pool: &'a ExprPool,
    bounds: Bounds<'a>,
    ways: Ways<'a>,
    code: Code,
    constants: AHashMap<i64, Reg>,
    /// For each node with a routine, the instruction that provides its value and the register that
    /// receives it.
    kept: AHashMap<ExprId, (Op, Reg)>,
}

/// The position of a jump whose target is not known yet.
type Hole = usize;

impl<'a> Compiler<'a> {
    /// Creates a compiler for a pool over the variables of a program; `roots` are all expressions that
    /// will be compiled.
    ///
    /// # Errors
    /// The work is cancelled.
    pub fn new(
        program: &'a Program,
        pool: &'a ExprPool,
        roots: &[ExprId],
        poll: &mut Poll<'_>,
    ) -> Result<Self> {
        let code = Code { initial: vec![0; program.variables.len()], ..Code::default() };
        let (constants, kept) = (AHashMap::new(), AHashMap::new());
        let (bounds, ways) = (Bounds::new(program, pool), Ways::new(program, pool));
        let mut compiler = Compiler { pool, bounds, ways, code, constants, kept };
        compiler.compile_kept(program, share::plan(program, pool, roots, poll)?);
        Ok(compiler)
    }

    /// Returns the code of all compiled expressions.
    pub fn finish(self) -> Code {
        self.code
    }

    /// Emits code that returns the value of a Boolean expression.
    pub fn condition(&mut self, e: ExprId) -> Entry {
        self.conjunction(&[e])
    }

    /// Emits code that returns whether all given conditions are true. Evaluation stops at the first
    /// one that is false.
    pub fn conjunction(&mut self, of: &[ExprId]) -> Entry {
        let start = self.here();
        let mut fails = Vec::new();
        for &e in of {
            self.jump_if(e, false, &mut fails);
        }
        self.emit(Op::Return(true));
        self.land(fails);
        self.emit(Op::Return(false));
        Entry { start, result: 0 }
    }

    /// Emits code that leaves the value of an expression in a register.
    pub fn value(&mut self, e: ExprId) -> Entry {
        let start = self.here();
        let result = self.reg(e);
        self.emit(Op::Return(true));
        Entry { start, result }
    }

    /// Emits code that leaves the value of an expression in a register as a real; integers are
    /// converted.
    pub fn real(&mut self, e: ExprId) -> Entry {
        let start = self.here();
        let result = self.real_reg(e);
        self.emit(Op::Return(true));
        Entry { start, result }
    }

    /// Compiles the routines; operands come before the nodes that use them.
    fn compile_kept(&mut self, program: &Program, kept: Vec<Kept>) {
        for Kept { node, memo } in kept {
            let start = self.here();
            let result = self.compute(node);
            let (dst, op) = match memo {
                None => {
                    self.code.routines.push(Routine { start });
                    (result, Op::Share { routine: self.code.routines.len() as u32 - 1 })
                }
                Some(support) => {
                    // The result may be that of another node, or a constant.
                    let dst = self.fresh();
                    self.emit(Op::Copy { dst, a: result });
                    let valuations = Valuations::new(program, &support.variables);
                    self.code.memos.push(Memo { start, valuations });
                    (dst, Op::Recall { dst, memo: self.code.memos.len() as u32 - 1 })
                }
            };
            self.emit(Op::Return(true));
            self.kept.insert(node, (op, dst));
        }
    }

    /// Emits code that leaves the value of `e` in the returned register.
    fn reg(&mut self, e: ExprId) -> Reg {
        match self.kept.get(&e) {
            Some(&(op, result)) => {
                self.emit(op);
                result
            }
            None => stack::level(|| self.compute(e)),
        }
    }

    fn compute(&mut self, e: ExprId) -> Reg {
        match self.pool.node(e) {
            Node::Literal(_) => self.literal(e),
            Node::Var(v) => v.0,
            Node::Unary(Unary::Not, _) => self.truth(e),
            Node::Unary(op, a) => {
                let (ty, a) = (self.pool.ty(a), self.reg(a));
                let dst = self.fresh();
                self.emit(Op::Unary { op, ty, dst, a });
                dst
            }
            Node::Binary(op, a, b) => self.binary(e, op, a, b),
            Node::Ite(condition, then, otherwise) => {
                let mut fails = Vec::new();
                self.jump_if(condition, false, &mut fails);
                let dst = self.fresh();
                let a = self.reg(then);
                self.emit(Op::Copy { dst, a });
                let end = self.emit(Op::Jump { to: 0 });
                self.land(fails);
                let a = self.reg(otherwise);
                self.emit(Op::Copy { dst, a });
                self.land(vec![end]);
                dst
            }
        }
    }

    fn binary(&mut self, e: ExprId, op: Binary, a: ExprId, b: ExprId) -> Reg {
        let (left, right) = (self.pool.ty(a), self.pool.ty(b));
        let whole = left == right && left != Type::Real;
        let compares = match op {
            Binary::Eq | Binary::Lt | Binary::Le => true,
            Binary::And | Binary::Or => left == Type::Bool,
            _ => false,
        };
        if whole && compares {
            return self.truth(e);
        }
        if !whole {
            let (a, b) = (self.real_reg(a), self.real_reg(b));
            let dst = self.fresh();
            self.emit(Op::Real { op, dst, a, b });
            return dst;
        }
        let (a, b) = (self.reg(a), self.reg(b));
        let dst = self.fresh();
        self.emit(match (op, left) {
            (Binary::Add, Type::Int) => Op::Add { dst, a, b },
            (Binary::Sub, Type::Int) => Op::Sub { dst, a, b },
            (Binary::Mul, Type::Int) => Op::Mul { dst, a, b },
            (Binary::Min, Type::Int) => Op::Min { dst, a, b },
            (Binary::Max, Type::Int) => Op::Max { dst, a, b },
            _ => Op::Whole { op, ty: left, dst, a, b },
        });
        dst
    }

    /// Emits code that leaves the value of `e` as a real in the returned register; integers are
    /// converted.
    fn real_reg(&mut self, e: ExprId) -> Reg {
        let (ty, a) = (self.pool.ty(e), self.reg(e));
        if ty == Type::Real {
            return a;
        }
        let dst = self.fresh();
        self.emit(Op::Unary { op: Unary::ToReal, ty, dst, a });
        dst
    }

    /// Emits code that leaves 1 in the returned register if a condition is true, else 0.
    fn truth(&mut self, e: ExprId) -> Reg {
        let (one, zero) = (self.constant(1), self.constant(0));
        let mut fails = Vec::new();
        self.branch(e, false, &mut fails);
        let dst = self.fresh();
        self.emit(Op::Copy { dst, a: one });
        let end = self.emit(Op::Jump { to: 0 });
        self.land(fails);
        self.emit(Op::Copy { dst, a: zero });
        self.land(vec![end]);
        dst
    }

    /// Emits jumps that are taken if `e` equals `value`; otherwise execution continues after them.
    fn jump_if(&mut self, e: ExprId, value: bool, holes: &mut Vec<Hole>) {
        if self.kept.contains_key(&e) {
            self.test(e, value, holes);
        } else {
            stack::level(|| self.branch(e, value, holes));
        }
    }

    fn branch(&mut self, e: ExprId, value: bool, holes: &mut Vec<Hole>) {
        match self.pool.node(e) {
            Node::Unary(Unary::Not, a) if self.pool.ty(a) == Type::Bool => self.jump_if(a, !value, holes),
            Node::Binary(op @ (Binary::And | Binary::Or), a, b) if self.pool.ty(a) == Type::Bool => {
                let operands = self.operands(op, [a, b]);
                if op == Binary::Or
                    && let Some(any) = self.table(e, &operands)
                {
                    return self.test_reg(any, value, holes);
                }
                // The value of an operand that decides.
                let decides = op == Binary::Or;
                if value == decides {
                    return operands.iter().for_each(|&e| self.jump_if(e, value, holes));
                }
                let (others, last) = operands.split_at(operands.len() - 1);
                let mut past = Vec::new();
                others.iter().for_each(|&e| self.jump_if(e, decides, &mut past));
                last.iter().for_each(|&e| self.jump_if(e, value, holes));
                self.land(past);
            }
            Node::Binary(op @ (Binary::Eq | Binary::Lt | Binary::Le), a, b)
                if self.pool.ty(a) == self.pool.ty(b) && self.pool.ty(a) != Type::Real =>
            {
                let (a, b) = (self.reg(a), self.reg(b));
                let jump = compare(op, value, a, b);
                holes.push(self.emit(jump));
            }
            Node::Unary(Unary::Not, a) => {
                let (ty, a) = (self.pool.ty(a), self.reg(a));
                let dst = self.fresh();
                self.emit(Op::Unary { op: Unary::Not, ty, dst, a });
                self.test_reg(dst, value, holes);
            }
            _ => self.test(e, value, holes),
        }
    }

    /// Returns the operands of a conjunction or disjunction, also of nested ones that are not kept, in their order.
    fn operands(&self, op: Binary, [a, b]: [ExprId; 2]) -> Vec<ExprId> {
        let (mut found, mut stack) = (Vec::new(), vec![b, a]);
        while let Some(e) = stack.pop() {
            match self.pool.node(e) {
                Node::Binary(own, a, b) if own == op && !self.kept.contains_key(&e) => stack.extend([b, a]),
                _ => found.push(e),
            }
        }
        found
    }

    /// Emits code that leaves the value of a disjunction in the returned register, if a look-up of the disjuncts that
    /// the values of some variables can make true is shorter than their tests one by one.
    fn table(&mut self, e: ExprId, disjuncts: &[ExprId]) -> Option<Reg> {
        if disjuncts.len() <= WORTH_SHARING as usize || !self.bounds.is_total(e) {
            return None;
        }
        let of = |&e: &ExprId| self.ways.of(&operands(self.pool, Binary::And, e));
        let ways: Vec<_> = disjuncts.iter().map(of).collect();
        let lists = self.ways.list(&ways);
        if disjuncts.len() - lists.others.len() <= lists.splits.len() * WORTH_SHARING as usize {
            return None;
        }
        let past = self.emit(Op::Jump { to: 0 });
        let starts = disjuncts.iter().map(|&e| self.condition(e).start).collect();
        self.land(vec![past]);
        let (dst, table) = (self.fresh(), self.code.tables.len() as u32);
        self.code.tables.push(Table { lists, starts });
        self.emit(Op::Any { dst, table });
        Some(dst)
    }

    /// Emits code that computes a truth value and jumps if it equals `value`.
    fn test(&mut self, e: ExprId, value: bool, holes: &mut Vec<Hole>) {
        let a = self.reg(e);
        self.test_reg(a, value, holes);
    }

    fn test_reg(&mut self, a: Reg, value: bool, holes: &mut Vec<Hole>) {
        let b = self.constant(0);
        let jump = if value { Op::JumpNe { a, b, to: 0 } } else { Op::JumpEq { a, b, to: 0 } };
        holes.push(self.emit(jump));
    }

    fn literal(&mut self, e: ExprId) -> Reg {
        let word = match self.pool.exact_literal(e) {
            Some(Exact::Bool(b)) => i64::from(b),
            Some(Exact::Int(i)) => i,
            Some(Exact::Real(number)) => self.code.numbers.constant(number),
            None => 0,
        };
        self.constant(word)
    }

    fn constant(&mut self, word: i64) -> Reg {
        let registers = &mut self.code.initial;
        *self.constants.entry(word).or_insert_with(|| {
            registers.push(word);
            registers.len() as Reg - 1
        })
    }

    fn fresh(&mut self) -> Reg {
        self.code.initial.push(0);
        self.code.initial.len() as Reg - 1
    }

    fn here(&self) -> u32 {
        self.code.ops.len() as u32
    }

    fn emit(&mut self, op: Op) -> Hole {
        self.code.ops.push(op);
        self.code.ops.len() - 1
    }

    /// Sets the target of jumps to the next instruction.
    fn land(&mut self, holes: Vec<Hole>) {
        let here = self.here();
        for hole in holes {
            match &mut self.code.ops[hole] {
                Op::Jump { to }
                | Op::JumpEq { to, .. }
                | Op::JumpNe { to, .. }
                | Op::JumpLt { to, .. }
                | Op::JumpLe { to, .. } => *to = here,
                _ => {}
            }
        }
    }
}

/// Returns the jump that is taken if `a op b` equals `value`.
fn compare(op: Binary, value: bool, a: Reg, b: Reg) -> Op {
    match (op, value) {
        (Binary::Lt, true) => Op::JumpLt { a, b, to: 0 },
        (Binary::Lt, false) => Op::JumpLe { a: b, b: a, to: 0 },
        (Binary::Le, true) => Op::JumpLe { a, b, to: 0 },
        (Binary::Le, false) => Op::JumpLt { a: b, b: a, to: 0 },
        (_, true) => Op::JumpEq { a, b, to: 0 },
        (_, false) => Op::JumpNe { a, b, to: 0 },
    }
}
