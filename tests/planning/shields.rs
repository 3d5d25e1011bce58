//! Shields on random models: the promise holds, and secure nodes are the greatest such set.

use meliora::export::{read_shield, write_shield};
use meliora::planning::{Shield, ShieldNode};
use meliora::{Error, Kind, Model, Options, Safety, Settings, SourceFile};
use rand::RngExt;
use rand::SeedableRng;
use rand::rngs::SmallRng;

/// Returns a model of eight states with random branches, and wishes about three of them.
fn analysed(seed: u64, safety: Safety) -> meliora::Analysis {
    let mut random = SmallRng::seed_from_u64(seed);
    let mut text = "mdp module m s : [0..7] init 0;\n".to_owned();
    for state in 0..8 {
        for action in ["a", "b", "c"].iter().take(random.random_range(1..4)) {
            // Most steps lead to later states, so decisions are final.
            let low = if random.random_bool(0.9) { state } else { 0 };
            let [one, other] = [0; 2].map(|_| random.random_range(low..8));
            text += &format!("[{action}] s={state} -> 1/2: (s'={one}) + 1/2: (s'={other});\n");
        }
    }
    let model = Model::parse(text + "endmodule", "").unwrap();
    let wishes = "objective A = F s=5; objective B = F s=6; objective C = F s=7; prefer A, B > C;";
    let explored = model.explore(Settings::default()).unwrap();
    let options = Options { safety, ..Options::default() };
    let mut analysis = explored.prefer(&SourceFile::new("wishes", wishes), options).unwrap();
    analysis.run(&mut |_| ()).unwrap();
    analysis
}

fn shield(seed: u64, safety: Safety, kind: Kind) -> Shield {
    Shield::new(&mut analysed(seed, safety).strategy(kind).unwrap(), 1000).unwrap()
}

/// Returns the nodes from which a permitted step may weaken now or later. While improvements are
/// ahead, the agent may choose badly among the permitted actions; at level 0 it avoids the worst.
fn threatened(shield: &Shield) -> Vec<bool> {
    let nodes = &shield.nodes;
    let mut bad = vec![false; nodes.len()];
    for _ in 0..nodes.len() {
        for (v, node) in nodes.iter().enumerate() {
            let threat = |next: &Vec<usize>| {
                next.iter().any(|&to| {
                    let class = nodes[to].class.unwrap();
                    bad[to] || shield.weakening[node.reference].contains(&class)
                })
            };
            let mut threats = node.actions.iter().filter(|a| a.permitted).map(|a| threat(&a.next));
            bad[v] |= match node.ahead {
                Some(0) => node.actions.iter().all(|a| threat(&a.next)),
                _ => threats.any(|threat| threat),
            };
        }
    }
    bad
}

#[test]
fn secure_nodes_are_those_that_nothing_threatens() {
    let (mut secure, mut others, mut ahead) = (0, 0, 0);
    for seed in 0..150 {
        for (safety, kind) in [(Safety::Action, Kind::Sasi), (Safety::Action, Kind::Spi)] {
            let shield = shield(seed, safety, kind);
            assert_eq!(shield.fault(), None);
            let bad = threatened(&shield);
            for (v, node) in shield.nodes.iter().enumerate() {
                assert_eq!(node.secure, !bad[v], "seed {seed}, node {v}");
                secure += usize::from(node.secure);
                others += usize::from(!node.secure);
                ahead += usize::from(node.ahead != Some(0));
            }
        }
    }
    assert!(secure > 100 && others > 0 && ahead > 20, "{secure} {others} {ahead}");
}

#[test]
fn shields_under_prefix_keep_their_promise() {
    for seed in 0..100 {
        for kind in [Kind::Sasi, Kind::Spi] {
            let shield = shield(seed, Safety::Prefix, kind);
            assert_eq!(shield.fault(), None, "seed {seed}");
            assert!(shield.nodes.iter().any(|node: &ShieldNode| node.secure), "seed {seed}");
        }
    }
}

#[test]
fn a_table_with_a_weakening_step_is_refused() {
    let mut refused = 0;
    for seed in 0..50 {
        let shield = shield(seed, Safety::Action, Kind::Sasi);
        for v in 0..shield.nodes.len() {
            let mut changed = shield.clone();
            changed.nodes[v].actions.iter_mut().for_each(|action| action.permitted = true);
            refused += usize::from(changed.fault().is_some());
            changed.nodes[v].reference = 99;
            assert!(changed.fault().is_some());
        }
    }
    assert!(refused > 10, "{refused}");
}

#[test]
fn strategies_that_may_weaken_have_no_shield() {
    let mut strategy = analysed(1, Safety::Transition).strategy(Kind::Sasi).unwrap();
    assert!(matches!(Shield::new(&mut strategy, 1000), Err(Error::Usage(_))));
    let mut strategy = analysed(1, Safety::Action).strategy(Kind::Sasi).unwrap();
    assert!(matches!(Shield::new(&mut strategy, 2), Err(Error::Limit(_))));
}

#[test]
fn a_saved_shield_replaces_an_older_one_and_nothing_else() {
    let (folder, new) = (tempfile::tempdir().unwrap(), shield(1, Safety::Action, Kind::Sasi));
    let names = || {
        let entries = std::fs::read_dir(folder.path().join("deep")).unwrap();
        Vec::from_iter(entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()))
    };
    let path = folder.path().join("deep/shield");
    for seed in [2, 1] {
        write_shield(&shield(seed, Safety::Action, Kind::Sasi), &path).unwrap();
        assert_eq!(names(), ["shield"]);
    }
    assert_eq!(read_shield(&path).unwrap().nodes.len(), new.nodes.len());
    std::fs::write(path.join("letter.txt"), "mine").unwrap();
    let refused = write_shield(&shield(2, Safety::Action, Kind::Sasi), &path).unwrap_err().to_string();
    assert!(refused.contains("`letter.txt`, which does not belong to the shield"), "{refused}");
    assert_eq!(read_shield(&path).unwrap().nodes.len(), new.nodes.len());
    assert_eq!(names(), ["shield"]);
}
