//! The methods that remove an attractor, each against the reference and the explicit engine.

use meliora::advanced::symbolic::Ways;
use proptest::prelude::*;

use crate::common::agreement;
use crate::common::prelude::*;
use crate::engines::explicit::numbers;

/// Each way to remove an attractor.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    /// The recursion over parts, with their bounds, to its end.
    Parts,
    /// The recursion over the lists of all groups, to its end.
    Lists,
    /// The recursion, and a first turn of some steps for the methods of backward reachability.
    Hasty(u64),
    /// Turns of both recursions, the first one of some steps.
    Turns(u64),
    /// The usual turns.
    Usual,
}

/// A budget that no search here spends.
const ENDLESS: usize = 1 << 40;

impl Way {
    const ALL: [Way; 8] = [
        Way::Parts,
        Way::Lists,
        Way::Hasty(1),
        Way::Hasty(20),
        Way::Turns(1),
        Way::Turns(20),
        Way::Turns(100),
        Way::Usual,
    ];

    fn thresholds(self) -> Thresholds {
        let (relations_per_bit, first_turn) = match self {
            Way::Parts => (ENDLESS, ENDLESS as u64),
            Way::Lists => (0, ENDLESS as u64),
            Way::Hasty(steps) => (0, steps),
            Way::Turns(steps) => (ENDLESS, steps),
            Way::Usual => return Thresholds::default(),
        };
        Thresholds { relations_per_bit, first_turn, ..Thresholds::default() }
    }

    /// Checks that the regions of an mdp were found in this way.
    fn was_taken(self, ways: &Ways) {
        let (parts, lists, layers) = (ways.lost_by_recursion, ways.lost_by_lists, ways.lost_by_layers);
        let is_right = match self {
            Way::Parts => lists + layers == 0,
            Way::Lists | Way::Hasty(_) => parts + layers == 0,
            Way::Turns(_) | Way::Usual => true,
        };
        assert!(is_right, "{self:?}: {ways:?}");
    }
}

fn listed<E: Engine>(engine: &E, target: &Predicate) -> Regions<Vec<State>> {
    let found = regions(engine, &engine.states_where(target).unwrap()).unwrap();
    found.map(|x| engine.list_states(&x, usize::MAX).unwrap())
}

proptest! {
    #![proptest_config(meliora_amount::random(200))]

    #[test]
    fn every_way_to_remove_an_attractor_finds_the_same(
        of in numbers(160),
        first in numbers(20),
        second in numbers(20),
    ) {
        let mut program = random_program(&of, false);
        let predicates = [random_predicate(&mut program, &first), random_predicate(&mut program, &second)];
        let program = Arc::new(program);
        let brute = Brute::new(&program, Settings::default().scope).unwrap();
        let explicit = ExplicitEngine::new(program.clone(), Settings::default()).unwrap();
        for way in Way::ALL {
            let settings = || Settings { memory: 64 << 20, thresholds: way.thresholds(), ..Settings::default() };
            let engine = SymbolicEngine::new(program.clone(), settings()).unwrap();
            for target in predicates.map(|e| program.predicate(e)) {
                prop_assert_eq!(listed(&engine, &target), listed(&explicit, &target), "{:?}", way);
            }
            // A model without steps is left to the recursion over parts.
            if way == Way::Parts {
                way.was_taken(&engine.ways());
            }
            agreement::check(&engine, &program, &brute, &predicates);
        }
    }
}

/// Modules that run down side by side: each loss has as many layers as the longest of them.
fn burning(modules: usize, thresholds: Thresholds) -> SymbolicEngine {
    let module = |i: usize| {
        let text = "module m# x# : [0..9]; [] x#<9 -> 0.5: (x#'=x#+1) + 0.5: true; endmodule ";
        text.replace('#', &i.to_string())
    };
    let none = SourceFile::new("constants", "");
    let source = SourceFile::new("m", format!("mdp {}", (0..modules).map(module).collect::<String>()));
    let program = lang::load(&source, &none).unwrap().program;
    SymbolicEngine::new(Arc::new(program), Settings { thresholds, ..Settings::default() }).unwrap()
}

#[test]
fn losses_of_many_layers_in_a_product_need_no_layers() {
    let thresholds = Thresholds { relations_per_bit: 0, ..Thresholds::default() };
    let engine = burning(6, thresholds);
    let last = engine.singleton(&[9; 6]).unwrap();
    let found = regions(&engine, &last).unwrap();
    assert_eq!(engine.count(&found.pmin_positive).unwrap(), 1_000_000u32.into());
    let ways = engine.ways();
    assert!(ways.lost_by_lists > 0 && ways.lost_by_layers == 0, "{ways:?}");
}

#[test]
fn a_game_with_barred_choices_in_a_product_needs_no_layers() {
    let thresholds = Thresholds { relations_per_bit: 0, ..Thresholds::default() };
    let engine = burning(6, thresholds);
    let x0 = engine.program().variable("x0").unwrap();
    let all = engine.all_states();
    let barred = engine.slice(&[(x0, 5)]).unwrap();
    let from = engine.difference(&all, &barred).unwrap();
    let entering = engine.pre(&engine.all_choices(), &barred).unwrap();
    let choices = engine.choices_in(&engine.difference(&engine.all_choices(), &entering).unwrap(), &from);
    let x1 = engine.program().variable("x1").unwrap();
    let goal = engine.slice(&[(x1, 5)]).unwrap();
    let labels = EdgeLabels::new(from.clone(), goal, engine.no_states());
    let labels = EdgeLabels { barred: vec![(from.clone(), barred)], ..labels };
    let start = Region { states: from, choices: choices.unwrap() };
    let found = engine.almost_surely_win(start, &[labels]).unwrap().region;
    // Where x1 is 5, a state without another step loses: with x0=9, and with x0=4 by the barred step.
    assert_eq!(engine.count(&found.states).unwrap(), 539_998u32.into());
    let ways = engine.ways();
    assert!(ways.lost_by_lists > 0 && ways.lost_by_layers == 0, "{ways:?}");
}

#[test]
fn each_way_is_taken() {
    for way in Way::ALL {
        let engine = burning(2, way.thresholds());
        let last = engine.singleton(&[9; 2]).unwrap();
        let found = regions(&engine, &last).unwrap();
        assert_eq!(engine.count(&found.pmin_positive).unwrap(), 100u32.into());
        let ways = engine.ways();
        way.was_taken(&ways);
        let own = match way {
            Way::Parts => ways.lost_by_recursion,
            Way::Lists | Way::Hasty(_) => ways.lost_by_lists,
            // Either may be the first to end.
            Way::Turns(_) => ways.lost_by_recursion + ways.lost_by_lists,
            Way::Usual => continue,
        };
        assert!(own > 0, "{way:?}: {ways:?}");
    }
}
