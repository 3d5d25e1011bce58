//! Pages of games: whose move it is, in square and round cells, and where each player stands.

use crate::cli::report::data;
use crate::common::prelude::*;

const PURSUIT: &str = "report models/pursuit.prism models/pursuit.pref -c N=4";

/// Two robots on a field of 3 x 3 that move in turns; a cell holds one of them.
const FIELD: &str = "smg\nplayer rover [a], [b] endplayer\nplayer other [c], [d] endplayer\nmodule first\n \
    r1 : [0..2] init 0; c1 : [0..2] init 0; turn : bool init true;\n \
    [a] turn & r1<2 & !(r1+1=r2 & c1=c2) -> (r1'=r1+1)&(turn'=false);\n \
    [b] turn -> (c1'=min(c1+1,2))&(turn'=false);\n [c] !turn -> (turn'=true);\n [d] !turn -> (turn'=true);\n\
    endmodule\nmodule second\n r2 : [0..2] init 2; c2 : [0..2] init 1;\n [c] r2>0 -> (r2'=r2-1);\n [d] true -> true;\n\
    endmodule\n";
const WISHES: &str = "objective Far = F (r1=2); objective Out = F (c1=2); prefer Far > Out;\n";

/// The cells of an SVG that are round.
fn round(svg: &str) -> usize {
    let rounded = svg.matches("rx=\"17\"").count();
    assert_eq!(
        svg.matches("<g class=\"cell theirs\"").count() + svg.matches("elsewhere theirs\"").count(),
        rounded
    );
    rounded
}

#[test]
fn cells_in_which_the_opponent_moves_are_round() {
    let svg = |more: &str| run!("{PURSUIT} --format svg --picture sasi{more}").expect(0).stdout;
    let ours = svg("");
    assert_eq!((round(&ours), ours.matches("<rect").count() > 25), (0, true));
    for legend in [">■</text>", ">robot moves</text>", ">●</text>", ">guard moves</text>"] {
        assert!(ours.contains(legend), "{legend}: {ours}");
    }
    // The robot does not stand in the wall, the column 2, between its doors; far cells are not reached yet.
    let theirs = svg(" --at robots_turn=false");
    assert!(round(&theirs) > 10, "{theirs}");
    // Seen by the guard, the robot is the opponent.
    let exchanged = " --coalition guard";
    assert!(round(&svg(exchanged)) > 10 && round(&svg(&format!("{exchanged} --at robots_turn=false"))) == 0);
    let all = svg(" --at robots_turn=false --coalition robot,guard");
    assert_eq!(round(&all), 0);
}

#[test]
fn a_page_says_who_plays_and_against_whom_results_hold() {
    let page = run(PURSUIT).expect(0).stdout;
    assert!(page.contains("This holds against every strategy of guard."), "{page}");
    assert!(page.contains("<span class=\"who ours\">robot</span> is ours, and moves in square cells"));
    assert!(
        page.contains("<span class=\"who theirs\">guard</span> is the opponent, and moves in round cells")
    );
    assert!(!page.contains("its sign also shows where it stands"), "the guard has a row only");
    let data_of_page = data(&page);
    let (game, choices) = (&data_of_page["game"], data_of_page["choices"].as_array().unwrap());
    let sides: Vec<Json> =
        game["players"].as_array().unwrap().iter().map(|p| json!([p["name"], p["ours"]])).collect();
    assert_eq!(sides, [json!(["robot", true]), json!(["guard", false])]);
    let choice = |m: &Json| &choices[usize::try_from(m["choice"].as_u64().unwrap()).unwrap()];
    let mut moves: Vec<&str> =
        game["moves"].as_array().unwrap().iter().map(|m| choice(m)["name"].as_str().unwrap()).collect();
    moves.sort_unstable();
    assert_eq!(moves, ["down", "lock", "stay", "up"]);
    for of in game["moves"].as_array().unwrap() {
        assert_eq!((of["sasi"].as_array().unwrap().len(), of["spi"].as_array().unwrap().len()), (2, 2));
    }
    let alone = run!("{PURSUIT} --coalition robot,guard").expect(0).stdout;
    assert!(!alone.contains("This holds against") && data(&alone)["game"]["moves"] == json!([]));
    let none = run("report models/toy.prism models/toy.pref").expect(0).stdout;
    assert!(data(&none)["game"].is_null() && !none.contains("class=\"who"));
}

#[test]
fn both_robots_are_drawn_where_they_stand() {
    let scratch = Scratch::new(&[("m.prism", FIELD), ("p.pref", WISHES)]);
    let (model, wishes) = (scratch.show("m.prism"), scratch.show("p.pref"));
    let at = |more: &[&str]| {
        let fixed = ["report", &model, &wishes, "--format", "svg", "--picture", "sasi"];
        Finished::of(executable().args([&fixed[..], more].concat())).expect(0).stdout
    };
    let map = at(&[]);
    // Rows grow downwards here: the other robot stands in row 2 and column 1.
    let from = map.find("<g class=\"cell\" transform=\"translate(").map(|_| ());
    assert!(from.is_some(), "{map}");
    let cell = |row: i64, column: i64| {
        let end = map.find(&format!(" data-row=\"{row}\" data-col=\"{column}\"")).unwrap();
        let start = map[..end].rfind("transform=\"").unwrap();
        map[start..end].trim().to_owned()
    };
    let piece = map.split("<g class=\"piece theirs\"").nth(1).unwrap();
    assert!(piece.contains(&cell(2, 1)) && piece.contains("visibility=\"visible\""), "{piece}");
    assert!(piece.contains("<title>other</title>") && piece.contains("<circle"), "{piece}");
    let page = scratch.run("report m.prism p.pref").expect(0).stdout;
    assert!(page.contains("its sign also shows where it stands"), "{page}");
    // The mark of the run is that of our robot.
    assert!(page.contains("<g class=\"token\" visibility=\"hidden\"><rect"), "{page}");
    let theirs = at(&["--grid", "r2,c2"]);
    assert!(
        theirs.contains("<g class=\"token theirs\" visibility=\"hidden\"><circle")
            && theirs.contains("<g class=\"piece ours\""),
        "{theirs}"
    );
}

#[test]
fn pages_of_games_are_files_with_a_report() {
    let scratch = Scratch::new(&[]);
    let out = scratch.show("page.html");
    let found = run!("{PURSUIT} --out {out} --json").expect(0).json();
    assert_eq!(found["check"]["players"][1], json!({"name": "guard", "ours": false, "states": "290"}));
    assert_eq!(found["written"]["bytes"], fs::read(out).unwrap().len());
    run!("{PURSUIT} --engine explicit").expect(2);
    run!("{PURSUIT} --safety transition").expect(2);
}

/// Pictures computed the run of a page, too, and so were refused where a plan is.
#[test]
fn pictures_need_no_strategy() {
    let wishes = "objective Far = F G (r1=2); objective Out = F (c1=2); prefer Far > Out;";
    let scratch = Scratch::new(&[("m.prism", FIELD), ("p.pref", wishes)]);
    let (model, wishes) = (scratch.show("m.prism"), scratch.show("p.pref"));
    let report = |more: &[&str]| {
        Finished::of(executable().args([&["report", model.as_str(), wishes.as_str()], more].concat()))
    };
    report(&["--format", "dot"]).prints(0, "Far");
    report(&["--format", "svg", "--picture", "sasi"]).prints(0, ">rover moves</text>");
    report(&["--kind", "sasi"]).expect(0);
    for refused in [&[][..], &["--format", "dot", "--kind", "plan"]] {
        report(refused).ends(2, "that achieves `Far` is not supported");
    }
}

/// Our choice `a` has the value 1/4, since the opponent answers with `c`; `b` has 1/5.
const ANSWERS: &str = "smg\nplayer us [a], [b] endplayer\nplayer them [c], [d] endplayer\nmodule m\n x : [0..4] init 0;\n\
    [a] x=0 -> 1/2:(x'=1) + 1/2:(x'=2);\n [b] x=0 -> 2/5:(x'=4) + 3/5:(x'=2);\n\
    [c] x=1 -> 1/2:(x'=3) + 1/2:(x'=2);\n [d] x=1 -> (x'=3);\n\
    [c] x=4 -> 1/2:(x'=3) + 1/2:(x'=2);\n [d] x=4 -> (x'=3);\n [a] x=2 | x=3 -> true;\nendmodule\n";

#[test]
fn a_page_of_a_game_has_values_against_the_opponent() {
    let wishes = "objective A = F x>=0; objective G = F x=3; prefer G > A;";
    let scratch = Scratch::new(&[("m.prism", ANSWERS), ("p.pref", wishes)]);
    let page = |choose: &str| {
        scratch
            .run(format!("report m.prism p.pref --kind spi --choose '{choose}' --opponent worst"))
            .expect(0)
            .stdout
    };
    let likely = page("likely");
    let headline = "Can improve from A to G with probability at least 0.25; no improvement is guaranteed.";
    assert!(likely.contains(headline), "{likely}");
    assert!(
        likely.contains("<span class=\"number text\">a</span><span class=\"label\">is the best first action")
    );
    let heat = &data(&likely)["heat"];
    let measure = &heat["measures"][0];
    assert_eq!(measure["id"], "p1");
    let text = |x: i64| {
        let state = heat["states"].as_array().unwrap().iter().position(|state| state[0] == json!(x)).unwrap();
        measure["looks"][measure["all"][state].as_u64().unwrap() as usize]["text"].clone()
    };
    assert_eq!([0, 1, 2, 4].map(text), ["0.25", "0.5", "0", "0.5"]);
    // The run of the page takes the action by its value.
    let play = data(&likely)["play"].as_array().unwrap().clone();
    assert!([json!([1]), json!([2])].contains(&play[1]), "{play:?}");
}
