//! The report that one looks at: a page of its own, single pictures, or Markdown.
//!
//! The page is one file that loads nothing: the regions are in it as a decision diagram, which its own
//! script evaluates when a slider moves. Everything but the sliders is there without the script.

mod bars;
mod data;
mod hasse;
mod html;
mod layered;
mod letters;
mod map;
mod markdown;
mod paint;
mod palette;
mod report;
mod words;

pub use report::{PageReport, Written};

use super::simulate::TraceReport;
use super::{CheckReport, Number};
use crate::model::preference::{Outline, Preferences};
use crate::model::{Program, State};
use crate::planning::simulate::PlayEnd;
use crate::planning::{Kind, Scheduler};
use crate::projections::Projections;

/// All that a page shows.
pub struct Content<'a> {
    /// What `check` found.
    pub check: &'a CheckReport,
    /// The model.
    pub program: &'a Program,
    /// The preferences.
    pub preferences: &'a Preferences,
    /// The regions over a plane; none where no plane was named or guessed.
    pub projections: Option<&'a Projections>,
    /// A play; none where there is nothing to play for.
    pub play: Option<&'a Play>,
}

/// A simulated play.
#[derive(Debug, Clone)]
pub struct Play {
    /// Under which strategies.
    pub kind: Kind,
    /// Which of the two.
    pub scheduler: Scheduler,
    /// What the random draws started from.
    pub seed: u64,
    /// The play in words.
    pub trace: TraceReport,
    /// The states it visits, the first one first.
    pub states: Vec<State>,
    /// How it ended.
    pub end: PlayEnd,
}

/// A picture of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Picture {
    /// The preference order.
    Hasse,
    /// The SASI ranks over the plane.
    Sasi,
    /// The SPI ranks over the plane.
    Spi,
    /// The classes over the plane.
    Classes,
}

impl Picture {
    /// The maps, in the order in which a page has them.
    const MAPS: [Picture; 3] = [Picture::Sasi, Picture::Spi, Picture::Classes];

    /// The name on the command line and in the page.
    pub fn name(self) -> &'static str {
        match self {
            Picture::Hasse => "hasse",
            Picture::Sasi => "sasi",
            Picture::Spi => "spi",
            Picture::Classes => "classes",
        }
    }

    fn title(self) -> &'static str {
        match self {
            Picture::Hasse => "What is preferred to what",
            Picture::Sasi => "Guaranteed improvements",
            Picture::Spi => "Possible improvements",
            Picture::Classes => "What is sure already",
        }
    }
}

impl Content<'_> {
    /// The page.
    pub fn html(&self) -> String {
        html::page(self)
    }

    /// The report as Markdown.
    pub fn markdown(&self) -> String {
        markdown::render(self)
    }

    /// A picture as SVG; none where it needs a plane and there is none.
    pub fn svg(&self, picture: Picture) -> Option<String> {
        let drawn = match picture {
            Picture::Hasse => hasse::svg(&self.order(), true),
            _ => map::svg(self, self.projections?, picture),
        };
        Some(drawn.into_string())
    }

    /// The preference order in the language DOT.
    pub fn dot(&self) -> String {
        hasse::dot(&self.order())
    }

    /// The preference order with the names and sizes that its picture shows.
    fn order(&self) -> hasse::Order {
        let sure = |i: &usize| self.check.objectives.get(*i).map(|o| o.almost_sure.clone());
        let note = |group: &[usize]| {
            let sure: Vec<Number> = group.iter().filter_map(sure).collect();
            sure.iter().max().map(|n| format!("sure in {}", words::short(n)))
        };
        let names: Vec<&str> = self.preferences.objectives.iter().map(|o| o.name.as_str()).collect();
        hasse::Order::new(&self.preferences.order, self.preferences.empty, &names, note)
    }
}

/// A preference order without a model as a picture: the Hasse diagram, as SVG.
pub fn order_svg(preferences: &Outline) -> String {
    let names: Vec<&str> = preferences.objectives.iter().map(|(name, _)| name.as_str()).collect();
    let order = hasse::Order::new(&preferences.order, preferences.empty, &names, |_| None);
    hasse::svg(&order, true).into_string()
}
