//! Merging of modules that cannot be separate in PRISM's language.
//!
//! There, a command with a label writes only variables of its own module. In other formats several
//! modules may write the same variable; such modules are merged, and the commands are all
//! combinations of the original ones.

use std::sync::Arc;

use ahash::AHashMap;

use crate::combinations::{combinations, product};
use crate::names::Names;
use meliora_base::error::{Limit, Result};
use meliora_model::expr::{Binary, ExprPool};
use meliora_model::{Branch, Branches, Command, CommandId, Program, Synchronisation, VarId};

/// Maximum number of commands of a merged program.
const MOST_COMMANDS: usize = 100_000;

/// Merges modules of a program where necessary.
///
/// # Errors
/// The merged modules have too many commands.
pub(super) fn merged(whole: &Arc<Program>) -> Result<Arc<Program>> {
    let classes = Classes::new(whole);
    let owners = classes.owners(whole);
    if classes.are_apart() && whole.variables.iter().zip(&owners).all(|(v, owner)| v.module == *owner) {
        return Ok(Arc::clone(whole));
    }
    let mut program = Program::clone(whole);
    program.variables.iter_mut().zip(owners).for_each(|(v, owner)| v.module = owner);
    if classes.are_apart() {
        return Ok(Arc::new(program));
    }
    program.pool = ExprPool::over(&program.pool).into();
    let mut merge = Merge { known: AHashMap::new(), commands: Vec::new(), numbers: AHashMap::new() };
    let mut synchronisations = Vec::new();
    for step in program.synchronisations.clone() {
        let mut groups: Vec<(usize, Vec<Vec<CommandId>>)> = Vec::new();
        for factor in step.factors {
            let class = classes.of_module[program.commands[factor[0].index()].module];
            match groups.iter_mut().find(|(c, _)| *c == class) {
                Some((_, factors)) => factors.push(factor),
                None => groups.push((class, vec![factor])),
            }
        }
        let mut factors = Vec::new();
        for (class, parts) in groups {
            factors.push(merge.factor(&mut program, class, step.action, &parts)?);
        }
        synchronisations.push(Synchronisation { action: step.action, factors });
    }
    program.modules = classes.names(&program);
    program.commands = merge.commands;
    program.synchronisations = synchronisations;
    Ok(Arc::new(program))
}

/// A partition of the modules: each class becomes one module.
struct Classes {
    /// For each module the number of its class, in the order of the first members.
    of_module: Vec<usize>,
    count: usize,
    /// For each variable, true if a synchronisation with a label, or of several modules, writes it.
    labelled: Vec<bool>,
    /// For each variable, the modules that write it.
    writers: Vec<Vec<usize>>,
}

impl Classes {
    fn new(program: &Program) -> Self {
        let mut writers: Vec<Vec<usize>> = program.variables.iter().map(|_| Vec::new()).collect();
        let mut labelled = vec![false; program.variables.len()];
        for step in &program.synchronisations {
            for id in step.factors.iter().flatten() {
                let command = &program.commands[id.index()];
                for &(VarId(v), _) in command.branches.iter().flat_map(|b| &b.updates) {
                    let at = v as usize;
                    if !writers[at].contains(&command.module) {
                        writers[at].push(command.module);
                    }
                    labelled[at] |= step.action.is_some() || step.factors.len() > 1;
                }
            }
        }
        // The smallest module of each class represents it until all are known.
        let mut least: Vec<usize> = (0..program.modules.len()).collect();
        for (at, own) in writers.iter().enumerate() {
            let owner = program.variables[at].module;
            let all: Vec<usize> = own.iter().copied().chain(owner).collect();
            let apart = own.iter().any(|w| Some(*w) != owner);
            if all.len() > 1 && apart && (labelled[at] || owner.is_some()) {
                let to = all.iter().map(|&m| least[m]).min().unwrap_or(0);
                let from: Vec<usize> = all.iter().map(|&m| least[m]).collect();
                least.iter_mut().filter(|l| from.contains(l)).for_each(|l| *l = to);
            }
        }
        let mut numbers: Vec<usize> = least.clone();
        numbers.sort_unstable();
        numbers.dedup();
        let of_module: Vec<usize> = least.iter().map(|l| numbers.binary_search(l).unwrap_or(0)).collect();
        Classes { count: numbers.len(), of_module, labelled, writers }
    }

    fn are_apart(&self) -> bool {
        self.count == self.of_module.len()
    }

    /// Returns for each variable the class that declares it: that of its module. For a global
    /// variable written with a label it is the class of its first writer, and otherwise `None`.
    fn owners(&self, program: &Program) -> Vec<Option<usize>> {
        let owner = |(at, v): (usize, &meliora_model::Variable)| match v.module {
            Some(module) => Some(self.of_module[module]),
            None if self.labelled[at] => self.writers[at].first().map(|&m| self.of_module[m]),
            None => None,
        };
        program.variables.iter().enumerate().map(owner).collect()
    }

    fn names(&self, program: &Program) -> Vec<String> {
        let mut names = Names::default();
        let of = |class: usize| {
            let own = program.modules.iter().zip(&self.of_module).filter(|(_, c)| **c == class);
            own.map(|(name, _)| name.as_str()).collect::<Vec<_>>().join("_")
        };
        (0..self.count).map(|class| names.add(&of(class))).collect()
    }
}

/// The commands of the merged program under construction.
struct Merge {
    known: AHashMap<Vec<CommandId>, CommandId>,
    commands: Vec<Command>,
    numbers: AHashMap<(usize, Option<usize>), usize>,
}

impl Merge {
    /// Makes one command for each combination of one command from each part.
    fn factor(
        &mut self,
        program: &mut Program,
        class: usize,
        action: Option<usize>,
        parts: &[Vec<CommandId>],
    ) -> Result<Vec<CommandId>> {
        if product(parts) > MOST_COMMANDS {
            return Err(too_many());
        }
        combinations(parts.iter().cloned())
            .into_iter()
            .map(|ids| self.command(program, class, action, ids))
            .collect()
    }

    fn command(
        &mut self,
        program: &mut Program,
        class: usize,
        action: Option<usize>,
        ids: Vec<CommandId>,
    ) -> Result<CommandId> {
        if let Some(&known) = self.known.get(&ids) {
            return Ok(known);
        }
        if self.commands.len() >= MOST_COMMANDS {
            return Err(too_many());
        }
        let mut command = program.commands[ids[0].index()].clone();
        for id in &ids[1..] {
            let other = program.commands[id.index()].clone();
            let pool = Arc::make_mut(&mut program.pool);
            command.guard = pool.binary(Binary::And, command.guard, other.guard);
            command.branches = both(pool, &command.branches, &other.branches);
        }
        // A single command keeps its label; a combination gets the label of its synchronisation.
        command.action = if ids.len() > 1 { action } else { command.action };
        command.module = class;
        let number = self.numbers.entry((class, command.action)).or_default();
        *number += 1;
        command.number = *number;
        let new = CommandId(u32::try_from(self.commands.len()).unwrap_or(u32::MAX));
        self.commands.push(command);
        self.known.insert(ids, new);
        Ok(new)
    }
}

/// Combines each branch of the left side with each branch of the right side.
fn both(pool: &mut ExprPool, left: &[Branch], right: &[Branch]) -> Branches {
    let mut all = Branches::new();
    for a in left {
        for b in right {
            let probability = pool.binary(Binary::Mul, a.probability, b.probability);
            let updates = a.updates.iter().chain(&b.updates).copied().collect();
            all.push(Branch { probability, updates });
        }
    }
    all
}

fn too_many() -> meliora_base::error::Error {
    let what = format!(
        "the modules that write the same variables merge into one with more than {MOST_COMMANDS} commands"
    );
    Limit::Size { what }.into()
}
