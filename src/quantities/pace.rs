//! The pace of an iteration: how its changes shrink, and when it ends.

/// The number of sweeps after which an iteration may be given up because it would take longer.
pub(super) const PATIENCE: usize = 50;
/// This number with little patience, and the greatest number of further sweeps to expect then. Measured on shared
/// coins: elimination for all policies is as fast as this many.
const IMPATIENCE: usize = 32;
const VERY_FEW_SWEEPS: f64 = 100.0;
/// The greatest expected number of sweeps of a component that elimination can solve, and of others.
/// Measured on random walks in the plane, which are left slowly: elimination is as fast as some
/// hundred sweeps.
const FEW_SWEEPS: f64 = 500.0;
const MOST_SWEEPS: f64 = 20_000.0;
/// The number of groups that elimination solves in less than a minute on such walks.
const ELIMINABLE: usize = 50_000;
/// Changes of smaller values are compared with this.
pub(super) const FLOOR: f64 = 1e-6;
/// The number of sweeps that may make an upper bound of a candidate to which the changes lead, and after which
/// the next one is tried.
pub(super) const SOON: usize = 8;

/// The greatest change of a sweep, relative to the values from [`FLOOR`] on.
#[derive(Default)]
pub(super) struct Change(pub(super) f64);

impl Change {
    /// Counts a change of a value.
    #[inline]
    pub(super) fn note(&mut self, by: f64, value: f64) {
        let scale = value.max(FLOOR);
        // Most changes are smaller, and then a product is faster than a quotient.
        if by > self.0 * scale {
            self.0 = by / scale;
        }
    }
}

/// The changes of the last sweeps.
#[derive(Default)]
pub(super) struct Trend {
    /// The last change is the last one.
    changes: [f64; 5],
    sweeps: usize,
    /// The sweep before which no more candidates are tried.
    pause: usize,
}

impl Trend {
    pub(super) fn note(&mut self, change: f64) {
        self.changes.rotate_left(1);
        self.changes[4] = change;
        self.sweeps += 1;
    }

    /// Returns the sum of all further changes, divided by the last one; infinite if they do not shrink.
    pub(super) fn still_to_come(&self) -> f64 {
        let [first, .., last] = self.changes;
        let shrinks = (last / first).sqrt().sqrt();
        if first > 0.0 && shrinks < 1.0 { shrinks / (1.0 - shrinks) } else { f64::INFINITY }
    }

    /// Returns whether upper bounds of this width are expected after the next sweep. After that it is false
    /// for some sweeps.
    pub(super) fn expects(&mut self, width: f64) -> bool {
        let near = self.sweeps >= self.pause && 2.0 * self.still_to_come() * self.changes[4] <= width;
        if near {
            self.pause = self.sweeps + SOON;
        }
        near
    }
}

/// The patience with a method before another one is tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Patience {
    Little,
    Much,
}

/// Decides when an iteration ends: when it is still, or when it would take too long.
pub(super) struct Pace {
    still: f64,
    /// The number of sweeps between two predictions.
    interval: usize,
    /// The greatest number of sweeps to expect.
    most: f64,
    sweeps: usize,
    last: f64,
}

impl Pace {
    pub(super) fn new(still: f64, groups: usize, patience: Patience) -> Self {
        let (interval, most) = match patience {
            Patience::Little => (IMPATIENCE, VERY_FEW_SWEEPS),
            Patience::Much if groups <= ELIMINABLE => (PATIENCE, FEW_SWEEPS),
            Patience::Much => (PATIENCE, MOST_SWEEPS),
        };
        Pace { still: still.max(1e-15), interval, most, sweeps: 0, last: f64::INFINITY }
    }

    /// Returns whether the end is reached (true) or too far away (false); `None` to continue.
    pub(super) fn after(&mut self, change: f64) -> Option<bool> {
        self.sweeps += 1;
        if change <= self.still {
            return Some(true);
        }
        if self.sweeps.is_multiple_of(self.interval) {
            let left = self.interval as f64 * (self.still / change).ln() / (change / self.last).ln();
            // While values arrive for the first time, the change says nothing.
            if change < 0.5 && (left < 0.0 || left > self.most) {
                return Some(false);
            }
            self.last = change;
        }
        None
    }
}
