//! Reward structures from transient numbers: the values that locations give are earned when a state
//! is left, the values that edges assign are earned by the step.

use super::super::read::model::Destination;
use super::super::read::property::Reward;
use super::scope::{EdgeOf, Meaning, Place, Slot};
use super::state::Lowering;
use crate::ast::{BinaryOp, Node, NodeKind, Span};
use crate::combinations::combinations;
use crate::refusal::Refusal;
use meliora_base::value::{Type, Value};
use meliora_model::expr::ExprId;
use meliora_model::rewards::{Earner, RewardItem, RewardStructure};
use meliora_model::{Command, CommandId};

/// The moments at which values are earned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Accumulation {
    /// With every step: the values that its edges assign.
    pub(super) steps: bool,
    /// At the end of a stay in a state: the value in the state.
    pub(super) exit: bool,
}

impl<'a> Lowering<'a> {
    /// Records what a command earns: the expected values that its edges assign to transient numbers.
    pub(super) fn earn(&mut self, parts: &[EdgeOf<'a>], command: Option<&Command>, id: CommandId) {
        let assigned = self.assigned_numbers(parts);
        let Some(command) = command.filter(|_| !assigned.is_empty()) else { return };
        let told = self.lowerer.diagnostics.len();
        for &transient in &assigned {
            if let Some(value) = self.expected(parts, command, transient)
                && let Some(guard) = self.lowerer.literal(Value::Bool(true))
            {
                let earner = Earner::Command(id);
                self.earned.items.push((transient, RewardItem { earner, guard, value, span: command.span }));
            }
        }
        for error in self.lowerer.diagnostics.split_off(told) {
            self.earned.errors.extend(assigned.iter().map(|&transient| (transient, error.clone())));
        }
    }

    /// Returns the global transient numbers that edges assign, each once.
    fn assigned_numbers(&self, parts: &[EdgeOf<'a>]) -> Vec<usize> {
        let mut all = Vec::new();
        for &(instance, edge) in parts {
            for assignment in edge.destinations.iter().flat_map(|d| &d.assignments) {
                if let Some(Meaning::Transient(t)) =
                    self.meaning(&assignment.variable.name.name, Some(instance))
                    && self.is_reward(t)
                {
                    all.push(t);
                }
            }
        }
        all.sort_unstable();
        all.dedup();
        all
    }

    fn is_reward(&self, transient: usize) -> bool {
        let Some(of) = self.transients.get(transient) else { return false };
        of.variable.ty.ty != Type::Bool && of.instance.is_none() && of.element.is_none()
    }

    /// Returns the sum of `probability * value` over the branches of a command that assign a
    /// transient number.
    fn expected(&mut self, parts: &[EdgeOf<'a>], command: &Command, transient: usize) -> Option<ExprId> {
        let mut sum: Option<ExprId> = None;
        for (destinations, branch) in ways(parts).iter().zip(&command.branches) {
            let Some(value) = self.value_after(parts, destinations, transient)? else { continue };
            let span = command.span;
            let value = self.lowerer.made_real(value, span)?;
            let value = match self.lowerer.pool.literal(branch.probability) {
                Some(Value::Real(1.0)) => value,
                _ => self.lowerer.binary(BinaryOp::Mul, (branch.probability, span), (value, span), span)?,
            };
            sum = Some(match sum {
                None => value,
                Some(before) => self.lowerer.binary(BinaryOp::Add, (before, span), (value, span), span)?,
            });
        }
        sum
    }

    /// Returns the value of a transient variable after the assignments of some destinations;
    /// `Some(None)` if they do not assign it.
    #[allow(clippy::option_option)]
    fn value_after(
        &mut self,
        parts: &[EdgeOf<'a>],
        destinations: &[&'a Destination],
        transient: usize,
    ) -> Option<Option<ExprId>> {
        let mut steps = self.assignments(parts, destinations)?;
        let slot = Slot::Transient(transient);
        let Some(last) = steps.iter().filter(|s| s.slot == slot).map(|s| s.assignment.index).max() else {
            return Some(None);
        };
        // Other rewards of the last index have no influence.
        steps.retain(|s| s.slot == slot || s.assignment.index < last);
        Some(self.values_after(steps)?.get(&slot).copied())
    }

    /// Returns a reward structure for each global transient number.
    pub(super) fn reward_structures(&mut self) -> Vec<RewardStructure> {
        let rewards: Vec<usize> = (0..self.transients.len()).filter(|&t| self.is_reward(t)).collect();
        let all = Accumulation { steps: true, exit: true };
        rewards.into_iter().map(|transient| self.reward_structure(transient, all)).collect()
    }

    /// Returns the reward structure of a transient number.
    pub(super) fn reward_structure(
        &mut self,
        transient: usize,
        accumulation: Accumulation,
    ) -> RewardStructure {
        let variable = self.transients[transient].variable;
        let (name, span) = (variable.name.name.clone(), variable.name.span);
        let told = self.lowerer.diagnostics.len();
        let mut items = Vec::new();
        if accumulation.exit {
            items.extend(self.value_in_state(transient, span));
        }
        if accumulation.steps {
            self.check_initial(transient, span);
            let own = self.earned.items.iter().filter(|(t, _)| *t == transient);
            items.extend(own.map(|(_, item)| item.clone()));
        }
        let mut errors = self.lowerer.diagnostics.split_off(told);
        let steps = self.earned.errors.iter().filter(|(t, _)| *t == transient && accumulation.steps);
        errors.extend(steps.map(|(_, error)| error.clone()));
        RewardStructure { name: Some(name), items, errors, span }
    }

    /// Returns the item for the value in a state, unless it is 0 in all states.
    fn value_in_state(&mut self, transient: usize, span: Span) -> Option<RewardItem> {
        let value = self.transient(transient, span)?;
        let value = self.lowerer.made_real(value, span)?;
        if self.lowerer.pool.literal(value) == Some(Value::Real(0.0)) {
            return None;
        }
        let guard = self.lowerer.literal(Value::Bool(true))?;
        Some(RewardItem { earner: Earner::State, guard, value, span })
    }

    /// Reports an initial value other than 0: every step that does not assign the variable would
    /// earn it.
    fn check_initial(&mut self, transient: usize, span: Span) {
        let Some(id) = self.initial_of_transient(transient, span) else { return };
        if self.lowerer.pool.literal(id).is_some_and(|v| v.to_f64() != 0.0) {
            let name = &self.transients[transient].variable.name.name;
            let message = format!("the reward `{name}` has an initial value other than 0");
            let help = "the supported rewards of steps are 0 unless an edge assigns a value";
            let diagnostic =
                self.lowerer.wrong(span, message).severity(meliora_base::error::Severity::Unsupported);
            self.lowerer.report(diagnostic.help(help));
        }
    }
}

impl Lowering<'_> {
    /// Returns the number of the structure of a reward, from 1. One that is not a structure of the model becomes one
    /// with the name of the property.
    pub(super) fn structure(
        &mut self,
        property: &str,
        reward: &Reward,
        structures: &mut Vec<RewardStructure>,
    ) -> Result<usize, Refusal> {
        let named = match reward.value.nodes.as_slice() {
            [Node { kind: NodeKind::Name(name), .. }] => self.meaning(name, None),
            _ => None,
        };
        let own = match named {
            Some(Meaning::Transient(t)) if self.is_reward(t) => self.reward_structure(t, reward.into()),
            _ => self.reward_of_expression(reward)?,
        };
        if let Some(wrong) = own.errors.first() {
            return Err(Refusal::at(wrong));
        }
        let same = |s: &RewardStructure| {
            s.name == own.name && s.items.len() == own.items.len() && s.errors.is_empty()
        };
        Ok(match structures.iter().position(same) {
            Some(known) => known + 1,
            None => {
                structures.push(RewardStructure { name: Some(property.to_owned()), ..own });
                structures.len()
            }
        })
    }

    /// Returns the structure of a reward that is an expression over the state.
    fn reward_of_expression(&mut self, reward: &Reward) -> Result<RewardStructure, Refusal> {
        let span = reward.value.span();
        let told = self.lowerer.diagnostics.len();
        let value = self.typed(&reward.value, Place::default(), Type::Real, "a reward");
        let errors = self.lowerer.diagnostics.split_off(told);
        let (Some(value), Some(guard)) = (value, self.lowerer.literal(Value::Bool(true))) else {
            return Err(errors
                .first()
                .map_or_else(|| Refusal::without_place("its reward is wrong"), Refusal::at));
        };
        // A constant that is earned by every step is earned by every state that is left.
        let is_constant = self.lowerer.pool.literal(value).is_some();
        let items = match (reward.steps, reward.exit) {
            (false, false) => Vec::new(),
            (true, false) if is_constant => vec![RewardItem { earner: Earner::State, guard, value, span }],
            (false, true) => vec![RewardItem { earner: Earner::State, guard, value, span }],
            _ => return Err(Refusal::without_place("it accumulates an expression with every step")),
        };
        Ok(RewardStructure { name: None, items, errors, span })
    }
}

impl From<&Reward> for Accumulation {
    fn from(reward: &Reward) -> Self {
        Accumulation { steps: reward.steps, exit: reward.exit }
    }
}

/// Returns all combinations of one destination per edge, in the order of the command's branches.
pub(super) fn ways<'a>(parts: &[EdgeOf<'a>]) -> Vec<Vec<&'a Destination>> {
    combinations(parts.iter().map(|(_, edge)| edge.destinations.iter().collect()))
}
