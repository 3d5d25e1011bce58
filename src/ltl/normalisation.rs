//! Normalisation: an equivalent Boolean combination of formulas of the classes Π2 and Σ2.
//!
//! J. Esparza, R. Rubio and S. Sickert, *A simple rewrite system for the normalization of linear
//! temporal logic* (2022), here with R in place of W. In a context φ\[·\] without negation, and with
//! W and M as abbreviations:
//!
//! 1. φ R ψ with an U in φ is (ψ U (φ & ψ)) | G ψ;
//! 2. φ R ψ\[p U q\] is (G F q & φ R ψ\[p W q\]) | (ψ U ((φ & ψ) | G ψ\[false\]));
//! 3. φ\[G F p\] is (G F p & φ\[true\]) | φ\[false\], and the same for F G p;
//! 4. G F φ\[p R q\] is G F φ\[q U (p & q)\] | (F G q & G F φ\[true\]);
//! 5. F G φ\[p U q\] is (G F q & F G φ\[p W q\]) | F G φ\[false\].
//!
//! Rules 1 and 2 are used first, on an outermost R and in it on an outermost U, until no U stands
//! below an R outside of limits `G F` and `F G`; then rule 3, until limits stand below `&` and `|`
//! alone; then 4 and 5.

use ahash::AHashMap;

use super::formulas::{Form, FormulaId, Formulas, Limit as AtLimit, Window};
use meliora_base::error::{Limit, Result};
use meliora_base::stack;

/// Maximum number of formulas that one normalisation makes.
const MOST_FORMULAS: usize = 1 << 16;

/// Returns an equivalent Boolean combination of formulas of Σ2, of `G F φ` with co-safe φ, and of
/// `F G φ` with safe φ.
///
/// # Errors
/// The normalisation makes more than [`MOST_FORMULAS`] formulas.
pub(crate) fn normalised(all: &mut Formulas, f: FormulaId) -> Result<FormulaId> {
    let most = all.count() + MOST_FORMULAS;
    let mut work = Normalisation { all, most, ordered: AHashMap::new(), apart: AHashMap::new() };
    let simple = work.simplified(f, &mut AHashMap::new())?;
    let ordered = work.ordered(simple)?;
    work.taken_apart(ordered)
}

/// Results by formula.
type Known = AHashMap<FormulaId, FormulaId>;

struct Normalisation<'a> {
    all: &'a mut Formulas,
    /// Maximum number of formulas.
    most: usize,
    ordered: Known,
    apart: Known,
}

impl Normalisation<'_> {
    fn check(&self) -> Result<()> {
        if self.all.count() <= self.most {
            return Ok(());
        }
        let what = format!("a normal form of more than {MOST_FORMULAS} parts");
        Err(Limit::Size { what }.into())
    }

    /// Returns the formula with the same operator and simplified operands; the operand of a limit is
    /// the formula below both of its operators.
    fn rebuilt(
        &mut self,
        f: FormulaId,
        change: &mut dyn FnMut(&mut Self, FormulaId) -> Result<FormulaId>,
    ) -> Result<FormulaId> {
        self.check()?;
        match self.all.limit(f) {
            Some(AtLimit::Again(inner)) => {
                let inner = change(self, inner)?;
                return Ok(self.all.again(inner));
            }
            Some(AtLimit::Settled(inner)) => {
                let inner = change(self, inner)?;
                return Ok(self.all.settled(inner));
            }
            None => {}
        }
        let form = self.all.form(f).clone();
        Ok(match form {
            Form::Constant(_) | Form::Literal(..) => f,
            Form::And(ref parts) | Form::Or(ref parts) => {
                let parts = parts.iter().map(|&p| change(self, p)).collect::<Result<Vec<_>>>()?;
                self.all.simple_join(matches!(form, Form::And(_)), parts)
            }
            Form::Next(inner) => {
                let inner = change(self, inner)?;
                self.all.simple_next(inner)
            }
            Form::Until(window, left, right) | Form::Release(window, left, right) => {
                let (left, right) = (change(self, left)?, change(self, right)?);
                self.all.simple_binary(matches!(form, Form::Until(..)), window, left, right)
            }
        })
    }

    /// Simplifies all parts, and writes unbounded operators with a lower bound in other ones.
    fn simplified(&mut self, f: FormulaId, known: &mut Known) -> Result<FormulaId> {
        if let Some(&known) = known.get(&f) {
            return Ok(known);
        }
        let simple = stack::level(|| self.rebuilt(f, &mut |own, part| own.simplified(part, known)))?;
        let simple = match *self.all.form(simple) {
            Form::Until(Window { least, most: None }, left, right) if least > 0 => {
                self.later(true, least, left, right)
            }
            Form::Release(Window { least, most: None }, left, right) if least > 0 => {
                self.later(false, least, left, right)
            }
            _ => simple,
        };
        known.insert(f, simple);
        Ok(simple)
    }

    /// φ U>=k ψ is (G<k φ) & (φ U ψ in k steps); φ R>=k ψ is (F<k φ) | (φ R ψ in k steps).
    fn later(&mut self, until: bool, least: u64, left: FormulaId, right: FormulaId) -> FormulaId {
        let (before, at) = (Window { least: 0, most: Some(least - 1) }, Window { least, most: Some(least) });
        let first = self.all.simple_binary(!until, before, Formulas::constant(!until), left);
        let then = self.all.simple_binary(until, Window::ALWAYS, left, right);
        let then = self.all.simple_binary(true, at, Formulas::TRUE, then);
        self.all.simple_join(until, [first, then])
    }

    /// Replaces a part wherever it stands.
    fn replaced(&mut self, f: FormulaId, old: FormulaId, new: FormulaId) -> Result<FormulaId> {
        self.replaced_in(f, (old, new), &mut AHashMap::new())
    }

    fn replaced_in(
        &mut self,
        f: FormulaId,
        (old, new): (FormulaId, FormulaId),
        known: &mut Known,
    ) -> Result<FormulaId> {
        // A formula is made after its parts.
        if f <= old {
            return Ok(if f == old { new } else { f });
        }
        if let Some(&known) = known.get(&f) {
            return Ok(known);
        }
        let found =
            stack::level(|| self.rebuilt(f, &mut |own, part| own.replaced_in(part, (old, new), known)))?;
        known.insert(f, found);
        Ok(found)
    }

    /// Returns an outermost unbounded U (or R) outside of limits, with its operands.
    fn outermost(&self, until: bool, f: FormulaId) -> Option<(FormulaId, FormulaId, FormulaId)> {
        let mut at = f;
        loop {
            if !self.has(until, at) {
                return None;
            }
            match self.all.form(at) {
                &Form::Until(Window::ALWAYS, p, q) if until => return Some((at, p, q)),
                &Form::Release(Window::ALWAYS, p, q) if !until => return Some((at, p, q)),
                form => at = form.operands().find(|&part| self.has(until, part))?,
            }
        }
    }

    fn has(&self, until: bool, f: FormulaId) -> bool {
        if until { self.all.has_until(f) } else { self.all.has_release(f) }
    }

    /// Returns `p W q`.
    fn weak(&mut self, p: FormulaId, q: FormulaId) -> FormulaId {
        let either = self.all.either(p, q);
        self.all.simple_binary(false, Window::ALWAYS, q, either)
    }

    /// Returns `p U q` with q strengthened: `q U (p & q)` for `p R q` that does not last.
    fn strong(&mut self, p: FormulaId, q: FormulaId) -> FormulaId {
        let both = self.all.both(p, q);
        self.all.simple_binary(true, Window::ALWAYS, q, both)
    }

    /// Rules 1 and 2: no U stands below an R outside of limits.
    fn ordered(&mut self, f: FormulaId) -> Result<FormulaId> {
        if self.all.limit(f).is_some() || !self.all.has_until(f) || !self.all.has_release(f) {
            return Ok(f);
        }
        if let Some(&known) = self.ordered.get(&f) {
            return Ok(known);
        }
        let found = stack::level(|| match self.without_an_until(f)? {
            Some(step) => {
                self.check()?;
                self.ordered(step)
            }
            None => self.rebuilt(f, &mut Self::ordered),
        })?;
        self.ordered.insert(f, found);
        Ok(found)
    }

    /// Uses rule 1 or 2, if one applies.
    fn without_an_until(&mut self, f: FormulaId) -> Result<Option<FormulaId>> {
        let Form::Release(Window::ALWAYS, left, right) = *self.all.form(f) else { return Ok(None) };
        if self.all.has_until(left) {
            let (ends, lasts) = (self.strong(left, right), self.all.always(right));
            return Ok(Some(self.all.either(ends, lasts)));
        }
        let Some((until, p, q)) = self.outermost(true, right) else { return Ok(None) };
        let weak = self.weak(p, q);
        let (with, without) =
            (self.replaced(right, until, weak)?, self.replaced(right, until, Formulas::FALSE)?);
        let often = self.all.again(q);
        let with = self.all.simple_binary(false, Window::ALWAYS, left, with);
        let with = self.all.both(often, with);
        let lasts = self.all.simple_binary(false, Window::ALWAYS, Formulas::FALSE, without);
        let ends = self.all.both(left, right);
        let last = self.all.either(ends, lasts);
        let without = self.all.simple_binary(true, Window::ALWAYS, right, last);
        Ok(Some(self.all.either(with, without)))
    }

    /// Rules 3 to 5: limits stand below `&` and `|` alone, no R stands below `G F`, and no U below
    /// `F G`.
    fn taken_apart(&mut self, f: FormulaId) -> Result<FormulaId> {
        if !self.all.has_limit(f) {
            return Ok(f);
        }
        if let Some(&known) = self.apart.get(&f) {
            return Ok(known);
        }
        let found = stack::level(|| match self.all.form(f) {
            Form::And(_) | Form::Or(_) => self.rebuilt(f, &mut Self::taken_apart),
            _ => match self.one_apart(f)? {
                step if step == f => Ok(f),
                step => {
                    self.check()?;
                    self.taken_apart(step)
                }
            },
        })?;
        self.apart.insert(f, found);
        Ok(found)
    }

    /// Uses one of the rules 3 to 5, if one applies.
    fn one_apart(&mut self, f: FormulaId) -> Result<FormulaId> {
        if let Some(limit) = self.limit_within(f) {
            let (with, without) =
                (self.replaced(f, limit, Formulas::TRUE)?, self.replaced(f, limit, Formulas::FALSE)?);
            let with = self.all.both(limit, with);
            return Ok(self.all.either(with, without));
        }
        match self.all.limit(f) {
            Some(AtLimit::Again(inner)) => self.again_without_release(f, inner),
            Some(AtLimit::Settled(inner)) => self.settled_without_until(f, inner),
            None => Ok(f),
        }
    }

    /// Returns an outermost limit that is a proper part of a formula.
    fn limit_within(&self, f: FormulaId) -> Option<FormulaId> {
        let inside = |f: FormulaId| match self.all.limit(f) {
            Some(AtLimit::Again(inner) | AtLimit::Settled(inner)) => vec![inner],
            None => self.all.form(f).operands().collect(),
        };
        let mut at = inside(f).into_iter().find(|&part| self.all.has_limit(part))?;
        while self.all.limit(at).is_none() {
            at = inside(at).into_iter().find(|&part| self.all.has_limit(part))?;
        }
        Some(at)
    }

    fn again_without_release(&mut self, f: FormulaId, inner: FormulaId) -> Result<FormulaId> {
        let Some((release, p, q)) = self.outermost(false, inner) else { return Ok(f) };
        let strong = self.strong(p, q);
        let (ends, lasts) =
            (self.replaced(inner, release, strong)?, self.replaced(inner, release, Formulas::TRUE)?);
        let (ends, lasts, settled) = (self.all.again(ends), self.all.again(lasts), self.all.settled(q));
        let lasts = self.all.both(settled, lasts);
        Ok(self.all.either(ends, lasts))
    }

    fn settled_without_until(&mut self, f: FormulaId, inner: FormulaId) -> Result<FormulaId> {
        let Some((until, p, q)) = self.outermost(true, inner) else { return Ok(f) };
        let weak = self.weak(p, q);
        let (with, without) =
            (self.replaced(inner, until, weak)?, self.replaced(inner, until, Formulas::FALSE)?);
        let (with, without, often) = (self.all.settled(with), self.all.settled(without), self.all.again(q));
        let with = self.all.both(often, with);
        Ok(self.all.either(with, without))
    }
}
