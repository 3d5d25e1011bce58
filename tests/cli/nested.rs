//! Properties as expressions over states: nested operators, arithmetic, filters, references and players.

use crate::common::prelude::*;

const CHAIN: &str = "dtmc\nmodule m\n x : [0..3] init 0;\n [] x=0 -> 1/2: (x'=1) + 1/2: (x'=2);\n\
     [] x=1 -> 1/2: (x'=2) + 1/2: (x'=0);\n [] x=2 -> 1/3: (x'=3) + 2/3: (x'=0);\nendmodule\n\
     rewards true : 1; endrewards\n";

const CHOICES: &str = "mdp\nmodule m\n x : [0..2] init 0;\n [] x=0 -> 1/4: (x'=1) + 3/4: (x'=2);\n\
     [] x=0 -> 1/2: (x'=1) + 1/2: (x'=2);\nendmodule\n";

const GAME: &str = "smg\nplayer us [a], [b] endplayer\nplayer them [c], [d] endplayer\nmodule m\n x : [0..3] init 0;\n\
     [a] x=0 -> (x'=1);\n [b] x=0 -> 1/5: (x'=2) + 4/5: (x'=3);\n [c] x=1 -> 1/2: (x'=2) + 1/2: (x'=3);\n\
     [d] x=1 -> 2/3: (x'=2) + 1/3: (x'=3);\nendmodule\n";

/// Returns the answers to a file of properties, under one engine.
fn answers(model: &str, properties: &str, engine: &str) -> Vec<Json> {
    let scratch = Scratch::new(&[("m.prism", model), ("m.props", properties)]);
    let found = scratch.run(format!("reach m.prism --properties m.props --engine {engine} --json"));
    let json: Json = serde_json::from_str(&found.stdout).unwrap_or_else(|e| panic!("{e}: {}", found.stderr));
    json["properties"].as_array().unwrap().clone()
}

/// Checks that properties have these verdicts and numbers under both engines.
fn expect(model: &str) -> impl Fn(&[(&str, Json)]) {
    move |expected| {
        let file: String = expected.iter().map(|(property, _)| format!("{property};\n")).collect();
        for engine in ["explicit", "symbolic"] {
            for (answer, (property, value)) in answers(model, &file, engine).iter().zip(expected) {
                if value.is_boolean() {
                    assert_eq!(&answer["holds"], value, "{property} ({engine}): {answer}");
                    continue;
                }
                if value == "inf" {
                    assert_eq!(answer["value"]["lower"], *value, "{property} ({engine}): {answer}");
                    continue;
                }
                let [lower, upper] = ["lower", "upper"].map(|key| answer["value"][key].as_f64());
                let (lower, upper) =
                    lower.zip(upper).unwrap_or_else(|| panic!("{property} ({engine}): {answer}"));
                let value = value.as_f64().unwrap();
                let slack = 1e-12;
                let inside = lower - slack <= value && value <= upper + slack && upper - lower <= 1e-6;
                assert!(inside, "{property} ({engine}): {answer}");
            }
        }
    }
}

#[test]
fn operators_nest_and_are_operands() {
    expect(CHAIN)(&[
        ("\"sure\": P>=1 [ F x=3 ]", json!(true)),
        ("ceil(P=? [ F x=3 ]) + 1", json!(2)),
        ("1 - P=? [ F<=3 x=3 ]", json!(0.75)),
        // Bounds of a billion are too wide, so that fractions are computed.
        ("1000000000 * (R=? [ F x=3 ] - 9)", json!(0)),
        ("P=? [ F<=3 x=3 ] * 4 > 0.5 => \"sure\"", json!(true)),
        // From x=0 and x=1 the next state is x=2 with probability 1/2.
        ("P=? [ X P>=0.5 [ X x=2 ] ]", json!(0.5)),
        ("P>=0.5 [ (F P>0.4 [ X x=2 ]) & (G x<=3) ]", json!(true)),
        ("P=? [ X (P>=1 [ F x=3 ] ? P>=1 [ X x=0 ] : P>=0.4 [ X x=0 ]) ]", json!(0)),
        ("P=? [ F<=1 x=3 {x=2} ]", json!(1.0 / 3.0)),
        ("P>=1 [ F x=3 ] & x=0 ? P=? [ X x=1 ] : 7", json!(0.5)),
    ]);
}

#[test]
fn rewards_of_steps_and_of_the_long_run_are_numbers() {
    expect(CHAIN)(&[
        ("R=? [ C<=5 ]", json!(5)),
        ("R=? [ I=4 ]", json!(1)),
        ("R=? [ F x=3 ]", json!(9)),
        ("R=? [ S ]", json!(1)),
        ("S=? [ x=3 ]", json!(1)),
        ("R=? [ X true ]", json!(1)),
    ]);
}

#[test]
fn averages_of_an_mdp_are_those_of_the_best_end_component_that_is_reached() {
    let model = "mdp\nmodule m\n x : [0..3] init 0;\n [] x=0 -> (x'=1);\n [] x=1 -> (x'=0);\n\
         [] x=0 -> 1/2:(x'=2) + 1/2:(x'=3);\n [] x>1 -> true;\nendmodule\n\
         rewards \"r\" x=1 : 4; x=2 : 3; endrewards\n";
    expect(model)(&[
        ("R{\"r\"}max=? [ S ]", json!(2)),
        ("R{\"r\"}min=? [ S ]", json!(1.5)),
        ("R{\"r\"}>=1.5 [ S ]", json!(true)),
        ("R{\"r\"}>1.5 [ S ]", json!(false)),
        ("Smax=? [ x=1 ]", json!(0.5)),
        ("Smax=? [ x=2 ]", json!(0.5)),
        ("Smin=? [ x<2 ]", json!(0)),
        ("filter(max, Smax=? [ x=2 ])", json!(1)),
    ]);
}

#[test]
fn several_objectives_recur_and_have_bounds_on_steps() {
    let model = "mdp\nmodule m\n x : [0..3] init 0;\n [] x=0 -> (x'=1);\n [] x=0 -> (x'=2);\n\
         [] x=1 -> (x'=3);\n [] x=1 -> true;\n [] x=2 -> true;\n [] x=3 -> (x'=1);\nendmodule\n\
         rewards \"a\" x=1 : 1; endrewards\nrewards \"b\" x=2 : 1; endrewards\n";
    expect(model)(&[
        ("multi(P>=1 [ G F x=1 ], P>=1 [ G F x=3 ])", json!(true)),
        ("multi(P>=0.4 [ G F x=1 ], P>=0.6 [ G F x=2 ])", json!(true)),
        ("multi(P>=0.5 [ G F x=1 ], P>=0.6 [ G F x=2 ])", json!(false)),
        ("multi(Pmax=? [ G F x=2 ], P>=0.25 [ G F x=3 ])", json!(0.75)),
        ("multi(P>=0.5 [ F G x=1 ], P>=0.5 [ G F x=3 ])", json!(true)),
        ("multi(P>=0.75 [ F G x=1 ], P>=0.5 [ G F x=3 ])", json!(false)),
        ("multi(Pmin=? [ G F x=3 ], P>=0.75 [ F x=1 ])", json!(0)),
        ("multi(Pmax=? [ x!=1 U x=2 ], P>=0.25 [ F x=3 ])", json!(0.75)),
        ("multi(R{\"a\"}max=? [ C<=2 ], R{\"b\"}>=0.25 [ C<=2 ])", json!(0.75)),
        ("multi(R{\"a\"}>=1 [ C<=3 ], R{\"b\"}>=0.5 [ C<=2 ])", json!(true)),
        ("multi(R{\"a\"}>=1.25 [ C<=3 ], R{\"b\"}>=0.5 [ C<=2 ])", json!(false)),
    ]);
}

#[test]
fn rewards_of_several_objectives_until_a_target_are_infinite_where_it_is_avoided() {
    let model = "mdp\nmodule m\n x : [0..3] init 0;\n [a] x=0 -> 1/2:(x'=1) + 1/2:(x'=2);\n [b] x=0 -> (x'=1);\n\
         [w] x=0 -> true;\n [c] x=1 -> true;\n [e] x=1 -> (x'=3);\n [d] x>=2 -> true;\nendmodule\n\
         rewards \"a\" [a] true : 1; [b] true : 5; [w] true : 1; [c] true : 1; [e] true : 3; endrewards\n\
         rewards \"b\" [a] true : 1; [b] true : 2; [e] true : 2; endrewards\n";
    expect(model)(&[
        ("multi(R{\"a\"}<=8 [ F x=3 ], R{\"b\"}<=4 [ F x=3 ])", json!(true)),
        ("multi(R{\"a\"}<=7.9 [ F x=3 ], R{\"b\"}<=4 [ F x=3 ])", json!(false)),
        ("multi(R{\"a\"}min=? [ F x=1 ], R{\"b\"}<=3 [ C ])", json!(5)),
        ("multi(R{\"a\"}min=? [ F x=1 ], R{\"b\"}<=1 [ C ])", json!("inf")),
        ("multi(R{\"b\"}min=? [ F x=1 ], R{\"b\"}<=1 [ C ])", json!("inf")),
        ("multi(R{\"b\"}max=? [ F x=3 ], R{\"a\"}<=9 [ F x=3 ])", json!(4)),
        ("multi(R{\"a\"}<=100 [ F x=1 ], P>=0.5 [ F x=2 ])", json!(false)),
        ("multi(R{\"a\"}min=? [ F x>0 ], P>=0.25 [ F x=2 ])", json!(1)),
        ("multi(R{\"a\"}min=? [ F x>0 ], P>=0.75 [ F x=1 ])", json!(3)),
    ]);
}

#[test]
fn a_pareto_front_has_as_many_numbers_as_objectives() {
    let model = "mdp\nmodule m\n x : [0..3] init 0;\n [] x=0 -> (x'=1);\n [] x=0 -> (x'=2);\n [] x=0 -> (x'=3);\n\
         [] x>0 -> true;\nendmodule\nrewards \"a\" x=1 : 1; endrewards\n";
    let text = "multi(Pmax=? [ F x=1 ], Pmin=? [ G x<2 ], R{\"a\"}min=? [ C<=3 ]);";
    for engine in ["explicit", "symbolic"] {
        let found = &answers(model, text, engine)[0];
        let points = found["front"].as_array().unwrap_or_else(|| panic!("{found}"));
        let number = |x: &Json| x.as_f64().unwrap().round();
        let rounded: Vec<Vec<f64>> =
            points.iter().map(|point| point.as_array().unwrap().iter().map(number).collect()).collect();
        assert_eq!(rounded, [[0.0, 0.0, 0.0], [1.0, 1.0, 2.0]], "{found}");
    }
}

#[test]
fn every_path_and_some_path_are_not_every_strategy_and_some_strategy() {
    expect(CHAIN)(&[
        ("A [ F x=3 ]", json!(false)),
        ("P>=1 [ F x=3 ]", json!(true)),
        ("E [ G x<3 ]", json!(true)),
        ("P>0 [ G x<3 ]", json!(false)),
        ("A [ G E [ F x=3 ] ]", json!(true)),
        ("E [ F<=1 x=3 ]", json!(false)),
        ("A [ x=0 W x>0 ]", json!(true)),
        ("E [ (G F x=1) & (G F x=2) ]", json!(true)),
        ("A [ (G F x=1) | (F x>=2) ]", json!(true)),
    ]);
}

#[test]
fn filters_are_functions_of_the_values_in_several_states() {
    expect(CHAIN)(&[
        ("filter(count, P>0.4 [ X x=2 ])", json!(2)),
        ("filter(count, P>0.4 [ X x=2 ] | P>0.4 [ X x=1 ] | P>=1 [ X x=3 ])", json!(3)),
        ("filter(count, P>0.4 [ X x=2 ] => P>0.4 [ X x=1 ])", json!(3)),
        ("filter(sum, P=? [ X x=2 ])", json!(1)),
        ("filter(avg, P=? [ X x=2 ], x<=1)", json!(0.5)),
        ("filter(min, R=? [ F x=3 ], x<3)", json!(7)),
        ("filter(max, R=? [ F x=3 ])", json!(9)),
        ("filter(state, P=? [ X x=3 ], x=2)", json!(1.0 / 3.0)),
        ("filter(first, x+1, x>=1)", json!(2)),
        ("filter(forall, P>=1 [ F x=3 ])", json!(true)),
        ("filter(exists, P>=1 [ X x=3 ], x<3)", json!(false)),
        ("filter(argmax, P=? [ F<=2 x=3 ])", json!(false)),
    ]);
    for engine in ["explicit", "symbolic"] {
        let found = answers(
            CHAIN,
            "filter(argmax, P=? [ F<=2 x=3 ], x<3);\nfilter(print, P=? [ X x=3 ], x<3);",
            engine,
        );
        assert_eq!(found[0]["values"][0]["state"], json!({"x": 2}), "{found:?}");
        assert_eq!(found[0]["values"].as_array().unwrap().len(), 1, "{found:?}");
        assert_eq!(found[1]["values"][0]["state"], json!({"x": 2}), "{found:?}");
        assert_eq!(
            found[1]["values"].as_array().unwrap().len(),
            1,
            "states with the value 0 are left out: {found:?}"
        );
        let several = answers(CHAIN, "filter(state, x, x<2);\nP>0 [ F x=3 ];", engine);
        assert!(several[0]["reason"].as_str().unwrap().contains("several states"), "{several:?}");
        assert_eq!(several[1]["holds"], json!(true), "a property without an answer leaves the others");
    }
}

#[test]
fn without_a_game_everybody_or_nobody_chooses() {
    expect(CHOICES)(&[
        ("P>=0.5 [ F x=1 ]", json!(false)),
        ("<<*>> P>=0.5 [ F x=1 ]", json!(true)),
        ("[[*]] P>=0.5 [ F x=1 ]", json!(false)),
        ("<<>> P>=0.5 [ F x=1 ]", json!(false)),
        ("[[]] P>=0.5 [ F x=1 ]", json!(true)),
        ("[[*]] Pmax=? [ F x=1 ]", json!(0.5)),
    ]);
}

#[test]
fn the_values_of_games_are_numbers() {
    expect(GAME)(&[
        ("<<us>> Pmax=? [ F x=2 ]", json!(0.5)),
        ("<<us>> Pmin=? [ F x=2 ]", json!(0.2)),
        ("<<us,them>> Pmax=? [ F x=2 ]", json!(2.0 / 3.0)),
        ("[[us]] Pmin=? [ F x=2 ]", json!(0.5)),
        ("<<us>> P>=0.5 [ F<=2 x=2 ]", json!(true)),
        ("<<us>> P>0.5 [ F<=2 x=2 ]", json!(false)),
        ("<<us>> Pmax=? [ F<=1 x=2 ]", json!(0.2)),
        ("filter(max, <<us>> Pmax=? [ X x=2 ])", json!(1)),
    ]);
}

#[test]
fn without_players_all_players_of_a_game_choose_together() {
    expect(GAME)(&[
        ("Pmax=? [ F x=2 ]", json!(2.0 / 3.0)),
        ("Pmin=? [ F x=2 ]", json!(0.2)),
        ("P>=0.2 [ F x=2 ]", json!(true)),
        ("P>=0.4 [ F x=2 ]", json!(false)),
        ("Pmax>=0.4 [ F x=2 ]", json!(true)),
        ("filter(max, Pmax=? [ X x=2 ], x=1)", json!(2.0 / 3.0)),
    ]);
}

/// We may wait in x=0 for nothing, or go where each step earns 1 until chance or the opponent ends it.
const EARNING: &str = "smg\nplayer us [wait], [go] endplayer\nplayer them [on], [end] endplayer\nmodule m\n\
     x : [0..3] init 0;\n [wait] x=0 -> true;\n [go] x=0 -> (x'=1);\n [on] x=1 -> 1/2: true + 1/2: (x'=2);\n\
     [end] x=1 -> 1/4: (x'=1) + 3/4: (x'=3);\nendmodule\nrewards \"r\" x=1 : 1; endrewards\n";

/// We may wait in x=0 forever; the opponent may wait in x=2, or go on to x=1.
const WAITING: &str = "smg\nplayer us [a], [b] endplayer\nplayer them [c], [d] endplayer\nmodule m\n x : [0..2] init 0;\n\
     [a] x=0 -> true;\n [b] x=0 -> 0.85: (x'=2) + 0.15: (x'=1);\n [c] x=2 -> true;\n [d] x=2 -> (x'=1);\nendmodule\n";

#[test]
fn who_waits_forever_satisfies_a_safe_formula_of_a_game() {
    expect(WAITING)(&[
        ("<<us>> Pmin=? [ G x!=1 ]", json!(0.85)),
        ("<<them>> Pmax=? [ G x!=1 ]", json!(0.85)),
        ("<<us>> Pmax=? [ F x=1 ]", json!(0.15)),
        ("<<us>> Pmin=? [ (x!=1) W false ]", json!(0.85)),
        ("<<us>> Pmax=? [ G x!=1 ]", json!(1)),
        ("<<them>> P>=0.85 [ G x!=1 ]", json!(true)),
        ("<<them>> P>0.85 [ G x!=1 ]", json!(false)),
    ]);
}

#[test]
fn rewards_of_a_game_may_be_kept_where_the_target_is_not_reached() {
    expect(EARNING)(&[
        // The opponent ends it: 1 + 1/4 of the same.
        ("<<us>> R{\"r\"}max=? [ C ]", json!(4.0 / 3.0)),
        ("<<us>> R{\"r\"}min=? [ C ]", json!(0)),
        ("<<us,them>> R{\"r\"}max=? [ C ]", json!(2)),
        ("<<us>> R{\"r\"}max=? [ Fc x=2 ]", json!(4.0 / 3.0)),
        ("<<us>> R{\"r\"}max=? [ Fc x=1 ]", json!(0)),
        ("filter(max, <<them>> R{\"r\"}max=? [ Fc x=2 ], x=1)", json!(2)),
        ("<<us>> R{\"r\"}>=1.3 [ Fc x=2 ]", json!(true)),
        // Formulas that each finite part of a path decides, taken together.
        ("<<us>> Pmax=? [ (F x=1) & (F x=2) ]", json!(0)),
        ("<<us,them>> Pmax=? [ (F x=1) & (F x=2) ]", json!(1)),
        ("<<them>> Pmax=? [ (G x<2) | (G x!=3) ]", json!(1)),
    ]);
}

/// The best choice depends on the reward so far: 4 are kept, and 0 are risked for 2.
const RISK: &str = "mdp\nmodule m\n x : [0..5] init 0;\n [draw] x=0 -> 1/2:(x'=1) + 1/2:(x'=2);\n\
    [on] x=1 | x=2 -> (x'=3);\n [keep] x=3 -> (x'=4);\n [risk] x=3 -> 1/2:(x'=4) + 1/2:(x'=5);\n\
   endmodule\n\
    rewards \"r\" x=1 : 4; [risk] true : 2; endrewards\n";

#[test]
fn rewards_may_be_lost_where_the_target_is_not_reached() {
    expect(RISK)(&[
        ("R{\"r\"}max=? [ F0 x=4 ]", json!(2.5)),
        ("R{\"r\"}min=? [ F0 x=4 ]", json!(1.5)),
        ("R{\"r\"}max=? [ F0 x=5 ]", json!(2)),
        ("R{\"r\"}max=? [ F0 x=0 ]", json!(0)),
        ("R{\"r\"}>=1.5 [ F0 x=4 ]", json!(true)),
    ]);
    // Both sides can stay until the opponent takes the greater chance, by which rewards are not without bound.
    let game = "smg\nplayer us m, [go], [leave] endplayer\nplayer them [a], [b] endplayer\nmodule m\n x : [0..3] init 0;\n\
        [a] x=0 -> (x'=1);\n [b] x=0 -> 3/5:(x'=2) + 2/5:(x'=3);\n [go] x=1 -> (x'=0);\n\
        [leave] x=1 -> 1/2:(x'=2) + 1/2:(x'=3);\nendmodule\nrewards \"r\" [go] true : 1; endrewards\n";
    let scratch = Scratch::new(&[("m.prism", game)]);
    let property = "<<us>> R{\"r\"}max=? [ F0 x=2 ]";
    let found = scratch.run(format!("reach m.prism --property '{property}'"));
    found.ends(2, "`F0` is not supported for this game");
}

#[test]
fn min_and_max_accept_one_argument() {
    expect(CHAIN)(&[("min(P=? [ F<=2 x=3 ])", json!(1.0 / 6.0)), ("max(3) + min(2,1)", json!(4))]);
}

#[test]
fn a_bracket_may_follow_a_constant_number_of_steps_and_the_number_may_be_large() {
    let file = "const int T = 2;\nP=? [ F<=T (x=3) ];\nP=? [ F<=min(T,30000) x=3 ];\nP>0.999 [ F<=30000 (x=3) ];\n\
                P=? [ x<3 U[1,T] (x=3) ];\nR=? [ C{0.9} ];";
    for engine in ["explicit", "symbolic"] {
        let found = answers(CHAIN, file, engine);
        for at in [0, 1, 3] {
            let value = found[at]["value"]["lower"].as_f64().unwrap();
            assert!((value - 1.0 / 6.0).abs() < 1e-9, "{at} ({engine}): {}", found[at]);
        }
        assert_eq!(found[2]["holds"], json!(true));
        assert!(found[4]["reason"].as_str().unwrap().contains("discounted rewards are not supported"));
    }
}

/// A bound on rewards was called a discount, and `Cdiscount` an unknown name.
#[test]
fn properties_of_other_tools_are_refused_by_the_name_of_what_they_ask() {
    let cases = [
        ("R=? [ C{\"c\"}<=2 ]", "bounds on rewards are not supported"),
        ("P=? [ F{\"c\"}<=2 x=3 ]", "bounds on rewards are not supported"),
        ("R=? [ Cdiscount=0.9 ]", "discounted rewards are not supported"),
        ("Pmaxmin=? [ F x=3 ]", "`Pmaxmin` is about intervals of probabilities"),
        ("<n, PreSafety, lambda=0.9> P=? [ G x<3 ]", "a shield expression is not a property"),
        ("P=? [ F x=2 || x=3 ]", "`||` is not an operator"),
    ];
    for (property, message) in cases {
        let found = &answers(CHAIN, &format!("{property};"), "explicit")[0];
        let reason = found["reason"].as_str().unwrap_or_else(|| panic!("{property}: {found}"));
        assert!(reason.contains(message), "{property}: {reason}");
    }
}

#[test]
fn a_property_that_refers_to_itself_is_refused() {
    let found =
        answers(CHAIN, "\"a\": !\"b\";\n\"b\": \"a\" & x=0;\n\"c\": x=0;\n\"d\": \"c\" | x=1;", "explicit");
    assert!(found[0]["reason"].as_str().unwrap().contains("refers to itself"), "{found:?}");
    assert_eq!(found[3]["holds"], json!(true));
}

/// The first property took the whole time limit, and the second one was not answered.
#[test]
fn a_property_without_an_end_leaves_the_others_their_share_of_the_time() {
    let endless = "R=? [ C<=1000000000000 ] + 0;\nfilter(count, x<2);\nP=? [ F x=3 ];\n";
    let scratch = Scratch::new(&[("m.prism", CHAIN), ("m.props", endless)]);
    let ask = |more: &[&str]| scratch.ask("reach m.prism --properties m.props --json", more).expect(4);
    let finished = ask(&["--timeout", "4s"]);
    finished.says("used up its share of the limit of 4s");
    let found = finished.json()["properties"].clone();
    let reason = found[0]["reason"].as_str().unwrap_or_default();
    assert!(reason.contains("its share of the time limit ended"), "{found}");
    assert_eq!(
        (&found[1]["value"]["upper"], &found[2]["value"]["upper"]),
        (&json!(2.0), &json!(1.0)),
        "{found}"
    );
}

/// The list of states of the first property does not fit into the memory limit, and the second one needs none.
#[test]
fn a_property_that_needs_too_much_memory_leaves_the_others() {
    let model = "mdp\nmodule m\n x : [0..999];\n y : [0..999];\n z : [0..99];\n [a] x<999 -> 1/2:(x'=x+1) + 1/2:(y'=0);\n\
         [b] y<999 -> (y'=y+1);\n [c] z<99 -> 1/2:(z'=z+1) + 1/2:(z'=0);\nendmodule\n";
    let scratch = Scratch::new(&[
        ("m.prism", model),
        ("m.props", "filter(sum, Pmax=? [ F x=3 ]);\nfilter(count, x<2&y<1&z<1);\n"),
    ]);
    let found = scratch.run("reach m.prism --properties m.props --json");
    let found = found.expect(4).json()["properties"].clone();
    assert_eq!(found[0]["reason"], "too large: more than 1048576 states to list", "{found}");
    assert_eq!(found[1]["value"]["upper"], json!(2.0), "{found}");
}

/// `--policy` wrote no file, without a message.
#[test]
fn a_policy_of_a_property_that_is_not_one_operator_is_refused() {
    let scratch = Scratch::new(&[("m.prism", CHOICES)]);
    for (property, words) in [
        ("1 - Pmax=? [ F x=1 ]", "is that of one operator"),
        ("filter(max, Pmax=? [ F<=2 x=1 ], x<2)", "is that of one operator"),
    ] {
        let found = scratch.run(format!("reach m.prism --property '{property}' --policy policy.json"));
        found.ends(2, words);
    }
}

/// Properties with several operators were refused under requirements.
#[test]
fn under_requirements_the_operators_of_a_property_are_about_the_strategies_that_keep_them() {
    let model = "mdp\nmodule m\n x : [0..3] init 0;\n [a] x=0 -> 1/2:(x'=1) + 1/2:(x'=3);\n [b] x=0 -> (x'=2);\n\
         [c] x=1 -> (x'=2);\n [d] x>1 -> true;\nendmodule\n";
    let file = "Pmax=? [ F x=1 ] + 0;\nP>=1 [ F P>=1 [ X x=2 ] ];\nfilter(count, true);\n\
         Pmax=? [ (F x=1) & (F x=2) ] + 0;\nmulti(Pmax=? [ F x=1 ], P>=0 [ F x=2 ]);\n\
         A [ (F x=1) & (F x=2) ];\n";
    let scratch = Scratch::new(&[("m.prism", model), ("m.props", file)]);
    let ask = |more: &[&str]| {
        let found = scratch.ask("reach m.prism --properties m.props --json", more);
        let json: Json = serde_json::from_str(&found.stdout).unwrap_or_else(|_| panic!("{}", found.stderr));
        json["properties"].as_array().unwrap().clone()
    };
    let upper = |answer: &Json| answer["value"]["upper"].as_f64().map(|x| (x * 1e6).round() / 1e6);
    for engine in ["explicit", "symbolic"] {
        let free = ask(&["--engine", engine]);
        assert_eq!([0, 2, 3, 4].map(|at| upper(&free[at])), [0.5, 4.0, 0.5, 0.5].map(Some), "{free:?}");
        let kept = ask(&["--engine", engine, "--require", "G x!=3"]);
        assert_eq!([0, 2, 3, 4].map(|at| upper(&kept[at])), [0.0, 3.0, 0.0, 0.0].map(Some), "{kept:?}");
        assert_eq!((&free[1]["holds"], &kept[1]["holds"]), (&json!(false), &json!(true)), "{kept:?}");
        assert!(kept[5]["reason"].as_str().is_some_and(|reason| reason.contains("under requirements")));
        let lost = ask(&["--engine", engine, "--require", "G x!=0"]);
        assert_eq!((&lost[0]["value"], &lost[1]["holds"]), (&Json::Null, &json!(false)), "{lost:?}");
    }
}

#[test]
fn bounds_of_zero_and_implications_between_operators_hold_where_their_definitions_do() {
    expect(CHOICES)(&[
        ("P<=0 [ F P>=1 [ X x=0 ] ]", json!(true)),
        ("P<=0 [ F P>=1 [ X x=1 ] ]", json!(false)),
        ("P<1 [ F P>=1 [ X x=1 ] ]", json!(true)),
        ("P<1 [ F P>=1 [ X x>0 ] ]", json!(false)),
        ("P>=1 [ G (P>=1 [ X x=1 ] => x=1) ]", json!(true)),
        ("Pmax=? [ X (P>=1 [ X x=2 ] => x=1) ]", json!(0.5)),
        ("Pmin=? [ X (P>=1 [ X x=2 ] => P<=0 [ X x=1 ]) ]", json!(1)),
    ]);
}
