//! Files after an `export` that fails, the form of tables, and the settings that `verify` takes from a dump.

use crate::common::prelude::*;

const NEGATIVE: &str = "mdp
module m
  s : [0..4] init 0;
  [a] s=0 -> 1/2:(s'=1) + 1/2:(s'=2);
  [b] s=2 -> (s'=1);
endmodule
rewards \"negative\" s=2 : -1; endrewards";
const ONE: &str = "objective A = F s=1; objective B = F s=2; prefer A > B;";
const LINKS: &str = "(define (domain d) (:predicates (lnk ?x ?y) (g) (h))
 (:action tog :parameters (?x ?y) :precondition (and (not (h)) (not (lnk ?x ?y))) :effect (oneof (lnk ?x ?y) (h))))
(define (problem p) (:domain d) (:objects a b) (:init)
 (:goal (and (preference one (lnk a b)) (preference two (lnk b a)))))";

/// The older dump was replaced by regions without a certificate.
#[test]
fn an_export_whose_values_fail_leaves_the_older_dump() {
    let scratch =
        Scratch::new(&[("m.prism", NEGATIVE), ("m.pref", ONE), ("none.pref", "objective A = F s=1;")]);
    let [model, wishes, none, out] =
        ["m.prism", "m.pref", "none.pref", "dump"].map(|name| scratch.show(name));
    run!("export {model} {wishes} --out {out} -q").expect(0);
    let verify = format!("verify {out} {model} {wishes}");
    run(&verify).expect(0);
    let before = fs::read(scratch.path("dump").join("manifest.json")).unwrap();
    for failing in [
        format!("export {model} {wishes} --out {out} --values --reward negative"),
        format!("export {model} {none} --out {out} --values"),
    ] {
        assert_ne!(run(&failing).status, 0, "{failing}");
        assert_eq!(fs::read(scratch.path("dump").join("manifest.json")).unwrap(), before, "{failing}");
        run(&verify).expect(0);
    }
}

#[test]
fn names_with_commas_are_quoted_in_the_header_of_values() {
    let scratch = Scratch::new(&[("c.pddl", LINKS), ("c.pref", "prefer one > two;")]);
    let [model, wishes, out] = ["c.pddl", "c.pref", "dump"].map(|name| scratch.show(name));
    run!("export {model} {wishes} --out {out} --values -q").expect(0);
    let table = fs::read_to_string(scratch.path("dump").join("values.csv")).unwrap();
    let header = table.lines().next().unwrap();
    assert!(header.contains("\"lnk(a,b)\","), "{header}");
    run!("verify {out} {model} {wishes}").expect(0);
}

/// Whoever writes a dump chooses its constants, its scope and its safety: `verify` says which they are.
#[test]
fn verify_names_what_it_takes_from_the_dump() {
    let scratch = Scratch::new(&[]);
    let out = scratch.show("dump");
    let (model, wishes) = ("models/pursuit.prism", "models/pursuit.pref");
    let options = "-c N=3 --safety prefix --max-level 1 --values --levels 1";
    run!("export {model} {wishes} {options} --out {out} -q").expect(0);
    let verify = format!("verify {out} {model} {wishes}");
    let taken = run!("{verify} --json").expect(0).json()["taken"].clone();
    let expected = [
        ("constants", "N=3"),
        ("scope", "reachable"),
        ("safety", "prefix"),
        ("empty", "bottom"),
        ("max_level", "1"),
        ("reward", "steps"),
        ("levels", "1"),
    ];
    for (name, value) in expected {
        assert_eq!(taken[name], value, "{name} {taken}");
    }
    let text = run(&verify).expect(0).stdout;
    assert!(
        text.starts_with("taken from the dump: constants N=3, empty bottom, levels 1, max_level 1, "),
        "{text}"
    );
    // A number of a million digits is not printed in full.
    let digits = "0".repeat(1_000_000);
    run!("export models/drone.prism models/drone.pref --out {out} -q").expect(0);
    let manifest = scratch.path("dump").join("manifest.json");
    let long = fs::read_to_string(&manifest).unwrap().replace("\"given\": []", "\"given\": [\"B\"]");
    let long = long.replace("\"B\": 4", &format!("\"B\": 4.{digits}"));
    fs::write(&manifest, long).unwrap();
    let refused = run!("verify {out} models/drone.prism models/drone.pref");
    assert_ne!(refused.status, 0);
    let length = refused.stdout.len() + refused.stderr.len();
    assert!(length < 10_000, "{length} bytes");
}
