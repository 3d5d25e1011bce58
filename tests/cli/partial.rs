//! `reach` computes the regions that a property needs, and prints the known results when a limit ends it.

use crate::common::prelude::*;

const REGIONS: [&str; 4] = ["pmax_one", "pmax_positive", "pmin_one", "pmin_positive"];

/// A model in which `bad` can be reached everywhere, and avoided only where two lists of bits are
/// equal: a set whose diagram doubles with each bit.
fn lists(bits: usize) -> String {
    let all = |line: &dyn Fn(usize) -> String| (0..bits).map(line).collect::<String>();
    let [xs, ys] = ["x", "y"].map(|name| all(&|i| format!("  {name}{i} : bool;\n")));
    let checks = all(&|i| {
        format!("  [] k={i} & x{i}=y{i} -> (k'={});\n  [] k={i} & x{i}!=y{i} -> (bad'=true);\n", i + 1)
    });
    format!(
        "mdp module m\n  k : [0..{bits}]; bad : bool;\n{xs}{ys}{checks}  [] true -> (bad'=true);\n  \
         [] k={bits} -> true;\nendmodule init k=0 & !bad endinit"
    )
}

fn reach(model: &str, options: &[&str], properties: &[&str]) -> Finished {
    let scratch = Scratch::new(&[("m.prism", model)]);
    let properties = properties.iter().flat_map(|property| ["--property", property]);
    Finished::of(executable().args(["reach", &scratch.show("m.prism")]).args(options).args(properties))
}

/// The names of the regions that an entry has.
fn known(entry: &Json) -> Vec<&str> {
    REGIONS.into_iter().filter(|region| !entry[region].is_null()).collect()
}

/// The diagram of Pmin > 0 has more nodes than fit; no other region is large.
const SMALL: [&str; 8] =
    ["--scope", "all", "--engine", "symbolic", "--order", "declared", "--memory", "2MiB"];

#[test]
fn a_property_is_answered_where_a_region_that_it_does_not_need_is_too_large() {
    let model = lists(14);
    reach(&model, &SMALL, &["Pmax>=1 [ F bad ]"]).prints(0, "The property holds in all initial states.");
    let needed = reach(&model, &SMALL, &["P>0 [ F bad ]"]).expect(4);
    needed.says("`Pmin > 0`");
    needed.shows("The property is not decided.");
}

#[test]
fn a_limit_leaves_the_answers_to_the_other_properties() {
    let (model, properties) = (lists(14), ["P>0 [ F bad ]", "Pmax>=1 [ F bad ]", "Pmax=? [ F k=14 ]"]);
    let found = reach(&model, &[&SMALL[..], &["--json"]].concat(), &properties).expect(4).json();
    let entries = found["properties"].as_array().unwrap();
    assert_eq!((&entries[0]["holds"], &entries[1]["holds"]), (&Json::Null, &json!(true)));
    assert_eq!(known(&entries[0]), ["pmax_one"], "known for another property of the target");
    let text = reach(&model, &SMALL, &properties).expect(4).stdout;
    let line = |property: &str| text.lines().find(|line| line.trim().starts_with(property)).unwrap();
    assert!(line(properties[0]).ends_with("not decided"), "{text}");
    assert!(line(properties[1]).ends_with("holds"), "{text}");
}

const MODEL: &str = "mdp module m x : [0..4]; [] x<2 -> 0.5: (x'=x+1) + 0.5: true; [] x<3 -> (x'=0);
    [] x=2 -> (x'=3); [] x=3 -> 0.5: (x'=2) + 0.5: true; [] x=1 -> (x'=4); endmodule";

/// The regions of a property in an engine by their names.
fn regions(model: &str, engine: &str, property: &str) -> Vec<(&'static str, String)> {
    let found = reach(model, &["--engine", engine, "--json"], &[property]).json();
    let size = |name: &'static str| Some((name, found[name].as_str()?.to_owned()));
    REGIONS.into_iter().filter_map(size).collect()
}

/// The regions that a property needs come with those that they are computed from, and are the same
/// in every question.
#[test]
fn a_property_has_the_regions_that_it_needs() {
    const PROPERTIES: [&str; 4] = ["Pmax>=1", "Pmax>0", "P>=1", "P>0"];
    let [one, positive, every, every_positive] = REGIONS;
    let chain = MODEL.replacen("mdp", "dtmc", 1);
    for (model, formula, needed) in [
        (MODEL, "F x=3", [&[one][..], &[positive], &[every, every_positive], &[every_positive]]),
        (MODEL, "G F x=3", [&[one, positive], &[positive], &[every], &[every, every_positive]]),
        (&chain, "F x=4", [&[one][..], &[positive], &[one, every], &[positive, every_positive]]),
    ] {
        let mut sizes = std::collections::BTreeMap::new();
        for engine in ["symbolic", "explicit"] {
            for (operator, needed) in PROPERTIES.into_iter().zip(needed) {
                let property = format!("{operator} [ {formula} ]");
                let found = regions(model, engine, &property);
                assert_eq!(found.iter().map(|(name, _)| *name).collect::<Vec<_>>(), needed, "{property}");
                for (name, size) in found {
                    assert_eq!(
                        sizes.entry(name).or_insert_with(|| size.clone()),
                        &size,
                        "{property}: {name}"
                    );
                }
            }
        }
        assert_eq!(sizes.len(), 4, "{sizes:?}");
        if let Some(target) = formula.strip_prefix("F ") {
            let scratch = Scratch::new(&[("m.prism", model)]);
            let whole = scratch.run(format!("reach m.prism --json --target '{target}'"));
            let whole = whole.expect(0).json();
            assert!(sizes.iter().all(|(name, size)| whole[name] == json!(size)), "{sizes:?} {whole}");
        }
    }
}

#[test]
fn numbers_need_two_regions_and_rewards_one() {
    let model = format!("{MODEL} rewards true : 1; endrewards");
    for (property, needed) in [
        ("Pmax=? [ F x=3 ]", &REGIONS[..2]),
        ("Pmin=? [ F x=3 ]", &REGIONS[2..]),
        ("P<=0.5 [ F x=3 ]", &REGIONS[..2]),
        ("Rmin=? [ F x=3 ]", &REGIONS[..1]),
        ("Rmax=? [ F x=3 ]", &REGIONS[2..]),
    ] {
        let found = regions(&model, "auto", property);
        assert_eq!(found.iter().map(|(name, _)| *name).collect::<Vec<_>>(), needed, "{property}");
    }
}

/// The rows of a sweep have the answers that are known when a limit ends an instance.
#[test]
fn a_row_has_the_answers_that_are_known() {
    let model = lists(14).replacen("mdp", "mdp const int N;", 1);
    let ranges = ["-c", "N=1:2", "--csv", "-"];
    let found =
        reach(&model, &[&SMALL[..], &ranges].concat(), &["P>0 [ F bad ]", "Pmax>=1 [ F bad ]"]).expect(4);
    let rows: Vec<&str> = found.stdout.lines().collect();
    assert!(rows[0].contains(",P>0 [ F bad ],Pmax>=1 [ F bad ],") && rows.len() == 3, "{rows:?}");
    for row in &rows[1..] {
        assert!(row.contains(",,true,") && row.ends_with(",limit"), "{row}");
    }
}
