//! Tests in which one condition of `verify` fails alone. Each dump has one fault. All sets that follow from the
//! fault are changed with it, so that a checker without the condition would accept the dump.

mod draft;
mod games;
mod levels;
mod outcomes;
mod plays;
mod safe;
mod scope;
mod trends;
mod verdict;

use draft::Draft;

use crate::common::prelude::*;
use crate::dumps::others::case;
use crate::dumps::verify::Case;

pub(super) const SCOPES: [Scope; 2] = [Scope::Reachable, Scope::All];
/// Objectives are judged from the present state on, or over whole paths.
const HISTORIES: [&str; 2] = ["history = state;", "history = play;"];

/// A condition, and a fault that violates it.
type Fault = (&'static str, fn(&mut Draft));

/// Honest dumps of a model, each with its options.
struct Cases(Vec<(String, Case)>);

/// Makes the honest dumps of a model for each of these histories, each scope and each of these safety modes.
fn cases(model: &str, preferences: &str, histories: &[&str], safeties: &[Safety]) -> Cases {
    let mut all = Vec::new();
    for history in histories {
        for scope in SCOPES {
            for &safety in safeties {
                let case = case(model, &format!("{preferences} {history}"), scope, safety);
                all.push((format!("{history} {} {safety}", scope.name()), case));
            }
        }
    }
    Cases(all)
}

impl Cases {
    /// Checks that the honest dumps are accepted, also as the draft writes them, and refused with each fault.
    fn refuse(&self, faults: &[Fault]) {
        // By default, each fault occurs under a third of the options, in all modes.
        let step = self.0.len().min(3);
        for (at, (options, case)) in self.0.iter().enumerate() {
            let turn = at + at / 3;
            if takes_one_of(step, turn) {
                accepted(case, &case.dump, options);
                accepted(case, &Draft::of(&case.dump).dump(), options);
            }
            for (_, (condition, forge)) in
                faults.iter().enumerate().filter(|(of, _)| takes_one_of(step, turn + of))
            {
                let mut draft = Draft::of(&case.dump);
                forge(&mut draft);
                refused(case, &draft.dump(), condition, options);
            }
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
    assert_eq!(violation.condition.to_string(), condition, "{options}");
}
