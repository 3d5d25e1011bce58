//! Conversion between states and dictionaries.

use std::sync::Arc;

use meliora::model::value::{Type, Value};
use meliora::model::{Program, State, VarId, Variable};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};

use crate::errors::usage;

/// The variables of a program, with their names as Python strings.
pub(crate) struct Names {
    pub(crate) program: Arc<Program>,
    names: Vec<Py<PyString>>,
}

impl Names {
    pub(crate) fn new(py: Python<'_>, program: &Arc<Program>) -> Arc<Self> {
        let names = program.variables.iter().map(|v| PyString::new(py, &v.name).unbind()).collect();
        Arc::new(Names { program: Arc::clone(program), names })
    }

    /// Converts a state to a dictionary, with the variables in the order of declaration.
    pub(crate) fn dict<'py>(&self, py: Python<'py>, state: &[i64]) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for ((variable, name), &value) in self.program.variables.iter().zip(&self.names).zip(state) {
            dict.set_item(name, shown(py, variable, value)?)?;
        }
        Ok(dict)
    }

    /// Converts a dictionary with a value for each variable to a state; values may be out of range.
    ///
    /// # Errors
    /// `UsageError` if a variable is missing or unknown, or a value has the wrong type.
    pub(crate) fn state(&self, state: &Bound<'_, PyAny>) -> PyResult<State> {
        let dict = as_dict(state)?;
        let mut values = State::with_capacity(self.names.len());
        for (variable, name) in self.program.variables.iter().zip(&self.names) {
            let Some(value) = dict.get_item(name)? else {
                let message = format!(
                    "the state has no value for `{}`; `Model.state` gives the others their initial values",
                    variable.name
                );
                return Err(usage(message));
            };
            values.push(read(variable, &value)?);
        }
        if dict.len() > values.len() {
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

/// Converts the value of a constant.
pub(crate) fn constant<'py>(py: Python<'py>, value: Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Bool(b) => PyBool::new(py, b).to_owned().into_any(),
        Value::Int(i) => i.into_pyobject(py)?.into_any(),
        Value::Real(x) => x.into_pyobject(py)?.into_any(),
    })
}

/// Formats a dictionary of constants as `K=4,p=0.5`.
///
/// # Errors
/// `UsageError` if a value is not a bool, int or float.
pub(crate) fn constants_text(constants: Option<&Bound<'_, PyDict>>) -> PyResult<String> {
    let Some(constants) = constants else { return Ok(String::new()) };
    let mut parts = Vec::new();
    for (name, value) in constants {
        let name: String = name.extract().map_err(|_| usage("the names of constants are strings"))?;
        let text = if let Ok(b) = value.extract::<bool>() {
            b.to_string()
        } else if let Ok(i) = value.extract::<i64>() {
            i.to_string()
        } else if let Ok(x) = value.extract::<f64>() {
            format!("{x:?}")
        } else {
            return Err(usage(format!("constants are bools, ints and floats: `{name}` is {value}")));
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
