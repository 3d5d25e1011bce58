//! A written text is read back as the same tree; broken text never panics.

use meliora::advanced::lang::ast::*;
use meliora::lang::{flat, load, parse_expression};
use meliora::model::value::Value;
use proptest::collection::vec;
use proptest::option;
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

fn text() -> impl Strategy<Value = String> + Clone {
    expr().prop_map(|e| e.text()).boxed()
}

fn names(most: usize) -> impl Strategy<Value = String> + Clone {
    vec(name(), 1..most).prop_map(|all| all.join(", ")).boxed()
}

fn pairs(sign: &'static str) -> impl Strategy<Value = String> + Clone {
    let pair = (name(), name()).prop_map(move |(old, new)| format!("{old} {sign} {new}"));
    vec(pair, 1..4).prop_map(|all| all.join(", ")).boxed()
}

/// A composition as text, and true if it needs brackets as an operand.
fn system() -> impl Strategy<Value = (String, bool)> {
    name().prop_map(|n| (n, false)).prop_recursive(4, 20, 3, |s| {
        let operand = s.prop_map(|(text, open)| if open { format!("({text})") } else { text }).boxed();
        prop_oneof![
            vec(operand.clone(), 2..4).prop_map(|v| (v.join(" || "), true)),
            vec(operand.clone(), 2..4).prop_map(|v| (v.join(" ||| "), true)),
            (operand.clone(), names(3), operand.clone())
                .prop_map(|(a, on, b)| (format!("{a} |[{on}]| {b}"), true)),
            (operand.clone(), names(3)).prop_map(|(a, hidden)| (format!("{a} / {{{hidden}}}"), false)),
            (operand, pairs("<-")).prop_map(|(a, renames)| (format!("{a} {{{renames}}}"), false)),
        ]
    })
}

fn variable() -> impl Strategy<Value = String> {
    let init = option::of(text()).prop_map(|e| e.map_or(String::new(), |e| format!(" init {e}")));
    (name(), option::of((text(), text())), init).prop_map(|(name, range, init)| match range {
        Some((low, high)) => format!("{name} : [{low}..{high}]{init};"),
        None => format!("{name} : bool{init};"),
    })
}

fn command() -> impl Strategy<Value = String> {
    let assignment = (name(), text()).prop_map(|(variable, value)| format!("({variable}' = {value})"));
    let updates = vec(assignment, 0..3)
        .prop_map(|all| if all.is_empty() { "true".to_owned() } else { all.join(" & ") })
        .boxed();
    let branch = (text(), updates.clone()).prop_map(|(p, updates)| format!("{p} : {updates}"));
    let several = vec(branch, 1..3).prop_map(|all| all.join(" + "));
    (option::of(name()), text(), prop_oneof![updates, several]).prop_map(|(action, guard, branches)| {
        format!("[{}] {guard} -> {branches};", action.unwrap_or_default())
    })
}

fn reward() -> impl Strategy<Value = String> {
    (option::of(option::of(name())), text(), text()).prop_map(|(action, guard, value)| {
        let action = action.map_or(String::new(), |a| format!("[{}] ", a.unwrap_or_default()));
        format!("    {action}{guard} : {value};\n")
    })
}

fn item() -> impl Strategy<Value = String> {
    let lines = |lines: Vec<String>| lines.iter().map(|l| format!("    {l}\n")).collect::<String>();
    let value = option::of(text()).prop_map(|e| e.map_or(String::new(), |e| format!(" = {e}")));
    prop_oneof![
        (prop::sample::select(vec!["int", "double", "bool"]), name(), value)
            .prop_map(|(ty, name, value)| format!("const {ty} {name}{value};")),
        (name(), text()).prop_map(|(name, e)| format!("formula {name} = {e};")),
        (name(), text()).prop_map(|(name, e)| format!("label \"{name}\" = {e};")),
        variable().prop_map(|v| format!("global {v}")),
        (name(), vec(variable(), 0..3), vec(command(), 0..3)).prop_map(move |(name, variables, commands)| {
            format!("module {name}\n{}{}endmodule", lines(variables), lines(commands))
        }),
        (name(), name(), pairs("="))
            .prop_map(|(name, base, renames)| format!("module {name} = {base} [{renames}] endmodule")),
        (option::of(name()), vec(reward(), 0..3)).prop_map(|(name, items)| {
            let name = name.map_or(String::new(), |n| format!(" \"{n}\""));
            format!("rewards{name}\n{}endrewards", items.concat())
        }),
        text().prop_map(|e| format!("init {e} endinit")),
        system().prop_map(|(s, _)| format!("system {s} endsystem")),
        (name(), vec(name(), 0..3), vec(name(), 1..3)).prop_map(|(name, modules, actions)| {
            let items = modules.into_iter().chain(actions.into_iter().map(|action| format!("[{action}]")));
            format!("player {name} {} endplayer", items.collect::<Vec<_>>().join(", "))
        }),
    ]
}

fn model() -> impl Strategy<Value = String> {
    let kind = prop::sample::select(vec!["", "mdp\n", "dtmc\n", "smg\n"]);
    let items = vec(item().prop_map(|i| i + "\n"), 0..5);
    (kind, items).prop_map(|(kind, items)| kind.to_owned() + &items.concat())
}

proptest! {
    #![proptest_config(crate::common::amount::random(64))]

    #[test]
    fn an_expression_reads_back(e in expr()) {
        let mut expected = Expr::default();
        e.nodes(&mut expected.nodes);
        let text = e.text();
        let again = parse_expression(&SourceFile::new("e", text.clone()));
        prop_assert_eq!(again.ok(), Some(expected), "{}", text);
    }

    #[test]
    fn a_checked_model_never_panics(text in model()) {
        if let Ok(checked) = load(&SourceFile::new("m", text), &SourceFile::new("c", "")) {
            flat(&checked.program).unwrap();
        }
    }
}
