//! Levels and ranks.

use std::sync::Arc;

use meliora::embed::{Planning, Projection, States};
use meliora::planning::levels::End;
use meliora::planning::{Kind, Rank};
use meliora::{Error, Result};
use num_bigint::BigUint;
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyTuple};

use crate::arrays;
use crate::errors::unpicklable;
use crate::exploration::level;
use crate::region::{Region, Space, View, shape};
use crate::shared::Shared;
use crate::strategy::Strategy;
use crate::watch::lock;

/// The levels of one kind. Level k contains the states from which k improvements can be made,
/// almost surely (SASI) or with positive probability (SPI).
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Levels {
    pub(crate) kind: Kind,
    pub(crate) shared: Arc<Shared>,
    pub(crate) space: Space,
}

/// Converts a rank to an int, or infinity.
pub(crate) fn rank_of<'py>(py: Python<'py>, rank: Rank) -> PyResult<Bound<'py, PyAny>> {
    Ok(match rank {
        Rank::Finite(k) | Rank::AtLeast(k) => k.into_pyobject(py)?.into_any(),
        Rank::Unbounded => PyFloat::new(py, f64::INFINITY).into_any(),
    })
}

impl Levels {
    fn look<T>(&self, py: Python<'_>, at: impl FnOnce(&Planning) -> Result<T>) -> PyResult<T> {
        self.space.worker.quick(py, || at(&lock(&self.shared.planning)))
    }

    /// Returns W_k: all states for k = 0; past the last level the fixpoint, which may be empty.
    fn level(planning: &Planning, kind: Kind, k: usize) -> Result<States> {
        let Some(index) = k.checked_sub(1) else { return Ok(planning.exploration().states()) };
        let found = planning.levels(kind);
        if let Some(states) = found.get(index) {
            return Ok(states.clone());
        }
        match &planning.analysis().levels(kind).end {
            Some(End::Empty) => Ok(none(planning)),
            Some(End::Unbounded(_)) => Ok(found.last().cloned().unwrap_or_else(|| none(planning))),
            Some(End::Cut) | None => {
                Err(Error::Usage(format!("level {k} was not searched: {} are known", found.len())))
            }
        }
    }
}

fn none(planning: &Planning) -> States {
    let all = planning.exploration().states();
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

    /// The sizes of the known levels from level 1 on, strictly decreasing.
    #[getter]
    fn counts(&self) -> Vec<BigUint> {
        let known = lock(&self.shared.known);
        match self.kind {
            Kind::Sasi => known.sasi.levels.clone(),
            Kind::Spi => known.spi.levels.clone(),
        }
    }

    /// The known levels from level 1 on.
    #[getter]
    fn regions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let found = self.look(py, |planning| Ok(planning.levels(self.kind)))?;
        self.space.regions(py, found)
    }

    /// The states from which any number of improvements is possible. None if this is unknown,
    /// because `max_level` or a limit ended the search.
    #[getter]
    fn unbounded(&self, py: Python<'_>) -> PyResult<Option<Region>> {
        let found = self.look(py, |planning| match &planning.analysis().levels(self.kind).end {
            Some(End::Empty) => Ok(Some(none(planning))),
            Some(End::Unbounded(_)) => Ok(planning.levels(self.kind).pop()),
            Some(End::Cut) | None => Ok(None),
        })?;
        Ok(found.map(|states| self.space.region(states)))
    }

    /// True if all levels are known: neither `max_level` nor a limit ended the search.
    #[getter]
    fn complete(&self, py: Python<'_>) -> PyResult<bool> {
        self.look(py, |planning| {
            let end = &planning.analysis().levels(self.kind).end;
            Ok(matches!(end, Some(End::Empty | End::Unbounded(_))))
        })
    }

    /// The number of known levels.
    fn __len__(&self) -> usize {
        self.counts().len()
    }

    /// Returns the states of rank k or more; all states for k = 0.
    ///
    /// Raises:
    ///     UsageError: The level was not computed.
    fn at_least(&self, py: Python<'_>, k: i64) -> PyResult<Region> {
        let k = level(k)?;
        let states = self.look(py, |planning| Levels::level(planning, self.kind, k))?;
        Ok(self.space.region(states))
    }

    /// Returns the states of rank k exactly; `math.inf` for those of unbounded rank.
    ///
    /// Raises:
    ///     UsageError: The levels that determine these states were not computed.
    fn exactly(&self, py: Python<'_>, k: f64) -> PyResult<Region> {
        if k == f64::INFINITY {
            let missing = || crate::errors::usage("whether a rank is unbounded was not searched");
            return self.unbounded(py)?.ok_or_else(missing);
        }
        if k < 0.0 || k.fract() != 0.0 {
            return Err(crate::errors::usage(format!("{k} is no rank: an int from 0, or math.inf")));
        }
        let (shared, kind, k) = (Arc::clone(&self.shared), self.kind, k as usize);
        let states = self.space.worker.long(py, move || {
            let planning = lock(&shared.planning);
            Levels::level(&planning, kind, k)?.difference(&Levels::level(&planning, kind, k + 1)?)
        })?;
        Ok(self.space.region(states))
    }

    /// Returns the rank of a state: the number of possible or sure improvements, an int or
    /// `math.inf`. If `max_level` ended the search, the true rank of a state in the last level may
    /// be larger; see `complete`.
    ///
    /// Raises:
    ///     UsageError: A variable is missing or unknown.
    fn rank<'py>(&self, py: Python<'py>, state: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let state = self.space.names.state(state)?;
        let rank = self.look(py, |planning| planning.rank(self.kind, &state))?;
        rank_of(py, rank)
    }

    /// Returns the greatest ranks over one or two integer variables. The result is an array of
    /// floats of shape (rows, columns), or (columns,) if `row` is None, from the smallest values
    /// on. A cell contains the greatest rank of its states in which the variables of `where` have
    /// their values; all other variables are free. A cell without states is NaN, an unbounded rank
    /// is infinity.
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
        let view = self.space.view(row, column, r#where)?;
        let plane = view.plane;
        let (shared, kind) = (Arc::clone(&self.shared), self.kind);
        let (shape, ranks) = self.space.worker.long(py, move || {
            let planning = lock(&shared.planning);
            let scope = planning.exploration().states().projection(view.plane, &view.fixed)?;
            let ranks = ranks(&planning, kind, &view, &scope)?;
            Ok((shape(plane, &scope), ranks))
        })?;
        arrays::floats(py, &ranks, &shape)
    }

    /// Returns the strategies of this kind.
    fn strategy(&self, py: Python<'_>) -> PyResult<Strategy> {
        Strategy::new(py, &self.shared, &self.space, self.kind)
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
fn ranks(planning: &Planning, kind: Kind, view: &View, scope: &Projection) -> Result<Vec<f64>> {
    let mut ranks: Vec<f64> = scope.cells.iter().map(|&there| if there { 0.0 } else { f64::NAN }).collect();
    let found = planning.levels(kind);
    let unbounded = matches!(planning.analysis().levels(kind).end, Some(End::Unbounded(_)));
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
