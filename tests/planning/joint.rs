//! Objectives that are achieved together, compared with one objective that is their conjunction.

use std::cell::Cell;
use std::collections::BTreeSet;
use std::sync::Arc;

use meliora::engine::{Algebra, AnyEngine, Engine, Scope, Settings, Storage};
use meliora::error::SourceFile;
use meliora::lang;
use meliora::planning::{Analysis, Options};
use proptest::test_runner::{Config, TestRunner};

use crate::plans::{FORMULAS, drawn, model};

/// Analyses objectives that cannot be compared.
fn analysed(model: &str, history: &str, formulas: &[&str], storage: Storage) -> Analysis<AnyEngine> {
    analysed_within(model, history, formulas, storage, Scope::Reachable)
}

fn analysed_within(
    model: &str,
    history: &str,
    formulas: &[&str],
    storage: Storage,
    scope: Scope,
) -> Analysis<AnyEngine> {
    let mut wishes = format!("history = {history};\n");
    for (i, formula) in formulas.iter().enumerate() {
        wishes += &format!("objective o{i} = {formula};\n");
    }
    let none = SourceFile::new("c", "");
    let mut program = lang::load(&SourceFile::new("m", model), &none).unwrap().program;
    let preferences = lang::load_preferences(&SourceFile::new("p", wishes), &mut program).unwrap();
    let settings = Settings { storage, scope, memory: 16 << 20, ..Settings::default() };
    let engine = Arc::new(AnyEngine::new(Arc::new(program), settings).unwrap());
    let mut analysis = Analysis::new(&engine, &Arc::new(preferences), Options::default());
    analysis.run(&mut |_| ()).unwrap();
    analysis
}

/// The model states from which the conjunction of some formulas is almost sure.
fn together(model: &str, formulas: &[&str]) -> BTreeSet<i64> {
    let conjunction = formulas.iter().map(|f| format!("({f})")).collect::<Vec<_>>().join(" & ");
    let analysis = analysed(model, "play", &[&conjunction], Storage::Explicit);
    let (engine, regions) = (analysis.engine(), analysis.outcomes().unwrap().get(0).unwrap());
    let start = engine.intersection(&engine.initial_states(), &regions.almost_sure).unwrap();
    engine.list_states(&start, 100).unwrap().iter().map(|state| state[0]).collect()
}

/// Returns the number of states and sets of which some were achieved together.
fn check(model: &str, history: &str, formulas: &[&str], storage: Storage) -> usize {
    let mut analysis = analysed(model, history, formulas, storage);
    analysis.run_jointly().unwrap();
    let program = Arc::clone(analysis.engine().program());
    let mut seen = 0;
    for prospects in analysis.initial_prospects(&program, 100).unwrap() {
        let members: Vec<usize> =
            prospects.most_preferred.iter().map(|name| name[1..].parse().unwrap()).collect();
        let found = prospects.jointly.unwrap();
        for bits in 1u32..1 << members.len() {
            let chosen: Vec<usize> =
                (0..members.len()).filter(|i| bits >> i & 1 == 1).map(|i| members[i]).collect();
            let texts: Vec<&str> = chosen.iter().map(|&i| formulas[i]).collect();
            let names: Vec<String> = chosen.iter().map(|i| format!("o{i}")).collect();
            let possible = found.iter().any(|set| names.iter().all(|name| set.contains(name)));
            let expected = together(model, &texts).contains(&prospects.state[0]);
            assert_eq!(possible, expected, "{names:?} from {:?}\n{model}", prospects.state);
            seen += usize::from(possible && names.len() > 1);
        }
    }
    if history == "state" {
        // All states are initial, so the counts of the classes are those of the initial states.
        let counted =
            analysis.result().classes.iter().flatten().flat_map(|class| class.jointly.iter().flatten());
        let counted: usize = counted.map(|joint| joint.states.to_string().parse::<usize>().unwrap()).sum();
        assert_eq!(counted, seen);
    }
    seen
}

#[test]
fn what_is_achieved_together_is_a_conjunction() {
    let seen = Cell::new([0, 0]);
    let config = Config { cases: 60, failure_persistence: None, ..Config::default() };
    let outcome = TestRunner::new(config).run(&drawn(), |(choices, formulas, _, history, _)| {
        let model = model(&choices);
        let kinds = if history { FORMULAS.len() } else { 2 };
        let mut chosen: Vec<&str> = formulas.iter().map(|f| FORMULAS[f % kinds]).collect();
        chosen.push("F s=0");
        let history = if history { "play" } else { "state" };
        for storage in [Storage::Symbolic, Storage::Explicit] {
            let mut counts = seen.get();
            counts[usize::from(history == "play")] += check(&model, history, &chosen, storage);
            seen.set(counts);
        }
        Ok(())
    });
    outcome.unwrap_or_else(|e| panic!("{e}"));
    assert!(seen.get().iter().all(|&n| n > 50), "too few sets are achieved together: {seen:?}");
}

#[test]
fn a_strategy_that_can_take_only_one_key_achieves_one_objective() {
    let model = "mdp module m s : [0..3] init 0; [left] s=0 -> (s'=1); [right] s=0 -> (s'=2); \
                 [both] s=3 -> (s'=0); endmodule";
    let mut analysis = analysed(model, "state", &["F s=1", "F s=2"], Storage::Symbolic);
    analysis.run_jointly().unwrap();
    let program = Arc::clone(analysis.engine().program());
    let [start] = &analysis.initial_prospects(&program, 9).unwrap()[..] else { panic!("one initial state") };
    assert_eq!(start.jointly, Some(vec![vec!["o0".to_owned()], vec!["o1".to_owned()]]));
}

/// A class with too many objectives must not hide the results of the others, nor end the command.
#[test]
fn a_class_with_too_many_objectives_leaves_the_others_their_results() {
    let model = "mdp module m s : [0..4] init 3; [left] s=0 -> (s'=1); [right] s=0 -> (s'=2); \
                 [go] s=3 -> (s'=0); [stay] s=4 -> true; endmodule";
    // From 0 and 3 the first two are sure, one at a time; in 4 the eleven others are.
    let formulas: Vec<String> = ["F s=1".to_owned(), "F s=2".to_owned()]
        .into_iter()
        .chain((0..11).map(|i| format!("F (s=4 & s>{i}-9)")))
        .collect();
    let texts: Vec<&str> = formulas.iter().map(String::as_str).collect();
    for storage in [Storage::Symbolic, Storage::Explicit] {
        let mut analysis = analysed_within(model, "state", &texts, storage, Scope::All);
        analysis.run_jointly().unwrap();
        let classes = analysis.result().classes.clone().unwrap();
        let large = classes.iter().find(|class| class.most_preferred.len() == 11).unwrap();
        assert_eq!((&large.jointly, large.jointly_limit), (&None, Some(10)));
        let others = classes.iter().filter(|class| class.most_preferred.len() < 11);
        assert!(others.clone().all(|class| class.jointly_limit.is_none() && class.jointly.is_some()));
        assert!(others.clone().any(|class| class.most_preferred.len() == 2));
        let program = Arc::clone(analysis.engine().program());
        let of = |state: i64| analysis.prospects(&program, &[state]).unwrap().jointly;
        assert_eq!(of(3), Some(vec![vec!["o0".to_owned()], vec!["o1".to_owned()]]));
        assert_eq!(of(4), None);
    }
}
