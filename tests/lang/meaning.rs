//! The meaning of models once they are flat: precedence, renaming, constants, composition.

use meliora::advanced::lang::property::{
    Bound, Inequality, Measure, Named, Optimum, PropertyKind, Rewards, Strategies,
};
use meliora::lang::{flat, load, lower_target, parse_expression, parse_property, parse_state};
use meliora::model::value::Value;
use proptest::prelude::*;

use crate::common::prelude::*;

fn program_with(text: &str, constants: &str) -> Program {
    let loaded = load(&SourceFile::new("m.prism", text), &SourceFile::new("--const", constants));
    match loaded {
        Ok(checked) => checked.program,
        Err(error) => panic!("{error}\n{text}"),
    }
}

fn program(text: &str) -> Program {
    program_with(text, "")
}

/// The value of an expression in the initial state of a model; conditions only.
fn holds(model: &str, condition: &str) -> bool {
    let program = program(model);
    let source = SourceFile::new("--target", condition);
    let target = parse_expression(&source).expect("it parses");
    let target = lower_target(&program, &source, &target).expect("it is a condition");
    let state: Vec<i64> = program.variables.iter().map(|v| v.initial.unwrap_or(v.low)).collect();
    target.eval(&state) == Ok(Value::Bool(true))
}

/// The tree of an expression, with brackets everywhere.
fn tree(text: &str) -> String {
    use meliora::advanced::lang::ast::NodeKind;
    let mut stack: Vec<String> = Vec::new();
    for node in parse_expression(&SourceFile::new("e", text)).expect("it parses").nodes {
        let on = stack.split_off(stack.len() - node.kind.operands());
        let joined = |op: &str| {
            let rest = on[1..].iter();
            rest.fold(on[0].clone(), |left, right| format!("({left}{op}{right})"))
        };
        stack.push(match node.kind {
            NodeKind::Literal(value) => value.to_string(),
            NodeKind::Name(name) => name.to_string(),
            NodeKind::Label(name) => format!("\"{name}\""),
            NodeKind::Not => format!("(!{})", on[0]),
            NodeKind::Neg => format!("(-{})", on[0]),
            NodeKind::Binary(op) | NodeKind::Join(op, _) => joined(op.symbol()),
            NodeKind::Ite => format!("({}?{}:{})", on[0], on[1], on[2]),
            NodeKind::Call(function, _) => format!("{}({})", function.name, on.join(", ")),
            NodeKind::Apply(function, _) => format!("{}({})", function.name(), on.join(", ")),
            NodeKind::Operator(_) => unreachable!("no property"),
            NodeKind::Element | NodeKind::Array(_) | NodeKind::Comprehension(_) | NodeKind::Known(_) => {
                unreachable!("no JANI")
            }
        });
    }
    stack.pop().expect("there is a root")
}

#[test]
fn precedence_is_that_of_prism() {
    for (text, expected) in [
        ("!a=b", "(!(a=b))"),
        ("!a&b", "((!a)&b)"),
        ("!!a|b", "((!(!a))|b)"),
        ("a|b&c", "(a|(b&c))"),
        ("a=>b<=>c", "(a=>(b<=>c))"),
        ("a=>b=>c", "((a=>b)=>c)"),
        ("a<=>b<=>c", "((a<=>b)<=>c)"),
        ("a<=>b|c", "(a<=>(b|c))"),
        ("a=b!=c", "((a=b)!=c)"),
        ("a=b<c", "(a=(b<c))"),
        ("a+b<c*d", "((a+b)<(c*d))"),
        ("a-b-c", "((a-b)-c)"),
        ("a-b+c", "((a-b)+c)"),
        ("a/b*c", "((a/b)*c)"),
        ("-a*b", "((-a)*b)"),
        ("-a^b", "(-(a^b))"),
        ("a^-b*c", "((a^(-b))*c)"),
        ("a*b^c", "(a*(b^c))"),
        ("--a", "(-(-a))"),
        ("a--b", "(a-(-b))"),
        ("a?b:c?d:e", "(a?b:(c?d:e))"),
        ("a=>b?c:d+e", "((a=>b)?c:(d+e))"),
        ("a?b?c:d:e", "(a?(b?c:d):e)"),
        ("a&b=c|!d<e", "((a&(b=c))|(!(d<e)))"),
    ] {
        assert_eq!(tree(text), expected, "{text}");
    }
}

#[test]
fn functions_and_arithmetic_have_the_values_of_prism() {
    let model = "mdp\nmodule m\n x : [-3..8] init -3; y : [0..8] init 4;\nendmodule\n";
    for condition in [
        "mod(x-1,3)=2",
        "y/3 > 1.3 & y/3 < 1.4",
        "floor(y/3)=1 & ceil(y/3)=2 & round(y/8)=1 & round(-1.5)=-1",
        "min(x,y,2)=-3 & max(x,y,2)=4 & max(y,4.5)=4.5",
        "pow(2,3)=8 & pow(2,-1.0)=0.5 & 2^3=8 & 1-2^2=-3",
        "log(8,2) > 2.999 & log(8,2) < 3.001",
        "func(min,x,y)=x & func(floor,2.5)=2",
        "floor(y)=y",
        "y=4.0",
        "(x<0 ? 1 : 2.5) = 1",
        "true = (y=4)",
        "(false => true) & (y=4 <=> x=-3)",
    ] {
        assert!(holds(model, condition), "{condition}");
    }
}

#[test]
fn constants_depend_on_each_other_in_any_order() {
    let text = "mdp\nconst int a = b*2;\nconst b = c+1;\nconst int c;\nconst double d = a/4;\nformula f = a;\n\
                const int e = f;\nmodule m\n x : [0..a];\nendmodule";
    let program = program_with(text, "c=2");
    let values: Vec<String> = program.constants.iter().map(|(n, v)| format!("{n}={}", v.rounded())).collect();
    assert_eq!(values, ["a=6", "b=3", "c=2", "d=1.5", "e=6"]);
    assert_eq!(program.given_constants, ["c"]);
    assert_eq!(program.variables[0].high, 6);
}

#[test]
fn a_long_row_of_constants_and_formulas_is_no_problem() {
    let mut text = String::from("mdp\nconst int k0 = 1;\nformula f0 = x;\n");
    for i in 1..20_000 {
        text.push_str(&format!("const int k{i} = k{};\nformula f{i} = f{} & true;\n", i - 1, i - 1));
    }
    text.push_str("module m\n x : bool;\n [] f19999 -> (x'=k19999=1);\nendmodule");
    assert_eq!(program(&text).commands.len(), 1);
}

#[test]
fn formulas_that_double_stay_small() {
    let mut text = String::from("mdp\nformula f0 = x;\n");
    for i in 1..200 {
        text.push_str(&format!("formula f{i} = (f{0} ? y : f{0}) | (f{0} & y);\n", i - 1));
    }
    text.push_str("module m\n x : bool; y : bool;\n [] f199 -> true;\nendmodule");
    let program = program(&text);
    assert!(program.pool.len() < 2000);
    let again = flat(&program).unwrap();
    assert!(again.len() < 100_000);
    load(&SourceFile::new("flat", again), &SourceFile::new("--const", "")).expect("it reads back");
}

#[test]
fn a_long_disjunction_is_no_problem() {
    let many: Vec<String> = (0..50_000).map(|i| format!("x={i}")).collect();
    let text = format!("mdp\nmodule m\n x : [0..50000];\n [] {} -> true;\nendmodule", many.join("|"));
    assert_eq!(program(&text).commands.len(), 1);
}

#[test]
fn renaming_reaches_into_formulas_and_swaps() {
    let program = program(
        "mdp\nconst int lo = 1; const int hi = 2;\nformula f = x=lo & g;\nformula g = y=1;\nmodule m\n x : [0..3];\n \
         [go] f -> (x'=max(x,lo));\nendmodule\nmodule n = m [x=y, y=x, go=run, lo=hi, max=min] endmodule\n",
    );
    assert_eq!(program.actions, ["go", "run"]);
    let text = flat(&program).unwrap();
    assert!(text.contains("[go] x = 1 & y = 1 -> 1.0 : (x' = max(x, 1));"), "{text}");
    assert!(text.contains("[run] y = 2 & x = 1 -> 1.0 : (y' = min(y, 2));"), "{text}");
}

#[test]
fn a_formula_renamed_by_name_is_read_as_it_stands() {
    let program = program(
        "mdp\nformula f = x=1;\nformula g = x=2;\nmodule m\n x : [0..3];\n [] f -> true;\nendmodule\n\
         module n = m [x=y, f=g] endmodule\nmodule o = n [y=z] endmodule\n",
    );
    let text = flat(&program).unwrap();
    assert_eq!(text.matches("[] x = 2 -> 1.0 : true;").count(), 2, "{text}");
}

#[test]
fn a_copy_can_be_copied() {
    let program = program(
        "mdp\nmodule o = n [y=z, b=c] endmodule\nmodule n = m [x=y, a=b] endmodule\nmodule m\n x : [0..3];\n \
         [a] x<3 -> (x'=x+1);\nendmodule\n",
    );
    let names: Vec<_> = program.variables.iter().map(|v| v.name.as_str()).collect();
    assert_eq!(names, ["z", "y", "x"]);
    assert_eq!(program.actions, ["c", "b", "a"]);
}

/// Each synchronisation as `action: factors`, a factor as the numbers of its commands.
fn moves(system: &str) -> Vec<String> {
    let program = program(&format!(
        "mdp\nmodule a\n x : bool;\n [s] x -> true;\n [s] !x -> true;\n [t] x -> true;\n [] x -> true;\nendmodule\n\
         module b\n y : bool;\n [s] y -> true;\n [u] y -> true;\nendmodule\nmodule c\n z : bool;\n [t] z -> true;\n \
         [] z -> true;\nendmodule\n{system}"
    ));
    let show = |s: &meliora::model::Synchronisation| {
        let factor = |f: &Vec<meliora::model::CommandId>| {
            f.iter().map(|c| c.0.to_string()).collect::<Vec<_>>().join("|")
        };
        let action = s.action.map_or("", |a| program.actions[a].as_str());
        format!("{action}: {}", s.factors.iter().map(factor).collect::<Vec<_>>().join(" "))
    };
    program.synchronisations.iter().map(show).collect()
}

#[test]
fn a_composition_says_which_commands_move_together() {
    let all = [": 3", ": 7", "s: 0|1 4", "t: 2 6", "u: 5"];
    assert_eq!(moves(""), all);
    assert_eq!(moves("system a || b || c endsystem"), all);
    assert_eq!(moves("system (a || b) || c endsystem"), all);
    assert_eq!(
        moves("system a |[s]| b ||| c endsystem".replace("a |[s]| b", "(a |[s]| b)").as_str()),
        [": 3", ": 7", "s: 0|1 4", "t: 2", "t: 6", "u: 5"]
    );
    assert_eq!(moves("system a ||| b ||| c endsystem").len(), 8 - 1);
    assert_eq!(
        moves("system (a / {s}) || b || c endsystem"),
        [": 0|1", ": 3", ": 7", "s: 4", "t: 2 6", "u: 5"]
    );
    assert_eq!(moves("system (a || b {u<-t}) || c endsystem"), [": 3", ": 7", "s: 0|1 4", "t: 2 5 6"]);
    assert_eq!(moves("system (a |[t]| b) || c endsystem"), [": 3", ": 7", "s: 0|1", "s: 4", "u: 5"]);
    assert_eq!(
        moves("system (a || b || c) {s<-v, t<-w} endsystem"),
        [": 3", ": 7", "u: 5", "v: 0|1 4", "w: 2 6"]
    );
}

#[test]
fn commands_are_numbered_by_label() {
    let program =
        program("mdp\nmodule a\n [s] true -> true;\n [] true -> true;\n [s] true -> true;\nendmodule");
    let numbers: Vec<_> = program.commands.iter().map(|c| c.number).collect();
    assert_eq!(numbers, [1, 1, 2]);
}

#[test]
fn the_model_type_may_come_late_or_not_at_all() {
    use meliora::model::ModelKind;
    let of = |text: &str| program(text).kind;
    assert_eq!(of("module m endmodule"), ModelKind::Mdp);
    assert_eq!(of("const int N = 1;\ndtmc\nmodule m endmodule"), ModelKind::Dtmc);
    assert_eq!(of("probabilistic module m endmodule"), ModelKind::Dtmc);
    assert_eq!(of("nondeterministic module m endmodule"), ModelKind::Mdp);
}

#[test]
fn built_in_labels_can_be_targets() {
    let model = "mdp\nmodule m\n x : [0..2];\n [] x=0 -> (x'=1);\nendmodule\n";
    assert!(holds(model, "\"init\" & !\"deadlock\""));
    assert!(holds("mdp\nmodule m endmodule", "\"deadlock\" & \"init\""));
}

#[test]
fn a_state_takes_what_is_left_out_from_the_initial_state() {
    let program = program("mdp\nmodule m\n x : [-3..3] init 1; b : bool init true;\nendmodule");
    let state = |text: &str| parse_state(&SourceFile::new("--at", text), &program).ok();
    assert_eq!(state("x=-2"), Some(vec![-2, 1]));
    assert_eq!(state(" b = false "), Some(vec![1, 0]));
    assert_eq!(state(""), Some(vec![1, 1]));
}

/// Returns the question of a property that is one operator, for a model of one strategy.
fn question(text: &str) -> PropertyKind {
    let model =
        "dtmc module m x : [0..1]; endmodule label \"done\" = x=1; rewards \"cost\" true : 1; endrewards
        rewards true : 2; endrewards";
    let source = SourceFile::new("--property", text);
    let (property, program) = (parse_property(&source).expect("its syntax is right"), program(model));
    let term = property.term(&program, &source, &Named::default()).expect("it has a meaning");
    term.query(&program).expect("it is one operator").question
}

#[test]
fn properties_speak_of_all_or_some_strategies() {
    let of = |text: &str| match question(text) {
        PropertyKind::Qualitative(strategies, bound) => (strategies, bound),
        PropertyKind::Quantity(quantity) => panic!("{quantity:?}"),
    };
    assert_eq!(of("P>=1 [ F \"done\" ]"), (Strategies::All, Bound::One));
    assert_eq!(of("P>0 [ F x=1 ]"), (Strategies::All, Bound::Positive));
    assert_eq!(of("P<1 [ F x=1 ];"), (Strategies::All, Bound::BelowOne));
    assert_eq!(of("P<=0 [ F x=1 ]"), (Strategies::All, Bound::Zero));
    assert_eq!(of("Pmax>=1.0 [ F x=1 ]"), (Strategies::Some, Bound::One));
    assert_eq!(of("P max > 0 [ F x=1 ]"), (Strategies::Some, Bound::Positive));
    assert_eq!(of("Pmin>=1 [ F x=1 ]"), (Strategies::All, Bound::One));
    assert_eq!(of("Pmin<1 [ F x=1 ]"), (Strategies::Some, Bound::BelowOne));
    assert_eq!(of("Pmax<=0 [ F x=1 ]"), (Strategies::All, Bound::Zero));
}

#[test]
fn properties_ask_for_probabilities_and_rewards() {
    let of = |text: &str| match question(text) {
        PropertyKind::Quantity(q) => (q.measure, q.optimum, q.bound),
        qualitative => panic!("{qualitative:?}"),
    };
    let ratio = |n: i64, d: i64| Ratio::new(n.into(), d.into());
    let probability = |optimum, bound| (Measure::Probability, optimum, bound);
    assert_eq!(of("Pmax=? [ x=0 U x=1 ]"), probability(Optimum::Max, None));
    assert_eq!(of("P min =? [ F<=3 x=1 ]"), probability(Optimum::Min, None));
    assert_eq!(of("P=? [ F x=1 ]"), probability(Optimum::Max, None));
    assert_eq!(of("P>=0.9 [ F x=1 ]"), probability(Optimum::Min, Some((Inequality::Ge, ratio(9, 10)))));
    assert_eq!(of("P<0.5 [ F x=1 ]"), probability(Optimum::Max, Some((Inequality::Lt, ratio(1, 2)))));
    assert_eq!(of("Pmax>0.5 [ F x=1 ]"), probability(Optimum::Max, Some((Inequality::Gt, ratio(1, 2)))));
    assert_eq!(of("P>=0 [ F x=1 ]"), probability(Optimum::Min, Some((Inequality::Ge, ratio(0, 1)))));
    let reward = |rewards, optimum, bound| (Measure::Reward(rewards), optimum, bound);
    let named = Rewards::Named("cost".to_owned());
    assert_eq!(of("R{\"cost\"}min=? [ F x=1 ]"), reward(named, Optimum::Min, None));
    assert_eq!(of("R{2}max=? [ F x=1 ]"), reward(Rewards::Numbered(2), Optimum::Max, None));
    assert_eq!(of("Rmax=? [ F x=1 ]"), reward(Rewards::First, Optimum::Max, None));
    assert_eq!(
        of("R<=3 [ F x=1 ]"),
        reward(Rewards::First, Optimum::Max, Some((Inequality::Le, ratio(3, 1))))
    );
}

#[test]
fn actions_may_be_called_like_operators_of_properties() {
    let program = program(
        "mdp\nmodule m\n x : bool;\n [E] x -> true;\nendmodule\nmodule n = m [x=y, E=W] endmodule\n\
         system m ||| n {W<-S} endsystem",
    );
    assert_eq!(program.actions, ["E", "W", "S"]);
}

/// Returns for every reachable state the labels with the states that they lead to.
fn behaviour(text: &str) -> Vec<(State, Vec<String>)> {
    let program = Arc::new(program(text));
    let engine = ExplicitEngine::new(Arc::clone(&program), Settings::default()).expect("it is small");
    let states = engine.list_states(&engine.all_states(), usize::MAX).expect("it is small");
    let steps = |state: State| {
        let show = |step: &Step| {
            let action = match &step.choice {
                Choice::Combination { synchronisation, .. } => {
                    program.synchronisations[*synchronisation].action
                }
                _ => None,
            };
            let label = action.map_or("", |a| program.actions[a].as_str());
            format!("{label} {:?}", step.successors)
        };
        let mut steps: Vec<String> =
            program.steps(&state).expect("it has a meaning").iter().map(show).collect();
        steps.sort();
        (state, steps)
    };
    states.into_iter().map(steps).collect()
}

/// A composition of the modules `a`, `b` and `c`.
fn any_system() -> impl Strategy<Value = String> {
    let action = || prop::sample::select(vec!["s", "t", "u"]);
    let wrap = move |inner: String| {
        prop_oneof![
            3 => Just(inner.clone()),
            1 => action().prop_map({ let i = inner.clone(); move |x| format!("({i} / {{{x}}})") }),
            2 => (action(), action()).prop_map({ let i = inner.clone(); move |(x, y)| format!("({i} {{{x}<-{y}}})") }),
            1 => action().prop_map(move |x| format!("({inner} {{{x}<-new}})")),
        ]
    };
    let join = move |a: String, b: String| {
        prop_oneof![
            Just(format!("({a} || {b})")),
            Just(format!("({a} ||| {b})")),
            (action(), action()).prop_map(move |(x, y)| format!("({a} |[{x},{y}]| {b})")),
        ]
    };
    let leaf = move |name: &str| wrap(name.to_owned());
    let orders = vec![["a", "b", "c"], ["b", "c", "a"], ["c", "a", "b"]];
    prop::sample::select(orders)
        .prop_flat_map(move |[x, y, z]| (leaf(x), leaf(y), leaf(z)))
        .prop_flat_map(move |(x, y, z)| (join(x, y), Just(z)))
        .prop_flat_map(move |(xy, z)| (wrap(xy), Just(z)))
        .prop_flat_map(move |(xy, z)| join(xy, z))
        .prop_flat_map(wrap)
}

proptest! {
    #![proptest_config(meliora_amount::random(200))]

    #[test]
    fn a_composition_written_flat_reads_back_as_the_same(system in any_system()) {
        let text = format!(
            "mdp\nmodule a\n x : [0..2];\n [s] x<2 -> (x'=x+1);\n [s] x=2 -> 0.5 : (x'=0) + 0.5 : true;\n [t] x=1 -> (x'=2);\n \
             [] x=0 -> (x'=1);\nendmodule\nmodule b\n y : [0..2];\n [s] y<2 -> (y'=y+1);\n [u] y=1 -> (y'=0);\nendmodule\n\
             module c\n z : bool;\n [t] z -> (z'=false);\n [u] !z -> (z'=true);\n [] z -> (z'=false);\nendmodule\n\
             system {system} endsystem"
        );
        let source = SourceFile::new("m", text.clone());
        prop_assume!(load(&source, &SourceFile::new("--const", "")).is_ok());
        let again = flat(&program(&text)).unwrap();
        prop_assert_eq!(behaviour(&text), behaviour(&again), "{}\n{}", system, again);
    }
}

#[test]
fn a_carriage_return_ends_a_line() {
    let text = "mdp // a type\rmodule m // a module\r x : [0..3];\r [] x<3 -> (x'=x+1);\rendmodule";
    assert_eq!(program(text).commands.len(), 1);
    assert_eq!(program(&format!("\u{feff}{}", text.replace('\r', "\r\n"))).commands.len(), 1);
}

#[test]
fn an_arrow_to_the_left_is_a_comparison_in_expressions() {
    let program = program("mdp\nformula f = x<-1;\nmodule m\n x : [-3..3];\n [] f -> (x'=-x);\nendmodule");
    assert_eq!(program.pool.eval(program.commands[0].guard, &[-2]), Ok(Value::Bool(true)));
    assert_eq!(program.pool.eval(program.commands[0].guard, &[-1]), Ok(Value::Bool(false)));
}

#[test]
fn what_is_observable_is_read_and_ignored() {
    let text = "mdp\nobservables x, y endobservables\nobservable \"high\" = x>2;\nmodule m\n x : [0..3];\n y : bool;\n \
                [] x<3 -> (x'=x+1);\nendmodule";
    assert_eq!(program(text).variables.len(), 2);
}

#[test]
fn probabilities_that_were_rounded_are_a_distribution_with_a_warning() {
    for (command, enabled) in [
        ("[] x=0 -> 0.333333 : (x'=1) + 0.333333 : (x'=2) + 0.333333 : (x'=3)", true),
        ("[] x=0 -> (x+1)*0.4999996 : (x'=1) + 0.5 : (x'=2)", true),
        ("[] x=0 -> 1/3 : (x'=1) + 1/3 : (x'=2) + 1/3 : (x'=3)", false),
        ("[] x=0 -> true;\n [] x=1 -> 0.333333 : (x'=1) + 0.666666 : (x'=2)", false),
    ] {
        let program = Arc::new(program(&format!("mdp\nmodule m\n x : [0..3];\n {command};\nendmodule")));
        let explicit =
            ExplicitEngine::new(Arc::clone(&program), Settings::default()).expect("it has a meaning");
        let symbolic = SymbolicEngine::new(Arc::clone(&program), Settings::default());
        let expected = enabled.then(|| vec![0]);
        assert_eq!(explicit.rounded_state(), expected.as_ref(), "{command}");
        assert_eq!(symbolic.expect("it has a meaning").rounded_state(), expected.as_ref(), "{command}");
        assert_eq!(program.rounded_in(&[0]).is_some(), enabled, "{command}");
    }
}
