//! Games: at the states of the opponent every choice counts, and strategies have none of them.

use meliora::planning::Safety;

use super::draft::Draft;
use super::{Cases, cases};

/// The opponent chooses in 2, 4, 6, 7, 10 and 11. From 4 both of its choices lead to state 1, from 10 both lead to state
/// 8; from 2 and 11 one of them leads elsewhere. In 6 it may leave a target that counted, and from 7 it goes there.
const MODEL: &str = "smg
    player us [begin], [go], [risk], [stay], [toss] endplayer
    player them [push], [pull], [keep] endplayer
    module m s:[0..12] init 12;
      [begin] s=12 -> 1/8:(s'=0) + 1/8:(s'=2) + 1/8:(s'=6) + 1/8:(s'=7) + 1/8:(s'=8) + 1/8:(s'=10) + 1/4:(s'=11);
      [go] s=0 -> (s'=4); [risk] s=0 -> (s'=2); [go] s=5 -> (s'=1); [stay] s=1 | s=3 | s=9 -> true;
      [push] s=2 | s=4 -> (s'=1); [pull] s=2 | s=11 -> (s'=3); [pull] s=4 -> (s'=5);
      [keep] s=6 -> true; [push] s=6 -> (s'=3); [push] s=7 -> (s'=6);
      [toss] s=8 -> 0.5:(s'=1) + 0.5:(s'=9); [push] s=10 | s=11 -> (s'=8); [pull] s=10 -> (s'=8);
    endmodule";
const PREFERENCES: &str = "objective A = F s=1; objective B = F s=9; objective C = F s=8;
    objective D = F s=6; prefer A, B > C;";

const BOTH: [Safety; 2] = [Safety::Action, Safety::Prefix];

fn under(safeties: &[Safety]) -> Cases {
    cases(MODEL, PREFERENCES, &["history = state;"], safeties)
}

/// Replaces the layers of a region.
fn layers(draft: &mut Draft, region: &str, states: &[&[i64]]) {
    let sets: Vec<_> = states.iter().map(|first| draft.states(first)).collect();
    draft.layers(region, &sets.iter().collect::<Vec<_>>());
}

/// Replaces a region and its layers.
fn region(draft: &mut Draft, region: &str, states: &[&[i64]]) {
    draft.set(region, draft.states(&states.concat()));
    layers(draft, region, states);
}

/// Replaces the first rounds of a region.
fn rounds(draft: &mut Draft, region: &str, states: &[&[i64]]) {
    let sets: Vec<_> = states.iter().map(|first| draft.states(first)).collect();
    draft.rounds(region, &sets.iter().collect::<Vec<_>>());
}

/// State 2 is said to reach state 1, though one choice of the opponent escapes.
#[test]
fn a_state_with_a_choice_that_escapes_is_too_many() {
    under(&BOTH).refuse(&[
        ("each state in layer 1 of `positive:A` has a step into an earlier layer", |d| {
            region(d, "positive:A", &[&[1], &[2, 5, 8], &[4, 10], &[0], &[12]])
        }),
        ("each state in layer 1 of `almost-sure:A` has a step into an earlier layer", |d| {
            region(d, "almost-sure:A", &[&[1], &[2, 5], &[4], &[0]]);
            d.add("strategy:almost-sure:A", &d.choices("risk", 0));
        }),
    ]);
}

/// States are left out though every choice of the opponent leads to state 1.
#[test]
fn a_state_without_an_escape_is_missed() {
    under(&BOTH).refuse(&[
        ("each state with a step into `positive:A` is in it", |d| {
            region(d, "positive:A", &[&[1], &[5, 8], &[10], &[12]])
        }),
        ("no state lost in round 0 of `almost-sure:A` has a safe step out of the round", |d| {
            region(d, "almost-sure:A", &[&[1], &[5]]);
            d.take("strategy:almost-sure:A", &d.choices("go", 0));
            rounds(d, "almost-sure:A", &[&[4], &[0], &[2, 3, 6, 7, 8, 9, 10, 11, 12]]);
        }),
    ]);
}

#[test]
fn levels_hold_against_every_choice_of_the_opponent() {
    under(&[Safety::Action]).refuse(&[
        ("each state in layer 1 of `sasi:1` has a step into an earlier layer", |d| {
            region(d, "sasi:1", &[&[8], &[10, 11]])
        }),
        ("layer 0 of `sasi:1` are the states at its goal", |d| region(d, "sasi:1", &[&[8, 11], &[10]])),
        ("no state lost in round 0 of `sasi:1` has a safe step out of the round", |d| {
            region(d, "sasi:1", &[&[8]]);
            rounds(d, "sasi:1", &[&[10], &[0, 1, 2, 3, 4, 5, 6, 7, 9, 11, 12]]);
        }),
        ("each state with a step towards `spi:1` is in it", |d| region(d, "spi:1", &[&[8]])),
        ("each state in layer 1 of `spi:1` has a step into an earlier layer", |d| {
            region(d, "spi:1", &[&[8], &[10, 11]])
        }),
    ]);
}

#[test]
fn safe_regions_hold_against_every_choice_of_the_opponent() {
    under(&[Safety::Prefix]).refuse(&[
        ("each state of `safe:D` has a choice that stays in it", |d| d.add("safe:D", &d.states(&[6, 7]))),
        ("each state lost in round 0 of `safe:D` weakens, or must risk an earlier round", |d| {
            d.take("safe:D", &d.states(&[10]));
            rounds(d, "safe:D", &[&[10], &[2, 3, 11, 12], &[6], &[7]]);
        }),
    ]);
}

#[test]
fn each_bad_state_counts_and_no_other() {
    let missing = "each state in which the opponent can weaken, or step into `bad`, is in it";
    under(&[Safety::Action]).refuse(&[
        (missing, |d| region(d, "bad", &[])),
        (missing, |d| region(d, "bad", &[&[6]])),
        ("each state in layer 2 of `bad` has a step into an earlier layer", |d| {
            region(d, "bad", &[&[6], &[7], &[4]])
        }),
        ("layer 0 of `bad` are the states at its goal", |d| region(d, "bad", &[&[6, 12], &[7]])),
    ]);
}

#[test]
fn strategies_and_owners_are_those_of_the_players() {
    under(&BOTH).refuse(&[
            ("`strategy:almost-sure:A` are the choices that stay in `almost-sure:A`", |d| {
                d.add("strategy:almost-sure:A", &d.choices("push", 4))
            }),
            ("`player:us` are the states in which this player chooses", |d| {
                let state = d.states(&[4]);
                d.take("player:them", &state);
                d.add("player:us", &state);
            }),
            ("`player:them` are the states in which this player chooses", |d| {
                d.take("player:them", &d.states(&[4]))
            }),
            (
                "the coalition is `us`: the dump was made for `them`; `--coalition them` checks it for these players",
                |d| d.manifest.coalition = vec!["them".to_owned()],
            ),
            ("the players of the model are `us`, `them`: the dump says `them`, `us`", |d| {
                d.manifest.players.reverse()
            }),
            ("the players of the model are `us`, `them`: the dump says none", |d| {
                d.manifest.players.clear();
                d.manifest.coalition.clear();
                d.remove(|name| name.starts_with("player:"));
            }),
        ]);
    under(&[Safety::Action]).refuse(&[
        ("`strategy:sasi:1` are the kept choices that keep winning", |d| {
            d.add("strategy:sasi:1", &d.choices("push", 10))
        }),
        ("`strategy:spi:1` are the kept choices that keep winning", |d| {
            d.add("strategy:spi:1", &d.choices("pull", 10))
        }),
    ]);
}
