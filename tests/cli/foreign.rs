//! Files of other programs: read, or refused by name.

use crate::common::prelude::*;

/// Runs `info` for the first of some files.
fn info(files: &[(&str, &str)]) -> Finished {
    let scratch = Scratch::new(files);
    Finished::of(executable().args(["info", &scratch.show(files[0].0), "--json"]))
}

/// Reads a property of the first of some files.
fn value(files: &[(&str, &str)], property: &str, constants: &[&str]) -> Json {
    let scratch = Scratch::new(files);
    let given = constants.iter().flat_map(|given| ["-c", *given]);
    let asked = ["reach", &scratch.show(files[0].0), "--json", "--property", property];
    Finished::of(executable().args(asked).args(given)).expect(0).json()["properties"][0]["value"].clone()
}

#[test]
fn what_is_not_read_is_refused_by_what_it_is_with_what_helps() {
    let drn = "@type: CTMC\n@parameters\n\n@nr_states\n1\n@model\nstate 0 init\n\taction 0\n\t\t0 : 1\n";
    for (name, text, message, help) in [
        // A dtmc was read.
        ("m.tra", "# Transitions (CTMC)\n2 2\n0 1 1\n1 1 1\n", "models of type CTMC are not supported", ""),
        ("m.tra", "# Transitions (POMDP)\n1 1 1 1\n0 0 0 1 0 a\n", "models with observations (POMDPs)", ""),
        ("m.tra", "# Transitions (LTS)\n2 2 2\n0 0 1\n1 0 1\n", "models of type LTS are not supported", ""),
        ("m.tra", "# Transitions (IMDP)\n2 2 2\n0 0 1 [1,1]\n", "models of type IMDP are not supported", ""),
        ("m.tra", "# Transitions (MDP)\n2 2\n0 1 1\n1 1 1\n", "has the numbers of the type `dtmc`", ""),
        ("m.tra", "2 2 2 1\n- - 0 - 0\n0 0 1 1 0 a\n1 0 1 1 0 a\n", "models with observations (POMDPs)", ""),
        ("m.tra", "2 2 2\n0 0 1:1 a\n1 0 1:1 b\n", "several transitions of a choice", "-exportrows`"),
        ("m.tra", "2 2\n0 1:1\n1 1:1\n", "several transitions of a choice", "-exportrows`"),
        ("m.tra", "2 2\n0 1 2\n1 1 3\n", "2 is not a probability", "rates of a CTMC are not supported"),
        ("m.tra", "2 3\n0 0 0.5\n0 1 0.75\n1 1 1\n", "sum to 1.25", "rates of a CTMC are not supported"),
        (
            "m.pexp",
            "2 2\n0 1 1\n1 1 1\n# Labels\n0=\"i\"\n0: 0\n# Labels\n0=\"i\"\n1: 0\n",
            "occurs twice",
            "",
        ),
        ("m.pexp", "2 2\n0 1 1\n1 1 1\n# Transitions (DTMC)\n1 1\n0 0 1\n", "occurs twice", ""),
        ("m.drn", drn, "models of type CTMC are not supported", ""),
        ("m.rddl", "domain walk {\n}\n", "RDDL is not supported", "PPDDL"),
        ("m.modest", "process P() { tau }\n", "Modest is not supported", "writes JANI"),
        ("m.jani", "{ // a walk\n\"jani-version\": 1}", "not JSON", "JSON has no comments"),
        ("m.jani", "// a walk\n{\"jani-version\": 1}", "not JSON", "JSON has no comments"),
        ("m.json", "/* a\n walk */ {\"jani-version\": 1}", "not JSON", "JSON has no comments"),
        ("m.txt", "(0):a\n(1):b\n", "a strategy that PRISM exported", "type=induced"),
        ("m.txt", "(0,true),0=a\n", "a strategy that PRISM exported", "type=induced"),
        ("m.txt", "0:1\n1:0\n", "a strategy that PRISM exported", "type=induced"),
        ("m.txt", "0,0:1\n", "a strategy that PRISM exported", "type=induced"),
        ("m.dot", "digraph M {\n0 -> 1;\n}\n", "a graph for pictures (DOT)", ""),
        ("m.txt", "3:north\n", "a strategy that PRISM exported", "type=induced"),
    ] {
        info(&[(name, text)]).ends(3, message).says(help);
    }
}

#[test]
fn labels_without_an_initial_state_say_what_is_missing() {
    for labels in ["0=\"end\"\n1: 0\n", "0=\"init\" 1=\"end\"\n1: 1\n"] {
        info(&[("m.tra", "2 2\n0 1 1\n1 1 1\n"), ("m.lab", labels)])
            .ends(3, "no state is labelled \"init\"")
            .says("m.lab:1:1");
    }
}

#[test]
fn a_label_with_blanks_is_read() {
    let files = [
        ("m.tra", "# Transitions (DTMC)\n3 4\n0 1 0.25\n0 2 0.75\n1 1 1\n2 2 1\n"),
        ("m.lab", "0=\"init\" 1=\"at the goal\"  2=\"x\"\n0: 0\n1: 1\n2: 2\n"),
    ];
    for (label, is) in [("at the goal", 0.25), ("x", 0.75)] {
        let found = value(&files, &format!("P=? [ F \"{label}\" ]"), &[]);
        assert_eq!(found, json!({"lower": is, "upper": is}), "{label}");
    }
    for labels in ["0=\"init\" 1=\"goal\n0: 0\n", "0=\"init\" 2=\"goal\"\n0: 0\n", "0=\"init\" goal\n0: 0\n"]
    {
        info(&[files[0], ("m.lab", labels)]).ends(3, "expected labels such as");
    }
}

#[test]
fn one_file_with_transitions_states_and_labels_is_read() {
    let text = "# Transitions (MDP)\n3 4 5\n0 0 1 0.25 a\n0 0 2 0.75 a\n0 1 1 1 b\n1 0 1 1 c\n2 0 2 1 c\n\
        # States\n(x,done)\n0:(5,false)\n1:(7,true)\n2:(6,false)\n\
        # Labels\n0=\"init\" 1=\"deadlock\" 2=\"at goal\"\n0: 0\n1: 2\n";
    // A file with the states of another model has no effect.
    for beside in [&[][..], &[("m.sta", "(y)\n0:(0)\n1:(1)\n2:(2)\n")]] {
        let files: Vec<_> = [("m.pexp", text)].iter().chain(beside).copied().collect();
        let found = info(&files).expect(0).json();
        let names: Vec<&Json> =
            found["model"]["variables"].as_array().unwrap().iter().map(|v| &v["name"]).collect();
        assert_eq!(names, [&json!("x"), &json!("done")]);
        assert_eq!(found["model"]["type"], json!("mdp"));
        let least = value(&files, "Pmin=? [ F \"at goal\" ]", &[]);
        let [lower, upper] = ["lower", "upper"].map(|side| least[side].as_f64().unwrap());
        assert!(lower <= 0.25 && 0.25 <= upper && upper - lower < 1e-9, "{least}");
        assert_eq!(value(&files, "Pmin=? [ F x=6 & !done ]", &[]), json!({"lower": 0.0, "upper": 0.0}));
    }
    let rewards = format!("{text}# Reward structure \"r\"\n# State rewards\n3 1\n0 1\n");
    info(&[("m.pexp", &rewards)]).ends(0, "a section `# Reward structure` is not read");
}

#[test]
fn the_type_of_a_drn_file_may_be_written_in_small_letters() {
    let text = "@type: mdp\n@parameters\n\n@reward_models\n\n@nr_states\n1\n@model\nstate 0 init\n\taction a\n\t\t0 : 1\n";
    assert_eq!(info(&[("m.drn", text)]).expect(0).json()["model"]["type"], json!("mdp"));
    let chain = text.replace("mdp", "Dtmc");
    assert_eq!(info(&[("m.drn", &chain)]).expect(0).json()["model"]["type"], json!("dtmc"));
}

#[test]
fn a_constant_may_be_given_as_a_fraction() {
    let model = "dtmc\nconst double p;\nmodule m\n s:[0..2];\n [] s=0 -> p:(s'=1)+(1-p):(s'=2);\n [] s>0 -> true;\nendmodule\n";
    let files = [("m.prism", model)];
    let third = value(&files, "P=? [ F s=1 ]", &["p=1/3"]);
    let [lower, upper] = ["lower", "upper"].map(|side| third[side].as_f64().unwrap());
    assert!(lower <= 1.0 / 3.0 && 1.0 / 3.0 <= upper && upper - lower < 1e-9, "{third}");
    // Exactly a third, of which the nearest double is less.
    let scratch = Scratch::new(&files);
    for (property, status) in [("P>=q [ F s=1 ]", 0), ("P>q [ F s=1 ]", 1)] {
        let file = format!("const double q = 1/3;\n{property};\n");
        scratch.write("m.props", file);
        scratch.run("reach m.prism --properties m.props -c 'p = 2 / 6'").expect(status);
    }
    scratch.run("reach m.prism --property 'P=? [ F s=1 ]' -c p={1/4,-1/-4}").expect(0);
    for (given, message) in
        [("p=1/0", "divides by 0"), ("p=1/", "expected a number"), ("p=1/x", "expected a number")]
    {
        scratch.run(format!("info m.prism -c '{given}'")).ends(3, message);
    }
}

#[test]
fn a_module_may_have_the_name_of_an_operator_of_properties() {
    let model = "mdp\nmodule A\n a:[0..1];\n [S] a=0 -> (a'=1);\nendmodule\nmodule F = A [a=b] endmodule\nsystem A || F endsystem\n";
    let found = info(&[("m.prism", model)]).expect(0).json();
    assert_eq!((&found["counts"]["states"], &found["counts"]["choices"]), (&json!("2"), &json!("2")));
    let scratch = Scratch::new(&[("m.prism", model)]);
    let flat = scratch.run("info m.prism --flat").expect(0).stdout;
    assert_eq!(info(&[("flat.prism", &flat)]).expect(0).json()["counts"], found["counts"]);
    info(&[("m.prism", &model.replace("a:", "A:"))])
        .ends(3, "`A` is a keyword and cannot be the name of a variable");
}

#[test]
fn the_state_of_a_model_without_variables_is_shown() {
    let model = "mdp\nmodule m\n [a] true -> true;\nendmodule\n";
    let scratch = Scratch::new(&[("m.prism", model), ("m.pref", "objective G = F true;")]);
    scratch.run("check m.prism m.pref").prints(0, "Initial state (no variables)\n");
    scratch.run("info m.prism").prints(0, "Variables\n  none\n");
    let json = scratch.run("check m.prism m.pref --json").expect(0).json();
    assert_eq!(json["initial"][0]["state"], json!({}));
}

#[test]
fn explicit_files_of_storm_have_their_kind_in_the_first_line() {
    let labels = ("m.lab", "#DECLARATION\ninit goal\n#END\n0 init\n1 goal\n2 goal\n");
    let mdp = ("m.tra", "mdp\n0 0 1 0.25\n0 0 3 0.75\n0 1 2 0.5\n0 1 3 0.5\n1 0 1 1\n2 0 2 1\n3 0 3 1\n");
    let greatest = value(&[mdp, labels], "Pmax=? [ F \"goal\" ]", &[]);
    assert_eq!(greatest, json!({"lower": 0.5, "upper": 0.5}));
    let dtmc = ("m.tra", "dtmc\n0 1 0.5\n0 3 0.5\n1 1 1\n3 3 1\n");
    let only = value(&[dtmc, labels], "P=? [ F \"goal\" ]", &[]);
    assert_eq!(only, json!({"lower": 0.5, "upper": 0.5}));
    // State 2 has no line: it is a deadlock.
    assert_eq!(info(&[dtmc, labels]).json()["counts"]["states"], "3");
    for (text, message) in [
        ("mdp\n0 0 900000 1\n", "no transitions of 900001 states"),
        ("mdp\n0 1\n", "expected `state choice target probability action`"),
        ("dtmc\n1 1 1\n0 0 1\n", "not sorted"),
    ] {
        info(&[("m.tra", text)]).ends(3, message);
    }
    let labels = ("m.lab", "#DECLARATION\ninit goal\n#END\n0 init away\n");
    info(&[dtmc, labels]).ends(3, "the label away is not in the first line");
}

#[test]
fn files_in_latin_1_are_read_with_a_warning() {
    let scratch = Scratch::new(&[("p.pref", "objective A = F x=1;\n")]);
    let model = b"// Mod\xe8le d'Andr\xe9\nmdp module m x : [0..1] init 0; [] x=0 -> (x'=1); [] x=1 -> true; endmodule\n";
    scratch.write("m.prism", model);
    scratch.write("m.props", b"// caf\xe9\nP>=1 [ F x=1 ];\n");
    let run = |arguments: &[&str]| Finished::of(executable().args(arguments));
    let (path, file) = (scratch.show("m.prism"), scratch.show("m.props"));
    let read = run(&["reach", &path, "--properties", &file]).expect(0);
    read.says("the file is not UTF-8, and is read as Latin-1");
    read.says("warning");
    scratch.write("m.bin", [0x89, 0x50, 0x4e, 0x47, 0xff, 0x00]);
    run(&["info", &scratch.show("m.bin")]).ends(3, "this is not UTF-8 text: byte 0 is invalid");
}

#[test]
fn probabilities_that_six_digits_round_are_scaled_with_a_warning() {
    let six =
        "0.142857:(s'=1)+0.142857:(s'=2)+0.142857:(s'=3)+0.142857:(s'=4)+0.142857:(s'=5)+0.285713:(s'=6)";
    let model = format!("mdp module m s:[0..6] init 0; [go] s=0 -> {six}; [] s>0 -> true; endmodule\n");
    let scratch = Scratch::new(&[("m.prism", &model)]);
    scratch.run("reach m.prism --property 'Pmax<0.28572 [ F s=6 ]'").ends(0, "sum to");
    let far = model.replace("0.285713", "0.28570");
    let scratch = Scratch::new(&[("m.prism", &far)]);
    scratch.run("info m.prism").expect(3);
}

/// The rewards next to PRISM's transitions were not read, and not mentioned.
#[test]
fn rewards_next_to_transitions_of_prism_are_read() {
    let tra = ("m.tra", "3 4 5\n0 0 1 0.5 a\n0 0 2 0.5 a\n0 1 2 1 b\n1 0 1 1\n2 0 2 1\n");
    let srew = ("m.srew", "# Reward structure \"cost\"\n# State rewards\n3 1\n0 5/2\n");
    let trew = ("m.trew", "# Reward structure \"cost\"\n# Transition rewards\n3 4 2\n0 0 1 3\n0 1 2 4\n");
    let bounds = |files: &[(&str, &str)], property: &str| {
        let found = value(files, property, &[]);
        ["lower", "upper"].map(|side| found[side].as_f64().unwrap())
    };
    for (files, most, least) in [
        (vec![tra, srew, trew], 6.5, 4.0),
        (vec![tra, srew], 2.5, 2.5),
        // Half of the paths of `a` earn 3.
        (vec![tra, trew], 4.0, 1.5),
    ] {
        assert_eq!(bounds(&files, "R{\"cost\"}max=? [ F state>0 ]"), [most; 2], "{files:?}");
        assert_eq!(bounds(&files, "R{\"cost\"}min=? [ F state>0 ]"), [least; 2], "{files:?}");
    }
    let dtmc = [
        ("d.tra", "2 2\n0 1 1\n1 1 1\n"),
        ("d1.srew", "# Reward structure: \"one\"\n2 0\n"),
        ("d2.trew", "# Reward structure \"two\"\n2 1\n0 1 7\n"),
    ];
    assert_eq!(bounds(&dtmc, "R{\"two\"}=? [ F state=1 ]"), [7.0; 2]);
    assert_eq!(bounds(&dtmc, "R{\"one\"}=? [ F state=1 ]"), [0.0; 2]);
    for (file, message) in [
        (("m.srew", "4 1\n0 1\n"), "the file has rewards of 4 states, the model has 3"),
        (("m.srew", "3 1\n3 1\n"), "state 3 is not one of 3"),
        (("m.srew", "3 1\n0 1 1\n"), "expected `state reward`"),
        (("m.trew", "3 4 1\n0 2 1 1\n"), "the model has no such transition"),
        (("m.trew", "3 4 1\n0 1 1 1\n"), "the model has no such transition"),
        (("m.trew", "3 4 1\n0 1 2 x\n"), "`x` is not a number"),
    ] {
        info(&[tra, file]).ends(3, message);
    }
}
