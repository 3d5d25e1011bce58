//! Filters of properties: functions over the values of states.

use super::super::json::{Node, Object, Shape};
use super::property::{Asks, Question, no};
use super::reader::Reader;
use crate::ast::Ident;
use crate::property::Over;
use meliora_base::stack;

/// The functions of the format.
const FUNCTIONS: &[&str] = &["min", "max", "sum", "avg", "count", "∀", "∃", "argmin", "argmax", "values"];

impl<'a> Reader<'a> {
    /// Reads a filter. A refused filter keeps its question, whose target is a label.
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
            let over = match is_initial {
                true => over(fun, asked.bound.is_some()),
                false => Err(format!(
                    "the filter \"{fun}\" over other states than the initial ones is not supported"
                )),
            };
            match over {
                Ok(over) => Question { over, ..asked },
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

/// Returns the part of the initial states whose answer is the value of a function of the values in all of
/// them, or the reason why there is none.
fn over(fun: &'static str, is_verdict: bool) -> Result<Over, String> {
    match (fun, is_verdict) {
        ("∀", true) => Ok(Over::All),
        ("min", false) => Ok(Over::Least),
        ("max", false) => Ok(Over::Greatest),
        ("∃" | "values", true) | ("sum" | "avg" | "values", false) => Ok(Over::Only(fun)),
        ("∀" | "∃", false) => Err(format!("its filter \"{fun}\" is over numbers, not over comparisons")),
        ("min" | "max" | "sum" | "avg" | "argmin" | "argmax", true) => {
            Err(format!("its filter \"{fun}\" is over comparisons, not over numbers"))
        }
        _ => Err(format!("the filter \"{fun}\" is not supported")),
    }
}
