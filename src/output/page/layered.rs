//! Layered drawings of acyclic graphs: nodes in rows, each arc from a row to a lower one. An arc
//! that passes a row runs straight down through its own gap there, so it crosses no other node.
//!
//! After Sugiyama, Tagawa and Toda, "Methods for visual understanding of hierarchical system
//! structures" (1981): add a bend in each row that an arc passes, order the rows to reduce
//! crossings, then compute positions.

/// The height of a node, and the distance between two rows.
pub(super) const HEIGHT: f64 = 44.0;
const BETWEEN_ROWS: f64 = 52.0;
/// The minimum distance between two nodes, and between an arc and its neighbours.
const BETWEEN_NODES: f64 = 18.0;
const BESIDE_ARCS: f64 = 12.0;
/// The margin around the drawing.
const MARGIN: f64 = 2.0;
/// Maximum number of nodes and bends; larger drawings are unreadable and slow to compute.
const MOST_ITEMS: usize = 10_000;

/// A graph to draw.
pub(super) struct Layered {
    /// The width of each node.
    pub(super) widths: Vec<f64>,
    /// The row of each node, from the top.
    pub(super) rows: Vec<usize>,
    /// The arcs, each from a node to one in a lower row.
    pub(super) arcs: Vec<(usize, usize)>,
}

/// The positions in a drawing.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Drawing {
    /// The upper left corner of each node.
    pub(super) nodes: Vec<(f64, f64)>,
    /// The corners of each arc, from below its upper node to above its lower one.
    pub(super) arcs: Vec<Vec<(f64, f64)>>,
    pub(super) width: f64,
    pub(super) height: f64,
}

/// Nodes and bends, in rows.
struct Items {
    widths: Vec<f64>,
    is_bend: Vec<bool>,
    above: Vec<Vec<usize>>,
    below: Vec<Vec<usize>>,
    rows: Vec<Vec<usize>>,
    /// For each arc its upper node, its bends and its lower node.
    chains: Vec<Vec<usize>>,
}

impl Layered {
    /// Draws the graph; returns `None` if it is too large.
    pub(super) fn draw(&self) -> Option<Drawing> {
        let bends: usize = self.arcs.iter().map(|&(high, low)| self.rows[low] - self.rows[high] - 1).sum();
        if self.widths.len() + bends > MOST_ITEMS {
            return None;
        }
        let mut items = self.items();
        items.sort_rows();
        let middles = items.middles();
        Some(self.drawing(&items, &middles))
    }

    fn items(&self) -> Items {
        let count = self.widths.len();
        let mut items = Items {
            widths: self.widths.clone(),
            is_bend: vec![false; count],
            above: vec![Vec::new(); count],
            below: vec![Vec::new(); count],
            rows: vec![Vec::new(); self.rows.iter().max().map_or(0, |last| last + 1)],
            chains: Vec::new(),
        };
        self.rows.iter().enumerate().for_each(|(node, &row)| items.rows[row].push(node));
        for &(high, low) in &self.arcs {
            let bends = (self.rows[high] + 1..self.rows[low]).map(|row| items.bend(row));
            let chain: Vec<usize> =
                [high].into_iter().chain(bends.collect::<Vec<_>>()).chain([low]).collect();
            for pair in chain.windows(2) {
                items.below[pair[0]].push(pair[1]);
                items.above[pair[1]].push(pair[0]);
            }
            items.chains.push(chain);
        }
        items
    }

    fn drawing(&self, items: &Items, middles: &[f64]) -> Drawing {
        let left = |item: usize| middles[item] - items.widths[item] / 2.0;
        let right = |item: usize| middles[item] + items.widths[item] / 2.0;
        let all = || 0..items.widths.len();
        let start = all().map(left).fold(f64::INFINITY, f64::min).min(0.0) - MARGIN;
        let end = all().map(right).fold(0.0, f64::max) + MARGIN;
        let mut tops = vec![0.0; items.widths.len()];
        for (row, members) in items.rows.iter().enumerate() {
            members.iter().for_each(|&item| tops[item] = MARGIN + row as f64 * (HEIGHT + BETWEEN_ROWS));
        }
        let corners = |chain: &Vec<usize>| {
            let mut corners = Vec::with_capacity(2 * chain.len());
            for (index, &item) in chain.iter().enumerate() {
                let x = middles[item] - start;
                if index > 0 {
                    corners.push((x, tops[item]));
                }
                if index + 1 < chain.len() {
                    corners.push((x, tops[item] + HEIGHT));
                }
            }
            corners
        };
        Drawing {
            nodes: (0..self.widths.len()).map(|node| (left(node) - start, tops[node])).collect(),
            arcs: items.chains.iter().map(corners).collect(),
            width: end - start,
            height: items.rows.len() as f64 * (HEIGHT + BETWEEN_ROWS) - BETWEEN_ROWS + 2.0 * MARGIN,
        }
    }
}

impl Items {
    fn bend(&mut self, row: usize) -> usize {
        let item = self.widths.len();
        self.widths.push(0.0);
        self.is_bend.push(true);
        self.above.push(Vec::new());
        self.below.push(Vec::new());
        self.rows[row].push(item);
        item
    }

    /// Orders each row by the average position of the neighbours above, then below, and again.
    fn sort_rows(&mut self) {
        for round in 0..8 {
            let mut position = vec![0.0; self.widths.len()];
            for row in &self.rows {
                for (index, &item) in row.iter().enumerate() {
                    position[item] = (index as f64 + 0.5) / row.len() as f64;
                }
            }
            let neighbours = if round % 2 == 0 { &self.above } else { &self.below };
            for row in &mut self.rows {
                let key = |item: &usize| average(&neighbours[*item], &position).unwrap_or(position[*item]);
                row.sort_by(|a, b| key(a).total_cmp(&key(b)));
            }
        }
    }

    /// Returns the middle of each item, as close to its neighbours as the order in its row allows.
    fn middles(&self) -> Vec<f64> {
        let mut middles = vec![0.0; self.widths.len()];
        let neighbours: Vec<Vec<usize>> =
            self.above.iter().zip(&self.below).map(|(above, below)| [&above[..], below].concat()).collect();
        for round in 0..32 {
            for index in 0..self.rows.len() {
                let row = &self.rows[if round % 2 == 0 { index } else { self.rows.len() - 1 - index }];
                let wish = |&item: &usize| average(&neighbours[item], &middles).unwrap_or(middles[item]);
                let wishes: Vec<f64> = row.iter().map(wish).collect();
                for (&item, middle) in row.iter().zip(self.apart(row, &wishes)) {
                    middles[item] = middle;
                }
            }
        }
        middles
    }

    /// Returns the middles of a row in its order, with the minimum distances and the least sum of
    /// squared distances to the wishes. Items that would overlap form a block.
    fn apart(&self, row: &[usize], wishes: &[f64]) -> Vec<f64> {
        let mut offsets = Vec::with_capacity(row.len());
        let mut offset = 0.0;
        for (index, &item) in row.iter().enumerate() {
            if let Some(before) = index.checked_sub(1).map(|i| row[i]) {
                let bends = self.is_bend[before] || self.is_bend[item];
                let gap = if bends { BESIDE_ARCS } else { BETWEEN_NODES };
                offset += (self.widths[before] + self.widths[item]) / 2.0 + gap;
            }
            offsets.push(offset);
        }
        // The blocks: the sum of the wishes minus the offsets of the members, and their number.
        let mut blocks: Vec<(f64, usize)> = Vec::new();
        for (wish, offset) in wishes.iter().zip(&offsets) {
            let (mut sum, mut count) = (wish - offset, 1);
            while let Some(&(before, members)) = blocks.last()
                && before / members as f64 >= sum / count as f64
            {
                (sum, count) = (sum + before, count + members);
                blocks.pop();
            }
            blocks.push((sum, count));
        }
        let starts = blocks.into_iter().flat_map(|(sum, count)| vec![sum / count as f64; count]);
        starts.zip(offsets).map(|(start, offset)| start + offset).collect()
    }
}

fn average(items: &[usize], values: &[f64]) -> Option<f64> {
    (!items.is_empty()).then(|| items.iter().map(|&i| values[i]).sum::<f64>() / items.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Draw;

    /// Returns whether a straight line passes through the inside of a rectangle (Liang and Barsky).
    fn passes(line: [(f64, f64); 2], corner: (f64, f64), width: f64) -> bool {
        let [(x, y), (x2, y2)] = line;
        let (dx, dy) = (x2 - x, y2 - y);
        let (mut enter, mut leave) = (0.0f64, 1.0f64);
        for (step, distance) in [
            (-dx, x - corner.0),
            (dx, corner.0 + width - x),
            (-dy, y - corner.1),
            (dy, corner.1 + HEIGHT - y),
        ] {
            match step {
                0.0 if distance <= 0.0 => return false,
                0.0 => {}
                s if s < 0.0 => enter = enter.max(distance / s),
                s => leave = leave.min(distance / s),
            }
        }
        enter + 1e-9 < leave
    }

    /// Checks that nodes keep apart and that no arc passes through a node.
    fn check(graph: &Layered) {
        let drawing = graph.draw().expect("it is small");
        let nodes = || drawing.nodes.iter().zip(&graph.widths).enumerate();
        for (a, (&(x, y), &width)) in nodes() {
            assert!(x >= 0.0 && x + width <= drawing.width && y + HEIGHT <= drawing.height);
            for (b, (&(x2, y2), _)) in nodes() {
                assert!(a == b || y != y2 || x2 >= x + width + 11.0 || x2 < x, "nodes {a} and {b}");
            }
        }
        for (arc, ends) in drawing.arcs.iter().zip(&graph.arcs) {
            for line in arc.windows(2) {
                for (node, (&corner, &width)) in nodes() {
                    // An arc only touches the edges of its end nodes.
                    assert!(!passes([line[0], line[1]], corner, width), "{ends:?} passes {node}: {line:?}");
                }
            }
        }
    }

    #[test]
    fn lines_that_touch_an_edge_do_not_pass() {
        assert!(passes([(0.0, 0.0), (10.0, 100.0)], (0.0, 10.0), 20.0));
        assert!(!passes([(10.0, 0.0), (10.0, 10.0)], (0.0, 10.0), 20.0));
        assert!(!passes([(0.0, 0.0), (0.0, 100.0)], (0.0, 10.0), 20.0));
    }

    #[test]
    fn an_arc_across_rows_goes_round_what_is_between() {
        // Best > Good > Fair > Poor, Other > Poor
        let graph = Layered {
            widths: vec![60.0; 5],
            rows: vec![0, 1, 2, 3, 0],
            arcs: vec![(0, 1), (1, 2), (2, 3), (4, 3)],
        };
        check(&graph);
        assert_eq!(graph.draw().expect("it is small").arcs[3].len(), 6);
    }

    #[test]
    fn no_arc_passes_through_a_node() {
        for seed in 0..300 {
            let mut draw = Draw::numbered(seed, 1);
            let count = 1 + draw.below(14);
            let widths = (0..count).map(|_| 40.0 + draw.below(150) as f64).collect();
            let share = 1 + draw.below(6);
            let mut arcs = Vec::new();
            for high in 0..count {
                arcs.extend((high + 1..count).filter(|_| draw.below(7) < share).map(|low| (high, low)));
            }
            let mut rows = vec![0; count];
            arcs.iter().for_each(|&(high, low)| rows[low] = rows[low].max(rows[high] + 1));
            check(&Layered { widths, rows, arcs });
        }
    }

    #[test]
    fn what_is_too_large_is_not_drawn() {
        let (count, chain) = (200, 100);
        let mut arcs: Vec<(usize, usize)> = (1..chain).map(|low| (low - 1, low)).collect();
        arcs.extend((chain..count).map(|high| (high, chain - 1)));
        let rows = (0..count).map(|node| if node < chain { node } else { 0 }).collect();
        assert_eq!(
            Layered { widths: vec![40.0; count], rows, arcs: arcs.clone() }.draw().map(|d| d.arcs.len()),
            Some(arcs.len())
        );
        let rows = (0..count).map(|node| if node < chain { 100 * node } else { 0 }).collect();
        assert_eq!(Layered { widths: vec![40.0; count], rows, arcs }.draw(), None);
    }
}
