//! Expressions as diagrams mean what the reference evaluation says, in every state.

use std::sync::Arc;

use meliora::engine::symbolic::{SymbolicEngine, order};
use meliora::engine::{Engine, Scope, Settings};
use meliora::error::{Error, SourceFile};
use meliora::model::expr::{Binary, ExprId, ExprPool, Unary};
use meliora::model::value::{Type, Value};
use meliora::model::{ModelKind, Program, VarId, Variable};
use proptest::prelude::*;

/// What an expression is built from; the types are made right when it is lowered.
#[derive(Debug, Clone)]
enum Tree {
    Int(i64),
    Real(f64),
    Var(usize),
    Unary(Unary, Box<Tree>),
    Binary(Binary, Box<Tree>, Box<Tree>),
    Ite(Box<Tree>, Box<Tree>, Box<Tree>),
}

fn tree() -> impl Strategy<Value = Tree> {
    let leaf = prop_oneof![
        (-6i64..7).prop_map(Tree::Int),
        prop_oneof![Just(0.5), Just(-1.25), Just(2.0), Just(0.0)].prop_map(Tree::Real),
        Just(Tree::Int(i64::MAX)),
        (0usize..4).prop_map(Tree::Var),
        (0usize..4).prop_map(Tree::Var),
    ];
    let unary = prop_oneof![
        Just(Unary::Not),
        Just(Unary::Neg),
        Just(Unary::Floor),
        Just(Unary::Ceil),
        Just(Unary::Round),
        Just(Unary::ToReal)
    ];
    use Binary::*;
    let binary = prop_oneof![
        Just(And),
        Just(Or),
        Just(Eq),
        Just(Lt),
        Just(Le),
        Just(Add),
        Just(Sub),
        Just(Mul),
        Just(Div),
        Just(Min),
        Just(Max),
        Just(Pow),
        Just(Mod),
        Just(Log)
    ];
    leaf.prop_recursive(5, 24, 3, move |inner| {
        prop_oneof![
            (unary.clone(), inner.clone()).prop_map(|(op, a)| Tree::Unary(op, Box::new(a))),
            (binary.clone(), inner.clone(), inner.clone()).prop_map(|(op, a, b)| Tree::Binary(
                op,
                Box::new(a),
                Box::new(b)
            )),
            (inner.clone(), inner.clone(), inner).prop_map(|(c, a, b)| Tree::Ite(
                Box::new(c),
                Box::new(a),
                Box::new(b)
            )),
        ]
    })
}

fn variables() -> Vec<Variable> {
    let int = |name: &str, low, high| Variable {
        name: name.into(),
        ty: Type::Int,
        low,
        high,
        module: None,
        initial: Some(low),
        span: 0..0,
    };
    let flag = Variable { ty: Type::Bool, ..int("f", 0, 1) };
    vec![int("x", 0, 5), int("y", -3, 2), flag, int("z", 7, 7)]
}

struct Lowering {
    pool: ExprPool,
    variables: Vec<Variable>,
}

impl Lowering {
    fn as_bool(&mut self, e: ExprId) -> Option<ExprId> {
        match self.pool.ty(e) {
            Type::Bool => Some(e),
            ty => {
                let zero = if ty == Type::Int { Value::Int(0) } else { Value::Real(0.0) };
                let zero = self.pool.value(zero);
                self.pool.binary(Binary::Lt, zero, e).ok()
            }
        }
    }

    fn as_int(&mut self, e: ExprId) -> Option<ExprId> {
        match self.pool.ty(e) {
            Type::Int => Some(e),
            Type::Real => self.pool.unary(Unary::Floor, e).ok(),
            Type::Bool => {
                let (one, zero) = (self.pool.value(Value::Int(1)), self.pool.value(Value::Int(0)));
                Some(self.pool.ite(e, one, zero))
            }
        }
    }

    fn as_real(&mut self, e: ExprId) -> Option<ExprId> {
        if self.pool.ty(e) == Type::Real {
            return Some(e);
        }
        let e = self.as_int(e)?;
        self.pool.unary(Unary::ToReal, e).ok()
    }

    /// None where folding of literals already fails.
    fn lower(&mut self, tree: &Tree) -> Option<ExprId> {
        match tree {
            Tree::Int(i) => Some(self.pool.value(Value::Int(*i))),
            Tree::Real(x) => Some(self.pool.value(Value::Real(*x))),
            Tree::Var(v) => Some(self.pool.var(VarId(*v as u32), self.variables[*v].ty)),
            Tree::Unary(op, a) => {
                let a = self.lower(a)?;
                let a = match op {
                    Unary::Not => self.as_bool(a)?,
                    Unary::Neg if self.pool.ty(a) != Type::Bool => a,
                    Unary::Neg | Unary::ToReal => self.as_int(a)?,
                    _ => self.as_real(a)?,
                };
                self.pool.unary(*op, a).ok()
            }
            Tree::Binary(op, a, b) => {
                let (a, b) = (self.lower(a)?, self.lower(b)?);
                let (a, b) = match op {
                    Binary::And | Binary::Or => (self.as_bool(a)?, self.as_bool(b)?),
                    Binary::Div | Binary::Log => (self.as_real(a)?, self.as_real(b)?),
                    Binary::Mod => (self.as_int(a)?, self.as_int(b)?),
                    _ if self.pool.ty(a) == self.pool.ty(b) && self.pool.ty(a) != Type::Bool => (a, b),
                    Binary::Eq if self.pool.ty(a) == self.pool.ty(b) => (a, b),
                    _ => (self.as_real(a)?, self.as_real(b)?),
                };
                self.pool.binary(*op, a, b).ok()
            }
            Tree::Ite(c, a, b) => {
                let (c, a, b) = (self.lower(c)?, self.lower(a)?, self.lower(b)?);
                let c = self.as_bool(c)?;
                let (a, b) = if self.pool.ty(a) == self.pool.ty(b) {
                    (a, b)
                } else {
                    (self.as_real(a)?, self.as_real(b)?)
                };
                Some(self.pool.ite(c, a, b))
            }
        }
    }
}

/// All valuations, the first variable slowest.
fn all_states(variables: &[Variable]) -> Vec<Vec<i64>> {
    let mut states = vec![vec![]];
    for v in variables {
        states = states
            .iter()
            .flat_map(|s| (v.low..=v.high).map(move |x| [s.clone(), vec![x]].concat()))
            .collect();
    }
    states
}

fn program(pool: ExprPool, initial: ExprId) -> Program {
    Program {
        source: Arc::new(SourceFile { name: "test".into(), text: String::new() }),
        kind: ModelKind::Mdp,
        constants: vec![],
        given_constants: vec![],
        pool,
        variables: variables(),
        modules: vec![],
        initial,
        actions: vec![],
        commands: vec![],
        synchronisations: vec![],
        labels: vec![],
        formulas: vec![],
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn diagrams_agree_with_evaluation(tree in tree()) {
        let mut lowering = Lowering { pool: ExprPool::default(), variables: variables() };
        let Some(e) = lowering.lower(&tree) else { return Ok(()) };
        let Some(e) = lowering.as_bool(e) else { return Ok(()) };
        let truth = lowering.pool.value(Value::Bool(true));
        let program = Arc::new(program(lowering.pool, truth));
        let settings = Settings { scope: Scope::All, memory: 64 << 20, ..Settings::default() };
        let engine = SymbolicEngine::new(program.clone(), order::declared(&program), 1, settings).unwrap();
        let states = all_states(&program.variables);
        let expected: Vec<_> = states.iter().map(|s| program.pool.eval(e, s)).collect();
        match engine.states_where(e) {
            Err(Error::Input(_)) => prop_assert!(expected.iter().any(Result::is_err), "no state fails"),
            Err(error) => prop_assert!(matches!(error, Error::Limit(_)), "{error}"),
            Ok(holds) => {
                for (state, value) in states.iter().zip(&expected) {
                    let expected = *value == Ok(Value::Bool(true));
                    prop_assert!(value.is_ok(), "{:?} fails in {:?}", tree, state);
                    prop_assert_eq!(engine.contains(&holds, state), expected, "{:?}", state);
                }
            }
        }
    }
}
