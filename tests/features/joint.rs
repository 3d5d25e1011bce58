//! Objectives that are achieved together, compared with one objective that is their conjunction.

use std::collections::BTreeSet;
use std::sync::Arc;

use meliora::engine::{Algebra, Engine, Settings};
use meliora::error::SourceFile;
use meliora::lang;
use meliora::model::State;
use proptest::test_runner::Config;

use crate::coverage::draw_until;
use crate::random_case::{RandomCase, random_case};
use crate::{Analysed, settings};

/// The number of variables of the model, which come before those of monitors.
fn width(case: &RandomCase) -> usize {
    let model = SourceFile::new("m.prism", case.model.as_str());
    lang::load(&model, &SourceFile::new("c", "")).unwrap().program.variables.len()
}

/// The initial states of the model from which the conjunction of some formulas is almost sure; nothing
/// if the conjunction is refused.
fn together(case: &RandomCase, formulas: &[usize], settings: Settings) -> Option<BTreeSet<State>> {
    let parts: Vec<String> = formulas.iter().map(|&f| format!("({})", case.formulas[f])).collect();
    let required: Vec<&str> = case.preferences.lines().filter(|line| line.starts_with("require")).collect();
    let wish = format!("history = play; objective all = {};\n{}", parts.join(" & "), required.join("\n"));
    let (model, wish) = (SourceFile::new("m", case.model.as_str()), SourceFile::new("p", wish));
    let program = lang::load(&model, &SourceFile::new("c", "")).unwrap().program;
    let lang::Question { program, preferences } = lang::load_preferences(&wish, program).ok()?;
    let of = Analysed::new((&Arc::new(program), &Arc::new(preferences)), settings, case.safety);
    let (engine, regions) = (of.analysis.engine(), of.analysis.outcomes().unwrap().get(0).unwrap());
    let starts = engine.intersection(&engine.initial_states(), &regions.almost_sure).unwrap();
    let states = engine.list_states(&starts, usize::MAX).unwrap();
    Some(states.iter().map(|state| state[..width(case)].into()).collect())
}

/// Returns the number of initial states and sets of at least two objectives that are achieved together.
fn check(case: &RandomCase, settings: &Settings) -> usize {
    let (program, preferences) = case.load();
    let mut of = Analysed::new((&program, &preferences), settings.clone(), case.safety);
    of.analysis.run_jointly(&mut |_| ()).unwrap();
    let mut seen = 0;
    for bits in 1u32..1 << case.formulas.len() {
        let chosen: Vec<usize> = (0..case.formulas.len()).filter(|i| bits >> i & 1 == 1).collect();
        let Some(expected) = together(case, &chosen, settings.clone()) else { continue };
        let names: Vec<String> = chosen.iter().map(|i| format!("o{i}")).collect();
        for prospects in of.analysis.initial_prospects(&program, 100).unwrap() {
            if names.iter().all(|name| prospects.most_preferred.contains(name)) {
                let found = prospects.jointly.unwrap();
                let possible = found.iter().any(|set| names.iter().all(|name| set.contains(name)));
                let state = &prospects.state[..width(case)];
                assert_eq!(possible, expected.contains(state), "{names:?} from {state:?}");
                seen += usize::from(possible && names.len() > 1);
            }
        }
    }
    seen
}

#[test]
fn objectives_are_achieved_together_where_their_conjunction_is() {
    let config = Config { source_file: Some(file!()), ..crate::amount::random(60) };
    // Sets of several objectives that are achieved together.
    let enough = |seen: &usize| *seen > 20;
    draw_until(&config, &random_case(), enough, |case, seen| {
        let [symbolic, explicit, _] = settings(&case);
        *seen += check(&case, &symbolic) + check(&case, &explicit);
    });
}
