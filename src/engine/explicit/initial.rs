//! A search for the initial states that does not enumerate all valuations.

use super::compile::Compiler;
use super::machine::{Code, Machine};
use meliora_model::error::{Limit, Result};
use meliora_model::expr::{Binary, ExprId, Node};
use meliora_model::progress::{Poll, ProgressSink};
use meliora_model::{Program, State};

/// Number of partial valuations tried between two checks of the progress sink.
const PATIENCE: u64 = 1 << 16;

/// A search for the valuations in which all conjuncts of a predicate are true, variable by
/// variable.
pub(super) struct Search<'a> {
    program: &'a Program,
    sink: &'a dyn ProgressSink,
    code: Code,
    machine: Machine,
    /// For each depth, the conjuncts that can be tested once the variables before it have values.
    tests: Vec<Vec<u32>>,
    /// The order in which variables are assigned, with the first and last value to be tried.
    order: Vec<(usize, i64, i64)>,
    tried: u64,
}

impl<'a> Search<'a> {
    /// Creates a search for the states of a predicate, such as that of the initial states.
    /// Conjuncts that fix a variable restrict its range.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(super) fn new(program: &'a Program, predicate: ExprId, sink: &'a dyn ProgressSink) -> Result<Self> {
        let mut conjuncts = Vec::new();
        split(program, predicate, &mut conjuncts);
        let mut order: Vec<(usize, i64, i64)> =
            program.variables.iter().enumerate().map(|(i, v)| (i, v.low, v.high)).collect();
        for &e in &conjuncts {
            if let Some((variable, value)) = fixed(program, e) {
                let (_, low, high) = &mut order[variable];
                (*low, *high) = ((*low).max(value), (*high).min(value));
            }
        }
        // Variables with one value come first: they cost nothing, and more conjuncts can be tested
        // early.
        order.sort_by_key(|&(variable, low, high)| (high > low, variable));
        let mut compiler = Compiler::new(program, &program.pool, &conjuncts, &mut Poll::new(sink))?;
        let mut tests = vec![Vec::new(); order.len() + 1];
        for &e in &conjuncts {
            let support = program.pool.support(e);
            let last = order.iter().rposition(|(v, ..)| support.iter().any(|s| s.index() == *v));
            tests[last.map_or(0, |at| at + 1)].push(compiler.condition(e).start);
        }
        let code = compiler.finish();
        let machine = Machine::new(&code);
        Ok(Search { program, sink, code, machine, tests, order, tried: 0 })
    }

    /// Calls `found` with every state of the predicate. Tries at most `most` partial valuations.
    ///
    /// A conjunct without a value counts as false. It matters only in states of the scope, where
    /// the whole expression is evaluated again.
    ///
    /// # Errors
    /// The work is cancelled, there are more to try, or `found` fails.
    pub(super) fn run(&mut self, most: u64, found: &mut dyn FnMut(&[i64]) -> Result<()>) -> Result<()> {
        if !self.passes(0) {
            return Ok(());
        }
        let depth = self.order.len();
        // For each assigned variable, the next value to try.
        let mut next: Vec<i128> = self.order.iter().map(|&(_, low, _)| low.into()).collect();
        let mut at = 0;
        loop {
            if at == depth {
                let state: State = self.machine.regs[..self.program.variables.len()].to_vec();
                found(&state)?;
            } else {
                let (variable, low, high) = self.order[at];
                if next[at] <= i128::from(high) {
                    self.machine.regs[variable] = next[at] as i64;
                    next[at] += 1;
                    self.poll(most)?;
                    at += usize::from(self.passes(at + 1));
                    continue;
                }
                next[at] = low.into();
            }
            match at.checked_sub(1) {
                Some(before) => at = before,
                None => return Ok(()),
            }
        }
    }

    fn passes(&mut self, at: usize) -> bool {
        self.machine.next_state();
        let (machine, code) = (&mut self.machine, &self.code);
        self.tests[at].iter().all(|&start| machine.run(code, start) == Ok(true))
    }

    fn poll(&mut self, most: u64) -> Result<()> {
        self.tried += 1;
        if self.tried > most {
            let what = format!("more than {most} partial valuations to find the initial states");
            return Err(Limit::Size { what }.into());
        }
        if self.tried.is_multiple_of(PATIENCE)
            && let Some(limit) = self.sink.stop()
        {
            return Err(limit.into());
        }
        Ok(())
    }
}

/// Collects the conjuncts of an expression.
fn split(program: &Program, e: ExprId, conjuncts: &mut Vec<ExprId>) {
    let mut stack = vec![e];
    while let Some(e) = stack.pop() {
        match program.pool.node(e) {
            Node::Binary(Binary::And, a, b) => stack.extend([b, a]),
            _ => conjuncts.push(e),
        }
    }
}

/// Returns the variable and the value of a conjunct `variable = constant`.
fn fixed(program: &Program, e: ExprId) -> Option<(usize, i64)> {
    use meliora_model::value::Value;
    let pool = &program.pool;
    match pool.node(e) {
        Node::Var(v) => Some((v.index(), 1)),
        Node::Unary(meliora_model::expr::Unary::Not, a) => match pool.node(a) {
            Node::Var(v) => Some((v.index(), 0)),
            _ => None,
        },
        Node::Binary(Binary::Eq, a, b) => match (pool.node(a), pool.node(b)) {
            (Node::Var(v), Node::Literal(Value::Int(c))) | (Node::Literal(Value::Int(c)), Node::Var(v)) => {
                Some((v.index(), c))
            }
            _ => None,
        },
        _ => None,
    }
}
