//! Several objectives at once, from one state of an arena without an opponent: whether one strategy satisfies all, the
//! best value of one under bounds of the others, and the Pareto front of all.
//!
//! Weighted sums of objectives have a best strategy without memory beyond the visited sets. Each shows a point that can
//! be attained, and a half-space that contains all of them; strategies with chance attain the means of such points. V.
//! Forejt, M. Kwiatkowska, D. Parker, "Pareto curves for probabilistic model checking" (ATVA 2012).

use meliora_base::error::{Error, Result};
use meliora_base::exact::Ratio;
use meliora_model::Optimum;
use num_traits::{One, Signed, ToPrimitive, Zero};

use crate::graphs::arena::Arena;
use crate::graphs::meter::Meter;
use crate::solvers::hull::{mixed as mixed_shares, separated};
use crate::solvers::outer::Outer;
pub use crate::solvers::pairs::{Counted, counted_steps, decided};
pub use crate::solvers::strategy::{Node, Taking};
use crate::solvers::weighted::{Point, Weighted, rate};
use meliora_base::interval::Interval;

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
    /// The cost without a bound is infinite under each strategy that satisfies the other bounds.
    Infinite,
    /// Points that can be attained, such that no attainable point is better than their means by more than the precision.
    Front(Vec<Vec<f64>>),
}

/// A strategy that a mix begins with.
#[derive(Debug)]
pub struct Part {
    /// Its probability; `None` on a front, each point of which is a strategy of its own.
    pub share: Option<Ratio>,
    /// The values of the objectives that it guarantees: lower bounds of those that are to be great, upper bounds of others.
    pub values: Vec<Ratio>,
    /// The states that it visits with its memory; the first one is the start.
    pub nodes: Vec<Node>,
}

/// Answers a question about several objectives from a state, without an opponent.
///
/// # Errors
/// Several objectives have no bound, but others have one; a front has no finite point; a reward that is to be great can be
/// infinite; the model is a game; a limit is reached.
pub fn several(
    arena: &Arena<'_>,
    state: usize,
    objectives: &[Objective<'_>],
    precision: f64,
) -> Result<Several> {
    answered(arena, state, objectives, precision, false).map(|(found, _)| found)
}

/// Does the same as [`several`], and returns the strategies that show it: a mix draws one of them at the start and follows
/// it from then on. There are none if no strategy satisfies the bounds.
///
/// # Errors
/// The errors of [`several`].
pub fn mixed(
    arena: &Arena<'_>,
    state: usize,
    objectives: &[Objective<'_>],
    precision: f64,
) -> Result<(Several, Vec<Part>)> {
    answered(arena, state, objectives, precision, true)
}

fn answered(
    arena: &Arena<'_>,
    state: usize,
    objectives: &[Objective<'_>],
    precision: f64,
    keeps: bool,
) -> Result<(Several, Vec<Part>)> {
    if arena.theirs.as_ref().is_some_and(|theirs| theirs.any()) {
        return Err(Error::Usage("several objectives are not supported against an opponent".to_owned()));
    }
    let mut meter = arena.meter();
    let counted: Vec<_> = objectives.iter().map(|own| (own.counted, own.optimum)).collect();
    let found = Weighted::new(arena, state, &counted, keeps, &mut meter)?;
    let mut search = found.map(|weighted| Search::new(weighted, precision <= 0.0));
    let open: Vec<usize> = (0..objectives.len()).filter(|&at| objectives[at].bound.is_none()).collect();
    let sign = |at: usize| if objectives[at].optimum == Optimum::Max { Ratio::one() } else { -Ratio::one() };
    let bounds: Vec<Ratio> =
        (0..objectives.len()).map(|at| objectives[at].bound.clone().unwrap_or_default() * sign(at)).collect();
    let found = match (open.as_slice(), &mut search) {
        ([], None) => Several::Achievable(Some(false)),
        ([], Some(search)) => search.achievable(&bounds, &mut meter)?,
        (&[best], search) => {
            let found = match search {
                Some(search) => search.best(best, bounds, sign(best), precision, &mut meter)?,
                None => Several::Best(None),
            };
            match found {
                Several::Best(None) => without(arena, state, objectives, best, precision)?,
                found => found,
            }
        }
        (open, _) if open.len() < objectives.len() => {
            let message = "ask for one value under bounds, or for the best values of all objectives";
            return Err(Error::Usage(message.to_owned()));
        }
        (_, None) => {
            let message = "no strategy has finite values of all objectives";
            return Err(Error::Usage(message.to_owned()));
        }
        (open, Some(search)) => {
            search.front(&open.iter().map(|&at| sign(at)).collect::<Vec<_>>(), precision, &mut meter)?
        }
    };
    let Some(search) = search.filter(|_| keeps) else { return Ok((found, Vec::new())) };
    let signs: Vec<Ratio> = (0..objectives.len()).map(sign).collect();
    let parts = search.parts(arena, &counted, &signs, &mut meter)?;
    Ok((found, parts))
}

/// Returns the value of an objective that is not finite under any strategy that satisfies the others.
fn without(
    arena: &Arena<'_>,
    state: usize,
    objectives: &[Objective<'_>],
    best: usize,
    precision: f64,
) -> Result<Several> {
    let Objective { counted, optimum, .. } = objectives[best];
    if optimum == Optimum::Max || !matches!(counted, Counted::Total(_) | Counted::Before(..)) {
        return Ok(Several::Best(None));
    }
    let others = [&objectives[..best], &objectives[best + 1..]].concat();
    if others.is_empty() {
        return Ok(Several::Infinite);
    }
    Ok(match several(arena, state, &others, precision)? {
        Several::Achievable(Some(true)) => Several::Infinite,
        Several::Achievable(Some(false)) => Several::Best(None),
        undecided => undecided,
    })
}

/// The points that were found.
struct Search {
    weighted: Weighted,
    points: Vec<Vec<Ratio>>,
    /// The policies of the points.
    policies: Vec<Vec<usize>>,
    exact: bool,
    /// The points that show the answer, with their shares in a mean.
    shown: Vec<(usize, Option<Ratio>)>,
}

/// The result of a search for a separation.
enum Separation {
    /// Some strategy reaches the bounds.
    Inside,
    /// The weights and the greatest weighted sum that show that no strategy does.
    Outside(Vec<Ratio>, Ratio),
    /// The bounds are on the border, as far as doubles tell.
    Border,
}

impl Search {
    fn new(weighted: Weighted, exact: bool) -> Self {
        Search { weighted, points: Vec::new(), policies: Vec::new(), exact, shown: Vec::new() }
    }

    /// Begins again with fractions.
    fn be_exact(&mut self) {
        (self.exact, self.points, self.policies) = (true, Vec::new(), Vec::new());
    }

    /// Notes the mean of points that reaches some bounds.
    fn show(&mut self, bounds: &[Ratio]) {
        let shares = mixed_shares(bounds, &self.points).into_iter().enumerate();
        self.shown = shares.filter(|(_, x)| x.is_positive()).map(|(at, x)| (at, Some(x))).collect();
    }

    /// Returns the strategies of the points that show the answer.
    fn parts(
        &self,
        arena: &Arena<'_>,
        objectives: &[(Counted<'_>, Optimum)],
        signs: &[Ratio],
        meter: &mut Meter<'_>,
    ) -> Result<Vec<Part>> {
        let part = |(at, share): &(usize, Option<Ratio>)| {
            let nodes = self.weighted.strategy(&self.policies[*at], arena, objectives, meter)?;
            let values = self.points[*at].iter().zip(signs).map(|(x, sign)| x * sign).collect();
            Ok(Part { share: share.clone(), values, nodes })
        };
        self.shown.iter().map(part).collect()
    }

    /// Finds the best point for some weights.
    fn point(&mut self, weights: &[Ratio], meter: &mut Meter<'_>) -> Result<Point> {
        let point = match self.exact {
            true => self.weighted.exact(weights, meter)?,
            false => self.weighted.near(weights, meter)?,
        };
        self.points.push(point.gains.clone());
        self.policies.push(point.policy.clone());
        Ok(point)
    }

    /// Finds out whether some strategy reaches all bounds.
    fn locate(&mut self, bounds: &[Ratio], meter: &mut Meter<'_>) -> Result<Separation> {
        let n = bounds.len();
        if self.points.is_empty() {
            let equal = self.usable(&vec![Ratio::new(1.into(), n.into()); n]);
            let point = self.point(&equal, meter)?;
            if rate(&equal, bounds) > point.most {
                return Ok(Separation::Outside(equal, point.most));
            }
        }
        loop {
            let (t, weights) = separated(bounds, &self.points);
            if !t.is_positive() {
                return Ok(Separation::Inside);
            }
            let weights = self.usable(&weights);
            let known = self.known(&weights);
            let point = self.point(&weights, meter)?;
            if rate(&weights, bounds) > point.most {
                return Ok(Separation::Outside(weights, point.most));
            }
            if rate(&weights, &point.gains) <= known {
                return Ok(Separation::Border);
            }
        }
    }

    fn achievable(&mut self, bounds: &[Ratio], meter: &mut Meter<'_>) -> Result<Several> {
        let found = match self.locate(bounds, meter)? {
            Separation::Border if !self.exact => {
                self.be_exact();
                self.locate(bounds, meter)?
            }
            found => found,
        };
        if matches!(found, Separation::Inside) {
            self.show(bounds);
        }
        Ok(Several::Achievable(match found {
            Separation::Inside => Some(true),
            Separation::Outside(..) => Some(false),
            Separation::Border => None,
        }))
    }

    /// Lowers the bound of the objective `at`, which is first the best value without the others, by one half-space after
    /// the other, until it can be reached.
    fn best(
        &mut self,
        at: usize,
        mut bounds: Vec<Ratio>,
        sign: Ratio,
        precision: f64,
        meter: &mut Meter<'_>,
    ) -> Result<Several> {
        bounds[at] = self.point(&alone(at, bounds.len()), meter)?.most;
        let width = Ratio::from_float(precision).unwrap_or_default();
        loop {
            match self.locate(&bounds, meter)? {
                Separation::Inside => break,
                Separation::Outside(weights, most) if weights[at].is_positive() => {
                    let others = rate(&weights, &bounds) - &weights[at] * &bounds[at];
                    bounds[at] = (most - others) / &weights[at];
                }
                Separation::Outside(..) => return Ok(Several::Best(None)),
                Separation::Border => break,
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
                        self.be_exact();
                        self.best(at, bounds, sign, precision, meter)
                    }
                };
            }
            less = step.clone();
            step *= Ratio::from_integer(2.into());
            bounds[at] = &upper - &less;
        }
        self.show(&bounds);
        let (low, high) = (bounds[at].clone() * &sign, upper * &sign);
        Ok(Several::Best(Some(Interval::around(&low).range(Interval::around(&high)))))
    }

    /// Searches at the vertices of the half-spaces, as long as one lies further outside than the precision.
    fn front(&mut self, signs: &[Ratio], precision: f64, meter: &mut Meter<'_>) -> Result<Several> {
        // The other half is lost by points that are left out.
        let half = Ratio::from_float(precision / 2.0).unwrap_or_default();
        let mut top = Vec::new();
        for at in 0..signs.len() {
            top.push(self.point(&alone(at, signs.len()), meter)?.most);
        }
        let (mut outer, mut near) = (Outer::below(top), Vec::new());
        while let Some(vertex) = outer.vertex(|x| !near.iter().any(|near: &Vec<Ratio>| near == x)) {
            let vertex = vertex.to_vec();
            let (away, weights) = separated(&vertex, &self.points);
            if away <= half {
                near.push(vertex);
                continue;
            }
            let weights = self.usable(&weights);
            let known = self.known(&weights);
            let point = self.point(&weights, meter)?;
            if rate(&weights, &vertex) > point.most {
                outer.cut(&weights, &point.most);
            } else if rate(&weights, &point.gains) <= known {
                near.push(vertex);
            }
        }
        let shown = needed(&self.points, &half);
        // Rounding outwards may lead below 0, where no probability and no reward is.
        let number = |(x, sign): (&Ratio, &Ratio)| (x * sign).to_f64().unwrap_or(f64::NAN).max(0.0);
        let point = |&at: &usize| self.points[at].iter().zip(signs).map(number).collect();
        let front = shown.iter().map(point).collect();
        self.shown = shown.into_iter().map(|at| (at, None)).collect();
        Ok(Several::Front(front))
    }

    /// Returns weights with few digits, unless all numbers are exact.
    fn usable(&self, weights: &[Ratio]) -> Vec<Ratio> {
        weights.iter().map(|weight| if self.exact { weight.clone() } else { rounded(weight) }).collect()
    }

    /// Returns the greatest weighted sum of the points so far.
    fn known(&self, weights: &[Ratio]) -> Ratio {
        self.points.iter().map(|x| rate(weights, x)).max().unwrap_or_default()
    }
}

/// Returns the positions of the points that are not below means of the others, in the order of the first objective; all
/// that are left out are at most `width` above such means.
fn needed(points: &[Vec<Ratio>], width: &Ratio) -> Vec<usize> {
    let mut left: Vec<usize> = (0..points.len()).collect();
    left.sort_by(|&a, &b| points[a].cmp(&points[b]));
    left.dedup_by(|a, b| points[*a] == points[*b]);
    let each = width / Ratio::from_integer(left.len().into());
    let mut at = 0;
    while at < left.len() {
        let point = left.remove(at);
        let others: Vec<Vec<Ratio>> = left.iter().map(|&other| points[other].clone()).collect();
        if others.is_empty() || separated(&points[point], &others).0 > each {
            left.insert(at, point);
            at += 1;
        }
    }
    left
}

/// Returns a weight with few digits.
fn rounded(x: &Ratio) -> Ratio {
    x.to_f64().and_then(Ratio::from_float).unwrap_or_default()
}

/// Returns the weights of one objective alone, of `n`.
fn alone(at: usize, n: usize) -> Vec<Ratio> {
    (0..n).map(|own| Ratio::from_integer((own == at).into())).collect()
}
