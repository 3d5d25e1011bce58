//! One step of a program from one state: the reference meaning of commands.

use std::collections::BTreeMap;

use super::expr::ExprId;
use super::rounding::Sum;
use super::value::{EvalError, Value};
use super::{Command, CommandId, ModelKind, Program, State, VarId};

/// Which choice of a state: what the engines' sets of choices speak of.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Choice {
    /// One command of each factor of a synchronisation, by its position in the program.
    Combination {
        /// The position in [`Program::synchronisations`].
        synchronisation: usize,
        /// One command a factor.
        commands: Vec<CommandId>,
    },
    /// The only choice of a state of a `dtmc`: all enabled combinations.
    Uniform,
    /// The self-loop of a deadlock state.
    Deadlock,
}

/// A choice with the distribution it leads to.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Which choice.
    pub choice: Choice,
    /// Its name: see [`Program::choices`].
    pub name: String,
    /// Each successor once, with its probability.
    pub successors: Vec<(State, f64)>,
}

/// Why a step has no meaning in a state.
#[derive(Debug, Clone, PartialEq)]
pub enum StepError {
    /// An expression has no value: that of a guard, a probability or an update.
    Eval(CommandId, EvalError),
    /// The probabilities of a command sum to this, or one of them is this.
    Probability(CommandId, f64),
    /// An update leaves the range of its variable with this value.
    OutOfRange(CommandId, VarId, i64),
    /// More choices or successors than [`MOST_WAYS`].
    TooMany,
}

/// A state with more choices, or more ways to take the branches of them, is not listed: synchronised
/// commands multiply.
pub const MOST_WAYS: usize = 1 << 20;

/// Positions of variables with their new values, and the probability.
type Taken = (Vec<(usize, i64)>, f64);

impl Program {
    /// All choices of `state` in the order of the program, each with its name; commands that are
    /// enabled have their probabilities checked, but no branch is taken.
    ///
    /// An action is named by its label, `module#k` for the k-th unlabelled command of a module; where
    /// one label has several choices in this state, the name is followed by the commands' numbers,
    /// `label(m1#2,m2#1)`. A state without an enabled command has the self-loop, named `deadlock`.
    ///
    /// # Errors
    /// A guard or probabilities without a meaning in this state; too many choices.
    pub fn choices(&self, state: &[i64]) -> Result<Vec<(Choice, String)>, StepError> {
        let combinations = self.combinations(state)?;
        if combinations.is_empty() {
            return Ok(vec![(Choice::Deadlock, "deadlock".into())]);
        }
        let names = self.names(&combinations);
        if self.kind == ModelKind::Dtmc {
            return Ok(vec![(Choice::Uniform, names.join("+"))]);
        }
        let choice = |(synchronisation, commands)| Choice::Combination { synchronisation, commands };
        Ok(combinations.into_iter().map(choice).zip(names).collect())
    }

    /// The choices of `state` as [`Program::choices`] lists them, each with its distribution.
    ///
    /// # Errors
    /// A command without a meaning in this state; too many choices or successors.
    pub fn steps(&self, state: &[i64]) -> Result<Vec<Step>, StepError> {
        let combinations = self.combinations(state)?;
        if combinations.is_empty() {
            let successors = vec![(state.to_vec(), 1.0)];
            return Ok(vec![Step { choice: Choice::Deadlock, name: "deadlock".into(), successors }]);
        }
        let names = self.names(&combinations);
        let (mut steps, mut ways) = (Vec::new(), 0);
        for ((synchronisation, commands), name) in combinations.into_iter().zip(names) {
            let successors = self.distribution(&commands, state, &mut ways)?;
            steps.push(Step { choice: Choice::Combination { synchronisation, commands }, name, successors });
        }
        Ok(match self.kind {
            ModelKind::Mdp => steps,
            ModelKind::Dtmc => vec![uniform(steps)],
        })
    }

    /// The combinations of enabled commands, one of each factor, by synchronisation.
    fn combinations(&self, state: &[i64]) -> Result<Vec<(usize, Vec<CommandId>)>, StepError> {
        let mut combinations = Vec::new();
        for (index, synchronisation) in self.synchronisations.iter().enumerate() {
            let mut enabled = Vec::new();
            for factor in &synchronisation.factors {
                enabled.push(self.enabled(factor, state)?);
            }
            let count = enabled.iter().fold(1usize, |n, f| n.saturating_mul(f.len()));
            if count.saturating_add(combinations.len()) > MOST_WAYS {
                return Err(StepError::TooMany);
            }
            combinations.extend(product(&enabled).into_iter().map(|commands| (index, commands)));
        }
        Ok(combinations)
    }

    fn enabled(&self, factor: &[CommandId], state: &[i64]) -> Result<Vec<CommandId>, StepError> {
        let mut enabled = Vec::new();
        for &id in factor {
            let guard =
                self.pool.eval(self.commands[id.index()].guard, state).map_err(|e| StepError::Eval(id, e))?;
            if guard == Value::Bool(true) {
                self.check_probabilities(id, state)?;
                enabled.push(id);
            }
        }
        Ok(enabled)
    }

    /// Every probability lies in [0,1] and they sum to 1, if need be rounded.
    fn check_probabilities(&self, id: CommandId, state: &[i64]) -> Result<(), StepError> {
        let mut sum = 0.0;
        for branch in &self.commands[id.index()].branches {
            let p = self.real(branch.probability, id, state)?;
            if !(0.0..=1.0).contains(&p) {
                return Err(StepError::Probability(id, p));
            }
            sum += p;
        }
        if Sum::of(sum) == Sum::Wrong { Err(StepError::Probability(id, sum)) } else { Ok(()) }
    }

    fn real(&self, e: ExprId, id: CommandId, state: &[i64]) -> Result<f64, StepError> {
        Ok(self.pool.eval(e, state).map_err(|e| StepError::Eval(id, e))?.to_f64())
    }

    /// Each way to take a branch of each command; `ways` counts them over all choices of a state.
    fn distribution(
        &self,
        commands: &[CommandId],
        state: &[i64],
        ways: &mut usize,
    ) -> Result<Vec<(State, f64)>, StepError> {
        let mut partial = vec![(state.to_vec(), 1.0)];
        for &id in commands {
            let taken = self.taken_branches(id, state)?;
            if ways.saturating_add(partial.len().saturating_mul(taken.len())) > MOST_WAYS {
                return Err(StepError::TooMany);
            }
            let mut next = Vec::new();
            for (values, weight) in &partial {
                for (updates, p) in &taken {
                    let mut values = values.clone();
                    for &(variable, value) in updates {
                        values[variable] = value;
                    }
                    next.push((values, weight * p));
                }
            }
            partial = next;
        }
        *ways += partial.len();
        Ok(merge(partial))
    }

    /// The branches of positive probability: the variables they write with the new values.
    fn taken_branches(&self, id: CommandId, state: &[i64]) -> Result<Vec<Taken>, StepError> {
        let command: &Command = &self.commands[id.index()];
        let mut taken = Vec::new();
        for branch in &command.branches {
            let p = self.real(branch.probability, id, state)?;
            if p > 0.0 {
                let new = |&(v, e): &(VarId, ExprId)| Ok((v.index(), self.updated(id, v, e, state)?));
                taken.push((branch.updates.iter().map(new).collect::<Result<_, StepError>>()?, p));
            }
        }
        Ok(taken)
    }

    fn updated(&self, id: CommandId, variable: VarId, e: ExprId, state: &[i64]) -> Result<i64, StepError> {
        let value = match self.pool.eval(e, state).map_err(|e| StepError::Eval(id, e))? {
            Value::Bool(b) => i64::from(b),
            Value::Int(i) => i,
            Value::Real(_) => return Err(StepError::Eval(id, EvalError::NotAnInteger)),
        };
        let declared = &self.variables[variable.index()];
        if (declared.low..=declared.high).contains(&value) {
            Ok(value)
        } else {
            Err(StepError::OutOfRange(id, variable, value))
        }
    }

    /// Names for combinations that are enabled in one state.
    pub fn names(&self, combinations: &[(usize, Vec<CommandId>)]) -> Vec<String> {
        let action = |index: usize| self.synchronisations[index].action;
        let mut uses: BTreeMap<usize, usize> = BTreeMap::new();
        for (index, _) in combinations {
            if let Some(a) = action(*index) {
                *uses.entry(a).or_default() += 1;
            }
        }
        let name = |(index, commands): &(usize, Vec<CommandId>)| match action(*index) {
            Some(a) if uses[&a] == 1 => self.actions[a].clone(),
            Some(a) => format!("{}({})", self.actions[a], self.numbers(commands)),
            None => self.numbers(commands),
        };
        combinations.iter().map(name).collect()
    }

    /// `m1#2,m2#1`
    fn numbers(&self, commands: &[CommandId]) -> String {
        // Monitors take part in every step: that is nobody's choice.
        let watches = |id: &&CommandId| self.monitors.as_ref().is_some_and(|o| o.command == id.index());
        let number = |id: &CommandId| {
            let command = &self.commands[id.index()];
            format!("{}#{}", self.modules[command.module], command.number)
        };
        commands.iter().filter(|id| !watches(id)).map(number).collect::<Vec<_>>().join(",")
    }
}

/// One choice out of all, each as likely as the others.
fn uniform(steps: Vec<Step>) -> Step {
    let share = 1.0 / steps.len() as f64;
    let name = steps.iter().map(|s| s.name.as_str()).collect::<Vec<_>>().join("+");
    let all = steps.into_iter().flat_map(|s| s.successors).map(|(s, p)| (s, p * share)).collect();
    Step { choice: Choice::Uniform, name, successors: merge(all) }
}

/// Adds up the probabilities of equal states, in the order of the states.
fn merge(weighted: Vec<(State, f64)>) -> Vec<(State, f64)> {
    let mut sums: BTreeMap<State, f64> = BTreeMap::new();
    for (state, p) in weighted {
        *sums.entry(state).or_default() += p;
    }
    sums.into_iter().collect()
}

/// The Cartesian product, first factor slowest.
fn product(factors: &[Vec<CommandId>]) -> Vec<Vec<CommandId>> {
    let mut all = vec![Vec::new()];
    for factor in factors {
        let longer = |prefix: &Vec<CommandId>| {
            let prefix = prefix.clone();
            factor
                .iter()
                .map(move |&c| prefix.iter().copied().chain([c]).collect::<Vec<_>>())
                .collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}
