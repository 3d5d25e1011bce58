//! Random games of modules that synchronise and take turns: one engine against the other.

use std::sync::Arc;

use meliora::engine::regions::{Regions, regions};
use meliora::engine::{Engine, ExplicitEngine, Scope, SymbolicEngine};
use meliora::model::expr::{Binary, Unary};
use meliora::model::players::{Player, Players};
use meliora::model::predicate::Predicate;
use meliora::model::value::{Type, Value};
use meliora::model::{ModelKind, Program, State, VarId, Variable};
use proptest::prelude::*;

use super::random_program::{random_predicate, random_program};
use super::{settings, thresholds};

/// Lets two players own the modules and actions of a program and take turns: a command is enabled in
/// its player's turn only, and its branches pass on the turn as the bits say.
pub(crate) fn with_turns(program: &mut Program, mut bits: u64) {
    let mut bit = || {
        bits = bits.rotate_right(1);
        bits & 1 == 1
    };
    let player = |bit: bool| Some(usize::from(bit));
    let of_module: Vec<Option<usize>> = program.modules.iter().map(|_| player(bit())).collect();
    let of_action: Vec<Option<usize>> = program.actions.iter().map(|_| player(bit())).collect();
    let turn = VarId(program.variables.len() as u32);
    let (name, ty) = ("turn".to_owned(), Type::Bool);
    let (low, high, module, initial, values, span) = (0, 1, None, None, vec![], 0..0);
    program.variables.push(Variable { name, ty, low, high, module, initial, values, span });
    let pool = Arc::make_mut(&mut program.pool);
    let theirs = pool.var(turn, Type::Bool);
    let ours = pool.unary(Unary::Not, theirs);
    for command in &mut program.commands {
        let player = command.action.map_or(of_module[command.module], |action| of_action[action]);
        let mine = if player == Some(1) { theirs } else { ours };
        command.guard = pool.binary(Binary::And, command.guard, mine);
    }
    // In each choice, the first command passes on the turn.
    let first = program.synchronisations.iter().filter_map(|s| s.factors.first()).flatten();
    for id in first.copied().collect::<Vec<_>>() {
        for branch in &mut program.commands[id.index()].branches {
            if bit() || bit() {
                let value = pool.value(Value::Bool(bit()));
                branch.updates.push((turn, value));
            }
        }
    }
    let list = ["us", "them"].map(|name| Player { name: name.into(), ours: name == "us" });
    program.players = Some(Players { list: list.into(), of_module, of_action, span: 0..0 });
    program.kind = ModelKind::Smg;
}

fn listed<E: Engine>(engine: &E, target: &Predicate) -> Regions<Vec<State>> {
    let found = regions(engine, &engine.states_where(target).unwrap()).unwrap();
    found.map(|x| engine.list_states(&x, usize::MAX).unwrap())
}

fn players<E: Engine>(engine: &E) -> Vec<Vec<State>> {
    engine.player_states().iter().map(|x| engine.list_states(x, usize::MAX).unwrap()).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn both_engines_agree_on_random_games(
        of in proptest::collection::vec(0u16..1000, 0..160),
        target in proptest::collection::vec(0u16..1000, 0..20),
        bits in any::<u64>(),
        all in any::<bool>(),
    ) {
        let mut program = random_program(&of, false);
        program.kind = ModelKind::Mdp;
        with_turns(&mut program, bits);
        let target = random_predicate(&mut program, &target);
        let target = program.predicate(target);
        let program = Arc::new(program);
        let scope = if all { Scope::All } else { Scope::Reachable };
        let explicit = ExplicitEngine::new(program.clone(), settings(scope, thresholds()[0])).unwrap();
        for thresholds in thresholds() {
            let symbolic = SymbolicEngine::new(program.clone(), settings(scope, thresholds)).unwrap();
            prop_assert_eq!(players(&symbolic), players(&explicit));
            for coalition in [[true, false], [false, true], [true, true], [false, false]] {
                let (one, other) =
                    (symbolic.with_coalition(&coalition).unwrap(), explicit.with_coalition(&coalition).unwrap());
                prop_assert_eq!(listed(&one, &target), listed(&other, &target), "{:?}", coalition);
            }
        }
    }
}
