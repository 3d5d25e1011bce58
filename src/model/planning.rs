//! The names of the planning problem that a program was made from.

use ahash::AHashMap;

use super::VarId;
use super::expr::ExprId;

/// The names of a planning problem: its objectives, and the atoms that formulas can name.
#[derive(Debug, Clone, Default)]
pub struct Planning {
    /// The objectives of the problem: `goal`, and its preferences by name.
    pub objectives: Vec<(String, ExprId)>,
    /// The facts that change, each with its variable and the value that stands for it.
    pub facts: Vec<PlannedFact>,
    /// The atoms that hold in some state, by their names in small letters, such as `at(robot,kitchen)`.
    pub atoms: AHashMap<String, ExprId>,
    /// The predicates by their names in small letters, each with the objects of its parameters.
    pub predicates: AHashMap<String, Vec<Vec<String>>>,
    /// True if outcomes have equal probabilities because the problem states none.
    pub assumes_uniform: bool,
}

/// A fact of a planning problem.
#[derive(Debug, Clone)]
pub struct PlannedFact {
    /// Its name, such as `at(robot,kitchen)`.
    pub name: String,
    /// The variable that has a value for it.
    pub variable: VarId,
    /// The value.
    pub value: i64,
}

/// The meaning of a text as an atom.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Named {
    /// An atom that holds in some state.
    Atom(ExprId),
    /// An atom that holds in no state.
    Never,
}

impl Planning {
    /// Returns the atom with a name, in which spaces and capitals do not count; `None` if it is none.
    pub fn named(&self, text: &str) -> Option<Named> {
        let name: String = text.to_lowercase().split_whitespace().collect();
        if let Some(&id) = self.atoms.get(&name) {
            return Some(Named::Atom(id));
        }
        let (predicate, arguments) = match name.strip_suffix(')') {
            Some(called) => called.split_once('(')?,
            None => (name.as_str(), ""),
        };
        let parameters = self.predicates.get(predicate)?;
        let arguments: Vec<&str> =
            if arguments.is_empty() { Vec::new() } else { arguments.split(',').collect() };
        let fits =
            |(given, known): (&&str, &Vec<String>)| known.iter().any(|name| name.eq_ignore_ascii_case(given));
        let is_atom = arguments.len() == parameters.len() && arguments.iter().zip(parameters).all(fits);
        is_atom.then_some(Named::Never)
    }
}
