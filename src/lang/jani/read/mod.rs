//! From the text to the tree: checks the shape of the document, and reports several errors per run.

mod automaton;
mod expr;
mod property;
mod reader;

use std::sync::Arc;

use super::ast::{Constant, Function, Model, System, TypeOf, Variable, Vector};
use super::json::Node;
use crate::error::{Result, SourceFile};
use crate::lang::ast::{Ident, ModelType};
use crate::model::value::Type;
use crate::progress::ProgressSink;
use reader::{Object, Reader, Value};

/// Features that are supported, or have no effect here.
const SUPPORTED: &[&str] = &[
    "derived-operators",
    "functions",
    "state-exit-rewards",
    "hyperbolic-functions",
    "trigonometric-functions",
    "named-expressions",
    "x-momba-operators",
];

/// Parses the tree of a model.
///
/// # Errors
/// The text is not JSON, is not a model, or uses unsupported constructs.
pub(super) fn model(source: &Arc<SourceFile>, sink: &dyn ProgressSink) -> Result<Model> {
    let mut reader = Reader::new(source, sink);
    let document = reader.document();
    let model = document.and_then(|node| reader.model(node));
    reader.finish(model)
}

impl<'a> Reader<'a> {
    fn model(&mut self, node: Node<'a>) -> Option<Model> {
        let keys = &[
            "jani-version",
            "name",
            "metadata",
            "type",
            "features",
            "actions",
            "constants",
            "variables",
            "functions",
            "datatypes",
            "restrict-initial",
            "properties",
            "automata",
            "system",
        ];
        let what = "the model";
        let object = self.object(node, what, keys)?;
        let kind = self.kind(&object);
        self.version(&object);
        self.features(&object);
        let actions = self.items(object.get("actions"), "the actions", |reader, node| {
            let object = reader.object(node, "an action", &["name"])?;
            reader.named(&object, "an action", "name")
        });
        let constants = self.items(object.get("constants"), "the constants", Reader::constant_definition);
        let variables = self.items(object.get("variables"), "the variables", Reader::variable);
        let functions = self.items(object.get("functions"), "the functions", Reader::function);
        let restrict = self.wrapped(object.get("restrict-initial"), "a restriction");
        let properties = self.items(object.get("properties"), "the properties", Reader::property);
        let automata = self.required(&object, what, "automata");
        let automata = automata.and_then(|n| self.items(Some(n), "the automata", Reader::automaton));
        let system = self.required(&object, what, "system").and_then(|n| self.system(n));
        Some(Model {
            kind: kind?,
            constants: constants?,
            variables: variables?,
            functions: functions?,
            actions: actions?,
            automata: automata?,
            system: system?,
            restrict: restrict?,
            properties: properties?,
        })
    }

    fn kind(&mut self, object: &Object<'a>) -> Option<ModelType> {
        let kind = self.named(object, "the model", "type")?;
        match kind.name.as_str() {
            "mdp" => Some(ModelType::Mdp),
            "dtmc" => Some(ModelType::Dtmc),
            "lts" | "ctmc" | "ctmdp" | "ma" | "ta" | "pta" | "sta" | "ha" | "pha" | "sha" => {
                let diagnostic =
                    self.wrong(kind.span, format!("models of type `{}` are not supported", kind.name));
                let diagnostic =
                    diagnostic.severity(crate::error::Severity::Unsupported).label("not supported");
                self.report(diagnostic.help("the types `mdp` and `dtmc` are supported"));
                None
            }
            name => self.fail(kind.span, format!("unknown model type \"{name}\"")),
        }
    }

    fn version(&mut self, object: &Object<'a>) {
        if let Some(node) = object.get("jani-version")
            && let Some(version) = self.whole(node, "the \"jani-version\"")
            && version != 1
        {
            self.unsupported::<()>(node.span(), format!("version {version} of the format is not supported"));
        }
    }

    /// Refuses unsupported features by name; features that only add operators are refused at the
    /// operators.
    fn features(&mut self, object: &Object<'a>) {
        let names = self.items(object.get("features"), "the features", |r, n| r.name(n, "a feature"));
        for feature in names.unwrap_or_default() {
            if !SUPPORTED.contains(&feature.name.as_str()) {
                let message = format!("the feature \"{}\" is not supported", feature.name);
                self.unsupported::<()>(feature.span, message);
            }
        }
        if object.get("datatypes").is_some() {
            self.unsupported::<()>(object.key_span("datatypes"), "datatypes are not supported");
        }
    }

    fn constant_definition(&mut self, node: Node<'a>) -> Option<Constant> {
        let what = "a constant";
        let object = self.object(node, what, &["name", "type", "value"])?;
        let name = self.named(&object, what, "name");
        let ty = self.required(&object, what, "type").and_then(|n| self.type_of(n));
        let value = match object.get("value") {
            Some(node) => self.expression(node).map(Some),
            None => Some(None),
        };
        Some(Constant { name: name?, ty: ty?, value: value? })
    }

    fn variable(&mut self, node: Node<'a>) -> Option<Variable> {
        let what = "a variable";
        let object = self.object(node, what, &["name", "type", "transient", "initial-value"])?;
        let name = self.named(&object, what, "name");
        let ty = self.required(&object, what, "type").and_then(|n| self.type_of(n));
        let transient = match object.get("transient") {
            Some(node) => self.truth(node, "\"transient\""),
            None => Some(false),
        };
        let initial = match object.get("initial-value") {
            Some(node) => self.expression(node).map(Some),
            None => Some(None),
        };
        Some(Variable { name: name?, ty: ty?, transient: transient?, initial: initial? })
    }

    pub(super) fn function(&mut self, node: Node<'a>) -> Option<Function> {
        let what = "a function";
        let object = self.object(node, what, &["name", "type", "parameters", "body"])?;
        let name = self.named(&object, what, "name");
        let ty = self.required(&object, what, "type").and_then(|n| self.type_of(n));
        let parameters = self.items(object.get("parameters"), "the parameters", |reader, node| {
            let what = "a parameter";
            let object = reader.object(node, what, &["name", "type"])?;
            let name = reader.named(&object, what, "name");
            let ty = reader.required(&object, what, "type").and_then(|n| reader.type_of(n));
            Some((name?, ty?))
        });
        let body = self.operand(&object, what, "body");
        Some(Function { name: name?, ty: ty?, parameters: parameters?, body: body? })
    }

    /// Reads `"bool"`, `"int"`, `"real"`, or a bounded type of the last two.
    fn type_of(&mut self, node: Node<'a>) -> Option<TypeOf> {
        let span = node.span();
        let plain = |ty| TypeOf { ty, low: None, high: None, span };
        let kind = match self.any(node)? {
            Value::Text(name) => return self.basic(&Ident { name, span }).map(plain),
            Value::Object(object) => object,
            _ => return self.fail(span, "expected a type"),
        };
        let name = self.named(&kind, "a type", "kind")?;
        match name.name.as_str() {
            "bounded" => {
                self.known(&kind, "a bounded type", &["kind", "base", "lower-bound", "upper-bound"])?;
                let base = self.named(&kind, "a bounded type", "base")?;
                let ty = self.basic(&base)?;
                if ty == Type::Bool {
                    return self.fail(base.span, "only numbers have bounds");
                }
                let mut bound = |key| match kind.get(key) {
                    Some(node) => self.expression(node).map(Some),
                    None => Some(None),
                };
                let (low, high) = (bound("lower-bound"), bound("upper-bound"));
                Some(TypeOf { ty, low: low?, high: high?, span })
            }
            "array" => self.unsupported(name.span, "arrays are not supported"),
            "datatype" | "option" => self.unsupported(name.span, "datatypes are not supported"),
            other => self.fail(name.span, format!("unknown kind of type \"{other}\"")),
        }
    }

    fn basic(&mut self, name: &Ident) -> Option<Type> {
        match name.name.as_str() {
            "bool" => Some(Type::Bool),
            "int" => Some(Type::Int),
            "real" => Some(Type::Real),
            "clock" => self.unsupported(name.span, "clocks are not supported"),
            "continuous" => self.unsupported(name.span, "continuous variables are not supported"),
            other => self.fail(name.span, format!("unknown type \"{other}\"")),
        }
    }

    fn system(&mut self, node: Node<'a>) -> Option<System> {
        let what = "the system";
        let object = self.object(node, what, &["elements", "syncs"])?;
        let elements = self.required(&object, what, "elements");
        let elements = elements.and_then(|n| self.items(Some(n), "the elements", Reader::element));
        let vectors = match object.get("syncs") {
            Some(node) => self.items(Some(node), "the synchronisation vectors", Reader::vector).map(Some),
            None => Some(None),
        };
        Some(System { elements: elements?, vectors: vectors?, span: object.start() })
    }

    fn element(&mut self, node: Node<'a>) -> Option<Ident> {
        let what = "an element of the system";
        let object = self.object(node, what, &["automaton", "input-enable"])?;
        if let Some(enabled) = object.get("input-enable")
            && !self.array(enabled, "the actions that are always enabled")?.is_empty()
        {
            let span = object.key_span("input-enable");
            return self.unsupported(span, "input-enabled automata are not supported");
        }
        self.named(&object, what, "automaton")
    }

    fn vector(&mut self, node: Node<'a>) -> Option<Vector> {
        let what = "a synchronisation vector";
        let object = self.object(node, what, &["synchronise", "result"])?;
        let actions = self.required(&object, what, "synchronise");
        let actions = actions.and_then(|n| self.items(Some(n), "the actions of the vector", Reader::place));
        let result = match object.get("result") {
            Some(node) => self.place(node),
            None => Some(None),
        };
        Some(Vector { actions: actions?, result: result?, span: node.span() })
    }

    /// Reads an action, or `null`.
    fn place(&mut self, node: Node<'a>) -> Option<Option<Ident>> {
        if self.is_null(node) { Some(None) } else { self.name(node, "an action or null").map(Some) }
    }
}
