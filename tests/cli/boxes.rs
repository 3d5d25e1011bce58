//! The layout of pages, by the boxes of the browser: marks stay inside of their cells, and texts neither
//! overlap nor are cut, on screens and on phones. Without Chromium the tests are skipped.

use crate::cli::browser::{browser, noted, shown};
use crate::common::prelude::*;

/// A robot on a grid, whose places are objectives.
fn robot(rows: usize, columns: usize, names: [&str; 2], objectives: usize) -> [String; 2] {
    let [row, column] = names;
    let (bottom, end) = (rows - 1, columns - 1);
    let model = format!(
        "mdp\nmodule robot\n {row} : [0..{bottom}] init {bottom}; {column} : [0..{end}] init 0; door : bool init false;\n\
         [north] {row}>0 -> 0.9:({row}'={row}-1) + 0.1:true;\n [south] {row}<{bottom} -> ({row}'={row}+1);\n\
         [east] {column}<{end} -> ({column}'={column}+1);\n [west] {column}>0 -> 0.5:({column}'={column}-1) + 0.5:true;\n\
         [push] {row}=0 & !door -> 0.3:(door'=true) + 0.7:true;\nendmodule\nlabel \"carpet\" = {column}=0;\n"
    );
    let one = |i: usize| {
        let place = format!("{row}={} & {column}={}", i * 3 % rows, i * 5 % columns);
        format!("objective Objective_{i}_of_the_mission = F (door & {place});\n")
    };
    let order = (1..objectives)
        .map(|i| format!("prefer Objective_{i}_of_the_mission > Objective_0_of_the_mission;\n"));
    let own = (0..objectives).map(one);
    [model, own.chain(order).collect()]
}

/// Two robots' positions on a strip, and what remains of the battery: a map that is wide and low.
const STRIP: &str = "mdp\nmodule strip\n p : [0..3] init 0; e : [0..29] init 29; door : bool init false;\n\
    [on] p<3 & e>0 -> (p'=p+1) & (e'=e-1);\n [back] p>0 & e>0 -> (p'=p-1) & (e'=e-1);\n [rest] e>0 -> (e'=e-1);\n\
    [open] !door -> 0.5:(door'=true) + 0.5:true;\nendmodule\n";
const STRIP_PREFS: &str =
    "objective Through = F (door & p=3);\nobjective Door = F door;\nprefer Through > Door;\n";

#[test]
fn marks_stay_in_their_cells_and_texts_are_whole_on_screens_and_phones() {
    let Some(browser) = browser() else { return };
    let short = ["r", "c"];
    let long = ["position_of_the_robot_row", "position_of_the_robot_col"];
    let models = [
        robot(1, 1, short, 1),
        robot(4, 3, short, 3),
        robot(12, 20, short, 12),
        robot(60, 40, short, 5),
        robot(40, 2, short, 2),
        robot(5, 6, long, 4),
        [STRIP.to_owned(), STRIP_PREFS.to_owned()],
        ["models/pursuit.prism", "models/pursuit.pref"]
            .map(|file| fs::read_to_string(file).unwrap().replace("const int N;", "const int N = 9;")),
    ];
    // The maps take their sizes after the first frame; sliders are at their start.
    let script = format!("<script>setTimeout(() => {{ {} }}, 500);</script>", include_str!("boxes.js"));
    let page = |[model, prefs]: &[String; 2]| {
        let scratch = Scratch::new(&[("m.prism", model), ("p.pref", prefs)]);
        let page = scratch.show("page.html");
        scratch.run("report m.prism p.pref --out page.html").expect(0);
        fs::read_to_string(&page).unwrap()
    };
    let pages: Vec<String> = models.iter().map(page).collect();
    let frames: Vec<_> = pages.iter().flat_map(|page| [(page.as_str(), 1400), (page, 420)]).collect();
    let noted = noted(&browser, &Scratch::new(&[]), &[], &script, &frames);
    for (number, faults) in noted.iter().enumerate() {
        assert_eq!(faults, "none", "model {}, {} pixels", number / 2, frames[number].1);
    }
}

/// Returns the glyphs of the marks in a map of ranks, without pale ones.
fn marks(dom: &str) -> Vec<String> {
    let figure = dom.split("id=\"map-sasi\"").nth(1).unwrap().split("</figure>").next().unwrap();
    let marks = figure.split("<text class=\"single\"").skip(1);
    marks.map(|part| part.split('>').nth(1).unwrap().split('<').next().unwrap().to_owned()).collect()
}

#[test]
fn marks_follow_the_sliders_and_are_left_out_where_most_cells_have_them() {
    let scratch = Scratch::new(&[("m.prism", STRIP), ("p.pref", STRIP_PREFS)]);
    let page = scratch.show("page.html");
    let written = |options: &[&str]| {
        scratch.ask("report m.prism p.pref --out page.html", options).expect(0);
        fs::read_to_string(&page).unwrap()
    };
    // The door is open in no state of the first view, and in each of the second one.
    assert_eq!(marks(&written(&[])), [""; 0]);
    let open = written(&["--at", "p=3,e=20,door=true"]);
    let expected = vec!["T"; marks(&open).len()];
    assert_eq!(marks(&open), expected);
    assert!((20..=30).contains(&expected.len()), "{}", expected.len());
    assert!(open.contains("<li data-mark=\"0\"><span class=\"glyph\">T</span>Through</li>"), "{open}");
    assert!(open.contains("<li data-mark=\"1\" hidden"), "{open}");
    let Some(browser) = browser() else { return };
    let views = ["door=true", "door=false", "door=any"];
    let doms = shown(&browser, &scratch, views.map(|view| format!("{page}#{view}")));
    for (view, dom) in views.iter().zip(doms) {
        let count = if *view == "door=false" { 0 } else { expected.len() };
        assert_eq!(marks(&dom), vec!["T"; count], "{view}");
        // Pale marks show the states with other values.
        let pale = dom.split("</figure>").next().unwrap().matches("<text class=\"single pale\"").count();
        assert_eq!(pale, if count == 0 { expected.len() } else { 0 }, "{view}");
        assert_eq!(dom.contains("<li class=\"faint\" hidden"), count > 0, "{view}");
    }
}
