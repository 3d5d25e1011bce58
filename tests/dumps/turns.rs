//! Rounds of models whose variables return to their values: machines that work, break and are repaired.

use meliora::certify::Verdict;
use meliora::dump::manifest::Digit;

use crate::common::factory::{PREFERENCES, factory};
use crate::common::prelude::*;

const HASHES: Hashes<'static> = Hashes { model: "m", preferences: "p" };

/// Returns the dump of a model, and its verifier.
fn dump(model: String, wishes: &str, safety: Safety) -> (Dump, impl Fn(&Dump) -> Verdict) {
    let (program, preferences) = task(model, wishes);
    let settings = || Settings { memory: 256 << 20, ..Settings::default() };
    let engine = Arc::new(SymbolicEngine::new(Arc::clone(&program), settings()).unwrap());
    let analysis = finished(&engine, &preferences, Options { safety, max_level: None });
    let inputs = Inputs {
        model: ("m".into(), HASHES.model.into()),
        preferences: ("p".into(), HASHES.preferences.into()),
    };
    let dump = export(&analysis, &inputs, &DumpContent { wanted: &|_| true, certificate: true }).unwrap();
    (dump, move |dump: &Dump| verify(&program, &preferences, HASHES, dump, settings()).unwrap())
}

/// Returns the order of rounds.
fn order(dump: &mut Dump) -> &mut Vec<Digit> {
    &mut dump.manifest.certificate.as_mut().unwrap().order_of_rounds
}

/// Returns the numbers of rounds of the two objectives that are lost nearly everywhere, and the nodes of the largest.
fn rounds(dump: &Dump) -> ([usize; 2], usize) {
    let roots = &dump.manifest.certificate.as_ref().unwrap().roots;
    let of = |name: &str| roots.iter().filter(|root| root.name.starts_with(name)).collect::<Vec<_>>();
    let both = ["refuted:almost-sure:Collapse:", "refuted:almost-sure:Worn:"].map(of);
    let most = both.iter().flatten().map(|root| root.nodes).max().unwrap();
    (both.map(|rounds| rounds.len()), most)
}

#[test]
fn rounds_of_machines_that_break_and_are_repaired_do_not_grow_with_their_number() {
    let sizes = [4, 8, 12].map(|machines| {
        let (dump, verify) = dump(factory(machines), PREFERENCES, Safety::Action);
        assert_eq!(verify(&dump).violation, None, "{machines}");
        let (numbers, most) = rounds(&dump);
        assert_eq!(numbers, [2, 2], "{machines}");
        most
    });
    // Three times as many machines have at most six times as many nodes.
    assert!(sizes[2] <= 6 * sizes[0], "{sizes:?}");
}

#[test]
fn only_the_order_of_the_values_proves_these_rounds() {
    for safety in Safety::ALL {
        let (dump, verify) = dump(factory(3), PREFERENCES, *safety);
        assert_eq!(verify(&dump).violation, None, "{safety}");
        let mut others = vec![dump.clone(); 3];
        order(&mut others[0]).iter_mut().for_each(|digit| digit.values.clear());
        order(&mut others[1]).iter_mut().for_each(|digit| digit.values.reverse());
        order(&mut others[2]).reverse();
        for other in &others {
            let violation = verify(other).violation.expect("a round with another order");
            assert!(
                violation.condition.to_string().contains("has a safe step out of the round"),
                "{}",
                violation.condition
            );
        }
    }
}

/// The order of the values is idle, busy and then done, whatever their numbers are: done is 2, busy 1, idle 0,
/// and the last one is broken, 3.
#[test]
fn values_are_ordered_by_the_steps_that_each_choice_may_take() {
    let (mut dump, _) = dump(factory(2), PREFERENCES, Safety::Action);
    for digit in
        order(&mut dump).iter().filter(|digit| digit.variable.starts_with('s') && digit.variable != "shipped")
    {
        assert_eq!(digit.values, [2, 1, 0, 3], "{}", digit.variable);
    }
}

/// A model whose values need no order of their own has the dump that it had before.
#[test]
fn natural_values_need_no_order_of_rounds() {
    let model =
        "mdp module m x:[0..3] init 0; [a] x<3 -> 0.5:(x'=x+1) + 0.5:(x'=3); [b] x=3 -> true; endmodule";
    let (mut dump, verify) =
        dump(model.to_owned(), "objective A = F x=2; objective B = F x=1; prefer A > B;", Safety::Action);
    assert_eq!(verify(&dump).violation, None);
    assert!(order(&mut dump).is_empty());
}
