//! Every error of the front end, as users see it. One snapshot per theme.

use meliora::error::{Error, SourceFile, render};
use meliora::lang::{
    load, lower_target, parse_constants, parse_expression, parse_preferences, parse_property, parse_state,
};

pub(super) fn rendered<T>(result: Result<T, Error>) -> String {
    match result {
        Ok(_) => "accepted\n".to_owned(),
        Err(Error::Input(diagnostics)) => render(&diagnostics, false),
        Err(other) => format!("{other}\n"),
    }
}

/// Returns the outputs for the cases of a theme, one after the other.
pub(super) fn all(cases: &[&str], run: impl Fn(&str) -> String) -> String {
    cases.iter().map(|case| format!("{}\n", run(case))).collect()
}

/// Compares with the stored snapshot, without the source expression in the file's head.
pub(super) fn snapshot(name: &str, text: impl AsRef<str>) {
    let mut settings = insta::Settings::clone_current();
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!(name, text.as_ref()));
}

/// The snapshot of the outputs for the cases of a theme.
fn snapshots(name: &str, run: impl Fn(&str) -> String) -> impl Fn(&[&str]) {
    move |cases| snapshot(name, all(cases, &run))
}

pub(super) fn model(text: &str) -> String {
    model_with(text, "")
}

fn model_with(text: &str, constants: &str) -> String {
    rendered(load(&SourceFile::new("m.prism", text), &SourceFile::new("--const", constants)))
}

/// A module with the given commands around a small state.
pub(super) fn with_commands(commands: &str) -> String {
    model(&format!("mdp\nmodule m\n x : [0..3];\n b : bool;\n {commands}\nendmodule\n"))
}

const SMALL: &str = "mdp\nconst int N = 3;\nformula low = x<2;\nlabel \"done\" = x=N;\nmodule m\n \
                     x : [0..N]; b : bool;\n [go] x<N -> (x'=x+1);\nendmodule\n";

fn target(text: &str) -> String {
    let checked =
        load(&SourceFile::new("m", SMALL), &SourceFile::new("--const", "")).expect("the model is right");
    let source = SourceFile::new("--target", text);
    rendered(parse_expression(&source).and_then(|e| lower_target(&checked.program, &source, &e)))
}

#[test]
fn errors_of_syntax_are_shown_at_their_place() {
    snapshots("syntax", model)(&[
        "mdp\nmodule m\n x : [0..3]\n [] x=0 -> true;\nendmodule",
        "mdp\nmodule m\n x : [0..3];\n [] x=0 -> (x'=1;\n [] x=1 -> (x=2);\n [] -> true;\n y @ 3;\nendmodule",
        "mdp\nmodule m\n x : [0..3];\n [] x=0 -> true;\n",
        "mdp\nmodule m\n x : bool;\nmodule n endmodule",
        "mdp\nmodule m\n [] true -> 0.5 : true + true;\nendmodule",
        "mdp\nmodule m\n [] true -> true;\n x : bool;\nendmodule",
        "mdp\nlabel done = true;\nmodule m endmodule",
        "mdp\nlabel \"a b\" = true;\nmodule m endmodule",
        "mdp\nlabel \"init\" = true;\nmodule m endmodule",
        "mdp\nformula f = ;\nformula g = 1 + ;\nmodule m endmodule",
        "mdp\nformula f = a = !b;\nmodule m endmodule",
        "mdp\nformula f = 2 ^ 3 ^ 2;\nmodule m endmodule",
        "mdp\nformula f = 99999999999999999999 + 1e999;\nmodule m endmodule",
        "mdp\nformula f = 99999999999999999999;\nformula g = 1e999;\nmodule m endmodule",
        "mdp\n#const N# \nmodule m endmodule",
        "mdp\nlabel \"open = true;\nmodule m endmodule",
        "mdp\ndtmc\nmodule m endmodule",
        "mdp\nrewards x : 1 endrewards\nmodule m endmodule",
        "mdp\nrewards true : 1;\nmodule m endmodule",
        "mdp\ninit true\nmodule m endmodule",
        "hello\nmodule m endmodule",
        "mdp\nsystem a || b ||| c endsystem\nmodule a endmodule",
        "mdp\nmodule m\n [] P>=1 -> true;\nendmodule",
    ]);
}

#[test]
fn a_keyword_is_no_name() {
    snapshots("keywords_as_names", model)(&[
        "mdp\nmodule module endmodule",
        "mdp\nconst int F = 3;\nmodule m endmodule",
        "mdp\nmodule m\n label : [0..2];\nendmodule",
        "mdp\nmodule m\n x : bool;\n [system] x -> true;\nendmodule",
        "mdp\nmodule m\n x : bool;\n [] X -> (G'=true);\nendmodule",
    ]);
}

#[test]
fn what_is_not_supported_is_refused_by_name() {
    snapshots("not_supported", model)(&[
        "ctmc\nmodule m endmodule",
        "stochastic\nmodule m endmodule",
        "pta\nmodule m\n t : clock;\n invariant t<3 endinvariant\n [] true -> true;\nendmodule",
        "csg\nmodule m endmodule",
        "pomdp\nobservables x endobservables\nmodule m\n x : bool;\nendmodule",
        "ma\nmodule m endmodule",
        "mdp\nmodule m\n x : int;\n y : double;\nendmodule",
        "mdp\nsystem \"one\" m endsystem\nmodule m endmodule",
        "mdp\nmodule m\n x : bool;\n [] multi(x, x) -> true;\nendmodule",
        "mdp\nmodule m\n x : bool;\n [] x -> [0.1,0.2] : (x'=true) + [0.8,0.9] : (x'=false);\nendmodule",
    ]);
}

#[test]
fn names_that_are_unknown_or_taken_are_errors() {
    snapshots("names", model)(&[
        "mdp\nconst int x = 1;\nmodule m\n x : bool;\nendmodule\nmodule m endmodule",
        "mdp\nlabel \"a\" = true;\nlabel \"a\" = false;\nmodule m endmodule",
        "mdp\nmodule m\n count : [0..3];\n [] coutn=1 & cont=2 -> (Count'=1);\nendmodule",
        "mdp\nmodule m\n x : bool;\n [] \"done\" -> true;\nendmodule",
        "mdp\nformula f = g(1);\nmodule m endmodule",
        "mdp\nformula f = pow(1);\nformula g = mod(1);\nformula h = floor(1, 2);\nmodule m endmodule",
        "mdp\ninit true endinit\ninit true endinit\nmodule m endmodule",
        "mdp\n",
    ]);
}

#[test]
fn operands_of_wrong_types_are_errors() {
    snapshots("types", with_commands)(&[
        "[] x -> true;",
        "[] x/2 = 1 -> (x'=x/2);",
        "[] x = b -> true;",
        "[] b < b -> true;",
        "[] !x & -b > 0 -> true;",
        "[] b & 1 | x -> true;",
        "[] true -> b : (x'=1) + 0.5 : (b'=1);",
        "[] (b ? 1 : true) -> true;",
        "[] (x ? true : b) -> true;",
        "[] mod(x, 1.5) = 0 -> true;",
        "[] max(x, b) = 0 -> true;",
        "[] floor(b) = 0 -> true;",
        "[] x => b -> true;",
    ]);
}

#[test]
fn constants_without_a_value_of_their_type_are_errors() {
    let two = "mdp\nconst int N;\nconst double p;\nconst bool fast;\nmodule m endmodule";
    let one = "mdp\nconst int N = 2;\nmodule m endmodule";
    let mut text = String::new();
    for (model, constants) in [
        (two, ""),
        (two, "N=1,M=2"),
        (two, "N=1.5,p=1,fast=1"),
        (two, "N=1,p=0.5,fast=true"),
        (one, "N=3"),
        (one, "K=3"),
        (one, "N"),
        (one, "N=,"),
        (one, "N=1,N=2"),
        ("mdp\nconst int a = b;\nconst int b = a + 1;\nmodule m endmodule", ""),
        ("mdp\nconst int a = mod(1, 0);\nmodule m endmodule", ""),
        ("mdp\nconst int a = 1/2;\nmodule m endmodule", ""),
        ("mdp\nconst int a = 9223372036854775807 + 1;\nmodule m endmodule", ""),
        ("mdp\nconst int a = pow(2, -1);\nmodule m endmodule", ""),
        ("mdp\nconst int a = x;\nmodule m\n x : [0..1];\nendmodule", ""),
        ("mdp\nformula f = g;\nformula g = h & true;\nformula h = f;\nmodule m endmodule", ""),
    ] {
        text.push_str(&model_with(model, constants));
        text.push('\n');
    }
    snapshot("constants", text);
}

#[test]
fn variables_without_a_range_or_a_value_in_it_are_errors() {
    snapshots("variables", model)(&[
        "mdp\nmodule m\n x : [3..1];\nendmodule",
        "mdp\nmodule m\n x : [0..y];\n y : [0..1.5];\nendmodule",
        "mdp\nmodule m\n x : [0..9007199254740993];\nendmodule",
        "mdp\nmodule m\n x : [0..3] init 4;\n y : bool init 1;\nendmodule",
        "mdp\nmodule m\n x : [0..3] init 1;\nendmodule\ninit x=2 endinit",
        "mdp\nmodule m\n x : [0..3];\nendmodule\ninit x endinit",
    ]);
}

#[test]
fn updates_that_cannot_be_made_are_errors() {
    snapshots("updates", model)(&[
        "mdp\nmodule m\n x : [0..3];\n [] true -> (x'=1) & (x'=2);\nendmodule",
        "mdp\nmodule m\n x : [0..3];\nendmodule\nmodule n\n [] true -> (x'=1);\nendmodule",
        "mdp\nglobal g : [0..3];\nmodule m\n [a] true -> (g'=1);\nendmodule",
        "mdp\nconst int N = 1;\nmodule m\n [] true -> (N'=1) & (z'=1);\nendmodule",
    ]);
}

#[test]
fn renamings_that_name_no_module_or_leave_names_are_errors() {
    let base = "mdp\nmodule m\n x : [0..3];\n y : bool;\n [] true -> (x'=1) & (y'=true);\nendmodule\n";
    snapshots("renaming", |text| model(&format!("{base}{text}")))(&[
        "module n = m [x=z] endmodule",
        "module n = k [x=z, y=w] endmodule",
        "module n = n [x=z, y=w] endmodule",
        "module n = m [x=z, x=w, y=v] endmodule",
        "module n = m [x=x, y=w] endmodule",
        "module n = m [x=z, y=z] endmodule",
        "module n = m [x=z y=w] endmodule",
    ]);
}

#[test]
fn compositions_of_wrong_modules_or_actions_are_errors() {
    let base = "mdp\nmodule a\n x : bool;\n [s] x -> true;\nendmodule\nmodule b = a [x=y] endmodule\n";
    snapshots("composition", |text| model(&format!("{base}{text}")))(&[
        "system a endsystem",
        "system a || a || b endsystem",
        "system a || b || c endsystem",
        "system a |[t]| b endsystem",
        "system (a || b) / {t} endsystem",
        "system (a || b) {t<-s} endsystem",
        "system (a || b) {s<-t, s<-u} endsystem",
        "system a || b endsystem system a || b endsystem",
        "system a || b",
    ]);
}

#[test]
fn targets_that_are_no_conditions_are_errors() {
    snapshots("targets", target)(&[
        "y = 1",
        "x + 1",
        "\"dnoe\"",
        "x = 1 x",
        "",
        "(x = 1",
        "low & \"done\" & \"init\" & \"deadlock\" & N=3",
    ]);
}

#[test]
fn properties_that_cannot_be_read_are_errors() {
    snapshots("properties", |text| rendered(parse_property(&SourceFile::new("--property", text))))(&[
        "Pmax=? [ F x=1 ]",
        "P=? [ F x=1 ]",
        "P=1 [ F x=1 ]",
        "P>=0.5 [ F x=1 ]",
        "P>=0 [ F x=1 ]",
        "R<=3 [ F x=1 ]",
        "P>=1.5 [ F x=1 ]",
        "R{cost}min=? [ F x=1 ]",
        "R{0}min=? [ F x=1 ]",
        "R{\"cost\"}min=? [ C<=3 ]",
        "Rmin=? [ x=0 U x=1 ]",
        "S>=0.5 [ x=1 ]",
        "filter(min, P>0 [ F x=1 ])",
        "P>=1 [ G x=1 ]",
        "P>=1 [ F<=3 x=1 ]",
        "P>=1 [ x=0 U x=1 ]",
        "P>=1 [ F x=0 U x=1 ]",
        "P>=1 F x=1",
        "P>=x [ F x=1 ]",
        "x=1",
        "P>=1 [ F x=1 ] & true",
        "Pmax=? [ F x=1 ] > 0.5",
        "Pmax=? [ F x=1 ]; Pmin=? [ F x=1 ];",
        "Pmax=? [ F x=1 ]{\"low\"}",
        "pmax=? [ F x=1 ]",
        "Smax=? [ x=1 ]",
        "E [ F x=1 ]",
        "A [ G x=1 ]",
        "multi(Pmax=? [ F x=1 ], Pmax=? [ F x=2 ])",
        "filter(count, \"low\")",
        "filter(forall, P>0 [ F x=1 ])",
        "Pmax=? [ C<=3 ]",
        "Pmax=? [ F{\"cost\"}<=3 x=1 ]",
        "R{\"cost\"}min=? [ LRA ]",
        "<<p>> R{\"cost\"}min=? [ Fc x=1 ]",
        "<<p>> R{\"cost\"}min=? [ F* x=1 ]",
        "<<p:q>>max=? (P[ F x=1 ] + P[ F x=2 ])",
        "[[p]] Pmax=? [ F x=1 ]",
        "Pmax=? [ not \"low\" U x=1 ]",
        "Pmax=? [ F (x=1 -> x=2) ]",
    ]);
}

#[test]
fn preferences_that_cannot_be_read_or_met_are_errors() {
    snapshots("preferences", |text| rendered(parse_preferences(&SourceFile::new("p.pref", text))))(&[
        "objective A = x=1;\nobjective = F y;\nprefer A;\nprefer A < B;\nprefer A > ;\nempty = nothing;",
        "objective A = F (x=1)\nobjective B = F (x=2);",
        "objective nothing = F x;",
        "empty = gain;\nempty = bottom;",
        "prefers A > B;\nprefer A, > B;",
        "prefer A > B",
    ]);
}

#[test]
fn states_that_do_not_exist_are_errors() {
    let checked =
        load(&SourceFile::new("m", SMALL), &SourceFile::new("--const", "")).expect("the model is right");
    snapshots("states", |text| rendered(parse_state(&SourceFile::new("--at", text), &checked.program)))(&[
        "z=1,x=true,b=1",
        "x=4",
        "x=1,x=2",
        "x",
        "x=1;b=true",
    ]);
}

#[test]
fn given_constants_that_do_not_fit_are_errors() {
    snapshots("constants_on_the_command_line", |text| {
        rendered(parse_constants(&SourceFile::new("--const", text)))
    })(&["a=b", "=3", "a==3", "a=--1", "true=1"]);
}

#[test]
fn expressions_nested_too_deep_are_errors() {
    for (open, close) in [("(", ")"), ("!", ""), ("-", ""), ("max(1,", ")"), ("true ? 1 : (", ")")] {
        let text = format!("{}1{}", open.repeat(100_000), close.repeat(100_000));
        let shown = rendered(parse_expression(&SourceFile::new("--target", text)));
        assert!(shown.contains("nested more than 10000 levels deep"), "{open}");
    }
    // With every level of precedence in between, on a small stack.
    let (open, close) = ("(true=>true<=>true|true&!1=-1+1*(true?1:", "))");
    let deep = format!("mdp formula f = {}1{};\nmodule m endmodule", open.repeat(45), close.repeat(45));
    assert!(model(&deep).contains("type error"), "{}", model(&deep));
    let text = format!("mdp system {}a{} endsystem", "(".repeat(100_000), ")".repeat(100_000));
    assert!(model(&text).contains("nested more than 200 levels deep"));
}

/// Reads a model with a guard, on a thread with a small stack; returns the error or the empty text.
fn on_a_small_stack(guard: String) -> String {
    let read = move || {
        let text = format!("mdp module m x : [0..9]; [] {guard} -> (x'=1); endmodule");
        let none = SourceFile::new("constants", "");
        meliora::lang::load(&SourceFile::new("model", text), &none)
            .map_or_else(|e| e.to_string(), |_| String::new())
    };
    std::thread::Builder::new().stack_size(256 << 10).spawn(read).unwrap().join().unwrap()
}

#[test]
fn brackets_nest_up_to_the_limit_on_a_small_stack() {
    let brackets = |n: usize| format!("{}x=0{}", "(".repeat(n), ")".repeat(n));
    assert_eq!(on_a_small_stack(brackets(10_000)), "");
    assert!(on_a_small_stack(brackets(10_001)).contains("nested more than 10000 levels deep"));
    let sums = |n: usize| format!("{}x{}>0", "(1+".repeat(n), ")".repeat(n));
    assert_eq!(on_a_small_stack(sums(9_990)), "");
    assert!(on_a_small_stack("x+".repeat(10_000) + "x>0").contains("nests more than 10000 operators"));
}

#[test]
fn formulas_that_pile_up_too_high_are_an_error() {
    let mut text = String::from("mdp\nmodule m\n x : [0..1];\nendmodule\nformula f0 = x;\n");
    for i in 1..11_000 {
        text.push_str(&format!("formula f{i} = f{} + 1.5;\n", i - 1));
    }
    assert!(model(&text).contains("nests more than 10000 operators"));
}

#[test]
fn a_mistyped_keyword_is_told_with_the_one_that_was_meant() {
    let cases = [
        "mdp\nmodul m\n x : bool;\nendmodule",
        "mdp\nmodule m\n x : bool;\nendmodul\nmodule n\n y : bool;\nendmodule",
        "mdp\nconts int N = 3;\nmodule m\n x : [0..N];\nendmodule",
        "mdp\nmodule m\n x : bool;\nendmodule\ninit x endini",
    ];
    let preferences =
        rendered(parse_preferences(&SourceFile::new("p.pref", "objectiv A = F x;\nprefer A > A;")));
    snapshot("words_that_were_meant_to_be_others", all(&cases, model) + &preferences);
}

#[test]
fn what_is_missing_is_shown_at_the_end_of_its_line() {
    let cases = [
        "mdp\nconst int N = 3\n\n// the module\nmodule m\n x : [0..N]\nendmodule",
        "mdp\nmodule m\n x : [0..3];\n [] (x=1\n -> true;\nendmodule",
        "mdp\nmodule m\n x : [0..3];\nendmodule\nlabel \"a\" = x=1",
    ];
    let preferences = rendered(parse_preferences(&SourceFile::new("p.pref", "prefer A > B\nprefer B > C;")));
    snapshot("what_is_missing", all(&cases, model) + &preferences);
}

#[test]
fn a_label_written_as_a_name_is_told_with_its_quotes() {
    snapshot("labels_and_names", all(&["done", "\"low\"", "\"x\" = 1"], target));
}
