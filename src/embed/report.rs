//! Reports, pages and pictures of an analysis.

use super::{Analysis, PageRun};
use meliora_base::error::{Error, Result};
use meliora_engine::Engine;
use meliora_export::projections::{self, Plane};
use meliora_model::State;
use meliora_planning::Phase;
use meliora_quantities::outlook::Outlook;
use meliora_report::CheckReport;
use meliora_report::page::{Content, Picture};

/// The maximum number of diagram nodes in a page.
const MOST_NODES: usize = 500_000;

/// The kind of drawing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Drawing {
    /// A page that loads nothing from elsewhere, with maps, levels, the preference order and all
    /// tables.
    Html,
    /// One picture, as SVG.
    Svg(Picture),
    /// The preference order in the language DOT.
    Dot,
}

impl Analysis {
    /// Builds the report of `meliora check` from the results so far. `source` is the name of the
    /// preference file.
    /// [`meliora_report::Report::text`] formats it as text; it can also be written as JSON. Cost:
    /// see [`meliora_planning::Analysis::prospects`].
    pub fn report(&self, source: &str) -> Result<CheckReport> {
        CheckReport::of_analysis(self, self.program(), self.engine().storage(), source)
    }

    /// Draws a page, with a run of a plan, or a picture; `source` is the name of the preference file. Maps span the integer variables that `grid` names, rows first:
    /// `r,c`. Without `grid`, the names of the variables suggest a plane; if no plane is found, the
    /// drawing has no map.
    ///
    /// # Errors
    /// [`Error::Input`] if `grid` is invalid; [`Error::Usage`] if a map is requested from the
    /// explicit engine, or for a model without integer variables; a limit is reached.
    pub fn draw(&self, source: &str, drawing: Drawing, grid: Option<&str>) -> Result<String> {
        let (check, program) = (self.report(source)?, self.program());
        let plane = match grid {
            Some(names) => Some(Plane::named(program, names)?),
            None => Plane::guess(program),
        };
        let has_maps = !matches!(drawing, Drawing::Dot | Drawing::Svg(Picture::Hasse));
        let at: Option<State> = self.engine().list_states(&self.engine().initial_states(), 1)?.pop();
        let projections = match (plane, &at) {
            (Some(plane), Some(at)) if has_maps => Some(projections::build(self, plane, at, MOST_NODES)?),
            _ => None,
        };
        let preferences = self.preferences();
        let complete = Phase::ALL.iter().all(|&phase| self.is_done(phase));
        let wanted = complete && drawing == Drawing::Html;
        let outlook = if wanted { Some(Outlook::of(self, program)?) } else { None };
        let run = match at.filter(|_| wanted) {
            Some(at) => PageRun::default().shown(self, program, &at, outlook.as_ref())?,
            None => None,
        };
        let content = Content {
            check: &check,
            preferences,
            projections: projections.as_ref(),
            run: run.as_ref(),
            outlook: outlook.as_ref(),
        };
        match drawing {
            Drawing::Html => Ok(content.html()),
            Drawing::Dot => Ok(content.dot()),
            Drawing::Svg(picture) => content.svg(picture).ok_or_else(|| {
                Error::Usage(
                    "no map can be drawn: the model needs one or two integer variables of suitable range"
                        .to_owned(),
                )
            }),
        }
    }
}
