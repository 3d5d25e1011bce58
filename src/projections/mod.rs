//! The sets of a finished analysis over a plane of two variables, as one shared diagram that other
//! programs, such as the page that `meliora report` writes, evaluate for themselves.
//!
//! A cell of the plane is looked up by fixing some bits of the diagram: no state is ever enumerated, so
//! the other variables may have any number of values. A variable may also be left open; then the
//! cell speaks of the best that some value allows.

mod build;
mod directions;
mod plane;

pub use build::build;
pub use plane::Plane;

use ahash::AHashSet;

use crate::dump::{Diagram, Edge};
use crate::engine::symbolic::Encoding;
use crate::model::preference::ObjectiveSet;
use crate::model::{State, VarId, Variable};
use crate::planning::Rank;

/// Regions and strategies over a plane.
#[derive(Debug, Clone)]
pub struct Projections {
    /// The variables of the model.
    pub variables: Vec<Variable>,
    /// For each variable the levels of its bits in the diagram, least significant first.
    pub levels: Vec<Vec<u32>>,
    /// Which variables span the plane.
    pub plane: Plane,
    /// Whether larger rows stand higher, as on a map with north on top.
    pub rows_up: bool,
    /// The state whose values are shown first.
    pub at: State,
    /// The diagram that all edges below lead into.
    pub diagram: Diagram,
    /// The states of the scope.
    pub scope: Edge,
    /// Almost-sure improvements.
    pub sasi: Ladder,
    /// Possible improvements.
    pub spi: Ladder,
    /// The classes that occur, with their states.
    pub classes: Vec<(ObjectiveSet, Edge)>,
    /// The target of each objective.
    pub targets: Vec<Edge>,
    /// The choices, by their numbers in the strategies of the ladders; none where there are too many.
    pub choices: Vec<Direction>,
    /// Whether the sets are projected onto the plane, because all would be too large: then nothing can
    /// be asked of the other variables, which are open in every view.
    pub projected: bool,
}

/// The levels of one kind.
#[derive(Debug, Clone)]
pub struct Ladder {
    /// W_1 ⊋ W_2 ⊋ …
    pub levels: Vec<Edge>,
    /// The states of unbounded rank, where there are some.
    pub unbounded: Option<Edge>,
    /// Whether there may be more levels: `--max-level` ended the search.
    pub open: bool,
    /// For each choice of [`Projections::choices`] the states in which the permissive strategy of their own
    /// rank permits it.
    pub permitted: Vec<Edge>,
}

/// A choice and where in the plane it usually leads.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Direction {
    /// Its name.
    pub name: String,
    /// -1, 0 or 1: whether the row usually falls, stays or grows.
    pub row: i8,
    /// The same for the column.
    pub column: i8,
}

/// What is asked of a cell: for each variable a value, or none for any value.
pub type View = Vec<Option<i64>>;

/// What holds in a cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cell {
    /// The greatest SASI rank of a state that fits the view.
    pub sasi: Rank,
    /// The greatest SPI rank.
    pub spi: Rank,
    /// The classes of states that fit, by their positions in [`Projections::classes`].
    pub classes: Vec<usize>,
}

impl Projections {
    /// What holds in the states that fit a view; none where there are none.
    ///
    /// Cost: for each region, with no variable open, its number of bits; else its nodes at most.
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

    /// The objectives with a state of their target that fits a view.
    pub fn targets_at(&self, view: &View) -> Vec<usize> {
        let pattern = self.pattern(view);
        (0..self.targets.len()).filter(|&i| self.meets(self.targets[i], &pattern)).collect()
    }

    /// Whether a state that fits a view is in the set of an edge.
    pub fn holds(&self, edge: Edge, view: &View) -> bool {
        self.meets(edge, &self.pattern(view))
    }

    /// The view of a cell: the plane's variables with these values, the others as in `others`.
    pub fn view(&self, others: &View, row: i64, column: i64) -> View {
        let mut view = others.clone();
        if let Some(variable) = self.plane.row {
            view[variable.index()] = Some(row);
        }
        view[self.plane.column.index()] = Some(column);
        view
    }

    /// The names of the plane's variables, that of the rows first.
    pub fn names(&self) -> Vec<String> {
        let plane = self.plane.row.into_iter().chain([self.plane.column]);
        plane.map(|v| self.variables[v.index()].name.clone()).collect()
    }

    /// The values of the rows, from the top of the picture down.
    pub fn rows(&self) -> Vec<i64> {
        let mut rows = self.plane.row.map_or_else(|| vec![0], |row| self.values(row));
        if self.rows_up {
            rows.reverse();
        }
        rows
    }

    /// The values of the columns.
    pub fn columns(&self) -> Vec<i64> {
        self.values(self.plane.column)
    }

    fn values(&self, variable: VarId) -> Vec<i64> {
        let variable = &self.variables[variable.index()];
        (variable.low..=variable.high).collect()
    }

    /// What to show first: the values of [`Projections::at`].
    pub fn opening(&self) -> View {
        match self.projected {
            true => vec![None; self.at.len()],
            false => self.at.iter().map(|&value| Some(value)).collect(),
        }
    }

    /// What holds in a cell with the other variables as in `others`, and `true`; where no state fits
    /// these, what holds with any others, and `false`; none where there is no state at all.
    pub fn found(&self, others: &View, row: i64, column: i64) -> Option<(Cell, bool)> {
        let here = self.cell(&self.view(others, row, column)).map(|cell| (cell, true));
        let open = vec![None; self.at.len()];
        here.or_else(|| Some((self.cell(&self.view(&open, row, column))?, false)))
    }

    fn rank(&self, ladder: &Ladder, pattern: &[Option<bool>]) -> Rank {
        if ladder.unbounded.is_some_and(|fixpoint| self.meets(fixpoint, pattern)) {
            return Rank::Unbounded;
        }
        let rank = ladder.levels.iter().take_while(|&&level| self.meets(level, pattern)).count();
        if ladder.open && rank == ladder.levels.len() { Rank::AtLeast(rank) } else { Rank::Finite(rank) }
    }

    /// The bits of a view by their levels.
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

    /// Whether some assignment that fits the pattern satisfies a function.
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

/// For each variable the positions of its bits, least significant first.
fn levels(encoding: &Encoding) -> Vec<Vec<u32>> {
    let mut levels: Vec<Vec<u32>> = encoding.variables().iter().map(|v| vec![0; v.bits() as usize]).collect();
    for (position, bit) in encoding.order().iter().enumerate() {
        levels[bit.variable.index()][bit.index as usize] = position as u32;
    }
    levels
}
