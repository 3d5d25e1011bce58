//! Lists of commands or synchronisations by the values of variables.
//!
//! Thousands of guards such as `x=1`, `x=2`, … need not be evaluated one by one: at most those for the
//! value of x can be true.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use ahash::AHashMap;

use meliora_base::value::{Type, Value};
use meliora_model::expr::{Binary, ExprId, ExprPool, Node, Unary};

/// The values of a variable outside of which something cannot be enabled.
pub(super) type Need = (u32, Vec<i64>);

/// Things that can be enabled, by the values of variables. Things are numbers.
pub(super) struct ByValue {
    /// For a variable, the things that need each of its values, again by the values of other variables.
    splits: Vec<(usize, AHashMap<i64, ByValue>)>,
    /// The things that do not depend on these variables, or not in this way.
    others: Vec<u32>,
}

impl ByValue {
    /// Lists things by the variables that they need; `None` if no two things need the same one.
    pub(super) fn new(needs: &[Vec<Need>]) -> Option<Self> {
        let things = (0u32..).zip(needs).map(|(thing, needs)| (thing, needs.iter().collect()));
        Some(Self::of_things(things.collect())).filter(|all| !all.splits.is_empty())
    }

    /// Lists things, each with the needs that are left, by the variable that most of them need.
    fn of_things(things: Vec<(u32, Vec<&Need>)>) -> Self {
        let mut votes: AHashMap<u32, usize> = AHashMap::new();
        things.iter().flat_map(|(_, needs)| needs).for_each(|(v, _)| *votes.entry(*v).or_default() += 1);
        let (mut split, mut others) = (BTreeMap::<u32, AHashMap<i64, Vec<_>>>::new(), Vec::new());
        for (thing, needs) in things {
            let most = |need: &&&Need| (votes[&need.0], Reverse(need.0));
            let Some(&(variable, values)) = needs.iter().max_by_key(most).filter(|(v, _)| votes[v] > 1)
            else {
                others.push(thing);
                continue;
            };
            // With several values for each variable, there would be a copy for each combination.
            let is_left = |need: &&Need| need.0 != *variable && need.1.len() == 1;
            let left = Vec::from_iter(needs.iter().copied().filter(is_left));
            let lists = split.entry(*variable).or_default();
            values.iter().for_each(|&value| lists.entry(value).or_default().push((thing, left.clone())));
        }
        let below = |lists: AHashMap<i64, Vec<_>>| {
            lists.into_iter().map(|(value, things)| (value, Self::of_things(things))).collect()
        };
        let splits = split.into_iter().map(|(variable, lists)| (variable as usize, below(lists)));
        ByValue { splits: splits.collect(), others }
    }

    /// Adds the things that can be enabled with these values of the variables, in their order.
    pub(super) fn find(&self, values: &[i64], into: &mut Vec<u32>) {
        self.add(values, into);
        if !into.is_sorted() {
            into.sort_unstable();
        }
    }

    fn add(&self, values: &[i64], into: &mut Vec<u32>) {
        into.extend_from_slice(&self.others);
        for (variable, lists) in &self.splits {
            if let Some(list) = lists.get(&values[*variable]) {
                list.add(values, into);
            }
        }
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
        let needs = [
            vec![(0, vec![1])],
            vec![(1, vec![5])],
            vec![(0, vec![1, 2]), (1, vec![5])],
            vec![],
            vec![(0, vec![2]), (1, vec![5])],
            vec![(0, vec![2]), (1, vec![6])],
        ];
        let lists = ByValue::new(&needs).unwrap();
        let of = |values: [i64; 2]| {
            let mut found = Vec::new();
            lists.find(&values, &mut found);
            found
        };
        assert_eq!([of([1, 5]), of([2, 5]), of([2, 6])], [vec![0, 1, 2, 3], vec![1, 2, 3, 4], vec![3, 5]]);
        assert_eq!(of([3, 5]), [1, 3]);
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
