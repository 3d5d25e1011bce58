//! The plot of a sweep: one panel per result, over the values of the first constant that varies.

use std::collections::BTreeMap;
use std::path::Path;

use meliora_base::error::Error;
use meliora_report::plot::{Curve, Panel, Plot, Point};

use super::super::files::Target;
use super::super::ranges::{Range, instance};
use super::row::Job;

/// The file of a plot, and the rows that it will show.
pub(super) struct Plotted {
    target: Target,
    /// The position of the constant among the ranges.
    constant: usize,
    /// The cells after the constants, by the position of their instance.
    pub(super) rows: BTreeMap<usize, Vec<String>>,
}

impl Plotted {
    /// Checks the file and selects the constant.
    ///
    /// # Errors
    /// The file cannot be written, or no constant varies.
    pub(super) fn new(path: &Path, inputs: &[&Path], ranges: &[Range]) -> Result<Self, Error> {
        if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("svg")) {
            let message = "`--plot` draws SVG; give the name of a file that ends with `.svg`";
            return Err(Error::Usage(message.to_owned()));
        }
        let Some(constant) = ranges.iter().position(|range| range.varies) else {
            let message = "`--plot` shows results over a constant; give one a range, such as `-c N=1:5`";
            return Err(Error::Usage(message.to_owned()));
        };
        Ok(Plotted { target: Target::new(path, inputs)?, constant, rows: BTreeMap::new() })
    }

    /// Writes the plot of the rows.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn write(&self, ranges: &[Range], kind: &Job) -> Result<(), Error> {
        self.target.write(&self.plot(ranges, kind).svg())
    }

    fn plot(&self, ranges: &[Range], kind: &Job) -> Plot {
        let curves = self.curves(ranges);
        let titles: Vec<&str> = kind.columns().collect();
        let curve = |found: &Found<'_>, column: usize| Curve {
            name: found.name.clone(),
            points: found.rows.iter().filter_map(|(at, cells)| point(*at, &cells[column])).collect(),
        };
        let panel = |column: usize| Panel {
            title: titles[column].to_owned(),
            curves: curves.iter().map(|found| curve(found, column)).collect(),
        };
        let panels = kind.plotted().into_iter().map(panel).collect();
        let constant = &ranges[self.constant];
        Plot { constant: constant.name.clone(), values: constant.values.clone(), panels }
    }

    /// Groups the rows by the values of the other constants, in the order of the instances.
    fn curves(&self, ranges: &[Range]) -> Vec<Found<'_>> {
        let mut curves: Vec<Found<'_>> = Vec::new();
        for (&position, cells) in &self.rows {
            let values = instance(ranges, position);
            let name = self.name(ranges, &values);
            let mut known = ranges[self.constant].values.iter();
            let at = known.position(|value| *value == values[self.constant]).unwrap_or(0);
            match curves.iter_mut().find(|found| found.name == name) {
                Some(found) => found.rows.push((at, cells)),
                None => curves.push(Found { name, rows: vec![(at, cells)] }),
            }
        }
        curves.iter_mut().for_each(|found| found.rows.sort_by_key(|(at, _)| *at));
        curves
    }

    /// Returns the values of the other constants that vary.
    fn name(&self, ranges: &[Range], values: &[&str]) -> String {
        let others = ranges.iter().zip(values).enumerate();
        let others = others.filter(|(at, (range, _))| range.varies && *at != self.constant);
        others.map(|(_, (range, value))| format!("{}={value}", range.name)).collect::<Vec<_>>().join(", ")
    }
}

/// The rows with the same values of the other constants.
struct Found<'a> {
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
