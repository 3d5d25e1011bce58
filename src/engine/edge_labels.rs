//! Games over edges: some edges win, some are not there.

use super::{Engine, Region};
use crate::error::Result;

/// What the edges from some states are worth.
#[derive(Debug, Clone)]
pub struct EdgeLabels<S> {
    /// The states; those of different parts of a game are disjoint.
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
    edge_labels: &[EdgeLabels<E::States>],
) -> Result<E::Choices> {
    edges_into(engine, choices, edge_labels, |m| Ok(m.goal.clone()))
}

/// { (s,a) ∈ C : some edge that is there enters X }
///
/// # Errors
/// A limit of the engine. Cost: one pre-image a distinct X \ dropped.
pub(crate) fn keeping<E: Engine>(
    engine: &E,
    choices: &E::Choices,
    edge_labels: &[EdgeLabels<E::States>],
    x: &E::States,
) -> Result<E::Choices> {
    edges_into(engine, choices, edge_labels, |m| engine.difference(x, &m.dropped))
}

/// { (s,a) ∈ C : some edge that is there and does not win enters X }
///
/// # Errors
/// A limit of the engine. Cost: one pre-image a distinct X \ goal \ dropped.
pub(crate) fn leaning<E: Engine>(
    engine: &E,
    choices: &E::Choices,
    edge_labels: &[EdgeLabels<E::States>],
    x: &E::States,
) -> Result<E::Choices> {
    edges_into(engine, choices, edge_labels, |m| {
        engine.difference(&engine.difference(x, &m.goal)?, &m.dropped)
    })
}

/// { (s,a) ∈ C : some edge enters what `into` says of the edge labels of the part of s }
fn edges_into<E: Engine>(
    engine: &E,
    choices: &E::Choices,
    edge_labels: &[EdgeLabels<E::States>],
    into: impl Fn(&EdgeLabels<E::States>) -> Result<E::States>,
) -> Result<E::Choices> {
    let edges = edge_labels.iter().map(|m| Ok((m.from.clone(), into(m)?)));
    pairs_into(engine, choices, edges.collect::<Result<_>>()?)
}

/// The edges that are not there, grouped by where they would go.
///
/// # Errors
/// A limit of the engine. Cost: no image.
pub(crate) fn dropped<E: Engine>(
    engine: &E,
    edge_labels: &[EdgeLabels<E::States>],
) -> Result<Edges<E::States>> {
    grouped(engine, edge_labels.iter().map(|m| (m.from.clone(), m.dropped.clone())).collect())
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
        union = engine.union(&union, &entering)?;
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
        match groups.iter_mut().find(|(_, same)| engine.same(same, &into)) {
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
    *choices = engine.difference(choices, gone)?;
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
    left: &mut Region<E::States, E::Choices>,
    within: &E::Choices,
    lost: &E::States,
    is_simpler: impl Fn(&E::States, &E::States) -> bool,
) -> Result<E::States> {
    if is_simpler(&left.states, lost) {
        let outside = engine.difference(&engine.all_states(), &left.states)?;
        if is_simpler(&outside, lost) {
            left.choices = engine.difference(within, &engine.entering(within, &outside)?)?;
            return engine.difference(&left.states, &engine.sources(&left.choices)?);
        }
    }
    let gone = engine.entering(&left.choices, lost)?;
    disallow(engine, &mut left.choices, &gone)
}

/// [`Engine::almost_surely_win`] by sets.
///
/// Choices are disallowed only where they may step into a lost state: no choice of a lost state leads
/// to what can still win, so it need not be cut, and what an engine remembers of the others stays of
/// use. States left without a choice are lost at once, before the next backward fixpoint.
pub(super) fn almost_surely_win<E: Engine>(
    engine: &E,
    start: Region<E::States, E::Choices>,
    edge_labels: &[EdgeLabels<E::States>],
) -> Result<Region<E::States, E::Choices>> {
    let winning = winning(engine, &start.choices, edge_labels)?;
    let within = start.choices.clone();
    let mut left = start;
    loop {
        let seeds = engine.sources(&engine.intersection(&left.choices, &winning)?)?;
        let reaching = engine.can_reach(&seeds, &left.choices, edge_labels)?;
        let lost = engine.difference(&left.states, &reaching)?;
        left.states = engine.intersection(&left.states, &reaching)?;
        if engine.is_empty(&lost) {
            left.choices = engine.choices_in(&left.choices, &left.states)?;
            return Ok(left);
        }
        left = engine.remove_attractor(left, (&within, &engine.no_states()), edge_labels, lost)?;
    }
}

/// [`Engine::remove_attractor`] layer by layer. `is_simpler` says whether work on a set costs less than on another, however
/// many states they have: never, where an engine cannot tell.
pub(super) fn remove_attractor<E: Engine>(
    engine: &E,
    mut left: Region<E::States, E::Choices>,
    (within, won): (&E::Choices, &E::States),
    edge_labels: &[EdgeLabels<E::States>],
    mut lost: E::States,
    is_simpler: impl Fn(&E::States, &E::States) -> bool,
) -> Result<Region<E::States, E::Choices>> {
    while !engine.is_empty(&lost) {
        let stuck = if edge_labels.is_empty() {
            withdraw(engine, &mut left, within, &lost, &is_simpler)?
        } else {
            let gone = leaning(engine, &left.choices, edge_labels, &lost)?;
            disallow(engine, &mut left.choices, &gone)?
        };
        lost = engine.intersection(&engine.difference(&stuck, won)?, &left.states)?;
        left.states = engine.difference(&left.states, &lost)?;
    }
    Ok(left)
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
