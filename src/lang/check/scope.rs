//! What names mean: constants, formulas, variables; and what they mean inside a renamed module.

use ahash::AHashMap;

use crate::lang::ast::{Expr, ExprKind, Span};
use crate::lang::slip::is_slip;
use crate::model::VarId;
use crate::model::expr::ExprId;
use crate::model::value::{Type, Value};

/// What a name stands for.
#[derive(Debug, Clone, Copy)]
pub(super) enum Symbol {
    /// A constant or a formula, by its position in [`Scope::definitions`].
    Definition(usize),
    /// A variable of the program.
    Variable(VarId, Type),
    /// A constant of a finished program.
    Value(Value),
    /// A formula of a finished program.
    Expression(ExprId),
}

/// A constant or a formula: a name for an expression.
pub(super) struct Definition<'a> {
    pub(super) name: &'a str,
    pub(super) span: Span,
    /// What it stands for; none for a constant whose value is given from outside.
    pub(super) body: Option<&'a Expr>,
    /// The type of a constant; none for a formula.
    pub(super) constant: Option<Type>,
}

/// A renaming that is in force, by its position in [`Scope::renamings`] plus one; 0 is none.
pub(super) type Env = usize;

/// Outside of renamed modules.
pub(super) const NO_RENAMING: Env = 0;

/// The names of one renaming, and the renaming that is applied after it.
pub(super) struct Renaming<'a> {
    pub(super) map: AHashMap<&'a str, &'a str>,
    pub(super) then: Env,
}

/// All names of a model.
#[derive(Default)]
pub(in crate::lang) struct Scope<'a> {
    pub(super) symbols: AHashMap<String, (Symbol, Span)>,
    pub(super) definitions: Vec<Definition<'a>>,
    pub(super) renamings: Vec<Renaming<'a>>,
}

impl<'a> Scope<'a> {
    /// What `name` is called under a renaming, and the renaming under which to read what the new
    /// name stands for: a formula that is not itself renamed is renamed inside.
    pub(super) fn rename<'n>(&self, name: &'n str, env: Env) -> (&'n str, Env)
    where
        'a: 'n,
    {
        let (mut name, mut inside, mut at) = (name, env, env);
        while let Some(renaming) = at.checked_sub(1).and_then(|i| self.renamings.get(i)) {
            if let Some(&new) = renaming.map.get(name) {
                (name, inside) = (new, renaming.then);
            }
            at = renaming.then;
        }
        (name, inside)
    }

    pub(super) fn symbol(&self, name: &str) -> Option<Symbol> {
        self.symbols.get(name).map(|s| s.0)
    }

    /// The definitions that the body of a definition names under a renaming, each with the renaming
    /// to read it under.
    pub(super) fn dependencies(&self, definition: usize, env: Env) -> Vec<(usize, Env)> {
        let mut names = Vec::new();
        if let Some(body) = self.definitions[definition].body {
            collect_names(body, &mut names);
        }
        let resolve = |name| {
            let (name, inside) = self.rename(name, env);
            match self.symbol(name) {
                Some(Symbol::Definition(d)) => Some((d, inside)),
                _ => None,
            }
        };
        names.into_iter().filter_map(resolve).collect()
    }

    /// A name of the model that differs from `name` by one slip of the hand.
    pub(super) fn similar(&self, name: &str) -> Option<&str> {
        let known = self.symbols.keys().filter(|k| is_slip(k, name));
        known.min().map(String::as_str)
    }
}

fn collect_names<'e>(e: &'e Expr, names: &mut Vec<&'e str>) {
    match &e.kind {
        ExprKind::Name(name) => names.push(name),
        ExprKind::Not(a) | ExprKind::Neg(a) => collect_names(a, names),
        ExprKind::Chain(first, rest) => {
            collect_names(first, names);
            rest.iter().for_each(|(_, e)| collect_names(e, names));
        }
        ExprKind::Ite(cases, otherwise) => {
            for (condition, then) in cases {
                collect_names(condition, names);
                collect_names(then, names);
            }
            collect_names(otherwise, names);
        }
        ExprKind::Call(_, arguments) => arguments.iter().for_each(|e| collect_names(e, names)),
        ExprKind::Bool(_) | ExprKind::Int(_) | ExprKind::Real(_) | ExprKind::Label(_) => {}
    }
}
