//! Models that list their states one by one: UMB, Storm's DRN, and PRISM's explicit files.
//!
//! Each reader fills a [`Table`]. [`lower`] turns it into a flat program with few commands: the
//! choices of all states with the same action become one command, whose guard, probabilities and
//! updates are decision trees over the state ([`tree`]).

mod drn;
mod earned;
mod lines;
mod lower;
mod sections;
mod tra;
mod tree;
mod umb;
mod valuations;

use std::sync::Arc;

use num_traits::Zero;

use meliora_base::error::{Result, SourceFile};
use meliora_base::exact::{Exact, Ratio, Real};
use meliora_base::progress::Poll;
use meliora_base::rounding::{Sum, is_weight, judged};
use meliora_base::span::Span;
use meliora_base::value::Type;
use meliora_model::ModelKind;
use meliora_model::expr::{ExprId, ExprPool};

pub(crate) use drn::{is_drn, load as load_drn};
pub use earned::RewardFiles;
pub(crate) use lower::Frame;
pub(crate) use sections::has_states;
pub(crate) use tra::{is_tra, load as load_tra};
pub(crate) use umb::load as load_umb;

/// A model as lists of its states, choices and branches.
pub(crate) struct Table {
    kind: ModelKind,
    /// The numbers in it, as literals.
    pool: ExprPool,
    /// For each state, the number of its first choice; last, the number of choices.
    choices: Vec<usize>,
    /// For each choice, the number of its first branch; last, the number of branches.
    branches: Vec<usize>,
    /// For each choice, the number of its action, if it has one.
    action_of: Vec<Option<usize>>,
    actions: Vec<String>,
    /// The target of each branch.
    targets: Vec<usize>,
    /// The probability of each branch.
    probabilities: Vec<ExprId>,
    /// The initial states, in ascending order.
    initial: Vec<usize>,
    /// Labels with their states, in ascending order.
    labels: Vec<(String, Vec<usize>)>,
    /// The variables; none if states have only numbers.
    columns: Vec<Column>,
    rewards: Vec<Rewards>,
    /// The names of the players of a game; none for other models.
    players: Vec<String>,
    /// The player of each state of a game; that of a deadlock has no meaning.
    owners: Vec<usize>,
    /// Facts that a user should know.
    warnings: Vec<String>,
}

/// A variable with its value in each state.
struct Column {
    name: String,
    /// The place of the name, if it is not in the text of the model or has none.
    place: Option<(Arc<SourceFile>, Span)>,
    ty: Type,
    low: i64,
    high: i64,
    /// The names of the values from `low` on, if they have names.
    names: Vec<String>,
    values: Vec<i64>,
}

/// A reward structure.
struct Rewards {
    name: Option<String>,
    states: Option<Vec<ExprId>>,
    choices: Option<Vec<ExprId>>,
}

/// Returns the names of players without names: `p1`, `p2`, …
fn numbered_players(count: usize) -> Vec<String> {
    (1..=count).map(|number| format!("p{number}")).collect()
}

impl Table {
    fn new(kind: ModelKind) -> Self {
        Table {
            kind,
            pool: ExprPool::default(),
            choices: vec![0],
            branches: vec![0],
            action_of: Vec::new(),
            actions: Vec::new(),
            targets: Vec::new(),
            probabilities: Vec::new(),
            initial: Vec::new(),
            labels: Vec::new(),
            columns: Vec::new(),
            rewards: Vec::new(),
            players: Vec::new(),
            owners: Vec::new(),
            warnings: Vec::new(),
        }
    }

    fn states(&self) -> usize {
        self.choices.len() - 1
    }

    /// Returns the player of a state; 0 if the model is not a game.
    fn owner(&self, state: usize) -> usize {
        self.owners.get(state).copied().unwrap_or_default()
    }

    /// Returns the literal of a number, which keeps its exact value.
    fn number(&mut self, exact: Ratio) -> ExprId {
        self.pool.exact_value(Exact::Real(Real::Finite(exact)))
    }

    /// Returns the literal of a double, which stands for itself and not for a decimal.
    fn double(&mut self, x: f64) -> ExprId {
        self.pool.exact_value(Exact::Real(Real::from(x)))
    }

    /// Adds a branch to the last choice of the last state.
    fn branch(&mut self, target: usize, probability: Ratio) {
        self.targets.push(target);
        let probability = self.number(probability);
        self.probabilities.push(probability);
        self.end();
    }

    /// Moves the ends of the last state and the last choice to the last branch.
    fn end(&mut self) {
        let (choices, branches) = (self.action_of.len(), self.targets.len());
        self.choices.last_mut().into_iter().for_each(|end| *end = choices);
        self.branches.last_mut().into_iter().for_each(|end| *end = branches);
    }

    fn value(&self, number: ExprId) -> Real {
        self.pool.exact_literal(number).map_or(Real::Undefined, Exact::into_real)
    }

    /// Adds to the reward of each choice the expected reward of its branches.
    fn expected(&mut self, choices: Option<&[ExprId]>, branches: &[ExprId]) -> Vec<ExprId> {
        let mut all = Vec::new();
        for choice in 0..self.branches.len() - 1 {
            let mut sum = choices.map_or_else(Ratio::zero, |of| self.exact(of[choice]));
            let row = self.branches[choice]..self.branches[choice + 1];
            for (weight, earned) in self.probabilities[row.clone()].iter().zip(&branches[row]) {
                sum += self.exact(*weight) * self.exact(*earned);
            }
            all.push(self.number(sum));
        }
        all
    }

    /// Returns the exact value of a literal; 0 for one that is not finite.
    fn exact(&self, number: ExprId) -> Ratio {
        self.pool.eval_exact(number, &[]).unwrap_or_else(|_| Ratio::zero())
    }

    /// Checks what readers leave unchecked: targets, distributions, and the choices of a `dtmc`.
    /// Returns the first fault: a state and the reason.
    fn first_fault(&self, poll: &mut Poll<'_>) -> Result<Option<(usize, String)>> {
        for state in 0..self.states() {
            poll.step()?;
            let choices = self.choices[state]..self.choices[state + 1];
            if self.kind == ModelKind::Dtmc && choices.len() > 1 {
                return Ok(Some((state, format!("{} choices in a dtmc", choices.len()))));
            }
            for choice in choices.clone() {
                if let Some(reason) = self.fault_of(choice) {
                    return Ok(Some((state, format!("choice {}: {reason}", choice - choices.start))));
                }
            }
        }
        Ok(None)
    }

    fn fault_of(&self, choice: usize) -> Option<String> {
        let branches = self.branches[choice]..self.branches[choice + 1];
        if let Some(far) = self.targets[branches.clone()].iter().find(|t| **t >= self.states()) {
            return Some(format!("the target {far} is not one of the {} states", self.states()));
        }
        let weights = self.probabilities[branches].iter().map(|p| self.value(*p));
        if let Some(wrong) = weights.clone().find(|p| !is_weight(p)) {
            return Some(format!("{wrong} is not a probability"));
        }
        match judged(weights.map(Ok)) {
            Ok((Sum::Wrong, sum)) => Some(format!("the probabilities sum to {sum}, not to 1")),
            Ok(_) => None,
            Err(reason) => Some(format!("the sum of the probabilities: {reason}")),
        }
    }
}
