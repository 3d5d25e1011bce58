//! The greatest weighted sum of several objectives from one state of an arena without an opponent.
//!
//! States are paired with what the path has decided, so that each objective is a sum of gains of choices; a gain is
//! negative if the objective is to be small. End components in which nothing is gained become one group, in which a path
//! may stop; what recurs in the part where it stays is gained then. In the end components that remain, every choice loses
//! or gains nothing. Only strategies that stop almost surely have finite costs, and only pairs that have one are kept.
//! Policy iteration starts with one and never leaves them: a policy that stays in an end component is not better
//! than the one before. So equations of which one step confirms the solution have bounds.

use meliora_base::error::{Error, Limit, Result};
use meliora_base::exact::Ratio;
use meliora_model::Optimum;
use meliora_space::weighted::Fractions;
use num_traits::{Signed, ToPrimitive};

use super::components::EndComponents;
use super::groups::{BETTER, Entry, greatest, slack};
use super::pairs::{Action, Counted, End, Pairs, Taken, decided, signed};
use super::policies::{MARGIN, Policies};
use super::rows::{Constant, Rows};
use super::strategy::{self, Node};
use crate::graphs::arena::Arena;
use crate::graphs::meter::{Meter, Stop, Turn};
use meliora_base::number::Weight;

/// The groups and their actions. An action without edges stops.
pub(crate) struct Weighted {
    groups: Vec<Vec<Action>>,
    fractions: Fractions,
    start: usize,
    /// The gains before the first step.
    first: Vec<Ratio>,
    /// The pairs and their groups, if strategies are wanted.
    kept: Option<(Pairs, EndComponents)>,
}

/// A point that a strategy attains, and a half-space that contains all points.
pub(crate) struct Point<N = Ratio> {
    /// Lower bounds of the expected gains of a strategy.
    pub(crate) gains: Vec<N>,
    /// An upper bound of the weighted sum of the gains of all strategies.
    pub(crate) most: N,
    /// The action of each group under the strategy, by its number among all.
    pub(crate) policy: Vec<usize>,
}

impl Weighted {
    /// Prepares objectives, each of which is to be great or small; `None` if no strategy has finite values.
    ///
    /// # Errors
    /// A reward that is to be great may be infinite; there are too many objectives; a limit is reached.
    pub(crate) fn new(
        arena: &Arena<'_>,
        start: usize,
        objectives: &[(Counted<'_>, Optimum)],
        keeps_strategies: bool,
        meter: &mut Meter<'_>,
    ) -> Result<Option<Self>> {
        if objectives.len() > u32::BITS as usize {
            let what = format!("{} objectives; at most {} are supported", objectives.len(), u32::BITS);
            return Err(Limit::Size { what }.into());
        }
        let mut fractions = arena.fractions.clone();
        let zero = fractions.number(Ratio::default());
        let pairs = Pairs::explored(arena, start, objectives, &mut fractions, meter)?;
        let finite = pairs.finite(objectives, zero, meter)?;
        if !finite[0] {
            return Ok(None);
        }
        let resting = pairs.resting(objectives, &[Optimum::Max, Optimum::Min], zero, meter)?;
        if let Some(pair) = pairs.endless(objectives, &resting, &finite, zero, meter)? {
            let state = arena.program.show_state(&arena.state(pairs.list[pair as usize].0 as usize));
            return Err(Error::Usage(format!(
                "several objectives need rewards that end: a reward that is to be great can be infinite from the state {state}"
            )));
        }
        let mut groups: Vec<Vec<Action>> = (0..resting.count).map(|_| Vec::new()).collect();
        for pair in finite.iter_ones() {
            let own = resting.group[pair];
            for choice in pairs.choices.of(pair as u32).filter(|&choice| !resting.inside[choice]) {
                let to = pairs.choices.successors(choice);
                let leaves = to.iter().any(|&to| resting.group[to as usize] != own);
                if leaves && to.iter().all(|&to| finite[to as usize]) {
                    groups[own as usize].push(pairs.action(own, choice, &resting.group, &mut fractions));
                }
            }
        }
        for end in pairs.ends(objectives, &resting, &finite, meter)? {
            let End { pair, hits, .. } = end;
            let gains = objectives.iter().enumerate().map(|(at, own)| {
                fractions.number(signed(Ratio::from_integer((hits >> at & 1).into()), own.1))
            });
            let stop = Action { edges: Vec::new(), gains: gains.collect(), taken: Taken::Stay(end) };
            let own = &mut groups[resting.group[pair as usize] as usize];
            if !own.iter().any(|action| action.edges.is_empty() && action.gains == stop.gains) {
                own.push(stop);
            }
        }
        // No action enters the groups of other pairs.
        for group in groups.iter_mut().filter(|group| group.is_empty()) {
            let gains = vec![zero; objectives.len()];
            group.push(Action { edges: Vec::new(), gains, taken: Taken::Nothing });
        }
        let (_, satisfied) = decided(objectives, start);
        let first = |(at, own): (usize, &(Counted<'_>, Optimum))| {
            signed(Ratio::from_integer((satisfied >> at & 1).into()), own.1)
        };
        let first = objectives.iter().enumerate().map(first).collect();
        let start = resting.group[0] as usize;
        let kept = keeps_strategies.then_some((pairs, resting));
        Ok(Some(Weighted { groups, fractions, start, first, kept }))
    }

    /// Returns a policy as a strategy; nothing unless strategies were wanted.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(crate) fn strategy(
        &self,
        policy: &[usize],
        arena: &Arena<'_>,
        objectives: &[(Counted<'_>, Optimum)],
        meter: &mut Meter<'_>,
    ) -> Result<Vec<Node>> {
        let Some((pairs, resting)) = &self.kept else { return Ok(Vec::new()) };
        let actions: Vec<&Action> = self.groups.iter().flatten().collect();
        let taken: Vec<Taken> = policy.iter().map(|&action| actions[action].taken).collect();
        let picks = strategy::picks(pairs, resting, &taken, objectives, meter)?;
        Ok(strategy::followed(pairs, &picks, arena))
    }

    /// Returns the rows of the actions, and the gains of all actions.
    fn rows<N: Entry>(&self, numbers: &[N]) -> (Rows<N>, Vec<N>) {
        let (mut rows, mut gains) =
            (Rows::empty(Optimum::Max, vec![Optimum::Max; self.groups.len()]), Vec::new());
        for (group, actions) in (0..).zip(&self.groups) {
            rows.begin(group);
            for action in actions {
                let edges = action.edges.iter().map(|&(to, p)| (to, numbers[p as usize].clone()));
                // To stop is to leave.
                let escape = if action.edges.is_empty() { N::one() } else { N::zero() };
                let constant = Constant { low: N::zero(), high: N::zero(), most: 0.0, escape };
                rows.push(rows.choices.len() as u32, edges, constant);
                gains.extend(action.gains.iter().map(|&gain| numbers[gain as usize].clone()));
            }
        }
        rows.begin(self.groups.len() as u32);
        (rows, gains)
    }

    /// Returns a point with nearly the greatest weighted sum, by doubles if they are precise enough.
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
        let found = found.and_then(|Point { gains, most, policy }| {
            let gains = gains.into_iter().zip(&self.first).map(|(gain, first)| Some(exact(gain)? + first));
            Some(Point {
                gains: gains.collect::<Option<_>>()?,
                most: exact(most)? + rate(&self.first, weights),
                policy,
            })
        });
        found.map_or_else(|| self.exact(weights, meter), Ok)
    }

    /// Returns lower bounds of the gains of a policy from the start, and an upper bound of the weighted sum of all
    /// policies: solutions with a margin per step that one step confirms. As every policy stops almost surely, they are
    /// bounds.
    fn confirmed(&self, numbers: &[f64], weights: &[f64], meter: &mut Meter<'_>) -> Turn<Option<Point<f64>>> {
        let (rows, gains) = self.rows(numbers);
        let (n, rated) = (weights.len(), rated(&gains, weights));
        let mut policies = Policies::new(&rows);
        policies.begin(&[], usize::MAX, meter)?;
        let x = policies.improve(|action| rated[action], slack, meter)?;
        let mut margin = MARGIN * f64::EPSILON * greatest(&x).max(1.0);
        while margin < BETTER.sqrt() * greatest(&x).max(1.0) {
            let high = policies.improve(|action| rated[action] + margin, |_| margin / MARGIN, meter)?;
            let less = of_actions(&gains, n, &policies.policy).map(|gain| gain - margin).collect();
            let low = policies.evaluate(less, meter)?;
            let is_above = |group: usize, action: usize| {
                let terms = gains[n * action..].iter().zip(weights).map(|(gain, w)| (gain * w).abs());
                let (q, error) = rounded(&rows, action, rated[action], terms.sum(), |to| high[to]);
                q + error + f64::EPSILON * high[group].abs() <= high[group]
            };
            let is_below = |group: usize, at: usize| {
                let (action, own) = (policies.policy[group], low[n * group + at]);
                let gain = gains[n * action + at];
                let (q, error) = rounded(&rows, action, gain, gain.abs(), |to| low[n * to + at]);
                own + f64::EPSILON * own.abs() <= q - error
            };
            let holds = |group: usize| {
                rows.actions(group).all(|action| is_above(group, action))
                    && (0..n).all(|at| is_below(group, at))
            };
            if (0..rows.groups()).all(holds) {
                let (gains, most) = (low[n * self.start..][..n].to_vec(), high[self.start]);
                return Ok(Some(Point { gains, most, policy: policies.policy }));
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
        let rated = rated(&gains, weights);
        let mut policies = Policies::new(&rows);
        let mut solve = || {
            policies.begin(&[], usize::MAX, meter)?;
            policies.improve(|action| rated[action].clone(), |_| Ratio::zero(), meter)?;
            let own = of_actions(&gains, weights.len(), &policies.policy).cloned().collect();
            policies.evaluate(own, meter)
        };
        let x = solve().map_err(|stop| match stop {
            Stop::Limit(error) => error,
            _ => Limit::Size { what: "the objectives of a strategy have no values".to_owned() }.into(),
        })?;
        let gains: Vec<Ratio> =
            x[weights.len() * self.start..].iter().zip(&self.first).map(|(x, y)| x + y).collect();
        let most = rate(&gains, weights);
        Ok(Point { gains, most, policy: policies.policy })
    }
}

/// Returns the value of an action to the nearest, and a bound of its error; `gain` is given with the sum of the sizes of
/// its terms.
fn rounded(rows: &Rows<f64>, action: usize, gain: f64, size: f64, x: impl Fn(usize) -> f64) -> (f64, f64) {
    let (mut sum, mut sizes, mut terms) = (gain, size, 8.0);
    for (to, p) in rows.row(action) {
        sum += p * x(to as usize);
        sizes += p * x(to as usize).abs();
        terms += 1.0;
    }
    (sum, (terms + 32.0) * f64::EPSILON * sizes)
}

/// Returns the gains of some actions, `n` of each.
fn of_actions<'g, N>(gains: &'g [N], n: usize, actions: &[usize]) -> impl Iterator<Item = &'g N> {
    actions.iter().flat_map(move |action| &gains[n * action..][..n])
}

/// Returns the weighted sums of the gains of all actions.
fn rated<N: Weight>(gains: &[N], weights: &[N]) -> Vec<N> {
    gains.chunks(weights.len().max(1)).map(|gains| rate(gains, weights)).collect()
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
