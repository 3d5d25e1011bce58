//! Several objectives at once, from one state of an arena without an opponent: whether one strategy satisfies all, the
//! best value of one under bounds of the others, and the Pareto front of two.
//!
//! Weighted sums of objectives have a best strategy without memory beyond the visited sets. Each shows a point that can
//! be attained, and a half-space that contains all of them; strategies with chance attain the means of such points. V.
//! Forejt, M. Kwiatkowska, D. Parker, "Pareto curves for probabilistic model checking" (ATVA 2012).

use meliora_base::error::{Error, Result};
use meliora_base::exact::Ratio;
use meliora_model::Optimum;
use num_traits::{One, Signed, ToPrimitive, Zero};

use crate::equations::arena::Arena;
use crate::equations::meter::Meter;
use crate::equations::number::Interval;
use crate::solvers::hull::separated;
pub use crate::solvers::weighted::Counted;
use crate::solvers::weighted::{Point, Weighted, rate};

/// An objective.
#[derive(Debug, Clone)]
pub struct Objective<'a> {
    /// The number that is counted.
    pub counted: Counted<'a>,
    /// The extreme that is wanted.
    pub optimum: Optimum,
    /// The number that it must reach, or not exceed; `None` for `=?`.
    pub bound: Option<Ratio>,
}

/// The answer for several objectives.
#[derive(Debug)]
pub enum Several {
    /// True if one strategy satisfies all bounds; `None` if it is not decided.
    Achievable(Option<bool>),
    /// Bounds of the best value of the objective without a bound; `None` if the other bounds cannot be satisfied.
    Best(Option<Interval>),
    /// Points that can be attained, such that no attainable point is better than their means by more than the precision.
    Front(Vec<[f64; 2]>),
}

/// Answers a question about several objectives from a state, without an opponent.
///
/// # Errors
/// More than two objectives have no bound, or one of three or more; a reward can be earned for all time; the model is a
/// game; a limit is reached.
pub fn several(
    arena: &Arena<'_>,
    state: usize,
    objectives: &[Objective<'_>],
    precision: f64,
) -> Result<Several> {
    if arena.theirs.as_ref().is_some_and(|theirs| theirs.any()) {
        return Err(Error::Usage("several objectives are not supported against an opponent".to_owned()));
    }
    let mut meter = arena.meter();
    let counted: Vec<_> = objectives.iter().map(|own| (own.counted, own.optimum)).collect();
    let weighted = Weighted::new(arena, state, &counted, &mut meter)?;
    let search = Search { weighted, points: Vec::new(), exact: precision <= 0.0 };
    let open: Vec<usize> = (0..objectives.len()).filter(|&at| objectives[at].bound.is_none()).collect();
    let sign = |at: usize| if objectives[at].optimum == Optimum::Max { Ratio::one() } else { -Ratio::one() };
    let bounds: Vec<Ratio> =
        (0..objectives.len()).map(|at| objectives[at].bound.clone().unwrap_or_default() * sign(at)).collect();
    match *open {
        [] => search.achievable(&bounds, &mut meter),
        [best] => search.best(best, bounds, sign(best), precision, &mut meter),
        [0, 1] if objectives.len() == 2 => search.front([sign(0), sign(1)], precision, &mut meter),
        _ => Err(Error::Usage("ask for at most two values at once, and for two without bounds".to_owned())),
    }
}

/// The points that were found.
struct Search {
    weighted: Weighted,
    points: Vec<Vec<Ratio>>,
    exact: bool,
}

/// The result of a search for a separation.
enum Found {
    /// Some strategy reaches the bounds.
    Inside,
    /// The weights and the greatest weighted sum that show that no strategy does.
    Outside(Vec<Ratio>, Ratio),
    /// The bounds are on the border, as far as doubles tell.
    Border,
}

impl Search {
    /// Finds the best point for some weights.
    fn point(&mut self, weights: &[Ratio], meter: &mut Meter<'_>) -> Result<Point> {
        let point = match self.exact {
            true => self.weighted.exact(weights, meter)?,
            false => self.weighted.near(weights, meter)?,
        };
        self.points.push(point.gains.clone());
        Ok(point)
    }

    /// Finds out whether some strategy reaches all bounds.
    fn locate(&mut self, bounds: &[Ratio], meter: &mut Meter<'_>) -> Result<Found> {
        let n = bounds.len();
        if self.points.is_empty() {
            let equal = vec![rounded(&Ratio::new(1.into(), n.into())); n];
            let point = self.point(&equal, meter)?;
            if rate(&equal, bounds) > point.most {
                return Ok(Found::Outside(equal, point.most));
            }
        }
        loop {
            let (t, weights) = separated(bounds, &self.points);
            if !t.is_positive() {
                return Ok(Found::Inside);
            }
            let weights: Vec<Ratio> = weights.iter().map(rounded).collect();
            let known = self.points.iter().map(|x| rate(&weights, x)).max().unwrap_or_default();
            let point = self.point(&weights, meter)?;
            if rate(&weights, bounds) > point.most {
                return Ok(Found::Outside(weights, point.most));
            }
            if rate(&weights, &point.gains) <= known {
                return Ok(Found::Border);
            }
        }
    }

    fn achievable(mut self, bounds: &[Ratio], meter: &mut Meter<'_>) -> Result<Several> {
        let found = match self.locate(bounds, meter)? {
            Found::Border if !self.exact => {
                (self.exact, self.points) = (true, Vec::new());
                self.locate(bounds, meter)?
            }
            found => found,
        };
        Ok(Several::Achievable(match found {
            Found::Inside => Some(true),
            Found::Outside(..) => Some(false),
            Found::Border => None,
        }))
    }

    /// Lowers the bound of the objective `at`, which is first the best value without the others, by one half-space after
    /// the other, until it can be reached.
    fn best(
        mut self,
        at: usize,
        mut bounds: Vec<Ratio>,
        sign: Ratio,
        precision: f64,
        meter: &mut Meter<'_>,
    ) -> Result<Several> {
        let alone: Vec<Ratio> =
            (0..bounds.len()).map(|own| if own == at { Ratio::one() } else { Ratio::zero() }).collect();
        bounds[at] = self.point(&alone, meter)?.most;
        let width = Ratio::from_float(precision).unwrap_or_default();
        loop {
            match self.locate(&bounds, meter)? {
                Found::Inside => break,
                Found::Outside(weights, most) if weights[at].is_positive() => {
                    let others = rate(&weights, &bounds) - &weights[at] * &bounds[at];
                    bounds[at] = (most - others) / &weights[at];
                }
                Found::Outside(..) => return Ok(Several::Best(None)),
                Found::Border => break,
            }
        }
        let upper = bounds[at].clone();
        // What the points so far show, up to the precision.
        let mut less = Ratio::zero();
        let mut step = &width / Ratio::from_integer(1024.into());
        while separated(&bounds, &self.points).0.is_positive() {
            if less > width {
                return match self.exact {
                    true => Ok(Several::Best(None)),
                    false => {
                        let again = Search { exact: true, points: Vec::new(), ..self };
                        again.best(at, bounds, sign, precision, meter)
                    }
                };
            }
            less = step.clone();
            step *= Ratio::from_integer(2.into());
            bounds[at] = &upper - &less;
        }
        let (low, high) = (bounds[at].clone() * &sign, upper * &sign);
        let (low, high) = if low <= high { (low, high) } else { (high, low) };
        Ok(Several::Best(Some(Interval {
            lower: Interval::around(&low).lower,
            upper: Interval::around(&high).upper,
        })))
    }

    /// Searches between neighbours, as long as a point lies further outside than the precision.
    fn front(mut self, signs: [Ratio; 2], precision: f64, meter: &mut Meter<'_>) -> Result<Several> {
        let (one, zero) = (Ratio::one(), Ratio::zero());
        let width = Ratio::from_float(precision).unwrap_or_default();
        let (a, b) = (self.point(&[one.clone(), zero.clone()], meter)?, self.point(&[zero, one], meter)?);
        let mut open = vec![(a.gains, b.gains)];
        while let Some((a, b)) = open.pop() {
            let weights = [&b[1] - &a[1], &a[0] - &b[0]];
            let sum = &weights[0] + &weights[1];
            if !weights.iter().all(|w| w.is_positive()) || !sum.is_positive() {
                continue;
            }
            let weights = weights.map(|w| rounded(&(w / &sum)));
            let point = self.point(&weights, meter)?;
            if point.most - rate(&weights, &a) > width && rate(&weights, &point.gains) > rate(&weights, &a) {
                open.extend([(a, point.gains.clone()), (point.gains, b)]);
            }
        }
        Ok(Several::Front(upper_right(self.points, &signs)))
    }
}

/// Returns the points to which no other one is preferable, in the order of the first objective.
fn upper_right(mut points: Vec<Vec<Ratio>>, signs: &[Ratio; 2]) -> Vec<[f64; 2]> {
    points.sort();
    points.dedup();
    let mut kept: Vec<Vec<Ratio>> = Vec::new();
    for point in points {
        while kept.last().is_some_and(|last| last[1] <= point[1]) {
            kept.pop();
        }
        kept.push(point);
    }
    // Rounding outwards may lead below 0, where no probability and no reward is.
    let number = |x: &Ratio, sign: &Ratio| (x * sign).to_f64().unwrap_or(f64::NAN).max(0.0);
    kept.iter().map(|x| [number(&x[0], &signs[0]), number(&x[1], &signs[1])]).collect()
}

/// Returns a weight with few digits.
fn rounded(x: &Ratio) -> Ratio {
    x.to_f64().and_then(Ratio::from_float).unwrap_or_default()
}
