//! The contents of the report page and of the pictures.

use crate::cli::common::{LONG, LONG_PREFS};
use crate::common::prelude::*;

const ROBOT: &str = "report models/robot5x5.prism models/robot5x5.pref";

/// The data that the page's script reads.
pub(crate) fn data(page: &str) -> Json {
    let from = page.find("<script id=\"data\"").unwrap();
    let text = &page[from..];
    let text = &text[text.find('>').unwrap() + 1..text.find("</script>").unwrap()];
    serde_json::from_str(text).unwrap()
}

#[test]
fn a_page_is_one_file_that_loads_nothing() {
    let scratch = Scratch::new(&[]);
    let out = scratch.show("page.html");
    let found = run!("{ROBOT} --scope all --safety transition --out {out} --json").expect(0).json();
    assert_eq!(found["schema"], "meliora.report/1");
    assert_eq!(found["written"]["grid"], serde_json::json!(["r", "c"]));
    assert_eq!(found["check"]["initial"][0]["sasi_rank"], 2);
    let page = fs::read_to_string(out).unwrap();
    assert_eq!(found["written"]["bytes"], page.len());
    for loading in ["src=", "href=", "@import", "fetch(", "url(http"] {
        assert!(!page.contains(loading), "{loading}");
    }
    assert_eq!(page.matches("http").count(), page.matches("http://www.w3.org/2000/svg").count());
    assert!(page.contains("<p class=\"headline\">Can improve from nothing to "), "{page}");
    // Without a script, too: the cell where planning starts is there with its rank.
    assert!(page.contains("data-row=\"2\" data-col=\"2\" data-value=\"2\""));
    assert_eq!(data(&page)["play"][0], serde_json::json!([2, 2, 8, 0, 0, 0, 0]));
}

#[test]
fn without_a_plane_there_are_no_maps_but_all_the_rest() {
    let model = "mdp\nmodule m\n w : [0..99999] init 0;\n [] w<2 -> (w'=w+1);\nendmodule\n";
    let scratch = Scratch::new(&[("m.prism", model), ("p.pref", "objective A = F w=2;\n")]);
    let (m, p, out) = (scratch.show("m.prism"), scratch.show("p.pref"), scratch.show("page.html"));
    run!("report {m} {p} --out {out}").expect(0);
    let page = fs::read_to_string(&out).unwrap();
    assert!(page.contains("<code>--grid ROW,COLUMN</code>") && !page.contains("id=\"data\""));
    run!("report {m} {p} --format svg --picture sasi").expect(2);
}

#[test]
fn maps_are_over_the_first_two_integers_where_no_names_suggest_better_ones() {
    let model = "mdp\nmodule m\n f : bool; w : [0..99999] init 0; p : [0..2] init 0; q : [0..3] init 0;\n \
                 [] p<2 -> (p'=p+1);\nendmodule\n";
    let scratch = Scratch::new(&[("m.prism", model), ("p.pref", "objective A = F p=2;\n")]);
    let (m, p) = (scratch.show("m.prism"), scratch.show("p.pref"));
    let page = run!("report {m} {p} --scope all").expect(0).stdout;
    assert_eq!((&data(&page)["row"], &data(&page)["column"]), (&2.into(), &3.into()));
    let strip = run!("report {m} {p} --format svg --picture classes --grid q").expect(0).stdout;
    // No other value of q is ever reached.
    assert_eq!(strip.matches("class=\"cell\"").count(), 4);
    assert_eq!(strip.matches("height=\"40\" fill=\"url(#wall)\"").count(), 3);
    assert!(strip.contains(">unreachable</text>"));
}

#[test]
fn the_play_shown_keeps_what_is_promised() {
    let page = run!("{ROBOT} --safety action").expect(0).stdout;
    assert!(page.contains("The run makes 2 improvements, and achieves "), "{page}");
    assert!(page.contains("<details open><summary class=\"hint\">All steps"), "short runs are shown in full");
    run!("{ROBOT} --safety action --kind sasi")
        .prints(0, "All guaranteed improvements happen: 2 improvements.");
    let lucky = run!("{ROBOT} --safety action --kind spi --scheduler permissive").expect(0).stdout;
    assert!(
        lucky.contains("The run is cut off after 500 steps") || lucky.contains("No simulated run made all"),
        "{lucky}"
    );
    if lucky.contains("after 500 steps") {
        assert!(
            lucky.contains("<details><summary class=\"hint\">All steps"),
            "long runs are folded, not cut"
        );
    }
}

#[test]
fn a_battery_that_hides_most_cells_is_open_and_the_other_pale_cells_speak_of_other_values() {
    let page = run(ROBOT).expect(0).stdout;
    // With the full battery of the start, 19 of 20 cells would be pale.
    assert_eq!(data(&page)["opening"], serde_json::json!([2, 2, null, 0, 0, 0, 0]));
    assert!(page.contains("each cell shows the best of these."));
    assert!(page.contains("<code>--safety action</code> counts"), "options are no text in backticks");
    let maps = page.matches("<figure class=\"map\"").count();
    assert!(maps > 3);
    assert_eq!(page.matches("class=\"cell elsewhere\"").count(), maps * 3);
}

#[test]
fn axes_are_neither_monitors_nor_turns_and_may_be_booleans() {
    let model = "mdp\nmodule m\n turn : [0..1] init 0; a : bool init false; c : bool init false;\n \
        [x] turn=0 & !a -> 0.5:(a'=true)&(turn'=1)+0.5:true;\n [y] a & !c -> 0.5:(c'=true)+0.5:(a'=false);\n \
        [z] true -> true;\nendmodule\n";
    let scratch =
        Scratch::new(&[("m.prism", model), ("p.pref", "objective A = F (a & X c); objective Z = F G c;\n")]);
    let page = run!("report {} {}", scratch.show("m.prism"), scratch.show("p.pref")).expect(0).stdout;
    assert_eq!((&data(&page)["row"], &data(&page)["column"]), (&1.into(), &2.into()));
}

#[test]
fn names_of_files_cannot_become_parts_of_the_page() {
    let scratch = Scratch::new(&[]);
    let model = scratch.path("<script>x&.prism");
    fs::copy("models/robot5x5.prism", &model).unwrap();
    let arguments = ["report", model.to_str().unwrap(), "models/robot5x5.pref"];
    let page = Finished::of(executable().args(arguments)).expect(0).stdout;
    assert!(page.contains("&lt;script&gt;x&amp;.prism") && !page.contains("<script>x"));
}

#[test]
fn other_formats_are_pictures() {
    let hasse = run!("{ROBOT} --format svg --picture hasse").expect(0).stdout;
    assert!(hasse.starts_with("<svg") && hasse.matches("class=\"cover\"").count() == 6, "{hasse}");
    let map = run!("{ROBOT} --format svg --scope all --at r=0,c=0,b=3").expect(0).stdout;
    assert_eq!(map.matches("class=\"cell\"").count(), 25);
    assert!(
        map.contains("#bee6c8") && !map.contains("var("),
        "programs that draw SVG know no variables: {map}"
    );
    let dot = run!("{ROBOT} --format dot").expect(0).stdout;
    assert!(dot.starts_with("digraph") && dot.matches(" -> ").count() == 9, "{dot}");
}

#[test]
fn what_cannot_be_drawn_is_refused_by_name() {
    for (options, status, word) in [
        ("--engine explicit", 2, "`--engine explicit`"),
        ("--format html --picture sasi", 2, "`--picture`"),
        ("--format md", 2, "html, svg, dot"),
        ("--format dot --picture spi", 2, "preference order"),
        ("--json", 2, "--out"),
        ("--grid r,z", 3, "unknown variable `z`"),
        ("--grid r,r", 3, "twice"),
        ("--at r=9", 3, "range"),
    ] {
        let found = run!("{ROBOT} {options}").expect(status);
        assert!(found.stderr.contains(word) && !found.stdout.contains("<html"), "{options}: {found:#?}");
    }
    let wide = "mdp module m x : [0..9999] init 0; y : [0..9999] init 0; [] true -> true; endmodule";
    let scratch = Scratch::new(&[("m.prism", wide), ("p.pref", "objective A = F x=2;\n")]);
    let (m, p) = (scratch.show("m.prism"), scratch.show("p.pref"));
    run!("report {m} {p} --grid y,x").ends(3, "can be drawn");
}

#[test]
fn a_page_that_was_not_finished_is_not_there() {
    let scratch = Scratch::new(&[("m.prism", LONG), ("p.pref", LONG_PREFS)]);
    let (m, p, out) = (scratch.show("m.prism"), scratch.show("p.pref"), scratch.show("page.html"));
    run!("report {m} {p} -c N=4000 --timeout 200ms --out {out}").expect(4);
    assert!(!scratch.path("page.html").exists());
    let folder = scratch.show("nowhere/page.html");
    run!("{ROBOT} --out {folder}").expect(3);
}

#[test]
fn the_state_shown_first_can_be_chosen() {
    let found = Finished::of(executable().args(ROBOT.split(' ')).args([
        "--scope",
        "all",
        "--at",
        "r=4,c=1,b=3,f=true",
    ]))
    .expect(0);
    let data = data(&found.stdout);
    assert_eq!(data["at"], serde_json::json!([4, 1, 3, 0, 0, 1, 0]));
    assert_eq!(data["play"][0], data["at"]);
}

#[test]
fn values_have_maps_a_sentence_and_the_run() {
    let page = run("report models/drone.prism models/drone.pref").expect(0).stdout;
    let sentence = "Can improve from Shore to Ridge or Wreck with probability one, in 1 step on average; \
                    a second time, to Cabin, with probability 0.17.";
    assert!(page.contains(sentence), "{page}");
    for (map, text) in [("p2", "0.17"), ("c1", "1")] {
        let figure = &page[page.find(&format!("id=\"map-{map}\"")).unwrap()..];
        assert!(figure[..figure.find("</figure>").unwrap()].contains(&format!("data-value=\"{text}\"")));
    }
    assert!(page.contains("the permitted action with the fewest expected steps"));
    run("report models/drone.prism models/drone.pref --choose likely")
        .prints(0, "the permitted action with the greatest probability of success");
    run("report models/drone.prism models/drone.pref --choose first")
        .prints(0, "the first permitted action that comes closer to its goal");
}

#[test]
fn cells_and_legends_name_the_classes() {
    let page = run(ROBOT).expect(0).stdout;
    // A cell that stands for states of several classes has a square for each, and names all.
    let map = &page[page.find("id=\"map-classes\"").unwrap()..];
    let cell = |row: i32, column: i32| {
        let start = map.find(&format!("data-row=\"{row}\" data-col=\"{column}\"")).unwrap();
        &map[start..start + map[start..].find("</g>").unwrap()]
    };
    assert!(cell(4, 1).contains("<title>C; F; nothing</title>"), "{}", cell(4, 1));
    assert_eq!(cell(4, 1).matches("■</tspan>").count(), 3, "{}", cell(4, 1));
    assert_eq!(cell(2, 0).matches("■</tspan>").count(), 0, "{}", cell(2, 0));
    // The legend of many classes is grouped by the first of their objectives.
    let group = &page[page.find("<li class=\"group\"><b>A</b>").unwrap()..];
    let group = &group[..group.find("</ul>").unwrap()];
    assert_eq!(group.matches("</span>").count(), 3);
    assert!(group.contains("</span>A</li>") && group.contains("</span>A/B/F · A, B or F</li>"), "{group}");
    let figure = &map[..map.find("</figure>").unwrap()];
    assert_eq!(figure.matches("<li class=\"group\">").count(), 3);
}

#[test]
fn more_than_four_classes_of_a_cell_are_three_squares_and_a_sign() {
    let branches: Vec<String> = (1..=6).map(|h| format!("1/6: (x'=1) & (h'={h})")).collect();
    let model = format!(
        "mdp\nmodule m\n x : [0..3] init 0; h : [0..6] init 0;\n [go] x=0 -> {};\n \
         [on] x>0 & x<3 -> (x'=x+1);\nendmodule\n",
        branches.join(" + ")
    );
    let wishes: String = (1..=6).map(|h| format!("objective O{h} = F (x=3 & h={h});\n")).collect();
    let scratch = Scratch::new(&[("m.prism", &model), ("p.pref", &wishes)]);
    let (m, p) = (scratch.show("m.prism"), scratch.show("p.pref"));
    let page = run!("report {m} {p} --grid x").expect(0).stdout;
    let map = &page[page.find("id=\"map-classes\"").unwrap()..];
    let cell = &map[map.find("data-col=\"2\"").unwrap()..];
    let cell = &cell[..cell.find("</g>").unwrap()];
    assert_eq!(cell.matches("■</tspan>").count(), 3, "{cell}");
    assert!(cell.contains("+</tspan>"), "{cell}");
}

#[test]
fn sliders_of_many_variables_are_folded() {
    let page = |count: usize| {
        let variables: String = (0..count).map(|i| format!(" f{i} : bool;")).collect();
        let model = format!(
            "mdp\nmodule m\n x : [0..2] init 0;{variables}\n [] x<2 -> (x'=x+1) & (f0'=!f0);\nendmodule\n"
        );
        let scratch = Scratch::new(&[("m.prism", &model), ("p.pref", "objective A = F x=2;\n")]);
        run!("report {} {} --grid x", scratch.show("m.prism"), scratch.show("p.pref")).expect(0).stdout
    };
    assert!(page(6).contains("<details class=\"others\" open>"));
    assert!(page(7).contains("<details class=\"others\"><summary>"));
}

#[test]
fn monitors_show_words_at_sliders_and_axes() {
    let courier = "report models/courier.prism models/courier.pref";
    run(courier).prints(0, "<option value=\"0\" selected>waiting for key</option>");
    for grid in ["Deliver,place", "place,Deliver", "Deliver"] {
        let page = run!("{courier} --grid {grid}").expect(0).stdout;
        let axis = page.split("class=\"axis ").skip(1).map(|part| part.split("</ol>").next().unwrap());
        assert!(axis.into_iter().any(|axis| axis.contains(">waiting for key</")), "{grid}: {page}");
    }
}

#[test]
fn targets_have_letters_in_maps_of_any_size() {
    let row = "mdp module m x : [0..5] init 0; [] x<5 -> (x'=x+1); endmodule";
    let wishes = "objective Child = F x=1; objective Climber = F x=2;";
    let scratch = Scratch::new(&[("row.prism", row), ("row.pref", wishes)]);
    let two = run!("report {} {}", scratch.show("row.prism"), scratch.show("row.pref"));
    let two = two.expect(0).stdout;
    for (letters, name) in [("Ch", "Child"), ("Cl", "Climber")] {
        assert!(two.contains(&format!("\"><span class=\"glyph\">{letters}</span>{name}</li>")), "{two}");
    }
    // A target in most cells has no letter.
    let rescue = run("report models/rescue.prism models/rescue.pref -c H=2").expect(0).stdout;
    assert!(!rescue.contains("<g class=\"marks\">"), "{rescue}");
    let large = "generate gridworld --rows 26 --cols 26 --battery none --items 4 --seed 5 --out";
    run!("{large} {}", scratch.show("large")).expect(0);
    // The item B is behind a door.
    let large = format!(
        "report {} {} --at open_B=true,open_charger=true",
        scratch.show("large.prism"),
        scratch.show("large.pref")
    );
    let page = run(&large).expect(0).stdout;
    let spots: Vec<_> =
        page.split("<text class=\"single\"").skip(1).map(|t| t.split(['>', '<']).nth(1)).collect();
    assert_eq!(spots.len() % 4, 0);
    assert!(["A", "B", "C", "D"].iter().all(|name| spots.contains(&Some(name))), "{spots:?}");
}

#[test]
fn the_headline_of_a_large_model_names_what_improves() {
    let scratch = Scratch::new(&[]);
    let large = "generate gridworld --rows 12 --cols 12 --items 4 --seed 1 --out";
    run!("{large} {}", scratch.show("large")).expect(0);
    let page = run!("report {} {}", scratch.show("large.prism"), scratch.show("large.pref"));
    let page = page.expect(0).stdout;
    assert!(page.contains("Values are left out"));
    assert!(page.contains("Can improve from B to C or D with probability one."), "{page}");
}

#[test]
fn values_are_left_out_of_large_pages() {
    let large = "report models/scramble.prism models/scramble.pref -c cells=5003";
    let page = run(large).expect(0).stdout;
    assert!(
        page.contains("Values are left out: the model has more than 4,096 states.")
            && !page.contains("map-p")
    );
    assert!(page.contains("Can improve from Cellar to RedVault or BlueVault with probability one."));
    run!("{large} --choose likely").ends(2, "at most 4096 states");
    let drone = "report models/drone.prism models/drone.pref --choose cheap";
    run!("{drone} --kind spi").ends(2, "`--kind spi`");
    run!("{drone} --scheduler permissive").ends(2, "permissive");
}

/// A robot picks up a box: that is a flag, and a label says where it is set.
const STORE: [(&str, &str); 2] = [
    (
        "store.prism",
        "mdp module robot r : [0..3] init 0; c : [0..3] init 0; box : bool init false;\n\
         [n] r<3 -> (r'=r+1); [e] c<3 -> (c'=c+1); [s] r>0 -> (r'=r-1); [w] c>0 -> (c'=c-1);\n\
         [pick] r=1 & c=2 -> (box'=true); endmodule\n\
         label \"Boxed\" = r=1 & c=2; label \"charger\" = r=3 & c=0; label \"wet\" = r=2 & c=2;\n\
         label \"anywhere\" = r>=0; label \"exit\" = r=3 & c=3;",
    ),
    ("store.pref", "objective Boxed = F box; objective Out = F \"exit\"; require G !\"wet\";"),
];

#[test]
fn labels_have_marks_and_flags_are_where_a_label_says() {
    let scratch = Scratch::new(&STORE);
    let store = format!("{} {}", scratch.show("store.prism"), scratch.show("store.pref"));
    let page = run!("report {store}").expect(0).stdout;
    let map = &page[page.find("id=\"map-sasi\"").unwrap()..page.find("id=\"map-spi\"").unwrap()];
    let cell = |row: i32, column: i32| {
        let start = map.find(&format!("data-row=\"{row}\" data-col=\"{column}\"")).unwrap();
        &map[start..start + map[start..].find("</g>").unwrap()]
    };
    let legend = &page[page.find("<ul class=\"legend key\">").unwrap()..];
    let legend = &legend[..legend.find("<li class=\"small\">").unwrap()];
    // The labels of the targets have letters; a label of all cells says nothing.
    for (sign, label) in [("▲", "charger"), ("●", "wet")] {
        assert!(legend.contains(&format!("<span class=\"glyph\">{sign}</span>{label}")), "{legend}");
    }
    assert_eq!(legend.matches("class=\"glyph\"").count(), 4, "{legend}");
    assert!(cell(3, 0).contains(">▲</text>") && cell(2, 2).contains(">●</text>"), "{map}");
    assert!(cell(2, 2).contains("data-value=\"×\""), "{}", cell(2, 2));
    assert!(cell(1, 2).contains(">B</text>") && cell(3, 3).contains(">O</text>"), "{map}");
    assert_eq!(map.matches("<g class=\"marks\">").count(), 4, "{map}");
    assert!(!cell(0, 0).contains(">B</text>"), "{}", cell(0, 0));
    run!("report {store} --format svg --picture spi")
        .prints(0, ">charger</text>")
        .shows("<text class=\"glyph\" x=\"7\" y=\"12\">▲</text>");
}
