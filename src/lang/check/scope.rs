//! The meaning of names: constants, formulas and variables, also inside renamed modules.

use std::borrow::Cow;

use ahash::AHashMap;

use crate::ast::Span;
use meliora_base::slip::is_slip;
use meliora_base::value::Type;
use meliora_model::VarId;
use meliora_model::expr::ExprId;

/// The meaning of a name.
#[derive(Debug, Clone, Copy)]
pub(super) enum Symbol {
    /// A constant or a formula.
    Definition(DefId),
    /// A variable of the program.
    Variable(VarId, Type),
    /// A constant or a formula of a finished program.
    Expression(ExprId),
}

/// A constant or a formula: a name for an expression.
pub(super) struct Definition<'a> {
    pub(super) name: &'a str,
    pub(super) span: Span,
    /// Place of the body; `None` for a constant whose value the user gives.
    pub(super) body: Option<Span>,
    /// Type of a constant; `None` for a formula.
    pub(super) constant: Option<Type>,
}

/// A constant or a formula, as its position in [`Scope::definitions`].
pub(super) type DefId = u32;

/// A renaming, as its position in [`Scope::renamings`] plus one; 0 means no renaming.
pub(super) type Env = u32;

/// The environment outside of renamed modules.
pub(super) const NO_RENAMING: Env = 0;

/// The names of one renaming, and the renaming that is applied after it.
pub(super) struct Renaming<'a> {
    pub(super) map: AHashMap<&'a str, &'a str>,
    pub(super) then: Env,
}

/// All names of a model.
#[derive(Default)]
pub(crate) struct Scope<'a> {
    pub(super) symbols: AHashMap<Cow<'a, str>, (Symbol, Span)>,
    pub(super) definitions: Vec<Definition<'a>>,
    pub(super) renamings: Vec<Renaming<'a>>,
}

impl<'a> Scope<'a> {
    /// Returns the new name under a renaming, and the renaming that applies to the body of that
    /// name: a formula that is not itself renamed is renamed inside.
    pub(super) fn rename<'n>(&self, name: &'n str, env: Env) -> (&'n str, Env)
    where
        'a: 'n,
    {
        let (mut name, mut inside, mut at) = (name, env, env);
        while let Some(renaming) = at.checked_sub(1).and_then(|i| self.renamings.get(i as usize)) {
            if let Some(&new) = renaming.map.get(name) {
                (name, inside) = (new, renaming.then);
            }
            at = renaming.then;
        }
        (name, inside)
    }

    /// Returns the renaming that applies to the body of a definition named under `env`: constants
    /// have the same value everywhere.
    pub(super) fn inside(&self, definition: DefId, env: Env) -> Env {
        let is_constant = self.definitions[definition as usize].constant.is_some();
        if is_constant { NO_RENAMING } else { env }
    }

    pub(super) fn symbol(&self, name: &str) -> Option<Symbol> {
        self.symbols.get(name).map(|s| s.0)
    }

    /// Returns a name of the model that is a likely misspelling of `name`.
    pub(super) fn similar(&self, name: &str) -> Option<&str> {
        let known = self.symbols.keys().filter(|k| is_slip(k, name));
        known.min().map(AsRef::as_ref)
    }
}
