//! Points in a convex hull, exactly.

use meliora_base::exact::Ratio;
use num_traits::{One, Signed, Zero};

/// Returns the greatest t and the weights w ≥ 0 with sum 1 such that w · (b - x) ≥ t for all given points x. If t is at
/// most 0, some mean of the points is at least b in every coordinate; else w separates b from them.
///
/// This is the value of a matrix game with the rows b - x, which J. von Neumann's linear program solves; by the simplex
/// method with the rule of R. Bland (1977), which ends.
pub(crate) fn separated(b: &[Ratio], points: &[Vec<Ratio>]) -> (Ratio, Vec<Ratio>) {
    let (rows, columns) = (b.len(), points.len());
    let Solved { tableau, shift, .. } = solved(b, points);
    let duals = &tableau[rows][columns..columns + rows];
    let sum: Ratio = duals.iter().sum();
    let weights = duals.iter().map(|dual| dual / &sum).collect();
    (sum.recip() - shift, weights)
}

/// Returns the shares of the points in the mean that comes closest to b: at least b, if some mean is.
pub(crate) fn mixed(b: &[Ratio], points: &[Vec<Ratio>]) -> Vec<Ratio> {
    let Solved { tableau, basis, .. } = solved(b, points);
    let mut shares = vec![Ratio::zero(); points.len()];
    for (row, &column) in basis.iter().enumerate().filter(|(_, column)| **column < points.len()) {
        shares[column] = tableau[row].last().cloned().unwrap_or_default();
    }
    let sum: Ratio = shares.iter().sum();
    shares.into_iter().map(|share| share / &sum).collect()
}

/// A solved linear program.
struct Solved {
    tableau: Vec<Vec<Ratio>>,
    /// The variable of each row.
    basis: Vec<usize>,
    /// The constant added to all entries of the game.
    shift: Ratio,
}

/// Solves the game of some points and b.
fn solved(b: &[Ratio], points: &[Vec<Ratio>]) -> Solved {
    let (rows, columns) = (b.len(), points.len());
    let entry = |i: usize, j: usize| &b[i] - &points[j][i];
    let all = (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
    let least = all.map(|(i, j)| entry(i, j)).min().unwrap_or_else(Ratio::zero);
    // All entries are positive then, and so is the value.
    let shift = Ratio::one() - least;
    let mut tableau: Vec<Vec<Ratio>> = (0..rows)
        .map(|i| {
            let own = (0..columns).map(|j| entry(i, j) + &shift);
            let slack = (0..rows).map(|k| if k == i { Ratio::one() } else { Ratio::zero() });
            own.chain(slack).chain([Ratio::one()]).collect()
        })
        .collect();
    let negative = (0..columns).map(|_| -<Ratio as One>::one());
    tableau.push(negative.chain((0..=rows).map(|_| Ratio::zero())).collect());
    let basis = maximise(&mut tableau, columns);
    Solved { tableau, basis, shift }
}

/// Pivots until no entry of the last row is negative; returns the variable of each row.
fn maximise(tableau: &mut [Vec<Ratio>], columns: usize) -> Vec<usize> {
    let (rows, width) = (tableau.len() - 1, tableau[0].len());
    let mut basis: Vec<usize> = (columns..columns + rows).collect();
    while let Some(enter) = (0..width - 1).find(|&at| tableau[rows][at].is_negative()) {
        let ratio = |row: usize| &tableau[row][width - 1] / &tableau[row][enter];
        let candidates = (0..rows).filter(|&row| tableau[row][enter].is_positive());
        let leave = candidates.min_by(|&a, &b| ratio(a).cmp(&ratio(b)).then(basis[a].cmp(&basis[b])));
        // All entries of the first columns are positive, so the maximum is finite.
        let Some(leave) = leave else { break };
        basis[leave] = enter;
        let divisor = tableau[leave][enter].clone();
        tableau[leave].iter_mut().for_each(|x| *x /= &divisor);
        let row = tableau[leave].clone();
        for (_, other) in tableau.iter_mut().enumerate().filter(|(at, _)| *at != leave) {
            let factor = other[enter].clone();
            if !factor.is_zero() {
                other.iter_mut().zip(&row).for_each(|(x, y)| *x -= &factor * y);
            }
        }
    }
    basis
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: [i64; 2]) -> Vec<Ratio> {
        x.map(|x| Ratio::new(x.into(), 4.into())).to_vec()
    }

    #[test]
    fn means_of_points_are_not_separated_from_them() {
        let points = [point([0, 4]), point([4, 0])];
        assert_eq!(separated(&point([2, 2]), &points).0, Ratio::zero());
        assert!(separated(&point([1, 2]), &points).0.is_negative());
        let (t, w) = separated(&point([3, 3]), &points);
        assert_eq!((t, w), (Ratio::new(1.into(), 4.into()), vec![Ratio::new(1.into(), 2.into()); 2]));
        let (_, w) = separated(&point([5, 0]), &points);
        assert_eq!(w, vec![Ratio::one(), Ratio::zero()]);
    }

    #[test]
    fn shares_of_points_have_a_mean_that_reaches_what_can_be_reached() {
        let points = [point([0, 4]), point([4, 0]), point([0, 0])];
        let quarters = |x: [i64; 3]| x.map(|x| Ratio::new(x.into(), 4.into())).to_vec();
        assert_eq!(mixed(&point([1, 3]), &points), quarters([3, 1, 0]));
        let shares = mixed(&point([1, 2]), &points);
        let mean = |at: usize| shares.iter().zip(&points).map(|(share, x)| share * &x[at]).sum::<Ratio>();
        assert!(mean(0) >= point([1, 2])[0] && mean(1) >= point([1, 2])[1]);
        assert_eq!(shares.iter().sum::<Ratio>(), Ratio::one());
    }
}
