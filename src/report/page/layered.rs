//! Layered drawings of acyclic graphs: nodes in rows, each arc from a row to a lower one. An arc
//! that passes a row runs straight down through its own gap there, so it crosses no other node.
//!
//! An arc that passes a row has a bend there, which is a node without width. So every arc goes from
//! one row to the next. As Sugiyama, Tagawa and Toda (1981) propose, each row is ordered by the mean positions of the
//! neighbours in the row before, downwards and upwards in turns, and adjacent items are exchanged where fewer arcs cross
//! then. Last, items move to the means of their neighbours as far as their distances allow.

/// The height of a node, and the distance between two rows.
pub(super) const HEIGHT: f64 = 44.0;
const BETWEEN_ROWS: f64 = 52.0;
/// The minimum distance between two items of a row, which are nodes and arcs.
const BETWEEN_ITEMS: f64 = 18.0;
/// The margin around the drawing.
const MARGIN: f64 = 2.0;
/// The number of times that the rows are ordered and moved, downwards and upwards.
const TURNS: usize = 8;
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

/// Nodes and bends.
struct Items {
    widths: Vec<f64>,
    rows: Vec<usize>,
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
        let items = self.items();
        let (middles, width) = items.middles();
        let top = |item: usize| MARGIN + items.rows[item] as f64 * (HEIGHT + BETWEEN_ROWS);
        let corners = |chain: &Vec<usize>| {
            let ends = |&item: &usize| [(middles[item], top(item)), (middles[item], top(item) + HEIGHT)];
            let all: Vec<(f64, f64)> = chain.iter().flat_map(ends).collect();
            // An arc starts below its upper node and ends above its lower one.
            all[1..all.len() - 1].to_vec()
        };
        let rows = self.rows.iter().max().map_or(0, |last| last + 1);
        Some(Drawing {
            nodes: (0..self.rows.len()).map(|i| (middles[i] - items.widths[i] / 2.0, top(i))).collect(),
            arcs: items.chains.iter().map(corners).collect(),
            width,
            height: rows as f64 * (HEIGHT + BETWEEN_ROWS) - BETWEEN_ROWS + 2.0 * MARGIN,
        })
    }

    fn items(&self) -> Items {
        let (mut widths, mut rows, mut chains) = (self.widths.clone(), self.rows.clone(), Vec::new());
        for &(high, low) in &self.arcs {
            let first = rows.len();
            rows.extend(self.rows[high] + 1..self.rows[low]);
            widths.resize(rows.len(), 0.0);
            chains.push([high].into_iter().chain(first..rows.len()).chain([low]).collect());
        }
        Items { widths, rows, chains }
    }
}

impl Items {
    /// Returns the middle of each item, and the width of the drawing. Parts that no arc connects
    /// stand side by side.
    fn middles(&self) -> (Vec<f64>, f64) {
        let mut neighbours = vec![[Vec::new(), Vec::new()]; self.rows.len()];
        for pair in self.chains.iter().flat_map(|chain| chain.windows(2)) {
            neighbours[pair[0]][1].push(pair[1]);
            neighbours[pair[1]][0].push(pair[0]);
        }
        let (mut middles, mut end) = (vec![0.0; self.rows.len()], MARGIN - BETWEEN_ITEMS);
        for rows in self.parts(&neighbours) {
            let rows = ordered(rows, &neighbours);
            rows.iter().for_each(|row| self.place(row, |_| None, &mut middles));
            for (side, row) in (0..TURNS).flat_map(|_| turns(rows.len())) {
                let wishes: Vec<Option<f64>> =
                    rows[row].iter().map(|&item| mean(&neighbours[item][side], &middles)).collect();
                self.place(&rows[row], |at| wishes[at], &mut middles);
            }
            let items = || rows.iter().flatten().copied();
            let left = items().map(|i| middles[i] - self.widths[i] / 2.0).fold(f64::INFINITY, f64::min);
            let start = end + BETWEEN_ITEMS - left;
            for item in items() {
                middles[item] += start;
                end = end.max(middles[item] + self.widths[item] / 2.0);
            }
        }
        (middles, end + MARGIN)
    }

    /// Returns the items of each connected part, row by row.
    fn parts(&self, neighbours: &[[Vec<usize>; 2]]) -> Vec<Vec<Vec<usize>>> {
        let (count, mut seen, mut parts) = (self.rows.len(), vec![false; self.rows.len()], Vec::new());
        let last = self.rows.iter().max().map_or(0, |last| last + 1);
        for first in 0..count {
            let (mut rows, mut open) = (vec![Vec::new(); last], vec![first]);
            while let Some(item) = open.pop() {
                if !std::mem::replace(&mut seen[item], true) {
                    rows[self.rows[item]].push(item);
                    open.extend(neighbours[item].iter().flatten());
                }
            }
            rows.retain(|row| !row.is_empty());
            if !rows.is_empty() {
                parts.push(rows);
            }
        }
        parts
    }

    /// Places the items of a row in their order, each as near to its wish as the distances allow (least squares); an
    /// item without a wish wants to stay.
    fn place(&self, row: &[usize], wish_at: impl Fn(usize) -> Option<f64>, middles: &mut [f64]) {
        // Groups of items that touch: the number of items, and the mean of the places where the first one should be.
        let mut groups: Vec<(usize, f64)> = Vec::new();
        let mut offsets = Vec::with_capacity(row.len());
        let mut offset = 0.0;
        for (at, &item) in row.iter().enumerate() {
            if at > 0 {
                offset += (self.widths[row[at - 1]] + self.widths[item]) / 2.0 + BETWEEN_ITEMS;
            }
            offsets.push(offset);
            groups.push((1, wish_at(at).unwrap_or(middles[item]) - offset));
            while let [.., (few, first), (more, second)] = groups[..]
                && first > second
            {
                groups.truncate(groups.len() - 2);
                let sum = first * few as f64 + second * more as f64;
                groups.push((few + more, sum / (few + more) as f64));
            }
        }
        let starts = groups.iter().flat_map(|&(count, start)| std::iter::repeat_n(start, count));
        for ((&item, offset), start) in row.iter().zip(offsets).zip(starts) {
            middles[item] = start + offset;
        }
    }
}

/// Returns the rows downwards, each with the side of its neighbours that are placed before, and then upwards.
fn turns(rows: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..rows).map(|row| (0, row)).chain((0..rows).rev().map(|row| (1, row)))
}

/// Orders the items of each row so that few arcs cross: the best of the orders that the turns give.
fn ordered(mut rows: Vec<Vec<usize>>, neighbours: &[[Vec<usize>; 2]]) -> Vec<Vec<usize>> {
    let mut at = vec![0.0; neighbours.len()];
    let number = |row: &[usize], at: &mut [f64]| {
        row.iter().enumerate().for_each(|(position, &item)| at[item] = position as f64);
    };
    rows.iter().for_each(|row| number(row, &mut at));
    let (mut best, mut least) = (rows.clone(), crossings(&rows, neighbours, &at));
    let count = rows.len();
    for (side, row) in (0..TURNS).flat_map(|_| turns(count)) {
        let mean = |item: &usize| mean(&neighbours[*item][side], &at).unwrap_or(at[*item]);
        rows[row].sort_by(|a, b| mean(a).total_cmp(&mean(b)));
        number(&rows[row], &mut at);
        for left in 1..rows[row].len() {
            let [a, b] = [rows[row][left - 1], rows[row][left]];
            let crossed = |a: usize, b: usize| pair_crossings(&neighbours[a], &neighbours[b], &at);
            if crossed(b, a) < crossed(a, b) {
                rows[row].swap(left - 1, left);
                number(&rows[row], &mut at);
            }
        }
        let found = crossings(&rows, neighbours, &at);
        if found < least {
            (best, least) = (rows.clone(), found);
        }
    }
    best
}

/// Counts the crossings between the arcs of an item and those of the next one in its row.
fn pair_crossings(left: &[Vec<usize>; 2], right: &[Vec<usize>; 2], at: &[f64]) -> usize {
    let of_side = |side: usize| {
        let pairs = left[side].iter().flat_map(|a| right[side].iter().map(move |b| (a, b)));
        pairs.filter(|&(&a, &b)| at[a] > at[b]).count()
    };
    of_side(0) + of_side(1)
}

/// Counts the crossings of arcs between neighbouring rows.
fn crossings(rows: &[Vec<usize>], neighbours: &[[Vec<usize>; 2]], at: &[f64]) -> usize {
    let mut count = 0;
    for row in rows {
        // The lower ends of the arcs of the items so far, sorted.
        let mut ends: Vec<f64> = Vec::new();
        for &item in row {
            let own = neighbours[item][1].iter().map(|&low| at[low]);
            count += own.clone().map(|end| ends.len() - ends.partition_point(|&e| e <= end)).sum::<usize>();
            own.for_each(|end| ends.insert(ends.partition_point(|&e| e <= end), end));
        }
    }
    count
}

/// Returns the mean of the middles of some items; `None` without items.
fn mean(items: &[usize], middles: &[f64]) -> Option<f64> {
    let sum: f64 = items.iter().map(|&item| middles[item]).sum();
    (!items.is_empty()).then(|| sum / items.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_base::random::Draw;

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
        let (count, chain) = (100, 50);
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
