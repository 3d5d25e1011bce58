//! The texts of games: players and their states, and refusals.

use super::raw::{loaded, program};
use crate::common::prelude::*;

const GAME: &str = "smg
player p1 one, [go] endplayer
player p2 two endplayer
player p3 endplayer
module one
 x : [0..3] init 0;
 [] x=0 -> (x'=1);
 [go] x=2 -> (x'=3);
endmodule
module two
 y : [0..1] init 0;
 [] x=1 & y=0 -> (y'=1);
 [go] y=1 -> true;
endmodule
";

fn message(text: &str) -> String {
    match lang::load(&SourceFile::new("game", text), &SourceFile::new("", "")) {
        Err(Error::Input(all)) => {
            let one = |d: &meliora::error::Diagnostic| {
                let (line, column) = d.position();
                format!("{line}:{column} {}", d.message)
            };
            all.iter().map(one).collect::<Vec<_>>().join("; ")
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn players_own_modules_and_actions() {
    let program = program(GAME);
    let players = program.players.as_ref().unwrap();
    assert_eq!(players.names(), "`p1`, `p2`, `p3`");
    assert_eq!(players.coalition(), [true, false, false]);
    assert_eq!(players.named(&["p3", "2"]), Ok(vec![false, true, true]));
    assert_eq!(players.named(&["p3", "4"]), Err(1));
    let owners: Vec<_> = program.synchronisations.iter().map(|s| program.player_of(s)).collect();
    assert_eq!(owners, [Some(0), Some(1), Some(0)]);
}

/// Explores a game by both engines.
fn explored(program: &Arc<Program>, scope: Scope) -> [Result<AnyEngine, Error>; 2] {
    [Storage::Explicit, Storage::Symbolic]
        .map(|storage| AnyEngine::new(program.clone(), Settings { storage, scope, ..Settings::default() }))
}

#[test]
fn what_belongs_to_two_players_is_refused() {
    for (from, to, expected) in [
        ("two endplayer", "two, one endplayer", "3:16 the module `one` belongs to two players"),
        ("two endplayer", "two, [go] endplayer", "3:17 the action `go` belongs to two players"),
        ("p3", "p1", "4:8 the player `p1` is defined twice"),
        ("two endplayer", "three endplayer", "3:11 unknown module `three`"),
        ("[go] endplayer", "[go], [halt] endplayer", "2:23 unknown action `halt`"),
        ("smg", "mdp", "2:8 only a game has players"),
        (
            "smg",
            "smg\nsystem one || (two / {go}) endsystem",
            "2:16 actions of a game cannot be hidden or renamed in `system … endsystem`",
        ),
    ] {
        let text = GAME.replacen(from, to, 1);
        assert!(message(&text).starts_with(expected), "{to}: {}", message(&text));
    }
    assert_eq!(message("smg module m x : bool; endmodule"), "1:1 the game has no player");
}

/// Both modules have the actions; `one` updates the global variable together with [a], `two` with [b].
const GLOBAL: &str = "smg
player p1 [a] endplayer
player p2 [b] endplayer
global g : [0..2] init 0;
module one
 x : bool;
 [a] g=0 -> (g'=1)&(x'=true);
 [b] g=1 -> true;
endmodule
module two
 [b] x -> (g'=2);
 [a] true -> true;
endmodule
";

#[test]
fn a_labelled_command_of_a_game_updates_a_global_variable() {
    let program = Arc::new(program(GLOBAL));
    for engine in explored(&program, Scope::Reachable).map(Result::unwrap) {
        let list = |x: &_| engine.list_states(x, 9).unwrap();
        assert_eq!(list(&engine.all_states()), [[0, 0], [1, 1], [2, 1]]);
        let players: Vec<_> = engine.player_states().iter().map(list).collect();
        assert_eq!(players, [vec![vec![0, 0]], vec![vec![1, 1]]]);
    }
    let both = GLOBAL.replace("[a] true -> true", "[a] true -> (g'=2)");
    assert_eq!(message(&both), "12:2 two commands update the global variable `g` together");
    let both = both.replace("(g'=1)&", "");
    assert!(lang::load(&SourceFile::new("game", both), &SourceFile::new("", "")).is_ok());
    // PRISM refuses it in models of other types.
    let players = ["smg", "player p1 [a] endplayer\n", "player p2 [b] endplayer\n"];
    let mdp = players.iter().fold(format!("mdp{GLOBAL}"), |text, part| text.replacen(part, "", 1));
    let refused = "a command with an action cannot update the global variable `g`";
    assert_eq!(message(&mdp), format!("5:14 {refused}; 9:12 {refused}"));
}

#[test]
fn jani_has_no_games() {
    let text = r#"{"jani-version": 1, "name": "m", "type": "smg", "variables": [], "automata": [],
        "system": {"elements": []}}"#;
    assert!(message(text).contains("1:42 models of type `smg` are not supported"), "{}", message(text));
}

#[test]
fn a_state_of_two_players_is_refused_by_both_engines() {
    let program = Arc::new(program(&GAME.replace("x=1 & y=0", "y=0")));
    for engine in explored(&program, Scope::Reachable) {
        let Err(Error::Input(all)) = engine else { panic!() };
        let expected = "several players may move in the state x=0,y=0: `p1` by `one#1` and `p2` by `two#1`";
        assert_eq!(all[0].message, expected);
        assert_eq!(all[0].position(), (12, 2));
    }
}

/// In x=0 and x=1 the action of nobody stands next to a choice of `p1` or `p2`, in x=3 it is alone. The module `free`
/// belongs to nobody, too.
const UNLISTED: &str = "smg
player p1 one endplayer
player p2 [turn] endplayer
module one
 x : [0..4] init 0;
 [] x=0 -> (x'=1);
 [turn] x=1 -> (x'=2);
 [go] x<=1 | x=3 -> (x'=min(x+1,4));
endmodule
module free
 y : [0..1] init 0;
 [] x=2 & y=0 -> (y'=1);
 [go] true -> true;
endmodule
";

#[test]
fn choices_of_no_player_belong_to_the_owner_of_the_others_or_alone_to_the_first_player() {
    let program = Arc::new(program(&UNLISTED.replace("x=2 & y=0", "x=2")));
    for engine in explored(&program, Scope::All).map(Result::unwrap) {
        let list = |x: &_| engine.list_states(x, 99).unwrap();
        let players: Vec<Vec<i64>> =
            engine.player_states().iter().map(|own| list(own).iter().map(|s| s[0]).collect()).collect();
        // [go] goes with `one` in 0, with `p2` in 1; in 2 the unlabelled command is alone, in 3 it is [go].
        assert_eq!(players, [vec![0, 0, 2, 2, 3, 3], vec![1, 1]], "{:?}", engine.storage());
        let choices = engine.choices_in(&engine.all_choices(), &engine.all_states()).unwrap();
        // Two choices in 0 and 1, one in 2 and 3, and the self-loop of 4; each for two values of y.
        assert_eq!(engine.count(&choices).unwrap(), 14_u32.into());
    }
    assert_eq!(
        program.choices(&[1, 0]).unwrap().iter().map(|c| c.1.as_str()).collect::<Vec<_>>(),
        ["turn", "go"]
    );
}

#[test]
fn a_state_with_several_choices_of_no_player_is_refused_by_both_engines() {
    for engine in explored(&Arc::new(program(&UNLISTED.replace("x=2 & y=0", "x=3"))), Scope::All) {
        let Err(Error::Input(all)) = engine else { panic!() };
        let expected = "several choices belong to no player in the state x=3,y=0: `free#1` and `go`";
        assert_eq!(all[0].message, expected);
    }
}

#[test]
fn states_belong_to_the_player_of_their_choices() {
    let program = Arc::new(program(GAME));
    for engine in explored(&program, Scope::Reachable).map(Result::unwrap) {
        let list = |x: &_| engine.list_states(x, 9).unwrap();
        let players: Vec<_> = engine.player_states().iter().map(list).collect();
        assert_eq!(players, [vec![vec![0, 0]], vec![vec![1, 0]], vec![]]);
        assert_eq!(engine.theirs().map(|x| list(&x)), Some(vec![vec![1, 0]]));
        let others = engine.with_coalition(&[false, true, true]).unwrap();
        assert_eq!(others.theirs().map(|x| list(&x)), Some(vec![vec![0, 0]]));
        assert!(engine.with_coalition(&[true]).is_err());
        assert!(engine.with_coalition(&[true, true, false]).unwrap().theirs().is_none());
    }
}

#[test]
fn a_coalition_names_players() {
    let source = |text: &str| SourceFile::new("--coalition", text);
    let program = program(GAME);
    assert_eq!(lang::parse_coalition(&program, &source("p2, p3")).unwrap(), [false, true, true]);
    let Err(Error::Input(all)) = lang::parse_coalition(&program, &source("p2, p4")) else { panic!() };
    assert_eq!((all[0].message.as_str(), all[0].position()), ("unknown player `p4`", (1, 5)));
}

#[test]
fn the_library_refuses_work_for_one_player() {
    fn refused<T>(result: Result<T, Error>, expected: &str) {
        let Err(error) = result else { panic!("{expected}: not refused") };
        assert!(error.to_string().contains(expected), "{error}");
    }
    let text = GAME.replace("x=0 -> (x'=1)", "x=0 -> 1/2:(x'=1) + 1/2:(x'=2)");
    let wishes = "empty = gain; objective A = F x=0; objective B = F y=1; prefer B > A;";
    let (program, preferences) = loaded(&text, wishes);
    let engine = Arc::new(AnyEngine::new(program.clone(), Settings::default()).unwrap());
    let mut analysis = finished(&engine, &preferences, Options::default());
    refused(analysis.run_jointly(&mut |_| ()), "`--jointly` of a game");
    let transition = Options { safety: Safety::Transition, ..Options::default() };
    refused(
        Analysis::new(&engine, &preferences, transition).run(&mut |_| ()),
        "`--safety transition` of a game",
    );
    refused(lang::flat(&program), "the flat program of a game");
}
