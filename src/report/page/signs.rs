//! Marks for the labels of a model: chargers, doors, forbidden zones.

use meliora_export::projections::{Projections, View};

use super::Content;

/// The marks, one per label in the order of declaration.
const GLYPHS: [&str; 6] = ["▲", "●", "★", "▼", "✚", "◗"];

/// The labels that maps show, each with its mark.
pub(super) struct Signs {
    /// The positions of the labels in [`Projections::labels`].
    drawn: Vec<usize>,
}

impl Signs {
    /// Selects the labels that belong to some cells: not those of all corners, nor those with the cells
    /// of a target, which has a letter.
    pub(super) fn new(projections: &Projections, everywhere: &[bool]) -> Self {
        let cells = |edge| -> Vec<bool> {
            all_views(projections).iter().map(|view| projections.holds(edge, view)).collect()
        };
        let shown = projections.targets.iter().zip(everywhere).filter(|(_, everywhere)| !**everywhere);
        let targets: Vec<Vec<bool>> = shown.map(|(&target, _)| cells(target)).collect();
        let belongs = |label: &usize| {
            let edge = projections.labels[*label].1;
            let own = cells(edge);
            own.contains(&true) && !in_all_corners(projections, edge) && !targets.contains(&own)
        };
        Signs { drawn: (0..projections.labels.len()).filter(belongs).take(GLYPHS.len()).collect() }
    }

    /// Returns the marks of a cell.
    pub(super) fn at(&self, projections: &Projections, view: &View) -> Vec<&'static str> {
        let holds = |(_, label): &(&str, &usize)| projections.holds(projections.labels[**label].1, view);
        let pairs = GLYPHS.into_iter().zip(&self.drawn);
        pairs.filter(holds).map(|(glyph, _)| glyph).collect()
    }

    /// Returns the marks with the names of their labels.
    pub(super) fn legend(&self, projections: &Projections) -> Vec<(&'static str, String)> {
        let name = |label: &usize| projections.labels[*label].0.clone();
        GLYPHS.into_iter().zip(self.drawn.iter().map(name)).collect()
    }
}

/// Returns the label that says where an objective is achieved: it is called like the objective, or
/// `at_` and then its name.
pub(super) fn place_of(content: &Content<'_>, projections: &Projections, objective: usize) -> Option<usize> {
    let name = &content.preferences.objectives[objective].name;
    let is_called = |label: &str| {
        let label = label.strip_prefix("at_").unwrap_or(label);
        label.eq_ignore_ascii_case(name)
    };
    projections
        .labels
        .iter()
        .position(|(label, edge)| is_called(label) && !in_all_corners(projections, *edge))
}

/// Returns whether a set has states in all four corners of the plane.
pub(super) fn in_all_corners(projections: &Projections, edge: meliora_model::diagram::Edge) -> bool {
    let open: View = vec![None; projections.variables.len()];
    let ends = |values: Vec<i64>| [values.first().copied().unwrap_or(0), values.last().copied().unwrap_or(0)];
    let corners =
        ends(projections.rows()).into_iter().flat_map(|r| ends(projections.columns()).map(|c| (r, c)));
    corners.into_iter().all(|(row, column)| projections.holds(edge, &projections.view(&open, row, column)))
}

/// Returns the views of all cells, with any values of the other variables.
fn all_views(projections: &Projections) -> Vec<View> {
    let open: View = vec![None; projections.variables.len()];
    let columns = projections.columns();
    let row = |row: i64| columns.iter().map(move |&column| (row, column)).collect::<Vec<_>>();
    let places = projections.rows().into_iter().flat_map(row);
    places.map(|(row, column)| projections.view(&open, row, column)).collect()
}
