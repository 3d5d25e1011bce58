//! Runs under a strategy keep its guarantees on random models.

use std::collections::VecDeque;

use meliora::planning::explain::Verdict;
use proptest::prelude::*;
use proptest::test_runner::Config;

use crate::common::coverage::draw_until;
use crate::common::graphs::edges;
use crate::common::prelude::*;

/// A model of one variable: for each state its choices, for each choice where it leads.
fn program(
    choices: &[Vec<Vec<usize>>],
    targets: &[usize],
    above: &[(usize, usize)],
    empty: &str,
) -> (Program, Preferences) {
    let mut text = format!("mdp\nmodule m\n  s : [0..{}] init 0;\n", choices.len() - 1);
    for (s, choices) in choices.iter().enumerate() {
        for to in choices {
            let share = format!("1/{}", to.len());
            let branches: Vec<String> = to.iter().map(|t| format!("{share}: (s'={t})")).collect();
            text += &format!("  [] s={s} -> {};\n", branches.join(" + "));
        }
    }
    text += "endmodule\n";
    let mut preferences = String::new();
    for (i, target) in targets.iter().enumerate() {
        preferences += &format!("objective o{i} = F s={target};\n");
    }
    for (i, j) in above.iter().filter(|(i, j)| i > j && *i < targets.len()) {
        preferences += &format!("prefer o{i} > o{j};\n");
    }
    preferences += &format!("empty = {empty};\n");
    let program = parsed(text);
    let lang::Task { program, preferences } =
        lang::load_preferences(&SourceFile::new("p", preferences), program).unwrap();
    (program, preferences)
}

/// Returns the fewest improvements on a path from node 0 to each node; none for unreachable nodes.
fn fewest(edges: &[Vec<(usize, bool)>]) -> Vec<Option<usize>> {
    let mut found = vec![None; edges.len()];
    found[0] = Some(0);
    let mut queue = VecDeque::from([0]);
    while let Some(node) = queue.pop_front() {
        for &(to, improves) in &edges[node] {
            let count = found[node].unwrap() + usize::from(improves);
            if found[to].is_none_or(|known| count < known) {
                found[to] = Some(count);
                queue.push_back(to);
            }
        }
    }
    found
}

/// Returns true if some path from node 0 has at least `times` improvements.
fn can_improve(edges: &[Vec<(usize, bool)>], times: usize) -> bool {
    let mut seen = BTreeSet::from([(0, 0)]);
    let mut queue = VecDeque::from([(0, 0)]);
    while let Some((node, count)) = queue.pop_front() {
        if count >= times {
            return true;
        }
        for &(to, improves) in &edges[node] {
            let next = (to, count + usize::from(improves));
            if seen.insert(next) {
                queue.push_back(next);
            }
        }
    }
    false
}

/// Checks the guarantee on the induced Markov chain. Under SASI it almost surely comes to an end, and
/// every path to an end has at least `rank` improvements; under SPI `rank` improvements are possible.
fn check_course(kind: Kind, unfolded: &InducedModel, rank: Rank, label: &str) {
    assert!(unfolded.complete);
    let edges = edges(unfolded);
    let ends = |n: usize| unfolded.nodes[n].at.memory.level == Rank::Finite(0);
    let promised = match rank {
        Rank::Finite(k) => k,
        _ => 12,
    };
    if kind == Kind::Spi {
        assert!(can_improve(&edges, promised), "{label}: {promised} are possible");
        return;
    }
    let reached = fewest(&edges);
    for node in 0..edges.len() {
        if ends(node) {
            assert!(edges[node].is_empty() && reached[node] >= Some(promised), "{label}: too few");
        }
    }
    // In a finite chain, to be able to end from everywhere is to end almost surely.
    let mut ending: Vec<bool> = (0..edges.len()).map(ends).collect();
    for _ in 0..edges.len() {
        for node in 0..edges.len() {
            ending[node] |= edges[node].iter().any(|&(to, _)| ending[to]);
        }
    }
    assert!(ending.iter().all(|&e| e), "{label}: a path may continue forever");
}

fn check_plays(
    strategy: &mut FiniteMemoryStrategy<SymbolicEngine>,
    safety: Safety,
    start: &[i64],
    scheduler: Scheduler,
    bound: Option<usize>,
) {
    let steps = bound.map_or(60, |b| b as u64);
    let tally = Simulation::new(strategy, Setup { scheduler, runs: 10, steps, seed: 3 }).run(start).unwrap();
    assert_eq!(tally.runs, 10);
    match safety {
        Safety::Action => assert_eq!(tally.weakened_step, 0),
        Safety::Prefix => assert_eq!(tally.weakened_reference, 0),
        Safety::Transition => return,
    }
    if bound.is_some() {
        assert_eq!(tally.given_up, 0);
    }
    if let (Kind::Sasi, Some(_), Rank::Finite(k)) = (strategy.kind().levels(), bound, tally.rank) {
        assert_eq!(tally.fewer_than(k), 0);
    }
}

fn check(program: Program, preferences: &Arc<Preferences>, ranks: &mut Ranks) {
    let settings = Settings { scope: Scope::All, memory: 16 << 20, ..Settings::default() };
    let program = Arc::new(program);
    let engine = Arc::new(SymbolicEngine::new(Arc::clone(&program), settings).unwrap());
    for safety in [Safety::Action, Safety::Prefix, Safety::Transition] {
        let analysis = finished(&engine, preferences, Options { safety, max_level: None });
        for kind in [Kind::Sasi, Kind::Spi] {
            let mut strategy = FiniteMemoryStrategy::new(&analysis, &program, kind).unwrap();
            for start in engine.list_states(&engine.all_states(), 10).unwrap() {
                ranks.note(kind, safety, strategy.rank(&start).unwrap());
                for scheduler in [Scheduler::Permissive, Scheduler::Progress] {
                    let unfolded =
                        InducedModel::unfold(&mut strategy, std::slice::from_ref(&start), scheduler, 10_000)
                            .unwrap();
                    // The induced model follows the real system, which need not keep the guarantee of `transition`.
                    if safety != Safety::Transition {
                        check_course(
                            kind,
                            &unfolded,
                            strategy.rank(&start).unwrap(),
                            &format!("{kind} {safety} {start:?}"),
                        );
                    }
                    check_plays(&mut strategy, safety, &start, scheduler, unfolded.longest_path());
                }
            }
        }
    }
}

/// The numbers of starting states of rank 0, 1, and 2 or more. Rank 0 guarantees nothing.
#[derive(Debug, Default)]
struct Ranks(BTreeMap<(&'static str, &'static str), [usize; 3]>);

impl Ranks {
    /// True if many states have something to improve.
    fn are_enough(&self) -> bool {
        !self.0.is_empty() && self.0.values().all(|[_, one, more]| *one > share(50) && *more > share(10))
    }

    fn note(&mut self, kind: Kind, safety: Safety, rank: Rank) {
        let kind = if kind == Kind::Sasi { "SASI" } else { "SPI" };
        let safety = match safety {
            Safety::Action => "action",
            Safety::Prefix => "prefix",
            Safety::Transition => "transition",
        };
        let slot = match rank {
            Rank::Finite(k) => k.min(2),
            _ => 2,
        };
        self.0.entry((kind, safety)).or_default()[slot] += 1;
    }
}

/// A random model with its preferences, as [`program`] takes it.
type Drawn = (Vec<Vec<Vec<usize>>>, Vec<usize>, Vec<(usize, usize)>, &'static str);

/// Layers of three states; most choices leave to chance where in the next layer they lead, and what
/// lies a layer further on is mostly preferred. Others hardly ever have something to improve for sure.
fn layered() -> impl Strategy<Value = Drawn> {
    const WIDTH: usize = 3;
    let stray = prop::option::weighted(0.15, 0..12usize);
    let choice = (prop::collection::vec(prop::bool::weighted(0.75), WIDTH), stray);
    let choices = prop::collection::vec(prop::collection::vec(choice, 1..=2), WIDTH..=4 * WIDTH);
    let is_target = prop::collection::vec(prop::bool::weighted(0.9), 4 * WIDTH);
    let preferred = prop::collection::vec(prop::bool::weighted(0.85), 16 * WIDTH * WIDTH);
    let empty = prop::sample::select(vec!["bottom", "gain", "incomparable"]);
    (choices, is_target, preferred, empty).prop_map(|(drawn, is_target, preferred, empty)| {
        let n = drawn.len();
        let leads = |s: usize, (next, stray): &(Vec<bool>, Option<usize>)| {
            let first = (s / WIDTH + 1) * WIDTH;
            let onwards = (0..WIDTH).filter(|&i| next[i]).map(|i| first + i);
            let mut to: Vec<usize> = onwards.chain(*stray).map(|t| if t < n { t } else { s }).collect();
            if to.is_empty() {
                to.push(s);
            }
            to
        };
        let choices = drawn.iter().enumerate().map(|(s, all)| all.iter().map(|c| leads(s, c)).collect());
        let targets: Vec<usize> = (0..n).filter(|&s| s == 0 || is_target[s]).collect();
        let pairs = (0..targets.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
        let further = |i: usize, j: usize| targets[i] / WIDTH > targets[j] / WIDTH;
        let above = pairs.filter(|&(i, j)| further(i, j) && preferred[4 * WIDTH * i + j]).collect();
        (choices.collect(), targets, above, empty)
    })
}

#[test]
fn plays_on_random_models_keep_their_promise() {
    let config = Config { cases: share(300) as u32, failure_persistence: None, ..Config::default() };
    draw_until(&config, &layered(), Ranks::are_enough, |(choices, targets, above, empty), ranks| {
        let (program, preferences) = program(&choices, &targets, &above, empty);
        check(program, &Arc::new(preferences), ranks);
    });
}

#[test]
fn a_choice_that_is_not_safe_names_the_successor_that_is_not() {
    // From 1 the path must continue to 2, where A can not be reached any more.
    let text = "mdp module m x : [0..2] init 0; [stay] x=0 -> true; [go] x=0 -> 0.5: true + 0.5: (x'=1);\n\
        [on] x=1 -> (x'=2); endmodule";
    let (program, preferences) = task(text, "objective A = F x=1;");
    let settings = Settings { order: Order::Declared, ..Settings::default() };
    let engine = Arc::new(SymbolicEngine::new(program.clone(), settings).unwrap());
    let options = Options { safety: Safety::Prefix, ..Options::default() };
    let analysis = finished(&engine, &preferences, options);
    let mut strategy = FiniteMemoryStrategy::new(&analysis, &program, Kind::Sasi).unwrap();
    let memory = strategy.start(&[0]).unwrap();
    let actions = strategy.explain(&[0], memory).unwrap().actions;
    let go = actions.iter().find(|a| a.name == "go").unwrap();
    let bad = go.successors.iter().position(|s| s.state == [1]);
    assert_eq!(go.verdict, Verdict::Unsafe(bad));
}
