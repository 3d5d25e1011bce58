//! Random programs with objectives: factored ones, and graphs that a program spells out.

use meliora::advanced::lang::ast::Span;
use meliora::model::value::{Type, Value};
use meliora::model::{Branch, Command, CommandId, Synchronisation};
use proptest::prelude::*;

use crate::common::prelude::*;
use crate::planning::generate::order;

/// A program with objectives, statements about them, and which valuations are states.
#[derive(Clone)]
pub(crate) struct World {
    pub(crate) program: Arc<Program>,
    pub(crate) targets: Vec<ExprId>,
    pub(crate) statements: Vec<Statement>,
    pub(crate) scope: Scope,
    /// A condition on every state of a path.
    pub(crate) requirement: Option<ExprId>,
}

impl World {
    /// Forbids the states of the last target outside of the first.
    pub(crate) fn forbidding(self) -> World {
        let mut program = Program::clone(&self.program);
        let (first, last) = (self.targets[0], self.targets[self.targets.len() - 1]);
        let pool = Arc::make_mut(&mut program.pool);
        let outside = pool.unary(Unary::Not, last);
        let requirement = Some(pool.binary(Binary::Or, outside, first));
        World { program: Arc::new(program), requirement, ..self }
    }
}

fn numbers(most: usize) -> impl Strategy<Value = Vec<u16>> {
    prop::collection::vec(0u16..1000, 0..most)
}

fn scope() -> impl Strategy<Value = Scope> {
    prop_oneof![Just(Scope::Reachable), Just(Scope::All)]
}

/// The parts of a factored world.
#[derive(Debug, Clone)]
pub(crate) struct Factored {
    program: Vec<u16>,
    /// Two predicates per objective, which holds where both do.
    objectives: Vec<(Vec<u16>, Vec<u16>)>,
    statements: Vec<Statement>,
    scope: Scope,
}

/// Modules that synchronise, globals, probabilities that may be zero, deadlocks, many initial states.
pub(crate) fn factored() -> impl Strategy<Value = Factored> {
    (1..=4usize).prop_flat_map(|n| {
        let objectives = prop::collection::vec((numbers(12), numbers(12)), n);
        (numbers(160), objectives, order(n), scope()).prop_map(|(program, objectives, statements, scope)| {
            Factored { program, objectives, statements, scope }
        })
    })
}

impl Factored {
    pub(crate) fn world(&self) -> World {
        let mut program = random_program(&self.program, false);
        let mut targets = Vec::new();
        for (first, second) in &self.objectives {
            let both = (random_predicate(&mut program, first), random_predicate(&mut program, second));
            targets.push(Arc::make_mut(&mut program.pool).binary(Binary::And, both.0, both.1));
        }
        let statements = self.statements.clone();
        World { program: Arc::new(program), targets, statements, scope: self.scope, requirement: None }
    }
}

/// The parts of the world of a graph.
#[derive(Debug, Clone)]
pub(crate) struct Graph {
    /// For each node and choice the successors; a node without a choice is a sink.
    nodes: Vec<Vec<Vec<usize>>>,
    initial: Vec<usize>,
    targets: Vec<Vec<usize>>,
    statements: Vec<Statement>,
    scope: Scope,
    /// A node is encoded in two variables, the digits of its number to this base.
    base: usize,
}

/// Sparse graphs with sinks, most edges short.
pub(crate) fn graph(most: usize) -> impl Strategy<Value = Graph> {
    (2..=most, 1..=4usize).prop_flat_map(|(n, objectives)| {
        let successor = prop_oneof![3 => 0..5usize, 1 => 0..n];
        let choice = prop::collection::vec(successor, 1..=3);
        let node = prop_oneof![
            1 => Just(Vec::new()),
            4 => prop::collection::vec(choice, 1..=3),
        ];
        let nodes = prop::collection::vec(node, n);
        let target = prop::collection::vec(0..n, 0..=3);
        let targets = prop::collection::vec(target, objectives);
        let initial = prop::collection::vec(0..n, 1..=3);
        let base = prop_oneof![Just(2usize), Just(5), Just(64)];
        (nodes, initial, targets, order(objectives), scope(), base).prop_map(
            move |(mut nodes, initial, targets, statements, scope, base)| {
                for (from, choices) in nodes.iter_mut().enumerate() {
                    choices.iter_mut().flatten().for_each(|to| *to = (from + *to) % n);
                }
                Graph { nodes, initial, targets, statements, scope, base }
            },
        )
    })
}

impl Graph {
    pub(crate) fn world(&self) -> World {
        let mut pool = ExprPool::default();
        let mut commands: Vec<Command> = Vec::new();
        for (node, choices) in self.nodes.iter().enumerate() {
            for successors in choices {
                let number = commands.len() + 1;
                commands.push(self.command(&mut pool, number, node, successors));
            }
        }
        let initial = self.at(&mut pool, &self.initial);
        let targets = self.targets.iter().map(|t| self.at(&mut pool, t)).collect();
        let all = (0..commands.len() as u32).map(CommandId).collect();
        let program = Program {
            kind: ModelKind::Mdp,
            modules: vec!["m".into()],
            variables: vec![self.variable("high"), self.variable("low")],
            commands,
            synchronisations: vec![Synchronisation { action: None, factors: vec![all] }],
            ..empty_program(pool, initial)
        };
        let (statements, scope) = (self.statements.clone(), self.scope);
        World { program: Arc::new(program), targets, statements, scope, requirement: None }
    }

    fn variable(&self, name: &str) -> Variable {
        let high = if name == "high" { (self.nodes.len() - 1) / self.base } else { self.base - 1 };
        Variable {
            name: name.into(),
            ty: Type::Int,
            low: 0,
            high: high as i64,
            module: Some(0),
            initial: None,
            values: vec![],
            span: 0..0,
        }
    }

    fn digits(&self, node: usize) -> [(VarId, i64); 2] {
        [(VarId(0), (node / self.base) as i64), (VarId(1), (node % self.base) as i64)]
    }

    /// One branch per successor, equally likely, and one to the next node that never happens.
    fn command(&self, pool: &mut ExprPool, number: usize, node: usize, successors: &[usize]) -> Command {
        let chance = 1.0 / successors.len() as f64;
        let never = [((node + 1) % self.nodes.len(), 0.0)];
        let ways = successors.iter().map(|&to| (to, chance)).chain(never);
        let branches = ways.map(|(to, p)| {
            let probability = pool.value(Value::Real(p));
            let updates = self.digits(to).map(|(v, digit)| (v, pool.value(Value::Int(digit))));
            Branch { probability, updates: updates.into() }
        });
        let branches = branches.collect();
        let guard = self.at(pool, &[node]);
        Command { module: 0, action: None, number, unlisted: None, guard, branches, span: Span::default() }
    }

    /// The expression that holds in these nodes.
    fn at(&self, pool: &mut ExprPool, nodes: &[usize]) -> ExprId {
        let mut some = pool.value(Value::Bool(false));
        for &node in nodes {
            let [high, low] = self.digits(node).map(|(v, digit)| {
                let (v, digit) = (pool.var(v, Type::Int), pool.value(Value::Int(digit)));
                pool.binary(Binary::Eq, v, digit)
            });
            let here = pool.binary(Binary::And, high, low);
            some = pool.binary(Binary::Or, some, here);
        }
        some
    }
}
