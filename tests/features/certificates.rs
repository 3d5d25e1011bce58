//! Every dump is accepted, with its bounds of quantities. A dump of which a limit ended the certificate has the parts that
//! were finished.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

use meliora::certify::{Hashes, verify};
use meliora::engine::{Settings, SymbolicEngine};
use meliora::error::Limit;
use meliora::export::bounds::{Wanted, add};
use meliora::export::{DumpContent, Inputs, certify, export};
use meliora::planning::{Analysis, Kind, Options};
use meliora::progress::ProgressSink;
use meliora::quantities::Earned;
use proptest::prelude::*;
use proptest::test_runner::Config;

use crate::coverage::draw_until;
use crate::random_case::{REWARDS, RandomCase, random_case};
use crate::settings;

const HASHES: Hashes<'static> = Hashes { model: "m", preferences: "p" };

fn inputs() -> Inputs {
    let named = |hash: &str| ("file".to_owned(), hash.to_owned());
    Inputs { model: named(HASHES.model), preferences: named(HASHES.preferences) }
}

/// A limit that can be lifted.
#[derive(Default)]
struct Share(AtomicBool);

impl ProgressSink for Share {
    fn stop(&self) -> Option<Limit> {
        self.0.load(Relaxed).then_some(Limit::Time(Duration::ZERO))
    }
}

/// Ends one part of the certificate, counted from the last: regions that are not proved are named, and the others are
/// accepted. Returns whether the limit came in time.
fn check_without(case: &RandomCase, part: usize) -> bool {
    let (program, preferences) = case.load();
    let [settings, ..] = settings(case);
    let sink = Arc::new(Share::default());
    let limited = Settings { sink: Arc::clone(&sink) as _, ..settings.clone() };
    let engine = Arc::new(SymbolicEngine::new(Arc::clone(&program), limited).unwrap());
    let mut analysis = Analysis::new(&engine, &preferences, Options { safety: case.safety, max_level: None });
    analysis.run(&mut |_| ()).unwrap();
    let content = DumpContent { wanted: &|_| true, certificate: false };
    let mut dump = export(&analysis, &inputs(), &content).unwrap();
    let limit = certify(&mut dump, &analysis, &mut |left| sink.0.store(left == Some(part), Relaxed)).unwrap();
    let verdict = verify(&program, &preferences, HASHES, &dump, settings).unwrap();
    assert_eq!(verdict.violation, None);
    assert_eq!(verdict.is_accepted(), limit.is_none());
    let uncertified = &dump.manifest.certificate.as_ref().unwrap().uncertified;
    assert_eq!(&verdict.uncertified, uncertified);
    let proved = verdict.checked.iter().filter(|checked| checked.inside && checked.outside);
    let named: BTreeSet<_> = proved.map(|checked| &checked.region).chain(uncertified).collect();
    let missing = dump.manifest.regions.roots.iter().find(|root| !named.contains(&root.name));
    assert!(missing.is_none(), "{missing:?}");
    limit.is_some()
}

/// Returns whether the dump had bounds of quantities.
fn check(case: &RandomCase) -> bool {
    let (program, preferences) = case.load();
    let [settings, ..] = settings(case);
    let engine = Arc::new(SymbolicEngine::new(Arc::clone(&program), settings.clone()).unwrap());
    let options = Options { safety: case.safety, max_level: None };
    let mut analysis = Analysis::new(&engine, &preferences, options);
    analysis.run(&mut |_| ()).unwrap();
    let content = DumpContent { wanted: &|_| true, certificate: true };
    let mut dump = export(&analysis, &inputs(), &content).unwrap();
    let has_values = !analysis.levels(Kind::Spi).found.is_empty();
    if has_values {
        let structure = &program.rewards[program.reward_structure(Some(REWARDS)).unwrap()];
        let costs = Earned { program: &program, structure };
        let wanted = Wanted { levels: 2, reward: REWARDS, costs: &costs, limit: 10_000 };
        add(&mut dump, &analysis, &wanted).unwrap();
    }
    let verdict = verify(&program, &preferences, HASHES, &dump, settings).unwrap();
    assert_eq!(verdict.violation, None);
    has_values
}

proptest! {
    #![proptest_config(crate::amount::random(100))]

    #[test]
    fn every_dump_is_accepted_with_its_values(case in random_case()) {
        check(&case);
    }
}

#[test]
fn a_limit_leaves_the_finished_parts_of_a_certificate() {
    let config = Config { source_file: Some(file!()), ..crate::amount::random(100) };
    let enough = |ended: &usize| *ended > 10;
    draw_until(&config, &(random_case(), 1..=8_usize), enough, |(case, part), ended| {
        *ended += usize::from(check_without(&case, part));
    });
}
