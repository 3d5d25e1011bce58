//! The plot of a sweep: one panel per result, over the values of the first constant that varies.

use std::collections::BTreeMap;

use meliora_report::plot::{Curve, Panel, Plot, Point};

use super::columns::Columns;
use super::ranges::{Range, instance};

/// The cells after the constants, by the position of their instance.
pub type Rows = BTreeMap<usize, Vec<String>>;

/// Draws rows over the first constant with several values; `None` if there is none.
pub fn plot(ranges: &[Range], columns: &Columns, rows: &Rows) -> Option<Plot> {
    let constant = ranges.iter().position(|range| range.varies)?;
    let curves = curves(ranges, constant, rows);
    let titles: Vec<&str> = columns.names().collect();
    let curve = |found: &CurveRows<'_>, column: usize| Curve {
        name: found.name.clone(),
        points: found.rows.iter().filter_map(|(at, cells)| point(*at, &cells[column])).collect(),
    };
    let panel = |column: usize| Panel {
        title: titles[column].to_owned(),
        curves: curves.iter().map(|found| curve(found, column)).collect(),
    };
    let panels = columns.plotted().into_iter().map(panel).collect();
    let Range { name, values, .. } = &ranges[constant];
    Some(Plot { constant: name.clone(), values: values.clone(), panels })
}

/// Groups the rows by the values of the other constants, in the order of the instances.
fn curves<'r>(ranges: &[Range], constant: usize, rows: &'r Rows) -> Vec<CurveRows<'r>> {
    let mut curves: Vec<CurveRows<'_>> = Vec::new();
    for (&position, cells) in rows {
        let values = instance(ranges, position);
        let others = ranges.iter().zip(&values).enumerate();
        let others = others.filter(|(at, (range, _))| range.varies && *at != constant);
        let named = others.map(|(_, (range, value))| format!("{}={value}", range.name));
        let name = named.collect::<Vec<_>>().join(", ");
        let mut known = ranges[constant].values.iter();
        let at = known.position(|value| *value == values[constant]).unwrap_or(0);
        match curves.iter_mut().find(|found| found.name == name) {
            Some(found) => found.rows.push((at, cells)),
            None => curves.push(CurveRows { name, rows: vec![(at, cells)] }),
        }
    }
    curves.iter_mut().for_each(|found| found.rows.sort_by_key(|(at, _)| *at));
    curves
}

/// The rows with the same values of the other constants.
struct CurveRows<'a> {
    name: String,
    /// The cells, each with the position of the value of the constant.
    rows: Vec<(usize, &'a [String])>,
}

/// Returns the point of a cell; `None` if it has no number.
fn point(at: usize, cell: &str) -> Option<Point> {
    let number = |text: &str| match text {
        "true" => Some(1.0),
        "false" => Some(0.0),
        "unbounded" => Some(f64::INFINITY),
        _ => text.parse::<f64>().ok(),
    };
    let (lower, upper) = cell.split_once("..").unwrap_or((cell, cell));
    Some(Point { at, lower: number(lower)?, upper: number(upper)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_points() {
        let bounds = |cell| point(0, cell).map(|p| (p.lower, p.upper));
        assert_eq!(bounds("0.25..0.5"), Some((0.25, 0.5)));
        assert_eq!(bounds("12"), Some((12.0, 12.0)));
        assert_eq!(bounds("true"), Some((1.0, 1.0)));
        assert_eq!(bounds("unbounded"), Some((f64::INFINITY, f64::INFINITY)));
        assert_eq!(bounds("1..inf"), Some((1.0, f64::INFINITY)));
        for cell in ["", "no value", "not answered"] {
            assert_eq!(bounds(cell), None, "{cell}");
        }
    }
}
