//! Formulas in negation normal form, each stored once: `!` only at state formulas, and X, U and R as
//! the only temporal operators.

use std::collections::BTreeSet;
use std::rc::Rc;

use ahash::AHashMap;

use meliora_base::span::Span;
use meliora_base::stack;
use meliora_model::expr::ExprId;

/// A formula, by its position in [`Formulas`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct FormulaId(u32);

/// The forms of a formula in negation normal form.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Form {
    /// `true`, `false`
    Constant(bool),
    /// A state formula, or its negation.
    Literal(ExprId, bool),
    /// `φ & ψ & …`
    And(Rc<[FormulaId]>),
    /// `φ | ψ | …`
    Or(Rc<[FormulaId]>),
    /// `X φ`
    Next(FormulaId),
    /// `φ U[window] ψ`; `F ψ` is `true U ψ`.
    Until(Window, FormulaId, FormulaId),
    /// `φ R[window] ψ`; `G ψ` is `false R ψ`.
    Release(Window, FormulaId, FormulaId),
}

/// An interval of step numbers; `most` is `None` for an unbounded one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Window {
    /// The first step.
    pub least: u64,
    /// The last step.
    pub most: Option<u64>,
}

impl Window {
    /// The interval of all steps.
    pub const ALWAYS: Window = Window { least: 0, most: None };
}

/// The unbounded operators that stand in a formula. Bounded ones are abbreviations for X.
#[derive(Debug, Clone, Copy, Default)]
struct Operators {
    until: bool,
    release: bool,
    until_below_release: bool,
    release_below_until: bool,
    /// An unbounded U outside of all limits `G F φ` and `F G φ`; then the same for R.
    free_until: bool,
    free_release: bool,
    /// A limit stands in the formula, or the formula is one.
    limit: bool,
}

/// A formula on the limit of a path, which no finite prefix decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// `G F φ`
    Again(FormulaId),
    /// `F G φ`
    Settled(FormulaId),
}

/// All formulas made so far.
#[derive(Debug)]
pub struct Formulas {
    nodes: Vec<(Form, Operators)>,
    known: AHashMap<Form, FormulaId>,
    negations: AHashMap<FormulaId, FormulaId>,
    places: AHashMap<FormulaId, Span>,
    pub(crate) implications: AHashMap<(FormulaId, FormulaId), bool>,
}

impl Formulas {
    /// The formula `false`.
    pub const FALSE: FormulaId = FormulaId(0);
    /// The formula `true`.
    pub const TRUE: FormulaId = FormulaId(1);

    /// Returns the constants alone.
    #[expect(clippy::new_without_default, reason = "an empty list of formulas would lack the constants")]
    pub fn new() -> Self {
        let mut all = Formulas {
            nodes: Vec::new(),
            known: AHashMap::new(),
            negations: AHashMap::new(),
            places: AHashMap::new(),
            implications: AHashMap::new(),
        };
        for value in [false, true] {
            all.add(Form::Constant(value));
        }
        all
    }

    /// Returns the number of formulas; the two constants are always there.
    pub fn count(&self) -> usize {
        self.nodes.len()
    }

    /// Returns the form of a formula.
    pub fn form(&self, f: FormulaId) -> &Form {
        &self.nodes[f.0 as usize].0
    }

    /// Says where a formula stands in the text.
    pub fn place(&mut self, f: FormulaId, span: Span) {
        self.places.entry(f).or_insert(span);
    }

    /// Returns where a formula stands in the text, `None` if it was made from others.
    pub fn place_of(&self, f: FormulaId) -> Option<Span> {
        self.places.get(&f).copied()
    }

    fn operators(&self, f: FormulaId) -> Operators {
        self.nodes[f.0 as usize].1
    }

    /// Returns `true` or `false`.
    pub fn constant(value: bool) -> FormulaId {
        if value { Self::TRUE } else { Self::FALSE }
    }

    /// Returns the formula of a form as it is, for literals and where nothing is to be simplified.
    pub fn add(&mut self, form: Form) -> FormulaId {
        if let Some(&known) = self.known.get(&form) {
            return known;
        }
        let new = FormulaId(self.nodes.len() as u32);
        let operators = self.operators_of(&form);
        self.nodes.push((form.clone(), operators));
        self.known.insert(form, new);
        new
    }

    fn operators_of(&self, form: &Form) -> Operators {
        let mut own = Operators::default();
        for part in form.operands() {
            let part = self.operators(part);
            own.until |= part.until;
            own.release |= part.release;
            own.until_below_release |= part.until_below_release;
            own.release_below_until |= part.release_below_until;
            own.free_until |= part.free_until;
            own.free_release |= part.free_release;
            own.limit |= part.limit;
        }
        match form {
            Form::Until(Window { most: None, .. }, ..) => {
                own.release_below_until |= own.release;
                (own.until, own.free_until) = (true, true);
            }
            Form::Release(Window { most: None, .. }, ..) => {
                own.until_below_release |= own.until;
                (own.release, own.free_release) = (true, true);
            }
            _ => {}
        }
        if self.limit_of(form).is_some() {
            (own.limit, own.free_until, own.free_release) = (true, false, false);
        }
        own
    }

    /// Returns `X φ`.
    pub fn next(&mut self, f: FormulaId) -> FormulaId {
        if matches!(self.form(f), Form::Constant(_)) { f } else { self.add(Form::Next(f)) }
    }

    /// Returns `left U[window] right` if `until`, `left R[window] right` otherwise.
    pub fn binary(&mut self, until: bool, window: Window, left: FormulaId, right: FormulaId) -> FormulaId {
        if right == Self::constant(!until) || (right == Self::constant(until) && window.least == 0) {
            return right;
        }
        self.add(if until { Form::Until(window, left, right) } else { Form::Release(window, left, right) })
    }

    /// Returns `F φ`.
    pub fn eventually(&mut self, f: FormulaId) -> FormulaId {
        self.binary(true, Window::ALWAYS, Self::TRUE, f)
    }

    /// Returns `G φ`.
    pub fn always(&mut self, f: FormulaId) -> FormulaId {
        self.binary(false, Window::ALWAYS, Self::FALSE, f)
    }

    /// Returns `G F φ`.
    pub fn recurring(&mut self, f: FormulaId) -> FormulaId {
        let eventually = self.eventually(f);
        self.always(eventually)
    }

    /// Returns the conjunction (or the disjunction), flattened and without constants.
    pub fn join(&mut self, conjunction: bool, parts: impl IntoIterator<Item = FormulaId>) -> FormulaId {
        let mut flat = Vec::new();
        for part in parts {
            match self.form(part) {
                Form::Constant(c) if *c == conjunction => {}
                Form::Constant(_) => return part,
                Form::And(inner) if conjunction => flat.extend_from_slice(inner),
                Form::Or(inner) if !conjunction => flat.extend_from_slice(inner),
                _ => flat.push(part),
            }
        }
        match flat.as_slice() {
            [] => Self::constant(conjunction),
            [one] => *one,
            _ if conjunction => self.add(Form::And(flat.into())),
            _ => self.add(Form::Or(flat.into())),
        }
    }

    /// Returns the negation.
    pub fn negated(&mut self, f: FormulaId) -> FormulaId {
        if let Some(&known) = self.negations.get(&f) {
            return known;
        }
        let found = stack::level(|| match self.form(f).clone() {
            Form::Constant(value) => Self::constant(!value),
            Form::Literal(e, positive) => self.add(Form::Literal(e, !positive)),
            Form::And(parts) => {
                let parts: Vec<FormulaId> = parts.iter().map(|&p| self.negated(p)).collect();
                self.join(false, parts)
            }
            Form::Or(parts) => {
                let parts: Vec<FormulaId> = parts.iter().map(|&p| self.negated(p)).collect();
                self.join(true, parts)
            }
            Form::Next(a) => {
                let a = self.negated(a);
                self.next(a)
            }
            Form::Until(w, a, b) => {
                let (a, b) = (self.negated(a), self.negated(b));
                self.binary(false, w, a, b)
            }
            Form::Release(w, a, b) => {
                let (a, b) = (self.negated(a), self.negated(b));
                self.binary(true, w, a, b)
            }
        });
        self.negations.insert(f, found);
        found
    }

    /// Returns the number of different parts, f included.
    pub fn size(&self, f: FormulaId) -> usize {
        let (mut seen, mut open) = (BTreeSet::from([f]), vec![f]);
        while let Some(next) = open.pop() {
            open.extend(self.form(next).operands().filter(|&part| seen.insert(part)));
        }
        seen.len()
    }

    /// Returns φ for `F φ`.
    pub fn is_eventually(&self, f: FormulaId) -> Option<FormulaId> {
        match self.form(f) {
            Form::Until(Window::ALWAYS, Self::TRUE, inner) => Some(*inner),
            _ => None,
        }
    }

    /// Returns φ for `G φ`.
    pub fn is_always(&self, f: FormulaId) -> Option<FormulaId> {
        match self.form(f) {
            Form::Release(Window::ALWAYS, Self::FALSE, inner) => Some(*inner),
            _ => None,
        }
    }

    /// Returns φ for the limits `G F φ` and `F G φ`.
    pub fn limit(&self, f: FormulaId) -> Option<Limit> {
        self.limit_of(self.form(f))
    }

    fn limit_of(&self, form: &Form) -> Option<Limit> {
        match form {
            Form::Release(Window::ALWAYS, Self::FALSE, inner) => self.is_eventually(*inner).map(Limit::Again),
            Form::Until(Window::ALWAYS, Self::TRUE, inner) => self.is_always(*inner).map(Limit::Settled),
            _ => None,
        }
    }

    /// Returns true for an unbounded R, perhaps after some X: it needs nothing to happen yet.
    pub fn only_lasts(&self, f: FormulaId) -> bool {
        let mut at = f;
        while let Form::Next(inner) = self.form(at) {
            at = *inner;
        }
        matches!(self.form(at), Form::Release(Window { most: None, .. }, ..))
    }

    /// Returns true for a syntactically co-safe formula (no unbounded R): every path that satisfies
    /// it has a prefix all of whose continuations satisfy it.
    pub fn is_cosafe(&self, f: FormulaId) -> bool {
        !self.operators(f).release
    }

    /// Returns true for a syntactically safe formula (no unbounded U): every path that violates it
    /// has a prefix all of whose continuations violate it.
    pub fn is_safe(&self, f: FormulaId) -> bool {
        !self.operators(f).until
    }

    /// Returns true for a formula of the class Π2: no unbounded R stands below an unbounded U.
    pub fn is_pi2(&self, f: FormulaId) -> bool {
        !self.operators(f).release_below_until
    }

    /// Returns true for a formula of the class Σ2: no unbounded U stands below an unbounded R.
    pub fn is_sigma2(&self, f: FormulaId) -> bool {
        !self.operators(f).until_below_release
    }

    /// Returns true if an unbounded U stands in the formula outside of limits.
    pub fn has_until(&self, f: FormulaId) -> bool {
        self.operators(f).free_until
    }

    /// Returns true if an unbounded R stands in the formula outside of limits.
    pub fn has_release(&self, f: FormulaId) -> bool {
        self.operators(f).free_release
    }

    /// Returns true if a limit stands in the formula, or the formula is one.
    pub fn has_limit(&self, f: FormulaId) -> bool {
        self.operators(f).limit
    }
}

impl Form {
    /// Returns the operands.
    pub fn operands(&self) -> impl Iterator<Item = FormulaId> {
        let (row, pair): (&[FormulaId], [Option<FormulaId>; 2]) = match self {
            Form::Constant(_) | Form::Literal(..) => (&[], [None, None]),
            Form::And(parts) | Form::Or(parts) => (parts, [None, None]),
            Form::Next(a) => (&[], [Some(*a), None]),
            Form::Until(_, a, b) | Form::Release(_, a, b) => (&[], [Some(*a), Some(*b)]),
        };
        row.iter().copied().chain(pair.into_iter().flatten())
    }
}
