//! Dumps of models that requirements restrict.

use meliora::dump::manifest::RootKind;

use crate::common::prelude::*;
use crate::dumps::verify::{Case, replace};

const MODEL: &str = "mdp
    module m x : [0..7] init 0;
      [a] x=0 -> 0.5:(x'=1) + 0.5:(x'=2); [b] x=0 -> (x'=3); [on] x=1 -> (x'=4);
      [c] x=2 -> 0.5:(x'=5) + 0.5:(x'=6); [d] x=3 -> 0.5:(x'=0) + 0.5:(x'=4); [e] x=5 -> (x'=7);
      [stay] x=4 | x=6 -> true;
    endmodule label \"wet\" = x=6;";
const PREFERENCES: &str = "objective A = F x=1; objective B = F x=4; prefer B > A;";

fn case(preferences: &str, scope: Scope, safety: Safety) -> Case {
    let source = SourceFile::new("m.prism", MODEL);
    let program = lang::load(&source, &SourceFile::new("--const", "")).unwrap().program;
    let source = SourceFile::new("p.pref", format!("{PREFERENCES}{preferences}"));
    let lang::Task { program, preferences } = lang::load_preferences(&source, program).unwrap();
    Case::of(program, preferences, scope, safety)
}

const REQUIREMENTS: [&str; 4] = [
    "require G !\"wet\";",
    "require G x!=6; require G x<7;",
    "require G (x=0 => X x!=1); history = play;",
    "require (x<5) W (x=5); require X X x!=2; history = play;",
];

#[test]
fn every_dump_under_requirements_is_accepted() {
    for text in REQUIREMENTS {
        for scope in [Scope::Reachable, Scope::All] {
            for &safety in Safety::ALL {
                let case = case(text, scope, safety);
                assert!(!case.dump.manifest.requirements.is_empty());
                let verdict = case.verify(&case.dump).unwrap();
                assert_eq!(verdict.violation, None, "{text} {scope:?} {safety}");
                assert!(verdict.checked.iter().any(|c| c.region == "unsafe"), "{verdict:?}");
            }
        }
    }
}

#[test]
fn a_false_set_of_unsafe_states_is_refused() {
    let case = case(REQUIREMENTS[0], Scope::All, Safety::Action);
    for (name, by, word) in [
        // Too small: a state inside violates, or can only step out.
        ("unsafe", "class:nothing", "violates a requirement"),
        // Too large: the rounds do not remove all of it.
        ("unsafe", "reachable", "is lost in some round"),
        ("unsafe", "almost-sure:B", "violates a requirement"),
        ("refuted:unsafe:0", "layers:positive:A:0", "violates a requirement, or must risk"),
        ("refuted:unsafe:1", "layers:positive:B:1", "violates a requirement, or must risk"),
    ] {
        println!("{name} := {by}");
        let condition = case.refused(|dump| replace(dump, name, by));
        assert!(condition.contains(word), "{condition}");
    }
    let condition = case.refused(|dump| dump.manifest.requirements[0].push(' '));
    assert!(condition.contains("requirements"), "{condition}");
}

#[test]
fn a_dump_without_its_requirement_is_refused() {
    let with = case(REQUIREMENTS[0], Scope::All, Safety::Action);
    let without = case("", Scope::All, Safety::Action);
    let verdict = with.verify(&without.dump).unwrap();
    assert!(verdict.violation.is_some(), "the regions of the whole model were accepted");
    let verdict = without.verify(&with.dump).unwrap();
    assert!(verdict.violation.is_some(), "the regions of the restricted model were accepted");
}

#[test]
fn a_strategy_over_forbidden_choices_is_refused() {
    let case = case(REQUIREMENTS[0], Scope::All, Safety::Action);
    let roots = &case.dump.manifest.regions.roots;
    let is_strategy = |name: &str| name.starts_with("strategy:");
    let strategies: Vec<_> =
        roots.iter().filter(|r| r.kind == RootKind::Choices && is_strategy(&r.name)).collect();
    assert!(!strategies.is_empty());
    for strategy in strategies {
        let condition = case.refused(|dump| replace(dump, &strategy.name, "choices"));
        assert!(condition.contains("strategy"), "{condition}");
    }
}
