//! Conditions of a program as conjunctions of *facts*: tests of single variables, and alternatives of these.
//!
//! A state satisfies at least the facts of each condition that is true in it. Parts that are no tests of one
//! variable are left out, so a condition may have fewer facts than it needs, but never more.

use std::rc::Rc;

use ahash::AHashMap;

use meliora_base::stack;
use meliora_base::value::{Binary, Type, Unary, Value};
use meliora_model::Program;
use meliora_model::expr::{ExprId, ExprPool, Node};

use meliora_space::layout::width;
use meliora_space::needs::interval;

/// A fact, by its number.
pub(super) type Fact = u32;

/// The facts of a condition, sorted; `None` if it is never true.
pub(super) type Condition = Option<Rc<[Fact]>>;

/// The facts that conditions of a program name.
pub(super) struct Facts<'p> {
    pub(super) pool: &'p ExprPool,
    program: &'p Program,
    /// The number of facts.
    pub(super) count: u32,
    /// For each variable and each of its values from the lowest one, the tests that it passes; no lists for a
    /// variable with too many values.
    pub(super) passed: Vec<Vec<Vec<Fact>>>,
    /// The alternatives: each fact with conditions that imply it.
    pub(super) implied: Vec<(Rc<[Fact]>, Fact)>,
    /// The conditions that are known, also negated ones.
    known: AHashMap<(ExprId, bool), Condition>,
    /// The facts of tests, by the variable and its values that pass.
    tests: AHashMap<(u32, Vec<bool>), Fact>,
    /// The facts that a variable has a value, or not.
    pub(super) values: AHashMap<(u32, i64, bool), Fact>,
}

impl<'p> Facts<'p> {
    /// Creates an empty list; the pool is that of the program, or rests on it.
    pub(super) fn new(program: &'p Program, pool: &'p ExprPool) -> Self {
        // A longer list of values would dominate the expressions, which name only some of them.
        let values = |variable| usize::try_from(width(variable)).ok().filter(|&width| width < pool.len());
        let lists = |variable| values(variable).map_or_else(Vec::new, |width| vec![Vec::new(); width + 1]);
        Facts {
            pool,
            program,
            count: 0,
            passed: program.variables.iter().map(lists).collect(),
            implied: Vec::new(),
            known: AHashMap::new(),
            tests: AHashMap::new(),
            values: AHashMap::new(),
        }
    }

    /// Returns the facts of a condition, or of its negation.
    pub(super) fn of(&mut self, e: ExprId, holds: bool) -> Condition {
        if let Some(known) = self.known.get(&(e, holds)) {
            return known.clone();
        }
        let found = stack::level(|| self.compute(e, holds));
        self.known.insert((e, holds), found.clone());
        found
    }

    fn compute(&mut self, e: ExprId, holds: bool) -> Condition {
        match self.pool.node(e) {
            Node::Literal(Value::Bool(value)) => (value == holds).then(|| [].into()),
            Node::Unary(Unary::Not, a) => self.of(a, !holds),
            Node::Binary(op @ (Binary::And | Binary::Or), a, b) if self.pool.ty(a) == Type::Bool => {
                let (a, b) = (self.of(a, holds), self.of(b, holds));
                if (op == Binary::And) == holds { all(&[a, b]) } else { self.any(&[a, b]) }
            }
            Node::Ite(c, a, b) if self.pool.ty(e) == Type::Bool => {
                let then = all(&[self.of(c, true), self.of(a, holds)]);
                let otherwise = all(&[self.of(c, false), self.of(b, holds)]);
                self.any(&[then, otherwise])
            }
            _ => self.test(e, holds),
        }
    }

    /// Returns the condition that one of several conditions is true.
    pub(super) fn any(&mut self, alternatives: &[Condition]) -> Condition {
        let possible: Vec<&Rc<[Fact]>> = alternatives.iter().flatten().collect();
        match possible.as_slice() {
            [] => None,
            [only] => Some(Rc::clone(only)),
            _ if possible.iter().any(|condition| condition.is_empty()) => Some([].into()),
            _ => {
                let fact = self.fresh();
                self.implied.extend(possible.into_iter().map(|condition| (Rc::clone(condition), fact)));
                Some([fact].into())
            }
        }
    }

    /// Returns the fact of a test of one variable; no facts for other conditions.
    fn test(&mut self, e: ExprId, holds: bool) -> Condition {
        if let Some((variable, [value, high])) = interval(self.pool, e, true)
            && value == high
        {
            return self.value(variable.0, value, holds);
        }
        let support = self.pool.support(e);
        let [variable] = support.as_slice() else { return Some([].into()) };
        let mut state = vec![0; self.program.variables.len()];
        let low = self.program.variables[variable.index()].low;
        let mut passes = vec![false; self.passed[variable.index()].len()];
        for (value, passes) in (low..).zip(&mut passes) {
            state[variable.index()] = value;
            // Where the test has no value, it may count as passed.
            *passes = self.pool.eval(e, &state).is_ok_and(|found| found == Value::Bool(!holds));
            *passes = !*passes;
        }
        match passes.iter().filter(|passes| **passes).count() {
            n if n == passes.len() => Some([].into()),
            0 => None,
            _ => Some([self.of_test(variable.0, passes)].into()),
        }
    }

    fn of_test(&mut self, variable: u32, passes: Vec<bool>) -> Fact {
        if let Some(&known) = self.tests.get(&(variable, passes.clone())) {
            return known;
        }
        let fact = self.fresh();
        for (list, _) in self.passed[variable as usize].iter_mut().zip(&passes).filter(|(_, passes)| **passes)
        {
            list.push(fact);
        }
        self.tests.insert((variable, passes), fact);
        fact
    }

    /// Returns the fact that a variable has a value, or that it has another one.
    pub(super) fn value(&mut self, variable: u32, value: i64, holds: bool) -> Condition {
        let declared = &self.program.variables[variable as usize];
        let lists = self.passed[variable as usize].len();
        let (low, high) = (declared.low, declared.high);
        if !(low..=high).contains(&value) {
            return (!holds).then(|| [].into());
        }
        match lists {
            0 => return Some([].into()),
            1 => return holds.then(|| [].into()),
            // The other one of two values.
            2 if !holds => return self.value(variable, low + high - value, true),
            _ => {}
        }
        if let Some(&known) = self.values.get(&(variable, value, holds)) {
            return Some([known].into());
        }
        let fact = self.fresh();
        let lists = &mut self.passed[variable as usize];
        for (list, _) in lists.iter_mut().zip(low..).filter(|&(_, other)| (other == value) == holds) {
            list.push(fact);
        }
        self.values.insert((variable, value, holds), fact);
        Some([fact].into())
    }

    fn fresh(&mut self) -> Fact {
        self.count += 1;
        self.count - 1
    }

    /// Returns the tests that a variable passes with a value.
    pub(super) fn passed_by(&self, variable: u32, value: i64) -> &[Fact] {
        let low = self.program.variables[variable as usize].low;
        let at = usize::try_from(value.wrapping_sub(low)).ok();
        at.and_then(|at| self.passed[variable as usize].get(at)).map_or(&[], Vec::as_slice)
    }

    /// Returns whether the values of a variable have lists.
    pub(super) fn has_values(&self, variable: u32) -> bool {
        !self.passed[variable as usize].is_empty()
    }
}

/// Returns the condition that all of several conditions are true.
pub(super) fn all(conditions: &[Condition]) -> Condition {
    let mut facts = Vec::new();
    for condition in conditions {
        facts.extend_from_slice(condition.as_deref()?);
    }
    facts.sort_unstable();
    facts.dedup();
    Some(facts.into())
}
