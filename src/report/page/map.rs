//! Maps over the plane. They show the opening view; the page's script changes colours, numbers, marks
//! and arrows when a slider moves.

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::axes::{self, Sizes};
use super::heat::Heat;
use super::marks::{MORE, Placed, SEVERAL};
use super::paint::{Look, Paint, SIDE, ViewCell};
use super::palette::Rgb;
use super::{Content, Picture, game, palette};
use meliora_engine::Scope;
use meliora_export::projections::{Projections, View};

/// Maximum number of classes whose legend is not grouped.
const UNGROUPED: usize = 8;

/// The dots of targets and labels in the smallest cells.
pub(super) const TARGET: &str = "M20 6L34 20L20 34L6 20Z";
pub(super) const LABEL: &str = "M20 14A6 6 0 0 1 20 26A6 6 0 0 1 20 14Z";

/// The contents of the cells of a map.
#[derive(Clone, Copy)]
pub(super) enum Layer<'a> {
    Ranks(Picture),
    /// The looks of the cells, row by row.
    Values(&'a [Look]),
}

/// Renders a map as a part of the page.
pub(super) fn part(content: &Content<'_>, paint: &Paint<'_>, picture: Picture) -> Markup {
    let words =
        Words { id: picture.name().to_owned(), title: picture.title().to_owned(), hint: hint(picture) };
    let legend = legend(content, paint, picture);
    figure(content, paint, Layer::Ranks(picture), paint.smallest(picture), &words, &legend)
}

/// Renders the maps of values as parts of the page.
pub(super) fn values(content: &Content<'_>, paint: &Paint<'_>, heat: &Heat<'_>) -> Markup {
    let looks = heat.looks(paint.projections, &paint.views());
    html! {
        @for (table, looks) in heat.tables.iter().zip(&looks) {
            @let measure = table.measure;
            @let words = Words { id: measure.id(), title: measure.title(), hint: measure.hint() };
            @let smallest = table.looks.iter().map(|look| axes::size(&look.text)).max().unwrap_or(0);
            (figure(content, paint, Layer::Values(looks), smallest, &words, &plain_legend(&table.legend())))
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

/// Renders a map; `smallest` is the font size of the smallest texts of its cells.
fn figure(
    content: &Content<'_>,
    paint: &Paint<'_>,
    layer: Layer<'_>,
    smallest: usize,
    words: &Words,
    legend: &Markup,
) -> Markup {
    let (projections, sizes) = (paint.projections, Sizes::new(paint.projections));
    let (rows, columns) = (projections.rows().len(), projections.columns().len());
    let under = axes::under(projections);
    let shape = format!("--left:{}px;--under:{under:.0}px;--rows:{rows};--columns:{columns}", sizes.left);
    let walls = paint.cells.iter().flatten().any(ViewCell::is_wall);
    let several = paint.cells.iter().flatten().any(ViewCell::is_several);
    html! {
        figure.map id=(format!("map-{}", words.id)) {
            figcaption {
                strong { (words.title) }
                span.hint { (words.hint) }
            }
            div.plot style=(shape) {
                div class=(format!("drawing {}", axes::detail(sizes.side, smallest))) data-readable=(axes::readable(smallest)) {
                    svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {} {}", SIDE * columns, SIDE * rows))
                        role="img" aria-label=(words.title) {
                        (cells(layer, paint, sizes))
                    }
                    (axes::page(projections, sizes))
                }
                p.names { @for name in axes::names(projections) { span { (name) } " " } }
            }
            ul.legend {
                (legend)
                @if let Some(entry) = paint.unsafe_legend() { (plain_legend(&[entry])) }
                @if content.check.header.scope == Some(Scope::Reachable) && walls {
                    li.wall-key { span.swatch.wall {} "unreachable" }
                }
                @if matches!(layer, Layer::Ranks(Picture::Classes)) {
                    li.several hidden[!several] {
                        span.swatch.several {}
                        "several classes, each with a square: select a cell to see their names"
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

/// Names the signs and letters in the maps.
pub(super) fn key(paint: &Paint<'_>) -> Markup {
    let (projections, marks) = (paint.projections, &paint.marks.0);
    let shown = |number: usize| paint.cells.iter().flatten().any(|found| found.has(number));
    let group = |title: &str, is_target: bool| {
        let own = || marks.iter().enumerate().filter(move |(_, mark)| mark.is_target == is_target);
        html! { @if own().next().is_some() { li.group { b { (title) } ul.legend {
            @for (number, mark) in own() {
                li data-mark=(number) hidden[!shown(number)] { span.glyph { (mark.glyph) } (mark.name) }
            }
        } } } }
    };
    let crowded = paint.cells.iter().flatten().any(|found| found.marks.len() > 4);
    let sizes = Sizes::new(projections);
    html! {
        ul.legend.key {
            li { (sign(&start())) "start" }
            @if !projections.choices.is_empty() && sizes.side >= axes::TINY {
                li { (sign(&html! { path.arrows d="M10 8L32 20L10 32Z" {} })) "direction of a permitted action" }
            }
            (group("Targets", true))
            (group("Labels", false))
            @if !marks.is_empty() {
                li.small { b { (SEVERAL[0]) } " targets and " b { (SEVERAL[1]) } " labels in small cells" }
                li.faint hidden[!paint.has_pale()] { span.glyph.pale { (marks[0].glyph) } "with other values" }
                li.crowded hidden[!crowded] { span.glyph { (MORE) } "further marks" }
            }
        }
    }
}

/// Renders a sign of the maps in a legend.
fn sign(drawn: &Markup) -> Markup {
    html! { svg.sign viewBox=(format!("0 0 {SIDE} {SIDE}")) aria-hidden="true" { (drawn) } }
}

fn start() -> Markup {
    html! { g.start { circle.halo cx="20" cy="20" r="17" {} circle cx="20" cy="20" r="17" {} } }
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
            Some(value) => projections.reading(index, *value),
            None => format!("any {}", variable.name),
        };
        (!inside(index)).then_some(text)
    };
    view.iter().enumerate().filter_map(one).collect::<Vec<_>>().join(", ")
}

/// Renders the cells with their marks, in units of [`SIDE`] per cell.
pub(super) fn cells(layer: Layer<'_>, paint: &Paint<'_>, sizes: Sizes) -> Markup {
    let projections = paint.projections;
    html! {
        defs { pattern #wall width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(45)" {
            rect.wall width="6" height="6" {}
            line.wall x1="0" y1="0" x2="0" y2="6" {}
        } }
        @for (i, row) in paint.cells.iter().enumerate() {
            @for (j, found) in row.iter().enumerate() {
                (cell(layer, paint, i * row.len() + j, sizes.side >= axes::TINY, SIDE * j, SIDE * i, found))
            }
        }
        (game::pieces(projections, &paint.opening, |row, column| corner(projections, row, column)))
        g.chosen visibility="hidden" {
            rect.halo x="3" y="3" width=(SIDE - 6) height=(SIDE - 6) {}
            rect x="3" y="3" width=(SIDE - 6) height=(SIDE - 6) {}
        }
        (game::token(projections))
    }
}

/// Returns the upper left corner of a cell.
fn corner(projections: &Projections, row: i64, column: i64) -> Option<(usize, usize)> {
    let i = projections.rows().iter().position(|&r| r == row)?;
    let j = projections.columns().iter().position(|&c| c == column)?;
    Some((SIDE * j, SIDE * i))
}

/// Renders a cell; if it is `tiny`, without texts.
fn cell(
    layer: Layer<'_>,
    paint: &Paint<'_>,
    number: usize,
    has_texts: bool,
    x: usize,
    y: usize,
    found: &ViewCell,
) -> Markup {
    let look = match layer {
        Layer::Ranks(picture) => &paint.look(picture, found),
        Layer::Values(_) if found.is_unsafe => &Look::not_safe(),
        Layer::Values(looks) => &looks[number],
    };
    let arrows = match layer {
        Layer::Ranks(picture) if picture != Picture::Classes => Some(paint.arrows(picture, found)),
        _ => None,
    };
    // The circle of the start would cross a long text, which therefore has a rim in the colour of the cell.
    let halo = paint.projections.is_first(found.row, found.column).then_some(&look.fill);
    html! {
        g.cell.elsewhere[found.elsewhere].theirs[found.is_theirs] transform=(format!("translate({x},{y})")) data-row=(found.row) data-col=(found.column)
            data-value=(if found.elsewhere { "" } else { &look.text }) {
            @if matches!(layer, Layer::Ranks(Picture::Classes)) { title { (paint.named(found)) } }
            rect width=(SIDE) height=(SIDE) rx=[game::corners(found.is_theirs)] fill=(look.fill) {}
            @if paint.projections.is_first(found.row, found.column) { (start()) }
            @if !found.marks.is_empty() { (marks(paint, &found.marks)) }
            @if has_texts {
                @if look.squares.is_empty() {
                    text class=(format!("value s{}", axes::size(&look.text))) x=(SIDE / 2) y="26" fill=(look.ink) stroke=[halo] { (look.text) }
                } @else {
                    text.value.squares x=(SIDE / 2) y="26" fill=(look.ink) {
                        @for (fill, square) in look.squares.iter().zip(look.text.chars()) { tspan fill=(fill) { (square) } }
                    }
                }
                @if let Some(arrows) = arrows { path.arrows fill=(look.ink) d=(arrows) {} }
            }
        }
    }
}

/// Renders the marks of a cell: their glyphs in its corners, and for small cells one in the middle and a dot.
fn marks(paint: &Paint<'_>, marks: &[Placed]) -> Markup {
    let single = paint.marks.single(marks);
    let pale = marks.iter().all(|placed| placed.is_pale);
    html! {
        g.marks {
            text.corners {
                @for (corner, glyph, is_pale) in paint.marks.corners(marks) {
                    tspan.end[corner % 2 == 1].pale[is_pale] x=(if corner % 2 == 0 { 3 } else { SIDE - 3 }) y=(if corner < 2 { 11 } else { SIDE - 4 }) { (glyph) }
                }
            }
            text.single.pair[single.chars().count() > 1].pale[pale] x=(SIDE / 2) y="29" { (single) }
            path.dot.pale[pale] d=(if paint.marks.labels_only(marks) { LABEL } else { TARGET }) {}
        }
    }
}
