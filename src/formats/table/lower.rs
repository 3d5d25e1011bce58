//! From a table to the flat program.

use std::collections::BTreeMap;
use std::sync::Arc;

use smallvec::SmallVec;

use super::tree::{Leaf, Trees, sorted};
use super::{Column, Rewards, Table};
use meliora_base::error::{Diagnostic, Error, Result, Severity, SourceFile};
use meliora_base::progress::{Poll, ProgressSink};
use meliora_base::span::Span;
use meliora_base::value::{Type, Value};
use meliora_lang::BUILT_IN_LABELS;
use meliora_lang::Checked;
use meliora_lang::Given;
use meliora_lang::names::{Names, renamed};
use meliora_model::expr::{ExprId, ExprPool};
use meliora_model::players::{Player, Players};
use meliora_model::rewards::{Earner, RewardItem, RewardStructure};
use meliora_model::{Branch, Command, CommandId, ModelKind, Program, Synchronisation, VarId, Variable};

/// The variable of the number of a state, if states have no other values.
pub(super) const NUMBER: &str = "state";

/// The sources and options from which a model is read.
pub(crate) struct Frame<'f> {
    /// The text of the model, or a description of its archive.
    pub(crate) source: &'f Arc<SourceFile>,
    pub(crate) given: &'f Given,
    pub(crate) sink: &'f dyn ProgressSink,
}

/// The choices that become one command: the k-th choice of each state of a player with an action and a
/// number of branches.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Group {
    player: usize,
    action: Option<usize>,
    number: usize,
    branches: usize,
}

/// A choice at a position of the sorted states.
type Member = (usize, usize);

/// The parts of the program that are under construction.
struct Lowering<'t> {
    trees: Trees<'t>,
    commands: Vec<Command>,
    poll: Poll<'t>,
}

impl Frame<'_> {
    /// Returns the error for constants or bounds, which these formats do not have.
    pub(super) fn refuse_values(&self) -> Result<()> {
        for (given, what) in
            [(&self.given.constants, "constants"), (&self.given.bounds, "unbounded integers")]
        {
            if !given.text.trim().is_empty() {
                let message = format!("a model that lists its states has no {what}");
                return Err(Diagnostic::new(given, 0..given.text.len(), message).into());
            }
        }
        Ok(())
    }

    fn warning(&self, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(self.source, 0..0, message).severity(Severity::Warning)
    }

    pub(super) fn wrong(&self, message: impl Into<String>) -> Error {
        Diagnostic::new(self.source, 0..0, message).into()
    }

    /// Lowers a table.
    ///
    /// # Errors
    /// The table is not a model; a limit.
    pub(super) fn lower(&self, mut table: Table) -> Result<Checked> {
        let mut poll = Poll::new(self.sink);
        if let Some((state, reason)) = table.first_fault(&mut poll)? {
            let help = "the probabilities of a choice sum to 1; the rates of a CTMC are not supported";
            let wrong = Diagnostic::new(self.source, 0..0, format!("state {state}: {reason}"));
            return Err(wrong.help(help).into());
        }
        table.initial.sort_unstable();
        table.initial.dedup();
        if table.initial.is_empty() {
            return Err(self.wrong("the model has no initial state"));
        }
        let without = table.take_deadlocks();
        let order = table.order(&mut poll)?;
        let [mut names, mut players] = [Names::default(), Names::default()];
        let variables = variables(&table, &mut names);
        table.players.iter_mut().for_each(|name| *name = players.add_of_model(name, Span::default()));
        let mut warnings: Vec<Diagnostic> = table.warnings.iter().map(|w| self.warning(w)).collect();
        for changed in names.changed.iter().chain(&players.changed) {
            let place = table.columns.iter().find(|column| column.name == changed.name);
            let place = place.and_then(|column| column.place.as_ref());
            warnings.push(renamed(place.map_or(self.source, |(source, _)| source), changed));
        }
        let mut pool = std::mem::take(&mut table.pool);
        let trees = Trees::new(&mut pool, &table.columns, order);
        let mut lowering = Lowering { trees, commands: Vec::new(), poll };
        let groups = groups(&table, &lowering.trees.sorted, &without);
        for (group, members) in &groups {
            lowering.command(&table, *group, members)?;
        }
        let rewards = lowering.rewards(&table, &groups)?;
        let (initial, labels) = lowering.labels(&table)?;
        let commands = lowering.commands;
        let program = Program { initial, labels, rewards, ..self.program(table, variables, commands) };
        Ok(Checked { program: Program { pool: pool.into(), ..program }, warnings, properties: Vec::new() })
    }

    /// Returns a program without an initial state, labels, rewards and expressions.
    fn program(&self, table: Table, variables: Vec<Variable>, commands: Vec<Command>) -> Program {
        let mut pool = ExprPool::default();
        let initial = pool.value(Value::Bool(false));
        Program {
            variables,
            players: (table.kind == ModelKind::Smg).then(|| players(&table)),
            modules: modules(&table),
            synchronisations: synchronisations(&commands),
            actions: table.actions,
            commands,
            ..Program::empty(Arc::clone(self.source), table.kind, pool.into(), initial)
        }
    }
}

impl Table {
    /// Removes the labels with a built-in meaning. Returns for each state whether it is a deadlock
    /// that the writer gave a self-loop: it is labelled "deadlock", and its only choice stays there
    /// and earns nothing.
    fn take_deadlocks(&mut self) -> Vec<bool> {
        let mut deadlocks = vec![false; self.states()];
        let labels = std::mem::take(&mut self.labels);
        for (_, states) in labels.iter().filter(|(name, _)| name == "deadlock") {
            for &state in states {
                let loops = self.is_loop(state);
                deadlocks[state] = loops;
                if !loops && self.choices[state] < self.choices[state + 1] {
                    let message = format!(
                        "state {state} is labelled \"deadlock\" and has choices; the label is ignored"
                    );
                    self.warnings.push(message);
                    break;
                }
            }
        }
        self.labels =
            labels.into_iter().filter(|(name, _)| !BUILT_IN_LABELS.contains(&name.as_str())).collect();
        deadlocks
    }

    fn is_loop(&self, state: usize) -> bool {
        let choices = self.choices[state]..self.choices[state + 1];
        let branches = self.branches[choices.start]..self.branches[choices.end];
        let earned = self.rewards.iter().filter_map(|r| r.choices.as_ref());
        choices.len() == 1
            && self.targets[branches].iter().all(|t| *t == state)
            && earned.map(|of| self.value(of[choices.start])).all(|x| x.is_zero())
    }

    /// Returns the states sorted by their values. If the values do not tell states apart, their
    /// numbers become the only variable.
    fn order(&mut self, poll: &mut Poll<'_>) -> Result<Vec<usize>> {
        let states = self.states();
        if !self.columns.is_empty() {
            if let Some(order) = sorted(&self.columns, states, poll)? {
                return Ok(order);
            }
            let reason = "two states have the same values";
            self.warnings.push(format!("states have only their numbers, in `{NUMBER}`: {reason}"));
        }
        let numbers = i64::try_from(states).unwrap_or(i64::MAX);
        self.columns = vec![Column {
            name: NUMBER.to_owned(),
            place: None,
            ty: Type::Int,
            low: 0,
            high: numbers - 1,
            names: Vec::new(),
            values: (0..numbers).collect(),
        }];
        Ok((0..states).collect())
    }
}

/// Returns the names of the modules: one for each player, which has the choices of the player's states.
fn modules(table: &Table) -> Vec<String> {
    match table.kind {
        ModelKind::Smg => table.players.clone(),
        ModelKind::Mdp | ModelKind::Dtmc => vec!["model".to_owned()],
    }
}

/// Returns the players of a game; the first one is ours.
fn players(table: &Table) -> Players {
    let player = |(at, name): (usize, &String)| Player { name: name.clone(), ours: at == 0 };
    Players {
        list: table.players.iter().enumerate().map(player).collect(),
        of_module: (0..table.players.len()).map(Some).collect(),
        of_action: vec![None; table.actions.len()],
        span: 0..0,
    }
}

fn variables(table: &Table, names: &mut Names) -> Vec<Variable> {
    let only = match table.initial.as_slice() {
        [only] => Some(*only),
        _ => None,
    };
    let variable = |column: &Column| Variable {
        name: names
            .add_of_model(&column.name, column.place.as_ref().map_or(Span::default(), |place| place.1)),
        ty: column.ty,
        low: column.low,
        high: column.high,
        module: (table.players.len() < 2).then_some(0),
        initial: only.map(|state| column.values[state]),
        values: column.names.clone(),
        span: 0..0,
    };
    table.columns.iter().map(variable).collect()
}

/// Returns the groups of choices, each sorted by the positions of their states.
fn groups(table: &Table, sorted: &[usize], without: &[bool]) -> BTreeMap<Group, Vec<Member>> {
    let mut groups: BTreeMap<Group, Vec<Member>> = BTreeMap::new();
    let mut seen: BTreeMap<(Option<usize>, usize), usize> = BTreeMap::new();
    for (position, &state) in sorted.iter().enumerate().filter(|(_, state)| !without[**state]) {
        seen.clear();
        let player = table.owner(state);
        for choice in table.choices[state]..table.choices[state + 1] {
            let branches = table.branches[choice + 1] - table.branches[choice];
            let action = table.action_of[choice].filter(|_| table.kind != ModelKind::Dtmc);
            let number = seen.entry((action, branches)).or_default();
            let group = Group { player, action, number: *number, branches };
            groups.entry(group).or_default().push((position, choice));
            *number += 1;
        }
    }
    groups
}

/// Returns one synchronisation for the commands of each action and player.
fn synchronisations(commands: &[Command]) -> Vec<Synchronisation> {
    let mut by_action: BTreeMap<(Option<usize>, usize), Vec<CommandId>> = BTreeMap::new();
    for (command, id) in commands.iter().zip(0..) {
        by_action.entry((command.action, command.module)).or_default().push(CommandId(id));
    }
    let one = |((action, _), ids)| Synchronisation { action, factors: vec![ids] };
    by_action.into_iter().map(one).collect()
}

impl Lowering<'_> {
    fn command(&mut self, table: &Table, group: Group, members: &[Member]) -> Result<()> {
        let Group { player: module, action, branches: width, .. } = group;
        let positions: Vec<usize> = members.iter().map(|m| m.0).collect();
        let guard = self.trees.member(&positions, &mut self.poll)?;
        let mut branches = SmallVec::new();
        for k in 0..width {
            let branch = |choice: usize| table.branches[choice] + k;
            let weights: Vec<Leaf> =
                members.iter().map(|&(p, choice)| (p, table.probabilities[branch(choice)])).collect();
            let probability = self.trees.select(&weights, &mut self.poll)?;
            let mut updates = SmallVec::new();
            for column in 0..table.columns.len() {
                let target = |choice: usize| table.columns[column].values[table.targets[branch(choice)]];
                if members.iter().all(|&(p, choice)| self.trees.at(column, p) == target(choice)) {
                    continue;
                }
                let mut leaves: Vec<Leaf> = Vec::with_capacity(members.len());
                for &(p, choice) in members {
                    leaves.push((p, self.trees.literal(column, target(choice))));
                }
                let id = VarId(u32::try_from(column).unwrap_or(u32::MAX));
                updates.push((id, self.trees.select(&leaves, &mut self.poll)?));
            }
            branches.push(Branch { probability, updates });
        }
        let last = self.commands.last().filter(|c| (c.module, c.action) == (module, action));
        let number = last.map_or(1, |c| c.number + 1);
        self.commands.push(Command {
            module,
            action,
            number,
            unlisted: None,
            guard,
            branches,
            span: Span::default(),
        });
        Ok(())
    }

    /// Returns the states in `initial`, and the labels.
    fn labels(&mut self, table: &Table) -> Result<(ExprId, Vec<(String, ExprId)>)> {
        let mut position = vec![0; table.states()];
        self.trees.sorted.iter().enumerate().for_each(|(at, &state)| position[state] = at);
        let mut condition = |states: &[usize]| {
            let mut positions: Vec<usize> = states.iter().map(|s| position[*s]).collect();
            positions.sort_unstable();
            positions.dedup();
            self.trees.member(&positions, &mut self.poll)
        };
        let initial = condition(&table.initial)?;
        let label = |(name, states): &(String, Vec<usize>)| Ok((name.clone(), condition(states)?));
        Ok((initial, table.labels.iter().map(label).collect::<Result<_>>()?))
    }

    fn rewards(
        &mut self,
        table: &Table,
        groups: &BTreeMap<Group, Vec<Member>>,
    ) -> Result<Vec<RewardStructure>> {
        let structure = |of: &Rewards| {
            let mut items = Vec::new();
            if let Some(states) = &of.states {
                let leaves = self.trees.sorted.iter().enumerate().map(|(p, &state)| (p, states[state]));
                items.extend(self.item(Earner::State, &leaves.collect::<Vec<_>>())?);
            }
            for ((_, members), id) in groups.iter().zip(0..) {
                let Some(choices) = &of.choices else { break };
                let leaves = members.iter().map(|&(p, choice)| (p, choices[choice]));
                items.extend(self.item(Earner::Command(CommandId(id)), &leaves.collect::<Vec<_>>())?);
            }
            let name = of.name.clone();
            Ok(RewardStructure { name, items, errors: Vec::new(), span: Span::default() })
        };
        table.rewards.iter().map(structure).collect()
    }

    /// Returns an item, unless all its values are 0.
    fn item(&mut self, earner: Earner, leaves: &[Leaf]) -> Result<Option<RewardItem>> {
        let is_zero = |value: ExprId| {
            self.trees.pool.exact_literal(value).is_some_and(|value| value.into_real().is_zero())
        };
        if leaves.iter().all(|leaf| is_zero(leaf.1)) {
            return Ok(None);
        }
        let guard = self.trees.pool.value(Value::Bool(true));
        let value = self.trees.select(leaves, &mut self.poll)?;
        Ok(Some(RewardItem { earner, guard, value, span: Span::default() }))
    }
}
