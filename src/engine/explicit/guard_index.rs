//! Which commands of a participant can be enabled, by a table over a few variables.
//!
//! Most guards ask where their module stands, or what is the case in a cell of a grid. Those parts of
//! a participant's guards that are over a few variables are looked up together: each valuation of
//! these has a cell, with the commands whose parts hold there. The table fills as it is used.

use std::cmp::Reverse;

use ahash::{AHashMap, AHashSet};

use super::bounds::Bounds;
use super::compile::Compiler;
use super::machine::{Code, Entry, Machine};
use super::share::{self, Key};
use crate::error::Result;
use crate::model::expr::{Binary, ExprId, Node};
use crate::model::value::{EvalError, Type, Value};
use crate::model::{CommandId, Program};
use crate::progress::Poll;

/// A table has at most so many cells.
const MOST_CELLS: u64 = 1 << 18;
/// For variables that only one conjunct is over it grows to no more than this.
const FEW_CELLS: u64 = 1 << 10;
/// All tables of a program together have at most so many cells.
const ALL_CELLS: u64 = 1 << 22;
/// The rows of a table hold at most so many commands together.
const MOST_MEMBERS: usize = 1 << 20;
/// A table is worth its memory only after so many look-ups.
const PATIENCE: u32 = 64;
/// The cell of which nothing is known; there are no more rows than this.
const UNKNOWN: u16 = u16::MAX;

/// How the guards of a participant's commands are divided.
pub(super) struct Division {
    /// The variables that the table is over.
    keys: Vec<u32>,
    commands: Vec<Divided>,
}

/// A guard as two conjunctions.
struct Divided {
    command: CommandId,
    settled: Vec<ExprId>,
    rest: Vec<ExprId>,
}

/// A part of a guard.
struct Conjunct {
    e: ExprId,
    /// The variables in it; none where a table may not answer for it.
    support: Option<Vec<u32>>,
}

impl Division {
    /// Divides the guards of `commands`; there will be `tables` of these in all.
    ///
    /// # Errors
    /// The work is to stop.
    pub(super) fn new(
        program: &Program,
        bounds: &Bounds,
        commands: &[CommandId],
        tables: usize,
        poll: &mut Poll<'_>,
    ) -> Result<Self> {
        let mut guards: Vec<Vec<Conjunct>> = Vec::with_capacity(commands.len());
        for command in commands {
            poll.step()?;
            guards.push(conjuncts(program, bounds, program.commands[command.index()].guard));
        }
        let most = MOST_CELLS.min(ALL_CELLS / tables.max(1) as u64);
        let keys = keys(program, &guards, most);
        let divide = |(&command, guard): (&CommandId, Vec<Conjunct>)| {
            let (settled, rest) = guard.into_iter().partition::<Vec<_>, _>(|c| c.is_over(&keys));
            let parts = |of: Vec<Conjunct>| of.into_iter().map(|c| c.e).collect();
            Divided { command, settled: parts(settled), rest: parts(rest) }
        };
        let commands = commands.iter().zip(guards).map(divide).collect();
        Ok(Division { keys, commands })
    }

    /// All parts of guards.
    pub(super) fn roots(&self) -> impl Iterator<Item = ExprId> {
        self.commands.iter().flat_map(|c| c.settled.iter().chain(&c.rest)).copied()
    }

    /// The same as code.
    ///
    /// # Errors
    /// The work is to stop.
    pub(super) fn compile(
        &self,
        program: &Program,
        compiler: &mut Compiler<'_>,
        poll: &mut Poll<'_>,
    ) -> Result<GuardIndex> {
        let mut entry = |of: &[ExprId]| (!of.is_empty()).then(|| compiler.conjunction(of));
        let mut candidates = Vec::with_capacity(self.commands.len());
        for c in &self.commands {
            poll.step()?;
            let (settled, rest) = (entry(&c.settled), entry(&c.rest));
            candidates.push(Candidate { command: c.command.0, settled, rest });
        }
        let (keys, cells) = share::table(program, &self.keys);
        Ok(GuardIndex { keys, cells, candidates })
    }
}

impl Conjunct {
    fn is_over(&self, keys: &[u32]) -> bool {
        self.support.as_ref().is_some_and(|s| s.iter().all(|v| keys.contains(v)))
    }
}

/// The conjuncts of a guard, in their order.
///
/// A table may answer for one when it and all before it are total: where it is false, the guard is
/// false then, and not without a value.
fn conjuncts(program: &Program, bounds: &Bounds, guard: ExprId) -> Vec<Conjunct> {
    let pool = &program.pool;
    let (mut found, mut stack, mut total) = (Vec::new(), vec![guard], true);
    while let Some(e) = stack.pop() {
        match pool.node(e) {
            Node::Binary(Binary::And, a, b) if pool.ty(a) == Type::Bool => stack.extend([b, a]),
            Node::Literal(Value::Bool(true)) => {}
            _ => {
                total &= bounds.is_total(e);
                let support = total.then(|| pool.support(e).into_iter().map(|v| v.0).collect());
                found.push(Conjunct { e, support });
            }
        }
    }
    found
}

/// The variables for a table: those that most different conjuncts are over come first, since what
/// all guards have in common tells no command from another.
fn keys(program: &Program, guards: &[Vec<Conjunct>], most: u64) -> Vec<u32> {
    let mut votes: AHashMap<&[u32], AHashSet<ExprId>> = AHashMap::new();
    for conjunct in guards.iter().flatten() {
        if let Some(support) = conjunct.support.as_deref() {
            votes.entry(support).or_default().insert(conjunct.e);
        }
    }
    let mut wanted: Vec<(&[u32], usize)> = votes.into_iter().map(|(s, of)| (s, of.len())).collect();
    wanted.sort_unstable_by_key(|&(support, count)| (Reverse(count), support.len(), support));
    let mut keys = Vec::new();
    for (support, count) in wanted {
        let more = share::merged(keys.clone(), support);
        let most = if count > 1 { most } else { most.min(FEW_CELLS) };
        if share::cells(program, &more).is_some_and(|n| n <= most) {
            keys = more;
        }
    }
    // One look-up is no better than one test.
    let settled = guards.iter().flatten().filter(|c| c.is_over(&keys)).count();
    if settled > 1 { keys } else { Vec::new() }
}

/// The commands of a participant by cell.
pub(super) struct GuardIndex {
    keys: Vec<Key>,
    cells: u32,
    pub(super) candidates: Vec<Candidate>,
}

/// A command of a participant.
pub(super) struct Candidate {
    pub(super) command: u32,
    /// The part of its guard that the table answers for.
    settled: Option<Entry>,
    /// The part that has to be looked at in each state.
    pub(super) rest: Option<Entry>,
}

/// The table of a [`GuardIndex`], as far as it is filled.
#[derive(Default)]
pub(super) struct Rows {
    /// For each cell the number of its row.
    cells: Vec<u16>,
    /// Where each row is in `members`.
    rows: Vec<(u32, u32)>,
    /// Positions in [`GuardIndex::candidates`]; those in front are the last row that was not kept.
    pub(super) members: Vec<u32>,
    known: AHashMap<Vec<u32>, u16>,
    asked: u32,
}

impl Rows {
    /// Where in [`Rows::members`] the candidates are that the present state does not rule out by the
    /// variables of the table, in the order of the program. Holds until the next call.
    #[inline]
    pub(super) fn of(
        &mut self,
        guard_index: &GuardIndex,
        machine: &mut Machine,
        code: &Code,
    ) -> Result<(u32, u32), EvalError> {
        let mut cell = 0;
        for key in &guard_index.keys {
            cell += key.offset(&machine.regs);
        }
        match self.cells.get(cell) {
            Some(&row) if row != UNKNOWN => Ok(self.rows[row as usize]),
            _ => self.fill(cell, guard_index, machine, code),
        }
    }

    #[cold]
    fn fill(
        &mut self,
        cell: usize,
        guard_index: &GuardIndex,
        machine: &mut Machine,
        code: &Code,
    ) -> Result<(u32, u32), EvalError> {
        let mut row = Vec::new();
        for (position, candidate) in guard_index.candidates.iter().enumerate() {
            if candidate.settled.map_or(Ok(true), |entry| machine.run(code, entry.start))? {
                row.push(position as u32);
            }
        }
        if self.members.is_empty() {
            self.members.resize(guard_index.candidates.len(), 0);
        }
        self.asked = self.asked.saturating_add(1);
        let full = self.rows.len() >= usize::from(UNKNOWN) || self.members.len() + row.len() > MOST_MEMBERS;
        if self.asked < PATIENCE || full {
            self.members[..row.len()].copy_from_slice(&row);
            return Ok((0, row.len() as u32));
        }
        if self.cells.is_empty() {
            self.cells.resize(guard_index.cells as usize, UNKNOWN);
        }
        let number = self.number(row);
        self.cells[cell] = number;
        Ok(self.rows[number as usize])
    }

    /// The number of a row.
    fn number(&mut self, row: Vec<u32>) -> u16 {
        if let Some(&number) = self.known.get(&row) {
            return number;
        }
        let (number, start) = (self.rows.len() as u16, self.members.len() as u32);
        self.members.extend_from_slice(&row);
        self.rows.push((start, self.members.len() as u32));
        self.known.insert(row, number);
        number
    }
}
