//! The vertices of a polyhedron, exactly.

use meliora_base::exact::Ratio;
use num_traits::{One, Signed, Zero};

/// A vertex, or a direction in which the polyhedron has no end.
#[derive(Debug)]
struct Corner {
    x: Vec<Ratio>,
    is_vertex: bool,
    /// The half-spaces on whose border it is; the first one contains the directions alone.
    borders: Vec<bool>,
}

/// The points that are in some half-spaces w · x ≤ m with w ≥ 0.
///
/// The double description method (T. Motzkin et al., 1953): a new half-space removes vertices, and each edge that it cuts
/// gives a new one. Two corners have an edge if no third one is on all borders that they share.
#[derive(Debug)]
pub(crate) struct Outer(Vec<Corner>);

impl Outer {
    /// Returns the points that are nowhere above the given one.
    pub(crate) fn below(x: Vec<Ratio>) -> Self {
        let n = x.len();
        let direction = |at: usize| Corner {
            x: (0..n).map(|own| if own == at { -Ratio::one() } else { Ratio::zero() }).collect(),
            is_vertex: false,
            borders: (0..=n).map(|border| border != at + 1).collect(),
        };
        let top = Corner { x, is_vertex: true, borders: (0..=n).map(|border| border > 0).collect() };
        Outer((0..n).map(direction).chain([top]).collect())
    }

    /// Returns a vertex that satisfies a condition.
    pub(crate) fn vertex(&self, condition: impl Fn(&[Ratio]) -> bool) -> Option<&[Ratio]> {
        let mut vertices = self.0.iter().filter(|corner| corner.is_vertex).map(|corner| corner.x.as_slice());
        vertices.find(|x| condition(x))
    }

    /// Keeps the points with w · x ≤ m.
    pub(crate) fn cut(&mut self, weights: &[Ratio], most: &Ratio) {
        let over = |corner: &Corner| {
            let sum: Ratio = corner.x.iter().zip(weights).map(|(x, w)| x * w).sum();
            if corner.is_vertex { sum - most } else { sum }
        };
        let all: Vec<Ratio> = self.0.iter().map(over).collect();
        let mut new = Vec::new();
        for (out, p) in all.iter().enumerate().filter(|(_, p)| p.is_positive()) {
            for (inside, q) in all.iter().enumerate().filter(|(_, q)| q.is_negative()) {
                new.extend(
                    self.edge(out, inside).map(|borders| self.between((out, p), (inside, q), borders)),
                );
            }
        }
        for (corner, over) in self.0.iter_mut().zip(&all) {
            corner.borders.push(over.is_zero());
        }
        let mut over = all.iter();
        self.0.retain(|_| over.next().is_some_and(|over| !over.is_positive()));
        self.0.extend(new);
    }

    /// Returns the borders that two corners share, if they have an edge.
    fn edge(&self, a: usize, b: usize) -> Option<Vec<bool>> {
        let pair = self.0[a].borders.iter().zip(&self.0[b].borders);
        let borders: Vec<bool> = pair.map(|(a, b)| *a && *b).collect();
        let is_on_all =
            |corner: &Corner| borders.iter().zip(&corner.borders).all(|(shared, own)| !shared || *own);
        let third = (0..self.0.len()).any(|other| other != a && other != b && is_on_all(&self.0[other]));
        (!third).then_some(borders)
    }

    /// Returns the point on the border of a half-space, between a vertex outside and a corner inside, by how much each is
    /// over the border.
    fn between(
        &self,
        (out, p): (usize, &Ratio),
        (inside, q): (usize, &Ratio),
        mut borders: Vec<bool>,
    ) -> Corner {
        let (a, b) = (&self.0[out], &self.0[inside]);
        let share = if b.is_vertex { p / (p - q) } else { -(p / q) };
        let kept = if b.is_vertex { Ratio::one() - &share } else { Ratio::one() };
        borders.push(true);
        let x = a.x.iter().zip(&b.x).map(|(x, y)| x * &kept + y * &share).collect();
        Corner { x, is_vertex: true, borders }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: &[i64]) -> Vec<Ratio> {
        x.iter().map(|&x| Ratio::new(x.into(), 4.into())).collect()
    }

    fn vertices(outer: &Outer) -> Vec<Vec<Ratio>> {
        let mut all: Vec<_> = outer.0.iter().filter(|corner| corner.is_vertex).map(|c| c.x.clone()).collect();
        all.sort();
        all
    }

    #[test]
    fn a_half_space_cuts_a_corner_of_a_box() {
        let mut outer = Outer::below(point(&[4, 4, 4]));
        outer.cut(&point(&[4, 4, 4]), &(Ratio::one() + Ratio::one()));
        assert_eq!(vertices(&outer), [point(&[0, 4, 4]), point(&[4, 0, 4]), point(&[4, 4, 0])]);
        outer.cut(&point(&[4, 4, 0]), &Ratio::one());
        assert_eq!(vertices(&outer), [point(&[0, 4, 4]), point(&[4, 0, 4])]);
        assert!(outer.vertex(|x| x[0].is_zero()).is_some() && outer.vertex(|x| x[1] > x[2]).is_none());
    }

    #[test]
    fn an_edge_without_end_is_cut() {
        let mut outer = Outer::below(point(&[4, 4]));
        outer.cut(&point(&[2, 4]), &Ratio::one());
        assert_eq!(vertices(&outer), [point(&[0, 4]), point(&[4, 2])]);
    }
}
