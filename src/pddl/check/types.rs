//! Types, typed lists, objects and predicates.

use std::sync::Arc;

use ahash::{AHashMap, AHashSet};

use super::Checker;
use super::requirements::Requirement;
use crate::syntax::Node;
use crate::task::{Domain, Predicate};
use meliora_base::error::{Diagnostic, Severity};

/// The type of all objects.
pub(super) const ROOT: &str = "object";

/// The types, and the types of objects.
#[derive(Default)]
pub(super) struct Types {
    /// The types directly above each type.
    above: AHashMap<String, Vec<String>>,
    /// For each object, its declared types.
    pub(super) of_object: Vec<Vec<String>>,
    /// Domains that were asked for.
    pub(super) known: AHashMap<Vec<String>, Arc<Domain>>,
}

impl Types {
    /// Returns the objects that have one of some types.
    fn domain(&mut self, of: &[String]) -> Arc<Domain> {
        if let Some(known) = self.known.get(of) {
            return Arc::clone(known);
        }
        let member: Vec<bool> = self.of_object.iter().map(|types| self.is_below(types, of)).collect();
        let objects = (0..).zip(&member).filter(|(_, is)| **is).map(|(object, _)| object).collect();
        let domain = Arc::new(Domain { objects, member });
        self.known.insert(of.to_vec(), Arc::clone(&domain));
        domain
    }

    fn is_below(&self, types: &[String], wanted: &[String]) -> bool {
        if wanted.iter().any(|name| name == ROOT) {
            return true;
        }
        let (mut open, mut seen): (Vec<&String>, AHashSet<&String>) =
            (types.iter().collect(), AHashSet::new());
        while let Some(name) = open.pop() {
            if wanted.contains(name) {
                return true;
            }
            if seen.insert(name) {
                open.extend(self.above.get(name).into_iter().flatten());
            }
        }
        false
    }
}

/// A predicate as it is declared: its name in small letters and as it is written, and the types of its
/// parameters.
pub(super) struct Declared {
    pub(super) name: String,
    shown: String,
    pub(super) parameters: Vec<Vec<String>>,
}

impl Checker {
    /// Declares types; those after `-` are declared as well.
    pub(super) fn declare_types(&mut self, parts: &[Node]) {
        self.used.add(Requirement::Typing);
        for (node, above) in self.typed_list(parts) {
            let Some(name) = node.word() else {
                self.report::<()>(node.expected("the name of a type"));
                continue;
            };
            let above = self.type_names(above);
            for upper in &above {
                self.types.above.entry(upper.clone()).or_default();
            }
            self.types.above.entry(name.to_owned()).or_default().extend(above);
        }
    }

    /// Declares constants or objects. A repeated declaration adds its types.
    pub(super) fn declare_objects(&mut self, parts: &[Node]) {
        for (node, of) in self.typed_list(parts) {
            let Some(name) = node.word() else {
                self.report::<()>(node.expected("the name of an object"));
                continue;
            };
            let of = self.types_of(of);
            match self.object_of.get(name) {
                Some(&known) => self.types.of_object[known as usize].extend(of),
                None => self.add_object(node, of),
            }
        }
        self.types.known.clear();
    }

    /// Adds an object with its types.
    pub(super) fn add_object(&mut self, node: &Node, of: Vec<String>) {
        let number = u32::try_from(self.objects.len()).unwrap_or(u32::MAX);
        self.object_of.insert(node.word().unwrap_or_default().to_owned(), number);
        self.objects.push(node.text().to_owned());
        self.types.of_object.push(of);
    }

    /// Reads the declarations of predicates.
    pub(super) fn read_predicates(&mut self, parts: &[Node], declared: &mut Vec<Declared>) {
        for node in parts {
            let (Some((name, parameters)), Some(first)) =
                (node.form(), node.list().and_then(<[Node]>::first))
            else {
                self.report::<()>(node.expected("a predicate such as `(at ?x - place)`"));
                continue;
            };
            if declared.iter().any(|known| known.name == name) {
                self.report::<()>(first.wrong(format!("the predicate `{name}` is declared twice")));
            }
            let parameters = self.placeholders(parameters);
            declared.push(Declared { name: name.to_owned(), shown: first.text().to_owned(), parameters });
        }
    }

    /// Adds predicates, once all objects are known.
    pub(super) fn add_predicates(&mut self, declared: Vec<Declared>) {
        self.types.known.clear();
        for Declared { name, shown, parameters } in declared {
            let parameters = parameters.iter().map(|of| self.types.domain(of)).collect();
            self.predicate_of.insert(name, self.predicates.len());
            let predicate = Predicate { name: shown, parameters, is_derived: false, is_changed: false };
            self.predicates.push(predicate);
        }
    }

    /// Reads `?x ?y - t`: names of variables, in small letters, with their domains.
    pub(super) fn variables(&mut self, parts: &[Node]) -> Vec<(String, Arc<Domain>)> {
        let variables = self.typed_variables(parts);
        for (name, node) in repeated(&variables) {
            let wrong = node.wrong(format!("the variable `{name}` stands twice in this list"));
            self.report::<()>(wrong.help("give each variable a name of its own"));
        }
        let domain = |(node, of): (&Node, Vec<String>)| {
            (node.word().unwrap_or_default().to_owned(), self.types.domain(&of))
        };
        variables.into_iter().map(domain).collect()
    }

    /// Reads the parameters of a declaration: the types of each. Nothing refers to their names, so one that stands
    /// twice is only noted.
    pub(super) fn placeholders(&mut self, parts: &[Node]) -> Vec<Vec<String>> {
        let variables = self.typed_variables(parts);
        for (name, node) in repeated(&variables) {
            let note = node.wrong(format!("the parameter `{name}` stands twice in this list"));
            self.faults.notes.push(note.severity(Severity::Warning).label("read as another parameter"));
        }
        variables.into_iter().map(|(_, of)| of).collect()
    }

    /// Reads `?x ?y - t`: the variables with the names of their types.
    fn typed_variables<'n>(&mut self, parts: &'n [Node]) -> Vec<(&'n Node, Vec<String>)> {
        let mut variables = Vec::new();
        for (node, of) in self.typed_list(parts) {
            let of = self.types_of(of);
            if node.word().is_some_and(|name| name.starts_with('?')) {
                variables.push((node, of));
            } else {
                let wrong = node.expected("a variable such as `?x`");
                self.report::<()>(wrong.help("the names of variables begin with `?`"));
            }
        }
        variables
    }

    /// Splits `a b - t c`: each name with the node of its type.
    pub(super) fn typed_list<'n>(&mut self, parts: &'n [Node]) -> Vec<(&'n Node, Option<&'n Node>)> {
        let (mut all, mut rest) = (Vec::new(), parts);
        while let Some((node, after)) = rest.split_first() {
            rest = after;
            if node.word() != Some("-") {
                all.push((node, None));
                continue;
            }
            let Some((of, after)) = rest.split_first() else {
                self.report::<()>(node.wrong("expected a type after `-`"));
                break;
            };
            rest = after;
            self.used.add(Requirement::Typing);
            all.iter_mut()
                .rev()
                .take_while(|(_, known)| known.is_none())
                .for_each(|(_, known)| *known = Some(of));
        }
        all
    }

    /// Returns the names of a type, or of `(either t u)`, without a check.
    pub(super) fn type_names(&mut self, of: Option<&Node>) -> Vec<String> {
        let Some(node) = of else { return vec![ROOT.to_owned()] };
        let parts = match (node.word(), node.form()) {
            (Some(name), _) => return vec![name.to_owned()],
            (_, Some(("either", parts))) => parts,
            _ => {
                self.report::<()>(node.expected("a type, or `(either t u)`"));
                return Vec::new();
            }
        };
        parts.iter().filter_map(Node::word).map(str::to_owned).collect()
    }

    /// Same as [`Checker::type_names`]; reports types that are not declared.
    fn types_of(&mut self, of: Option<&Node>) -> Vec<String> {
        let types = self.type_names(of);
        for name in &types {
            if let Some(node) = of.filter(|_| name != ROOT && !self.types.above.contains_key(name)) {
                let wrong = node.wrong(format!("unknown type `{name}`")).label("not declared in `:types`");
                let known: Vec<&str> = self.types.above.keys().map(String::as_str).collect();
                self.report::<()>(with_known(wrong, "types", known));
            }
        }
        types
    }
}

/// Returns the variables whose names stand before them in the same list.
fn repeated<'n>(variables: &[(&'n Node, Vec<String>)]) -> Vec<(&'n str, &'n Node)> {
    let mut seen = AHashSet::new();
    let named = variables.iter().filter_map(|(node, _)| Some((node.word()?, *node)));
    named.filter(|(name, _)| !seen.insert(*name)).collect()
}

/// Adds the known names to an error.
pub(super) fn with_known(wrong: Diagnostic, what: &str, mut known: Vec<&str>) -> Diagnostic {
    known.sort_unstable();
    match known.is_empty() {
        true => wrong.help(format!("no {what} are declared")),
        false => wrong.help(format!("the {what} are `{}`", known.join("`, `"))),
    }
}
