//! Composition of modules (`system … endsystem`, or full parallel) into a flat list of
//! synchronisations.

use std::collections::{BTreeMap, BTreeSet};

use ahash::{AHashMap, AHashSet};

use super::actions::Actions;
use super::collect::Parts;
use super::lowerer::Lowerer;
use crate::ast::{Ident, Span, System, SystemKind};
use meliora_model::{Command, CommandId, Synchronisation, VarId};

/// Maximum number of synchronisations of a composition.
pub(super) const MAX_SYNCHRONISATIONS: usize = 100_000;

/// The behaviour of a part of a composition.
#[derive(Debug, Clone, Default)]
struct Process {
    /// Actions that it takes part in, even if it never has a step for them.
    alphabet: BTreeSet<usize>,
    moves: Vec<Synchronisation>,
}

/// Synchronisations by their action.
type ByAction = BTreeMap<usize, Vec<Synchronisation>>;

impl Process {
    /// Splits the synchronisations: those without an action in `actions`, and those of each action
    /// of the set.
    fn split(self, actions: &BTreeSet<usize>) -> (Vec<Synchronisation>, ByAction) {
        let mut with: ByAction = actions.iter().map(|&a| (a, Vec::new())).collect();
        let mut without = Vec::new();
        for step in self.moves {
            match step.action.and_then(|a| with.get_mut(&a)) {
                Some(same) => same.push(step),
                None => without.push(step),
            }
        }
        (without, with)
    }
}

impl<'a> Lowerer<'a> {
    /// Returns the names of all actions, and the synchronisations of the model.
    pub(super) fn synchronisations(
        &mut self,
        parts: &Parts<'a>,
        commands: &Option<Vec<Command>>,
        mut actions: Actions,
    ) -> Option<(Vec<String>, Vec<Synchronisation>)> {
        let processes = processes(parts.modules.len(), commands.as_deref().unwrap_or(&[]));
        let whole = match parts.system {
            None => self.full(processes, Span::default()),
            Some(system) => {
                self.check_modules(system, parts);
                let mut composition = Composition { parts, processes: &processes, actions: &mut actions };
                let whole = composition.process(system, self);
                whole.filter(|_| self.diagnostics.is_empty())
            }
        }?;
        let mut moves = whole.moves;
        // A stable sort: within one action, and among unlabelled synchronisations, the order of the
        // text stays.
        moves.sort_by_key(|m| m.action);
        let commands = commands.as_ref()?;
        if parts.is_game {
            self.check_globals(parts, commands, &moves);
        }
        Some((actions.names, moves))
    }

    /// Reports global variables that two commands update together.
    fn check_globals(&mut self, parts: &Parts<'a>, commands: &[Command], moves: &[Synchronisation]) {
        for step in moves.iter().filter(|step| step.factors.len() > 1) {
            let mut writers: AHashMap<VarId, &Command> = AHashMap::new();
            for command in step.factors.iter().flatten().map(|id| &commands[id.index()]) {
                for (variable, _) in command.branches.iter().flat_map(|branch| &branch.updates) {
                    let first = *writers.entry(*variable).or_insert(command);
                    // A variable that is not global has one module.
                    if first.module != command.module {
                        self.report_conflict(parts, *variable, [first, command]);
                    }
                }
            }
        }
    }

    fn report_conflict(&mut self, parts: &Parts<'a>, variable: VarId, [first, second]: [&Command; 2]) {
        let module = |command: &Command| &parts.modules[command.module].name.name;
        let name = &parts.variables[variable.index()].name;
        let message = format!("two commands update the global variable `{name}` together");
        let diagnostic =
            self.wrong(second.span, message).label(format!("updated by the module `{}`", module(second)));
        let related = format!("updated by the module `{}`, too", module(first));
        let help = "only one of the modules that synchronise can update a global variable";
        self.report(diagnostic.related(first.span.range(), related).help(help));
    }

    /// Checks that each module occurs once in the composition.
    fn check_modules(&mut self, system: &System, parts: &Parts<'a>) {
        let mut seen: Vec<(&str, Span)> = Vec::new();
        modules_of(system, &mut seen);
        let known: AHashSet<&str> = parts.modules.iter().map(|m| m.name.name.as_str()).collect();
        let mut met: AHashMap<&str, Span> = AHashMap::new();
        for (name, span) in seen {
            if !known.contains(name) {
                self.fail::<()>(span, format!("unknown module `{name}`"));
            } else if let Some(first) = met.insert(name, span) {
                let diagnostic =
                    self.wrong(span, format!("the module `{name}` occurs twice in the composition"));
                self.report(diagnostic.related(first.range(), "first occurrence"));
            }
        }
        for module in &parts.modules {
            let name = &module.name.name;
            if !met.contains_key(name.as_str()) {
                let message = format!("the module `{name}` does not occur in the composition");
                let diagnostic =
                    self.wrong(system.span, message).help("every module must occur exactly once");
                self.report(diagnostic);
            }
        }
    }

    /// Composes all operands, synchronised on each action that several of them have.
    fn full(&mut self, operands: Vec<Process>, span: Span) -> Option<Process> {
        let mut whole = Process::default();
        let mut participants: BTreeMap<usize, Vec<Vec<Synchronisation>>> = BTreeMap::new();
        for operand in operands {
            whole.alphabet.extend(&operand.alphabet);
            let alphabet = operand.alphabet.clone();
            let (mut alone, together) = operand.split(&alphabet);
            whole.moves.append(&mut alone);
            for (action, moves) in together {
                participants.entry(action).or_default().push(moves);
            }
        }
        for (action, participants) in participants {
            let mut joint = vec![Synchronisation { action: Some(action), factors: Vec::new() }];
            for moves in participants {
                let size = joint.len().saturating_mul(moves.len()).saturating_add(whole.moves.len());
                self.check_size(size, span)?;
                joint = join(&joint, &moves);
            }
            whole.moves.append(&mut joint);
        }
        Some(whole)
    }

    /// Composes two operands, synchronised on the given actions, which need a step of both.
    fn parallel(&mut self, a: Process, b: Process, on: &BTreeSet<usize>, span: Span) -> Option<Process> {
        let alphabet = a.alphabet.union(&b.alphabet).copied().collect();
        let ((mut moves, left), (mut others, right)) = (a.split(on), b.split(on));
        moves.append(&mut others);
        for (left, right) in left.values().zip(right.values()) {
            let size = left.len().saturating_mul(right.len()).saturating_add(moves.len());
            self.check_size(size, span)?;
            moves.extend(join(left, right));
        }
        Some(Process { alphabet, moves })
    }

    fn check_size(&mut self, size: usize, span: Span) -> Option<()> {
        if size <= MAX_SYNCHRONISATIONS {
            return Some(());
        }
        self.fail(span, format!("the composition has more than {MAX_SYNCHRONISATIONS} synchronisations"))
    }
}

/// Combines every synchronisation of the left side with every one of the right side.
fn join(left: &[Synchronisation], right: &[Synchronisation]) -> Vec<Synchronisation> {
    let mut all = Vec::with_capacity(left.len().saturating_mul(right.len()));
    for a in left {
        for b in right {
            let factors = a.factors.iter().chain(&b.factors).cloned().collect();
            all.push(Synchronisation { action: a.action, factors });
        }
    }
    all
}

/// Returns the modules as separate processes.
fn processes(modules: usize, commands: &[Command]) -> Vec<Process> {
    let mut processes = vec![Process::default(); modules];
    // Position of the synchronisation of each module and action.
    let mut known: AHashMap<(usize, Option<usize>), usize> = AHashMap::new();
    for (index, command) in commands.iter().enumerate() {
        let process = &mut processes[command.module];
        let id = CommandId(u32::try_from(index).unwrap_or(u32::MAX));
        process.alphabet.extend(command.action);
        match known.get(&(command.module, command.action)) {
            Some(&at) => process.moves[at].factors[0].push(id),
            None => {
                known.insert((command.module, command.action), process.moves.len());
                process.moves.push(Synchronisation { action: command.action, factors: vec![vec![id]] });
            }
        }
    }
    processes
}

fn modules_of<'s>(system: &'s System, seen: &mut Vec<(&'s str, Span)>) {
    match &system.kind {
        SystemKind::Module(name) => seen.push((name, system.span)),
        SystemKind::Full(parts) | SystemKind::Interleaved(parts) => {
            parts.iter().for_each(|p| modules_of(p, seen));
        }
        SystemKind::Parallel(a, _, b) => {
            modules_of(a, seen);
            modules_of(b, seen);
        }
        SystemKind::Hide(inner, _) | SystemKind::Rename(inner, _) => modules_of(inner, seen),
    }
}

/// Context for the operators of a composition.
struct Composition<'c, 'a> {
    parts: &'c Parts<'a>,
    processes: &'c [Process],
    actions: &'c mut Actions,
}

impl<'a> Composition<'_, 'a> {
    fn process(&mut self, system: &System, lowerer: &mut Lowerer<'a>) -> Option<Process> {
        match &system.kind {
            SystemKind::Module(name) => {
                let index = self.parts.modules.iter().position(|m| m.name.name == *name)?;
                self.processes.get(index).cloned()
            }
            SystemKind::Full(operands) => {
                let operands = self.operands(operands, lowerer)?;
                lowerer.full(operands, system.span)
            }
            SystemKind::Interleaved(operands) => {
                let mut whole = Process::default();
                for mut operand in self.operands(operands, lowerer)? {
                    whole.alphabet.append(&mut operand.alphabet);
                    whole.moves.append(&mut operand.moves);
                }
                Some(whole)
            }
            SystemKind::Parallel(a, on, b) => {
                let (a, b) = (self.process(a, lowerer), self.process(b, lowerer));
                let on = self.known(on, lowerer)?;
                lowerer.parallel(a?, b?, &on, system.span)
            }
            SystemKind::Hide(inner, hidden) => {
                let inner = self.process(inner, lowerer);
                let hidden = self.known(hidden, lowerer)?;
                Some(hide(inner?, &hidden))
            }
            SystemKind::Rename(inner, renames) => {
                let inner = self.process(inner, lowerer);
                let renames = self.renames(renames, lowerer)?;
                Some(rename(inner?, &renames))
            }
        }
    }

    fn operands(&mut self, operands: &[System], lowerer: &mut Lowerer<'a>) -> Option<Vec<Process>> {
        let all: Vec<_> = operands.iter().map(|o| self.process(o, lowerer)).collect();
        all.into_iter().collect()
    }

    /// Resolves actions that some module has, or that a renaming has made.
    fn known(&self, names: &[Ident], lowerer: &mut Lowerer<'a>) -> Option<BTreeSet<usize>> {
        let look_up = |name: &Ident| match self.actions.get(&name.name) {
            Some(action) => Some(action),
            None => lowerer.fail(name.span, format!("unknown action `{}`", name.name)),
        };
        let all: Vec<_> = names.iter().map(look_up).collect();
        all.into_iter().collect()
    }

    fn renames(
        &mut self,
        renames: &[(Ident, Ident)],
        lowerer: &mut Lowerer<'a>,
    ) -> Option<Vec<(usize, usize)>> {
        let mut all: Vec<(usize, usize)> = Vec::new();
        for (old, new) in renames {
            let Some(from) = self.actions.get(&old.name) else {
                lowerer.fail::<()>(old.span, format!("unknown action `{}`", old.name));
                return None;
            };
            if all.iter().any(|(f, _)| *f == from) {
                return lowerer.fail(old.span, format!("the action `{}` is renamed twice", old.name));
            }
            all.push((from, self.actions.add(&new.name)));
        }
        Some(all)
    }
}

fn hide(mut process: Process, hidden: &BTreeSet<usize>) -> Process {
    process.alphabet.retain(|a| !hidden.contains(a));
    for step in &mut process.moves {
        step.action = step.action.filter(|a| !hidden.contains(a));
    }
    process
}

fn rename(mut process: Process, renames: &[(usize, usize)]) -> Process {
    let new = |a: usize| renames.iter().find(|(from, _)| *from == a).map_or(a, |(_, to)| *to);
    process.alphabet = process.alphabet.into_iter().map(new).collect();
    for step in &mut process.moves {
        step.action = step.action.map(new);
    }
    process
}
