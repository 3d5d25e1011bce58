//! The greatest weighted sum of several objectives from one state of an arena without an opponent.
//!
//! States are paired with what the path has decided, so that each objective is a sum of gains of choices; a gain is
//! negative if the objective is to be small. End components in which nothing is gained become one group, in which a path
//! may stop; what recurs in the part where it stays is gained then. Then every strategy stops almost surely, and equations of which one step confirms the solution
//! have bounds.

use ahash::AHashMap;
use bitvec::vec::BitVec;
use meliora_base::error::{Error, Limit, Result};
use meliora_base::exact::Ratio;
use meliora_engine::explicit::weighted::Fractions;
use meliora_model::Optimum;
use num_traits::{Signed, ToPrimitive};

use super::components::{self, EndComponents};
use super::groups::{BETTER, Entry, greatest};
use super::policies::{MARGIN, Policies};
use super::rows::{Constant, Rows};
use crate::equations::arena::{Arena, Rewards};
use crate::equations::choices::Choices;
use crate::equations::meter::{Meter, Stop, Turn};
use crate::equations::number::Weight;
use crate::equations::system::Sense;

/// A number of a path.
#[derive(Debug, Clone, Copy)]
pub enum Counted<'a> {
    /// 1 if the path visits the set.
    Visit(&'a BitVec),
    /// 1 if the path visits the second set through states of the first one.
    Until(&'a BitVec, &'a BitVec),
    /// 1 if the path visits the set infinitely often.
    Recur(&'a BitVec),
    /// The rewards of all steps.
    Total(&'a Rewards),
    /// The rewards of the first steps.
    Within(&'a Rewards, u32),
}

/// A choice of a group, divided by the probability to leave the group.
struct Action {
    /// The groups that are entered, with the numbers of the probabilities.
    edges: Vec<(u32, u32)>,
    /// The numbers of the gains.
    gains: Vec<u32>,
}

/// The groups and their actions. An action without edges stops.
pub(crate) struct Weighted {
    groups: Vec<Vec<Action>>,
    fractions: Fractions,
    start: usize,
    /// The gains before the first step.
    first: Vec<Ratio>,
}

/// A point that a strategy attains, and a half-space that contains all points.
pub(crate) struct Point {
    /// Lower bounds of the expected gains of a strategy.
    pub(crate) gains: Vec<Ratio>,
    /// An upper bound of the weighted sum of the gains of all strategies.
    pub(crate) most: Ratio,
}

/// The memory that the objectives need of the steps before.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Memory {
    /// The objectives that are decided, as bits.
    decided: u32,
    /// The number of steps, as far as it counts.
    steps: u32,
}

/// States with memory.
struct Pairs {
    list: Vec<(u32, Memory)>,
    numbers: AHashMap<(u32, Memory), u32>,
    choices: Choices,
    /// The numbers of the probabilities of the successors, and of the gains of each choice.
    weights: Vec<u32>,
    gains: Vec<Vec<u32>>,
}

impl Pairs {
    fn number(&mut self, pair: (u32, Memory)) -> u32 {
        let Pairs { list, numbers, .. } = self;
        *numbers.entry(pair).or_insert_with(|| {
            list.push(pair);
            list.len() as u32 - 1
        })
    }

    /// Explores the pairs that a state reaches.
    fn explored(
        arena: &Arena<'_>,
        start: usize,
        objectives: &[(Counted<'_>, Optimum)],
        fractions: &mut Fractions,
        meter: &mut Meter<'_>,
    ) -> Result<Self> {
        let mut pairs = Pairs {
            list: Vec::new(),
            numbers: AHashMap::new(),
            choices: Choices::default(),
            weights: Vec::new(),
            gains: Vec::new(),
        };
        let within = objectives.iter().map(|(counted, _)| match counted {
            Counted::Within(_, steps) => *steps,
            _ => 0,
        });
        let most = within.max().unwrap_or_default();
        pairs.number((start as u32, Memory { decided: decided(objectives, start).0, steps: 0 }));
        let mut next = 0;
        while let Some(&(state, memory)) = pairs.list.get(next) {
            meter.take(size_of::<(u32, Memory)>() * 4)?;
            next += 1;
            for choice in arena.choices.of(state) {
                let mut gains: Vec<Ratio> = objectives
                    .iter()
                    .map(|(counted, _)| match counted {
                        Counted::Total(rewards) => rewards.choice(choice).clone(),
                        Counted::Within(rewards, steps) if memory.steps < *steps => {
                            rewards.choice(choice).clone()
                        }
                        _ => Ratio::default(),
                    })
                    .collect();
                for (to, weight) in arena.edges(choice) {
                    let p = &arena.fractions.list()[weight as usize];
                    let (own, satisfied) = decided(objectives, to as usize);
                    let new = satisfied & !memory.decided;
                    (0..objectives.len()).filter(|at| new >> at & 1 == 1).for_each(|at| gains[at] += p);
                    let steps = most.min(memory.steps + 1);
                    let to = pairs.number((to, Memory { decided: memory.decided | own, steps }));
                    pairs.choices.to.push(to);
                    pairs.weights.push(weight);
                }
                let signed = gains.into_iter().zip(objectives).map(|(gain, own)| signed(gain, own.1));
                pairs.gains.push(signed.map(|gain| fractions.number(gain)).collect());
                pairs.choices.start.push(pairs.choices.to.len() as u32);
                meter.take(12 * arena.choices.successors(choice).len() + 4 * objectives.len() + 28)?;
            }
            pairs.choices.first.push(pairs.choices.start.len() as u32 - 1);
        }
        Ok(pairs)
    }

    /// Returns a pair of each end component in which a path may stay, with the objectives of [`Counted::Recur`] that it
    /// satisfies there: all states of the component are visited infinitely often. Some of the sets that are to be avoided
    /// are left out, in all ways.
    fn ends(
        &self,
        objectives: &[(Counted<'_>, Optimum)],
        found: &EndComponents,
        meter: &mut Meter<'_>,
    ) -> Result<Vec<(u32, u32)>> {
        let recurring = objectives.iter().enumerate().filter_map(|(at, own)| match own.0 {
            Counted::Recur(set) => Some((at, set, own.1)),
            _ => None,
        });
        let recurring: Vec<_> = recurring.collect();
        let avoided: Vec<usize> =
            recurring.iter().filter(|own| own.2 == Optimum::Min).map(|own| own.0).collect();
        let hits = |pair: u32| {
            let state = self.list[pair as usize].0 as usize;
            recurring.iter().fold(0u32, |hits, &(at, set, _)| hits | u32::from(set[state]) << at)
        };
        let mut ends = Vec::new();
        for subset in 0..1u32 << avoided.len() {
            let left_out = avoided.iter().enumerate().filter(|(bit, _)| subset >> bit & 1 == 1);
            let left_out = left_out.fold(0u32, |bits, (_, at)| bits | 1 << at);
            let stays = |pair: u32| hits(pair) & left_out == 0;
            let mut choices = Choices::default();
            for pair in 0..self.list.len() as u32 {
                for choice in self.choices.of(pair).filter(|&choice| found.inside[choice] && stays(pair)) {
                    let successors = self.choices.successors(choice);
                    if successors.iter().all(|&to| stays(to)) {
                        choices.to.extend_from_slice(successors);
                        choices.start.push(choices.to.len() as u32);
                    }
                }
                choices.first.push(choices.start.len() as u32 - 1);
            }
            let parts = components::end_components(&choices, meter)?;
            let mut hit: AHashMap<u32, (u32, u32)> = AHashMap::new();
            let inside =
                (0..self.list.len() as u32).filter(|&pair| choices.of(pair).any(|own| parts.inside[own]));
            for pair in inside {
                hit.entry(parts.group[pair as usize]).or_insert((pair, 0)).1 |= hits(pair);
            }
            ends.extend(hit.into_values());
        }
        ends.sort_unstable();
        Ok(ends)
    }

    /// Returns the action of a choice that leaves its group `own`.
    fn action(&self, (own, choice): (u32, usize), group: &[u32], fractions: &mut Fractions) -> Action {
        let known = |fractions: &Fractions, number: u32| fractions.list()[number as usize].clone();
        let (mut edges, mut leaving): (Vec<(u32, Ratio)>, _) = (Vec::new(), Ratio::default());
        for at in self.choices.start[choice] as usize..self.choices.start[choice + 1] as usize {
            let to = group[self.choices.to[at] as usize];
            if to != own {
                let p = known(fractions, self.weights[at]);
                leaving += &p;
                edges.push((to, p));
            }
        }
        edges.sort_unstable_by_key(|edge| edge.0);
        edges.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 += &next.1;
            }
            same
        });
        let edges = edges.into_iter().map(|(to, p)| (to, fractions.number(p / &leaving))).collect();
        let gains = self.gains[choice].iter();
        let gains = gains.map(|&gain| known(fractions, gain) / &leaving).collect::<Vec<_>>();
        Action { edges, gains: gains.into_iter().map(|gain| fractions.number(gain)).collect() }
    }
}

/// Returns the objectives that a state decides if none of the states before does, and those that it satisfies, as bits.
fn decided(objectives: &[(Counted<'_>, Optimum)], state: usize) -> (u32, u32) {
    let (mut decided, mut satisfied) = (0, 0);
    for (at, (counted, _)) in objectives.iter().enumerate() {
        let (left, right) = match counted {
            Counted::Visit(right) => (true, right[state]),
            Counted::Until(left, right) => (left[state], right[state]),
            Counted::Recur(_) | Counted::Total(_) | Counted::Within(..) => continue,
        };
        satisfied |= u32::from(right) << at;
        decided |= u32::from(right || !left) << at;
    }
    (decided, satisfied)
}

fn signed(gain: Ratio, optimum: Optimum) -> Ratio {
    if optimum == Optimum::Max { gain } else { -gain }
}

impl Weighted {
    /// Prepares objectives, each of which is to be great or small.
    ///
    /// # Errors
    /// A reward is earned in an end component; there are too many objectives; a limit is reached.
    pub(crate) fn new(
        arena: &Arena<'_>,
        start: usize,
        objectives: &[(Counted<'_>, Optimum)],
        meter: &mut Meter<'_>,
    ) -> Result<Self> {
        if objectives.len() > u32::BITS as usize {
            let what = format!("{} objectives; at most {} are supported", objectives.len(), u32::BITS);
            return Err(Limit::Size { what }.into());
        }
        let mut fractions = arena.fractions.clone();
        let zero = fractions.number(Ratio::default());
        let pairs = Pairs::explored(arena, start, objectives, &mut fractions, meter)?;
        let found = components::end_components(&pairs.choices, meter)?;
        let mut groups: Vec<Vec<Action>> = (0..found.count).map(|_| Vec::new()).collect();
        for pair in 0..pairs.list.len() as u32 {
            let own = found.group[pair as usize];
            for choice in pairs.choices.of(pair) {
                if !found.inside[choice] {
                    groups[own as usize].push(pairs.action((own, choice), &found.group, &mut fractions));
                } else if pairs.gains[choice].iter().any(|&gain| gain != zero) {
                    let state = arena.program.show_state(&arena.state(pairs.list[pair as usize].0 as usize));
                    return Err(Error::Usage(format!(
                        "several objectives need rewards that end: a reward can be earned for all time from the state {state}"
                    )));
                }
            }
        }
        for (pair, hit) in pairs.ends(objectives, &found, meter)? {
            let gains = objectives.iter().enumerate().map(|(at, own)| {
                fractions.number(signed(Ratio::from_integer((hit >> at & 1).into()), own.1))
            });
            let stop = Action { edges: Vec::new(), gains: gains.collect() };
            let own = &mut groups[found.group[pair as usize] as usize];
            if !own.iter().any(|action| action.edges.is_empty() && action.gains == stop.gains) {
                own.push(stop);
            }
        }
        let (_, satisfied) = decided(objectives, start);
        let first = |(at, own): (usize, &(Counted<'_>, Optimum))| {
            signed(Ratio::from_integer((satisfied >> at & 1).into()), own.1)
        };
        let first = objectives.iter().enumerate().map(first).collect();
        Ok(Weighted { groups, fractions, start: found.group[0] as usize, first })
    }

    /// Returns the rows of the actions, and their gains.
    fn rows<N: Entry>(&self, numbers: &[N]) -> (Rows<N>, Vec<Vec<N>>) {
        let (mut rows, mut gains) = (Rows::empty(Sense::Max), Vec::new());
        for (group, actions) in (0..).zip(&self.groups) {
            rows.begin(group);
            for action in actions {
                let edges = action.edges.iter().map(|&(to, p)| (to, numbers[p as usize].clone()));
                // To stop is to leave.
                let escape = if action.edges.is_empty() { N::one() } else { N::zero() };
                let constant = Constant { low: N::zero(), high: N::zero(), most: 0.0, escape };
                rows.push(gains.len() as u32, edges, constant);
                gains.push(action.gains.iter().map(|&gain| numbers[gain as usize].clone()).collect());
            }
        }
        rows.begin(self.groups.len() as u32);
        (rows, gains)
    }

    /// Returns a point with nearly the greatest weighted sum, by doubles; one that says nothing if none is found.
    ///
    /// # Errors
    /// A limit is reached.
    pub(crate) fn near(&self, weights: &[Ratio], meter: &mut Meter<'_>) -> Result<Point> {
        let numbers: Vec<f64> = self.fractions.list().iter().map(nearest).collect();
        let exact = |x: f64| Ratio::from_float(x);
        let found = match self.confirmed(&numbers, &weights.iter().map(nearest).collect::<Vec<_>>(), meter) {
            Ok(found) => found,
            Err(Stop::Limit(error)) => return Err(error),
            Err(_) => None,
        };
        let found = found.and_then(|(gains, most)| {
            let gains = gains.into_iter().zip(&self.first).map(|(gain, first)| Some(exact(gain)? + first));
            Some(Point {
                gains: gains.collect::<Option<_>>()?,
                most: exact(most)? + rate(&self.first, weights),
            })
        });
        let unknown = || exact(f64::MAX).unwrap_or_default();
        Ok(found.unwrap_or_else(|| Point { gains: vec![-unknown(); weights.len()], most: unknown() }))
    }

    /// Returns lower bounds of the gains of a policy from the start, and an upper bound of the weighted sum of all
    /// policies: solutions with a margin per step that one step confirms. As every policy stops almost surely, they are
    /// bounds.
    fn confirmed(
        &self,
        numbers: &[f64],
        weights: &[f64],
        meter: &mut Meter<'_>,
    ) -> Turn<Option<(Vec<f64>, f64)>> {
        let (rows, gains) = self.rows(numbers);
        let rated: Vec<f64> = gains.iter().map(|gains| rate(gains, weights)).collect();
        let mut policies = Policies::new(&rows);
        policies.begin(&[], usize::MAX, meter)?;
        let x = policies.improve(&rated, f64::slack, meter)?;
        let mut margin = MARGIN * f64::EPSILON * greatest(&x).max(1.0);
        while margin < BETTER.sqrt() * greatest(&x).max(1.0) {
            let more: Vec<f64> = rated.iter().map(|gain| gain + margin).collect();
            let high = policies.improve(&more, |_| margin / MARGIN, meter)?;
            let less = |gains: &Vec<f64>| gains.iter().map(|gain| gain - margin).collect();
            let low = policies.evaluate(&gains.iter().map(less).collect::<Vec<Vec<f64>>>(), meter)?;
            let is_above = |group: usize, action: usize| {
                let terms = gains[action].iter().zip(weights).map(|(gain, w)| (gain * w).abs());
                let (q, error) = rounded(&rows, action, (rated[action], terms.sum()), |to| high[to]);
                q + error + f64::EPSILON * high[group].abs() <= high[group]
            };
            let is_below = |group: usize, at: usize| {
                let (action, own) = (policies.policy[group], low[group][at]);
                let gain = gains[action][at];
                let (q, error) = rounded(&rows, action, (gain, gain.abs()), |to| low[to][at]);
                own + f64::EPSILON * own.abs() <= q - error
            };
            let holds = |group: usize| {
                rows.actions(group).all(|action| is_above(group, action))
                    && (0..weights.len()).all(|at| is_below(group, at))
            };
            if (0..rows.groups()).all(holds) {
                return Ok(Some((low[self.start].clone(), high[self.start])));
            }
            margin *= MARGIN;
        }
        Ok(None)
    }

    /// Returns the point of the best policy, exactly.
    ///
    /// # Errors
    /// A limit is reached.
    pub(crate) fn exact(&self, weights: &[Ratio], meter: &mut Meter<'_>) -> Result<Point> {
        let (rows, gains) = self.rows(self.fractions.list());
        let rated: Vec<Ratio> = gains.iter().map(|gains| rate(gains, weights)).collect();
        let mut policies = Policies::new(&rows);
        let mut solve = || {
            policies.begin(&[], usize::MAX, meter)?;
            policies.improve(&rated, Ratio::slack, meter)?;
            policies.evaluate(&gains, meter)
        };
        let x = solve().map_err(|stop| match stop {
            Stop::Limit(error) => error,
            _ => Limit::Size { what: "the objectives of a strategy have no values".to_owned() }.into(),
        })?;
        let gains: Vec<Ratio> = x[self.start].iter().zip(&self.first).map(|(x, y)| x + y).collect();
        let most = rate(&gains, weights);
        Ok(Point { gains, most })
    }
}

/// Returns the value of an action to the nearest, and a bound of its error; `gain` is given with the sum of the sizes of
/// its terms.
fn rounded(
    rows: &Rows<f64>,
    action: usize,
    (gain, size): (f64, f64),
    x: impl Fn(usize) -> f64,
) -> (f64, f64) {
    let (mut sum, mut sizes, mut terms) = (gain, size, 8.0);
    for (to, p) in rows.row(action) {
        sum += p * x(to as usize);
        sizes += p * x(to as usize).abs();
        terms += 1.0;
    }
    (sum, (terms + 32.0) * f64::EPSILON * sizes)
}

/// Returns a weighted sum.
pub(crate) fn rate<N: Weight>(gains: &[N], weights: &[N]) -> N {
    gains.iter().zip(weights).fold(N::zero(), |sum, (x, w)| sum.plus(&x.times(w)))
}

/// Returns the nearest double.
fn nearest(x: &Ratio) -> f64 {
    let size = x.abs().to_f64().unwrap_or(f64::MAX);
    if x.is_negative() { -size } else { size }
}
