//! Work that ends early: the exit status, the messages, the printed results, and the files left over.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::time::{Duration, Instant};

use crate::cli::common::{LONG, LONG_PREFS};
use crate::common::prelude::*;

/// A model that takes minutes in every phase, with its preferences, and a place for a dump.
fn hard() -> Scratch {
    Scratch::new(&[("m.prism", &LONG.replace("const int N;", "const int N=4000;")), ("m.pref", LONG_PREFS)])
}

/// A model with as many brackets and operators as expressions may nest, with its preferences.
fn nested() -> Scratch {
    let brackets = |inside: &str, n: usize| format!("{}{inside}{}", "(".repeat(n), ")".repeat(n));
    let sum = format!("{}x{}", "(1+".repeat(9_900), ")".repeat(9_900));
    let steps: String = (0..9_900).map(|i| format!("x={}?({i}):(", i % 4)).collect();
    let chain = format!("{steps}4{}", ")".repeat(9_900));
    let model = format!(
        "mdp module m x : [0..4] init 0; [a] {} -> 0.5: (x'={}) + 0.5: (x'=2); [b] {}(x=1) & {sum}>0 -> (x'=3);
         [c] x<3 -> (x'=min(4, {chain})); endmodule rewards \"r\" true : {}; endrewards",
        brackets("x=0", 10_000),
        brackets("1", 10_000),
        "!".repeat(1000),
        brackets("x", 10_000),
    );
    let prefs = format!("objective A = F {}; objective B = F x=4; prefer A > B;", brackets("x=3", 9_990));
    Scratch::new(&[("m.prism", &model), ("m.pref", &prefs)])
}

#[test]
fn every_command_reads_deeply_nested_expressions() {
    let scratch = nested();
    for command in [
        "info MODEL --flat",
        "check MODEL PREFS",
        "check MODEL PREFS --engine explicit",
        "reach MODEL --target x=3",
        "values MODEL PREFS --reward r",
        "strategy MODEL PREFS",
        "export MODEL PREFS --out OUT",
        "verify OUT MODEL PREFS",
    ] {
        run(&filled(&scratch, command)).expect(0);
    }
    let deeper = scratch.path("deeper.prism");
    let text = scratch.read("m.prism");
    std::fs::write(&deeper, text.replacen("((x=0))", "(((x=0)))", 1)).unwrap();
    run(&format!("info {}", deeper.display())).ends(3, "nested more than 10000 levels deep");
}

/// A started run with its output on stderr.
struct Running {
    child: Child,
    err: BufReader<ChildStderr>,
    said: String,
    #[cfg_attr(not(target_os = "linux"), expect(dead_code, reason = "ways are counted on Linux only"))]
    started: Instant,
}

/// The command line with MODEL and PREFS put in.
fn start(scratch: &Scratch, arguments: &str) -> Running {
    let arguments = filled(scratch, arguments);
    let mut command = Command::new(env!("CARGO_BIN_EXE_meliora"));
    command.args(arguments.split(' ')).stdout(Stdio::piped()).stderr(Stdio::piped());
    let started = Instant::now();
    let mut child = command.spawn().unwrap();
    let err = BufReader::new(child.stderr.take().unwrap());
    Running { child, err, said: String::new(), started }
}

fn filled(scratch: &Scratch, arguments: &str) -> String {
    arguments
        .replace("MODEL", &scratch.show("m.prism"))
        .replace("PREFS", &scratch.show("m.pref"))
        .replace("OUT", &scratch.show("dump"))
}

impl Running {
    /// Waits until the run, which must have `-v`, says that the model has been read, and sends a signal.
    fn kill_after_parsing(&mut self, signal: &str) {
        while !self.said.contains("parse: ") {
            assert_ne!(self.err.read_line(&mut self.said).unwrap(), 0, "it ended: {}", self.said);
        }
        let done = Command::new("kill").args([signal, &self.child.id().to_string()]).status().unwrap();
        assert!(done.success());
    }

    /// Waits for the end; gives the exit status and both texts.
    fn end(mut self) -> (Option<i32>, String, String) {
        let mut out = String::new();
        self.child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
        self.err.read_to_string(&mut self.said).unwrap();
        (self.child.wait().unwrap().code(), out, self.said)
    }
}

/// Nothing is left but the two files of the model.
#[track_caller]
fn nothing_is_left_behind(scratch: &Scratch) {
    let names = std::fs::read_dir(scratch.path("")).unwrap().map(|e| e.unwrap().file_name());
    let mut names: Vec<_> = names.map(|n| n.into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["m.pref", "m.prism"]);
}

const COMMANDS: &[&str] = &[
    "check MODEL PREFS --json",
    "check MODEL PREFS --json --engine explicit",
    "check MODEL PREFS --json --scope all",
    "reach MODEL --target x=y --json",
    "info MODEL --json",
    "strategy MODEL PREFS --json",
    "simulate MODEL PREFS --json",
    "values MODEL PREFS --json",
    "export MODEL PREFS --out OUT --json",
    "compare MODEL PREFS --json",
];

#[test]
fn an_interrupt_ends_every_command_with_130_and_what_is_known() {
    let scratch = hard();
    for command in COMMANDS {
        let mut run = start(&scratch, &format!("{command} -v"));
        run.kill_after_parsing("-INT");
        let (status, out, err) = run.end();
        assert_eq!(status, Some(130), "{command}: {err}");
        assert!(err.contains("interrupted"), "{command}: {err}");
        let report: Json = serde_json::from_str(&out).unwrap();
        assert_eq!(report["complete"], false, "{command}");
        assert_eq!(report["error"]["message"], "interrupted", "{command}");
        nothing_is_left_behind(&scratch);
    }
}

/// Waits until several ways of a race run; false if the run ends before.
#[cfg(target_os = "linux")]
fn wait_for_ways(run: &mut Running) -> bool {
    let tasks = format!("/proc/{}/task", run.child.id());
    let ways = || {
        let names = std::fs::read_dir(&tasks).unwrap().map(|task| task.unwrap().path().join("comm"));
        names
            .filter(|name| std::fs::read_to_string(name).is_ok_and(|name| name.trim() == "meliora-way"))
            .count()
    };
    while ways() < 3 {
        if run.child.try_wait().unwrap().is_some() {
            return false;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    true
}

/// Returns the seconds after which a run with several ways has ended; infinite if there were no such ways.
#[cfg(target_os = "linux")]
fn ends_after(threads: usize, end: &dyn Fn(&mut Running), more: &str, status: i32) -> f64 {
    let scratch = hard();
    let mut run = start(&scratch, &format!("check MODEL PREFS --json --quiet --threads {threads}{more}"));
    if !wait_for_ways(&mut run) {
        return f64::INFINITY;
    }
    end(&mut run);
    let start = Instant::now();
    let (found, out, err) = run.end();
    assert_eq!(found, Some(status), "{err}");
    assert_eq!(serde_json::from_str::<Json>(&out).unwrap()["complete"], false);
    start.elapsed().as_secs_f64()
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_and_the_time_limit_end_all_ways_of_a_race_soon() {
    let interrupt = |run: &mut Running| {
        let done = Command::new("kill").args(["-INT", &run.child.id().to_string()]).status().unwrap();
        assert!(done.success());
    };
    // The best of some runs counts, since the machine may be busy.
    let soon = |seconds: &dyn Fn() -> f64| (0..8).any(|_| seconds() < 0.2);
    for (_, threads) in [2, 1, 4].into_iter().enumerate().filter(|(at, _)| takes(*at)) {
        assert!(soon(&|| ends_after(threads, &interrupt, "", 130)), "{threads} threads, an interrupt");
        let late = |run: &mut Running| {
            std::thread::sleep(Duration::from_secs(3).saturating_sub(run.started.elapsed()));
        };
        assert!(soon(&|| ends_after(threads, &late, " --timeout 3s", 4)), "{threads} threads, a time limit");
    }
}

#[test]
fn the_signal_of_job_schedulers_is_an_interrupt_too() {
    let scratch = hard();
    let mut run = start(&scratch, "check MODEL PREFS --json -v");
    run.kill_after_parsing("-TERM");
    let (status, out, _) = run.end();
    assert_eq!(status, Some(130));
    assert_eq!(serde_json::from_str::<Json>(&out).unwrap()["complete"], false);
}

#[cfg(target_os = "linux")]
#[test]
fn an_abort_is_not_reported_as_a_limit_if_memory_is_not_limited() {
    let scratch = hard();
    let mut run = start(&scratch, "check MODEL PREFS -v");
    run.kill_after_parsing("-ABRT");
    let (status, _, err) = run.end();
    assert_eq!(status, None, "the signal ends the process: {err}");
}

#[test]
fn the_time_limit_ends_every_command_with_4_and_what_is_known() {
    let scratch = hard();
    for command in COMMANDS {
        let (status, out, err) = start(&scratch, &format!("{command} --timeout 200ms")).end();
        assert_eq!(status, Some(4), "{command}: {err}");
        assert!(err.contains("--timeout"), "{command}: {err}");
        assert!(err.contains("stopped in the phase"), "{command}: {err}");
        let report: Json = serde_json::from_str(&out).unwrap();
        assert_eq!(report["complete"], false, "{command}");
        assert_eq!(report["error"]["kind"], "resource", "{command}");
        nothing_is_left_behind(&scratch);
    }
}

/// Returns true if a rank is at most another one. A rank is a lower bound while levels are missing.
fn is_at_most(part: &Json, whole: &Json) -> bool {
    match (part.as_u64(), whole.as_u64()) {
        (Some(part), Some(whole)) => part <= whole,
        (Some(_), None) => whole == "unbounded",
        _ => part.is_null() || part == whole,
    }
}

/// Returns true if a partial report agrees with the full one wherever it has a value.
fn agrees(part: &Json, whole: &Json) -> bool {
    match (part, whole) {
        (Json::Null, _) => true,
        (Json::Object(part), Json::Object(whole)) => part.iter().all(|(key, value)| {
            let about_the_work = ["time", "memory", "complete", "error"].contains(&key.as_str());
            let is_rank = ["sasi_rank", "spi_rank"].contains(&key.as_str());
            let compare = if is_rank { is_at_most } else { agrees };
            about_the_work || whole.get(key).is_some_and(|w| compare(value, w))
        }),
        (Json::Array(part), Json::Array(whole)) => {
            part.len() <= whole.len() && part.iter().zip(whole).all(|(p, w)| agrees(p, w))
        }
        _ => part == whole,
    }
}

#[test]
fn what_is_printed_when_memory_ends_is_part_of_the_full_answer() {
    let robot = "check models/robot5x5.prism models/robot5x5.pref --scope all --json --quiet";
    for (engine, sizes) in [("explicit", 150..500), ("symbolic", 50..400)] {
        let whole = run(&format!("{robot} --engine {engine}")).expect(0).json();
        let mut phases = std::collections::BTreeSet::new();
        for kilobytes in sizes.step_by(25) {
            let finished = run(&format!("{robot} --engine {engine} --memory {kilobytes}KiB"));
            assert!([0, 4].contains(&finished.status), "{finished:?}");
            let part = finished.json();
            assert!(agrees(&part, &whole), "{engine}, {kilobytes} KiB: {part:#}");
            if finished.status == 4 {
                assert_eq!(part["complete"], false);
                finished.says("--memory");
                phases.insert(part["objectives"].as_array().map_or(0, Vec::len));
            }
        }
        assert!(!phases.is_empty(), "{engine}: memory never ended");
    }
}

#[test]
fn a_full_disk_ends_with_4_and_says_so() {
    if !std::path::Path::new("/dev/full").exists() {
        return;
    }
    let toy = "models/toy.prism models/toy.pref";
    for arguments in [
        format!("check {toy}"),
        format!("check {toy} --json"),
        format!("strategy {toy} --csv -"),
        "info models/toy.prism --flat".to_owned(),
        "generate gridworld --rows 4 --cols 4 --items 2".to_owned(),
        "man check".to_owned(),
        "completions bash".to_owned(),
    ] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let mut command = Command::new(env!("CARGO_BIN_EXE_meliora"));
        command.args(arguments.split(' ')).current_dir(env!("CARGO_MANIFEST_DIR"));
        let output = command.stdout(full).stderr(Stdio::piped()).output().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(4), "{arguments}: {err}");
        assert!(err.contains("could not be written"), "{arguments}: {err}");
    }
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    for arguments in ["info models/robot5x5.prism --json", "man check", "--help"] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_meliora"));
        command.args(arguments.split(' ')).current_dir(env!("CARGO_MANIFEST_DIR"));
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let mut err = String::new();
        child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
        assert_eq!((child.wait().unwrap().code(), err.as_str()), (Some(0), ""), "{arguments}");
    }
}

#[test]
fn alternatives_that_multiply_are_a_limit_that_is_named() {
    let modules = |command: &dyn Fn(usize) -> String| -> String {
        (0..40).map(|i| format!("module m{i} x{i}:[0..3]; {} endmodule\n", command(i))).collect()
    };
    let alternatives = |i: usize| (0..4).map(|k| format!("[a] true -> (x{i}'={k});")).collect::<String>();
    let branches = |i: usize| format!("[a] true -> 0.5:(x{i}'=1) + 0.5:(x{i}'=2);");
    let text = format!("mdp {}", modules(&alternatives));
    let scratch = Scratch::new(&[("m.prism", &text), ("m.pref", "objective A = F x0=1;")]);
    for engine in ["symbolic", "explicit"] {
        run(&filled(&scratch, &format!("check MODEL PREFS --engine {engine}"))).ends(4, "too large");
    }
    // Many branches are no difficulty for diagrams, only to list them one by one.
    let text = format!("mdp {}", modules(&branches));
    let scratch = Scratch::new(&[("m.prism", &text), ("m.pref", "objective A = F x0=1;")]);
    let report = run(&filled(&scratch, "check MODEL PREFS --json")).expect(0).json();
    assert_eq!(report["initial"][0]["most_preferred"][0], "A");
    for command in ["check MODEL PREFS --engine explicit", "simulate MODEL PREFS", "strategy MODEL PREFS"] {
        run(&filled(&scratch, command)).ends(4, "too large");
    }
}

#[test]
fn states_of_many_bits_are_a_limit_that_is_named() {
    let variables: String = (0..2_000).map(|i| format!("x{i}:[0..9007199254740992];")).collect();
    let scratch =
        Scratch::new(&[("m.prism", &format!("mdp module m {variables} endmodule")), ("m.pref", "")]);
    for (engine, what) in
        [("symbolic", "the symbolic engine"), ("explicit", "where they are stored one by one")]
    {
        let finished = run(&filled(&scratch, &format!("info MODEL --engine {engine}"))).expect(4);
        let message = format!("states of 108000 bits; {what}");
        finished.says(&message);
    }
}

#[test]
fn a_wide_range_costs_nothing_until_its_values_are_reached() {
    let text = "mdp module m x:[0..2000000000]; y:[0..2000000000]; [] x<9 -> (x'=x+1); endmodule";
    let scratch = Scratch::new(&[("m.prism", text), ("m.pref", "")]);
    for engine in ["symbolic", "explicit"] {
        let report = run(&filled(&scratch, &format!("info MODEL --engine {engine} --json --memory 64MiB")));
        assert_eq!(report.expect(0).json()["counts"]["states"], "10");
    }
    run(&filled(&scratch, "info MODEL --engine explicit --scope all --memory 64MiB")).ends(4, "too many for");
}

/// Runs a command in a shell that first lowers a limit of the system.
#[cfg(target_os = "linux")]
fn limited(limit: &str, arguments: &str) -> (Option<i32>, String) {
    let script = format!("ulimit {limit}; exec {} {arguments}", env!("CARGO_BIN_EXE_meliora"));
    let mut command = Command::new("sh");
    let output = command.args(["-c", &script]).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn a_system_that_gives_no_memory_or_no_threads_is_a_limit_that_is_named() {
    let toy = "info models/toy.prism";
    for (kib, memory) in [(400_000, 8), (700_000, 8), (900_000, 8), (1_400_000, 8), (3_000_000, 8192)] {
        let (status, err) = limited(&format!("-v {kib}"), &format!("{toy} --memory {memory}MiB"));
        assert_eq!(status, Some(4), "{kib} KiB: {err}");
        assert!(!err.contains("internal") && !err.contains("panicked"), "{kib} KiB: {err}");
        // Without a heap for its thread, work would go on a hundred times as slowly.
        assert_eq!(err.contains("a heap of 128 MiB"), kib == 700_000, "{kib} KiB: {err}");
    }
    let (status, err) = limited("-v 4000000", &format!("{toy} --memory 8MiB --threads 60000"));
    assert_eq!(status, Some(0), "{err}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_model_that_is_too_large_to_read_is_a_limit_that_is_named() {
    let line = "[] x=1 & y>2 -> 0.5:(x'=3)&(y'=x) + 0.5:(y'=min(y+1,9));\n";
    // The text is most of the memory: a comment is read faster than commands.
    let comment = "x".repeat(45 << 20);
    let text = format!("// {comment}\nmdp module m x:[0..9]; y:[0..9];\n{}endmodule", line.repeat(50_000));
    let scratch = Scratch::new(&[("m.prism", &text)]);
    let path = scratch.show("m.prism");
    let finished = run(&format!("info {path} --memory 8MiB --json")).expect(4);
    finished.says("--memory");
    let memory = finished.json()["memory"]["peak_rss_bytes"].as_u64().unwrap() >> 20;
    assert!(memory < 8 + 64 + 16, "{memory} MiB");
    // The list of numbers grows by hundreds of MiB at once, which exceeds the limit.
    let text = format!("{{\"jani-version\":1,\"variables\":[{}0]}}", "0,".repeat(2_500_000));
    let scratch = Scratch::new(&[("m.jani", &text)]);
    let (status, err) = limited("-v 900000", &format!("info {} --memory 8GiB", scratch.show("m.jani")));
    assert_eq!(status, Some(4), "{err}");
    assert!(err.contains("memory allocation of"), "{err}");
}

#[cfg(target_os = "linux")]
#[test]
fn advice_fits_the_command_and_the_cause() {
    let scratch = Scratch::new(&[]);
    let dump = scratch.show("dump");
    run(&format!("export models/toy.prism models/toy.pref --out {dump} -q")).expect(0);
    for kib in [300_000, 900_000, 1_400_000] {
        let (status, err) = limited(&format!("-v {kib}"), &format!("query {dump} reachable --memory 8MiB"));
        assert_eq!(status, Some(4), "{err}");
        assert!(err.contains("ulimit") && !err.contains("--engine") && !err.contains("raises"), "{err}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn without_a_memory_limit_of_its_own_a_run_keeps_to_that_of_the_address_space() {
    let run = "reach models/robot5x5.prism --target b=0 --engine symbolic";
    for limit in ["-v 6291456", "-d 6291456", "-v 2500000", "-d 2500000"] {
        let (status, err) = limited(limit, run);
        assert_eq!(status, Some(0), "{limit}: {err}");
    }
    for (limit, what) in [("-v 6291456", "address space"), ("-d 6291456", "data")] {
        let (status, err) = limited(limit, &format!("{run} --memory 8GiB"));
        assert_eq!(status, Some(4), "{err}");
        let option = &limit[..2];
        let named = format!(
            "the {what} of this process is limited to 6144 MiB; use a smaller `--memory` or a larger \
                             `ulimit {option}`"
        );
        assert!(err.contains(&named), "{err}");
    }
}

/// The threads of a table end a moment after it is dropped. Until then there was no room for the next one, and
/// about half of such runs ended with an error.
#[cfg(target_os = "linux")]
#[test]
fn a_table_waits_until_the_system_has_the_stack_of_the_last_one_again() {
    let run = "info models/line.prism -c K=511 --engine symbolic";
    for kib in [3_000_000, 3_500_000] {
        for _ in 0..share(4) {
            let (status, err) = limited(&format!("-v {kib}"), run);
            assert_eq!(status, Some(0), "{kib} KiB: {err}");
        }
    }
    for _ in 0..share(4) {
        let (status, err) = limited("-v 2000000", run);
        let named = "the address space of this process is limited to 1953 MiB; use a";
        assert!(status == Some(0) || status == Some(4) && err.contains(named), "{status:?} {err}");
    }
}
