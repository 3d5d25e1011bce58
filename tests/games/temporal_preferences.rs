//! Preferences over temporal objectives of games: outcomes against the regions of each formula, and against the
//! model with one player.

use proptest::prelude::*;
use proptest::sample::select;

use super::raw::{loaded, program};
use super::temporal::{REFUSED, analysed, formula, game};
use super::{settings, thresholds};
use crate::common::prelude::*;

/// Preferences over three formulas, with a requirement.
fn preferences(formulas: &[String], required: &str) -> String {
    let objective = |(i, formula): (usize, &String)| format!("objective o{i} = {formula};\n");
    let objectives: String = formulas.iter().enumerate().map(objective).collect();
    format!("history = play;\n{objectives}prefer o0 > o1;\nprefer o0 > o2;\n{required}")
}

/// Reads a game and preferences; `None` if some formula is refused.
fn accepted(text: &str, preferences: &str) -> Option<(Arc<Program>, Arc<Preferences>)> {
    match meliora::lang::load_preferences(&SourceFile::new("preferences", preferences), program(text)) {
        Ok(_) => Some(loaded(text, preferences)),
        Err(Error::Input(all)) => {
            assert!(
                all.iter().all(|d| d.message.starts_with(REFUSED) || d.message.contains("cases over its"))
            );
            None
        }
        Err(other) => panic!("{other}"),
    }
}

proptest! {
    #![proptest_config(meliora_amount::random(300))]

    /// The objectives that we can enforce grow with each move of the opponent, so none weakens.
    #[test]
    fn outcomes_are_those_of_the_formulas_and_the_opponent_never_weakens(
        (raw, labels) in game(6, 2),
        formulas in [formula(), formula(), formula()],
        required in select(vec!["", "require G (x!=5);", "require (x!=5) W \"q\";", "require G (\"p\" => X (x!=4));"]),
    ) {
        let Some((program, preferences)) =
            accepted(&(raw.text() + &labels), &preferences(&formulas, required)) else { return Ok(()) };
        for safety in [Safety::Action, Safety::Prefix] {
            let own = settings(Scope::Reachable, thresholds()[0]);
            let explicit = ExplicitEngine::new(program.clone(), own.clone()).unwrap();
            let (explicit, result) = analysed(explicit, &preferences, safety);
            let symbolic = SymbolicEngine::new(program.clone(), own).unwrap();
            prop_assert_eq!(&result, &analysed(symbolic, &preferences, safety).1);
            let engine = explicit.engine();
            for (i, objective) in preferences.objectives.iter().enumerate() {
                let regions = explicit.outcomes().unwrap().get(i).unwrap();
                let Goal::Satisfy { condition, .. } = &objective.goal else { panic!() };
                let found = RegionSearch::of_condition(engine, condition).all().unwrap();
                prop_assert!(engine.same(&found.pmax_one, &regions.almost_sure).unwrap());
                prop_assert!(engine.same(&found.pmax_positive, &regions.positive).unwrap());
                if let Some(theirs) = engine.theirs() {
                    let own = engine.choices_in(&engine.all_choices(), &theirs).unwrap();
                    let own = engine.choices_in(&own, &regions.almost_sure).unwrap();
                    let left = engine.difference(&engine.post(&own).unwrap(), &regions.almost_sure).unwrap();
                    prop_assert!(engine.is_empty(&left).unwrap());
                }
            }
            let classes = explicit.classes().unwrap();
            for class in &classes.list {
                let Some(theirs) = engine.theirs() else { continue };
                let own = engine.choices_in(&engine.all_choices(), &theirs).unwrap();
                let own = engine.choices_in(&own, &class.states).unwrap();
                let worse = engine.intersection(&engine.post(&own).unwrap(), &class.worse).unwrap();
                prop_assert!(engine.is_empty(&worse).unwrap());
            }
        }
    }
}
