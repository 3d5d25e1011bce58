//! Games over edges: some edges win, some are not there.

use super::{Engine, Region};
use crate::error::Result;

/// What the edges from some states are worth.
#[derive(Debug, Clone)]
pub struct Moves<S> {
    /// The states; those of different moves of a game are disjoint.
    pub from: S,
    /// An edge from `from` into these wins.
    pub goal: S,
    /// An edge from `from` into these is not there; disjoint from `goal`.
    pub dropped: S,
}

/// Edges by where they come from and where they go.
type Edges<S> = Vec<(S, S)>;

/// { (s,a) ∈ C : some edge wins }
///
/// # Errors
/// A limit of the engine. Cost: one pre-image a distinct goal.
pub(crate) fn winning<E: Engine>(
    engine: &E,
    choices: &E::Choices,
    moves: &[Moves<E::States>],
) -> Result<E::Choices> {
    pairs_into(engine, choices, moves.iter().map(|m| (m.from.clone(), m.goal.clone())).collect())
}

/// { (s,a) ∈ C : some edge that is there enters X }
///
/// # Errors
/// A limit of the engine. Cost: one pre-image a distinct X \ dropped.
pub(crate) fn keeping<E: Engine>(
    engine: &E,
    choices: &E::Choices,
    moves: &[Moves<E::States>],
    x: &E::States,
) -> Result<E::Choices> {
    let edges = moves.iter().map(|m| Ok((m.from.clone(), engine.difference(x, &m.dropped)?)));
    pairs_into(engine, choices, edges.collect::<Result<_>>()?)
}

/// { (s,a) ∈ C : some edge that is there and does not win enters X }
///
/// # Errors
/// A limit of the engine. Cost: one pre-image a distinct X \ goal \ dropped.
pub(crate) fn leaning<E: Engine>(
    engine: &E,
    choices: &E::Choices,
    moves: &[Moves<E::States>],
    x: &E::States,
) -> Result<E::Choices> {
    let into = |m: &Moves<E::States>| engine.difference(&engine.difference(x, &m.goal)?, &m.dropped);
    let edges = moves.iter().map(|m| Ok((m.from.clone(), into(m)?)));
    pairs_into(engine, choices, edges.collect::<Result<_>>()?)
}

/// The edges that are not there, grouped by where they would go.
///
/// # Errors
/// A limit of the engine. Cost: no image.
pub(crate) fn dropped<E: Engine>(engine: &E, moves: &[Moves<E::States>]) -> Result<Edges<E::States>> {
    grouped(engine, moves.iter().map(|m| (m.from.clone(), m.dropped.clone())).collect())
}

/// ⋃ over (X, Y) of { (s,a) ∈ C : s ∈ X, succ(s,a) ∩ Y ≠ ∅ }.
///
/// # Errors
/// A limit of the engine. Cost: one pre-image a distinct non-empty Y with a non-empty X.
pub(crate) fn pairs_into<E: Engine>(
    engine: &E,
    choices: &E::Choices,
    pairs: Edges<E::States>,
) -> Result<E::Choices> {
    let mut union = engine.no_choices();
    for (from, into) in grouped(engine, pairs)? {
        let entering = engine.entering(&engine.choices_in(choices, &from)?, &into)?;
        union = engine.union_choices(&union, &entering)?;
    }
    Ok(union)
}

/// The pairs (from, into) without empty sides, those with the same `into` made one.
///
/// # Errors
/// A limit of the engine. Cost: no image.
pub(crate) fn grouped<E: Engine>(engine: &E, pairs: Edges<E::States>) -> Result<Edges<E::States>> {
    let mut groups: Edges<E::States> = Vec::new();
    for (from, into) in pairs {
        if engine.is_empty(&from) || engine.is_empty(&into) {
            continue;
        }
        match groups.iter_mut().find(|(_, same)| engine.same_states(same, &into)) {
            Some((union, _)) => *union = engine.union(union, &from)?,
            None => groups.push((from, into)),
        }
    }
    Ok(groups)
}

/// Takes some of its pairs out of a set, and returns the states that lost their last pair by it.
///
/// Looks at no state but those of the pairs, however large the set is.
///
/// # Errors
/// A limit of the engine. Cost: no image.
fn disallow<E: Engine>(engine: &E, choices: &mut E::Choices, gone: &E::Choices) -> Result<E::States> {
    *choices = engine.without_choices(choices, gone)?;
    let hit = engine.sources(gone)?;
    let alive = engine.sources(&engine.choices_in(choices, &hit)?)?;
    engine.difference(&hit, &alive)
}

/// Takes the pairs that enter lost states out of C, and returns the states left that have no pair
/// any more, perhaps with states that were not left before.
///
/// C is what those of `within` are that do not enter a state lost earlier. In systems of many
/// independent parts all that is lost so far can be a much smaller diagram than what is lost in one
/// round, as a ball is simpler than its shell: then C is found from `within` anew.
///
/// # Errors
/// A limit of the engine. Cost: one pre-image.
fn withdraw<E: Engine>(
    engine: &E,
    choices: &mut E::Choices,
    within: &E::Choices,
    lost: &E::States,
    left: &E::States,
) -> Result<E::States> {
    if engine.is_simpler(left, lost) {
        let outside = engine.difference(&engine.all_states(), left)?;
        if engine.is_simpler(&outside, lost) {
            *choices = engine.without_choices(within, &engine.entering(within, &outside)?)?;
            return engine.difference(left, &engine.sources(choices)?);
        }
    }
    let gone = engine.entering(choices, lost)?;
    disallow(engine, choices, &gone)
}

/// [`Engine::almost_surely_win`] by sets.
///
/// Choices are disallowed only where they may step into a lost state: no choice of a lost state leads
/// to what can still win, so it need not be cut, and what an engine remembers of the others stays of
/// use. States left without a choice are lost at once, before the next backward fixpoint.
pub(super) fn almost_surely_win<E: Engine>(
    engine: &E,
    start: Region<E::States, E::Choices>,
    moves: &[Moves<E::States>],
) -> Result<Region<E::States, E::Choices>> {
    let winning = winning(engine, &start.choices, moves)?;
    let Region { mut states, choices: within } = start;
    let mut choices = within.clone();
    loop {
        let seeds = engine.sources(&engine.common_choices(&choices, &winning)?)?;
        let reaching = engine.can_reach(&seeds, &choices, moves)?;
        let lost = engine.difference(&states, &reaching)?;
        states = engine.intersection(&states, &reaching)?;
        if engine.is_empty(&lost) {
            choices = engine.choices_in(&choices, &states)?;
            return Ok(Region { states, choices });
        }
        lose(engine, &mut states, &mut choices, (&within, &engine.no_states()), moves, lost)?;
    }
}

/// Takes lost states out of `states`, and out of `choices` all pairs that may step into them other than
/// by a safe edge; states that have none left then, and have not won, are lost too, and so on.
///
/// `choices` is what is left of `within`, and none of a state lost before leads to what can still win.
///
/// # Errors
/// A limit of the engine. Cost: what [`Engine::lose`] costs, or a pre-image for each set of moves and
/// each layer of states that are lost.
pub(super) fn lose<E: Engine>(
    engine: &E,
    states: &mut E::States,
    choices: &mut E::Choices,
    (within, won): (&E::Choices, &E::States),
    moves: &[Moves<E::States>],
    lost: E::States,
) -> Result<()> {
    if let Some((all, left)) = engine.lose(&lost, won, choices, moves)? {
        *states = engine.difference(states, &all)?;
        *choices = left;
        return Ok(());
    }
    let mut lost = lost;
    while !engine.is_empty(&lost) {
        let stuck = if moves.is_empty() {
            withdraw(engine, choices, within, &lost, states)?
        } else {
            let gone = leaning(engine, choices, moves, &lost)?;
            disallow(engine, choices, &gone)?
        };
        lost = engine.intersection(&engine.difference(&stuck, won)?, states)?;
        *states = engine.difference(states, &lost)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::{Engine, grouped};
    use crate::engine::Settings;
    use crate::engine::explicit::ExplicitEngine;
    use crate::error::SourceFile;
    use crate::lang;

    #[test]
    fn groups_have_no_empty_side_and_each_target_once() {
        let source = SourceFile::new("m", "mdp module m x : [0..3] init 0; [a] true -> (x'=0); endmodule");
        let program = lang::load(&source, &SourceFile::new("constants", "")).unwrap().program;
        let settings = Settings { scope: crate::engine::Scope::All, ..Settings::default() };
        let engine = ExplicitEngine::new(Arc::new(program), settings).unwrap();
        let [a, b, c, into] = [0, 1, 2, 3].map(|x| engine.singleton(&[x]).unwrap());
        let none = engine.no_states();
        let pairs = [(&none, &into), (&a, &none), (&b, &into), (&none, &a), (&a, &b), (&c, &into)];
        let groups = grouped(&engine, pairs.map(|(x, y)| (x.clone(), y.clone())).into()).unwrap();
        let numbers = |set| engine.list_states(set, 4).unwrap().concat();
        let groups: Vec<_> = groups.iter().map(|(x, y)| (numbers(x), numbers(y))).collect();
        assert_eq!(groups, [(vec![1, 2], vec![3]), (vec![0], vec![1])]);
    }
}
