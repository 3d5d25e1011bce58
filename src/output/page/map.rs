//! Heat maps over the plane. The page's script changes colours, numbers and arrows of these drawings when
//! a slider moves; as they stand they show the opening view.

use maud::{Markup, PreEscaped, html};

use super::palette::{self, Rgb};
use super::{Content, Picture, words};
use crate::atlas::{Atlas, Cell, Direction, Ladder, View};
use crate::engine::Scope;
use crate::model::preference::ObjectiveSet;
use crate::output::text;
use crate::planning::Rank;

/// The side of a cell.
const SIDE: usize = 40;
/// Room for the numbers of rows and columns.
const LEFT: usize = 44;
const BELOW: usize = 48;
/// The same for pictures with many cells, which are shown smaller.
const LEFT_OF_MANY: usize = 70;
const BELOW_MANY: usize = 120;
/// With more columns than this, numbers and arrows in the cells would be too small to be seen.
const READABLE: usize = 24;

/// What a drawing on its own needs to look like one in the page.
pub(super) fn style() -> Markup {
    html! { style { (PreEscaped(include_str!("picture.css"))) } }
}

/// A map as a drawing on its own, with a title and a legend.
pub(super) fn svg(content: &Content<'_>, atlas: &Atlas, picture: Picture) -> Markup {
    let legend = legend(content, atlas, picture);
    let size = size(atlas);
    let width = size.0.max(320);
    let view = lines(&view_text(atlas, &atlas.opening()), width / 7);
    let top = 34 + 16 * view.len();
    let (beside, height) = ((width / 100).max(1), top + size.1);
    let below = 24 * legend.len().div_ceil(beside) + 12;
    html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width} {}", height + below)) {
            (style())
            (paper(width, height + below))
            text.title x="4" y="20" { (picture.title()) }
            @for (index, line) in view.iter().enumerate() {
                text.small x="4" y=(38 + 16 * index) { (line) }
            }
            g transform=(format!("translate(0,{top})")) { (cells(atlas, picture, &Paint::new(content, atlas))) }
            @for (index, (color, label)) in legend.iter().enumerate() {
                @let (x, y) = (index % beside * 100 + 4, index / beside * 24 + height + 8);
                g transform=(format!("translate({x},{y})")) {
                    rect.swatch width="16" height="16" fill=(palette::hex(*color)) {}
                    text.small x="22" y="13" { (label) }
                }
            }
        }
    }
}

/// What a drawing on its own lies on, so that it reads on dark pages too.
pub(super) fn paper(width: usize, height: usize) -> Markup {
    html! { rect.paper width=(width) height=(height) {} }
}

/// A list broken at its commas into lines of about so many letters.
fn lines(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for part in text.split_inclusive(", ") {
        match lines.last_mut() {
            Some(line) if line.len() + part.len() <= width => line.push_str(part),
            _ => lines.push(part.to_owned()),
        }
    }
    lines
}

/// A map as a part of the page.
pub(super) fn part(content: &Content<'_>, atlas: &Atlas, picture: Picture) -> Markup {
    let (width, height) = size(atlas);
    html! {
        figure.map id=(format!("map-{}", picture.name())) {
            figcaption {
                strong { (picture.title()) }
                span.hint { (hint(picture)) }
            }
            svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width} {height}")) role="img"
                aria-label=(picture.title()) style=(format!("max-width:{}px", (width * 2).clamp(320, 720))) {
                (cells(atlas, picture, &Paint::new(content, atlas)))
            }
            ul.legend {
                @for (color, label) in legend(content, atlas, picture) {
                    li { span.swatch style=(format!("background:{}", palette::hex(color))) {} (label) }
                }
                @if content.check.scope == Scope::Reachable && !atlas.confined { li.wall-key { span.swatch.wall {} "never reached" } }
                @if picture == Picture::Classes { li.several { span.swatch.several {} "several" } }
            }
        }
    }
}

fn hint(picture: Picture) -> &'static str {
    match picture {
        Picture::Sasi => "SASI rank: so often a play surely moves on to something preferred",
        Picture::Spi => "SPI rank: so often it can, with luck",
        Picture::Classes | Picture::Hasse => "the most preferred objectives that are certain",
    }
}

fn size(atlas: &Atlas) -> (usize, usize) {
    let below = if is_large(atlas) { BELOW_MANY } else { BELOW };
    (left(atlas) + SIDE * atlas.columns().len() + 4, SIDE * atlas.rows().len() + below)
}

fn is_large(atlas: &Atlas) -> bool {
    atlas.columns().len() > READABLE
}

fn left(atlas: &Atlas) -> usize {
    if is_large(atlas) { LEFT_OF_MANY } else { LEFT }
}

/// What colours mean, those that occur.
fn legend(content: &Content<'_>, atlas: &Atlas, picture: Picture) -> Vec<(Rgb, String)> {
    let paint = Paint::new(content, atlas);
    if picture == Picture::Classes {
        let one = |index| (paint.class(index).0, paint.names[index].clone());
        return (0..atlas.classes.len()).map(one).collect();
    }
    let ladder = ladder(atlas, picture);
    let most = ladder.levels.len();
    let mut ranks: Vec<Rank> = (0..=most).map(Rank::Finite).collect();
    if ladder.open {
        ranks[most] = Rank::AtLeast(most);
    }
    if ladder.unbounded.is_some() {
        // The last level is the fixpoint: no state has its number as its rank.
        ranks[most] = Rank::Unbounded;
    }
    ranks
        .into_iter()
        .map(|r| (palette::rank(r, paint.most(picture)), words::mark(r).replace('∞', "∞ any number")))
        .collect()
}

fn ladder(atlas: &Atlas, picture: Picture) -> &Ladder {
    if picture == Picture::Spi { &atlas.spi } else { &atlas.sasi }
}

/// `b=8, d=false`, or `any b, any d`.
pub(super) fn view_text(atlas: &Atlas, view: &View) -> String {
    let one = |(index, value): (usize, &Option<i64>)| {
        let variable = &atlas.variables[index];
        let in_plane = atlas.plane.row.is_some_and(|r| r.index() == index);
        if in_plane || atlas.plane.column.index() == index {
            return None;
        }
        Some(match value {
            Some(value) => format!("{}={}", variable.name, variable.show(*value)),
            None => format!("any {}", variable.name),
        })
    };
    view.iter().enumerate().filter_map(one).collect::<Vec<_>>().join(", ")
}

/// The colours and words of an atlas.
pub(super) struct Paint {
    /// The names of the classes.
    pub(super) names: Vec<String>,
    /// Their names in cells.
    pub(super) marks: Vec<String>,
    /// For each class its place by size, the largest first; none for that of those sure of nothing.
    places: Vec<Option<usize>>,
    objectives: Vec<String>,
    /// For each objective whether its target meets the first and the last row and column.
    everywhere: Vec<bool>,
    greatest: [usize; 2],
}

impl Paint {
    pub(super) fn new(content: &Content<'_>, atlas: &Atlas) -> Self {
        let name = |class: &_| {
            let names = content.preferences.names(class);
            text::names(&names.into_iter().map(str::to_owned).collect::<Vec<_>>())
        };
        let mark = |class: &ObjectiveSet| match class.is_empty() {
            true => "–".to_owned(),
            false => content.preferences.names(class).join(","),
        };
        // The fixpoint has a colour of its own.
        let greatest = |l: &Ladder| l.levels.len() - usize::from(l.unbounded.is_some());
        Paint {
            names: atlas.classes.iter().map(|(class, _)| name(class)).collect(),
            objectives: content.preferences.objectives.iter().map(|o| o.name.clone()).collect(),
            everywhere: everywhere(atlas),
            marks: atlas.classes.iter().map(|(class, _)| mark(class)).collect(),
            places: places(content, atlas),
            greatest: [greatest(&atlas.sasi), greatest(&atlas.spi)],
        }
    }

    /// The greatest finite rank.
    pub(super) fn most(&self, picture: Picture) -> usize {
        self.greatest[usize::from(picture == Picture::Spi)]
    }

    /// Colour and ink of a class.
    pub(super) fn class(&self, index: usize) -> (Rgb, &'static str) {
        let color = palette::class(self.places[index]);
        (color, palette::ink(color))
    }

    /// Colour, ink, text and the value that scripts read, of a cell.
    fn cell(&self, picture: Picture, cell: &Cell) -> (String, &'static str, String) {
        let rank = match picture {
            Picture::Spi => cell.spi,
            Picture::Sasi | Picture::Hasse => cell.sasi,
            Picture::Classes => {
                return match cell.classes[..] {
                    [index] => {
                        let (color, ink) = self.class(index);
                        (palette::hex(color), ink, self.marks[index].clone())
                    }
                    _ => ("var(--several, #d8d4e8)".to_owned(), "#1a1a1a", "…".to_owned()),
                };
            }
        };
        let color = palette::rank(rank, self.most(picture));
        (palette::hex(color), palette::ink(color), words::mark(rank))
    }
}

/// The classes by size, so that the strongest colours go to the largest.
fn places(content: &Content<'_>, atlas: &Atlas) -> Vec<Option<usize>> {
    let sizes = content.check.classes.as_deref().unwrap_or_default();
    let size = |class: usize| sizes.get(class).map(|c| c.states.clone());
    let mut order: Vec<usize> =
        (0..atlas.classes.len()).filter(|&c| !atlas.classes[c].0.is_empty()).collect();
    order.sort_by_key(|&class| std::cmp::Reverse(size(class)));
    (0..atlas.classes.len()).map(|c| order.iter().position(|&o| o == c)).collect()
}

/// For each objective whether its target can be in all four corners of the plane: then it is not a place.
fn everywhere(atlas: &Atlas) -> Vec<bool> {
    let open: View = vec![None; atlas.variables.len()];
    let (rows, columns) = (atlas.rows(), atlas.columns());
    let ends = |values: &[i64]| [values.first().copied().unwrap_or(0), values.last().copied().unwrap_or(0)];
    let corners = ends(&rows).into_iter().flat_map(|r| ends(&columns).map(|c| (r, c)));
    let found: Vec<Vec<usize>> = corners.map(|(r, c)| atlas.targets_at(&atlas.view(&open, r, c))).collect();
    (0..atlas.targets.len()).map(|i| found.iter().all(|here| here.contains(&i))).collect()
}

/// The cells with the numbers of their rows and columns.
fn cells(atlas: &Atlas, picture: Picture, paint: &Paint) -> Markup {
    let (rows, columns) = (atlas.rows(), atlas.columns());
    let opening = atlas.opening();
    let start = start(atlas);
    html! {
        defs { pattern #wall width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(45)" {
            rect.wall width="6" height="6" {}
            line.wall x1="0" y1="0" x2="0" y2="6" {}
        } }
        (axes(atlas, &rows, &columns))
        @for (i, &row) in rows.iter().enumerate() {
            @for (j, &column) in columns.iter().enumerate() {
                (cell(atlas, picture, paint, (i, j), &atlas.view(&opening, row, column), (row, column)))
            }
        }
        @if let Some((i, j)) = start {
            @let (x, y) = (left(atlas) + SIDE * j + SIDE / 2, SIDE * i + SIDE / 2);
            circle.start cx=(x) cy=(y) r=((SIDE / 2 - 3).max(columns.len())) { title { "where planning starts" } }
        }
        rect.chosen width=(SIDE) height=(SIDE) visibility="hidden" {}
        circle.token r=((SIDE / 2 - 6).max(columns.len())) visibility="hidden" {}
    }
}

/// Where the state that is shown first stands.
fn start(atlas: &Atlas) -> Option<(usize, usize)> {
    let value = |variable: crate::model::VarId| atlas.at[variable.index()];
    let row = atlas.plane.row.map_or(0, value);
    let i = atlas.rows().iter().position(|&r| r == row)?;
    Some((i, atlas.columns().iter().position(|&c| c == value(atlas.plane.column))?))
}

fn axes(atlas: &Atlas, rows: &[i64], columns: &[i64]) -> Markup {
    let bottom = SIDE * rows.len();
    let name = |v: crate::model::VarId| atlas.variables[v.index()].name.as_str();
    // About sixteen numbers are enough.
    let (down, along) = (rows.len().div_ceil(16), columns.len().div_ceil(16));
    let (large, left) = (if is_large(atlas) { "axis large" } else { "axis" }, left(atlas));
    let (first, second) = if is_large(atlas) { (42, 100) } else { (18, 40) };
    html! {
        @if let Some(row) = atlas.plane.row {
            @for (i, value) in rows.iter().enumerate().step_by(down) {
                text class=(large) x=(left - 8) y=(SIDE * i + SIDE / 2 + 5) style="text-anchor:end" { (value) }
            }
            text class=(large) x="2" y=(bottom + second) style="text-anchor:start" {
                (name(row)) " ↑ " (name(atlas.plane.column)) " →"
            }
        } @else {
            text class=(large) x="2" y=(bottom + second) style="text-anchor:start" { (name(atlas.plane.column)) }
        }
        @for (j, value) in columns.iter().enumerate().step_by(along) {
            text class=(large) x=(left + SIDE * j + SIDE / 2) y=(bottom + first) { (value) }
        }
    }
}

fn cell(
    atlas: &Atlas,
    picture: Picture,
    paint: &Paint,
    (i, j): (usize, usize),
    view: &View,
    (row, column): (i64, i64),
) -> Markup {
    let found = atlas.cell(view);
    let shown = found.as_ref().map(|cell| paint.cell(picture, cell));
    let readable = !is_large(atlas);
    let place = format!("translate({},{})", left(atlas) + SIDE * j, SIDE * i);
    let target = target(atlas, paint, row, column);
    html! {
        g.cell transform=(place) data-row=(row) data-col=(column)
            data-value=(shown.as_ref().map_or("", |(_, _, text)| text.as_str())) {
            rect width=(SIDE) height=(SIDE)
                fill=(shown.as_ref().map_or("var(--void, #ffffff00)", |(fill, _, _)| fill.as_str())) {}
            @if readable {
                text class=(size_class(shown.as_ref().map_or("", |(_, _, text)| text.as_str())))
                    x=(SIDE / 2) y="26" fill=(shown.as_ref().map_or("none", |(_, ink, _)| ink)) {
                    @if let Some((_, _, text)) = &shown { (text) }
                }
                @if picture != Picture::Classes {
                    path.arrows fill=(shown.as_ref().map_or("none", |(_, ink, _)| ink))
                        d=(arrows(atlas, ladder(atlas, picture), view)) {}
                }
                @if let Some(target) = target {
                    text.target x="3" y="11" fill=(shown.as_ref().map_or("currentColor", |(_, ink, _)| ink)) { (target) }
                }
            }
        }
    }
}

/// Long texts are smaller.
fn size_class(text: &str) -> &'static str {
    match text.chars().count() {
        0..=3 => "value",
        4..=5 => "value long",
        _ => "value longer",
    }
}

/// The objectives whose target can be in a cell; none where that tells nothing, for it is so everywhere.
fn target(atlas: &Atlas, paint: &Paint, row: i64, column: i64) -> Option<String> {
    let open: View = vec![None; atlas.variables.len()];
    let here = atlas.targets_at(&atlas.view(&open, row, column));
    let names: Vec<&str> =
        here.into_iter().filter(|&i| !paint.everywhere[i]).map(|i| paint.objectives[i].as_str()).collect();
    let text = names.concat();
    match text.chars().count() {
        0 => None,
        1..=4 => Some(text),
        _ => Some("◆".to_owned()),
    }
}

/// The arrows of the permitted choices, where no variable is open.
fn arrows(atlas: &Atlas, ladder: &Ladder, view: &View) -> String {
    let mut path = String::new();
    if view.iter().any(Option::is_none) {
        return path;
    }
    for (choice, &edge) in atlas.choices.iter().zip(&ladder.permitted) {
        let arrow = arrow(choice, atlas.rows_up);
        if !path.contains(&arrow) && atlas.holds(edge, view) {
            path.push_str(&arrow);
        }
    }
    path
}

/// A triangle at the edge of a cell, on the side to which the choice leads; none where it leads nowhere.
pub(super) fn arrow(choice: &Direction, rows_up: bool) -> String {
    let (dx, dy) = (f64::from(choice.column), f64::from(choice.row) * if rows_up { -1.0 } else { 1.0 });
    let length = dx.hypot(dy);
    if length == 0.0 {
        return String::new();
    }
    let (ux, uy) = (dx / length, dy / length);
    let half = SIDE as f64 / 2.0;
    let reach = half - 2.0;
    let tip = (half + ux * reach * length.min(1.25), half + uy * reach * length.min(1.25));
    let base = (tip.0 - ux * 7.0, tip.1 - uy * 7.0);
    let (px, py) = (-uy * 5.5, ux * 5.5);
    format!(
        "M{:.1} {:.1}L{:.1} {:.1}L{:.1} {:.1}Z",
        tip.0,
        tip.1,
        base.0 + px,
        base.1 + py,
        base.0 - px,
        base.1 - py
    )
}
