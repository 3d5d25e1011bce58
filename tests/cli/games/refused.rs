//! Questions that games do not have are refused by name.

use super::{at, scratch};
use crate::cli::common::Scratch;

#[test]
fn commands_for_one_player_refuse_a_game_by_name() {
    let scratch = scratch();
    let refused = at(&scratch, &["info", "@g.prism", "--flat"]).expect(3);
    refused.says("the flat program of a game is not supported");
    refused.says("g.prism:1:1");
    refused.says("help: the text does not name the players");
}

#[test]
fn what_a_game_cannot_be_written_with_is_refused_by_name() {
    let scratch = scratch();
    for (more, name, help) in [
        (&["--format", "drn"][..], "`--format drn`", "write `--format umb` or `explicit`"),
        (&["--format", "drn", "--kind", "sasi"], "`--format drn`", "write `--format umb` or `explicit`"),
    ] {
        let all = [&["export", "@g.prism", "@g.pref", "--out", "@dump"], more].concat();
        let refused = at(&scratch, &all).expect(3);
        refused.says(format!("{name} of a game is not supported"));
        refused.says(help);
        refused.says("g.prism:1:1");
        assert!(!scratch.path("dump").exists());
    }
}

/// Checks that each command ends with the status and an error that contains the text.
fn refuses(scratch: &Scratch) -> impl Fn(&[(&[&str], i32, &str)]) {
    move |cases| {
        for (arguments, status, expected) in cases {
            at(scratch, arguments).ends(*status, expected);
        }
    }
}

#[test]
fn options_that_games_do_not_have_are_refused_by_name() {
    let scratch = scratch();
    refuses(&scratch)(&[
        (&["check", "@g.prism", "@g.pref", "--safety", "transition"], 2, "`--safety transition` of a game"),
        (&["compare", "@g.prism", "@g.pref", "--safety", "transition"], 2, "`--safety transition` of a game"),
        (&["check", "@g.prism", "@g.pref", "--safety", "transition"], 2, "`action` and `prefix` hold"),
        (&["check", "@g.prism", "@g.pref", "--jointly"], 2, "`--jointly` of a game"),
        (&["check", "@g.prism", "@g.pref", "--jointly"], 2, "strategies of the kind `achieve` say where"),
        (
            &["strategy", "@g.prism", "@g.pref", "--safety", "transition"],
            2,
            "`--safety transition` of a game",
        ),
        (
            &["simulate", "models/toy.prism", "models/toy.pref", "--opponent", "worst"],
            2,
            "only a game (`smg`) has",
        ),
    ]);
}

#[test]
fn formulas_and_properties_that_games_do_not_have_are_refused_by_name() {
    let scratch = scratch();
    scratch.write("play.pref", "objective A = (G F (x=2)) | (F G (x=1));");
    scratch.write("safe.pref", "objective A = F (x=2); require x=0 W (x=2);");
    scratch.write("keep.pref", "objective A = F G x!=1;");
    refuses(&scratch)(&[
        (&["check", "@g.prism", "@play.pref"], 3, "combines recurrence and persistence"),
        (&["check", "@g.prism", "@safe.pref"], 3, "`G condition`"),
        (
            &["export", "@g.prism", "@keep.pref", "--out", "@dump"],
            2,
            "a dump of a game with temporal objectives",
        ),
        (
            &["strategy", "@g.prism", "@keep.pref", "--kind", "achieve", "--objective", "A"],
            2,
            "a strategy of a game that achieves `A` is not supported",
        ),
        (&["simulate", "@g.prism", "@keep.pref"], 2, "such as `F a`, `G a` and `G F a`"),
        (
            &["reach", "@g.prism", "--property", "<<us>> P>=1 [ (G F x=2) => (G F x=1) ]"],
            3,
            "combines recurrence and persistence",
        ),
        (&["reach", "@g.prism", "--property", "<<us>> Pmax>=1 [ F x=2 ]"], 3, "`<<p1>> P>=1"),
        (&["reach", "@g.prism", "--property", "<<us>> R{\"r\"}min=? [ F* x=2 ]"], 3, "`F0` loses them"),
    ]);
}

#[test]
fn a_coalition_is_of_players_of_a_game() {
    let scratch = scratch();
    refuses(&scratch)(&[
        (&["reach", "@g.prism", "--property", "<<us,you>> P>=1 [ F x=2 ]"], 3, "unknown player `you`"),
        (&["check", "@g.prism", "@g.pref", "--coalition", "us,you"], 3, "unknown player `you`"),
        (
            &["reach", "models/toy.prism", "--target", "s=3", "--coalition", "us"],
            3,
            "only a game has players",
        ),
        (&["reach", "models/toy.prism", "--property", "<<us>> P>=1 [ F s=3 ]"], 3, "only a game has players"),
        (&["check", "models/toy.prism", "@them.pref"], 3, "only a game has players"),
    ]);
}
