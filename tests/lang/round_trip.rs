//! Printing and reading again gives the same tree; broken text never panics.

use meliora::error::SourceFile;
use meliora::lang::ast::*;
use meliora::lang::{flat, load, parse_expression, parse_model, parse_preferences, parse_property};
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;

fn span() -> Span {
    Span::default()
}

fn at(kind: ExprKind) -> Expr {
    Expr { kind, span: span() }
}

fn ident() -> impl Strategy<Value = Ident> {
    prop::sample::select(vec!["x", "y", "z1", "_a", "foo", "Bar", "endmodules", "trueish"])
        .prop_map(|name| Ident { name: name.to_owned(), span: span() })
}

const LEVELS: &[&[BinaryOp]] = &[
    &[BinaryOp::Implies],
    &[BinaryOp::Iff],
    &[BinaryOp::Or],
    &[BinaryOp::And],
    &[BinaryOp::Eq, BinaryOp::Ne],
    &[BinaryOp::Lt, BinaryOp::Le, BinaryOp::Gt, BinaryOp::Ge],
    &[BinaryOp::Add, BinaryOp::Sub],
    &[BinaryOp::Mul, BinaryOp::Div],
];

fn chain(e: impl Strategy<Value = Expr> + Clone + 'static) -> impl Strategy<Value = Expr> {
    let level = prop::sample::select(LEVELS.to_vec());
    level.prop_flat_map(move |ops| {
        let link = (prop::sample::select(ops.to_vec()), e.clone());
        (e.clone(), vec(link, 1..4)).prop_map(|(first, rest)| at(ExprKind::Chain(Box::new(first), rest)))
    })
}

fn expr() -> impl Strategy<Value = Expr> + Clone {
    let leaf = prop_oneof![
        any::<bool>().prop_map(|b| at(ExprKind::Bool(b))),
        (0..i64::MAX).prop_map(|i| at(ExprKind::Int(i))),
        (0.0..1e300f64).prop_map(|x| at(ExprKind::Real(x))),
        prop::num::f64::POSITIVE.prop_filter("finite", |x| x.is_finite()).prop_map(|x| at(ExprKind::Real(x))),
        ident().prop_map(|i| at(ExprKind::Name(i.name))),
        ident().prop_map(|i| at(ExprKind::Label(i.name))),
    ];
    leaf.prop_recursive(5, 40, 4, |e| {
        let function = prop_oneof![
            ident(),
            prop::sample::select(vec!["min", "max", "floor", "mod"])
                .prop_map(|name| Ident { name: name.to_owned(), span: span() })
        ];
        prop_oneof![
            4 => chain(e.clone()),
            1 => e.clone().prop_map(|a| at(ExprKind::Not(Box::new(a)))),
            1 => e.clone().prop_map(|a| at(ExprKind::Neg(Box::new(a)))),
            1 => (e.clone(), e.clone()).prop_map(|(a, b)| {
                at(ExprKind::Chain(Box::new(a), vec![(BinaryOp::Pow, b)]))
            }),
            1 => (vec((e.clone(), e.clone()), 1..3), e.clone())
                .prop_map(|(cases, last)| at(ExprKind::Ite(cases, Box::new(last)))),
            1 => (function, vec(e, 1..4)).prop_map(|(f, args)| at(ExprKind::Call(Box::new(f), args))),
        ]
    })
    .boxed()
}

fn system() -> impl Strategy<Value = System> {
    let make = |kind| System { kind, span: span() };
    ident().prop_map(move |i| make(SystemKind::Module(i.name))).prop_recursive(4, 20, 3, move |s| {
        prop_oneof![
            vec(s.clone(), 2..4).prop_map(move |v| make(SystemKind::Full(v))),
            vec(s.clone(), 2..4).prop_map(move |v| make(SystemKind::Interleaved(v))),
            (s.clone(), vec(ident(), 1..3), s.clone())
                .prop_map(move |(a, on, b)| make(SystemKind::Parallel(Box::new(a), on, Box::new(b)))),
            (s.clone(), vec(ident(), 1..3)).prop_map(move |(a, h)| make(SystemKind::Hide(Box::new(a), h))),
            (s, vec((ident(), ident()), 1..3))
                .prop_map(move |(a, r)| make(SystemKind::Rename(Box::new(a), r))),
        ]
    })
}

fn variable() -> impl Strategy<Value = VarDecl> {
    (ident(), option::of((expr(), expr())), option::of(expr())).prop_map(|(name, range, init)| VarDecl {
        name,
        range,
        init,
        span: span(),
    })
}

fn command() -> impl Strategy<Value = Command> {
    let assignment = (ident(), expr()).prop_map(|(variable, value)| Assignment { variable, value });
    let updates = vec(assignment, 0..3).boxed();
    let alone = updates.clone().prop_map(|updates| vec![Branch { probability: None, updates, span: span() }]);
    let several = vec((expr(), updates), 1..3).prop_map(|all| {
        all.into_iter().map(|(p, updates)| Branch { probability: Some(p), updates, span: span() }).collect()
    });
    (option::of(ident()), expr(), prop_oneof![alone, several]).prop_map(|(action, guard, branches)| Command {
        action,
        guard,
        branches,
        span: span(),
    })
}

fn item() -> impl Strategy<Value = Item> {
    let ty = prop::sample::select(vec![ConstType::Int, ConstType::Double, ConstType::Bool]);
    let reward = (option::of(option::of(ident())), expr(), expr())
        .prop_map(|(action, guard, value)| RewardItem { action, guard, value });
    prop_oneof![
        (ty, ident(), option::of(expr())).prop_map(|(ty, name, value)| Item::Const(ConstDef {
            ty,
            name,
            value
        })),
        (ident(), expr()).prop_map(|(name, body)| Item::Formula(FormulaDef { name, body })),
        (ident(), expr()).prop_map(|(name, body)| Item::Label(LabelDef { name, body })),
        variable().prop_map(|v| Item::Global(Box::new(v))),
        (ident(), vec(variable(), 0..3), vec(command(), 0..3)).prop_map(|(name, variables, commands)| {
            Item::Module(Box::new(Module { name, variables, commands }))
        }),
        (ident(), ident(), vec((ident(), ident()), 1..4))
            .prop_map(|(name, base, renames)| Item::Renamed(Box::new(RenamedModule { name, base, renames }))),
        (option::of(ident()), vec(reward, 0..3)).prop_map(|(name, items)| Item::Rewards(Box::new(Rewards {
            name,
            items,
            span: span()
        }))),
        expr().prop_map(Item::Init),
        system().prop_map(|s| Item::System(Box::new(s))),
    ]
}

fn model() -> impl Strategy<Value = Model> {
    let kind = option::of(prop::sample::select(vec![(ModelType::Mdp, span()), (ModelType::Dtmc, span())]));
    (kind, vec(item(), 0..5)).prop_map(|(kind, items)| Model { kind, items })
}

/// Two texts that read otherwise than they were meant, in PRISM too: a label in front of a reward item
/// without `[…]` is the name of the structure, and `true + …` in front of a branch is an update.
fn ambiguous(model: &Model) -> bool {
    fn starts_with_label(e: &Expr) -> bool {
        e.to_string().starts_with('"')
    }
    model.items.iter().any(|item| match item {
        Item::Rewards(r) => {
            r.name.is_none()
                && r.items.first().is_some_and(|i| i.action.is_none() && starts_with_label(&i.guard))
        }
        Item::Module(m) => m
            .commands
            .iter()
            .flat_map(|c| &c.branches)
            .any(|b| b.probability.as_ref().is_some_and(|p| p.to_string().starts_with("true +"))),
        _ => false,
    })
}

const SEED: &str = "mdp\nconst int N = 3; // size\nconst double p = 0.5;\nglobal g : [0..1];\nformula f = x<N & !(g=1);\n\
    label \"done\" = x=N | y;\nmodule m\n x : [0..N] init 1;\n y : bool;\n [a] f -> p : (x'=min(x+1,N)) + 1-p : (y'=!y);\n \
    [] x=N -> true;\nendmodule\nmodule n = m [x=z, y=w, a=b] endmodule\nrewards \"r\" [a] true : x/2; endrewards\n\
    system (m / {a}) ||| n {b<-c} endsystem\n";

/// The models and preference files that come with the program.
fn shipped() -> Vec<String> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    let entries = std::fs::read_dir(folder).expect("the folder is there");
    let mut paths: Vec<_> =
        entries.map(|e| e.expect("it can be listed").path()).filter(|p| p.is_file()).collect();
    paths.sort();
    let texts = paths.iter().map(|p| std::fs::read_to_string(p).expect("it is text"));
    texts.filter(|t| !t.is_empty()).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn an_expression_reads_back(e in expr()) {
        let text = e.to_string();
        let again = parse_expression(&SourceFile::new("e", text.clone()));
        prop_assert_eq!(again.ok(), Some(e), "{}", text);
    }

    #[test]
    fn a_model_reads_back(m in model()) {
        prop_assume!(!ambiguous(&m));
        let text = m.to_string();
        match parse_model(&SourceFile::new("m", text.clone())) {
            Ok(again) => prop_assert_eq!(again, m, "{}", text),
            Err(error) => prop_assert!(false, "{}\n{}", error, text),
        }
    }

    #[test]
    fn a_checked_model_never_panics(m in model()) {
        let text = m.to_string();
        if let Ok(checked) = load(&SourceFile::new("m", text), &SourceFile::new("c", "")) {
            flat(&checked.program).unwrap();
        }
    }

    #[test]
    fn edited_bytes_never_panic(edits in vec((0..SEED.len(), any::<u8>(), 0..3u8), 1..6)) {
        let mut bytes = SEED.as_bytes().to_vec();
        for (at, byte, how) in edits {
            let at = at.min(bytes.len().saturating_sub(1));
            match how {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                _ => { bytes.remove(at); }
            }
        }
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let source = SourceFile::new("m", text);
        if let Err(meliora::error::Error::Input(all)) = load(&source, &SourceFile::new("c", "")) {
            meliora::error::render(&all, true);
        }
    }

    #[test]
    fn edited_models_never_panic(
        which in any::<prop::sample::Index>(),
        edits in vec((any::<prop::sample::Index>(), any::<u8>(), 0..3u8), 1..6),
    ) {
        let texts = shipped();
        let mut bytes = which.get(&texts).clone().into_bytes();
        for (at, byte, how) in edits {
            let at = at.index(bytes.len());
            match how {
                0 => bytes[at] = byte,
                1 => bytes.insert(at, byte),
                _ => { bytes.remove(at); }
            }
        }
        let source = SourceFile::new("m", String::from_utf8_lossy(&bytes).into_owned());
        let _ = (load(&source, &SourceFile::new("c", "")), parse_preferences(&source));
    }

    #[test]
    fn cut_text_never_panics(from in 0..SEED.len(), to in 0..SEED.len()) {
        let text = SEED.get(from.min(to)..from.max(to)).unwrap_or("");
        let source = SourceFile::new("m", text);
        let _ = (parse_model(&source), parse_preferences(&source), parse_property(&source), parse_expression(&source));
    }
}

#[test]
fn the_seed_is_a_model() {
    load(&SourceFile::new("m", SEED), &SourceFile::new("c", "")).expect("it is right");
}
