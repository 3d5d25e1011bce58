//! The opponent's moves in pages, against the steps of each state and the other engine.

use meliora::model::diagram::Edge;
use meliora::projections::{self, MoveView, Plane, Projections};
use proptest::prelude::*;

use super::levels::{Case, some_case};
use super::raw::loaded;
use super::{settings, thresholds};
use crate::common::prelude::*;

/// The results of a move: the ranks of both kinds after it, and whether it may and surely does improve and weaken.
type Leads = (BTreeSet<usize>, BTreeSet<usize>, [bool; 4]);

/// The place of a rank in the lists of a move.
fn place(rank: Rank, levels: usize) -> usize {
    match rank {
        Rank::Finite(k) | Rank::AtLeast(k) => k,
        Rank::Unbounded => levels,
    }
}

/// Returns what a page says about a move in a state.
fn shown(projections: &Projections, of: &MoveView, state: &[i64]) -> Leads {
    let view = state.iter().map(|&value| Some(value)).collect();
    let holds = |edge: Edge| projections.holds(edge, &view);
    let ranks = |edges: &[Edge]| (0..edges.len()).filter(|&k| holds(edges[k])).collect();
    let effects = [of.may_improve, of.improves, of.may_weaken, of.weakens].map(holds);
    (ranks(&of.sasi), ranks(&of.spi), effects)
}

/// Returns the results of a step, by the explicit engine.
fn led(analysis: &Analysis<ExplicitEngine>, state: &[i64], step: &Step) -> Leads {
    let (engine, classes) = (analysis.engine(), analysis.classes().unwrap());
    let after: Vec<&[i64]> = step.successors.iter().map(|(to, _)| to.as_slice()).collect();
    let ranks = |kind: Kind| -> BTreeSet<usize> {
        let levels = analysis.levels(kind);
        let rank = |to: &&[i64]| place(levels.rank(engine, to).unwrap(), levels.found.len());
        after.iter().map(rank).collect()
    };
    let mp = |state: &[i64]| classes.most_preferred(engine, state).unwrap();
    let is = |change: Change| move |to: &&[i64]| analysis.preferences().change(&mp(state), &mp(to)) == change;
    let both = |change: Change| [after.iter().any(is(change)), after.iter().all(is(change))];
    let ([may_improve, improves], [may_weaken, weakens]) = (both(Change::Improving), both(Change::Weakening));
    (ranks(Kind::Sasi), ranks(Kind::Spi), [may_improve, improves, may_weaken, weakens])
}

fn check(case: &Case) {
    let (program, preferences) = loaded(&case.raw.text(), &case.preferences());
    let settings = || settings(Scope::All, thresholds()[0]);
    let symbolic = Arc::new(SymbolicEngine::new(program.clone(), settings()).unwrap());
    let explicit = Arc::new(ExplicitEngine::new(program.clone(), settings()).unwrap());
    let mut drawn = Analysis::new(&symbolic, &preferences, Options::default());
    let mut listed = Analysis::new(&explicit, &preferences, Options::default());
    drawn.run(&mut |_| ()).unwrap();
    listed.run(&mut |_| ()).unwrap();
    let plane = Plane { row: None, column: VarId(0) };
    let projections = projections::build(&drawn, plane, &[0], usize::MAX).unwrap();
    let game = projections.game.as_ref().unwrap();
    for s in 0..case.raw.len() {
        let state = [s as i64];
        assert_eq!(
            projections.is_theirs(&vec![Some(state[0])]),
            case.raw.theirs[s],
            "owner of {s}: {case:?}"
        );
        let steps = match case.raw.theirs[s] && !listed.is_unsafe(&state).unwrap() {
            true => program.steps(&state).unwrap(),
            false => Vec::new(),
        };
        let enabled = |m: &&MoveView| projections.holds(m.enabled, &vec![Some(state[0])]);
        assert_eq!(game.moves.iter().filter(enabled).count(), steps.len(), "moves in {s}: {case:?}");
        for step in &steps {
            // Commands that are never enabled together are one choice.
            let is_it = |m: &&MoveView| projections.choices[m.choice].name.split('|').any(|n| n == step.name);
            let of = game.moves.iter().filter(enabled).find(is_it).unwrap();
            let (shown, led) = (shown(&projections, of, &state), led(&listed, &state, step));
            assert_eq!(shown, led, "{} in {s}: {case:?}", step.name);
        }
    }
}

proptest! {
    #![proptest_config(crate::common::amount::random(300))]

    #[test]
    fn moves_lead_where_their_steps_do(case in some_case()) {
        check(&case);
    }
}
