//! Combinations of one item from each of several lists.

/// Returns an upper bound on the number of combinations of all lists, and of the first ones; it is
/// exact if no list is empty.
pub(crate) fn product<T>(lists: &[Vec<T>]) -> usize {
    lists.iter().fold(1, |all, list| list.len().max(1).saturating_mul(all))
}

/// Returns all combinations; the last list varies fastest.
pub(crate) fn combinations<T: Copy>(lists: impl Iterator<Item = Vec<T>>) -> Vec<Vec<T>> {
    lists.fold(vec![Vec::new()], |all, list| {
        let longer = |c: &Vec<T>| list.iter().map(|&x| [c.as_slice(), &[x]].concat()).collect::<Vec<_>>();
        all.iter().flat_map(longer).collect()
    })
}
