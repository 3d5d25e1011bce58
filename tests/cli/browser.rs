//! The page in a browser: Chromium opens it, moves a slider and steps through the run. The values of the
//! cells are compared with `meliora query`. Without Chromium the test prints a message and is skipped.

use std::process::{Command, Stdio};

use crate::common::prelude::*;

type Cells = BTreeMap<(i64, i64), String>;

/// The browser, if there is one.
fn chromium() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"];
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found =
        |name| std::env::split_paths(&path).map(|folder| folder.join(name)).find(|file| file.is_file());
    let given = std::env::var_os("CHROMIUM").map(PathBuf::from);
    given.or_else(|| names.iter().find_map(found))
}

/// Returns the output of Chromium on stdout for these arguments.
fn browse(browser: &Path, scratch: &Scratch, arguments: &[&str]) -> String {
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
    assert!(child.wait().unwrap().success(), "the browser failed");
    std::fs::read_to_string(log).unwrap()
}

/// The values of the cells of a map.
fn cells(dom: &str, map: &str) -> Cells {
    let figure = dom.split("<figure").find(|part| part.contains(&format!("id=\"map-{map}\""))).unwrap();
    let quoted = |part: &str, name: &str| part.split(&format!("{name}=\"")).nth(1).unwrap().to_owned();
    let attribute = |part: &str, name: &str| quoted(part, name).split('"').next().unwrap().to_owned();
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
            let [r, c] = ["r", "c"].map(|name| state["state"][name].as_i64().unwrap());
            cells.insert((r, c), value.to_owned());
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

/// Shows frames in one window, since the start of a browser takes long. Returns the text that each frame notes under the
/// name of its window, or sends to the window around it.
fn in_frames(browser: &Path, scratch: &Scratch, options: &[&str], frames: Vec<String>) -> Vec<String> {
    let listen = "addEventListener('message', (e) => { document.body.dataset[e.data[0]] = e.data[1]; })";
    let (mut html, count) = (format!("<!doctype html><body><script>{listen}</script>"), frames.len());
    for (number, frame) in frames.into_iter().enumerate() {
        html += &format!("<iframe name=\"f{number}\" style=\"border:0\" height=900 {frame}></iframe>");
    }
    let file = scratch.show("frames.html");
    std::fs::write(&file, html).unwrap();
    let url = format!("file://{file}");
    let dom = browse(browser, scratch, &[options, &["--window-size=1400,900", "--dump-dom", &url]].concat());
    let note = |number: usize| {
        let found = dom.split(&format!(" data-f{number}=\"")).nth(1);
        let text = found.unwrap_or_else(|| panic!("frame {number} notes nothing: {dom}")).split('"').next();
        let signs = [("&quot;", "\""), ("&lt;", "<"), ("&gt;", ">"), ("&nbsp;", "\u{a0}"), ("&amp;", "&")];
        signs.iter().fold(text.unwrap().to_owned(), |text, (code, sign)| text.replace(code, sign))
    };
    (0..count).map(note).collect()
}

/// Shows pages, each with a script at its end and in a frame of its width. Returns what each script notes. (Windows of
/// the browser are at least 500 pixels wide.)
pub(crate) fn noted(
    browser: &Path,
    scratch: &Scratch,
    options: &[&str],
    script: &str,
    pages: &[(&str, usize)],
) -> Vec<String> {
    let frame = |(page, width): &(&str, usize)| {
        let inner = page.replace("</body>", &format!("{script}</body>"));
        format!("width={width} srcdoc=\"{}\"", inner.replace('&', "&amp;").replace('"', "&quot;"))
    };
    in_frames(browser, scratch, options, pages.iter().map(frame).collect())
}

/// A script that tells the window around a page what the page shows.
const TELL: &str = "<script>addEventListener('load', () => setTimeout(() =>\
    parent.postMessage([window.name, document.documentElement.outerHTML], '*'), 100));</script>";

/// Shows views: files, each with what follows a `#` in its address. Returns what they show.
pub(crate) fn shown<const N: usize>(browser: &Path, scratch: &Scratch, views: [String; N]) -> [String; N] {
    let frame = |view: String| {
        let (file, hash) = view.split_once('#').unwrap_or((&view, ""));
        let page = std::fs::read_to_string(file).unwrap().replace("</body>", &format!("{TELL}</body>"));
        std::fs::write(format!("{file}.told.html"), page).unwrap();
        format!("width=1400 src=\"file://{file}.told.html#{hash}\"")
    };
    in_frames(browser, scratch, &[], views.map(frame).to_vec()).try_into().unwrap()
}

/// Returns the browser, or prints that the test is skipped.
pub(crate) fn browser() -> Option<PathBuf> {
    chromium().or_else(|| {
        eprintln!("skipped: there is no Chromium here to open the page (set CHROMIUM to its path)");
        None
    })
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
    let probed = |options: &[&str], widths: &[usize]| {
        let frames = widths.iter().flat_map(|&width| pages.each_ref().map(|page| (page.as_str(), width)));
        let notes = noted(&browser, &scratch, options, PROBE, &frames.collect::<Vec<_>>());
        let three = |text: String| {
            let numbers: Vec<f64> = text.split(' ').map(|number| number.parse().unwrap()).collect();
            <[f64; 3]>::try_from(numbers).unwrap()
        };
        notes.into_iter().map(three).collect::<Vec<_>>()
    };
    let light = probed(&[], &[1400, 420]);
    let dark = probed(&["--blink-settings=preferredColorScheme=0"], &[1400]);
    for (at, model) in models.iter().enumerate() {
        let ([low, width, light], [_, narrow, _], [_, _, dark]) = (light[at], light[3 + at], dark[at]);
        assert!(low <= 900.0 && width <= 1400.0 && light > 600.0, "{model}: {low} {width} {light}");
        assert!(dark < 560.0, "{model}: {dark}");
        assert!(narrow <= 420.0, "{model}: {narrow}");
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

    // The slider, moved as a hand would, in a copy with a few lines that move it.
    let moved = scratch.show("moved.html");
    let mover = "<script>const slider = document.getElementById('var-b'); slider.value = 3;\
                 slider.dispatchEvent(new Event('input', { bubbles: true }));\
                 document.querySelector('#map-sasi .cell[data-row=\"2\"][data-col=\"1\"] rect')\
                 .dispatchEvent(new Event('click', { bubbles: true }));</script>";
    let text = std::fs::read_to_string(&page).unwrap().replace("</body>", &format!("{mover}</body>"));
    std::fs::write(&moved, text).unwrap();
    let views = ["b=5&d=true&cell=3,2", "b=any&d=any&e=any&cell=2,1", "step=2"];
    let [linked, open, play] = views.map(|view| format!("{page}#{view}"));
    let [linked, open, play, dom] = shown(&browser, &scratch, [linked, open, play, moved]);

    // The view that a link leads to.
    let condition = "b=5 & d & !e & !f & !ch";
    assert_eq!(cells(&linked, "sasi"), queried(&dump, "sasi", 2, condition));
    assert_eq!(cells(&linked, "spi"), queried(&dump, "spi", 5, condition));
    assert!(linked.contains("r=3,c=2,b=5,d=true"), "the cell is described");
    let values = run(&format!("values {robot} --all --limit 4096 --json")).expect(0).json();
    for (map, k, what) in [("p2", 1, "probability"), ("c1", 0, "cost")] {
        let shown = cells(&linked, map);
        let others = json!({"b": 5, "d": true, "e": false, "f": false, "ch": false});
        let expected = computed(&values, &others, k, what);
        assert_eq!(shown.len(), 25);
        for (cell, text) in shown.iter().filter(|(_, text)| !text.is_empty()) {
            let close = match (text.parse::<f64>(), expected[cell]) {
                (Ok(shown), Some(x)) => (shown - x).abs() <= if x < 1.0 { 0.005 } else { 0.05 },
                (shown, x) => shown.is_err() && (x.is_none() || text == ">0.99"),
            };
            assert!(close, "{map}: {cell:?} shows {text}, {:?} expected", expected[cell]);
        }
    }

    let condition = "b=3 & !d & !e & !f & !ch";
    let sasi = cells(&dom, "sasi");
    assert_eq!(sasi, queried(&dump, "sasi", 2, condition));
    assert_ne!(sasi, cells(&linked, "sasi"), "the slider changes the picture");
    assert!(dom.contains("r=2,c=1,b=3"), "a click describes the cell");

    // A cell that stands for states of several classes names them, and so does its description.
    assert!(open.contains("<title>r=2, c=1: most preferred: B; D; nothing</title>"), "{open}");
    assert!(open.contains("<dd>B; D; nothing (depends on the other values)</dd>"), "{open}");

    // The run, at its second step.
    assert!(play.contains("step 2 of") && play.contains("data-turn=\"2\" class=\"now\""));

    // A picture of it all, wide and as on a phone.
    for (name, size) in [("wide", "1200,1000"), ("phone", "390,1600")] {
        let picture = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("report-{name}.png"));
        let [to, size] = [format!("--screenshot={}", picture.display()), format!("--window-size={size}")];
        browse(&browser, &scratch, &[&to, &size, &format!("file://{page}")]);
        let bytes = std::fs::read(&picture).unwrap();
        assert!(bytes.starts_with(b"\x89PNG") && bytes.len() > 30_000, "{name}: {} bytes", bytes.len());
    }
}

/// The rows of the table of moves: the name, and both columns of ranks.
fn moves(dom: &str) -> BTreeMap<String, [String; 2]> {
    let table = dom.split("<table class=\"moves\">").nth(1).unwrap().split("</table>").next().unwrap();
    let texts =
        |row: &str| row.split("<td>").map(|cell| cell.split('<').next().unwrap().to_owned()).collect();
    let row = |cells: Vec<String>| (cells[1].clone(), [cells[2].clone(), cells[3].clone()]);
    table.split("<tr>").filter(|row| row.contains("<td>")).map(texts).map(row).collect()
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
    let states = [(0, 0, 0, 0), (0, 1, 2, 0), (0, 3, 3, 2), (3, 3, 0, 1)];
    let view = |(x, y, g, locked)| format!("{page}#robots_turn=false&g={g}&locked={locked}&cell={y},{x}");
    let doms = shown(&browser, &scratch, states.map(view));
    let others = ["robots_turn=true&cell=1,0", "step=1"].map(|view| format!("{page}#{view}"));
    let [ours, step] = shown(&browser, &scratch, others);
    for ((x, y, g, locked), dom) in states.into_iter().zip(doms) {
        assert!(dom.contains("<dd class=\"who theirs\">guard, the opponent</dd>"), "{dom}");
        let state = format!("x={x},y={y},robots_turn=false,g={g},locked={locked}");
        let (sasi, spi) = (explained(&state, "sasi"), explained(&state, "spi"));
        let both = |(name, rank): (String, String)| (name.clone(), [rank, spi[&name].clone()]);
        assert_eq!(moves(&dom), sasi.into_iter().map(both).collect(), "{state}");
        // All cells of this view are the guard's.
        let figure = dom.split("id=\"map-sasi\"").nth(1).unwrap().split("</figure>").next().unwrap();
        assert!(figure.contains("class=\"cell theirs\"") && figure.contains("rx=\"17\""), "{figure}");
    }
    assert!(ours.contains("<dd class=\"who ours\">robot, ours</dd>") && !ours.contains("class=\"moves\""));
    assert!(step.contains("id=\"turn\" class=\"who theirs\">guard moves<"), "the robot moved first");
    assert!(step.contains("<tr class=\"ours now\" data-turn=\"1\">"));
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
    let pages = ["m.html", "c.html", "g.html"].map(|name| scratch.show(name));
    scratch.run("report m.prism m.pref --out m.html").expect(0);
    scratch.run("report c.prism m.pref --out c.html").expect(0);
    scratch.run("report g.prism m.pref --coalition q --out g.html").expect(0);
    let [mdp, chain, game] = pages.map(|page| format!("{page}#cell=0,0"));
    let later = mdp.replace("0,0", "0,1");
    let [at_0, at_1, chain, game] = shown(&browser, &scratch, [mdp, later, chain, game]);
    for (x, dom) in [at_0, at_1].iter().enumerate() {
        let at = format!("x={x}");
        let told = scratch.run(format!("strategy m.prism m.pref --at '{at}' --json")).expect(0).json();
        let actions = told["states"][0]["actions"].as_array().unwrap().iter();
        let kept = actions.filter(|action| action["permitted"] == true);
        let expected = kept.map(|action| action["name"].as_str().unwrap().to_owned());
        assert_eq!(permitted(dom), expected.collect(), "{at}: {dom}");
    }
    // In a Markov chain, nothing is chosen.
    assert!(chain.contains("<dt>guaranteed</dt><dd>1</dd>"), "{chain}");
    // The opponent of a game has the same choices.
    let names: Vec<String> = moves(&game).into_keys().collect();
    assert_eq!(names, ["back", "go(m#1)", "go(m#2)"], "{game}");
}
