//! Cells: states that have the same choices, as differences of codes.
//!
//! Models count: the charge of a battery is compared with numbers, and raised or lowered. A variable is a *counter* if
//! each of its uses compares it with a literal, or is part of its own new value, of the form v + d, v - d or d, where
//! d, and which form it is, depend on v at most through comparisons. The comparisons divide the values of a counter
//! into intervals. States that agree in all other variables and in the intervals of the counters form a cell.

use ahash::AHashMap;

use super::layout::{Bits, Code, Field, Layout};
use meliora_model::expr::{Binary, ExprId, Node};
use meliora_model::value::Value;
use meliora_model::{Program, VarId};

/// The greatest number of cells: 16 MiB of numbers.
const MOST_CELLS: u64 = 1 << 22;
/// The least number of valuations per cell that makes cells worth their memory.
const WORTH: u64 = 16;

/// The cells of a program.
#[derive(Debug)]
pub(super) struct Cells {
    /// For each variable with several values, without counters, its bits and the weight of its digit in the number of
    /// a cell.
    digits: Vec<(Bits, u64)>,
    counters: Vec<Counter>,
    count: usize,
}

#[derive(Debug)]
struct Counter {
    field: Field,
    /// The weight of its interval in the number of a cell.
    weight: u64,
    /// The least value of each interval, counted from the least value of the variable.
    starts: Vec<u64>,
}

impl Counter {
    fn interval(&self, value: u64) -> usize {
        self.starts.partition_point(|&start| start <= value) - 1
    }

    /// Returns the least and the greatest value of an interval.
    fn ends(&self, interval: usize) -> [u64; 2] {
        let last = self.starts.get(interval + 1).copied().unwrap_or(self.field.values());
        [self.starts[interval], last - 1]
    }
}

impl Cells {
    /// Finds the counters of a program; `None` if there are no cells worth their memory. Cost: one look at each
    /// expression of the commands.
    pub(super) fn new(program: &Program, layout: &Layout) -> Option<Self> {
        let cuts = Uses::of_commands(program).cuts;
        let (mut digits, mut counters) = (Vec::new(), Vec::new());
        let (mut count, mut in_each) = (1_u64, 1_u64);
        for (index, cuts) in cuts.into_iter().enumerate() {
            let field = layout.field(index);
            let values = field.values();
            let starts = cuts.map(|cuts| starts(cuts, program.variables[index].low, values));
            let parts = starts.as_ref().map_or(values, |starts| starts.len() as u64);
            let weight = count;
            count = count.checked_mul(parts).filter(|&count| 0 < count && count <= MOST_CELLS)?;
            in_each = in_each.saturating_mul(values / parts);
            match starts {
                Some(starts) => counters.push(Counter { field, weight, starts }),
                None if values > 1 => digits.push((field.bits(), weight)),
                None => {}
            }
        }
        (in_each >= WORTH).then_some(Cells { digits, counters, count: count as usize })
    }

    /// Returns the number of cells.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Returns the cell of a state.
    #[inline]
    pub(super) fn cell(&self, code: &[u64]) -> usize {
        let digits: u64 = self.digits.iter().map(|(bits, weight)| bits.of(code) * weight).sum();
        let interval =
            |counter: &Counter| counter.interval(counter.field.bits().of(code)) as u64 * counter.weight;
        (digits + self.counters.iter().map(interval).sum::<u64>()) as usize
    }

    /// Returns the valuations of the cell of a state in which all counters have their least values, and in which all
    /// have their greatest ones.
    pub(super) fn corners(&self, code: &[u64]) -> [Code; 2] {
        let mut corners = [(); 2].map(|()| Code::from_slice(code));
        for counter in &self.counters {
            let value = counter.field.bits().of(code);
            let ends = counter.ends(counter.interval(value));
            for (corner, end) in corners.iter_mut().zip(ends) {
                counter.field.add(corner, value as i64, end as i64);
            }
        }
        corners
    }
}

/// Returns the least value of each interval, given the values where one may begin.
fn starts(cuts: Vec<i64>, low: i64, values: u64) -> Vec<u64> {
    let inside = |cut: i64| cut.checked_sub(low).and_then(|cut| u64::try_from(cut).ok());
    let mut starts: Vec<u64> = cuts.into_iter().filter_map(inside).filter(|&cut| cut < values).collect();
    starts.push(0);
    starts.sort_unstable();
    starts.dedup();
    starts
}

/// The dependence of an expression on the state within a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shape {
    Constant,
    /// In each cell, the value of the variable plus a constant, or a constant.
    Counted(VarId),
}

/// The uses of the variables in the commands.
struct Uses<'p> {
    program: &'p Program,
    /// For each variable that may be a counter, the values at which its intervals begin.
    cuts: Vec<Option<Vec<i64>>>,
    shapes: AHashMap<ExprId, Shape>,
}

impl<'p> Uses<'p> {
    fn of_commands(program: &'p Program) -> Self {
        let cuts =
            program.variables.iter().map(|v| (v.high.abs_diff(v.low) >= WORTH).then(Vec::new)).collect();
        let mut uses = Uses { program, cuts, shapes: AHashMap::new() };
        for command in &program.commands {
            uses.constant(command.guard);
            for branch in &command.branches {
                uses.constant(branch.probability);
                for &(variable, value) in &branch.updates {
                    match uses.shape(value) {
                        Shape::Counted(used) if used != variable => uses.exclude(used),
                        _ => {}
                    }
                }
            }
        }
        uses
    }

    /// Makes a variable one that must agree within a cell.
    fn exclude(&mut self, variable: VarId) {
        self.cuts[variable.index()] = None;
    }

    /// Makes an expression constant within each cell.
    fn constant(&mut self, e: ExprId) {
        if let Shape::Counted(variable) = self.shape(e) {
            self.exclude(variable);
        }
    }

    /// Finds the shape of an expression, operands first.
    fn shape(&mut self, e: ExprId) -> Shape {
        let mut stack = vec![e];
        while let Some(&e) = stack.last() {
            let open = |a: &ExprId| !self.shapes.contains_key(a);
            let before = stack.len();
            if open(&e) {
                stack.extend(self.program.pool.operands(e).filter(open));
            }
            if stack.len() == before {
                let shape = self.shape_of(self.program.pool.node(e));
                self.shapes.entry(e).or_insert(shape);
                stack.pop();
            }
        }
        self.shapes[&e]
    }

    fn shape_of(&mut self, node: Node) -> Shape {
        match node {
            Node::Literal(_) => Shape::Constant,
            Node::Var(variable) => match self.cuts.get(variable.index()) {
                Some(Some(_)) => Shape::Counted(variable),
                _ => Shape::Constant,
            },
            Node::Binary(Binary::Eq | Binary::Lt | Binary::Le, a, b) if self.is_cut(a, b) => Shape::Constant,
            Node::Binary(Binary::Add, a, b) => match (self.shapes[&a], self.shapes[&b]) {
                (shape, Shape::Constant) | (Shape::Constant, shape) => shape,
                _ => self.mixed([a, b]),
            },
            Node::Binary(Binary::Sub, a, b) if self.shapes[&b] == Shape::Constant => self.shapes[&a],
            Node::Ite(condition, a, b) => {
                self.constant(condition);
                match (self.shapes[&a], self.shapes[&b]) {
                    (shape, Shape::Constant) | (Shape::Constant, shape) => shape,
                    (x, y) if x == y => x,
                    _ => self.mixed([a, b]),
                }
            }
            Node::Unary(_, a) => self.mixed([a]),
            Node::Binary(_, a, b) => self.mixed([a, b]),
        }
    }

    /// Makes operands constant within each cell, and so the whole.
    fn mixed<const N: usize>(&mut self, operands: [ExprId; N]) -> Shape {
        operands.into_iter().for_each(|a| self.constant(a));
        Shape::Constant
    }

    /// Notes the values at which a comparison of a variable with a literal changes; returns whether it is one.
    fn is_cut(&mut self, a: ExprId, b: ExprId) -> bool {
        let pool = &self.program.pool;
        let (variable, at) = match (pool.node(a), pool.node(b)) {
            (Node::Var(variable), Node::Literal(Value::Int(at)))
            | (Node::Literal(Value::Int(at)), Node::Var(variable)) => (variable, at),
            _ => return false,
        };
        if let Some(Some(cuts)) = self.cuts.get_mut(variable.index()) {
            cuts.extend([Some(at), at.checked_add(1)].into_iter().flatten());
        }
        true
    }
}
