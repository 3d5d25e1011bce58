//! Strategies for several objectives, as files state them: their values are computed again, and runs are drawn.

use std::fmt;

use super::Evaluator;
use super::operators::position;
use super::several::Read;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_base::random::Draw;
use meliora_engine::Engine;
use meliora_lang::property::Optimum;
use meliora_lang::property::term::{Term, TermKind};
use meliora_model::State;
use meliora_quantities::equations::arena::Arena;
use meliora_quantities::followed::{Followed, NodeFault};
use meliora_quantities::path_values::Value;
use meliora_quantities::several::{Counted, Node, Taking};
use meliora_quantities::{Bounds, Interval};

/// The objectives of a property `multi(…)` in the only initial state.
pub struct Objectives<'m> {
    pub(super) arena: &'m Arena<'m>,
    pub(super) start: State,
    pub(super) read: Vec<Read>,
    texts: Vec<String>,
}

/// A strategy of a file: the states that it visits, the start first, with the choices that it takes there.
pub type Nodes = Vec<(State, Vec<Taking>)>;

/// A reason why a strategy is none of a model, with the state.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StrategyFault {
    /// The state.
    pub state: State,
    /// The fault.
    pub kind: StrategyFaultKind,
}

/// The faults of a strategy.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StrategyFaultKind {
    /// It does not begin in the initial state.
    Start,
    /// A state is not in the scope.
    Unknown,
    /// A node is wrong.
    Node(NodeFault),
}

impl fmt::Display for StrategyFaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StrategyFaultKind::Start => f.write_str("the strategy does not begin in the initial state"),
            StrategyFaultKind::Unknown => f.write_str("the model does not reach a state of the strategy"),
            StrategyFaultKind::Node(NodeFault::Open) => {
                f.write_str("the strategy has no action in a state that it visits")
            }
            StrategyFaultKind::Node(NodeFault::Disabled(position)) => {
                write!(f, "the model has no choice with the position {position} in a state of the strategy")
            }
            StrategyFaultKind::Node(NodeFault::Successors(position)) => write!(
                f,
                "the nodes after the choice with the position {position} are not its successors with their probabilities"
            ),
        }
    }
}

/// The values of a strategy.
pub struct Following<'m> {
    objectives: &'m Objectives<'m>,
    chain: Followed<'m>,
}

/// The decisions and gains by which runs are counted.
pub struct Runs<'f> {
    of: &'f Following<'f>,
    rests: Vec<Vec<Option<f64>>>,
    gains: Vec<Vec<Vec<f64>>>,
}

impl<E: Engine> Evaluator<'_, '_, E> {
    /// Reads the objectives of a property `multi(…)`. Cost: that of the states in its formulas.
    ///
    /// # Errors
    /// The property is another one; there are several initial states; the errors of [`Evaluator::answer`].
    pub fn objectives(&self, term: &Term) -> Result<Objectives<'_>> {
        let initial = self.at(&self.engine.initial_states())?;
        let (TermKind::Multi(all), [start]) = (&term.kind, initial.list.as_slice()) else {
            let message = "the strategies of `multi` begin in one initial state";
            return Err(self.wrong(term, message).into());
        };
        let arena: &Arena<'_> = self.model.arena()?;
        let read = self.read(arena, all, start)?;
        let texts = all.iter().map(|objective| self.text(objective)).collect();
        Ok(Objectives { arena, start: start.clone(), read, texts })
    }
}

impl Objectives<'_> {
    /// Returns the texts of the objectives.
    pub fn texts(&self) -> &[String] {
        &self.texts
    }

    /// Returns true if an objective is a probability.
    pub fn is_probability(&self, at: usize) -> bool {
        matches!(self.counted(at), Counted::Visit(_) | Counted::Until(..) | Counted::Recur(_))
    }

    /// Returns whether a value of an objective is as good as a bound.
    fn reaches(&self, at: usize, value: &Ratio, bound: &Ratio) -> bool {
        if self.read[at].optimum == Optimum::Max { value >= bound } else { value <= bound }
    }

    /// Returns whether the mean of some strategies satisfies the bound of an objective, if it has one.
    pub fn is_satisfied(&self, at: usize, mean: f64, slack: f64) -> bool {
        let better = if self.read[at].optimum == Optimum::Max { mean + slack } else { mean - slack };
        let bound = self.read[at].bound.as_ref();
        bound.is_none_or(|bound| Ratio::from_float(better).is_some_and(|mean| self.reaches(at, &mean, bound)))
    }

    fn counted(&self, at: usize) -> Counted<'_> {
        self.read[at].objective().counted
    }

    /// Returns the nodes of a strategy by the numbers of their states, or the first fault.
    pub fn nodes(&self, strategy: &Nodes) -> std::result::Result<Vec<Node>, StrategyFault> {
        let fault = |state: &State, kind| Err(StrategyFault { state: state.clone(), kind });
        if let Some((state, _)) = strategy.first().filter(|(state, _)| *state != self.start) {
            return fault(state, StrategyFaultKind::Start);
        }
        let mut nodes = Vec::new();
        for (state, choices) in strategy {
            let number = position(self.arena, state);
            if self.arena.state(number) != *state {
                return fault(state, StrategyFaultKind::Unknown);
            }
            nodes.push(Node { state: number, decided: 0, steps: 0, choices: choices.clone() });
        }
        Ok(nodes)
    }

    /// Follows a strategy, or returns its first fault. Cost: linear.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub fn follow<'m>(
        &'m self,
        nodes: &'m [Node],
    ) -> Result<std::result::Result<Following<'m>, StrategyFault>> {
        let fault = |(at, kind): (usize, NodeFault)| {
            let state = self.arena.state(nodes[at].state);
            StrategyFault { state, kind: StrategyFaultKind::Node(kind) }
        };
        let chain = Followed::new(self.arena, nodes)?;
        Ok(chain.map(|chain| Following { objectives: self, chain }).map_err(fault))
    }
}

impl<'m> Following<'m> {
    fn value(&self, at: usize, exact: bool) -> Result<Value> {
        self.chain.value(self.objectives.counted(at), self.objectives.read[at].negated, exact)
    }

    /// Returns the value of an objective, and whether it is as good as a claimed one. Fractions decide if bounds do not; a
    /// claim is rounded to the nearest double.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn attains(&self, at: usize, claimed: f64) -> Result<(Interval, bool)> {
        let is_max = self.objectives.read[at].optimum == Optimum::Max;
        let claim = Ratio::from_float(if is_max { claimed.next_down() } else { claimed.next_up() });
        let Some(claim) = claim else { return Ok((self.value(at, false)?.interval(), false)) };
        let reaches = |x: f64| match Ratio::from_float(x) {
            Some(x) => self.objectives.reaches(at, &x, &claim),
            None => is_max,
        };
        let found = self.value(at, false)?.interval();
        let (worst, best) = if is_max { (found.lower, found.upper) } else { (found.upper, found.lower) };
        match (reaches(worst), reaches(best)) {
            (true, _) => Ok((found, true)),
            (_, false) => Ok((found, false)),
            (false, true) => match self.value(at, true)? {
                Value::Finite(Bounds { exact: Some(exact), interval }) => {
                    Ok((interval, self.objectives.reaches(at, &exact, &claim)))
                }
                other => Ok((other.interval(), reaches(other.interval().lower))),
            },
        }
    }

    /// Prepares runs. Cost: linear for each objective.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn runs(&self) -> Result<Runs<'_>> {
        let all = || (0..self.objectives.read.len()).map(|at| self.objectives.counted(at));
        let rests = all().map(|counted| self.chain.rests(counted)).collect::<Result<_>>()?;
        Ok(Runs { of: self, rests, gains: all().map(|counted| self.chain.gains(counted)).collect() })
    }
}

impl Runs<'_> {
    /// Draws a run, of at most some steps; returns the number that it counts of each objective, `None` where it was given up before.
    pub fn run(&self, most: u64, draw: &mut Draw) -> Vec<Option<f64>> {
        let (mut node, mut step) = (0, 0);
        let count = self.rests.len();
        let (mut found, mut sums) = (vec![None; count], vec![0.0; count]);
        loop {
            for at in 0..count {
                let is_over = matches!(self.of.objectives.counted(at), Counted::Within(_, steps) if step >= steps.into());
                let rest = if is_over { Some(0.0) } else { self.rests[at][node] };
                if let (None, Some(rest)) = (found[at], rest) {
                    found[at] = Some(sums[at] + rest);
                }
            }
            if step == most || found.iter().all(Option::is_some) {
                break;
            }
            let (taken, next) = self.of.chain.drawn(node, draw);
            for (sum, gains) in sums.iter_mut().zip(&self.gains) {
                *sum += gains.get(node).map_or(0.0, |own| own[taken]);
            }
            (node, step) = (next, step + 1);
        }
        let negated = self.of.objectives.read.iter().map(|own| own.negated);
        found
            .into_iter()
            .zip(negated)
            .map(|(x, negated)| if negated { x.map(|x| 1.0 - x) } else { x })
            .collect()
    }
}
