//! The data of the page's script: the diagram of the regions, and the meaning of its roots.

use serde_json::{Value as Json, json};

use super::heat::Heat;
use super::marks::Mark;
use super::paint::{MOST_SQUARES, Paint, UNSAFE, arrow};
use super::{Content, Picture, axes, game, map, palette};
use meliora_base::diagram::Edge;
use meliora_base::value::Type;
use meliora_export::projections::{Direction, Ladder, Projections};
use meliora_planning::Rank;

/// Returns the data as JSON for an HTML script element.
pub(super) fn script(content: &Content<'_>, paint: &Paint<'_>) -> String {
    let projections = paint.projections;
    let classes: Vec<Json> =
        projections.classes.iter().enumerate().map(|(i, c)| class(paint, i, c.1)).collect();
    let edges = |edges: &[Edge]| edges.iter().map(|e| e.number()).collect::<Vec<_>>();
    let choice = |c: &Direction| {
        let several = c.several.map(|edge| edge.number());
        json!({"name": c.name, "own": c.own, "several": several, "arrow": arrow(c, projections.rows_up)})
    };
    let run: Vec<&Vec<i64>> = content.run.iter().flat_map(|p| &p.states).collect();
    let data = json!({
        "variables": variables(projections),
        "row": projections.plane.row.map(|v| v.index()),
        "column": projections.plane.column.index(),
        "rows": projections.rows(),
        "columns": projections.columns(),
        "at": projections.at,
        "opening": paint.opening,
        "squares": MOST_SQUARES,
        "projected": projections.projected,
        "width": projections.diagram.variables.len(),
        "nodes": nodes(projections),
        "scope": projections.scope.number(),
        "unsafe": projections.unsafe_states.map(|edge| json!({
            "edge": edge.number(), "text": UNSAFE, "fill": palette::css(palette::UNSAFE), "ink": palette::ink(palette::UNSAFE),
        })),
        "sides": {"middle": axes::MIDDLE, "tiny": axes::TINY},
        "sasi": ladder(&projections.sasi, paint, Picture::Sasi),
        "spi": ladder(&projections.spi, paint, Picture::Spi),
        "classes": classes,
        "objectives": content.preferences.objectives.iter().map(|o| o.name.as_str()).collect::<Vec<_>>(),
        "targets": edges(&projections.targets),
        "dots": [map::TARGET, map::LABEL],
        "marks": paint.marks.0.iter().map(mark).collect::<Vec<_>>(),
        "labels": projections.labels.iter().map(|(name, edge)| json!({"name": name, "edge": edge.number()})).collect::<Vec<_>>(),
        "chain": content.check.header.is_chain(),
        "choices": projections.choices.iter().map(choice).collect::<Vec<_>>(),
        "play": run,
        "game": game::data(projections),
        "heat": content.heat().as_ref().map(Heat::data),
    });
    meliora_base::json::script(&data).unwrap_or_default()
}

fn variables(projections: &Projections) -> Vec<Json> {
    let mut all = Vec::new();
    for ((v, levels), facts) in projections.variables.iter().zip(&projections.levels).zip(&projections.facts)
    {
        let boolean = v.ty == Type::Bool;
        let (low, high) = (v.low, v.high);
        let names = &v.values;
        all.push(json!({"name": v.name, "bool": boolean, "low": low, "high": high, "names": names, "levels": levels, "facts": facts}));
    }
    all
}

/// Returns three numbers per node: its level, and the arcs for true and for false.
fn nodes(projections: &Projections) -> Vec<i64> {
    let three = |n: &meliora_dump::Node| {
        [i64::from(n.level), i64::from(n.then.number()), i64::from(n.otherwise.number())]
    };
    projections.diagram.nodes.iter().flat_map(three).collect()
}

fn mark(mark: &Mark) -> Json {
    json!({"glyph": mark.glyph, "target": mark.is_target, "edge": mark.edge.number(), "wide": mark.is_wide})
}

fn class(paint: &Paint<'_>, index: usize, edge: Edge) -> Json {
    let (color, ink) = paint.class(index);
    json!({
        "name": paint.names[index],
        "mark": paint.texts[index],
        "size": axes::size(&paint.texts[index]),
        "fill": palette::css(color),
        "ink": ink,
        "edge": edge.number(),
    })
}

fn ladder(ladder: &Ladder, paint: &Paint<'_>, picture: Picture) -> Json {
    let most = paint.most(picture);
    let color = |rank: Rank| {
        let color = palette::rank(rank, most);
        json!({"fill": palette::css(color), "ink": palette::ink(color)})
    };
    json!({
        "levels": ladder.levels.iter().map(|e| e.number()).collect::<Vec<_>>(),
        "unbounded": ladder.unbounded.map(Edge::number),
        "open": ladder.open,
        "permitted": ladder.permitted.iter().map(|e| e.number()).collect::<Vec<_>>(),
        "colors": (0..=ladder.levels.len()).map(|k| color(Rank::Finite(k))).collect::<Vec<_>>(),
        "unboundedColor": color(Rank::Unbounded),
    })
}
