//! Plots of the results of a sweep: one panel per result, with curves over a constant.

use maud::{Markup, html};
use meliora_base::escape;

use super::page::drawing::{self, color, paper};

/// Size of the frame of a panel, in pixels.
const FRAME: (f64, f64) = (340.0, 200.0);
/// Room for the labels left of a frame, above it, right of it and below it.
const ROOM: (f64, f64, f64, f64) = (78.0, 34.0, 24.0, 44.0);
/// Number of panels in a row.
const ACROSS: usize = 2;
/// Maximum number of ticks on an axis, roughly.
const TICKS: usize = 6;
/// The ratio of the greatest and the least number from which an axis is logarithmic.
const WIDE: f64 = 1000.0;
/// Maximum number of characters of a title.
const TITLE: usize = 48;

/// A plot of several results over the values of one constant.
#[derive(Debug, Clone, PartialEq)]
pub struct Plot {
    /// The name of the constant.
    pub constant: String,
    /// Its values, in their order.
    pub values: Vec<String>,
    /// The results.
    pub panels: Vec<Panel>,
}

/// One result.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// The name of the result.
    pub title: String,
    /// Curves, with a name if there are several.
    pub curves: Vec<Curve>,
}

/// The results for some values of the other constants.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// The values of the other constants.
    pub name: String,
    /// The results.
    pub points: Vec<Point>,
}

/// The result of one instance, between two bounds; a verdict is 0 or 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// The position of the constant's value.
    pub at: usize,
    /// The lower bound, which may be infinite.
    pub lower: f64,
    /// The upper bound.
    pub upper: f64,
}

impl Plot {
    /// Draws the plot as a file.
    pub fn svg(&self) -> String {
        let names: Vec<&str> =
            self.panels.first().iter().flat_map(|panel| &panel.curves).map(|curve| &*curve.name).collect();
        let legend = if names.len() > 1 { names } else { Vec::new() };
        let (across, rows) = (ACROSS.min(self.panels.len()).max(1), self.panels.len().div_ceil(ACROSS));
        let cell = (ROOM.0 + FRAME.0 + ROOM.2, ROOM.1 + FRAME.1 + ROOM.3);
        let (width, below) = (cell.0 * across as f64, cell.1 * rows as f64);
        let beside = (width / 160.0).max(1.0) as usize;
        let height = below + 22.0 * legend.len().div_ceil(beside) as f64;
        let horizontal = self.horizontal();
        let drawn = html! {
            svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width} {height}")) width=(width) height=(height) {
                (drawing::style())
                (paper(width as usize, height as usize))
                @for (index, panel) in self.panels.iter().enumerate() {
                    @let (x, y) = ((index % ACROSS) as f64 * cell.0 + ROOM.0, (index / ACROSS) as f64 * cell.1 + ROOM.1);
                    g transform=(format!("translate({x},{y})")) { (self.panel(panel, &horizontal)) }
                }
                @for (index, name) in legend.iter().enumerate() {
                    @let (x, y) = ((index % beside) as f64 * 160.0 + 10.0, (index / beside) as f64 * 22.0 + below);
                    g transform=(format!("translate({x},{y})")) {
                        line x1="0" y1="8" x2="22" y2="8" stroke=(color(index)) stroke-width="2" {}
                        circle cx="11" cy="8" r="3" fill=(color(index)) {}
                        text.small x="28" y="12" { (name) }
                    }
                }
            }
        };
        escape::lines(&drawn.into_string()).into_owned()
    }

    /// Returns the axis of the constant: one of numbers if all values are numbers.
    fn horizontal(&self) -> Axis {
        let numbers: Option<Vec<f64>> = self.values.iter().map(|value| value.parse().ok()).collect();
        let is_short = self.values.len() <= 2 * TICKS;
        match numbers {
            Some(numbers) if is_short => {
                let ticks = numbers.iter().copied().zip(self.values.iter().cloned()).collect();
                Axis { ticks, ..Axis::new(&numbers, false) }
            }
            Some(numbers) => Axis::new(&numbers, false),
            None => {
                let every = self.values.len().div_ceil(2 * TICKS);
                let ticks = self.values.iter().enumerate().step_by(every);
                let ticks = ticks.map(|(at, value)| (at as f64, value.clone())).collect();
                Axis { low: 0.0, high: (self.values.len() - 1).max(1) as f64, is_log: false, ticks }
            }
        }
    }

    /// Returns the place of the value at a position.
    fn across(&self, horizontal: &Axis, at: usize) -> f64 {
        let is_numeric = self.values.iter().all(|value| value.parse::<f64>().is_ok());
        let number = self.values.get(at).and_then(|value| value.parse().ok()).filter(|_| is_numeric);
        horizontal.share(number.unwrap_or(at as f64)) * FRAME.0
    }

    fn panel(&self, panel: &Panel, horizontal: &Axis) -> Markup {
        let vertical = panel.vertical();
        let up = |y: f64| if y == f64::INFINITY { 0.0 } else { (1.0 - vertical.share(y)) * FRAME.1 };
        html! {
            text.small x="0" y="-12" { title { (panel.title) } (shortened(&panel.title)) }
            @for (y, label) in &vertical.ticks {
                line x1="0" y1=(place(up(*y))) x2=(FRAME.0) y2=(place(up(*y))) stroke="currentColor" stroke-opacity="0.15" {}
                text.axis x="-8" y=(place(up(*y) + 4.0)) style="text-anchor:end;font-size:12px" { (label) }
            }
            @for (x, label) in &horizontal.ticks {
                text.axis x=(place(horizontal.share(*x) * FRAME.0)) y=(FRAME.1 + 18.0) style="font-size:12px" { (label) }
            }
            text.axis x=(FRAME.0 / 2.0) y=(FRAME.1 + 36.0) style="font-size:12px" { (self.constant) }
            rect width=(FRAME.0) height=(FRAME.1) fill="none" stroke="currentColor" stroke-opacity="0.6" {}
            @for (index, curve) in panel.curves.iter().enumerate() {
                g.curve { (self.curve(curve, &color(index), &|at| self.across(horizontal, at), &up)) }
            }
        }
    }

    /// Draws a line through the middles of the results, and a mark for each with its bounds. An
    /// infinite result is a triangle at the top.
    fn curve(
        &self,
        curve: &Curve,
        color: &str,
        across: &dyn Fn(usize) -> f64,
        up: &dyn Fn(f64) -> f64,
    ) -> Markup {
        let middle = |point: &Point| (up(point.lower) + up(point.upper)) / 2.0;
        html! {
            @for run in runs(&curve.points) {
                @let line: Vec<String> = run.iter().map(|p| format!("{},{}", place(across(p.at)), place(middle(p)))).collect();
                polyline points=(line.join(" ")) fill="none" stroke=(color) stroke-width="2" {}
            }
            @for point in &curve.points {
                @let (x, y) = (across(point.at), middle(point));
                g {
                    title { (self.told(curve, point)) }
                    @if point.lower == f64::INFINITY {
                        path d=(format!("M{} 2l6 10h-12z", place(x))) fill=(color) {}
                    } @else {
                        @if (up(point.lower) - up(point.upper)).abs() > 1.0 {
                            line x1=(place(x)) x2=(place(x)) y1=(place(up(point.lower))) y2=(place(up(point.upper))) stroke=(color) stroke-width="2" {}
                        }
                        circle cx=(place(x)) cy=(place(y)) r="3.5" fill=(color) {}
                    }
                }
            }
        }
    }

    /// Returns the words of a result: `N=3, T=4: 0.5`.
    fn told(&self, curve: &Curve, point: &Point) -> String {
        let value = self.values.get(point.at).map_or("", String::as_str);
        let others = if curve.name.is_empty() { String::new() } else { format!(", {}", curve.name) };
        let [lower, upper] = [point.lower, point.upper].map(number);
        let result = if lower == upper { lower } else { format!("{lower} to {upper}") };
        format!("{}={value}{others}: {result}", self.constant)
    }
}

impl Panel {
    /// Returns the axis of the results.
    fn vertical(&self) -> Axis {
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let bounds: Vec<f64> = points().flat_map(|p| [p.lower, p.upper]).filter(|y| y.is_finite()).collect();
        Axis::new(&bounds, true)
    }
}

/// Returns the longest parts of consecutive finite results.
fn runs(points: &[Point]) -> impl Iterator<Item = &[Point]> {
    points
        .chunk_by(|a, b| a.at + 1 == b.at && a.upper.is_finite() && b.upper.is_finite())
        .filter(|run| run.len() > 1)
}

/// The range of an axis, with the places of its labels.
struct Axis {
    low: f64,
    high: f64,
    is_log: bool,
    ticks: Vec<(f64, String)>,
}

impl Axis {
    /// Returns the axis of some numbers. If it shows results, it begins at 0, or is logarithmic.
    fn new(numbers: &[f64], shows_results: bool) -> Self {
        let least = numbers.iter().copied().fold(f64::INFINITY, f64::min);
        let most = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if !least.is_finite() {
            return Axis::linear(0.0, 1.0);
        }
        if shows_results && least > 0.0 && most / least >= WIDE {
            return Axis::logarithmic(least, most);
        }
        let low = if shows_results { least.min(0.0) } else { least };
        Axis::linear(low, if most > low { most } else { low + 1.0 })
    }

    fn linear(low: f64, high: f64) -> Self {
        let rough = (high - low) / TICKS as f64;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * power).find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * power);
        let (first, last) = ((low / step).ceil() as i64, (high / step + 1e-9).floor() as i64);
        let ticks = (first..=last).map(|k| (k as f64 * step, number(k as f64 * step))).collect();
        Axis { low, high, is_log: false, ticks }
    }

    fn logarithmic(least: f64, most: f64) -> Self {
        let (first, last) = (least.log10().floor() as i32, most.log10().ceil() as i32);
        let every = (last - first).max(1).unsigned_abs().div_ceil(TICKS as u32) as usize;
        let ticks = (first..=last).step_by(every).map(|k| (10f64.powi(k), format!("1e{k}"))).collect();
        Axis { low: 10f64.powi(first), high: 10f64.powi(last), is_log: true, ticks }
    }

    /// Returns the place of a number between the ends of the axis, which are 0 and 1.
    fn share(&self, x: f64) -> f64 {
        match self.is_log {
            true => (x / self.low).ln() / (self.high / self.low).ln(),
            false => (x - self.low) / (self.high - self.low),
        }
    }
}

/// Formats a number with six significant digits.
fn number(x: f64) -> String {
    meliora_base::decimal::rounded(x)
}

/// Formats a place in pixels.
fn place(x: f64) -> String {
    meliora_base::decimal::readable((x * 100.0).round() / 100.0)
}

fn shortened(title: &str) -> String {
    match title.chars().count() > TITLE {
        true => title.chars().take(TITLE - 1).chain(['…']).collect(),
        false => title.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(at: usize, y: f64) -> Point {
        Point { at, lower: y, upper: y }
    }

    fn plot(values: &[&str], points: Vec<Point>) -> Plot {
        let curves = vec![Curve { name: String::new(), points }];
        let panels = vec![Panel { title: "Pmax=? [ F a<b ]".to_owned(), curves }];
        Plot { constant: "N".to_owned(), values: values.iter().map(|v| (*v).to_owned()).collect(), panels }
    }

    #[test]
    fn greater_results_are_higher_and_greater_values_further_right() {
        let svg = plot(&["1", "2", "4"], vec![point(0, 0.0), point(1, 0.5), point(2, 1.0)]).svg();
        assert!(svg.contains("points=\"0,200 113.33,100 340,0\""), "{svg}");
        assert!(svg.contains("<title>N=2: 0.5</title>") && svg.contains("F a&lt;b"), "{svg}");
    }

    #[test]
    fn a_line_ends_where_a_result_is_missing_or_infinite() {
        let points =
            vec![point(0, 1.0), point(1, 2.0), point(3, 3.0), point(4, f64::INFINITY), point(5, 4.0)];
        let svg = plot(&["1", "2", "3", "4", "5", "6"], points).svg();
        assert_eq!((svg.matches("<polyline").count(), svg.matches("<circle").count()), (1, 4), "{svg}");
        assert_eq!(svg.matches("<path").count(), 1, "{svg}");
        assert!(svg.contains("<title>N=5: inf</title>"), "{svg}");
    }

    #[test]
    fn values_that_are_not_numbers_stand_side_by_side() {
        let svg = plot(&["true", "false"], vec![point(0, 3.0), point(1, 4.0)]).svg();
        assert!(svg.contains("points=\"0,50 340,0\"") && svg.contains(">false<"), "{svg}");
    }

    #[test]
    fn results_of_very_different_sizes_are_on_a_logarithmic_axis() {
        let svg = plot(&["1", "2"], vec![point(0, 10.0), point(1, 100_000.0)]).svg();
        assert!(svg.contains("points=\"0,200 340,0\"") && svg.contains(">1e3<"), "{svg}");
    }

    #[test]
    fn bounds_that_differ_are_a_line() {
        let bounds = Point { at: 0, lower: 0.25, upper: 1.0 };
        let svg = plot(&["1", "2"], vec![bounds]).svg();
        assert!(svg.contains("y1=\"150\" y2=\"0\"") && svg.contains("0.25 to 1"), "{svg}");
    }

    #[test]
    fn a_plot_without_results_has_axes() {
        for values in [&["7"][..], &["a"], &["1", "2"]] {
            let svg = plot(values, Vec::new()).svg();
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }
}
