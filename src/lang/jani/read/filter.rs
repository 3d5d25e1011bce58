//! Filters of properties: functions over the values of states.

use super::super::json::Object;
use super::nested;
use super::reader::Reader;
use crate::ast::{Expr, Ident};

/// The functions of the format.
const FUNCTIONS: &[&str] = &["min", "max", "sum", "avg", "count", "∀", "∃", "argmin", "argmax", "values"];

const FILTER: &str = "a filter";

impl<'a> Reader<'a> {
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
}
