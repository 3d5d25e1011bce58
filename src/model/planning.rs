//! The names of the planning problem that a program was made from.

use ahash::{AHashMap, AHashSet};

use super::expr::ExprId;
use super::{Program, VarId, Variable};
use meliora_base::value::Type;

/// The name of the goal, as a label and as an objective.
pub const GOAL: &str = "goal";

/// The names of a planning problem: its objectives, and the atoms that formulas can name.
#[derive(Debug, Clone, Default)]
pub struct Planning {
    /// The objectives of the problem, each of which is also a label: [`GOAL`] unless there are only
    /// preferences, and its preferences by name.
    pub objectives: Vec<String>,
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
    /// Returns the fact with a name, in which spaces and capitals do not count.
    pub fn fact(&self, text: &str) -> Option<&PlannedFact> {
        let name = plain(text);
        self.facts.iter().find(|fact| plain(&fact.name) == name)
    }

    /// Returns whether the problem has a goal that must hold, and not preferences alone.
    pub fn has_goal(&self) -> bool {
        self.objectives.iter().any(|name| name == "goal")
    }

    /// Returns a name that two facts have, as objects may have commas in their names.
    pub fn doubled_fact(&self) -> Option<&str> {
        let mut known = AHashSet::new();
        self.facts.iter().find(|fact| !known.insert(plain(&fact.name))).map(|fact| fact.name.as_str())
    }

    /// Returns the atom with a name, in which spaces and capitals do not count; `None` if it is none.
    pub fn named(&self, text: &str) -> Option<Named> {
        let name = plain(text);
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

/// Returns the name of an atom or an action without spaces and capitals, which do not count.
pub fn plain(name: &str) -> String {
    name.to_lowercase().split_whitespace().collect()
}

impl Program {
    /// Returns whether two names of actions are the same: names are exact, but in planning problems spaces and capitals do
    /// not count.
    pub fn is_same_name(&self, a: &str, b: &str) -> bool {
        a == b || self.planning.is_some() && plain(a) == plain(b)
    }

    /// Formats a value of a variable as people read it: the fact of a planning problem that it stands for,
    /// `at(robot,kitchen)` or `not clean(hall)`, and else `x=1`.
    pub fn reading(&self, variable: &Variable, value: i64) -> String {
        variable.reading(&self.facts_of(variable), value)
    }

    /// Returns the names of the facts that the values of a variable stand for, from `low` to `high`, empty texts
    /// for values without a fact; no texts if there are no facts.
    pub fn facts_of(&self, variable: &Variable) -> Vec<String> {
        let mut names = Vec::new();
        for fact in self.planning.iter().flat_map(|planning| &planning.facts) {
            let at = usize::try_from(fact.value - variable.low).ok();
            let is_of = self.variables[fact.variable.index()].name == variable.name;
            let Some(at) = at.filter(|_| is_of) else { continue };
            if names.is_empty() {
                names = vec![String::new(); usize::try_from(variable.high - variable.low + 1).unwrap_or(0)];
            }
            if let Some(name) = names.get_mut(at) {
                name.clone_from(&fact.name);
            }
        }
        names
    }
}

impl Variable {
    /// Formats a value as [`Program::reading`] does, given the facts that its values stand for.
    pub fn reading(&self, facts: &[String], value: i64) -> String {
        let fact = |value: i64| {
            let at = usize::try_from(value.checked_sub(self.low)?).ok()?;
            facts.get(at).filter(|name| !name.is_empty())
        };
        match (fact(value), fact(1)) {
            (Some(name), _) => name.clone(),
            (None, Some(name)) if self.ty == Type::Bool => format!("not {name}"),
            _ => self.equation(value),
        }
    }
}
