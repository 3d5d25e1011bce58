//! Expressions mean the same as diagrams, as compiled code, folded as constants and by the reference
//! evaluation, in every state.

use meliora::model::value::{EvalError, Type, Value};
use proptest::prelude::*;

use crate::common::prelude::*;

/// The tree of an expression; its types are corrected when it is lowered.
#[derive(Debug, Clone)]
enum Tree {
    Int(i64),
    Real(f64),
    Var(usize),
    Unary(Unary, Box<Tree>),
    Binary(Binary, Box<Tree>, Box<Tree>),
    Ite(Box<Tree>, Box<Tree>, Box<Tree>),
}

/// Reals at which something may go wrong.
const REALS: &[f64] = &[0.5, -1.25, 2.0, 0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, 9.3e18, 0.49999999999999994];

/// Integers at which something may go wrong.
const INTEGERS: &[i64] = &[i64::MAX, i64::MIN, i64::MIN + 1, 1 << 62, (1 << 53) + 1, 63, 64, -1];

fn tree() -> impl Strategy<Value = Tree> {
    let leaf = prop_oneof![
        (-6i64..7).prop_map(Tree::Int),
        proptest::sample::select(REALS).prop_map(Tree::Real),
        proptest::sample::select(INTEGERS).prop_map(Tree::Int),
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
        values: vec![],
        span: 0..0,
    };
    let flag = Variable { ty: Type::Bool, ..int("f", 0, 1) };
    vec![int("x", 0, 5), int("y", -3, 2), flag, int("z", (1 << 53) - 1, 1 << 53)]
}

struct Lowering {
    pool: ExprPool,
    variables: Vec<Variable>,
    /// The values of the variables, where they are to be constants.
    fixed: Option<Vec<i64>>,
}

impl Lowering {
    fn new(fixed: Option<Vec<i64>>) -> Self {
        Lowering { pool: ExprPool::default(), variables: variables(), fixed }
    }

    fn variable(&mut self, index: usize) -> ExprId {
        let ty = self.variables[index].ty;
        match &self.fixed {
            None => self.pool.var(VarId(index as u32), ty),
            Some(values) if ty == Type::Bool => self.pool.value(Value::Bool(values[index] != 0)),
            Some(values) => self.pool.value(Value::Int(values[index])),
        }
    }

    fn as_bool(&mut self, e: ExprId) -> ExprId {
        match self.pool.ty(e) {
            Type::Bool => e,
            ty => {
                let zero = if ty == Type::Int { Value::Int(0) } else { Value::Real(0.0) };
                let zero = self.pool.value(zero);
                self.pool.binary(Binary::Lt, zero, e)
            }
        }
    }

    fn as_int(&mut self, e: ExprId) -> ExprId {
        match self.pool.ty(e) {
            Type::Int => e,
            Type::Real => self.pool.unary(Unary::Floor, e),
            Type::Bool => {
                let (one, zero) = (self.pool.value(Value::Int(1)), self.pool.value(Value::Int(0)));
                self.pool.ite(e, one, zero)
            }
        }
    }

    fn as_real(&mut self, e: ExprId) -> ExprId {
        if self.pool.ty(e) == Type::Real {
            return e;
        }
        let e = self.as_int(e);
        self.pool.unary(Unary::ToReal, e)
    }

    fn lower(&mut self, tree: &Tree) -> ExprId {
        match tree {
            Tree::Int(i) => self.pool.value(Value::Int(*i)),
            Tree::Real(x) => self.pool.value(Value::Real(*x)),
            Tree::Var(v) => self.variable(*v),
            Tree::Unary(op, a) => {
                let a = self.lower(a);
                let a = match op {
                    Unary::Not => self.as_bool(a),
                    Unary::Neg if self.pool.ty(a) != Type::Bool => a,
                    Unary::Neg | Unary::ToReal => self.as_int(a),
                    _ => self.as_real(a),
                };
                self.pool.unary(*op, a)
            }
            Tree::Binary(op, a, b) => {
                let (a, b) = (self.lower(a), self.lower(b));
                let (a, b) = match op {
                    Binary::And | Binary::Or => (self.as_bool(a), self.as_bool(b)),
                    Binary::Div | Binary::Log => (self.as_real(a), self.as_real(b)),
                    Binary::Mod => (self.as_int(a), self.as_int(b)),
                    _ if self.pool.ty(a) == self.pool.ty(b) && self.pool.ty(a) != Type::Bool => (a, b),
                    Binary::Eq if self.pool.ty(a) == self.pool.ty(b) => (a, b),
                    _ => (self.as_real(a), self.as_real(b)),
                };
                self.pool.binary(*op, a, b)
            }
            Tree::Ite(c, a, b) => {
                let (c, a, b) = (self.lower(c), self.lower(a), self.lower(b));
                let c = self.as_bool(c);
                let (a, b) = if self.pool.ty(a) == self.pool.ty(b) {
                    (a, b)
                } else {
                    (self.as_real(a), self.as_real(b))
                };
                self.pool.ite(c, a, b)
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
    Program { kind: ModelKind::Mdp, variables: variables(), ..empty_program(pool, initial) }
}

/// The sets of states of both engines in which a condition holds, as a list over all states; or that
/// some state has no value.
fn answers(program: &Arc<Program>, e: ExprId, states: &[Vec<i64>]) -> [Result<Vec<bool>, Error>; 2] {
    fn of<E: Engine>(engine: &E, e: &Predicate, states: &[Vec<i64>]) -> Result<Vec<bool>, Error> {
        let holds = engine.states_where(e)?;
        Ok(states.iter().map(|s| engine.contains(&holds, s).unwrap()).collect())
    }
    let settings = Settings { scope: Scope::All, memory: 64 << 20, ..Settings::default() };
    let explicit = ExplicitEngine::new(program.clone(), settings.clone()).unwrap();
    let symbolic =
        SymbolicEngine::new(program.clone(), Settings { order: Order::Declared, ..settings }).unwrap();
    let e = program.predicate(e);
    [of(&explicit, &e, states), of(&symbolic, &e, states)]
}

proptest! {
    #![proptest_config(meliora_amount::random(400))]

    #[test]
    fn engines_agree_with_evaluation(tree in tree()) {
        let mut lowering = Lowering::new(None);
        let e = lowering.lower(&tree);
        let condition = lowering.as_bool(e);
        let states = all_states(&lowering.variables);
        // The condition itself, and comparisons of `e` with its values in two states.
        let mut questions = vec![condition];
        for state in [&states[0], &states[states.len() / 2 + 1]] {
            if let Ok(value) = lowering.pool.eval(e, state) {
                let value = lowering.pool.value(value);
                questions.push(lowering.pool.binary(Binary::Eq, e, value));
            }
        }
        let truth = lowering.pool.value(Value::Bool(true));
        let program = Arc::new(program(lowering.pool, truth));
        for question in questions {
            let expected: Result<Vec<bool>, _> =
                states.iter().map(|s| Ok(program.pool.eval(question, s)? == Value::Bool(true))).collect::<Result<_, EvalError>>();
            for (engine, found) in ["explicit", "symbolic"].into_iter().zip(answers(&program, question, &states)) {
                match (&expected, found) {
                    (Ok(expected), Ok(found)) => prop_assert_eq!(&found, expected, "{}", engine),
                    (Err(_), Err(Error::Input(_))) | (_, Err(Error::Limit(_))) => {}
                    (expected, found) => prop_assert!(false, "{}: {:?}, not {:?}", engine, found, expected),
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(meliora_amount::random(2000))]

    #[test]
    fn constants_fold_to_what_evaluation_says(tree in tree(), at in any::<prop::sample::Index>()) {
        let mut lowering = Lowering::new(None);
        let e = lowering.lower(&tree);
        let states = all_states(&lowering.variables);
        let state = at.get(&states);
        let evaluated = lowering.pool.eval(e, state);
        let mut folding = Lowering::new(Some(state.clone()));
        let folded = folding.lower(&tree);
        // An expression without a value stays an operation, and fails for the same reason.
        prop_assert_eq!(folding.pool.literal(folded), evaluated.ok(), "in {:?}", state);
        prop_assert_eq!(folding.pool.eval(folded, &[]), evaluated, "in {:?}", state);
    }
}
