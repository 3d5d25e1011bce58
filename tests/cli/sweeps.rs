//! Sweeps over constants: rows, files, parts, resumed runs.

use crate::common::prelude::*;

const MODEL: &str = "mdp\nconst int N;\nconst int K;\nmodule m\n x : [0..N] init 0;\n\
    [a] x<N -> 0.5: (x'=x+1) + 0.5: (x'=max(x-K,0));\n [b] x>0 -> (x'=0);\nendmodule\n";
const PREFS: &str = "objective A = F x=N; objective B = F x=1; prefer A > B;\n";

fn scratch() -> Scratch {
    Scratch::new(&[("m.prism", MODEL), ("m.pref", PREFS)])
}

fn sweep(scratch: &Scratch, arguments: &[&str]) -> Finished {
    scratch.ask("check m.prism m.pref", arguments)
}

/// The rows of a file without the columns that differ from run to run.
fn rows(scratch: &Scratch, name: &str) -> Vec<String> {
    let text = scratch.read(name);
    let header: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let kept = |line: &str| {
        let cells = header.iter().zip(line.split(','));
        let kept = cells.filter(|(name, _)| !matches!(**name, "seconds" | "peak_rss_bytes" | "peak_nodes"));
        kept.map(|(_, cell)| cell).collect::<Vec<_>>().join(",")
    };
    text.lines().map(kept).collect()
}

#[test]
fn a_sweep_has_a_row_and_the_whole_report_of_every_instance() {
    let scratch = scratch();
    let csv = scratch.show("all.csv");
    let found = sweep(&scratch, &["-c", "N=2:2:6,K={1,2}", "--json", "--csv", &csv]).expect(0).json();
    assert_eq!(found["schema"], "meliora.sweep/1");
    assert_eq!(found["ranges"], json!({"N": [2, 4, 6], "K": [1, 2]}));
    let runs = found["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 6);
    assert_eq!(runs[3]["constants"], json!({"N": 4, "K": 2}));
    assert_eq!(runs[3]["status"], "done");
    let single = sweep(&scratch, &["-c", "N=4,K=2", "--json"]).expect(0).json();
    for key in ["counts", "sasi", "spi", "initial", "classes"] {
        assert_eq!(runs[3]["result"][key], single[key], "{key}");
    }
    let rows = rows(&scratch, "all.csv");
    assert!(rows[0].starts_with("N,K,states,choices,transitions,sasi_1,"), "{}", rows[0]);
    assert!(rows[0].contains(",sasi_unbounded,") && rows[0].contains(",spi_1,"), "{}", rows[0]);
    let states = single["counts"]["states"].as_str().unwrap();
    assert!(rows[4].starts_with(&format!("4,2,{states},")) && rows[4].ends_with(",done"), "{}", rows[4]);
}

#[test]
fn parts_together_have_the_rows_of_the_whole_and_a_resumed_file_is_the_same() {
    let scratch = scratch();
    let show = |name: &str| scratch.show(name);
    let run_values = |values: &str, name: &str, more: &[&str]| {
        let csv = show(name);
        sweep(&scratch, &[&["-c", values, "--csv", &csv], more].concat()).expect(0)
    };
    let run = |name: &str, more: &[&str]| run_values("N=2:4,K=1:2", name, more);
    run("whole.csv", &["--jobs", "2"]);
    run_values("N=2:3,K=1:2", "one.csv", &[]);
    run_values("N=4,K=1:2", "two.csv", &[]);
    let whole = rows(&scratch, "whole.csv");
    let mut joined = rows(&scratch, "one.csv");
    joined.extend(rows(&scratch, "two.csv").into_iter().skip(1));
    assert_eq!((whole.len(), rows(&scratch, "one.csv").len()), (7, 5));
    // Rows are in the order of the instances at the end, whichever of the two jobs was faster.
    assert_eq!(joined, whole);
    // As if it had ended in the middle.
    let text = scratch.read("whole.csv");
    let half: String = text.split_inclusive('\n').take(4).collect();
    scratch.write("half.csv", &half);
    let shown = run("half.csv", &["--resume"]).stdout;
    assert_eq!(shown.lines().count(), 5, "three instances were left: {shown}");
    let resumed = scratch.read("half.csv");
    assert!(resumed.starts_with(&half), "rows that were there stay as they are");
    assert_eq!(rows(&scratch, "half.csv"), whole);
    run("half.csv", &["--resume"]);
    assert_eq!(scratch.read("half.csv"), resumed);
}

/// Imitates a process that was killed while it wrote a row: the row is computed again.
/// Reports were kept until the end, and then sorted.
#[test]
fn reports_of_parallel_instances_are_in_the_order_of_the_instances() {
    let found = sweep(&scratch(), &["-c", "N=2:7,K={1,2}", "--json", "--jobs", "4"]).expect(0).json();
    let runs = found["runs"].as_array().unwrap();
    let constants = |run: &Json| ["N", "K"].map(|name| run["constants"][name].as_i64().unwrap());
    let expected: Vec<_> = (2..=7).flat_map(|n| [[n, 1], [n, 2]]).collect();
    assert_eq!(runs.iter().map(constants).collect::<Vec<_>>(), expected);
    assert_eq!(found["ranges"]["K"], serde_json::json!([1, 2]));
}

#[test]
fn ranges_that_are_too_long_are_refused_by_their_limit() {
    sweep(&scratch(), &["-c", "N=0:1000000,K=1"])
        .ends(2, "a range has at most 1000000 values, and this one has 1000001");
}

#[test]
fn resuming_cuts_off_an_incomplete_last_row() {
    let scratch = scratch();
    let csv = scratch.show("rows.csv");
    let arguments = ["-c", "N=2:4,K=1", "--csv", &csv, "--resume"];
    sweep(&scratch, &arguments).expect(0);
    let whole = rows(&scratch, "rows.csv");
    let text = std::fs::read_to_string(&csv).unwrap();
    let two: usize = text.split_inclusive('\n').take(3).map(str::len).sum();
    // In the header, in the first cells, in a later row, and just before the end of the line.
    for cut in [3, text.find('\n').unwrap(), two - 1, two + 2, two + 30, text.len() - 1] {
        std::fs::write(&csv, &text[..cut]).unwrap();
        let shown = sweep(&scratch, &arguments).expect(0).stdout;
        let kept = text[..cut].matches('\n').count().saturating_sub(1);
        assert_eq!(shown.lines().count(), 2 + 3 - kept, "cut at {cut}: {shown}");
        assert_eq!(rows(&scratch, "rows.csv"), whole, "cut at {cut}");
    }
}

/// Each row is in the file before the next instance starts; a file that cannot be replaced, such as
/// a pipe or a device, receives every row once.
#[test]
#[cfg(unix)]
fn rows_are_appended_to_streams() {
    let scratch = scratch();
    let pipe = scratch.show("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || std::fs::read_to_string(pipe).unwrap()
    });
    sweep(&scratch, &["-c", "N=2:4,K=1", "--csv", &pipe]).expect(0);
    assert_eq!(reader.join().unwrap().lines().count(), 4);
}

#[test]
fn what_goes_wrong_in_one_instance_ends_its_row_only() {
    let scratch = scratch();
    let csv = scratch.show("rows.csv");
    // N=-1 has no range for x.
    let found = sweep(&scratch, &["-c", "N={2,-1,3},K=1", "--json", "--csv", &csv]).expect(0).json();
    let status: Vec<&Json> = found["runs"].as_array().unwrap().iter().map(|r| &r["status"]).collect();
    assert_eq!(status, ["done", "error", "done"]);
    assert_eq!(found["runs"][1]["result"]["schema"], "meliora.error/1");
    assert!(rows(&scratch, "rows.csv")[2].starts_with("-1,1,,,"));
    sweep(&scratch, &["-c", "N=-2:-1,K=1"]).expect(3);
}

#[test]
fn mistakes_are_told_before_anything_runs() {
    let scratch = scratch();
    let csv = scratch.show("other.csv");
    scratch.write("other.csv", "A,B\n1,2\n");
    for wrong in ["N=3:1,K=1", "N=1:0:3,K=1", "N={},K=1"] {
        sweep(&scratch, &["-c", wrong]).expect(2);
    }
    sweep(&scratch, &["-c", "N=1:2,K=1", "--resume"]).expect(2);
    let other = sweep(&scratch, &["-c", "N=1:2,K=1", "--csv", &csv, "--resume"]).expect(3);
    other.says("not the header of this sweep");
    assert_eq!(scratch.read("other.csv"), "A,B\n1,2\n");
}

#[test]
fn a_file_with_two_rows_for_one_instance_is_not_resumed() {
    let scratch = scratch();
    let csv = scratch.show("rows.csv");
    sweep(&scratch, &["-c", "N=1:2,K=1", "--csv", &csv]).expect(0);
    let complete = scratch.read("rows.csv");
    let first = complete.lines().nth(1).unwrap();
    let twice = format!("{complete}{first}\n");
    scratch.write("rows.csv", &twice);
    let refused = sweep(&scratch, &["-c", "N=1:3,K=1", "--csv", &csv, "--resume"]).expect(3);
    refused.says("this row has the constants of an earlier row");
    refused.says("rows.csv:4:1");
    assert_eq!(scratch.read("rows.csv"), twice);
}

#[test]
fn reach_and_compare_sweep_too() {
    let scratch = scratch();
    let (model, prefs, csv) = (scratch.show("m.prism"), scratch.show("m.pref"), scratch.show("r.csv"));
    let reach = ["reach", &model, "--target", "x=N", "-c", "N=1:2,K=1", "--csv", &csv];
    Finished::of(executable().args(reach)).expect(0);
    assert_eq!(rows(&scratch, "r.csv")[0].split(',').nth(6), Some("pmax_one"));
    assert_eq!(rows(&scratch, "r.csv").len(), 3);
    let compare = ["compare", &model, &prefs, "-c", "N=1:2", "-c", "K=1", "--json"];
    let found = Finished::of(executable().args(compare)).expect(0).json();
    assert_eq!(found["runs"][1]["result"]["equal"], true);
}

const ANSWERS: &str = "\"sure\": Pmax>=1 [ F x=N ];\n\"least\": Pmin=? [ F x=N ];\nPmax=? [ F<=8 x=N ];\n\
    \"unknown\": P>=1 [ F y=1 ];\n\"half\": Pmax>=0.5 [ F<=2 x=N ]\n";

/// A robot that we move on a line of N cells, and an opponent that pushes it back.
const GAME: &str = "smg\nconst int N;\nplayer robot [on] endplayer\nplayer wind [push], [rest] endplayer\n\
    module m\n x : [0..N] init 0; t : bool init true;\n [on] t -> (x'=min(x+1,N))&(t'=false);\n \
    [push] !t & x<N & mod(x,2)=0 -> (x'=max(x-1,0))&(t'=true);\n [rest] !t -> (t'=true);\nendmodule\n";

#[test]
fn sweeps_of_games_check_for_each_coalition() {
    let scratch = Scratch::new(&[]);
    let csv = scratch.show("all.csv");
    let check = |more: &[&str]| {
        let fixed = ["check", "models/pursuit.prism", "models/pursuit.pref", "--coalition"];
        Finished::of(executable().args([&fixed, more].concat()))
    };
    let swept = |coalition: &str| {
        check(&[coalition, "-c", "N=3:5", "--jobs", "2", "--csv", &csv]).expect(0);
        let found =
            columns(&scratch, "all.csv", &["N", "states", "sasi_1", "sasi_rank", "spi_rank", "status"]);
        for (row, n) in found.iter().zip(3..) {
            let one = check(&[coalition, "-c", &format!("N={n}"), "--json"]).expect(0).json();
            let text = |value: &Json| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
            let level = one["sasi"]["levels"].get(0).map_or_else(String::new, text);
            let [sasi, spi] = ["sasi_rank", "spi_rank"].map(|name| text(&one["initial"][0][name]));
            let states = text(&one["counts"]["states"]);
            assert_eq!(*row, [n.to_string(), states, level, sasi, spi, "done".into()]);
        }
        found
    };
    assert_eq!(swept("robot")[1], ["4", "580", "100", "1", "1", "done"]);
    // If the guard is one of us, both rooms are sure from the start.
    assert!(swept("robot,guard").iter().all(|row| row[3] == "0"));
    let unknown = check(&["nobody", "-c", "N=3:4"]).expect(3);
    assert!(unknown.stderr.contains("unknown player `nobody`") && unknown.stdout.is_empty(), "{unknown:?}");
}

#[test]
fn sweeps_of_games_answer_properties_of_coalitions() {
    let scratch = Scratch::new(&[("m.prism", GAME)]);
    let (csv, plot) = (scratch.show("all.csv"), scratch.show("game.svg"));
    let properties = ["<<robot>> P>=1 [ F x=N ]", "<<robot,wind>> P>=1 [ F x=N ]"];
    let asked = properties.iter().flat_map(|p| ["--property", p]);
    let arguments = ["-c", "N=1:4", "--jobs", "2", "--csv", &csv, "--plot", &plot];
    reach(&scratch, &asked.chain(arguments).collect::<Vec<_>>()).expect(1);
    // At even cells, the wind can push the robot back.
    let answers: Vec<String> =
        columns(&scratch, "all.csv", &properties).iter().map(|row| row.join(" ")).collect();
    assert_eq!(answers, ["true true", "true true", "false true", "false true"]);
    let picture = std::fs::read_to_string(plot).unwrap();
    assert!(picture.contains("&lt;&lt;robot&gt;&gt; P&gt;=1"), "{picture}");
}

fn reach(scratch: &Scratch, arguments: &[&str]) -> Finished {
    scratch.ask("reach m.prism", arguments)
}

/// The cells of the columns with these names, row by row.
fn columns(scratch: &Scratch, file: &str, names: &[&str]) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(scratch.path(file)).unwrap();
    let header: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let at =
        |name: &&str| header.iter().position(|h| h == name).unwrap_or_else(|| panic!("{name}: {header:?}"));
    let positions: Vec<usize> = names.iter().map(at).collect();
    let row = |row: csv::StringRecord| positions.iter().map(|&at| row[at].to_owned()).collect();
    reader.records().map(|found| row(found.unwrap())).collect()
}

#[test]
fn each_property_has_a_column_with_its_answer() {
    let scratch = Scratch::new(&[("m.prism", MODEL), ("m.props", ANSWERS)]);
    let (csv, props) = (scratch.show("r.csv"), scratch.show("m.props"));
    let told = reach(&scratch, &["-c", "N=1:3,K=1", "--properties", &props, "--csv", &csv]).expect(1);
    let notes: Vec<&str> =
        told.stderr.lines().filter(|line| line.starts_with("note: no answer to")).collect();
    assert!(notes.len() == 1 && notes[0].contains("unknown name `y`"), "{notes:?}");
    let shown = told.stdout;
    let names = ["N", "sure", "least", "Pmax=? [ F<=8 x=N ]", "unknown", "half", "status"];
    let found = columns(&scratch, "r.csv", &names);
    assert_eq!(found[0][..3], ["1", "true", "1"]);
    let bounds: Vec<f64> = found[0][3].split("..").map(|bound| bound.parse().unwrap()).collect();
    assert!(bounds.iter().all(|bound| (bound - 0.99609375).abs() < 1e-6), "{bounds:?}");
    assert_eq!(found[0][4..], ["not answered", "true", "done"]);
    assert_eq!((&*found[2][1], &*found[2][5]), ("true", "false"));
    assert!(shown.lines().nth(1).unwrap().contains("Pmax=? [ F<=8 x=N ]"), "{shown}");
    assert!(shown.lines().nth(2).unwrap().contains("0.996094"), "{shown}");
    let asked = ["--property", "Pmin=? [ F x=N ]", "--property", "P>=1 [ F x=N ]"];
    reach(&scratch, &[&["-c", "N=1:2,K=1", "--csv", &csv], &asked[..]].concat()).expect(1);
    assert_eq!(columns(&scratch, "r.csv", &[asked[1], asked[3]]), [["1", "true"], ["0", "false"]]);
    // A single one keeps the columns of its regions.
    reach(&scratch, &["-c", "N=1:2,K=1", "--csv", &csv, "--property", "Pmax>=1 [ F x=N ]"]).expect(0);
    let names = ["target", "pmax_one", "pmin_one", "Pmax>=1 [ F x=N ]"];
    assert_eq!(columns(&scratch, "r.csv", &names), [["1", "2", "", "true"], ["1", "3", "", "true"]]);
}

#[test]
fn a_plot_shows_each_result_over_the_first_constant() {
    let scratch = Scratch::new(&[("m.prism", MODEL), ("m.pref", PREFS), ("m.props", ANSWERS)]);
    let (plot, csv, props) = (scratch.show("p.svg"), scratch.show("r.csv"), scratch.show("m.props"));
    let ranges = ["-c", "N=1:4,K=1:2", "--properties", &props, "--plot", &plot, "--csv", &csv];
    reach(&scratch, &ranges).expect(1);
    let drawn = scratch.read("p.svg");
    assert_eq!(drawn.matches("<g class=\"curve\">").count(), 10, "five panels with two curves");
    assert!(drawn.contains("<title>N=1, K=2: 0.996094</title>"), "{drawn}");
    assert_eq!(drawn.matches("<circle").count(), 4 * 8 + 2, "unanswered properties have no points");
    // A resumed sweep draws the rows of the file, too.
    reach(&scratch, &[&ranges[..], &["--resume"]].concat()).ends(1, "all 8 instances have a row in the file");
    assert_eq!(scratch.read("p.svg"), drawn);
    for (wrong, reason) in [("p.png", ".svg"), ("m.prism.svg/x.svg", "does not exist")] {
        reach(&scratch, &["-c", "N=1:2,K=1", "--target", "x=N", "--plot", &scratch.show(wrong)]).says(reason);
    }
    reach(&scratch, &["-c", "N=1,K=1", "--target", "x=N", "--plot", &plot]).ends(2, "give one a range");
    sweep(&scratch, &["-c", "N=2:4,K=1", "--plot", &plot]).expect(0);
    let drawn = scratch.read("p.svg");
    assert!(["sasi_rank", "spi_rank", "sasi_1", "spi_1"].iter().all(|name| drawn.contains(name)), "{drawn}");
}

/// A wrong property, formula or preference was an error of every instance.
#[test]
fn what_is_wrong_in_every_instance_is_told_once_before_the_first() {
    let scratch = Scratch::new(&[("m.prism", MODEL), ("m.pref", "objective A = F y=N;\n")]);
    let csv = scratch.show("r.csv");
    for wrong in [
        &["--property", "Pmax=? [ F y=N ]"][..],
        &["--property", "Pmax=? [ F x=N"],
        &["--property", "P>=1 [ F x=N ]", "--property", "R{\"r\"}max=? [ F x=N ]"],
        &["--target", "x=z"],
        &["--target", "x=N", "--require", "G y<1"],
        &["--target", "x=N", "--coalition", "p1"],
    ] {
        let told = reach(&scratch, &[&["-c", "N=1:3,K=1", "--csv", &csv], wrong].concat()).expect(3);
        assert_eq!(told.stderr.matches("error: ").count(), 1, "{wrong:?}: {}", told.stderr);
        assert!(told.stdout.is_empty() && !scratch.path("r.csv").exists(), "{wrong:?}: {}", told.stdout);
    }
    let told = sweep(&scratch, &["-c", "N=1:3,K=1"]).expect(3);
    assert_eq!((told.stderr.matches("error: ").count(), &*told.stdout), (1, ""), "{}", told.stderr);
    // What only some instances refuse is in their rows.
    let model = MODEL.replace("mdp", "mdp\nconst double q = 2-N;");
    scratch.write("m.prism", model);
    for (values, status) in [("N={0,2}", ["error", "done"]), ("N={2,0}", ["done", "error"])] {
        let constants = format!("{values},K=1");
        reach(&scratch, &["-c", &constants, "--csv", &csv, "--property", "Pmax>=q [ F x=0 ]"]).expect(0);
        assert_eq!(columns(&scratch, "r.csv", &["status"]), status.map(|status| [status]));
    }
}

/// A range of fractions was refused, and an exact 1/3 was shown as 0.3333333333333333.
#[test]
fn fractions_are_swept_and_shown_as_they_are_given() {
    let model = "mdp\nconst double p;\nmodule m\n x : [0..1] init 0;\n [a] x=0 -> p: (x'=1) + (1-p): true;\nendmodule\n";
    let scratch = Scratch::new(&[("m.prism", model)]);
    let (csv, asked) = (scratch.show("r.csv"), ["--property", "Pmax=? [ F<=1 x=1 ]"]);
    reach(&scratch, &[&["-c", "p=1/3:1/3:1", "--csv", &csv], &asked[..]].concat()).expect(0);
    let found = columns(&scratch, "r.csv", &["p", "status"]);
    assert_eq!(found, [["1/3", "done"], ["2/3", "done"], ["1.0", "done"]]);
    let one = |more: &[&str]| reach(&scratch, &[more, &asked[..]].concat()).expect(0);
    one(&["-c", "p=1/3"]).shows(", p=1/3\n");
    let found = one(&["-c", "p=2/6", "--json"]).json();
    assert_eq!(found["model"]["exact_constants"], json!({"p": "1/3"}));
    assert_eq!(found["model"]["constants"], json!({"p": 0.333_333_333_333_333_3}));
    let found = one(&["-c", "p=0.1", "--json"]).json();
    assert!(
        found["model"].get("exact_constants").is_none() && found["model"]["constants"]["p"] == json!(0.1)
    );
}

/// With all rows in the file, the status was 0 whatever they said.
#[test]
fn the_status_of_a_resumed_sweep_is_that_of_all_rows() {
    let scratch = Scratch::new(&[]);
    let file = scratch.show("all.csv");
    let sweep = |property: &str, range: &str, more: &str| {
        scratch.ask(
            format!("reach models/chain.prism --property '{property}' -c '{range}' --csv all.csv"),
            more.split_whitespace(),
        )
    };
    let (holds, fails) = ("P>=1 [ true U true ]", "P>=1 [ false U false ]");
    sweep(fails, "N=2:3", "").expect(1);
    sweep(fails, "N=2:3", "--resume").ends(1, "nothing is left to run");
    sweep(fails, "N=2:4", "--resume").expect(1);
    std::fs::remove_file(&file).unwrap();
    sweep(holds, "N=2:3", "").expect(0);
    sweep(holds, "N=2:3", "--resume").expect(0);
    // Rows that a limit ended decide if no other is complete.
    let text = std::fs::read_to_string(&file).unwrap().replace(",done", ",limit");
    std::fs::write(&file, text).unwrap();
    sweep(holds, "N=2:3", "--resume").expect(4);
    sweep(holds, "N=2:4", "--resume").expect(0);
}
