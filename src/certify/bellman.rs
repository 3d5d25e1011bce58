//! One step of the optimality equations of P_k and C_k (`docs/quantities.md`), in fractions.
//!
//! With B the operator of the equations, a bound holds if
//!
//! - upper bounds of probabilities: U ≥ B(U), as P_k is the least solution;
//! - lower bounds of probabilities: L ≤ B(L) by some choice that enters a smaller rank with positive
//!   probability, where L > 0;
//! - lower bounds of costs: L ≤ cost + Σ p L for every permitted choice;
//! - upper bounds of costs: U ≥ cost + Σ p U for some permitted choice that enters a smaller rank,
//!   where U is finite.
//!
//! A step has rank 0 if its value is given: it is counted, lost, known from the levels, or has the
//! lower bound 0. K. Chatterjee et al., "Fixed point certificates for reachability and expected
//! rewards in MDPs" (TACAS 2025).
//!
//! In a game, a state of the opponent has these conditions with *some* and *every* exchanged:
//!
//! - upper bounds of probabilities: some choice has at most U. If the opponent takes these choices, U
//!   is above the least solution for us;
//! - lower bounds of probabilities: every choice has at least L and enters a smaller rank, where L > 0,
//!   so that L is below what our choices guarantee, whatever the opponent does;
//! - lower bounds of costs: some permitted choice costs at least L. If the opponent takes these choices,
//!   no strategy of ours that makes the improvements costs less;
//! - upper bounds of costs: every choice is permitted, costs at most U and enters a smaller rank, where
//!   U is finite, so that our choices make the improvements, whatever the opponent does.
//!
//! A choice that the arena does not keep loses the path if the opponent takes it.
//! `proofs.md` has the proofs.

use num_traits::{One, Zero};

use super::arena::Arena;
use super::checker::Checker;
use super::condition::Condition;
use super::error::{CheckError, CheckResult};
use super::table::{Entry, Table};
use meliora_base::bound::Bound;
use meliora_base::exact::Ratio;
use meliora_dump::bounds::Bounds;
use meliora_engine::Engine;
use meliora_model::rewards::RewardStructure;
use meliora_model::step::Choice;
use meliora_model::{Program, fault};

/// The cost of a step.
pub(super) enum Costs<'p> {
    /// 1
    Steps,
    /// The rewards of a structure.
    Rewards(&'p RewardStructure),
}

impl Costs<'_> {
    fn of(&self, program: &Program, state: &[i64], choice: &Choice) -> CheckResult<Ratio> {
        match self {
            Costs::Steps => Ok(Ratio::one()),
            Costs::Rewards(structure) => Ok(program.reward(structure, state, choice)?),
        }
    }
}

/// The choices of a row.
struct Choices<'t> {
    /// True if the opponent chooses.
    is_theirs: bool,
    kept: Vec<Kept<'t>>,
}

impl<'t> Choices<'t> {
    /// Returns whether some choice of ours, or every choice of the opponent, satisfies a condition.
    fn can(&self, holds: impl Fn(&Kept<'t>) -> bool) -> bool {
        if self.is_theirs { self.kept.iter().all(holds) } else { self.kept.iter().any(holds) }
    }

    /// Returns whether every choice of ours, or some choice of the opponent, satisfies a condition.
    fn must(&self, holds: impl Fn(&Kept<'t>) -> bool) -> bool {
        if self.is_theirs { self.kept.iter().any(holds) } else { self.kept.iter().all(holds) }
    }
}

/// A choice of a row.
struct Kept<'t> {
    cost: Ratio,
    edges: Vec<(Ratio, Edge<'t>)>,
}

/// A kept edge, with the entries of its target; no entry where P_1 is 0.
enum Edge<'t> {
    Lost,
    /// An improvement that is counted; the entry is that of the target's own arena, if it has one.
    Counted(Option<&'t Entry<'t>>),
    /// A step without an improvement, in the same arena.
    Plain(Option<&'t Entry<'t>>),
    /// An improvement that may be counted or not: both of these.
    Either(Option<&'t Entry<'t>>, Option<&'t Entry<'t>>),
}

/// The value at the end of an edge, `None` if it is infinite, and its rank.
type End = (Option<Ratio>, u32);

#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Lower,
    Upper,
}

impl Side {
    fn of(self, bounds: &Bounds) -> &Bound {
        if self == Side::Lower { &bounds.lower } else { &bounds.upper }
    }
}

/// Checks all rows by one step.
pub(super) fn check(
    checker: &Checker<'_>,
    table: &Table<'_>,
    program: &Program,
    costs: &Costs<'_>,
) -> CheckResult {
    let sink = &checker.engine.settings().sink;
    let theirs = checker.engine.theirs();
    for entry in &table.entries {
        if let Some(limit) = sink.stop() {
            return Err(CheckError::Error(limit.into()));
        }
        let of = |theirs| checker.engine.contains(theirs, &entry.row.state);
        let is_theirs = theirs.as_ref().map(of).transpose()?.unwrap_or(false);
        let choices = Choices { is_theirs, kept: kept(checker, table, entry, (program, costs), is_theirs)? };
        for k in 1..=table.levels {
            let violated = table.probability(entry, k, &choices).or_else(|| table.cost(entry, k, &choices));
            if let Some(condition) = violated {
                return Err(CheckError::violated(condition, Some(entry.row.state.clone())));
            }
        }
    }
    Ok(())
}

/// Returns the choices of a row that its arena keeps. Other choices of the opponent lose the path.
fn kept<'t>(
    checker: &Checker<'_>,
    table: &'t Table<'t>,
    entry: &Entry<'_>,
    (program, costs): (&Program, &Costs<'_>),
    is_theirs: bool,
) -> CheckResult<Vec<Kept<'t>>> {
    let (arena, state) = (&table.arenas[entry.arena], &entry.row.state);
    let steps = program.exact_steps(state).map_err(|e| fault::error(program, &e, state))?;
    let mut choices = Vec::new();
    for step in steps {
        if !checker.engine.contains_choice(&arena.kept, state, &step.choice)? {
            if is_theirs {
                choices.push(Kept { cost: Ratio::zero(), edges: vec![(Ratio::one(), Edge::Lost)] });
            }
            continue;
        }
        let cost = costs.of(program, state, &step.choice)?;
        let mut edges = Vec::with_capacity(step.successors.len());
        for (to, p) in step.successors {
            edges.push((p, edge(checker, table, entry.arena, arena, state, &to)?));
        }
        choices.push(Kept { cost, edges });
    }
    Ok(choices)
}

fn edge<'t>(
    checker: &Checker<'_>,
    table: &'t Table<'t>,
    number: usize,
    arena: &Arena,
    from: &[i64],
    to: &[i64],
) -> CheckResult<Edge<'t>> {
    let engine = &checker.engine;
    let mut improves = false;
    for part in &arena.edge_labels {
        if engine.contains(&part.from, from)? {
            if engine.contains(&part.dropped, to)? {
                return Ok(Edge::Lost);
            }
            improves = engine.contains(&part.goal, to)?;
        }
    }
    let own = || match table.own_arena(checker, to)? {
        Some(own) => table.find(checker, own, to),
        None => Ok(None),
    };
    Ok(match (improves, table.may_skip) {
        (false, _) => Edge::Plain(table.find(checker, number, to)?),
        (true, false) => Edge::Counted(own()?),
        (true, true) => Edge::Either(own()?, table.find(checker, number, to)?),
    })
}

/// Returns whether `a` is at most `b`; `None` is infinite.
fn at_most(a: Option<&Ratio>, b: Option<&Ratio>) -> bool {
    match (a, b) {
        (_, None) => true,
        (None, Some(_)) => false,
        (Some(a), Some(b)) => a <= b,
    }
}

/// Returns the bounds of C_k; `None` where k improvements are not certain.
fn costs<'e>(entry: Option<&'e Entry<'_>>, k: usize) -> Option<&'e Bounds> {
    entry?.row.costs[k - 1].as_ref()
}

impl Table<'_> {
    /// Checks the bounds of P_k; returns a condition that is violated.
    fn probability(&self, entry: &Entry<'_>, k: usize, choices: &Choices<'_>) -> Option<Condition> {
        if k > entry.positive || k <= entry.sure && !self.shows_ones {
            return None;
        }
        let bounds = &entry.row.probabilities[k - 1];
        let (lower, upper) = (bounds.lower.exact(), bounds.upper.exact());
        let value = |choice: &Kept<'_>, side: Side| {
            choice.sum(Ratio::zero(), |edge| Some(self.chance(edge, k, side)))
        };
        let below = |choice: &Kept<'_>| {
            value(choice, Side::Upper).is_some_and(|(sum, _)| at_most(sum.as_ref(), upper.as_ref()))
        };
        if !choices.must(below) {
            return Some(Condition::UpperProbability { level: k, theirs: choices.is_theirs });
        }
        let reaches = |choice: &Kept<'_>| {
            let found = value(choice, Side::Lower);
            found.is_some_and(|(sum, rank)| at_most(lower.as_ref(), sum.as_ref()) && rank < bounds.rank)
        };
        let holds = lower.as_ref().is_some_and(Zero::is_zero) || choices.can(reaches);
        (!holds).then_some(Condition::LowerProbability { level: k, theirs: choices.is_theirs })
    }

    /// Checks the bounds of C_k; returns a condition that is violated.
    fn cost(&self, entry: &Entry<'_>, k: usize, choices: &Choices<'_>) -> Option<Condition> {
        let bounds = entry.row.costs[k - 1].as_ref()?;
        let (lower, upper) = (bounds.lower.exact(), bounds.upper.exact());
        let value = |choice: &Kept<'_>, side: Side| {
            choice.sum(choice.cost.clone(), |edge| self.expense(edge, k, side))
        };
        // A choice that is not permitted has no value, and confirms nothing.
        let above = |choice: &Kept<'_>| match value(choice, Side::Lower) {
            Some((sum, _)) => at_most(lower.as_ref(), sum.as_ref()),
            None => !choices.is_theirs,
        };
        if !choices.must(above) {
            return Some(Condition::LowerCost { level: k, theirs: choices.is_theirs });
        }
        let reaches = |choice: &Kept<'_>| {
            let found = value(choice, Side::Upper);
            found.is_some_and(|(sum, rank)| at_most(sum.as_ref(), upper.as_ref()) && rank < bounds.rank)
        };
        let holds = upper.is_none() || choices.can(reaches);
        (!holds).then_some(Condition::UpperCost { level: k, theirs: choices.is_theirs })
    }

    /// Returns a bound of P_k after an edge, and its rank.
    fn chance(&self, edge: &Edge<'_>, k: usize, side: Side) -> End {
        let of = |entry: &Option<&Entry<'_>>, k: usize| {
            let bound = |entry: &Entry<'_>| side.of(&entry.row.probabilities[k - 1]).exact();
            entry.map_or_else(|| Some(Ratio::zero()), bound)
        };
        let counted = |own: &Option<&Entry<'_>>| if k == 1 { Some(Ratio::one()) } else { of(own, k - 1) };
        let plain = |entry: &Option<&Entry<'_>>| -> End {
            let bound = of(entry, k);
            let given = |entry: &Entry<'_>| k > entry.positive || k <= entry.sure && !self.shows_ones;
            let rank = match entry {
                Some(entry) if !given(entry) && !bound.as_ref().is_some_and(Zero::is_zero) => {
                    entry.row.probabilities[k - 1].rank
                }
                _ => 0,
            };
            (bound, rank)
        };
        match edge {
            Edge::Lost => (Some(Ratio::zero()), 0),
            Edge::Counted(own) => (counted(own), 0),
            Edge::Plain(entry) => plain(entry),
            Edge::Either(own, entry) => {
                let (counted, plain) = (counted(own), plain(entry));
                if at_most(plain.0.as_ref(), counted.as_ref()) { (counted, 0) } else { plain }
            }
        }
    }

    /// Returns a bound of C_k after an edge, and its rank; `None` if k improvements are not certain
    /// then.
    fn expense(&self, edge: &Edge<'_>, k: usize, side: Side) -> Option<End> {
        let counted = |own: &Option<&Entry<'_>>| -> Option<End> {
            match k {
                1 => Some((Some(Ratio::zero()), 0)),
                _ => Some((side.of(costs(*own, k - 1)?).exact(), 0)),
            }
        };
        let plain = |entry: &Option<&Entry<'_>>| -> Option<End> {
            let bounds = costs(*entry, k)?;
            Some((side.of(bounds).exact(), bounds.rank))
        };
        match edge {
            Edge::Lost => None,
            Edge::Counted(own) => counted(own),
            Edge::Plain(entry) => plain(entry),
            Edge::Either(own, entry) => match (counted(own), plain(entry)) {
                (Some(counted), Some(plain)) => {
                    Some(if at_most(counted.0.as_ref(), plain.0.as_ref()) { counted } else { plain })
                }
                (counted, plain) => counted.or(plain),
            },
        }
    }
}

impl Kept<'_> {
    /// Returns `first` + Σ p · value, and the least rank of an edge; `None` if an edge has no value.
    fn sum<'s>(&'s self, first: Ratio, value: impl Fn(&'s Edge<'_>) -> Option<End>) -> Option<End> {
        let (mut sum, mut least) = (Some(first), u32::MAX);
        for (p, edge) in &self.edges {
            let (x, rank) = value(edge)?;
            sum = sum.zip(x).map(|(sum, x)| sum + p * x);
            least = least.min(rank);
        }
        Some((sum, least))
    }
}
