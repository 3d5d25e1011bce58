//! Games state by state: written and read again; wrong ones are refused.

use meliora::export::explicit::{Graph, drn, explored, prism, umb};
use proptest::collection::vec;
use proptest::prelude::*;

use crate::common::prelude::*;
use crate::common::random_game::with_turns;
use crate::dumps::exchange::{analysed, index, label, none, read, steps, tar, two_states, words};

/// A random game with two targets.
struct Written {
    program: Arc<Program>,
    /// The first target.
    target: Predicate,
    graph: Graph,
    archive: Vec<u8>,
}

fn written(numbers: &[u16], bits: u64) -> Option<Written> {
    let mut program = random_program(numbers, false);
    program.kind = ModelKind::Mdp;
    with_turns(&mut program, bits);
    let targets = [0, numbers.len() / 2].map(|from| random_predicate(&mut program, &numbers[from..]));
    let program = Arc::new(program);
    let targets = targets.map(|target| program.predicate(target));
    let engine = ExplicitEngine::new(Arc::clone(&program), Settings::default()).unwrap();
    let target = targets[0].clone();
    let analysis = analysed(engine, targets);
    let graph = explored(&analysis, &program, 1 << 12).unwrap();
    let archive = umb(&graph, &analysis, &program, None).unwrap();
    (!graph.states.is_empty()).then_some(Written { program, target, graph, archive })
}

/// The states of each player; for each coalition, the regions of the first target of the archive.
type Facts = (Vec<Vec<State>>, Vec<Vec<Vec<State>>>);

fn facts<E: Engine>(engine: &E, target: &E::States) -> Facts {
    let list = |x: &E::States| engine.list_states(x, usize::MAX).unwrap();
    let of = |coalition: &[bool; 2]| {
        let found = regions(&engine.with_coalition(coalition).unwrap(), target).unwrap();
        let all = [found.pmax_one, found.pmax_positive, found.pmin_one, found.pmin_positive];
        all.iter().map(list).collect()
    };
    let players = engine.player_states().iter().map(list).collect();
    (players, [[true, false], [false, true], [true, true], [false, false]].iter().map(of).collect())
}

/// The facts of a read game.
fn facts_of(program: &Arc<Program>) -> [Facts; 2] {
    let target = label(program, "target_o0");
    let explicit = ExplicitEngine::new(Arc::clone(program), Settings::default()).unwrap();
    let symbolic = SymbolicEngine::new(Arc::clone(program), Settings::default()).unwrap();
    let one = facts(&explicit, &explicit.states_where(&target).unwrap());
    [one, facts(&symbolic, &symbolic.states_where(&target).unwrap())]
}

fn names(program: &Program) -> Vec<&str> {
    program.players.as_ref().unwrap().list.iter().map(|player| player.name.as_str()).collect()
}

proptest! {
    #![proptest_config(meliora_amount::random(100))]

    #[test]
    fn a_random_game_is_the_same_after_writing_and_reading(
        numbers in vec(0u16..1000, 0..120),
        bits in any::<u64>(),
    ) {
        let Some(Written { program, target, graph, archive }) = written(&numbers, bits) else { return Ok(()) };
        let again = Arc::new(read(&archive).unwrap().program);
        prop_assert_eq!(names(&again), ["us", "them"]);
        let engine = ExplicitEngine::new(Arc::clone(&program), Settings::default()).unwrap();
        let expected = facts(&engine, &engine.states_where(&target).unwrap());
        for found in facts_of(&again) {
            prop_assert_eq!(&found, &expected);
        }
        for state in &graph.states {
            prop_assert_eq!(steps(&again, state), steps(&program, state));
        }
    }

    #[test]
    fn the_text_format_gives_the_same_game(numbers in vec(0u16..1000, 0..120), bits in any::<u64>()) {
        let Some(Written { graph, archive, .. }) = written(&numbers, bits) else { return Ok(()) };
        let folder = tempfile::tempdir().unwrap();
        let (files, at) = (prism(&graph), |name: &str| folder.path().join(name));
        for (name, text) in [("m.tra", &files.tra), ("m.sta", &files.sta), ("m.lab", &files.lab)] {
            std::fs::write(at(name), text).unwrap();
        }
        let text = Arc::new(Document::open(&at("m.tra")).unwrap().load(&none(), &NoProgress).unwrap().program);
        prop_assert_eq!(names(&text), ["p1", "p2"]);
        prop_assert_eq!(facts_of(&text), facts_of(&Arc::new(read(&archive).unwrap().program)));
    }
}

#[test]
fn a_game_is_not_written_to_drn() {
    let Written { program, graph, .. } = written(&[], 0).unwrap();
    let refused = drn(&graph, &program, &NoProgress).unwrap_err();
    assert_eq!(refused.to_string(), "`--format drn` of a game is not supported");
}

/// An archive of two states in a row that belong to two players.
fn two_players(system: &str, more: &[(&str, &[u8])]) -> Result<Checked, String> {
    two_states(&index(system, "").replace("players\": 1", "players\": 2"), more)
}

fn owners(numbers: [u32; 2]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

#[test]
fn the_players_of_an_archive_have_names_and_states() {
    let players = |checked: Result<Checked, String>| {
        let program = Arc::new(checked.unwrap().program);
        let engine = ExplicitEngine::new(Arc::clone(&program), Settings::default()).unwrap();
        let count = |x: &_| engine.list_states(x, 9).unwrap().len();
        let sizes: Vec<_> = engine.player_states().iter().map(count).collect();
        let names: Vec<String> = names(&program).iter().map(|name| (*name).to_owned()).collect();
        (names, sizes)
    };
    let both = owners([0, 1]);
    let file: &[(&str, &[u8])] = &[("state-to-player.bin", &both)];
    assert_eq!(players(two_players("", file)), (vec!["p1".into(), "p2".into()], vec![1, 1]));
    assert_eq!(players(two_players("", &[])).1, [2, 0]);
    let named = r#", "player-names": ["robot", "the guard"]"#;
    assert_eq!(players(two_players(named, file)).0, ["robot", "the_guard"]);
    let warned = two_players(named, file).unwrap().warnings[0].message.clone();
    assert!(warned.contains("`the guard` is renamed to `the_guard`"), "{warned}");
}

#[test]
fn wrong_players_of_an_archive_are_refused() {
    let refused = |system: &str, players: [u32; 2]| {
        two_players(system, &[("state-to-player.bin", &owners(players))]).unwrap_err()
    };
    for (system, players, message) in [
        ("", [0, 2], "state-to-player.bin: state 1 belongs to player 2, counted from 0, of 2"),
        (r#", "player-names": ["a"]"#, [0, 1], "index.json: 1 player names of 2 players"),
        (r#", "player-names": ["a", "a"]"#, [0, 1], "index.json: two players have the name `a`"),
    ] {
        let found = refused(system, players);
        assert!(found.contains(message), "{found}");
    }
    let short = two_players("", &[("state-to-player.bin", &[0; 4])]).unwrap_err();
    assert!(short.contains("state-to-player.bin: the file has 4 bytes, expected 8"), "{short}");
    // A chain has no players, and an mdp has one.
    for (count, message) in [("0", "player 0, counted from 0, of 0"), ("1", "player 1, counted from 0, of 1")]
    {
        let index = index("", "").replace("players\": 1", &format!("players\": {count}"));
        let found = two_states(&index, &[("state-to-player.bin", &owners([0, 1]))]).unwrap_err();
        assert!(found.contains(message), "{found}");
    }
    let whole = tar(&[("index.json", index("", "").as_bytes()), ("state-is-initial.bin", &words(&[1]))]);
    assert!(read(&whole).is_ok());
}

const TRA: &str = "3:2 3 4\n0:0 0 1 0.5 a\n0:0 0 2 0.5 a\n0:0 1 2 1 b\n2:1 0 2 1 a\n";

fn load(text: &str) -> Result<Checked, Error> {
    lang::load(&SourceFile::new("m.tra", text), &SourceFile::new("c", ""))
}

#[test]
fn the_players_of_transitions_stand_next_to_the_states() {
    let program = Arc::new(load(TRA).unwrap().program);
    assert_eq!((program.actions.len(), program.modules.len()), (2, 2));
    let engine = SymbolicEngine::new(Arc::clone(&program), Settings::default()).unwrap();
    let list = |x: &_| engine.list_states(x, 9).unwrap();
    let players: Vec<_> = engine.player_states().iter().map(list).collect();
    assert_eq!(players, [vec![vec![0]], vec![vec![2]]]);
    assert_eq!(program.choices(&[2]).unwrap()[0].1, "a");
    for (from, to, message) in [
        ("2:1", "2:2", "6:1 player 2, counted from 0, is not one of 2"),
        ("2:1", "2", "6:1 expected `state:player choice target probability action`"),
        ("0:0 1", "0:1 1", "5:1 state 0 belongs to player 1 here, and to 0 in the lines before"),
        ("3:2", "3:0", "2:1 the file has no transitions of 0 players"),
        ("3:2", "3:900", "2:1 the file has no transitions of 900 players"),
        ("3:2 3 4", "3:2 3 5", "2:1 the numbers of this line are [3, 3, 4] in the file"),
        (
            "3:2 3",
            "3 3",
            "1:1 this heading names the type SMG, but the first line has the numbers of the type `mdp`",
        ),
    ] {
        let text = format!("# Transitions (SMG)\n{}", TRA.replace(from, to));
        let Err(Error::Input(all)) = load(&text) else { panic!("{to}") };
        let (line, column) = all[0].position();
        assert_eq!(format!("{line}:{column} {}", all[0].message), message);
    }
}
