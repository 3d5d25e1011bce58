//! The report as a page, or as single pictures.
//!
//! The page is one file that loads nothing else. It contains the regions as a decision diagram, and
//! its script evaluates them when a slider moves. Without the script everything but the sliders
//! works.

mod axes;
mod bars;
mod cycle;
mod data;
pub(crate) mod drawing;
#[cfg(test)]
mod escaping;
mod game;
mod hasse;
mod heat;
mod html;
mod layered;
mod letters;
mod map;
mod marks;
mod paint;
mod palette;
mod picture;
mod report;
mod sentence;
mod words;

pub use report::PageReport;
pub use report::Written;
use strum::{EnumMessage, EnumString, IntoStaticStr, VariantArray};

use super::CheckReport;
use super::simulate::TraceReport;
use heat::Heat;
use meliora_base::escape;
use meliora_export::projections::Projections;
use meliora_model::State;
use meliora_model::preference::{Outline, Preferences};
use meliora_planning::tally::RunEnd;
use meliora_planning::{Opponent, Scheduler, StrategyKind};
use meliora_quantities::Choose;
use meliora_quantities::outlook::Outlook;

/// The contents of a page.
pub struct Content<'a> {
    /// The results of `check`.
    pub check: &'a CheckReport,
    /// The preferences.
    pub preferences: &'a Preferences,
    /// The regions over a plane, if one was selected or guessed.
    pub projections: Option<&'a Projections>,
    /// A run; `None` if nothing can be improved or achieved.
    pub run: Option<&'a ShownRun>,
    /// The values of all states, and the outlook of the initial ones; `None` if some levels are unknown.
    pub outlook: Option<&'a Outlook>,
}

/// A simulated run.
#[derive(Debug, Clone)]
pub struct ShownRun {
    /// The kind of the strategy.
    pub kind: StrategyKind,
    /// The strategy of that kind.
    pub scheduler: Scheduler,
    /// The action that the progress strategy takes.
    pub choose: Choose,
    /// The choices of the opponent; `None` if the model is not a game.
    pub opponent: Option<Opponent>,
    /// The seed of the random numbers.
    pub seed: u64,
    /// The number of runs from which it was selected, at most.
    pub tried: u64,
    /// The run as text.
    pub trace: TraceReport,
    /// The visited states, starting with the first.
    pub states: Vec<State>,
    /// The end of the run.
    pub end: RunEnd,
}

/// A single picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, EnumMessage, EnumString, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Picture {
    /// Preference order.
    Hasse,
    /// Map of guaranteed improvements (SASI ranks).
    Sasi,
    /// Map of possible improvements (SPI ranks).
    Spi,
    /// Map of the most preferred objectives (classes).
    Classes,
}

impl Picture {
    /// All pictures.
    pub const ALL: &[Picture] = Picture::VARIANTS;

    /// The maps in the order of the page.
    const MAPS: [Picture; 3] = [Picture::Sasi, Picture::Spi, Picture::Classes];

    /// Returns the name on the command line and in the page.
    pub fn name(self) -> &'static str {
        self.into()
    }

    fn title(self) -> &'static str {
        match self {
            Picture::Hasse => "Preference order",
            Picture::Sasi => "Guaranteed improvements",
            Picture::Spi => "Possible improvements",
            Picture::Classes => "Most preferred objectives",
        }
    }
}

impl Content<'_> {
    /// Renders the page.
    pub fn html(&self) -> String {
        escape::lines(&html::page(self)).into_owned()
    }

    /// Renders a picture as SVG; returns `None` if it needs a plane and there is none.
    pub fn svg(&self, picture: Picture) -> Option<String> {
        let drawn = match picture {
            Picture::Hasse => hasse::svg(&self.order(), true),
            _ => picture::svg(self, self.projections?, picture),
        };
        Some(plain(&drawn.into_string()))
    }

    /// Renders the preference order in the DOT language.
    pub fn dot(&self) -> String {
        hasse::dot(&self.order())
    }

    /// Returns the values of all states, if they are known.
    fn heat(&self) -> Option<Heat<'_>> {
        self.outlook?.all.as_ref().map(Heat::new)
    }

    /// Returns the preference order with the names and sizes in its picture.
    fn order(&self) -> hasse::Order {
        let sure = |i: &usize| self.check.result.objectives.get(*i).map(|o| &o.almost_sure);
        let note = |group: &[usize]| {
            group.iter().filter_map(sure).max().map(|n| format!("sure in {}", words::short(n)))
        };
        let names: Vec<&str> = self.preferences.objectives.iter().map(|o| o.name.as_str()).collect();
        hasse::Order::new(&self.preferences.order, self.preferences.empty, &names, note)
    }
}

/// Replaces variables of CSS by their default values, for programs that do not know them, and
/// characters that are not displayed.
fn plain(svg: &str) -> String {
    let mut parts = svg.split("var(");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (variable, rest) = part.split_once(')').unwrap_or((part, ""));
        out.push_str(variable.split_once(", ").map_or(variable, |(_, value)| value));
        out.push_str(rest);
    }
    escape::lines(&out).into_owned()
}

/// Renders the Hasse diagram of a preference order without a model, as SVG.
pub fn order_svg(preferences: &Outline) -> String {
    let names: Vec<&str> = preferences.objectives.iter().map(|(name, _)| name.as_str()).collect();
    let order = hasse::Order::new(&preferences.order, preferences.empty, &names, |_| None);
    plain(&hasse::svg(&order, true).into_string())
}
