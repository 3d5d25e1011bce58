//! The regions of random games, against nested fixpoints by their definition.

use bitvec::vec::BitVec;

use crate::graphs::game_graph::{Edge, GameGraph};
use crate::graphs::meter::Meter;
use crate::solvers::sides::Sides;
use meliora_amount::share;
use meliora_base::random::Draw;
use meliora_engine::NoProgress;

/// A random game with a set of maximisers, a target, the states through which it is reached, and choices that are
/// allowed or gain.
struct Made {
    game: GameGraph,
    maximisers: BitVec,
    target: BitVec,
    left: BitVec,
    allowed: BitVec,
    gains: BitVec,
}

fn made(draw: &mut Draw) -> Made {
    let (mut game, states) = (GameGraph::default(), 1 + draw.below(9));
    let mut allowed = BitVec::new();
    for _ in 0..states {
        let choices = 1 + draw.below(3);
        for choice in 0..choices {
            (0..=draw.below(3)).for_each(|_| game.add_edge(Edge::new(draw.below(states) as u32, 0, false)));
            game.end_choice();
            // At least one choice of a state is allowed.
            allowed.push(choice == 0 || draw.below(4) > 0);
        }
        game.end_node();
    }
    let mut set =
        |count: usize, often: usize| -> BitVec { (0..count).map(|_| draw.below(often) > 0).collect() };
    let maximisers = [BitVec::repeat(true, states), BitVec::repeat(false, states), set(states, 2)];
    let (target, left, gains) = (!set(states, 4), set(states, 6), !set(allowed.len(), 4));
    let maximisers = maximisers[draw.below(3)].clone();
    Made { game, maximisers, target, left, allowed, gains }
}

impl Made {
    /// νY. μX. T ∪ { s in `left`: a maximiser has an allowed choice, a minimiser has only allowed choices that stay in
    /// Y and hit or have a successor in X }
    fn nested(
        &self,
        target: &BitVec,
        left: &BitVec,
        allowed: &BitVec,
        hits: impl Fn(usize) -> bool,
    ) -> BitVec {
        let mut y = BitVec::repeat(true, left.len());
        loop {
            let mut x = target.clone();
            loop {
                let good = |choice: usize| {
                    let to = self.game.choices.successors(choice);
                    to.iter().all(|&to| y[to as usize])
                        && (hits(choice) || to.iter().any(|&to| x[to as usize]))
                };
                let own = |state: usize| {
                    let mut own = self.game.choices.of(state as u32).filter(|&choice| allowed[choice]);
                    match self.maximisers[state] {
                        true => own.any(good),
                        false => own.clone().next().is_some() && own.all(good),
                    }
                };
                let next: BitVec = (0..left.len()).map(|s| target[s] || left[s] && own(s)).collect();
                if next == x {
                    break;
                }
                x = next;
            }
            if x == y {
                return y;
            }
            y = x;
        }
    }
}

#[test]
fn almost_sure_regions_are_nested_fixpoints() {
    let (mut draw, meter, mut kinds) = (Draw::new(20), &mut Meter::unlimited(&NoProgress), [0; 3]);
    for _ in 0..share(20_000) {
        let made = made(&mut draw);
        let Made { game, maximisers, target, left, allowed, .. } = &made;
        let sides = Sides::new(&game.choices, maximisers, allowed, meter).unwrap();
        let found = sides.almost_sure(target, left, meter).unwrap();
        assert_eq!(found, made.nested(target, left, allowed, |_| false));
        let positive = sides.positive(target, left);
        kinds[if found == positive {
            0
        } else if found == *target {
            1
        } else {
            2
        }] += 1;
    }
    assert!(kinds.iter().all(|&count| count > share(500)), "{kinds:?}");
}

#[test]
fn recurring_choices_are_nested_fixpoints_again_and_again() {
    let (mut draw, meter, mut some) = (Draw::new(21), &mut Meter::unlimited(&NoProgress), 0);
    for _ in 0..share(20_000) {
        let is_max = draw.below(2) == 0;
        let made = made(&mut draw);
        let states = made.left.len();
        let made = Made { maximisers: BitVec::repeat(is_max, states), ..made };
        let Made { game, maximisers, left, allowed, gains, .. } = &made;
        let sides = Sides::new(&game.choices, maximisers, allowed, meter).unwrap();
        let found = sides.recurring(gains, left, meter).unwrap();
        // Without the other side: the states that reach one where the choices can be taken again and again.
        let none = BitVec::repeat(false, states);
        let sure = made.nested(&none, left, allowed, |choice| gains[choice]);
        if is_max {
            assert_eq!(found, sides.positive(&sure, left));
            some += usize::from(found.any());
        } else {
            assert!(sure.iter_ones().all(|state| found[state]));
        }
    }
    assert!(some > share(2000), "{some}");
}
