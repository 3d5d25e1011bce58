//! The colours and texts of cells, computed once for all maps.

use super::marks::{Marks, Placed};
use super::palette::{self, Rgb};
use super::{Content, Picture, axes};
use crate::{ranks, text};
use meliora_export::projections::{Cell, Direction, Inside, Ladder, Projections, View};
use meliora_model::preference::ObjectiveSet;
use meliora_planning::Rank;

/// The side of a cell.
pub(super) const SIDE: usize = 40;
/// Maximum number of columns for texts of several words.
const ROOMY: usize = 12;

/// Maximum number of squares for the classes of a cell.
pub(super) const MOST_SQUARES: usize = 4;

/// The text of a cell with unsafe states.
pub(super) const UNSAFE: &str = "×";

/// The opening view of projections with its colours and texts.
pub(super) struct Paint<'a> {
    pub(super) projections: &'a Projections,
    /// The names of the classes.
    pub(super) names: Vec<String>,
    /// The texts of the classes in cells.
    pub(super) texts: Vec<String>,
    /// The rank of each class by size, the largest first; `None` for the class `nothing`.
    places: Vec<Option<usize>>,
    greatest: [usize; 2],
    /// The opening view.
    pub(super) opening: View,
    /// The targets and labels that have marks.
    pub(super) marks: Marks,
    /// The cells, row by row from the top.
    pub(super) cells: Vec<Vec<ViewCell>>,
}

/// A cell of the opening view.
pub(super) struct ViewCell {
    pub(super) row: i64,
    pub(super) column: i64,
    /// The results there; `None` if no values of the other variables give a state, and if all states
    /// are unsafe.
    cell: Option<Cell>,
    /// True if all states there are unsafe.
    pub(super) is_unsafe: bool,
    /// True if no state has the values of the view there: then the cell shows the best over all
    /// other values.
    pub(super) elsewhere: bool,
    /// True if the opponent chooses in all states there.
    pub(super) is_theirs: bool,
    /// The marks that its states have.
    pub(super) marks: Vec<Placed>,
}

impl ViewCell {
    /// Returns whether the cell has a mark.
    pub(super) fn has(&self, mark: usize) -> bool {
        self.marks.iter().any(|placed| placed.mark == mark)
    }

    /// Returns whether no values of the other variables give a state.
    pub(super) fn is_wall(&self) -> bool {
        self.cell.is_none() && !self.is_unsafe
    }

    /// Returns whether the cell stands for states of several classes.
    pub(super) fn is_several(&self) -> bool {
        self.cell.as_ref().is_some_and(|cell| cell.classes.len() > 1)
    }
}

/// The colours and the text of a cell.
#[derive(Clone)]
pub(super) struct Look {
    pub(super) fill: String,
    pub(super) ink: &'static str,
    pub(super) text: String,
    /// The colours of the characters of the text, if they differ.
    pub(super) squares: Vec<String>,
}

impl Look {
    /// Returns the look of a place without states.
    pub(super) fn wall() -> Self {
        Look { fill: "url(#wall)".to_owned(), ink: "currentColor", text: String::new(), squares: Vec::new() }
    }

    /// Returns the look of unsafe states.
    pub(super) fn not_safe() -> Self {
        Look::colored(palette::UNSAFE, UNSAFE.to_owned())
    }

    /// Returns a text on a colour.
    pub(super) fn colored(color: Rgb, text: String) -> Self {
        Look { fill: palette::css(color), ink: palette::ink(color), text, squares: Vec::new() }
    }

    /// Returns a text on the colour of a share.
    pub(super) fn scaled(share: f64, text: String) -> Self {
        let (fill, ink) = palette::scaled(share);
        Look { fill, ink, text, squares: Vec::new() }
    }

    /// Returns a text on the colour for nothing.
    pub(super) fn none(text: String) -> Self {
        Look::colored(palette::NONE, text)
    }
}

impl<'a> Paint<'a> {
    pub(super) fn new(content: &Content<'_>, projections: &'a Projections) -> Self {
        let name = |class: &_| text::either(&content.preferences.owned_names(class));
        // The fixpoint has its own colour.
        let greatest = |l: &Ladder| l.levels.len() - usize::from(l.unbounded.is_some());
        let opening = opening(projections);
        let marks = Marks::new(content, projections);
        let mut cells = found(projections, &opening);
        marks.place(projections, &opening, &mut cells);
        Paint {
            projections,
            names: projections.classes.iter().map(|(class, _)| name(class)).collect(),
            texts: texts(content, projections),
            places: places(content, projections),
            greatest: [greatest(&projections.sasi), greatest(&projections.spi)],
            marks,
            cells,
            opening,
        }
    }

    /// Returns whether some marks are pale.
    pub(super) fn has_pale(&self) -> bool {
        self.cells.iter().flatten().any(|found| found.marks.iter().any(|placed| placed.is_pale))
    }

    /// Returns the greatest finite rank.
    pub(super) fn most(&self, picture: Picture) -> usize {
        self.greatest[usize::from(picture == Picture::Spi)]
    }

    /// Returns the font size of the smallest texts in the cells of a map.
    pub(super) fn smallest(&self, picture: Picture) -> usize {
        let texts = match picture {
            Picture::Classes => self.texts.clone(),
            _ => self.legend(picture).into_iter().map(|(_, name)| name.replace(" any number", "")).collect(),
        };
        texts.iter().map(|text| axes::size(text)).max().unwrap_or(0)
    }

    /// Returns the background and text colour of a class.
    pub(super) fn class(&self, index: usize) -> (Rgb, &'static str) {
        let color = palette::class(self.places[index]);
        (color, palette::ink(color))
    }

    /// Returns the colours and the text of a cell.
    pub(super) fn look(&self, picture: Picture, found: &ViewCell) -> Look {
        let Some(cell) = &found.cell else {
            return if found.is_unsafe { Look::not_safe() } else { Look::wall() };
        };
        let rank = match (picture, &cell.classes[..]) {
            (Picture::Classes, &[index]) => {
                return Look::colored(self.class(index).0, self.texts[index].clone());
            }
            (Picture::Classes, classes) => return self.squares(classes),
            (Picture::Spi, _) => cell.spi,
            (Picture::Sasi | Picture::Hasse, _) => cell.sasi,
        };
        Look::colored(palette::rank(rank, self.most(picture)), ranks::mark(Some(rank)))
    }

    /// Returns a square of each class, at most four, the last one for all others.
    fn squares(&self, classes: &[usize]) -> Look {
        let all = classes.iter().map(|&class| palette::css(self.class(class).0));
        let mut squares: Vec<String> = all.take(MOST_SQUARES).collect();
        let mut text = "■".repeat(squares.len());
        if classes.len() > MOST_SQUARES {
            squares[MOST_SQUARES - 1] = "currentColor".to_owned();
            text = "■".repeat(MOST_SQUARES - 1) + "+";
        }
        let fill = "var(--several, #d8d4e8)".to_owned();
        Look { fill, ink: "currentColor", text, squares }
    }

    /// Returns the names of the classes of a cell: `A or B; C`.
    pub(super) fn named(&self, found: &ViewCell) -> String {
        let Some(cell) = &found.cell else {
            return if found.is_unsafe { "unsafe" } else { "unreachable" }.to_owned();
        };
        cell.classes.iter().map(|&class| self.names[class].as_str()).collect::<Vec<_>>().join("; ")
    }

    /// Returns the views of the cells of the opening view; `None` where no state is, or only unsafe ones.
    pub(super) fn views(&self) -> Vec<Option<View>> {
        let open: View = vec![None; self.projections.variables.len()];
        let view = |found: &ViewCell| {
            let others = if found.elsewhere { &open } else { &self.opening };
            found.cell.as_ref().map(|_| self.projections.view(others, found.row, found.column))
        };
        self.cells.iter().flatten().map(view).collect()
    }

    /// Returns the arrows of the permitted choices in a cell; empty if a variable has any value.
    pub(super) fn arrows(&self, picture: Picture, found: &ViewCell) -> String {
        let view = self.projections.view(&self.opening, found.row, found.column);
        let mut path = String::new();
        if found.elsewhere || view.iter().any(Option::is_none) {
            return path;
        }
        let ladder = ladder(self.projections, picture);
        for (choice, &edge) in self.projections.choices.iter().zip(&ladder.permitted) {
            let arrow = arrow(choice, self.projections.rows_up);
            if !path.contains(&arrow) && self.projections.holds(edge, &view) {
                path.push_str(&arrow);
            }
        }
        path
    }

    /// Returns the meaning of the colour of unsafe states, if there are some.
    pub(super) fn unsafe_legend(&self) -> Option<(Rgb, String)> {
        self.projections.unsafe_states.map(|_| (palette::UNSAFE, format!("{UNSAFE} unsafe")))
    }

    /// Returns the meaning of the colours of ranks or classes.
    pub(super) fn legend(&self, picture: Picture) -> Vec<(Rgb, String)> {
        if picture == Picture::Classes {
            let label = |index: usize| match (&self.texts[index], &self.names[index]) {
                (mark, name) if mark == name => name.clone(),
                (mark, name) if self.projections.classes[index].0.is_empty() => format!("{mark} {name}"),
                (mark, name) => format!("{mark} · {name}"),
            };
            let one = |index| (self.class(index).0, label(index));
            return (0..self.names.len()).map(one).collect();
        }
        let ladder = ladder(self.projections, picture);
        let last = ladder.levels.len();
        let mut ranks: Vec<Rank> = (0..=last).map(Rank::Finite).collect();
        if ladder.open {
            ranks[last] = Rank::AtLeast(last);
        }
        if ladder.unbounded.is_some() {
            // The last level is the fixpoint, so no state has its number as its rank.
            ranks[last] = Rank::Unbounded;
        }
        let name = |rank| match rank {
            Rank::Unbounded => "∞ any number".to_owned(),
            _ => ranks::mark(Some(rank)),
        };
        ranks.into_iter().map(|r| (palette::rank(r, self.most(picture)), name(r))).collect()
    }
}

fn ladder(projections: &Projections, picture: Picture) -> &Ladder {
    if picture == Picture::Spi { &projections.spi } else { &projections.sasi }
}

/// Returns the first view to show: the values of the start. If they leave most cells without a state, as the
/// charge of a battery does, the variable is open that hides most of them, or else all are.
fn opening(projections: &Projections) -> View {
    let start = projections.opening();
    let columns = projections.columns();
    let places = || projections.rows().into_iter().flat_map(|row| columns.iter().map(move |&c| (row, c)));
    let faded = |view: &View| {
        let found = places().filter_map(|(row, column)| projections.found(view, row, column));
        let exact: Vec<bool> = found.map(|(_, exact)| exact).collect();
        let elsewhere = exact.iter().filter(|exact| !**exact).count();
        if 2 * elsewhere > exact.len() { elsewhere } else { 0 }
    };
    if faded(&start) == 0 {
        return start;
    }
    let opened = |variable: usize| {
        let mut view = start.clone();
        view[variable] = None;
        view
    };
    let views = (0..start.len()).map(opened);
    let best = views.map(|view| (faded(&view), view)).min_by_key(|(faded, _)| *faded);
    best.filter(|(faded, _)| *faded == 0).map_or_else(|| vec![None; start.len()], |(_, view)| view)
}

/// Returns the cells of a view, without their marks.
fn found(projections: &Projections, view: &View) -> Vec<Vec<ViewCell>> {
    let open: View = vec![None; projections.variables.len()];
    let one = |row: i64, column: i64| {
        let (inside, exact) = projections.found(view, row, column).unzip();
        let is_unsafe = inside == Some(Inside::Unsafe);
        let is_theirs = match exact {
            Some(true) => projections.is_theirs(&projections.view(view, row, column)),
            Some(false) => projections.is_theirs(&projections.view(&open, row, column)),
            None => false,
        };
        let cell = match inside {
            Some(Inside::Safe(cell)) => Some(cell),
            Some(Inside::Unsafe) | None => None,
        };
        let elsewhere = exact == Some(false);
        ViewCell { row, column, cell, is_unsafe, elsewhere, is_theirs, marks: Vec::new() }
    };
    let columns = projections.columns();
    projections
        .rows()
        .into_iter()
        .map(|row| columns.iter().map(|&column| one(row, column)).collect())
        .collect()
}

/// Returns the maximum number of characters of a class in a cell.
fn longest(projections: &Projections) -> usize {
    if projections.columns().len() > ROOMY { 4 } else { 6 }
}

/// Returns the texts of the classes in cells: their names or, if one is too long, numbers.
fn texts(content: &Content<'_>, projections: &Projections) -> Vec<String> {
    let name = |class: &ObjectiveSet| match class.is_empty() {
        true => "–".to_owned(),
        false => content.preferences.names(class).join("/"),
    };
    let names: Vec<String> = projections.classes.iter().map(|(class, _)| name(class)).collect();
    if names.iter().all(|name| name.chars().count() <= longest(projections)) {
        return names;
    }
    let number = |(index, name): (usize, &String)| match name.as_str() {
        "–" => name.clone(),
        _ => (index + 1).to_string(),
    };
    names.iter().enumerate().map(number).collect()
}

/// Ranks the classes by size, so that the strongest colours go to the largest.
fn places(content: &Content<'_>, projections: &Projections) -> Vec<Option<usize>> {
    let sizes = content.check.result.classes.as_deref().unwrap_or_default();
    let size = |class: usize| sizes.get(class).map(|c| c.states.clone());
    let mut order: Vec<usize> =
        (0..projections.classes.len()).filter(|&c| !projections.classes[c].0.is_empty()).collect();
    order.sort_by_key(|&class| std::cmp::Reverse(size(class)));
    (0..projections.classes.len()).map(|c| order.iter().position(|&o| o == c)).collect()
}

/// Returns a triangle at the edge of a cell, on the side to which the choice leads; empty if it
/// leads nowhere.
pub(super) fn arrow(choice: &Direction, rows_up: bool) -> String {
    let (dx, dy) = (f64::from(choice.column), f64::from(choice.row) * if rows_up { -1.0 } else { 1.0 });
    let length = dx.hypot(dy);
    if length == 0.0 {
        return String::new();
    }
    let (ux, uy) = (dx / length, dy / length);
    let half = SIDE as f64 / 2.0;
    let reach = half - 2.0;
    let tip = (half + ux * reach * length.min(1.25), half + uy * reach * length.min(1.25));
    let base = (tip.0 - ux * 7.0, tip.1 - uy * 7.0);
    let (px, py) = (-uy * 5.5, ux * 5.5);
    format!(
        "M{:.1} {:.1}L{:.1} {:.1}L{:.1} {:.1}Z",
        tip.0,
        tip.1,
        base.0 + px,
        base.1 + py,
        base.0 - px,
        base.1 - py
    )
}
