//! Export, query and verify from the command line.

use crate::cli::common::{LONG, LONG_PREFS, keys};
use crate::common::factory::{PREFERENCES, factory};
use crate::common::prelude::*;

fn export(scratch: &Scratch, model: &str, options: &str) -> String {
    let out = scratch.show("dump");
    run!("export models/{model}.prism models/{model}.pref {options} --out {out} -q").expect(0);
    out
}

fn query(dump: &str, arguments: &[&str]) -> Finished {
    Finished::of(executable().args(["query", dump]).args(arguments))
}

fn count(dump: &str, region: &str) -> String {
    query(dump, &[region, "--count"]).expect(0).stdout.trim().to_owned()
}

/// Returns the size of each region in the report of `check`, by the region's name.
fn expected(report: &Json) -> BTreeMap<String, String> {
    let mut all = BTreeMap::new();
    let mut add = |name: String, count: &Json| {
        all.insert(name, count.as_str().unwrap().to_owned());
    };
    add("reachable".into(), &report["counts"]["states"]);
    add("choices".into(), &report["counts"]["choices"]);
    add("deadlock".into(), &report["counts"]["deadlocks"]);
    add("initial".into(), &report["counts"]["initial"]);
    for objective in report["objectives"].as_array().unwrap() {
        let name = objective["name"].as_str().unwrap();
        add(format!("target:{name}"), &objective["target"]);
        add(format!("almost-sure:{name}"), &objective["almost_sure"]);
        add(format!("positive:{name}"), &objective["positive"]);
    }
    for class in report["classes"].as_array().unwrap() {
        let names: Vec<&str> =
            class["most_preferred"].as_array().unwrap().iter().map(|n| n.as_str().unwrap()).collect();
        let name = if names.is_empty() { "nothing".to_owned() } else { names.join("+") };
        add(format!("class:{name}"), &class["states"]);
    }
    for kind in ["sasi", "spi"] {
        for (k, level) in report[kind]["levels"].as_array().unwrap().iter().enumerate() {
            add(format!("{kind}:{}", k + 1), level);
        }
        add(format!("{kind}:unbounded"), &report[kind]["unbounded"]);
    }
    all
}

#[test]
fn a_dump_has_the_counts_of_check() {
    for (model, options) in [
        ("robot5x5", "--scope all --safety transition"),
        ("robot5x5", "--scope reachable --order declared"),
        ("robot5x5", "--scope all --safety prefix"),
        ("toy", ""),
        ("lateral", ""),
        ("lateral_prefix", "--safety prefix"),
    ] {
        let scratch = Scratch::new(&[]);
        let dump = export(&scratch, model, options);
        let report = run!("check models/{model}.prism models/{model}.pref {options} --json").expect(0).json();
        let manifest: Json =
            serde_json::from_str(&fs::read_to_string(format!("{dump}/manifest.json")).unwrap()).unwrap();
        let roots = manifest["regions"]["roots"].as_array().unwrap();
        for (region, number) in expected(&report) {
            let root = roots.iter().find(|root| root["name"] == *region).unwrap();
            assert_eq!(root["count"], *number, "{model} {options}: {region}");
            // `verify` counts the members of each root again; one small dump is enough for `query`.
            if model == "toy" {
                assert_eq!(count(&dump, &region), number, "{region}");
            }
        }
        run!("verify {dump} models/{model}.prism models/{model}.pref").expect(0);
    }
}

#[test]
fn the_papers_states_are_in_the_dump_with_their_strategy() {
    let scratch = Scratch::new(&[]);
    let dump = export(&scratch, "robot5x5", "--scope all --safety transition");
    let state = "r=2,c=2,b=8,d=false,e=false,f=false,ch=false";
    let found = query(&dump, &["strategy:sasi:2", "--contains", state, "--json"]).expect(0).json();
    assert_eq!(found["contains"][0]["choices"], serde_json::json!(["N"]));
    query(&dump, &["sasi:2", "--contains", "r=0,c=0,b=0,d=false,e=false,f=false,ch=false"]).expect(1);
}

#[test]
fn expressions_join_regions() {
    let scratch = Scratch::new(&[]);
    let dump = export(&scratch, "robot5x5", "--scope all --safety transition");
    for (region, number) in [
        ("sasi:1 & !sasi:2", "670"),
        ("!(sasi:1|!sasi:1)", "0"),
        ("!reachable", "0"),
        ("class:A | class:B & class:C", "314"),
        ("!strategy:sasi:1", "11915"),
        ("strategy:sasi:1 | !reachable", "1973"),
    ] {
        let found = count(&dump, region);
        assert_eq!(found, number, "{region}");
    }
    let confined =
        query(&dump, &["reachable", "--where", "b > 3 & !(d | e) & r + c = 4", "--count"]).expect(0);
    assert_eq!(confined.stdout.trim(), "100");
    let listed =
        query(&dump, &["reachable", "--where", "b = 8 & r = 4", "--list", "3", "--json"]).expect(0).json();
    assert_eq!(listed["states"].as_array().unwrap().len(), 3);
    assert_eq!(keys(&listed["states"][0]["state"]), ["r", "c", "b", "d", "e", "f", "ch"]);
}

#[test]
fn levels_past_the_last_one_are_the_fixpoint() {
    let scratch = Scratch::new(&[]);
    let dump = export(&scratch, "toy", "");
    for region in ["sasi:7", "strategy:sasi:7", "sasi:unbounded"] {
        assert_eq!(query(&dump, &[region, "--count"]).expect(0).stdout, "0\n", "{region}");
    }
}

#[test]
fn an_empty_list_says_so() {
    let scratch = Scratch::new(&[]);
    let dump = export(&scratch, "toy", "");
    let empty = query(&dump, &["reachable & !reachable", "--list", "3"]).expect(0);
    assert_eq!(empty.stdout, "");
    empty.says("no state to list");
    assert_eq!(query(&dump, &["reachable", "--list", "3"]).expect(0).stderr, "");
    assert_eq!(query(&dump, &["reachable", "--list", "0"]).expect(0).stderr, "");
}

#[test]
fn wrong_questions_point_at_their_place() {
    let scratch = Scratch::new(&[]);
    let dump = export(&scratch, "toy", "");
    for (arguments, word) in [
        (vec!["sasi:0"], "unknown region `sasi:0`"),
        (vec!["sasi:1 &"], "name of a region"),
        (vec!["(sasi:1"], "not closed"),
        (vec!["sasi:1 sasi:1"], "the expression ends before this"),
        (vec!["sasi:1", "--where", "y = 1"], "y"),
        (vec!["sasi:1", "--where", "\"goal\""], "does not contain the labels"),
        (vec!["sasi:1", "--contains", "s=99"], "range"),
    ] {
        let found = query(&dump, &arguments).expect(3);
        assert!(found.stderr.contains(word) && found.stdout.is_empty(), "{found:#?}");
    }
}

#[test]
fn a_changed_file_model_or_hash_is_refused() {
    let scratch = Scratch::new(&[]);
    let dump = export(&scratch, "toy", "");
    let model = fs::read_to_string("models/toy.prism").unwrap();
    scratch.write("m.prism", model + "// changed\n");
    let other = run!("verify {dump} {} models/toy.pref --json", scratch.show("m.prism")).expect(1).json();
    assert!(other["violation"]["condition"].as_str().unwrap().contains("SHA-256 of the model"));
    let file = scratch.path("dump").join("certificate.dddmp");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, text.replacen(" 1 -1\n", " 1 -2\n", 1)).unwrap();
    run!("verify {dump} models/toy.prism models/toy.pref").expect(3);
    fs::write(&file, "").unwrap();
    let failed = run!("verify {dump} models/toy.prism models/toy.pref --json").expect(3).json();
    assert_eq!((&failed["kind"], &failed["line"]), (&Json::from("input"), &Json::from(1)));
}

#[test]
fn texts_that_the_dump_was_not_made_from_are_named() {
    let scratch = Scratch::new(&[("other.pref", "objective A = F nowhere=1;\n")]);
    let dump = export(&scratch, "network", "-c K=3,M=1");
    for (model, preferences, what) in [
        ("models/chain.prism", "models/network.pref".to_owned(), "the dump was made from another model"),
        (
            "models/network.prism",
            scratch.show("other.pref"),
            "the dump was made from another preference file",
        ),
    ] {
        let refused = run!("verify {dump} {model} {preferences}").expect(3).stderr;
        assert!(refused.contains(what) && !refused.contains("the constants of the dump"), "{refused}");
        assert!(refused.contains("manifest.json: "), "{refused}");
    }
}

#[test]
fn regions_are_chosen_by_globs() {
    let scratch = Scratch::new(&[]);
    let dump = export(&scratch, "toy", "--region sasi:* --region class:nothing --format dot");
    let mut files: Vec<String> = fs::read_dir(scratch.path("dump"))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .collect();
    files.sort();
    assert_eq!(
        files,
        [
            "class_nothing.dot",
            "initial.dot",
            "manifest.json",
            "reachable.dot",
            "regions.dddmp",
            "sasi_1.dot",
            "sasi_unbounded.dot"
        ]
    );
    run!("verify {dump} models/toy.prism models/toy.pref").expect(3);
    let nothing =
        format!("export models/toy.prism models/toy.pref --region x* --out {}", scratch.show("other"));
    run(&nothing).expect(2);
    assert!(!scratch.path("other").exists());
}

#[test]
fn constants_come_from_the_dump() {
    let scratch = Scratch::new(&[("m.prism", LONG), ("p.pref", LONG_PREFS)]);
    let (m, p, out) = (scratch.show("m.prism"), scratch.show("p.pref"), scratch.show("dump"));
    run!("export {m} {p} -c N=20 --out {out}").expect(0);
    run!("verify {out} {m} {p}").expect(0);
    let confined = query(&out, &["reachable", "--where", "x = N", "--count"]).expect(0).stdout;
    assert_eq!(confined.trim(), count(&out, "target:A"));
}

#[test]
fn constants_of_every_size_survive_a_dump() {
    let model = "mdp const double big; const double small = 0.00007; const double tiny = 1e-7; const int n;
        module m x:[0..3]; [] x<3 & big>small & tiny>0 -> (x'=x+1); endmodule";
    let scratch = Scratch::new(&[("m.prism", model), ("m.pref", "objective A = F x=n;")]);
    let (m, p, out) = (scratch.show("m.prism"), scratch.show("m.pref"), scratch.show("dump"));
    for big in ["1e16", "1e22", "123456789012345680.0", "0.1", "3", "5e-324", "1.7976931348623157e308"] {
        run!("export {m} {p} -c big={big},n=2 --out {out} -q").expect(0);
        run!("verify {out} {m} {p}").expect(0);
    }
    run!("export {m} {p} -c big=1e999,n=2 --out {out} -q").ends(3, "`1e999` is too large for a double");
}

#[test]
fn an_unknown_scope_of_a_dump_is_an_error_and_not_the_usual_one() {
    let scratch = Scratch::new(&[]);
    let dump = export(&scratch, "toy", "");
    let manifest = scratch.path("dump").join("manifest.json");
    let text = fs::read_to_string(&manifest).unwrap();
    fs::write(&manifest, text.replacen("\"reachable\",", "\"reached\",", 1)).unwrap();
    let refused = run!("verify {dump} models/toy.prism models/toy.pref").expect(3);
    let message = "the scope is `reached`; expected `reachable` or `all`";
    refused.says(message);
}

#[test]
fn a_false_picture_is_refused() {
    let scratch = Scratch::new(&[]);
    let dump = export(&scratch, "toy", "--format dot");
    let verify = format!("verify {dump} models/toy.prism models/toy.pref --json");
    run(&verify).expect(0);
    let picture = scratch.path("dump").join("sasi_1.dot");
    let text = fs::read_to_string(&picture).unwrap();
    for other in [text.replacen("dashed", "solid", 1), text.clone() + " ", text[1..].to_owned()] {
        fs::write(&picture, other).unwrap();
        let condition = run(&verify).expect(1).json()["violation"]["condition"].to_string();
        assert!(condition.contains("`sasi:1`"), "{condition}");
    }
    fs::remove_file(&picture).unwrap();
    run(&verify).expect(1);
}

#[test]
fn values_of_a_dump_are_verified() {
    let scratch = Scratch::new(&[]);
    for (model, options) in [
        ("drone", "--values"),
        ("robot5x5", "--values --safety transition --levels 1"),
        ("lateral_prefix", "--values --safety prefix --format dot"),
        ("pursuit", "--values -c N=4"),
        ("pursuit", "--values --safety prefix --levels 3 -c N=3"),
    ] {
        let dump = export(&scratch, model, options);
        run!("verify {dump} models/{model}.prism models/{model}.pref").prints(0, "P_1 ").shows("C_1 ");
    }
    let out = scratch.show("drone");
    let drone = format!("export models/drone.prism models/drone.pref --out {out} --values --safety action");
    let report = run!("{drone} --json").expect(0).json();
    assert_eq!((report["values"]["rows"].as_u64(), report["values"]["levels"].as_u64()), (Some(2), Some(2)));
    assert!(report["values"]["narrow"].as_bool().unwrap());
    let text = fs::read_to_string(format!("{out}/values.csv")).unwrap();
    assert!(text.starts_with("at,p_1_lower,p_1_upper,p_1_rank,c_1_lower,"), "{text}");
    // Doubles are as narrow as possible, but 1/6 is none.
    run!("{drone} --precision 1e-300").prints(0, "more than the precision");
    run!("{drone} --limit 1").ends(4, "the values of 2 states; a larger `--limit` than 1 allows it");
    for wrong in ["--reward gold", "--region sasi:*", "--no-certificate", "--format drn"] {
        run!("{drone} {wrong}").expect(2);
    }
    run(&drone.replace("--values", "--levels 2")).expect(2);
}

/// The message named the phase `write`, in which nothing was missing.
#[test]
fn a_limit_that_ends_the_proof_is_in_its_phase_and_leaves_the_regions() {
    let scratch = Scratch::new(&[("m.prism", &factory(12)), ("m.pref", PREFERENCES)]);
    let [model, wishes, out] = ["m.prism", "m.pref", "dump"].map(|name| scratch.show(name));
    let export = |limit: &str| run!("export {model} {wishes} --out {out} {limit} --json");
    let total = export("").expect(0).json()["time"]["total"].as_f64().unwrap();
    // The machine may be busy, so the limits are many.
    for share in [0.9, 0.8, 0.7, 0.6, 1.0, 0.5, 1.2] {
        fs::remove_dir_all(scratch.path("dump")).unwrap_or_default();
        let ended = export(&format!("--timeout {}ms", (1000.0 * total * share) as u64));
        let report = ended.json();
        if !report["regions"].as_array().unwrap().is_empty() {
            run!("query {out} reachable --count").expect(0);
        }
        if ended.stderr.contains("without a certificate") {
            assert_eq!(ended.status, 4);
            ended.says("all regions are written, with the proofs of the others");
            ended.says("phase `certificate`");
            assert!(report["certificate_nodes"].is_number(), "{report}");
            return;
        }
    }
    panic!("no limit ended a part of the proof: {total} s");
}
