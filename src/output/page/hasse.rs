//! The preference order as a drawing: what is preferred stands above.

use std::fmt::Write;

use maud::{Markup, html};

use super::map;
use crate::model::hasse::Hasse;

/// An order with what its nodes say.
pub(super) struct Order {
    pub(super) hasse: Hasse,
    /// The names of each group.
    pub(super) labels: Vec<String>,
    /// What stands below the names.
    pub(super) notes: Vec<Option<String>>,
    /// Whether achieving nothing stands below everything.
    pub(super) bottom: bool,
}

const HEIGHT: f64 = 44.0;
const BETWEEN_ROWS: f64 = 52.0;
const BETWEEN_NODES: f64 = 18.0;
/// What a letter takes, more or less, in the two sizes of text.
const LETTER: f64 = 9.5;
const SMALL_LETTER: f64 = 6.2;

/// A node in its place.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Place {
    x: f64,
    y: f64,
    width: f64,
}

impl Order {
    /// The groups layer by layer, in an order in which lines cross little: each at the average of its
    /// neighbours in the layer above, then below, and again.
    fn rows(&self) -> Vec<Vec<usize>> {
        let layers = self.hasse.layers();
        let count = layers.iter().max().map_or(0, |most| most + 1);
        let mut rows: Vec<Vec<usize>> = vec![Vec::new(); count];
        layers.iter().enumerate().for_each(|(group, &layer)| rows[layer].push(group));
        for round in 0..8 {
            let position = self.positions(&rows);
            for row in &mut rows {
                let key = |group: &usize| self.middle(*group, round % 2 == 0, &position);
                row.sort_by(|a, b| key(a).total_cmp(&key(b)));
            }
        }
        rows
    }

    fn positions(&self, rows: &[Vec<usize>]) -> Vec<f64> {
        let mut positions = vec![0.0; self.labels.len()];
        for row in rows {
            for (index, &group) in row.iter().enumerate() {
                positions[group] = (index as f64 + 0.5) / row.len() as f64;
            }
        }
        positions
    }

    /// The average position of the neighbours above (or below); its own where there are none.
    fn middle(&self, group: usize, above: bool, positions: &[f64]) -> f64 {
        let pairs = self.hasse.covers.iter();
        let neighbours: Vec<f64> = pairs
            .filter_map(|&(high, low)| match above {
                true => (low == group).then_some(positions[high]),
                false => (high == group).then_some(positions[low]),
            })
            .collect();
        match neighbours.len() {
            0 => positions[group],
            n => neighbours.iter().sum::<f64>() / n as f64,
        }
    }

    fn width(&self, group: usize) -> f64 {
        let label = self.labels[group].chars().count() as f64 * LETTER;
        let note = self.notes[group].as_ref().map_or(0, |n| n.chars().count()) as f64 * SMALL_LETTER;
        label.max(note).max(40.0) + 18.0
    }

    /// The places of the groups, and the size of the drawing without the bottom.
    fn places(&self) -> (Vec<Place>, f64, f64) {
        let rows = self.rows();
        let span = |row: &Vec<usize>| {
            row.iter().map(|&g| self.width(g)).sum::<f64>() + BETWEEN_NODES * (row.len() as f64 - 1.0)
        };
        let widest = rows.iter().map(span).fold(120.0, f64::max);
        let mut places = vec![Place { x: 0.0, y: 0.0, width: 0.0 }; self.labels.len()];
        for (layer, row) in rows.iter().enumerate() {
            let y = layer as f64 * (HEIGHT + BETWEEN_ROWS) + 2.0;
            // Narrow rows are spread out, so that lines between layers are less steep.
            let extra = (widest - span(row)) / (row.len() as f64 + 1.0);
            let mut x = 2.0 + extra;
            for &group in row {
                let width = self.width(group);
                places[group] = Place { x, y, width };
                x += width + BETWEEN_NODES + extra;
            }
        }
        let height = rows.len() as f64 * (HEIGHT + BETWEEN_ROWS) - BETWEEN_ROWS + 4.0;
        (places, widest + 4.0, height)
    }
}

/// The drawing, as a part of a page or `alone`.
pub(super) fn svg(order: &Order, alone: bool) -> Markup {
    let (places, width, mut height) = order.places();
    let bottom = order.bottom.then(|| {
        let place = Place { x: width / 2.0 - 45.0, y: height + BETWEEN_ROWS - 4.0, width: 90.0 };
        height += BETWEEN_ROWS + HEIGHT * 0.7;
        place
    });
    html! {
        svg.hasse xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width:.0} {height:.0}"))
            role="img" aria-label="The preference order: what is preferred stands above"
            style=(format!("max-width:{:.0}px", width * 1.25)) {
            @if alone { (map::style()) (map::paper(width as usize + 1, height as usize + 1)) }
            @for &(high, low) in &order.hasse.covers {
                (line(places[high], places[low], HEIGHT, "cover"))
            }
            @if let Some(bottom) = bottom {
                @for group in order.hasse.lowest() { (line(places[group], bottom, HEIGHT, "cover weak")) }
                (node(bottom, HEIGHT * 0.6, "nothing", None, "node bottom"))
            }
            @for ((place, label), note) in places.iter().zip(&order.labels).zip(&order.notes) {
                (node(*place, HEIGHT, label, note.as_deref(), "node"))
            }
        }
    }
}

fn line(from: Place, to: Place, height: f64, class: &str) -> Markup {
    let (x1, y1) = (from.x + from.width / 2.0, from.y + height);
    let (x2, y2) = (to.x + to.width / 2.0, to.y);
    html! {
        line class=(class) x1=(format!("{x1:.1}")) y1=(format!("{y1:.1}"))
            x2=(format!("{x2:.1}")) y2=(format!("{y2:.1}")) {}
    }
}

fn node(place: Place, height: f64, label: &str, note: Option<&str>, class: &str) -> Markup {
    let Place { x, y, width } = place;
    let middle = if note.is_some() { 19.0 } else { height / 2.0 + 5.0 };
    html! {
        g class=(class) transform=(format!("translate({x:.1},{y:.1})")) {
            rect width=(format!("{width:.1}")) height=(format!("{height:.1}")) rx="7" {}
            text x=(format!("{:.1}", width / 2.0)) y=(format!("{middle:.1}")) { (label) }
            @if let Some(note) = note {
                text.note x=(format!("{:.1}", width / 2.0)) y="35" { (note) }
            }
        }
    }
}

/// The order in the language DOT: an arc from each group to those right below it.
pub(super) fn dot(order: &Order) -> String {
    let mut out = String::from("digraph preferences {\n  rankdir=TB;\n  node [shape=box, style=rounded];\n");
    out.push_str("  edge [arrowhead=none];\n");
    for (index, label) in order.labels.iter().enumerate() {
        let _ = writeln!(out, "  g{index} [label=\"{}\"];", label.escape_default());
    }
    for (high, low) in &order.hasse.covers {
        let _ = writeln!(out, "  g{high} -> g{low};");
    }
    if order.bottom {
        let _ = writeln!(out, "  nothing [style=\"rounded,dashed\"];");
        for group in order.hasse.lowest() {
            let _ = writeln!(out, "  g{group} -> nothing [style=dashed];");
        }
    }
    out.push_str("}\n");
    out
}
