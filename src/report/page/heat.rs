//! Values of all states: heat maps of probabilities and costs, over the plane of the rank maps.

use std::cmp::Ordering;

use ahash::AHashMap;
use serde_json::{Value as Json, json};

use super::paint::Look;
use super::palette::{self, Rgb};
use super::{axes, words};
use meliora_export::projections::{Projections, View};
use meliora_quantities::all_states::AllStates;

/// Maximum number of improvements with maps of their own.
const MOST_MAPS: usize = 3;

/// A map of values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Measure {
    /// P_k
    Probability(usize),
    /// C_k, in steps.
    Steps(usize),
}

/// The values of the states of the scope, and the maps that show them.
pub(crate) struct Heat<'a> {
    all: &'a AllStates,
    pub(super) tables: Vec<Table>,
}

/// The looks of the values of a map. Values with the same text look the same.
pub(super) struct Table {
    pub(super) measure: Measure,
    /// The least and the greatest value over all states.
    range: (f64, f64),
    /// The looks from the best value to the worst; the last one belongs to states without a value.
    pub(super) looks: Vec<Look>,
    /// The position of the look of each state.
    of_states: Vec<usize>,
}

impl<'a> Heat<'a> {
    /// Selects the maps of these values.
    pub(super) fn new(all: &'a AllStates) -> Self {
        Heat { all, tables: telling(all).into_iter().map(|measure| Table::new(all, measure)).collect() }
    }

    /// Returns the looks of the cells of some views, one list per measure.
    pub(super) fn looks(&self, projections: &Projections, views: &[Option<View>]) -> Vec<Vec<Look>> {
        let plane = |values: &dyn Fn(usize) -> Option<i64>| {
            (projections.plane.row.map(|row| values(row.index())), values(projections.plane.column.index()))
        };
        let mut index: AHashMap<_, Vec<usize>> = AHashMap::new();
        for (number, state) in self.all.states.iter().enumerate() {
            index.entry(plane(&|at| Some(state[at]))).or_default().push(number);
        }
        let look = |table: &Table, view: &Option<View>| {
            let Some(view) = view else { return Look::wall() };
            let fits = |number: &&usize| {
                view.iter()
                    .zip(&self.all.states[**number])
                    .all(|(wanted, value)| wanted.is_none_or(|w| w == *value))
            };
            let here = index.get(&plane(&|at| view[at])).into_iter().flatten().filter(fits);
            let best = here.map(|&number| table.of_states[number]).min();
            table.looks[best.unwrap_or(table.looks.len() - 1)].clone()
        };
        self.tables.iter().map(|table| views.iter().map(|view| look(table, view)).collect()).collect()
    }

    /// Returns the data of the page's script.
    pub(super) fn data(&self) -> Json {
        let look = |look: &Look| json!({"text": look.text, "size": axes::size(&look.text), "fill": look.fill, "ink": look.ink});
        let one = |table: &Table| {
            let (id, title) = (table.measure.id(), table.measure.title());
            let looks: Vec<Json> = table.looks.iter().map(look).collect();
            json!({"id": id, "title": title, "looks": looks, "all": table.of_states})
        };
        json!({"states": self.all.states, "measures": self.tables.iter().map(one).collect::<Vec<_>>()})
    }
}

impl Table {
    fn new(all: &AllStates, measure: Measure) -> Self {
        let values: Vec<Option<f64>> = (0..all.states.len()).map(|state| measure.of(all, state)).collect();
        let range = match measure {
            Measure::Probability(_) => (0.0, 1.0),
            Measure::Steps(_) => {
                let known = values.iter().flatten();
                known.fold((f64::INFINITY, 0.0_f64), |(low, high), &x| (low.min(x), high.max(x)))
            }
        };
        let mut order: Vec<usize> = (0..values.len()).collect();
        order.sort_by(|&a, &b| measure.compare(values[a], values[b]));
        let mut table = Table { measure, range, looks: Vec::new(), of_states: vec![0; values.len()] };
        for state in order {
            let look = match values[state] {
                Some(x) => Look::scaled(measure.share(x, range), measure.text(x)),
                None => measure.nothing(),
            };
            if table.looks.last().is_none_or(|last| last.text != look.text) {
                table.looks.push(look);
            }
            table.of_states[state] = table.looks.len() - 1;
        }
        if table.looks.last().is_none_or(|last| last.text != measure.nothing().text) {
            table.looks.push(measure.nothing());
        }
        table
    }

    /// Returns the meaning of the colours.
    pub(super) fn legend(&self) -> Vec<(Rgb, String)> {
        let (low, high) = self.range;
        let parts = if low == high { 1 } else { 5 };
        let value = |i: usize| low + (high - low) * i as f64 / (parts - 1).max(1) as f64;
        let one = |x: f64| match self.measure {
            Measure::Probability(_) if x == 0.0 => (palette::NONE, "0".to_owned()),
            measure => (palette::scale(measure.share(x, self.range)), digits(x)),
        };
        let mut all: Vec<_> = (0..parts).map(|i| one(value(i))).collect();
        if let Measure::Steps(_) = self.measure {
            all.push((palette::NONE, "– not certain".to_owned()));
        }
        all
    }
}

/// Returns the measures that say more than the ranks: probabilities other than 0 and 1, and steps.
fn telling(all: &AllStates) -> Vec<Measure> {
    let levels = all.values.options().levels;
    let open = |k: &usize| all.probabilities.iter().any(|p| p[k - 1] > 0.0 && p[k - 1] < 1.0);
    let certain = |k: &usize| all.costs.iter().any(|c| c[k - 1].is_some());
    let probabilities = (1..=levels).filter(open).take(MOST_MAPS).map(Measure::Probability);
    probabilities.chain((1..=levels).filter(certain).take(MOST_MAPS).map(Measure::Steps)).collect()
}

impl Measure {
    pub(super) fn id(self) -> String {
        match self {
            Measure::Probability(k) => format!("p{k}"),
            Measure::Steps(k) => format!("c{k}"),
        }
    }

    pub(super) fn title(self) -> String {
        match self {
            Measure::Probability(k) => format!("Probability of {}", words::improvements(k)),
            Measure::Steps(k) => format!("Steps until {}", words::improvements(k)),
        }
    }

    pub(super) fn hint(self) -> &'static str {
        match self {
            Measure::Probability(_) => "at best",
            Measure::Steps(_) => "expected, if certain",
        }
    }

    /// Returns the value of a state; `None` if there is none, or if it is zero.
    fn of(self, all: &AllStates, state: usize) -> Option<f64> {
        match self {
            Measure::Probability(k) => all.probabilities[state].get(k - 1).copied().filter(|&p| p > 0.0),
            Measure::Steps(k) => all.costs[state].get(k - 1).copied().flatten(),
        }
    }

    /// Returns the look of states without a value.
    fn nothing(self) -> Look {
        Look::none(if matches!(self, Measure::Steps(_)) { "–" } else { "0" }.to_owned())
    }

    /// Puts better values first, and no value last.
    fn compare(self, a: Option<f64>, b: Option<f64>) -> Ordering {
        let (Some(x), Some(y)) = (a, b) else { return a.is_none().cmp(&b.is_none()) };
        if let Measure::Steps(_) = self { x.total_cmp(&y) } else { y.total_cmp(&x) }
    }

    /// Returns a value in words. Only of a probability it matters that it is less than 1.
    fn text(self, x: f64) -> String {
        match self {
            Measure::Steps(_) if x > 0.995 && x < 1.0 => digits(1.0),
            _ => digits(x),
        }
    }

    /// Returns the place on the colour scale: likely and soon are dark.
    fn share(self, x: f64, (low, high): (f64, f64)) -> f64 {
        let share = if high > low { (x - low) / (high - low) } else { 0.0 };
        match self {
            Measure::Probability(_) => share,
            Measure::Steps(_) => 1.0 - share,
        }
    }
}

/// Formats a value in at most five characters: `0.41`, `11.4`, `120`.
pub(super) fn digits(x: f64) -> String {
    let plain = |decimals: usize| {
        let text = format!("{x:.decimals$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    };
    match x {
        x if x > 0.0 && x < 0.005 => format!("{x:.0e}"),
        x if x > 0.995 && x < 1.0 => ">0.99".to_owned(),
        x if x < 1.0 => plain(2),
        x if x < 100.0 => plain(1),
        x if x < 1e5 => plain(0),
        x => format!("{x:.0e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_shortened_to_fit_a_cell() {
        for (x, text) in [
            (0.0, "0"),
            (0.065_843_6, "0.07"),
            (1e-9, "1e-9"),
            (0.999_9, ">0.99"),
            (1.0, "1"),
            (11.44, "11.4"),
            (120.6, "121"),
            (3e7, "3e7"),
        ] {
            assert_eq!(digits(x), text);
        }
    }

    #[test]
    fn only_probabilities_stay_below_one() {
        assert_eq!(Measure::Probability(1).text(0.999_999_9), ">0.99");
        assert_eq!(Measure::Steps(1).text(0.999_999_9), "1");
    }

    #[test]
    fn likely_and_soon_values_are_dark() {
        let (p, c) = (Measure::Probability(1), Measure::Steps(1));
        assert_eq!(
            (p.share(1.0, (0.0, 1.0)), c.share(2.0, (2.0, 9.0)), c.share(9.0, (2.0, 9.0))),
            (1.0, 1.0, 0.0)
        );
        assert_eq!(p.compare(Some(0.5), Some(0.2)), Ordering::Less);
        assert_eq!(c.compare(Some(2.0), Some(5.0)), Ordering::Less);
        assert_eq!([p, c].map(|m| m.compare(None, Some(1.0))), [Ordering::Greater; 2]);
    }
}
