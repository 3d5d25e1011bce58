//! The methods that remove an attractor, each against the reference and the explicit engine.

use std::sync::Arc;

use meliora::advanced::symbolic::{Thresholds, Ways};
use meliora::engine::regions::{Regions, pmin_positive, regions};
use meliora::engine::{Algebra, EdgeLabels, Engine, ExplicitEngine, Region, Settings, SymbolicEngine};
use meliora::error::SourceFile;
use meliora::lang;
use meliora::model::predicate::Predicate;
use meliora::model::{State, VarId};
use proptest::prelude::*;

use crate::common::agreement;
use crate::common::brute::Brute;
use crate::common::random_program::{random_predicate, random_program};
use crate::explicit::numbers;

/// Each way to remove an attractor.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    /// The recursion over parts, with their bounds, which never gives up.
    Parts,
    /// The recursion over the lists of all groups, which never gives up.
    Lists,
    /// Layers of states alone, which never give up.
    States,
    /// Turns of that recursion and of layers, the first after this many steps, or after half of them if the
    /// sets have grown.
    Turns(u64),
    /// Layers of states for four times this many steps; then these turns, each recursion with two steps more per
    /// node of the candidates.
    StatesFirst(u64),
    /// The usual order of attempts, with a few steps for each method of backward reachability. Where that
    /// ends by layers, layers of states come first here, too.
    Hasty,
    /// The usual order of attempts.
    Usual,
}

/// A budget that no search here spends.
const ENDLESS: usize = 1 << 40;

/// The usual order of attempts without parts, with some steps for each method of backward reachability.
fn hasty(trial_steps: u64) -> Thresholds {
    Thresholds {
        relations_per_bit: 0,
        most_shared_percent: 0,
        trial_steps,
        trial_steps_per_node: 0,
        ..Thresholds::default()
    }
}

impl Way {
    const ALL: [Way; 10] = [
        Way::Parts,
        Way::Lists,
        Way::States,
        Way::Turns(1),
        Way::Turns(20),
        Way::Turns(100),
        Way::StatesFirst(1),
        Way::StatesFirst(20),
        Way::Hasty,
        Way::Usual,
    ];

    fn thresholds(self) -> Thresholds {
        let usual = Thresholds::default();
        let (free_cases, free_steps) = (ENDLESS, ENDLESS as u64);
        let without_parts = Thresholds { relations_per_bit: 0, ..usual };
        let states_first = Thresholds {
            shared_by_percent: 0,
            most_shared_percent: 100,
            nodes_per_bit: ENDLESS,
            ..without_parts
        };
        match self {
            Way::Parts => Thresholds { relations_per_bit: ENDLESS, free_cases, free_steps, ..usual },
            Way::Lists => Thresholds { lose_steps: u64::MAX, most_shared_percent: 0, ..without_parts },
            Way::States => Thresholds { lose_steps: u64::MAX, ..states_first },
            Way::Turns(lose_steps) => Thresholds {
                lose_steps,
                lose_steps_per_node: 0,
                lose_trial_steps: lose_steps / 2,
                lose_growth: 1,
                ..without_parts
            },
            Way::StatesFirst(lose_steps) => {
                Thresholds { lose_steps, lose_steps_per_node: 2, lose_trial_steps: 1, ..states_first }
            }
            Way::Hasty => hasty(1),
            Way::Usual => usual,
        }
    }

    /// Checks that the regions of an mdp were found in this way.
    fn was_taken(self, ways: &Ways) {
        let (parts, lists, layers) = (ways.lost_by_recursion, ways.lost_by_lists, ways.lost_by_layers);
        let is_right = match self {
            Way::Parts => lists + layers + ways.given_up == 0,
            Way::Lists => parts + layers == 0,
            Way::States => parts + lists + layers == 0,
            Way::Turns(_) | Way::StatesFirst(_) | Way::Hasty => parts == 0,
            Way::Usual => true,
        };
        assert!(is_right, "{self:?}: {ways:?}");
    }
}

fn listed<E: Engine>(engine: &E, target: &Predicate) -> Regions<Vec<State>> {
    let found = regions(engine, &engine.states_where(target).unwrap()).unwrap();
    found.map(|x| engine.list_states(&x, usize::MAX).unwrap())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

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
    climbing(modules, "true", thresholds)
}

/// Modules with ten values each. A step counts one of them up, or does something else.
fn climbing(modules: usize, other: &str, thresholds: Thresholds) -> SymbolicEngine {
    let module = |i: usize| {
        let text = "module m# x# : [0..9]; [] x#<9 -> 0.5: (x#'=x#+1) + 0.5: OTHER; endmodule ";
        text.replace("OTHER", other).replace('#', &i.to_string())
    };
    engine_of(format!("mdp {}", (0..modules).map(module).collect::<String>()), thresholds)
}

fn engine_of(text: String, thresholds: Thresholds) -> SymbolicEngine {
    let none = SourceFile::new("constants", "");
    let source = SourceFile::new("m", text);
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

/// Two stations with a common clock, which wait for each other to be silent before they send.
fn stations(thresholds: Thresholds) -> SymbolicEngine {
    let station = |i: usize, j: usize| {
        format!(
            "module station{i} s{i} : [0..3]; t{i} : [0..6]; slot{i} : [0..15]; b{i} : [0..3];
               [time] s{i}=0 & s{j}!=2 & t{i}<3 -> (t{i}'=t{i}+1);
               [] s{i}=0 & t{i}>=2 & t{i}<=3 -> 1/2: (s{i}'=1) & (t{i}'=0) & (slot{i}'=15)
                 + 1/4: (s{i}'=1) & (t{i}'=0) & (slot{i}'=7) + 1/4: (s{i}'=1) & (t{i}'=0) & (slot{i}'=0);
               [time] s{i}=0 & s{j}=2 -> (t{i}'=0);
               [time] s{i}=1 & s{j}!=2 & slot{i}>0 -> (slot{i}'=slot{i}-1);
               [time] s{i}=1 & s{j}=2 -> true;
               [] s{i}=1 & slot{i}=0 -> (s{i}'=2) & (t{i}'=0);
               [time] s{i}=2 & t{i}<6 -> (t{i}'=t{i}+1);
               [] s{i}=2 & t{i}>=4 & b{i}<3 & s{j}=2 -> (s{i}'=0) & (t{i}'=0) & (b{i}'=b{i}+1);
               [] s{i}=2 & t{i}>=4 & s{j}!=2 -> (s{i}'=3) & (t{i}'=0);
               [] s{i}=2 & t{i}>=4 & b{i}=3 -> (s{i}'=3) & (t{i}'=0);
               [time] s{i}=3 -> true;
             endmodule "
        )
    };
    engine_of(format!("mdp {} {}", station(1, 2), station(2, 1)), thresholds)
}

#[test]
fn layers_that_find_what_reaches_a_target_come_first_for_lost_states() {
    let mut ends_by_layers = Vec::new();
    for trial_steps in (20..=800).step_by(20) {
        let engine = stations(hasty(trial_steps));
        let target = engine.slice(&[(VarId(0), 3)]).unwrap();
        let reaching = engine.can_reach(&target, &engine.all_choices(), &[]).unwrap();
        assert_eq!(engine.count(&reaching).unwrap(), 420u32.into());
        let by_layers = engine.ways().by_layers > 0;
        let found = pmin_positive(&engine, &target).unwrap();
        assert!(engine.is_empty(&engine.difference(&target, &found).unwrap()).unwrap());
        assert_eq!(engine.ways().lost_by_state_layers > 0, by_layers, "{trial_steps}");
        ends_by_layers.push(by_layers);
    }
    assert!(ends_by_layers.contains(&true) && ends_by_layers.contains(&false), "{ends_by_layers:?}");
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
    let found = engine.almost_surely_win(start, &[labels]).unwrap();
    // Where x1 is 5, a state without another step loses: with x0=9, and with x0=4 by the barred step.
    assert_eq!(engine.count(&found.states).unwrap(), 539_998u32.into());
    let ways = engine.ways();
    assert!(ways.lost_by_lists > 0 && ways.lost_by_layers == 0, "{ways:?}");
}

#[test]
fn each_way_is_taken() {
    for way in Way::ALL {
        // Layers of states come first only where shared variables move back and forth.
        let engine = climbing(2, "(x#'=max(x#-1, 0))", way.thresholds());
        let last = engine.singleton(&[9; 2]).unwrap();
        let found = regions(&engine, &last).unwrap();
        assert_eq!(engine.count(&found.pmin_positive).unwrap(), 100u32.into());
        let ways = engine.ways();
        way.was_taken(&ways);
        let own = match way {
            Way::Parts => ways.lost_by_recursion,
            Way::Lists => ways.lost_by_lists,
            Way::States => ways.lost_by_state_layers,
            // Recursion and layers continue each other's turns: either may be the last.
            Way::Turns(_) | Way::StatesFirst(_) => ways.lost_by_lists + ways.lost_by_layers,
            Way::Hasty => ways.lost_by_lists + ways.lost_by_state_layers,
            Way::Usual => continue,
        };
        assert!(own > 0, "{way:?}: {ways:?}");
    }
}
