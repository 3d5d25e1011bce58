//! Estimates of the value of a strategy from simulated runs, with confidence intervals.

/// The confidence of all intervals.
pub const CONFIDENCE: f64 = 0.99;
/// The quantile of the normal distribution for this confidence: Φ(z) = 0.995.
const Z: f64 = 2.575_829_303_548_901;
/// The smallest number of runs for which an interval of the mean cost is stated.
const FEWEST: u64 = 10;

/// The runs from one state as a sample: how many made k improvements, and at what cost.
#[derive(Debug, Clone, PartialEq)]
pub struct Sample {
    /// The number of improvements k.
    pub improvements: usize,
    /// The number of runs.
    pub runs: u64,
    /// The number of runs with k improvements.
    pub reached: u64,
    /// The number of runs that were given up before, and could still have made k improvements.
    pub open: u64,
    /// The mean cost until the k-th improvement over the runs that made it.
    pub mean_cost: f64,
    /// The sum of the squared distances from this mean.
    squares: f64,
}

impl Sample {
    /// Creates a sample without runs.
    pub fn new(improvements: usize) -> Self {
        Sample { improvements, runs: 0, reached: 0, open: 0, mean_cost: 0.0, squares: 0.0 }
    }

    /// Adds a run that made k improvements at a cost (B. P. Welford, 1962).
    pub fn reach(&mut self, cost: f64) {
        (self.runs, self.reached) = (self.runs + 1, self.reached + 1);
        let before = cost - self.mean_cost;
        self.mean_cost += before / self.reached as f64;
        self.squares += before * (cost - self.mean_cost);
    }

    /// Adds a run that did not make k improvements; `open` if it was given up before.
    pub fn miss(&mut self, open: bool) {
        self.runs += 1;
        self.open += u64::from(open);
    }

    /// Returns the share of the runs with k improvements.
    pub fn share(&self) -> f64 {
        self.reached as f64 / self.runs as f64
    }

    /// Returns a confidence interval of the probability of k improvements: E. B. Wilson's (1927). An
    /// open run counts as a failure in the lower bound, and as a success in the upper bound.
    pub fn probability(&self) -> (f64, f64) {
        let (lower, _) = wilson(self.reached, self.runs);
        let (_, upper) = wilson(self.reached + self.open, self.runs);
        (lower, upper)
    }

    /// Returns a confidence interval of the expected cost, from Student's distribution; `None` if some
    /// run did not make k improvements, or for fewer than 10 runs.
    pub fn cost(&self) -> Option<(f64, f64)> {
        if self.reached < self.runs || self.runs < FEWEST {
            return None;
        }
        let n = self.runs as f64;
        let half = student(n - 1.0) * (self.squares / (n - 1.0) / n).sqrt();
        Some((self.mean_cost - half, self.mean_cost + half))
    }
}

fn wilson(successes: u64, runs: u64) -> (f64, f64) {
    let (n, p) = (runs as f64, successes as f64 / runs as f64);
    let square = Z * Z / n;
    let centre = (p + square / 2.0) / (1.0 + square);
    let half = (p * (1.0 - p) * square + square * square / 4.0).sqrt() / (1.0 + square);
    // At the ends, the formula is exact except for rounding.
    let lower = if successes == 0 { 0.0 } else { (centre - half).max(0.0) };
    let upper = if successes == runs { 1.0 } else { (centre + half).min(1.0) };
    (lower, upper)
}

/// Returns the quantile of Student's distribution with `v` ≥ 9 degrees of freedom, with an error below
/// 0.003 (M. Abramowitz and I. A. Stegun, 26.7.5).
fn student(v: f64) -> f64 {
    let (z, w) = (Z, Z * Z);
    let first = z * (w + 1.0) / 4.0;
    let second = z * ((5.0 * w + 16.0) * w + 3.0) / 96.0;
    let third = z * (((3.0 * w + 19.0) * w + 17.0) * w - 15.0) / 384.0;
    z + (first + (second + third / v) / v) / v
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(x: f64, y: f64, error: f64) -> bool {
        (x - y).abs() < error
    }

    #[test]
    fn bounds_are_the_probabilities_that_the_test_just_accepts() {
        for (successes, runs) in [(26, 100), (1, 1000), (999, 1000), (3, 4)] {
            let p = successes as f64 / runs as f64;
            let (lower, upper) = wilson(successes, runs);
            for bound in [lower, upper] {
                let deviation = (bound * (1.0 - bound) / runs as f64).sqrt();
                assert!(close((p - bound).abs(), Z * deviation, 1e-12), "{bound}");
            }
        }
    }

    #[test]
    fn quantiles_are_those_of_tables() {
        assert!(close(student(9.0), 3.249_836, 0.003) && close(student(99.0), 2.626_405, 1e-5));
    }

    #[test]
    fn certain_and_impossible_events_are_in_their_intervals() {
        assert_eq!((wilson(0, 7).0, wilson(7, 7).1), (0.0, 1.0));
        assert!(wilson(7, 7).0 > 0.4 && wilson(0, 7).1 < 0.6);
    }

    #[test]
    fn runs_that_were_given_up_widen_the_interval() {
        let mut sample = Sample::new(1);
        (0..10).for_each(|_| sample.reach(1.0));
        assert_eq!(sample.cost(), Some((1.0, 1.0)));
        sample.miss(true);
        assert_eq!((sample.probability().1, sample.cost()), (1.0, None));
        sample.miss(false);
        assert!(sample.probability().1 < 1.0);
    }

    #[test]
    fn costs_have_their_mean_and_deviation() {
        let mut sample = Sample::new(1);
        (1..=11).for_each(|cost| sample.reach(f64::from(cost)));
        // The variance is 11, so the error of the mean is 1; qt(0.995, 10) = 3.169273.
        let (lower, upper) = sample.cost().unwrap();
        assert!(close(lower, 6.0 - 3.169_273, 0.003) && close(upper, 6.0 + 3.169_273, 0.003));
    }
}
