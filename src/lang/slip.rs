//! Detection of misspelt words.

/// Returns true if two names differ only in case, by one wrong, missing or extra letter, or by two
/// adjacent letters in the wrong order.
pub(super) fn is_slip(a: &str, b: &str) -> bool {
    if a.eq_ignore_ascii_case(b) {
        return true;
    }
    let (long, short) =
        if a.len() >= b.len() { (a.as_bytes(), b.as_bytes()) } else { (b.as_bytes(), a.as_bytes()) };
    if short.len() < 3 || long.len() - short.len() > 1 {
        return false;
    }
    let prefix = long.iter().zip(short).take_while(|(x, y)| x == y).count();
    let rest = &short[prefix..];
    if let ([a, b, end @ ..], [c, d, tail @ ..]) = (&long[prefix..], rest)
        && (a, b, end) == (d, c, tail)
    {
        return true;
    }
    long[prefix + 1..] == rest[usize::from(long.len() == short.len())..]
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
