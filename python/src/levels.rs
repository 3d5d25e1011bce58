//! Levels and ranks.

use meliora::planning::levels::End;
use meliora::{Analysis, Choose, Kind, Rank, Wanted};
use num_bigint::BigUint;
use pyo3::prelude::*;
use pyo3::types::{PyIterator, PyTuple};

use crate::arrays;
use crate::errors::{unpicklable, usage};
use crate::handle::Handle;
use crate::region::{Region, shape};
use crate::strategy::Strategy;
use crate::values::rank_of_safe;
use crate::worker::Call;

/// The levels of one kind. Level k contains the states from which k improvements can be made,
/// almost surely (SASI) or with positive probability (SPI).
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Levels {
    pub(crate) kind: Kind,
    pub(crate) handle: Handle,
}

#[pymethods]
impl Levels {
    /// `"sasi"` or `"spi"`.
    #[getter]
    fn kind(&self) -> &'static str {
        self.kind.name()
    }

    /// The sizes of the known levels from level 1 on, strictly decreasing; empty if no state can improve,
    /// or if none is known yet (`complete` is False).
    #[getter]
    fn counts(&self) -> Vec<BigUint> {
        let known = self.handle.known();
        match self.kind {
            Kind::Sasi => known.sasi.levels,
            Kind::Spi => known.spi.levels,
        }
    }

    /// The known levels from level 1 on; empty if `counts` is.
    #[getter]
    fn regions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let found = self.handle.quick(py, |analysis| Ok(analysis.level_states(self.kind)))?;
        self.handle.space.regions(py, found)
    }

    /// The states from which any number of improvements is possible. None if this is unknown,
    /// because `max_level` or a limit ended the search.
    #[getter]
    fn unbounded(&self, py: Python<'_>) -> PyResult<Option<Region>> {
        let found = self.handle.quick(py, |analysis| analysis.unbounded(self.kind))?;
        Ok(found.map(|states| self.handle.space.region(states)))
    }

    /// True if all levels are known: neither `max_level` nor a limit ended the search.
    #[getter]
    fn complete(&self, py: Python<'_>) -> PyResult<bool> {
        self.handle.quick(py, |analysis| {
            let end = &analysis.levels(self.kind).end;
            Ok(matches!(end, Some(End::Empty | End::Unbounded(_))))
        })
    }

    /// The number of known levels.
    fn __len__(&self) -> usize {
        self.counts().len()
    }

    /// Returns the region of a known level, from level 1 at index 0 on, as `regions` does.
    fn __getitem__<'py>(&self, py: Python<'py>, index: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.regions(py)?.into_any().get_item(index)
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        self.regions(py)?.into_any().try_iter()
    }

    /// Returns the states of rank k or more; for k = 0 all states but the unsafe ones, which have no
    /// rank.
    ///
    /// Raises:
    ///     UsageError: The level was not computed.
    fn at_least(&self, py: Python<'_>, k: i64) -> PyResult<Region> {
        let k = level(k)?;
        let states = self.handle.quick(py, |analysis| analysis.at_least(self.kind, k))?;
        Ok(self.handle.space.region(states))
    }

    /// Returns the states of rank k exactly; `math.inf` for those of unbounded rank.
    ///
    /// Raises:
    ///     UsageError: The levels that determine these states were not computed.
    fn exactly(&self, py: Python<'_>, k: f64) -> PyResult<Region> {
        if k == f64::INFINITY {
            let missing = || usage("whether a rank is unbounded was not searched");
            return self.unbounded(py)?.ok_or_else(missing);
        }
        if k < 0.0 || k.fract() != 0.0 {
            return Err(usage(format!("{k} is no rank: an int from 0, or math.inf")));
        }
        let (kind, k) = (self.kind, k as usize);
        let states = self.handle.long(py, move |analysis| analysis.exactly(kind, k))?;
        Ok(self.handle.space.region(states))
    }

    /// Returns the rank of a state: the number of possible or sure improvements, an int or
    /// `math.inf`; `math.nan` for unsafe states, which have none. If `max_level` ended the search,
    /// the true rank of a state in the last level may be larger; see `complete`.
    ///
    /// Raises:
    ///     UsageError: A variable is missing or unknown.
    fn rank<'py>(&self, py: Python<'py>, state: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let state = self.handle.space.names.state(state)?;
        let found =
            |analysis: &Analysis| Ok((analysis.is_unsafe(&state)?, analysis.rank(self.kind, &state)?));
        let (is_unsafe, rank) = self.handle.quick(py, found)?;
        rank_of_safe(py, is_unsafe, rank)
    }

    /// Returns the greatest ranks over one or two integer variables. The result is an array of
    /// floats of shape (rows, columns), or (columns,) if `row` is None, from the smallest values
    /// on. A cell contains the greatest rank of its states in which the variables of `where` have
    /// their values; all other variables are free. A cell without states is NaN, and so is one whose
    /// states are all unsafe; `Analysis.region("unsafe")` tells them apart. An unbounded rank is
    /// infinity.
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
        let view = self.handle.space.view(row, column, r#where)?;
        let (kind, plane) = (self.kind, view.plane);
        let found = move |analysis: &Analysis| analysis.greatest_ranks(kind, plane, &view.fixed);
        let (scope, ranks) = self.handle.long(py, found)?;
        let ranks: Vec<f64> = ranks.into_iter().map(|rank| rank.map_or(f64::NAN, float_of)).collect();
        arrays::floats(py, &ranks, &shape(plane, &scope))
    }

    /// Returns the strategies of this kind.
    fn strategy(&self, py: Python<'_>) -> PyResult<Strategy> {
        let kind = (self.kind.into(), None);
        let at = (py, &Call::plain());
        Strategy::new(at, &self.handle, kind, Choose::First, Vec::new(), Wanted::default())
    }

    fn __repr__(&self) -> String {
        let counts: Vec<String> = self.counts().iter().map(ToString::to_string).collect();
        format!("<Levels of {}: [{}]>", self.kind.name(), counts.join(", "))
    }

    fn __reduce__(&self) -> PyResult<Py<PyAny>> {
        Err(unpicklable("Levels", "`counts` and arrays can be pickled"))
    }
}

/// Converts a rank to a float.
fn float_of(rank: Rank) -> f64 {
    match rank {
        Rank::Finite(k) | Rank::AtLeast(k) => k as f64,
        Rank::Unbounded => f64::INFINITY,
    }
}

/// Checks that a level is not negative.
pub(crate) fn level(k: i64) -> PyResult<usize> {
    usize::try_from(k).map_err(|_| usage(format!("{k} is no level: they are counted from 0")))
}
