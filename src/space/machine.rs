//! A register machine for compiled expressions.
//!
//! The first registers contain the values of the variables; constants and results follow. Thus `x <
//! 5` is one instruction. Integers are stored as they are, Booleans as 0 and 1, reals as the
//! words of exact numbers.

use smallvec::SmallVec;

use super::by_value::ByValue;
use super::numbers::Numbers;
use meliora_base::exact::{self, Exact};
use meliora_base::value::{EvalError, Type};
use meliora_model::expr::{Binary, Unary};
use meliora_model::{Program, VarId};

/// A register.
pub(crate) type Reg = u32;

/// One instruction; `to` is the position where execution continues if the condition is true.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Op {
    Add {
        dst: Reg,
        a: Reg,
        b: Reg,
    },
    Sub {
        dst: Reg,
        a: Reg,
        b: Reg,
    },
    Mul {
        dst: Reg,
        a: Reg,
        b: Reg,
    },
    Min {
        dst: Reg,
        a: Reg,
        b: Reg,
    },
    Max {
        dst: Reg,
        a: Reg,
        b: Reg,
    },
    Copy {
        dst: Reg,
        a: Reg,
    },
    /// Any operator on integers or Booleans.
    Whole {
        op: Binary,
        ty: Type,
        dst: Reg,
        a: Reg,
        b: Reg,
    },
    /// Any operator on reals.
    Real {
        op: Binary,
        dst: Reg,
        a: Reg,
        b: Reg,
    },
    Unary {
        op: Unary,
        ty: Type,
        dst: Reg,
        a: Reg,
    },
    Jump {
        to: u32,
    },
    JumpEq {
        a: Reg,
        b: Reg,
        to: u32,
    },
    JumpNe {
        a: Reg,
        b: Reg,
        to: u32,
    },
    JumpLt {
        a: Reg,
        b: Reg,
        to: u32,
    },
    JumpLe {
        a: Reg,
        b: Reg,
        to: u32,
    },
    /// Computes whether one of the conditions of a table is true.
    Any {
        dst: Reg,
        table: u32,
    },
    /// Provides a node that is kept in a register; computes it only once per state.
    Share {
        routine: u32,
    },
    /// Provides a condition that is kept in a register; computes it once per valuation of its variables.
    Recall {
        dst: Reg,
        memo: u32,
    },
    /// Ends the code: returns the value of a condition, or `true` after computing a value.
    Return(bool),
}

/// The entry point of code that computes a condition or a value.
#[derive(Debug, Clone, Copy)]
pub struct Entry {
    /// The position of the first instruction.
    pub start: u32,
    /// The register that contains the value afterwards.
    pub result: u32,
}

/// A node whose value is kept.
#[derive(Debug, Clone)]
pub(crate) struct Routine {
    /// The position of its first instruction.
    pub(crate) start: u32,
}

/// A condition that is computed once per valuation of its variables.
#[derive(Debug, Clone)]
pub(crate) struct Memo {
    /// The position of its first instruction.
    pub(crate) start: u32,
    pub(crate) valuations: Valuations,
}

/// The valuations of some variables, numbered from 0.
#[derive(Debug, Clone)]
pub(crate) struct Valuations {
    /// The variables with their lowest values, and the distance of the numbers for neighbouring values.
    fields: SmallVec<[(Reg, i64, usize); 2]>,
    pub(crate) count: usize,
}

impl Valuations {
    /// Numbers the valuations of some variables, which must be fewer than 2^32.
    pub(crate) fn new(program: &Program, variables: &[VarId]) -> Self {
        let mut count = 1;
        let field = |v: &VarId| {
            let declared = &program.variables[v.index()];
            let weight = count;
            count *= declared.high.abs_diff(declared.low) as usize + 1;
            (v.0, declared.low, weight)
        };
        let fields = variables.iter().map(field).collect();
        Valuations { fields, count }
    }

    /// Returns the number of the valuation in some registers.
    #[inline]
    pub(crate) fn number(&self, regs: &[i64]) -> usize {
        let place =
            |&(variable, low, weight): &(Reg, i64, usize)| (regs[variable as usize] - low) as usize * weight;
        self.fields.iter().map(place).sum()
    }
}

/// The disjuncts of a condition, of which only those are tested that the values of the variables may make true.
pub(crate) struct Table {
    pub(crate) lists: ByValue,
    /// The position of the first instruction of each disjunct.
    pub(crate) starts: Vec<u32>,
}

/// The code of all expressions of a program.
#[derive(Default)]
pub struct Code {
    pub(crate) ops: Vec<Op>,
    pub(crate) routines: Vec<Routine>,
    pub(crate) memos: Vec<Memo>,
    pub(crate) tables: Vec<Table>,
    /// The initial contents of the registers.
    pub(crate) initial: Vec<i64>,
    /// The reals among the constants.
    pub(crate) numbers: Numbers,
}

/// The registers of one evaluation.
#[derive(Debug, Clone)]
pub struct Machine {
    /// The registers, variables first.
    pub regs: Vec<i64>,
    /// For each routine, the number of the state for which its register is valid.
    stamps: Vec<u64>,
    /// For each memo, the results: 0 if not known yet, 1 for false, 2 for true.
    memos: Vec<Vec<u8>>,
    /// The reals in the registers.
    pub(crate) numbers: Numbers,
    now: u64,
}

impl Machine {
    /// Creates a machine for the given code.
    pub fn new(code: &Code) -> Self {
        let stamps = vec![0; code.routines.len()];
        let memos = vec![Vec::new(); code.memos.len()];
        Machine { regs: code.initial.clone(), stamps, memos, numbers: code.numbers.clone(), now: 0 }
    }

    /// Discards the kept results, because the variables have new values.
    pub fn next_state(&mut self) {
        self.now += 1;
        self.numbers.next_state();
    }

    /// Runs code from `start`: returns the value of a condition, or writes a value to its register.
    ///
    /// # Errors
    /// An expression has no value.
    pub fn run(&mut self, code: &Code, start: u32) -> Result<bool, EvalError> {
        let mut at = start as usize;
        loop {
            match code.ops[at] {
                Op::Jump { to } => at = to as usize,
                Op::JumpEq { a, b, to } => at = self.branch(at, to, self.get(a) == self.get(b)),
                Op::JumpNe { a, b, to } => at = self.branch(at, to, self.get(a) != self.get(b)),
                Op::JumpLt { a, b, to } => at = self.branch(at, to, self.get(a) < self.get(b)),
                Op::JumpLe { a, b, to } => at = self.branch(at, to, self.get(a) <= self.get(b)),
                Op::Any { dst, table } => {
                    let table = &code.tables[table as usize];
                    self.regs[dst as usize] = self.any(code, &table.lists, &table.starts)?.into();
                    at += 1;
                }
                Op::Share { routine } => {
                    self.share(code, routine as usize)?;
                    at += 1;
                }
                Op::Recall { dst, memo } => {
                    self.recall(code, dst, memo as usize)?;
                    at += 1;
                }
                Op::Return(value) => return Ok(value),
                op => {
                    self.compute(op)?;
                    at += 1;
                }
            }
        }
    }

    fn any(&mut self, code: &Code, lists: &ByValue, starts: &[u32]) -> Result<bool, EvalError> {
        for &disjunct in &lists.others {
            if self.run(code, starts[disjunct as usize])? {
                return Ok(true);
            }
        }
        for split in &lists.splits {
            if let Some(lists) = split.get(self.regs[split.variable])
                && self.any(code, lists, starts)?
            {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn recall(&mut self, code: &Code, dst: Reg, index: usize) -> Result<(), EvalError> {
        let memo = &code.memos[index];
        let at = memo.valuations.number(&self.regs);
        let known = self.memos[index].get(at).copied().unwrap_or_default();
        if known != 0 {
            self.regs[dst as usize] = i64::from(known) - 1;
            return Ok(());
        }
        self.run(code, memo.start)?;
        let results = &mut self.memos[index];
        results.resize(memo.valuations.count, 0);
        results[at] = self.regs[dst as usize] as u8 + 1;
        Ok(())
    }

    fn share(&mut self, code: &Code, index: usize) -> Result<(), EvalError> {
        if self.stamps[index] != self.now {
            self.run(code, code.routines[index].start)?;
            self.stamps[index] = self.now;
        }
        Ok(())
    }

    fn compute(&mut self, op: Op) -> Result<(), EvalError> {
        let overflow = EvalError::Overflow;
        let (dst, value) = match op {
            Op::Add { dst, a, b } => (dst, self.get(a).checked_add(self.get(b)).ok_or(overflow)?),
            Op::Sub { dst, a, b } => (dst, self.get(a).checked_sub(self.get(b)).ok_or(overflow)?),
            Op::Mul { dst, a, b } => (dst, self.get(a).checked_mul(self.get(b)).ok_or(overflow)?),
            Op::Min { dst, a, b } => (dst, self.get(a).min(self.get(b))),
            Op::Max { dst, a, b } => (dst, self.get(a).max(self.get(b))),
            Op::Copy { dst, a } => (dst, self.get(a)),
            Op::Whole { op, ty, dst, a, b } => {
                (dst, self.place(exact::binary(op, &self.whole(ty, a), &self.whole(ty, b))?))
            }
            Op::Real { op, dst, a, b } => (dst, self.numbers.binary(op, self.get(a), self.get(b))?),
            Op::Unary { op, ty: Type::Real, dst, a } => (dst, self.numbers.unary(op, self.get(a))?),
            Op::Unary { op: Unary::ToReal, dst, a, .. } => (dst, self.numbers.integer(self.get(a))),
            Op::Unary { op, ty, dst, a } => (dst, self.place(exact::unary(op, self.whole(ty, a))?)),
            _ => return Ok(()),
        };
        self.regs[dst as usize] = value;
        Ok(())
    }

    #[inline]
    fn branch(&self, at: usize, to: u32, taken: bool) -> usize {
        if taken { to as usize } else { at + 1 }
    }

    #[inline]
    fn get(&self, reg: Reg) -> i64 {
        self.regs[reg as usize]
    }

    /// Returns whether the real in a register is 0.
    pub fn is_zero(&self, reg: Reg) -> bool {
        Numbers::is_zero(self.get(reg))
    }

    /// Returns the integer or the truth value in a register.
    fn whole(&self, ty: Type, reg: Reg) -> Exact {
        let word = self.get(reg);
        if ty == Type::Bool { Exact::Bool(word != 0) } else { Exact::Int(word) }
    }

    /// Returns the register content for a value.
    fn place(&mut self, value: Exact) -> i64 {
        match value {
            Exact::Bool(b) => i64::from(b),
            Exact::Int(i) => i,
            Exact::Real(number) => self.numbers.place(number),
        }
    }
}
