//! Each condition of `verify` alone: dumps that are right but for one fault. All that follows from the fault is
//! forged with it, so that a checker without the condition would accept the dump.

mod draft;
mod levels;
mod outcomes;
mod plays;
mod safe;
mod scope;
mod verdict;

use meliora::dump::Dump;
use meliora::engine::Scope;
use meliora::planning::Safety;

use crate::others::case;
use crate::verify::{Case, SAFETIES};
use draft::Draft;

const SCOPES: [Scope; 2] = [Scope::Reachable, Scope::All];
/// Objectives of the present state on, and over whole plays.
const HISTORIES: [&str; 2] = ["history = state;", "history = play;"];

/// A fault, and the condition that it violates.
struct Fault {
    condition: &'static str,
    forge: fn(&mut Draft),
}

/// The honest dumps of a model for each history, scope and safety of these.
fn cases(model: &str, preferences: &str, histories: &[&str], safeties: &[Safety]) -> Vec<(String, Case)> {
    let mut all = Vec::new();
    for history in histories {
        for scope in SCOPES {
            for &safety in safeties {
                let case = case(model, &format!("{preferences} {history}"), scope, safety);
                all.push((format!("{history} {} {safety}", scope.name()), case));
            }
        }
    }
    all
}

/// The honest dump is accepted as it is and as the draft writes it; with each fault it is refused.
fn refuse(cases: &[(String, Case)], faults: &[Fault]) {
    for (options, case) in cases {
        accepted(case, &case.dump, options);
        accepted(case, &Draft::of(&case.dump).dump(), options);
        for Fault { condition, forge } in faults {
            let mut draft = Draft::of(&case.dump);
            forge(&mut draft);
            refused(case, &draft.dump(), condition, options);
        }
    }
}

#[track_caller]
fn accepted(case: &Case, dump: &Dump, options: &str) {
    assert_eq!(case.verify(dump).unwrap().violation, None, "{options}");
}

#[track_caller]
fn refused(case: &Case, dump: &Dump, condition: &str, options: &str) {
    let violation = case.verify(dump).unwrap().violation;
    let violation = violation.unwrap_or_else(|| panic!("{options}: accepted, but not: {condition}"));
    assert_eq!(violation.condition, condition, "{options}");
}
