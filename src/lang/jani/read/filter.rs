//! Filters of properties: functions over the values of states.

use super::super::json::{Node, Object, Shape};
use super::property::{Asks, Question, no};
use super::reader::Reader;
use crate::ast::Ident;
use meliora_model::stack;

/// The functions of the format.
const FUNCTIONS: &[&str] = &["min", "max", "sum", "avg", "count", "∀", "∃", "argmin", "argmax", "values"];

impl<'a> Reader<'a> {
    /// Reads a filter. What it asks for is kept even if it is refused: its target is a label.
    pub(super) fn filter(&mut self, object: &Object<'a>) -> Asks<Question> {
        let what = "a filter";
        self.known(object, what, &["op", "fun", "values", "states"])?;
        let fun = self.field::<Ident>(object, what, "fun", None);
        let states = self.required(object, what, "states");
        let values = self.required(object, what, "values")?;
        let (Ident { name, span }, states) = (fun?, states?);
        let Some(fun) = FUNCTIONS.iter().find(|fun| **fun == name) else {
            let message = format!("unknown function \"{name}\" of a filter");
            let functions = FUNCTIONS.iter().map(|fun| format!("\"{fun}\"")).collect::<Vec<_>>();
            let help = format!("the functions are {}", functions.join(", "));
            self.report(self.wrong(span, message).help(help));
            return None;
        };
        if self.operator(values)?.as_deref() == Some("filter") {
            return no("its filter has another filter inside");
        }
        let is_initial = self.is_initial(states)?;
        let asked = stack::level(|| self.asked(values))?;
        Some(asked.map(|asked| {
            let over_one = match is_initial {
                true => over_one(fun, asked.bound.is_some()),
                false => Err(format!(
                    "the filter \"{fun}\" over other states than the initial ones is not supported"
                )),
            };
            match over_one {
                Ok(over_one) => Question { over_one, ..asked },
                Err(reason) => Question { refused: asked.refused.or(Some(reason)), ..asked },
            }
        }))
    }

    fn is_initial(&mut self, states: Node<'a>) -> Option<bool> {
        match self.any(states)? {
            Shape::Object(object) if self.operator(states)?.as_deref() == Some("initial") => {
                self.known(&object, "the initial states", &["op"])?;
                Some(true)
            }
            _ => Some(false),
        }
    }

    /// Returns the operator of an object that has one.
    #[allow(clippy::option_option)]
    pub(super) fn operator(&mut self, node: Node<'a>) -> Option<Option<String>> {
        let Shape::Object(object) = self.any(node)? else { return Some(None) };
        let Some(op) = object.get("op") else { return Some(None) };
        Some(Some(self.name(op, "an operator")?.name))
    }
}

/// Returns the function if its value is the answer only where there is one initial state, `None` if it
/// is the answer for all initial states together, and the reason if it is never the answer.
fn over_one(fun: &'static str, is_verdict: bool) -> Result<Option<&'static str>, String> {
    match (fun, is_verdict) {
        ("∀", true) => Ok(None),
        ("∃" | "values", true) | ("min" | "max" | "sum" | "avg" | "values", false) => Ok(Some(fun)),
        ("∀" | "∃", false) => Err(format!("its filter \"{fun}\" is over numbers, not over comparisons")),
        ("min" | "max" | "sum" | "avg" | "argmin" | "argmax", true) => {
            Err(format!("its filter \"{fun}\" is over comparisons, not over numbers"))
        }
        _ => Err(format!("the filter \"{fun}\" is not supported")),
    }
}
