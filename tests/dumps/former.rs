//! A dump of a former version, whose layers are those of one distance each, is accepted.

use meliora::dump::directory::sha256;

use crate::common::prelude::*;
use crate::dumps::others::read;

#[test]
fn a_dump_with_layers_by_distance_is_accepted_and_refused_if_changed() {
    let text = |name: &str| fs::read_to_string(format!("tests/dumps/by_distance{name}")).unwrap();
    let (model, preferences) = (text(".prism"), text(".pref"));
    let mut dump = read_directory(Path::new("tests/dumps/by_distance"), true, &NoProgress).unwrap();
    let proof = dump.manifest.certificate.as_ref().unwrap();
    assert!(proof.order.is_empty() && proof.roots.iter().all(|root| root.trend.is_none()));
    assert!(proof.root("layers:positive:H:3").is_some());
    let hashes = [&model, &preferences].map(|text| sha256(text.as_bytes()));
    let hashes = Hashes { model: &hashes[0], preferences: &hashes[1] };
    let (program, preferences) = read(&model, &preferences);
    let program = Arc::new(program);
    let verdict = verify(&program, &preferences, hashes, &dump, Settings::default()).unwrap();
    assert_eq!(verdict.violation, None);
    let roots = &mut dump.manifest.certificate.as_mut().unwrap().roots;
    for (from, to) in [("positive:H:1", "x"), ("positive:H:2", "positive:H:1"), ("x", "positive:H:2")] {
        let root = roots.iter_mut().find(|root| root.name.ends_with(from)).unwrap();
        root.name = format!("layers:{to}");
    }
    let violation = verify(&program, &preferences, hashes, &dump, Settings::default()).unwrap().violation;
    assert_eq!(
        violation.unwrap().condition.to_string(),
        "each state in layer 1 of `positive:H` has a step into an earlier layer"
    );
}
