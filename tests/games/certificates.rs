//! Certificates of the values of games: they are confirmed, they contain the values over all pairs of pure strategies, and
//! no bound that is moved past a value is confirmed.

use meliora::dump::bounds::{Bounds, Number, Row};
use meliora::export::bounds::{Wanted, add};
use num_traits::ToPrimitive;
use proptest::prelude::*;

use super::levels::{Case, Reference, some_case};
use super::raw::loaded;
use super::values::{LEVELS, levels};
use super::{settings, thresholds};
use crate::common::prelude::*;

const HASHES: Hashes<'static> = Hashes { model: "m", preferences: "p" };

/// The values of a row: P_1, P_2, … and C_1, C_2, …, as far as they exist.
type Truth = [Vec<Option<Ratio>>; 2];

fn contains(bounds: Option<&Bounds>, value: Option<&Ratio>) -> bool {
    let (Some(bounds), Some(value)) = (bounds, value) else { return bounds.is_none() && value.is_none() };
    bounds.lower.exact().is_some_and(|lower| lower <= *value)
        && bounds.upper.exact().is_none_or(|upper| *value <= upper)
}

fn is_true(row: &Row, truth: &Truth) -> bool {
    let [chances, costs] = truth;
    row.probabilities.iter().zip(chances).all(|(p, value)| contains(Some(p), value.as_ref()))
        && row.costs.iter().zip(costs).all(|(c, value)| contains(c.as_ref(), value.as_ref()))
}

/// Moves one bound past the value, by a little or by a lot, with a rank that is great enough.
fn moved(dump: &Dump, truth: &[Truth], at: usize, by: f64) -> Option<Dump> {
    let mut dump = dump.clone();
    let rows = dump.values.as_mut()?;
    let row = at % rows.len().max(1);
    let levels = rows.first()?.costs.len();
    let (k, is_cost, is_lower) = (at / 64 % levels, at / 256 % 2 == 1, at / 512 % 2 == 1);
    let (own, truth) = (rows.get_mut(row)?, &truth[row]);
    let bounds = if is_cost { own.costs[k].as_mut()? } else { &mut own.probabilities[k] };
    let value = truth[usize::from(is_cost)][k].as_ref()?.to_f64()?;
    bounds.rank = 99;
    match is_lower {
        true => bounds.lower = Number::Double(value + by),
        false => bounds.upper = Number::Double((value - by).max(0.0)),
    }
    Some(dump)
}

fn check(case: &Case, safety: Safety, moves: &[(usize, f64)]) -> Result<(), TestCaseError> {
    let (program, preferences) = loaded(&case.raw.text(), &case.preferences());
    let settings = || settings(Scope::All, thresholds()[0]);
    let engine = Arc::new(SymbolicEngine::new(Arc::clone(&program), settings()).unwrap());
    let analysis = finished(&engine, &preferences, Options { safety, ..Options::default() });
    if analysis.levels(Kind::Spi).found.is_empty() {
        return Ok(());
    }
    let named = |hash: &str| ("file".to_owned(), hash.to_owned());
    let inputs = Inputs { model: named(HASHES.model), preferences: named(HASHES.preferences) };
    let content = DumpContent { wanted: &|_| true, certificate: true };
    let mut dump = export(&analysis, &inputs, &content).unwrap();
    let wanted = Wanted { levels: LEVELS, reward: "steps", costs: &Steps, limit: 100 };
    let width = add(&mut dump, &analysis, &wanted).unwrap();
    prop_assert!(width <= 1e-6, "{} {:?} {:?}", width, case, dump.values);
    let judge = |dump: &Dump| verify(&program, &preferences, HASHES, dump, settings()).unwrap().violation;
    prop_assert_eq!(judge(&dump), None, "{:?}", case);
    let truth = truth(case, &analysis, &dump);
    let is_right = |dump: &Dump| dump.values.iter().flatten().zip(&truth).all(|(row, t)| is_true(row, t));
    prop_assert!(is_right(&dump), "{:?} {:?}", case, dump.values);
    for &(at, by) in moves {
        let Some(wrong) = moved(&dump, &truth, at, by) else { continue };
        prop_assert!(judge(&wrong).is_some() || is_right(&wrong), "{:?} {:?}", case, wrong.values);
    }
    Ok(())
}

/// The values of all rows: without arenas those over all pairs of strategies, else those of an exact computation.
fn truth(case: &Case, analysis: &Analysis<SymbolicEngine>, dump: &Dump) -> Vec<Truth> {
    let rows = dump.values.as_deref().unwrap_or_default();
    if analysis.options().safety == Safety::Action {
        let known = levels(&Reference::new(case));
        let of = |row: &Row, at: usize| {
            let state = row.state[0] as usize;
            known.iter().map(|level| level[at][state].clone()).collect()
        };
        return rows.iter().map(|row| [of(row, 0), of(row, 1)]).collect();
    }
    let starts: Vec<Vec<i64>> = rows.iter().map(|row| row.state.clone()).collect();
    let options = ValueOptions { levels: LEVELS, exact: true, within: None };
    let program = analysis.engine().program();
    let values = Values::compute(options, analysis, program, &starts, &Steps).unwrap();
    let arenas = &analysis.improvement().unwrap().arenas;
    let named = |class: Option<usize>| {
        let class = &analysis.classes().unwrap().list[class.unwrap()].most_preferred;
        let names = analysis.preferences().names(class).join("+");
        if names.is_empty() { "nothing".to_owned() } else { names }
    };
    let of = |row: &Row| {
        let arena = arenas.iter().position(|arena| named(arena.reference) == row.arena);
        let node = values.node(arena, &row.state).unwrap();
        let p = (1..=LEVELS).map(|k| values.probability(node, k).exact).collect();
        [p, (1..=LEVELS).map(|k| values.cost(node, k).map(|cost| cost.exact.unwrap())).collect()]
    };
    rows.iter().map(of).collect()
}

proptest! {
    #![proptest_config(crate::common::amount::random(100))]

    #[test]
    fn certificates_of_values_are_right_and_none_is_that_is_moved(
        case in some_case(),
        moves in prop::collection::vec((0..1024usize, prop::sample::select(&[1e-9, 0.01, 0.3][..])), 8),
    ) {
        for safety in [Safety::Action, Safety::Prefix] {
            check(&case, safety, &moves)?;
        }
    }
}
