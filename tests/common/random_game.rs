//! Random games: the players of a random program take turns.

use meliora::model::players::{Player, Players};
use meliora::model::value::{Type, Value};

use crate::common::prelude::*;

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
