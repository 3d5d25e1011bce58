//! Every dump is accepted, with its bounds of quantities.

use std::sync::Arc;

use meliora::certify::{Hashes, verify};
use meliora::engine::SymbolicEngine;
use meliora::export::bounds::{Wanted, add};
use meliora::export::{DumpContent, Inputs, export};
use meliora::planning::{Analysis, Kind, Options};
use meliora::quantities::Earned;
use proptest::prelude::*;

use crate::random_case::{REWARDS, RandomCase, random_case};
use crate::{config, settings};

const HASHES: Hashes<'static> = Hashes { model: "m", preferences: "p" };

/// Returns whether the dump had bounds of quantities.
fn check(case: &RandomCase) -> bool {
    let (program, preferences) = case.load();
    let [settings, ..] = settings(case);
    let engine = Arc::new(SymbolicEngine::new(Arc::clone(&program), settings.clone()).unwrap());
    let options = Options { safety: case.safety, max_level: None };
    let mut analysis = Analysis::new(&engine, &preferences, options);
    analysis.run(&mut |_| ()).unwrap();
    let named = |hash: &str| ("file".to_owned(), hash.to_owned());
    let inputs = Inputs { model: named(HASHES.model), preferences: named(HASHES.preferences) };
    let mut dump = export(&analysis, &inputs, &DumpContent { wanted: &|_| true, certificate: true }).unwrap();
    let has_values = !analysis.levels(Kind::Spi).found.is_empty();
    if has_values {
        let structure = &program.rewards[program.reward_structure(Some(REWARDS)).unwrap()];
        let costs = Earned { program: &program, structure };
        let wanted = Wanted { levels: 2, reward: REWARDS, costs: &costs, limit: 10_000, precision: 1e-6 };
        add(&mut dump, &analysis, &wanted).unwrap();
    }
    let verdict = verify(&program, &preferences, HASHES, &dump, settings).unwrap();
    assert_eq!(verdict.violation, None);
    has_values
}

proptest! {
    #![proptest_config(config(100))]

    #[test]
    fn every_dump_is_accepted_with_its_values(case in random_case()) {
        check(&case);
    }
}
