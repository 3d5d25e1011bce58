//! Marks for the labels of a model: chargers, doors, forbidden zones.

use super::Content;
use meliora_export::projections::{Projections, View};
use meliora_model::diagram::Edge;

/// The marks, one per label in the order of declaration.
const GLYPHS: [&str; 6] = ["▲", "●", "★", "▼", "✚", "◗"];

/// The labels that maps show, each with its mark.
pub(super) struct Signs {
    /// The positions of the labels in [`Projections::labels`].
    drawn: Vec<usize>,
}

impl Signs {
    /// Selects the labels that belong to some cells: not those of most cells, nor those with the cells of
    /// a target, which has a letter.
    pub(super) fn new(projections: &Projections, targets: &[Option<Edge>]) -> Self {
        let cells = |edge| -> Vec<bool> {
            all_views(projections).iter().map(|view| projections.holds(edge, view)).collect()
        };
        let targets: Vec<Vec<bool>> = targets.iter().flatten().map(|&edge| cells(edge)).collect();
        let belongs = |label: &usize| {
            let edge = projections.labels[*label].1;
            let own = cells(edge);
            own.contains(&true) && !is_wide(projections, edge) && !targets.contains(&own)
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
    projections.labels.iter().position(|(label, edge)| is_called(label) && !is_wide(projections, *edge))
}

/// Returns whether a set is too large to mark its cells: it has states in all four corners of the plane,
/// or in more than half of the cells.
pub(super) fn is_wide(projections: &Projections, edge: Edge) -> bool {
    let open: View = vec![None; projections.variables.len()];
    let ends = |values: Vec<i64>| [values.first().copied().unwrap_or(0), values.last().copied().unwrap_or(0)];
    let corners =
        ends(projections.rows()).into_iter().flat_map(|r| ends(projections.columns()).map(|c| (r, c)));
    let holds = |(row, column)| projections.holds(edge, &projections.view(&open, row, column));
    let all = all_views(projections);
    let count = |edge| all.iter().filter(|view| projections.holds(edge, view)).count();
    corners.into_iter().all(holds) || 2 * count(edge) > all.len()
}

/// Returns the views of all cells, with any values of the other variables.
fn all_views(projections: &Projections) -> Vec<View> {
    let open: View = vec![None; projections.variables.len()];
    let columns = projections.columns();
    let row = |row: i64| columns.iter().map(move |&column| (row, column)).collect::<Vec<_>>();
    let places = projections.rows().into_iter().flat_map(row);
    places.map(|(row, column)| projections.view(&open, row, column)).collect()
}
