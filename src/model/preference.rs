//! Preferences: a preorder on objectives, and what it says of sets of them.
//!
//! No state and no diagram here; [`crate::planning`] applies these to regions.

use std::collections::VecDeque;
use std::fmt;
use std::ops::Range;

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
    /// To satisfy a formula, as observers see the whole play.
    Satisfy {
        /// What is asked of their marks.
        condition: Condition,
        /// How many states its observers have together.
        observer: u64,
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

    /// How many states its observers have together; none for a reachability from the present state.
    pub fn observer(&self) -> Option<u64> {
        match self.goal {
            Goal::Reach(_) => None,
            Goal::Satisfy { observer, .. } => Some(observer),
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

/// What one statement of a preference file says of two objectives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Relation {
    /// `x > y`
    Strict,
    /// `x >= y`
    Weak,
    /// `x ~ y`
    Indifferent,
}

impl fmt::Display for Relation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Relation::Strict => ">",
            Relation::Weak => ">=",
            Relation::Indifferent => "~",
        })
    }
}

/// `left relation right`, objectives by position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Statement {
    /// The preferred side.
    pub left: usize,
    /// How.
    pub relation: Relation,
    /// The other side.
    pub right: usize,
}

/// A statement `x > y` although the closure of all statements has y >= x.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the preferences contradict each other: an objective is strictly preferred to itself")]
pub struct Contradiction {
    /// The objectives around the cycle x, y, …: each is stated to be at least as good as the next,
    /// and the last as the first.
    pub cycle: Vec<usize>,
    /// The statement behind each step of the cycle, by its position; the first is the strict one.
    pub statements: Vec<usize>,
}

/// How two objectives compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Comparison {
    /// The first is strictly preferred.
    Preferred,
    /// The second is strictly preferred.
    Dispreferred,
    /// Each is at least as good as the other.
    Indifferent,
    /// Neither is at least as good as the other.
    Incomparable,
}

/// A preorder on objectives 0 … n-1.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Preorder {
    /// For each x: { y : x >= y }.
    at_least: Vec<ObjectiveSet>,
    /// For each y: { x : x > y }.
    above: Vec<ObjectiveSet>,
}

impl Preorder {
    /// The reflexive-transitive closure of the statements over objectives 0 … n-1.
    ///
    /// Statements about positions past n-1 are ignored.
    ///
    /// # Errors
    /// A stated `x > y` whose closure also has y >= x, with a shortest cycle through it.
    pub fn new(n: usize, statements: &[Statement]) -> Result<Self, Contradiction> {
        let mut at_least: Vec<ObjectiveSet> = (0..n).map(|x| ObjectiveSet::from_iter([x])).collect();
        for s in statements.iter().filter(|s| s.left < n && s.right < n) {
            at_least[s.left].insert(s.right);
            if s.relation == Relation::Indifferent {
                at_least[s.right].insert(s.left);
            }
        }
        close(&mut at_least);
        for (index, s) in statements.iter().enumerate() {
            let known = s.left < n && s.right < n;
            if known && s.relation == Relation::Strict && at_least[s.right].contains(s.left) {
                return Err(contradiction(n, statements, index));
            }
        }
        let above = (0..n)
            .map(|y| (0..n).filter(|&x| at_least[x].contains(y) && !at_least[y].contains(x)).collect())
            .collect();
        Ok(Preorder { at_least, above })
    }

    /// The number of objectives.
    pub fn len(&self) -> usize {
        self.at_least.len()
    }

    /// Whether there is no objective.
    pub fn is_empty(&self) -> bool {
        self.at_least.is_empty()
    }

    /// x >= y
    pub fn at_least(&self, x: usize, y: usize) -> bool {
        self.at_least.get(x).is_some_and(|below| below.contains(y))
    }

    /// x >= y and not y >= x
    pub fn strictly(&self, x: usize, y: usize) -> bool {
        self.strictly_above(y).is_some_and(|above| above.contains(x))
    }

    /// Whether x > y for no x and y.
    pub fn prefers_nothing(&self) -> bool {
        self.above.iter().all(ObjectiveSet::is_empty)
    }

    /// { x : x > y }; none where y is no objective.
    pub fn strictly_above(&self, y: usize) -> Option<&ObjectiveSet> {
        self.above.get(y)
    }

    /// How x and y compare.
    pub fn compare(&self, x: usize, y: usize) -> Comparison {
        match (self.at_least(x, y), self.at_least(y, x)) {
            (true, true) => Comparison::Indifferent,
            (true, false) => Comparison::Preferred,
            (false, true) => Comparison::Dispreferred,
            (false, false) => Comparison::Incomparable,
        }
    }

    /// { i ∈ X : no j ∈ X is strictly preferred to i }
    pub fn maximal(&self, set: &ObjectiveSet) -> ObjectiveSet {
        set.iter().filter(|&i| !self.strictly_above(i).is_some_and(|above| above.meets(set))).collect()
    }

    /// Some y ∈ `high` is strictly preferred to some x ∈ `low`.
    pub fn some_above(&self, low: &ObjectiveSet, high: &ObjectiveSet) -> bool {
        low.iter().any(|x| self.strictly_above(x).is_some_and(|above| above.meets(high)))
    }
}

/// Warshall's closure, a row at a time.
fn close(at_least: &mut [ObjectiveSet]) {
    for middle in 0..at_least.len() {
        let through = at_least[middle].clone();
        for row in at_least.iter_mut().filter(|row| row.contains(middle)) {
            row.extend_with(&through);
        }
    }
}

/// The shortest way back from the right side of a strict statement to its left side.
fn contradiction(n: usize, statements: &[Statement], strict: usize) -> Contradiction {
    let Statement { left, right, .. } = statements[strict];
    // Breadth first from `right`: who was entered from whom, by which statement.
    let mut entered: Vec<Option<(usize, usize)>> = vec![None; n];
    let mut queue = VecDeque::from([right]);
    while entered[left].is_none()
        && let Some(x) = queue.pop_front()
    {
        for (y, statement) in stated_below(statements, x) {
            if y < n && y != right && entered[y].is_none() {
                entered[y] = Some((x, statement));
                queue.push_back(y);
            }
        }
    }
    let (mut cycle, mut steps) = (Vec::new(), Vec::new());
    let mut at = left;
    while let Some((from, statement)) = entered[at].filter(|_| at != right) {
        cycle.push(from);
        steps.push(statement);
        at = from;
    }
    cycle.reverse();
    steps.reverse();
    Contradiction {
        cycle: [left].into_iter().chain(cycle).collect(),
        statements: [strict].into_iter().chain(steps).collect(),
    }
}

/// The objectives stated to be at most as good as x, each with the statement that says so.
fn stated_below(statements: &[Statement], x: usize) -> impl Iterator<Item = (usize, usize)> + '_ {
    statements.iter().enumerate().filter_map(move |(index, s)| {
        if s.left == x {
            Some((s.right, index))
        } else if s.right == x && s.relation == Relation::Indifferent {
            Some((s.left, index))
        } else {
            None
        }
    })
}
