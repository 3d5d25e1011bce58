//! Output streams: results on stdout, everything else on stderr, colours on request and on terminals.

use crate::cli::common::{Finished, Scratch, executable, run};

const TOY: [&str; 3] = ["check", "models/toy.prism", "models/toy.pref"];

/// A model with a deadlock, and preferences with an empty target.
fn suspicious() -> Scratch {
    Scratch::new(&[
        ("m.prism", "mdp\nmodule m\n  x : [0..2] init 0;\n  [a] x<2 -> (x'=x+1);\nendmodule\n"),
        ("m.pref", "objective A = F x=2; objective B = F (x=2 & x=1); prefer B > A;\n"),
    ])
}

#[test]
fn the_report_names_its_inputs() {
    let finished = Finished::of(executable().args(TOY)).expect(0);
    finished.shows("models/toy.prism");
    finished.shows("models/toy.pref");
    assert_eq!(finished.stderr, "");
}

#[test]
fn counts_have_thousands_separators() {
    let finished =
        run("check models/robot5x5.prism models/robot5x5.pref --scope all --safety transition").expect(0);
    finished.shows("18,496");
    finished.shows("1,946");
}

#[test]
fn warnings_go_to_stderr_and_q_silences_them() {
    let scratch = suspicious();
    let arguments = format!("check {} {}", scratch.show("m.prism"), scratch.show("m.pref"));
    let loud = run(&arguments).expect(0);
    loud.says("objective `B`");
    loud.says("deadlock");
    let quiet = run!("{arguments} -q").expect(0);
    assert_eq!(quiet.stderr, "");
    quiet.shows("m.prism");
}

#[test]
fn the_option_v_tells_of_phases_on_stderr_only() {
    let plain = run("check models/toy.prism models/toy.pref --json").expect(0);
    let verbose = run("check models/toy.prism models/toy.pref --json -v").expect(0);
    assert_eq!(plain.stderr, "");
    verbose.says("outcomes");
    assert_eq!(plain.json()["sasi"], verbose.json()["sasi"]);
}

#[test]
fn colours_are_used_where_they_are_wanted() {
    let escapes = |arguments: &[&str], no_color: bool| {
        let mut command = executable();
        command.args(TOY).args(arguments);
        if no_color {
            command.env("NO_COLOR", "1");
        }
        Finished::of(&mut command).expect(0).stdout.contains('\u{1b}')
    };
    assert!(!escapes(&[], false), "a pipe is no terminal");
    assert!(!escapes(&["--color", "auto"], true));
    assert!(escapes(&["--color", "always"], false));
    assert!(escapes(&["--color", "always"], true), "the option is stronger than NO_COLOR");
    assert!(!escapes(&["--color", "never"], false));
    assert!(!escapes(&["--json", "--color", "always"], false), "JSON has no colours");
}

#[test]
fn errors_heed_the_colour_settings() {
    let finished = run("info missing --color always").expect(3);
    assert!(finished.stderr.contains('\u{1b}'), "{}", finished.stderr);
    assert!(!run("info missing").expect(3).stderr.contains('\u{1b}'));
}

#[test]
fn completions_and_manual_are_there() {
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        run!("completions {shell}").prints(0, "meliora").shows("reach");
    }
    run("man").prints(0, ".TH meliora");
    run("man check").prints(0, "safety");
}

#[test]
fn flat_shows_what_the_engines_work_on() {
    let scratch = Scratch::new(&[(
        "m.prism",
        "mdp\nconst int N = 2;\nformula low = x<N;\nmodule a\n  x : [0..N] init 0;\n  [s] low -> 0.5: (x'=x+1) + 0.5: true;\n\
         endmodule\nmodule b = a [x=y] endmodule\n",
    )]);
    let text = run!("info {} --flat", scratch.show("m.prism")).expect(0).stdout;
    let text = text.replace(' ', "");
    for part in ["constintN=2;", "moduleb", "y:[0..2]", "(y'=y+1)"] {
        assert!(text.contains(part), "{part} is missing in\n{text}");
    }
    assert!(!text.contains("formulalow"), "{text}");
}

#[cfg(unix)]
#[test]
fn names_of_files_are_no_orders_to_a_terminal() {
    let text = |name: &str| std::fs::read_to_string(format!("models/toy.{name}")).unwrap();
    let (model, preferences) = (text("prism"), text("pref"));
    let name = "a\u{1b}[2J\u{9b}31m\u{202e}x";
    let wrong = format!("w\u{1b}[2J{name}");
    let scratch = Scratch::new(&[(name, &model), ("p.pref", &preferences), (&wrong, "mdp \u{1b}[2J =")]);
    let [good, wrong, missing] = [name, &wrong, "\u{7}no"].map(|name| scratch.show(name));
    let preferences = scratch.show("p.pref");
    for arguments in [
        vec!["check", &good, &preferences],
        vec!["info", &good],
        vec!["reach", &good, "--target", "s=1"],
        vec!["report", &good, &preferences, "--format", "svg"],
        vec!["check", &wrong, &preferences],
        vec!["check", &missing, &preferences],
        vec!["query", &missing, "\u{1b}[2J"],
    ] {
        let finished = Finished::of(executable().args(&arguments));
        for text in [&finished.stdout, &finished.stderr] {
            let hides =
                |c| matches!(c, '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
            let unsafe_character = text.chars().find(|&c| c != '\n' && (c.is_control() || hides(c)));
            assert_eq!(unsafe_character, None, "{arguments:?}: {text:?}");
        }
    }
}

/// A class with too many outcomes ended the command with an error, without the other results.
#[test]
fn jointly_above_its_limit_says_so_and_keeps_the_report() {
    let many: String = (0..11).map(|i| format!("objective o{i} = F s>={};", i % 3)).collect();
    let scratch = Scratch::new(&[("many.pref", &many)]);
    let command = format!("check models/toy.prism {} --jointly", scratch.show("many.pref"));
    let text = run(&command).expect(0).stdout;
    assert!(text.contains("not computed: more than 10 objectives"), "{text}");
    assert!(text.contains("Levels") && text.contains("Initial state"), "{text}");
    let json = run!("{command} --json").expect(0).json();
    let classes = json["classes"].as_array().unwrap();
    let large: Vec<_> = classes.iter().filter(|class| class["jointly_limit"] == 10).collect();
    assert!(!large.is_empty() && large.iter().all(|class| class.get("jointly").is_none()), "{classes:?}");
}
