//! Sorts the parts of a model, finds the base of each renamed module, and declares all names.

use std::borrow::Cow;

use ahash::AHashMap;

use super::limits::MOST_RENAMINGS;
use super::lower::Lowerer;
use super::scope::{Definition, Env, NO_RENAMING, Renaming, Symbol};
use crate::lang::ast::{
    ConstDef, FormulaDef, Ident, Item, LabelDef, ModelType, Module, RenamedModule, Rewards, Span, System,
    VarDecl,
};
use crate::lang::parse::Outline;
use crate::model::VarId;
use crate::model::value::Type;

/// A module, or a renamed copy of one.
pub(super) struct Instance<'a> {
    pub(super) name: &'a Ident,
    pub(super) module: &'a Module<Span, Span>,
    /// Renaming to apply to the module.
    pub(super) env: Env,
    /// Declaration of the copy, if it is one; used in messages.
    pub(super) copy: Option<&'a RenamedModule>,
}

/// A variable declaration, with its module and the renaming that applies to it.
pub(super) struct Declared<'a> {
    pub(super) declaration: &'a VarDecl<Span>,
    pub(super) name: String,
    pub(super) env: Env,
    pub(super) module: Option<usize>,
    /// Place for messages about it.
    pub(super) span: Span,
}

/// The parts of a model, sorted by kind.
pub(super) struct Parts<'a> {
    pub(super) kind: ModelType,
    pub(super) constants: Vec<&'a ConstDef<Span>>,
    pub(super) formulas: Vec<&'a FormulaDef<Span>>,
    pub(super) labels: Vec<&'a LabelDef<Span>>,
    pub(super) modules: Vec<Instance<'a>>,
    /// Total number of commands of the modules.
    pub(super) commands: usize,
    pub(super) variables: Vec<Declared<'a>>,
    pub(super) init: Option<Span>,
    pub(super) system: Option<&'a System>,
    pub(super) rewards: Vec<&'a Rewards<Span>>,
    /// First place of each label and of each module.
    label_at: AHashMap<&'a str, Span>,
    module_at: AHashMap<&'a str, Span>,
}

impl Default for Parts<'_> {
    fn default() -> Self {
        Parts {
            kind: ModelType::Mdp,
            constants: Vec::new(),
            formulas: Vec::new(),
            labels: Vec::new(),
            modules: Vec::new(),
            commands: 0,
            variables: Vec::new(),
            init: None,
            system: None,
            rewards: Vec::new(),
            label_at: AHashMap::new(),
            module_at: AHashMap::new(),
        }
    }
}

impl<'a> Parts<'a> {
    /// Fills in everything; reports parts that occur twice and copies without a base.
    pub(super) fn collect(&mut self, model: &'a Outline, lowerer: &mut Lowerer<'a>) {
        self.kind = model.kind.map_or(ModelType::Mdp, |(kind, _)| kind);
        self.constants = super::constants(model).collect();
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
                Item::Const(_) => {}
            }
        }
        if self.modules.is_empty() && lowerer.diagnostics.is_empty() {
            let end = Span::new(lowerer.source.text.len(), lowerer.source.text.len());
            let diagnostic = lowerer.wrong(end, "the model has no module");
            lowerer.report(diagnostic);
        }
    }

    fn label(&mut self, label: &'a LabelDef<Span>, lowerer: &mut Lowerer<'a>) {
        if let Some(first) = self.label_at.get(label.name.name.as_str()) {
            let message = format!("the label \"{}\" is defined twice", label.name.name);
            let diagnostic = lowerer.wrong(label.name.span, message).label("defined again");
            lowerer.report(diagnostic.related(first.range(), "defined here first"));
        }
        self.label_at.entry(&label.name.name).or_insert(label.name.span);
        self.labels.push(label);
    }

    fn init(&mut self, e: Span, lowerer: &mut Lowerer<'a>) {
        if let Some(first) = self.init.replace(e) {
            let diagnostic = lowerer.wrong(e, "there are several `init … endinit`").label("again");
            lowerer.report(diagnostic.related(first.range(), "the first one"));
        }
    }

    fn system(&mut self, s: &'a System, lowerer: &mut Lowerer<'a>) {
        if let Some(first) = self.system.replace(s) {
            let diagnostic = lowerer.wrong(s.span, "there are several `system … endsystem`").label("again");
            lowerer.report(diagnostic.related(first.span.range(), "the first one"));
        }
    }

    fn instance(&mut self, instance: Instance<'a>, lowerer: &mut Lowerer<'a>) {
        if !lowerer.fits(self, &instance) {
            return;
        }
        if let Some(first) = self.module_at.get(instance.name.name.as_str()) {
            let message = format!("the module `{}` is defined twice", instance.name.name);
            let diagnostic = lowerer.wrong(instance.name.span, message).label("defined again");
            lowerer.report(diagnostic.related(first.range(), "defined here first"));
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
fn bases(model: &Outline) -> (ByName<'_, Module<Span, Span>>, ByName<'_, RenamedModule>) {
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
    plain: &ByName<'a, Module<Span, Span>>,
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
            let diagnostic = lowerer.wrong(old.span, format!("`{}` is renamed twice", old.name));
            lowerer.report(diagnostic);
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
            let diagnostic = self.wrong(span, format!("`{name}` is declared twice")).label("declared again");
            self.report(diagnostic.related(first.range(), "declared here first"));
            return;
        }
        self.scope.symbols.insert(name, (symbol, span));
    }
}
