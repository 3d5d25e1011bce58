//! Preference files over a program: their meaning and their errors.

use meliora::model::preference::Comparison;

use crate::common::prelude::*;

const MODEL: &str = "mdp\nmodule m\n  x : [0..3] init 0;\n  [] x<3 -> (x'=x+1);\nendmodule\n\
                     label \"done\" = x=3;\nformula half = x>=2;\n";

fn program() -> Program {
    parsed(MODEL)
}

fn load(text: &str) -> Result<Preferences, Error> {
    Ok(lang::load_preferences(&SourceFile::new("p.pref", text), program())?.preferences)
}

/// The rendered errors of a text.
fn errors(text: &str) -> String {
    match load(text) {
        Err(Error::Input(diagnostics)) => render(&diagnostics, false),
        other => panic!("no error: {other:?}"),
    }
}

const THREE: &str = "objective A = F \"done\"; objective B = F half; objective C = F x=1;\n";

#[test]
fn sides_and_chains_speak_of_every_pair_of_neighbours() {
    let preferences = load(&format!("{THREE}prefer A > B, C;")).unwrap();
    assert_eq!(preferences.order.compare(0, 1), Comparison::Preferred);
    assert_eq!(preferences.order.compare(0, 2), Comparison::Preferred);
    assert_eq!(preferences.order.compare(1, 2), Comparison::Incomparable);
    let preferences = load(&format!("{THREE}prefer C > B ~ A;")).unwrap();
    assert_eq!(preferences.order.compare(2, 0), Comparison::Preferred);
    assert_eq!(preferences.order.compare(0, 1), Comparison::Indifferent);
}

#[test]
fn nothing_is_worth_least_unless_stated() {
    assert_eq!(load(THREE).unwrap().empty, Empty::Bottom);
    for (word, empty) in
        [("bottom", Empty::Bottom), ("gain", Empty::Gain), ("incomparable", Empty::Incomparable)]
    {
        assert_eq!(load(&format!("{THREE}empty = {word};")).unwrap().empty, empty);
    }
}

#[test]
fn several_errors_are_told_at_once() {
    let text = errors("objective A = F x=1;\nobjective A = F y;\nobjective B = F x;\nprefer A > Z;\n");
    for part in [
        "`A` is declared twice",
        "declared here first",
        "unknown name `y`",
        "must be of type `bool`",
        "unknown objective `Z`",
        "the objectives are `A`, `B`",
        "p.pref:4:12",
    ] {
        assert!(text.contains(part), "{part} is missing in\n{text}");
    }
}

#[test]
fn a_contradiction_shows_its_cycle() {
    let text = errors(&format!("{THREE}prefer A > B;\nprefer B >= C;\nprefer C ~ A;\n"));
    assert!(text.contains("A > B >= C ~ A"), "{text}");
    assert_eq!(text.matches("together with this").count(), 2, "{text}");
    let text = errors(&format!("{THREE}prefer A > A;"));
    assert!(text.contains("A > A"), "{text}");
}

#[test]
fn a_file_without_objectives_is_refused() {
    assert!(errors("").contains("the file declares no objective"));
    assert!(errors("empty = gain;").contains("the file declares no objective"));
}

#[test]
fn a_dtmc_draws_where_two_choices_meet() {
    let text = "dtmc\nmodule a\n x:[0..2];\n [] x<2 -> true;\n [] x=1 -> true;\n [s] x=2 -> true;\nendmodule\n\
                module b\n y:[0..2];\n [s] y>0 -> true;\n [s] y=2 -> true;\nendmodule\n";
    let checked = lang::load(&SourceFile::new("m", text), &SourceFile::new("--const", "")).unwrap();
    let program = checked.program;
    let overlap = program.overlap();
    for (x, y, two) in [(0, 2, false), (1, 0, true), (2, 0, false), (2, 1, false), (2, 2, true)] {
        let choices: usize =
            program.synchronisations.iter().map(|s| enabled(&program, &s.factors, &[x, y])).sum();
        assert_eq!(choices > 1, two, "x={x} y={y}");
        assert_eq!(overlap.eval(&[x, y]), Ok(meliora::model::value::Value::Bool(two)));
    }
}

fn enabled(program: &Program, factors: &[Vec<meliora::model::CommandId>], state: &[i64]) -> usize {
    let holds = |c: &&meliora::model::CommandId| {
        let guard = program.commands[c.index()].guard;
        program.pool.eval(guard, state) == Ok(meliora::model::value::Value::Bool(true))
    };
    factors.iter().map(|f| f.iter().filter(holds).count()).product()
}

#[test]
fn an_invariant_needs_no_monitor() {
    for text in [
        "require G !\"done\";",
        "require (G x!=2) & (G (x<3 | half));",
        "require !(F x=2);",
        "require G G x!=2;",
        "require G true;",
    ] {
        let preferences = load(&format!("{THREE}{text}")).unwrap();
        assert_eq!(preferences.requirements.len(), 1, "{text}");
        assert_eq!(preferences.requirements[0].monitor, None, "{text}");
        let preferences = load(&format!("{THREE}{text} history = play;")).unwrap();
        assert_eq!(preferences.requirements[0].monitor, None, "{text}");
    }
    let preferences = load(&format!("{THREE}require G\n  x!=2; require G x!=1;")).unwrap();
    let texts: Vec<_> = preferences.requirements.iter().map(|r| r.text.as_str()).collect();
    assert_eq!(texts, ["G x!=2", "G x!=1"]);
}

#[test]
fn other_safe_formulas_need_the_whole_path() {
    for text in ["require x<2 W \"done\";", "require G (x=1 => X x!=2);", "require X x=1;"] {
        let wrong = errors(&format!("{THREE}{text}"));
        assert!(wrong.contains("not of the form `G condition`"), "{wrong}");
        assert!(wrong.contains("history = play;"), "{wrong}");
        let preferences = load(&format!("{THREE}{text} history = play;")).unwrap();
        assert!(preferences.requirements[0].monitor.is_some(), "{text}");
    }
}

#[test]
fn a_requirement_that_is_not_safe_is_refused() {
    for text in ["require F x=1;", "require G F x=1;", "require x<2 U \"done\";"] {
        let wrong = errors(&format!("{THREE}{text} history = play;"));
        assert!(wrong.contains("it is not a safe formula"), "{wrong}");
    }
    let wrong = errors(&format!("{THREE}require x<2;"));
    assert!(wrong.contains("a requirement is a formula over paths"), "{wrong}");
    let wrong = errors(&format!("{THREE}require G y=1; require G x!=1 history = play;"));
    assert!(wrong.contains("expected `;`"), "{wrong}");
    let wrong = errors(&format!("{THREE}require G y=1;"));
    assert!(wrong.contains("unknown name `y`"), "{wrong}");
}
