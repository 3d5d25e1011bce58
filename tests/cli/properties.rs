//! Property files.

use serde_json::{Value as Json, json};

use crate::common::{Finished, Scratch, meliora};

const MODEL: &str = "mdp\nmodule m\n x : [0..3] init 0;\n [a] x<3 -> 0.5: (x'=x+1) + 0.5: true;\n [b] x<2 -> true;\nendmodule\n";
const PROPERTIES: &str = "// what is asked of it\nconst int last = 3;\nlabel \"end\" = x=last;\n\
    \"sure\": Pmax>=1 [ F \"end\" ];\n\"always\": P>=1 [ F \"end\" ];\nP>0 [ F x=1 ]\n\
    \"number\": Pmax=? [ F \"end\" ]\n\"cost\": R{\"steps\"}min=? [ F \"end\" ];\n";

fn asked(more: &[&str]) -> Finished {
    let scratch = Scratch::new(&[("m.prism", MODEL), ("m.props", PROPERTIES)]);
    let (model, file) = (scratch.show("m.prism"), scratch.show("m.props"));
    Finished::of(meliora().args(["reach", &model, "--properties", &file]).args(more))
}

#[test]
fn the_qualitative_ones_are_answered_and_the_others_have_a_reason() {
    for engine in ["symbolic", "explicit"] {
        let found = asked(&["--json", "--engine", engine]).expect(1).json();
        let all = found["properties"].as_array().unwrap();
        let names: Vec<&Json> = all.iter().map(|p| &p["name"]).collect();
        assert_eq!(names, [&json!("sure"), &json!("always"), &Json::Null, &json!("number"), &json!("cost")]);
        let holds: Vec<&Json> = all.iter().map(|p| &p["holds"]).collect();
        assert_eq!(holds, [&json!(true), &json!(false), &json!(false), &Json::Null, &Json::Null]);
        assert_eq!((&all[0]["pmax_one"], &all[0]["pmin_one"]), (&json!("4"), &json!("2")));
        assert!(all[4]["reason"].as_str().unwrap().contains('R'), "{}", all[4]);
    }
    let shown = asked(&[]).expect(1).stdout;
    assert!(shown.contains("Not answered") && shown.contains("does not hold"), "{shown}");
}

#[test]
fn one_of_them_is_asked_by_its_name() {
    let found = asked(&["--json", "--only", "sure"]).expect(0).json();
    assert_eq!(found["properties"].as_array().unwrap().len(), 1);
    asked(&["--only", "none"]).expect(2);
}
