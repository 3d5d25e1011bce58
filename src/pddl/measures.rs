//! Measures as reward structures: what actions add to them, and the reward of the goal.
//!
//! The reward of the goal is earned once, by the first step into a state of the goal, or by the first step of all if the
//! goal holds initially. So a Boolean variable remembers whether it has been earned.

use std::collections::BTreeSet;

use num_traits::Zero;

use crate::ground::{Fact, GroundAction};
use crate::lower::{Lowering, unique};
use crate::task::Measure;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_base::span::Span;
use meliora_base::value::Type;
use meliora_model::expr::{Binary, ExprId, Unary};
use meliora_model::rewards::{Earner, RewardItem, RewardStructure};
use meliora_model::{Branch, CommandId, VarId, Variable};

/// The name of the variable that tells whether the reward of the goal has been earned.
const EARNED: &str = "goal-reward";

impl Measure {
    fn name(self) -> &'static str {
        match self {
            Measure::Cost => "cost",
            Measure::Reward => "reward",
        }
    }
}

/// The items of the reward structures, as far as the commands are known.
pub(crate) struct Measures {
    items: Vec<(Measure, RewardItem)>,
    goal: Option<GoalReward>,
}

/// The reward of the goal.
struct GoalReward {
    amount: Ratio,
    /// The variable that tells whether it has been earned.
    variable: VarId,
    /// The goal holds in the state.
    holds: ExprId,
    /// The goal does not hold, and has not been reached before.
    is_open: ExprId,
    /// For each fact, whether the goal depends on it.
    is_read: Vec<bool>,
}

impl Measures {
    /// Adds the variable of the reward of the goal, if there is one.
    pub(crate) fn new(lowering: &mut Lowering<'_>, variables: &mut Vec<Variable>) -> Self {
        let mut measures = Measures { items: Vec::new(), goal: None };
        let amount = lowering.task.goal_reward.as_ref().filter(|amount| !amount.is_zero());
        let (Some(amount), false) = (amount, lowering.ground.measures.is_empty()) else { return measures };
        let variable = VarId(u32::try_from(variables.len()).unwrap_or(u32::MAX));
        let mut taken = variables.iter().map(|variable| variable.name.clone()).collect();
        let name = unique(EARNED.to_owned(), &mut taken);
        let (module, initial) = (Some(0), Some(0));
        variables.push(Variable {
            name,
            ty: Type::Bool,
            low: 0,
            high: 1,
            module,
            initial,
            values: Vec::new(),
            span: 0..0,
        });
        let holds = lowering.goal();
        let earned = lowering.pool.var(variable, Type::Bool);
        let before = lowering.pool.unary(Unary::Not, earned);
        let fails = lowering.pool.unary(Unary::Not, holds);
        let first = lowering.pool.binary(Binary::And, holds, before);
        let is_open = lowering.pool.binary(Binary::And, fails, before);
        let value = lowering.number(amount);
        measures.push(Measure::Reward, Earner::State, first, value);
        let condition = lowering.ground.goal.as_ref();
        let is_read = condition.map_or_else(Vec::new, |goal| lowering.ground.read_by(goal));
        measures.goal = Some(GoalReward { amount: amount.clone(), variable, holds, is_open, is_read });
        measures
    }

    fn push(&mut self, measure: Measure, earner: Earner, guard: ExprId, value: ExprId) {
        self.items.push((measure, RewardItem { earner, guard, value, span: Span::default() }));
    }

    /// Adds what a command earns. Its branches remember that the goal was reached.
    ///
    /// # Errors
    /// A derived predicate depends on its own negation.
    pub(crate) fn add(
        &mut self,
        lowering: &mut Lowering<'_>,
        (command, action): (CommandId, &GroundAction),
        branches: &mut [Branch],
    ) -> Result<()> {
        let earner = Earner::Command(command);
        for earned in &action.earned {
            let (guard, value) = (lowering.condition(&earned.condition), lowering.number(&earned.amount));
            self.push(earned.measure, earner, guard, value);
        }
        let Some(goal) = &self.goal else { return Ok(()) };
        let nothing = lowering.number(&Ratio::zero());
        let mut sum = nothing;
        for (branch, outcome) in branches.iter_mut().zip(&action.outcomes) {
            let after = lowering.goal_after(goal, &branch.updates)?;
            let share = lowering.number(&(&goal.amount * &outcome.probability));
            let pool = &mut lowering.pool;
            let earned = pool.ite(after, share, nothing);
            sum = pool.binary(Binary::Add, sum, earned);
            let known = pool.var(goal.variable, Type::Bool);
            let reached = pool.binary(Binary::Or, goal.holds, after);
            let reached = pool.binary(Binary::Or, known, reached);
            if reached != known {
                branch.updates.push((goal.variable, reached));
            }
        }
        let is_open = goal.is_open;
        if sum != nothing {
            self.push(Measure::Reward, earner, is_open, sum);
        }
        Ok(())
    }

    /// Returns the structures of some measures.
    pub(crate) fn structures(self, measures: &BTreeSet<Measure>) -> Vec<RewardStructure> {
        let of = |measure: &Measure| RewardStructure {
            name: Some(measure.name().to_owned()),
            items: self.items.iter().filter(|(of, _)| of == measure).map(|(_, item)| item.clone()).collect(),
            errors: Vec::new(),
            span: Span::default(),
        };
        measures.iter().map(of).collect()
    }
}

impl Lowering<'_> {
    /// Returns the goal as it is after updates, over the state before.
    ///
    /// # Errors
    /// A derived predicate depends on its own negation.
    fn goal_after(&mut self, goal: &GoalReward, updates: &[(VarId, ExprId)]) -> Result<ExprId> {
        let mut before = Vec::new();
        let groups = self.groups;
        let is_read = |fact: &&Fact| goal.is_read.get(**fact as usize) == Some(&true);
        for &(variable, new) in updates {
            for &fact in groups[variable.index()].facts.iter().filter(is_read) {
                let ty = self.pool.ty(new);
                let after = self.is_value(new, ty, self.place[fact as usize].1);
                before.push((fact, std::mem::replace(&mut self.facts[fact as usize], after)));
            }
        }
        if before.is_empty() {
            return Ok(goal.holds);
        }
        let derived = self.derived.clone();
        self.define_derived()?;
        let goal = self.goal();
        self.derived = derived;
        for (fact, id) in before {
            self.facts[fact as usize] = id;
        }
        Ok(goal)
    }
}
