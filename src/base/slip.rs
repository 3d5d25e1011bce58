//! Detection of misspelt words.

/// Returns true if two names differ only in case, by one wrong, missing or extra letter, or by two
/// adjacent letters in the wrong order.
pub fn is_slip(a: &str, b: &str) -> bool {
    a.eq_ignore_ascii_case(b) || a.len().min(b.len()) >= 3 && strsim::osa_distance(a, b) <= 1
}

/// Returns the first name, in alphabetical order, of which another one is a likely misspelling.
pub fn meant<'n>(known: impl IntoIterator<Item = &'n str>, name: &str) -> Option<&'n str> {
    known.into_iter().filter(|known| is_slip(known, name)).min()
}

#[cfg(test)]
mod tests {
    use super::is_slip;

    #[test]
    fn words_with_one_slip_of_the_hand_are_alike() {
        for (a, b) in [
            ("count", "Count"),
            ("count", "coutn"),
            ("count", "cont"),
            ("count", "counts"),
            ("count", "coumt"),
        ] {
            assert!(is_slip(a, b) && is_slip(b, a), "{a} {b}");
        }
        for (a, b) in [("count", "cuont1"), ("x", "y"), ("s1", "s2"), ("abc", "xyz"), ("count", "c")] {
            assert!(!is_slip(a, b) && !is_slip(b, a), "{a} {b}");
        }
    }
}
