//! `--memory` is kept by everything that reads, computes and writes: each input here once took many
//! times the limit.

use std::fmt::Write as _;
use std::io::{Read, Write as _};

use flate2::Compression;
use flate2::write::GzEncoder;
use tar::{Builder, EntryType, Header};

use crate::cli::common::{Finished, Scratch, executable};

/// The memory that the process may use for itself, and that it may gain before the watch notices, in
/// MiB. The machine may be busy.
const SLACK: u64 = 64 + 32 + 64;

/// A model of two states.
const TWO: &str = "mdp module m x:[0..1] init 0; [a] x=0 -> (x'=1); [b] x=1 -> (x'=0); endmodule";

/// Runs a command with a limit of 8 MiB, which it must report and keep.
#[track_caller]
fn ends_in_time(arguments: &str) -> Finished {
    let mut command = executable();
    command.args(arguments.split_whitespace()).args(["--memory", "8MiB", "--json"]);
    let finished = Finished::of(&mut command).expect(4);
    finished.says("`--memory` raises the limit");
    let report = finished.json();
    assert_eq!(report["complete"], false, "{arguments}");
    let peak = report["memory"]["peak_rss_bytes"].as_u64().unwrap() >> 20;
    assert!(peak <= 8 + SLACK, "{arguments}: {peak} MiB");
    finished
}

/// Joins texts for the numbers below `n`.
fn each(n: usize, text: impl Fn(usize) -> String) -> String {
    (0..n).fold(String::new(), |all, i| all + &text(i))
}

/// An archive with an entry of a certain type that is large, but well compressed.
fn bomb(ty: EntryType, size: u64) -> Vec<u8> {
    let mut builder = Builder::new(GzEncoder::new(Vec::new(), Compression::fast()));
    let mut header = Header::new_gnu();
    header.set_entry_type(ty);
    header.set_size(size);
    header.set_path("index.json").unwrap();
    header.set_cksum();
    builder.append(&header, std::io::repeat(b'x').take(size)).unwrap();
    let mut encoder = builder.into_inner().unwrap();
    encoder.flush().unwrap();
    encoder.finish().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn archives_keep_the_limit() {
    let scratch = Scratch::new(&[]);
    for ty in [EntryType::Regular, EntryType::GNULongName, EntryType::XHeader] {
        let bytes = bomb(ty, 190 << 20);
        assert!(bytes.len() < 2 << 20);
        scratch.write("m.umb", bytes);
        ends_in_time(&format!("info {}", scratch.show("m.umb")));
    }
    let label = |i: usize| format!(r#""label{i}":{{"applies-to":["states"],"type":{{"type":"bool"}}}},"#);
    let labels = each(500_000, label);
    let index = format!(
        r##"{{"format-version":1,"format-revision":0,"transition-system":{{"time":"discrete","#players":1,
        "#states":1,"#initial-states":1,"#choices":1,"#choice-actions":0,"#branches":1,"#branch-actions":0,
        "#observations":0}},"annotations":{{"aps":{{{}}}}}}}"##,
        labels.trim_end_matches(',')
    );
    let mut builder = Builder::new(GzEncoder::new(Vec::new(), Compression::fast()));
    let mut header = Header::new_ustar();
    header.set_size(index.len() as u64);
    builder.append_data(&mut header, "index.json", index.as_bytes()).unwrap();
    scratch.write("m.umb", builder.into_inner().unwrap().finish().unwrap());
    ends_in_time(&format!("info {}", scratch.show("m.umb")));
}

#[cfg(target_os = "linux")]
#[test]
fn texts_state_by_state_keep_the_limit() {
    let labels = each(1_000_000, |i| format!(" l{i}"));
    let drn = format!("@type: MDP\n@model\nstate 0 init{labels}\n\taction a\n\t\t0 : 1\n");
    let n = 500_000;
    let tra = format!("{n} {n} {n}\n") + &each(n, |i| format!("{i} 0 {} 1 a\n", (i + 1) % n));
    let scratch = Scratch::new(&[("m.drn", &drn), ("m.tra", &tra)]);
    ends_in_time(&format!("info {}", scratch.show("m.drn")));
    ends_in_time(&format!("info {}", scratch.show("m.tra")));
}

#[cfg(target_os = "linux")]
#[test]
fn documents_and_preferences_keep_the_limit() {
    let jani = format!("{{\"a\":[{}[]]}}", "[],".repeat(14_000_000));
    let prefs = each(1_000_000, |i| format!("objective o{i} = F x=1;\n"));
    let scratch = Scratch::new(&[("m.jani", &jani), ("m.prism", TWO), ("m.pref", &prefs)]);
    ends_in_time(&format!("info {}", scratch.show("m.jani")));
    ends_in_time(&format!("check {} {}", scratch.show("m.prism"), scratch.show("m.pref")));
}

#[cfg(target_os = "linux")]
#[test]
fn dumps_keep_the_limit() {
    let scratch = Scratch::new(&[]);
    let dump = scratch.show("dump");
    run!("export models/toy.prism models/toy.pref --out {dump} -q").expect(0);
    let manifest = scratch.read("dump/manifest.json");
    let lists = format!("\"constants\": {{\"K\": [{}[]]}}", "[],".repeat(5_000_000));
    assert!(manifest.contains("\"constants\": {}"));
    let path = scratch.path("dump/manifest.json");
    std::fs::write(&path, manifest.replace("\"constants\": {}", &lists)).unwrap();
    ends_in_time(&format!("query {dump} reachable"));
    std::fs::write(&path, manifest).unwrap();
    let mut header = ".ver DDDMP-2.0\n.mode A\n.varinfo 0\n.nnodes 1\n.orderedvarnames".to_owned();
    (0..3_000_000).for_each(|i| write!(header, " v{i}").unwrap());
    scratch.write("dump/regions.dddmp", header);
    ends_in_time(&format!("query {dump} reachable"));
    ends_in_time(&format!("verify {dump} models/toy.prism models/toy.pref"));
}

#[cfg(target_os = "linux")]
#[test]
fn monitors_and_quantities_keep_the_limit() {
    let counter = "mdp module m x:[0..3] init 0; [a] x<3 -> (x'=x+1); [b] x>0 -> (x'=x-1); endmodule";
    let prefs = "history = play; objective A = G (x=1 => F<=4000 x=0);";
    let scratch = Scratch::new(&[("m.prism", counter), ("m.pref", prefs)]);
    ends_in_time(&format!("check {} {}", scratch.show("m.prism"), scratch.show("m.pref")))
        .says("stopped in the phase `parse`");
    let found = ends_in_time("values models/toy.prism models/toy.pref --levels 1000000");
    assert_eq!(found.json()["counts"]["states"], "6", "known results are printed");
}

#[cfg(target_os = "linux")]
#[test]
fn a_tiny_stack_is_enough() {
    let script = format!(
        "ulimit -s 64; exec {} check models/toy.prism models/toy.pref",
        env!("CARGO_BIN_EXE_meliora")
    );
    let mut command = std::process::Command::new("sh");
    let output = command.args(["-c", &script]).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}
