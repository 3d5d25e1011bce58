//! Strategies for several objectives, as files state them: their values are computed again, and runs are drawn.

use std::fmt;

use super::Evaluator;
use super::several::Read;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_base::random::Draw;
use meliora_engine::Engine;
use meliora_equations::several::{Counted, Node};
use meliora_equations::{Arena, Value};
use meliora_lang::property::Optimum;
use meliora_lang::property::term::{Term, TermKind};
use meliora_model::State;
use meliora_quantities::followed::{Followed, NodeFault, misremembered};
use meliora_quantities::{Bounds, Interval};

/// The objectives of a property `multi(…)` in the only initial state.
pub struct Objectives<'m> {
    pub(super) arena: &'m Arena<'m>,
    pub(super) start: State,
    pub(super) read: Vec<Read>,
    texts: Vec<String>,
}

/// A strategy of a file: the states that it visits, the start first, with its memory and the choices that it takes there.
pub type Nodes = Vec<(State, Node)>;

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
    /// The memory of a node is not that of the paths that lead to it, or no path leads to it.
    Memory,
    /// Another node has the same state and memory.
    Twice,
    /// The formula has fewer sets that are visited again and again.
    Round,
    /// A node is wrong.
    Node(NodeFault),
}

impl fmt::Display for StrategyFaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            StrategyFaultKind::Start => f.write_str("the strategy does not begin in the initial state"),
            StrategyFaultKind::Unknown => f.write_str("the model does not reach a state of the strategy"),
            StrategyFaultKind::Memory => f.write_str(
                "`decided` and `steps` of a node are not those of the paths of the strategy that lead to it",
            ),
            StrategyFaultKind::Twice => f.write_str("two nodes have the same state and memory"),
            StrategyFaultKind::Round => f.write_str(
                "`round` of a node is not the number of a set that the formula visits again and again, from 0",
            ),
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

    /// Returns whether some objective has a bound.
    pub fn have_bounds(&self) -> bool {
        self.read.iter().any(|own| own.bound.is_some())
    }

    /// Returns whether some objective asks for its best value.
    pub fn are_open(&self) -> bool {
        self.read.iter().any(|own| own.bound.is_none())
    }

    /// Returns whether the mean of strategies with these shares satisfies the bound of an objective, if it has one. Fractions
    /// decide where bounds of their values do not.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn is_satisfied(&self, at: usize, all: &[(Ratio, &Following<'_>)]) -> Result<bool> {
        let Some(bound) = &self.read[at].bound else { return Ok(true) };
        let is_max = self.read[at].optimum == Optimum::Max;
        let reaches = |mean: Option<Ratio>| mean.map_or(is_max, |mean| self.reaches(at, &mean, bound));
        let drawn = || all.iter().filter(|(share, _)| *share != Ratio::default());
        let mut found = Vec::new();
        for (share, following) in drawn() {
            found.push((share, following.value(at, false)?.interval()));
        }
        let mean = |side: fn(&Interval) -> f64| {
            found.iter().map(|(share, own)| Some(Ratio::from_float(side(own))? * *share)).sum()
        };
        let (lower, upper) = (mean(|own| own.lower), mean(|own| own.upper));
        let (worst, best) = if is_max { (lower, upper) } else { (upper, lower) };
        match (reaches(worst), reaches(best)) {
            (true, _) => return Ok(true),
            (_, false) => return Ok(false),
            (false, true) => {}
        }
        let mut mean = Some(Ratio::default());
        for (share, following) in drawn() {
            let own = match following.value(at, true)? {
                Value::Finite(Bounds { exact: Some(exact), .. }) => Some(exact),
                Value::Infinite => None,
                Value::Finite(_) => return Ok(false),
            };
            mean = mean.zip(own).map(|(mean, own)| mean + own * share);
        }
        Ok(reaches(mean))
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
        for (state, node) in strategy {
            let number = self.arena.number(state);
            if self.arena.state(number) != *state {
                return fault(state, StrategyFaultKind::Unknown);
            }
            nodes.push(Node { state: number, ..node.clone() });
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
        let fault = |at: usize, kind| StrategyFault { state: self.arena.state(nodes[at].state), kind };
        let chain = match Followed::new(self.arena, nodes)? {
            Ok(chain) => chain,
            Err((at, kind)) => return Ok(Err(fault(at, StrategyFaultKind::Node(kind)))),
        };
        let objectives: Vec<_> = self.read.iter().map(Read::objective).collect();
        let objectives: Vec<_> = objectives.iter().map(|own| (own.counted, own.optimum)).collect();
        Ok(match misremembered(&objectives, nodes) {
            Some(at) => Err(fault(at, StrategyFaultKind::Memory)),
            None => Ok(Following { objectives: self, chain }),
        })
    }
}

impl<'m> Following<'m> {
    fn value(&self, at: usize, exact: bool) -> Result<Value> {
        self.chain.value(self.objectives.counted(at), self.objectives.read[at].negated, exact)
    }

    /// Returns the value of an objective, and whether it is as good as a claimed one. Fractions decide if bounds do not.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn attains(&self, at: usize, claim: &Ratio) -> Result<(Interval, bool)> {
        let is_max = self.objectives.read[at].optimum == Optimum::Max;
        let reaches = |x: f64| match Ratio::from_float(x) {
            Some(x) => self.objectives.reaches(at, &x, claim),
            None => is_max,
        };
        let found = self.value(at, false)?.interval();
        let (worst, best) = if is_max { (found.lower, found.upper) } else { (found.upper, found.lower) };
        match (reaches(worst), reaches(best)) {
            (true, _) => Ok((found, true)),
            (_, false) => Ok((found, false)),
            (false, true) => match self.value(at, true)? {
                Value::Finite(Bounds { exact: Some(exact), interval }) => {
                    Ok((interval, self.objectives.reaches(at, &exact, claim)))
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
