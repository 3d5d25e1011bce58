//! Actions and derived predicates.

use super::Checker;
use super::requirements::Requirement;
use crate::syntax::Node;
use crate::task::{Action, Axiom, Effect};
use meliora_base::error::Severity;

impl Checker {
    /// Reads `(:action NAME :parameters (…) :precondition … :effect …)`.
    pub(super) fn action(&mut self, parts: &[Node], node: &Node) {
        let Some((name, parts)) = parts.split_first().filter(|(name, _)| name.word().is_some()) else {
            self.report::<()>(node.wrong("expected the name of the action after `:action`"));
            return;
        };
        if let Some(first) = self.actions.iter().find(|known| known.name.eq_ignore_ascii_case(name.text())) {
            let message = format!("the action `{}` is declared twice", first.name);
            let note = name.wrong(message).severity(Severity::Warning);
            self.faults.notes.push(note.label("kept as an action of its own, with a number after its name"));
        }
        let Some([parameters, precondition, effect]) = self.keys(parts) else { return };
        let parameters = match parameters.map(|node| (node, node.list())) {
            None => Vec::new(),
            Some((_, Some(list))) => self.variables(list),
            Some((node, None)) => {
                self.report::<()>(node.expected("parameters in brackets"));
                return;
            }
        };
        let domains = parameters.iter().map(|(_, domain)| domain.clone()).collect();
        self.scope = parameters;
        let precondition = self.optional_condition(precondition);
        let effect = match effect {
            Some(effect) => self.effect(effect),
            None => Some(Effect::And(Vec::new())),
        };
        self.scope.clear();
        if let (Some(precondition), Some(effect)) = (precondition, effect) {
            let (name, span) = (name.text().to_owned(), self.joined(node));
            self.actions.push(Action { name, parameters: domains, precondition, effect, span });
        }
    }

    /// Splits the parts of an action by their keys.
    fn keys<'n>(&mut self, parts: &'n [Node]) -> Option<[Option<&'n Node>; 3]> {
        let mut slots = [None; 3];
        for pair in parts.chunks(2) {
            let (key, value) = (&pair[0], pair.get(1));
            let slot = match key.word() {
                Some(":parameters") => &mut slots[0],
                Some(":precondition") => &mut slots[1],
                Some(":effect") => &mut slots[2],
                Some(":duration" | ":condition") => {
                    return self.report(key.wrong("actions with a duration are not supported"));
                }
                Some(":observe") => {
                    return self.report(key.wrong("`:observe` is not supported: all facts are observed"));
                }
                _ => {
                    let wrong = key.expected("`:parameters`, `:precondition` or `:effect`");
                    return self.report(wrong);
                }
            };
            match (value, *slot) {
                (Some(value), None) => *slot = Some(value),
                (_, Some(_)) => return self.report(key.wrong("this part stands twice")),
                // `:precondition` without a condition, as some writers end an action.
                (None, None) => {}
            }
        }
        Some(slots)
    }

    /// Marks the predicate of `(:derived (p ?x) condition)`.
    pub(super) fn declare_derived(&mut self, parts: &[Node]) {
        self.used.add(Requirement::Derived);
        let name = parts.first().and_then(Node::form).map(|(name, _)| name);
        if let Some(&predicate) = name.and_then(|name| self.predicate_of.get(name)) {
            self.predicates[predicate].is_derived = true;
        }
    }

    /// Reads `(:derived (p ?x - t) condition)`.
    pub(super) fn derived(&mut self, parts: &[Node], node: &Node) {
        let Some([head, body]) = self.exactly(node, parts, ":derived") else { return };
        let Some((name, parameters)) = head.form() else {
            self.report::<()>(head.expected("an atom over variables"));
            return;
        };
        let Some(&predicate) = self.predicate_of.get(name) else {
            self.report::<()>(head.wrong(format!("unknown predicate `{name}`")));
            return;
        };
        let variables = self.variables(parameters);
        let expected = self.predicates[predicate].parameters.len();
        if variables.len() != expected {
            let message = format!("`{name}` has {expected} arguments, here are {}", variables.len());
            self.report::<()>(head.wrong(message));
            return;
        }
        // Where the rule states no type, the declaration of the predicate does.
        let is_typed = parameters.iter().any(|part| part.word() == Some("-"));
        let declared = self.predicates[predicate].parameters.clone();
        let typed = variables.into_iter().zip(declared);
        self.scope = typed.map(|((name, own), of)| (name, if is_typed { own } else { of })).collect();
        let parameters = self.scope.iter().map(|(_, domain)| domain.clone()).collect();
        let condition = self.condition(body, true);
        self.scope.clear();
        self.axioms.extend(condition.map(|condition| Axiom { predicate, parameters, condition }));
    }
}
