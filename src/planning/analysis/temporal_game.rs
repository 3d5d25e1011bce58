//! Winning regions of temporal formulas in games against an opponent.
//!
//! Co-safe and safe formulas change their marks at most once on a path. So from some state on these
//! marks are fixed, and at most one other mark m is left to decide. A path then satisfies the condition
//! if and only if infinitely many of its states are in A, or all from some state on are in P:
//! - A are the states whose fixed marks satisfy the condition if m recurs, and that are marked by m or
//!   satisfy the condition also if m does not recur;
//! - P are the states whose fixed marks satisfy the condition if m does not recur, and that are not
//!   marked by m.
//!
//! This is a parity condition: A has the priority 0, P \ A the priority 2, all other states 1, and the
//! least priority that recurs is even. In such games, memoryless strategies suffice for both sides
//! (K. Chatterjee, M. Jurdziński and T. Henzinger, *Simple stochastic parity games*, 2003).
//!
//! Recurrence alone has P = ∅, a Büchi game; persistence alone has A = ∅, a co-Büchi game.

use meliora_base::error::{Error, Result};
use meliora_engine::regions::Which;
use meliora_engine::{Engine, Region};
use meliora_model::preference::{Goal, Objective};
use meliora_model::temporal::{Asks, Condition};

/// Computes a region of a condition in a game in which the opponent has states.
///
/// These games are determined: either we satisfy the condition almost surely against every strategy of
/// the opponent, or the opponent has a strategy that violates it with positive probability against
/// every strategy of ours, and the same with the sides exchanged. Hence, where AS are the states of
/// [`almost_sure`] for one side:
/// - Pmax = 1 is our AS(φ), and Pmin = 1 is the opponent's AS(φ);
/// - Pmax > 0 is S \ AS(¬φ) of the opponent, and Pmin > 0 is S \ AS(¬φ) of ours.
///
/// Cost: that of [`almost_sure`].
///
/// # Errors
/// A limit of the engine is reached, a state formula has no value, or several marks are left to decide.
pub(crate) fn region<E: Engine>(
    engine: &E,
    opponent: &E,
    which: Which,
    condition: &Condition,
) -> Result<E::States> {
    let not_sure = |side: &E| {
        let sure = almost_sure(side, &condition.negated())?;
        engine.difference(&engine.all_states(), &sure)
    };
    match which {
        Which::PmaxOne => almost_sure(engine, condition),
        Which::PminOne => almost_sure(opponent, condition),
        Which::PmaxPositive => not_sure(opponent),
        Which::PminPositive => not_sure(engine),
    }
}

/// Computes the states from which we satisfy a condition almost surely against every strategy of the
/// opponent: νY. μX. νZ. can_choose(C), where C are the pairs (s,a) with
/// 1. s ∈ A and succ(s,a) ⊆ Y, or
/// 2. succ(s,a) ⊆ Y and succ(s,a) ∩ X ≠ ∅, or
/// 3. s ∈ P and succ(s,a) ⊆ Z.
///
/// Every state of the result has this property. Let the rank of a state be the first X that it is in.
/// With pairs of C, paths stay in the result. Suppose that a path takes pairs of the first sort
/// finitely often. Let r be the least rank that recurs. If the second sort recurs in states of rank r,
/// a rank below r recurs almost surely, as each of these steps enters one with a probability that is
/// bounded from below. So from some step on, only the third sort is taken in rank r; such a step stays
/// in rank r or less. The path then stays in P.
///
/// Every state with this property is in the result. Let W be the states with the property, and X the
/// result of μX for Y = W. In a state outside X, the opponent can enforce a pair outside C, of one of
/// these sorts: it may leave W; or it stays outside X, and s ∉ A, and either s ∉ P or the step may lead
/// to a state outside Z that was removed earlier. So against every strategy of ours, a path from W \ X
/// leaves W with positive probability, or it stays outside A and almost surely leaves P again and
/// again. Then it does not satisfy the condition, so W \ X is empty.
///
/// The formula replaces both predecessors in that of games without chance (T. Banerjee, R. Majumdar, K.
/// Mallik, A.-K. Schmuck and S. Soudjani, *Fast symbolic algorithms for omega-regular games under strong
/// transition fairness*, 2022). Cost: per round of Y and X one `can_reach`, and one pre-image per layer
/// that Z removes; per round of Y one [`Engine::stay_within`].
///
/// # Errors
/// The errors of [`region`].
fn almost_sure<E: Engine>(engine: &E, condition: &Condition) -> Result<E::States> {
    let parity = Parity::new(engine, condition)?;
    let mut left = Region { states: engine.all_states(), choices: engine.all_choices() };
    loop {
        let won = parity.won_within(engine, &left)?;
        if engine.same(&won, &left.states)? {
            return Ok(won);
        }
        left = engine.stay_within(&won, &left.choices)?;
    }
}

/// Refuses to achieve some objectives against an opponent if it may choose how one of them is satisfied;
/// see [`Condition::reaching_suffices`].
///
/// # Errors
/// [`Error::Usage`] with the name of the objective; a condition has too many disjuncts.
pub(crate) fn check_achieved<'o, E: Engine>(
    engine: &E,
    objectives: impl IntoIterator<Item = &'o Objective>,
) -> Result<()> {
    if engine.theirs().is_none() {
        return Ok(());
    }
    for objective in objectives {
        if let Goal::Satisfy { condition, .. } = &objective.goal
            && !condition.reaching_suffices()?
        {
            let name = &objective.name;
            let message = format!(
                "a strategy of a game that achieves `{name}` is not supported: the opponent may choose how \
                 the formula is satisfied; strategies achieve formulas with one case and without persistence, \
                 such as `F a`, `G a` and `G F a`; those of SASI and SPI pursue no objective"
            );
            return Err(Error::Usage(message));
        }
    }
    Ok(())
}

/// The states of a condition that recur or are kept; see the documentation of the module.
struct Parity<E: Engine> {
    /// A, the states of priority 0.
    again: E::States,
    /// P, of priority 2 outside A.
    settled: E::States,
}

impl<E: Engine> Parity<E> {
    /// Computes A and P. Cost: no image.
    ///
    /// Conditions of texts have one mark left at most, since recurrence and persistence are joined there;
    /// those that a program builds itself may have several.
    ///
    /// # Errors
    /// Several marks are left to decide, or the errors of [`Engine::states_where`].
    fn new(engine: &E, condition: &Condition) -> Result<Self> {
        let marked = match condition.undecided().as_slice() {
            [] => engine.no_states(),
            [mark] => engine.states_where(mark)?,
            _ => {
                let message = "a formula of a game that needs several recurring marks is not supported";
                return Err(Error::Usage(message.to_owned()));
            }
        };
        let [if_not, if_recurs] = [false, true].map(|recurs| satisfying(engine, condition, recurs));
        let (if_not, if_recurs) = (if_not?, if_recurs?);
        let again = engine.intersection(&if_recurs, &engine.union(&if_not, &marked)?)?;
        Ok(Parity { again, settled: engine.difference(&if_not, &marked)? })
    }

    /// Computes μX. νZ. can_choose(C) for the states Y of a region whose pairs stay in Y, as
    /// [`almost_sure`] describes it. X begins with the states that reach A, and grows by all states that
    /// reach it: these have pairs of the first and of the second sort.
    fn won_within(&self, engine: &E, left: &Region<E::States, E::Choices>) -> Result<E::States> {
        let again = engine.intersection(&self.again, &left.states)?;
        let settled = engine.intersection(&self.settled, &left.states)?;
        let mut won = engine.can_reach(&again, &left.choices, &[])?;
        loop {
            let kept = kept(engine, left, &won, &settled)?;
            if engine.same(&kept, &won)? {
                return Ok(won);
            }
            won = engine.can_reach(&kept, &left.choices, &[])?;
        }
    }
}

/// Computes νZ. X ∪ can_choose({ (s,a) : succ(s,a) ∩ X ≠ ∅, or s ∈ P and succ(s,a) ⊆ Z }) among the
/// pairs of a region, for a set X that no other state of the region reaches by such pairs. Cost: one
/// pre-image for X, and one per layer of removed states.
fn kept<E: Engine>(
    engine: &E,
    left: &Region<E::States, E::Choices>,
    won: &E::States,
    settled: &E::States,
) -> Result<E::States> {
    let mut open = engine.difference(settled, won)?;
    if engine.is_empty(&open)? {
        return Ok(won.clone());
    }
    let entering = engine.pre(&left.choices, won)?;
    let mut staying = engine.difference(&engine.choices_in(&left.choices, &open)?, &entering)?;
    let mut lost = engine.difference(&engine.difference(&left.states, won)?, &open)?;
    while !engine.is_empty(&lost)? && !engine.is_empty(&open)? {
        staying = engine.difference(&staying, &engine.pre(&staying, &lost)?)?;
        let safe = engine.can_choose(&engine.union(&staying, &entering)?)?;
        lost = engine.difference(&open, &safe)?;
        open = engine.difference(&open, &lost)?;
    }
    engine.union(won, &open)
}

/// Computes the states whose marks of co-safe and safe formulas satisfy a condition if the other mark
/// `recurs`, or if it does not. Cost: no image.
fn satisfying<E: Engine>(engine: &E, condition: &Condition, recurs: bool) -> Result<E::States> {
    let constant = |value: bool| if value { engine.all_states() } else { engine.no_states() };
    let each = |part: &Condition| satisfying(engine, part, recurs);
    match condition {
        Condition::Constant(value) => Ok(constant(*value)),
        Condition::Leaf(Asks::Accept, mark) => engine.states_where(mark),
        Condition::Leaf(Asks::Avoid, mark) => {
            engine.difference(&engine.all_states(), &engine.states_where(mark)?)
        }
        Condition::Leaf(Asks::Again, _) => Ok(constant(recurs)),
        Condition::Leaf(Asks::Settle, _) => Ok(constant(!recurs)),
        Condition::All(parts) => {
            parts.iter().try_fold(engine.all_states(), |all, part| engine.intersection(&all, &each(part)?))
        }
        Condition::Any(parts) => {
            parts.iter().try_fold(engine.no_states(), |any, part| engine.union(&any, &each(part)?))
        }
    }
}
