//! Shields of games: the promise holds against every memoryless strategy of the opponent.

use meliora::planning::ShieldNode;
use proptest::prelude::*;

use super::levels::{Case, some_case};
use super::raw::{Raw, Won, loaded};
use super::{settings, thresholds};
use crate::common::prelude::*;

/// Maximum number of pairs of strategies that a check enumerates.
const MOST_PAIRS: usize = 1024;

/// The shield of a kind; `achieve` is for the first objective.
fn shield(case: &Case, safety: Safety, kind: StrategyKind) -> Shield {
    let (program, preferences) = loaded(&case.raw.text(), &case.preferences());
    let engine = ExplicitEngine::new(Arc::clone(&program), settings(Scope::All, thresholds()[0])).unwrap();
    let options = Options { safety, ..Options::default() };
    let analysis = finished(&Arc::new(engine), &preferences, options);
    let objectives = (kind == StrategyKind::Achieve).then_some(0);
    let strategy = FiniteMemoryStrategy::of_kind(&analysis, &program, kind, kind.levels(), objectives);
    Shield::new(&mut strategy.unwrap().unwrap(), 10_000).unwrap()
}

/// Returns whether a step between classes improves.
fn improves(case: &Case, shield: &Shield, from: usize, to: usize) -> bool {
    let weakens = |from: usize, to: usize| shield.weakening[from].contains(&to);
    match shield.classes[from].is_empty() {
        true => case.empty != "incomparable" && !shield.classes[to].is_empty(),
        false => weakens(to, from) && !weakens(from, to),
    }
}

/// The game of the opponent against a shield: at our nodes all permitted actions are taken at random. A step
/// for which `wins` is true leads to a goal, which is last; nodes that are not open lead nowhere.
fn against(shield: &Shield, open: impl Fn(usize) -> bool, wins: impl Fn(usize, usize) -> bool) -> Raw {
    let goal = shield.nodes.len();
    let end = |v: usize, to: usize| if wins(v, to) { goal } else { to };
    let choices = |v: usize| -> Vec<Vec<usize>> {
        let permitted = shield.nodes[v].actions.iter().filter(|action| action.permitted);
        let all: Vec<Vec<usize>> =
            permitted.map(|action| action.next.iter().map(|&to| end(v, to)).collect()).collect();
        match (open(v), shield.nodes[v].theirs) {
            (false, _) => vec![vec![v]],
            (true, false) => vec![all.concat()],
            (true, true) => all,
        }
    };
    Raw {
        theirs: shield.nodes.iter().map(|node| node.theirs).chain([false]).collect(),
        choices: (0..goal).map(choices).chain([vec![vec![goal]]]).collect(),
    }
}

/// The nodes from which we reach the goal surely and possibly, whatever the opponent does; `None` if there
/// are too many strategies.
fn enforced(raw: &Raw) -> Option<[Won; 2]> {
    let target: Won = (0..raw.len()).map(|s| s + 1 == raw.len()).collect();
    let [us, _] = (raw.pairs() <= MOST_PAIRS).then(|| raw.enforced(&target))?;
    Some([us.surely, us.possibly])
}

/// Checks that the improvements that are ahead can be made against each strategy of the opponent.
fn improvements_are_ahead(case: &Case, shield: &Shield, kind: Kind) {
    let is_ahead = |node: &ShieldNode| node.ahead != Some(0);
    let wins = |v: usize, to: usize| {
        let (node, next) = (&shield.nodes[v], &shield.nodes[to]);
        let left = match (node.ahead, next.ahead) {
            (_, None) => true,
            (None, Some(_)) => false,
            (Some(k), Some(left)) => left + 1 >= k,
        };
        left && next.class.is_some_and(|class| improves(case, shield, node.reference, class))
    };
    let raw = against(shield, |v| is_ahead(&shield.nodes[v]), wins);
    let Some([surely, possibly]) = enforced(&raw) else { return };
    let won = if kind == Kind::Sasi { surely } else { possibly };
    for (v, node) in shield.nodes.iter().enumerate().filter(|(_, node)| is_ahead(node)) {
        assert!(won[v], "{kind} of {:?}: {case:?}", node.state);
    }
}

/// Checks that the objectives that are pursued are achieved against each strategy of the opponent.
fn objectives_are_achieved(case: &Case, shield: &Shield) {
    let pursues = |node: &ShieldNode| !node.pursues.is_empty();
    let achieved = |v: usize| shield.nodes[v].achieved;
    let raw = against(shield, |v| pursues(&shield.nodes[v]) && !achieved(v), |_, to| achieved(to));
    let Some([surely, _]) = enforced(&raw) else { return };
    for (v, node) in shield.nodes.iter().enumerate().filter(|(_, node)| pursues(node)) {
        assert!(surely[v] || achieved(v), "{:?} of {:?}: {case:?}", node.pursues, node.state);
    }
}

/// Checks that no step from a secure node weakens, whoever makes it, and that it leads to a secure node.
fn secure_nodes_stay_secure(shield: &Shield) {
    for node in shield.nodes.iter().filter(|node| node.secure) {
        for &to in node.actions.iter().filter(|action| action.permitted).flat_map(|action| &action.next) {
            let class = shield.nodes[to].class.expect("a secure node leads to an unsafe state");
            assert!(shield.nodes[to].secure && !shield.weakening[node.reference].contains(&class));
        }
    }
}

/// The nodes from which the opponent, or a bad choice among permitted actions, may weaken. At level 0 we
/// avoid the worst.
fn threatened(shield: &Shield) -> Vec<bool> {
    let nodes = &shield.nodes;
    let mut bad: Vec<bool> = nodes.iter().map(|node| node.class.is_none()).collect();
    for _ in 0..nodes.len() {
        for (v, node) in nodes.iter().enumerate() {
            let weakens = |to: usize| {
                nodes[to].class.is_none_or(|class| shield.weakening[node.reference].contains(&class))
            };
            let threat = |next: &Vec<usize>| next.iter().any(|&to| bad[to] || weakens(to));
            let mut permitted = node.actions.iter().filter(|action| action.permitted);
            bad[v] |= match (node.ahead, node.theirs) {
                (Some(0), false) => node.actions.iter().all(|action| threat(&action.next)),
                _ => permitted.any(|action| threat(&action.next)),
            };
        }
    }
    bad
}

/// Checks that the opponent's actions are all permitted, and that the table says who chooses.
fn the_opponent_is_free(case: &Case, shield: &Shield) {
    for node in &shield.nodes {
        let s = node.state[0] as usize;
        assert_eq!(node.theirs, case.raw.theirs[s], "{s}: {case:?}");
        assert!(!node.theirs || node.actions.iter().all(|action| action.permitted), "{s}: {case:?}");
    }
}

proptest! {
    #![proptest_config(meliora_amount::random(100))]

    #[test]
    fn promises_hold_against_every_opponent(case in some_case()) {
        for safety in [Safety::Action, Safety::Prefix] {
            for &kind in StrategyKind::ALL {
                let shield = shield(&case, safety, kind);
                prop_assert_eq!(shield.fault(), None, "{} {}: {:?}", kind, safety, case);
                the_opponent_is_free(&case, &shield);
                secure_nodes_stay_secure(&shield);
                improvements_are_ahead(&case, &shield, kind.levels());
                objectives_are_achieved(&case, &shield);
                if safety == Safety::Action && matches!(kind, StrategyKind::Sasi | StrategyKind::Spi) {
                    let secure: Vec<bool> = shield.nodes.iter().map(|node| node.secure).collect();
                    let safe: Vec<bool> = threatened(&shield).into_iter().map(|bad| !bad).collect();
                    prop_assert_eq!(secure, safe, "{} {}: {:?}", kind, safety, case);
                }
            }
        }
    }
}

/// A table that forbids something to the opponent, or in which one of its actions escapes, is refused.
#[test]
fn tables_that_restrict_the_opponent_are_refused() {
    let raw = Raw {
        theirs: vec![false, true, false, false],
        choices: vec![vec![vec![1]], vec![vec![2], vec![3]], vec![vec![2]], vec![vec![3]]],
    };
    let at = |states: &[usize]| (0..4).map(|s| states.contains(&s)).collect::<Won>();
    let case = Case {
        raw,
        targets: vec![at(&[2, 3]), at(&[0, 1])],
        pairs: vec![(0, 1)],
        empty: "bottom",
        required: None,
    };
    let honest = shield(&case, Safety::Action, StrategyKind::Achieve);
    let theirs = honest.nodes.iter().position(|node| node.theirs).unwrap();
    let refused = |change: fn(&mut ShieldNode), said: &str| {
        let mut forged = honest.clone();
        change(&mut forged.nodes[theirs]);
        let fault = forged.fault().unwrap();
        assert!(fault.contains(said), "{fault}");
    };
    assert_eq!(honest.fault(), None);
    refused(|node| node.actions[1].permitted = false, "the opponent's action");
    // If the opponent stays, the objective is never achieved.
    let stays = |node: &mut ShieldNode| node.actions[1].next.clear();
    refused(stays, "has no successor");
    let mut forged = honest.clone();
    forged.nodes[theirs].actions[1].next = vec![theirs];
    assert!(forged.fault().unwrap().contains("permitted steps cannot achieve them"));
}
