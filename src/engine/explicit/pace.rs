//! A forecast of the cost of an exploration, by that of its first states.

/// The cost of some states of a model for the explicit engine.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Pace {
    pub(super) explored: u64,
    /// The work of these states, counted in states and their successors.
    pub(super) work: u64,
    pub(super) reached: u64,
    /// The bytes of those reached.
    pub(crate) bytes: u64,
}

impl Pace {
    /// Returns the work for a number of states at this pace.
    pub(crate) fn work(&self, states: u64) -> u64 {
        in_proportion(states, self.work, self.explored)
    }

    /// Returns the bytes for a number of states at this pace.
    pub(crate) fn bytes(&self, states: u64) -> u64 {
        in_proportion(states, self.bytes, self.reached)
    }
}

/// Returns n · cost / of, and n without a measurement.
fn in_proportion(n: u64, cost: u64, of: u64) -> u64 {
    let whole = (u128::from(n) * u128::from(cost)).checked_div(of.into());
    u64::try_from(whole.unwrap_or(n.into())).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::Pace;

    #[test]
    fn the_cost_is_in_proportion_to_the_states() {
        let pace = Pace { explored: 10, work: 45, reached: 20, bytes: 1000 };
        assert_eq!((pace.work(100), pace.bytes(100)), (450, 5000));
        assert_eq!((pace.work(u64::MAX), pace.bytes(u64::MAX)), (u64::MAX, u64::MAX));
        assert_eq!((Pace::default().work(7), Pace::default().bytes(7)), (7, 7));
    }
}
