//! Models state by state: archives written and read again, texts in other formats, and archives
//! that are damaged or not supported.

use std::io::Read;

use meliora::export::explicit::{Graph, drn, explored, prism, umb};
use meliora::lang::Given;
use meliora::planning::AnalysisResult;
use num_traits::ToPrimitive;
use proptest::collection::vec;
use proptest::prelude::*;

use crate::common::entry;
use crate::common::prelude::*;

pub(crate) fn none() -> Given {
    Given { constants: SourceFile::new("c", ""), bounds: SourceFile::new("b", "") }
}

pub(crate) fn read(bytes: &[u8]) -> Result<Checked, meliora::Error> {
    Document::read("m.umb", bytes)?.load(&none(), &NoProgress)
}

/// The analysis of two targets, of which the second is preferred.
pub(crate) fn analysed<E: Engine>(engine: E, targets: [Predicate; 2]) -> Analysis<E> {
    let objective = |(i, e)| Objective { name: format!("o{i}"), goal: Goal::Reach(e), span: None };
    let statement = Statement { left: 1, relation: Relation::Strict, right: 0 };
    let preferences = Preferences {
        objectives: targets.into_iter().enumerate().map(objective).collect(),
        order: Preorder::new(2, &[statement]).unwrap(),
        empty: Empty::Bottom,
        history: History::State,
        requirements: Vec::new(),
    };
    finished(&Arc::new(engine), &Arc::new(preferences), Options::default())
}

fn result<E: Engine>(engine: E, targets: [Predicate; 2]) -> AnalysisResult {
    analysed(engine, targets).result().clone()
}

/// The steps of a state: for each choice its name and its distribution. Chains have no names.
pub(crate) fn steps(program: &Program, state: &[i64]) -> BTreeMap<String, BTreeMap<Vec<i64>, String>> {
    let named = program.kind != ModelKind::Dtmc;
    let all = program.exact_steps(state).unwrap().into_iter();
    let name = |name: String| if named { name } else { String::new() };
    all.map(|s| (name(s.name), s.successors.into_iter().map(|(to, p)| (to, p.to_string())).collect()))
        .collect()
}

pub(crate) fn counts<E: Engine>(engine: &E) -> [String; 5] {
    let (states, choices) = (engine.all_states(), engine.all_choices());
    [
        engine.count(&states).unwrap().to_string(),
        engine.count(&choices).unwrap().to_string(),
        engine.count_transitions(&choices, &states).unwrap().to_string(),
        engine.count(&engine.deadlock_states()).unwrap().to_string(),
        engine.count(&engine.initial_states()).unwrap().to_string(),
    ]
}

/// A program with two targets, its graph, and its archive.
struct Written {
    program: Arc<Program>,
    graph: Graph,
    archive: Vec<u8>,
    counts: [String; 5],
    result: AnalysisResult,
}

fn written(numbers: &[u16]) -> Option<Written> {
    let mut program = random_program(numbers, false);
    let targets = [0, numbers.len() / 2].map(|from| random_predicate(&mut program, &numbers[from..]));
    let program = Arc::new(program);
    let targets = targets.map(|target| program.predicate(target));
    let engine = ExplicitEngine::new(Arc::clone(&program), Settings::default()).unwrap();
    let counts = counts(&engine);
    let analysis = analysed(engine, targets);
    let graph = explored(&analysis, &program, 1 << 12).unwrap();
    let archive = umb(&graph, &analysis, &program, None).unwrap();
    let result = analysis.result().clone();
    (!graph.states.is_empty()).then_some(Written { program, graph, archive, counts, result })
}

pub(crate) fn label(program: &Program, name: &str) -> Predicate {
    program.predicate(program.labels.iter().find(|(label, _)| label == name).unwrap().1)
}

proptest! {
    #![proptest_config(meliora_amount::random(100))]

    #[test]
    fn a_random_model_is_the_same_after_writing_and_reading(numbers in vec(0u16..1000, 0..120)) {
        let Some(written) = written(&numbers) else { return Ok(()) };
        let again = Arc::new(read(&written.archive).unwrap().program);
        let targets = ["target_o0", "target_o1"].map(|name| label(&again, name));
        let symbolic = SymbolicEngine::new(Arc::clone(&again), Settings::default()).unwrap();
        prop_assert_eq!(&counts(&symbolic), &written.counts);
        let explicit = ExplicitEngine::new(Arc::clone(&again), Settings::default()).unwrap();
        prop_assert_eq!(&counts(&explicit), &written.counts);
        prop_assert_eq!(&result(symbolic, targets.clone()), &written.result);
        prop_assert_eq!(&result(explicit, targets), &written.result);
        for state in &written.graph.states {
            prop_assert_eq!(steps(&again, state), steps(&written.program, state));
        }
    }

    #[test]
    fn the_text_formats_give_the_same_model(numbers in vec(0u16..1000, 0..120)) {
        let Some(written) = written(&numbers) else { return Ok(()) };
        let folder = tempfile::tempdir().unwrap();
        let (files, at) = (prism(&written.graph), |name: &str| folder.path().join(name));
        for (name, text) in [("m.tra", &files.tra), ("m.sta", &files.sta), ("m.lab", &files.lab)] {
            std::fs::write(at(name), text).unwrap();
        }
        std::fs::write(at("m.drn"), drn(&written.graph, &written.program, &NoProgress).unwrap()).unwrap();
        for name in ["m.tra", "m.drn"] {
            let loaded = Document::open(&at(name)).unwrap().load(&none(), &NoProgress).unwrap();
            let engine = ExplicitEngine::new(Arc::new(loaded.program), Settings::default()).unwrap();
            prop_assert_eq!(&counts(&engine), &written.counts, "{}", name);
        }
    }

    #[test]
    fn a_damaged_archive_never_panics(
        numbers in vec(0u16..1000, 0..60),
        edits in vec((any::<prop::sample::Index>(), any::<u8>(), any::<bool>()), 1..6),
    ) {
        let Some(written) = written(&numbers) else { return Ok(()) };
        let mut plain = Vec::new();
        flate2::read::GzDecoder::new(&written.archive[..]).read_to_end(&mut plain).unwrap();
        for (index, byte, in_front) in edits {
            // The front has the index, whose numbers are the most dangerous.
            let n = if in_front { 4096.min(plain.len()) } else { plain.len() };
            plain[index.index(n)] = byte;
        }
        entry::umb(&plain);
        let cut = plain.len() * numbers.len() / 60;
        entry::umb(&plain[..cut.min(plain.len())]);
    }
}

#[test]
fn branches_that_become_one_with_a_sum_just_above_1_are_read_again() {
    let text = "mdp module m x:[0..1] init 0; [a] x=0 -> 0.5:(x'=1) + 0.5000000005:(x'=1); endmodule";
    let source = SourceFile::new("m.prism", format!("{text} label \"end\" = x=1;"));
    let program = Arc::new(lang::load(&source, &SourceFile::new("c", "")).unwrap().program);
    let target = label(&program, "end");
    let engine = ExplicitEngine::new(Arc::clone(&program), Settings::default()).unwrap();
    let analysis = analysed(engine, [target.clone(), target]);
    let graph = explored(&analysis, &program, 1 << 12).unwrap();
    let archive = umb(&graph, &analysis, &program, None).unwrap();
    assert_eq!(read(&archive).unwrap().program.exact_steps(&[0]).unwrap().len(), 1);
    let tra = prism(&graph).tra;
    assert!(tra.contains("1.0000000005"), "{tra}");
    for (probability, accepted) in [("1.0000000005", true), ("1.1", false)] {
        let source = SourceFile::new("m.tra", tra.replace("1.0000000005", probability));
        let loaded = lang::load(&source, &SourceFile::new("c", ""));
        assert_eq!(loaded.is_ok(), accepted, "{probability}");
    }
}

/// An archive without compression.
pub(crate) fn tar(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut builder = tar::Builder::new(Vec::new());
    for (name, content) in files {
        let mut header = tar::Header::new_ustar();
        header.set_size(content.len() as u64);
        header.set_mode(0o644);
        builder.append_data(&mut header, name, *content).unwrap();
    }
    builder.into_inner().unwrap()
}

pub(crate) fn index(system: &str, rest: &str) -> String {
    format!(
        r##"{{"format-version": 1, "format-revision": 0, "transition-system": {{"time": "discrete",
        "#players": 1, "#states": 2, "#initial-states": 1, "#choices": 2, "#choice-actions": 0,
        "#branches": 2, "#branch-actions": 0, "#observations": 0{system}}}{rest}}}"##
    )
}

pub(crate) fn words(numbers: &[u64]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

/// Reads an archive of two states in a row, with an index.
pub(crate) fn two_states(index: &str, more: &[(&str, &[u8])]) -> Result<Checked, String> {
    let (initial, targets) = (words(&[1]), words(&[1, 1]));
    let files = [
        ("index.json", index.as_bytes()),
        ("state-is-initial.bin", &initial),
        ("branch-to-target.bin", &targets),
    ];
    read(&tar(&[&files, more].concat())).map_err(|e| e.to_string())
}

#[test]
fn what_is_not_supported_is_refused_by_name() {
    assert!(two_states(&index("", ""), &[]).is_ok());
    let replaced = |from: &str, to: &str| two_states(&index("", "").replace(from, to), &[]).unwrap_err();
    for (from, to, message) in [
        ("\"discrete\"", "\"stochastic\"", "models with time \"stochastic\" are not supported"),
        ("players\": 1", "players\": 999999999", "and 999999999 players, without data for them"),
        ("observations\": 0", "observations\": 1", "models with partial observability are not supported"),
        ("version\": 1", "version\": 2", "version 2 of the format is not supported"),
        ("states\": 2, ", "states\": 9999999999, ", "without data for them"),
        ("initial-states\": 1", "initial-states\": 2", "1 states, the index says 2"),
        ("time", "tim", "missing field `time`"),
    ] {
        let found = replaced(from, to);
        assert!(found.contains(message), "{from}: {found}");
    }
    let interval = r#", "branch-probability-type": {"type": "double-interval"}"#;
    let found = two_states(&index(interval, ""), &[]).unwrap_err();
    assert!(found.contains("intervals of probabilities are not supported"), "{found}");
}

#[test]
fn numbers_that_are_not_distributions_are_refused() {
    let double = r#", "branch-probability-type": {"type": "double"}"#;
    let with = |p: [f64; 2]| {
        let bytes: Vec<u8> = p.iter().flat_map(|x| x.to_le_bytes()).collect();
        two_states(&index(double, ""), &[("branch-to-probability.bin", &bytes)])
    };
    assert!(with([1.0, 1.0]).is_ok());
    assert!(with([1.0, 0.5]).unwrap_err().contains("state 1: choice 0: the probabilities sum to 0.5"));
    assert!(with([f64::NAN, 1.0]).unwrap_err().contains("NaN is not a probability"));
    let rational = r#", "branch-probability-type": {"type": "rational"}"#;
    let zero = words(&[1, 1, 1, 0]);
    let found = two_states(&index(rational, ""), &[("branch-to-probability.bin", &zero)]).unwrap_err();
    assert!(found.contains("a denominator is 0"), "{found}");
}

#[test]
fn valuations_with_padding_offsets_strings_and_options_are_read() {
    // The first example of the specification, with the bit of the option before the value as its text
    // says, and an integer with an offset.
    let valuations = r##", "valuations": {"states": {"unique": true, "#strings": 3, "classes": [{"variables": [
        {"name": "v0", "type": {"type": "bool", "size": 2}},
        {"name": "v1", "type": {"type": "uint", "size": 6}, "is-optional": true}, {"padding": 5},
        {"name": "v2", "type": {"type": "string"}}, {"name": "v3", "type": {"type": "bool", "size": 3}},
        {"padding": 7}, {"name": "v4", "type": {"type": "uint", "size": 8}, "offset": -128}]}]}}"##;
    let row = [0xdd, 0x40, 0, 0, 0, 0, 0, 0, 0, 0x40, 0, 184];
    let mut other = row;
    other[0] = 0;
    let checked = two_states(
        &index("", valuations),
        &[
            ("valuations/states/valuations.bin", &[row, other].concat()),
            ("valuations/states/string-mapping.bin", &words(&[0, 3, 5, 6])),
            ("valuations/states/strings.bin", b"xyzabc"),
        ],
    );
    let program = checked.unwrap().program;
    let initial: Vec<i64> = program.variables.iter().map(|v| v.initial.unwrap()).collect();
    assert_eq!(program.show_state(&initial), "v0=true,v1=\"27\",v2=ab,v3=true,v4=56");
    let names: Vec<_> = program.variables[1].values.iter().map(String::as_str).collect();
    assert_eq!(names, ["27", "none"]);
}

#[test]
fn states_with_equal_values_get_numbers() {
    let valuations = r#", "valuations": {"states": {"unique": false, "classes": [{"variables": [
        {"name": "v", "type": {"type": "uint", "size": 8}}]}]}}"#;
    let checked =
        two_states(&index("", valuations), &[("valuations/states/valuations.bin", &[7, 7])]).unwrap();
    assert_eq!(checked.program.variables[0].name, "state");
    assert!(checked.warnings[0].message.contains("two states have the same values"));
}

#[test]
fn texts_are_read_and_their_errors_have_places() {
    let load = |text: &str| lang::load(&SourceFile::new("m", text), &SourceFile::new("c", ""));
    let drn = "@type: MDP\n@parameters\n\n@reward_models\ncost\n@nr_states\n2\n@nr_choices\n2\n@model\n\
        state 0 [1] init\n\taction go [1/2]\n\t\t0 : 1/3\n\t\t1 : 2/3\nstate 1 goal deadlock\n\
        \taction __NOLABEL__\n\t\t1 : 1\n";
    let program = load(drn).unwrap().program;
    assert_eq!((program.commands.len(), program.labels.len(), program.rewards[0].items.len()), (1, 1, 2));
    let (choice, _) = program.choices(&[0]).unwrap().remove(0);
    assert_eq!(program.reward(&program.rewards[0], &[0], &choice).unwrap().to_string(), "3/2");
    assert_eq!(program.exact_steps(&[0]).unwrap()[0].successors[0].1.to_string(), "1/3");
    for (from, to, message) in [
        ("MDP", "CTMC", "models of type CTMC are not supported"),
        ("MDP", "SMG", "games in this format are not supported"),
        ("@parameters\n", "@parameters\np", "parameters are not supported"),
        ("2/3", "1/2", "state 0: choice 0: the probabilities sum to 0.8333333333333334, not to 1"),
        ("1 : 2/3", "7 : 2/3", "state 0: choice 0: the target 7 is not one of the 2 states"),
        ("1 : 2/3", "1 : [0.1, 0.9]", "intervals of probabilities are not supported"),
        ("state 1", "state 2", "state 2 is not in its place, expected state 1"),
        ("@nr_choices\n2", "@nr_choices\n3", "the model has 2 choices, not 3"),
        (" init", "", "the model has no initial state"),
    ] {
        assert_eq!(load(&drn.replace(from, to)).unwrap_err().to_string(), message);
    }
    let tra = "3 3 4\n0 0 1 0.5 a\n0 0 2 0.5 a\n0 1 2 1 b\n2 0 2 1\n";
    let program = load(tra).unwrap().program;
    assert_eq!(program.actions, ["a", "b"]);
    assert_eq!(program.choices(&[1]).unwrap()[0].1, "deadlock");
    for (from, to, message) in [
        ("3 3 4", "4000 3 4", "the file has no transitions of 4000 states"),
        ("3 3 4", "3 4 4", "the numbers of this line are [3, 3, 4] in the file"),
        ("0 1 2 1 b", "0 1 2 x b", "`x` is not a number"),
        ("2 0 2 1", "0 0 2 1", "the transitions are not sorted by state and choice"),
    ] {
        assert_eq!(load(&tra.replace(from, to)).unwrap_err().to_string(), message);
    }
}

/// The export to DRN left rewards out.
#[test]
fn states_of_drn_have_the_names_of_a_section() {
    let load = |names: &str| {
        let text = format!(
            "@type: MDP\n@state_names\n{names}\n@nr_states\n2\n@model\nstate 0 init\n\taction go\n\t\t1 : 1\n\
             state 1\n\taction go\n\t\t1 : 1\n"
        );
        lang::load(&SourceFile::new("m", text), &SourceFile::new("c", ""))
    };
    let program = load("\"at home\"\n\"// shop\"").unwrap().program;
    let variable = &program.variables[0];
    assert_eq!((variable.name.as_str(), variable.initial), ("state", Some(0)));
    assert_eq!(variable.values, ["at home", "// shop"]);
    assert_eq!(program.steps(&[0]).unwrap()[0].successors[0].0, [1]);
    for (names, message) in [
        ("\"one\"", "the model has 2 states, but 1 names for them"),
        ("\"one\"\n\"one\"", "two states are called `one`"),
        ("one\n\"two\"", "expected the name of a state in double quotes"),
        ("\"\"\n\"two\"", "expected the name of a state in double quotes"),
        ("\"a\u{202e}b\"\n\"two\"", "of visible characters"),
    ] {
        let error = load(names).unwrap_err().to_string();
        assert!(error.contains(message), "{names:?}: {error}");
    }
}

#[test]
fn rewards_are_written_to_drn_and_read_again() {
    let model = "module m s : [0..2] init 0; [a] s<2 -> 1/2:(s'=s+1) + 1/2:true; \
        [b] s=0 -> (s'=2); endmodule label \"goal\" = s=2; rewards \"pay\" s=1 : 0.1; [a] s=0 : 2; [b] true : 1/3; \
        endrewards rewards true : s; endrewards rewards \"p_ay\" s=2 : 7; endrewards \
        rewards \"wrong\" s=1 : log(s-1, 2); endrewards";
    for kind in ["mdp", "dtmc"] {
        let (text, none) = (format!("{kind} {model}"), SourceFile::new("c", ""));
        let program = Arc::new(lang::load(&SourceFile::new("m", text), &none).unwrap().program);
        let engine = ExplicitEngine::new(Arc::clone(&program), Settings::default()).unwrap();
        let analysis = analysed(engine, ["goal"; 2].map(|name| label(&program, name)));
        let graph = explored(&analysis, &program, 9).unwrap();
        let text = drn(&graph, &program, &NoProgress).unwrap();
        assert!(text.contains("@reward_models\npay reward p_ay\n"), "{text}");
        let again = lang::load(&SourceFile::new("m.drn", text), &none).unwrap().program;
        let names: Vec<_> = again.rewards.iter().map(|rewards| rewards.name.as_deref().unwrap()).collect();
        assert_eq!(names, ["pay", "reward", "p_ay"]);
        for (number, state) in graph.states.iter().enumerate() {
            let (steps, copies) =
                (program.exact_steps(state).unwrap(), again.exact_steps(&[number as i64]).unwrap());
            assert_eq!(steps.len(), copies.len());
            for (structure, copied) in program.rewards.iter().zip(&again.rewards) {
                for (step, copy) in steps.iter().zip(&copies) {
                    let earned = program.reward(structure, state, &step.choice).unwrap();
                    let read = again.reward(copied, &[number as i64], &copy.choice).unwrap();
                    let [earned, read] = [earned, read].map(|x| x.to_f64().unwrap());
                    assert!((earned - read).abs() < 1e-15, "{kind} {state:?}: {earned} and {read}");
                }
            }
        }
    }
}
