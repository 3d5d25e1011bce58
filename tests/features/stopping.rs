//! Paths that stop where a question is decided have the same answer in the initial states, by each engine.

use std::collections::BTreeMap;
use std::sync::Arc;

use meliora::engine::regions::Which;
use meliora::engine::{AnyEngine, Count, Engine, Scope, Settings};
use meliora::error::SourceFile;
use meliora::lang;
use meliora::model::{Program, State};
use meliora::question::{Asking, Stopping, Under};
use meliora_quantities::state_values::Bound;
use proptest::prelude::*;
use proptest::sample::select;

use crate::random_case::{RandomCase, random_case};
use crate::settings;

/// Formulas that a state decides.
const FORMULAS: [&str; 12] = [
    "F (P)",
    "F<=2 (P)",
    "G (P)",
    "G<=3 (P)",
    "(P) U (Q)",
    "(P) U<=2 (Q)",
    "(P) W (Q)",
    "(P) R (Q)",
    "(P) M (Q)",
    "!(F (P))",
    "!((P) U (Q))",
    "(true) U (P)",
];

const ATOMS: [&str; 9] =
    ["s=0", "s=2", "s>1", "b", "s!=1", "s=2 & !b", "\"l\"", "\"deadlock\"", "!\"deadlock\" & s<3"];

/// The answer of an engine to a question.
struct Said {
    /// The regions that contain each initial state.
    regions: BTreeMap<State, Vec<bool>>,
    value: Option<Bound>,
    holds: Option<bool>,
    states: u64,
    deadlocks: u64,
}

fn said(program: Program, asking: &Asking, settings: &Settings) -> Said {
    let (program, variables) = (Arc::new(program.clone()), program.variables.len());
    let engine = AnyEngine::new(Arc::clone(asking.goal.program(&program)), settings.clone()).unwrap();
    let under = Under::new(&engine, &program, &asking.goal).unwrap();
    let counts = under.counts(&asking.goal).unwrap();
    let count = |count: &Count| count.to_string().parse().unwrap();
    let mut search = asking.goal.search(&engine).unwrap();
    let mut regions = BTreeMap::new();
    for which in Which::ALL {
        let region = search.region(which).unwrap();
        for state in engine.list_states(&engine.initial_states(), usize::MAX).unwrap() {
            let is_in = engine.contains(&region, &state).unwrap();
            regions.entry(state[..variables].to_vec()).or_insert_with(Vec::new).push(is_in);
        }
    }
    let answer = under.answer(asking, &program, search.known(), 1e-6).unwrap();
    answer.end.unwrap();
    let (states, deadlocks) = (count(&counts.states), count(&counts.deadlocks));
    Said { regions, value: answer.value, holds: answer.holds, states, deadlocks }
}

fn overlap(one: &Option<Bound>, other: &Option<Bound>) -> bool {
    match (one, other) {
        (Some(a), Some(b)) => {
            let near = |x: f64, y: f64| x == y || (x - y).abs() <= 3e-6 * x.abs().max(1.0);
            near(a.lower, b.lower) && near(a.upper, b.upper)
        }
        (None, None) => true,
        _ => false,
    }
}

fn check(case: &RandomCase, question: &str) {
    let case = RandomCase { scope: Scope::Reachable, ..case.clone() };
    let none = SourceFile::new("--const", "");
    let program = lang::load(&SourceFile::new("m.prism", case.model.as_str()), &none).unwrap().program;
    let source = SourceFile::new("--property", question);
    let mut values = Vec::new();
    for settings in settings(&case) {
        let asking = Asking::property(&program, &source, &[]).unwrap();
        let whole = said(program.clone(), &asking, &settings);
        let Stopping { program, asking } = Stopping::parse(&program, &source).unwrap();
        let stopped = said(program, &asking, &settings);
        assert_eq!(stopped.regions, whole.regions, "{question}");
        assert_eq!(stopped.holds, whole.holds, "{question}");
        assert!(overlap(&stopped.value, &whole.value), "{question}: {:?} {:?}", stopped.value, whole.value);
        assert!(stopped.states <= whole.states && stopped.deadlocks <= whole.deadlocks, "{question}");
        values.push([whole.value, stopped.value].map(|value| format!("{value:?}")));
    }
    // States found by number and by code have the same equations, in the same order.
    assert!(values.iter().all(|of| *of == values[0]), "{question}: {values:?}");
}

proptest! {
    #![proptest_config(crate::amount::random(150))]

    #[test]
    fn paths_that_stop_where_a_formula_is_decided_have_the_same_answer(
        case in random_case(),
        form in select(&FORMULAS[..]),
        p in select(&ATOMS[..]),
        q in select(&ATOMS[..]),
        operator in select(&["Pmax=?", "Pmin=?", "P>=1", "Pmax>0", "P<=0.5"][..]),
    ) {
        let formula = form.replace('P', p).replace('Q', q);
        check(&case, &format!("{operator} [ {formula} ]"));
    }

    #[test]
    fn paths_that_stop_at_a_target_have_the_same_reward(
        case in random_case(),
        p in select(&ATOMS[..]),
        operator in select(&["Rmin=?", "Rmax=?"][..]),
    ) {
        check(&case, &format!("{operator} [ F ({p}) ]"));
    }
}
