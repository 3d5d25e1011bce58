//! Projections of a set of states onto one or two variables.

use super::{Exploration, States};
use meliora_base::error::{Error, Limit, Result};
use meliora_engine::any::AnyStates;
use meliora_engine::symbolic::{Set, StateSet, SymbolicEngine};
use meliora_engine::{Algebra, Engine};
use meliora_export::projections::Plane;
use meliora_model::{Program, VarId};

/// The maximum number of cells of a projection.
const MOST_CELLS: u64 = 1 << 28;

/// A projection: for each cell of a plane, true if some state of a set has the values of the cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Projection {
    /// The number of rows: the number of values of the row's variable, or 1.
    pub rows: usize,
    /// The number of columns.
    pub columns: usize,
    /// The cells row by row, from the smallest values on.
    pub cells: Vec<bool>,
}

impl Exploration {
    /// Returns the states in which some variables have the given values. Cost: symbolically one
    /// conjunction per bit, explicitly one test per state.
    pub fn slice(&self, fixed: &[(VarId, i64)]) -> Result<States> {
        self.states().slice(fixed)
    }
}

impl States {
    /// Returns { s ∈ X : the variables have the given values in s }.
    ///
    /// # Errors
    /// The errors of [`Exploration::slice`].
    pub fn slice(&self, fixed: &[(VarId, i64)]) -> Result<States> {
        let engine = self.engine();
        let set = engine.intersection(&engine.slice(fixed)?, self.set())?;
        Ok(States::new(engine, set))
    }

    /// Computes for each cell of the plane if X has a state there with the values in `fixed`; all
    /// other variables may have any values. Cost: symbolically one conjunction per bit, one
    /// quantification, and one path of the diagram per cell; explicitly one test per state.
    ///
    /// # Errors
    /// The plane has too many cells; a limit is reached.
    pub fn projection(&self, plane: Plane, fixed: &[(VarId, i64)]) -> Result<Projection> {
        let program = self.engine().program();
        let mut projection = Projection::empty(program, plane)?;
        match (self.set(), self.engine().symbolic(), self.engine().explicit()) {
            (AnyStates::Symbolic(x), Some(engine), _) => {
                let slice = engine.intersection(&engine.slice(fixed)?, x)?;
                projection.fill(engine, &slice, plane)?;
            }
            (AnyStates::Explicit(x), _, Some(engine)) => {
                let place = Place::new(program, plane);
                engine.visit(x, &mut |state| {
                    if fits(state, fixed) {
                        projection.cells[place.row(state) * projection.columns + place.column(state)] = true;
                    }
                })?;
            }
            _ => return Err(Error::Usage("the set belongs to another engine".to_owned())),
        }
        Ok(projection)
    }
}

fn fits(state: &[i64], fixed: &[(VarId, i64)]) -> bool {
    fixed.iter().all(|&(variable, value)| state[variable.index()] == value)
}

/// The mapping from states to cells.
struct Place {
    row: Option<(usize, i64)>,
    column: (usize, i64),
}

impl Place {
    fn new(program: &Program, plane: Plane) -> Self {
        let axis = |v: VarId| (v.index(), program.variables[v.index()].low);
        Place { row: plane.row.map(axis), column: axis(plane.column) }
    }

    fn row(&self, state: &[i64]) -> usize {
        self.row.map_or(0, |(variable, low)| state[variable].wrapping_sub(low) as usize)
    }

    fn column(&self, state: &[i64]) -> usize {
        let (variable, low) = self.column;
        state[variable].wrapping_sub(low) as usize
    }
}

impl Projection {
    fn empty(program: &Program, plane: Plane) -> Result<Self> {
        let values = |v: VarId| {
            let variable = &program.variables[v.index()];
            (variable.high.wrapping_sub(variable.low) as u64).saturating_add(1)
        };
        let (rows, columns) = (plane.row.map_or(1, values), values(plane.column));
        let cells = rows.saturating_mul(columns);
        if cells > MOST_CELLS {
            let what = format!("a plane of {cells} cells ({MOST_CELLS} at most)");
            return Err(Limit::Size { what }.into());
        }
        let (rows, columns) = (rows as usize, columns as usize);
        Ok(Projection { rows, columns, cells: vec![false; rows * columns] })
    }

    /// Marks the cells of a set: quantifies all other variables, and evaluates the diagram at the
    /// bits of each cell.
    fn fill(&mut self, engine: &SymbolicEngine, x: &StateSet, plane: Plane) -> Result<()> {
        let onto: Vec<VarId> = plane.row.into_iter().chain([plane.column]).collect();
        let shadow = engine.projection(x, &onto)?;
        let diagram = engine.diagram(&[Set::States(shadow)], &[])?;
        let mut bits = vec![false; diagram.variables.len()];
        let levels = |variable: VarId| {
            let order = engine.encoding().order().iter().enumerate();
            order.filter(|(_, bit)| bit.variable == variable).map(|(l, bit)| (l, bit.index)).collect()
        };
        let row_levels: Vec<(usize, u32)> = plane.row.map_or_else(Vec::new, levels);
        let column_levels: Vec<(usize, u32)> = levels(plane.column);
        for row in 0..self.rows {
            row_levels.iter().for_each(|&(level, index)| bits[level] = row >> index & 1 == 1);
            for column in 0..self.columns {
                column_levels.iter().for_each(|&(level, index)| bits[level] = column >> index & 1 == 1);
                let inside = diagram.eval(diagram.roots[0], |level| bits[level as usize]);
                self.cells[row * self.columns + column] = inside;
            }
        }
        Ok(())
    }
}
