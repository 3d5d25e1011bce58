//! Marks in the cells of maps: letters for the targets of objectives, signs for the labels of a model.

use super::Content;
use super::paint::ViewCell;
use meliora_base::diagram::Edge;
use meliora_export::projections::{Projections, View};

/// The signs of labels, in the order of declaration.
const GLYPHS: [&str; 6] = ["▲", "●", "★", "▼", "✚", "◗"];

/// The signs of targets, and of labels alone, in small cells.
pub(super) const SEVERAL: [&str; 2] = ["◆", "•"];

/// The sign of all further marks in the last corner of a cell.
pub(super) const MORE: &str = "+";

/// A mark and the states that have it.
pub(super) struct Mark {
    pub(super) glyph: String,
    /// The name of the objective or the label.
    pub(super) name: String,
    pub(super) is_target: bool,
    pub(super) edge: Edge,
    /// True if too many cells have such states for some values of the other variables.
    pub(super) is_wide: bool,
}

/// A mark of a cell.
#[derive(Clone, Copy)]
pub(super) struct Placed {
    /// The position of the mark.
    pub(super) mark: usize,
    /// True if no state with the values of the view has it, but one with other values.
    pub(super) is_pale: bool,
}

/// The marks of a model.
pub(super) struct Marks(pub(super) Vec<Mark>);

impl Marks {
    /// Returns the targets of all objectives, and the labels that belong to some cells: not to most cells,
    /// and not to those of a target, which has a letter.
    pub(super) fn new(content: &Content<'_>, projections: &Projections) -> Self {
        let mut all = targets(content, projections);
        let places = |edge| -> Vec<bool> {
            all_views(projections).iter().map(|view| projections.holds(edge, view)).collect()
        };
        let known: Vec<Vec<bool>> = all.iter().map(|target| places(target.edge)).collect();
        let belongs = |&(_, edge): &(&str, Edge)| {
            let own = places(edge);
            own.contains(&true) && !is_wide(projections, edge) && !known.contains(&own)
        };
        let labels = projections.labels.iter().map(|(name, edge)| (name.as_str(), *edge)).filter(belongs);
        all.extend(GLYPHS.into_iter().zip(labels).map(|(glyph, (name, edge))| Mark {
            glyph: glyph.to_owned(),
            name: name.to_owned(),
            is_target: false,
            edge,
            is_wide: false,
        }));
        Marks(all)
    }

    /// Marks the cells of a view: those with states that have the mark and, paler, those where states with
    /// other values have it. A mark that more than half of the cells have tells nothing and is left out.
    pub(super) fn place(&self, projections: &Projections, view: &View, cells: &mut [Vec<ViewCell>]) {
        let open: View = vec![None; view.len()];
        let mut live: Vec<&mut ViewCell> =
            cells.iter_mut().flatten().filter(|found| !found.is_wall()).collect();
        for (number, mark) in self.0.iter().enumerate() {
            let has = |found: &ViewCell, others: &View| {
                projections.holds(mark.edge, &projections.view(others, found.row, found.column))
            };
            let (mut own, mut pale) = (Vec::new(), Vec::new());
            for (at, found) in live.iter().enumerate() {
                if !found.elsewhere && has(found, view) {
                    own.push(at);
                } else if !mark.is_wide && has(found, &open) {
                    // The whole cell shows states with other values, so the mark is not paler.
                    if found.elsewhere { own.push(at) } else { pale.push(at) }
                }
            }
            if 2 * (own.len() + pale.len()) > live.len() {
                pale.clear();
            }
            if 2 * own.len() > live.len() {
                own.clear();
            }
            for (places, is_pale) in [(own, false), (pale, true)] {
                places.into_iter().for_each(|at| live[at].marks.push(Placed { mark: number, is_pale }));
            }
        }
    }

    /// Returns the glyphs for the corners of a cell: targets from the upper left one on, labels from the
    /// lower right one on, and whether they are pale. The last of too many marks is [`MORE`].
    pub(super) fn corners(&self, marks: &[Placed]) -> Vec<(usize, &str, bool)> {
        let glyph = |placed: &Placed| self.0[placed.mark].glyph.as_str();
        if marks.len() > 4 {
            let first =
                marks[..3].iter().map(|placed| (glyph(placed), placed.is_pale)).chain([(MORE, false)]);
            return first.enumerate().map(|(at, (glyph, is_pale))| (at, glyph, is_pale)).collect();
        }
        let targets = marks.iter().filter(|placed| self.0[placed.mark].is_target).count();
        let corner = |at: usize| if at < targets { at } else { 3 - (at - targets) };
        marks.iter().enumerate().map(|(at, placed)| (corner(at), glyph(placed), placed.is_pale)).collect()
    }

    /// Returns the glyph in the middle of a small cell.
    pub(super) fn single(&self, marks: &[Placed]) -> &str {
        let labels = usize::from(self.labels_only(marks));
        if let [placed] = marks { &self.0[placed.mark].glyph } else { SEVERAL[labels] }
    }

    pub(super) fn labels_only(&self, marks: &[Placed]) -> bool {
        marks.iter().all(|placed| !self.0[placed.mark].is_target)
    }
}

/// Returns the states that show where each objective is achieved: its target or, if most cells have such
/// states, those of a label that is called like the objective.
fn targets(content: &Content<'_>, projections: &Projections) -> Vec<Mark> {
    let names: Vec<&str> = content.preferences.objectives.iter().map(|o| o.name.as_str()).collect();
    let one = |((objective, glyph), name): ((usize, String), &str)| {
        let own = projections.targets[objective];
        let label = if is_wide(projections, own) { place_of(name, projections) } else { None };
        let edge = label.unwrap_or(own);
        let is_wide = label.is_none() && is_wide(projections, own);
        Mark { glyph, name: name.to_owned(), is_target: true, edge, is_wide }
    };
    letters(&names).into_iter().enumerate().zip(names).map(one).collect()
}

/// Returns the first letter or the first two letters of each name; if some names share them, `a`, `b`, …
fn letters(names: &[&str]) -> Vec<String> {
    let first = |n| names.iter().map(|name| name.chars().take(n).collect()).collect();
    let distinct = |letters: &Vec<String>| !(1..letters.len()).any(|i| letters[..i].contains(&letters[i]));
    let in_turn = || {
        let all = ('a'..='z').map(String::from).chain(std::iter::repeat(SEVERAL[0].to_owned()));
        all.take(names.len()).collect()
    };
    (1..=2).map(first).find(distinct).unwrap_or_else(in_turn)
}

/// Returns the label that says where an objective is achieved: it is called like the objective, or
/// `at_` and then its name.
fn place_of(name: &str, projections: &Projections) -> Option<Edge> {
    let is_called = |label: &str| label.strip_prefix("at_").unwrap_or(label).eq_ignore_ascii_case(name);
    let mut labels = projections.labels.iter();
    labels.find(|(label, edge)| is_called(label) && !is_wide(projections, *edge)).map(|label| label.1)
}

/// Returns whether a set is too large to mark its cells for any values of the other variables: it has
/// states in all four corners of the plane, or in more than half of the cells.
fn is_wide(projections: &Projections, edge: Edge) -> bool {
    let all = all_views(projections);
    let (columns, last) = (projections.columns().len(), all.len().saturating_sub(1));
    let corners = [0, columns - 1, last + 1 - columns, last];
    let holds = |view: &View| projections.holds(edge, view);
    corners.iter().all(|&at| holds(&all[at])) || 2 * all.iter().filter(|view| holds(view)).count() > all.len()
}

/// Returns the views of all cells, with any values of the other variables.
fn all_views(projections: &Projections) -> Vec<View> {
    let open: View = vec![None; projections.variables.len()];
    let columns = projections.columns();
    let row = |row: i64| columns.iter().map(move |&column| (row, column)).collect::<Vec<_>>();
    let places = projections.rows().into_iter().flat_map(row);
    places.map(|(row, column)| projections.view(&open, row, column)).collect()
}

#[cfg(test)]
mod tests {
    use super::letters;

    #[test]
    fn each_objective_has_letters_of_its_own() {
        assert_eq!(letters(&["Dock", "Lab"]), ["D", "L"]);
        assert_eq!(letters(&["Dock", "Desk"]), ["Do", "De"]);
        assert_eq!(letters(&["O1", "O2", "O10"]), ["a", "b", "c"]);
        let many: Vec<String> = (0..30).map(|i| format!("goal{i}")).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        assert_eq!(letters(&many)[25..27], ["z", "◆"]);
    }
}
