//! The values of variables that a condition needs, as its text shows them.

use std::collections::BTreeMap;

use ahash::AHashSet;
use smallvec::{SmallVec, smallvec};

use meliora_base::stack;
use meliora_base::value::{Type, Value};
use meliora_model::expr::{Binary, ExprId, ExprPool, Node, Unary};
use meliora_model::{Program, VarId};

/// The values of a variable outside of which something cannot be enabled: intervals, the lowest first.
pub(crate) type Need = (u32, SmallVec<[[i64; 2]; 1]>);

/// A way in which a condition can be true, by its needs.
pub(crate) type Way = Vec<Need>;

/// Reads the ways in which conditions can be true, and lists things by these.
pub(crate) struct Ways<'p> {
    pub(crate) program: &'p Program,
    pool: &'p ExprPool,
    /// The disjunctions that were read, nested ones too.
    known: AHashSet<ExprId>,
    /// The number of disjunctions that may still be read again: at most one for each character of the text. Formulas that
    /// use others again and again may stand for much more.
    again: usize,
    /// The number of copies of ways that a list may still have, for several values of a variable: at first, one for each
    /// interval of a need.
    pub(crate) copies: usize,
}

impl<'p> Ways<'p> {
    /// Begins with a pool over the variables of a program.
    pub(crate) fn new(program: &'p Program, pool: &'p ExprPool) -> Self {
        let again = program.source.text.len().max(pool.len());
        Ways { program, pool, known: AHashSet::new(), again, copies: 0 }
    }

    /// Returns the ways in which all of some conditions can be true: one for each disjunct of the longest disjunction
    /// among them. The conditions have a value in every state.
    pub(crate) fn of(&mut self, conjuncts: &[ExprId]) -> Vec<Way> {
        let mut all = Way::new();
        for (variable, values) in conjuncts.iter().filter_map(|&e| interval(self.pool, e, true)) {
            narrow(&mut all, &(variable.0, smallvec![values]));
        }
        if self.again == 0 {
            return vec![all];
        }
        let disjunctions = conjuncts.iter().map(|&e| nest(self.pool, Binary::Or, e));
        let longest = disjunctions.max_by_key(|(disjuncts, _)| disjuncts.len());
        let Some((disjuncts, inner)) = longest.filter(|(_, inner)| !inner.is_empty()) else {
            return vec![all];
        };
        let again = inner.into_iter().filter(|&e| !self.known.insert(e)).count();
        self.again = self.again.saturating_sub(again);
        let mut ways = Vec::new();
        for e in disjuncts {
            for own in stack::level(|| self.of(&operands(self.pool, Binary::And, e))) {
                let mut way = all.clone();
                own.iter().for_each(|need| narrow(&mut way, need));
                if way == all {
                    // One that needs no more makes the others useless.
                    return vec![all];
                }
                ways.push(way);
            }
        }
        ways
    }
}

/// Adds a need of one interval to a way with such needs.
fn narrow(way: &mut Way, need: &Need) {
    match way.iter_mut().find(|known| known.0 == need.0) {
        Some((_, known)) => {
            for ([low, high], &[from, to]) in known.iter_mut().zip(&need.1) {
                (*low, *high) = (from.max(*low), to.min(*high));
            }
        }
        None => way.push(need.clone()),
    }
}

/// Returns the operands of a conjunction or disjunction, nested ones too, each once, in their order; for another
/// condition this one alone.
pub fn operands(pool: &ExprPool, op: Binary, e: ExprId) -> Vec<ExprId> {
    nest(pool, op, e).0
}

/// Returns the same, and the conjunctions or disjunctions of which they are operands.
fn nest(pool: &ExprPool, op: Binary, e: ExprId) -> (Vec<ExprId>, Vec<ExprId>) {
    let (mut found, mut inner, mut stack, mut seen) = (Vec::new(), Vec::new(), vec![e], AHashSet::new());
    while let Some(e) = stack.pop() {
        match pool.node(e) {
            _ if !seen.insert(e) => {}
            Node::Binary(own, a, b) if own == op && pool.ty(a) == Type::Bool => {
                inner.push(e);
                stack.extend([b, a]);
            }
            Node::Literal(Value::Bool(neutral)) if neutral == (op == Binary::And) => {}
            _ => found.push(e),
        }
    }
    (found, inner)
}

/// Returns the lowest and the highest value that a variable can have where a condition is true, or false, if the condition
/// compares it with a number or is a truth value.
pub fn interval(pool: &ExprPool, e: ExprId, holds: bool) -> Option<(VarId, [i64; 2])> {
    let (least, most) = (i64::MIN, i64::MAX);
    let (op, a, b) = match pool.node(e) {
        Node::Var(v) if pool.ty(e) == Type::Bool => return Some((v, [holds.into(); 2])),
        Node::Unary(Unary::Not, a) if pool.ty(a) == Type::Bool => return interval(pool, a, !holds),
        Node::Binary(op, a, b) => (op, pool.node(a), pool.node(b)),
        _ => return None,
    };
    // Where a < b is false, b <= a is true.
    let (op, a, b) = match (op, holds) {
        (Binary::Lt, false) => (Binary::Le, b, a),
        (Binary::Le, false) => (Binary::Lt, b, a),
        (_, false) => return None,
        (_, true) => (op, a, b),
    };
    let less = i64::from(op == Binary::Lt);
    match (op, a, b) {
        (Binary::Eq, Node::Var(v), Node::Literal(Value::Int(c)))
        | (Binary::Eq, Node::Literal(Value::Int(c)), Node::Var(v)) => Some((v, [c, c])),
        (Binary::Lt | Binary::Le, Node::Var(v), Node::Literal(Value::Int(c))) => {
            Some((v, [least, c.saturating_sub(less)]))
        }
        (Binary::Lt | Binary::Le, Node::Literal(Value::Int(c)), Node::Var(v)) => {
            Some((v, [c.saturating_add(less), most]))
        }
        _ => None,
    }
}

/// Returns what all ways together need: the values of each variable that each of them needs.
pub(crate) fn of_all<'a>(ways: impl Iterator<Item = &'a Way>) -> Way {
    let mut count = 0;
    let mut all: BTreeMap<u32, (usize, SmallVec<_>)> = BTreeMap::new();
    for way in ways {
        for (variable, values) in way {
            let (last, found) = all.entry(*variable).or_default();
            // A variable that a way before this one did not need is never complete again.
            if *last == count {
                (*last, _) = (count + 1, found.extend_from_slice(values));
            }
        }
        count += 1;
    }
    let complete = all.into_iter().filter(|(_, (last, _))| *last == count);
    complete.map(|(variable, (_, values))| (variable, joined(values))).collect()
}

/// Joins intervals that overlap.
fn joined(mut values: SmallVec<[[i64; 2]; 1]>) -> SmallVec<[[i64; 2]; 1]> {
    values.sort_unstable();
    values.dedup_by(|next, last| {
        let is_joined = next[0] <= last[1];
        if is_joined {
            last[1] = last[1].max(next[1]);
        }
        is_joined
    });
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_base::error::SourceFile;
    use meliora_lang as lang;

    /// A need of some intervals.
    fn need<const N: usize>(variable: u32, values: [[i64; 2]; N]) -> Need {
        (variable, values.into_iter().collect())
    }

    #[test]
    fn all_ways_together_need_what_each_of_them_needs() {
        let both = [vec![need(0, [[3, 3]]), need(1, [[1, 1]])], vec![need(0, [[2, 2]]), need(2, [[1, 1]])]];
        assert_eq!(of_all(both.iter()), [need(0, [[2, 2], [3, 3]])]);
        assert_eq!(of_all(both[..1].iter()), both[0]);
        let late = [vec![], vec![need(0, [[2, 2]])]];
        assert_eq!(of_all(late.iter()), []);
        let apart = [[5, 9], [0, 2], [7, 12], [14, i64::MAX]].map(|values| vec![need(0, [values])]);
        assert_eq!(of_all(apart.iter()), [need(0, [[0, 2], [5, 12], [14, i64::MAX]])]);
    }

    #[test]
    fn formulas_that_use_others_twice_have_few_ways() {
        let double = |n: usize| format!("formula f{} = f{n} & y={n} | f{n} & z={n};\n", n + 1);
        let formulas: String = (0..60).map(double).collect();
        let text = format!(
            "mdp formula f0 = x=1 | x=2;\n{formulas}
            module m x : [0..9]; y : [0..99]; z : [0..99]; [] f60 -> true; endmodule"
        );
        let program =
            lang::load(&SourceFile::new("m", &text), &SourceFile::new("constants", "")).unwrap().program;
        let ways = Ways::new(&program, &program.pool).of(&[program.commands[0].guard]);
        assert!((60..2 * text.len()).contains(&ways.len()), "{}", ways.len());
    }

    #[test]
    fn each_disjunct_is_a_way_with_the_values_that_it_needs() {
        let text = "mdp module m x : [0..9]; y : [0..9]; \
            [] (x=1 & !(y<5) | x=2 & (y<3 | x=1)) & y<=8 -> true; [] (x=1 | y<=8) & y<=8 -> true; endmodule";
        let program =
            lang::load(&SourceFile::new("m", text), &SourceFile::new("constants", "")).unwrap().program;
        let of = |command: usize| {
            let guard = operands(&program.pool, Binary::And, program.commands[command].guard);
            Ways::new(&program, &program.pool).of(&guard)
        };
        let ways = of(0);
        let low = i64::MIN;
        assert_eq!(ways[0], [need(1, [[5, 8]]), need(0, [[1, 1]])]);
        assert_eq!(ways[1], [need(1, [[low, 2]]), need(0, [[2, 2]])]);
        // Never true.
        assert_eq!(ways[2], [need(1, [[low, 8]]), need(0, [[2, 1]])]);
        assert_eq!(ways.len(), 3);
        assert_eq!(of(1), [[need(1, [[low, 8]])]]);
    }
}
