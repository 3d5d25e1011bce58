//! The paper's definitions word by word: closure by Warshall, MP state by state, the doubled
//! improvement MDP V = S × {0,1}, the fixpoints of [`Brute`]. Shares nothing with the library but data types.

use crate::common::prelude::*;
use crate::planning::Case;
use crate::planning::tiny::Mdp;

pub(crate) use crate::common::brute::Set;

/// PWin(F)
pub(crate) fn positive(mdp: &Mdp, target: &Set) -> Set {
    let brute = Brute::of_graph(&mdp.0);
    brute.can_reach(target, &brute.all_choices(), &[])
}

/// ASWin(F)
pub(crate) fn almost_sure(mdp: &Mdp, target: &Set) -> Set {
    let brute = Brute::of_graph(&mdp.0);
    brute.almost_surely_reach(target, &brute.all_choices()).0
}

/// A case with MP of every state and the strict order.
pub(crate) struct Literal<'a> {
    pub(crate) case: &'a Case,
    pub(crate) mp: Vec<Set>,
    strict: Vec<Vec<bool>>,
    empty: Empty,
}

impl<'a> Literal<'a> {
    pub(crate) fn new(case: &'a Case, empty: Empty) -> Self {
        let n = case.targets.len();
        let weak = closure(case);
        let strict: Vec<Vec<bool>> =
            (0..n).map(|x| (0..n).map(|y| weak[x][y] && !weak[y][x]).collect()).collect();
        let regions: Vec<Set> =
            case.targets.iter().map(|t| almost_sure(&case.mdp, &t.iter().copied().collect())).collect();
        let mp = |s: usize| {
            let out: Set = (0..n).filter(|&i| regions[i].contains(&s)).collect();
            out.iter().copied().filter(|&i| !out.iter().any(|&j| strict[j][i])).collect()
        };
        let mp = (0..case.mdp.0.len()).map(mp).collect();
        Literal { case, mp, strict, empty }
    }

    pub(crate) fn improves(&self, from: &Set, to: &Set) -> bool {
        match (from.is_empty(), to.is_empty()) {
            (true, false) => self.empty != Empty::Incomparable,
            _ => from.iter().any(|&i| to.iter().any(|&j| self.strict[j][i])),
        }
    }

    pub(crate) fn weakens(&self, from: &Set, to: &Set) -> bool {
        match (from.is_empty(), to.is_empty()) {
            (false, true) => self.empty == Empty::Bottom,
            _ => from.iter().any(|&i| to.iter().any(|&j| self.strict[i][j])),
        }
    }

    /// The successors of a choice that `safety` keeps, for `action` and `transition`.
    pub(crate) fn kept(&self, safety: Safety, s: usize, a: usize) -> Vec<usize> {
        let successors = &self.case.mdp.0[s][a];
        let weakens = |t: &usize| self.weakens(&self.mp[s], &self.mp[*t]);
        if safety == Safety::Action && successors.iter().any(weakens) {
            return Vec::new();
        }
        successors.iter().copied().filter(|t| !weakens(t)).collect()
    }

    /// The improvement MDP over V: (s, m) is state 2 s + m.
    fn doubled(&self, safety: Safety) -> Mdp {
        let mut doubled = Vec::new();
        for s in 0..self.mp.len() {
            let bit = |t: usize| usize::from(self.improves(&self.mp[s], &self.mp[t]));
            let kept = (0..self.case.mdp.0[s].len()).map(|a| self.kept(safety, s, a));
            let choices: Vec<Vec<usize>> = kept
                .filter(|successors| !successors.is_empty())
                .map(|successors| successors.iter().map(|&t| 2 * t + bit(t)).collect())
                .collect();
            doubled.extend([choices.clone(), choices]);
        }
        Mdp(doubled)
    }

    /// |V| and the number of transitions over V.
    pub(crate) fn sizes(&self, safety: Safety) -> (usize, usize) {
        let doubled = self.doubled(safety);
        (doubled.0.len(), doubled.0.iter().flatten().map(Vec::len).sum())
    }

    /// W_1, W_2, … until empty or the same again, then once more; over S.
    pub(crate) fn levels(&self, kind: Kind, safety: Safety) -> Vec<Set> {
        let mut levels: Vec<Set> = Vec::new();
        loop {
            let entered = levels.last().cloned().unwrap_or_else(|| (0..self.mp.len()).collect());
            let next = match safety {
                Safety::Prefix => self.prefix_level(kind, &entered),
                _ => self.doubled_level(kind, safety, &entered),
            };
            let done = next.is_empty() || levels.last() == Some(&next);
            levels.push(next);
            if done {
                return levels;
            }
        }
    }

    fn doubled_level(&self, kind: Kind, safety: Safety, entered: &Set) -> Set {
        let goals: Set = entered.iter().map(|s| 2 * s + 1).collect();
        let doubled = self.doubled(safety);
        let won = win(&doubled, kind, &goals);
        (0..self.mp.len()).filter(|s| won.contains(&(2 * s))).collect()
    }

    /// Safe_c of the class of MP value c.
    pub(crate) fn safe(&self, class: &Set) -> Set {
        let mut z: Set = (0..self.mp.len()).filter(|&s| !self.weakens(class, &self.mp[s])).collect();
        loop {
            let stays = |s: &usize| self.case.mdp.0[*s].iter().any(|c| c.iter().all(|t| z.contains(t)));
            let fewer: Set = z.iter().copied().filter(stays).collect();
            if fewer == z {
                return z;
            }
            z = fewer;
        }
    }

    fn prefix_level(&self, kind: Kind, entered: &Set) -> Set {
        let classes: BTreeSet<&Set> = self.mp.iter().collect();
        let mut level = Set::new();
        for class in classes {
            let safe = self.safe(class);
            let inside = |s: usize| {
                let stays = |c: &&Vec<usize>| safe.contains(&s) && c.iter().all(|t| safe.contains(t));
                self.case.mdp.0[s].iter().filter(stays).cloned().collect()
            };
            let game = Mdp((0..self.mp.len()).map(inside).collect());
            let goal =
                |s: &usize| entered.contains(s) && safe.contains(s) && self.improves(class, &self.mp[*s]);
            let won = win(&game, kind, &(0..self.mp.len()).filter(goal).collect());
            level.extend(won.into_iter().filter(|&s| safe.contains(&s) && self.mp[s] == *class));
        }
        level
    }
}

fn win(mdp: &Mdp, kind: Kind, goals: &Set) -> Set {
    match kind {
        Kind::Sasi => almost_sure(mdp, goals),
        Kind::Spi => positive(mdp, goals),
    }
}

fn closure(case: &Case) -> Vec<Vec<bool>> {
    let n = case.targets.len();
    let mut weak: Vec<Vec<bool>> = (0..n).map(|x| (0..n).map(|y| x == y).collect()).collect();
    for s in &case.statements {
        weak[s.left][s.right] = true;
        weak[s.right][s.left] |= s.relation == Relation::Indifferent;
    }
    for k in 0..n {
        for x in 0..n {
            for y in 0..n {
                weak[x][y] |= weak[x][k] && weak[k][y];
            }
        }
    }
    weak
}
