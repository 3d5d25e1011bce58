//! Lists of commands or synchronisations by the value of one variable.
//!
//! Thousands of guards such as `x=1`, `x=2`, … need not be evaluated one by one: at most those for the
//! value of x can be true.

use ahash::AHashMap;

use meliora_base::value::{Type, Value};
use meliora_model::expr::{Binary, ExprId, ExprPool, Node, Unary};

/// The values of a variable outside of which something cannot be enabled.
pub(super) type Need = (u32, Vec<i64>);

/// Things that can be enabled, by the value of one variable. Things are numbers.
pub(super) struct ByValue {
    pub(super) variable: usize,
    /// For each value the things that need it, in order.
    lists: AHashMap<i64, Vec<u32>>,
    /// The things that do not depend on the value, or not in this way.
    others: Vec<u32>,
}

impl ByValue {
    /// Lists things by the variable that most of them need; `None` if no two things need the same one.
    pub(super) fn new(needs: &[Vec<Need>]) -> Option<Self> {
        let mut votes: AHashMap<u32, usize> = AHashMap::new();
        needs.iter().flatten().for_each(|(variable, _)| *votes.entry(*variable).or_default() += 1);
        let most = |&(variable, count): &(u32, usize)| (count, std::cmp::Reverse(variable));
        let (variable, _) = votes.into_iter().filter(|(_, count)| *count > 1).max_by_key(most)?;
        let (mut lists, mut others) = (AHashMap::<i64, Vec<u32>>::new(), Vec::new());
        for (thing, needs) in (0u32..).zip(needs) {
            match needs.iter().find(|(needed, _)| *needed == variable) {
                Some((_, values)) => {
                    values.iter().for_each(|&value| lists.entry(value).or_default().push(thing));
                }
                None => others.push(thing),
            }
        }
        Some(ByValue { variable: variable as usize, lists, others })
    }

    /// Returns the things that can be enabled if the variable has this value, in their order.
    pub(super) fn of(&self, value: i64) -> impl Iterator<Item = u32> + '_ {
        let list = self.lists.get(&value).map_or(&[][..], Vec::as_slice);
        let (mut own, mut others) = (list.iter().copied().peekable(), self.others.iter().copied().peekable());
        std::iter::from_fn(move || match (own.peek(), others.peek()) {
            (Some(a), Some(b)) if a < b => own.next(),
            (Some(_), None) => own.next(),
            _ => others.next(),
        })
    }
}

/// Returns the only value of a variable for which a condition is true, if the condition itself shows it:
/// `x = 3`, `b` or `!b`.
pub(super) fn only_value(pool: &ExprPool, e: ExprId) -> Option<(u32, i64)> {
    match pool.node(e) {
        Node::Var(v) if pool.ty(e) == Type::Bool => Some((v.0, 1)),
        Node::Unary(Unary::Not, a) => match pool.node(a) {
            Node::Var(v) if pool.ty(a) == Type::Bool => Some((v.0, 0)),
            _ => None,
        },
        Node::Binary(Binary::Eq, a, b) => match (pool.node(a), pool.node(b)) {
            (Node::Var(v), Node::Literal(Value::Int(c))) | (Node::Literal(Value::Int(c)), Node::Var(v)) => {
                Some((v.0, c))
            }
            _ => None,
        },
        _ => None,
    }
}

/// Returns what all alternatives together need: the values of each variable that each of them needs.
pub(super) fn of_alternatives<'a>(alternatives: impl Iterator<Item = &'a Vec<Need>>) -> Vec<Need> {
    let mut count = 0;
    let mut all: AHashMap<u32, (usize, Vec<i64>)> = AHashMap::new();
    for needs in alternatives {
        for (variable, values) in needs {
            let (last, found) = all.entry(*variable).or_default();
            // A variable that an alternative before this one did not need is never complete again.
            if *last == count {
                (*last, _) = (count + 1, found.extend(values));
            }
        }
        count += 1;
    }
    let complete = all.into_iter().filter(|(_, (last, _))| *last == count);
    let mut needs: Vec<Need> = complete.map(|(variable, (_, values))| (variable, values)).collect();
    for (_, values) in &mut needs {
        values.sort_unstable();
        values.dedup();
    }
    needs.sort_unstable();
    needs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_are_listed_for_the_values_that_they_need_and_all_others_always() {
        let needs = vec![vec![(0, vec![1])], vec![(1, vec![5])], vec![(0, vec![1, 2]), (1, vec![5])], vec![]];
        let lists = ByValue::new(&needs).unwrap();
        assert_eq!(lists.variable, 0);
        let of = |value| lists.of(value).collect::<Vec<_>>();
        assert_eq!([of(1), of(2), of(3)], [vec![0, 1, 2, 3], vec![1, 2, 3], vec![1, 3]]);
        assert!(ByValue::new(&needs[..2]).is_none() && ByValue::new(&[]).is_none());
    }

    #[test]
    fn alternatives_need_what_each_of_them_needs() {
        let both = [vec![(0, vec![3]), (1, vec![1])], vec![(0, vec![2]), (2, vec![1])]];
        assert_eq!(of_alternatives(both.iter()), [(0, vec![2, 3])]);
        assert_eq!(of_alternatives(both[..1].iter()), both[0]);
        let late = [vec![], vec![(0, vec![2])]];
        assert_eq!(of_alternatives(late.iter()), []);
    }
}
