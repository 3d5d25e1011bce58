//! Small models, each of which shows one property of the planning algorithms.

use meliora::model::preference::{Empty, Relation, Statement};
use meliora::planning::result::LevelsEnd;
use meliora::planning::{Event, Kind, Phase, Rank, Safety};

use crate::planning::tiny::Mdp;
use crate::planning::{Case, analyse};

fn above(pairs: &[(usize, usize)]) -> Vec<Statement> {
    pairs.iter().map(|&(left, right)| Statement { left, relation: Relation::Strict, right }).collect()
}

/// The paper's Example 1.
pub(crate) fn toy() -> Case {
    let from_start = vec![vec![1, 5], vec![2, 3], vec![3, 4]];
    let mdp = Mdp::new(vec![from_start, vec![], vec![], vec![], vec![], vec![vec![1]]]);
    Case { mdp, targets: vec![vec![1, 5], vec![2, 4], vec![3]], statements: above(&[(1, 0), (2, 0)]) }
}

/// Each of three states may wait, or try the next one, which improves on it, around a circle; a try may
/// also end in a sink. (Without waiting, no state would be safe against the one before it.)
pub(crate) fn circle(sink: &[usize]) -> Case {
    let mdp = Mdp::new(vec![
        vec![vec![0], vec![1, 3]],
        vec![vec![1], vec![2, 3]],
        vec![vec![2], vec![0, 3]],
        vec![],
    ]);
    let (zero, one, two) = (vec![0], vec![1], vec![2]);
    let targets = vec![zero.clone(), one.clone(), one, two.clone(), two, zero, sink.to_vec()];
    Case { mdp, targets, statements: above(&[(1, 0), (3, 2), (5, 4)]) }
}

#[test]
fn spi_can_be_unbounded_in_every_mode() {
    let case = circle(&[3]);
    let engine = case.engine();
    for &empty in Empty::ALL {
        let preferences = case.preferences(&engine, empty);
        for &safety in Safety::ALL {
            let analysis = analyse(&engine, &preferences, safety);
            let spi = analysis.levels(Kind::Spi);
            assert_eq!(spi.rank(&engine, &[0]).unwrap(), Rank::Unbounded, "{safety} {empty}");
            assert_eq!(spi.rank(&engine, &[3]).unwrap(), Rank::Finite(0));
            assert_eq!(analysis.result().spi.end, LevelsEnd::Unbounded(3u32.into()));
            assert_eq!(analysis.result().spi.unbounded(), analysis.result().spi.levels.last().cloned());
        }
    }
}

#[test]
fn sasi_can_be_unbounded_under_transition_only() {
    // The sink achieves nothing: entering it weakens, and only `transition` pretends it does not happen.
    let case = circle(&[]);
    let engine = case.engine();
    let preferences = case.preferences(&engine, Empty::Bottom);
    for (safety, rank) in [
        (Safety::Transition, Rank::Unbounded),
        (Safety::Action, Rank::Finite(0)),
        (Safety::Prefix, Rank::Finite(0)),
    ] {
        let analysis = analyse(&engine, &preferences, safety);
        assert_eq!(analysis.levels(Kind::Sasi).rank(&engine, &[0]).unwrap(), rank, "{safety}");
    }
}

#[test]
fn a_fixpoint_strategy_stays_in_the_fixpoint() {
    // State 0 may improve into the circle or into a state from which nothing improves.
    let mut case = circle(&[3]);
    case.mdp.0.extend([vec![vec![0], vec![5]], vec![vec![5]]]);
    case.targets.extend([vec![5], vec![4]]);
    let engine = case.engine();
    let preferences = case.preferences(&engine, Empty::Gain);
    let analysis = analyse(&engine, &preferences, Safety::Action);
    let spi = analysis.levels(Kind::Spi);
    let rank = spi.rank(&engine, &[0]).unwrap();
    assert_eq!(rank, Rank::Unbounded);
    let fixpoint = spi.level(rank).unwrap();
    for game in &fixpoint.games {
        for m in &game.edge_labels {
            assert!(m.goal.is_subset(&fixpoint.states));
        }
    }
}

#[test]
fn a_model_without_objectives_has_one_class_and_no_level() {
    let case = Case { mdp: toy().mdp, targets: vec![], statements: vec![] };
    let engine = case.engine();
    for &empty in Empty::ALL {
        let preferences = case.preferences(&engine, empty);
        for &safety in Safety::ALL {
            let analysis = analyse(&engine, &preferences, safety);
            assert_eq!(analysis.classes().unwrap().list.len(), 1);
            assert_eq!(analysis.result().sasi.end, LevelsEnd::Empty);
            assert_eq!(analysis.result().spi.levels, []);
        }
    }
}

#[test]
fn the_listener_hears_phases_in_order_and_each_level() {
    let case = toy();
    let engine = case.engine();
    let preferences = case.preferences(&engine, Empty::Bottom);
    let mut analysis = meliora::planning::Analysis::new(&engine, &preferences, Default::default());
    let (mut phases, mut levels, mut objectives) = (Vec::new(), Vec::new(), Vec::new());
    let (mut heard, mut parts) = (meliora::AnalysisResult::default(), Vec::new());
    let mut hear = |event: Event<'_>| {
        heard.add(event);
        match event {
            Event::Started(phase) => phases.push((phase, true)),
            Event::Part(_, part) => parts.push(part.to_owned()),
            Event::Finished(phase, _) => phases.push((phase, false)),
            Event::Level(kind, number, count) => levels.push((kind, number, count.clone())),
            Event::Objective(counts) => objectives.push(counts.objective),
            _ => {}
        }
    };
    analysis.run(&mut hear).unwrap();
    analysis.run_jointly(&mut hear).unwrap();
    assert_eq!(&heard, analysis.result(), "the events have all results");
    assert_eq!(parts[..4], ["", "objective 1 of 3", "objective 2 of 3", "objective 3 of 3"]);
    assert_eq!(parts[4..], ["", "level 1", "level 2", "level 1", "level 2"]);
    let order = [Phase::Counts, Phase::Outcomes, Phase::Improvement, Phase::Sasi, Phase::Spi];
    assert_eq!(phases, order.iter().flat_map(|&p| [(p, true), (p, false)]).collect::<Vec<_>>());
    assert_eq!(levels, [(Kind::Sasi, 1, 1u32.into()), (Kind::Spi, 1, 1u32.into())]);
    assert_eq!(objectives, [0, 1, 2]);
}
