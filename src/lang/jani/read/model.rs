//! The objects of a model.

use super::super::json::{Node, Shape};
use super::composition::Part;
use super::property::Properties;
use super::reader::Reader;
use super::record::{NonEmpty, Read, records};
use super::types::{Action, Bounds, Exp, Feature, Version};
use crate::ast::{Expr, Ident};
use meliora_base::stack;
use meliora_model::ModelKind;

records! {
    Model = "the model" {
        "type" => kind: ModelKind,
        "actions" => actions: Vec<Named> = Vec::new(),
        "constants" => constants: Vec<Constant> = Vec::new(),
        "variables" => variables: Vec<Variable> = Vec::new(),
        "functions" => functions: Vec<Function> = Vec::new(),
        "restrict-initial" => restrict: Option<Exp> = None,
        "properties" => properties: Properties = Properties::default(),
        "automata" => automata: Vec<Automaton>,
        "system" => system: System,
    }
    checks { "jani-version" => Version, "features" => Vec<Feature> }
    refuses { "datatypes" => "datatypes are not supported" }
    ignores { "name", "metadata" };

    /// The declaration of an action.
    Named = "an action" {
        "name" => name: Ident,
    };

    Constant = "a constant" {
        "name" => name: Ident,
        "type" => ty: Bounds,
        "value" => value: Option<Expr> = None,
    };

    Variable = "a variable" {
        "name" => name: Ident,
        "type" => ty: Bounds,
        "transient" => transient: bool = false,
        "initial-value" => initial: Option<Expr> = None,
    };

    Function = "a function" {
        "name" => name: Ident,
        "type" => ty: Bounds,
        "parameters" => parameters: Vec<Parameter> = Vec::new(),
        "body" => body: Expr,
    };

    Parameter = "a parameter" {
        "name" => name: Ident,
        "type" => ty: Bounds,
    };

    Automaton = "an automaton" {
        "name" => name: Ident,
        "variables" => variables: Vec<Variable> = Vec::new(),
        "functions" => functions: Vec<Function> = Vec::new(),
        "restrict-initial" => restrict: Option<Exp> = None,
        "locations" => locations: NonEmpty<Location>,
        "initial-locations" => initial: NonEmpty<Ident>,
        "edges" => edges: Vec<Edge>,
    };

    Location = "a location" {
        "name" => name: Ident,
        "transient-values" => values: Vec<TransientValue> = Vec::new(),
    }
    refuses { "time-progress" => "conditions on the progress of time are not supported" };

    /// The value of a transient variable in a location.
    TransientValue = "a transient value" {
        "ref" => variable: Ident,
        "value" => value: Expr,
    };

    Edge = "an edge" {
        "location" => location: Ident,
        "action" => action: Option<Ident> = None,
        "guard" => guard: Option<Exp> = None,
        "assignments" => assignments: Vec<Assignment> = Vec::new(),
        "destinations" => destinations: NonEmpty<Destination>,
    }
    refuses { "rate" => "edges with rates are not supported" }
    ignores { "color" }
    at span;

    Destination = "a destination" {
        "location" => location: Ident,
        "probability" => probability: Option<Exp> = None,
        "assignments" => assignments: Vec<Assignment> = Vec::new(),
    }
    at span;

    Assignment = "an assignment" {
        "ref" => variable: Target,
        "value" => value: Expr,
        "index" => index: i64 = 0,
    };

    /// The automata that run in parallel, and their synchronisation; without vectors they are `None`.
    System = "the system" {
        "elements" => parts: Vec<Part>,
        "syncs" => vectors: Option<Vec<Vector>> = None,
    }
    at span;

    Element = "an element of the system" {
        "automaton" => automaton: Ident,
    }
    empties { "input-enable" => "input-enabled automata are not supported" };

    /// A synchronisation vector: for each element an action, or none.
    Vector = "a synchronisation vector" {
        "synchronise" => actions: Vec<Action>,
        "result" => result: Action = Action(None),
    }
    at span;
}

/// The variable that an assignment changes, or an element of an array.
#[derive(Debug, Clone)]
pub(crate) struct Target {
    pub(crate) name: Ident,
    /// The indices from the outer array on.
    pub(crate) indices: Vec<Expr>,
}

impl<'a> Read<'a> for Target {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self> {
        let Some(Shape::Object(object)) = reader.any(node) else {
            return Some(Target { name: reader.name(node, what)?, indices: Vec::new() });
        };
        let op: Ident = reader.field(&object, what, "op", None)?;
        if op.name != "aa" {
            return reader
                .fail(op.span, "an assignment changes a variable, or an element of an array by \"aa\"");
        }
        reader.known(&object, "\"aa\"", &["op", "exp", "index"])?;
        let array = reader.required(&object, "\"aa\"", "exp")?;
        let Target { name, mut indices } = stack::level(|| Target::read(reader, array, what))?;
        indices.push(reader.field(&object, "\"aa\"", "index", None)?);
        Some(Target { name, indices })
    }
}

impl Model {
    /// Gives the assignments that an edge makes itself, as in files written by Storm, to each of its
    /// destinations.
    pub(super) fn with_assignments_of_edges(mut self) -> Self {
        for edge in self.automata.iter_mut().flat_map(|automaton| &mut automaton.edges) {
            let shared = std::mem::take(&mut edge.assignments);
            for destination in &mut edge.destinations.0 {
                destination.assignments.extend(shared.iter().cloned());
            }
        }
        self
    }
}
