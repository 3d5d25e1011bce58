//! Programs whose states are not left where a condition holds.

use ahash::AHashMap;

use super::expr::{Binary, ExprId, Unary};
use super::predicate::Predicates;
use super::{Branch, Command, CommandId, Program, Synchronisation};
use meliora_base::span::Span;
use meliora_base::value::Value;

/// The name of the module, and of the action, of the states that are not left.
const STOP: &str = "stop";

impl Program {
    /// Returns the program in which the states of a condition s have a self-loop alone: each guard g becomes
    /// !s & g, and a command `[stop] s -> true` is added. The states behind these are not reached, unless
    /// another way leads there. The condition is one of `predicates`, a pool over this program, which becomes
    /// that of the new program.
    ///
    /// Every path is the same up to its first state in s. The self-loop is a choice, so that these states are
    /// no deadlocks; in a game they belong to nobody. Where s has no value, an error names it before any
    /// command: its synchronisation comes first.
    pub fn stopping_at(&self, mut predicates: Predicates, condition: ExprId) -> Program {
        let pool = predicates.pool();
        let goes_on = pool.unary(Unary::Not, condition);
        let mut program = self.clone();
        let mut guards: AHashMap<ExprId, ExprId> = AHashMap::new();
        for command in &mut program.commands {
            let mut and = |guard| pool.binary(Binary::And, goes_on, guard);
            command.guard = *guards.entry(command.guard).or_insert_with_key(|&guard| and(guard));
        }
        let stop = CommandId(program.commands.len() as u32);
        let (module, action) = (program.modules.len(), Some(program.actions.len()));
        let branch = Branch { probability: pool.value(Value::Real(1.0)), updates: [].into_iter().collect() };
        program.modules.push(STOP.to_owned());
        program.actions.push(STOP.to_owned());
        let (branches, span) = ([branch].into(), Span::default());
        program.commands.push(Command {
            module,
            action,
            number: 1,
            unlisted: None,
            guard: condition,
            branches,
            span,
        });
        program.synchronisations.insert(0, Synchronisation { action, factors: vec![vec![stop]] });
        program.stop = Some(stop);
        program.inexact = program.inexact.or(pool.inexact.take());
        program.pool = predicates.into_pool();
        program
    }
}
