//! Untrusted text: any text gives a result or an error, quickly and in little memory.

use std::fmt::Write;

use proptest::prelude::*;

use crate::common::entry;
use crate::common::prelude::*;
use meliora_amount::is_long;

/// Words that the languages are made of, and numbers at the edges.
const WORDS: &[&str] = &[
    "mdp",
    "dtmc",
    "module",
    "endmodule",
    "const",
    "int",
    "double",
    "bool",
    "formula",
    "label",
    "global",
    "init",
    "endinit",
    "system",
    "endsystem",
    "rewards",
    "endrewards",
    "true",
    "false",
    "min",
    "max",
    "floor",
    "ceil",
    "round",
    "pow",
    "mod",
    "log",
    "func",
    "objective",
    "prefer",
    "empty",
    "gain",
    "F",
    "P",
    "Pmax",
    "x",
    "y",
    "b",
    "K",
    "A",
    "B",
    "m",
    "n",
    "go",
    "\"l\"",
    "\"init\"",
    "0",
    "1",
    "2",
    "3",
    "0.5",
    "1e308",
    ".",
    "-",
    "9223372036854775807",
    "9223372036854775808",
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    ";",
    ":",
    ",",
    "'",
    "=",
    "!=",
    "<",
    "<=",
    ">",
    ">=",
    "+",
    "*",
    "/",
    "^",
    "!",
    "&",
    "|",
    "||",
    "|||",
    "|[",
    "]|",
    "=>",
    "<=>",
    "->",
    "<-",
    "..",
    "?",
    "~",
    "[go]",
    "(x'=x+1)",
    "x:[0..3]",
    "x.0",
    "y.2",
    "x=1",
    "sasi:1",
    "reachable",
    "class:A+B",
    "//",
    "\n",
    "é",
    "\"",
    "#",
];

/// Pieces of valid text, in any order.
fn soup() -> impl Strategy<Value = String> {
    let word = proptest::sample::select(WORDS);
    proptest::collection::vec(word, 0..60).prop_map(|words| words.join(" "))
}

/// Any bytes, most of them readable.
fn bytes() -> impl Strategy<Value = Vec<u8>> {
    let byte = prop_oneof![4 => 32u8..127, 1 => any::<u8>()];
    proptest::collection::vec(byte, 0..200)
}

/// A valid text with parts left out, doubled, moved or overwritten.
fn mutated(texts: Vec<String>) -> impl Strategy<Value = String> {
    let edit = (0usize..4, any::<prop::sample::Index>(), 1usize..40, proptest::sample::select(WORDS));
    let edits = proptest::collection::vec(edit, 1..6);
    (proptest::sample::select(texts), edits).prop_map(|(text, edits)| {
        let mut bytes = text.into_bytes();
        for (kind, at, length, word) in edits {
            let start = at.index(bytes.len() + 1);
            let end = (start + length).min(bytes.len());
            let piece = bytes[start..end].to_vec();
            let new = match kind {
                0 => Vec::new(),
                1 => [piece.clone(), piece].concat(),
                2 => word.as_bytes().to_vec(),
                _ => [word.as_bytes(), b" ", &piece].concat(),
            };
            bytes.splice(start..end, new);
        }
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

/// The files of `models/` that end so.
fn files(extension: &str) -> Vec<String> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("models");
    let paths = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    let wanted = paths.filter(|p| p.extension().is_some_and(|e| e == extension));
    wanted.map(|p| std::fs::read_to_string(p).unwrap()).chain([entry::MODEL.to_owned()]).collect()
}

fn everywhere(text: &str) {
    entry::model(text);
    entry::preferences(text);
    entry::arguments(text);
    entry::order_file(text);
    entry::manifest(text);
    entry::diagram(text.as_bytes());
    entry::values(text.as_bytes());
}

/// Bounds of two states.
const VALUES: &str = "arena,x,b,p_1_lower,p_1_upper,p_1_rank,c_1_lower,c_1_upper,c_1_rank
A+B,-1,0,1.0,1.0,0,2.5,1/3,7
nothing,3,1,1e-300,0.5,2,,,
";

proptest! {
    #![proptest_config(meliora_amount::random(400))]

    #[test]
    fn keywords_in_any_order_never_panic(text in soup()) {
        everywhere(&text);
    }

    #[test]
    fn bytes_never_panic(bytes in bytes()) {
        everywhere(&String::from_utf8_lossy(&bytes));
        entry::diagram(&bytes);
    }

    #[test]
    fn a_mutated_model_never_panics(text in mutated(files("prism"))) {
        entry::model(&text);
    }

    #[test]
    fn both_engines_say_the_same_of_a_mutated_model(text in mutated(vec![entry::MODEL.to_owned()])) {
        entry::engines(&text);
    }

    #[test]
    fn mutated_values_never_panic(text in mutated(vec![VALUES.to_owned()])) {
        entry::values(text.as_bytes());
    }

    #[test]
    fn mutated_preferences_never_panic(text in mutated(vec![entry::PREFERENCES.to_owned()])) {
        entry::preferences(&text);
    }

    #[test]
    fn mutated_arguments_never_panic(
        text in mutated(["x=1,y=-2,b=true", "sasi:1 & !(spi:1 | class:nothing)", "P>=1 [ F x>0 ? b : \"l\" ]"]
            .map(str::to_owned).to_vec())
    ) {
        entry::arguments(&text);
    }
}

proptest! {
    #![proptest_config(meliora_amount::random(100))]

    #[test]
    fn a_mutated_dump_never_panics(
        manifest in mutated(vec![entry::exported().manifest.text().unwrap()]),
        diagram in mutated(vec![diagram_text()]),
    ) {
        entry::manifest(&manifest);
        entry::diagram(diagram.as_bytes());
        entry::dump(diagram.as_bytes());
    }
}

fn diagram_text() -> String {
    let mut bytes = Vec::new();
    meliora::dump::dddmp::write(&entry::exported().regions, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

/// The message for a model that is refused.
#[track_caller]
fn refused(text: &str) -> String {
    match lang::load(&SourceFile::new("m.prism", text), &SourceFile::new("--const", "")) {
        Err(Error::Input(diagnostics)) => diagnostics[0].message.clone(),
        other => panic!("{:?}", other.map(|_| ())),
    }
}

/// A model with one expression for a constant.
fn constant(expression: &str) -> String {
    format!("mdp const int k={expression}; module m x:[0..3]; endmodule")
}

#[test]
fn deep_nesting_is_an_error_and_no_overflow_of_the_stack() {
    const DEEP: usize = 100_000;
    for (before, after) in [("(", ")"), ("true?", ":1"), ("-", ""), ("floor(", ")"), ("1+(", ")")] {
        let text = constant(&format!("{}1{}", before.repeat(DEEP), after.repeat(DEEP)));
        assert!(refused(&text).contains("nested more than"), "{before}");
    }
    let negations = format!("mdp module m x:[0..3]; [] {}true -> true; endmodule", "!".repeat(DEEP));
    assert!(refused(&negations).contains("nested more than"));
    let system = format!("mdp module m x:[0..3]; endmodule system {}m", "(".repeat(DEEP));
    assert!(refused(&system).contains("nested more than"));
    everywhere(&"(".repeat(DEEP));
    everywhere(&"!".repeat(DEEP));
    everywhere(&"[".repeat(DEEP));
}

#[test]
fn nesting_is_allowed_up_to_the_bound_that_is_named() {
    for (before, after) in [("(", ")"), ("-", ""), ("floor(", ")"), ("1+(", ")")] {
        let nested = |depth: usize| constant(&format!("{}1{}", before.repeat(depth), after.repeat(depth)));
        let deep = SourceFile::new("m", nested(10_000));
        assert!(lang::load(&deep, &SourceFile::new("c", "")).is_ok(), "{before}");
        let found = refused(&nested(10_001));
        assert!(found.contains("nested more than 10000 levels"), "{before}: {found}");
    }
}

#[test]
fn a_row_of_conditionals_is_read_without_depth() {
    let text = constant(&format!("{}1", "true?1:".repeat(10_000)));
    assert!(lang::load(&SourceFile::new("m", text), &SourceFile::new("c", "")).is_ok());
}

#[test]
fn a_long_row_of_regions_is_read_without_depth() {
    entry::arguments(&format!("reachable{}", " | initial & reachable".repeat(5_000)));
}

#[test]
fn high_expressions_are_refused_before_an_engine_recurses_over_them() {
    let sum = format!("mdp module m x:[0..3]; [] x{}>0 -> true; endmodule", "+x*x".repeat(11_000));
    assert!(refused(&sum).contains("nests more than"));
    let mut formulas = "mdp formula f0 = x;".to_owned();
    for i in 1..5_000 {
        write!(formulas, "formula f{i} = max(f{0}, mod(f{0}+1, 4));", i - 1).unwrap();
    }
    assert!(refused(&(formulas + "module m x:[0..3]; endmodule")).contains("nests more than"));
}

#[test]
fn formulas_that_double_are_read_in_linear_time() {
    let mut text = "mdp formula f0 = x;".to_owned();
    for i in 1..900 {
        write!(text, "formula f{i} = min(f{0}, f{0}) + 0*f{0};", i - 1).unwrap();
    }
    entry::model(&(text + "module m x:[0..3]; endmodule"));
}

#[test]
fn copies_of_copies_are_limited() {
    let mut text = "mdp module m0 x0:[0..3]; endmodule ".to_owned();
    for i in 1..1_000 {
        write!(text, "module m{i} = m{0} [x{0}=x{i}] endmodule ", i - 1).unwrap();
    }
    let message = refused(&text);
    assert!(message.contains("a copy of a copy"), "{message}");
}

#[test]
fn copies_cannot_multiply_commands_variables_or_formulas_without_end() {
    let copies = |count: usize| -> String {
        (1..count).fold(String::new(), |all, i| all + &format!("module m{i} = m0 [x0=x{i}] endmodule "))
    };
    let commands = "[] x0=1 -> true; ".repeat(2_000);
    let text = format!("mdp module m0 x0:[0..3]; {commands} endmodule {}", copies(2_000));
    assert!(refused(&text).contains("1000000 commands"));
    let text = format!("mdp module m0 x0:[0..3]; endmodule {}", copies(20_000));
    assert!(refused(&text).contains("10000 modules"));
    // Four million expressions are read before the limit is reached.
    if !is_long() {
        return;
    }
    let mut formulas = String::new();
    for i in 0..2_000 {
        write!(formulas, "formula f{i} = x0 + {i};").unwrap();
    }
    let all = (0..2_000).map(|i| format!("f{i} > 7")).collect::<Vec<_>>().join(" & ");
    let text = format!("mdp {formulas} module m0 x0:[0..3]; [] {all} -> true; endmodule {}", copies(4_000));
    assert!(refused(&text).contains("different expressions"));
}

#[test]
fn products_of_alternatives_are_limited_where_they_are_composed() {
    let modules: String = (0..40).fold(String::new(), |all, i| {
        all + &format!("module m{i} x{i}:[0..3]; [a] true -> (x{i}'=1); endmodule ")
    });
    let pairs: Vec<String> = (0..20).map(|i| format!("(m{} ||| m{})", 2 * i, 2 * i + 1)).collect();
    let message = refused(&format!("mdp {modules} system {} endsystem", pairs.join(" || ")));
    assert!(message.contains("more than 100000 synchronisations"), "{message}");
}

#[test]
fn wide_ranges_are_refused_past_what_a_double_holds_exactly() {
    for range in ["0..9223372036854775807", "-9007199254740993..0", "0..9007199254740993"] {
        assert!(refused(&format!("mdp module m x:[{range}]; endmodule")).contains("2^53"), "{range}");
    }
    assert!(refused("mdp module m x:[0..9223372036854775808]; endmodule").contains("64 bits"));
}

#[test]
fn many_labels_modules_actions_and_updates_are_read_in_linear_time() {
    let numbered = |what: &dyn Fn(usize) -> String, count| (0..count).map(what).collect::<String>();
    let labels = numbered(&|i| format!("label \"l{i}\" = true;"), 50_000);
    let commands = numbered(&|i| format!("[a{i}] x=1 -> (x'=2);"), 50_000);
    let bits = numbered(&|i| format!("b{i}:bool;"), 20_000);
    let updates = (0..20_000).map(|i| format!("(b{i}'=true)")).collect::<Vec<_>>().join("&");
    let modules = numbered(&|i| format!("module n{i} y{i}:bool; endmodule "), 9_000);
    let text = format!(
        "mdp {labels} module m x:[0..3]; {bits} {commands} [] true -> {updates}; endmodule {modules}"
    );
    let checked = lang::load(&SourceFile::new("m.prism", text), &SourceFile::new("c", "")).unwrap();
    assert_eq!(checked.program.synchronisations.len(), 50_001);
}

/// The messages for preferences that are refused.
fn refused_preferences(text: &str) -> Vec<String> {
    match lang::load_preferences(&SourceFile::new("m.pref", text), entry::program()) {
        Err(Error::Input(diagnostics)) => diagnostics.into_iter().map(|d| d.message).collect(),
        other => panic!("{:?}", other.map(|_| ())),
    }
}

#[test]
fn objectives_and_statements_are_limited() {
    let objectives = (0..1_001).map(|i| format!("objective A{i} = F x=1;")).collect::<String>();
    assert!(refused_preferences(&objectives)[0].contains("more than 1000 objectives"));
    let objectives = (0..1_000).map(|i| format!("objective A{i} = F x=1;")).collect::<String>();
    let side = |from: usize| (from..from + 500).map(|i| format!("A{i}")).collect::<Vec<_>>().join(",");
    let chain = (0..10).map(|i| side(500 * (i % 2))).collect::<Vec<_>>().join(" >= ");
    let messages = refused_preferences(&format!("{objectives} prefer {chain};"));
    assert!(messages[0].contains("more than 1000000 pairs"), "{messages:?}");
}

#[test]
fn a_name_said_many_times_on_both_sides_of_a_preference_counts_once() {
    let again = "A,".repeat(20_000) + "A";
    let text =
        format!("objective A = F x=1; objective B = F x=2; prefer {again} > {};", again.replace('A', "B"));
    assert!(lang::load_preferences(&SourceFile::new("p", text), entry::program()).is_ok());
}

#[test]
fn no_text_is_answered_with_more_than_a_screen_of_errors() {
    let unknown = format!(
        "objective A = F x=1; prefer {};",
        (0..5_000).map(|i| format!("N{i}")).collect::<Vec<_>>().join(" > ")
    );
    assert!(refused_preferences(&unknown).len() <= 20);
    let order = meliora::advanced::symbolic::order::parse(
        &entry::program(),
        &SourceFile::new("o", "z ".repeat(50_000)),
    );
    assert!(matches!(order, Err(Error::Input(all)) if all.len() <= 20));
}
