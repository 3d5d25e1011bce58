//! The paper's robot on the 5 x 5 grid, written by hand from its description.

use meliora::planning::strategy;

use crate::common::prelude::*;
use crate::planning::tiny::{Mdp, Tiny};
use crate::planning::{Case, analyse};

type Cell = (i64, i64);
/// Row, column, battery, flags of D, E, F and the charger.
type State = (Cell, i64, [bool; 4]);

const OBSTACLES: [Cell; 5] = [(0, 2), (1, 0), (3, 0), (1, 4), (3, 4)];
const SLIPPERY: [Cell; 4] = [(1, 1), (3, 1), (1, 3), (3, 3)];
const MOVES: [Cell; 4] = [(1, 0), (-1, 0), (0, 1), (0, -1)];
const BATTERY: i64 = 8;

fn index(((r, c), b, flags): State) -> usize {
    let bits = flags.iter().fold(0, |bits, &f| 2 * bits + usize::from(f));
    (((r * 5 + c) * (BATTERY + 1) + b) as usize) * 16 + bits
}

fn state(index: usize) -> State {
    let (cell, bits) = (index as i64 / 16, index % 16);
    let (place, b) = (cell / (BATTERY + 1), cell % (BATTERY + 1));
    ((place / 5, place % 5), b, [8, 4, 2, 1].map(|bit| bits & bit != 0))
}

/// Returns the neighbour of `to`, or `from` if that neighbour is outside the grid or an obstacle.
fn resolve(from: Cell, to: Cell, (dr, dc): Cell) -> Cell {
    let cell = (to.0 + dr, to.1 + dc);
    let inside = (0..5).contains(&cell.0) && (0..5).contains(&cell.1);
    if inside && !OBSTACLES.contains(&cell) { cell } else { from }
}

fn landings(from: Cell, direction: Cell) -> Vec<Cell> {
    let to = resolve(from, from, direction);
    if to == from || !SLIPPERY.contains(&to) {
        return vec![to];
    }
    let mut slips = vec![(0, 0), (1, 0), (-1, 0)];
    slips.extend((to == (3, 3)).then_some((0, -1)));
    slips.into_iter().map(|slip| resolve(from, to, slip)).collect()
}

fn arrive(cell: Cell, battery: i64, [mut d, mut e, mut f, mut charger]: [bool; 4]) -> State {
    let full = cell == (0, 4) && charger;
    let (ab, c) = (cell == (0, 0) || cell == (2, 0), cell == (4, 0));
    d |= ab;
    e |= ab || c;
    f |= c;
    charger |= ab || c;
    (cell, if full { BATTERY } else { battery - 1 }, [d, e, f, charger])
}

fn choices(s: usize) -> Vec<Vec<usize>> {
    let (cell, battery, flags) = state(s);
    if battery == 0 {
        return vec![vec![s]; 4];
    }
    let tunnel = cell == (2, 2) || cell == (4, 2);
    let directions = &MOVES[..if tunnel { 2 } else { 4 }];
    let step = |&direction: &Cell| {
        landings(cell, direction).into_iter().map(|to| index(arrive(to, battery, flags))).collect()
    };
    directions.iter().map(step).collect()
}

fn robot() -> Case {
    let where_is = |holds: &dyn Fn(State) -> bool| (0..3600).filter(|&s| holds(state(s))).collect();
    let item = |cell: Cell, flag: Option<usize>| -> Vec<usize> {
        where_is(&|(at, _, flags)| at == cell && flag.is_none_or(|f| flags[f]))
    };
    let targets = vec![
        item((0, 0), None),
        item((2, 0), None),
        item((4, 0), None),
        item((2, 4), Some(0)),
        item((4, 4), Some(1)),
        item((1, 2), Some(2)),
    ];
    let strict = |&(left, right): &(usize, usize)| Statement { left, relation: Relation::Strict, right };
    let statements = [(3, 0), (4, 0), (3, 1), (4, 1), (4, 2), (5, 2)].iter().map(strict).collect();
    Case { mdp: Mdp::new((0..3600).map(choices).collect()), targets, statements }
}

fn level_sizes(analysis: &Analysis<Tiny>, kind: Kind) -> String {
    let result = analysis.result();
    let counts = if kind == Kind::Sasi { &result.sasi } else { &result.spi };
    let sizes = counts.levels.iter().map(ToString::to_string).collect::<Vec<_>>().join(",");
    format!("{sizes};{}", counts.unbounded().unwrap())
}

/// Safety, transitions of the improvement MDP, and the level sizes with that of the fixpoint.
type Row = (Safety, Option<u32>, &'static str, &'static str);

fn check(empty: Empty) -> impl Fn(&[Row]) {
    move |rows| {
        let case = robot();
        let engine = case.engine();
        let preferences = case.preferences(&engine, empty);
        for &(safety, transitions, sasi, spi) in rows {
            let analysis = analyse(&engine, &preferences, safety);
            let counts = analysis.result().counts.clone().unwrap();
            assert_eq!((counts.states, counts.transitions), (3600u32.into(), 18496u32.into()));
            let sizes = analysis.result().improvement.clone();
            assert_eq!(sizes.map(|s| s.transitions), transitions.map(Into::into));
            assert_eq!(level_sizes(&analysis, Kind::Sasi), sasi, "{safety} {empty}");
            assert_eq!(level_sizes(&analysis, Kind::Spi), spi, "{safety} {empty}");
        }
    }
}

#[test]
fn the_paper_s_numbers_follow_from_gain_and_transition() {
    check(Empty::Gain)(&[
        (Safety::Transition, Some(35524), "768,98;0", "1946,1477,1165,1010,1004;1004"),
        (Safety::Action, Some(34844), "760,96;0", "1929,1464,1152,997,991;991"),
        (Safety::Prefix, None, "285;0", "955,246;0"),
    ]);
}

#[test]
fn the_robot_has_fewer_improvements_if_nothing_is_worth_least() {
    check(Empty::Bottom)(&[
        (Safety::Transition, Some(31312), "287;0", "798,101;0"),
        (Safety::Action, Some(29306), "285;0", "706,97;0"),
        (Safety::Prefix, None, "285;0", "746,123;0"),
    ]);
}

#[test]
fn the_robot_hardly_improves_if_nothing_is_incomparable() {
    check(Empty::Incomparable)(&[
        (Safety::Transition, Some(35524), "2;0", "444,6;0"),
        (Safety::Action, Some(34844), ";0", "364,2;0"),
        (Safety::Prefix, None, ";0", "463,1;0"),
    ]);
}

#[test]
fn the_robot_may_take_the_actions_that_the_paper_tells() {
    let case = robot();
    let engine = case.engine();
    let preferences = case.preferences(&engine, Empty::Gain);
    let analysis = analyse(&engine, &preferences, Safety::Transition);
    let permitted = |kind: Kind, rank: Rank, s: usize| {
        let (classes, improvement) = (analysis.classes().unwrap(), analysis.improvement().unwrap());
        let level = analysis.levels(kind).level(rank).unwrap();
        let all = strategy::permitted_at_start(&*engine, kind, classes, improvement, level).unwrap();
        engine.rows(&all)[s].iter().map(|&a| ["N", "S", "E", "W"][a]).collect::<Vec<_>>()
    };
    let rank = |kind: Kind, s: usize| analysis.levels(kind).rank(&engine, &[s as i64]).unwrap();
    let start = index(((2, 2), 8, [false; 4]));
    assert_eq!(rank(Kind::Sasi, start), Rank::Finite(2));
    assert_eq!(permitted(Kind::Sasi, Rank::Finite(2), start), ["N"]);
    assert_eq!(permitted(Kind::Spi, rank(Kind::Spi, start), start), ["N", "S"]);
    let north = index(((3, 2), 7, [false; 4]));
    assert_eq!(permitted(Kind::Sasi, rank(Kind::Sasi, north), north), ["W"]);
    assert!(engine.contains(&analysis.levels(Kind::Sasi).found[1].states, &[north as i64]).unwrap());
}
