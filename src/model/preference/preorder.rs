//! The preorder that statements of a preference file make, or the contradiction between them.

use std::collections::VecDeque;
use std::fmt;

use super::ObjectiveSet;

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
