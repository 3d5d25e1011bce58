//! From the syntax tree to the flat program: names, types, constants, renaming, composition.

mod actions;
mod collect;
mod constants;
mod cycles;
mod expr;
mod faults;
mod limits;
mod lowerer;
mod modules;
mod ops;
mod players;
mod rewards;
mod scope;
mod system;
mod target;
mod unlisted;
mod variables;

use std::sync::Arc;

use super::ast::{Model, NamedExpr};
use collect::Parts;
use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_base::progress::ProgressSink;
use meliora_model::expr::ExprPool;
use meliora_model::{ModelKind, Program};
use scope::NO_RENAMING;

pub use actions::Actions;
pub(crate) use constants::{Wanted, given_values};
pub(crate) use lowerer::{Lowered, Lowerer, MAX_ERRORS};
pub(crate) use rewards::warnings as reward_warnings;
pub(crate) use scope::Scope;
pub use target::lower_target;
pub(crate) use target::{lower_condition, lower_value};

/// A program, with further results of the checks.
#[derive(Debug, Clone)]
pub struct Checked {
    /// The flat program.
    pub program: Program,
    /// Warnings.
    pub warnings: Vec<Diagnostic>,
    /// Properties that the model names, if its format has them.
    pub properties: Vec<super::named::Property>,
}

/// Flattens a model: gives undefined constants their values, checks names and types, and carries
/// out renamings and the composition.
///
/// `source` is the text that `model` was read from, `given` the text of `bindings`.
///
/// # Errors
/// Everything that PRISM also refuses (see the tests for each case); a limit.
pub(crate) fn check(
    model: &Model,
    source: &Arc<SourceFile>,
    given: &Arc<SourceFile>,
    bindings: &[super::valuation::Binding],
    sink: &dyn ProgressSink,
) -> Result<Checked> {
    let mut parts = Parts::default();
    let mut lowerer = Lowerer::new(source, scope::Scope::default(), ExprPool::default(), sink);
    parts.collect(model, &mut lowerer);
    lowerer.declare(&parts);
    let mut foreign = lowerer.give_constants(&parts, given, bindings);
    let cyclic = lowerer.find_cycles();
    lowerer.poll.check()?;
    if cyclic || !foreign.is_empty() || !lowerer.diagnostics.is_empty() {
        // Errors in names and constants come first: without these, later errors would be noise.
        foreign.append(&mut lowerer.diagnostics);
        return Err(Error::Input(foreign));
    }
    let program = lowerer.program(model, &parts, bindings);
    lowerer.poll.check()?;
    match program {
        Some(program) if lowerer.diagnostics.is_empty() => Ok(Checked {
            warnings: rewards::warnings(&program.rewards)
                .into_iter()
                .chain(program.inexact.clone())
                .collect(),
            program: Program { pool: lowerer.pool.into(), ..program },
            properties: Vec::new(),
        }),
        _ => Err(Error::Input(lowerer.diagnostics)),
    }
}

impl<'a> Lowerer<'a> {
    /// Builds the program, with an empty pool in place of the one still in use here.
    fn program(
        &mut self,
        model: &Model,
        parts: &Parts<'a>,
        bindings: &[super::valuation::Binding],
    ) -> Option<Program> {
        let constants = self.constant_values(parts);
        let variables = self.variables(parts);
        let formulas: Vec<_> = parts.formulas.iter().map(|f| self.formula(f)).collect();
        let initial = self.initial(parts, &variables);
        let (actions, commands) = self.commands(parts);
        let labels: Vec<_> = parts.labels.iter().map(|l| self.label_definition(l)).collect();
        let composed = self.synchronisations(parts, &commands, actions);
        let (actions, mut synchronisations) = composed?;
        let rewards = self.rewards(parts, &actions);
        let players = self.players(model.kind, parts, &actions);
        let mut commands = commands?;
        if let Some(players) = &players {
            self.share_unlisted(players, &mut commands, &mut synchronisations)?;
        }
        Some(Program {
            source: Arc::clone(&self.source),
            kind: model.kind.map_or(ModelKind::Mdp, |(kind, _)| kind),
            constants: constants?,
            given_constants: bindings.iter().map(|b| b.name.name.clone()).collect(),
            pool: Arc::default(),
            variables: variables?,
            modules: parts.modules.iter().map(|m| m.name.name.clone()).collect(),
            initial: initial?,
            actions,
            commands,
            synchronisations,
            labels: labels.into_iter().collect::<Option<_>>()?,
            formulas: formulas.into_iter().collect::<Option<_>>()?,
            rewards,
            inexact: self.inexact.take(),
            monitors: None,
            planning: None,
            stop: None,
            players,
        })
    }

    fn formula(&mut self, formula: &NamedExpr) -> Option<(String, meliora_model::expr::ExprId)> {
        let definition = match self.scope.symbol(&formula.name.name) {
            Some(scope::Symbol::Definition(d)) => d,
            _ => return None,
        };
        Some((formula.name.name.clone(), self.definition(definition, NO_RENAMING)?))
    }

    fn label_definition(&mut self, label: &NamedExpr) -> Option<(String, meliora_model::expr::ExprId)> {
        let what = format!("the label \"{}\"", label.name.name);
        Some((label.name.name.clone(), self.condition(&label.body, NO_RENAMING, &what)?))
    }
}
