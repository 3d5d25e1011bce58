//! The variables of a model.

use meliora::model::value::Type;
use pyo3::prelude::*;

use crate::values;

/// A variable of a model.
#[pyclass(frozen, get_all, module = "meliora")]
pub(crate) struct Variable {
    /// Its name.
    name: String,
    /// `"int"` or `"bool"`.
    r#type: &'static str,
    /// The smallest value.
    low: i64,
    /// The largest value.
    high: i64,
    /// The value in the initial state; None if the initial states differ in it.
    initial: Option<Py<PyAny>>,
    /// The names of its values from `low` on, if they have names.
    values: Vec<String>,
}

impl Variable {
    pub(crate) fn new(py: Python<'_>, v: &meliora::model::Variable) -> PyResult<Self> {
        let initial = v.initial.map(|i| values::shown(py, v, i).map(Bound::unbind)).transpose()?;
        Ok(Variable {
            name: v.name.clone(),
            r#type: if v.ty == Type::Bool { "bool" } else { "int" },
            low: v.low,
            high: v.high,
            initial,
            values: v.values.clone(),
        })
    }
}

#[pymethods]
impl Variable {
    fn __repr__(&self) -> String {
        match self.r#type {
            "bool" => format!("Variable({:?}, bool)", self.name),
            _ => format!("Variable({:?}, {}..{})", self.name, self.low, self.high),
        }
    }
}
