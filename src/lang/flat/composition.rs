//! Labels of the commands in the text, and the `system` block that restores the synchronisations
//! from them.
//!
//! A composition may synchronise one command with different partners, and may rename or hide the
//! result. Such a synchronisation has its own label, which only its commands have. Full parallel
//! composition of the modules then makes exactly this synchronisation, and the `system` block
//! renames or hides its label. A command that takes part in several such synchronisations is
//! written once for each. One that takes part in none can never be executed and is left out.

use meliora_model::{Command, CommandId, Program, Synchronisation};

/// Labels of the commands of a program in its text.
pub(super) struct Composition {
    /// Commands sorted by module, each paired with the index of every label that it is written
    /// with.
    commands: Vec<(CommandId, u32)>,
    /// Labels; an unlabelled synchronisation has the empty text.
    labels: Vec<String>,
    /// Labels with the action that they stand for, `None` if it is hidden.
    renamed: Vec<(String, Option<usize>)>,
}

impl Composition {
    pub(super) fn new(program: &Program) -> Self {
        let prefix = free_prefix(program);
        let partners = Partners::new(program);
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

    /// Returns the commands of a module, each paired with every label that it is written with.
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

    /// Returns the `system` block, `None` if full parallel composition is enough.
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

/// Counts that tell if a label identifies its synchronisation.
struct Partners {
    /// For each action, the number of commands that have it as their label.
    commands: Vec<usize>,
    /// For each command, the number of synchronisations that it takes part in.
    moves: Vec<usize>,
}

impl Partners {
    fn new(program: &Program) -> Self {
        let mut commands = vec![0; program.actions.len()];
        program.commands.iter().filter_map(|c| c.action).for_each(|a| commands[a] += 1);
        let mut moves = vec![0; program.commands.len()];
        let all = program.synchronisations.iter().flat_map(|s| s.factors.iter().flatten());
        all.for_each(|id| moves[id.index()] += 1);
        Partners { commands, moves }
    }

    /// Returns the label if it makes this synchronisation alone: all commands that have it take
    /// part in this one and in no other.
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

/// Returns a prefix that no name of the program starts with.
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
