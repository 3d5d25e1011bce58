//! Dumps of objectives over whole paths.

use crate::common::prelude::*;
use crate::dumps::conditions::SCOPES;
use crate::dumps::verify::{Case, replace};

fn case(model: &str, constants: &str, preferences: &str, scope: Scope, safety: Safety) -> Case {
    let path = format!("models/{model}.prism");
    let source = SourceFile::new("m.prism", fs::read_to_string(path).unwrap());
    let program = lang::load(&source, &SourceFile::new("--const", constants)).unwrap().program;
    let lang::Task { program, preferences } =
        lang::load_preferences(&SourceFile::new("p.pref", preferences), program).unwrap();
    Case::of(program, preferences, scope, safety)
}

fn preferences_of(model: &str) -> String {
    fs::read_to_string(format!("models/{model}.pref")).unwrap()
}

#[test]
fn every_dump_of_whole_plays_is_accepted() {
    for (model, constants) in [("courier", ""), ("counter", ""), ("patrol", "N=2"), ("lateral_prefix", "")] {
        let preferences = match model {
            "lateral_prefix" => preferences_of(model) + "history = play;",
            _ => preferences_of(model),
        };
        for scope in SCOPES {
            for &safety in Safety::ALL {
                let case = case(model, constants, &preferences, scope, safety);
                assert_eq!(case.dump.manifest.history.as_deref(), Some("play"));
                let verdict = case.verify(&case.dump).unwrap();
                assert_eq!(verdict.violation, None, "{model} {scope:?} {safety}");
                assert!(verdict.checked.iter().any(|c| c.region.starts_with("secured:")), "{verdict:?}");
            }
        }
    }
}

/// Checks that a swapped region is refused in dumps of objectives over whole paths too.
#[test]
fn a_region_in_the_place_of_another_is_refused() {
    let case = case("patrol", "N=2", &preferences_of("patrol"), Scope::Reachable, Safety::Action);
    for (name, by, word) in [
        ("secured:Patrol:1", "reachable", "choices that stay"),
        ("secured:Patrol:1", "class:nothing", "strategy"),
        ("secured:West:1", "reachable", "must always hold"),
        ("secured:Rest:1", "secured:Patrol:1", "must always hold"),
        ("secured:Rest:1", "sasi:unbounded", "strategy"),
        ("strategy:secured:Patrol:1", "choices", "choices that stay"),
        ("target:West", "almost-sure:West", "is secured"),
        ("almost-sure:Patrol", "positive:Patrol", "strategy"),
        ("layers:secured:Patrol:1:1:0", "layers:secured:Patrol:1:2:0", "layer 0"),
        ("layers:secured:Patrol:1:2:1", "layers:secured:Patrol:1:2:2", "layer 1"),
        ("refuted:secured:Patrol:1:0", "layers:secured:Patrol:1:1:0", "round 0"),
        ("refuted:secured:Patrol:1:0", "layers:reachable:0", "round 0"),
    ] {
        println!("{name} := {by}");
        let condition = case.refused(|dump| replace(dump, name, by));
        assert!(condition.contains(word), "{condition}");
    }
}
