//! The guards of the commands of one participant, listed by the values of variables.

use super::bounds::Bounds;
use super::by_value::ByValue;
use super::compile::Compiler;
use super::machine::Entry;
use super::needs::{Way, Ways, operands};
use meliora_base::error::Result;
use meliora_base::progress::Poll;
use meliora_model::expr::{Binary, ExprId};
use meliora_model::{CommandId, Program};

/// The guards of a participant's commands as conjunctions.
pub(crate) struct Guards {
    commands: Vec<(CommandId, Vec<ExprId>)>,
    /// The ways in which the guard of each command can be true.
    pub(crate) ways: Vec<Vec<Way>>,
}

impl Guards {
    /// Reads the guards of `commands`.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(crate) fn new(
        program: &Program,
        commands: &[CommandId],
        (bounds, ways): (&mut Bounds<'_>, &mut Ways<'_>),
        poll: &mut Poll<'_>,
    ) -> Result<Self> {
        let mut guards = Guards { commands: Vec::with_capacity(commands.len()), ways: Vec::new() };
        for &command in commands {
            poll.step()?;
            let guard = operands(&program.pool, Binary::And, program.commands[command.index()].guard);
            // A conjunct counts only if it and those before it are total: then a guard with a false conjunct is
            // false and never without a value.
            let total = guard.iter().take_while(|&&e| bounds.is_total(e)).count();
            guards.ways.push(ways.of(&guard[..total]));
            guards.commands.push((command, guard));
        }
        Ok(guards)
    }

    /// Returns all conjuncts of the guards.
    pub(crate) fn roots(&self) -> impl Iterator<Item = ExprId> {
        self.commands.iter().flat_map(|(_, guard)| guard).copied()
    }

    /// Compiles the guards.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(crate) fn compile(
        &self,
        compiler: &mut Compiler<'_>,
        ways: &mut Ways<'_>,
        poll: &mut Poll<'_>,
    ) -> Result<Candidates> {
        let mut all = Vec::with_capacity(self.commands.len());
        for (command, guard) in &self.commands {
            poll.step()?;
            let guard = (!guard.is_empty()).then(|| compiler.conjunction(guard));
            all.push(Candidate { command: command.0, guard });
        }
        Ok(Candidates { all, by_value: ways.list(&self.ways) })
    }
}

/// The commands of a participant.
pub(crate) struct Candidates {
    pub(crate) all: Vec<Candidate>,
    /// Their positions by the values of variables.
    pub(crate) by_value: ByValue,
}

/// A command of a participant.
pub(crate) struct Candidate {
    pub(crate) command: u32,
    /// Its guard, unless that is always true.
    pub(crate) guard: Option<Entry>,
}
