//! One step of a program from one state: the reference semantics of commands.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use super::expr::ExprId;
use super::weight::Probability;
pub use super::weight::StepError;
use super::{Branch, CommandId, ModelKind, Program, State, VarId};
use meliora_base::exact::Ratio;
use meliora_base::rounding::Sum;
use meliora_base::value::{EvalError, Value};

/// A choice of a state, as in the choice sets of the engines.
#[derive(Debug, Clone, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Choice {
    /// One command of each factor of a synchronisation.
    Combination {
        /// The position in [`Program::synchronisations`].
        synchronisation: usize,
        /// One command per factor.
        commands: Vec<CommandId>,
    },
    /// The only choice of a state of a `dtmc`: all enabled combinations.
    Uniform,
    /// The self-loop of a deadlock state.
    Deadlock,
}

/// One enabled command of each factor of a synchronisation, which is given by its position in
/// [`Program::synchronisations`].
pub type Combination = (usize, Vec<CommandId>);

/// A choice with its distribution over successors.
#[derive(Debug, Clone, PartialEq)]
pub struct Step<W = f64> {
    /// The choice.
    pub choice: Choice,
    /// Its name: see [`Program::choices`].
    pub name: String,
    /// Each successor once, with its probability.
    pub successors: Vec<(State, W)>,
}

/// Maximum number of choices of a state, and of ways to take their branches: synchronised commands
/// multiply.
pub const MOST_WAYS: usize = 1 << 20;

/// New values by position of the variable, and the probability.
type Taken<W> = (Vec<(usize, i64)>, W);

impl Program {
    /// Returns all choices of `state` in the order of the program, each with its name. Checks the
    /// probabilities of enabled commands, but takes no branch.
    ///
    /// An action is named by its label; the k-th unlabelled command of a module is `module#k`. If a
    /// label has several choices in this state, the commands' numbers follow: `label(m1#2,m2#1)`. A
    /// state without an enabled command has a self-loop named `deadlock`.
    ///
    /// # Errors
    /// A guard has no value, probabilities are invalid, or there are too many choices.
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

    /// Returns the choices of `state` as [`Program::choices`] lists them, each with its
    /// distribution.
    ///
    /// # Errors
    /// A command has no meaning in this state, or there are too many choices or successors.
    pub fn steps(&self, state: &[i64]) -> Result<Vec<Step>, StepError> {
        self.weighted_steps(state)
    }

    /// Returns the same choices and successors as [`Program::steps`], with exact probabilities.
    ///
    /// Probabilities are those of the text: 0.1 is one tenth, and divisions are exact; see
    /// [`meliora_base::exact`]. If those of a command do not sum to 1 (three times 0.333333), each is
    /// divided by the sum.
    ///
    /// # Errors
    /// The errors of [`Program::steps`].
    pub fn exact_steps(&self, state: &[i64]) -> Result<Vec<Step<Ratio>>, StepError> {
        self.weighted_steps(state)
    }

    /// Returns the probabilities of the branches of an enabled command, those of probability 0 left
    /// out, as [`Program::exact_steps`] uses them.
    ///
    /// # Errors
    /// A probability has no value.
    pub fn exact_branches(&self, id: CommandId, state: &[i64]) -> Result<Vec<Ratio>, StepError> {
        Ok(Ratio::branches(self, id, state)?.into_iter().map(|(_, p)| p).collect())
    }

    /// Returns those of [`Program::exact_steps`] that belong to some synchronisations, given by their positions: all
    /// synchronisations of an action, or none, so that the names are the same. Other commands are not evaluated.
    ///
    /// # Errors
    /// The errors of [`Program::steps`].
    pub fn exact_steps_of(&self, state: &[i64], among: &[usize]) -> Result<Vec<Step<Ratio>>, StepError> {
        let combinations = self.combinations_of(state, among.iter().copied())?;
        if combinations.is_empty() { Ok(Vec::new()) } else { self.weighted(state, combinations) }
    }

    fn weighted_steps<W: Probability>(&self, state: &[i64]) -> Result<Vec<Step<W>>, StepError> {
        self.weighted(state, self.combinations(state)?)
    }

    fn weighted<W: Probability>(
        &self,
        state: &[i64],
        combinations: Vec<Combination>,
    ) -> Result<Vec<Step<W>>, StepError> {
        if combinations.is_empty() {
            let successors = vec![(state.to_vec(), W::one())];
            return Ok(vec![Step { choice: Choice::Deadlock, name: "deadlock".into(), successors }]);
        }
        let names = self.names(&combinations);
        let (mut steps, mut ways) = (Vec::new(), 0);
        for ((synchronisation, commands), name) in combinations.into_iter().zip(names) {
            let successors = self.distribution(&commands, state, &mut ways)?;
            steps.push(Step { choice: Choice::Combination { synchronisation, commands }, name, successors });
        }
        Ok(match self.kind {
            ModelKind::Mdp | ModelKind::Smg => steps,
            ModelKind::Dtmc => vec![uniform(steps)],
        })
    }

    /// Returns the combinations of enabled commands, one of each factor, by synchronisation.
    pub(super) fn combinations(&self, state: &[i64]) -> Result<Vec<Combination>, StepError> {
        self.combinations_of(state, 0..self.synchronisations.len())
    }

    fn combinations_of(
        &self,
        state: &[i64],
        among: impl Iterator<Item = usize>,
    ) -> Result<Vec<Combination>, StepError> {
        let mut combinations = Vec::new();
        for index in among {
            let mut enabled = Vec::new();
            for factor in &self.synchronisations[index].factors {
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

    /// Checks that every probability is in [0,1] and that they sum to 1, possibly after rounding.
    fn check_probabilities(&self, id: CommandId, state: &[i64]) -> Result<(), StepError> {
        match self.judged(&self.commands[id.index()], state) {
            Ok((Sum::Wrong, wrong)) => Err(StepError::Probability(id, wrong)),
            Ok(_) => Ok(()),
            Err(reason) => Err(StepError::Eval(id, reason)),
        }
    }

    /// Returns the successors for all ways to take a branch of each command; `ways` counts the ways
    /// over all choices of a state.
    fn distribution<W: Probability>(
        &self,
        commands: &[CommandId],
        state: &[i64],
        ways: &mut usize,
    ) -> Result<Vec<(State, W)>, StepError> {
        let mut partial = vec![(state.to_vec(), W::one())];
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
                    next.push((values, weight.scaled(p)));
                }
            }
            partial = next;
        }
        *ways += partial.len();
        Ok(merge(partial))
    }

    /// Returns the branches of positive probability: the new values and the probability.
    fn taken_branches<W: Probability>(
        &self,
        id: CommandId,
        state: &[i64],
    ) -> Result<Vec<Taken<W>>, StepError> {
        let mut taken = Vec::new();
        for (branch, p) in W::branches(self, id, state)? {
            taken.push((self.new_values(id, branch, state)?, p));
        }
        Ok(taken)
    }

    /// Returns the variables that a branch of a command writes in a state, each with its new value.
    ///
    /// # Errors
    /// An update has no value, or one out of range.
    pub fn new_values(
        &self,
        id: CommandId,
        branch: &Branch,
        state: &[i64],
    ) -> Result<Vec<(usize, i64)>, StepError> {
        let new = |&(v, e): &(VarId, ExprId)| Ok((v.index(), self.updated(id, v, e, state)?));
        branch.updates.iter().map(new).collect()
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

    /// Returns the names of combinations that are enabled in one state.
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

    /// Formats the numbers of commands, for example as `m1#2,m2#1`.
    fn numbers(&self, commands: &[CommandId]) -> String {
        // Monitors take part in every step and are not chosen.
        let watches = |id: &&CommandId| self.monitors.as_ref().is_some_and(|o| o.command == id.index());
        let number = |id: &CommandId| {
            let command = &self.commands[id.index()];
            format!("{}#{}", self.modules[command.module], command.number)
        };
        commands.iter().filter(|id| !watches(id)).map(number).collect::<Vec<_>>().join(",")
    }
}

/// Merges all choices into one that selects each with the same probability.
fn uniform<W: Probability>(steps: Vec<Step<W>>) -> Step<W> {
    let share = W::share(steps.len());
    let name = steps.iter().map(|s| s.name.as_str()).collect::<Vec<_>>().join("+");
    let all = steps.into_iter().flat_map(|s| s.successors).map(|(s, p)| (s, p.scaled(&share))).collect();
    Step { choice: Choice::Uniform, name, successors: merge(all) }
}

/// Adds up the probabilities of equal states; the result is ordered by state.
fn merge<W: Probability>(weighted: Vec<(State, W)>) -> Vec<(State, W)> {
    let mut sums: BTreeMap<State, W> = BTreeMap::new();
    for (state, p) in weighted {
        match sums.entry(state) {
            Entry::Vacant(entry) => {
                entry.insert(p);
            }
            Entry::Occupied(mut entry) => *entry.get_mut() = entry.get().plus(&p),
        }
    }
    sums.into_iter().collect()
}

/// Returns the Cartesian product, first factor slowest.
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
