//! The variables and constants of a manifest, as a program without commands.

use std::sync::Arc;

use serde_json::Value as Json;

use meliora_base::decimal;
use meliora_base::error::{Error, Result, SourceFile};
use meliora_base::exact::{Exact, Real};
use meliora_base::value::{Type, Value};
use meliora_dump::Manifest;
use meliora_model::expr::{Binary, ExprPool};
use meliora_model::planning::{PlannedFact, Planning};
use meliora_model::{ModelKind, Program, VarId, Variable};

/// Rebuilds the program; messages call the manifest `name`.
///
/// # Errors
/// A constant has an invalid value.
pub(super) fn rebuild(name: &str, manifest: &Manifest) -> Result<Program> {
    let mut pool = ExprPool::default();
    let initial = pool.value(Value::Bool(true));
    let mut constants = Vec::new();
    for (constant, json) in &manifest.constants {
        let Some(value) = value(json) else {
            let message = format!("the constant `{constant}` has the invalid value {json}");
            return Err(Error::Dump { file: name.to_owned(), line: 0, message });
        };
        constants.push((constant.clone(), value));
    }
    for (constant, text) in &manifest.exact {
        let (known, value) = (constants.iter_mut().find(|(name, _)| name == constant), decimal::read(text));
        let (Some(known), Some(value)) = (known, value) else {
            let message = format!("the constant `{constant}` has an invalid exact value");
            return Err(Error::Dump { file: name.to_owned(), line: 0, message });
        };
        known.1 = Exact::Real(Real::Finite(value));
    }
    let variable = |v: &meliora_dump::manifest::Variable| Variable {
        name: v.name.clone(),
        ty: if v.is_bool() { Type::Bool } else { Type::Int },
        low: v.low,
        high: v.high,
        module: None,
        initial: v.initial.filter(|i| (v.low..=v.high).contains(i)),
        values: v.values.clone(),
        span: 0..0,
    };
    let planning = planning(manifest, &mut pool).map(Arc::new);
    let variables = manifest.encoding.variables.iter().map(variable).collect();
    let empty = Program::empty(SourceFile::new(name, ""), ModelKind::Mdp, pool.into(), initial);
    Ok(Program { constants, variables, planning, ..empty })
}

/// Returns the facts of a planning problem; `None` for dumps of other models.
fn planning(manifest: &Manifest, pool: &mut ExprPool) -> Option<Planning> {
    let mut planning = Planning::default();
    for (id, of) in (0..).map(VarId).zip(&manifest.encoding.variables) {
        for (value, name) in (of.low..).zip(&of.facts).filter(|(_, name)| !name.is_empty()) {
            let holds = match of.is_bool() {
                true => pool.var(id, Type::Bool),
                false => {
                    let (variable, value) = (pool.var(id, Type::Int), pool.value(Value::Int(value)));
                    pool.binary(Binary::Eq, variable, value)
                }
            };
            planning.atoms.insert(name.to_lowercase(), holds);
            planning.facts.push(PlannedFact { name: name.clone(), variable: id, value });
        }
    }
    (!planning.facts.is_empty()).then_some(planning)
}

fn real(x: f64) -> Exact {
    Exact::Real(Real::shortest(x))
}

/// Reads a constant as `export` writes it.
fn value(json: &Json) -> Option<Exact> {
    match json {
        Json::Bool(b) => Some(Exact::Bool(*b)),
        Json::Number(n) => n.as_i64().map(Exact::Int).or_else(|| n.as_f64().map(real)),
        Json::String(text) => text.parse().ok().map(real),
        _ => None,
    }
}
