//! Small random programs from a sequence of numbers: shorter sequences and smaller numbers give
//! simpler programs, so that a failing one shrinks well.

use meliora::advanced::lang::ast::Span;
use meliora::model::value::{Type, Value};
use meliora::model::{Branch, Command, CommandId, Synchronisation};

use crate::common::prelude::*;

/// A program of an `mdp` without variables, to be filled.
pub(crate) fn empty_program(pool: ExprPool, initial: ExprId) -> Program {
    Program {
        source: SourceFile::new("random", ""),
        kind: ModelKind::Mdp,
        pool: pool.into(),
        variables: vec![],
        initial,
        constants: vec![],
        given_constants: vec![],
        labels: vec![],
        formulas: vec![],
        rewards: Vec::new(),
        inexact: None,
        monitors: None,
        stop: None,
        planning: None,
        players: None,
        modules: vec![],
        actions: vec![],
        commands: vec![],
        synchronisations: vec![],
    }
}

/// Numbers that are used up one by one; 0 after the last.
struct Source<'a> {
    numbers: std::slice::Iter<'a, u16>,
}

impl Source<'_> {
    /// A number below `n`.
    fn below(&mut self, n: usize) -> usize {
        usize::from(self.numbers.next().copied().unwrap_or(0)) % n.max(1)
    }

    fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == n - 1
    }
}

struct Builder<'a> {
    source: Source<'a>,
    pool: ExprPool,
    variables: Vec<Variable>,
    /// True if updates may leave their range and probabilities may be wrong.
    faulty: bool,
}

/// A program with up to four variables of up to four values, up to three modules and two labels.
///
/// With `faulty` some updates leave their range, some probabilities do not sum to one and some
/// expressions have no value; else everything is in order.
pub(crate) fn random_program(numbers: &[u16], faulty: bool) -> Program {
    let source = Source { numbers: numbers.iter() };
    let mut b = Builder { source, pool: ExprPool::default(), variables: Vec::new(), faulty };
    let kind = if b.source.one_in(4) { ModelKind::Dtmc } else { ModelKind::Mdp };
    let modules = 1 + b.source.below(3);
    for index in 0..1 + b.source.below(4) {
        let variable = b.variable(index, modules);
        b.variables.push(variable);
    }
    let actions = b.source.below(3);
    let mut commands = Vec::new();
    for module in 0..modules {
        for _ in 0..b.source.below(4) {
            commands.push(b.command(module, actions));
        }
    }
    let initial = b.initial();
    let synchronisations = synchronisations(&mut commands, modules, actions);
    let literal = b.pool.value(Value::Bool(true));
    Program {
        kind,
        labels: vec![("true".into(), literal)],
        modules: (0..modules).map(|m| format!("m{m}")).collect(),
        actions: (0..actions).map(|a| format!("a{a}")).collect(),
        variables: b.variables,
        commands,
        synchronisations,
        ..empty_program(b.pool, initial)
    }
}

/// A Boolean expression over the variables of a program, total.
pub(crate) fn random_predicate(program: &mut Program, numbers: &[u16]) -> ExprId {
    let mut b = Builder {
        source: Source { numbers: numbers.iter() },
        pool: std::mem::take(Arc::make_mut(&mut program.pool)),
        variables: program.variables.clone(),
        faulty: false,
    };
    let e = b.condition(3);
    program.pool = b.pool.into();
    e
}

fn synchronisations(commands: &mut [Command], modules: usize, actions: usize) -> Vec<Synchronisation> {
    let mut all = Vec::new();
    for action in std::iter::once(None).chain((0..actions).map(Some)) {
        let mut factors = Vec::new();
        for module in 0..modules {
            let own: Vec<usize> = (0..commands.len())
                .filter(|&c| commands[c].module == module && commands[c].action == action)
                .collect();
            for (number, &c) in own.iter().enumerate() {
                commands[c].number = number + 1;
            }
            let factor: Vec<CommandId> = own.into_iter().map(|c| CommandId(c as u32)).collect();
            match (factor.is_empty(), action) {
                (true, _) => {}
                (false, None) => all.push(Synchronisation { action, factors: vec![factor] }),
                (false, Some(_)) => factors.push(factor),
            }
        }
        if !factors.is_empty() {
            all.push(Synchronisation { action, factors });
        }
    }
    all
}

impl Builder<'_> {
    fn variable(&mut self, index: usize, modules: usize) -> Variable {
        let is_bool = self.source.one_in(3);
        let low = if is_bool { 0 } else { self.source.below(3) as i64 - 1 };
        let high = if is_bool { 1 } else { low + [1, 0, 2, 3][self.source.below(4)] };
        let owner = self.source.below(modules + 1);
        Variable {
            name: format!("v{index}"),
            ty: if is_bool { Type::Bool } else { Type::Int },
            low,
            high,
            module: (owner < modules).then_some(owner),
            initial: None,
            values: vec![],
            span: 0..0,
        }
    }

    /// Either one value for each variable, or a condition that may hold in many states.
    fn initial(&mut self) -> ExprId {
        if self.source.one_in(3) {
            return self.condition(2);
        }
        let mut all = self.pool.value(Value::Bool(true));
        for index in 0..self.variables.len() {
            let value = self.variables[index].low;
            let is = self.is(index, value);
            all = self.pool.binary(Binary::And, all, is);
        }
        all
    }

    fn command(&mut self, module: usize, actions: usize) -> Command {
        let action = self.source.below(actions + 1).checked_sub(1);
        let guard = self.condition(2);
        let probabilities = self.probabilities();
        let branches = probabilities.into_iter().map(|p| self.branch(module, action, p)).collect();
        Command { module, action, number: 0, unlisted: None, guard, branches, span: Span::default() }
    }

    fn probabilities(&mut self) -> Vec<ExprId> {
        let constants: &[f64] = match self.source.below(if self.faulty { 9 } else { 7 }) {
            0 => &[1.0],
            1 => &[0.5, 0.5],
            2 => &[0.0, 1.0],
            3 => &[0.25, 0.0, 0.75],
            4 | 5 | 7 => return self.varying_probabilities(),
            6 => &[0.1, 0.2, 0.3, 0.4],
            _ => &[0.5, 0.4],
        };
        constants.iter().map(|&p| self.pool.value(Value::Real(p))).collect()
    }

    /// p and 1 - p, where p is sometimes 0 or 1 and, in faulty programs, sometimes worse.
    fn varying_probabilities(&mut self) -> Vec<ExprId> {
        let condition = self.condition(1);
        let value = |b: &mut Self| {
            let all: &[f64] = if b.faulty { &[0.0, 0.5, 1.0, 1.5] } else { &[0.0, 0.5, 1.0] };
            all[b.source.below(all.len())]
        };
        let (then, otherwise) = (value(self), value(self));
        let (then, otherwise) = (self.pool.value(Value::Real(then)), self.pool.value(Value::Real(otherwise)));
        let p = self.pool.ite(condition, then, otherwise);
        let one = self.pool.value(Value::Real(1.0));
        let q = self.pool.binary(Binary::Sub, one, p);
        vec![p, q]
    }

    /// Labelled commands write the variables of their module only.
    fn branch(&mut self, module: usize, action: Option<usize>, probability: ExprId) -> Branch {
        let mut updates = Vec::new();
        for index in 0..self.variables.len() {
            let owner = self.variables[index].module;
            let writable = owner == Some(module) || (owner.is_none() && action.is_none());
            if writable && self.source.below(3) > 0 {
                updates.push((VarId(index as u32), self.update(index)));
            }
        }
        Branch { probability, updates: updates.into() }
    }

    fn update(&mut self, index: usize) -> ExprId {
        let Variable { ty, low, high, .. } = self.variables[index];
        if ty == Type::Bool {
            return self.condition(1);
        }
        match self.source.below(if self.faulty { 8 } else { 5 }) {
            0 => {
                let value = low + self.source.below((high - low + 1) as usize) as i64;
                self.int(value)
            }
            1 | 2 => {
                let e = self.integer(1);
                let (low, high) = (self.int(low), self.int(high));
                let e = self.pool.binary(Binary::Max, e, low);
                self.pool.binary(Binary::Min, e, high)
            }
            3 | 4 => {
                let e = self.integer(1);
                let n = self.int(high - low + 1);
                let low = self.int(low);
                let e = self.pool.binary(Binary::Mod, e, n);
                self.pool.binary(Binary::Add, low, e)
            }
            _ => self.integer(1),
        }
    }

    fn condition(&mut self, depth: usize) -> ExprId {
        if depth == 0 || self.source.one_in(4) {
            let index = self.source.below(self.variables.len());
            let Variable { low, high, .. } = self.variables[index];
            let value = low + self.source.below((high - low + 1) as usize) as i64;
            return self.is(index, value);
        }
        match self.source.below(6) {
            0 => self.pool.value(Value::Bool(true)),
            1 => self.join(depth, Binary::And),
            2 => self.join(depth, Binary::Or),
            3 => {
                let e = self.condition(depth - 1);
                self.pool.unary(Unary::Not, e)
            }
            4 => {
                let (a, b) = (self.integer(depth - 1), self.integer(depth - 1));
                let op = [Binary::Lt, Binary::Le, Binary::Eq][self.source.below(3)];
                self.pool.binary(op, a, b)
            }
            _ => {
                let (c, a) = (self.condition(depth - 1), self.condition(depth - 1));
                let b = self.condition(depth - 1);
                self.pool.ite(c, a, b)
            }
        }
    }

    fn join(&mut self, depth: usize, op: Binary) -> ExprId {
        let (a, b) = (self.condition(depth - 1), self.condition(depth - 1));
        self.pool.binary(op, a, b)
    }

    fn integer(&mut self, depth: usize) -> ExprId {
        let kind = self.source.below(if depth == 0 { 2 } else { 8 });
        match kind {
            0 => {
                let value = self.source.below(5) as i64 - 1;
                self.int(value)
            }
            1 => self.any_variable(),
            2..=5 => {
                let op = [Binary::Add, Binary::Sub, Binary::Mul, Binary::Max][kind - 2];
                let (a, b) = (self.integer(depth - 1), self.integer(depth - 1));
                self.pool.binary(op, a, b)
            }
            6 if self.faulty => {
                let (a, b) = (self.integer(depth - 1), self.any_variable());
                self.pool.binary(Binary::Mod, a, b)
            }
            _ => {
                let c = self.condition(depth - 1);
                let (a, b) = (self.integer(depth - 1), self.integer(depth - 1));
                self.pool.ite(c, a, b)
            }
        }
    }

    /// A variable as an integer.
    fn any_variable(&mut self) -> ExprId {
        let index = self.source.below(self.variables.len());
        let ty = self.variables[index].ty;
        let v = self.pool.var(VarId(index as u32), ty);
        if ty == Type::Int {
            return v;
        }
        let (one, zero) = (self.int(1), self.int(0));
        self.pool.ite(v, one, zero)
    }

    fn is(&mut self, index: usize, value: i64) -> ExprId {
        let ty = self.variables[index].ty;
        let v = self.pool.var(VarId(index as u32), ty);
        match (ty, value) {
            (Type::Bool, 0) => self.pool.unary(Unary::Not, v),
            (Type::Bool, _) => v,
            _ => {
                let value = self.int(value);
                self.pool.binary(Binary::Eq, v, value)
            }
        }
    }

    fn int(&mut self, value: i64) -> ExprId {
        self.pool.value(Value::Int(value))
    }
}
