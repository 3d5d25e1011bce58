//! Checks the monitors against the definition of LTL on ultimately periodic words.

use std::sync::Arc;

use proptest::prelude::*;

use crate::ast::{BinaryOp, Expr, Node as Part, NodeKind, Span};
use crate::ltl::normaliser::{Meaning, Normaliser};
use crate::ltl::{Formula, FormulaKind, Steps, parse_formula};
use meliora_amount::share;
use meliora_base::error::{Error, Limit, Result, SourceFile};
use meliora_base::value::{Type, Value};
use meliora_ltl::{Form, Formulas, Leaf, Monitor, Tree, leaves};
use meliora_model::VarId;
use meliora_model::expr::{Binary, ExprId, ExprPool, Node, Unary};
use meliora_model::temporal::Asks;

/// A lasso: the letters up to the end of the loop, and the start of the loop. Bit k of a letter is
/// the value of atom k.
#[derive(Debug, Clone)]
struct Word {
    letters: Vec<u8>,
    back: usize,
}

impl Word {
    fn after(&self, at: usize) -> usize {
        if at + 1 < self.letters.len() { at + 1 } else { self.back }
    }
}

pub(super) fn state(atom: u8) -> Formula {
    let name = NodeKind::Name(char::from(b'a' + atom).to_string().into());
    made(FormulaKind::State(Expr::new(name, Span::default())))
}

pub(super) fn made(kind: FormulaKind) -> Formula {
    Formula { kind, span: Span::default() }
}

fn number(n: u64) -> Option<(Expr, bool)> {
    Some((Expr::new(NodeKind::Literal(Value::Int(n as i64)), Span::default()), false))
}

/// Returns the value of a formula at each position: the definition of LTL.
fn meaning(f: &Formula, word: &Word) -> Vec<bool> {
    let n = word.letters.len();
    let each = |f: &dyn Fn(usize) -> bool| (0..n).map(f).collect::<Vec<bool>>();
    match &f.kind {
        FormulaKind::Known(_) | FormulaKind::Nested(_) => unreachable!("no formula here is lowered"),
        FormulaKind::State(e) => {
            let [Part { kind: NodeKind::Name(name), .. }] = e.nodes.as_slice() else { panic!("{e:?}") };
            let bit = name.as_bytes()[0] - b'a';
            each(&|i| word.letters[i] >> bit & 1 == 1)
        }
        FormulaKind::Not(a) => meaning(a, word).iter().map(|v| !v).collect(),
        FormulaKind::And(all) => {
            all.iter().map(|a| meaning(a, word)).reduce(|x, y| each(&|i| x[i] && y[i])).unwrap()
        }
        FormulaKind::Or(all) => {
            all.iter().map(|a| meaning(a, word)).reduce(|x, y| each(&|i| x[i] || y[i])).unwrap()
        }
        FormulaKind::Implies(a, b) => {
            let (a, b) = (meaning(a, word), meaning(b, word));
            each(&|i| !a[i] || b[i])
        }
        FormulaKind::Iff(a, b) => {
            let (a, b) = (meaning(a, word), meaning(b, word));
            each(&|i| a[i] == b[i])
        }
        FormulaKind::Next(a) => {
            let a = meaning(a, word);
            each(&|i| a[word.after(i)])
        }
        FormulaKind::Eventually(steps, a) => until(steps, &vec![true; n], &meaning(a, word), word),
        FormulaKind::Always(steps, a) => {
            let not: Vec<bool> = meaning(a, word).iter().map(|v| !v).collect();
            until(steps, &vec![true; n], &not, word).iter().map(|v| !v).collect()
        }
        FormulaKind::Until(steps, a, b) => until(steps, &meaning(a, word), &meaning(b, word), word),
        FormulaKind::Weak(_, a, b) => {
            let (a, b) = (meaning(a, word), meaning(b, word));
            let both = until(&Steps::default(), &a, &b, word);
            each(&|i| both[i] || walk(i, word, 2 * n).all(|j| a[j]))
        }
        FormulaKind::Release(_, a, b) => {
            let not = |x: Vec<bool>| x.into_iter().map(|v| !v).collect::<Vec<bool>>();
            not(until(&Steps::default(), &not(meaning(a, word)), &not(meaning(b, word)), word))
        }
        FormulaKind::Strong(a, b) => {
            let (a, b) = (meaning(a, word), meaning(b, word));
            until(&Steps::default(), &b, &each(&|i| a[i] && b[i]), word)
        }
    }
}

/// Returns the positions from `from` on.
fn walk(from: usize, word: &Word, steps: usize) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(from), |&i| Some(word.after(i))).take(steps)
}

fn steps_of(e: &Expr) -> u64 {
    match e.nodes.as_slice() {
        [Part { kind: NodeKind::Literal(Value::Int(n)), .. }] => *n as u64,
        _ => panic!("bounds are numbers"),
    }
}

fn until(steps: &Steps, a: &[bool], b: &[bool], word: &Word) -> Vec<bool> {
    let value = |bound: &Option<(Expr, bool)>| bound.as_ref().map(|(e, _)| steps_of(e) as usize);
    let (least, most) = (value(&steps.least).unwrap_or(0), value(&steps.most));
    let horizon = most.map_or(least + 2 * a.len() + 1, |m| m + 1);
    let holds = |i| {
        for (step, j) in walk(i, word, horizon).enumerate() {
            if step >= least && b[j] {
                return true;
            }
            if !a[j] {
                return false;
            }
        }
        false
    };
    (0..a.len()).map(holds).collect()
}

/// Atoms are Boolean variables without a program.
pub(super) struct Atoms {
    pub(super) pool: ExprPool,
    source: Arc<SourceFile>,
}

impl Atoms {
    pub(super) fn new() -> Self {
        Atoms { pool: ExprPool::default(), source: SourceFile::new("formula", "") }
    }
}

impl Meaning for Atoms {
    fn state(&mut self, e: &Expr) -> Result<ExprId> {
        let mut stack: Vec<ExprId> = Vec::new();
        for node in &e.nodes {
            let operands = stack.split_off(stack.len() - node.kind.operands());
            stack.push(match (&node.kind, operands.as_slice()) {
                (NodeKind::Name(name), _) => {
                    self.pool.var(VarId(u32::from(name.as_bytes()[0] - b'a')), Type::Bool)
                }
                (NodeKind::Not, [operand]) => self.pool.unary(Unary::Not, *operand),
                (NodeKind::Join(op, _), [first, rest @ ..]) => {
                    let op = if *op == BinaryOp::And { Binary::And } else { Binary::Or };
                    rest.iter().fold(*first, |all, &e| self.pool.binary(op, all, e))
                }
                _ => panic!("atoms are names"),
            });
        }
        Ok(stack[0])
    }

    fn bound(&mut self, e: &Expr) -> Result<u64> {
        Ok(steps_of(e))
    }

    fn literal(&mut self, mut e: ExprId, mut positive: bool) -> Form {
        while let Node::Unary(Unary::Not, inner) = self.pool.node(e) {
            (e, positive) = (inner, !positive);
        }
        match self.pool.literal(e) {
            Some(Value::Bool(value)) => Form::Constant(value == positive),
            _ => Form::Literal(e, positive),
        }
    }

    fn fold(&mut self, conjunction: bool, literals: &[(ExprId, bool)]) -> Form {
        let op = if conjunction { Binary::And } else { Binary::Or };
        let mut all = self.pool.value(Value::Bool(conjunction));
        for &(e, positive) in literals {
            let e = if positive { e } else { self.pool.unary(Unary::Not, e) };
            all = self.pool.binary(op, all, e);
        }
        self.literal(all, true)
    }

    fn source(&self) -> &Arc<SourceFile> {
        &self.source
    }
}

/// A formula with its monitors.
pub(super) struct Judge {
    tree: Tree,
    monitors: Vec<Monitor>,
    pool: ExprPool,
}

impl Judge {
    pub(super) fn new(f: &Formula) -> std::result::Result<Self, Error> {
        let (mut atoms, mut all) = (Atoms::new(), Formulas::new());
        let normal = Normaliser::new(&mut atoms, &mut all).build(f, true)?;
        let tree = leaves(&mut all, normal).map_err(|found| found.limit)?;
        let monitors = all_leaves(&tree).into_iter().map(|leaf| Monitor::owing(&all, leaf.watched));
        Ok(Judge { monitors: monitors.collect::<Result<_>>()?, tree, pool: atoms.pool })
    }

    /// Returns the number of states of each different monitor.
    pub(super) fn sizes(&self) -> Vec<usize> {
        let different = |&(at, monitor): &(usize, &Monitor)| {
            !self.monitors[..at].iter().any(|other| other.is_same(monitor))
        };
        self.monitors.iter().enumerate().filter(different).map(|(_, m)| m.states.len()).collect()
    }

    fn holds(&self, word: &Word) -> bool {
        let mut marked = self.monitors.iter().map(|o| self.marked(o, word));
        Self::truth(&self.tree, &mut marked)
    }

    fn truth(tree: &Tree, marked: &mut dyn Iterator<Item = bool>) -> bool {
        match tree {
            Tree::Constant(value) => *value,
            Tree::Leaf(Leaf { asks: Asks::Accept | Asks::Again, .. }) => marked.next().unwrap(),
            Tree::Leaf(_) => !marked.next().unwrap(),
            // Every operand is evaluated: each consumes its own marks.
            Tree::All(parts) => parts.iter().map(|p| Self::truth(p, marked)).fold(true, |x, y| x & y),
            Tree::Any(parts) => parts.iter().map(|p| Self::truth(p, marked)).fold(false, |x, y| x | y),
        }
    }

    /// Returns true if the loop of the word has marks after the monitor has entered a cycle.
    fn marked(&self, monitor: &Monitor, word: &Word) -> bool {
        let (mut at, mut state) = (0, 0);
        let mut seen: Vec<(usize, usize, bool)> = Vec::new();
        loop {
            if let Some(first) = seen.iter().position(|&(a, s, _)| (a, s) == (at, state)) {
                return seen[first..].iter().any(|s| s.2);
            }
            let values: Vec<i64> = (0..3).map(|bit| i64::from(word.letters[at] >> bit & 1)).collect();
            let (next, mark) =
                monitor.step(state, |e| self.pool.eval(e, &values).unwrap() == Value::Bool(true));
            seen.push((at, state, mark));
            (at, state) = (word.after(at), next);
        }
    }
}

fn all_leaves(tree: &Tree) -> Vec<Leaf> {
    match tree {
        Tree::Constant(_) => Vec::new(),
        Tree::Leaf(leaf) => vec![*leaf],
        Tree::All(parts) | Tree::Any(parts) => parts.iter().flat_map(all_leaves).collect(),
    }
}

/// Returns all words over two atoms with at most `most` letters.
fn words(most: usize) -> Vec<Word> {
    let mut all = Vec::new();
    for length in 1..=most {
        for code in 0..4usize.pow(length as u32) {
            let letters: Vec<u8> = (0..length).map(|i| (code >> (2 * i) & 3) as u8).collect();
            all.extend((0..length).map(|back| Word { letters: letters.clone(), back }));
        }
    }
    all
}

/// Returns all formulas with `size` operators.
fn formulas(size: usize) -> Vec<Formula> {
    if size == 0 {
        return vec![state(0), state(1)];
    }
    let mut all = Vec::new();
    for a in formulas(size - 1) {
        let a = || Box::new(a.clone());
        let bounded = Steps { least: None, most: number(1) };
        all.push(made(FormulaKind::Not(a())));
        all.push(made(FormulaKind::Next(a())));
        all.push(made(FormulaKind::Eventually(Steps::default(), a())));
        all.push(made(FormulaKind::Always(Steps::default(), a())));
        all.push(made(FormulaKind::Always(bounded, a())));
    }
    for left in 0..size {
        for a in formulas(left) {
            for b in formulas(size - 1 - left) {
                let (a, b) = (Box::new(a.clone()), Box::new(b));
                all.push(made(FormulaKind::And(vec![(*a).clone(), (*b).clone()])));
                all.push(made(FormulaKind::Until(Steps::default(), a.clone(), b.clone())));
                all.push(made(FormulaKind::Weak(Steps::default(), a.clone(), b.clone())));
                all.push(made(FormulaKind::Release(Steps::default(), a, b)));
            }
        }
    }
    all
}

/// Compares a formula on words.
fn agrees(f: &Formula, words: &[Word]) {
    let judge = Judge::new(f).unwrap();
    for word in words {
        assert_eq!(judge.holds(word), meaning(f, word)[0], "{f:?} on {word:?}");
    }
}

#[test]
fn monitors_are_right_for_all_formulas_of_up_to_two_operators() {
    let words = words(4);
    for size in 0..=2 {
        let all = formulas(size);
        all.iter().for_each(|f| agrees(f, &words));
        assert_eq!(all.len(), [2, 26, 546][size]);
    }
}

#[test]
fn monitors_are_right_for_some_formulas_of_three_operators() {
    let words = words(3);
    let all = formulas(3);
    // One of five; with fewer cases, one of 25.
    let step = 5 * all.len().div_ceil(share(all.len()));
    all.iter().step_by(step).for_each(|f| agrees(f, &words));
    assert_eq!(all.len(), 14_170);
}

#[test]
fn a_step_before_what_recurs_counts_where_it_matters() {
    let words = words(3);
    for text in [
        "X G F a",
        "X F G a",
        "X G (a => F b)",
        "X F (a & G b)",
        "X F (a W b)",
        "X X G (a | X F b)",
        "X ((G F a) & (G (a => F b)))",
        "X ((F G a) | (F (a & G b)))",
    ] {
        let f = parse_formula(&SourceFile::new("formula", text)).unwrap();
        agrees(&f, &words);
    }
}

#[test]
fn monitors_of_common_formulas_are_small() {
    let states = |text: &str| {
        let f = parse_formula(&SourceFile::new("formula", text)).unwrap();
        let judge = Judge::new(&f).unwrap();
        judge.sizes()
    };
    for (text, expected) in [
        ("F a", vec![2]),
        ("G a", vec![2]),
        ("G F a", vec![1]),
        ("F G a", vec![1]),
        ("F (a & F b)", vec![3]),
        ("!c U b", vec![3]),
        ("G (a => F b)", vec![2]),
        ("F (a & G b)", vec![2]),
        ("F<=3 a", vec![6]),
        ("G (a => F<=20 b)", vec![22]),
        ("G (a => (F<=9 (b & F<=9 a)))", vec![56]),
        ("(F a) | (F b)", vec![2]),
        ("(F a) & (F b)", vec![2, 2]),
        ("(G F a) & (G F b)", vec![1, 1]),
        ("X X X a", vec![6]),
        ("a U (G b)", vec![3]),
        ("G (a => (b U (G c)))", vec![4, 1, 2]),
        ("(F a) W b", vec![4]),
        ("F (!a <=> G !a)", vec![1, 2]),
        ("!(F (!a <=> G !a))", vec![1]),
        ("G F (a & X G b)", vec![1, 1]),
        ("F<=2 (G F a)", vec![1]),
    ] {
        assert_eq!(states(text), expected, "{text}");
    }
}

fn steps() -> impl Strategy<Value = Steps> {
    prop_oneof![
        3 => Just(Steps::default()),
        1 => (0u64..4).prop_map(|m| Steps { least: None, most: number(m) }),
        1 => (0u64..3, 0u64..3).prop_map(|(l, m)| Steps { least: number(l), most: number(l + m) }),
        1 => (0u64..3).prop_map(|l| Steps { least: number(l), most: None }),
    ]
}

fn formula() -> impl Strategy<Value = Formula> {
    (0u8..3).prop_map(state).prop_recursive(6, 14, 3, |inner| {
        let one = || inner.clone().prop_map(Box::new);
        let list = || prop::collection::vec(inner.clone(), 2..4);
        prop_oneof![
            one().prop_map(|a| made(FormulaKind::Not(a))),
            one().prop_map(|a| made(FormulaKind::Next(a))),
            (steps(), one()).prop_map(|(s, a)| made(FormulaKind::Eventually(s, a))),
            (steps(), one()).prop_map(|(s, a)| made(FormulaKind::Always(s, a))),
            (steps(), one(), one()).prop_map(|(s, a, b)| made(FormulaKind::Until(s, a, b))),
            (one(), one()).prop_map(|(a, b)| made(FormulaKind::Weak(Steps::default(), a, b))),
            (one(), one()).prop_map(|(a, b)| made(FormulaKind::Release(Steps::default(), a, b))),
            (one(), one()).prop_map(|(a, b)| made(FormulaKind::Strong(a, b))),
            (one(), one()).prop_map(|(a, b)| made(FormulaKind::Implies(a, b))),
            (one(), one()).prop_map(|(a, b)| made(FormulaKind::Iff(a, b))),
            list().prop_map(|all| made(FormulaKind::And(all))),
            list().prop_map(|all| made(FormulaKind::Or(all))),
        ]
    })
}

/// Generates co-safe formulas over two atoms and their negations.
fn cosafe() -> impl Strategy<Value = Formula> {
    let literal = (0u8..2, any::<bool>()).prop_map(|(atom, positive)| match positive {
        true => state(atom),
        false => made(FormulaKind::Not(Box::new(state(atom)))),
    });
    let bounded = (0u64..3).prop_map(|most| Steps { least: None, most: number(most) });
    literal.prop_recursive(5, 10, 2, move |inner| {
        let one = || inner.clone().prop_map(Box::new);
        let two = || prop::collection::vec(inner.clone(), 2);
        prop_oneof![
            2 => one().prop_map(|a| made(FormulaKind::Next(a))),
            2 => one().prop_map(|a| made(FormulaKind::Eventually(Steps::default(), a))),
            1 => (bounded.clone(), one()).prop_map(|(s, a)| made(FormulaKind::Eventually(s, a))),
            1 => (bounded.clone(), one()).prop_map(|(s, a)| made(FormulaKind::Always(s, a))),
            2 => (one(), one()).prop_map(|(a, b)| made(FormulaKind::Until(Steps::default(), a, b))),
            2 => two().prop_map(|all| made(FormulaKind::And(all))),
            2 => two().prop_map(|all| made(FormulaKind::Or(all))),
        ]
    })
}

/// Generates combinations of co-safe formulas, recurrences and their negations.
fn combination() -> impl Strategy<Value = Formula> {
    let always = |a: Formula| made(FormulaKind::Always(Steps::default(), Box::new(a)));
    prop_oneof![1 => cosafe(), 4 => cosafe().prop_map(always)].prop_recursive(3, 6, 2, |inner| {
        let one = || inner.clone().prop_map(Box::new);
        prop_oneof![
            2 => one().prop_map(|a| made(FormulaKind::Not(a))),
            1 => one().prop_map(|a| made(FormulaKind::Next(a))),
            1 => one().prop_map(|a| made(FormulaKind::Eventually(Steps::default(), a))),
            1 => one().prop_map(|a| made(FormulaKind::Always(Steps::default(), a))),
            1 => (one(), one()).prop_map(|(a, b)| made(FormulaKind::Implies(a, b))),
            1 => (one(), one()).prop_map(|(a, b)| made(FormulaKind::Iff(a, b))),
            1 => prop::collection::vec(inner.clone(), 2).prop_map(|all| made(FormulaKind::And(all))),
            1 => prop::collection::vec(inner.clone(), 2).prop_map(|all| made(FormulaKind::Or(all))),
        ]
    })
}

fn word() -> impl Strategy<Value = Word> {
    prop::collection::vec(0u8..8, 1..9)
        .prop_flat_map(|letters| (Just(letters.clone()), 0..letters.len()))
        .prop_map(|(letters, back)| Word { letters, back })
}

/// Returns the monitors of a formula, `None` at a limit.
fn judge(f: &Formula) -> Option<Judge> {
    match Judge::new(f) {
        Ok(judge) => Some(judge),
        Err(Error::Limit(Limit::Size { .. })) => None,
        Err(other) => panic!("{f:?}: {other}"),
    }
}

/// Compares the verdicts on a formula.
fn compare(f: &Formula, words: &[Word]) -> Result<(), TestCaseError> {
    let Some(judge) = judge(f) else { return Ok(()) };
    for word in words {
        prop_assert_eq!(judge.holds(word), meaning(f, word)[0], "{:?} on {:?}", f, word);
    }
    Ok(())
}

proptest! {
    #![proptest_config(meliora_amount::random(3_000))]

    #[test]
    fn monitors_are_right_for_random_formulas(f in formula(), words in prop::collection::vec(word(), 12)) {
        compare(&f, &words)?;
    }

    #[test]
    fn monitors_are_right_for_random_combinations(f in combination(), words in prop::collection::vec(word(), 12)) {
        compare(&f, &words)?;
    }

    #[test]
    fn tautologies_hold_on_all_words_and_contradictions_on_none(f in combination(), words in prop::collection::vec(word(), 12)) {
        let not = made(FormulaKind::Not(Box::new(f.clone())));
        let true_and_false = [
            (made(FormulaKind::Or(vec![f.clone(), not.clone()])), true),
            (made(FormulaKind::And(vec![f.clone(), not.clone()])), false),
            (made(FormulaKind::Iff(Box::new(f.clone()), Box::new(not))), false),
            (made(FormulaKind::Implies(Box::new(f.clone()), Box::new(f.clone()))), true),
        ];
        for (g, expected) in true_and_false {
            if let Some(judge) = judge(&g) {
                prop_assert!(words.iter().all(|word| judge.holds(word) == expected), "{:?}", g);
            }
        }
    }
}
