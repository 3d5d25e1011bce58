//! The sizes of maps, and the values along their axes.

use maud::{Markup, html};

use super::letters::{shortened, width};
use meliora_export::projections::Projections;
use meliora_model::VarId;

/// The font size of the values in pixels, and the distance between two of them.
const FONT: f64 = 12.0;
const BETWEEN: f64 = 10.0;
/// The longest text of a value.
const LONGEST: usize = 16;
/// The width of the page and of the gaps between maps, as in the style sheet, and the width of a map on
/// a phone.
const PAGE: f64 = 1312.0;
const GAP: f64 = 19.2;
const PHONE: f64 = 390.0;
/// The minimum width of a map next to others, and the least and the usual height of the windows for it.
const LEAST: f64 = 320.0;
const LOW: f64 = 320.0;
const HIGH: f64 = 516.0;
/// A map needs its own row if its cells would be smaller next to others, unless it is higher than this.
const WIDE: f64 = 220.0;
/// The side of the largest cells on a page.
const LARGEST: f64 = 64.0;
/// Cells with a smaller side show a single mark instead of a number.
pub(super) const MIDDLE: f64 = 30.0;
/// Cells with a smaller side show colours and a dot for a mark.
pub(super) const TINY: f64 = 14.0;

/// The sizes of a map on the page, in pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sizes {
    /// The width of the row values.
    pub(super) left: f64,
    /// The minimum width of the map.
    pub(super) least: f64,
    /// The side of a cell on a screen, and on a phone.
    pub(super) side: f64,
    phone: f64,
}

impl Sizes {
    pub(super) fn new(projections: &Projections) -> Self {
        let (rows, columns) = (projections.rows().len() as f64, projections.columns().len() as f64);
        let left = left(projections);
        let least = (columns * MIDDLE.min(WIDE / rows) + left).clamp(LEAST, PAGE);
        let beside = ((PAGE + GAP) / (least + GAP)).floor();
        let own = (PAGE + GAP) / beside - GAP;
        let side = |width: f64, height: f64| LARGEST.min((width - left) / columns).min(height / rows);
        Sizes { left, least, side: side(own, HIGH), phone: side(PHONE, LOW) }
    }

    /// Returns the sizes of a separate picture.
    pub(super) fn alone(projections: &Projections) -> Self {
        let most = projections.rows().len().max(projections.columns().len());
        let side = (640 / most).clamp(6, 40) as f64;
        Sizes { left: left(projections), least: LEAST, side, phone: side }
    }
}

/// Returns the style of cells with such sides: the classes that hide what would be too small to read.
/// `size` is the font size of the smallest texts.
pub(super) fn detail(side: f64, size: usize) -> String {
    let all = [("middle", MIDDLE), ("tiny", TINY), ("colors", readable(size))];
    all.into_iter().filter(|(_, least)| side < *least).map(|(class, _)| class).collect::<Vec<_>>().join(" ")
}

/// Returns the font size of a text in a cell, from 0 for short texts to 4 for long ones.
pub(super) fn size(text: &str) -> usize {
    let wide = width(text);
    [1.6, 2.2, 2.9, 3.6].iter().filter(|most| wide > **most).count()
}

/// Returns the least side of a cell in which texts of a font size are readable.
pub(super) fn readable(size: usize) -> f64 {
    [16.0, 22.0, 26.0, 32.0, 36.0][size.min(4)]
}

/// A value at an axis.
struct Tick {
    /// The position of its row or column.
    at: usize,
    text: String,
    /// True if it is left out where cells are smaller than `least` of [`Ticks`].
    fine: bool,
}

struct Ticks {
    least: f64,
    all: Vec<Tick>,
}

/// Selects the values that have room.
fn ticks(projections: &Projections, variable: VarId, values: &[i64], room: f64, sizes: Sizes) -> Ticks {
    let step = nice(room / sizes.side, 1);
    let coarse = nice(room / sizes.phone.min(sizes.side), step);
    let words = !projections.variables[variable.index()].values.is_empty();
    let multiples = !words && values.iter().any(|value| value % coarse == 0);
    let number = |at: usize| if multiples { values[at] } else { at as i64 };
    let shown = (0..values.len()).filter(|&at| number(at) % step == 0);
    let one = |at: usize| Tick {
        at,
        text: text(projections, variable, values[at]),
        fine: number(at) % coarse != 0,
    };
    Ticks { least: room / step as f64, all: shown.map(one).collect() }
}

/// Returns the least multiple of `of` among 1, 2, 5, 10, 20, … that is not less than `x`.
fn nice(x: f64, of: i64) -> i64 {
    let steps = (0..).flat_map(|power| [1, 2, 5].map(|digit| digit * 10i64.pow(power)));
    steps.take(30).find(|&step| step as f64 >= x && step % of == 0).unwrap_or(i64::MAX)
}

fn text(projections: &Projections, variable: VarId, value: i64) -> String {
    shortened(&projections.variables[variable.index()].show(value), LONGEST)
}

/// Returns the width of the longest value of a variable at an axis.
fn widest(projections: &Projections, variable: VarId, values: &[i64]) -> f64 {
    FONT * values.iter().map(|&value| width(&text(projections, variable, value))).fold(0.0, f64::max)
}

/// Returns the width of the row values. Slanted names reach to the left of their columns.
fn left(projections: &Projections) -> f64 {
    let row = projections.plane.row.map_or(0.0, |row| widest(projections, row, &projections.rows()) + 8.0);
    row.max(if slanted(projections) { under(projections) - 10.0 } else { 0.0 }).ceil()
}

/// Returns whether the values of the columns are words, which are written at an angle.
fn slanted(projections: &Projections) -> bool {
    !projections.variables[projections.plane.column.index()].values.is_empty()
}

/// Returns the height of the values of the columns.
pub(super) fn under(projections: &Projections) -> f64 {
    match slanted(projections) {
        true => 0.71 * widest(projections, projections.plane.column, &projections.columns()) + 16.0,
        false => FONT + 8.0,
    }
}

fn both(projections: &Projections, sizes: Sizes) -> (Ticks, Ticks) {
    let (rows, columns, column) = (projections.rows(), projections.columns(), projections.plane.column);
    let room =
        if slanted(projections) { FONT + 4.0 } else { widest(projections, column, &columns) + BETWEEN };
    let down = match projections.plane.row {
        Some(row) => ticks(projections, row, &rows, FONT + 4.0, sizes),
        None => Ticks { least: 0.0, all: Vec::new() },
    };
    (down, ticks(projections, column, &columns, room, sizes))
}

/// Returns the names of the axes with their directions.
pub(super) fn names(projections: &Projections) -> Vec<String> {
    let name = |v: VarId| shortened(&projections.variables[v.index()].name, 2 * LONGEST);
    let up = if projections.rows_up { "↑" } else { "↓" };
    let row = projections.plane.row.map(|row| format!("{} {up}", name(row)));
    row.into_iter().chain([format!("{} →", name(projections.plane.column))]).collect()
}

/// Renders the values along the axes of a map of the page. They are no part of the drawing, so that they
/// have the same size in each map.
pub(super) fn page(projections: &Projections, sizes: Sizes) -> Markup {
    let (rows, columns) = both(projections, sizes);
    html! {
        ol.axis.down data-least=(format!("{:.1}", rows.least)) aria-hidden="true" {
            @for tick in &rows.all { li.fine[tick.fine] style=(format!("grid-row:{}", tick.at + 1)) { (tick.text) } }
        }
        ol.axis.across.slanted[slanted(projections)] data-least=(format!("{:.1}", columns.least)) aria-hidden="true" {
            @for tick in &columns.all {
                li.fine[tick.fine] style=(format!("grid-column:{}", tick.at + 1)) { span { (tick.text) } }
            }
        }
    }
}

/// Renders the values along the axes of a separate picture, and returns their height below the cells.
pub(super) fn alone(projections: &Projections, sizes: Sizes) -> (Markup, f64) {
    let (rows, columns) = both(projections, sizes);
    let (left, middle) = (sizes.left, |at: usize| (at as f64 + 0.5) * sizes.side);
    let bottom = projections.rows().len() as f64 * sizes.side;
    let drawn = html! {
        @for tick in &rows.all {
            text.axis.last x=(left - 6.0) y=(format!("{:.1}", middle(tick.at) + 4.0)) { (tick.text) }
        }
        @for tick in &columns.all {
            @let x = left + middle(tick.at);
            @if slanted(projections) {
                text.axis.last transform=(format!("translate({:.1} {:.1}) rotate(-45)", x + 4.0, bottom + 12.0)) { (tick.text) }
            } @else {
                text.axis x=(format!("{x:.1}")) y=(bottom + FONT + 3.0) { (tick.text) }
            }
        }
    };
    (drawn, under(projections))
}

#[cfg(test)]
mod tests {
    use super::{detail, nice, size};

    #[test]
    fn steps_between_values_are_round() {
        let found = [(0.4, 1), (1.2, 1), (2.1, 1), (5.5, 1), (11.0, 1), (2.5, 2), (4.0, 5)]
            .map(|(x, of)| nice(x, of));
        assert_eq!(found, [1, 2, 5, 10, 20, 10, 5]);
    }

    #[test]
    fn small_cells_have_no_long_texts() {
        assert_eq!(["2", "12", "120", "0.17", ">0.99", "A/B/F"].map(size), [0, 0, 1, 2, 3, 4]);
        assert_eq!(detail(40.0, 4), "");
        assert_eq!(detail(29.0, 4), "middle colors");
        assert_eq!(detail(20.0, 0), "middle");
        assert_eq!(detail(6.0, 0), "middle tiny colors");
    }
}
