//! Shields of models in which several choices have one label: everything that a node says holds for
//! each choice of each permitted label; other shields are refused.

use meliora::planning::ShieldNode;
use meliora::{Choose, Options};

use crate::common::prelude::*;

const SAFE: [Safety; 2] = [Safety::Action, Safety::Prefix];

/// A random model of eight states: the choices of each state, by label and successors.
type World = Vec<Vec<(&'static str, Vec<usize>)>>;

fn world(random: &mut SmallRng) -> World {
    let choice = |state: usize, random: &mut SmallRng| {
        // Most labels occur once in a state, so that many models have a shield.
        let label = ["a", "b", "c", "d"][random.random_range(0..4)];
        let low = if random.random_bool(0.8) { state } else { 0 };
        (label, (0..2).map(|_| random.random_range(low..8)).collect())
    };
    let choices = |state: usize| {
        let count = random.random_range(1..4);
        (0..count).map(|_| choice(state, random)).collect()
    };
    (0..8).map(choices).collect()
}

fn analysed(commands: &str, states: usize, wishes: &str, options: Options) -> meliora::Analysis {
    let text = format!("mdp module m s : [0..{}] init 0; {commands} endmodule", states - 1);
    let explored = Model::parse(text, "").unwrap().explore(Settings::default()).unwrap();
    let mut analysis = explored.prefer(&SourceFile::new("wishes", wishes), options).unwrap();
    analysis.run(&mut |_| ()).unwrap();
    analysis
}

/// Returns the shields of all kinds and safe modes, or their refusals.
fn shields(commands: &str, states: usize, wishes: &str) -> Vec<(Kind, Result<Shield, Error>)> {
    let of = |safety, kind| {
        let options = Options { safety, ..Options::default() };
        let analysis = analysed(commands, states, wishes, options);
        (kind, Shield::new(&mut analysis.strategy(kind).unwrap(), 1000))
    };
    SAFE.iter().flat_map(|&safety| Kind::ALL.iter().map(move |&kind| of(safety, kind))).collect()
}

/// Checks that all of them are refused, with this message.
fn refused(commands: &str, states: usize, wishes: &str, message: &str) {
    for (kind, found) in shields(commands, states, wishes) {
        let error = found.err().unwrap_or_else(|| panic!("{kind}: a shield")).to_string();
        assert!(error.contains(message) && error.contains("give them different labels"), "{kind}: {error}");
    }
}

/// `c` surely violates the requirement, and `b` may: both were permitted.
#[test]
fn a_label_that_may_violate_a_requirement_is_not_permitted_for_want_of_another() {
    let wishes = "objective A = F s=0; require G !(s=1);";
    let shared = "[b] s=0 -> (s'=1); [b] s=0 -> (s'=2); [c] s=0 -> (s'=1);";
    refused(shared, 3, wishes, "in the state s=0, `b(m#2)` keeps the requirements, but not every choice");
    let apart = "[b] s=0 -> (s'=1); [d] s=0 -> (s'=2); [c] s=0 -> (s'=1);";
    for (kind, shield) in shields(apart, 3, wishes) {
        let shield = shield.unwrap();
        let node = shield.nodes.iter().find(|node| node.state == [0]).unwrap();
        let permitted: Vec<&str> = permitted(node).map(|a| shield.actions[a].as_str()).collect();
        assert_eq!((permitted, node.secure), (vec!["d"], false), "{kind}");
    }
}

fn permitted(node: &ShieldNode) -> impl Iterator<Item = usize> {
    node.actions.iter().filter(|action| action.permitted).map(|action| action.action)
}

/// The table promised an improvement that the other choice of the label does not make.
#[test]
fn an_improvement_is_not_promised_if_a_choice_of_its_label_only_waits() {
    let wishes = "objective A = F s=1; objective B = F s=2; objective C = F s=3; prefer A, B > C;";
    let rest = "[stay] s>0 -> true; [low] s=0 -> (s'=3);";
    let roll = "[b] s=0 -> 1/2:(s'=1) + 1/2:(s'=2);";
    let message = "in the state s=0, `b(m#1)` makes progress, but not every choice with its label";
    refused(&format!("{roll} [b] s=0 -> true; {rest}"), 4, wishes, message);
    // One that the strategy forbids was permitted with the other.
    let message = "in the state s=0, `b(m#1)` is permitted, but not every choice with its label";
    refused(&format!("{roll} [b] s=0 -> (s'=3); {rest}"), 4, wishes, message);
    for (kind, shield) in shields(&format!("{roll} {roll} {rest}"), 4, wishes) {
        let shield = shield.unwrap();
        let node = shield.nodes.iter().find(|node| node.state == [0]).unwrap();
        assert_eq!((node.ahead, node.secure), (Some(1), true), "{kind}");
    }
}

/// A choice that leaves the states where the reference can be kept was permitted with one that stays.
#[test]
fn a_choice_that_loses_the_reference_is_not_permitted_with_another() {
    let commands =
        "[c] s=0 -> true; [c] s=0 -> (s'=1); [risk] s=1 -> 1/2:(s'=2) + 1/2:(s'=3); [stay] s>1 -> true;";
    let wishes = "objective A = F s=0; objective B = F (s=1 | s=3); objective C = F s=2; prefer A > C;";
    let analysis = analysed(commands, 4, wishes, Options { safety: Safety::Prefix, ..Options::default() });
    let error = Shield::new(&mut analysis.strategy(Kind::Sasi).unwrap(), 1000).unwrap_err().to_string();
    assert!(error.contains("in the state s=0, `c(m#1)` is permitted, but not every"), "{error}");
}

/// The nodes that a choice of a permitted label may enter: by node, then by label.
fn steps(shield: &Shield, world: &World) -> Vec<Vec<Vec<BTreeSet<usize>>>> {
    let at = |node: &ShieldNode| node.state[0] as usize;
    let label = |node: &ShieldNode, action: usize| {
        let next = &node.actions.iter().find(|known| known.action == action).unwrap().next;
        let entered = |to: &usize| *next.iter().find(|&&node| at(&shield.nodes[node]) == *to).unwrap();
        let own = world[at(node)].iter().filter(|(name, _)| *name == shield.actions[action]);
        own.map(|(_, to)| to.iter().map(entered).collect()).collect()
    };
    let node = |node: &ShieldNode| permitted(node).map(|action| label(node, action)).collect();
    shield.nodes.iter().map(node).collect()
}

/// Returns the nodes from which permitted labels that are taken at random end almost surely (`surely`)
/// or with positive probability, whatever choices of the labels are taken.
fn ending(
    steps: &[Vec<Vec<BTreeSet<usize>>>],
    surely: bool,
    ends: impl Fn(usize, usize) -> bool,
) -> Vec<bool> {
    let mut won = vec![true; steps.len()];
    loop {
        let stays = |v: usize| {
            let all = steps[v].iter().flatten().flatten();
            !surely || all.clone().all(|&to| ends(v, to) || won[to])
        };
        let mut near = vec![false; steps.len()];
        loop {
            let leads = |choice: &BTreeSet<usize>, v| choice.iter().any(|&to| ends(v, to) || near[to]);
            let is_new = |v: &usize| {
                let led = steps[*v].iter().any(|label| label.iter().all(|choice| leads(choice, *v)));
                !near[*v] && won[*v] && stays(*v) && led
            };
            let Some(v) = (0..steps.len()).find(is_new) else { break };
            near[v] = true;
        }
        if near == won {
            return won;
        }
        won = near;
    }
}

/// Returns whether a step improves as much as the node says.
fn improves(shield: &Shield, from: usize, to: usize) -> bool {
    let (from, to) = (&shield.nodes[from], &shield.nodes[to]);
    let weakens = |from: usize, to: usize| shield.weakening[from].contains(&to);
    let left = match (from.ahead, to.ahead) {
        (_, None) => true,
        (None, Some(_)) => false,
        (Some(k), Some(left)) => left + 1 >= k,
    };
    let empty = |class: usize| shield.classes[class].is_empty();
    let better = |class: usize| {
        if empty(from.reference) { !empty(class) } else { weakens(class, from.reference) }
    };
    left && to.class.is_some_and(|class| better(class) && !weakens(from.reference, class))
}

/// A label with a choice that makes progress and one that the strategy forbids was permitted.
#[test]
fn what_a_node_says_holds_for_every_choice_of_every_permitted_label() {
    let (mut refused, mut ahead, mut secure, mut shared) = (0, 0, 0, 0);
    for seed in 0..share(300) as u64 {
        let mut random = SmallRng::seed_from_u64(seed);
        let world = world(&mut random);
        let (history, b) = [("state", "F s=6"), ("play", "F (s=6 & X s=7)")][random.random_range(0..2)];
        let wishes = format!(
            "history = {history}; objective A = F s=5; objective B = {b}; objective C = F s=7; \
             prefer A, B > C;"
        );
        for (kind, found) in shields(&commands(&world), 8, &wishes) {
            let Ok(shield) = found else {
                refused += 1;
                continue;
            };
            assert_eq!(shield.fault(), None, "seed {seed}, {kind}");
            let steps = steps(&shield, &world);
            let made = ending(&steps, kind == Kind::Sasi, |v, to| improves(&shield, v, to));
            for (v, node) in shield.nodes.iter().enumerate() {
                let what = format!("seed {seed}, {kind}, {}, {:?}", shield.safety, node.state);
                assert!(made[v] || node.ahead == Some(0), "{what}");
                ahead += usize::from(node.ahead != Some(0));
                secure += usize::from(node.secure);
                shared += steps[v].iter().filter(|choices| choices.len() > 1).count();
                for &to in steps[v].iter().flatten().flatten().filter(|_| node.secure) {
                    let class = shield.nodes[to].class.unwrap();
                    assert!(!shield.weakening[node.reference].contains(&class), "{what}");
                    assert!(shield.nodes[to].secure, "{what}");
                }
            }
        }
    }
    let found = [refused, ahead, secure, shared];
    assert!(found.iter().all(|&count| count > share(100)), "{found:?}");
}

fn commands(world: &World) -> String {
    let command = |state: usize, (label, to): &(&str, Vec<usize>)| {
        format!("[{label}] s={state} -> 1/2: (s'={}) + 1/2: (s'={}); ", to[0], to[1])
    };
    let of = |(state, own): (usize, &Vec<_>)| own.iter().map(|c| command(state, c)).collect::<String>();
    world.iter().enumerate().map(of).collect()
}

/// A pursued objective is achieved almost surely, whatever choices of the permitted labels are taken.
#[test]
fn what_is_pursued_is_achieved_by_every_choice_of_every_permitted_label() {
    let aims = [
        (StrategyKind::Plan, None),
        (StrategyKind::Plan, Some("C")),
        (StrategyKind::Achieve, Some("A")),
        (StrategyKind::Achieve, Some("B")),
        (StrategyKind::Achieve, Some("A,C")),
    ];
    let (mut refused, mut pursuing) = (0, 0);
    for seed in 0..share(150) as u64 {
        let world = world(&mut SmallRng::seed_from_u64(seed));
        let wishes =
            "objective A = F s=5; objective B = F (s=6 | s=4); objective C = F s=7; prefer A, B > C;";
        for (safety, (kind, aim)) in SAFE.into_iter().flat_map(|safety| aims.map(|aims| (safety, aims))) {
            let analysis = analysed(&commands(&world), 8, wishes, Options { safety, ..Options::default() });
            let mut strategy = analysis.strategy_of(kind, Choose::First, aim).unwrap();
            let Ok(shield) = Shield::new(&mut strategy, 1000) else {
                refused += 1;
                continue;
            };
            assert_eq!(shield.fault(), None, "seed {seed}, {kind} {aim:?}");
            let sure = ending(&steps(&shield, &world), true, |_, to| shield.nodes[to].achieved);
            for (v, node) in shield.nodes.iter().enumerate().filter(|(_, node)| !node.pursues.is_empty()) {
                assert!(sure[v] || node.achieved, "seed {seed}, {kind} {aim:?}, {:?}", node.state);
                pursuing += 1;
            }
        }
    }
    assert!(refused > share(50) && pursuing > share(500), "{refused} {pursuing}");
}
