//! Bounds of the optimal values of a large component, by optimistic value iteration.
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
//! rounded up, until one sweep raises no value: then it is an upper bound. If no candidate is found, the
//! lower bounds are raised by a small relative amount when they hardly change. If this takes too long, the lower bounds are iterated
//! further and a smaller amount is tried. If the values at the exits are bounds, a candidate must be
//! above their upper ones: it is iterated with them first, or else their greatest width is added to
//! it. Probabilities have the upper bound 1 to start with; if no candidate is found, it is iterated
//! downwards (interval iteration).
//!
//! A sweep visits the groups in postorder and uses new values at once (Gauss and Seidel), so values
//! travel through most of a component in one sweep; [`super::order`] has a better order for some.
//! [`super::sparse`] describes the rounding.
//!
//! A. Hartmanns and B. Kaminski, "Optimistic value iteration" (CAV 2020); S. Haddad and B. Monmege,
//! "Interval iteration algorithm for MDPs and IMDPs" (TCS 2018).

use super::component::Sense;
use super::meter::Meter;
use super::pace::{Change, FLOOR, PATIENCE, Pace, Patience, SOON, Trend};
use super::solve::NONE;
pub(super) use super::sparse::Sparse;
use super::sparse::TINY;
use meliora_model::error::Result;

/// The relative width that is tried first, and the factor for the next attempts.
const WIDTH: f64 = 1e-9;
const NARROWER: f64 = 1e-2;
/// The change of a sweep, as a part of the width, at which lower bounds are raised to a candidate.
const STILL: f64 = 1e-3;
/// The width of bounds, absolute below 1, for which another attempt is made; twice the width of the
/// bounds at the exits is added.
const WIDE: f64 = 1e-8;
/// Attempts with a smaller width.
const ATTEMPTS: usize = 3;
/// The part of the width that is added to such a candidate.
const SPARE: f64 = 0.1;

/// The bounds of the groups.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) low: Vec<f64>,
    pub(super) high: Vec<Option<f64>>,
    /// The choice by which each group is left, or [`NONE`].
    pub(super) picks: Vec<u32>,
}

impl Found {
    /// Returns the bounds of some groups of which nothing is known.
    pub(super) fn nothing(groups: usize) -> Self {
        Found { low: vec![0.0; groups], high: vec![None; groups], picks: vec![NONE; groups] }
    }
}

/// Computes bounds of the groups, which are at most `top` if it is given. The result is true if they
/// are narrow, false if iteration would take too long, or an error if a limit is reached; the bounds
/// hold in any case.
pub(super) fn solve(
    sparse: &Sparse,
    top: Option<f64>,
    patience: Patience,
    meter: &mut Meter<'_>,
) -> (Found, Result<bool>) {
    let n = sparse.groups();
    let high = top.map(|top| vec![top; n]);
    let mut work = Iteration { sparse, low: vec![0.0; n], high, policy: vec![NONE; n], patience };
    let end = work.run(meter);
    (work.found(), end)
}

struct Iteration<'s> {
    sparse: &'s Sparse,
    low: Vec<f64>,
    /// Upper bounds, if some are known.
    high: Option<Vec<f64>>,
    /// For the greatest values: the action that raised the lower bound last. A policy of such actions
    /// leaves the component: if it stayed for all time, the first group to get the greatest value of
    /// all would have had to get it from a smaller one. For the least values: the action that
    /// attains the upper bound.
    policy: Vec<u32>,
    patience: Patience,
}

impl Iteration<'_> {
    fn run(&mut self, meter: &mut Meter<'_>) -> Result<bool> {
        // The errors of smaller numbers are not relative.
        if self.sparse.least < TINY {
            return Ok(false);
        }
        let mut width = WIDTH;
        for _ in 0..ATTEMPTS {
            match self.raise(width, meter)? {
                Raised::Enclosed => return Ok(true),
                Raised::Still if self.enclose(width, meter)? && self.is_narrow() => return Ok(true),
                Raised::Still => width *= NARROWER,
                Raised::Slow => return Ok(false),
            }
        }
        self.sink(meter)
    }

    /// Iterates upper bounds downwards; returns whether they become narrow.
    fn sink(&mut self, meter: &mut Meter<'_>) -> Result<bool> {
        let mut pace = Pace::new(WIDTH * STILL, self.sparse.groups(), self.patience);
        while !self.is_narrow() {
            let Some(high) = self.high.as_mut().filter(|_| self.sparse.sense == Sense::Max) else {
                return Ok(false);
            };
            let mut change = Change::default();
            self.sparse.sweep(true, high, meter, |_, x, (q, _)| {
                if q < *x {
                    change.note(*x - q, *x);
                    *x = q;
                }
            })?;
            let change = change.0;
            meter.progress(&|| format!("upper bounds of {} states, change {change:.1e}", high.len()));
            if pace.after(change).is_some() {
                return Ok(self.is_narrow());
            }
        }
        Ok(true)
    }

    /// Iterates the lower bounds until they hardly change, or until upper bounds are found near them.
    fn raise(&mut self, width: f64, meter: &mut Meter<'_>) -> Result<Raised> {
        let (mut pace, mut trend) =
            (Pace::new(width * STILL, self.sparse.groups(), self.patience), Trend::default());
        let mut before: Option<Vec<f64>> = None;
        loop {
            let change = self.lift(meter)?;
            meter.progress(&|| format!("lower bounds of {} states, change {change:.1e}", self.low.len()));
            trend.note(change);
            if let Some(before) = before.take()
                && self.extrapolate(&before, &trend, width, meter)?
            {
                return Ok(Raised::Enclosed);
            }
            match pace.after(change) {
                Some(true) => return Ok(Raised::Still),
                Some(false) => return Ok(Raised::Slow),
                None => before = trend.expects(width).then(|| self.low.clone()),
            }
        }
    }

    /// Iterates the lower bounds once; returns the greatest change.
    fn lift(&mut self, meter: &mut Meter<'_>) -> Result<f64> {
        let mut change = Change::default();
        let (greatest, policy) = (self.sparse.sense == Sense::Max, &mut self.policy);
        self.sparse.sweep(false, &mut self.low, meter, |group, x, (q, action)| {
            if q > *x {
                change.note(if *x == 0.0 { q.max(FLOOR) } else { q - *x }, q);
                *x = q;
                if greatest {
                    policy[group] = action as u32;
                }
            }
        })?;
        Ok(change.0)
    }

    /// Looks for upper bounds where the changes so far lead, from the values before the last sweep. If all
    /// changes shrink by the factor r, the values grow by r / (1 - r) times the last change. Twice this is an
    /// upper bound that one sweep confirms. The width of the exits is added, which stays one from step to
    /// step.
    fn extrapolate(
        &mut self,
        before: &[f64],
        trend: &Trend,
        width: f64,
        meter: &mut Meter<'_>,
    ) -> Result<bool> {
        let inherited = self.sparse.inherited;
        if inherited > WIDE {
            return Ok(false);
        }
        let (factor, more) = (2.0 * trend.still_to_come(), inherited * (1.0 + SPARE) + width * SPARE);
        let candidate = |(x, before): (&f64, &f64)| x + factor * (x - before) + more;
        let candidates = self.low.iter().zip(before).map(candidate).collect();
        Ok(self.confirm(candidates, SOON, meter)? && self.is_narrow())
    }

    /// Looks for upper bounds near the lower ones; returns whether they were found.
    fn enclose(&mut self, width: f64, meter: &mut Meter<'_>) -> Result<bool> {
        let mut x = self.low.clone();
        if self.sparse.is_exact() || self.follow(&mut x, width, meter)? {
            x.iter_mut().for_each(|x| *x += width * x.max(FLOOR));
            if self.confirm(x, usize::MAX, meter)? {
                return Ok(true);
            }
        }
        // An exit with wide bounds may be too rare to be followed.
        let inherited = self.sparse.inherited;
        if inherited == 0.0 || inherited > WIDE {
            return Ok(false);
        }
        let x = self.low.iter().map(|x| x + inherited + width * x.max(FLOOR)).collect();
        self.confirm(x, usize::MAX, meter)
    }

    /// Iterates a candidate until it is an upper bound; returns false if it does not become one in at most so
    /// many sweeps.
    fn confirm(&mut self, mut x: Vec<f64>, most: usize, meter: &mut Meter<'_>) -> Result<bool> {
        let (mut last, mut policy) = (f64::INFINITY, self.policy.clone());
        for sweep in 0..most {
            let mut raised = Change::default();
            let least = self.sparse.sense == Sense::Min;
            self.sparse.sweep(true, &mut x, meter, |group, x, (q, action)| {
                raised.note(q - *x, q);
                *x = q;
                if least {
                    policy[group] = action as u32;
                }
            })?;
            let raised = raised.0;
            if raised <= 0.0 {
                self.policy = policy;
                // Both are upper bounds.
                let known = self.high.take().unwrap_or_else(|| vec![f64::INFINITY; x.len()]);
                self.high = Some(x.into_iter().zip(known).map(|(x, known)| x.min(known)).collect());
                return Ok(true);
            }
            if sweep % (4 * PATIENCE) == 4 * PATIENCE - 1 {
                // The values settle without being an upper bound, or hardly anything changes.
                if raised > 0.5 * last || !raised.is_finite() {
                    return Ok(false);
                }
                last = raised;
            }
        }
        Ok(false)
    }

    fn is_narrow(&self) -> bool {
        let Some(high) = &self.high else { return false };
        let narrow =
            |(low, high): (&f64, &f64)| high - low <= WIDE * low.max(1.0) + 2.0 * self.sparse.inherited;
        self.low.iter().zip(high).all(narrow)
    }

    /// Iterates towards the solution with the upper bounds of the constants.
    fn follow(&self, x: &mut [f64], width: f64, meter: &mut Meter<'_>) -> Result<bool> {
        let mut pace = Pace::new(width * STILL, x.len(), self.patience);
        loop {
            let mut change = Change::default();
            self.sparse.sweep(true, x, meter, |_, x, (q, _)| {
                change.note(q - *x, q);
                *x = q.max(*x);
            })?;
            if let Some(done) = pace.after(change.0) {
                return Ok(done);
            }
        }
    }

    fn found(self) -> Found {
        let pick = |&action: &u32| {
            let known = action != NONE && (self.sparse.sense == Sense::Max || self.high.is_some());
            if known { self.sparse.choices[action as usize] } else { NONE }
        };
        let picks = self.policy.iter().map(pick).collect();
        let high = match self.high {
            Some(high) => high.into_iter().map(Some).collect(),
            None => vec![None; self.low.len()],
        };
        Found { low: self.low, high, picks }
    }
}

/// The end of an iteration of lower bounds.
enum Raised {
    /// Narrow upper bounds were found.
    Enclosed,
    /// The bounds hardly change.
    Still,
    /// It would take too long.
    Slow,
}

#[cfg(test)]
mod tests {
    use super::super::component::{Action, Component};
    use super::super::eliminate::Row;
    use super::super::number::{Interval, Number};
    use super::*;
    use meliora_engine::NoProgress;
    use meliora_model::random::Draw;

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
    fn sparse(sense: Sense, groups: &[Vec<Made>], width: f64) -> Sparse {
        let mut sparse = Sparse::empty(sense);
        (sparse.error, sparse.inherited, sparse.least) = (16.0 * f64::EPSILON, width, RARE);
        for (group, actions) in (0..).zip(groups) {
            sparse.begin(group);
            for made in actions {
                let number = sparse.choices.len() as u32;
                let (low, width) = (made.constant(), if number == 0 { width } else { 0.0 });
                let high = low + made.exits.first().map_or(0.0, |exit| exit.1 * width);
                let escape = made.exits.iter().map(|exit| exit.1).sum();
                sparse.push(number, made.edges.iter().copied(), [low, high, made.greatest() + width, escape]);
            }
        }
        sparse.begin(groups.len() as u32);
        sparse
    }

    fn component(sense: Sense, groups: &[Vec<Made>]) -> Component<Interval> {
        let action = |made: &Made| {
            let mut edges: Vec<_> = made.edges.iter().map(|&(to, p)| (to, Interval::point(p))).collect();
            edges.sort_unstable_by_key(|edge| edge.0);
            let escape = Interval::point(made.exits.iter().map(|exit| exit.1).sum());
            let constant = Interval::point(made.constant());
            Action::new(0, (Row { edges, escape, constant }, constant), true)
        };
        let actions = groups.iter().map(|actions| actions.iter().map(action).collect()).collect();
        Component { sense, actions }
    }

    /// Each group continues with the next one, or leaves with the value 1/2.
    fn ring(n: u32, leaving: f64) -> Vec<Vec<Made>> {
        let made =
            |i| Made { gain: 0.0, exits: vec![(0.5, leaving)], edges: vec![((i + 1) % n, 1.0 - leaving)] };
        (0..n).map(|i| vec![made(i)]).collect()
    }

    fn assert_half(found: &Found) {
        for (low, high) in found.low.iter().zip(&found.high) {
            let high = high.unwrap();
            assert!(*low <= 0.5 && 0.5 <= high && high - low < 1e-8, "{low} {high}");
        }
    }

    #[test]
    fn bounds_contain_the_value_and_are_narrow() {
        let ring = sparse(Sense::Max, &ring(50, 0.25), 0.0);
        let (found, end) = solve(&ring, None, Patience::Much, &mut Meter::unlimited(&NoProgress));
        assert!(end.unwrap());
        assert_half(&found);
    }

    #[test]
    fn a_component_that_is_hardly_left_is_given_up_with_true_bounds() {
        let ring = sparse(Sense::Max, &ring(50, 2.0f64.powi(-45)), 0.0);
        let (found, end) = solve(&ring, None, Patience::Much, &mut Meter::unlimited(&NoProgress));
        assert!(!end.unwrap());
        assert!(found.low.iter().all(|low| *low <= 0.5) && found.high.iter().all(Option::is_none));
    }

    /// All actions are equally good: to go round a ring that is left in one of its groups only, and
    /// rarely; to jump across it; and to leave it at once, in that group.
    fn hardly_left(width: f64) -> Sparse {
        let n = 2000;
        let go = |i: u32| Made { gain: 0.0, exits: Vec::new(), edges: vec![((i + n - 1) % n, 1.0)] };
        let jump =
            |i: u32| Made { gain: 0.0, exits: Vec::new(), edges: vec![((7 * i) % n, 0.25), (i / 2, 0.75)] };
        let mut groups: Vec<_> = (0..n).map(|i| vec![go(i), jump(i)]).collect();
        groups[0] = vec![
            Made { gain: 0.0, exits: vec![(0.5, RARE)], edges: vec![(n - 1, 1.0 - RARE)] },
            Made { gain: 0.0, exits: vec![(0.5, 1.0)], edges: Vec::new() },
        ];
        sparse(Sense::Max, &groups, width)
    }

    #[test]
    fn rounding_does_not_add_up_on_cycles_that_are_hardly_left() {
        let (found, end) = solve(&hardly_left(0.0), None, Patience::Much, &mut Meter::unlimited(&NoProgress));
        assert!(end.unwrap());
        assert_half(&found);
    }

    #[test]
    fn a_rare_exit_may_have_wide_bounds() {
        let (found, end) =
            solve(&hardly_left(5e-9), None, Patience::Much, &mut Meter::unlimited(&NoProgress));
        assert!(end.unwrap());
        assert_half(&found);
    }

    fn random(draw: &mut Draw, sense: Sense) -> Vec<Vec<Made>> {
        let n = 1001 + draw.below(200) as u32;
        let mut action = |i: u32, number: usize| {
            let (up, down) = ((i + 1 + draw.below(8) as u32) % n, (i + n - 1 - draw.below(8) as u32) % n);
            let exit = |draw: &mut Draw, p: f64| vec![([0.0, 0.25, 0.5, 1.0][draw.below(4)], p)];
            let cost = match sense {
                Sense::Max => 0.0,
                Sense::Min if i > 8 && draw.below(3) == 0 => 0.0,
                Sense::Min => [1.0, 2.0, 5.0][draw.below(3)],
            };
            match if number == 0 { 0 } else { draw.below(4) } {
                // Without cost, cycles would have no unique solution: such an action goes down.
                _ if sense == Sense::Min && cost == 0.0 => {
                    Made { gain: 0.0, exits: Vec::new(), edges: vec![(down, 1.0)] }
                }
                0 => Made { gain: cost, exits: exit(draw, 0.25), edges: vec![(up, 0.5), (down, 0.25)] },
                1 => {
                    Made { gain: cost + 0.25, exits: exit(draw, 0.5), edges: vec![(up, 0.25), (down, 0.25)] }
                }
                2 => Made { gain: cost, exits: exit(draw, RARE), edges: vec![(up, 1.0 - RARE)] },
                _ => {
                    Made { gain: cost, exits: vec![(0.0, RARE)], edges: vec![(up, 0.5), (down, 0.5 - RARE)] }
                }
            }
        };
        (0..n).map(|i| (0..=i as usize % 3).map(|number| action(i, number)).collect()).collect()
    }

    #[test]
    fn iteration_and_elimination_agree_on_large_random_components() {
        for (seed, sense) in (0..6).flat_map(|seed| [(seed, Sense::Max), (seed, Sense::Min)]) {
            let groups = random(&mut Draw::new(seed), sense);
            let mut meter = Meter::unlimited(&NoProgress);
            let (found, end) = solve(&sparse(sense, &groups, 0.0), None, Patience::Much, &mut meter);
            assert!(end.unwrap(), "seed {seed}, {sense:?}");
            let other = component(sense, &groups).solve(&mut meter).unwrap().unwrap();
            for group in 0..groups.len() {
                let (low, high) = (found.low[group], found.high[group].unwrap());
                assert!(high - low <= 1e-7 * low.max(1.0), "seed {seed}, {sense:?}: {low} {high}");
                let above = other.high[group].map_or(f64::INFINITY, |high| high.upper);
                assert!(
                    low <= above && other.low[group].bounds().lower <= high,
                    "seed {seed}, {sense:?}, group {group}: {low} {high}, {:?} {above}",
                    other.low[group]
                );
            }
        }
    }
}
