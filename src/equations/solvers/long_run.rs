//! The long-run average reward of a game of one player, by its end components.
//!
//! In an end component, some strategy moves from each state to each other one, so the best average of the strategies that
//! stay is the same in all its states. A path ends in an end component almost surely. So the value is that of a model with
//! one more choice in each state of an end component, which ends the path and earns this average.
//!
//! The average of a component in which each state has one choice is the reward until a state is entered again, divided by
//! the number of steps until then. Both come from one elimination of all other states, without subtraction. In other
//! components, let B be the operator of one step with its reward. For each vector v, the average is between the least and
//! the greatest number (B v)(s) - v(s); relative value iteration lets these meet. With fractions, policies are improved
//! until one step shows that they are the best. M. Puterman, "Markov Decision Processes" (1994), chapters 8 and 9.

use super::chain::{self, Listed};
use super::components::{self, EndComponents};
use super::reaching::{Vector, value_at};
use super::sides::Sides;
use crate::graphs::game_graph::{Edge, Extremes, GameGraph, Rewards};
use crate::graphs::graph::NONE;
use crate::graphs::meter::{Meter, Stop};
use crate::solvers::solution::{Members, Rest, Solution};
use crate::solvers::system::{Quantity, Sets, System};
use bitvec::vec::BitVec;
use meliora_base::error::{Error, Limit, Result};
use meliora_base::exact::Ratio;
use meliora_base::interval::Interval;
use meliora_base::number::Number;
use meliora_base::value::Binary;
use meliora_model::Optimum;

/// The relative distance of the bounds of an average at which iteration ends.
pub const AVERAGE_WIDTH: f64 = 1e-9;

/// The part of its change that a value takes in a sweep: all of it would let values alternate where a component is periodic.
pub const SWEEP_PART: f64 = 0.75;

/// Computes the averages of all states.
///
/// # Errors
/// Players look for different extremes; a limit is reached before anything is known.
pub(crate) fn values<N: Number>(
    game: &GameGraph,
    rewards: &Rewards,
    goal: Extremes,
    meter: &mut Meter<'_>,
) -> Result<Vector<N>> {
    let optimum = optimum(game, goal)?;
    meter.take(game.states() * (components::SEARCH + 12) + 2 * game.choices.bytes())?;
    let found = game.choices.end_components(meter)?;
    let members = found.members(&game.choices);
    let [probabilities, gains] = [&game.fractions, &rewards.fractions].map(|known| known.list());
    let [probabilities, gains] =
        [probabilities, gains].map(|list| list.iter().map(N::of).collect::<Vec<N>>());
    let (mut place, mut averages) = (vec![NONE; game.states()], Vec::new());
    for members in &members {
        members.iter().zip(0..).for_each(|(&state, at)| place[state as usize] = at);
        let numbers = (&*probabilities, &*gains);
        let inside = Inside::new(game, rewards, (members, &place), &found, numbers);
        averages.push(inside.average(optimum, meter)?);
        members.iter().for_each(|&state| place[state as usize] = NONE);
    }
    reached(game, (&members, &averages), optimum, meter)
}

/// Returns the extreme that all states with several choices look for.
fn optimum(game: &GameGraph, goal: Extremes) -> Result<Optimum> {
    let differs = |state: u32| game.is_theirs(state) && game.choices(state).len() > 1;
    if goal.ours != goal.theirs && (0..game.states() as u32).any(differs) {
        let what = "averages over the long run are not supported against an opponent; give both sides one goal, as in \
                    `<<all players>>`";
        return Err(Error::Usage(what.to_owned()));
    }
    Ok(goal.ours)
}

/// Computes the best expected average of the end component in which a path stays.
fn reached<N: Number>(
    game: &GameGraph,
    (members, averages): (&[Vec<u32>], &[N]),
    optimum: Optimum,
    meter: &mut Meter<'_>,
) -> Result<Vector<N>> {
    let states = game.states();
    let extended = with_exits(game, members);
    let nodes = extended.states();
    let [all, permitted] = [nodes, extended.choices_in_all()].map(|count| BitVec::repeat(true, count));
    let is_max = optimum == Optimum::Max;
    let side = |x: &N| if is_max { x.high() } else { x.low() };
    let better = |best, x| if side(x).beats(&side(best), is_max) { x } else { best };
    let Some(best) = averages.iter().reduce(better) else {
        return Ok(Vector { values: Vec::new(), end: Ok(()) });
    };
    let exits = |is_wanted: &dyn Fn(&N) -> bool| -> BitVec {
        (0..nodes).map(|node| node >= states && is_wanted(&averages[node - states])).collect()
    };
    // The best average is that of all states from which some strategy attains it almost surely.
    let sides = Sides::new(&extended.choices, &all, &permitted, meter)?;
    let sure = sides.almost_sure(&exits(&|average| average == best), &all, meter)?;
    let is_known = |node: u32| sure[node as usize] || node as usize >= states;
    let rest = Rest::ones(Members::none(nodes));
    let mut known = Solution::new(Members::new(nodes, is_known), rest, meter)?;
    (states as u32..).zip(averages).for_each(|(exit, average)| known.set(exit, average.clone()));
    sure.iter_ones().for_each(|node| known.set(node as u32, best.clone()));
    // Without a gain, the average is 0.
    let open = if is_max { sides.positive(&exits(&|average| !average.is_zero()), &all) } else { all.clone() };
    let open: BitVec = (0..nodes).map(|node| open[node] && !is_known(node as u32)).collect();
    let sets = Sets { open, ones: BitVec::repeat(false, nodes), permitted };
    let fractions: Vec<N> = extended.fractions().iter().map(N::of).collect();
    // A path has to end: minimisers would prefer to gain nothing.
    let quantity = if is_max { Quantity::Reward } else { Quantity::Cost(1) };
    let system = System::of_sets((&extended, &sets), (quantity, Extremes::all(optimum)), None, &fractions);
    let system = System { closed: Some(&known), ..system };
    let mut solution = system.start(meter)?;
    let end = system.solve(&mut solution, meter);
    let end = if N::EXACT { Ok(end?) } else { end };
    let value = |state: u32| match sets.open[state as usize] {
        true => value_at(&solution, state, f64::INFINITY),
        false => known.get(state).cloned(),
    };
    let values = (0..states as u32).map(value).collect();
    Ok(Vector { values, end })
}

/// Returns a game with one more state for each of some sets, which its members may enter for certain.
fn with_exits(game: &GameGraph, members: &[Vec<u32>]) -> GameGraph {
    let mut exits = vec![NONE; game.states()];
    for (exit, members) in (game.states() as u32..).zip(members) {
        members.iter().for_each(|&state| exits[state as usize] = exit);
    }
    let mut extended = GameGraph { fractions: game.fractions.clone(), ..GameGraph::default() };
    let sure = extended.fractions.number(Ratio::from_integer(1.into()));
    for state in 0..game.states() as u32 {
        for choice in game.choices(state) {
            game.edges(choice).for_each(|edge| extended.add_edge(edge));
            extended.end_choice();
        }
        if exits[state as usize] != NONE {
            extended.add_edge(Edge::new(exits[state as usize], sure, false));
            extended.end_choice();
        }
        extended.end_node();
    }
    members.iter().for_each(|_| extended.end_node());
    extended
}

/// An end component.
struct Inside<'a, N> {
    game: &'a GameGraph,
    rewards: &'a Rewards,
    /// The place of each state among the members.
    place: &'a [u32],
    /// The choices of each member that stay inside.
    choices: Vec<Vec<u32>>,
    /// The probabilities of the game and the rewards as numbers.
    probabilities: &'a [N],
    gains: &'a [N],
}

/// The rewards and the numbers of steps from each member until a reference is entered, and the average of the rewards.
struct Evaluated<N> {
    average: N,
    until: Vec<[N; 2]>,
}

impl<'a, N: Number> Inside<'a, N> {
    fn new(
        game: &'a GameGraph,
        rewards: &'a Rewards,
        (members, place): (&'a [u32], &'a [u32]),
        found: &EndComponents,
        (probabilities, gains): (&'a [N], &'a [N]),
    ) -> Self {
        let inside = |&state: &u32| {
            game.choices(state).filter(|&choice| found.inside[choice as usize]).collect::<Vec<u32>>()
        };
        let choices = members.iter().map(inside).collect();
        Inside { game, rewards, place, choices, probabilities, gains }
    }

    /// Returns the best average.
    fn average(&self, optimum: Optimum, meter: &mut Meter<'_>) -> Result<N> {
        let first = || self.choices.iter().map(|choices| choices[0]).collect::<Vec<u32>>();
        if self.choices.iter().all(|choices| choices.len() == 1) {
            let all: Vec<u32> = (0..self.choices.len() as u32).collect();
            let last = all.len() - 1;
            return Ok(self.evaluated(&first(), &all, last, meter)?.average);
        }
        if N::EXACT { self.improved(first(), optimum, meter) } else { self.iterated(optimum, meter) }
    }

    fn gain(&self, choice: u32) -> &N {
        &self.gains[self.rewards.of_choice.get(choice as usize) as usize]
    }

    /// Returns the members that a choice enters, with probabilities.
    fn edges(&self, choice: u32) -> impl Iterator<Item = (u32, &N)> {
        let edges = self.game.edges(choice);
        edges.map(|edge| (self.place[edge.to as usize], &self.probabilities[edge.probability() as usize]))
    }

    /// Evaluates a policy on the members `among`, which it does not leave and from which it enters the member
    /// `reference` almost surely.
    fn evaluated(
        &self,
        policy: &[u32],
        among: &[u32],
        reference: usize,
        meter: &mut Meter<'_>,
    ) -> Result<Evaluated<N>> {
        let mut at = vec![NONE; policy.len()];
        let others = || among.iter().filter(|&&member| member as usize != reference);
        others().zip(0..).for_each(|(&member, own)| at[member as usize] = own);
        let mut chain = Listed::empty();
        for &member in others() {
            let choice = policy[member as usize];
            let (mut edges, mut escape): (Vec<(u32, N)>, _) = (Vec::new(), N::zero());
            for (to, p) in self.edges(choice) {
                match at[to as usize] {
                    NONE => escape = escape.plus(p),
                    _ if to == member => {}
                    to => edges.push((to, p.clone())),
                }
            }
            edges.sort_unstable_by_key(|edge| edge.0);
            chain.push(edges, escape);
        }
        let mut left = usize::MAX;
        let gain = |&member: &u32| [self.gain(policy[member as usize]).clone(), N::one()];
        let gains = others().flat_map(gain).collect();
        let values = chain::solve(&chain, gains, &mut left, meter).map_err(|stop| match stop {
            Stop::Limit(error) => error,
            _ => Limit::Size { what: "the average of a component has no value".to_owned() }.into(),
        })?;
        let known = |member: u32| values.as_chunks::<2>().0.get(at[member as usize] as usize);
        let [mut sum, mut steps] = [self.gain(policy[reference]).clone(), N::one()];
        for (to, p) in self.edges(policy[reference]) {
            if let Some(values) = known(to) {
                sum = sum.plus(&p.times(&values[0]));
                steps = steps.plus(&p.times(&values[1]));
            }
        }
        let until = |member: u32| match known(member) {
            Some(values) => values.clone(),
            None => [N::zero(), N::zero()],
        };
        Ok(Evaluated { average: sum.over(&steps), until: (0..policy.len() as u32).map(until).collect() })
    }

    /// Returns the best average by relative value iteration.
    fn iterated(&self, optimum: Optimum, meter: &mut Meter<'_>) -> Result<N> {
        let middle = |x: &N| x.bounds().middle();
        let [probabilities, gains] =
            [self.probabilities, self.gains].map(|list| list.iter().map(middle).collect::<Vec<f64>>());
        let mean = |choice: u32, v: &[f64]| {
            let gain = gains[self.rewards.of_choice.get(choice as usize) as usize];
            self.game.edges(choice).fold(gain, |sum, edge| {
                sum + probabilities[edge.probability() as usize] * v[self.place[edge.to as usize] as usize]
            })
        };
        let best = if optimum == Optimum::Max { f64::max } else { f64::min };
        let (mut v, mut last) = (vec![0.0; self.choices.len()], f64::INFINITY);
        for sweep in 1usize.. {
            let (mut least, mut most, mut low) = (f64::INFINITY, 0.0f64, f64::INFINITY);
            let mut next = Vec::with_capacity(v.len());
            for (choices, own) in self.choices.iter().zip(&v) {
                meter.step()?;
                let change =
                    choices.iter().map(|&choice| mean(choice, &v)).reduce(best).unwrap_or(*own) - own;
                (least, most) = (least.min(change), most.max(change));
                next.push(own + SWEEP_PART * change);
                low = low.min(own + SWEEP_PART * change);
            }
            let width = most - least;
            meter.progress_at(sweep, &|| format!("averages of {} states, width {width:.1e}", v.len()));
            // From then on, rounding hides changes.
            let settles = sweep.is_power_of_two() && sweep > 4 * v.len() + 1024;
            let ends = width <= AVERAGE_WIDTH * most.max(1.0) || settles && width >= 0.9 * last;
            if settles {
                last = width;
            }
            if ends {
                break;
            }
            next.iter_mut().for_each(|x| *x -= low);
            v = next;
        }
        self.between(&v, optimum)
    }

    /// Returns the bounds of the average that one step shows for any values `v` of the members, which are at least 0.
    fn between(&self, v: &[f64], optimum: Optimum) -> Result<N> {
        let mut changes = Interval { lower: f64::INFINITY, upper: 0.0 };
        for (choices, own) in self.choices.iter().zip(v) {
            let mean = |&choice: &u32| {
                let value = |to: u32| N::rounded(Interval::point(v[to as usize])).unwrap_or_else(N::zero);
                let sum = |sum: N, (to, p): (u32, &N)| sum.plus(&p.times(&value(to)));
                self.edges(choice).fold(self.gain(choice).clone(), sum).bounds()
            };
            let both = |a: Interval, b: Interval| a.extreme(b, optimum == Optimum::Max);
            let Some(best) = choices.iter().map(mean).reduce(both) else { continue };
            changes = changes.range(best.combine(Binary::Sub, Interval::point(*own)));
        }
        let bounds = N::rounded(Interval { lower: changes.lower.max(0.0), ..changes });
        let what = "no exact average was found; bounds are found without `--exact`".to_owned();
        bounds.ok_or(Limit::Size { what }.into())
    }

    /// Returns the best average by policy iteration with fractions. Each policy enters one component of its chain almost
    /// surely. The next one has a better average, or the same with better rewards until then, so none returns.
    fn improved(&self, mut policy: Vec<u32>, optimum: Optimum, meter: &mut Meter<'_>) -> Result<N> {
        let all: Vec<u32> = (0..policy.len() as u32).collect();
        loop {
            let reference = self.best_bottom(&policy, optimum, meter)?;
            self.lead(&mut policy, reference);
            let Evaluated { average, until } = self.evaluated(&policy, &all, reference as usize, meter)?;
            let mut changed = false;
            for (member, choices) in self.choices.iter().enumerate() {
                meter.step()?;
                // r + Σ p R > g + (R - g T) + g Σ p T, without subtraction.
                let sides = |choice: u32| {
                    let (mut rewards, mut steps) = (self.gain(choice).clone(), N::one());
                    for (to, p) in self.edges(choice) {
                        rewards = rewards.plus(&p.times(&until[to as usize][0]));
                        steps = steps.plus(&p.times(&until[to as usize][1]));
                    }
                    (rewards, average.times(&steps))
                };
                let mut taken = sides(policy[member]);
                for &choice in choices {
                    let other = sides(choice);
                    if other.0.plus(&taken.1).beats(&taken.0.plus(&other.1), optimum == Optimum::Max) {
                        (policy[member], taken, changed) = (choice, other, true);
                    }
                }
            }
            if !changed {
                return Ok(average);
            }
        }
    }

    /// Returns a member of the component with the best average among those that a policy never leaves.
    fn best_bottom(&self, policy: &[u32], optimum: Optimum, meter: &mut Meter<'_>) -> Result<u32> {
        let after = |&choice: &u32| self.edges(choice).map(|(to, _)| to);
        let mut best: Option<(N, u32)> = None;
        for component in components::bottoms(policy.iter().map(after)) {
            let average = self.evaluated(policy, &component, component[0] as usize, meter)?.average;
            if best.as_ref().is_none_or(|(best, _)| average.beats(best, optimum == Optimum::Max)) {
                best = Some((average, component[0]));
            }
        }
        Ok(best.map_or(0, |(_, member)| member))
    }

    /// Lets the members from which a policy does not enter another one almost surely move towards it.
    fn lead(&self, policy: &mut [u32], to: u32) {
        let mut near = BitVec::<usize>::repeat(false, policy.len());
        near.set(to as usize, true);
        let enters = |choice: u32, near: &BitVec| self.edges(choice).any(|(to, _)| near[to as usize]);
        // First by the policy as it is, then by any choice.
        for by_policy in [true, false] {
            let mut grows = true;
            while grows {
                grows = false;
                for member in 0..policy.len() {
                    let pick = match by_policy {
                        true => Some(policy[member]).filter(|&choice| enters(choice, &near)),
                        false => self.choices[member].iter().copied().find(|&choice| enters(choice, &near)),
                    };
                    if let Some(pick) = pick.filter(|_| !near[member]) {
                        near.set(member, true);
                        (policy[member], grows) = (pick, true);
                    }
                }
            }
        }
    }
}
