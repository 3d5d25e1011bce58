//! Levels and ranks.

use meliora::planning::levels::End;
use meliora::{Analysis, Choose, Error, Kind, Projection, Result, States, Wanted};
use num_bigint::BigUint;
use pyo3::prelude::*;
use pyo3::types::{PyIterator, PyTuple};

use crate::arrays;
use crate::errors::{unpicklable, usage};
use crate::handle::Handle;
use crate::region::{Region, View, shape};
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

impl Levels {
    /// Returns W_k: all states but the unsafe ones for k = 0; past the last level the fixpoint, which
    /// may be empty.
    fn level(analysis: &Analysis, kind: Kind, k: usize) -> Result<States> {
        let Some(index) = k.checked_sub(1) else { return Ok(analysis.safe_states()) };
        let found = analysis.level_states(kind);
        if let Some(states) = found.get(index) {
            return Ok(states.clone());
        }
        match &analysis.levels(kind).end {
            Some(End::Empty) => Ok(none(analysis)),
            Some(End::Unbounded(_)) => Ok(found.last().cloned().unwrap_or_else(|| none(analysis))),
            Some(End::Cut) | None => {
                Err(Error::Usage(format!("level {k} was not searched: {} are known", found.len())))
            }
        }
    }
}

fn none(analysis: &Analysis) -> States {
    let all = analysis.exploration().states();
    // The engine computes a difference with itself at no cost.
    all.difference(&all).unwrap_or(all)
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
        let found = self.handle.quick(py, |analysis| match &analysis.levels(self.kind).end {
            Some(End::Empty) => Ok(Some(none(analysis))),
            Some(End::Unbounded(_)) => Ok(analysis.level_states(self.kind).pop()),
            Some(End::Cut) | None => Ok(None),
        })?;
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
        let states = self.handle.quick(py, |analysis| Levels::level(analysis, self.kind, k))?;
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
        let states = self.handle.long(py, move |analysis| {
            Levels::level(analysis, kind, k)?.difference(&Levels::level(analysis, kind, k + 1)?)
        })?;
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
        let plane = view.plane;
        let kind = self.kind;
        let (shape, ranks) = self.handle.long(py, move |analysis| {
            let scope = analysis.safe_states().projection(view.plane, &view.fixed)?;
            let ranks = ranks(analysis, kind, &view, &scope)?;
            Ok((shape(plane, &scope), ranks))
        })?;
        arrays::floats(py, &ranks, &shape)
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

/// Computes the greatest rank for each cell of the scope's projection.
fn ranks(analysis: &Analysis, kind: Kind, view: &View, scope: &Projection) -> Result<Vec<f64>> {
    let mut ranks: Vec<f64> = scope.cells.iter().map(|&there| if there { 0.0 } else { f64::NAN }).collect();
    let found = analysis.level_states(kind);
    let unbounded = matches!(analysis.levels(kind).end, Some(End::Unbounded(_)));
    for (index, level) in found.iter().enumerate() {
        let is_last = index + 1 == found.len();
        let rank = if unbounded && is_last { f64::INFINITY } else { (index + 1) as f64 };
        let projection = level.projection(view.plane, &view.fixed)?;
        for (cell, _) in ranks.iter_mut().zip(projection.cells).filter(|(_, there)| *there) {
            *cell = rank;
        }
    }
    Ok(ranks)
}

/// Checks that a level is not negative.
pub(crate) fn level(k: i64) -> PyResult<usize> {
    usize::try_from(k).map_err(|_| usage(format!("{k} is no level: they are counted from 0")))
}
