//! Exit statuses: the contract that scripts rely on.

use crate::cli::common::{Finished, LONG, LONG_PREFS, Scratch, executable, run};

#[test]
fn work_that_is_done_ends_with_0() {
    run("check models/toy.prism models/toy.pref").expect(0);
    run("reach models/toy.prism --target s=3").expect(0);
    run("info models/toy.prism").expect(0);
    run("compare models/toy.prism models/toy.pref").expect(0);
}

#[test]
fn help_and_version_go_to_stdout_with_0() {
    run("--help").prints(0, "Usage");
    run("check --help").prints(0, "--safety");
    let version = run("--version").expect(0).stdout;
    assert!(version.starts_with("meliora "), "{version}");
    for part in ["\ncommit ", "\nfeatures cli, output, supervise\n", "\noxidd 0."] {
        assert!(version.contains(part), "{version}");
    }
    assert_eq!(run("-V").expect(0).stdout.lines().count(), 1);
}

#[test]
fn wrong_usage_ends_with_2_and_nothing_on_stdout() {
    for arguments in [
        "",
        "chekc",
        "check models/toy.prism",
        "check models/toy.prism models/toy.pref --safety most",
        "check models/toy.prism models/toy.pref --max-level 0",
        "check models/toy.prism models/toy.pref --memory much",
        "check models/toy.prism models/toy.pref --memory 0",
        "check models/toy.prism models/toy.pref --timeout soon",
        "check models/toy.prism models/toy.pref --threads 0",
        "check models/toy.prism models/toy.pref --const K",
        "check models/toy.prism models/toy.pref -q -v",
        "check models/toy.prism models/toy.pref --engine explicit --order declared",
        "reach models/toy.prism",
        "reach models/toy.prism --target s=1 --property P>0[Fs=1]",
        "reach models/toy.prism --target s=1 --safety action",
        "info models/toy.prism --max-level 3",
        "info models/toy.prism --flat --json",
        "compare models/toy.prism models/toy.pref --engine symbolic",
        "completions klingon",
        "man klingon",
    ] {
        let finished = run(arguments).expect(2);
        assert!(!finished.stderr.is_empty(), "{arguments}");
        if !arguments.contains("--json") {
            assert_eq!(finished.stdout, "", "{arguments}");
        }
    }
}

#[test]
fn files_that_cannot_be_read_end_with_3_and_are_named() {
    let scratch = Scratch::new(&[]);
    scratch.write("bytes.prism", b"mdp \xff\xfe");
    for file in ["missing.prism", "bytes.prism", "."] {
        let path = scratch.show(file);
        let finished = run!("info {path}").expect(3);
        finished.says(&path);
        assert_eq!(finished.stdout, "");
    }
    run("check models/toy.prism missing.pref").expect(3);
}

#[test]
fn a_wrong_model_ends_with_3_and_shows_the_place() {
    let scratch = Scratch::new(&[(
        "m.prism",
        "mdp\nmodule m\n  x : [0..2] init 0;\n  [] x<2 -> (x'=y+1);\nendmodule\n",
    )]);
    let finished = run!("info {}", scratch.show("m.prism")).expect(3);
    finished.says("m.prism:4:");
    finished.says("[] x<2 -> (x'=y+1);");
}

#[test]
fn an_update_out_of_range_names_an_example_state() {
    let scratch = Scratch::new(&[(
        "m.prism",
        "mdp\nmodule m\n  x : [0..2] init 0;\n  [] x<=2 -> (x'=x+1);\nendmodule\n",
    )]);
    for engine in ["symbolic", "explicit"] {
        run!("info {} --engine {engine}", scratch.show("m.prism")).ends(3, "x=2");
    }
}

#[test]
fn constants_that_are_unknown_or_missing_end_with_3() {
    let scratch = Scratch::new(&[("long.prism", LONG)]);
    let path = scratch.show("long.prism");
    run!("info {path} -c N=5").expect(0);
    let missing = run!("info {path}").expect(3);
    assert!(missing.stderr.contains('N'), "{}", missing.stderr);
    let unknown = run!("info {path} -c N=5,M=2").expect(3);
    assert!(unknown.stderr.contains('M'), "{}", unknown.stderr);
    run!("info {path} -c N=five").expect(3);
    run!("info {path} -c N=5 -c N=6").expect(3);
}

#[test]
fn a_wrong_target_ends_with_3_and_names_the_option() {
    run("reach models/toy.prism --target s=").ends(3, "--target");
    run("reach models/toy.prism --target nobody").expect(3);
    run("reach models/toy.prism --target s+1").expect(3);
}

#[test]
fn a_wrong_order_file_ends_with_3() {
    let scratch = Scratch::new(&[("order", "nobody\n"), ("good", "s\n")]);
    run!("info models/toy.prism --order {}", scratch.show("order")).expect(3);
    run!("info models/toy.prism --order {}", scratch.show("good")).expect(0);
    run("info models/toy.prism --order nowhere").expect(3);
}

#[test]
fn too_little_memory_ends_with_4_or_works_but_never_panics() {
    for engine in ["symbolic", "explicit"] {
        for memory in ["1", "1KiB", "64KiB", "1MiB"] {
            let arguments = format!(
                "check models/robot5x5.prism models/robot5x5.pref --scope all --engine {engine} --memory {memory}"
            );
            let finished = run(&arguments);
            assert!([0, 4].contains(&finished.status), "{finished:#?}");
            if finished.status == 4 {
                finished.says("--memory");
            }
        }
    }
}

#[test]
fn the_explicit_engine_says_how_many_states_fitted_its_memory() {
    let scratch = Scratch::new(&[("long.prism", LONG), ("long.pref", LONG_PREFS)]);
    let (model, preferences) = (scratch.show("long.prism"), scratch.show("long.pref"));
    for scope in ["reachable", "all"] {
        let arguments = format!("check {model} {preferences} -c N=1000 --engine explicit --scope {scope}");
        run!("{arguments} --memory 14MiB").ends(4, "states reached so far");
    }
}

#[test]
fn a_property_is_answered() {
    let answers = |property: &str, holds: bool| {
        assert_eq!(
            Finished::of(executable().args(["reach", "models/toy.prism", "--json", "--property", property]))
                .expect(i32::from(!holds))
                .json()["holds"],
            holds
        );
    };
    answers("Pmax>=1 [ F s=1 ]", true);
    answers("P>=1 [ F s=1 ]", false);
    answers("P<1 [ F s=3 ]", true);
    answers("P<1 [ F s=1 ]", false);
}
