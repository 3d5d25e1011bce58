//! Heat maps over the plane. They show the opening view; the page's script changes colours, numbers
//! and arrows when a slider moves.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::drawing::{paper, style};
use super::heat::Heat;
use super::letters::{shortened, width as text_width};
use super::paint::{Found, Look, Paint, ROOMY, SIDE};
use super::palette::Rgb;
use super::{Content, Picture, game, palette};
use meliora_engine::Scope;
use meliora_export::projections::{Projections, View};
use meliora_model::VarId;

/// Maximum number of columns for readable numbers and arrows in the cells.
const READABLE: usize = 24;
/// Maximum number of classes whose legend is not grouped.
const UNGROUPED: usize = 8;
/// Maximum number of targets that are marked among many small cells.
const MOST_SPOTS: usize = 200;
/// Maximum number of them that are marked by letters.
const MOST_LETTERS: usize = 20;

/// Renders a map as a separate drawing, with a title and a legend.
pub(super) fn svg(content: &Content<'_>, projections: &Projections, picture: Picture) -> Markup {
    let paint = Paint::new(content, projections);
    let mut legend = paint.legend(picture);
    legend.extend(paint.unsafe_legend());
    let signs = paint.signs.legend(projections).into_iter().filter(|_| !is_large(projections));
    legend.extend(signs.map(|(glyph, name)| (palette::NONE, format!("{glyph} {name}"))));
    legend.extend(game::legend(&content.check.players).map(|text| (palette::NONE, text)));
    let size = size(projections);
    let width = size.0.max(320);
    let view = lines(&view_text(projections, &paint.opening), width / 7);
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
            g transform=(format!("translate(0,{top})")) { (cells(Layer::Ranks(picture), &paint)) }
            @for (index, (color, label)) in legend.iter().enumerate() {
                @let (x, y) = (index % beside * 100 + 4, index / beside * 24 + height + 8);
                g transform=(format!("translate({x},{y})")) {
                    rect.swatch width="16" height="16" fill=(palette::css(*color)) {}
                    text.small x="22" y="13" { (label) }
                }
            }
        }
    }
}

/// Breaks a list at its commas into lines of about `width` characters.
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

/// What the cells of a map show.
#[derive(Clone, Copy)]
enum Layer<'a> {
    Ranks(Picture),
    /// The looks of the cells, row by row.
    Values(&'a [Look]),
}

/// Renders a map as a part of the page.
pub(super) fn part(content: &Content<'_>, paint: &Paint<'_>, picture: Picture) -> Markup {
    let words =
        Words { id: picture.name().to_owned(), title: picture.title().to_owned(), hint: hint(picture) };
    let legend = legend(content, paint, picture);
    figure(content, paint, Layer::Ranks(picture), &words, &legend)
}

/// Renders the maps of values as parts of the page.
pub(super) fn values(content: &Content<'_>, paint: &Paint<'_>, heat: &Heat<'_>) -> Markup {
    let looks = heat.looks(paint.projections, &paint.views());
    html! {
        @for (&measure, looks) in heat.measures.iter().zip(&looks) {
            @let words = Words { id: measure.id(), title: measure.title(), hint: measure.hint() };
            (figure(content, paint, Layer::Values(looks), &words, &plain_legend(&heat.legend(measure))))
        }
    }
}

/// The texts of a map.
struct Words {
    id: String,
    title: String,
    hint: &'static str,
}

/// Renders the colours of a legend.
fn plain_legend(entries: &[(Rgb, String)]) -> Markup {
    html! {
        @for (color, label) in entries {
            li { span.swatch style=(format!("background:{}", palette::css(*color))) {} (label) }
        }
    }
}

/// Renders the colours of a map; many classes are grouped by their first most preferred objective.
fn legend(content: &Content<'_>, paint: &Paint<'_>, picture: Picture) -> Markup {
    let entries = paint.legend(picture);
    if picture != Picture::Classes || entries.len() <= UNGROUPED {
        return plain_legend(&entries);
    }
    let mut groups: BTreeMap<Option<usize>, Vec<(Rgb, String)>> = BTreeMap::new();
    for (entry, (class, _)) in entries.into_iter().zip(&paint.projections.classes) {
        groups.entry(class.iter().next()).or_default().push(entry);
    }
    let name = |first: &Option<usize>| {
        first.map(|objective| content.preferences.objectives[objective].name.as_str())
    };
    html! {
        @for (first, entries) in &groups {
            @if let (Some(name), true) = (name(first), entries.len() > 1) {
                li.group { b { (name) } ul.legend { (plain_legend(entries)) } }
            } @else {
                (plain_legend(entries))
            }
        }
    }
}

fn figure(
    content: &Content<'_>,
    paint: &Paint<'_>,
    layer: Layer<'_>,
    words: &Words,
    legend: &Markup,
) -> Markup {
    let projections = paint.projections;
    let (width, height) = size(projections);
    let most = if projections.plane.row.is_some() { (width * 8 / 5).clamp(200, 720) } else { width };
    let several = paint.cells.iter().flatten().any(Found::is_several);
    html! {
        figure.map id=(format!("map-{}", words.id)) {
            figcaption {
                strong { (words.title) }
                span.hint { (words.hint) }
            }
            svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width} {height}")) role="img"
                preserveAspectRatio="xMinYMin" aria-label=(words.title) style=(format!("max-width:{most}px")) {
                (cells(layer, paint))
            }
            ul.legend {
                (legend)
                @if let Some(entry) = paint.unsafe_legend() { (plain_legend(&[entry])) }
                @if !is_large(projections) {
                    @for (glyph, name) in paint.signs.legend(projections) { li { span.glyph { (glyph) } (name) } }
                }
                @if content.check.header.scope == Some(Scope::Reachable) {
                    li.wall-key { span.swatch.wall {} "unreachable" }
                }
                @if matches!(layer, Layer::Ranks(Picture::Classes)) {
                    li.several hidden[!several] {
                        span.swatch.several {}
                        (if is_large(projections) { "several classes" } else { "several classes, each with a square" })
                        ": select a cell to see their names"
                    }
                }
            }
        }
    }
}

fn hint(picture: Picture) -> &'static str {
    match picture {
        Picture::Sasi => "SASI rank",
        Picture::Spi => "SPI rank",
        Picture::Classes | Picture::Hasse => "almost sure",
    }
}

fn size(projections: &Projections) -> (usize, usize) {
    let below = under(projections) + 3 * letters(projections) / 2;
    (left(projections) + SIDE * projections.columns().len() + 4, SIDE * projections.rows().len() + below)
}

/// Returns the minimum width of a map on the page in rem, so that three maps fit next to each other.
pub(super) fn least_width(projections: &Projections) -> usize {
    match projections.plane.row {
        Some(_) => (projections.columns().len() * 3 / 2).clamp(20, 25),
        None => (size(projections).0 / 16).max(20),
    }
}

fn is_large(projections: &Projections) -> bool {
    projections.columns().len() > READABLE
}

/// Returns the font size of row and column numbers: pictures with many cells are shown smaller.
fn letters(projections: &Projections) -> usize {
    match projections.plane.row {
        Some(_) => (13 * projections.columns().len() / 10).max(12),
        None => 14,
    }
}

/// Returns the width of the longest value of a variable at an axis.
fn widest(projections: &Projections, variable: VarId, values: &[i64]) -> usize {
    let width = |&value: &i64| text_width(&shown(projections, variable, value));
    (values.iter().map(width).fold(0.0, f64::max) * letters(projections) as f64) as usize
}

/// Returns the text of a value at an axis.
fn shown(projections: &Projections, variable: VarId, value: i64) -> String {
    shortened(&projections.variables[variable.index()].show(value))
}

/// Returns the width of the row numbers, or of the names of values.
fn left(projections: &Projections) -> usize {
    let row = projections.plane.row.map_or(0, |row| widest(projections, row, &projections.rows()));
    // Slanted names reach to the left of their columns.
    let column = if slanted(projections) { under(projections) - SIDE / 2 } else { 0 };
    row.max(letters(projections)).max(column) + 14
}

/// Returns whether the values of the columns are words, which are written at an angle.
fn slanted(projections: &Projections) -> bool {
    !projections.variables[projections.plane.column.index()].values.is_empty()
}

/// Returns the height of the values of the columns.
fn under(projections: &Projections) -> usize {
    match slanted(projections) {
        true => widest(projections, projections.plane.column, &projections.columns()) * 7 / 10 + SIDE / 2,
        false => letters(projections) + 6,
    }
}

/// Formats a view: `b=8, d=false`, or `any b, any d`.
pub(super) fn view_text(projections: &Projections, view: &View) -> String {
    let inside = |index| {
        projections.plane.row.is_some_and(|r| r.index() == index) || projections.plane.column.index() == index
    };
    if view.len() > 3 && view.iter().enumerate().all(|(index, value)| value.is_none() || inside(index)) {
        return "any values of the other variables".to_owned();
    }
    let one = |(index, value): (usize, &Option<i64>)| {
        let variable = &projections.variables[index];
        let text = match value {
            Some(value) => format!("{}={}", variable.name, variable.show(*value)),
            None => format!("any {}", variable.name),
        };
        (!inside(index)).then_some(text)
    };
    view.iter().enumerate().filter_map(one).collect::<Vec<_>>().join(", ")
}

/// Renders the cells with the numbers of their rows and columns.
fn cells(layer: Layer<'_>, paint: &Paint<'_>) -> Markup {
    let projections = paint.projections;
    let (left, ring) = (left(projections), SIDE / 2 - 3);
    // In a picture of many small cells, a ring around one cell would be invisible.
    let many = projections.columns().len().min(SIDE * projections.rows().len() / 2);
    html! {
        defs { pattern #wall width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(45)" {
            rect.wall width="6" height="6" {}
            line.wall x1="0" y1="0" x2="0" y2="6" {}
        } }
        (axes(projections, &projections.rows(), &projections.columns()))
        g.dense[projections.columns().len() > ROOMY] {
            @for (i, row) in paint.cells.iter().enumerate() {
                @for (j, found) in row.iter().enumerate() {
                    @let number = i * row.len() + j;
                    (cell(layer, paint, number, (left + SIDE * j, SIDE * i), found))
                }
            }
        }
        @if is_large(projections) { (spots(paint)) }
        @if let Some((x, y)) = start(projections) {
            circle.start cx=(x + SIDE / 2) cy=(y + SIDE / 2) r=(ring.max(many)) { title { "start" } }
        }
        (game::pieces(projections, (&paint.opening, is_large(projections).then_some(many)), |row, column| corner(projections, row, column)))
        rect.chosen width=(SIDE) height=(SIDE) visibility="hidden" {}
        (game::token(projections, (ring - 3).max(many)))
    }
}

/// Marks the targets in a map with small cells by signs that are larger than a cell.
fn spots(paint: &Paint<'_>) -> Markup {
    let left = left(paint.projections);
    let places = paint.cells.iter().enumerate().flat_map(|(i, row)| {
        let targets = row.iter().enumerate().filter(|(_, found)| !found.targets.is_empty());
        targets.map(move |(j, found)| (left + SIDE * j + SIDE / 2, SIDE * i + SIDE / 2, &found.letters))
    });
    let places: Vec<_> = places.take(MOST_SPOTS).collect();
    let size = letters(paint.projections) * 3 / 2;
    html! {
        @for (x, y, letters) in &places {
            @if places.len() <= MOST_LETTERS {
                text.spot x=(x) y=(y + size / 3) style=(format!("font-size:{size}px")) { (letters.join("")) }
            } @else {
                path.spot d=(format!("M{x} {}l45 45l-45 45l-45 -45z", *y as i64 - 45)) { title { "target " (letters.join(", ")) } }
            }
        }
    }
}

/// Returns the corner of the cell of the state that is shown first.
fn start(projections: &Projections) -> Option<(usize, usize)> {
    let value = |variable: VarId| projections.at[variable.index()];
    corner(projections, projections.plane.row.map_or(0, value), value(projections.plane.column))
}

/// Returns the upper left corner of a cell.
fn corner(projections: &Projections, row: i64, column: i64) -> Option<(usize, usize)> {
    let i = projections.rows().iter().position(|&r| r == row)?;
    let j = projections.columns().iter().position(|&c| c == column)?;
    Some((left(projections) + SIDE * j, SIDE * i))
}

fn axes(projections: &Projections, rows: &[i64], columns: &[i64]) -> Markup {
    let (left, size, bottom) = (left(projections), letters(projections), SIDE * rows.len());
    let (first, second) = (bottom + size + 3, bottom + under(projections) + size);
    let name = |v: VarId| projections.variables[v.index()].name.as_str();
    let shown = |v, value| shown(projections, v, value);
    let font = format!("font-size:{size}px");
    let anchored = |anchor: &str| format!("{font};text-anchor:{anchor}");
    // About twelve numbers per axis are enough.
    let (down, along) = (rows.len().div_ceil(12), columns.len().div_ceil(12));
    html! {
        @if let Some(row) = projections.plane.row {
            @for (i, value) in rows.iter().enumerate().step_by(down) {
                text.axis x=(left - 8) y=(SIDE * i + SIDE / 2 + size / 3) style=(anchored("end")) { (shown(row, *value)) }
            }
            text.axis x="2" y=(second) style=(anchored("start")) {
                (name(row)) (if projections.rows_up { " ↑ " } else { " ↓ " }) (name(projections.plane.column)) " →"
            }
        } @else {
            text.axis x="2" y=(second) style=(anchored("start")) { (name(projections.plane.column)) " →" }
        }
        @for (j, value) in columns.iter().enumerate().step_by(along) {
            @let (x, text) = (left + SIDE * j + SIDE / 2, shown(projections.plane.column, *value));
            @if slanted(projections) {
                text.axis transform=(format!("translate({} {first}) rotate(-45)", x + size / 2)) style=(anchored("end")) { (text) }
            } @else {
                text.axis x=(x) y=(first) style=(font) { (text) }
            }
        }
    }
}

fn cell(layer: Layer<'_>, paint: &Paint<'_>, number: usize, (x, y): (usize, usize), found: &Found) -> Markup {
    let look = match layer {
        Layer::Ranks(picture) => &paint.look(picture, found),
        Layer::Values(_) if found.is_unsafe => &Look::not_safe(),
        Layer::Values(looks) => &looks[number],
    };
    let arrows = match layer {
        Layer::Ranks(picture) if picture != Picture::Classes => Some(paint.arrows(picture, found)),
        _ => None,
    };
    let place = !found.letters.is_empty() && paint.projections.columns().len() > ROOMY;
    html! {
        g.cell.elsewhere[found.elsewhere].place[place].theirs[found.is_theirs] transform=(format!("translate({x},{y})")) data-row=(found.row) data-col=(found.column)
            data-value=(if found.elsewhere { "" } else { &look.text }) {
            @if matches!(layer, Layer::Ranks(Picture::Classes)) { title { (paint.named(found)) } }
            rect width=(SIDE) height=(SIDE) rx=[game::corners(found.is_theirs)] fill=(look.fill) {}
            @if !is_large(paint.projections) {
                @if look.squares.is_empty() {
                    text class=(size_class(&look.text)) x=(SIDE / 2) y="26" fill=(look.ink) { (look.text) }
                } @else {
                    text.value.squares x=(SIDE / 2) y="26" fill=(look.ink) {
                        @for (fill, square) in look.squares.iter().zip(look.text.chars()) { tspan fill=(fill) { (square) } }
                    }
                }
                @if let Some(arrows) = arrows { path.arrows fill=(look.ink) d=(arrows) {} }
                @for (corner, letter) in found.letters.iter().enumerate() {
                    @if place && found.letters.len() == 1 {
                        text class="target only" x=(SIDE / 2) y="29" { (letter) }
                    } @else {
                        (corner_letter(corner, letter, if place { 17 } else { 12 }))
                    }
                }
                @if !found.signs.is_empty() { text.label x=(SIDE - 3) y=(SIDE - 4) { (found.signs.join("")) } }
            }
        }
    }
}

/// Renders a letter in a corner, away from the arrows.
fn corner_letter(corner: usize, letter: &str, top: usize) -> Markup {
    let (class, x) = match corner % 2 {
        0 if letter == "◆" || letter.chars().count() > 1 => ("target sign", 2),
        _ if letter.chars().count() > 1 => ("target sign end", SIDE - 2),
        0 => ("target", 2),
        _ => ("target end", SIDE - 2),
    };
    let y = if corner < 2 { top } else { SIDE - 3 };
    html! { text class=(class) x=(x) y=(y) { (letter) } }
}

/// Returns the class for the font size: long texts are smaller.
fn size_class(text: &str) -> &'static str {
    match text.chars().count() {
        0..=2 => "value short",
        3 => "value",
        4 => "value long",
        _ => "value longer",
    }
}
