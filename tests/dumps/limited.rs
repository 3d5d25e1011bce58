//! Dumps whose certificate lacks parts, because a limit ended them.

use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

use meliora::certify::Verdict;
use meliora::dump::directory::{complete_directory, write_regions_first};
use meliora::export::certify;
use meliora::progress::ProgressSink;

use crate::common::factory::{OVER_PATHS, PREFERENCES, factory};
use crate::common::prelude::*;

const HASHES: Hashes<'static> = Hashes { model: "m", preferences: "p" };

/// A limit that can be lifted.
#[derive(Default)]
struct Share(AtomicBool);

impl ProgressSink for Share {
    fn stop(&self) -> Option<Limit> {
        self.0.load(Relaxed).then_some(Limit::Time(Duration::ZERO))
    }
}

struct Case {
    program: Arc<Program>,
    preferences: Arc<Preferences>,
    sink: Arc<Share>,
    analysis: Analysis<SymbolicEngine>,
    regions: Dump,
}

impl Case {
    fn new(wishes: &str, safety: Safety) -> Self {
        let (program, preferences) = task(factory(3), wishes);
        let sink = Arc::new(Share::default());
        let settings = Settings { sink: Arc::clone(&sink) as _, ..Settings::default() };
        let engine = Arc::new(SymbolicEngine::new(Arc::clone(&program), settings).unwrap());
        let analysis = finished(&engine, &preferences, Options { safety, max_level: None });
        let inputs = Inputs {
            model: ("m".into(), HASHES.model.into()),
            preferences: ("p".into(), HASHES.preferences.into()),
        };
        let content = DumpContent { wanted: &|_| true, certificate: false };
        let regions = export(&analysis, &inputs, &content).unwrap();
        Case { program, preferences, sink, analysis, regions }
    }

    /// Returns the dump without one part, by the number of parts left with it, and whether a limit ended that part.
    fn without(&self, part: usize) -> (Dump, bool) {
        let mut dump = self.regions.clone();
        let mut share = |left| self.sink.0.store(left == Some(part), Relaxed);
        let limit = certify(&mut dump, &self.analysis, &mut share).unwrap();
        (dump, limit.is_some())
    }

    fn verify(&self, dump: &Dump) -> Verdict {
        verify(&self.program, &self.preferences, HASHES, dump, Settings::default()).unwrap()
    }
}

fn uncertified(dump: &mut Dump) -> &mut Vec<String> {
    &mut dump.manifest.certificate.as_mut().unwrap().uncertified
}

#[test]
fn what_a_limit_ends_is_not_certified_and_all_else_is() {
    for (wishes, safety) in
        [(PREFERENCES, Safety::Action), (PREFERENCES, Safety::Prefix), (OVER_PATHS, Safety::Action)]
    {
        let case = Case::new(wishes, safety);
        let mut ended = 0;
        for part in (1..=10).filter(|part| takes_one_of(3, part + wishes.len() + safety as usize)) {
            let (mut dump, is_limited) = case.without(part);
            let verdict = case.verify(&dump);
            assert_eq!(verdict.violation, None, "{safety:?} {part}");
            assert_eq!(verdict.is_accepted(), !is_limited);
            assert_eq!(&verdict.uncertified, uncertified(&mut dump));
            let whole = verdict.checked.iter().filter(|checked| checked.inside && checked.outside);
            let named =
                whole.map(|checked| &checked.region).chain(&verdict.uncertified).collect::<BTreeSet<_>>();
            let missing = dump.manifest.regions.roots.iter().find(|root| !named.contains(&root.name));
            assert!(missing.is_none(), "{safety:?} {part} {missing:?}");
            if is_limited {
                ended += 1;
                // To say that all is certified, or more than that, is refused, unless it needs no proof.
                let claimed = std::mem::take(uncertified(&mut dump));
                let verdict = case.verify(&dump);
                let is_true = claimed.iter().all(|name| is_shown(&verdict, name));
                assert!(verdict.violation.is_some() || is_true, "{safety:?} {part}");
                for left in (0..claimed.len()).filter(|&left| takes(left + part)) {
                    *uncertified(&mut dump) = claimed.clone();
                    let name = uncertified(&mut dump).remove(left);
                    let verdict = case.verify(&dump);
                    assert!(
                        verdict.violation.is_some() || is_shown(&verdict, &name),
                        "{safety:?} {part} {name}"
                    );
                }
            }
        }
        assert!(ended >= share(3), "{ended} parts need enough work for a limit to end them");
    }
}

/// Returns whether a verdict shows a whole region.
fn is_shown(verdict: &Verdict, name: &str) -> bool {
    verdict.checked.iter().any(|checked| checked.region == name && checked.inside && checked.outside)
}

#[test]
fn a_region_that_is_wrong_is_refused_next_to_one_that_is_not_certified() {
    let case = Case::new(PREFERENCES, Safety::Action);
    let (mut dump, is_limited) = (1..=10).map(|part| case.without(part)).find(|(_, ended)| *ended).unwrap();
    assert!(is_limited);
    let all = dump.manifest.regions.root("reachable").unwrap().clone();
    let wrong = dump.manifest.regions.roots.iter_mut().find(|root| root.name == "initial").unwrap();
    (wrong.node, wrong.nodes, wrong.count) = (all.node, all.nodes, all.count);
    dump.regions.roots[wrong.root] = all.node;
    assert!(case.verify(&dump).violation.is_some());
}

#[test]
fn only_regions_can_be_left_out() {
    let case = Case::new(PREFERENCES, Safety::Action);
    let (dump, _) = case.without(0);
    for name in ["layers:reachable:0", "nothing", "almost-sure:Order"] {
        let mut dump = dump.clone();
        uncertified(&mut dump).push(name.to_owned());
        assert!(case.verify(&dump).violation.is_some(), "{name}");
    }
}

/// The whole dump was written twice, and copied in memory for that.
#[cfg(unix)]
#[test]
fn the_certificate_is_added_to_regions_that_stay_as_they_were_written() {
    use std::os::unix::fs::MetadataExt;
    let case = Case::new(PREFERENCES, Safety::Action);
    let (mut dump, scratch) = (case.regions.clone(), tempfile::tempdir().unwrap());
    let path = scratch.path().join("dump");
    let file = path.join("regions.dddmp");
    let names = |folder: &Path| fs::read_dir(folder).unwrap().count();
    for dot in [false, true] {
        write_regions_first(&mut dump, &path, dot, &NoProgress).unwrap();
        let (bytes, inode) = (fs::read(&file).unwrap(), fs::metadata(&file).unwrap().ino());
        let pictures = if dot { dump.manifest.regions.roots.len() } else { 0 };
        assert_eq!(names(&path), 2 + pictures);
        certify(&mut dump, &case.analysis, &mut |_| ()).unwrap();
        complete_directory(&mut dump, &path, &NoProgress).unwrap();
        assert_eq!((fs::read(&file).unwrap(), fs::metadata(&file).unwrap().ino()), (bytes.clone(), inode));
        assert_eq!((names(&path), names(scratch.path())), (3 + pictures, 1));
        assert!(case.verify(&read_directory(&path, true, &NoProgress).unwrap()).is_accepted());
        // A dump that another process has written in the meantime is replaced as a whole.
        let mut other = case.regions.clone();
        other.manifest.regions.roots.truncate(1);
        other.regions.roots.truncate(1);
        write_regions_first(&mut other, &path, false, &NoProgress).unwrap();
        assert_ne!(fs::read(&file).unwrap(), bytes);
        complete_directory(&mut dump, &path, &NoProgress).unwrap();
        assert_eq!(fs::read(&file).unwrap(), bytes);
        assert!(case.verify(&read_directory(&path, true, &NoProgress).unwrap()).is_accepted());
        (dump.manifest.certificate, dump.certificate) = (None, None);
    }
}
