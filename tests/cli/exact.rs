//! Exact values decide which branches exist, in every format and both engines; and exact arithmetic
//! ends.

use crate::common::prelude::*;

/// The answer to a question about a model, the same under both engines.
#[track_caller]
fn holds(scratch: &Scratch, arguments: &[&str], property: &str) -> bool {
    let answers = ["symbolic", "explicit"].map(|engine| {
        let mut command = executable();
        command.args(["reach", "--json", "--engine", engine, "--property", property]);
        command.arg(scratch.show(arguments[0])).args(&arguments[1..]);
        let run = Finished::of(&mut command);
        assert!(run.status <= 1, "{run:#?}");
        run.json()["holds"].as_bool().unwrap()
    });
    assert_eq!(answers[0], answers[1], "{arguments:?} {property}");
    answers[0]
}

#[track_caller]
fn decides(model: &str, property: &str, expected: bool) {
    let scratch = Scratch::new(&[("m", model)]);
    assert_eq!(holds(&scratch, &["m"], property), expected, "{property}\n{model}");
}

fn step(p: &str, rest: &str) -> String {
    format!("mdp module m x:[0..2] init 0; [a] x=0 -> {p}:(x'=1) + {rest}:(x'=0); endmodule")
}

#[test]
fn doubles_neither_invent_a_branch_nor_lose_one() {
    for (p, exists) in [
        ("(0.1+0.2-0.3)", false),
        ("(3*0.1-0.3)", false),
        ("1e-400", true),
        ("(1-(1-1e-17))", true),
        ("pow(0.1,400)", true),
        ("(1/3-0.3333333333333333)", true),
        ("(x=0 ? 1e-400 : 0.5)", true),
        ("(1e-200*1e-200*(x+1))", true),
        ("((x+1)*0.1+0.2-0.3)", false),
    ] {
        decides(&step(p, &format!("(1-{p})")), "Pmax>0 [ F x=1 ]", exists);
        decides(&step(p, &format!("(1-{p})")), "Pmax>=1 [ F x=1 ]", exists);
    }
}

#[test]
fn doubles_do_not_decide_guards_labels_targets_and_bounds() {
    let model = "mdp const double p = 1e-400; formula f = 0.1*(x+1)+0.2; module m x:[0..2] init 0;\n\
        [a] 0.1+0.2=0.3 & f=0.3 & p>0 & ceil(10*f)=3 -> (x'=1); endmodule\nlabel \"l\" = f=0.4;";
    for (property, expected) in [
        ("Pmax>=1 [ F x=1 ]", true),
        ("Pmax>=1 [ F \"l\" ]", true),
        ("Pmax>=1 [ F (f=0.4 & p>0) ]", true),
        ("Pmax>0 [ F (f>0.4 | p=0) ]", false),
        ("Pmax>0 [ F floor(10*f)=2 ]", false),
    ] {
        decides(model, property, expected);
    }
    let likely = step("(1-1e-17)", "0").replace("+ 0:(x'=0)", "+ 1e-17:(x'=2)");
    decides(&likely, "Pmax>=1 [ F x=1 ]", false);
    decides(&likely, "Pmax>=0.99999999999999999 [ F x=1 ]", true);
    decides(&likely, "Pmax>=0.999999999999999999 [ F x=1 ]", false);
    decides(&likely, "Pmax>1e-400 [ F x=2 ]", true);
}

#[test]
fn constants_of_the_command_line_and_of_sweeps_are_exact() {
    let model = step("p", "(1-p)").replace("module m x", "const double p; module m x");
    let scratch = Scratch::new(&[("m", &model), ("m.pref", "objective A = F x=1;")]);
    for (p, exists) in [("1e-400", true), ("0.0", false), ("0", false), ("0.00000000000000000000001", true)] {
        assert_eq!(holds(&scratch, &["m", "-c", &format!("p={p}")], "Pmax>=1 [ F x=1 ]"), exists, "{p}");
    }
    let [model, prefs, out] = ["m", "m.pref", "out"].map(|name| scratch.show(name));
    let run = |arguments: &[&str]| Finished::of(executable().args(arguments)).expect(0);
    run(&["export", &model, &prefs, "-c", "p=1e-400", "--out", &out]);
    run(&["verify", &out, &model, &prefs]);
    let text = std::fs::read_to_string(scratch.path("out").join("manifest.json")).unwrap();
    let manifest: Json = serde_json::from_str(&text).unwrap();
    assert_eq!(manifest["exact"]["p"], "1e-400");
}

/// A model of two states in DRN, with a probability and the rest.
fn drn(p: &str, rest: &str) -> String {
    format!(
        "@type: MDP\n@parameters\n\n@reward_models\n\n@nr_states\n2\n@nr_choices\n2\n@model\n\
         state 0 init\n\taction a\n\t\t0 : {rest}\n\t\t1 : {p}\nstate 1 one\n\taction a\n\t\t1 : 1\n"
    )
}

#[test]
fn models_state_by_state_and_jani_are_exact() {
    let power = format!("1/1{}", "0".repeat(400));
    for p in ["1e-400", &power, "0.00000000000000000000001"] {
        decides(&drn(p, "1"), "Pmax>=1 [ F \"one\" ]", true);
        decides(&format!("2 2 3\n0 0 0 1\n0 0 1 {p}\n1 0 1 1\n"), "Pmax>=1 [ F state=1 ]", true);
    }
    decides(&drn("0e-400", "1"), "Pmax>0 [ F \"one\" ]", false);
    let jani = |p: &str| {
        format!(
            r#"{{"jani-version":1,"name":"m","type":"mdp","actions":[{{"name":"a"}}],"variables":[
            {{"name":"x","type":{{"kind":"bounded","base":"int","lower-bound":0,"upper-bound":1}},"initial-value":0}}],
            "automata":[{{"name":"m","locations":[{{"name":"l"}}],"initial-locations":["l"],"edges":[{{"location":"l",
            "action":"a","destinations":[{{"location":"l","probability":{{"exp":{p}}},"assignments":[{{"ref":"x","value":1}}]}},
            {{"location":"l","probability":{{"exp":{{"op":"-","left":1,"right":{p}}}}}}}]}}]}}],
            "system":{{"elements":[{{"automaton":"m"}}]}}}}"#
        )
    };
    decides(&jani("1e-400"), "Pmax>=1 [ F x=1 ]", true);
    let nothing = r#"{"op":"-","left":{"op":"+","left":0.1,"right":0.2},"right":0.3}"#;
    decides(&jani(nothing), "Pmax>0 [ F x=1 ]", false);
}

#[test]
fn what_is_written_reads_back_with_the_same_branches() {
    let model = "mdp module m x:[0..2] init 0; [a] x=0 -> 1e-400:(x'=1) + (1-1e-400-1/3):(x'=0) + 1/3:true;\n\
        [b] x=0 -> pow(2,-1200.0):(x'=2) + (1-pow(2,-1200.0)):(x'=0); endmodule";
    let scratch =
        Scratch::new(&[("m.prism", model), ("p.pref", "objective A = F x=1; objective B = F x=2;")]);
    let file = scratch.show("m.prism");
    let asked = |model: &str| {
        let json = Finished::of(executable().args(["info", model, "--json"])).expect(0).json();
        [json["counts"]["states"].clone(), json["counts"]["transitions"].clone()]
    };
    let expected = asked(&file);
    for (format, written) in [("umb", "model.umb"), ("drn", "model.drn"), ("explicit", "model.tra")] {
        let out = scratch.show(format);
        scratch.run(format!("export m.prism p.pref --format {format} --out {out}")).expect(0);
        assert_eq!(asked(&format!("{out}/{written}")), expected, "{format}");
    }
    let flat = scratch.run("info m.prism --flat").expect(0).stdout;
    scratch.write("flat.prism", flat);
    assert_eq!(asked(&scratch.show("flat.prism")), expected);
}

#[test]
fn sums_are_judged_exactly_within_a_tolerance() {
    let model = |p: &str| step(p, &format!("{p}:(x'=2) + {p}"));
    let said = |p: &str| {
        let scratch = Scratch::new(&[("m", &model(p))]);
        ["symbolic", "explicit"].map(|engine| {
            let run = scratch.run(format!("info m --engine {engine}"));
            (run.status, run.stderr.contains("sum to 0.999"), run.stderr.contains("give 0.999"))
        })
    };
    assert_eq!(said("1/3"), [(0, false, false); 2]);
    assert_eq!(said("0.3333333333"), [(0, false, false); 2]);
    assert_eq!(said("0.333333"), [(0, true, false); 2]);
    assert_eq!(said("0.333"), [(3, false, true); 2]);
}

#[test]
fn a_double_that_counts_for_an_exact_value_is_reported() {
    for (p, is_exact) in [
        ("log(2,3)", false),
        ("pow(0.5,0.5)", false),
        ("pow(0.99999,8760)", false),
        ("pow(0.5,x+0.5)", false),
        ("(log(8,4)-1)", true),
        ("pow(0.25,0.5)", true),
        ("pow(0.5,x+1)", true),
        ("pow(0.99,365)", true),
    ] {
        let scratch = Scratch::new(&[("m", &step(p, &format!("(1-{p})")))]);
        let run = scratch.run("info m --json").expect(0);
        assert_eq!(run.stderr.contains("a double counts"), !is_exact, "{p}: {}", run.stderr);
        assert_eq!(run.json()["model"]["inexact"].is_null(), is_exact, "{p}");
        let text = scratch.run("info m").expect(0).stdout;
        assert_eq!(text.contains("a double counts for an exact value at"), !is_exact, "{p}: {text}");
    }
}

#[test]
fn exact_arithmetic_is_bounded() {
    let digits = format!("0.{}", "7".repeat(1_000_000));
    for (p, said) in [
        ("pow(0.9,1000000)", "more than 16384 bits"),
        ("pow(1-1e-20,100000)", "more than 16384 bits"),
        ("(pow(1/3,8000)+pow(1/7,5000))", "more than 16384 bits"),
        ("1e-99999999", "more than 4931 decimal digits"),
        (&digits, "more than 4931 decimal digits"),
    ] {
        let scratch = Scratch::new(&[("m", &step(p, "1"))]);
        let run = scratch.run("info m").expect(3);
        run.says(said).says("m:1:");
        assert!(run.stderr.len() < 10_000, "{said}: {} bytes", run.stderr.len());
    }
    decides(
        &step("(1-pow(pow(0.9999999999,1000),1000))", "pow(pow(0.9999999999,1000),1000)"),
        "Pmax>=1 [ F x=1 ]",
        true,
    );
    let scratch = Scratch::new(&[("m", &drn(&digits, "1"))]);
    scratch.run("info m").ends(3, "more than 4931 decimal digits");
}

#[test]
fn formulas_that_double_are_evaluated_once_by_every_command() {
    let double = |i: usize| format!("formula f{i} = f{0}+f{0};\n", i - 1);
    let formulas = (1..=60).map(double).collect::<String>();
    let model = format!(
        "mdp\nformula f0 = x/pow(2,60);\n{formulas}module m\n x:[0..1] init 0;\n\
        [a] f60<10 -> f60/2+0.5:(x'=1) + 0.5-f60/2:(x'=0);\nendmodule\nlabel \"l\" = f60>0;\n"
    );
    let scratch = Scratch::new(&[("m.prism", &model), ("m.pref", "objective A = F f60=1;")]);
    for engine in ["symbolic", "explicit"] {
        for command in ["check", "strategy", "simulate", "values"] {
            scratch.run(format!("{command} m.prism m.pref --engine {engine}")).expect(0);
        }
    }
    for format in ["dddmp", "drn"] {
        scratch.run(format!("export m.prism m.pref --format {format} --out out-{format}")).expect(0);
    }
}

#[test]
fn cycles_of_many_formulas_are_reported_shortly() {
    let n = 20_000;
    let formulas: String = (0..n).map(|i| format!("formula f{i} = f{}+f0;\n", (i + 1) % n)).collect();
    let scratch = Scratch::new(&[("m", &format!("mdp\n{formulas}module m x:[0..1]; endmodule"))]);
    let run = scratch.run("info m").expect(3);
    run.says("the formula `f0` depends on itself");
    assert!(run.stderr.contains("more) -> f0") && run.stderr.len() < 100_000, "{} bytes", run.stderr.len());
}

/// A fraction of 400 digits was said to have no upper bound, although the report had it.
#[test]
fn a_fraction_beyond_all_doubles_is_a_value() {
    let model = "mdp module m x:[0..2] init 0; [] x=0 -> 1e-400:(x'=2) + (1-1e-400):(x'=1); [] x=1 -> (x'=0); endmodule";
    let scratch = Scratch::new(&[("m", model), ("p", "objective A = F x=1;\nempty = gain;")]);
    let values = |options: &[&str]| {
        let mut command = executable();
        command.args(["values", "--json", "--safety", "action"]).args(options);
        Finished::of(command.args([scratch.show("m"), scratch.show("p")]))
    };
    values(&[]).expect(4);
    let number = &values(&["--exact"]).expect(0).json()["states"][0]["number"];
    assert_eq!(number["exact"], json!("9".repeat(400)), "(1-p)/p with p = 10^-400");
}
