//! Temporal formulas whose regions are known: both engines.

use meliora::advanced::lang::ltl::{Monitoring, parse_formula};
use meliora::model::temporal::{Begin, Condition};

use crate::common::prelude::*;

/// Pmax = 1, Pmax > 0, Pmin = 1, Pmin > 0 of a property, each as the number of states of `start`.
fn counts<E: Engine>(engine: &E, condition: &Condition, start: &E::States) -> [String; 4] {
    let found = RegionSearch::of_condition(engine, condition).all().unwrap();
    [&found.pmax_one, &found.pmax_positive, &found.pmin_one, &found.pmin_positive]
        .map(|x| engine.count(&engine.intersection(x, start).unwrap()).unwrap().to_string())
}

/// Returns the verdicts in the initial state, or in all states: those in which monitors, if there are any,
/// are fresh.
fn judged<E: Engine>(
    engine: &E,
    condition: &Condition,
    fresh: Option<&Predicate>,
    initial: bool,
) -> [String; 4] {
    let start = match fresh {
        _ if initial => engine.initial_states(),
        Some(fresh) => engine.states_where(fresh).unwrap(),
        None => engine.all_states(),
    };
    counts(engine, condition, &start)
}

/// The condition of a formula; none where the formula exceeds a limit.
pub(crate) fn watched(
    watching: &mut Monitoring<'_>,
    source: &Arc<SourceFile>,
    formula: &meliora::advanced::lang::ltl::Formula,
) -> Option<Condition<ExprId>> {
    match watching.watch(source, formula, "w") {
        Ok(condition) => Some(condition),
        Err(error) => {
            let text = error.to_string();
            let is_limit = matches!(error, Error::Limit(_)) || text.contains("cases over its");
            assert!(is_limit, "{}: {text}", source.text);
            None
        }
    }
}

/// The answers of both engines: in the initial state, or in all states. None where the formula exceeds a limit.
fn answers(program: Program, formula: &str, initial: bool) -> Option<[[String; 4]; 2]> {
    let source = SourceFile::new("formula", formula);
    let mut watching = Monitoring::new(&program);
    let condition = watched(&mut watching, &source, &parse_formula(&source).unwrap())?;
    let program = watching.finish(Begin::Everywhere).unwrap();
    let condition = condition.map(&|mark| program.predicate(mark));
    let fresh = program.monitors.as_ref().map(|monitors| program.predicate(monitors.fresh));
    let (symbolic, explicit) = engines(program);
    let fresh = fresh.as_ref();
    Some([judged(&*symbolic, &condition, fresh, initial), judged(&*explicit, &condition, fresh, initial)])
}

fn engines(program: Program) -> (Arc<SymbolicEngine>, Arc<ExplicitEngine>) {
    let program = Arc::new(program);
    let settings = Settings { memory: 16 << 20, ..Settings::default() };
    let symbolic = SymbolicEngine::new(Arc::clone(&program), settings.clone()).unwrap();
    (Arc::new(symbolic), Arc::new(ExplicitEngine::new(program, settings).unwrap()))
}

fn at_start<E: Engine>(engine: &Arc<E>, program: &Program, preferences: &Arc<Preferences>) -> bool {
    let analysis = finished(engine, preferences, Options { safety: Safety::Action, max_level: None });
    !analysis.initial_prospects(program, 1).unwrap()[0].most_preferred.is_empty()
}

/// Obligations that are fulfilled in the step in which the next one comes up.
#[test]
fn what_is_owed_may_be_fulfilled_as_new_obligations_come_up() {
    let text = "mdp\nmodule m\n  s : [0..1] init 0;\n  [] true -> (s'=0);\n  [] true -> (s'=1);\nendmodule\n\
        label \"p\" = s=1;\n";
    let program = load(text);
    for (formula, expected) in [
        ("G ((X p) => (F p))", ["2", "2", "2", "2"]),
        ("G ((F p) | (X !p))", ["2", "2", "2", "2"]),
        ("G (X ((F p) | (F !p)))", ["2", "2", "2", "2"]),
        ("G ((X F p) | (X X F !p))", ["2", "2", "2", "2"]),
        ("G ((F p) | (X X !p))", ["2", "2", "2", "2"]),
        ("X (F ((G !p) & (X p)))", ["0", "0", "0", "0"]),
        ("F (G ((!p) & (X p)))", ["0", "0", "0", "0"]),
        ("(G F p) & (G ((X p) => (F p)))", ["2", "2", "0", "0"]),
        ("(F ((G>=1 !p) & (X p))) | !(F !p)", ["1", "1", "0", "0"]),
        ("(X F ((G !p) & (!p | (p R p)))) | (X p)", ["2", "2", "0", "0"]),
    ] {
        let formula = formula.replace('p', "\"p\"");
        let found = answers(program.clone(), &formula, false).unwrap();
        assert_eq!(found, [expected, expected].map(|row| row.map(String::from)), "{formula}");
    }
}

fn load(model: &str) -> Program {
    parsed(model)
}

/// One of two recurrences loses states while the other one is unchanged in its first round.
#[test]
fn each_recurrence_is_asked_for_again_when_another_one_loses_states() {
    let model = "mdp module m s:[0..2] init 0; [a] s=0 -> 0.5:(s'=1) + 0.5:(s'=2); [b] s=0 -> true;
        [] s=1 -> (s'=0); [] s=2 -> true; endmodule";
    for (formula, expected) in
        [("(G F s!=1) & (G F (s>0 & s<2))", ["0", "0", "0", "0"]), ("G F s!=1", ["3", "3", "3", "3"])]
    {
        let found = answers(load(model), formula, false).unwrap();
        assert_eq!(found, [expected, expected].map(|row| row.map(String::from)), "{formula}");
    }
}

#[test]
fn brackets_of_arithmetic_stand_beside_temporal_formulas() {
    let model = "mdp module m s:[0..3] init 0; [] s<3 -> (s'=s+1); endmodule";
    for formula in [
        "((s+1)*2=2) & (F s=3)",
        "(s+1)*2=2 & (F s=3)",
        "(F s=3) & (s+1)*2=2",
        "((s+1)*2=2 & (F s=3))",
        "(2*(s+1)=2) & (X ((s+1)*(1+1)=4))",
    ] {
        let found = answers(load(model), formula, false).unwrap();
        assert_eq!(found, [["1"; 4], ["1"; 4]].map(|row| row.map(String::from)), "{formula}");
    }
}

/// An objective may have the name of a variable: its monitor gets another one.
#[test]
fn an_objective_may_be_called_as_a_variable_is() {
    let program = load("mdp module m s:[0..1] init 0; [] true -> (s'=1-s); endmodule");
    let text = SourceFile::new("p", "objective s = G (s=0 => X s=1);");
    let lang::Task { program, preferences } = lang::load_preferences(&text, program).unwrap();
    let preferences = Arc::new(preferences);
    let names: std::collections::BTreeSet<&String> = program.variables.iter().map(|v| &v.name).collect();
    assert_eq!(names.len(), program.variables.len(), "{names:?}");
    let (symbolic, explicit) = engines(program.clone());
    assert!(at_start(&symbolic, &program, &preferences) && at_start(&explicit, &program, &preferences));
}

#[test]
fn bounds_and_constants_have_their_meaning() {
    let model = "mdp module m s:[0..3] init 0; [] s<3 -> (s'=s+1); endmodule";
    for (formula, states) in [
        ("F<=0 s=0", "1"),
        ("G<=0 s=0", "1"),
        ("(s<2) U[2,5] true", "1"),
        ("!((s<2) U[2,5] true)", "3"),
        ("((F s=3) & (G s>0)) | false", "3"),
        ("((F s=0) | (G s>1)) & true", "3"),
        ("!(((F s=3) & (G s>0)) | false)", "1"),
    ] {
        let found = answers(load(model), formula, false).unwrap();
        assert_eq!(found, [[states; 4], [states; 4]].map(|row| row.map(String::from)), "{formula}");
    }
}
