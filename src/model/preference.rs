//! Preferences: a preorder on objectives and its operations on sets of objectives.
//!
//! This module is independent of states and diagrams; planning applies it to winning
//! regions.

mod preorder;

use std::ops::Range;

use strum::{EnumString, IntoStaticStr};

pub use preorder::Contradiction;
pub use preorder::{Comparison, Preorder, Relation, Statement};

use super::predicate::Predicate;
use super::temporal::Condition;

/// The objectives of a preference file with their preorder.
#[derive(Debug, Clone)]
pub struct Preferences {
    /// The objectives in the order of declaration.
    pub objectives: Vec<Objective>,
    /// The preorder on the objectives.
    pub order: Preorder,
    /// The value of nothing.
    pub empty: Empty,
    /// The part of a path that counts.
    pub history: History,
    /// The requirements, which every strategy must keep: one formula, their conjunction.
    pub requirements: Vec<Requirement>,
}

/// A requirement: a safe formula that no path may violate, `require …;` of a preference file. All
/// requirements of a file are one formula, their conjunction: no path may violate it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Requirement<M = Predicate> {
    /// The formula as written.
    pub text: String,
    /// True in the states in which the formula is not violated. With a monitor, this is the condition
    /// of the conjunction of all requirements, and false from the violation on.
    pub kept: M,
    /// The number of states of the monitor, which follows the conjunction of all requirements; `None`
    /// for `G p` with a state formula p.
    pub monitor: Option<u64>,
}

/// The contents of a preference file that do not need a model.
#[derive(Debug, Clone)]
pub struct Outline {
    /// The objectives in the order of declaration: their names and their formulas as written.
    pub objectives: Vec<(String, String)>,
    /// The preorder on the objectives.
    pub order: Preorder,
    /// The value of nothing.
    pub empty: Empty,
    /// The part of a path that counts.
    pub history: History,
    /// The formulas of the requirements as written.
    pub requirements: Vec<String>,
}

/// The part of a path that counts: `history = …` of a preference file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, EnumString, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum History {
    /// The part from the present state on: targets reached before do not count.
    #[default]
    State,
    /// The whole path, from the state in which planning started.
    Play,
}

impl Preferences {
    /// Returns the conditions of the objectives and of the requirements. Those on marks of monitors,
    /// which belong to the product, are left out.
    pub fn predicates(&self) -> impl Iterator<Item = &Predicate> {
        self.objectives
            .iter()
            .map(|objective| objective.goal.predicate())
            .chain(self.requirements.iter().map(|r| &r.kept))
    }

    /// Returns warnings about the preferences, without the name of their file.
    pub fn warnings(&self) -> Vec<String> {
        warnings(&self.order, self.empty)
    }
}

impl Outline {
    /// Returns warnings about the preferences, without the name of their file.
    pub fn warnings(&self) -> Vec<String> {
        warnings(&self.order, self.empty)
    }
}

fn warnings(order: &Preorder, empty: Empty) -> Vec<String> {
    if order.len() < 2 || !order.prefers_nothing() {
        return Vec::new();
    }
    let left = match empty {
        Empty::Incomparable => "no step improves",
        Empty::Bottom | Empty::Gain => "only gaining a first objective improves",
    };
    let advice = "a statement such as `prefer A > B;` adds one";
    vec![format!("prefers no objective to another: {left}; {advice}")]
}

impl History {
    /// Returns the name, if it is not the default: reports leave that out.
    pub fn shown(self) -> Option<&'static str> {
        (self == History::Play).then_some(self.name())
    }

    /// Returns the name in preference files and reports.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// The goal of an objective.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Goal<M = Predicate> {
    /// Reaching a state in which the condition is true.
    Reach(M),
    /// Satisfying a formula, which monitors judge on the whole path.
    Satisfy {
        /// The condition on the monitors' marks.
        condition: Condition<M>,
        /// The states in which the path so far, with this state, satisfies the formula, whatever
        /// follows: the formula is achieved.
        decided: M,
        /// The number of states of its monitors together.
        monitor: u64,
    },
}

impl<M: Clone + Ord> Goal<M> {
    /// Returns the states of the target, or those in which the formula is satisfied whatever follows.
    fn predicate(&self) -> &M {
        match self {
            Goal::Reach(states) | Goal::Satisfy { decided: states, .. } => states,
        }
    }

    /// Returns the same goal with other conditions.
    pub fn map<N>(self, of: &impl Fn(M) -> N) -> Goal<N> {
        match self {
            Goal::Reach(target) => Goal::Reach(of(target)),
            Goal::Satisfy { condition, decided, monitor } => {
                Goal::Satisfy { condition: condition.map(of), decided: of(decided), monitor }
            }
        }
    }
}

impl<M> Requirement<M> {
    /// Returns the same requirement with another condition.
    pub fn map<N>(self, of: &impl Fn(M) -> N) -> Requirement<N> {
        Requirement { text: self.text, kept: of(self.kept), monitor: self.monitor }
    }
}

/// An objective: reaching a state of its target, or satisfying a formula.
#[derive(Debug, Clone)]
pub struct Objective {
    /// Its name.
    pub name: String,
    /// Its goal.
    pub goal: Goal,
    /// Its position in the preference file.
    pub span: Option<Range<usize>>,
}

impl Objective {
    /// Returns the predicate of the target states, if the objective is reachability.
    pub fn target(&self) -> Option<&Predicate> {
        match &self.goal {
            Goal::Reach(target) => Some(target),
            Goal::Satisfy { .. } => None,
        }
    }

    /// Returns the number of states of its monitors together; `None` for reachability from the
    /// present state.
    pub fn monitor(&self) -> Option<u64> {
        match self.goal {
            Goal::Reach(_) => None,
            Goal::Satisfy { monitor, .. } => Some(monitor),
        }
    }
}

impl Preferences {
    /// Returns the name `play` if the whole path counts, else `None`: `state` is not reported.
    pub fn whole_paths(&self) -> Option<&'static str> {
        self.history.shown()
    }
}

meliora_base::named! {
    /// The value of nothing: the comparison with an empty set of most preferred objectives, `empty = …`
    /// of a preference file.
    #[derive(Default, strum::Display)]
    pub enum Empty {
        /// Achieving nothing is worse than every objective.
        #[default]
        Bottom,
        /// Gaining a first objective improves; losing the last one does not weaken.
        Gain,
        /// Achieving nothing is incomparable to every objective.
        Incomparable,
    }
}

/// The effect of a step from one set of most preferred objectives to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, IntoStaticStr, schemars::JsonSchema)]
#[strum(serialize_all = "lowercase")]
#[schemars(rename_all = "lowercase")]
pub enum Change {
    /// The step improves and does not weaken.
    Improving,
    /// The step weakens, even if it also improves.
    Weakening,
    /// The step neither improves nor weakens.
    Lateral,
}

impl Change {
    /// Returns the name in reports.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

impl Preferences {
    /// Returns MP(X) = { i ∈ X : no j ∈ X is strictly preferred to i }.
    pub fn most_preferred(&self, achieved: &ObjectiveSet) -> ObjectiveSet {
        self.order.maximal(achieved)
    }

    /// Returns whether some j ∈ `to` is strictly preferred to some i ∈ `from`. For an empty side,
    /// [`Empty`] decides.
    pub fn improves(&self, from: &ObjectiveSet, to: &ObjectiveSet) -> bool {
        self.rated(from).improved_by(&self.rated(to), self.empty)
    }

    /// Returns whether some i ∈ `from` is strictly preferred to some j ∈ `to`. For an empty side,
    /// [`Empty`] decides.
    pub fn weakens(&self, from: &ObjectiveSet, to: &ObjectiveSet) -> bool {
        self.rated(from).weakened_by(&self.rated(to), self.empty)
    }

    /// Returns the effect of a step between states with these most preferred objectives.
    pub fn change(&self, from: &ObjectiveSet, to: &ObjectiveSet) -> Change {
        self.change_between(&self.rated(from), &self.rated(to))
    }

    /// Returns a set with the objectives that are preferred to it, for [`Preferences::change_between`].
    pub fn rated<'s>(&self, set: &'s ObjectiveSet) -> Rated<'s> {
        let mut above = ObjectiveSet::new();
        set.iter().filter_map(|i| self.order.strictly_above(i)).for_each(|more| above.extend_with(more));
        Rated { set, above }
    }

    /// Returns the effect of a step like [`Preferences::change`], in time linear in the number of
    /// objectives.
    pub fn change_between(&self, from: &Rated<'_>, to: &Rated<'_>) -> Change {
        if from.weakened_by(to, self.empty) {
            Change::Weakening
        } else if from.improved_by(to, self.empty) {
            Change::Improving
        } else {
            Change::Lateral
        }
    }

    /// Returns the names of a set's members in the order of declaration.
    pub fn names(&self, set: &ObjectiveSet) -> Vec<&str> {
        set.iter().filter_map(|i| self.objectives.get(i)).map(|o| o.name.as_str()).collect()
    }

    /// Returns the names like [`Preferences::names`], as texts of their own.
    pub fn owned_names(&self, set: &ObjectiveSet) -> Vec<String> {
        self.names(set).into_iter().map(str::to_owned).collect()
    }
}

/// A set of objectives with all objectives that are strictly preferred to one of its members.
#[derive(Debug, Clone)]
pub struct Rated<'s> {
    set: &'s ObjectiveSet,
    above: ObjectiveSet,
}

impl Rated<'_> {
    fn improved_by(&self, to: &Rated<'_>, empty: Empty) -> bool {
        if self.set.is_empty() || to.set.is_empty() {
            return empty != Empty::Incomparable && self.set.is_empty() && !to.set.is_empty();
        }
        self.above.meets(to.set)
    }

    fn weakened_by(&self, to: &Rated<'_>, empty: Empty) -> bool {
        if self.set.is_empty() || to.set.is_empty() {
            return empty == Empty::Bottom && !self.set.is_empty() && to.set.is_empty();
        }
        to.above.meets(self.set)
    }
}

/// A set of objectives, by their positions; any number of them.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct ObjectiveSet {
    /// Bit i % 64 of block i / 64 stands for objective i. The last block is not 0, so that equal
    /// sets are equal vectors.
    blocks: Vec<u64>,
}

impl ObjectiveSet {
    /// Creates the empty set.
    pub fn new() -> Self {
        ObjectiveSet::default()
    }

    /// Adds an objective: X ∪ {i}.
    pub fn insert(&mut self, objective: usize) {
        let block = objective / 64;
        if self.blocks.len() <= block {
            self.blocks.resize(block + 1, 0);
        }
        self.blocks[block] |= 1 << (objective % 64);
    }

    /// Adds all objectives of another set: X ∪ Y.
    pub fn extend_with(&mut self, other: &ObjectiveSet) {
        let length = self.blocks.len().max(other.blocks.len());
        self.blocks.resize(length, 0);
        for (block, more) in self.blocks.iter_mut().zip(&other.blocks) {
            *block |= more;
        }
    }

    /// Returns whether i ∈ X.
    pub fn contains(&self, objective: usize) -> bool {
        self.blocks.get(objective / 64).is_some_and(|b| b >> (objective % 64) & 1 == 1)
    }

    /// Returns whether X ∩ Y ≠ ∅.
    pub(crate) fn meets(&self, other: &ObjectiveSet) -> bool {
        self.blocks.iter().zip(&other.blocks).any(|(a, b)| a & b != 0)
    }

    /// Returns whether X = ∅.
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// Returns |X|.
    pub fn len(&self) -> usize {
        self.blocks.iter().map(|b| b.count_ones() as usize).sum()
    }

    /// Returns the members, smallest first.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        let bits = |(k, &block): (usize, &u64)| {
            (0..64).filter(move |i| block >> i & 1 == 1).map(move |i| 64 * k + i)
        };
        self.blocks.iter().enumerate().flat_map(bits)
    }
}

impl FromIterator<usize> for ObjectiveSet {
    fn from_iter<I: IntoIterator<Item = usize>>(objectives: I) -> Self {
        let mut set = ObjectiveSet::new();
        objectives.into_iter().for_each(|i| set.insert(i));
        set
    }
}
