//! Checks the monitors against the definition of LTL, for all formulas up to a size on all short
//! words.
//!
//! A word is a lasso u v^ω with |u| + |v| ≤ 4 over two atoms. The values of a formula at all
//! positions of all words are one bit set ([`Values`]), so the definition is evaluated operator by
//! operator. The verdict of a leaf on all words is computed from tables of its monitor. Formulas
//! are enumerated modulo renaming (the first atom is `a`) and modulo the order of the larger and
//! the smaller operand of `&` and `|`.

use std::borrow::Cow;
use std::rc::Rc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use ahash::AHashMap;

use super::words::{Atoms, made, state};
use crate::ltl::normaliser::Normaliser;
use crate::ltl::{Formula, FormulaKind, Steps};
use meliora_amount::is_long;
use meliora_base::value::Value;
use meliora_ltl::{FormulaId, Formulas, Leaf, Monitor, Tree, leaves};
use meliora_model::expr::ExprId;
use meliora_model::temporal::Asks;

/// Maximum length of a word.
const MOST_LETTERS: usize = 4;
/// Number of chunks of 64 words, over all shapes (length, start of the loop) and positions.
const CHUNKS: usize = 78;
/// Number of chunks at the first positions only.
const FIRST_CHUNKS: usize = 22;
/// Maximum number of formulas per thread; they are then forgotten.
const MOST_KNOWN: usize = 1_000_000;

/// The words of one length and one start of the loop. A word is numbered by its letters: two bits
/// each, the first letter lowest.
#[derive(Clone, Copy)]
struct Shape {
    length: usize,
    back: usize,
    /// First chunk of the first position: in [`Values`], and (`at_first`) in [`Verdicts`].
    at: usize,
    at_first: usize,
}

impl Shape {
    fn words(self) -> usize {
        1 << (2 * self.length)
    }

    fn chunks(self) -> usize {
        self.words().div_ceil(64)
    }

    fn after(self, position: usize) -> usize {
        if position + 1 < self.length { position + 1 } else { self.back }
    }

    fn range(self, position: usize) -> std::ops::Range<usize> {
        let start = self.at + position * self.chunks();
        start..start + self.chunks()
    }

    fn first(self) -> std::ops::Range<usize> {
        self.at_first..self.at_first + self.chunks()
    }

    /// Returns the bits of a chunk that stand for words.
    fn mask(self) -> u64 {
        if self.words() < 64 { (1 << self.words()) - 1 } else { u64::MAX }
    }
}

fn shapes() -> Vec<Shape> {
    let (mut all, mut at, mut at_first) = (Vec::new(), 0, 0);
    for length in 1..=MOST_LETTERS {
        for back in 0..length {
            let shape = Shape { length, back, at, at_first };
            at += length * shape.chunks();
            at_first += shape.chunks();
            all.push(shape);
        }
    }
    assert_eq!((at, at_first), (CHUNKS, FIRST_CHUNKS));
    all
}

/// Values of a formula: one bit per position and word.
type Values = [u64; CHUNKS];
/// Verdicts on a formula: one bit per word.
type Verdicts = [u64; FIRST_CHUNKS];

/// The definition of LTL, evaluated on all words.
struct Definition {
    shapes: Vec<Shape>,
    /// Each chunk with the chunk one step later, in the order that computes an until: backwards,
    /// twice, so that values propagate around the loop.
    steps: Vec<(usize, usize)>,
}

impl Definition {
    fn new() -> Self {
        let (shapes, mut steps) = (shapes(), Vec::new());
        for shape in &shapes {
            for position in (0..shape.length).rev().chain((0..shape.length).rev()) {
                steps.extend(shape.range(position).zip(shape.range(shape.after(position))));
            }
        }
        Definition { shapes, steps }
    }

    fn atom(&self, bit: usize) -> Values {
        let mut values = [0; CHUNKS];
        for &shape in &self.shapes {
            for position in 0..shape.length {
                let range = shape.range(position);
                for word in (0..shape.words()).filter(|word| word >> (2 * position + bit) & 1 == 1) {
                    values[range.start + word / 64] |= 1 << (word % 64);
                }
            }
        }
        values
    }

    fn next(&self, a: &Values) -> Values {
        let mut values = [0; CHUNKS];
        self.steps.iter().for_each(|&(here, then)| values[here] = a[then]);
        values
    }

    /// Computes the least solution of x = b | (a & X x).
    fn until(&self, a: &Values, b: &Values) -> Values {
        let mut values = [0; CHUNKS];
        self.steps.iter().for_each(|&(here, then)| values[here] = b[here] | a[here] & values[then]);
        values
    }

    fn of(&self, operator: Operator, a: &Values, b: &Values) -> Values {
        let always: Values = [u64::MAX; CHUNKS];
        match operator {
            Operator::Not => not(a),
            Operator::Next => self.next(a),
            Operator::Eventually => self.until(&always, a),
            Operator::Always => not(&self.until(&always, &not(a))),
            Operator::And => std::array::from_fn(|i| a[i] & b[i]),
            Operator::Or => std::array::from_fn(|i| a[i] | b[i]),
            Operator::Until => self.until(a, b),
            Operator::Release => not(&self.until(&not(a), &not(b))),
            // !(a W b) is !b U (!a & !b).
            Operator::Weak => {
                let neither: Values = std::array::from_fn(|i| !a[i] & !b[i]);
                not(&self.until(&not(b), &neither))
            }
        }
    }

    /// Returns the values at the first position, by chunk.
    fn first(&self, values: &Values) -> Verdicts {
        let mut verdicts = [0; FIRST_CHUNKS];
        for shape in &self.shapes {
            verdicts[shape.first()].copy_from_slice(&values[shape.range(0)]);
        }
        verdicts
    }
}

fn not(a: &Values) -> Values {
    std::array::from_fn(|i| !a[i])
}

#[derive(Clone, Copy, PartialEq)]
enum Operator {
    Not,
    Next,
    Eventually,
    Always,
    And,
    Or,
    Until,
    Release,
    Weak,
}

const UNARY: [Operator; 4] = [Operator::Not, Operator::Next, Operator::Eventually, Operator::Always];
const BINARY: [Operator; 5] =
    [Operator::And, Operator::Or, Operator::Until, Operator::Release, Operator::Weak];

/// A formula with its values.
#[derive(Clone)]
struct Case {
    formula: Formula,
    values: Values,
    /// True if its first atom is `a`.
    first: bool,
}

/// A formula that is not built yet: another thread builds most of them, and many have no verdict.
enum Draft<'a> {
    Known(&'a Case),
    /// An operator with its operands; if it has only one, that is given twice.
    Of(Operator, &'a Case, &'a Case),
}

impl<'a> Draft<'a> {
    fn formula(&self) -> Formula {
        let (operator, a, b) = match *self {
            Draft::Known(case) => return case.formula.clone(),
            Draft::Of(operator, a, b) => (operator, &a.formula, &b.formula),
        };
        let (steps, [x, y]) = (Steps::default(), [a, b].map(|operand| move || Box::new(operand.clone())));
        made(match operator {
            Operator::Not => FormulaKind::Not(x()),
            Operator::Next => FormulaKind::Next(x()),
            Operator::Eventually => FormulaKind::Eventually(steps, x()),
            Operator::Always => FormulaKind::Always(steps, x()),
            Operator::And => FormulaKind::And(vec![a.clone(), b.clone()]),
            Operator::Or => FormulaKind::Or(vec![a.clone(), b.clone()]),
            Operator::Until => FormulaKind::Until(steps, x(), y()),
            Operator::Release => FormulaKind::Release(Steps::default(), x(), y()),
            Operator::Weak => FormulaKind::Weak(Steps::default(), x(), y()),
        })
    }

    fn values(&self, definition: &Definition) -> Values {
        match *self {
            Draft::Known(case) => case.values,
            Draft::Of(operator, a, b) => definition.of(operator, &a.values, &b.values),
        }
    }

    fn case(&self, definition: &Definition) -> Cow<'a, Case> {
        match *self {
            Draft::Known(case) => Cow::Borrowed(case),
            Draft::Of(_, a, _) => {
                Cow::Owned(Case { formula: self.formula(), values: self.values(definition), first: a.first })
            }
        }
    }
}

/// All formulas with a number of operators, built from those with fewer.
struct Enumerated {
    definition: Definition,
    /// Formulas by number of operators.
    known: Vec<Vec<Case>>,
    binary: Vec<Operator>,
}

impl Enumerated {
    /// Builds all formulas with up to `size` operators.
    fn up_to(size: usize, binary: &[Operator]) -> Self {
        let definition = Definition::new();
        let atoms = [0, 1].map(|bit| Case {
            formula: state(bit as u8),
            values: definition.atom(bit),
            first: bit == 0,
        });
        let mut all = Enumerated { definition, known: vec![atoms.to_vec()], binary: binary.to_vec() };
        for size in 1..=size {
            let mut cases = Vec::new();
            all.each(size, false, &mut |_, draft| cases.push(draft.case(&all.definition).into_owned()));
            all.known.push(cases);
        }
        all
    }

    /// Enumerates all formulas with `size` operators. With `modulo`, it gives only those whose
    /// first atom is `a`, and one order of the operands of `&` and `|`.
    fn each(&self, size: usize, modulo: bool, found: &mut dyn FnMut(usize, Draft<'_>)) {
        if let Some(known) = self.known.get(size) {
            let wanted = known.iter().filter(|case| case.first || !modulo);
            return wanted.enumerate().for_each(|(n, case)| found(n, Draft::Known(case)));
        }
        let mut number = 0;
        let mut give = |draft: Draft<'_>| {
            found(number, draft);
            number += 1;
        };
        self.each(size - 1, modulo, &mut |_, a| {
            let a = &a.case(&self.definition);
            for operator in UNARY {
                // A double negation is left out.
                if operator != Operator::Not || !matches!(a.formula.kind, FormulaKind::Not(_)) {
                    give(Draft::Of(operator, a, a));
                }
            }
        });
        for left in 0..size {
            let right = size - 1 - left;
            self.pairs(left, right, modulo, &mut |a, b| {
                for &operator in &self.binary {
                    if !modulo || left >= right || !matches!(operator, Operator::And | Operator::Or) {
                        give(Draft::Of(operator, a, b));
                    }
                }
            });
        }
    }

    fn pairs(&self, left: usize, right: usize, modulo: bool, found: &mut dyn FnMut(&Case, &Case)) {
        // The loop over the larger operand is the outer one: it is made only once.
        if left >= right {
            self.each(left, modulo, &mut |_, a| {
                let a = a.case(&self.definition);
                self.each(right, false, &mut |_, b| found(&a, &b.case(&self.definition)));
            });
        } else {
            self.each(right, false, &mut |_, b| {
                let b = b.case(&self.definition);
                self.each(left, modulo, &mut |_, a| found(&a.case(&self.definition), &b));
            });
        }
    }
}

/// Verdicts of the monitors on all words.
struct Judge {
    shapes: Vec<Shape>,
    atoms: Atoms,
    all: Formulas,
    known: AHashMap<FormulaId, Rc<Verdicts>>,
    /// Verdicts by transition table, since many leaves have the same monitor.
    judged: AHashMap<Table, Rc<Verdicts>>,
}

/// For each state of a monitor and each letter, the next state and a flag for a marked step.
type Table = Vec<[(usize, bool); 4]>;

impl Judge {
    fn new() -> Self {
        let (atoms, all) = (Atoms::new(), Formulas::new());
        Judge { shapes: shapes(), atoms, all, known: AHashMap::new(), judged: AHashMap::new() }
    }

    fn verdicts(&mut self, f: &Formula) -> Verdicts {
        if self.all.count() > MOST_KNOWN {
            self.known.clear();
            self.all = Formulas::new();
        }
        let normal = Normaliser::new(&mut self.atoms, &mut self.all).build(f, true).unwrap();
        let tree = leaves(&mut self.all, normal).unwrap();
        self.truth(&tree)
    }

    fn truth(&mut self, tree: &Tree) -> Verdicts {
        let joined = |judge: &mut Self, parts: &[Tree], all: bool| {
            let mut verdicts = [if all { u64::MAX } else { 0 }; FIRST_CHUNKS];
            for part in parts {
                let part = judge.truth(part);
                verdicts =
                    std::array::from_fn(|i| if all { verdicts[i] & part[i] } else { verdicts[i] | part[i] });
            }
            verdicts
        };
        match tree {
            Tree::Constant(value) => [if *value { u64::MAX } else { 0 }; FIRST_CHUNKS],
            Tree::Leaf(Leaf { asks, watched, .. }) => {
                let marked = self.leaf(*watched);
                let wanted = matches!(asks, Asks::Accept | Asks::Again);
                std::array::from_fn(|i| if wanted { marked[i] } else { !marked[i] })
            }
            Tree::All(parts) => joined(self, parts, true),
            Tree::Any(parts) => joined(self, parts, false),
        }
    }

    /// Returns the words on which a monitor marks infinitely many steps.
    fn leaf(&mut self, watched: FormulaId) -> Rc<Verdicts> {
        if let Some(known) = self.known.get(&watched) {
            return Rc::clone(known);
        }
        let monitor = Monitor::owing(&self.all, watched).unwrap();
        let table = self.table(&monitor);
        let found = match self.judged.get(&table) {
            Some(found) => Rc::clone(found),
            None => Rc::new(marked(&self.shapes, &table)),
        };
        self.judged.insert(table, Rc::clone(&found));
        self.known.insert(watched, Rc::clone(&found));
        found
    }

    fn table(&self, monitor: &Monitor) -> Table {
        let holds = |letter: usize, e: ExprId| {
            let values = [letter & 1, letter >> 1].map(|bit| bit as i64);
            self.atoms.pool.eval(e, &values).unwrap() == Value::Bool(true)
        };
        let row = |state| std::array::from_fn(|letter| monitor.step(state, |e| holds(letter, e)));
        (0..monitor.states.len()).map(row).collect()
    }
}

/// Returns the words on which infinitely many steps are marked.
fn marked(shapes: &[Shape], table: &Table) -> Verdicts {
    // For each length and each word of that length: for each state the end of the run, and a flag
    // for a mark on it.
    let mut runs = vec![vec![(0..table.len()).map(|s| (s, false)).collect::<Vec<(usize, bool)>>()]];
    for length in 1..=MOST_LETTERS {
        let longer = |word: usize| {
            let after = |step: &[(usize, bool); 4]| {
                let (middle, mark) = step[word & 3];
                let (end, later) = runs[length - 1][word >> 2][middle];
                (end, mark | later)
            };
            table.iter().map(after).collect()
        };
        let longer = (0..1usize << (2 * length)).map(longer).collect();
        runs.push(longer);
    }
    let again: Vec<Vec<Vec<bool>>> =
        runs.iter().map(|row| row.iter().map(|run| recurring(run)).collect()).collect();
    let mut verdicts = [0; FIRST_CHUNKS];
    for &Shape { length, back, at_first, .. } in shapes {
        for word in 0..1usize << (2 * length) {
            let start = runs[back][word & ((1 << (2 * back)) - 1)][0].0;
            let marked = again[length - back][word >> (2 * back)][start];
            verdicts[at_first + word / 64] |= u64::from(marked) << (word % 64);
        }
    }
    verdicts
}

/// Returns for each state whether infinite repetition of a run gives infinitely many marks.
fn recurring(run: &[(usize, bool)]) -> Vec<bool> {
    let mut found = Vec::with_capacity(run.len());
    for start in 0..run.len() {
        let looping = (0..run.len()).fold(start, |s, _| run[s].0);
        let (mut at, mut marked) = (looping, false);
        loop {
            marked |= run[at].1;
            at = run[at].0;
            if at == looping {
                break;
            }
        }
        found.push(marked);
    }
    found
}

/// Compares every formula of a size, or one of `step`, on all threads; returns their number.
fn compare(formulas: &Enumerated, size: usize, step: usize) -> usize {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let all = AtomicUsize::new(0);
    let masks: Vec<u64> = shapes().iter().flat_map(|shape| vec![shape.mask(); shape.chunks()]).collect();
    let work = |own: usize| {
        let mut judge = Judge::new();
        formulas.each(size, true, &mut |number, draft| {
            if number % (threads * step) != own * step {
                return;
            }
            all.fetch_add(1, Relaxed);
            let formula = draft.formula();
            let found = judge.verdicts(&formula);
            let expected = formulas.definition.first(&draft.values(&formulas.definition));
            let same = (0..FIRST_CHUNKS).all(|i| (found[i] ^ expected[i]) & masks[i] == 0);
            assert!(same, "{formula:?}: {}", example(&found, &expected));
        });
    };
    std::thread::scope(|scope| {
        (0..threads).for_each(|own| {
            scope.spawn(move || work(own));
        });
    });
    all.into_inner()
}

/// Returns a word on which two verdicts differ.
fn example(found: &Verdicts, expected: &Verdicts) -> String {
    for shape in shapes() {
        for word in 0..shape.words() {
            let at = |verdicts: &Verdicts| verdicts[shape.at_first + word / 64] >> (word % 64) & 1 == 1;
            if at(found) != at(expected) {
                let letters: Vec<usize> = (0..shape.length).map(|i| word >> (2 * i) & 3).collect();
                return format!("{} on {letters:?}, loop from {}", at(found), shape.back);
            }
        }
    }
    "no word".to_owned()
}

#[test]
fn monitors_are_right_for_all_formulas_of_up_to_four_operators() {
    let formulas = Enumerated::up_to(3, &BINARY);
    let found: Vec<usize> = (0..=3).map(|size| compare(&formulas, size, 1)).collect();
    assert_eq!(found, [1, 14, 335, 9_987]);
    let all: usize = 274_458;
    let step = if is_long() { 1 } else { 20 };
    assert_eq!(compare(&formulas, 4, step), all.div_ceil(step));
}

/// One of 250 if all cases are wanted, otherwise one of 50 of those with two binary operators, because the enumeration of
/// all takes longer than the comparison. The environment variable `FIVE_STEP=1` asks for each.
#[test]
fn monitors_are_right_for_some_formulas_of_five_operators() {
    let (binary, count, step): (_, usize, _) =
        if is_long() { (&BINARY[..], 9_191_081, 250) } else { (&BINARY[1..3], 293_687, 50) };
    let step = std::env::var("FIVE_STEP").map_or(step, |step| step.parse().unwrap());
    let found = compare(&Enumerated::up_to(3, binary), 5, step);
    assert_eq!(found, count.div_ceil(step));
}
