//! The reason why an action is permitted or not.

use strum::{IntoStaticStr, VariantNames};

use super::achieve::Manner;
use super::explain::Successor;
use crate::analysis::levels::Kind;
use meliora_model::preference::Change;

/// The reason why an action is permitted or not, or what an action of the opponent leads to;
/// successors are given by their positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantNames)]
#[strum(serialize_all = "kebab-case")]
pub enum Verdict {
    /// Permitted: every kept successor is reached by a goal edge of the level.
    Improves,
    /// Permitted: some successor is reached by a goal edge of the level.
    MayImprove,
    /// Permitted: some successor is one layer closer to a goal edge.
    Approaches,
    /// Permitted, but makes no progress.
    Stays,
    /// Not kept: this successor weakens.
    Weakens(usize),
    /// Not kept under `prefix`: after this successor, weakening cannot be avoided forever. `None`
    /// if this is the case in the state itself.
    Unsafe(Option<usize>),
    /// Not kept in a game: after this successor, the opponent can weaken.
    Exposes(usize),
    /// An action of the opponent that neither improves nor weakens.
    Lateral,
    /// Not possible under the requirements: this successor is unsafe. `None` if the state itself is
    /// unsafe.
    Violates(Option<usize>),
    /// Kept, but this successor leaves the states from which the improvements are certain.
    Strays(usize),
    /// Kept, but no goal edge of the level can follow.
    Hopeless,
    /// Kept, but the state has rank 0: no improvement is possible.
    NothingAhead,
    /// Permitted: every successor achieves the pursued objective.
    Achieves,
    /// Permitted: some successor achieves the pursued objective.
    MayAchieve,
    /// Permitted: some successor is closer to the pursued objective.
    Nears,
    /// Permitted: the pursued objective remains certain, but comes no closer.
    Keeps,
    /// Not permitted: after this successor the pursued objective is no longer certain or, before a
    /// commitment, the kept choices no longer suffice for it.
    Forfeits(usize),
    /// Not permitted: no strategy achieves the objective almost surely from here.
    Unachievable,
    /// Permitted: no action achieves the pursued objective with a greater probability.
    Likeliest,
    /// Not permitted: the strategy takes another action, with which the probability of the pursued
    /// objective is not smaller.
    PassedOver,
    /// Not permitted: no strategy achieves the objective with positive probability from here.
    Impossible,
}

impl Verdict {
    /// The names of all verdicts in reports.
    pub const NAMES: &[&str] = <Verdict as VariantNames>::VARIANTS;
}

impl Verdict {
    /// Returns the name in reports.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// The facts that decide the verdict on an action, besides its successors.
pub(crate) struct Case {
    /// The manner in which the strategy pursues an objective.
    pub(crate) pursuit: Option<Manner>,
    /// True if the strategy is to achieve an objective.
    pub(crate) achieves: bool,
    /// True if no strategy keeps the requirements from the state.
    pub(crate) is_unsafe: bool,
    /// The kind of the levels.
    pub(crate) kind: Kind,
    /// True if the improvement MDP keeps the action.
    pub(crate) kept: bool,
    /// Two truth values: the strategy of the level or stage permits the action, and the action makes
    /// progress. `None` without a strategy.
    pub(crate) level: Option<(bool, bool)>,
    /// For an action that is not kept: the first successor outside of the states that paths may visit.
    pub(crate) outside: Option<usize>,
    /// For an action that is not kept: the first successor from which the opponent can weaken.
    pub(crate) exposed: Option<usize>,
}

impl Case {
    /// Returns the verdict: the first that applies, in this order.
    pub(crate) fn verdict(&self, successors: &[Successor]) -> Verdict {
        let first = |is_it: fn(&Successor) -> bool| successors.iter().position(is_it);
        let pursuit = self.pursuit.filter(|_| self.level.is_some());
        let weakening = first(|s| s.change == Change::Weakening);
        let keeps = pursuit.is_none_or(|manner| manner == Manner::Kept);
        match self.level {
            Some((true, progress)) if pursuit.is_some() => return pursuing(successors, progress),
            Some((true, progress)) => return allowed(successors, progress),
            None if self.achieves && !self.is_unsafe => return Verdict::Unachievable,
            _ => {}
        }
        if self.is_unsafe {
            return Verdict::Violates(None);
        }
        if let Some(index) = first(|s| s.is_unsafe) {
            return Verdict::Violates(Some(index));
        }
        // A plan that has not committed takes only kept choices, and none with a branch that weakens.
        match weakening {
            Some(index) if keeps && (!self.kept || pursuit.is_some()) => return Verdict::Weakens(index),
            None if keeps && !self.kept => return self.risk(),
            _ => {}
        }
        if pursuit.is_some() {
            return first(|s| !s.stays).map_or(Verdict::Unachievable, Verdict::Forfeits);
        }
        match (self.level, first(|s| !s.dropped && !s.goal && !s.stays)) {
            (None, _) => Verdict::NothingAhead,
            (Some(_), Some(index)) if self.kind == Kind::Sasi => Verdict::Strays(index),
            (Some(_), _) => Verdict::Hopeless,
        }
    }
}

impl Case {
    /// Returns the reason why an action is not kept of which no successor weakens.
    fn risk(&self) -> Verdict {
        self.exposed.map_or(Verdict::Unsafe(self.outside), Verdict::Exposes)
    }

    /// Returns what an action of the opponent leads to: the first verdict that applies, in this order.
    pub(crate) fn answer(&self, successors: &[Successor]) -> Verdict {
        let first = |is_it: fn(&Successor) -> bool| successors.iter().position(is_it);
        let pursuit = self.pursuit.filter(|_| self.level.is_some());
        let compares = pursuit.map_or(!self.achieves, |manner| manner == Manner::Kept);
        if let Some(index) = first(|s| s.is_unsafe) {
            return Verdict::Violates(Some(index));
        }
        if pursuit.is_some() && successors.iter().any(|s| s.goal) {
            return pursuing(successors, false);
        }
        match first(|s| s.change == Change::Weakening) {
            Some(index) if compares => return Verdict::Weakens(index),
            None if compares && !self.kept && (self.exposed.is_some() || self.outside.is_some()) => {
                return self.risk();
            }
            _ => {}
        }
        match successors.iter().filter(|s| s.change == Change::Improving).count() {
            0 => Verdict::Lateral,
            n if n == successors.len() => Verdict::Improves,
            _ => Verdict::MayImprove,
        }
    }
}

/// Returns the reason why an action is permitted while an objective is pursued.
fn pursuing(successors: &[Successor], progress: bool) -> Verdict {
    match (successors.iter().filter(|s| s.goal).count(), progress) {
        (0, true) => Verdict::Nears,
        (0, false) => Verdict::Keeps,
        (n, _) if n == successors.len() => Verdict::Achieves,
        _ => Verdict::MayAchieve,
    }
}

/// Returns the reason why an action is permitted.
fn allowed(successors: &[Successor], progress: bool) -> Verdict {
    let mut kept = successors.iter().filter(|s| !s.dropped);
    if kept.clone().all(|s| s.goal) {
        Verdict::Improves
    } else if kept.any(|s| s.goal) {
        Verdict::MayImprove
    } else if progress {
        Verdict::Approaches
    } else {
        Verdict::Stays
    }
}

#[cfg(test)]
mod tests {
    use super::super::finite_memory::Memory;
    use super::*;
    use crate::levels::Rank;
    use meliora_model::preference::ObjectiveSet;

    fn successor(dropped: bool, goal: bool, stays: bool) -> Successor {
        Successor {
            state: Vec::new(),
            probability: 0.25,
            is_unsafe: false,
            most_preferred: ObjectiveSet::new(),
            rank: Rank::Finite(0),
            change: Change::Lateral,
            gained: ObjectiveSet::new(),
            lost: ObjectiveSet::new(),
            dropped,
            goal,
            achieves: ObjectiveSet::new(),
            stays,
            next: Memory { level: Rank::Finite(0), arena: None, pursuit: None },
            improves: false,
        }
    }

    /// The case of an action that is kept, but not permitted.
    fn kept(kind: Kind) -> Case {
        let (pursuit, level) = (None, Some((false, false)));
        Case {
            pursuit,
            achieves: false,
            is_unsafe: false,
            kind,
            kept: true,
            level,
            outside: None,
            exposed: None,
        }
    }

    #[test]
    fn what_strays_is_there_and_neither_improves_nor_stays() {
        let fine =
            [successor(true, false, false), successor(false, true, false), successor(false, false, true)];
        assert_eq!(kept(Kind::Sasi).verdict(&fine), Verdict::Hopeless);
        let [first, second, third] = fine;
        let all = [first, second, third, successor(false, false, false)];
        assert_eq!(kept(Kind::Sasi).verdict(&all), Verdict::Strays(3));
        assert_eq!(kept(Kind::Spi).verdict(&all), Verdict::Hopeless);
    }

    /// An improving step of the opponent achieves nothing that is pursued, unless something is.
    #[test]
    fn a_step_of_the_opponent_achieves_only_where_something_is_pursued() {
        let mut all = [successor(false, true, false), successor(false, false, false)];
        all[0].change = Change::Improving;
        assert_eq!(kept(Kind::Sasi).answer(&all), Verdict::MayImprove);
        assert_eq!(kept(Kind::Sasi).answer(&all[..1]), Verdict::Improves);
        let plan = || Case { pursuit: Some(Manner::Kept), ..kept(Kind::Sasi) };
        assert_eq!(plan().answer(&all), Verdict::MayAchieve);
        assert_eq!(plan().answer(&all[1..]), Verdict::Lateral);
    }

    /// Unless an objective is to be achieved, or the strategy has committed to one.
    #[test]
    fn what_the_opponent_loses_is_told() {
        let mut all = [successor(false, false, false)];
        let committed = Some(Manner::Committed);
        let forgives =
            [Case { achieves: true, ..kept(Kind::Sasi) }, Case { pursuit: committed, ..kept(Kind::Sasi) }];
        for exposed in [None, Some(0)] {
            for outside in [None, Some(0)] {
                let lost =
                    |is_kept| Case { kept: is_kept, exposed, outside, ..kept(Kind::Sasi) }.answer(&all);
                assert_eq!(lost(true), Verdict::Lateral);
                let risk = match (exposed, outside) {
                    (Some(index), _) => Verdict::Exposes(index),
                    (None, Some(_)) => Verdict::Unsafe(outside),
                    (None, None) => Verdict::Lateral,
                };
                assert_eq!(lost(false), risk);
            }
        }
        all[0].change = Change::Weakening;
        assert_eq!(kept(Kind::Sasi).answer(&all), Verdict::Weakens(0));
        assert_eq!(forgives.map(|case| case.answer(&all)), [Verdict::Lateral; 2]);
    }

    #[test]
    fn of_several_verdicts_the_first_in_the_documented_order_counts() {
        let mut all: Vec<Successor> = (0..3).map(|_| successor(false, false, false)).collect();
        (all[1].change, all[2].is_unsafe) = (Change::Weakening, true);
        let refused = || Case { kept: false, outside: Some(0), ..kept(Kind::Sasi) };
        let manners = [None, Some(Manner::Kept), Some(Manner::Committed)];
        for pursuit in manners {
            assert_eq!(Case { is_unsafe: true, pursuit, ..refused() }.verdict(&all), Verdict::Violates(None));
            assert_eq!(Case { pursuit, ..refused() }.verdict(&all), Verdict::Violates(Some(2)));
            let permitted = Case { level: Some((true, true)), pursuit, ..kept(Kind::Sasi) };
            let expected = if pursuit.is_some() { Verdict::Nears } else { Verdict::Approaches };
            assert_eq!(permitted.verdict(&all), expected);
        }
        all[2].is_unsafe = false;
        let [none, plan, committed] = manners;
        assert_eq!(refused().verdict(&all), Verdict::Weakens(1));
        assert_eq!(Case { pursuit: plan, ..kept(Kind::Sasi) }.verdict(&all), Verdict::Weakens(1));
        assert_eq!(Case { pursuit: committed, ..refused() }.verdict(&all), Verdict::Forfeits(0));
        assert_eq!(
            Case { level: None, pursuit: none, ..kept(Kind::Sasi) }.verdict(&all),
            Verdict::NothingAhead
        );
        all[1].change = Change::Lateral;
        assert_eq!(refused().verdict(&all), Verdict::Unsafe(Some(0)));
        assert_eq!(Case { pursuit: plan, ..refused() }.verdict(&all), Verdict::Unsafe(Some(0)));
        assert_eq!(Case { level: None, achieves: true, ..refused() }.verdict(&all), Verdict::Unachievable);
        all.iter_mut().for_each(|s| s.stays = true);
        assert_eq!(Case { pursuit: committed, ..refused() }.verdict(&all), Verdict::Unachievable);
    }
}
