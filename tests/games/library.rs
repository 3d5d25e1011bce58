//! Games in the types for programs that embed the library.

use meliora::{Error, Exploration, Model, Options, Settings, SourceFile, States, Storage};

/// We choose in x=0, the opponent in x=1; x=2 is a deadlock.
const GAME: &str = "smg
player us [a], [b] endplayer
player them [c], [d] endplayer
module m
 x : [0..3] init 0;
 [a] x=0 -> (x'=1);
 [b] x=0 -> 1/2:(x'=2)+1/2:(x'=3);
 [c] x=1 -> (x'=2);
 [d] x=1 -> (x'=0);
 [a] x=3 -> true;
endmodule";

fn explored(model: &Model, storage: Storage) -> Exploration {
    model.explore(Settings { storage, memory: 64 << 20, ..Settings::default() }).unwrap()
}

fn listed(states: &States) -> Vec<i64> {
    states.list(9).unwrap().into_iter().map(|state| state[0]).collect()
}

#[test]
fn states_have_owners_and_steps() {
    let model = Model::parse(GAME, "").unwrap();
    let names: Vec<_> = model.players().iter().map(|p| (p.name.as_str(), p.ours)).collect();
    assert_eq!(names, [("us", true), ("them", false)]);
    for storage in [Storage::Symbolic, Storage::Explicit] {
        let (own, others) = (explored(&model, storage), model.with_coalition(&["2"]).unwrap());
        let others = explored(&others, storage);
        for (game, ours) in [(&own, true), (&others, false)] {
            let players = game.players();
            let all: Vec<_> = players.iter().map(|(p, s)| (p.name.as_str(), p.ours, listed(s))).collect();
            assert_eq!(all, [("us", ours, vec![0, 3]), ("them", !ours, vec![1])]);
            assert_eq!(listed(&game.theirs()), if ours { vec![1] } else { vec![0, 3] });
            let owners: Vec<_> =
                (0..4).map(|x| game.owner(&[x]).unwrap().map(|p| (p.name, p.ours))).collect();
            let us = || Some(("us".to_owned(), ours));
            assert_eq!(owners, [us(), Some(("them".to_owned(), !ours)), None, us()]);
        }
        let steps = own.steps(&[0]).unwrap();
        let names: Vec<_> = steps.iter().map(|step| (step.name.as_str(), step.successors.len())).collect();
        assert_eq!(names, [("a", 1), ("b", 2)]);
        assert!(matches!(own.steps(&[9]), Err(Error::Usage(_))) && own.owner(&[0, 0]).is_err());
    }
    let Err(Error::Input(all)) = model.with_coalition(&["us", "you"]) else { panic!("there is no `you`") };
    assert_eq!((all[0].message.as_str(), all[0].position()), ("unknown player `you`", (1, 4)));
    let one = Model::parse("mdp module m x : bool; endmodule", "").unwrap();
    assert!(one.players().is_empty() && one.with_coalition(&["us"]).is_err());
    let one = explored(&one, Storage::Symbolic);
    assert!(one.players().is_empty() && one.theirs().is_empty().unwrap());
    assert_eq!(one.owner(&[0]).unwrap(), None);
}

#[test]
fn a_model_names_a_coalition_before_the_preferences_do() {
    let wishes = |more: &str| {
        SourceFile::new(
            "g.pref",
            format!("objective Two = F x=2; objective Three = F x=3; prefer Two > Three;{more}"),
        )
    };
    let model = Model::parse(GAME, "").unwrap();
    for storage in [Storage::Symbolic, Storage::Explicit] {
        let sure = |explored: &Exploration, more: &str| {
            let mut found = explored.prefer(&wishes(more), Options::default()).unwrap();
            found.run(&mut |_| ()).unwrap();
            (listed(&found.region("almost-sure:Two").unwrap()), found.exploration())
        };
        let named = |players: &[&str]| explored(&model.with_coalition(players).unwrap(), storage);
        let plain = explored(&model, storage);
        assert_eq!(sure(&plain, "").0, [2]);
        let (states, theirs) = sure(&plain, "coalition them;");
        assert_eq!((states, listed(&theirs.theirs())), (vec![1, 2], vec![0, 3]));
        assert_eq!((sure(&theirs, "").0, sure(&theirs, "coalition us;").0), (vec![1, 2], vec![2]));
        let us = named(&["us"]);
        assert_eq!(sure(&us, "coalition them;").0, [2]);
        assert_eq!(sure(&sure(&us, "").1, "coalition them;").0, [2]);
        assert_eq!(sure(&named(&["them"]), "coalition us;").0, [1, 2]);
    }
}

#[test]
fn properties_are_answered_for_the_players_that_they_name() {
    let model = Model::parse(GAME, "").unwrap();
    for storage in [Storage::Symbolic, Storage::Explicit] {
        let game = explored(&model, storage);
        let one = |question: &str| {
            let found = game.reach_where(question).unwrap();
            (found.holds, listed(&found.regions.pmax_one), listed(&found.regions.pmin_one))
        };
        assert_eq!(one("x=2"), (None, vec![2], vec![1, 2]));
        assert_eq!(one("<<them>> P>=1 [ F x=2 ]"), (Some(false), vec![1, 2], vec![2]));
        assert_eq!(one("<<us,them>> P>=1 [ F x=2 ]"), (Some(true), vec![0, 1, 2], vec![2]));
        let target = game.states_where("x=2").unwrap();
        assert_eq!(listed(&game.reach(&target).unwrap().pmin_one), [1, 2]);
        let value = game.reach_where("<<us>> Pmax=? [ F x=2 ]").unwrap().value.unwrap();
        assert!(value.lower <= 0.5 && value.upper >= 0.5 && value.upper - value.lower < 1e-6, "{value:?}");
        assert_eq!(one("P>=1 [ F x=2 ]"), (Some(false), vec![0, 1, 2], vec![2]));
    }
}
