//! The guards of the commands of one participant, listed by the value of one variable.

use super::bounds::Bounds;
use super::by_value::{ByValue, Need, only_value};
use super::compile::Compiler;
use super::machine::Entry;
use meliora_base::error::Result;
use meliora_base::progress::Poll;
use meliora_base::value::{Type, Value};
use meliora_model::expr::{Binary, ExprId, Node};
use meliora_model::{CommandId, Program};

/// The guards of a participant's commands as conjunctions.
pub(super) struct Guards {
    commands: Vec<(CommandId, Vec<ExprId>)>,
    /// The values that the guard of each command needs.
    pub(super) needs: Vec<Vec<Need>>,
}

impl Guards {
    /// Reads the guards of `commands`.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(super) fn new(
        program: &Program,
        bounds: &Bounds,
        commands: &[CommandId],
        poll: &mut Poll<'_>,
    ) -> Result<Self> {
        let mut guards = Guards { commands: Vec::with_capacity(commands.len()), needs: Vec::new() };
        for &command in commands {
            poll.step()?;
            let conjuncts = conjuncts(program, program.commands[command.index()].guard);
            guards.needs.push(needs(program, bounds, &conjuncts));
            guards.commands.push((command, conjuncts));
        }
        Ok(guards)
    }

    /// Returns all conjuncts of the guards.
    pub(super) fn roots(&self) -> impl Iterator<Item = ExprId> {
        self.commands.iter().flat_map(|(_, guard)| guard).copied()
    }

    /// Compiles the guards.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(super) fn compile(&self, compiler: &mut Compiler<'_>, poll: &mut Poll<'_>) -> Result<Candidates> {
        let mut all = Vec::with_capacity(self.commands.len());
        for (command, guard) in &self.commands {
            poll.step()?;
            let guard = (!guard.is_empty()).then(|| compiler.conjunction(guard));
            all.push(Candidate { command: command.0, guard });
        }
        Ok(Candidates { all, by_value: ByValue::new(&self.needs) })
    }
}

/// Returns the conjuncts of a guard, in their order.
pub(super) fn conjuncts(program: &Program, guard: ExprId) -> Vec<ExprId> {
    let pool = &program.pool;
    let (mut found, mut stack) = (Vec::new(), vec![guard]);
    while let Some(e) = stack.pop() {
        match pool.node(e) {
            Node::Binary(Binary::And, a, b) if pool.ty(a) == Type::Bool => stack.extend([b, a]),
            Node::Literal(Value::Bool(true)) => {}
            _ => found.push(e),
        }
    }
    found
}

/// Returns the values that a guard needs.
///
/// A conjunct counts only if it and those before it are total: then a guard with a false conjunct is false and never
/// without a value.
fn needs(program: &Program, bounds: &Bounds, guard: &[ExprId]) -> Vec<Need> {
    let total = guard.iter().take_while(|&&e| bounds.is_total(e));
    let mut needs: Vec<Need> = Vec::new();
    for (variable, value) in total.filter_map(|&e| only_value(&program.pool, e)) {
        if needs.iter().all(|(known, _)| *known != variable) {
            needs.push((variable, vec![value]));
        }
    }
    needs
}

/// The commands of a participant.
pub(super) struct Candidates {
    pub(super) all: Vec<Candidate>,
    /// Their positions by the value of a variable, if that rules some out.
    pub(super) by_value: Option<ByValue>,
}

/// A command of a participant.
pub(super) struct Candidate {
    pub(super) command: u32,
    /// Its guard, unless that is always true.
    pub(super) guard: Option<Entry>,
}
