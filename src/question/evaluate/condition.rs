//! Sets of states as conditions over the variables.

use meliora_base::value::{Type, Value};
use meliora_model::expr::{Binary, ExprId, ExprPool};
use meliora_model::{Program, State, VarId};

/// Returns a condition that holds in the given states, in their order, and in no other ones.
pub(super) fn condition_of(program: &Program, pool: &mut ExprPool, states: &[State]) -> ExprId {
    Conditions { program, pool }.of(states, 0)
}

struct Conditions<'a> {
    program: &'a Program,
    pool: &'a mut ExprPool,
}

/// Values of a variable from the first to the last, with the condition on the variables behind.
type Part = (i64, i64, ExprId);

impl Conditions<'_> {
    /// Returns the condition on the variables from `at` on; all states agree on those before.
    fn of(&mut self, states: &[State], at: usize) -> ExprId {
        let Some(variable) = self.program.variables.get(at) else {
            return self.pool.value(Value::Bool(!states.is_empty()));
        };
        let never = self.pool.value(Value::Bool(false));
        let (ty, mut next) = (variable.ty, variable.low);
        let mut parts: Vec<Part> = Vec::new();
        let high = variable.high;
        for own in states.chunk_by(|a, b| a[at] == b[at]) {
            let value = own[0][at];
            let behind = self.of(own, at + 1);
            if next < value {
                join(&mut parts, (next, value - 1, never));
            }
            join(&mut parts, (value, value, behind));
            next = value + 1;
        }
        if next <= high || parts.is_empty() {
            join(&mut parts, (next, high.max(next), never));
        }
        let id = VarId(u32::try_from(at).unwrap_or(u32::MAX));
        let own = self.pool.var(id, ty);
        self.select(own, ty, &parts)
    }

    /// Returns the choice between parts in a binary search.
    fn select(&mut self, own: ExprId, ty: Type, parts: &[Part]) -> ExprId {
        let middle = parts.len() / 2;
        let Some((&(_, _, only), true)) = parts.first().map(|part| (part, middle == 0)) else {
            let (below, above) = (&parts[..middle], &parts[middle..]);
            let (low, high) = (self.select(own, ty, below), self.select(own, ty, above));
            return match ty {
                Type::Bool => self.pool.ite(own, high, low),
                _ => {
                    let last = self.pool.value(Value::Int(above[0].0 - 1));
                    let is_low = self.pool.binary(Binary::Le, own, last);
                    self.pool.ite(is_low, low, high)
                }
            };
        };
        only
    }
}

/// Adds a part; one with the same condition as the last continues it.
fn join(parts: &mut Vec<Part>, part: Part) {
    match parts.last_mut() {
        Some(last) if last.2 == part.2 => last.1 = part.1,
        _ => parts.push(part),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_base::error::SourceFile;

    /// All 4,096 sets of the twelve states of two variables, in their order.
    #[test]
    fn the_condition_of_a_set_holds_in_its_states_and_in_no_others() {
        let text = "mdp module m x : [1..3]; b : bool; y : [0..1]; endmodule";
        let none = SourceFile::new("--const", "");
        let program = meliora_lang::load(&SourceFile::new("m.prism", text), &none).unwrap().program;
        let all: Vec<State> =
            (0..12).map(|number| vec![1 + number / 4, number / 2 % 2, number % 2]).collect();
        for set in 0..1_u32 << all.len() {
            let inside = |number: usize| set >> number & 1 == 1;
            let states: Vec<State> =
                (0..all.len()).filter(|&number| inside(number)).map(|number| all[number].clone()).collect();
            let mut pool = ExprPool::clone(&program.pool);
            let condition = condition_of(&program, &mut pool, &states);
            for (number, state) in all.iter().enumerate() {
                let holds = pool.eval(condition, state).unwrap();
                assert_eq!(holds, Value::Bool(inside(number)), "{set:b} {state:?}");
            }
        }
    }
}
