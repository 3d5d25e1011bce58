//! Sorts the parts of a model, finds the base of each renamed module, and declares all names.

use std::borrow::Cow;

use ahash::AHashMap;

use super::limits::{MOST_COMMANDS, MOST_MODULES, MOST_RENAMINGS, MOST_VARIABLES};
use super::lowerer::Lowerer;
use super::scope::{Definition, Env, NO_RENAMING, Renaming, Symbol};
use crate::ast::{
    ConstDef, Ident, Item, Model, Module, NamedExpr, Player, RenamedModule, Rewards, Span, System, VarDecl,
};
use meliora_base::value::Type;
use meliora_model::{ModelKind, VarId};

/// A module, or a renamed copy of one.
pub(super) struct Instance<'a> {
    pub(super) name: &'a Ident,
    pub(super) module: &'a Module,
    /// Renaming to apply to the module.
    pub(super) env: Env,
    /// Declaration of the copy, if it is one; used in messages.
    pub(super) copy: Option<&'a RenamedModule>,
}

/// A variable declaration, with its module and the renaming that applies to it.
pub(super) struct Declared<'a> {
    pub(super) declaration: &'a VarDecl,
    pub(super) name: String,
    pub(super) env: Env,
    pub(super) module: Option<usize>,
    /// Place for messages about it.
    pub(super) span: Span,
}

/// The parts of a model, sorted by kind.
#[derive(Default)]
pub(super) struct Parts<'a> {
    pub(super) constants: Vec<&'a ConstDef>,
    pub(super) formulas: Vec<&'a NamedExpr>,
    pub(super) labels: Vec<&'a NamedExpr>,
    pub(super) modules: Vec<Instance<'a>>,
    /// Total number of commands of the modules.
    pub(super) commands: usize,
    pub(super) variables: Vec<Declared<'a>>,
    pub(super) init: Option<Span>,
    pub(super) system: Option<&'a System>,
    pub(super) rewards: Vec<&'a Rewards>,
    pub(super) players: Vec<&'a Player>,
    /// True for `smg`.
    pub(super) is_game: bool,
    /// First place of each label and of each module.
    label_at: AHashMap<&'a str, Span>,
    module_at: AHashMap<&'a str, Span>,
}

impl<'a> Parts<'a> {
    /// Fills in everything; reports parts that occur twice and copies without a base.
    pub(super) fn collect(&mut self, model: &'a Model, lowerer: &mut Lowerer<'a>) {
        self.is_game = matches!(model.kind, Some((ModelKind::Smg, _)));
        let (plain, copies) = bases(model);
        for item in &model.items {
            match item {
                Item::Formula(f) => self.formulas.push(f),
                Item::Label(l) => self.label(l, lowerer),
                Item::Global(declaration) => self.variables.push(Declared {
                    declaration,
                    name: declaration.name.name.clone(),
                    env: NO_RENAMING,
                    module: None,
                    span: declaration.name.span,
                }),
                Item::Module(module) => {
                    let instance = Instance { name: &module.name, module, env: NO_RENAMING, copy: None };
                    self.instance(instance, lowerer);
                }
                Item::Renamed(copy) => {
                    if let Some(instance) = resolve(copy, &plain, &copies, lowerer) {
                        self.instance(instance, lowerer);
                    }
                }
                Item::Init(e) => self.init(*e, lowerer),
                Item::System(s) => self.system(s, lowerer),
                Item::Rewards(r) => self.rewards.push(r),
                Item::Const(c) => self.constants.push(c),
                Item::Player(p) => self.players.push(p),
            }
        }
        if self.modules.is_empty() && lowerer.diagnostics.is_empty() {
            let end = Span::new(lowerer.source.text.len(), lowerer.source.text.len());
            lowerer.fail::<()>(end, "the model has no module");
        }
    }

    fn label(&mut self, label: &'a NamedExpr, lowerer: &mut Lowerer<'a>) {
        if let Some(first) = self.label_at.get(label.name.name.as_str()) {
            let message = format!("the label \"{}\" is defined twice", label.name.name);
            lowerer.again(label.name.span, message, *first, ["defined again", "defined here first"]);
        }
        self.label_at.entry(&label.name.name).or_insert(label.name.span);
        self.labels.push(label);
    }

    fn init(&mut self, e: Span, lowerer: &mut Lowerer<'a>) {
        if let Some(first) = self.init.replace(e) {
            lowerer.again(e, "there are several `init … endinit`", first, ["again", "the first one"]);
        }
    }

    fn system(&mut self, s: &'a System, lowerer: &mut Lowerer<'a>) {
        if let Some(first) = self.system.replace(s) {
            let message = "there are several `system … endsystem`";
            lowerer.again(s.span, message, first.span, ["again", "the first one"]);
        }
    }

    /// Returns true if the modules so far, including this one, are within the limits.
    fn fits(&self, instance: &Instance<'a>, lowerer: &mut Lowerer<'a>) -> bool {
        let commands = self.commands + instance.module.commands.len();
        let variables = self.variables.len() + instance.module.variables.len();
        let sizes = [
            ("modules", self.modules.len() + 1, MOST_MODULES),
            ("variables", variables, MOST_VARIABLES),
            ("commands", commands, MOST_COMMANDS),
        ];
        let Some((what, _, most)) = sizes.into_iter().find(|(_, size, most)| size > most) else {
            return true;
        };
        lowerer.too_large(what, most, instance.name.span);
        false
    }

    fn instance(&mut self, instance: Instance<'a>, lowerer: &mut Lowerer<'a>) {
        if !self.fits(&instance, lowerer) {
            return;
        }
        if let Some(first) = self.module_at.get(instance.name.name.as_str()) {
            let message = format!("the module `{}` is defined twice", instance.name.name);
            lowerer.again(instance.name.span, message, *first, ["defined again", "defined here first"]);
        }
        self.module_at.entry(&instance.name.name).or_insert(instance.name.span);
        self.commands += instance.module.commands.len();
        for declaration in &instance.module.variables {
            let (name, _) = lowerer.scope.rename(&declaration.name.name, instance.env);
            let span = instance.copy.map_or(declaration.name.span, |c| c.name.span);
            if let Some(copy) = instance.copy.filter(|_| name == declaration.name.name) {
                let message =
                    format!("the copy must rename the variable `{name}` of `{}`", instance.module.name.name);
                let diagnostic = lowerer.wrong(copy.name.span, message);
                let help = format!("add `{name}=…` to the list of renamings");
                let diagnostic =
                    diagnostic.help(help).related(declaration.name.span.range(), "declared here");
                lowerer.report(diagnostic);
                continue;
            }
            let (env, module) = (instance.env, Some(self.modules.len()));
            self.variables.push(Declared { declaration, name: name.to_owned(), env, module, span });
        }
        self.modules.push(instance);
    }
}

type ByName<'a, T> = AHashMap<&'a str, &'a T>;

/// Returns the modules and the copies of modules by name.
fn bases(model: &Model) -> (ByName<'_, Module>, ByName<'_, RenamedModule>) {
    let (mut plain, mut copies) = (AHashMap::new(), AHashMap::new());
    for item in &model.items {
        match item {
            Item::Module(m) => {
                plain.insert(m.name.name.as_str(), &**m);
            }
            Item::Renamed(r) => {
                copies.insert(r.name.name.as_str(), &**r);
            }
            _ => {}
        }
    }
    (plain, copies)
}

/// Returns the original module of a chain of copies, with all renamings on the way.
fn resolve<'a>(
    copy: &'a RenamedModule,
    plain: &ByName<'a, Module>,
    copies: &ByName<'a, RenamedModule>,
    lowerer: &mut Lowerer<'a>,
) -> Option<Instance<'a>> {
    let (mut at, mut env) = (copy, NO_RENAMING);
    for _ in 0..=copies.len().min(MOST_RENAMINGS) {
        env = add_renaming(at, env, lowerer);
        if let Some(&module) = plain.get(at.base.name.as_str()) {
            return Some(Instance { name: &copy.name, module, env, copy: Some(copy) });
        }
        match copies.get(at.base.name.as_str()) {
            Some(&next) => at = next,
            None => return lowerer.fail(at.base.span, format!("unknown module `{}`", at.base.name)),
        }
    }
    let name = &copy.name.name;
    let message = if copies.len() < MOST_RENAMINGS {
        format!("the module `{name}` is a copy of itself")
    } else {
        format!("`{name}` is a copy of a copy in more than {MOST_RENAMINGS} steps")
    };
    lowerer.fail(copy.base.span, message)
}

fn add_renaming<'a>(copy: &'a RenamedModule, then: Env, lowerer: &mut Lowerer<'a>) -> Env {
    let mut map = AHashMap::new();
    for (old, new) in &copy.renames {
        if map.insert(old.name.as_str(), new.name.as_str()).is_some() {
            lowerer.fail::<()>(old.span, format!("`{}` is renamed twice", old.name));
        }
    }
    lowerer.scope.renamings.push(Renaming { map, then });
    u32::try_from(lowerer.scope.renamings.len()).unwrap_or(u32::MAX)
}

impl<'a> Lowerer<'a> {
    /// Declares constants, formulas and variables; reports names that are declared twice.
    pub(super) fn declare(&mut self, parts: &Parts<'a>) {
        for c in &parts.constants {
            self.define(&c.name, c.value, Some(c.ty.ty()));
        }
        for f in &parts.formulas {
            self.define(&f.name, Some(f.body), None);
        }
        for (index, variable) in parts.variables.iter().enumerate() {
            let ty = if variable.declaration.range.is_some() { Type::Int } else { Type::Bool };
            let id = VarId(u32::try_from(index).unwrap_or(u32::MAX));
            self.name_once(Cow::Owned(variable.name.clone()), Symbol::Variable(id, ty), variable.span);
        }
    }

    fn define(&mut self, name: &'a Ident, body: Option<Span>, constant: Option<Type>) {
        let symbol = Symbol::Definition(u32::try_from(self.scope.definitions.len()).unwrap_or(u32::MAX));
        self.scope.definitions.push(Definition { name: &name.name, span: name.span, body, constant });
        self.name_once(Cow::Borrowed(&name.name), symbol, name.span);
    }

    fn name_once(&mut self, name: Cow<'a, str>, symbol: Symbol, span: Span) {
        if let Some(&(_, first)) = self.scope.symbols.get(&name) {
            self.declared_twice(&name, span, first);
            return;
        }
        self.scope.symbols.insert(name, (symbol, span));
    }
}
