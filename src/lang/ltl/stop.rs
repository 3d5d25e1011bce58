//! Formulas that a state decides, and programs in which these states are not left.

use std::sync::Arc;

use super::formula::{Formula, FormulaKind, Steps};
use crate::check::lower_condition;
use meliora_base::error::{Diagnostic, Error, Result, Severity, SourceFile};
use meliora_model::Program;
use meliora_model::expr::{Binary, ExprId, ExprPool, Unary};
use meliora_model::predicate::Predicates;

/// A program in which the states that decide a formula are not left, with the formula.
pub struct Stopped {
    /// The program.
    pub program: Program,
    /// The formula over it; `F ψ` for `φ U ψ`, which means the same there.
    pub formula: Formula,
}

impl Stopped {
    /// Lets the paths of a program stop where a formula is decided. The formula has the same probability
    /// in the initial states of both programs, and the reward until a target is the same.
    ///
    /// | formula | is decided in |
    /// | --- | --- |
    /// | `F ψ`, `F<=k ψ` | ψ |
    /// | `G ψ`, `G<=k ψ` | !ψ |
    /// | `φ U ψ`, `φ U<=k ψ`, `φ W ψ` | ψ \| !φ |
    /// | `φ R ψ`, `φ M ψ` | φ \| !ψ |
    ///
    /// # Errors
    /// A condition is wrong; the formula has another form: no state decides it.
    pub fn new(program: &Program, source: &Arc<SourceFile>, formula: &Formula) -> Result<Self> {
        let mut predicates = Predicates::over(program);
        let mut decider = Decider { program, source, pool: predicates.pool() };
        let Some((condition, formula)) = decider.decided(formula)? else {
            return Err(undecided(source, formula));
        };
        Ok(Stopped { program: program.stopping_at(predicates, condition), formula })
    }
}

/// A condition on states in the pool, also as a formula.
type Known = (ExprId, Box<Formula>);

struct Decider<'a> {
    program: &'a Program,
    source: &'a Arc<SourceFile>,
    pool: &'a mut ExprPool,
}

impl Decider<'_> {
    /// Returns the condition of the states that decide a formula, and the formula with all conditions in the
    /// pool; `None` if no state decides it.
    fn decided(&mut self, f: &Formula) -> Result<Option<(ExprId, Formula)>> {
        use FormulaKind::{Always, Eventually, Not, Release, Strong, Until, Weak};
        let here = |kind| Formula { kind, span: f.span };
        Ok(match &f.kind {
            Not(a) => self.decided(a)?.map(|(stop, a)| (stop, here(Not(Box::new(a))))),
            Eventually(steps, a) if steps.least.is_none() => {
                self.known(a)?.map(|(a, known)| (a, here(Eventually(steps.clone(), known))))
            }
            Always(steps, a) if steps.least.is_none() => {
                let known = self.known(a)?;
                known.map(|(a, known)| (self.pool.unary(Unary::Not, a), here(Always(steps.clone(), known))))
            }
            Until(steps, a, b) if steps.least.is_none() => self.pair(a, b)?.map(|(a, b)| {
                let kind = match &steps.most {
                    None => Eventually(Steps::default(), b.1),
                    Some(_) => Until(steps.clone(), a.1, b.1),
                };
                (self.unless(a.0, b.0), here(kind))
            }),
            Weak(steps, a, b) if steps.least.is_none() => {
                let pair = self.pair(a, b)?;
                pair.map(|(a, b)| (self.unless(a.0, b.0), here(Weak(steps.clone(), a.1, b.1))))
            }
            Release(steps, a, b) if steps.least.is_none() => {
                let pair = self.pair(a, b)?;
                pair.map(|(a, b)| (self.unless(b.0, a.0), here(Release(steps.clone(), a.1, b.1))))
            }
            Strong(a, b) => self.pair(a, b)?.map(|(a, b)| (self.unless(b.0, a.0), here(Strong(a.1, b.1)))),
            _ => None,
        })
    }

    /// Returns two conditions on states in the pool; `None` for other formulas.
    fn pair(&mut self, a: &Formula, b: &Formula) -> Result<Option<(Known, Known)>> {
        Ok(self.known(a)?.zip(self.known(b)?))
    }

    /// Returns the condition `b | !a`.
    fn unless(&mut self, a: ExprId, b: ExprId) -> ExprId {
        let not = self.pool.unary(Unary::Not, a);
        self.pool.binary(Binary::Or, b, not)
    }

    /// Returns a condition on states in the pool; `None` for other formulas.
    fn known(&mut self, f: &Formula) -> Result<Option<Known>> {
        let id = match &f.kind {
            FormulaKind::State(e) => lower_condition(self.program, self.pool, self.source, e)?,
            FormulaKind::Known(id) => *id,
            _ => return Ok(None),
        };
        Ok(Some((id, Box::new(Formula { kind: FormulaKind::Known(id), span: f.span }))))
    }
}

fn undecided(source: &Arc<SourceFile>, formula: &Formula) -> Error {
    let message = "no state alone decides this formula, so paths cannot stop at its target";
    let help = "formulas with one of F, G, U, W, R and M over conditions on states, without lower bounds on \
                steps, are decided by a state; leave out `--stop-at-target` for others";
    let diagnostic = Diagnostic::new(source, formula.span.range(), message).severity(Severity::Unsupported);
    diagnostic.label("decided by the path").help(help).into()
}
