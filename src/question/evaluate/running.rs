//! Random runs of the strategy of one operator, and what each of them counts.

use std::collections::VecDeque;

use meliora_base::error::{Error, Result};
use meliora_base::random::Draw;
use meliora_base::value::Value;
use meliora_equations::bottoms;
use meliora_lang::property::term::{Accumulated, Measure, Step, Term, TermKind};
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_model::temporal::Disjunct;
use num_traits::{ToPrimitive, Zero};

use super::aims::target;
use super::chain::{self, Linked, PolicyNode};
use super::following::StrategyFault;
use super::optimal::Played;

/// A strategy that is run.
pub struct PropertyRuns<'p> {
    nodes: &'p [PolicyNode],
    links: Vec<Linked>,
    starts: usize,
    counts: Counts,
}

/// The number that a run counts.
enum Counts {
    /// 1 if it comes to a node of `right` through those of `left` within the bounds, or 0 then if `negated`.
    Until { left: Vec<bool>, right: Vec<bool>, near: Vec<bool>, least: u64, most: Option<u64>, negated: bool },
    /// The rewards until a node of `end`; if none of `near` is left, nothing if `is_lost`, else infinite.
    Sum { end: Vec<bool>, near: Vec<bool>, most: Option<u64>, is_lost: bool },
    /// 1 or 0 in the nodes that decide the formula.
    Settled(Vec<Option<bool>>),
    /// The reward of the state after some steps.
    At(u64),
}

/// A run of a strategy.
#[derive(Debug, Clone, Default)]
pub struct PropertyRun {
    /// The nodes that it visits, each with the number of the choice that is taken there; the last one without.
    pub steps: Vec<(usize, usize)>,
    /// The last node.
    pub last: usize,
    /// The number that it counts; `None` if it was given up before.
    pub value: Option<f64>,
}

impl Played<'_> {
    /// Returns whether the operator asks for a probability.
    pub fn is_probability(&self) -> bool {
        matches!(self.measured.measure, Measure::Probability(_))
    }

    /// Prepares runs, or returns the first fault of the nodes. Cost: one step of the model per node.
    ///
    /// # Errors
    /// Runs do not decide the formula, or the average, after a number of steps; a command has no meaning in a state.
    pub fn runs<'p>(
        &self,
        plain: &Program,
        program: &Program,
        (nodes, starts): (&'p [PolicyNode], usize),
    ) -> Result<std::result::Result<PropertyRuns<'p>, StrategyFault>> {
        let structures = Vec::from_iter(self.structure(plain));
        let links = match chain::linked(program, nodes, &structures)? {
            Ok(links) => links,
            Err(fault) => return Ok(Err(fault)),
        };
        let counts = self.counts(nodes, &links)?;
        Ok(Ok(PropertyRuns { nodes, links, starts, counts }))
    }

    fn counts(&self, nodes: &[PolicyNode], links: &[Linked]) -> Result<Counts> {
        let members = |term: &Term| -> Vec<bool> { nodes.iter().map(|node| holds(term, node)).collect() };
        let all = |inside| vec![inside; nodes.len()];
        let until = |end: Vec<bool>, is_lost: bool| {
            let near = near(links, &end, &all(true));
            Counts::Sum { near, end, most: None, is_lost }
        };
        // Ends once nothing is left to earn, and in these nodes.
        let anyway = |over: Vec<bool>| {
            let earning =
                links.iter().zip(&over).map(|(link, over)| !over && link.earns()).collect::<Vec<bool>>();
            let open: Vec<bool> = over.iter().map(|over| !over).collect();
            let end = near(links, &earning, &open).iter().map(|near| !near).collect();
            Counts::Sum { end, near: all(true), most: None, is_lost: false }
        };
        Ok(match &self.measured.measure {
            Measure::Probability(path) if path.single.is_some() => {
                let Some(single) = &path.single else { return Err(undecided()) };
                let (left, right, least, most) = match &single.step {
                    Step::Now(now) => (all(false), members(now), 0, None),
                    Step::Next(next) => (all(true), members(next), 1, Some(1)),
                    Step::Until { left, right, least, most } => {
                        let left = left.as_ref().map_or_else(|| all(true), members);
                        (left, members(right), *least, *most)
                    }
                };
                let near = near(links, &right, &left);
                Counts::Until { left, right, near, least, most, negated: single.negated }
            }
            Measure::Reward(_, accumulated) => match accumulated {
                Accumulated::At(steps) => Counts::At(*steps),
                Accumulated::Within(steps) => {
                    Counts::Sum { end: all(false), near: all(true), most: Some(*steps), is_lost: false }
                }
                Accumulated::Total => anyway(all(false)),
                Accumulated::Until(path) => match target(path) {
                    Some(target) => until(members(target), false),
                    None => until(self.accepted(nodes)?, false),
                },
                Accumulated::Anyway(target) => anyway(members(target)),
                Accumulated::IfReached(target) => until(members(target), true),
                Accumulated::LongRun => return Err(undecided()),
            },
            Measure::Probability(_) => Counts::Settled(self.settled(nodes, links)?),
            Measure::LongRun(_) => return Err(undecided()),
        })
    }

    /// Returns the alternatives of the condition on the monitors, by the nodes in which each mark holds.
    fn disjuncts(&self, nodes: &[PolicyNode]) -> Result<Vec<Disjunct<Vec<bool>>>> {
        let (Some(condition), Some(watched)) = (&self.condition, &self.watched) else {
            return Err(undecided());
        };
        if nodes.iter().any(|node| node.state.len() + node.memory.len() != watched.variables.len()) {
            let message = "runs of this strategy need the `memory` of each node: the states of the monitors of its formula";
            return Err(Error::Usage(message.to_owned()));
        }
        let holds = |mark: &Predicate| -> Vec<bool> {
            nodes.iter().map(|node| mark.eval(&node.whole()) == Ok(Value::Bool(true))).collect()
        };
        let of = |own: Disjunct<Predicate>| Disjunct {
            always: own.always.iter().map(|(mark, truth)| (holds(mark), *truth)).collect(),
            again: own.again.iter().map(holds).collect(),
        };
        Ok(condition.disjuncts()?.into_iter().map(of).collect())
    }

    /// Returns the nodes in which the monitors have accepted the formula.
    fn accepted(&self, nodes: &[PolicyNode]) -> Result<Vec<bool>> {
        let all = self.disjuncts(nodes)?;
        let is_accepted = |at: usize| {
            all.iter()
                .any(|own| own.again.is_empty() && own.always.iter().all(|(mark, truth)| mark[at] == *truth))
        };
        Ok((0..nodes.len()).map(is_accepted).collect())
    }

    /// Returns whether the paths from each node satisfy the formula, where all of them are in a set of nodes that they never
    /// leave.
    fn settled(&self, nodes: &[PolicyNode], links: &[Linked]) -> Result<Vec<Option<bool>>> {
        let all = self.disjuncts(nodes)?;
        let mut settled = vec![None; nodes.len()];
        let after =
            |link: &Linked| link.choices.iter().flatten().map(|(to, _)| *to as u32).collect::<Vec<_>>();
        for bottom in bottoms(links.iter().map(after)) {
            let holds = |own: &Disjunct<Vec<bool>>| {
                let always =
                    |(mark, truth): &(Vec<bool>, bool)| bottom.iter().all(|&at| mark[at as usize] == *truth);
                own.always.iter().all(always)
                    && own.again.iter().all(|mark| bottom.iter().any(|&at| mark[at as usize]))
            };
            let is_satisfied = all.iter().any(holds);
            bottom.iter().for_each(|&at| settled[at as usize] = Some(is_satisfied));
        }
        Ok(settled)
    }
}

fn undecided() -> Error {
    Error::Usage(
        "no number of steps decides the value of a run of this strategy; `verify` computes the value of the strategy"
            .to_owned(),
    )
}

fn holds(term: &Term, node: &PolicyNode) -> bool {
    matches!(&term.kind, TermKind::State(condition) if condition.eval(&node.state) == Ok(Value::Bool(true)))
}

/// Returns the nodes from which some are reached through others.
fn near(links: &[Linked], target: &[bool], left: &[bool]) -> Vec<bool> {
    let mut before: Vec<Vec<usize>> = vec![Vec::new(); links.len()];
    for (at, link) in links.iter().enumerate() {
        link.choices.iter().flatten().for_each(|(to, _)| before[*to].push(at));
    }
    let mut near = target.to_vec();
    let mut open: VecDeque<usize> = (0..links.len()).filter(|&at| target[at]).collect();
    while let Some(at) = open.pop_front() {
        for &from in &before[at] {
            if left[from] && !std::mem::replace(&mut near[from], true) {
                open.push_back(from);
            }
        }
    }
    near
}

impl Counts {
    /// Returns what a run counts that is in a node after some steps, and has earned a sum, if it is decided there.
    fn value(&self, at: usize, (steps, sum): (u64, f64), links: &[Linked]) -> Option<f64> {
        match self {
            Counts::Until { left, right, near, least, most, negated } => {
                let truth = if right[at] && steps >= *least {
                    true
                } else if !left[at] || *most == Some(steps) || most.is_none() && !near[at] {
                    false
                } else {
                    return None;
                };
                Some(if truth == *negated { 0.0 } else { 1.0 })
            }
            Counts::Sum { end, near, most, is_lost } => match end[at] || *most == Some(steps) {
                true => Some(sum),
                false => (!near[at]).then_some(if *is_lost { 0.0 } else { f64::INFINITY }),
            },
            Counts::Settled(settled) => settled[at].map(|holds| f64::from(u8::from(holds))),
            Counts::At(count) => (steps == *count).then(|| links[at].state_reward()),
        }
    }
}

impl PropertyRuns<'_> {
    /// Draws a run, of at most some steps; the other side draws its choices. Cost: linear in its steps.
    pub fn run(&self, most: u64, draw: &mut Draw) -> PropertyRun {
        let mut at = if self.starts > 1 { draw.below(self.starts) } else { 0 };
        let (mut run, mut sum) = (PropertyRun::default(), 0.0);
        loop {
            run.last = at;
            let steps = run.steps.len() as u64;
            run.value = self.counts.value(at, (steps, sum), &self.links);
            if run.value.is_some() {
                return run;
            }
            let (taken, link) = (&self.nodes[at].choices, &self.links[at]);
            if steps == most || taken.is_empty() {
                return run;
            }
            let number = draw.below(taken.len());
            if matches!(self.counts, Counts::Sum { .. }) {
                sum += link.gain(number.min(link.choices.len() - 1));
            }
            run.steps.push((at, number));
            let successors = &taken[number].successors;
            let next = draw.by_probability(successors.iter().map(|(_, p)| p.to_f64().unwrap_or_default()));
            at = successors[next].0;
        }
    }

    /// Returns the position of the choice that a step of a run takes, and its node.
    pub fn taken(&self, (at, number): (usize, usize)) -> (&PolicyNode, usize) {
        (&self.nodes[at], self.nodes[at].choices[number].position)
    }
}

impl Linked {
    /// Returns whether some choice earns.
    fn earns(&self) -> bool {
        let own = self.state_rewards.iter().chain(self.rewards.iter().flatten());
        !self.choices.is_empty() && own.into_iter().any(|reward| !reward.is_zero())
    }

    fn state_reward(&self) -> f64 {
        self.state_rewards.first().and_then(ToPrimitive::to_f64).unwrap_or_default()
    }

    fn gain(&self, choice: usize) -> f64 {
        let own = self.rewards.get(choice).and_then(|own| own.first()?.to_f64());
        self.state_reward() + own.unwrap_or_default()
    }
}
