//! Which labels commands are written with, and the `system` block that makes the program's moves of them.
//!
//! A composition may let one command move with one partner here and with another one there, and may
//! rename or hide what comes of it. Such a move gets a label of its own: only its commands have it, so
//! putting all modules in parallel makes that move and no other, and the `system` block then renames
//! or hides the label. A command that takes part in several such moves is written once for each; one
//! that takes part in none can never move and is left out.

use crate::model::{Command, CommandId, Program, Synchronisation};

/// How the commands of a program are labelled in its text.
pub(super) struct Composition {
    /// The commands module by module, each with the number of every label that it is written with.
    commands: Vec<(CommandId, u32)>,
    /// The labels, an empty text for none.
    labels: Vec<String>,
    /// Labels with the action that they stand for; none for those that are hidden.
    renamed: Vec<(String, Option<usize>)>,
}

impl Composition {
    pub(super) fn of(program: &Program) -> Self {
        let prefix = free_prefix(program);
        let partners = Partners::of(program);
        let (mut commands, mut labels, mut renamed) = (Vec::new(), Vec::new(), Vec::new());
        for (index, step) in program.synchronisations.iter().enumerate() {
            let label = match partners.own_label(program, step) {
                Some(label) => label.to_owned(),
                None => {
                    let label = format!("{prefix}{index}");
                    renamed.push((label.clone(), step.action));
                    label
                }
            };
            commands.extend(step.factors.iter().flatten().map(|&id| (id, index as u32)));
            labels.push(label);
        }
        commands.sort_unstable_by_key(|&(id, label)| (program.commands[id.index()].module, id, label));
        Composition { commands, labels, renamed }
    }

    /// The commands of a module, each with every label that it is written with.
    pub(super) fn commands<'p>(
        &self,
        program: &'p Program,
        module: usize,
    ) -> impl Iterator<Item = (&'p Command, &str)> {
        let of = |&(id, _): &(CommandId, u32)| program.commands[id.index()].module;
        let start = self.commands.partition_point(|c| of(c) < module);
        let own = self.commands[start..].iter().take_while(move |c| of(c) == module);
        own.map(|&(id, label)| (&program.commands[id.index()], self.labels[label as usize].as_str()))
    }

    /// The `system` block; none where full parallel composition is what is meant.
    pub(super) fn system(&self, program: &Program) -> Option<String> {
        if self.renamed.is_empty() {
            return None;
        }
        let mut text = format!("system ({})", program.modules.join(" || "));
        let list = |all: Vec<String>| all.join(", ");
        let hidden = self.renamed.iter().filter(|(_, action)| action.is_none());
        let hidden: Vec<String> = hidden.map(|(label, _)| label.clone()).collect();
        if !hidden.is_empty() {
            text += &format!(" / {{{}}}", list(hidden));
        }
        let rename = |(label, action): &(String, Option<usize>)| {
            action.map(|a| format!("{label}<-{}", program.actions[a]))
        };
        let renames: Vec<String> = self.renamed.iter().filter_map(rename).collect();
        if !renames.is_empty() {
            text += &format!(" {{{}}}", list(renames));
        }
        Some(text + " endsystem")
    }
}

/// What can be seen of a label from the commands that have it.
struct Partners {
    /// For each action how many commands have it as their label.
    commands: Vec<usize>,
    /// For each command in how many synchronisations it takes part.
    moves: Vec<usize>,
}

impl Partners {
    fn of(program: &Program) -> Self {
        let mut commands = vec![0; program.actions.len()];
        program.commands.iter().filter_map(|c| c.action).for_each(|a| commands[a] += 1);
        let mut moves = vec![0; program.commands.len()];
        let all = program.synchronisations.iter().flat_map(|s| s.factors.iter().flatten());
        all.for_each(|id| moves[id.index()] += 1);
        Partners { commands, moves }
    }

    /// The label that makes this move by itself: all commands that have it take part, in nothing else.
    fn own_label<'p>(&self, program: &'p Program, step: &Synchronisation) -> Option<&'p str> {
        let own = |id: &CommandId| {
            program.commands[id.index()].action == step.action && self.moves[id.index()] == 1
        };
        let count = step.factors.iter().map(Vec::len).sum::<usize>();
        let all_own = step.factors.iter().flatten().all(own);
        match step.action {
            None => (all_own && step.factors.len() == 1).then_some(""),
            Some(a) => (all_own && self.commands[a] == count).then(|| program.actions[a].as_str()),
        }
    }
}

/// A beginning that no name of the program has.
fn free_prefix(program: &Program) -> String {
    let mut prefix = "s_".to_owned();
    let names = || {
        let variables = program.variables.iter().map(|v| &v.name);
        let constants = program.constants.iter().map(|c| &c.0);
        variables.chain(constants).chain(&program.actions).chain(&program.modules)
    };
    while names().any(|name| name.starts_with(&prefix)) {
        prefix.insert(0, 's');
    }
    prefix
}
