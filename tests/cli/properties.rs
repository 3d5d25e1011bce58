//! Property files.

use crate::common::prelude::*;

const MODEL: &str = "mdp\nmodule m\n x : [0..3] init 0;\n [a] x<3 -> 0.5: (x'=x+1) + 0.5: true;\n [b] x<2 -> true;\nendmodule\n";
const PROPERTIES: &str = "// what is asked of it\nconst int last = 3;\nlabel \"end\" = x=last;\n\
    \"sure\": Pmax>=1 [ F \"end\" ];\n\"always\": P>=1 [ F \"end\" ];\nP>0 [ F x=1 ]\n\
    \"number\": Pmax=? [ F \"end\" ]\n\"cost\": R{\"steps\"}min=? [ F \"end\" ];\n";

fn asked(more: &[&str]) -> Finished {
    let scratch = Scratch::new(&[("m.prism", MODEL), ("m.props", PROPERTIES)]);
    scratch.ask("reach m.prism --properties m.props", more)
}

#[test]
fn properties_are_answered_or_have_a_reason_why_not() {
    for engine in ["symbolic", "explicit"] {
        let found = asked(&["--json", "--engine", engine]).expect(1).json();
        let all = found["properties"].as_array().unwrap();
        let names: Vec<&Json> = all.iter().map(|p| &p["name"]).collect();
        assert_eq!(names, [&json!("sure"), &json!("always"), &Json::Null, &json!("number"), &json!("cost")]);
        let holds: Vec<&Json> = all.iter().map(|p| &p["holds"]).collect();
        assert_eq!(holds, [&json!(true), &json!(false), &json!(false), &Json::Null, &Json::Null]);
        assert_eq!((&all[0]["pmax_one"], &all[0]["pmin_one"]), (&json!("4"), &json!("2")));
        assert_eq!(all[3]["value"], json!({"lower": 1.0, "upper": 1.0}));
        let unknown = "the model has no reward structure; declare one in the model, or ask for a probability";
        assert_eq!(all[4]["reason"], json!(unknown));
        assert_eq!((&all[4]["line"], &all[4]["column"]), (&json!(8), &json!(9)));
        assert_eq!((&all[0]["line"], &all[0]["column"]), (&Json::Null, &Json::Null));
    }
    let shown = asked(&[]).expect(1).stdout;
    assert!(shown.contains("Not answered") && shown.contains("does not hold"), "{shown}");
    assert!(shown.contains("line 8, column 9: the model has no reward structure"), "{shown}");
}

#[test]
fn one_property_of_a_file_is_asked_by_its_name() {
    let found = asked(&["--json", "--only", "sure"]).expect(0).json();
    assert_eq!(found["properties"].as_array().unwrap().len(), 1);
    asked(&["--only", "none"]).expect(2);
    for question in [["--property", "P>0[Fx=1]"], ["--target", "x=1"]] {
        let scratch = Scratch::new(&[("m.prism", MODEL)]);
        scratch.ask("reach m.prism --only sure", question).ends(2, "`--only NAME` needs `--properties FILE`");
    }
}

#[test]
fn bounds_may_be_constants_of_the_model_or_the_file() {
    // From x=0 the end is reached within 3 steps with probability 1/8.
    let model = MODEL.replace("mdp", "mdp\nconst double half = 1/2;\nconst bool no = false;");
    let file = "const double p;\nconst int one = 1;\nP<=half [ F<=3 x=3 ];\nPmax>=p [ F<=3 x=3 ];\nP>=one [ F x>=0 ];\n\
        Pmax>q [ F x=3 ];\nPmax>no [ F x=3 ];\n";
    let scratch = Scratch::new(&[("m.prism", &model), ("m.props", file)]);
    let model = scratch.show("m.prism");
    for (p, holds) in [("0.125", true), ("0.126", false)] {
        let given = format!("p={p}");
        let found = scratch.run(format!("reach m.prism --properties m.props --json -c '{given}'"));
        let found = found.expect(if holds { 0 } else { 1 }).json();
        let verdicts: Vec<&Json> =
            found["properties"].as_array().unwrap().iter().map(|p| &p["holds"]).collect();
        assert_eq!(verdicts, [&json!(true), &json!(holds), &json!(true), &Json::Null, &Json::Null]);
        let reasons = [3, 4].map(|at: usize| found["properties"][at]["reason"].as_str().unwrap().to_owned());
        assert!(reasons[0].contains("unknown name `q`"), "{reasons:?}");
        assert!(reasons[1].contains("the constant `no` is not a finite number"), "{reasons:?}");
        assert_eq!(
            (&found["properties"][3]["line"], &found["properties"][3]["column"]),
            (&json!(6), &json!(6))
        );
    }
    scratch
        .run("reach m.prism --properties m.props")
        .prints(0, "line 4, column 7: the constant `p` has no value");
    let alone = ["reach", &model, "--property", "P<=half [ F<=3 x=3 ]"];
    Finished::of(executable().args(alone)).expect(0);
    Finished::of(executable().args([&alone[..], &["--stop-at-target"]].concat())).expect(0);
}

#[test]
fn a_model_without_an_initial_state_is_refused() {
    let model = MODEL.replace(" init 0", "").replace("endmodule", "endmodule\ninit x>3 endinit");
    let scratch = Scratch::new(&[
        ("m.prism", &model),
        ("m.props", "P>=1 [ F x=1 ];\nPmax=? [ F x=1 ];\n"),
        ("m.pref", "objective A = F x=1;\nobjective B = F x=2;\nprefer B > A;\n"),
    ]);
    let [file, props] = ["m.prism", "m.props"].map(|name| scratch.show(name));
    for engine in ["symbolic", "explicit"] {
        for question in [
            ["--property", "P>=1 [ F x=1 ]"],
            ["--property", "Pmax=? [ F x=1 ]"],
            ["--target", "x=1"],
            ["--properties", &props],
        ] {
            let asked = ["reach", &file, "--engine", engine].into_iter().chain(question);
            let refused = Finished::of(executable().args(asked)).expect(3).stderr;
            assert!(refused.contains("the model has no initial state"), "{refused}");
            assert!(refused.contains("m.prism:7:6") && refused.contains("init x>3 endinit"), "{refused}");
        }
    }
    for command in ["check", "strategy", "values", "simulate", "compare", "report"] {
        scratch.run(format!("{command} m.prism m.pref")).ends(3, "the model has no initial state");
    }
    scratch.run("export m.prism m.pref --out out").expect(3);
}

#[test]
fn constants_that_a_file_leaves_open_are_given_beside_those_of_the_model() {
    let model = MODEL.replace("mdp", "mdp\nconst int n;").replace("init 0", "init n");
    let file = "P>0 [ F \"end\" ];\nconst int last;\nconst double p;\nlabel \"end\" = x=last;\n\"free\": P>0 [ F x=1 ];\n\
        \"other\": P>0 [ F p>0.5 ];\n";
    let scratch = Scratch::new(&[("m.prism", &model), ("m.props", file)]);
    let ask = |given: &str| scratch.run(format!("reach m.prism --properties m.props --json -c '{given}'"));
    let found = ask("n=0,last=3,p=1").expect(1).json();
    let holds: Vec<&Json> = found["properties"].as_array().unwrap().iter().map(|p| &p["holds"]).collect();
    assert_eq!(holds, [&json!(false), &json!(false), &json!(true)]);
    let found = ask("last=0,n=0").expect(1).json();
    assert_eq!(found["properties"][0]["holds"], json!(true), "{found}");
    let reason = |found: &Json, at: usize| found["properties"][at]["reason"].as_str().unwrap().to_owned();
    assert!(reason(&found, 2).contains("the constant `p` has no value"), "{found}");
    let found = ask("n=0").expect(1).json();
    assert!(reason(&found, 0).contains("the constant `last` has no value: give it with `--const last=…`"));
    assert_eq!(found["properties"][1]["holds"], json!(false), "{found}");
    for (given, word) in [
        ("n=0,last=true", "type error: the constant `last`"),
        ("n=0,last=1,m=2", "the model has no constant `m`"),
        ("last=1", "`n`"),
    ] {
        ask(given).ends(3, word);
    }
}

#[test]
fn files_in_place_of_property_files_are_named() {
    let scratch = Scratch::new(&[
        ("m.prism", MODEL),
        ("m.jani", " {\"jani-version\": 1}"),
        ("m.pref", "prefer A > B;"),
    ]);
    let refused = |file: &str| {
        let (model, file) = (scratch.show("m.prism"), scratch.show(file));
        Finished::of(executable().args(["reach", &model, "--properties", &file])).expect(3).stderr
    };
    let jani = refused("m.jani");
    assert!(jani.contains("this is a JANI model, not a list of properties"), "{jani}");
    assert!(jani.contains("`--property NAME`"), "{jani}");
    assert!(refused("m.prism").contains("this is a model, not a list of properties"));
    assert!(refused("m.pref").contains("this is a preference file, not a list of properties"));
}

#[test]
fn a_constant_that_the_model_declares_is_refused_at_its_place() {
    let model = MODEL.replace("mdp", "mdp\nconst int n;").replace("init 0", "init n");
    let scratch = Scratch::new(&[("m.prism", &model), ("m.props", "P>0 [ F x=n ];\nconst int n;\n")]);
    let refused = scratch.run("reach m.prism --properties m.props -c n=1").expect(3).stderr;
    assert!(refused.contains("m.props:2:11") && refused.contains("`n` is declared already"), "{refused}");
    assert!(refused.contains("remove this declaration"), "{refused}");
}

#[test]
fn a_question_is_asked_for() {
    let scratch = Scratch::new(&[("m.prism", MODEL)]);
    scratch.run("reach m.prism").ends(2, "`--property PROPERTY`").says("names no properties");
    scratch.run("reach m.prism --all-properties").ends(2, "names no properties");
}

#[test]
fn an_open_constant_leaves_the_properties_that_do_not_need_it() {
    // What the definitions need, also one by the other, is needed by the properties that name them.
    let file = "const int k;\nconst int K = k+1;\nformula far = x>K;\nlabel \"far\" = far;\nlabel \"end\" = x=3;\n\
        \"a\": P>0 [ F \"end\" ];\n\"b\": Pmax=? [ F<=K \"end\" ];\n\"c\": P>0 [ F \"far\" ];\n\"d\": P>=K [ F far ];\n";
    let scratch = Scratch::new(&[("m.prism", MODEL), ("m.props", file)]);
    let ask = |more: &[&str]| {
        let found = scratch.ask("reach m.prism --properties m.props --json", more);
        found.expect(1).json()["properties"].as_array().unwrap().clone()
    };
    let found = ask(&[]);
    assert_eq!(found[0]["holds"], json!(false));
    for (property, line) in found[1..].iter().zip(7..) {
        let reason = property["reason"].as_str().unwrap();
        assert_eq!(reason, "the constant `k` has no value: give it with `--const k=…`");
        assert_eq!(property["line"], json!(line));
    }
    let found = ask(&["-c", "k=0"]);
    assert!(found.iter().all(|p| p.get("reason").is_none()), "{found:?}");
    // From x=0 the end is not within one step.
    assert_eq!(found[1]["value"]["upper"], json!(0.0));
    assert_eq!((&found[2]["holds"], &found[3]["holds"]), (&json!(false), &json!(false)));
}

#[test]
fn a_file_in_which_nothing_can_be_read_ends_with_status_3() {
    let status = |file: &str| {
        let scratch = Scratch::new(&[("m.prism", MODEL), ("m.props", file)]);
        let found = scratch.run("reach m.prism --properties m.props --json");
        let reasons = found.json()["properties"]
            .as_array()
            .unwrap()
            .iter()
            .filter(|p| p.get("reason").is_some())
            .count();
        (found.status, reasons, found.stderr.contains("none of the properties can be answered"))
    };
    assert_eq!(status("P>0 [ F y=1 ];\nP>0 [ F \"nowhere\" ];\n"), (3, 2, true));
    assert_eq!(status("P>0 [ F x= ];\n"), (3, 1, true));
    assert_eq!(status("S=? [ x=1 ];\n"), (3, 1, true));
    // Some can be read: the status is that of their answers.
    assert_eq!(status("P>0 [ F y=1 ];\nPmax>0 [ F x=1 ];\n"), (0, 1, false));
    assert_eq!(status("P>0 [ F y=1 ];\nPmax=? [ F x=1 ];\n"), (0, 1, false));
    assert_eq!(status("P>0 [ F y=1 ];\nPmax<=0 [ F x=1 ];\n"), (1, 1, false));
    let scratch = Scratch::new(&[
        ("m.prism", &MODEL.replace("mdp", "mdp const int n;")),
        ("m.props", "P>0 [ F y=n ];\n"),
    ]);
    let rows = scratch.run("reach m.prism --properties m.props -c n=1:2 --csv -").expect(3).stdout;
    assert!(
        rows.lines().skip(1).all(|row| row.contains(",not answered,") && row.ends_with(",error")),
        "{rows}"
    );
}

#[test]
fn a_wrong_reward_leaves_the_other_properties_of_a_file() {
    let model = format!("{MODEL}rewards \"r\"\n x=1 : -1;\nendrewards\n");
    let file = "\"cost\": R{\"r\"}min=? [ F x=3 ];\n\"end\": Pmax=? [ F x=3 ];\n";
    let scratch = Scratch::new(&[("m.prism", &model), ("m.props", file)]);
    let found = scratch.run("reach m.prism --properties m.props --json");
    let found = found.expect(0).json();
    let reason = found["properties"][0]["reason"].as_str().unwrap();
    assert!(reason.contains("earns -1 in the state x=1"), "{reason}");
    assert_eq!(found["properties"][1]["value"], json!({"lower": 1.0, "upper": 1.0}));
}

#[test]
fn a_name_of_the_model_is_not_defined_again() {
    let model = MODEL.replace("mdp", "mdp\nconst int c = 1;\nformula f = x>1;");
    let model = format!("{model}label \"one\" = x=1;\n");
    for (definition, place, first) in [
        // The answer was that of the second label.
        ("label \"one\" = x=2;", "m.props:1:7", "m.prism:9:7"),
        ("const int c = 2;", "m.props:1:11", "m.prism:2:11"),
        ("formula f = x>2;", "m.props:1:9", "m.prism:3:9"),
        ("formula x = 2;", "m.props:1:9", "m.prism:5:2"),
        ("const int f;", "m.props:1:11", "m.prism:3:9"),
    ] {
        let file = format!("{definition}\nPmax=? [ F \"one\" ];\n");
        let scratch = Scratch::new(&[("m.prism", &model), ("m.props", &file)]);
        scratch.run("reach m.prism --properties m.props").ends(3, place).says(first);
    }
    let unread =
        Scratch::new(&[("m.prism", MODEL), ("m.props", "label \"init\" = x=2;\nP>0 [ F \"init\" ];\n")]);
    unread.run("reach m.prism --properties m.props").ends(3, "init");
}

/// Such a file ended with status 0, as if all of its properties were true.
#[test]
fn a_file_without_a_property_is_refused() {
    for text in ["", "// nothing\n", "const int K = 3;\nlabel \"far\" = x=K;\n"] {
        let scratch = Scratch::new(&[("m.prism", MODEL), ("m.props", text)]);
        let refused = scratch.run("reach m.prism --properties m.props --json").expect(3).json();
        assert_eq!(
            (&refused["message"], &refused["file"]),
            (&json!("the file has no property"), &json!("m.props"))
        );
    }
}

#[test]
fn a_value_for_a_constant_that_the_file_defines_is_refused_with_its_place() {
    let file = "const int K = 3;\nP>0 [ F x=K ];\n";
    let scratch = Scratch::new(&[("m.prism", MODEL), ("m.props", file)]);
    for constants in ["K=2", "K=1:3"] {
        let refused = scratch.run(format!("reach m.prism --properties m.props -c '{constants}'")).expect(3);
        assert_eq!(refused.stderr.matches("error").count(), 1, "{}", refused.stderr);
        assert!(refused.stdout.is_empty(), "{refused:?}");
        refused.says("the constant `K` already has a value at m.props:1:11").says("`const int K;`");
    }
}

#[test]
fn an_unknown_reward_structure_is_told_with_those_that_there_are() {
    let named = |rewards: &str| {
        let scratch = Scratch::new(&[("m.prism", &format!("{MODEL}{rewards}"))]);
        scratch.run("reach m.prism --property 'R{\"x\"}max=? [ F x=3 ]'").expect(3).stderr
    };
    assert!(named("").contains("the model has no reward structure"));
    let unnamed = named("rewards true : 1; endrewards");
    assert!(
        unnamed.contains("unknown reward structure") && unnamed.contains("leave out the braces"),
        "{unnamed}"
    );
    let others = named("rewards \"time\" true : 1; endrewards rewards \"cost\" true : 2; endrewards");
    assert!(others.contains("the reward structures are \"time\", \"cost\""), "{others}");
}
