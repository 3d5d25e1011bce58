//! The Hasse diagram of a preorder on objectives.

use super::preference::{Comparison, Preorder};

/// The transitive reduction of a preorder, on groups of indifferent objectives.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Hasse {
    /// The groups of indifferent objectives, as positions of objectives, in the order of
    /// declaration.
    pub groups: Vec<Vec<usize>>,
    /// The pairs (x, y) of positions of groups with x > y and no group between them.
    pub covers: Vec<(usize, usize)>,
}

impl Hasse {
    /// Computes the diagram of a preorder: the transitive reduction of > on the classes of ~.
    ///
    /// Cost: cubic in the number of groups.
    pub fn new(order: &Preorder) -> Self {
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for x in 0..order.len() {
            match groups.iter_mut().find(|g| order.compare(g[0], x) == Comparison::Indifferent) {
                Some(group) => group.push(x),
                None => groups.push(vec![x]),
            }
        }
        let above = |x: usize, y: usize| order.strictly(groups[x][0], groups[y][0]);
        let count = groups.len();
        let mut covers = Vec::new();
        for x in 0..count {
            for y in (0..count).filter(|&y| above(x, y)) {
                if !(0..count).any(|z| above(x, z) && above(z, y)) {
                    covers.push((x, y));
                }
            }
        }
        Hasse { groups, covers }
    }

    /// Returns the layer of each group: 0 if no group is preferred to it, else 1 plus the greatest
    /// layer of the groups above it.
    pub fn layers(&self) -> Vec<usize> {
        let mut layers = vec![0; self.groups.len()];
        // A longest path has fewer steps than there are groups.
        for _ in 0..self.groups.len() {
            for &(high, low) in &self.covers {
                layers[low] = layers[low].max(layers[high] + 1);
            }
        }
        layers
    }

    /// Returns the minimal groups: no other group is below them.
    pub fn lowest(&self) -> Vec<usize> {
        (0..self.groups.len()).filter(|&g| self.covers.iter().all(|&(high, _)| high != g)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::preference::{Relation, Statement};
    use super::*;

    fn hasse(n: usize, statements: &[(usize, Relation, usize)]) -> Hasse {
        let statement = |&(left, relation, right): &_| Statement { left, relation, right };
        let statements: Vec<Statement> = statements.iter().map(statement).collect();
        Hasse::new(&Preorder::new(n, &statements).unwrap())
    }

    #[test]
    fn a_preference_that_follows_from_others_is_not_drawn() {
        use Relation::Strict;
        let found = hasse(3, &[(2, Strict, 1), (1, Strict, 0), (2, Strict, 0)]);
        assert_eq!(found.covers, [(1, 0), (2, 1)]);
        assert_eq!(found.layers(), [2, 1, 0]);
        assert_eq!(found.lowest(), [0]);
    }

    #[test]
    fn indifferent_objectives_share_a_node() {
        use Relation::{Indifferent, Strict, Weak};
        let found = hasse(5, &[(0, Indifferent, 3), (3, Strict, 1), (1, Weak, 2), (2, Weak, 1)]);
        assert_eq!(found.groups, [vec![0, 3], vec![1, 2], vec![4]]);
        assert_eq!(found.covers, [(0, 1)]);
        assert_eq!(found.lowest(), [1, 2]);
    }
}
