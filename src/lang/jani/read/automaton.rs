//! Automata: locations, edges, destinations, assignments.

use super::super::ast::{Assignment, Automaton, Destination, Edge, Expr, Location};
use super::super::json::Node;
use super::reader::{Object, Reader};
use crate::lang::ast::Ident;

impl<'a> Reader<'a> {
    /// Reads an automaton.
    pub(super) fn automaton(&mut self, node: Node<'a>) -> Option<Automaton> {
        let keys = &[
            "name",
            "variables",
            "functions",
            "restrict-initial",
            "locations",
            "initial-locations",
            "edges",
        ];
        let what = "an automaton";
        let object = self.object(node, what, keys)?;
        let name = self.named(&object, what, "name");
        let variables = self.items(object.get("variables"), "the variables", Reader::variable);
        let functions = self.items(object.get("functions"), "the functions", Reader::function);
        let restrict = self.wrapped(object.get("restrict-initial"), "a restriction");
        let locations = self.all(&object, what, "locations", Reader::location);
        let initial = self.all(&object, what, "initial-locations", |r, n| r.name(n, "a location"));
        let edges = self.all(&object, what, "edges", Reader::edge);
        let automaton = Automaton {
            name: name?,
            variables: variables?,
            functions: functions?,
            locations: locations?,
            initial: initial?,
            restrict: restrict?,
            edges: edges?,
        };
        if automaton.locations.is_empty() || automaton.initial.is_empty() {
            let message = "an automaton needs an initial location";
            return self.fail(automaton.name.span, message);
        }
        Some(automaton)
    }

    /// Reads the items under a required key.
    fn all<T>(
        &mut self,
        object: &Object<'a>,
        what: &str,
        key: &str,
        read: impl FnMut(&mut Self, Node<'a>) -> Option<T>,
    ) -> Option<Vec<T>> {
        let node = self.required(object, what, key)?;
        self.items(Some(node), &format!("the \"{key}\""), read)
    }

    fn location(&mut self, node: Node<'a>) -> Option<Location> {
        let what = "a location";
        let object = self.object(node, what, &["name", "time-progress", "transient-values"])?;
        if object.get("time-progress").is_some() {
            let span = object.key_span("time-progress");
            return self.unsupported(span, "conditions on the progress of time are not supported");
        }
        let name = self.named(&object, what, "name");
        let values = self.items(object.get("transient-values"), "the transient values", |reader, node| {
            let object = reader.object(node, "a transient value", &["ref", "value"])?;
            reader.assigned(&object, "a transient value")
        });
        Some(Location { name: name?, values: values? })
    }

    fn edge(&mut self, node: Node<'a>) -> Option<Edge> {
        let what = "an edge";
        let object =
            self.object(node, what, &["location", "action", "guard", "rate", "destinations", "color"])?;
        if object.get("rate").is_some() {
            return self.unsupported(object.key_span("rate"), "edges with rates are not supported");
        }
        let location = self.named(&object, what, "location");
        let action = match object.get("action") {
            Some(node) => self.name(node, "an action").map(Some),
            None => Some(None),
        };
        let guard = self.wrapped(object.get("guard"), "a guard");
        let destinations = self.all(&object, what, "destinations", Reader::destination);
        let (location, action, guard, destinations) = (location?, action?, guard?, destinations?);
        if destinations.is_empty() {
            return self.fail(object.key_span("destinations"), "an edge needs a destination");
        }
        Some(Edge { location, action, guard, destinations, span: node.span() })
    }

    fn destination(&mut self, node: Node<'a>) -> Option<Destination> {
        let what = "a destination";
        let object = self.object(node, what, &["location", "probability", "assignments"])?;
        let location = self.named(&object, what, "location");
        let probability = self.wrapped(object.get("probability"), "a probability");
        let assignments = self.items(object.get("assignments"), "the assignments", Reader::assignment);
        Some(Destination {
            location: location?,
            probability: probability?,
            assignments: assignments?,
            span: node.span(),
        })
    }

    fn assignment(&mut self, node: Node<'a>) -> Option<Assignment> {
        let what = "an assignment";
        let object = self.object(node, what, &["ref", "value", "index"])?;
        let assigned = self.assigned(&object, what);
        let index = match object.get("index") {
            Some(node) => self.whole(node, "the \"index\" of an assignment"),
            None => Some(0),
        };
        let (variable, value) = assigned?;
        Some(Assignment { variable, value, index: index? })
    }

    /// Reads `"ref"` and `"value"`.
    fn assigned(&mut self, object: &Object<'a>, what: &str) -> Option<(Ident, Expr)> {
        let target = self.required(object, what, "ref");
        let value = self.operand(object, what, "value");
        Some((self.name(target?, "the name of a variable")?, value?))
    }
}
