//! Temporal formulas in games.

use super::{at, scratch};

#[test]
fn a_formula_that_is_refused_is_shown_with_both_parts() {
    let property = "<<us>> P>=1 [ (G F x=2) & (F G x<2) & F x=1 ]";
    let refused = at(&scratch(), &["reach", "@g.prism", "--property", property]).expect(3);
    for expected in [
        "recurrence: something",
        "persistence: something",
        "a finite part of a path decides",
        "G F x=2",
        "F G x<2",
    ] {
        refused.says(expected);
    }
}
