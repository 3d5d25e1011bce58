//! Objectives that are achieved together: cases made by hand.

use crate::common::prelude::*;

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
    let (program, preferences) = task(model, wishes);
    let settings = Settings { storage, scope, memory: 16 << 20, ..Settings::default() };
    let engine = Arc::new(AnyEngine::new(program, settings).unwrap());
    finished(&engine, &preferences, Options::default())
}

#[test]
fn a_strategy_that_can_take_only_one_key_achieves_one_objective() {
    let model = "mdp module m s : [0..3] init 0; [left] s=0 -> (s'=1); [right] s=0 -> (s'=2); \
                 [both] s=3 -> (s'=0); endmodule";
    let mut analysis = analysed(model, "state", &["F s=1", "F s=2"], Storage::Symbolic);
    analysis.run_jointly(&mut |_| ()).unwrap();
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
        analysis.run_jointly(&mut |_| ()).unwrap();
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
