//! Values of all states: heat maps of probabilities and costs, over the plane of the rank maps.

use ahash::AHashMap;
use serde_json::{Value as Json, json};

use super::paint::Look;
use super::palette::{self, Rgb};
use super::words;
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
#[derive(Debug)]
pub(crate) struct Heat<'a> {
    all: &'a AllStates,
    pub(super) measures: Vec<Measure>,
}

impl<'a> Heat<'a> {
    /// Selects the maps of these values.
    pub(super) fn new(all: &'a AllStates) -> Self {
        Heat { all, measures: telling(all) }
    }

    fn of_state(&self, measure: Measure, state: usize) -> Option<f64> {
        match measure {
            Measure::Probability(k) => self.all.probabilities[state].get(k - 1).copied(),
            Measure::Steps(k) => self.all.costs[state].get(k - 1).copied().flatten(),
        }
    }

    /// Returns the least and the greatest value over all states.
    fn range(&self, measure: Measure) -> (f64, f64) {
        if let Measure::Probability(_) = measure {
            return (0.0, 1.0);
        }
        let all = (0..self.all.states.len()).filter_map(|state| self.of_state(measure, state));
        all.fold((f64::INFINITY, 0.0), |(low, high), x| (low.min(x), high.max(x)))
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
        let look = |measure: Measure, view: &Option<View>| {
            let Some(view) = view else { return Look::wall() };
            let fits = |number: &&usize| {
                view.iter()
                    .zip(&self.all.states[**number])
                    .all(|(wanted, value)| wanted.is_none_or(|w| w == *value))
            };
            let here = index.get(&plane(&|at| view[at])).into_iter().flatten().filter(fits);
            let values = here.filter_map(|&number| self.of_state(measure, number));
            self.look(measure, values.reduce(|a, b| if measure.prefers(a, b) { a } else { b }))
        };
        self.measures.iter().map(|&m| views.iter().map(|view| look(m, view)).collect()).collect()
    }

    fn look(&self, measure: Measure, value: Option<f64>) -> Look {
        match value.filter(|&x| x > 0.0 || matches!(measure, Measure::Steps(_))) {
            Some(x) => Look::scaled(measure.share(x, self.range(measure)), digits(x)),
            None => Look::none(if matches!(measure, Measure::Steps(_)) { "–" } else { "0" }.to_owned()),
        }
    }

    /// Returns the meaning of the colours.
    pub(super) fn legend(&self, measure: Measure) -> Vec<(Rgb, String)> {
        let (low, high) = self.range(measure);
        let parts = if low == high { 1 } else { 5 };
        let value = |i: usize| low + (high - low) * i as f64 / (parts - 1).max(1) as f64;
        let one = |x: f64| match measure {
            Measure::Probability(_) if x == 0.0 => (palette::NONE, "0".to_owned()),
            _ => (palette::scale(measure.share(x, (low, high))), digits(x)),
        };
        let mut all: Vec<_> = (0..parts).map(|i| one(value(i))).collect();
        if let Measure::Steps(_) = measure {
            all.push((palette::NONE, "– not certain".to_owned()));
        }
        all
    }

    /// Returns the data of the page's script.
    pub(super) fn data(&self) -> Json {
        let measure = |&measure: &Measure| {
            let (low, high) = self.range(measure);
            let all: Vec<Option<f64>> =
                (0..self.all.states.len()).map(|state| self.of_state(measure, state).map(rounded)).collect();
            let steps = matches!(measure, Measure::Steps(_));
            json!({"id": measure.id(), "title": measure.title(), "steps": steps, "low": low, "high": high, "all": all})
        };
        json!({
            "states": self.all.states,
            "measures": self.measures.iter().map(measure).collect::<Vec<_>>(),
            "stops": palette::stops(),
        })
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

    fn prefers(self, a: f64, b: f64) -> bool {
        match self {
            Measure::Probability(_) => a >= b,
            Measure::Steps(_) => a <= b,
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

/// Rounds to six significant digits.
fn rounded(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
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
    fn likely_and_soon_values_are_dark() {
        let (p, c) = (Measure::Probability(1), Measure::Steps(1));
        assert_eq!(
            (p.share(1.0, (0.0, 1.0)), c.share(2.0, (2.0, 9.0)), c.share(9.0, (2.0, 9.0))),
            (1.0, 1.0, 0.0)
        );
        assert!(p.prefers(0.5, 0.2) && c.prefers(2.0, 5.0) && !c.prefers(5.0, 2.0));
    }
}
