//! Preferences: a preorder on objectives, and what it says of sets of them.
//!
//! No state and no diagram here; [`crate::planning`] applies these to regions.

mod preorder;

use std::fmt;
use std::ops::Range;

pub use preorder::{Comparison, Contradiction, Preorder, Relation, Statement};

use super::expr::ExprId;
use super::temporal::Condition;

/// The objectives of a preference file with their order.
#[derive(Debug, Clone)]
pub struct Preferences {
    /// The objectives in the order of declaration.
    pub objectives: Vec<Objective>,
    /// Which objective is preferred to which.
    pub order: Preorder,
    /// What it is worth to achieve nothing.
    pub empty: Empty,
    /// Which part of a play counts.
    pub history: History,
}

/// What a preference file says without a model.
#[derive(Debug, Clone)]
pub struct Outline {
    /// The objectives in the order of declaration: their names, and their formulas as they are written.
    pub objectives: Vec<(String, String)>,
    /// Which objective is preferred to which.
    pub order: Preorder,
    /// What it is worth to achieve nothing.
    pub empty: Empty,
    /// Which part of a play counts.
    pub history: History,
}

/// Which part of a play counts: `history = …` of a preference file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum History {
    /// From the present state on: what was reached before does not count.
    #[default]
    State,
    /// All of it, from where planning started.
    Play,
}

impl History {
    /// The word for it in preference files and reports.
    pub fn name(self) -> &'static str {
        match self {
            History::State => "state",
            History::Play => "play",
        }
    }

    /// The value with this name.
    pub fn named(name: &str) -> Option<History> {
        [History::State, History::Play].into_iter().find(|h| h.name() == name)
    }
}

/// What an objective asks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Goal {
    /// To reach a state in which this holds.
    Reach(ExprId),
    /// To satisfy a formula, as monitors see the whole play.
    Satisfy {
        /// What is asked of their marks.
        condition: Condition,
        /// How many states its monitors have together.
        monitor: u64,
    },
}

/// An objective: to reach a state of its target, or to satisfy a formula.
#[derive(Debug, Clone)]
pub struct Objective {
    /// Its name.
    pub name: String,
    /// What it asks.
    pub goal: Goal,
    /// Where it stands in the preference file.
    pub span: Option<Range<usize>>,
}

impl Objective {
    /// What holds in the states to be reached, where that is the objective.
    pub fn target(&self) -> Option<ExprId> {
        match self.goal {
            Goal::Reach(target) => Some(target),
            Goal::Satisfy { .. } => None,
        }
    }

    /// How many states its monitors have together; none for a reachability from the present state.
    pub fn monitor(&self) -> Option<u64> {
        match self.goal {
            Goal::Reach(_) => None,
            Goal::Satisfy { monitor, .. } => Some(monitor),
        }
    }
}

impl Preferences {
    /// `play`, where the whole play counts; what needs no word has none.
    pub fn whole_plays(&self) -> Option<&'static str> {
        (self.history == History::Play).then_some(self.history.name())
    }
}

/// What an empty set of most preferred outcomes is worth: `empty = …` of a preference file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Empty {
    /// An outcome "nothing" below every objective: to gain the first objective improves, to lose the
    /// last one weakens.
    #[default]
    Bottom,
    /// To gain the first objective improves; to lose the last one does not weaken.
    Gain,
    /// With an empty side there is no pair, so neither.
    Incomparable,
}

impl Empty {
    /// All values, the default first.
    pub const ALL: [Empty; 3] = [Empty::Bottom, Empty::Gain, Empty::Incomparable];

    /// The word for it in preference files and reports.
    pub fn name(self) -> &'static str {
        match self {
            Empty::Bottom => "bottom",
            Empty::Gain => "gain",
            Empty::Incomparable => "incomparable",
        }
    }

    /// The value with this name.
    pub fn named(name: &str) -> Option<Empty> {
        Empty::ALL.into_iter().find(|e| e.name() == name)
    }
}

impl fmt::Display for Empty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// What a step from one set of most preferred outcomes to another is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Change {
    /// It improves and does not weaken.
    Improving,
    /// It weakens, whether or not it improves too.
    Weakening,
    /// Neither.
    Lateral,
}

impl Preferences {
    /// MP(X) = { i ∈ X : no j ∈ X is strictly preferred to i }
    pub fn most_preferred(&self, achieved: &ObjectiveSet) -> ObjectiveSet {
        self.order.maximal(achieved)
    }

    /// Some j ∈ `to` is strictly preferred to some i ∈ `from`; an empty side as [`Empty`] says.
    pub fn improves(&self, from: &ObjectiveSet, to: &ObjectiveSet) -> bool {
        if from.is_empty() || to.is_empty() {
            return self.empty != Empty::Incomparable && from.is_empty() && !to.is_empty();
        }
        self.order.some_above(from, to)
    }

    /// Some i ∈ `from` is strictly preferred to some j ∈ `to`; an empty side as [`Empty`] says.
    pub fn weakens(&self, from: &ObjectiveSet, to: &ObjectiveSet) -> bool {
        if from.is_empty() || to.is_empty() {
            return self.empty == Empty::Bottom && !from.is_empty() && to.is_empty();
        }
        self.order.some_above(to, from)
    }

    /// What a step between states of these most preferred outcomes is.
    pub fn change(&self, from: &ObjectiveSet, to: &ObjectiveSet) -> Change {
        if self.weakens(from, to) {
            Change::Weakening
        } else if self.improves(from, to) {
            Change::Improving
        } else {
            Change::Lateral
        }
    }

    /// The names of a set's members in the order of declaration.
    pub fn names(&self, set: &ObjectiveSet) -> Vec<&str> {
        set.iter().filter_map(|i| self.objectives.get(i)).map(|o| o.name.as_str()).collect()
    }
}

/// A set of objectives, by their positions; any number of them.
#[derive(Debug, Clone, PartialEq, Eq, Hash, Default)]
pub struct ObjectiveSet {
    /// Bit i % 64 of block i / 64 is objective i; the last block is not 0, so that equal sets are
    /// equal vectors.
    blocks: Vec<u64>,
}

impl ObjectiveSet {
    /// ∅
    pub fn new() -> Self {
        ObjectiveSet::default()
    }

    /// X ∪ {i}
    pub fn insert(&mut self, objective: usize) {
        let block = objective / 64;
        if self.blocks.len() <= block {
            self.blocks.resize(block + 1, 0);
        }
        self.blocks[block] |= 1 << (objective % 64);
    }

    /// X ∪ Y
    pub fn extend_with(&mut self, other: &ObjectiveSet) {
        let length = self.blocks.len().max(other.blocks.len());
        self.blocks.resize(length, 0);
        for (block, more) in self.blocks.iter_mut().zip(&other.blocks) {
            *block |= more;
        }
    }

    /// i ∈ X
    pub fn contains(&self, objective: usize) -> bool {
        self.blocks.get(objective / 64).is_some_and(|b| b >> (objective % 64) & 1 == 1)
    }

    /// X ∩ Y ≠ ∅
    pub fn meets(&self, other: &ObjectiveSet) -> bool {
        self.blocks.iter().zip(&other.blocks).any(|(a, b)| a & b != 0)
    }

    /// X = ∅
    pub fn is_empty(&self) -> bool {
        self.blocks.is_empty()
    }

    /// |X|
    pub fn len(&self) -> usize {
        self.blocks.iter().map(|b| b.count_ones() as usize).sum()
    }

    /// The members, smallest first.
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
