//! Filters of properties: functions over the values of states.

use super::super::json::{Node, Object, Shape};
use super::nested;
use super::property::{Asks, Question};
use super::reader::Reader;
use crate::ast::{Expr, Ident};
use crate::property::Over;
use meliora_base::stack;

/// The functions of the format.
const FUNCTIONS: &[&str] = &["min", "max", "sum", "avg", "count", "∀", "∃", "argmin", "argmax", "values"];

const FILTER: &str = "a filter";

impl<'a> Reader<'a> {
    /// Reads a filter; its part of the initial states is unknown if they do not answer it.
    pub(super) fn filter(&mut self, object: &Object<'a>) -> Asks<Question> {
        let Ident { name, .. } = self.function(object)?;
        let states = self.required(object, FILTER, "states")?;
        let values = self.required(object, FILTER, "values")?;
        let is_initial = self.is_initial(states)?;
        let asked = stack::level(|| self.asked(values))?;
        Some(asked.map(|asked| {
            let over = if is_initial { over(&name, asked.bound.is_some()) } else { None };
            Question { over: asked.over.and(over), ..asked }
        }))
    }

    /// Reads the function, the values and the states of a filter.
    pub(super) fn filtered(&mut self, object: &Object<'a>) -> Option<(Ident, Expr, Expr)> {
        let function = self.function(object);
        let values = self.field(object, FILTER, "values", None);
        let states = self.field(object, FILTER, "states", None);
        Some((nested::function(function?), values?, states?))
    }

    fn function(&mut self, object: &Object<'a>) -> Option<Ident> {
        self.known(object, FILTER, &["op", "fun", "values", "states"])?;
        let fun = self.field::<Ident>(object, FILTER, "fun", None)?;
        if !FUNCTIONS.contains(&fun.name.as_str()) {
            let message = format!("unknown function \"{}\" of a filter", fun.name);
            let functions = FUNCTIONS.iter().map(|fun| format!("\"{fun}\"")).collect::<Vec<_>>();
            let help = format!("the functions are {}", functions.join(", "));
            self.report(self.wrong(fun.span, message).help(help));
            return None;
        }
        Some(fun)
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
/// them.
fn over(fun: &str, is_verdict: bool) -> Option<Over> {
    match (fun, is_verdict) {
        ("∀", true) => Some(Over::All),
        ("min", false) => Some(Over::Least),
        ("max", false) => Some(Over::Greatest),
        _ => None,
    }
}
