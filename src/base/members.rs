//! The assignments that satisfy a function, enumerated on demand.

use num_bigint::BigUint;

use super::diagram::{Diagram, Edge};

/// The satisfying assignments of a function to all variables of a diagram. They are numbered from 0
/// in lexicographic order, the first variable first and false before true.
pub struct Members<'d> {
    diagram: &'d Diagram,
    edge: Edge,
    counts: Vec<BigUint>,
}

impl<'d> Members<'d> {
    /// Prepares the members of a function. Cost: linear in its nodes.
    pub fn new(diagram: &'d Diagram, edge: Edge) -> Self {
        Members { diagram, edge, counts: diagram.counts(edge) }
    }

    /// Returns the number of members.
    pub fn count(&self) -> BigUint {
        self.diagram.over(&self.counts, self.edge, 0)
    }

    /// Returns the member with this number as one value per variable; none past the last member.
    /// Cost: linear in the number of variables.
    pub fn nth(&self, number: &BigUint) -> Option<Vec<bool>> {
        if *number >= self.count() {
            return None;
        }
        let (mut edge, mut left) = (self.edge, number.clone());
        let levels = 0..self.diagram.variables.len() as u32;
        let value = |level: u32| {
            let (then, otherwise) = self.diagram.cofactors(edge, level);
            let clear = self.diagram.over(&self.counts, otherwise, level + 1);
            let set = left >= clear;
            if set {
                left -= clear;
            }
            edge = if set { then } else { otherwise };
            set
        };
        Some(levels.map(value).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_are_all_satisfying_assignments_in_order() {
        let mut diagram =
            Diagram { variables: ["a", "b", "c"].map(str::to_owned).into(), ..Diagram::default() };
        // a ? !c : c, over which b is free.
        let c = diagram.push(2, Edge::TRUE, Edge::FALSE).unwrap();
        let root = diagram.push(0, c.complement(), c).unwrap();
        let members = Members::new(&diagram, root);
        assert_eq!(members.count(), BigUint::from(4u32));
        let all: Vec<Vec<bool>> = (0..5u32).map_while(|n| members.nth(&n.into())).collect();
        let bits = [[0, 0, 1], [0, 1, 1], [1, 0, 0], [1, 1, 0]];
        assert_eq!(all, bits.map(|b| b.map(|bit| bit == 1).to_vec()));
        assert_eq!(Members::new(&diagram, Edge::FALSE).nth(&BigUint::ZERO), None);
    }
}
