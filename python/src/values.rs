//! Conversion between states and dictionaries.

use std::sync::Arc;

use meliora::Rank;
use meliora::model::value::{Type, Value};
use meliora::model::{Program, State, VarId, Variable};
use meliora::planning::result::ModelCounts;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyString};

use crate::errors::usage;

/// The variables of a program, with their names as Python strings.
pub(crate) struct Names {
    pub(crate) program: Arc<Program>,
    /// The action labels of the model, without those of monitors.
    pub(crate) actions: Vec<String>,
    names: Vec<Py<PyString>>,
}

impl Names {
    /// Returns the names of a model.
    pub(crate) fn new(py: Python<'_>, program: &Arc<Program>) -> Arc<Self> {
        Self::with_actions(py, program, &program.actions)
    }

    /// Returns the names of the product of this model with monitors, or of the model itself.
    pub(crate) fn of_product(self: &Arc<Self>, py: Python<'_>, product: &Arc<Program>) -> Arc<Self> {
        match product.monitors {
            Some(_) => Self::with_actions(py, product, &self.actions),
            None => Arc::clone(self),
        }
    }

    fn with_actions(py: Python<'_>, program: &Arc<Program>, actions: &[String]) -> Arc<Self> {
        let names = program.variables.iter().map(|v| PyString::new(py, &v.name).unbind()).collect();
        Arc::new(Names { program: Arc::clone(program), actions: actions.to_vec(), names })
    }

    /// Returns the value with which the variable of a monitor starts; `None` for the others.
    fn monitor_start(&self, variable: usize) -> Option<i64> {
        let monitors = self.program.monitors.as_ref()?;
        monitors.variables.iter().find(|v| v.index() == variable)?;
        self.program.variables[variable].initial
    }

    /// Converts a state to a dictionary, with the variables in the order of declaration.
    pub(crate) fn dict<'py>(&self, py: Python<'py>, state: &[i64]) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for ((variable, name), &value) in self.program.variables.iter().zip(&self.names).zip(state) {
            dict.set_item(name, shown(py, variable, value)?)?;
        }
        Ok(dict)
    }

    /// Converts a dictionary with a value for each variable of the model to a state; values may be
    /// out of range. Monitors without a value have their start values.
    ///
    /// # Errors
    /// `UsageError` if a variable is missing or unknown, or a value has the wrong type.
    pub(crate) fn state(&self, state: &Bound<'_, PyAny>) -> PyResult<State> {
        let dict = as_dict(state)?;
        let (mut values, mut given) = (State::with_capacity(self.names.len()), 0);
        for (index, (variable, name)) in self.program.variables.iter().zip(&self.names).enumerate() {
            let Some(value) = dict.get_item(name)? else {
                if let Some(start) = self.monitor_start(index) {
                    values.push(start);
                    continue;
                }
                let message = format!(
                    "the state has no value for `{}`; `Model.state` gives the others their initial values",
                    variable.name
                );
                return Err(usage(message));
            };
            values.push(read(variable, &value)?);
            given += 1;
        }
        if dict.len() > given {
            self.fixed(&dict)?;
        }
        Ok(values)
    }

    /// Returns the variables of a dictionary with their values; values may be out of range.
    ///
    /// # Errors
    /// `UsageError` if a variable is unknown, or a value has the wrong type.
    pub(crate) fn fixed(&self, values: &Bound<'_, PyDict>) -> PyResult<Vec<(VarId, i64)>> {
        let mut fixed = Vec::with_capacity(values.len());
        for (name, value) in values {
            let name: String = name.extract().map_err(|_| usage("the names of variables are strings"))?;
            let id = self.variable(&name)?;
            fixed.push((id, read(&self.program.variables[id.index()], &value)?));
        }
        Ok(fixed)
    }

    /// Returns the variable with a name.
    ///
    /// # Errors
    /// `UsageError` if the name is unknown.
    pub(crate) fn variable(&self, name: &str) -> PyResult<VarId> {
        self.program.variable(name).ok_or_else(|| {
            let known: Vec<&str> = self.program.variables.iter().map(|v| v.name.as_str()).collect();
            usage(format!("there is no variable `{name}`; the variables are {}", known.join(", ")))
        })
    }
}

/// Converts a mapping to a dictionary.
pub(crate) fn as_dict<'py>(mapping: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
    match mapping.cast::<PyDict>() {
        Ok(dict) => Ok(dict.clone()),
        Err(_) => {
            let dict = PyDict::new(mapping.py());
            let values = mapping
                .call_method0("items")
                .map_err(|_| usage(format!("a state is a dictionary of values by name, not {mapping}")))?;
            for pair in values.try_iter()? {
                let (name, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = pair?.extract()?;
                dict.set_item(name, value)?;
            }
            Ok(dict)
        }
    }
}

/// Converts a value of a variable: to a bool, an int, or its name if values have names.
pub(crate) fn shown<'py>(py: Python<'py>, variable: &Variable, value: i64) -> PyResult<Bound<'py, PyAny>> {
    if let Some(name) = variable.value_name(value) {
        return Ok(PyString::new(py, name).into_any());
    }
    Ok(match variable.ty {
        Type::Bool => PyBool::new(py, value != 0).to_owned().into_any(),
        _ => value.into_pyobject(py)?.into_any(),
    })
}

fn read(variable: &Variable, value: &Bound<'_, PyAny>) -> PyResult<i64> {
    let wrong = || {
        let expected = match variable.ty {
            Type::Bool => "a bool",
            _ if !variable.values.is_empty() => "the name of a value",
            _ => "an int",
        };
        usage(format!("`{}` takes {expected}, not {value}", variable.name))
    };
    if variable.ty == Type::Bool {
        return value.extract::<bool>().map(i64::from).map_err(|_| wrong());
    }
    if let Ok(name) = value.cast::<PyString>() {
        let index = variable.values.iter().position(|v| name == v.as_str());
        let index = index.and_then(|i| i64::try_from(i).ok());
        return index.map(|i| variable.low + i).ok_or_else(wrong);
    }
    if value.is_instance_of::<PyBool>() {
        return Err(wrong());
    }
    value.extract::<i64>().map_err(|_| wrong())
}

/// Converts a JSON text to Python dictionaries and lists, in which infinite bounds are floats.
pub(crate) fn plain(py: Python<'_>, json: serde_json::Result<String>) -> PyResult<Py<PyAny>> {
    let text = json.map_err(|e| PyRuntimeError::new_err(e.to_string()))?;
    Ok(py.import("meliora._json")?.call_method1("loads", (text,))?.unbind())
}

/// Converts the value of a constant.
pub(crate) fn constant<'py>(py: Python<'py>, value: Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Bool(b) => PyBool::new(py, b).to_owned().into_any(),
        Value::Int(i) => i.into_pyobject(py)?.into_any(),
        Value::Real(x) => x.into_pyobject(py)?.into_any(),
    })
}

/// Formats a dictionary of constants as `K=4,p=0.5`; a `Fraction` stays exact, as in `p=1/3`.
///
/// # Errors
/// `UsageError` if a value is not a bool, int, float or `Fraction`.
pub(crate) fn constants_text(constants: Option<&Bound<'_, PyDict>>) -> PyResult<String> {
    let Some(constants) = constants else { return Ok(String::new()) };
    let fraction = constants.py().import("fractions")?.getattr("Fraction")?;
    let mut parts = Vec::new();
    for (name, value) in constants {
        let name: String = name.extract().map_err(|_| usage("the names of constants are strings"))?;
        let text = if let Ok(b) = value.extract::<bool>() {
            b.to_string()
        } else if let Ok(i) = value.extract::<i64>() {
            i.to_string()
        } else if value.is_instance(&fraction)? {
            value.str()?.to_string()
        } else if let Ok(x) = value.extract::<f64>() {
            format!("{x:?}")
        } else {
            return Err(usage(format!(
                "constants are bools, ints, floats and fractions: `{name}` is {value}"
            )));
        };
        parts.push(format!("{name}={text}"));
    }
    Ok(parts.join(","))
}

/// Formats a dictionary of bounds as `x=0..7,y=-1..1`.
///
/// # Errors
/// `UsageError` if a value is not a pair of ints.
pub(crate) fn bounds_text(bounds: Option<&Bound<'_, PyDict>>) -> PyResult<String> {
    let Some(bounds) = bounds else { return Ok(String::new()) };
    let mut parts = Vec::new();
    for (name, pair) in bounds {
        let wrong = |_| usage(format!("bounds are pairs of ints: `{name}` has {pair}"));
        let (low, high): (i64, i64) = pair.extract().map_err(wrong)?;
        parts.push(format!("{name}={low}..{high}"));
    }
    Ok(parts.join(","))
}

/// Converts a rank to an int, or infinity.
pub(crate) fn rank_of<'py>(py: Python<'py>, rank: Rank) -> PyResult<Bound<'py, PyAny>> {
    Ok(match rank {
        Rank::Finite(k) | Rank::AtLeast(k) => k.into_pyobject(py)?.into_any(),
        Rank::Unbounded => PyFloat::new(py, f64::INFINITY).into_any(),
    })
}

/// Converts the rank of a state to an int, or infinity; NaN for an unsafe state, which has none.
pub(crate) fn rank_of_safe<'py>(py: Python<'py>, is_unsafe: bool, rank: Rank) -> PyResult<Bound<'py, PyAny>> {
    if is_unsafe { Ok(PyFloat::new(py, f64::NAN).into_any()) } else { rank_of(py, rank) }
}

/// Converts the sizes of a model to a dictionary.
pub(crate) fn counts_dict<'py>(py: Python<'py>, counts: &ModelCounts) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("states", &counts.states)?;
    if let Some(states) = &counts.model_states {
        dict.set_item("model_states", states)?;
    }
    dict.set_item("choices", &counts.choices)?;
    dict.set_item("transitions", &counts.transitions)?;
    dict.set_item("deadlocks", &counts.deadlocks)?;
    dict.set_item("initial", &counts.initial)?;
    if let Some(states) = &counts.unsafe_states {
        dict.set_item("unsafe", states)?;
    }
    Ok(dict)
}
