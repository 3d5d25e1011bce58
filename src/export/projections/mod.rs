//! Projections: the sets of a finished analysis over a plane of two variables, as one shared
//! diagram. Other programs can evaluate the diagram, such as the page that `meliora report` writes.
//! This module contains data only; `output::page` draws all pictures, also of the preference order
//! (`meliora_model::hasse`).
//!
//! A cell of the plane is evaluated by fixing some bits of the diagram. No states are enumerated,
//! so the other variables may have any number of values. A variable may also be left open; then the
//! cell shows the best result over its values.

mod build;
mod directions;
mod game;
mod plane;

pub use build::build;
pub use game::{GameView, MoveView, PlayerView};
pub use plane::Plane;

use ahash::AHashSet;

use meliora_base::diagram::{Diagram, Edge};
use meliora_engine::symbolic::Encoding;
use meliora_model::preference::ObjectiveSet;
use meliora_model::{State, VarId, Variable};
use meliora_planning::Rank;

/// Regions and strategies over a plane.
#[derive(Debug, Clone)]
pub struct Projections {
    /// The variables of the model.
    pub variables: Vec<Variable>,
    /// For each variable the facts of a planning problem that its values stand for; see [`Program::facts_of`].
    ///
    /// [`Program::facts_of`]: meliora_model::Program::facts_of
    pub facts: Vec<Vec<String>>,
    /// For each variable the levels of its bits in the diagram, least significant first.
    pub levels: Vec<Vec<u32>>,
    /// The variables that span the plane.
    pub plane: Plane,
    /// True if larger rows are drawn higher, as on a map with north on top.
    pub rows_up: bool,
    /// The state whose values are shown first.
    pub at: State,
    /// The diagram that contains all edges below.
    pub diagram: Diagram,
    /// The states of the scope, without the unsafe ones.
    pub scope: Edge,
    /// The states from which no strategy keeps the requirements, if there are some.
    pub unsafe_states: Option<Edge>,
    /// Almost-sure improvements.
    pub sasi: Ladder,
    /// Possible improvements.
    pub spi: Ladder,
    /// The classes that occur, with their states.
    pub classes: Vec<(ObjectiveSet, Edge)>,
    /// The target of each objective.
    pub targets: Vec<Edge>,
    /// The labels of the model, with their states; unsafe ones are among them.
    pub labels: Vec<(String, Edge)>,
    /// The players of a game; `None` for other models.
    pub game: Option<GameView>,
    /// The choices, by their numbers in the strategies of the ladders; empty if there are too many.
    pub choices: Vec<Direction>,
    /// True if the sets are projected onto the plane, because the full sets would be too large.
    /// Then the other variables are open in every view.
    pub projected: bool,
}

/// The levels of one kind.
#[derive(Debug, Clone)]
pub struct Ladder {
    /// W_1 ⊋ W_2 ⊋ …
    pub levels: Vec<Edge>,
    /// The states of unbounded rank, if any.
    pub unbounded: Option<Edge>,
    /// True if there may be more levels: `--max-level` ended the search.
    pub open: bool,
    /// For each choice of [`Projections::choices`] the states that permit it, by the permissive
    /// strategy of their own rank.
    pub permitted: Vec<Edge>,
}

/// A choice, and the direction in the plane in which it usually leads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Direction {
    /// Its label, or its commands.
    pub name: String,
    /// Its name in the states where several choices with its label are enabled.
    pub own: String,
    /// The states where several choices with its label are enabled; `None` if no other choice has the label.
    pub several: Option<Edge>,
    /// The usual change of the row: -1, 0 or 1.
    pub row: i8,
    /// The usual change of the column.
    pub column: i8,
}

/// A query for a cell: for each variable a value, or none for any value.
pub type View = Vec<Option<i64>>;

/// The states that match a view.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Inside {
    /// Some states from which the requirements can be kept, with their results.
    Safe(Cell),
    /// Unsafe states only.
    Unsafe,
}

/// The results in a cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cell {
    /// The greatest SASI rank of a state that matches the view.
    pub sasi: Rank,
    /// The greatest SPI rank of a state that matches the view.
    pub spi: Rank,
    /// The classes of states that match, by their indices in [`Projections::classes`].
    pub classes: Vec<usize>,
}

impl Projections {
    /// Returns the results over the states that match a view, without unsafe ones; none if no such
    /// state matches.
    ///
    /// Cost per region: its number of bits if no variable is open, otherwise at most its nodes.
    pub fn cell(&self, view: &View) -> Option<Cell> {
        let pattern = self.pattern(view);
        if !self.meets(self.scope, &pattern) {
            return None;
        }
        let classes = (0..self.classes.len()).filter(|&c| self.meets(self.classes[c].1, &pattern));
        Some(Cell {
            sasi: self.rank(&self.sasi, &pattern),
            spi: self.rank(&self.spi, &pattern),
            classes: classes.collect(),
        })
    }

    /// Returns true if the set of an edge contains a state that matches a view.
    pub fn holds(&self, edge: Edge, view: &View) -> bool {
        self.meets(edge, &self.pattern(view))
    }

    /// Returns the view of a cell: these values for the variables of the plane, the others as in
    /// `others`.
    pub fn view(&self, others: &View, row: i64, column: i64) -> View {
        let mut view = others.clone();
        if let Some(variable) = self.plane.row {
            view[variable.index()] = Some(row);
        }
        view[self.plane.column.index()] = Some(column);
        view
    }

    /// Formats a value of a variable as people read it: `x=1`, or the fact of a planning problem.
    pub fn reading(&self, variable: usize, value: i64) -> String {
        self.variables[variable].reading(&self.facts[variable], value)
    }

    /// Returns the names of the variables of the plane, rows first.
    pub fn names(&self) -> Vec<String> {
        let plane = self.plane.row.into_iter().chain([self.plane.column]);
        plane.map(|v| self.variables[v.index()].name.clone()).collect()
    }

    /// Returns whether a cell is the one of the state that is shown first.
    pub fn is_first(&self, row: i64, column: i64) -> bool {
        let value = |variable: VarId| self.at[variable.index()];
        row == self.plane.row.map_or(0, value) && column == value(self.plane.column)
    }

    /// Returns the values of the rows, from the top of the picture down.
    pub fn rows(&self) -> Vec<i64> {
        let mut rows = self.plane.row.map_or_else(|| vec![0], |row| self.values(row));
        if self.rows_up {
            rows.reverse();
        }
        rows
    }

    /// Returns the values of the columns.
    pub fn columns(&self) -> Vec<i64> {
        self.values(self.plane.column)
    }

    fn values(&self, variable: VarId) -> Vec<i64> {
        let variable = &self.variables[variable.index()];
        (variable.low..=variable.high).collect()
    }

    /// Returns the first view to show: the values of [`Projections::at`], or all variables open if
    /// the sets are projected.
    pub fn opening(&self) -> View {
        match self.projected {
            true => vec![None; self.at.len()],
            false => self.at.iter().map(|&value| Some(value)).collect(),
        }
    }

    /// Returns the states in a cell with the other variables as in `others`, and `true`. If no state
    /// matches, returns those with any values of the others, and `false`; none if that matches no state
    /// either.
    pub fn found(&self, others: &View, row: i64, column: i64) -> Option<(Inside, bool)> {
        let here = self.inside(&self.view(others, row, column)).map(|inside| (inside, true));
        let open = vec![None; self.at.len()];
        here.or_else(|| Some((self.inside(&self.view(&open, row, column))?, false)))
    }

    /// Returns whether in every state that matches a view the opponent chooses, and there is such a
    /// state.
    pub fn is_theirs(&self, view: &View) -> bool {
        let Some(game) = &self.game else { return false };
        let chooses = |ours| game.players.iter().any(|p| p.ours == ours && self.holds(p.states, view));
        chooses(false) && !chooses(true)
    }

    fn inside(&self, view: &View) -> Option<Inside> {
        let is_unsafe = || self.unsafe_states.is_some_and(|states| self.holds(states, view));
        self.cell(view).map(Inside::Safe).or_else(|| is_unsafe().then_some(Inside::Unsafe))
    }

    fn rank(&self, ladder: &Ladder, pattern: &[Option<bool>]) -> Rank {
        if ladder.unbounded.is_some_and(|fixpoint| self.meets(fixpoint, pattern)) {
            return Rank::Unbounded;
        }
        let rank = ladder.levels.iter().take_while(|&&level| self.meets(level, pattern)).count();
        if ladder.open && rank == ladder.levels.len() { Rank::AtLeast(rank) } else { Rank::Finite(rank) }
    }

    /// Returns the bits of a view by level.
    fn pattern(&self, view: &View) -> Vec<Option<bool>> {
        let mut pattern = vec![None; self.diagram.variables.len()];
        for ((variable, levels), value) in self.variables.iter().zip(&self.levels).zip(view) {
            let Some(value) = value else { continue };
            let offset = value.wrapping_sub(variable.low);
            for (index, &level) in levels.iter().enumerate() {
                pattern[level as usize] = Some(offset >> index & 1 == 1);
            }
        }
        pattern
    }

    /// Returns true if some assignment that matches the pattern satisfies a function.
    fn meets(&self, edge: Edge, pattern: &[Option<bool>]) -> bool {
        let (mut stack, mut seen) = (vec![edge], AHashSet::new());
        while let Some(edge) = stack.pop() {
            let Some(node) = self.diagram.node(edge) else {
                if edge == Edge::TRUE {
                    return true;
                }
                continue;
            };
            let (then, otherwise) = self.diagram.cofactors(edge, node.level);
            match pattern.get(node.level as usize).copied().flatten() {
                Some(true) => stack.push(then),
                Some(false) => stack.push(otherwise),
                None if seen.insert(edge) => stack.extend([otherwise, then]),
                None => {}
            }
        }
        false
    }
}

/// Returns for each variable the levels of its bits, least significant first.
fn levels(encoding: &Encoding) -> Vec<Vec<u32>> {
    let mut levels: Vec<Vec<u32>> = encoding.variables().iter().map(|v| vec![0; v.bits() as usize]).collect();
    for (position, bit) in encoding.order().iter().enumerate() {
        levels[bit.variable.index()][bit.index as usize] = position as u32;
    }
    levels
}
