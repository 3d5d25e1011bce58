//! Reward structures: the numbers that choices earn.

use num_rational::BigRational;
use num_traits::{Signed, Zero};

use super::expr::{ExprId, ExprPool};
use super::predicate::{Predicate, Predicates};
use super::step::{Choice, Combination};
use super::{CommandId, Program};
use meliora_base::error::{Diagnostic, Error, Result};
use meliora_base::span::Span;
use meliora_base::value::{Binary, EvalError, Unary, Value};

/// A reward structure.
#[derive(Debug, Clone)]
pub struct RewardStructure {
    /// Its name, if it has one.
    pub name: Option<String>,
    /// The items; all that apply are added.
    pub items: Vec<RewardItem>,
    /// The reasons why the structure has no meaning. They do not prevent other uses of the model.
    pub errors: Vec<Diagnostic>,
    /// The position of its declaration.
    pub span: Span,
}

/// An item of a reward structure.
#[derive(Debug, Clone)]
pub struct RewardItem {
    /// The choices that earn the reward.
    pub earner: Earner,
    /// The condition on the state.
    pub guard: ExprId,
    /// The reward, of type `Real`.
    pub value: ExprId,
    /// The position of the item.
    pub span: Span,
}

/// The choices that earn a reward in the states that satisfy its guard.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Earner {
    /// Every choice: the state earns the reward.
    State,
    /// The choices with this label, a position in [`Program::actions`], or those without a label.
    Action(Option<usize>),
    /// The choices that this command takes part in.
    Command(CommandId),
}

impl RewardStructure {
    /// Returns the name in messages.
    pub fn title(&self) -> String {
        self.name.as_ref().map_or_else(|| "without a name".to_owned(), |name| format!("\"{name}\""))
    }
}

impl Program {
    /// Returns the position of a reward structure: the one with this name, or the first one without
    /// a name to look for, as `R` without a name means in PRISM.
    pub fn reward_structure(&self, name: Option<&str>) -> Option<usize> {
        match name {
            None => (!self.rewards.is_empty()).then_some(0),
            // The name that planners give it.
            Some("total-cost") if self.planning.is_some() => self.reward_structure(Some("cost")),
            Some(_) => self.rewards.iter().position(|r| r.name.as_deref() == name),
        }
    }

    /// Returns the states in which some choice earns a negative or infinite reward, judged in double
    /// precision; [`Program::reward`] says why. The height of the expression grows with the logarithm
    /// of the number of items.
    pub fn wrong_rewards(&self, structure: usize) -> Predicate {
        let items = self.rewards.get(structure).map_or(&[][..], |s| &s.items);
        let mut predicates = Predicates::over(self);
        let pool = predicates.pool();
        let bounds = [0.0, f64::MAX].map(|x| pool.value(Value::Real(x)));
        let mut wrong = Vec::with_capacity(items.len());
        for item in items {
            let earned = self.earned_where(pool, item.earner);
            let guard = pool.binary(Binary::And, item.guard, earned);
            let least = pool.binary(Binary::Le, bounds[0], item.value);
            let most = pool.binary(Binary::Le, item.value, bounds[1]);
            let right = pool.binary(Binary::And, least, most);
            let not = pool.unary(Unary::Not, right);
            wrong.push(pool.binary(Binary::And, guard, not));
        }
        let some = pool.joined(Binary::Or, wrong);
        predicates.get(some)
    }

    /// Returns the states in which some item of a structure may apply to a choice: in all others, every
    /// choice earns 0. A structure without a meaning applies everywhere, so that its error is found.
    pub fn earning(&self, structure: &RewardStructure) -> Predicate {
        let mut predicates = Predicates::over(self);
        let pool = predicates.pool();
        let mut some = Vec::with_capacity(structure.items.len());
        for item in &structure.items {
            let earned = self.earned_where(pool, item.earner);
            some.push(pool.binary(Binary::And, item.guard, earned));
        }
        let some = match structure.errors.is_empty() {
            true => pool.joined(Binary::Or, some),
            false => pool.value(Value::Bool(true)),
        };
        predicates.get(some)
    }

    /// Returns the states in which some choice earns.
    fn earned_where(&self, pool: &mut ExprPool, earner: Earner) -> ExprId {
        match earner {
            Earner::State => pool.value(Value::Bool(true)),
            Earner::Command(command) => self.commands[command.index()].guard,
            Earner::Action(action) => {
                let with = self.synchronisations.iter().filter(|s| s.action == action);
                let enabled = with.map(|s| s.enabled_where(pool, &self.commands)).collect();
                pool.joined(Binary::Or, enabled)
            }
        }
    }

    /// Returns what a choice of a state earns: the sum of the rewards of the state, of the action of
    /// the choice, and of its commands. A self-loop of a deadlock has no action. The single choice
    /// of a `dtmc` earns the mean over the combinations that it draws from.
    ///
    /// # Errors
    /// The structure has no meaning; a reward is negative or has no value in this state; the choices
    /// of the state have no meaning.
    pub fn reward(&self, structure: &RewardStructure, state: &[i64], choice: &Choice) -> Result<BigRational> {
        let one;
        let drawn;
        let combinations = match choice {
            Choice::Deadlock => &[],
            Choice::Combination { synchronisation, commands } => {
                one = [(*synchronisation, commands.clone())];
                &one[..]
            }
            Choice::Uniform => {
                drawn = self.combinations(state).map_err(|fault| super::fault::error(self, &fault, state))?;
                &drawn[..]
            }
        };
        self.reward_of(structure, state, combinations)
    }

    /// Does the same as [`Program::reward`] for the combinations that the choice draws from.
    ///
    /// # Errors
    /// The structure has no meaning; a reward is negative or has no value in this state.
    pub fn reward_of(
        &self,
        structure: &RewardStructure,
        state: &[i64],
        combinations: &[Combination],
    ) -> Result<BigRational> {
        self.sum_of(structure, state, combinations, |item| {
            let value = self.value(structure, item, state)?;
            if value.is_negative() { Err(self.negative(structure, item, state, &value)) } else { Ok(value) }
        })
    }

    /// Does the same as [`Program::reward_of`] for rewards of any sign.
    ///
    /// # Errors
    /// The structure has no meaning; a reward has no value in this state.
    pub fn signed_reward_of(
        &self,
        structure: &RewardStructure,
        state: &[i64],
        combinations: &[Combination],
    ) -> Result<BigRational> {
        self.sum_of(structure, state, combinations, |item| self.value(structure, item, state))
    }

    fn sum_of(
        &self,
        structure: &RewardStructure,
        state: &[i64],
        combinations: &[Combination],
        value_of: impl Fn(&RewardItem) -> Result<BigRational>,
    ) -> Result<BigRational> {
        if !structure.errors.is_empty() {
            return Err(Error::Input(structure.errors.clone()));
        }
        let mut sum = BigRational::zero();
        for item in &structure.items {
            let (earning, of) = match item.earner {
                Earner::State => (1, 1),
                earner => {
                    let earns = |(s, commands): &&Combination| self.earns(earner, *s, commands);
                    (combinations.iter().filter(earns).count(), combinations.len())
                }
            };
            if earning > 0 && self.applies(structure, item, state)? {
                let value = value_of(item)?;
                sum +=
                    if earning == of { value } else { value * BigRational::new(earning.into(), of.into()) };
            }
        }
        Ok(sum)
    }

    fn earns(&self, earner: Earner, synchronisation: usize, commands: &[CommandId]) -> bool {
        match earner {
            Earner::State => true,
            Earner::Action(action) => self.synchronisations[synchronisation].action == action,
            Earner::Command(command) => commands.contains(&command),
        }
    }

    fn applies(&self, structure: &RewardStructure, item: &RewardItem, state: &[i64]) -> Result<bool> {
        match self.pool.eval(item.guard, state) {
            Ok(guard) => Ok(guard == Value::Bool(true)),
            Err(reason) => Err(self.undefined(structure, item, state, reason)),
        }
    }

    fn value(&self, structure: &RewardStructure, item: &RewardItem, state: &[i64]) -> Result<BigRational> {
        let value = self.pool.eval_exact(item.value, state);
        value.map_err(|reason| self.undefined(structure, item, state, reason))
    }

    fn negative(
        &self,
        structure: &RewardStructure,
        item: &RewardItem,
        state: &[i64],
        value: &BigRational,
    ) -> Error {
        let (title, at) = (structure.title(), self.show_state(state));
        let message = format!("the reward structure {title} earns {value} in the state {at}");
        let diagnostic = Diagnostic::new(&self.source, item.span.range(), message);
        let help = "rewards must be at least 0, except in `C<=k`, `I=k` and `S`";
        diagnostic.label("negative").help(help).into()
    }

    fn undefined(
        &self,
        structure: &RewardStructure,
        item: &RewardItem,
        state: &[i64],
        reason: EvalError,
    ) -> Error {
        let (title, at) = (structure.title(), self.show_state(state));
        let message = format!("the reward structure {title} has no value in the state {at}: {reason}");
        Diagnostic::new(&self.source, item.span.range(), message).label(reason.to_string()).into()
    }
}
