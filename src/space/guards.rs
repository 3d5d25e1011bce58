//! The guards of the commands of one participant, listed by the values of variables.

use super::bounds::Bounds;
use super::by_value::ByValue;
use super::compile::Compiler;
use super::local;
use super::machine::{Entry, Valuations};
use super::needs::{Need, Way, Ways, operands};
use meliora_base::error::Result;
use meliora_base::progress::Poll;
use meliora_model::expr::{Binary, ExprId};
use meliora_model::{CommandId, Program, VarId};

/// The guards of a participant's commands as conjunctions.
pub(crate) struct Guards {
    commands: Vec<Guard>,
    /// The ways in which the guard of each command can be true.
    pub(crate) ways: Vec<Vec<Way>>,
}

/// A conjunction.
struct Guard {
    command: CommandId,
    conjuncts: Vec<ExprId>,
    /// The number of conjuncts at the beginning that have a value in every state. If one of these is false, the guard is
    /// false, and never without a value.
    total: usize,
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
            let conjuncts = operands(&program.pool, Binary::And, program.commands[command.index()].guard);
            let total = conjuncts.iter().take_while(|&&e| bounds.is_total(e)).count();
            guards.ways.push(ways.of(&conjuncts[..total]));
            guards.commands.push(Guard { command, conjuncts, total });
        }
        Ok(guards)
    }

    /// Returns all conjuncts of the guards.
    pub(crate) fn roots(&self) -> impl Iterator<Item = ExprId> {
        self.commands.iter().flat_map(|guard| &guard.conjuncts).copied()
    }

    /// Compiles the guards. At most `kept` lists of candidates may be kept by values of variables; this is lowered by those
    /// that will be.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(crate) fn compile(
        &self,
        compiler: &mut Compiler<'_>,
        ways: &mut Ways<'_>,
        kept: &mut u64,
        poll: &mut Poll<'_>,
    ) -> Result<Candidates> {
        let total = self.commands.iter().flat_map(|guard| &guard.conjuncts[..guard.total]).copied();
        let chosen = local::chosen(ways.program, &total.collect::<Vec<_>>(), *kept, poll)?;
        let (variables, is_local) = chosen.unzip();
        let mut is_local = is_local.into_iter().flatten();
        let mut all = Vec::with_capacity(self.commands.len());
        for guard in &self.commands {
            poll.step()?;
            let (mut own, mut others) = (Vec::new(), Vec::new());
            let (total, partial) = guard.conjuncts.split_at(guard.total);
            for &e in total {
                if is_local.next() == Some(true) { own.push(e) } else { others.push(e) }
            }
            others.extend(partial);
            let [local, guard_left] =
                [own, others].map(|of| (!of.is_empty()).then(|| compiler.conjunction(&of)));
            all.push(Candidate { command: guard.command.0, local, guard: guard_left });
        }
        let Some(variables) = variables else {
            return Ok(Candidates { all, by_value: ways.list(&self.ways), valuations: None });
        };
        let valuations = Valuations::new(ways.program, &variables);
        *kept -= valuations.count as u64;
        Ok(Candidates { all, by_value: ways.list(&self.ways_over(&variables)), valuations: Some(valuations) })
    }

    /// Returns the ways in which the guards can be true, as far as some variables tell.
    fn ways_over(&self, variables: &[VarId]) -> Vec<Vec<Way>> {
        let is_over = |need: &&Need| variables.iter().any(|v| v.0 == need.0);
        let way = |way: &Way| way.iter().filter(is_over).cloned().collect();
        self.ways.iter().map(|ways| ways.iter().map(way).collect()).collect()
    }
}

/// The commands of a participant.
pub(crate) struct Candidates {
    pub(crate) all: Vec<Candidate>,
    /// Their positions by the values of variables: of those of `valuations`, if there are some.
    pub(crate) by_value: ByValue,
    /// The valuations for which they are listed, if some conditions depend on few variables.
    pub(crate) valuations: Option<Valuations>,
}

/// A command of a participant. Its guard is the conjunction of two parts.
pub(crate) struct Candidate {
    pub(crate) command: u32,
    /// The part whose results are kept, unless it is always true.
    pub(crate) local: Option<Entry>,
    /// The other part, unless it is always true.
    pub(crate) guard: Option<Entry>,
}
