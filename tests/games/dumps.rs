//! Dumps of games: each one is accepted.

use proptest::prelude::*;

use super::levels::some_case;
use super::raw::loaded;
use super::{settings, thresholds};
use crate::common::prelude::*;

const HASHES: Hashes<'static> = Hashes { model: "m", preferences: "p" };

type Question = (Arc<Program>, Arc<Preferences>);

fn analysis<E: Engine>(engine: E, preferences: &Arc<Preferences>, safety: Safety) -> Analysis<E> {
    let options = Options { safety, ..Options::default() };
    finished(&Arc::new(engine), preferences, options)
}

fn dump((program, preferences): &Question, safety: Safety, (scope, thresholds): (Scope, Thresholds)) -> Dump {
    let engine = SymbolicEngine::new(Arc::clone(program), settings(scope, thresholds)).unwrap();
    let analysis = analysis(engine, preferences, safety);
    let named = |hash: &str| ("file".to_owned(), hash.to_owned());
    let inputs = Inputs { model: named(HASHES.model), preferences: named(HASHES.preferences) };
    export(&analysis, &inputs, &DumpContent { wanted: &|_| true, certificate: true }).unwrap()
}

fn check(question: &Question, safety: Safety, scope: Scope, all: &[Thresholds]) -> Vec<Dump> {
    let one = |&thresholds: &Thresholds| {
        let dump = dump(question, safety, (scope, thresholds));
        let verdict = verify(&question.0, &question.1, HASHES, &dump, settings(scope, thresholds)).unwrap();
        assert_eq!(verdict.violation, None, "{safety} {scope:?}: {}", question.0.source.text);
        dump
    };
    all.iter().map(one).collect()
}

proptest! {
    #![proptest_config(meliora_amount::random(200))]

    #[test]
    fn every_dump_of_a_game_is_accepted(case in some_case(), at in 0..4usize) {
        for text in [case.raw.text(), case.raw.labelled_text()] {
            // The second writing has two digits of x in place of x.
            let is_split = text.contains("l : [0..1]");
            let preferences = match is_split {
                true => (0..case.raw.len()).rev().fold(case.preferences(), |text, s| {
                    text.replace(&format!("x={s}"), &format!("(h={} & l={})", s / 2, s % 2))
                }),
                false => case.preferences(),
            };
            let question = loaded(&text, &preferences);
            for safety in [Safety::Action, Safety::Prefix] {
                for scope in [Scope::All, Scope::Reachable] {
                    check(&question, safety, scope, &thresholds()[at..=at]);
                }
            }
        }
    }
}

/// Rows of states along which the opponent may push forwards or backwards, with steps of both trends.
#[test]
fn a_state_of_the_opponent_may_lead_on_by_steps_of_both_trends() {
    let text = "smg
        player us [go] endplayer
        player them [up], [down] endplayer
        module m
          x : [0..9] init 4; t : bool init true;
          [up] t & x>0 & x<9 -> (x'=x+1)&(t'=false);
          [down] t & x>0 & x<9 -> (x'=x-1)&(t'=false);
          [go] !t & x!=0 & x!=9 -> 1/2:(t'=true) + 1/2:(x'=9-x)&(t'=true);
        endmodule";
    let question = loaded(text, "objective End = F (x=0 | x=9); objective Top = F (x=9); prefer Top > End;");
    for safety in [Safety::Action, Safety::Prefix] {
        for scope in [Scope::All, Scope::Reachable] {
            check(&question, safety, scope, &thresholds());
        }
    }
}

/// The opponent at 1 may leave a target for nothing, or for 2, where it has left it already.
#[test]
fn bad_states_are_in_the_dump() {
    let text = "smg
        player us [to1], [to2], [out] endplayer
        player them [stay], [leave], [pass] endplayer
        module m
          x : [0..4] init 0;
          [to1] x=0 -> (x'=1);
          [to2] x=0 -> (x'=2);
          [out] x=0 -> (x'=4);
          [stay] x=1 -> (x'=1);
          [leave] x=1 -> (x'=3);
          [pass] x=2 -> (x'=1);
        endmodule";
    let question = loaded(text, "objective Held = F (x=1); objective Out = F (x=4); prefer Held > Out;");
    let dump = check(&question, Safety::Action, Scope::Reachable, &thresholds()).remove(0);
    let count = |name: &str| dump.manifest.regions.root(name).unwrap().count.clone();
    assert_eq!(["bad", "player:us", "player:them", "deadlock"].map(count), ["2", "1", "2", "2"]);
    assert_eq!(
        (dump.manifest.players.join(","), dump.manifest.coalition.join(",")),
        ("us,them".into(), "us".into())
    );
}
