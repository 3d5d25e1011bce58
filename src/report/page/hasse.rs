//! The preference order as a drawing, the most preferred objectives on top.

use std::fmt::Write;

use maud::{Markup, html};

use super::drawing;
use super::layered::{HEIGHT, Layered};
use super::letters::{self, LONGEST};
use meliora_base::escape;
use meliora_model::hasse::Hasse;
use meliora_model::preference::{Empty, Preorder};

/// An order with the texts of its nodes.
pub(super) struct Order {
    pub(super) hasse: Hasse,
    /// The names of each group.
    pub(super) labels: Vec<String>,
    /// The notes below the names.
    pub(super) notes: Vec<Option<String>>,
    /// True if achieving nothing is below every objective.
    pub(super) bottom: bool,
}

/// The height of the box for `nothing`.
const BOTTOM: f64 = 0.6 * HEIGHT;
/// The font sizes of names and notes, as in the style sheet; notes are not bold.
const NAME: f64 = 16.0;
const NOTE: f64 = 0.92 * 11.0;
/// The horizontal padding of a box.
const BESIDE: f64 = 20.0;

impl Order {
    /// Creates an order with the names of its objectives and a note for each group.
    pub(super) fn new(
        preorder: &Preorder,
        empty: Empty,
        names: &[&str],
        note: impl Fn(&[usize]) -> Option<String>,
    ) -> Self {
        let hasse = Hasse::new(preorder);
        let joined = |group: &Vec<usize>| {
            group.iter().filter_map(|&i| names.get(i).copied()).collect::<Vec<_>>().join(" ~ ")
        };
        Order {
            labels: hasse.groups.iter().map(joined).collect(),
            notes: hasse.groups.iter().map(|group| note(group)).collect(),
            bottom: empty != Empty::Incomparable,
            hasse,
        }
    }

    fn width(&self, group: usize) -> f64 {
        let label = letters::width(&letters::shortened(&self.labels[group], LONGEST)) * NAME;
        let note = self.notes[group].as_ref().map_or(0.0, |note| letters::width(note) * NOTE);
        label.max(note).max(40.0) + BESIDE
    }

    /// Returns the groups in layers, with the node for `nothing` last.
    fn layered(&self) -> Layered {
        let (mut rows, mut arcs) = (self.hasse.layers(), self.hasse.covers.clone());
        let mut widths: Vec<f64> = (0..self.labels.len()).map(|group| self.width(group)).collect();
        if self.bottom {
            arcs.extend(self.hasse.lowest().into_iter().map(|group| (group, self.labels.len())));
            rows.push(rows.iter().max().map_or(0, |last| last + 1));
            widths.push(90.0);
        }
        Layered { widths, rows, arcs }
    }
}

/// Draws the order, as a part of a page or `alone`. An order that is too large becomes a sentence.
pub(super) fn svg(order: &Order, alone: bool) -> Markup {
    let layered = order.layered();
    let Some(drawing) = layered.draw() else { return too_large(order, alone) };
    let (width, height) = (drawing.width, drawing.height);
    let groups = order.labels.len();
    html! {
        svg.hasse xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width:.0} {height:.0}"))
            role="img" aria-label="The preference order, the most preferred objectives on top"
            width=[alone.then(|| format!("{width:.0}"))] height=[alone.then(|| format!("{height:.0}"))]
            style=[(!alone).then(|| format!("min-width:{:.0}px;max-width:{:.0}px", 0.7 * width, 1.1 * width))] {
            @if alone { (drawing::style()) (drawing::paper(width as usize + 1, height as usize + 1)) }
            @for (corners, &(_, low)) in drawing.arcs.iter().zip(&layered.arcs) {
                (line(corners, if low < groups { "cover" } else { "cover weak" }))
            }
            @for (node, (&place, &width)) in drawing.nodes.iter().zip(&layered.widths).enumerate() {
                @match order.labels.get(node) {
                    Some(label) => (box_of(place, (width, HEIGHT), label, order.notes[node].as_deref(), "node")),
                    None => (box_of(place, (width, BOTTOM), "nothing", None, "node bottom")),
                }
            }
        }
    }
}

fn too_large(order: &Order, alone: bool) -> Markup {
    let text = format!("This order of {} objectives is too large to draw.", order.labels.len());
    html! {
        @if alone {
            svg.hasse xmlns="http://www.w3.org/2000/svg" viewBox="0 0 640 40" {
                (drawing::style()) (drawing::paper(640, 40)) text.small x="4" y="24" { (text) }
            }
        } @else {
            p { (text) " Use " code { "--format dot" } " and a program that draws graphs." }
        }
    }
}

fn line(corners: &[(f64, f64)], class: &str) -> Markup {
    let points = corners.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ");
    html! { polyline class=(class) points=(points) {} }
}

fn box_of(
    (x, y): (f64, f64),
    (width, height): (f64, f64),
    label: &str,
    note: Option<&str>,
    class: &str,
) -> Markup {
    let shown = letters::shortened(label, LONGEST);
    let middle = if note.is_some() { 19.0 } else { height / 2.0 + 5.0 };
    html! {
        g class=(class) transform=(format!("translate({x:.1},{y:.1})")) {
            rect width=(format!("{width:.1}")) height=(format!("{height:.1}")) rx="7" {}
            @if shown != label { title { (label) } }
            text x=(format!("{:.1}", width / 2.0)) y=(format!("{middle:.1}")) { (shown) }
            @if let Some(note) = note {
                text.note x=(format!("{:.1}", width / 2.0)) y="35" { (note) }
            }
        }
    }
}

/// Returns the order in the DOT language: an arc from each group to those directly below it.
pub(super) fn dot(order: &Order) -> String {
    let mut out = String::from("digraph preferences {\n  rankdir=TB;\n  node [shape=box, style=rounded];\n");
    out.push_str("  edge [arrowhead=none];\n");
    for (index, label) in order.labels.iter().enumerate() {
        let _ = writeln!(out, "  g{index} [label={}];", escape::dot(label));
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
