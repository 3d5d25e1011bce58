//! Strategies, re-checked on the Markov chains that they induce. Cases come from [`crate::planning::versus_literal`].

use meliora::planning::improvement::Arena;
use meliora::planning::levels::{Game, Level};
use meliora::planning::strategy::{ArenaStrategy, is_goal, permitted_at_start, strategies};

use crate::common::graphs::{bottom_components, reached};
use crate::common::prelude::*;
use crate::planning::literal::{Literal, Set};
use crate::planning::tiny::Tiny;

/// One arena at one level, with what the definitions say of its edges.
struct Play<'a> {
    literal: &'a Literal<'a>,
    safety: Safety,
    /// MP of the reference class under `prefix`, with its safe states.
    reference: Option<(Set, Set)>,
    /// W_{k-1}
    entered: Set,
}

impl Play<'_> {
    fn kept(&self, s: usize, a: usize) -> Vec<usize> {
        let successors = &self.literal.case.mdp.0[s][a];
        match &self.reference {
            Some((_, safe)) if safe.contains(&s) && successors.iter().all(|t| safe.contains(t)) => {
                successors.clone()
            }
            Some(_) => Vec::new(),
            None => self.literal.kept(self.safety, s, a),
        }
    }

    fn is_goal(&self, s: usize, t: usize) -> bool {
        let from = self.reference.as_ref().map_or(&self.literal.mp[s], |(class, _)| class);
        let to = &self.literal.mp[t];
        self.entered.contains(&t) && self.literal.improves(from, to) && !self.literal.weakens(from, to)
    }

    /// The chain of these choices; state |S| is the goal.
    fn chain(&self, scheduler: &[Vec<usize>]) -> Vec<Vec<usize>> {
        let goal = scheduler.len();
        let node = |s: usize, t: usize| if self.is_goal(s, t) { goal } else { t };
        let row = |s: usize| {
            let kept = scheduler[s].iter().flat_map(|&a| self.kept(s, a));
            kept.map(|t| node(s, t)).collect::<Vec<_>>()
        };
        (0..goal).map(row).chain([vec![goal]]).collect()
    }

    /// The permitted choices of a state by the definition, given the winning states.
    fn permits(&self, kind: Kind, won: &Set, s: usize, a: usize) -> bool {
        let kept = self.kept(s, a);
        let good = |t: &usize| won.contains(t) || self.is_goal(s, *t);
        won.contains(&s)
            && match kind {
                Kind::Sasi => !kept.is_empty() && kept.iter().all(good),
                Kind::Spi => kept.iter().any(good),
            }
    }
}

fn wins(kind: Kind, chain: &[Vec<usize>], s: usize) -> bool {
    let goal = chain.len() - 1;
    let absorbing = Set::from([goal]);
    match kind {
        Kind::Sasi => bottom_components(chain, s, &absorbing) == [absorbing.clone()],
        Kind::Spi => reached(chain, s, &absorbing).contains(&goal),
    }
}

fn check_strategy(engine: &Tiny, kind: Kind, play: &Play<'_>, strategy: &ArenaStrategy<Tiny>) {
    let won = &strategy.states;
    let permitted = engine.rows(&strategy.permissive);
    for (s, chosen) in permitted.iter().enumerate() {
        let all = 0..play.literal.case.mdp.0[s].len();
        let by_definition: Vec<usize> = all.filter(|&a| play.permits(kind, won, s, a)).collect();
        assert_eq!(*chosen, by_definition, "permitted in {s}");
    }
    let progress = engine.rows(&strategy.progress);
    let first: Vec<Vec<usize>> = progress.iter().map(|p| p.iter().copied().take(1).collect()).collect();
    let last: Vec<Vec<usize>> =
        progress.iter().map(|p| p.iter().copied().last().into_iter().collect()).collect();
    for scheduler in [&permitted, &first, &last] {
        let chain = play.chain(scheduler);
        for &s in won {
            assert!(wins(kind, &chain, s), "{kind} does not win from {s}");
        }
    }
    let mut layered = Set::new();
    for layer in &strategy.layers {
        assert!(!layer.is_empty() && layered.is_disjoint(layer));
        layered.extend(layer);
    }
    assert_eq!(layered, *won);
}

fn check_goals(engine: &Tiny, play: &Play<'_>, arena: &Arena<Tiny>, game: &Game<Tiny>) {
    for &s in &arena.states {
        for t in (0..play.literal.case.mdp.0[s].len()).flat_map(|a| play.kept(s, a)) {
            let found = is_goal(engine, game, &[s as i64], &[t as i64]).unwrap();
            assert_eq!(found, play.is_goal(s, t), "goal edge {s} -> {t}");
        }
    }
}

fn check_level(
    analysis: &Analysis<Tiny>,
    literal: &Literal<'_>,
    kind: Kind,
    level: &Level<Tiny>,
    entered: &Set,
) {
    let engine = analysis.engine();
    let (improvement, classes) = (analysis.improvement().unwrap(), analysis.classes().unwrap());
    let all = strategies(engine, kind, improvement, level).unwrap();
    assert_eq!(all.len(), improvement.arenas.len());
    let start = permitted_at_start(engine, kind, classes, improvement, level).unwrap();
    for ((strategy, arena), game) in all.iter().zip(&improvement.arenas).zip(&level.games) {
        let reference = strategy.reference.map(|c| {
            let mp: Set = classes.list[c].most_preferred.iter().collect();
            (mp.clone(), literal.safe(&mp))
        });
        let play = Play { literal, safety: improvement.safety, reference, entered: entered.clone() };
        check_strategy(engine, kind, &play, strategy);
        check_goals(engine, &play, arena, game);
        for (s, permitted) in engine.rows(&strategy.permissive).iter().enumerate() {
            let own = play.reference.as_ref().is_none_or(|(class, _)| *class == literal.mp[s]);
            assert!(!own || engine.rows(&start)[s] == *permitted);
        }
    }
    assert_eq!(engine.sources(&start).unwrap(), level.states);
}

/// Checks the strategies of all levels.
pub(crate) fn check(analysis: &Analysis<Tiny>, literal: &Literal<'_>) {
    for kind in [Kind::Sasi, Kind::Spi] {
        let mut entered: Set = (0..literal.case.mdp.0.len()).collect();
        let levels = analysis.levels(kind);
        for level in levels.found.iter().chain(levels.unbounded()) {
            check_level(analysis, literal, kind, level, &entered);
            entered = level.states.clone();
        }
    }
}

/// Checks that no kept choice weakens the outcomes that the safety option protects.
pub(crate) fn check_kept(analysis: &Analysis<Tiny>, literal: &Literal<'_>) {
    let classes = analysis.classes().unwrap();
    let improvement = analysis.improvement().unwrap();
    for arena in &improvement.arenas {
        let kept = analysis.engine().rows(&arena.choices);
        for &s in &arena.states {
            let from = match arena.reference {
                Some(c) => classes.list[c].most_preferred.iter().collect(),
                None => literal.mp[s].clone(),
            };
            for (a, successors) in literal.case.mdp.0[s].iter().enumerate() {
                let safe = successors.iter().all(|&t| !literal.weakens(&from, &literal.mp[t]));
                assert!(!kept[s].contains(&a) || safe, "{}: {s} by {a}", improvement.safety);
            }
        }
    }
}
