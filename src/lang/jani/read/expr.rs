//! Expressions.

use super::super::ast::{Expr, ExprKind, Op};
use super::super::json::Node;
use super::reader::{Object, Reader, Value};
use crate::lang::ast::{BinaryOp, Ident};
use crate::model::value;

/// Binary operators by their names in the format.
const BINARY: &[(&str, BinaryOp)] = &[
    ("∧", BinaryOp::And),
    ("∨", BinaryOp::Or),
    ("⇒", BinaryOp::Implies),
    ("=", BinaryOp::Eq),
    ("≠", BinaryOp::Ne),
    ("<", BinaryOp::Lt),
    ("≤", BinaryOp::Le),
    (">", BinaryOp::Gt),
    ("≥", BinaryOp::Ge),
    ("+", BinaryOp::Add),
    ("-", BinaryOp::Sub),
    ("*", BinaryOp::Mul),
    ("/", BinaryOp::Div),
];

/// Functions of two operands and of one operand that the modelling language also has.
const TWO: &[(&str, &str)] = &[("min", "min"), ("max", "max"), ("%", "mod"), ("pow", "pow"), ("log", "log")];
const ONE: &[(&str, &str)] = &[("floor", "floor"), ("ceil", "ceil")];

/// Operators of unsupported features, with the features.
const REFUSED: &[(&str, &str)] = &[
    ("aa", "arrays"),
    ("av", "arrays"),
    ("ac", "arrays"),
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

fn find<T: Copy>(table: &[(&str, T)], name: &str) -> Option<T> {
    table.iter().find(|(n, _)| *n == name).map(|(_, value)| *value)
}

impl<'a> Reader<'a> {
    /// Reads an expression.
    pub(super) fn expression(&mut self, node: Node<'a>) -> Option<Expr> {
        let span = node.span();
        let kind = match self.any(node)? {
            Value::Bool(b) => ExprKind::Literal(value::Value::Bool(b)),
            Value::Number(text) => ExprKind::Literal(self.number(node, text)?),
            Value::Text(name) => ExprKind::Name(name),
            Value::Object(object) => self.compound(&object)?,
        };
        Some(Expr { kind, span })
    }

    /// Reads an expression under a required key.
    pub(super) fn operand(&mut self, object: &Object<'a>, what: &str, key: &str) -> Option<Expr> {
        let node = self.required(object, what, key)?;
        self.expression(node)
    }

    /// Reads `{"exp": …}`, the form of guards, probabilities and restrictions.
    pub(super) fn wrapped(&mut self, node: Option<Node<'a>>, what: &str) -> Option<Option<Expr>> {
        let Some(node) = node else { return Some(None) };
        let object = self.object(node, what, &["exp"])?;
        self.operand(&object, what, "exp").map(Some)
    }

    /// Reads a number; without a point or an exponent it is an integer.
    fn number(&mut self, node: Node<'a>, text: &str) -> Option<value::Value> {
        if text.contains(['.', 'e', 'E']) {
            match text.parse::<f64>() {
                Ok(x) if x.is_finite() => return Some(value::Value::Real(x)),
                _ => return self.fail(node.span(), "this number is too large for a double"),
            }
        }
        match text.parse::<i64>() {
            Ok(i) => Some(value::Value::Int(i)),
            Err(_) => self.fail(node.span(), "this integer does not fit into 64 bits"),
        }
    }

    fn compound(&mut self, object: &Object<'a>) -> Option<ExprKind> {
        if object.get("constant").is_some() {
            return self.constant(object);
        }
        let op = self.named(object, "an expression", "op")?;
        if let Some(binary) = find(BINARY, &op.name) {
            return self.row(object, &op, binary);
        }
        if let Some(function) = find(TWO, &op.name) {
            return self.two(object, &op).map(|o| ExprKind::Op(Op::Function(function), o));
        }
        if let Some(function) = find(ONE, &op.name) {
            return self.one(object, &op).map(|o| ExprKind::Op(Op::Function(function), o));
        }
        match op.name.as_str() {
            "¬" => self.one(object, &op).map(|o| ExprKind::Op(Op::Not, o)),
            "abs" => self.one(object, &op).map(|o| ExprKind::Op(Op::Abs, o)),
            "sgn" => self.one(object, &op).map(|o| ExprKind::Op(Op::Sgn, o)),
            "trc" => self.one(object, &op).map(|o| ExprKind::Op(Op::Trc, o)),
            "ite" => self.conditional(object, &op),
            "call" => self.call(object),
            name => match find(REFUSED, name) {
                Some(feature) => {
                    self.unsupported(op.span, format!("the operator \"{name}\" ({feature}) is not supported"))
                }
                None => self.fail(op.span, format!("unknown operator \"{name}\" in an expression")),
            },
        }
    }

    /// Reads `{"constant": "e"}` or `{"constant": "π"}`.
    fn constant(&mut self, object: &Object<'a>) -> Option<ExprKind> {
        self.known(object, "a constant of mathematics", &["constant"])?;
        let name = self.named(object, "an expression", "constant")?;
        let value = match name.name.as_str() {
            "e" => std::f64::consts::E,
            "π" => std::f64::consts::PI,
            _ => return self.fail(name.span, format!("unknown constant \"{}\"", name.name)),
        };
        Some(ExprKind::Literal(value::Value::Real(value)))
    }

    /// Reads `left op right`; nested `∧`, and nested `∨`, are flattened.
    fn row(&mut self, object: &Object<'a>, op: &Ident, binary: BinaryOp) -> Option<ExprKind> {
        let associative = matches!(binary, BinaryOp::And | BinaryOp::Or);
        let mut operands = Vec::new();
        for operand in self.two(object, op)? {
            match operand.kind {
                ExprKind::Op(Op::Binary(inner), more) if associative && inner == binary => {
                    operands.extend(more);
                }
                _ => operands.push(operand),
            }
        }
        Some(ExprKind::Op(Op::Binary(binary), operands))
    }

    fn two(&mut self, object: &Object<'a>, op: &Ident) -> Option<Vec<Expr>> {
        let what = format!("\"{}\"", op.name);
        self.known(object, &what, &["op", "left", "right"])?;
        let left = self.operand(object, &what, "left");
        let right = self.operand(object, &what, "right");
        Some(vec![left?, right?])
    }

    fn one(&mut self, object: &Object<'a>, op: &Ident) -> Option<Vec<Expr>> {
        let what = format!("\"{}\"", op.name);
        self.known(object, &what, &["op", "exp"])?;
        Some(vec![self.operand(object, &what, "exp")?])
    }

    fn conditional(&mut self, object: &Object<'a>, op: &Ident) -> Option<ExprKind> {
        let what = format!("\"{}\"", op.name);
        self.known(object, &what, &["op", "if", "then", "else"])?;
        let parts = ["if", "then", "else"].map(|key| self.operand(object, &what, key));
        let [condition, then, otherwise] = parts;
        Some(ExprKind::Op(Op::Ite, vec![condition?, then?, otherwise?]))
    }

    fn call(&mut self, object: &Object<'a>) -> Option<ExprKind> {
        self.known(object, "a call", &["op", "function", "args"])?;
        let function = self.named(object, "a call", "function");
        let arguments = self.items(object.get("args"), "the arguments", Reader::expression);
        Some(ExprKind::Call(function?, arguments?))
    }
}
