//! Random tests that fail if the cases of interest are rare.

use std::cell::RefCell;
use std::fmt::Debug;

use proptest::strategy::Strategy;
use proptest::test_runner::{Config, TestRunner};

/// Rare events may be missing in one round by chance, and are missing in all only if they do not occur.
const ROUNDS: usize = 50;

/// Runs `test` on `config.cases` random cases, and in further rounds until its counts are `enough`.
///
/// Fails if a case fails, or if all rounds are not enough.
pub(crate) fn draw_until<S: Strategy, Seen: Debug + Default>(
    config: &Config,
    cases: &S,
    enough: impl Fn(&Seen) -> bool,
    test: impl Fn(S::Value, &mut Seen),
) {
    let seen = RefCell::new(Seen::default());
    for _ in 0..ROUNDS {
        let outcome = TestRunner::new(config.clone()).run(cases, |case| {
            test(case, &mut seen.borrow_mut());
            Ok(())
        });
        outcome.unwrap_or_else(|e| panic!("{e}"));
        if enough(&seen.borrow()) {
            return;
        }
    }
    panic!("{ROUNDS} rounds of {} cases have too few cases of interest: {:?}", config.cases, seen.borrow());
}
