//! Preferences.

use std::path::PathBuf;
use std::sync::Arc;

use meliora::SourceFile;
use meliora::lang;
use meliora::model::Program;
use meliora::model::hasse::Hasse;
use meliora::model::preference::{Comparison, Empty, History, Outline};
use meliora::output::page;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyTuple};

use crate::errors::{Failure, usage};
use crate::model::Model;
use crate::{display, files};

/// Objectives with a partial order on them: a preference file, read without a model.
///
/// `Model.check` checks that the formulas fit the model. Preferences are immutable values: they can
/// be compared, pickled, and used by several threads.
///
/// Args:
///     objectives: The formula of each objective by its name, such as "F (x = 3)" or 'F "goal"'.
///     prefer: Statements such as "D, E > A >= B", or pairs (better, worse).
///     empty: The value of nothing, for states without an almost-sure objective: "bottom", "gain"
///         or "incomparable".
///     history: "state", "play", or None for the default of the formulas.
///     require: safe formulas that no path may violate, such as `G !"pond"`.
///
/// Raises:
///     InputError: The preferences are invalid; each problem has its place in the generated text,
///         see `text`.
#[pyclass(frozen, module = "meliora")]
pub(crate) struct Preferences {
    pub(crate) source: Arc<SourceFile>,
    pub(crate) outline: Outline,
    /// The objectives of a planning problem, with their formulas.
    implied: Vec<(String, String)>,
}

impl Preferences {
    fn read(py: Python<'_>, source: Arc<SourceFile>) -> PyResult<Self> {
        Preferences::read_for(py, source, Vec::new())
    }

    /// Reads preferences for a planning problem with these objectives.
    fn read_for(py: Python<'_>, source: Arc<SourceFile>, implied: Vec<(String, String)>) -> PyResult<Self> {
        let outline = lang::outline_preferences_for(&source, &implied);
        let outline = outline.map_err(|error| Failure::of(error).raise(py))?;
        Ok(Preferences { source, outline, implied })
    }

    fn position(&self, name: &str) -> PyResult<usize> {
        let found = self.outline.objectives.iter().position(|(own, _)| own == name);
        found.ok_or_else(|| usage(format!("there is no objective `{name}`")))
    }
}

/// Returns the objectives that a planning problem declares.
fn implied(model: Option<&Bound<'_, Model>>) -> Vec<(String, String)> {
    model.map(|model| lang::implied_objectives(model.get().inner.program())).unwrap_or_default()
}

/// Returns the preferences of an argument, which may name the objectives of a planning problem.
///
/// # Errors
/// The errors of reading a file.
pub(crate) fn given(
    py: Python<'_>,
    argument: &Bound<'_, PyAny>,
    program: &Program,
) -> PyResult<Py<Preferences>> {
    let implied = lang::implied_objectives(program);
    if let Ok(preferences) = argument.cast::<Preferences>() {
        let known = preferences.get();
        if implied.is_empty() || !known.implied.is_empty() {
            return Ok(preferences.clone().unbind());
        }
        return Py::new(py, Preferences::read_for(py, Arc::clone(&known.source), implied)?);
    }
    let path: PathBuf = argument
        .extract()
        .map_err(|_| usage(format!("preferences are a Preferences or the path of a file, not {argument}")))?;
    let text = path.to_string_lossy();
    if text.contains(';') && !path.exists() {
        return Err(usage("this is a text of preferences; Preferences.from_string reads one"));
    }
    Py::new(py, Preferences::read_for(py, files::open(py, &path)?, implied)?)
}

/// Returns the items of a list; a text alone is none.
fn listed<'py, T: for<'a> FromPyObject<'a, 'py>>(
    name: &str,
    argument: Option<&Bound<'py, PyAny>>,
) -> PyResult<Vec<T>> {
    match argument {
        None => Ok(Vec::new()),
        Some(text) if text.is_instance_of::<PyString>() => {
            Err(usage(format!("{name} is a list: write [\"{text}\"]")))
        }
        Some(list) => list.extract(),
    }
}

#[pymethods]
impl Preferences {
    #[new]
    #[pyo3(signature = (objectives, prefer=None, *, empty="bottom", history=None, require=None))]
    fn new(
        py: Python<'_>,
        objectives: &Bound<'_, PyDict>,
        prefer: Option<&Bound<'_, PyAny>>,
        empty: &str,
        history: Option<&str>,
        require: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let prefer: Vec<Bound<'_, PyAny>> = listed("prefer", prefer)?;
        let require: Vec<String> = listed("require", require)?;
        let mut text = String::new();
        for (name, formula) in objectives {
            text.push_str(&format!("objective {name} = {formula};\n"));
        }
        for statement in prefer {
            if statement.is_instance_of::<PyString>() {
                text.push_str(&format!("prefer {statement};\n"));
            } else {
                let (better, worse): (String, String) = statement
                    .extract()
                    .map_err(|_| usage(format!("a text or a pair (better, worse), not {statement}")))?;
                text.push_str(&format!("prefer {better} > {worse};\n"));
            }
        }
        text.push_str(&format!("empty = {empty};\n"));
        if let Some(history) = history {
            text.push_str(&format!("history = {history};\n"));
        }
        for formula in require {
            text.push_str(&format!("require {formula};\n"));
        }
        Preferences::read(py, SourceFile::new("preferences", text))
    }

    /// Reads a preference file. With the `model` of a planning problem, the file may name the objectives that
    /// the problem declares; `Model.check` knows them anyway.
    ///
    /// Raises:
    ///     InputError: The text is invalid; each problem has its place.
    ///     OSError: The file cannot be read.
    #[staticmethod]
    #[pyo3(signature = (path, *, model=None))]
    fn from_file(py: Python<'_>, path: PathBuf, model: Option<&Bound<'_, Model>>) -> PyResult<Self> {
        Preferences::read_for(py, files::open(py, &path)?, implied(model))
    }

    /// Reads the text of a preference file. Messages call the preferences `name`. `model` is as in `from_file`.
    #[staticmethod]
    #[pyo3(signature = (text, *, name="preferences", model=None))]
    fn from_string(
        py: Python<'_>,
        text: String,
        name: &str,
        model: Option<&Bound<'_, Model>>,
    ) -> PyResult<Self> {
        Preferences::read_for(py, SourceFile::new(name, text), implied(model))
    }

    #[staticmethod]
    #[pyo3(signature = (name, text, implied=Vec::new()))]
    fn _restore(py: Python<'_>, name: &str, text: String, implied: Vec<(String, String)>) -> PyResult<Self> {
        Preferences::read_for(py, SourceFile::new(name, text), implied)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let restore = py.get_type::<Preferences>().getattr("_restore")?;
        (restore, (&self.source.name, self.source.original(), self.implied.clone())).into_pyobject(py)
    }

    /// The name in messages: the path of the file.
    #[getter]
    fn name(&self) -> &str {
        &self.source.name
    }

    /// The text.
    #[getter]
    fn text(&self) -> &str {
        self.source.original()
    }

    /// The formula of each objective by its name, in the order of declaration.
    #[getter]
    fn objectives<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for (name, formula) in &self.outline.objectives {
            all.set_item(name, formula)?;
        }
        Ok(all)
    }

    /// The value of nothing, for states without an almost-sure objective: `"bottom"`, `"gain"` or
    /// `"incomparable"`.
    #[getter]
    fn empty(&self) -> &'static str {
        Empty::name(self.outline.empty)
    }

    /// The warnings about the preferences, as text.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        let name = &self.source.name;
        self.outline.warnings().into_iter().map(|warning| format!("{name} {warning}")).collect()
    }

    /// The formulas of the requirements, which no path may violate.
    #[getter]
    fn requirements<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, &self.outline.requirements)
    }

    /// The part of a path that counts: `"state"` (from the present state on) or `"play"` (the whole
    /// path).
    #[getter]
    fn history(&self) -> &'static str {
        History::name(self.outline.history)
    }

    /// Compares two objectives: `">"` if the first is strictly preferred, `"<"`, `"~"`, or None if
    /// they are incomparable.
    fn compare(&self, first: &str, second: &str) -> PyResult<Option<&'static str>> {
        let (x, y) = (self.position(first)?, self.position(second)?);
        Ok(match self.outline.order.compare(x, y) {
            Comparison::Preferred => Some(">"),
            Comparison::Dispreferred => Some("<"),
            Comparison::Indifferent => Some("~"),
            Comparison::Incomparable => None,
        })
    }

    /// The order as pairs (better, worse), without those that follow from others: the lines of the Hasse
    /// diagram. Objectives that are equally good are in the same pairs.
    #[getter]
    fn edges(&self) -> Vec<(&str, &str)> {
        let Hasse { groups, covers } = Hasse::new(&self.outline.order);
        let names = |group: usize| groups[group].iter().map(|&at| self.outline.objectives[at].0.as_str());
        covers.iter().flat_map(|&(x, y)| names(x).flat_map(move |x| names(y).map(move |y| (x, y)))).collect()
    }

    /// Draws the order as a Hasse diagram, the most preferred objectives on top.
    ///
    /// Returns:
    ///     The text of an SVG file.
    fn to_svg(&self) -> String {
        page::order_svg(&self.outline)
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Preferences>().is_ok_and(|other| self.source.text == other.get().source.text)
    }

    fn __hash__(&self) -> u64 {
        use std::hash::{DefaultHasher, Hash, Hasher};
        let mut hasher = DefaultHasher::new();
        self.source.text.hash(&mut hasher);
        hasher.finish()
    }

    fn __repr__(&self) -> String {
        let names: Vec<&str> = self.outline.objectives.iter().map(|(name, _)| name.as_str()).collect();
        format!("<Preferences {:?}: {}>", self.source.name, names.join(", "))
    }

    fn _repr_svg_(&self) -> String {
        self.to_svg()
    }

    fn _repr_html_(slf: &Bound<'_, Self>) -> PyResult<String> {
        display::html(slf.as_any(), "preferences")
    }
}
