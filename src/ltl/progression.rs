//! Progression: computes the formula for the rest of a path from a formula and the present state.
//!
//! F. Bacchus and F. Kabanza, *Planning for temporally extended goals* (1998). The formula is a
//! Boolean function of obligations on the rest of the path: temporal formulas, and state formulas
//! that are not read yet.

use ahash::AHashMap;

use super::formulas::{Form, FormulaId, Formulas, Window};
use super::functions::{FALSE, Function, Functions, TRUE};
use meliora_base::error::{Limit, Result};
use meliora_base::stack;
use meliora_model::expr::ExprId;

/// First variable of an obligation; smaller variables are atoms of the present state.
pub(crate) const OBLIGATIONS: u32 = 1 << 16;
/// Maximum number of obligations of one formula.
const MOST_OBLIGATIONS: usize = 1 << 13;

/// A condition on the path from the next state on; its parts are functions of obligations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Obligation {
    Atom(u32),
    Next(Function),
    /// `φ U[window] ψ`, or `φ R[window] ψ`.
    Binary {
        until: bool,
        window: Window,
        left: Function,
        right: Function,
    },
    /// For an until, `φ U<=k ψ` and not `φ U<=k-1 ψ`; for a release,
    /// `φ R<=k ψ` or not `φ R<=k-1 ψ`.
    Exactly {
        until: bool,
        left: Function,
        right: Function,
        steps: u64,
    },
}

/// The obligations `φ U<=k ψ`, or `φ R<=k ψ`, for all k up to a maximum.
#[derive(Clone, Copy)]
struct Chain {
    /// Variable of the greatest k; the variables of smaller k follow it.
    first: u32,
    most: u64,
}

/// Progresses the formulas of one monitor.
pub(crate) struct Progress {
    pub functions: Functions,
    /// Atoms in the order of their variables.
    pub atoms: Vec<ExprId>,
    obligations: Vec<Obligation>,
    known: AHashMap<Obligation, u32>,
    chains: AHashMap<(bool, Function, Function), Vec<Chain>>,
    read: AHashMap<Function, Function>,
    owed: AHashMap<Function, Function>,
}

impl Progress {
    pub(crate) fn new() -> Self {
        Progress {
            functions: Functions::new(),
            atoms: Vec::new(),
            obligations: Vec::new(),
            known: AHashMap::new(),
            chains: AHashMap::new(),
            read: AHashMap::new(),
            owed: AHashMap::new(),
        }
    }

    /// Returns the formula as a function of obligations, before any state is read.
    ///
    /// # Errors
    /// The formula needs too many obligations or nodes, as for [`Progress::read`].
    pub(crate) fn ask(&mut self, all: &Formulas, f: FormulaId) -> Result<Function> {
        stack::level(|| match all.form(f) {
            Form::Constant(value) => Ok(Function::from(*value)),
            Form::Literal(e, positive) => {
                let atom = match self.atoms.iter().position(|a| a == e) {
                    Some(known) => known,
                    None => {
                        self.atoms.push(*e);
                        self.atoms.len() - 1
                    }
                };
                let variable = self.obligation(Obligation::Atom(atom as u32))?;
                self.functions.variable(variable, *positive)
            }
            form @ (Form::And(parts) | Form::Or(parts)) => {
                let both = matches!(form, Form::And(_));
                let mut joined = Function::from(both);
                for &part in parts.iter() {
                    let part = self.ask(all, part)?;
                    joined = self.join(both, joined, part)?;
                }
                Ok(joined)
            }
            Form::Next(inner) => {
                let inner = self.ask(all, *inner)?;
                self.owe(Obligation::Next(inner))
            }
            form @ (Form::Until(window, left, right) | Form::Release(window, left, right)) => {
                let until = matches!(form, Form::Until(..));
                let (left, right) = (self.ask(all, *left)?, self.ask(all, *right)?);
                self.owe(Obligation::Binary { until, window: *window, left, right })
            }
        })
    }

    /// Computes f ∧ g if `both`, f ∨ g otherwise. Until and release are dual, so both use this.
    fn join(&mut self, both: bool, f: Function, g: Function) -> Result<Function> {
        if both { self.functions.and(f, g) } else { self.functions.or(f, g) }
    }

    fn owe(&mut self, obligation: Obligation) -> Result<Function> {
        match obligation {
            Obligation::Next(FALSE | TRUE) => {
                return Ok(Function::from(obligation == Obligation::Next(TRUE)));
            }
            Obligation::Binary { until, window, right, .. }
                if right == Function::from(!until)
                    || (right == Function::from(until) && window.least == 0) =>
            {
                return Ok(right);
            }
            Obligation::Binary { until, window: Window { least: 0, most: Some(most) }, left, right } => {
                return self.within(until, left, right, most);
            }
            _ => {}
        }
        let variable = self.obligation(obligation)?;
        self.functions.variable(variable, true)
    }

    /// Returns `φ U<=k ψ` as the disjunction over j ≤ k of "in j steps and no fewer", and a release
    /// dually. In this form a smaller bound visibly implies a larger one, and of several deadlines
    /// only the first counts.
    fn within(&mut self, until: bool, left: Function, right: Function, most: u64) -> Result<Function> {
        let chains = self.chains.entry((until, left, right)).or_default();
        let chain = match chains.iter().find(|c| c.most >= most) {
            Some(known) => *known,
            None => {
                let new = Chain { first: OBLIGATIONS + self.obligations.len() as u32, most };
                chains.push(new);
                for steps in (0..=most).rev() {
                    // Each chain has its own consecutive variables.
                    self.known.remove(&Obligation::Exactly { until, left, right, steps });
                    self.obligation(Obligation::Exactly { until, left, right, steps })?;
                }
                new
            }
        };
        let mut all = Function::from(!until);
        for steps in 0..=most {
            let variable = chain.first + (chain.most - steps) as u32;
            all = if until {
                self.functions.node(variable, all, TRUE)?
            } else {
                self.functions.node(variable, FALSE, all)?
            };
        }
        Ok(all)
    }

    fn obligation(&mut self, obligation: Obligation) -> Result<u32> {
        if let Some(&known) = self.known.get(&obligation) {
            return Ok(known);
        }
        if self.obligations.len() >= MOST_OBLIGATIONS {
            let what = format!(
                "a monitor of more than {MOST_OBLIGATIONS} obligations; smaller bounds on the number of steps reduce them"
            );
            return Err(Limit::Size { what }.into());
        }
        let new = OBLIGATIONS + self.obligations.len() as u32;
        self.obligations.push(obligation);
        self.known.insert(obligation, new);
        Ok(new)
    }

    /// Progresses f through the present state: returns a function of its atoms and of obligations
    /// on the later states.
    ///
    /// # Errors
    /// Too many obligations or nodes.
    pub(crate) fn read(&mut self, f: Function) -> Result<Function> {
        let top = self.functions.top(f);
        if top == u32::MAX {
            return Ok(f);
        }
        if let Some(&known) = self.read.get(&f) {
            return Ok(known);
        }
        let found = stack::level(|| {
            let (low, high) = self.functions.halves(f, top);
            let (low, high) = (self.read(low)?, self.read(high)?);
            let test = self.fulfil(self.obligations[(top - OBLIGATIONS) as usize])?;
            self.functions.ite(test, high, low)
        })?;
        self.read.insert(f, found);
        Ok(found)
    }

    /// Returns the debts of f: f with `true` for each unbounded release, which needs nothing to
    /// happen. For a formula of the class Π2 this is co-safe.
    ///
    /// # Errors
    /// Too many obligations or nodes.
    pub(crate) fn owed(&mut self, f: Function) -> Result<Function> {
        let top = self.functions.top(f);
        if top == u32::MAX {
            return Ok(f);
        }
        if let Some(&known) = self.owed.get(&f) {
            return Ok(known);
        }
        let found = stack::level(|| {
            let (low, high) = self.functions.halves(f, top);
            let (low, high) = (self.owed(low)?, self.owed(high)?);
            let test = self.debt(top)?;
            self.functions.ite(test, high, low)
        })?;
        self.owed.insert(f, found);
        Ok(found)
    }

    /// Returns the debts of one variable.
    fn debt(&mut self, variable: u32) -> Result<Function> {
        let own = self.functions.variable(variable, true)?;
        let Some(&obligation) = variable.checked_sub(OBLIGATIONS).map(|at| &self.obligations[at as usize])
        else {
            return Ok(own);
        };
        match obligation {
            Obligation::Atom(_)
            | Obligation::Binary { until: true, window: Window { most: None, .. }, .. } => Ok(own),
            Obligation::Binary { until: false, window: Window { most: None, .. }, .. } => Ok(TRUE),
            Obligation::Next(inner) => {
                let inner = self.owed(inner)?;
                self.owe(Obligation::Next(inner))
            }
            Obligation::Binary { until, window, left, right } => {
                let (left, right) = (self.owed(left)?, self.owed(right)?);
                self.owe(Obligation::Binary { until, window, left, right })
            }
            Obligation::Exactly { until, left, right, steps } => {
                let parts = (self.owed(left)?, self.owed(right)?);
                if parts == (left, right) {
                    return Ok(own);
                }
                self.exactly(until, steps, |own, window| {
                    let (left, right) = parts;
                    own.owe(Obligation::Binary { until, window, left, right })
                })
            }
        }
    }

    /// Returns `within k steps, and not within fewer`, or the dual, from a function that gives
    /// `within` for a window.
    fn exactly(
        &mut self,
        until: bool,
        steps: u64,
        within: impl Fn(&mut Self, Window) -> Result<Function>,
    ) -> Result<Function> {
        let now = within(self, Window { least: 0, most: Some(steps) })?;
        let fewer = match steps.checked_sub(1) {
            Some(fewer) => within(self, Window { least: 0, most: Some(fewer) })?,
            None => Function::from(!until),
        };
        let not = self.functions.ite(fewer, FALSE, TRUE)?;
        self.join(until, now, not)
    }

    /// Progresses one obligation through the present state.
    fn fulfil(&mut self, obligation: Obligation) -> Result<Function> {
        match obligation {
            Obligation::Atom(atom) => self.functions.variable(atom, true),
            Obligation::Next(inner) => Ok(inner),
            Obligation::Exactly { until, left, right, steps } => {
                self.exactly(until, steps, |own, window| own.unfold(until, window, left, right))
            }
            Obligation::Binary { until, window, left, right } => self.unfold(until, window, left, right),
        }
    }

    /// Progresses φ U ψ = ψ | φ & X (φ U ψ), and dually φ R ψ = ψ & (φ | X (φ R ψ)).
    fn unfold(&mut self, until: bool, window: Window, left: Function, right: Function) -> Result<Function> {
        let going = match window.later() {
            Some(window) => {
                let now = self.read(left)?;
                let then = self.owe(Obligation::Binary { until, window, left, right })?;
                self.join(until, now, then)?
            }
            None => Function::from(!until),
        };
        let here = if window.least == 0 { self.read(right)? } else { Function::from(!until) };
        self.join(!until, here, going)
    }
}

impl Window {
    /// Returns the window one step later, `None` when it is over.
    fn later(self) -> Option<Window> {
        let most = match self.most {
            Some(0) => return None,
            Some(most) => Some(most - 1),
            None => None,
        };
        Some(Window { least: self.least.saturating_sub(1), most })
    }
}
