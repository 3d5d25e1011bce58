//! Commands of modules.

use ahash::AHashMap;

use super::actions::Actions;
use super::collect::{Instance, Parts};
use super::expr::Body;
use super::lowerer::Lowerer;
use super::scope::Symbol;
use crate::ast::{self, Assignment, Span};
use meliora_base::value::{Type, Value};
use meliora_model::expr::ExprId;
use meliora_model::{Branch, Command, Updates, VarId};

/// The module of a command.
#[derive(Clone, Copy)]
struct Inside<'p, 'a> {
    instance: &'p Instance<'a>,
    module: usize,
    /// True if the command has an action.
    labelled: bool,
    parts: &'p Parts<'a>,
}

impl<'a> Lowerer<'a> {
    /// Returns the actions, and all commands ordered by module.
    pub(super) fn commands(&mut self, parts: &Parts<'a>) -> (Actions, Option<Vec<Command>>) {
        let mut actions = Actions::default();
        let mut commands = Vec::new();
        for (module, instance) in parts.modules.iter().enumerate() {
            for &place in &instance.module.commands {
                let Some(command) = self.read_command(place) else {
                    commands.push(None);
                    continue;
                };
                let action =
                    command.action.as_ref().map(|a| actions.add(self.scope.rename(&a.name, instance.env).0));
                let number = actions.next_number(module, action);
                let inside = Inside { instance, module, labelled: action.is_some(), parts };
                let lowered = self.command(&command, inside);
                commands.push(lowered.map(|c| Command { action, number, ..c }));
            }
        }
        (actions, commands.into_iter().collect())
    }

    fn command(&mut self, command: &ast::Command, inside: Inside<'_, 'a>) -> Option<Command> {
        let guard = self.condition(&command.guard, inside.instance.env, "a guard");
        let branches: Vec<_> = command.branches.iter().map(|branch| self.branch(branch, inside)).collect();
        Some(Command {
            module: inside.module,
            action: None,
            number: 0,
            unlisted: None,
            guard: guard?,
            branches: branches.into_iter().collect::<Option<_>>()?,
            span: command.span,
        })
    }

    fn branch(&mut self, branch: &ast::Branch, inside: Inside<'_, 'a>) -> Option<Branch> {
        let probability = match &branch.probability {
            Some(e) => self.typed(e, inside.instance.env, Type::Real, "a probability"),
            None => self.literal(Value::Real(1.0)),
        };
        let mut updates: Vec<Option<(VarId, ExprId)>> = Vec::new();
        let mut met: AHashMap<&str, Span> = AHashMap::new();
        for assignment in &branch.updates {
            let update = self.assignment(assignment, inside);
            if let Some(first) = met.insert(&assignment.variable.name, assignment.variable.span) {
                let message = format!("`{}` is updated twice in one branch", assignment.variable.name);
                let labels = ["updated again", "updated here first"];
                self.again(assignment.variable.span, message, first, labels);
            }
            updates.push(update);
        }
        let updates: Updates = updates.into_iter().collect::<Option<_>>()?;
        self.check_distinct(&updates, branch, inside.parts)?;
        Some(Branch { probability: probability?, updates })
    }

    /// Checks that no variable is updated twice: a renaming can map two variables to one.
    fn check_distinct(
        &mut self,
        updates: &[(VarId, ExprId)],
        branch: &ast::Branch,
        parts: &Parts<'a>,
    ) -> Option<()> {
        let mut variables: Vec<VarId> = updates.iter().map(|u| u.0).collect();
        variables.sort_unstable();
        let names: ahash::AHashSet<&str> = branch.updates.iter().map(|a| a.variable.name.as_str()).collect();
        match variables.windows(2).find(|pair| pair[0] == pair[1]) {
            // A repeated name has been reported before.
            Some(_) if names.len() < branch.updates.len() => None,
            Some(pair) => {
                let name = &parts.variables[pair[0].index()].name;
                self.fail(branch.span, format!("`{name}` is updated twice in one branch"))
            }
            None => Some(()),
        }
    }

    fn assignment(&mut self, assignment: &Assignment, inside: Inside<'_, 'a>) -> Option<(VarId, ExprId)> {
        let Inside { instance, module, labelled, parts } = inside;
        let value = assignment.value.lowered(self, instance.env);
        let (name, _) = self.scope.rename(&assignment.variable.name, instance.env);
        let span = assignment.variable.span;
        let Some(Symbol::Variable(variable, ty)) = self.scope.symbol(name) else {
            let is_known = self.scope.symbol(name).is_some();
            let known = if is_known { "is not a variable" } else { "is unknown" };
            let mut diagnostic = self.wrong(span, format!("`{name}` cannot be updated: it {known}"));
            if let Some(similar) = self.scope.similar(name).filter(|_| !is_known) {
                diagnostic = diagnostic.help(format!("did you mean `{similar}`?"));
            }
            self.report(diagnostic);
            return None;
        };
        let declared = &parts.variables[variable.index()];
        match declared.module {
            Some(owner) if owner != module => {
                let owner = &parts.modules[owner].name.name;
                let message = format!("the module `{}` cannot update `{name}`", instance.name.name);
                let diagnostic =
                    self.wrong(span, message).label(format!("a variable of the module `{owner}`"));
                self.report(
                    diagnostic.help("only its own module can update a variable, unless it is `global`"),
                );
                return None;
            }
            // As in PRISM-games; `Lowerer::check_globals` looks for conflicts.
            None if labelled && !parts.is_game => {
                let message = format!("a command with an action cannot update the global variable `{name}`");
                let diagnostic = self.wrong(span, message).label("global");
                self.report(diagnostic.help("remove the action, `[]`, or move the variable into one module"));
                return None;
            }
            _ => {}
        }
        let what = format!("the new value of `{name}`");
        Some((variable, self.finished(value, ty, &what)?))
    }
}
