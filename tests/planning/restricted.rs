//! Requirements against the same model in which guards remove the forbidden choices: quantities,
//! strategies, simulations and shields of every state must be the same.

use std::fmt::Write;

use meliora::{Options, Wanted};

use crate::common::prelude::*;

const STATES: i64 = 7;
const STORAGES: [Storage; 2] = [Storage::Symbolic, Storage::Explicit];

/// An action of a state: its name, and its successors with their weights.
struct Choice {
    state: i64,
    name: &'static str,
    successors: Vec<(i64, u32)>,
}

/// A random model with some states that are forbidden.
struct World {
    choices: Vec<Choice>,
    bad: BTreeSet<i64>,
    wishes: String,
}

impl World {
    fn random(seed: u64) -> Self {
        let mut random = SmallRng::seed_from_u64(seed);
        let mut choices = Vec::new();
        for state in 0..STATES {
            // A state without a choice is a deadlock.
            for name in ["a", "b", "c"].into_iter().take(random.random_range(0..4)) {
                let low = if random.random_bool(0.6) { state } else { 0 };
                let mut successors: Vec<(i64, u32)> = Vec::new();
                for _ in 0..random.random_range(1..4) {
                    successors.push((random.random_range(low..STATES), random.random_range(1..4)));
                }
                choices.push(Choice { state, name, successors });
            }
        }
        let bad = (0..STATES).filter(|_| random.random_bool(0.2)).collect();
        let [a, b, c] = [(); 3].map(|()| random.random_range(0..STATES));
        let empty = ["bottom", "gain", "incomparable"][random.random_range(0..3)];
        let history = if random.random_bool(0.3) { "history = play;" } else { "" };
        let wishes = format!(
            "objective A = F s={a}; objective B = F s={b}; objective C = F s={c}; prefer A > B; prefer C > B; \
             empty = {empty}; {history}"
        );
        World { choices, bad, wishes }
    }

    /// Computes Z by the book: the states from which some choices avoid all bad states forever.
    fn safe(&self) -> BTreeSet<i64> {
        let mut safe: BTreeSet<i64> = (0..STATES).filter(|s| !self.bad.contains(s)).collect();
        loop {
            let stays = |s: &i64| {
                let mut own = self.choices.iter().filter(|c| c.state == *s).peekable();
                own.peek().is_none() || own.any(|c| c.successors.iter().all(|(to, _)| safe.contains(to)))
            };
            let next: BTreeSet<i64> = safe.iter().filter(|s| stays(s)).copied().collect();
            if next == safe {
                return safe;
            }
            safe = next;
        }
    }

    /// Writes the choices for which `kept` is true as a model.
    fn model(&self, kept: impl Fn(&Choice) -> bool) -> String {
        let mut text = format!("mdp module m s : [0..{}] init 0;\n", STATES - 1);
        for choice in self.choices.iter().filter(|choice| kept(choice)) {
            let sum: u32 = choice.successors.iter().map(|(_, weight)| weight).sum();
            let branch = |(to, weight): &(i64, u32)| format!("{weight}/{sum}: (s'={to})");
            let branches: Vec<String> = choice.successors.iter().map(branch).collect();
            writeln!(text, "[{}] s={} -> {};", choice.name, choice.state, branches.join(" + ")).unwrap();
        }
        text + "endmodule"
    }

    fn analysed(&self, model: &str, more: &str, safety: Safety, storage: Storage) -> meliora::Analysis {
        let model = Model::parse(model, "").unwrap();
        let settings =
            Settings { storage, scope: meliora::Scope::All, memory: 16 << 20, ..Settings::default() };
        let explored = model.explore(settings).unwrap();
        let wishes = SourceFile::new("wishes", format!("{}{more}", self.wishes));
        let options = Options { safety, ..Options::default() };
        let mut analysis = explored.prefer(&wishes, options).unwrap();
        analysis.run(&mut |_| ()).unwrap();
        analysis
    }

    /// Returns the analysis under the requirement, and that of the model without forbidden choices.
    fn both(&self, safety: Safety, storage: Storage) -> [meliora::Analysis; 2] {
        let safe = self.safe();
        let bad: String = self.bad.iter().map(|s| format!(" & s!={s}")).collect();
        let required = format!("require G (true{bad});");
        let kept =
            |c: &Choice| safe.contains(&c.state) && c.successors.iter().all(|(to, _)| safe.contains(to));
        [
            self.analysed(&self.model(|_| true), &required, safety, storage),
            self.analysed(&self.model(kept), "", safety, storage),
        ]
    }
}

/// The states of an analysis that are safe in the model with all choices.
fn safe_states(guarded: &meliora::Analysis, safe: &BTreeSet<i64>) -> Vec<Vec<i64>> {
    let all = guarded.exploration().states().list(usize::MAX).unwrap();
    all.into_iter().filter(|state| safe.contains(&state[0])).collect()
}

fn each(seeds: usize, test: impl Fn(&str, &World, [meliora::Analysis; 2])) {
    for seed in 0..share(seeds) as u64 {
        let world = World::random(seed);
        for storage in STORAGES {
            for &safety in Safety::ALL {
                let case = format!("seed {seed}, {safety}, {}", storage.name());
                test(&case, &world, world.both(safety, storage));
            }
        }
    }
}

#[test]
fn quantities_are_those_of_the_model_without_the_forbidden_choices() {
    let wanted = Wanted { levels: Some(2), exact: true, within: Some(3), ..Wanted::default() };
    each(150, |case, world, [required, guarded]| {
        let states = safe_states(&guarded, &world.safe());
        let [ours, theirs] = [&required, &guarded].map(|a| a.state_values(&states, &wanted).unwrap());
        assert_eq!(ours, theirs, "{case}: {}\n{}", world.model(|_| true), world.wishes);
    });
}

#[test]
fn a_shield_forbids_what_violates_the_requirements_wherever_it_can() {
    each(60, |case, _, [required, _]| {
        for &kind in Kind::ALL {
            let Ok(shield) = Shield::new(&mut required.strategy(kind).unwrap(), 10_000) else { continue };
            for node in shield.nodes.iter().filter(|node| node.class.is_some()) {
                let keeps = |next: &[usize]| next.iter().all(|&to| shield.nodes[to].class.is_some());
                assert!(node.actions.iter().any(|action| keeps(&action.next)), "{case}: {node:?}");
                for action in node.actions.iter().filter(|action| action.permitted) {
                    assert!(keeps(&action.next), "{case}: {node:?}");
                }
            }
        }
    });
}

#[test]
fn a_shield_permits_no_violation_where_every_other_action_weakens() {
    // Every action leaves the target; `c` also violates the requirement.
    let model = "mdp module m s:[0..2]; [a] s=0 -> (s'=1); [c] s=0 -> (s'=2); endmodule init s=0 endinit";
    let world =
        World { choices: Vec::new(), bad: BTreeSet::new(), wishes: "objective A = F s=0;".to_owned() };
    for storage in STORAGES {
        for safety in [Safety::Action, Safety::Prefix] {
            let found = world.analysed(model, "require G s!=2;", safety, storage);
            for &kind in Kind::ALL {
                let shield = Shield::new(&mut found.strategy(kind).unwrap(), 100).unwrap();
                let node = shield.nodes.iter().find(|node| node.state == [0]).unwrap();
                let names = node.actions.iter().map(|a| (shield.actions[a.action].as_str(), a.permitted));
                assert_eq!(names.collect::<Vec<_>>(), [("a", true), ("c", false)], "{safety}");
                assert!(!node.secure, "{safety}");
            }
        }
    }
}
