//! States whose values have names: printed states are read back as the same states.

use meliora::lang::{load, parse_state};
use meliora::model::valuation::Valuation;
use proptest::prelude::*;

use crate::common::prelude::*;

/// A model of two variables whose values have these names, and a third one without names.
fn program(names: &[Vec<String>; 2]) -> Program {
    let [x, y] = names.each_ref().map(|names| names.len() - 1);
    let text = format!("mdp module m x : [0..{x}]; y : [0..{y}]; b : bool; endmodule");
    let mut program =
        load(&SourceFile::new("m.prism", text), &SourceFile::new("--const", "")).unwrap().program;
    for (variable, names) in program.variables.iter_mut().zip(names) {
        variable.values.clone_from(names);
    }
    program
}

fn read(program: &Program, text: &str) -> Result<Vec<i64>, String> {
    parse_state(&SourceFile::new("--at", text), program).map_err(|error| error.to_string())
}

/// Reads every printed state back.
fn round_trip(names: &[Vec<String>; 2]) {
    let program = program(names);
    for x in 0..names[0].len() as i64 {
        for y in 0..names[1].len() as i64 {
            let state = vec![x, y, 1];
            for text in [program.show_state(&state), Valuation::new(&program, &state).to_string()] {
                assert_eq!(read(&program, &text), Ok(state.clone()), "{text} in {names:?}");
            }
        }
    }
}

/// Names made of what means something else in a state.
fn some_names() -> impl Strategy<Value = Vec<String>> {
    let part = prop::sample::select(vec![
        "a", "b", "x", "y", "0", "1", "-", ".5", "e", ",", "=", "\"", " ", "//", "*", "true", "é", "/", "{",
        "'",
    ]);
    let name = prop::collection::vec(part, 0..4).prop_map(|parts| parts.concat());
    prop::collection::btree_set(name, 1..6).prop_map(|names| names.into_iter().collect())
}

proptest! {
    #![proptest_config(meliora_amount::random(400))]

    #[test]
    fn every_printed_state_is_read_back_as_itself(x in some_names(), y in some_names()) {
        round_trip(&[x, y]);
    }
}

fn texts<const N: usize>(names: [&str; N]) -> Vec<String> {
    names.map(str::to_owned).to_vec()
}

/// `x=1` was the value called `1` in what is printed, and the second value elsewhere.
#[test]
fn a_number_is_never_taken_for_the_name_of_another_value() {
    let program = program(&[texts(["0", "2", "1/2"]), texts(["go", "a,b"])]);
    assert_eq!(program.show_state(&[1, 0, 0]), "x=\"2\",y=go,b=false");
    assert_eq!(program.show_state(&[2, 1, 0]), "x=\"1/2\",y=\"a,b\",b=false");
    assert_eq!(read(&program, "x=2,y=go,b=false"), Ok(vec![1, 0, 0]));
    assert_eq!(read(&program, "x=1/2,y=1,b=false"), Ok(vec![2, 1, 0]));
    let Err(Error::Input(refused)) = parse_state(&SourceFile::new("--at", "x=1,y=go,b=false"), &program)
    else {
        panic!("a value without a name is read")
    };
    assert_eq!(refused[0].message, "`x` has no value `1`");
    assert_eq!(refused[0].help.as_deref(), Some("its values are \"0\", \"2\", \"1/2\""));
}

#[test]
fn a_name_with_a_comma_hides_no_other_variable() {
    round_trip(&[texts(["a", "a,y=b", "\"a\"", "a "]), texts(["b", "b,b=false", "", "\"\""])]);
}
