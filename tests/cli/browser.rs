//! The page in a browser: Chromium opens it, moves a slider and steps through the run. The values of the
//! cells are compared with `meliora query`. Without Chromium the test prints a message and is skipped.

use std::process::{Command, Stdio};

use crate::common::prelude::*;

type Cells = BTreeMap<(i64, i64), String>;

/// The browser, if there is one.
fn chromium() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"];
    let given = std::env::var_os("CHROMIUM").map(PathBuf::from);
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let found = names.iter().find_map(|n| folders.iter().map(|f| f.join(n)).find(|p| p.is_file()));
    given.or(found)
}

/// Returns the output of Chromium on stdout for these arguments.
pub(crate) fn browse(browser: &Path, scratch: &Scratch, arguments: &[&str]) -> String {
    let log = scratch.path("browser.out");
    let mut child = Command::new(browser)
        // The sandbox needs rights that containers do not give; the page is ours.
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars"])
        .arg(format!("--user-data-dir={}", scratch.show("profile")))
        // Chromium and its libraries write settings and caches to the home folder.
        .env("HOME", scratch.show("home"))
        .env("XDG_CONFIG_HOME", scratch.show("home/config"))
        .env("XDG_CACHE_HOME", scratch.show("home/cache"))
        .args(["--no-first-run", "--virtual-time-budget=5000"])
        .args(arguments)
        .stdout(std::fs::File::create(&log).unwrap())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let ended = child.wait().unwrap();
    assert!(ended.success(), "the browser failed: {ended}");
    std::fs::read_to_string(log).unwrap()
}

/// The values of the cells of a map.
fn cells(dom: &str, map: &str) -> Cells {
    let figure = dom.split("<figure").find(|part| part.contains(&format!("id=\"map-{map}\""))).unwrap();
    let attribute = |part: &str, name: &str| {
        let from = part.find(&format!("{name}=\"")).unwrap() + name.len() + 2;
        part[from..].split('"').next().unwrap().to_owned()
    };
    let number = |part: &str, name: &str| attribute(part, name).parse::<i64>().unwrap();
    let parts = figure.split("<g class=\"cell").skip(1);
    parts.map(|p| ((number(p, "data-row"), number(p, "data-col")), attribute(p, "data-value"))).collect()
}

/// Returns the ranks that `query` lists, for the cells in which a condition holds.
fn queried(dump: &str, kind: &str, levels: usize, condition: &str) -> Cells {
    let mut cells = Cells::new();
    let mut note = |region: &str, value: &str| {
        let arguments = ["query", dump, region, "--where", condition, "--list", "100", "--json"];
        let found = Finished::of(executable().args(arguments)).expect(0).json();
        for state in found["states"].as_array().unwrap() {
            let value_of = |name: &str| state["state"][name].as_i64().unwrap();
            cells.insert((value_of("r"), value_of("c")), value.to_owned());
        }
    };
    note("reachable", "0");
    for k in 1..=levels {
        note(&format!("{kind}:{k}"), &k.to_string());
    }
    note(&format!("{kind}:unbounded"), "∞");
    cells
}

/// Returns the values that `values` computes, for the cells in which the other variables have values.
fn computed(values: &Json, others: &Json, k: usize, what: &str) -> BTreeMap<(i64, i64), Option<f64>> {
    let fits = |state: &&Json| {
        others.as_object().unwrap().iter().all(|(name, value)| state["state"][name] == *value)
    };
    let cell = |state: &Json| {
        let place = ["r", "c"].map(|name| state["state"][name].as_i64().unwrap());
        ((place[0], place[1]), state["levels"][k][what]["lower"].as_f64())
    };
    values["states"].as_array().unwrap().iter().filter(fits).map(cell).collect()
}

/// A script that notes where the maps end, how wide the page is, and how light the lightest cell.
const PROBE: &str = "<script>const box = (map) => document.querySelector('#map-' + map + ' svg').getBoundingClientRect();\
    const fills = [...document.querySelectorAll('.cell rect')].map((rect) => getComputedStyle(rect).fill);\
    const sum = (fill) => fill.match(/[\\d.]+/g).slice(0, 3).map(Number).reduce((a, b) => a + b) * (fill.startsWith('rgb') ? 1 : 255);\
    const light = Math.max(...fills.filter((fill) => !fill.startsWith('url')).map(sum));\
    const low = Math.max(...['sasi', 'spi', 'classes'].map((map) => box(map).bottom));\
    parent.document.body.dataset[window.name] = [low, document.documentElement.scrollWidth, light].join(' ');</script>";

/// Shows pages in one window, each with a script at its end and in a frame of its width. Returns what each script
/// notes under the name of its window. (Windows of the browser are at least 500 pixels wide.)
pub(crate) fn noted(
    browser: &Path,
    scratch: &Scratch,
    options: &[&str],
    script: &str,
    pages: &[(&str, usize)],
) -> Vec<String> {
    let frame = |(number, (page, width)): (usize, &(&str, usize))| {
        let inner = page.replace("</body>", &format!("{script}</body>"));
        let inner = inner.replace('&', "&amp;").replace('"', "&quot;");
        let size = format!("style=\"border:0\" width={width} height=900");
        format!("<iframe name=\"f{number}\" {size} srcdoc=\"{inner}\"></iframe>")
    };
    let frames: String = pages.iter().enumerate().map(frame).collect();
    let file = scratch.show("frames.html");
    std::fs::write(&file, format!("<!doctype html><body style=\"margin:0\">{frames}</body>")).unwrap();
    let url = format!("file://{file}");
    let all = [options, &["--window-size=1400,900", "--dump-dom", &url]].concat();
    let dom = browse(browser, scratch, &all);
    let head = dom.split("<iframe").next().unwrap();
    let note = |number: usize| {
        let found = head.split(&format!(" data-f{number}=\"")).nth(1);
        found
            .unwrap_or_else(|| panic!("frame {number} notes nothing: {head}"))
            .split('"')
            .next()
            .unwrap()
            .to_owned()
    };
    (0..pages.len()).map(note).collect()
}

/// Returns the browser, or prints that the test is skipped.
pub(crate) fn browser() -> Option<PathBuf> {
    let found = chromium();
    if found.is_none() {
        eprintln!("skipped: there is no Chromium here to open the page (set CHROMIUM to its path)");
    }
    found
}

#[test]
fn maps_fit_the_window_narrow_pages_and_dark_themes() {
    let Some(browser) = browser() else { return };
    let scratch = Scratch::new(&[]);
    let tall = "generate gridworld --rows 30 --cols 12 --battery none --items 4 --seed 2 --force";
    run(&format!("{tall} --out {}", scratch.show("tall"))).expect(0);
    let tall = format!("{} {}", scratch.show("tall.prism"), scratch.show("tall.pref"));
    let game = "models/pursuit.prism models/pursuit.pref -c N=12";
    let models = ["models/robot5x5.prism models/robot5x5.pref", &tall, game];
    let page = |model: &str| {
        let page = scratch.show("page.html");
        run(&format!("report {model} --out {page}")).expect(0);
        std::fs::read_to_string(page).unwrap()
    };
    let pages = models.map(page);
    let probed = |options: &[&str], width: usize| {
        let frames = pages.each_ref().map(|page| (page.as_str(), width));
        noted(&browser, &scratch, options, PROBE, &frames).into_iter().map(|text| {
            let numbers: Vec<f64> = text.split(' ').map(|number| number.parse().unwrap()).collect();
            <[f64; 3]>::try_from(numbers).unwrap()
        })
    };
    for (model, [low, width, light]) in models.iter().zip(probed(&[], 1400)) {
        assert!(low <= 900.0 && width <= 1400.0 && light > 600.0, "{model}: {low} {width} {light}");
    }
    for (model, [_, _, dark]) in models.iter().zip(probed(&["--blink-settings=preferredColorScheme=0"], 1400))
    {
        assert!(dark < 560.0, "{model}: {dark}");
    }
    for (model, [_, width, _]) in models.iter().zip(probed(&[], 420)) {
        assert!(width <= 420.0, "{model}: {width}");
    }
}

#[test]
fn a_page_shows_in_a_browser_what_query_says() {
    let Some(browser) = browser() else { return };
    let scratch = Scratch::new(&[]);
    let (page, dump) = (scratch.show("page.html"), scratch.show("dump"));
    let robot = "models/robot5x5.prism models/robot5x5.pref --scope all --safety transition";
    run(&format!("report {robot} --out {page}")).expect(0);
    run(&format!("export {robot} --no-certificate --out {dump}")).expect(0);

    // The view that a link leads to.
    let linked = browse(&browser, &scratch, &["--dump-dom", &format!("file://{page}#b=5&d=true&cell=3,2")]);
    let condition = "b=5 & d & !e & !f & !ch";
    assert_eq!(cells(&linked, "sasi"), queried(&dump, "sasi", 2, condition));
    assert_eq!(cells(&linked, "spi"), queried(&dump, "spi", 5, condition));
    assert!(linked.contains("r=3,c=2,b=5,d=true"), "the cell is described");
    let values = run(&format!("values {robot} --all --limit 4096 --json")).expect(0).json();
    for (map, k, what) in [("p2", 1, "probability"), ("c1", 0, "cost")] {
        let shown = cells(&linked, map);
        let expected =
            computed(&values, &json!({"b": 5, "d": true, "e": false, "f": false, "ch": false}), k, what);
        assert_eq!(shown.len(), 25);
        for (cell, text) in shown.iter().filter(|(_, text)| !text.is_empty()) {
            let close = match (text.parse::<f64>(), expected[cell]) {
                (Ok(shown), Some(x)) => (shown - x).abs() <= if x < 1.0 { 0.005 } else { 0.05 },
                (shown, x) => shown.is_err() && (x.is_none() || text == ">0.99"),
            };
            assert!(close, "{map}: {cell:?} shows {text}, {:?} expected", expected[cell]);
        }
    }

    // The slider, moved as a hand would, in a copy with a few lines that move it.
    let moved = scratch.show("moved.html");
    let mover = "<script>const slider = document.getElementById('var-b'); slider.value = 3;\
                 slider.dispatchEvent(new Event('input', { bubbles: true }));\
                 document.querySelector('#map-sasi .cell[data-row=\"2\"][data-col=\"1\"] rect')\
                 .dispatchEvent(new Event('click', { bubbles: true }));</script>";
    let text = std::fs::read_to_string(&page).unwrap().replace("</body>", &format!("{mover}</body>"));
    std::fs::write(&moved, text).unwrap();
    let dom = browse(&browser, &scratch, &["--dump-dom", &format!("file://{moved}")]);
    let condition = "b=3 & !d & !e & !f & !ch";
    let sasi = cells(&dom, "sasi");
    assert_eq!(sasi, queried(&dump, "sasi", 2, condition));
    assert_ne!(sasi, cells(&linked, "sasi"), "the slider changes the picture");
    assert!(dom.contains("r=2,c=1,b=3"), "a click describes the cell");

    // A cell that stands for states of several classes names them, and so does its description.
    let open =
        browse(&browser, &scratch, &["--dump-dom", &format!("file://{page}#b=any&d=any&e=any&cell=2,1")]);
    assert!(open.contains("<title>r=2, c=1: most preferred: B; D; nothing</title>"), "{open}");
    assert!(open.contains("<dd>B; D; nothing (depends on the other values)</dd>"), "{open}");

    // The run, at its second step.
    let play = browse(&browser, &scratch, &["--dump-dom", &format!("file://{page}#step=2")]);
    assert!(play.contains("step 2 of") && play.contains("data-turn=\"2\" class=\"now\""));

    // A picture of it all, wide and as on a phone.
    for (name, size) in [("wide", "1200,1000"), ("phone", "390,1600")] {
        let picture = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("report-{name}.png"));
        let to = format!("--screenshot={}", picture.display());
        let size = format!("--window-size={size}");
        browse(&browser, &scratch, &[&to, &size, &format!("file://{page}")]);
        let bytes = std::fs::read(&picture).unwrap();
        assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 30_000, "{name}: {} bytes", bytes.len());
    }
}

/// The rows of the table of moves: the name, and both columns of ranks.
fn moves(dom: &str) -> BTreeMap<String, [String; 2]> {
    let table = dom.split("<table class=\"moves\">").nth(1).unwrap().split("</table>").next().unwrap();
    let rows = table.split("<tr>").filter(|row| row.contains("<td>"));
    let cells =
        |row: &str| row.split("<td>").skip(1).map(|c| c.split('<').next().unwrap().to_owned()).collect();
    let row = |cells: Vec<String>| (cells[0].clone(), [cells[1].clone(), cells[2].clone()]);
    rows.map(cells).map(row).collect()
}

/// Returns the ranks after each move by `strategy` of one kind.
fn explained(state: &str, kind: &str) -> BTreeMap<String, String> {
    let game = "models/pursuit.prism models/pursuit.pref -c N=3";
    let found = run(&format!("strategy {game} --kind {kind} --at {state} --json")).expect(0).json();
    let at = &found["states"][0];
    assert_eq!(at["owner"], "opponent", "{at}");
    let ranks = |action: &Json| {
        let ranks = action["successors"].as_array().unwrap().iter().map(|to| to["rank"].to_string());
        ranks.collect::<BTreeSet<_>>().into_iter().collect::<Vec<_>>().join(" or ")
    };
    let one = |action: &Json| (action["name"].as_str().unwrap().to_owned(), ranks(action));
    at["actions"].as_array().unwrap().iter().map(one).collect()
}

#[test]
fn the_panel_says_what_each_move_of_the_opponent_leads_to() {
    let Some(browser) = browser() else { return };
    let scratch = Scratch::new(&[]);
    let page = scratch.show("page.html");
    run(&format!("report models/pursuit.prism models/pursuit.pref -c N=3 --out {page}")).expect(0);
    for (x, y, g, locked) in [(0, 0, 0, 0), (0, 1, 2, 0), (0, 3, 3, 2), (3, 3, 0, 1)] {
        let link = format!("file://{page}#robots_turn=false&g={g}&locked={locked}&cell={y},{x}");
        let dom = browse(&browser, &scratch, &["--dump-dom", &link]);
        assert!(dom.contains("<dd class=\"who theirs\">guard, the opponent</dd>"), "{link}");
        let state = format!("x={x},y={y},robots_turn=false,g={g},locked={locked}");
        let (sasi, spi) = (explained(&state, "sasi"), explained(&state, "spi"));
        let both = |(name, rank): (String, String)| (name.clone(), [rank, spi[&name].clone()]);
        assert_eq!(moves(&dom), sasi.into_iter().map(both).collect(), "{state}");
        // All cells of this view are the guard's.
        let figure = dom.split("id=\"map-sasi\"").nth(1).unwrap().split("</figure>").next().unwrap();
        assert!(figure.contains("class=\"cell theirs\"") && figure.contains("rx=\"17\""), "{figure}");
    }
    let ours =
        browse(&browser, &scratch, &["--dump-dom", &format!("file://{page}#robots_turn=true&cell=1,0")]);
    assert!(ours.contains("<dd class=\"who ours\">robot, ours</dd>") && !ours.contains("class=\"moves\""));
    let run = browse(&browser, &scratch, &["--dump-dom", &format!("file://{page}#step=1")]);
    assert!(
        run.contains("<span id=\"turn\" class=\"who theirs\">guard moves</span>"),
        "the robot moved first"
    );
    assert!(run.contains("<tr class=\"ours now\" data-turn=\"1\">"));
}

/// At x=0 both commands with the label `go` are enabled: two choices. At x=1 only one is.
const LABELS: &str = "TYPE\nmodule m\n x : [0..4] init 0;\n [go] x=0 -> 0.5:(x'=2) + 0.5:(x'=4);\n\
    [go] x<2 -> 0.5:(x'=2) + 0.5:(x'=3);\n [back] x=0 -> (x'=1);\n [stay] x>1 -> true;\nendmodule\n";
const LABELS_PREFS: &str =
    "objective Near = F (x<=1);\nobjective Two = F x=2;\nobjective More = F x>2;\nprefer Two, More > Near;\n";

/// The texts of the panel after the word `permitted: `.
fn permitted(dom: &str) -> BTreeSet<String> {
    let panel = dom.split("; permitted: ").nth(1).map(|rest| rest.split('<').next().unwrap());
    panel.into_iter().flat_map(|names| names.split(", ")).map(str::to_owned).collect()
}

#[test]
fn choices_with_one_label_have_the_names_that_strategy_gives_them() {
    let Some(browser) = browser() else { return };
    let players =
        "smg\nplayer p [go], [back], [stay] endplayer\nplayer q o endplayer\nmodule o\n y : bool;\nendmodule";
    let [mdp, game] = ["mdp", players].map(|kind| LABELS.replace("TYPE", kind));
    let chain = LABELS.replace("TYPE", "dtmc");
    let files = [("m.prism", &*mdp), ("g.prism", &*game), ("c.prism", &*chain), ("m.pref", LABELS_PREFS)];
    let scratch = Scratch::new(&files);
    let page = scratch.show("page.html");
    scratch.run("report m.prism m.pref --out page.html").expect(0);
    for x in [0, 1] {
        let at = format!("x={x}");
        let told = scratch.run(format!("strategy m.prism m.pref --at '{at}' --json")).expect(0).json();
        let actions = told["states"][0]["actions"].as_array().unwrap().iter();
        let kept = actions.filter(|action| action["permitted"] == true);
        let expected: BTreeSet<String> =
            kept.map(|action| action["name"].as_str().unwrap().to_owned()).collect();
        let dom = browse(&browser, &scratch, &["--dump-dom", &format!("file://{page}#cell=0,{x}")]);
        assert_eq!(permitted(&dom), expected, "{at}: {dom}");
    }
    // In a Markov chain, nothing is chosen.
    scratch.run("report c.prism m.pref --out page.html").expect(0);
    let dom = browse(&browser, &scratch, &["--dump-dom", &format!("file://{page}#cell=0,0")]);
    let guaranteed = dom.split("<dt>guaranteed</dt>").nth(1).unwrap().split("</dd>").next().unwrap();
    assert_eq!(guaranteed, "<dd>1");
    // The opponent of a game has the same choices.
    scratch.run("report g.prism m.pref --coalition q --out page.html").expect(0);
    let dom = browse(&browser, &scratch, &["--dump-dom", &format!("file://{page}#cell=0,0")]);
    let names: Vec<String> = moves(&dom).into_keys().collect();
    assert_eq!(names, ["back", "go(m#1)", "go(m#2)"], "{dom}");
}
