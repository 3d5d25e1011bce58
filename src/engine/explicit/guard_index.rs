//! The guard index: a table from the values of a few variables to the commands that can be enabled.
//!
//! Most guards test the location of their module or the contents of a grid cell. The parts of a
//! participant's guards over a few variables are looked up together. Each valuation of these
//! variables has a cell with the commands whose parts are true there. Cells are filled on first
//! use.

use std::cmp::Reverse;

use ahash::{AHashMap, AHashSet};

use super::bounds::Bounds;
use super::by_value::{ByValue, Need, only_value};
use super::compile::Compiler;
use super::machine::{Code, Entry, Machine};
use meliora_base::error::Result;
use meliora_base::progress::Poll;
use meliora_base::value::{EvalError, Type, Value};
use meliora_model::expr::{Binary, ExprId, Node};
use meliora_model::{CommandId, Program};

/// Maximum number of cells of all tables of a program together, and of commands in all rows of a table.
const MOST_CELLS: usize = 1 << 18;
/// The content of a cell that is not filled. The rows are numbered from 1.
const UNKNOWN: u16 = u16::MIN;

/// A variable that indexes a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Key {
    variable: u32,
    low: i64,
    /// The distance in cells between two consecutive values.
    stride: u32,
}

impl Key {
    /// Returns the variable's contribution to the cell number.
    #[inline]
    fn offset(&self, values: &[i64]) -> usize {
        let above = values[self.variable as usize].wrapping_sub(self.low) as usize;
        above.wrapping_mul(self.stride as usize)
    }
}

/// The guards of a participant's commands, each divided into a part for the table and the rest.
pub(super) struct Division {
    /// The variables that index the table.
    keys: Vec<u32>,
    commands: Vec<Divided>,
    /// The values that the guard of each command needs.
    pub(super) needs: Vec<Vec<Need>>,
}

/// A guard as two conjunctions: the part that the table answers and the rest.
struct Divided {
    command: CommandId,
    settled: Vec<ExprId>,
    rest: Vec<ExprId>,
}

/// A conjunct of a guard.
struct Conjunct {
    e: ExprId,
    /// The variables in it; `None` if a table must not answer for it.
    support: Option<Vec<u32>>,
}

impl Division {
    /// Divides the guards of `commands`; `tables` is the number of tables of the program.
    ///
    /// # Errors
    /// The work is cancelled.
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
        let needs = guards.iter().map(|guard| needs(program, guard)).collect();
        let keys = keys(program, &guards, (MOST_CELLS / tables.max(1)) as u64);
        let divide = |(&command, guard): (&CommandId, Vec<Conjunct>)| {
            let (settled, rest) = guard.into_iter().partition::<Vec<_>, _>(|c| c.depends_only_on(&keys));
            let parts = |of: Vec<Conjunct>| of.into_iter().map(|c| c.e).collect();
            Divided { command, settled: parts(settled), rest: parts(rest) }
        };
        let commands = commands.iter().zip(guards).map(divide).collect();
        Ok(Division { keys, commands, needs })
    }

    /// Returns all conjuncts of the guards.
    pub(super) fn roots(&self) -> impl Iterator<Item = ExprId> {
        self.commands.iter().flat_map(|c| c.settled.iter().chain(&c.rest)).copied()
    }

    /// Compiles the parts of the guards.
    ///
    /// # Errors
    /// The work is cancelled.
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
        let (keys, cells) = table(program, &self.keys);
        // A row is kept for the values of the keys, so it may not depend on other variables.
        let by_key = |needs: &Vec<Need>| {
            needs.iter().filter(|(variable, _)| self.keys.contains(variable)).cloned().collect()
        };
        let by_value = ByValue::new(&self.needs.iter().map(by_key).collect::<Vec<_>>());
        Ok(GuardIndex { keys, cells, candidates, by_value })
    }
}

impl Conjunct {
    fn depends_only_on(&self, keys: &[u32]) -> bool {
        self.support.as_ref().is_some_and(|s| s.iter().all(|v| keys.contains(v)))
    }
}

/// Returns the conjuncts of a guard, in their order.
///
/// A table may answer for a conjunct if it and all conjuncts before it are total. Then a guard with
/// a false conjunct is false and never without a value.
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

/// Returns the values that a guard needs. As for a table, a conjunct counts only if it and those before it
/// are total.
fn needs(program: &Program, guard: &[Conjunct]) -> Vec<Need> {
    let answered = guard.iter().filter(|conjunct| conjunct.support.is_some());
    let mut needs: Vec<Need> = Vec::new();
    for (variable, value) in answered.filter_map(|conjunct| only_value(&program.pool, conjunct.e)) {
        if needs.iter().all(|(known, _)| *known != variable) {
            needs.push((variable, vec![value]));
        }
    }
    needs
}

/// Chooses the variables of a table. Variable sets with more different conjuncts come first, and those with a
/// single one are left out, because a conjunct that all guards share does not distinguish commands.
fn keys(program: &Program, guards: &[Vec<Conjunct>], most: u64) -> Vec<u32> {
    let mut votes: AHashMap<&[u32], AHashSet<ExprId>> = AHashMap::new();
    for conjunct in guards.iter().flatten() {
        if let Some(support) = conjunct.support.as_deref() {
            votes.entry(support).or_default().insert(conjunct.e);
        }
    }
    let several = votes.into_iter().map(|(s, of)| (s, of.len())).filter(|&(_, count)| count > 1);
    let mut wanted: Vec<(&[u32], usize)> = several.collect();
    wanted.sort_unstable_by_key(|&(support, count)| (Reverse(count), support.len(), support));
    let mut keys = Vec::new();
    for (support, _) in wanted {
        let more = merged(keys.clone(), support);
        if cells(program, &more).is_some_and(|n| n <= most) {
            keys = more;
        }
    }
    // A look-up costs as much as a single test.
    let settled = guards.iter().flatten().filter(|c| c.depends_only_on(&keys)).count();
    if settled > 1 { keys } else { Vec::new() }
}

/// Returns the union of two sets of variables, sorted.
fn merged(mut x: Vec<u32>, y: &[u32]) -> Vec<u32> {
    x.extend(y.iter().filter(|v| !x.contains(v)).copied().collect::<Vec<_>>());
    x.sort_unstable();
    x
}

/// Returns the number of valuations of some variables; `None` if it overflows.
fn cells(program: &Program, support: &[u32]) -> Option<u64> {
    let size = |v: &u32| {
        let declared = &program.variables[*v as usize];
        (declared.high.wrapping_sub(declared.low) as u64).checked_add(1)
    };
    support.iter().try_fold(1u64, |n, v| n.checked_mul(size(v)?))
}

/// Returns the keys of a table over some variables and its number of cells. The number must fit 32
/// bits.
fn table(program: &Program, support: &[u32]) -> (Vec<Key>, u32) {
    let (mut keys, mut stride) = (Vec::new(), 1u32);
    for &variable in support.iter().rev() {
        let declared = &program.variables[variable as usize];
        keys.push(Key { variable, low: declared.low, stride });
        stride *= declared.high.wrapping_sub(declared.low) as u32 + 1;
    }
    (keys, stride)
}

/// The commands of a participant, looked up by cell.
pub(super) struct GuardIndex {
    keys: Vec<Key>,
    cells: u32,
    pub(super) candidates: Vec<Candidate>,
    /// The positions of the candidates by the value of a variable.
    by_value: Option<ByValue>,
}

/// A command of a participant.
pub(super) struct Candidate {
    pub(super) command: u32,
    /// The part of its guard that the table answers.
    settled: Option<Entry>,
    /// The part of its guard that is evaluated in each state.
    pub(super) rest: Option<Entry>,
}

/// The table of a [`GuardIndex`], filled on demand.
#[derive(Default)]
pub(super) struct Rows {
    /// For each cell, the number of its row.
    cells: Vec<u16>,
    /// Start and end of each row in `members`.
    rows: Vec<(u32, u32)>,
    /// Positions in [`GuardIndex::candidates`]. The first entries contain the last row that was not
    /// stored.
    pub(super) members: Vec<u32>,
    known: AHashMap<Vec<u32>, u16>,
}

impl Rows {
    /// Returns the range in [`Rows::members`] of the candidates that the table does not rule out in
    /// the present state, in the order of the program. The range is valid until the next call.
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
            Some(&row) if row != UNKNOWN => Ok(self.rows[row as usize - 1]),
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
        let value = guard_index.by_value.as_ref().map(|lists| (lists, machine.regs[lists.variable]));
        let add = |position: u32| {
            let settled = guard_index.candidates[position as usize].settled;
            if settled.map_or(Ok(true), |entry| machine.run(code, entry.start))? {
                row.push(position);
            }
            Ok(())
        };
        match value {
            Some((lists, value)) => lists.of(value).try_for_each(add)?,
            None => (0..guard_index.candidates.len() as u32).try_for_each(add)?,
        }
        if self.members.is_empty() {
            self.members.resize(guard_index.candidates.len(), 0);
        }
        let full = self.rows.len() >= usize::from(u16::MAX) || self.members.len() + row.len() > MOST_CELLS;
        if full {
            self.members[..row.len()].copy_from_slice(&row);
            return Ok((0, row.len() as u32));
        }
        if self.cells.is_empty() {
            self.cells = vec![UNKNOWN; guard_index.cells as usize];
        }
        let number = self.number(row);
        self.cells[cell] = number;
        Ok(self.rows[number as usize - 1])
    }

    /// Returns the number of a row; stores the row if it is new.
    fn number(&mut self, row: Vec<u32>) -> u16 {
        if let Some(&number) = self.known.get(&row) {
            return number;
        }
        let start = self.members.len() as u32;
        self.members.extend_from_slice(&row);
        self.rows.push((start, self.members.len() as u32));
        let number = self.rows.len() as u16;
        self.known.insert(row, number);
        number
    }
}
