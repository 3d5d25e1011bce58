use meliora_base::error::SourceFile;
use meliora_base::progress::NoProgress;
use meliora_base::value::Value;
use meliora_lang as lang;
use meliora_model::{Program, State};
use proptest::prelude::*;

use super::Search;

fn program(text: &str) -> Program {
    let source = SourceFile::new("m", text);
    lang::load(&source, &SourceFile::new("constants", "")).unwrap().program
}

/// The initial states of a model in the order in which they are found, with the work.
fn found(text: &str, most: u64) -> (Vec<State>, u64, bool) {
    let program = program(text);
    let mut search = Search::new(&program, program.initial, &NoProgress).unwrap();
    let mut states = Vec::new();
    let is_over = search.run(most, &NoProgress, &mut |state| {
        states.push(state.to_vec());
        Ok(())
    });
    (states, search.work, is_over.unwrap())
}

/// A model with variables and a condition for the initial states.
fn model(variables: &str, condition: &str) -> String {
    format!("mdp module m {variables} [] true -> true; endmodule init {condition} endinit")
}

#[track_caller]
fn assert_work(variables: &str, condition: &str, states: usize, most: u64) {
    let (found, work, is_over) = found(&model(variables, condition), 1 << 20);
    assert!(is_over && found.len() == states, "{} states of {condition}", found.len());
    assert!(work <= most, "{condition}: {work}");
}

#[test]
fn conditions_that_are_no_conjunctions_need_few_steps() {
    let square = "x:[0..1000000]; y:[0..1000000];";
    assert_work(square, "x=2 & y=0 | x=1 & y=1", 2, 200);
    assert_work(square, "!(x!=7 | y!=123456)", 1, 100);
    assert_work(square, "max(x,y)=3", 7, 1000);
    assert_work(square, "x+y=2", 3, 500);
    assert_work(square, "(x>5 ? y : x)=2 & x<9 & y<3", 6, 1000);
    assert_work("x:[0..1000]; y:[0..1000];", "x*y=12", 6, 30_000);
    assert_work(square, "x/10<0.3 & 0.5*y<=1", 9, 2000);
    assert_work(square, "floor(x/1000)=0 & pow(y,1)=3 & y<4", 1000, 100_000);
    assert_work(square, "x=y & x<1000 & mod(x,10)=3", 100, 100_000);
    assert_work(square, "x=3*y+1 & y>=333000", 334, 100_000);
    assert_work(square, "x<2 & (x=0 <=> y=7) & (x=1 => y=9)", 2, 500);
}

#[test]
fn sums_of_booleans_are_not_enumerated() {
    let numbers: Vec<String> = (0..200).map(|i| format!("q{i}")).collect();
    let variables: String = numbers.iter().map(|q| format!("{q}:[0..1];")).collect();
    assert_work(&variables, &format!("{}=1", numbers.join("+")), 200, 50_000);
    assert_work(&variables, &format!("{}=199", numbers.join("+")), 200, 50_000);
    let few: Vec<String> = numbers[..30].to_vec();
    let variables: String = few.iter().map(|q| format!("{q}:[0..1];")).collect();
    assert_work(&variables, &format!("{}=2", few.join("+")), 435, 20_000);
}

#[test]
fn a_list_of_states_is_searched_in_time_linear_in_its_length() {
    let work = |n: usize| {
        let state = |i: usize| format!("x={} & y={}", i * 7919 % 100_000, i * 104_729 % 100_000);
        let list: Vec<String> = (0..n).map(state).collect();
        let (states, work, is_over) = found(&model("x:[0..99999]; y:[0..99999];", &list.join("|")), u64::MAX);
        assert!(is_over && states.len() == n);
        work
    };
    assert!(work(2000) < 3 * work(1000));
}

#[test]
fn a_search_can_be_interrupted_and_continued() {
    let text = model("x:[0..99]; y:[0..99];", "x+y=7 | x=99 & y>90 | mod(x*y,11)=5");
    let (all, work, _) = found(&text, u64::MAX);
    let (first, done, is_over) = found(&text, work / 2);
    assert!(!is_over && done >= work / 2 && done < work);
    assert_eq!(first, all[..first.len()]);
    let program = program(&text);
    let mut search = Search::new(&program, program.initial, &NoProgress).unwrap();
    let (mut states, mut most) = (Vec::new(), 0);
    let mut add = |state: &[i64]| {
        states.push(state.to_vec());
        Ok(())
    };
    while !search.run(most, &NoProgress, &mut add).unwrap() {
        most += 3;
    }
    assert_eq!((states, search.work), (all, work));
}

/// A random condition over integers and Booleans that PRISM accepts, some without a value in some states.
fn condition() -> impl Strategy<Value = String> {
    let number = prop_oneof![
        Just("x".to_owned()),
        Just("y".to_owned()),
        Just("z".to_owned()),
        (-3..5i64).prop_map(|i| format!("({i})")),
        Just("9223372036854775807".to_owned()),
    ];
    let number = number.prop_recursive(3, 12, 3, |inner| {
        let two = (inner.clone(), inner.clone());
        prop_oneof![
            (prop::sample::select(&["+", "-", "*"][..]), two.clone())
                .prop_map(|(op, (a, b))| format!("({a}{op}{b})")),
            (prop::sample::select(&["min", "max", "mod", "pow"][..]), two.clone())
                .prop_map(|(op, (a, b))| format!("{op}({a},{b})")),
            (prop::sample::select(&["floor", "ceil", "round"][..]), two.clone())
                .prop_map(|(op, (a, b))| format!("{op}({a}/{b})")),
            (inner.clone(), two.clone()).prop_map(|(c, (a, b))| format!("({c}>0?{a}:{b})")),
            inner.prop_map(|a| format!("(-{a})")),
        ]
    });
    let compared = (prop::sample::select(&["=", "!=", "<", "<=", ">", ">="][..]), number.clone(), number);
    let atom = prop_oneof![
        4 => compared.clone().prop_map(|(op, a, b)| format!("{a}{op}{b}")),
        1 => compared.prop_map(|(op, a, b)| format!("0.5*{a}{op}{b}/3+0.25")),
        1 => Just("b".to_owned()),
        1 => prop::bool::ANY.prop_map(|b| b.to_string()),
    ];
    atom.prop_recursive(4, 24, 3, |inner| {
        let two = (prop::sample::select(&["&", "|", "=>", "<=>", "="][..]), inner.clone(), inner.clone());
        prop_oneof![
            3 => two.prop_map(|(op, a, b)| format!("(({a}) {op} ({b}))")),
            1 => inner.clone().prop_map(|a| format!("!({a})")),
            1 => (inner.clone(), inner.clone(), inner).prop_map(|(c, a, b)| format!("(({c})?({a}):({b}))")),
        ]
    })
}

proptest! {
    #![proptest_config(meliora_amount::random(2000))]

    /// Each state in which the condition is true is found exactly once.
    #[test]
    fn random_conditions_have_the_states_of_brute_force(condition in condition()) {
        let text = model("x:[-2..6]; y:[0..5]; z:[3..3]; b:bool;", &condition);
        let source = SourceFile::new("m", text);
        // Some conditions are refused, such as those that have no value in any state.
        let Ok(checked) = lang::load(&source, &SourceFile::new("constants", "")) else { return Ok(()) };
        let program = checked.program;
        let mut search = Search::new(&program, program.initial, &NoProgress).unwrap();
        let mut states: Vec<State> = Vec::new();
        let is_over = search.run(u64::MAX, &NoProgress, &mut |state| {
            states.push(state.to_vec());
            Ok(())
        });
        prop_assert!(is_over.unwrap());
        states.sort_unstable();
        let mut expected = Vec::new();
        for x in -2..=6 {
            for y in 0..=5 {
                for b in 0..=1 {
                    let state = vec![x, y, 3, b];
                    if program.pool.eval(program.initial, &state) == Ok(Value::Bool(true)) {
                        expected.push(state);
                    }
                }
            }
        }
        prop_assert_eq!(states, expected);
    }
}
