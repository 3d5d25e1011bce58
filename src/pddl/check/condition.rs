//! Conditions, in negation normal form.

use super::Checker;
use super::requirements::Requirement;
use super::types::with_known;
use crate::syntax::Node;
use crate::task::{Atom, Condition, Domain, Term};
use meliora_base::error::Severity;
use meliora_base::stack;

impl Checker {
    /// Reads a condition, or its negation. Returns `None` after reporting an error.
    pub(super) fn condition(&mut self, node: &Node, is_positive: bool) -> Option<Condition> {
        stack::level(|| self.condition_here(node, is_positive))
    }

    fn condition_here(&mut self, node: &Node, is_positive: bool) -> Option<Condition> {
        let Some((name, parts)) = node.form() else {
            // `()` is the empty conjunction.
            if node.list().is_some_and(<[Node]>::is_empty) {
                return Some(join(true, is_positive, Vec::new()));
            }
            if self.is_bare_atom(node) {
                return self.literal(node, is_positive);
            }
            return self.report(node.expected("a condition in brackets"));
        };
        match name {
            "and" | "or" => {
                if name == "or" {
                    self.used.add(Requirement::Disjunctive);
                }
                self.all_conditions(parts, is_positive).map(|all| join(name == "and", is_positive, all))
            }
            "not" => {
                let [inner] = self.exactly(node, parts, "not")?;
                self.condition(inner, !is_positive)
            }
            "imply" | "implies" => {
                self.used.add(Requirement::Disjunctive);
                let [premise, conclusion] = self.exactly(node, parts, name)?;
                let premise = self.condition(premise, !is_positive);
                let conclusion = self.condition(conclusion, is_positive);
                Some(join(false, is_positive, vec![premise?, conclusion?]))
            }
            "forall" | "exists" => self.quantified(node, parts, is_positive),
            "=" => self.equation(node, parts, is_positive),
            _ => self.literal(node, is_positive),
        }
    }

    fn all_conditions(&mut self, parts: &[Node], is_positive: bool) -> Option<Vec<Condition>> {
        let all: Vec<_> = parts.iter().map(|part| self.condition(part, is_positive)).collect();
        all.into_iter().collect()
    }

    fn quantified(&mut self, node: &Node, parts: &[Node], is_positive: bool) -> Option<Condition> {
        let is_all = node.form()?.0 == "forall";
        self.used.add(if is_all { Requirement::Universal } else { Requirement::Existential });
        let (domains, inner) =
            self.scoped(node, parts, |checker, inner| checker.condition(inner, is_positive))?;
        let make = if is_all == is_positive { Condition::All } else { Condition::Some };
        Some(make(domains, Box::new(inner?)))
    }

    /// Reads the variables and the inner part of a quantifier.
    pub(super) fn scoped<T>(
        &mut self,
        node: &Node,
        parts: &[Node],
        inner: impl FnOnce(&mut Self, &Node) -> T,
    ) -> Option<(Vec<std::sync::Arc<Domain>>, T)> {
        let [variables, body] = self.exactly(node, parts, node.form()?.0)?;
        let Some(list) = variables.list() else {
            return self.report(variables.expected("variables in brackets"));
        };
        let outside = self.scope.len();
        let variables = self.variables(list);
        let domains = variables.iter().map(|(_, domain)| domain.clone()).collect();
        self.scope.extend(variables);
        let result = inner(self, body);
        self.scope.truncate(outside);
        Some((domains, result))
    }

    fn equation(&mut self, node: &Node, parts: &[Node], is_positive: bool) -> Option<Condition> {
        self.used.add(Requirement::Equality);
        if let Some(list) = parts.iter().find(|part| part.list().is_some()) {
            let wrong = list.wrong("numbers in conditions are not supported");
            return self.report(wrong.label("expected an object or a variable"));
        }
        let [left, right] = self.exactly(node, parts, "=")?;
        let (left, right) = (self.term(left), self.term(right));
        Some(Condition::Equal(left?, right?, is_positive))
    }

    fn literal(&mut self, node: &Node, is_positive: bool) -> Option<Condition> {
        if !is_positive {
            self.used.add(Requirement::Negative);
        }
        self.atom(node).map(|atom| Condition::Literal(atom, is_positive))
    }

    /// Returns whether a node is the name of a predicate without brackets, as some collections write atoms without
    /// arguments.
    pub(super) fn is_bare_atom(&self, node: &Node) -> bool {
        node.word().is_some_and(|name| self.predicate_of.contains_key(name))
    }

    /// Reads an atom, and checks its predicate and arguments.
    pub(super) fn atom(&mut self, node: &Node) -> Option<Atom> {
        let bare = node.word().filter(|_| self.is_bare_atom(node)).map(|name| (name, &[][..]));
        let Some((name, parts)) = bare.or_else(|| node.form()) else {
            return self.report(node.expected("a fact such as `(at robot kitchen)`"));
        };
        let Some(&predicate) = self.predicate_of.get(name) else {
            return self.unknown(node, name);
        };
        let expected = self.predicates[predicate].parameters.len();
        if parts.len() != expected {
            let message = format!("`{name}` has {expected} arguments, here are {}", parts.len());
            return self.report(node.wrong(message).label("wrong number of arguments"));
        }
        let mut arguments = Vec::with_capacity(parts.len());
        for (at, part) in parts.iter().enumerate() {
            let term = self.term(part)?;
            self.note_type(part, term, predicate, at);
            arguments.push(term);
        }
        Some(Atom { predicate, arguments })
    }

    /// Notes an argument that never has the type of its parameter: the atom never holds then.
    fn note_type(&mut self, part: &Node, term: Term, predicate: usize, at: usize) {
        let wanted = &self.predicates[predicate].parameters[at];
        let fits = match term {
            Term::Object(object) => wanted.member[object as usize],
            Term::Variable(variable) => {
                let objects = &self.scope[variable].1.objects;
                objects.is_empty() || objects.iter().any(|&object| wanted.member[object as usize])
            }
        };
        if fits || self.is_noted {
            return;
        }
        self.is_noted = true;
        let name = &self.predicates[predicate].name;
        let message = format!("argument {} of `{name}` has another type than `{}`", at + 1, part.text());
        let note = part.wrong(message).severity(Severity::Warning);
        let note = note.label("no object of this type is declared for this argument");
        self.faults
            .notes
            .push(note.help("types of arguments are not enforced; further places are not listed"));
    }

    pub(super) fn term(&mut self, node: &Node) -> Option<Term> {
        let Some(name) = node.word() else {
            return self.report(node.expected("an object or a variable"));
        };
        if name.starts_with('?') {
            let Some(at) = self.scope.iter().rposition(|(known, _)| known == name) else {
                let known = self.scope.iter().map(|(name, _)| name.as_str()).collect();
                return self.report(with_known(
                    node.wrong(format!("unknown variable `{name}`")),
                    "variables here",
                    known,
                ));
            };
            return Some(Term::Variable(at));
        }
        match self.object_of.get(name) {
            Some(&object) => Some(Term::Object(object)),
            None => {
                let wrong = node.wrong(format!("unknown object `{name}`")).label("not declared");
                self.report(wrong.help("declare it in `:objects` of the problem, or in `:constants`"))
            }
        }
    }

    fn unknown<T>(&mut self, node: &Node, name: &str) -> Option<T> {
        const TEMPORAL: [&str; 10] = [
            "always",
            "sometime",
            "within",
            "at-most-once",
            "sometime-after",
            "sometime-before",
            "always-within",
            "hold-during",
            "hold-after",
            "at",
        ];
        let named = |known: &[&str]| known.contains(&name);
        if named(&["<", ">", "<=", ">="]) {
            return self.report(node.wrong("numbers in conditions are not supported"));
        }
        if name == "preference" {
            let wrong = node.wrong("a preference can stand only in the goal, alone or in its outer `and`");
            return self.report(wrong.help("write `(:goal (and (preference NAME condition) …))`"));
        }
        if named(&TEMPORAL[..9]) {
            let wrong = node.wrong(format!("conditions on whole paths, such as `{name}`, are not supported"));
            return self
                .report(wrong.help("write the formula as an objective of a preference file: `F`, `G`, `U`"));
        }
        if named(&[
            "when",
            "oneof",
            "probabilistic",
            "increase",
            "decrease",
            "assign",
            "scale-up",
            "scale-down",
        ]) {
            return self.report(node.wrong(format!("`{name}` cannot stand here")));
        }
        let known: Vec<String> = self.predicates.iter().map(|p| p.name.clone()).collect();
        let wrong = node.wrong(format!("unknown predicate `{name}`")).label("not declared in `:predicates`");
        self.report(with_known(wrong, "predicates", known.iter().map(String::as_str).collect()))
    }

    /// Returns the parts of a form, if it has the right number.
    pub(super) fn exactly<'n, const N: usize>(
        &mut self,
        node: &Node,
        parts: &'n [Node],
        name: &str,
    ) -> Option<[&'n Node; N]> {
        match <[&Node; N]>::try_from(parts.iter().collect::<Vec<_>>()) {
            Ok(parts) => Some(parts),
            Err(_) => self.report(node.wrong(format!("`{name}` has {N} parts, here are {}", parts.len()))),
        }
    }
}

/// Returns a conjunction or a disjunction, or the negation of it over conditions negated already.
fn join(is_and: bool, is_positive: bool, all: Vec<Condition>) -> Condition {
    let conjunction = is_and == is_positive;
    let mut flat = Vec::with_capacity(all.len());
    for condition in all {
        match condition {
            Condition::And(inner) if conjunction => flat.extend(inner),
            Condition::Or(inner) if !conjunction => flat.extend(inner),
            other => flat.push(other),
        }
    }
    if conjunction { Condition::And(flat) } else { Condition::Or(flat) }
}
