//! Markov chains, in which all strategies coincide.

use std::fmt::Write;

use meliora::{Model, Settings, Storage};
use proptest::prelude::*;

/// Successors of each state; a state without successors is a deadlock.
fn chains() -> impl Strategy<Value = Vec<Vec<usize>>> {
    (2usize..8).prop_flat_map(|n| {
        prop::collection::vec(prop::collection::btree_set(0..n, 0..4), n)
            .prop_map(|all| all.into_iter().map(|successors| successors.into_iter().collect()).collect())
    })
}

/// Writes a model in which each state has at most one command.
fn model(kind: &str, successors: &[Vec<usize>]) -> String {
    let mut text = format!("{kind}\nmodule m\n  s : [0..{}] init 0;\n", successors.len() - 1);
    for (state, successors) in successors.iter().enumerate() {
        let branch = |to: &usize| format!("1/{}: (s'={to})", successors.len());
        let branches = successors.iter().map(branch).collect::<Vec<_>>().join(" + ");
        if !branches.is_empty() {
            let _ = writeln!(text, "  [] s={state} -> {branches};");
        }
    }
    text + "endmodule\n"
}

proptest! {
    #![proptest_config(crate::common::amount::random(100))]

    // As an mdp, the four regions are computed one by one; as a dtmc, two are, and copied.
    #[test]
    fn the_regions_of_a_chain_are_those_of_the_mdp_with_the_same_steps(successors in chains()) {
        for storage in [Storage::Symbolic, Storage::Explicit] {
            for question in ["s=1", "F s=1", "G F s=1", "F G s!=1", "(F s=1) & (G F s!=0)", "s!=1 U s=0"] {
                let found = ["mdp", "dtmc"].map(|kind| {
                    let model = Model::parse(model(kind, &successors), "").unwrap();
                    let settings = Settings { storage, memory: 64 << 20, ..Settings::default() };
                    let regions = model.explore(settings).unwrap().reach_where(question).unwrap().regions;
                    regions.map(|states| states.list(100).unwrap())
                });
                prop_assert_eq!(&found[0], &found[1], "{}", question);
            }
        }
    }
}
