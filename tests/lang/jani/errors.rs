//! Error messages for wrong documents, as users see them.

use super::{around, load, load_text, sets_x};
use crate::common::prelude::*;

fn rendered(text: &str, constants: &str) -> String {
    match load_text(text, constants) {
        Ok(_) => "accepted\n".to_owned(),
        Err(Error::Input(diagnostics)) => render(&diagnostics, false),
        Err(other) => format!("{other}\n"),
    }
}

/// Compares with the stored snapshot, without the source expression in the file's head.
fn snapshot(name: &str) -> impl Fn(&[String]) {
    move |cases| {
        let mut settings = insta::Settings::clone_current();
        settings.set_omit_expression(true);
        settings.bind(|| insta::assert_snapshot!(name, cases.join("\n")));
    }
}

/// A small model as text, with one piece replaced.
fn but(piece: &str, other: &str) -> String {
    let text = SMALL.replacen(piece, other, 1);
    assert_ne!(text, SMALL, "{piece}");
    rendered(&text, "")
}

const SMALL: &str = r#"{"jani-version": 1, "name": "small", "type": "mdp", "features": ["derived-operators"],
"actions": [{"name": "go"}],
"variables": [{"name": "x", "type": {"kind": "bounded", "base": "int", "lower-bound": 0, "upper-bound": 3}, "initial-value": 0}],
"automata": [{"name": "m", "locations": [{"name": "l"}], "initial-locations": ["l"], "edges": [
  {"location": "l", "guard": {"exp": {"op": "<", "left": "x", "right": 3}},
   "destinations": [{"location": "l", "assignments": [{"ref": "x", "value": {"op": "+", "left": "x", "right": 1}}]}]}]}],
"system": {"elements": [{"automaton": "m"}], "syncs": [{"synchronise": ["go"]}]}}"#;

#[test]
fn errors_of_syntax_and_shape_are_shown_at_their_place() {
    assert_eq!(rendered(SMALL, ""), "accepted\n");
    snapshot("syntax_and_shape")(&[
        but("\"name\": \"small\"", "\"name\" \"small\""),
        rendered("{", ""),
        rendered("{\"jani-version\": 1, \"type\": \"mdp\"}", ""),
        but("\"jani-version\": 1,", "\"type\": \"dtmc\","),
        but("\"guard\"", "\"gaurd\""),
        but("\"name\": \"l\"", "\"name\": 7"),
        but("[{\"name\": \"go\"}]", "{\"name\": \"go\"}"),
    ]);
}

#[test]
fn what_is_not_supported_is_refused_by_name() {
    let integer = "{\"kind\": \"bounded\", \"base\": \"int\", \"lower-bound\": 0, \"upper-bound\": 3}";
    snapshot("not_supported")(&[
        but("\"type\": \"mdp\"", "\"type\": \"pta\""),
        but("\"derived-operators\"", "\"datatypes\""),
        but(integer, "\"int\""),
        but(integer, "\"real\""),
        but(integer, "\"clock\""),
        but(integer, "{\"kind\": \"datatype\", \"ref\": \"int\"}"),
        but("{\"automaton\": \"m\"}", "{\"automaton\": \"m\", \"input-enable\": [\"go\"]}"),
        but("\"op\": \"+\", \"left\": \"x\", \"right\": 1", "\"op\": \"sin\", \"exp\": \"x\""),
        but("\"jani-version\": 1", "\"jani-version\": 2"),
    ]);
}

#[test]
fn what_has_no_meaning_is_shown_at_its_place() {
    snapshot("meaning")(&[
        but("\"left\": \"x\", \"right\": 3", "\"left\": \"xx\", \"right\": true"),
        but("\"initial-value\": 0", "\"initial-value\": 4"),
        but("\"location\": \"l\", \"guard\"", "\"location\": \"k\", \"guard\""),
        but("\"ref\": \"x\"", "\"ref\": \"y\""),
        but("\"value\": {\"op\": \"+\"", "\"value\": {\"op\": \"/\""),
        but("[\"go\"]", "[\"go\", null]"),
        but("[\"go\"]", "[\"come\"]"),
        but("\"automaton\": \"m\"", "\"automaton\": \"n\""),
        but("\"name\": \"l\"}]", "\"name\": \"l\"}, {\"name\": \"l\"}]"),
    ]);
}

#[test]
fn constants_without_a_value_of_their_type_are_errors() {
    let with =
        |list: &str| SMALL.replacen("\"variables\"", &format!("\"constants\": [{list}], \"variables\""), 1);
    let two = "{\"name\": \"A\", \"type\": \"int\"}, {\"name\": \"B\", \"type\": \"int\", \"value\": {\"op\": \"+\", \
               \"left\": \"A\", \"right\": \"C\"}}, {\"name\": \"C\", \"type\": \"int\", \"value\": 1}";
    snapshot("constants")(&[
        rendered(&with("{\"name\": \"A\", \"type\": \"int\"}"), ""),
        rendered(&with("{\"name\": \"A\", \"type\": \"bool\"}"), "A=2,B=3"),
        rendered(&with(two), "A=1"),
    ]);
}

#[test]
fn functions_that_call_themselves_are_refused() {
    let mut document = around(json!([sets_x(json!({"op": "call", "function": "f", "args": ["x"]}))]));
    let body = json!({"op": "call", "function": "f", "args": ["v"]});
    let parameter = json!([{"name": "v", "type": "int"}]);
    document["functions"] = json!([{"name": "f", "type": "int", "parameters": parameter, "body": body}]);
    let Err(Error::Input(found)) = load(&document) else { panic!() };
    assert_eq!(found[0].message, "the function `f` calls itself");
}

#[test]
fn documents_without_end_or_bottom_are_refused_with_a_place() {
    let deep = |levels: usize, open: &str, close: &str| {
        let expression = format!("{}1{}", open.repeat(levels), close.repeat(levels));
        SMALL.replacen("\"right\": 1", &format!("\"right\": {expression}"), 1)
    };
    let nested = deep(100_000, "{\"op\": \"+\", \"left\": 1, \"right\": ", "}");
    let found = rendered(&nested, "");
    assert!(found.contains("more than 10000 levels"), "{}", &found[..found.len().min(500)]);
    assert!(rendered(&deep(100, "[", "]"), "").contains("expected a literal"));
    assert_eq!(rendered(&deep(9_980, "{\"op\": \"+\", \"left\": 1, \"right\": ", "}"), ""), "accepted\n");
}

/// Pieces of documents, and numbers at the edges.
const PIECES: &[&str] = &[
    "{",
    "}",
    "[",
    "]",
    ",",
    ":",
    "null",
    "true",
    "\"x\"",
    "\"l\"",
    "\"go\"",
    "0",
    "-1",
    "1e999",
    "9223372036854775808",
    "\"int\"",
    "\"real\"",
    "{\"exp\": 1}",
    "{\"op\": \"¬\", \"exp\": \"x\"}",
    "\"op\"",
    "\"left\"",
    "\"∧\"",
    "\"",
    "\\ud800",
    "{\"op\": \"/\", \"left\": 1, \"right\": 0}",
    "{\"op\": \"ite\", \"if\": true, \"then\": 1, \"else\": \"x\"}",
];

proptest::proptest! {
    #[test]
    fn documents_with_pieces_lost_doubled_and_put_in_never_panic(
        edits in proptest::collection::vec((0..SMALL.len(), 0..30usize, 0..PIECES.len() + 1), 1..5),
    ) {
        let mut text = SMALL.to_owned();
        for (at, length, piece) in edits {
            let from = text.floor_char_boundary(at.min(text.len()));
            let to = text.floor_char_boundary((from + length).min(text.len()));
            let doubled = text[from..to].repeat(2);
            text.replace_range(from..to, PIECES.get(piece).copied().unwrap_or(&doubled));
        }
        proptest::prop_assert!(!rendered(&text, "").is_empty());
        // An accepted document can be written in the modelling language and read back.
        if let Ok(checked) = load_text(&text, "") {
            let flat = meliora::lang::flat(&checked.program).unwrap();
            let again = load_text(&flat, "");
            proptest::prop_assert!(again.is_ok(), "{}", flat);
        }
    }
}
