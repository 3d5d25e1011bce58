//! Sets of states as values.

use std::sync::{Arc, Mutex};

use meliora::model::VarId;
use meliora::projections::Plane;
use meliora::supervise::lock;
use meliora::{Error, Listing, Projection, States};
use num_bigint::BigUint;
use pyo3::basic::CompareOp;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};

use crate::errors::{unpicklable, usage};
use crate::options;
use crate::values::{Names, as_dict};
use crate::worker::Worker;
use crate::{arrays, display, region_export};

/// The origin of regions: the worker for operations on them, and the names of their variables.
#[derive(Clone)]
pub(crate) struct Space {
    pub(crate) worker: Arc<Worker>,
    pub(crate) names: Arc<Names>,
}

impl Space {
    pub(crate) fn region(&self, states: States) -> Region {
        Region { states, space: self.clone() }
    }

    /// Returns a tuple of regions.
    pub(crate) fn regions<'py>(&self, py: Python<'py>, all: Vec<States>) -> PyResult<Bound<'py, PyTuple>> {
        let all: Vec<Py<Region>> =
            all.into_iter().map(|states| Py::new(py, self.region(states))).collect::<PyResult<_>>()?;
        PyTuple::new(py, all)
    }

    /// Runs an operation on sets; on the calling thread if they are `small`.
    ///
    /// # Errors
    /// The errors of the operation; `KeyboardInterrupt`, or any other exception of a signal
    /// handler.
    fn work<T: Send + 'static>(
        &self,
        py: Python<'_>,
        small: bool,
        work: impl FnOnce() -> Result<T, Error> + Send + 'static,
    ) -> PyResult<T> {
        if small { self.worker.quick(py, work) } else { self.worker.long(py, work) }
    }

    /// Returns the plane that two variables span, and the values of fixed variables.
    ///
    /// # Errors
    /// `UsageError` if a variable is unknown, named twice, or fixed although it spans the plane.
    pub(crate) fn view(
        &self,
        row: Option<&str>,
        column: &str,
        fixed: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<View> {
        let column_id = self.names.variable(column)?;
        let row_id = row.map(|row| self.names.variable(row)).transpose()?;
        if row_id == Some(column_id) {
            return Err(usage(format!("`{column}` cannot be both row and column")));
        }
        let fixed = match fixed {
            Some(values) => self.names.fixed(&as_dict(values)?)?,
            None => Vec::new(),
        };
        if let Some(&(id, _)) = fixed.iter().find(|(id, _)| Some(*id) == row_id || *id == column_id) {
            let name = &self.names.program.variables[id.index()].name;
            return Err(usage(format!("`{name}` spans the picture: `where` cannot fix it")));
        }
        Ok(View { plane: Plane { row: row_id, column: column_id }, fixed })
    }

    /// Returns `r,c` for the names of the variables that span maps.
    ///
    /// # Errors
    /// `UsageError` unless one or two different variables are named.
    pub(crate) fn grid(&self, names: Option<Vec<String>>) -> PyResult<Option<String>> {
        let Some(names) = names else { return Ok(None) };
        match names.as_slice() {
            [column] => self.view(None, column, None)?,
            [row, column] => self.view(Some(row), column, None)?,
            _ => return Err(usage("grid: one or two names of variables, (row, column)")),
        };
        Ok(Some(names.join(",")))
    }
}

/// A plane, and values that fix other variables.
pub(crate) struct View {
    pub(crate) plane: Plane,
    pub(crate) fixed: Vec<(VarId, i64)>,
}

/// Returns the shape of an array over a plane: two dimensions if there are rows, else one.
pub(crate) fn shape(plane: Plane, projection: &Projection) -> Vec<usize> {
    match plane.row {
        Some(_) => vec![projection.rows, projection.columns],
        None => vec![projection.columns],
    }
}

/// A set of states, as an immutable value. Its size is that of its diagram, which does not depend
/// on the number of states.
///
/// `a & b`, `a | b`, `a - b`, `a ^ b` and `~a` return new regions. `a <= b` tests inclusion, and
/// `state in a` tests membership of a dictionary with a value for every variable. `bool(a)` is
/// False for the empty region. Iteration returns the states in the order of their values, first
/// variable first. Operators combine regions of one exploration, also from different analyses.
/// Regions of different explorations are never equal, and operators refuse them.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Region {
    pub(crate) states: States,
    pub(crate) space: Space,
}

/// The row (if any), the column, and the rows of a picture.
type Picture = (Option<String>, String, Vec<Vec<bool>>);

/// An operation on two sets.
type Operation = fn(&States, &States) -> Result<States, Error>;

impl Region {
    fn with(&self, py: Python<'_>, other: &Region, operation: Operation) -> PyResult<Region> {
        if !self.states.engine().shares(other.states.engine()) {
            return Err(usage("the regions are of different explorations"));
        }
        let (x, y) = (self.states.clone(), other.states.clone());
        let small = x.is_small() && y.is_small();
        Ok(self.space.region(self.space.work(py, small, move || operation(&x, &y))?))
    }

    fn is_subset(&self, py: Python<'_>, other: &Region) -> PyResult<bool> {
        let rest = self.with(py, other, States::difference)?.states;
        self.space.worker.quick(py, || rest.is_empty())
    }

    fn members<'py>(&self, py: Python<'py>, states: &[Vec<i64>]) -> PyResult<Bound<'py, PyList>> {
        let dicts = states.iter().map(|state| self.space.names.dict(py, state));
        PyList::new(py, dicts.collect::<PyResult<Vec<_>>>()?)
    }
}

#[pymethods]
impl Region {
    fn __and__(&self, py: Python<'_>, other: &Bound<'_, Region>) -> PyResult<Region> {
        self.with(py, other.get(), States::intersection)
    }

    fn __or__(&self, py: Python<'_>, other: &Bound<'_, Region>) -> PyResult<Region> {
        self.with(py, other.get(), States::union)
    }

    fn __sub__(&self, py: Python<'_>, other: &Bound<'_, Region>) -> PyResult<Region> {
        self.with(py, other.get(), States::difference)
    }

    fn __xor__(&self, py: Python<'_>, other: &Bound<'_, Region>) -> PyResult<Region> {
        self.with(py, other.get(), States::symmetric_difference)
    }

    /// Returns all other states of the scope.
    fn __invert__(&self, py: Python<'_>) -> PyResult<Region> {
        let x = self.states.clone();
        Ok(self.space.region(self.space.worker.long(py, move || x.complement())?))
    }

    fn __richcmp__<'py>(
        &self,
        py: Python<'py>,
        other: &Bound<'py, PyAny>,
        operator: CompareOp,
    ) -> PyResult<Bound<'py, PyAny>> {
        let Ok(other) = other.cast::<Region>() else { return Ok(py.NotImplemented().into_bound(py)) };
        let other = other.get();
        let answer = match operator {
            CompareOp::Eq => self.states == other.states,
            CompareOp::Ne => self.states != other.states,
            CompareOp::Le => self.is_subset(py, other)?,
            CompareOp::Ge => other.is_subset(py, self)?,
            CompareOp::Lt => self.is_subset(py, other)? && self.states != other.states,
            CompareOp::Gt => other.is_subset(py, self)? && self.states != other.states,
        };
        Ok(answer.into_pyobject(py)?.to_owned().into_any())
    }

    fn __bool__(&self, py: Python<'_>) -> PyResult<bool> {
        self.space.worker.quick(py, || Ok(!self.states.is_empty()?))
    }

    fn __contains__(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<bool> {
        let state = self.space.names.state(state)?;
        self.space.worker.quick(py, || self.states.contains(&state))
    }

    /// Returns the exact number of states. (`len` is limited to 2**63 - 1.)
    pub(crate) fn count(&self, py: Python<'_>) -> PyResult<BigUint> {
        let x = self.states.clone();
        self.space.work(py, x.is_small(), move || x.count())
    }

    /// Returns up to `limit` states as dictionaries, in the order of their values, first variable
    /// first.
    #[pyo3(signature = (limit=1000))]
    fn states<'py>(&self, py: Python<'py>, limit: i128) -> PyResult<Bound<'py, PyList>> {
        let limit = options::count("limit", limit)?;
        let x = self.states.clone();
        let small = x.is_small() && limit <= 100;
        let found = self.space.work(py, small, move || x.list(limit))?;
        self.members(py, &found)
    }

    fn __iter__(&self, py: Python<'_>) -> PyResult<RegionIterator> {
        let x = self.states.clone();
        let listing = self.space.worker.long(py, move || x.listing())?;
        Ok(RegionIterator { rest: Mutex::new(listing), space: self.space.clone() })
    }

    /// Draws `size` distinct states uniformly at random.
    ///
    /// Equal seeds draw the same states with the same engine and order of bits.
    ///
    /// Raises:
    ///     UsageError: The region has fewer states.
    #[pyo3(signature = (size=1, seed=0))]
    fn sample<'py>(&self, py: Python<'py>, size: i128, seed: i128) -> PyResult<Bound<'py, PyList>> {
        let (size, seed) = (options::count("size", size)?, options::count("seed", seed)?);
        let x = self.states.clone();
        let found = self.space.worker.long(py, move || x.sample(size, seed))?;
        self.members(py, &found)
    }

    /// Returns the states in which some variables have these values: `region.where(b=8, d=True)`.
    #[pyo3(name = "where", signature = (**values))]
    fn restricted(&self, py: Python<'_>, values: Option<&Bound<'_, PyDict>>) -> PyResult<Region> {
        let fixed = values.map_or(Ok(Vec::new()), |values| self.space.names.fixed(values))?;
        let x = self.states.clone();
        Ok(self.space.region(self.space.worker.long(py, move || x.slice(&fixed))?))
    }

    /// Returns the projection of the region onto one or two integer variables. The result is a
    /// Boolean array of shape (rows, columns), or (columns,) if `row` is None, from the smallest
    /// values on. A cell is True if the region has a state there in which the variables of `where`
    /// have their values; all other variables are free.
    ///
    /// The symbolic engine does not enumerate states for this. Needs NumPy.
    #[pyo3(signature = (row, column, r#where=None))]
    fn to_numpy<'py>(
        &self,
        py: Python<'py>,
        row: Option<&str>,
        column: &str,
        r#where: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let View { plane, fixed } = self.space.view(row, column, r#where)?;
        let x = self.states.clone();
        let projection = self.space.worker.long(py, move || x.projection(plane, &fixed))?;
        arrays::bools(py, &projection.cells, &shape(plane, &projection))
    }

    /// Returns the region as a function of the package `dd`, over variables named by bits: `x.2`
    /// for bit 2 of x.
    ///
    /// Args:
    ///     manager: A BDD manager of `dd`, to which missing bits are added; None for a new one of
    ///         `dd.autoref`. The function's `bdd` is the manager.
    ///
    /// Raises:
    ///     UsageError: The region belongs to the explicit engine, which has no diagrams.
    #[pyo3(signature = (manager=None))]
    fn to_dd<'py>(&self, py: Python<'py>, manager: Option<Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
        region_export::to_dd(py, &self.diagram(py)?, manager)
    }

    /// Returns the diagram of the region in DDDMP 2.0 text, as CUDD and `dd` read it, over the
    /// names of the bits.
    fn to_dddmp(&self, py: Python<'_>) -> PyResult<String> {
        region_export::to_dddmp(&self.diagram(py)?)
    }

    /// Returns a picture of the region's diagram in the language DOT.
    fn to_dot(&self, py: Python<'_>) -> PyResult<String> {
        region_export::to_dot(&self.diagram(py)?)
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let count = self.count(py)?;
        let states = if count == BigUint::from(1u8) { "state" } else { "states" };
        Ok(format!("<Region of {count} {states}>"))
    }

    fn __str__(&self, py: Python<'_>) -> PyResult<String> {
        let x = self.states.clone();
        self.space.worker.long(py, move || Ok(x.to_string()))
    }

    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        display::html(slf.as_any(), "region")
    }

    /// Returns the variables with names that suggest rows and columns, and the projection of the
    /// region onto them by rows; None if there are none.
    fn _picture(&self, py: Python<'_>) -> PyResult<Option<Picture>> {
        let program = &self.space.names.program;
        let Some(plane) = Plane::guess(program) else { return Ok(None) };
        let x = self.states.clone();
        let projection = self.space.worker.long(py, move || x.projection(plane, &[]))?;
        let name = |v: VarId| program.variables[v.index()].name.clone();
        let rows = projection.cells.chunks(projection.columns).map(<[bool]>::to_vec).collect();
        Ok(Some((plane.row.map(name), name(plane.column), rows)))
    }

    fn __reduce__(&self) -> PyResult<Py<PyAny>> {
        Err(unpicklable("a Region", "`list(region)` and `to_dddmp()` can be pickled"))
    }
}

impl Region {
    fn diagram(&self, py: Python<'_>) -> PyResult<meliora::dump::Diagram> {
        let x = self.states.clone();
        self.space.worker.long(py, move || region_export::diagram(&x))
    }
}

/// An iterator over the states of a region.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct RegionIterator {
    rest: Mutex<Listing>,
    space: Space,
}

#[pymethods]
impl RegionIterator {
    fn __iter__(slf: Bound<'_, Self>) -> Bound<'_, Self> {
        slf
    }

    fn __next__<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let next = self.space.worker.quick(py, || lock(&self.rest).next().transpose())?;
        next.map(|state| self.space.names.dict(py, &state)).transpose()
    }
}
