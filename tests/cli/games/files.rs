//! Games that are written, read, verified and queried.

use super::{GAME, at, scratch};
use crate::common::prelude::*;

/// Only dumps had the region `bad`; models state by state have all regions as labels.
#[test]
fn the_bad_states_of_a_game_are_a_label_of_its_files() {
    let scratch = Scratch::new(&[
        (
            "m.prism",
            "smg player us endplayer player them m endplayer module m x : [0..2]; [] x=0 -> (x'=1); endmodule",
        ),
        ("m.pref", "objective Here = F x=0;"),
    ]);
    let bad = |format: &str, listed: &str, count: &str| {
        let safety = ["--safety", "action"];
        let arguments = ["export", "@m.prism", "@m.pref", "--out", "@out", "--format", format, "--json"];
        let arguments = [&arguments[..], &safety].concat();
        let written = at(&scratch, &arguments).expect(0).json();
        let entry = written[listed].as_array().unwrap().iter().find(|entry| entry["name"] == "bad").cloned();
        std::fs::remove_dir_all(scratch.path("out")).unwrap();
        entry.map(|entry| entry[count].clone())
    };
    for (format, listed, count) in
        [("explicit", "labels", "states"), ("umb", "labels", "states"), ("dddmp", "regions", "count")]
    {
        assert_eq!(bad(format, listed, count), Some(json!("1")), "{format}");
    }
}

/// Our strategy leaves an mdp of the opponent's choices, or a game with fewer choices of ours.
#[test]
fn the_model_that_a_strategy_of_a_game_induces_is_written() {
    let scratch = Scratch::new(&[]);
    let export = |more: &[&str]| {
        let files = ["export", "models/pursuit.prism", "models/pursuit.pref", "-c", "N=3", "--kind", "sasi"];
        at(&scratch, &[&files, more, &["--out", "@out", "--json"]].concat()).expect(0).json()
    };
    for (scheduler, kind) in [("progress", "mdp"), ("permissive", "smg")] {
        let written = export(&["--format", "umb", "--scheduler", scheduler]);
        let archive = format!("@out/sasi-{scheduler}.umb");
        let read = at(&scratch, &["info", &archive, "--json"]).expect(0).json();
        assert_eq!(read["model"]["type"], kind);
        assert_eq!(read["counts"]["states"], written["states"], "{scheduler}");
        // Every path improves, and ends: whatever the opponent does.
        let question = match kind {
            "mdp" => "Pmin>=1 [ F \"settled\" ]",
            _ => "<<robot>> P>=1 [ F \"improved\" ]",
        };
        at(&scratch, &["reach", &archive, "--property", question]).expect(0);
    }
    export(&["--format", "drn", "--scheduler", "progress"]);
    let drn = at(&scratch, &["info", "@out/sasi-progress.drn", "--json"]).expect(0).json();
    assert_eq!(drn["model"]["type"], "mdp");
}

#[test]
fn a_certificate_of_another_model_does_not_verify_a_game() {
    let scratch = scratch();
    let mdp = GAME
        .replace("smg", "mdp")
        .replace("player us [a], [b] endplayer\nplayer them [c], [d] endplayer\n", "");
    scratch.write("m.prism", mdp);
    at(&scratch, &["export", "@m.prism", "@g.pref", "--out", "@dump"]).expect(0);
    at(&scratch, &["verify", "@dump", "@g.prism", "@g.pref"]).prints(1, "the SHA-256 of the model");
}

#[test]
fn a_dump_is_verified_for_its_coalition() {
    let scratch = scratch();
    let accepted = |preferences: &str, more: &[&str]| {
        let all = [&["verify", "@dump", "@g.prism", preferences], more].concat();
        at(&scratch, &all).expect(0);
    };
    let refused = |preferences: &str, more: &[&str], said: &str| {
        let all = [&["verify", "@dump", "@g.prism", preferences], more].concat();
        at(&scratch, &all).prints(1, said);
    };
    at(&scratch, &["export", "@g.prism", "@g.pref", "--out", "@dump"]).expect(0);
    accepted("@g.pref", &[]);
    accepted("@g.pref", &["--coalition", "us"]);
    refused("@g.pref", &["--coalition", "them"], "the coalition is `them`: the dump was made for `us`");
    at(&scratch, &["export", "@g.prism", "@g.pref", "--out", "@dump", "--coalition", "them"]).expect(0);
    accepted("@g.pref", &["--coalition", "them"]);
    refused("@g.pref", &[], "`--coalition them` checks it for these players");
    at(&scratch, &["export", "@g.prism", "@them.pref", "--out", "@dump", "--format", "dot"]).expect(0);
    accepted("@them.pref", &[]);
    refused("@them.pref", &["--coalition", "us,them"], "the dump was made for `them`");
    at(&scratch, &["export", "@g.prism", "@g.pref", "--out", "@dump", "--safety", "prefix"]).expect(0);
    accepted("@g.pref", &[]);
}

#[test]
fn query_knows_the_players_and_their_states() {
    let scratch = scratch();
    at(&scratch, &["export", "@g.prism", "@g.pref", "--safety", "action", "--out", "@dump"]).expect(0);
    for (region, condition, count) in [
        ("player:us", "true", "2"),
        ("player:them", "true", "1"),
        ("player:us | player:them | deadlock", "true", "4"),
        ("player:us & positive:Two", "x<2", "1"),
        ("player:them & strategy:almost-sure:Two", "true", "0"),
        ("bad", "true", "0"),
    ] {
        let found = at(&scratch, &["query", "@dump", region, "--where", condition, "--count"]).expect(0);
        assert_eq!(found.stdout.trim(), count, "{region}");
    }
}
