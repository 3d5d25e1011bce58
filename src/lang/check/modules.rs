//! Commands of modules.

use ahash::AHashMap;

use super::collect::{Instance, Parts};
use super::lower::Lowerer;
use super::read::Lowered;
use super::scope::Symbol;
use crate::lang::ast::{self, Assignment, Span};
use crate::model::expr::ExprId;
use crate::model::value::{Type, Value};
use crate::model::{Branch, Command, Updates, VarId};

/// Names in the order of their first occurrence.
#[derive(Default)]
pub(super) struct Names {
    pub(super) names: Vec<String>,
    index: AHashMap<String, usize>,
}

impl Names {
    /// Returns the position of a name, which is added if it is new.
    pub(super) fn add(&mut self, name: &str) -> usize {
        if let Some(&index) = self.index.get(name) {
            return index;
        }
        self.names.push(name.to_owned());
        self.index.insert(name.to_owned(), self.names.len() - 1);
        self.names.len() - 1
    }

    pub(super) fn get(&self, name: &str) -> Option<usize> {
        self.index.get(name).copied()
    }
}

impl<'a> Lowerer<'a> {
    /// Returns the actions, and all commands ordered by module.
    pub(super) fn commands(&mut self, parts: &Parts<'a>) -> (Names, Option<Vec<Command>>) {
        let mut actions = Names::default();
        let mut commands = Vec::new();
        for (module, instance) in parts.modules.iter().enumerate() {
            let mut numbers: AHashMap<Option<usize>, usize> = AHashMap::new();
            for &place in &instance.module.commands {
                let Some(command) = self.read_command(place, instance.env) else {
                    commands.push(None);
                    continue;
                };
                let action =
                    command.action.as_ref().map(|a| actions.add(self.scope.rename(&a.name, instance.env).0));
                let number = numbers.entry(action).or_default();
                *number += 1;
                let number = *number;
                let lowered = self.command(&command, instance, module, parts);
                commands.push(lowered.map(|c| Command { action, number, ..c }));
            }
        }
        (actions, commands.into_iter().collect())
    }

    fn command(
        &mut self,
        command: &ast::Command<Lowered>,
        instance: &Instance<'a>,
        module: usize,
        parts: &Parts<'a>,
    ) -> Option<Command> {
        let guard = self.condition(&command.guard, instance.env, "a guard");
        let branches: Vec<_> = command
            .branches
            .iter()
            .map(|branch| self.branch(branch, command.action.is_some(), instance, module, parts))
            .collect();
        Some(Command {
            module,
            action: None,
            number: 0,
            guard: guard?,
            branches: branches.into_iter().collect::<Option<_>>()?,
            span: command.span,
        })
    }

    fn branch(
        &mut self,
        branch: &ast::Branch<Lowered>,
        labelled: bool,
        instance: &Instance<'a>,
        module: usize,
        parts: &Parts<'a>,
    ) -> Option<Branch> {
        let probability = match &branch.probability {
            Some(e) => self.typed(e, instance.env, Type::Real, "a probability"),
            None => self.literal(Value::Real(1.0)),
        };
        let mut updates: Vec<Option<(VarId, ExprId)>> = Vec::new();
        let mut met: AHashMap<&str, Span> = AHashMap::new();
        for assignment in &branch.updates {
            let update = self.assignment(assignment, labelled, instance, module, parts);
            if let Some(first) = met.insert(&assignment.variable.name, assignment.variable.span) {
                let message = format!("`{}` is updated twice in one branch", assignment.variable.name);
                let diagnostic = self.wrong(assignment.variable.span, message).label("updated again");
                self.report(diagnostic.related(first.range(), "updated here first"));
            }
            updates.push(update);
        }
        let updates: Updates = updates.into_iter().collect::<Option<_>>()?;
        self.check_distinct(&updates, branch, parts)?;
        Some(Branch { probability: probability?, updates })
    }

    /// Checks that no variable is updated twice: a renaming can map two variables to one.
    fn check_distinct(
        &mut self,
        updates: &[(VarId, ExprId)],
        branch: &ast::Branch<Lowered>,
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

    fn assignment(
        &mut self,
        assignment: &Assignment<Lowered>,
        labelled: bool,
        instance: &Instance<'a>,
        module: usize,
        parts: &Parts<'a>,
    ) -> Option<(VarId, ExprId)> {
        let value = self.expr(&assignment.value, instance.env);
        let (name, _) = self.scope.rename(&assignment.variable.name, instance.env);
        let span = assignment.variable.span;
        let Some(Symbol::Variable(variable, ty)) = self.scope.symbol(name) else {
            let known = if self.scope.symbol(name).is_some() { "is not a variable" } else { "is unknown" };
            return self.fail(span, format!("`{name}` cannot be updated: it {known}"));
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
            None if labelled => {
                let message = format!("a command with an action cannot update the global variable `{name}`");
                let diagnostic = self.wrong(span, message).label("global");
                self.report(diagnostic.help("remove the action, `[]`, or move the variable into one module"));
                return None;
            }
            _ => {}
        }
        let what = format!("the new value of `{name}`");
        let value = self.expect_type(value?, ty, assignment.value.1, &what)?;
        Some((variable, self.whole(value, assignment.value.1)?))
    }
}
