//! Errors of those who know other languages, or mistype a word: each says what to write.

use meliora::error::SourceFile;
use meliora::lang::parse_preferences;

use crate::lang::errors::{model, rendered, snapshot, with_commands};

#[test]
fn what_other_languages_write_is_told_with_what_to_write_here() {
    let command = |text: &str| with_commands(text);
    let mut text = String::new();
    for case in [
        "[] x==0 && b -> (x'=1) && (b'=true);",
        "[] x=<2 || x<>1 -> true;",
        "[] x=0 and b -> true;",
        "[] not b -> true;",
        "[] x % 2 = 0 -> true;",
        "[] x=0 -> x'=1;",
        "[] x=0 -> 0.5 : x'=1 + 0.5 : true;",
        "[] x'=0 -> true;",
        "# nothing\n [] true -> true;",
    ] {
        text.push_str(&command(case));
        text.push('\n');
    }
    snapshot("what_other_languages_write", text);
}

#[test]
fn files_of_another_kind_are_named() {
    let mut text = String::new();
    for case in [
        "// preferences\nobjective A = F x=1;",
        "P>=1 [ F x=1 ]",
        "(x,y)\n0:(0,1)\n",
        "0=\"init\" 1=\"deadlock\"\n0: 0\n",
        "const int T;\n\"far\": Pmax=? [ F<=T x=1 ];",
        "\"cost\": R{\"cost\"}min=? [ F x=1 ];",
    ] {
        text.push_str(&format!("{}\n", model(case)));
    }
    for case in [
        "mdp\nmodule m\n x : bool;\nendmodule",
        "const int N = 3;\nmdp",
        "const int T;\nPmax=? [ F<=T x=1 ];",
        "label \"far\" = x=3;\nobjective A = F \"far\";",
    ] {
        text.push_str(&format!("{}\n", rendered(parse_preferences(&SourceFile::new("p.pref", case)))));
    }
    snapshot("files_in_place_of_others", text);
}

/// Requires these words in an error message with its help.
fn expect_words(found: &str, words: &[&str]) {
    for word in words {
        assert!(found.contains(word), "`{word}` in: {found}");
    }
}

#[test]
fn what_is_written_otherwise_elsewhere_is_told_with_what_to_write() {
    expect_words(&with_commands("[] x=0 -> (x':=1);"), &["given by `=`", "(x'=1)"]);
    expect_words(&with_commands("[] x=0 -> (x'=1),(b'=true);"), &["`,` cannot join updates", "write `&`"]);
    expect_words(&with_commands("[] x=0 -> (x'=if b then 1 else 2);"), &["`condition ? value : other`"]);
    expect_words(&with_commands("[] x=0 -> (x'=1) & true;"), &["`true` stands alone", "leave it out"]);
    expect_words(&model("mdp /* why */ module m endmodule"), &["found `/`", "a comment begins with `//`"]);
    expect_words(&with_commands("[] x≤1 -> true;"), &["unexpected `≤`", "write `<=`"]);
    expect_words(&with_commands("[] 0<=x<=1 -> true;"), &["must be a number", "`0<=x & x<=1`"]);
    let rewards = |text: &str| {
        model(&format!("mdp module m x : bool; [a] true -> true; endmodule rewards {text} endrewards"))
    };
    for text in ["[a] 3;", "cost x : 1;"] {
        expect_words(
            &rewards(text),
            &["expected `:`", "`[action] condition : number;`", "`rewards \"name\"`"],
        );
    }
}

#[test]
fn an_update_of_a_misspelt_variable_is_told_with_the_one_that_was_meant() {
    let text = |name: &str| {
        format!("mdp const int count2 = 1; module m count : [0..3]; [] true -> ({name}'=1); endmodule")
    };
    expect_words(
        &model(&text("cuont")),
        &["`cuont` cannot be updated: it is unknown", "did you mean `count`?"],
    );
    let constant = model(&text("count2"));
    expect_words(&constant, &["`count2` cannot be updated: it is not a variable"]);
    assert!(!constant.contains("did you mean"), "{constant}");
}

#[test]
fn an_operator_with_nothing_behind_it_is_told_as_such() {
    let read = |text: &str| rendered(parse_preferences(&SourceFile::new("p.pref", text)));
    expect_words(&read("objective A = F<=10;"), &["`F<=10` has no operand", "`F<=10 (condition)`"]);
    expect_words(&read("objective A = G;"), &["`G` has no operand"]);
    expect_words(&read("objective A = P>=1 [ F x=1 ];"), &["within the brackets of a property"]);
}
