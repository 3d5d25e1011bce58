//! Expressions.

use super::super::json::{Node as Json, Object, Shape};
use super::path::is_of_properties;
use super::reader::Reader;
use super::record::Read;
use crate::ast::{BinaryOp, Comprehension, Expr, Function, Ident, Node, NodeKind};
use meliora_base::exact::{Real, decimal};
use meliora_base::stack;
use meliora_base::value;

const TWO: &[&str] = &["left", "right"];
const ONE: &[&str] = &["exp"];

/// Operators by their names in the format, with the keys of their operands.
const OPERATORS: &[(&str, &[&str], NodeKind)] = &[
    ("∧", TWO, NodeKind::Join(BinaryOp::And, 2)),
    ("∨", TWO, NodeKind::Join(BinaryOp::Or, 2)),
    ("⇒", TWO, NodeKind::Binary(BinaryOp::Implies)),
    ("=", TWO, NodeKind::Binary(BinaryOp::Eq)),
    ("≠", TWO, NodeKind::Binary(BinaryOp::Ne)),
    ("<", TWO, NodeKind::Binary(BinaryOp::Lt)),
    ("≤", TWO, NodeKind::Binary(BinaryOp::Le)),
    (">", TWO, NodeKind::Binary(BinaryOp::Gt)),
    ("≥", TWO, NodeKind::Binary(BinaryOp::Ge)),
    ("+", TWO, NodeKind::Binary(BinaryOp::Add)),
    ("-", TWO, NodeKind::Binary(BinaryOp::Sub)),
    ("*", TWO, NodeKind::Binary(BinaryOp::Mul)),
    ("/", TWO, NodeKind::Binary(BinaryOp::Div)),
    ("min", TWO, NodeKind::Apply(Function::Min, 2)),
    ("max", TWO, NodeKind::Apply(Function::Max, 2)),
    ("%", TWO, NodeKind::Apply(Function::Mod, 2)),
    ("pow", TWO, NodeKind::Apply(Function::Pow, 2)),
    ("log", TWO, NodeKind::Apply(Function::Log, 2)),
    ("floor", ONE, NodeKind::Apply(Function::Floor, 1)),
    ("ceil", ONE, NodeKind::Apply(Function::Ceil, 1)),
    ("abs", ONE, NodeKind::Apply(Function::Abs, 1)),
    ("sgn", ONE, NodeKind::Apply(Function::Sign, 1)),
    ("trc", ONE, NodeKind::Apply(Function::Truncate, 1)),
    ("¬", ONE, NodeKind::Not),
    ("ite", &["if", "then", "else"], NodeKind::Ite),
    ("aa", &["exp", "index"], NodeKind::Element),
];

/// Operators of unsupported features, with the features.
const REFUSED: &[(&str, &str)] = &[
    ("da", "datatypes"),
    ("dv", "datatypes"),
    ("some", "datatypes"),
    ("der", "derivatives of continuous variables"),
    ("nondet", "nondeterministic selection"),
    ("sin", "trigonometric-functions"),
    ("cos", "trigonometric-functions"),
    ("tan", "trigonometric-functions"),
    ("cot", "trigonometric-functions"),
    ("sec", "trigonometric-functions"),
    ("csc", "trigonometric-functions"),
    ("asin", "trigonometric-functions"),
    ("acos", "trigonometric-functions"),
    ("atan", "trigonometric-functions"),
    ("acot", "trigonometric-functions"),
    ("asec", "trigonometric-functions"),
    ("acsc", "trigonometric-functions"),
    ("sinh", "hyperbolic-functions"),
    ("cosh", "hyperbolic-functions"),
    ("tanh", "hyperbolic-functions"),
    ("∃", "quantifiers"),
    ("∀", "quantifiers"),
];

impl<'a> Read<'a> for Expr {
    fn read(reader: &mut Reader<'a>, node: Json<'a>, _: &str) -> Option<Self> {
        let mut nodes = Vec::new();
        reader.nodes(node, &mut nodes)?;
        Some(Expr { nodes })
    }
}

impl<'a> Reader<'a> {
    /// Adds the nodes of an expression.
    fn nodes(&mut self, node: Json<'a>, nodes: &mut Vec<Node>) -> Option<()> {
        let kind = match self.any(node)? {
            Shape::Bool(b) => NodeKind::Literal(value::Value::Bool(b)),
            Shape::Number(text) => NodeKind::Literal(self.number(node, text)?),
            Shape::Text(name) => NodeKind::Name(name.into()),
            Shape::Object(object) => self.compound(&object, nodes)?,
            Shape::Null | Shape::Array(_) => return None,
        };
        nodes.push(Node { kind, span: node.span() });
        Some(())
    }

    /// Reads a number; without a point or an exponent it is an integer.
    fn number(&mut self, node: Json<'a>, text: &str) -> Option<value::Value> {
        if text.contains(['.', 'e', 'E']) {
            let x = decimal(text).map(|exact| Real::Finite(exact).to_f64());
            return match x {
                Ok(x) if x.is_finite() => Some(value::Value::Real(x)),
                Ok(_) => self.fail(node.span(), "this number is too large for a double"),
                Err(reason) => self.fail(node.span(), format!("this number: {reason}")),
            };
        }
        match text.parse::<i64>() {
            Ok(i) => Some(value::Value::Int(i)),
            Err(_) => self.fail(node.span(), "this integer does not fit into 64 bits"),
        }
    }

    /// Adds the operands of an operator, and returns the operator.
    fn compound(&mut self, object: &Object<'a>, nodes: &mut Vec<Node>) -> Option<NodeKind> {
        if object.get("constant").is_some() {
            return self.constant(object);
        }
        let Ident { name, span } = self.field(object, "an expression", "op", None)?;
        match name.as_str() {
            "call" => return self.call(object, nodes),
            "av" => return self.array_of_values(object, nodes),
            "ac" => return self.comprehension(object),
            _ => {}
        }
        if let Some((_, keys, kind)) = OPERATORS.iter().find(|o| o.0 == name) {
            let known: Vec<&str> = ["op"].iter().chain(*keys).copied().collect();
            let what = format!("\"{name}\"");
            self.known(object, &what, &known)?;
            return self.operands(object, &what, keys, kind, nodes);
        }
        if self.is_nesting() && is_of_properties(&name) {
            return stack::level(|| self.nested(object, &name, span));
        }
        match REFUSED.iter().find(|r| r.0 == name) {
            Some((_, feature)) => {
                self.unsupported(span, format!("the operator \"{name}\" ({feature}) is not supported"))
            }
            None if is_of_properties(&name) => self.unsupported(
                span,
                format!("the operator \"{name}\" of properties is not supported in an expression"),
            ),
            None => self.fail(span, format!("unknown operator \"{name}\" in an expression")),
        }
    }

    /// Reads `{"constant": "e"}` or `{"constant": "π"}`.
    fn constant(&mut self, object: &Object<'a>) -> Option<NodeKind> {
        self.known(object, "a constant of mathematics", &["constant"])?;
        let Ident { name, span } = self.field(object, "an expression", "constant", None)?;
        let value = match name.as_str() {
            "e" => std::f64::consts::E,
            "π" => std::f64::consts::PI,
            _ => return self.fail(span, format!("unknown constant \"{name}\"")),
        };
        Some(NodeKind::Literal(value::Value::Real(value)))
    }

    /// Reads the operands under the given keys; nested `∧`, and nested `∨`, are flattened.
    fn operands(
        &mut self,
        object: &Object<'a>,
        what: &str,
        keys: &[&str],
        kind: &NodeKind,
        nodes: &mut Vec<Node>,
    ) -> Option<NodeKind> {
        let mut counts = Vec::new();
        for key in keys {
            let node =
                self.required(object, what, key).and_then(|node| stack::level(|| self.nodes(node, nodes)));
            counts.push(node.map(|()| match (kind, nodes.last().map(|root| &root.kind)) {
                (NodeKind::Join(op, _), Some(&NodeKind::Join(inner, count))) if *op == inner => {
                    nodes.pop();
                    count
                }
                _ => 1,
            }));
        }
        let count = counts.into_iter().sum::<Option<u32>>()?;
        Some(if let NodeKind::Join(op, _) = kind { NodeKind::Join(*op, count) } else { kind.clone() })
    }

    fn array_of_values(&mut self, object: &Object<'a>, nodes: &mut Vec<Node>) -> Option<NodeKind> {
        self.known(object, "an array", &["op", "elements"])?;
        let elements = stack::level(|| self.field::<Vec<Expr>>(object, "an array", "elements", None))?;
        let count = u32::try_from(elements.len()).ok()?;
        nodes.extend(elements.into_iter().flat_map(|e| e.nodes));
        Some(NodeKind::Array(count))
    }

    fn comprehension(&mut self, object: &Object<'a>) -> Option<NodeKind> {
        let what = "an array constructor";
        self.known(object, what, &["op", "var", "length", "exp"])?;
        let variable = self.field::<Ident>(object, what, "var", None);
        let length = self.field::<Expr>(object, what, "length", None);
        let body = stack::level(|| self.field::<Expr>(object, what, "exp", None));
        let made = Comprehension { variable: variable?, length: length?, body: body? };
        Some(NodeKind::Comprehension(Box::new(made)))
    }

    fn call(&mut self, object: &Object<'a>, nodes: &mut Vec<Node>) -> Option<NodeKind> {
        self.known(object, "a call", &["op", "function", "args"])?;
        let function = self.field::<Ident>(object, "a call", "function", None);
        let arguments = self.field::<Vec<Expr>>(object, "a call", "args", Some(Vec::new()))?;
        let count = u32::try_from(arguments.len()).ok()?;
        nodes.extend(arguments.into_iter().flat_map(|e| e.nodes));
        Some(NodeKind::Call(Box::new(function?), count))
    }
}
