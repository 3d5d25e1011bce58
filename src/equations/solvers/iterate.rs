//! Bounds of the optimal values of a component, by optimistic value iteration.
//!
//! Let B be the operator of the optimality equations of a component whose end components without
//! gain or cost are collapsed. Two facts make every number here a bound:
//!
//! - B is monotone, so what iteration from 0 reaches is never above the least solution.
//! - If B(U) ≤ U for a finite U ≥ 0, the least solution is not above U. (D. Park's induction; for
//!   costs: the policy that attains B(U) costs at most U, and a policy that never leaves costs
//!   infinitely much.)
//!
//! The lower bounds are iterated from 0, and rounded down. Their changes soon shrink by the same factor in
//! every sweep, so they show where the values lead: twice as far is a candidate U, which is iterated, and
//! rounded up, until one sweep raises no value: then it is an upper bound. If the values at the exits are bounds, their
//! greatest width is added to the candidate.
//!
//! A sweep visits the groups in postorder and uses new values at once (Gauss and Seidel), so values
//! travel through most of a component in one sweep. [`crate::solvers::rows`] describes the rounding.
//!
//! A. Hartmanns and B. Kaminski, "Optimistic value iteration" (CAV 2020).

use crate::graphs::graph::NONE;
use crate::graphs::meter::{Meter, Stop, Turn, spend};
use crate::solvers::policies::{MARGIN, SWEEPS};
use crate::solvers::rows::{GroupBounds, Rows, TINY};
use meliora_base::interval::PRECISION;

/// The relative width of the bounds that are sought, and the part that is added to a candidate.
const WIDTH: f64 = 1e-9;
/// The greatest change of a sweep, relative to the values from [`PRECISION`] on.
#[derive(Default)]
struct Change(f64);

impl Change {
    /// Counts a change of a value.
    #[inline]
    fn note(&mut self, by: f64, value: f64) {
        let scale = value.max(PRECISION);
        // Most changes are smaller, and then a product is faster than a quotient.
        if by > self.0 * scale {
            self.0 = by / scale;
        }
    }
}

/// The changes of the last sweeps.
#[derive(Default)]
struct Trend {
    /// The last change is the last one.
    changes: [f64; 5],
    sweeps: usize,
    /// The sweep before which no more candidates are tried.
    pause: usize,
}

impl Trend {
    fn note(&mut self, change: f64) {
        self.changes.rotate_left(1);
        self.changes[4] = change;
        self.sweeps += 1;
    }

    /// Returns whether the values change no more than rounding may hide.
    fn is_still(&self) -> bool {
        self.sweeps > 0 && self.changes[4] <= MARGIN * f64::EPSILON
    }

    /// Returns the factor by which the last changes shrank in each sweep.
    fn shrinks(&self) -> f64 {
        let [first, .., last] = self.changes;
        (last / first).sqrt().sqrt()
    }

    /// Returns the sum of all further changes, divided by the last one; infinite if they do not shrink.
    fn still_to_come(&self) -> f64 {
        let shrinks = self.shrinks();
        match self.changes[0] > 0.0 && shrinks < 1.0 {
            _ if self.is_still() => 0.0,
            true => shrinks / (1.0 - shrinks),
            false => f64::INFINITY,
        }
    }

    /// Returns the width of the bounds that are expected after the next sweep.
    fn width(&self) -> f64 {
        2.0 * self.still_to_come() * self.changes[4]
    }

    /// Returns whether narrow bounds are expected after the next sweep, if no candidate was tried just before.
    fn expects_bounds(&self) -> bool {
        self.sweeps >= self.pause && self.width() <= WIDTH
    }

    /// Returns whether narrow bounds are expected within some sweeps.
    fn settles_within(&self, sweeps: usize) -> bool {
        self.width() <= WIDTH || self.width() * self.shrinks().powf(sweeps as f64) <= WIDTH
    }

    /// Returns the number of sweeps that a candidate may take: those without a result take a part of all.
    fn patience(&self) -> usize {
        SWEEPS.max(self.sweeps / 4)
    }
}

/// An iteration, which continues in each turn.
pub(crate) struct Iteration<'s> {
    sparse: &'s Rows<f64>,
    low: Vec<f64>,
    /// Upper bounds, if some are known.
    high: Option<Vec<f64>>,
    /// For the greatest values: the action that raised the lower bound last. A policy of such actions
    /// leaves the component: if it stayed for all time, the first group to get the greatest value of
    /// all would have had to get it from a smaller one. For the least values: the action that
    /// attains the upper bound.
    policy: Vec<u32>,
    trend: Trend,
    /// The entries that may be read in this turn.
    left: usize,
}

impl<'s> Iteration<'s> {
    /// Starts with nothing but an upper bound, if it is given.
    pub(crate) fn new(sparse: &'s Rows<f64>, top: Option<f64>) -> Self {
        let n = sparse.groups();
        let high = top.map(|top| vec![top; n]);
        Iteration { sparse, low: vec![0.0; n], high, policy: vec![NONE; n], trend: Trend::default(), left: 0 }
    }

    /// Iterates until the bounds are narrow. They hold in any case.
    ///
    /// # Errors
    /// They cannot become narrow; more than `budget` entries would be read, or this is expected after some sweeps and the
    /// iteration `gives_up` then; a limit is reached.
    pub(crate) fn turn(&mut self, budget: usize, gives_up: bool, meter: &mut Meter<'_>) -> Turn<()> {
        // The errors of smaller numbers are not relative. Where paths need not end, the least solution is none.
        if self.sparse.least < TINY || self.sparse.may_rest {
            return Err(Stop::Never);
        }
        self.left = budget;
        let judged = self.trend.sweeps + SWEEPS;
        loop {
            let is_due = gives_up && self.trend.sweeps == judged;
            if is_due && !self.trend.settles_within(self.left / self.sparse.entries()) {
                return Err(Stop::Later);
            }
            let before = self.trend.expects_bounds().then(|| self.low.clone());
            let change = self.lift(meter)?;
            meter.progress(&|| format!("lower bounds of {} states, change {change:.1e}", self.low.len()));
            let Some(before) = before else { continue };
            if self.enclose(&before, meter)? {
                return Ok(());
            }
            if self.trend.is_still() {
                return Err(Stop::Never);
            }
            self.trend.pause = self.trend.sweeps + self.trend.patience();
        }
    }

    /// Counts a sweep.
    fn spend(&mut self) -> Turn<()> {
        spend(&mut self.left, self.sparse.entries())
    }

    /// Iterates the lower bounds once; returns the greatest change.
    fn lift(&mut self, meter: &mut Meter<'_>) -> Turn<f64> {
        self.spend()?;
        let mut change = Change::default();
        let (sparse, policy) = (self.sparse, &mut self.policy);
        self.sparse.sweep(false, &mut self.low, meter, |group, x, (q, action)| {
            if q > *x {
                change.note(if *x == 0.0 { q.max(PRECISION) } else { q - *x }, q);
                *x = q;
                if sparse.is_max(group) {
                    policy[group] = action as u32;
                }
            }
        })?;
        self.trend.note(change.0);
        Ok(change.0)
    }

    /// Looks for upper bounds where the changes so far lead, from the values before the last sweep. If all
    /// changes shrink by the factor r, the values grow by r / (1 - r) times the last change. Twice this is an
    /// upper bound that one sweep confirms. The width of the exits is added, which stays one from step to
    /// step.
    fn enclose(&mut self, before: &[f64], meter: &mut Meter<'_>) -> Turn<bool> {
        let inherited = self.sparse.inherited;
        if !inherited.is_finite() {
            return Ok(false);
        }
        let factor = 2.0 * self.trend.still_to_come();
        let candidate =
            |(x, before): (&f64, &f64)| x + factor * (x - before) + inherited + WIDTH * x.max(PRECISION);
        let candidates = self.low.iter().zip(before).map(candidate).collect();
        Ok(self.confirm(candidates, meter)? && self.is_narrow())
    }

    /// Iterates a candidate until it is an upper bound; returns false if it does not become one soon.
    fn confirm(&mut self, mut x: Vec<f64>, meter: &mut Meter<'_>) -> Turn<bool> {
        let mut policy = self.policy.clone();
        let sparse = self.sparse;
        for _ in 0..self.trend.patience() {
            self.spend()?;
            let mut raised = false;
            self.sparse.sweep(true, &mut x, meter, |group, x, (q, action)| {
                raised |= q > *x;
                *x = q;
                if !sparse.is_max(group) {
                    policy[group] = action as u32;
                }
            })?;
            if !raised {
                self.policy = policy;
                // Both are upper bounds.
                let known = self.high.take().unwrap_or_else(|| vec![f64::INFINITY; x.len()]);
                self.high = Some(x.into_iter().zip(known).map(|(x, known)| x.min(known)).collect());
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn is_narrow(&self) -> bool {
        self.high.as_ref().is_some_and(|high| self.sparse.is_narrow(&self.low, high))
    }

    /// Returns the bounds so far.
    pub(crate) fn found(&self) -> GroupBounds {
        let high = self.high.clone().unwrap_or_else(|| vec![f64::INFINITY; self.low.len()]);
        GroupBounds { low: self.low.clone(), high, picks: self.picks() }
    }

    /// Returns the choices so far, or [`NONE`] for groups of which none is known.
    pub(crate) fn picks(&self) -> Vec<u32> {
        let pick = |(group, &action): (usize, &u32)| {
            let known = action != NONE && (self.sparse.is_max(group) || self.high.is_some());
            if known { self.sparse.choices[action as usize] } else { NONE }
        };
        self.policy.iter().enumerate().map(pick).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solvers::chain;
    use crate::solvers::policies::Policy;
    use crate::solvers::rows::Constant;
    use meliora_base::random::Draw;
    use meliora_engine::NoProgress;
    use meliora_model::Optimum;

    const RARE: f64 = 1.0 / (1 << 30) as f64;

    /// An action: its gain or cost, the values and probabilities of its exits, and its edges. All sums
    /// and products are exact.
    struct Made {
        gain: f64,
        exits: Vec<(f64, f64)>,
        edges: Vec<(u32, f64)>,
    }

    impl Made {
        fn constant(&self) -> f64 {
            self.exits.iter().fold(self.gain, |sum, (value, p)| sum + value * p)
        }

        fn greatest(&self) -> f64 {
            let none = if self.gain > 0.0 { f64::INFINITY } else { 0.0 };
            self.exits.iter().fold(none, |most, exit| most.max(exit.0))
        }
    }

    /// Returns the rows of a component; `width` is that of the bounds at the first exit of all.
    fn sparse(optimum: Optimum, groups: &[Vec<Made>], width: f64) -> Rows<f64> {
        let mut sparse = Rows::empty(optimum, vec![optimum; groups.len()]);
        (sparse.error, sparse.inherited, sparse.least) = (16.0 * f64::EPSILON, width, RARE);
        for (group, actions) in (0..).zip(groups) {
            sparse.begin(group);
            for made in actions {
                let number = sparse.choices.len() as u32;
                let (low, width) = (made.constant(), if number == 0 { width } else { 0.0 });
                let high = low + made.exits.first().map_or(0.0, |exit| exit.1 * width);
                let escape = made.exits.iter().map(|exit| exit.1).sum();
                let constant = Constant { low, high, most: made.greatest() + width, escape };
                let mut edges = made.edges.clone();
                edges.sort_unstable_by_key(|edge| edge.0);
                sparse.push(number, edges.into_iter(), constant);
            }
        }
        sparse.begin(groups.len() as u32);
        sparse
    }

    /// Iterates for at most this number of sweeps; returns the bounds, and whether they are narrow.
    fn solve(sparse: &Rows<f64>, sweeps: usize) -> (GroupBounds, bool) {
        let mut iteration = Iteration::new(sparse, None);
        let end = iteration.turn(sweeps * sparse.entries(), false, &mut Meter::unlimited(&NoProgress));
        (iteration.found(), end.is_ok())
    }

    /// Each group continues with the next one, or leaves with the value 1/2.
    fn ring(n: u32, leaving: f64) -> Vec<Vec<Made>> {
        let made =
            |i| Made { gain: 0.0, exits: vec![(0.5, leaving)], edges: vec![((i + 1) % n, 1.0 - leaving)] };
        (0..n).map(|i| vec![made(i)]).collect()
    }

    fn assert_half((found, is_narrow): (GroupBounds, bool)) {
        assert!(is_narrow);
        for (&low, &high) in found.low.iter().zip(&found.high) {
            assert!(low <= 0.5 && 0.5 <= high && high - low < 1e-8, "{low} {high}");
        }
    }

    #[test]
    fn bounds_contain_the_value_and_are_narrow() {
        assert_half(solve(&sparse(Optimum::Max, &ring(50, 0.25), 0.0), 200));
    }

    #[test]
    fn a_component_that_is_hardly_left_has_true_bounds() {
        let ring = sparse(Optimum::Max, &ring(50, 2.0f64.powi(-45)), 0.0);
        let (found, is_narrow) = solve(&ring, 1000);
        assert!(!is_narrow && found.low.iter().all(|low| *low <= 0.5));
        assert!(found.high.iter().all(|high| high.is_infinite()));
    }

    #[test]
    fn a_turn_ends_early_where_changes_shrink_too_slowly_for_it() {
        // To walk to and fro costs 2, to leave costs 100, so each sweep raises the values by 2.
        let step = |to| Made { gain: 1.0, exits: Vec::new(), edges: vec![(to, 1.0)] };
        let leave = Made { gain: 100.0, exits: vec![(0.0, 1.0)], edges: Vec::new() };
        let rows = sparse(Optimum::Min, &[vec![step(1), leave], vec![step(0)]], 0.0);
        let mut iteration = Iteration::new(&rows, None);
        let meter = &mut Meter::unlimited(&NoProgress);
        assert!(matches!(iteration.turn(64 * rows.entries(), true, meter), Err(Stop::Later)));
        assert_eq!(iteration.trend.sweeps, SWEEPS);
        iteration.turn(1000 * rows.entries(), true, meter).unwrap();
        assert!((50..80).contains(&iteration.trend.sweeps), "{}", iteration.trend.sweeps);
        assert!(iteration.found().low.iter().zip([100.0, 101.0]).all(|(low, x)| x - low < 1e-6));
    }

    /// All actions are equally good: to go round a ring that is left in one of its groups only, and
    /// rarely; to jump across it; and to leave it at once, in that group.
    fn hardly_left(width: f64) -> Rows<f64> {
        let n = 2000;
        let go = |i: u32| Made { gain: 0.0, exits: Vec::new(), edges: vec![((i + n - 1) % n, 1.0)] };
        let jump =
            |i: u32| Made { gain: 0.0, exits: Vec::new(), edges: vec![((7 * i) % n, 0.25), (i / 2, 0.75)] };
        let mut groups: Vec<_> = (0..n).map(|i| vec![go(i), jump(i)]).collect();
        groups[0] = vec![
            Made { gain: 0.0, exits: vec![(0.5, RARE)], edges: vec![(n - 1, 1.0 - RARE)] },
            Made { gain: 0.0, exits: vec![(0.5, 1.0)], edges: Vec::new() },
        ];
        sparse(Optimum::Max, &groups, width)
    }

    #[test]
    fn rounding_does_not_add_up_on_cycles_that_are_hardly_left() {
        assert_half(solve(&hardly_left(0.0), 10_000));
    }

    #[test]
    fn a_rare_exit_may_have_wide_bounds() {
        assert_half(solve(&hardly_left(5e-9), 10_000));
    }

    /// Returns a random component, some exits of which have the probability `rare`.
    fn random(draw: &mut Draw, optimum: Optimum, rare: f64) -> Vec<Vec<Made>> {
        let n = 1001 + draw.below(200) as u32;
        let mut action = |i: u32, number: usize| {
            let (up, down) = ((i + 1 + draw.below(8) as u32) % n, (i + n - 1 - draw.below(8) as u32) % n);
            let exit = |draw: &mut Draw, p: f64| vec![([0.0, 0.25, 0.5, 1.0][draw.below(4)], p)];
            let cost = match optimum {
                Optimum::Max => 0.0,
                Optimum::Min if i > 8 && draw.below(3) == 0 => 0.0,
                Optimum::Min => [1.0, 2.0, 5.0][draw.below(3)],
            };
            match if number == 0 { 0 } else { draw.below(4) } {
                // Without cost, cycles would have no unique solution: such an action goes down.
                _ if optimum == Optimum::Min && cost == 0.0 => {
                    Made { gain: 0.0, exits: Vec::new(), edges: vec![(down, 1.0)] }
                }
                0 => Made { gain: cost, exits: exit(draw, 0.25), edges: vec![(up, 0.5), (down, 0.25)] },
                1 => {
                    Made { gain: cost + 0.25, exits: exit(draw, 0.5), edges: vec![(up, 0.25), (down, 0.25)] }
                }
                2 => Made { gain: cost, exits: exit(draw, rare), edges: vec![(up, 1.0 - rare)] },
                _ => {
                    Made { gain: cost, exits: vec![(0.0, rare)], edges: vec![(up, 0.5), (down, 0.5 - rare)] }
                }
            }
        };
        (0..n).map(|i| (0..=i as usize % 3).map(|number| action(i, number)).collect()).collect()
    }

    /// Returns the values of a policy by elimination with doubles.
    fn values(sparse: &Rows<f64>, policy: &[u32]) -> Vec<f64> {
        let actions: Vec<usize> = policy.iter().map(|&action| action as usize).collect();
        let constants = actions.iter().map(|&action| sparse.constant(action).low).collect();
        let (chain, mut left) = (Policy { rows: sparse, actions: &actions }, usize::MAX);
        chain::solve(&chain, constants, &mut left, &mut Meter::unlimited(&NoProgress)).unwrap()
    }

    #[test]
    fn iteration_and_elimination_agree_on_large_random_components() {
        for (seed, optimum) in (0..6).flat_map(|seed| [(seed, Optimum::Max), (seed, Optimum::Min)]) {
            let rare = if seed % 2 == 0 { RARE } else { 1.0 / 64.0 };
            let sparse = sparse(optimum, &random(&mut Draw::new(seed), optimum, rare), 0.0);
            let mut iteration = Iteration::new(&sparse, None);
            let end = iteration.turn(10_000 * sparse.entries(), false, &mut Meter::unlimited(&NoProgress));
            assert!(end.is_ok(), "seed {seed}, {optimum:?}: {end:?}");
            let GroupBounds { low, high, .. } = iteration.found();
            for (group, value) in values(&sparse, &iteration.policy).into_iter().enumerate() {
                let (low, high) = (low[group], high[group]);
                assert!(high - low <= 1e-7 * low.max(1.0), "seed {seed}, {optimum:?}: {low} {high}");
                // The policy attains one of the bounds, and elimination has an error of its own.
                let spare = 1e-9 * value.max(1.0);
                assert!(
                    low - spare <= value && value <= high + spare,
                    "seed {seed}, {optimum:?}, group {group}: {low} {high} {value}"
                );
            }
        }
    }
}
