//! Maps as separate drawings, with a title and a legend.

use maud::{Markup, html};

use super::axes::{self, Sizes};
use super::drawing::{paper, style};
use super::letters::{LONGEST, shortened, width as text_width};
use super::map::{self, Layer};
use super::marks::{MORE, SEVERAL};
use super::paint::{Paint, SIDE};
use super::{Content, Picture, game, palette};
use meliora_export::projections::Projections;

/// The font size of the legend, and the height of its lines.
const FONT: f64 = 12.0;
const LINE: f64 = 20.0;

/// An entry of the legend: a colour or a glyph, and its meaning.
struct Entry {
    fill: Option<String>,
    glyph: String,
    label: String,
    is_pale: bool,
}

impl Entry {
    fn width(&self) -> f64 {
        22.0 + FONT * text_width(&self.label) + 10.0
    }
}

/// Renders a map.
pub(super) fn svg(content: &Content<'_>, projections: &Projections, picture: Picture) -> Markup {
    let (paint, sizes) = (Paint::new(content, projections), Sizes::alone(projections));
    let legend = legend(content, &paint, sizes, picture);
    let view = map::view_text(projections, &paint.opening);
    let view: Vec<String> = view.split_inclusive(", ").map(str::to_owned).collect();
    let names = axes::names(projections).into_iter().map(|name| name + "  ").collect::<Vec<_>>();
    let entries: Vec<f64> = legend.iter().map(Entry::width).collect();
    let (rows, columns) = (projections.rows().len() as f64, projections.columns().len() as f64);
    let all = [widths(&view), widths(&names), entries.clone()].concat();
    let width = all.into_iter().fold(320.0, f64::max).max(sizes.left + columns * sizes.side + 4.0).ceil();
    let (view, names, places) = (lines(&view, width), lines(&names, width), flow(&entries, width));
    let (values, under) = axes::alone(projections, sizes);
    let top = 32.0 + 16.0 * view.len() as f64;
    let below = top + rows * sizes.side + under;
    let foot = below + 16.0 * names.len() as f64 + 10.0;
    let height = (foot + LINE * places.last().map_or(0.0, |place| place.1 + 1.0) + 4.0).ceil();
    html! {
        svg xmlns="http://www.w3.org/2000/svg" width=(width) height=(height) viewBox=(format!("0 0 {width} {height}")) {
            (style())
            (paper(width as usize, height as usize))
            text.title x="4" y="20" { (picture.title()) }
            @for (line, text) in view.iter().enumerate() { text.small x="4" y=(38 + 16 * line) { (text) } }
            g transform=(format!("translate(0,{top})")) {
                (values)
                g class=(axes::detail(sizes.side, paint.smallest(picture))) transform=(format!("translate({},0) scale({:.4})", sizes.left, sizes.side / SIDE as f64)) {
                    (map::cells(Layer::Ranks(picture), &paint, sizes))
                }
            }
            @for (line, text) in names.iter().enumerate() { text.small x="4" y=(below + 12.0 + 16.0 * line as f64) { (text) } }
            @for ((x, line), entry) in places.iter().zip(&legend) {
                g transform=(format!("translate({},{})", x + 4.0, foot + LINE * line)) {
                    @if let Some(fill) = &entry.fill { rect.swatch width="14" height="14" fill=(fill) {} }
                    @else { text.glyph.pale[entry.is_pale] x="7" y="12" { (entry.glyph) } }
                    text.small x="20" y="12" { (entry.label) }
                }
            }
        }
    }
}

/// Returns everything that the map shows.
fn legend(content: &Content<'_>, paint: &Paint<'_>, sizes: Sizes, picture: Picture) -> Vec<Entry> {
    let colour = |(color, label): (_, String)| Entry {
        fill: Some(palette::css(color)),
        glyph: String::new(),
        label: shortened(&label, 2 * LONGEST),
        is_pale: false,
    };
    let glyph =
        |glyph: &str, label: String| Entry { fill: None, glyph: glyph.to_owned(), label, is_pale: false };
    let found = || paint.cells.iter().flatten();
    let mut legend: Vec<Entry> =
        paint.legend(picture).into_iter().chain(paint.unsafe_legend()).map(colour).collect();
    if found().any(|found| found.is_wall()) {
        legend.push(Entry { fill: Some("url(#wall)".to_owned()), ..glyph("", "unreachable".to_owned()) });
    }
    legend.push(glyph("○", "start".to_owned()));
    for (number, mark) in paint.marks.0.iter().enumerate() {
        if found().any(|found| found.has(number)) {
            let what = if mark.is_target { "target of " } else { "" };
            let dot = SEVERAL[usize::from(!mark.is_target)];
            let own = if sizes.side < axes::TINY { dot } else { &mark.glyph };
            legend.push(glyph(own, format!("{what}{}", shortened(&mark.name, LONGEST))));
        }
    }
    if let (true, Some(mark)) = (paint.has_pale(), paint.marks.0.first()) {
        legend.push(Entry { is_pale: true, ..glyph(&mark.glyph, "with other values".to_owned()) });
    }
    let crowded = |most: usize| found().any(|found| found.marks.len() > most);
    match sizes.side {
        side if side >= axes::MIDDLE && crowded(4) => legend.push(glyph(MORE, "further marks".to_owned())),
        side if (axes::TINY..axes::MIDDLE).contains(&side) && crowded(1) => {
            let several = ["several marks", "several labels"].map(str::to_owned);
            legend.extend(SEVERAL.into_iter().zip(several).map(|(dot, text)| glyph(dot, text)));
        }
        _ => {}
    }
    let players = game::legend(&content.check.players);
    legend.extend(players.map(|(sign, text)| glyph(sign, text)));
    legend
}

fn widths(texts: &[String]) -> Vec<f64> {
    texts.iter().map(|text| FONT * text_width(text) + 8.0).collect()
}

/// Joins texts to lines of a width.
fn lines(texts: &[String], room: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for ((x, _), text) in flow(&widths(texts), room).into_iter().zip(texts) {
        match lines.last_mut() {
            Some(line) if x > 0.0 => line.push_str(text),
            _ => lines.push(text.clone()),
        }
    }
    lines
}

/// Puts items of these widths next to each other as long as there is room. Returns the start of each item
/// and the number of its line.
fn flow(widths: &[f64], room: f64) -> Vec<(f64, f64)> {
    let (mut x, mut line) = (0.0, 0.0);
    let mut places = Vec::new();
    for width in widths {
        if x > 0.0 && x + width > room {
            (x, line) = (0.0, line + 1.0);
        }
        places.push((x, line));
        x += width;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::flow;

    #[test]
    fn items_that_have_no_room_begin_a_line() {
        assert_eq!(
            flow(&[60.0, 30.0, 20.0, 200.0], 100.0),
            [(0.0, 0.0), (60.0, 0.0), (0.0, 1.0), (0.0, 2.0)]
        );
    }
}
