//! A written expression is read back as the same tree.

use meliora::advanced::lang::ast::*;
use meliora::lang::parse_expression;
use meliora::model::value::Value;
use proptest::collection::vec;
use proptest::prelude::*;

use crate::common::prelude::*;

const LEVELS: &[&[BinaryOp]] = &[
    &[BinaryOp::Implies],
    &[BinaryOp::Iff],
    &[BinaryOp::Or],
    &[BinaryOp::And],
    &[BinaryOp::Eq, BinaryOp::Ne],
    &[BinaryOp::Lt, BinaryOp::Le, BinaryOp::Gt, BinaryOp::Ge],
    &[BinaryOp::Add, BinaryOp::Sub],
    &[BinaryOp::Mul, BinaryOp::Div],
    &[BinaryOp::Pow],
];

/// An expression to write. A chain has operators of one level.
#[derive(Debug, Clone)]
enum Written {
    Leaf(NodeKind, String),
    Prefix(NodeKind, Box<Written>),
    Chain(Box<Written>, Vec<(BinaryOp, Written)>),
    Ite(Box<[Written; 3]>),
    Call(String, Vec<Written>),
}

impl Written {
    /// The precedence level of the outermost operator, `None` for `?:`, which binds least.
    fn level(&self) -> Option<u8> {
        match self {
            Written::Ite(_) => None,
            Written::Chain(_, rest) => Some(rest[0].0.level()),
            Written::Prefix(NodeKind::Not, _) => Some(NOT_LEVEL),
            Written::Prefix(..) => Some(NEG_LEVEL),
            Written::Leaf(..) | Written::Call(..) => Some(ATOM_LEVEL),
        }
    }

    /// The text, in brackets unless it binds at least as tightly as `least`.
    fn at(&self, least: u8) -> String {
        if self.level().is_some_and(|level| level >= least) {
            self.text()
        } else {
            format!("({})", self.text())
        }
    }

    /// The text with brackets only where they are needed.
    fn text(&self) -> String {
        match self {
            Written::Leaf(_, text) => text.clone(),
            Written::Prefix(NodeKind::Not, e) => format!("!{}", e.at(NOT_LEVEL)),
            Written::Prefix(_, e) => format!("-{}", e.at(NEG_LEVEL)),
            Written::Chain(first, rest) => {
                let least = rest[0].0.level() + 1;
                let link = |(op, e): &(BinaryOp, Written)| format!(" {} {}", op.symbol(), e.at(least));
                first.at(least) + &rest.iter().map(link).collect::<String>()
            }
            Written::Ite(parts) => {
                let [c, a, b] = &**parts;
                let b = if b.level().is_none() { b.text() } else { b.at(0) };
                format!("{} ? {} : {b}", c.at(0), a.at(0))
            }
            Written::Call(name, arguments) => {
                format!("{name}({})", arguments.iter().map(Written::text).collect::<Vec<_>>().join(", "))
            }
        }
    }

    /// Adds the nodes that the text stands for.
    fn nodes(&self, nodes: &mut Vec<Node>) {
        let kind = match self {
            Written::Leaf(kind, _) => kind.clone(),
            Written::Prefix(kind, e) => {
                e.nodes(nodes);
                kind.clone()
            }
            Written::Chain(first, rest) => {
                first.nodes(nodes);
                let join = matches!(rest[0].0, BinaryOp::And | BinaryOp::Or);
                for (index, (op, e)) in rest.iter().enumerate() {
                    e.nodes(nodes);
                    if !join && index + 1 < rest.len() {
                        nodes.push(Node { kind: NodeKind::Binary(*op), span: span() });
                    }
                }
                let last = rest[rest.len() - 1].0;
                if join { NodeKind::Join(last, rest.len() as u32 + 1) } else { NodeKind::Binary(last) }
            }
            Written::Ite(parts) => {
                parts.iter().for_each(|e| e.nodes(nodes));
                NodeKind::Ite
            }
            Written::Call(name, arguments) => {
                arguments.iter().for_each(|e| e.nodes(nodes));
                let function = Ident { name: name.clone(), span: span() };
                NodeKind::Call(Box::new(function), arguments.len() as u32)
            }
        };
        nodes.push(Node { kind, span: span() });
    }
}

fn span() -> Span {
    Span::default()
}

fn name() -> impl Strategy<Value = String> + Clone {
    let names = vec!["x", "y", "z1", "_a", "foo", "Bar", "endmodules", "trueish"];
    prop::sample::select(names).prop_map(str::to_owned).boxed()
}

fn chain(e: impl Strategy<Value = Written> + Clone + 'static) -> impl Strategy<Value = Written> {
    prop::sample::select(LEVELS.to_vec()).prop_flat_map(move |ops| {
        let link = (prop::sample::select(ops.to_vec()), e.clone());
        let most = if ops == [BinaryOp::Pow] { 2 } else { 4 };
        (e.clone(), vec(link, 1..most)).prop_map(|(first, rest)| Written::Chain(Box::new(first), rest))
    })
}

fn literal(value: Value) -> Written {
    let text = if let Value::Real(x) = value { format!("{x:?}") } else { value.to_string() };
    Written::Leaf(NodeKind::Literal(value), text)
}

fn expr() -> impl Strategy<Value = Written> + Clone {
    let leaf = prop_oneof![
        any::<bool>().prop_map(|b| literal(Value::Bool(b))),
        (0..i64::MAX).prop_map(|i| literal(Value::Int(i))),
        (0.0..1e300f64).prop_map(|x| literal(Value::Real(x))),
        prop::num::f64::POSITIVE
            .prop_filter("finite", |x| x.is_finite())
            .prop_map(|x| literal(Value::Real(x))),
        name().prop_map(|n| Written::Leaf(NodeKind::Name(n.as_str().into()), n)),
        name().prop_map(|n| Written::Leaf(NodeKind::Label(n.as_str().into()), format!("\"{n}\""))),
    ];
    leaf.prop_recursive(5, 40, 4, |e| {
        let builtin = prop::sample::select(vec!["min", "max", "floor", "mod"]).prop_map(str::to_owned);
        let function = prop_oneof![name(), builtin];
        prop_oneof![
            4 => chain(e.clone()),
            1 => e.clone().prop_map(|a| Written::Prefix(NodeKind::Not, Box::new(a))),
            1 => e.clone().prop_map(|a| Written::Prefix(NodeKind::Neg, Box::new(a))),
            1 => [e.clone(), e.clone(), e.clone()].prop_map(|parts| Written::Ite(Box::new(parts))),
            1 => (function, vec(e, 1..4)).prop_map(|(f, args)| Written::Call(f, args)),
        ]
    })
    .boxed()
}

proptest! {
    #![proptest_config(meliora_amount::random(64))]

    #[test]
    fn an_expression_reads_back(e in expr()) {
        let mut expected = Expr::default();
        e.nodes(&mut expected.nodes);
        let text = e.text();
        let again = parse_expression(&SourceFile::new("e", text.clone()));
        prop_assert_eq!(again.ok(), Some(expected), "{}", text);
    }
}
