//! Models whose initial states are given by a condition that is not a conjunction.

use crate::cli::common::{Scratch, run};

/// A square with two initial states and five reachable ones.
const SQUARE: &str = "mdp const int N=100000; module m x:[0..N]; y:[0..N]; [left] x>0 -> (x'=x-1); endmodule \
                      init x=2 & y=0 | x=1 & y=1 endinit";
const PREFS: &str = "objective A = F x=0; objective B = F x=1; prefer A > B;";

fn square() -> Scratch {
    Scratch::new(&[("m.prism", SQUARE), ("m.pref", PREFS)])
}

#[test]
fn few_initial_states_by_a_disjunction_are_found_by_every_command_and_engine() {
    let scratch = square();
    let (model, prefs) = (scratch.show("m.prism"), scratch.show("m.pref"));
    for engine in ["auto", "explicit", "symbolic"] {
        let asked = |command: &str| run!("{command} --engine {engine} --timeout 60s --json").expect(0).json();
        for command in
            [format!("reach {model} --target x=0"), format!("check {model} {prefs}"), format!("info {model}")]
        {
            let report = asked(&command);
            assert_eq!(report["counts"]["states"], "5", "{command} --engine {engine}");
            assert_eq!(report["counts"]["initial"], "2", "{command} --engine {engine}");
        }
        for command in ["values", "strategy --kind sasi"] {
            let report = asked(&format!("{command} {model} {prefs}"));
            assert_eq!(report["states"].as_array().unwrap().len(), 2, "{command} --engine {engine}");
        }
        let simulated = asked(&format!("simulate {model} {prefs} --kind sasi --runs 3"));
        assert_eq!(simulated["runs"], 3, "{engine}");
    }
}

#[test]
fn initial_states_by_a_sum_are_found_by_every_engine() {
    let names: Vec<String> = (0..30).map(|i| format!("q{i}")).collect();
    let variables: String = names.iter().map(|q| format!("{q}:[0..1];")).collect();
    let moves: String =
        (0..29).map(|i| format!("[] q{i}=1 & q{}=0 -> (q{i}'=0)&(q{}'=1);", i + 1, i + 1)).collect();
    let text = format!("mdp module m {variables} {moves} endmodule init {} = 2 endinit", names.join("+"));
    let scratch = Scratch::new(&[("m.prism", &text)]);
    for engine in ["auto", "explicit", "symbolic"] {
        let command = format!("info {} --engine {engine} --timeout 60s --json", scratch.show("m.prism"));
        let report = run(&command).expect(0).json();
        assert_eq!(report["counts"]["states"], "435", "{engine}");
        assert_eq!(report["counts"]["initial"], "435", "{engine}");
    }
}

#[test]
fn a_search_for_initial_states_that_does_not_end_obeys_the_time_limit_and_auto_leaves_it_to_diagrams() {
    let names: Vec<String> = (0..40).map(|i| format!("q{i}")).collect();
    let variables: String = names.iter().map(|q| format!("{q}:[0..1];")).collect();
    let odd = format!("mod({},2)=1", names.join("+"));
    let text = format!("mdp module m {variables} [] true -> true; endmodule init {odd} endinit");
    let scratch = Scratch::new(&[("m.prism", &text)]);
    let report = run!("info {} --timeout 60s --json", scratch.show("m.prism")).expect(0).json();
    assert_eq!(report["counts"]["states"], (1_u64 << 39).to_string());
    let hopeless = "mdp module m x:[0..1000000000]; y:[0..1000000000]; z:[0..1000000000]; [] true -> true; \
                    endmodule init x*y*z - x*x*y + z = 999999937 & x>2 & y>2 endinit";
    let scratch = Scratch::new(&[("m.prism", hopeless)]);
    let late = run!("info {} --engine explicit --timeout 300ms --json", scratch.show("m.prism"));
    late.ends(4, "out of time");
}
