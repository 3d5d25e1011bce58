//! The amount of exhaustive and random tests: a share by default, and all with `MELIORA_TESTS=long` in the environment.

use proptest::prelude::ProptestConfig;

/// By default, one of this many cases is tested.
const SHARE: usize = 10;

/// Returns whether all cases are wanted.
pub fn is_long() -> bool {
    std::env::var_os("MELIORA_TESTS").is_some_and(|amount| amount == "long")
}

/// Returns the number of cases to test of `all`, at least 1.
pub fn share(all: usize) -> usize {
    if is_long() { all } else { all.div_ceil(SHARE) }
}

/// Returns whether the case with a number, counted from 0, is tested.
pub fn takes(number: usize) -> bool {
    is_long() || number.is_multiple_of(SHARE)
}

/// Returns whether the case with a number is tested, where one of `of` of a short list is.
pub fn takes_one_of(of: usize, number: usize) -> bool {
    is_long() || number.is_multiple_of(of)
}

/// The settings of a test with `all` random cases.
pub fn random(all: u32) -> ProptestConfig {
    let some = u32::try_from(share(all as usize)).unwrap_or(all);
    ProptestConfig::with_cases(some)
}
