//! Objectives are achieved when the path so far decides them, and not before; and both engines say the
//! same of every state, of Markov chains and of deadlocks too.

use meliora::planning::tally::Trace;
use proptest::prelude::*;
use proptest::test_runner::Config;

use crate::common::coverage::draw_until;
use crate::common::graphs::{bottom_components, chain, edges};
use crate::common::prelude::*;
use crate::planning::literal::Set;

/// Writes a model in which paths start in every state.
fn model(choices: &[Vec<Vec<usize>>]) -> String {
    let last = choices.len() - 1;
    let mut text = format!("mdp\nmodule m\n  s : [0..{last}];\n");
    for (s, choices) in choices.iter().enumerate() {
        for to in choices {
            let branch = |t: &usize| format!("1/{}: (s'={})", to.len(), t.min(&last));
            text += &format!("  [] s={s} -> {};\n", to.iter().map(branch).collect::<Vec<_>>().join(" + "));
        }
    }
    text + "endmodule\ninit true endinit\n"
}

/// A formula, and whether the states of a path decide that it is true.
type Decided = (&'static str, fn(&[i64]) -> bool);

/// Formulas that some step decides, on every path that satisfies them.
const COSAFE: usize = 8;
const FORMULAS: [Decided; 20] = [
    ("F s=1", |path| path.contains(&1)),
    ("F (s=1 & F s=2)", |path| {
        path.iter().position(|&s| s == 1).is_some_and(|first| path[first..].contains(&2))
    }),
    ("!(s=1) U s=2", |path| path.iter().position(|&s| s == 2).is_some_and(|n| !path[..n].contains(&1))),
    ("F (s=1 & X s=1)", |path| path.windows(2).any(|pair| pair == [1, 1])),
    ("X X s=1", |path| path.get(2) == Some(&1)),
    ("F<=3 s=2", |path| path.iter().take(4).any(|&s| s == 2)),
    ("G<=2 !(s=1)", |path| path.len() > 2 && !path[..3].contains(&1)),
    ("(F s=1) & (G<=1 !(s=2))", |path| path.len() > 1 && path.contains(&1) && !path[..2].contains(&2)),
    ("G !(s=2)", |_| false),
    ("G F s=0", |_| false),
    ("F G !(s=1)", |_| false),
    ("G (s=1 => F s=2)", |_| false),
    ("(G F s=0) & (F s=1)", |_| false),
    ("(F s=1) | (G !(s=2))", |path| path.contains(&1)),
    ("(X s=1) | (G F s=0)", |path| path.get(1) == Some(&1)),
    ("!(s=2) W s=1", |path| path.iter().position(|&s| s == 1).is_some_and(|n| !path[..n].contains(&2))),
    ("(F s=1) W s=2", |path| {
        path.iter().position(|&s| s == 2).is_some_and(|n| path[n.saturating_sub(1)..].contains(&1) || n == 0)
    }),
    ("!(s=2) U (G s=1)", |_| false),
    ("G (s=1 => F (s=0 & G F s=2))", |_| false),
    ("s=1 R !(s=2)", |path| path.iter().position(|&s| s == 1).is_some_and(|n| !path[..n].contains(&2))),
];

#[derive(Debug, Clone)]
struct Drawn {
    choices: Vec<Vec<Vec<usize>>>,
    formulas: Vec<usize>,
    above: Vec<(usize, usize)>,
    is_chain: bool,
    from_everywhere: bool,
}

fn drawn() -> impl Strategy<Value = Drawn> {
    let leads = prop::collection::vec(0..5usize, 1..=3);
    let choices = prop::collection::vec(prop::collection::vec(leads, 0..=2), 3..=5);
    let formulas = prop::collection::vec(0..FORMULAS.len(), 1..=3);
    let above = prop::collection::vec((0..3usize, 0..3usize), 0..=3);
    (choices, formulas, above, any::<bool>(), any::<bool>()).prop_map(
        |(choices, formulas, above, is_chain, from_everywhere)| Drawn {
            choices,
            formulas,
            above,
            is_chain,
            from_everywhere,
        },
    )
}

impl Drawn {
    fn load(&self) -> (Arc<Program>, Arc<Preferences>) {
        let mut text = model(&self.choices);
        if self.is_chain {
            text = text.replacen("mdp", "dtmc", 1);
        }
        if !self.from_everywhere {
            text = text.replace("init true endinit", "");
        }
        let mut wishes = "history = play;\n".to_owned();
        for (i, &formula) in self.formulas.iter().enumerate() {
            wishes += &format!("objective o{i} = {};\n", FORMULAS[formula].0);
        }
        for (i, j) in self.above.iter().filter(|(i, j)| i > j && *i < self.formulas.len()) {
            wishes += &format!("prefer o{i} > o{j};\n");
        }
        task(text, wishes)
    }

    /// The objectives that the states of a path decide.
    fn decided(&self, path: &[i64]) -> Set {
        (0..self.formulas.len()).filter(|&o| FORMULAS[self.formulas[o]].1(path)).collect()
    }

    fn kinds(&self) -> impl Iterator<Item = (StrategyKind, Option<usize>)> {
        let achieve = (0..self.formulas.len()).map(|o| (StrategyKind::Achieve, Some(o)));
        [StrategyKind::Sasi, StrategyKind::Spi, StrategyKind::Plan]
            .map(|kind| (kind, None))
            .into_iter()
            .chain(achieve)
    }
}

type Analysed = (Arc<Program>, Analysis<AnyEngine>);

fn analysed(drawn: &Drawn, storage: Storage, safety: Safety) -> Analysed {
    let (program, preferences) = drawn.load();
    let settings = Settings { scope: Scope::Reachable, storage, memory: 16 << 20, ..Settings::default() };
    let engine = Arc::new(AnyEngine::new(Arc::clone(&program), settings).unwrap());
    let analysis = finished(&engine, &preferences, Options { safety, max_level: None });
    (program, analysis)
}

fn strategy(
    (program, analysis): &Analysed,
    (kind, objective): (StrategyKind, Option<usize>),
) -> FiniteMemoryStrategy {
    FiniteMemoryStrategy::of_kind(analysis, program, kind, kind.levels(), objective).unwrap().unwrap()
}

/// Checks each prefix of a simulated run; returns whether something was decided after the start.
fn check_run(drawn: &Drawn, start: i64, trace: &Trace) -> bool {
    let (mut path, mut achieved) = (vec![start], trace.achieved.iter().collect::<Set>());
    assert_eq!(achieved, drawn.decided(&path), "{drawn:?}, {path:?}");
    for turn in &trace.turns {
        path.push(turn.state[0]);
        achieved.extend(turn.achieved.iter());
        assert_eq!(achieved, drawn.decided(&path), "{drawn:?}, {path:?}");
    }
    achieved.len() > trace.achieved.iter().count()
}

/// Checks the runs of plans and of strategies that achieve an objective; those that achieve a co-safe
/// one end almost surely where it is achieved.
fn check_achieved(drawn: &Drawn, found: &Analysed, seen: &mut [usize; 2]) {
    let analysis = &found.1;
    let engine = analysis.engine();
    for (kind, objective) in drawn.kinds().filter(|(kind, _)| kind.name() != "sasi" && kind.name() != "spi") {
        let mut strategy = strategy(found, (kind, objective));
        for start in engine.list_states(&engine.initial_states(), 5).unwrap() {
            let sure = objective.is_some_and(|o| {
                engine.contains(&analysis.outcomes().unwrap().get(o).unwrap().almost_sure, &start).unwrap()
            });
            let cosafe = objective.is_some_and(|o| drawn.formulas[o] < COSAFE);
            for scheduler in [Scheduler::Progress, Scheduler::Permissive] {
                let setup = Setup { scheduler, runs: 5, steps: 12, seed: 1 };
                let mut each = |trace: &Trace| seen[0] += usize::from(check_run(drawn, start[0], trace));
                Simulation::new(&mut strategy, setup).run_each(&start, &mut each).unwrap();
                if sure && cosafe {
                    check_ends(&mut strategy, &start, scheduler);
                    seen[1] += 1;
                }
            }
        }
    }
}

/// Almost surely, the induced chain reaches a state where the objective is achieved.
fn check_ends(strategy: &mut FiniteMemoryStrategy, start: &[i64], scheduler: Scheduler) {
    let unfolded = InducedModel::unfold(strategy, &[start.to_vec()], scheduler, 10_000).unwrap();
    assert!(unfolded.complete);
    for component in bottom_components(&chain(&edges(&unfolded)), 0, &Set::new()) {
        let at = |node: &usize| &unfolded.nodes[*node].at;
        assert!(component.iter().all(|node| at(node).is_achieved()), "{component:?}: {unfolded:?}");
    }
}

#[test]
fn an_objective_is_achieved_when_the_path_decides_it_and_not_before() {
    let config = Config { cases: share(150) as u32, failure_persistence: None, ..Config::default() };
    let enough = |seen: &[usize; 2]| seen[0] > share(500) && seen[1] > share(100);
    draw_until(&config, &(drawn(), any::<bool>()), enough, |(drawn, symbolic), seen| {
        let storage = if symbolic { Storage::Symbolic } else { Storage::Explicit };
        for &safety in Safety::ALL {
            check_achieved(&drawn, &analysed(&drawn, storage, safety), seen);
        }
    });
}
