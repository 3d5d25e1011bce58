//! Lists of commands, synchronisations or disjuncts by the values of variables.
//!
//! Thousands of conditions such as `x=1`, `x=2`, … need not be evaluated one by one: at most those for the
//! value of x can be true. One such as `x=1 & y=2 | x=3 & y=4` is in two lists.

use std::collections::BTreeMap;

use ahash::AHashMap;

use super::needs::{Need, Way, Ways};

/// Things that can be enabled, by the values of variables. Things are numbers.
pub(crate) struct ByValue {
    /// For a variable, the things that need each of its values, again by the values of other variables.
    pub(crate) splits: Vec<Split>,
    /// The things that do not depend on these variables, or not in this way.
    pub(crate) others: Vec<u32>,
}

/// Lists by the values of a variable.
pub(crate) struct Split {
    pub(crate) variable: usize,
    /// The values with a list, the lowest first.
    values: Vec<i64>,
    lists: Vec<ByValue>,
    /// For each value from the lowest to the highest one, the position of its list, or [`NONE`]; empty if few of these
    /// values have one.
    positions: Vec<u32>,
}

/// The position of a list that does not exist.
const NONE: u32 = u32::MAX;

impl Split {
    fn new(variable: usize, lists: BTreeMap<i64, ByValue>) -> Self {
        let (values, lists): (Vec<i64>, Vec<ByValue>) = lists.into_iter().unzip();
        let mut split = Split { variable, values, lists, positions: Vec::new() };
        let (Some(&low), Some(&high)) = (split.values.first(), split.values.last()) else { return split };
        let span = high.abs_diff(low);
        if span < 8 * split.values.len() as u64 {
            split.positions = vec![NONE; span as usize + 1];
            for (position, value) in (0..).zip(&split.values) {
                split.positions[value.abs_diff(low) as usize] = position;
            }
        }
        split
    }

    /// Returns the list of a value.
    #[inline]
    pub(crate) fn get(&self, value: i64) -> Option<&ByValue> {
        let position = match self.positions.is_empty() {
            true => self.values.binary_search(&value).ok()?,
            false => {
                let at = usize::try_from(value.checked_sub(self.values[0])?).ok()?;
                *self.positions.get(at)? as usize
            }
        };
        self.lists.get(position)
    }
}

/// A way to enable a thing that is a number, with the needs that are left.
type Open<'w> = (u32, Vec<&'w Need>);

impl Ways<'_> {
    /// Lists things by the variables that each way to enable them needs.
    pub(crate) fn list(&mut self, things: &[Vec<Way>]) -> ByValue {
        let mut ways = Vec::new();
        for (thing, own) in (0u32..).zip(things) {
            ways.extend(own.iter().map(|way| (thing, way.iter().collect())));
        }
        self.copies = ways.iter().flat_map(|(_, needs): &Open<'_>| needs).map(|need| need.1.len()).sum();
        self.split(ways)
    }

    /// Lists things by the variables that are expected to rule out most, if these rule out at least one: a look-up takes
    /// as long as a test.
    fn split(&mut self, ways: Vec<Open<'_>>) -> ByValue {
        let mut gains: AHashMap<u32, f64> = AHashMap::new();
        for need in ways.iter().flat_map(|(_, needs)| needs) {
            *gains.entry(need.0).or_default() += 1.0 - self.share(need);
        }
        let (mut groups, mut others) = (BTreeMap::<u32, Vec<(&Need, Open<'_>)>>::new(), Vec::new());
        for (thing, needs) in ways {
            let by_gain = |a: &&Need, b: &&Need| gains[&a.0].total_cmp(&gains[&b.0]).then(b.0.cmp(&a.0));
            match needs.iter().copied().max_by(by_gain) {
                Some(need) => groups.entry(need.0).or_default().push((need, (thing, needs))),
                None => others.push(thing),
            }
        }
        let mut splits = Vec::new();
        for (variable, group) in groups {
            match self.by_values(&group) {
                Some(lists) => splits.push(Split::new(variable as usize, lists)),
                None => others.extend(group.iter().map(|(_, (thing, _))| *thing)),
            }
        }
        others.sort_unstable();
        others.dedup();
        ByValue { splits, others }
    }

    /// Lists things by the values of a variable that they need, each with its other needs.
    fn by_values(&mut self, group: &[(&Need, Open<'_>)]) -> Option<BTreeMap<i64, ByValue>> {
        let own = group.chunk_by(|(_, (a, _)), (_, (b, _))| a == b);
        let gain: f64 = own.map(|ways| self.ruled_out(ways.iter().map(|(_, (_, needs))| &**needs))).sum();
        let copies = group.iter().map(|(need, _)| self.copies_of(need)).fold(0, u64::saturating_add);
        if gain < 1.0 || copies > self.copies as u64 {
            return None;
        }
        self.copies -= copies as usize;
        let mut lists: BTreeMap<i64, Vec<Open<'_>>> = BTreeMap::new();
        for (need, (thing, needs)) in group {
            let left = Vec::from_iter(needs.iter().copied().filter(|other| other.0 != need.0));
            for value in self.values(need).flat_map(|[low, high]| low..=high) {
                lists.entry(value).or_default().push((*thing, left.clone()));
            }
        }
        Some(lists.into_iter().map(|(value, ways)| (value, self.split(ways))).collect())
    }

    /// Returns the number of values of a variable that are needed, without the first one.
    fn copies_of(&self, need: &Need) -> u64 {
        let add = |all: u64, [low, high]: [i64; 2]| all.saturating_add(high.abs_diff(low)).saturating_add(1);
        self.values(need).fold(0, add).saturating_sub(1)
    }

    /// Returns the values of a variable that are needed and in its range.
    fn values(&self, need: &Need) -> impl Iterator<Item = [i64; 2]> {
        let declared = &self.program.variables[need.0 as usize];
        let inside = move |&[low, high]: &[i64; 2]| [low.max(declared.low), high.min(declared.high)];
        need.1.iter().map(inside).filter(|[low, high]| low <= high)
    }

    /// Returns the share of the states in which a thing is ruled out, if the values of all variables are independent and
    /// no two of its ways exclude each other.
    fn ruled_out<'w>(&self, ways: impl Iterator<Item = &'w [&'w Need]>) -> f64 {
        let shares = ways.map(|needs| needs.iter().map(|need| self.share(need)).product::<f64>());
        1.0 - shares.sum::<f64>().min(1.0)
    }

    /// Returns the share of the values of a variable that are needed.
    fn share(&self, need: &Need) -> f64 {
        let count = |low: i64, high: i64| high.abs_diff(low) as f64 + 1.0;
        let declared = &self.program.variables[need.0 as usize];
        self.values(need).map(|[low, high]| count(low, high)).sum::<f64>()
            / count(declared.low, declared.high)
    }
}

impl ByValue {
    /// Returns the things that can be enabled with these values of the variables, each once, in their order; `room` may
    /// contain them.
    #[inline]
    pub(crate) fn find<'l>(&'l self, values: &[i64], room: &'l mut Vec<u32>) -> &'l [u32] {
        let mut lists = self;
        while !lists.splits.is_empty() && lists.others.is_empty() {
            let mut found = lists.splits.iter().filter_map(|split| split.get(values[split.variable]));
            lists = match (found.next(), found.next()) {
                (None, _) => return &[],
                (Some(only), None) => only,
                _ => break,
            };
        }
        if lists.splits.is_empty() {
            return &lists.others;
        }
        room.clear();
        lists.add(values, room);
        if !room.is_sorted_by(|a, b| a < b) {
            room.sort_unstable();
            room.dedup();
        }
        room
    }

    fn add(&self, values: &[i64], into: &mut Vec<u32>) {
        into.extend_from_slice(&self.others);
        for split in &self.splits {
            if let Some(list) = split.get(values[split.variable]) {
                list.add(values, into);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_base::error::SourceFile;
    use meliora_lang as lang;

    /// Returns the number of things in all lists.
    fn size(lists: &ByValue) -> usize {
        lists.others.len() + lists.splits.iter().flat_map(|split| &split.lists).map(size).sum::<usize>()
    }

    #[test]
    fn things_are_listed_for_the_values_that_they_need_and_all_others_always() {
        let text = "mdp module m x : [0..9]; y : [0..9]; [] true -> true; endmodule";
        let program =
            lang::load(&SourceFile::new("m", text), &SourceFile::new("constants", "")).unwrap().program;
        let need =
            |variable: u32, from: i64, to: i64| -> Need { (variable, [[from, to]].into_iter().collect()) };
        let needs = [
            vec![vec![need(0, 1, 1)]],
            vec![vec![need(1, 5, 5)]],
            vec![vec![need(0, 1, 2), need(1, 5, 5)]],
            vec![vec![]],
            vec![vec![need(0, 2, 2), need(1, 5, 5)], vec![need(1, i64::MIN, 0)]],
            vec![vec![need(0, 2, 2), need(1, 6, 6)], vec![need(0, 1, 1), need(1, 5, 5)]],
            vec![vec![need(0, 8, 7)]],
        ];
        let list = |needs: &[Vec<Way>]| Ways::new(&program, &program.pool).list(needs);
        let of = |lists: &ByValue, values: [i64; 2]| lists.find(&values, &mut Vec::new()).to_vec();
        let lists = list(&needs);
        assert_eq!(of(&lists, [1, 5]), [0, 1, 2, 3, 5]);
        assert_eq!(of(&lists, [2, 5]), [1, 2, 3, 4]);
        assert_eq!([of(&lists, [2, 6]), of(&lists, [3, 5])], [[3, 5], [1, 3]]);
        assert_eq!(of(&lists, [9, 0]), [3, 4]);
        // A look-up that rules out less than one thing is for nothing.
        assert!(list(&needs[..1]).splits.is_empty() && list(&[]).splits.is_empty());
        let wide = |width: i64| {
            let need = |at: i64| vec![vec![need(0, width * at, width * (at + 1) - 1)]];
            list(&[need(0), need(1), need(2)])
        };
        assert_eq!(of(&wide(2), [5, 0]), [2]);
        assert!(wide(3).splits.is_empty(), "each of three things would have two copies");
        let apart = |variable: u32| (variable, [[0, 0], [2, 2], [4, 4], [6, 6]].into_iter().collect());
        let many = list(&vec![vec![vec![apart(0), apart(1)]]; 3]);
        assert!(!many.splits.is_empty() && size(&many) <= 3 + 3 * (4 + 4), "a copy for each interval");
    }
}
