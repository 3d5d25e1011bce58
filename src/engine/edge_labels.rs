//! Games on edges: goal edges win, dropped edges are not part of the game, all others are plain.

use super::engine::{Engine, Region, Won, position};
use meliora_base::error::Result;

/// The labels of the edges from a set of states: goal, dropped or plain. A game has one such *part*
/// per group of states.
#[derive(Debug, Clone)]
pub struct EdgeLabels<S> {
    /// The source states; those of different parts of a game are disjoint.
    pub from: S,
    /// The targets of goal edges: an edge from `from` into this set wins.
    pub goal: S,
    /// The targets of dropped edges: an edge from `from` into this set is ignored. Disjoint from
    /// `goal`.
    pub dropped: S,
    /// Pairs (X, Y) with disjoint X ⊆ `from`, and Y outside of `from`: no choice of the game has an edge from
    /// X into Y. They say why choices are missing, so that a search may look at states alone.
    pub barred: Edges<S>,
}

impl<S> EdgeLabels<S> {
    /// Creates labels without barred edges.
    pub fn new(from: S, goal: S, dropped: S) -> Self {
        EdgeLabels { from, goal, dropped, barred: Vec::new() }
    }

    /// Returns all sets.
    pub(super) fn sets(&self) -> impl Iterator<Item = &S> {
        let barred = self.barred.iter().flat_map(|(from, into)| [from, into]);
        [&self.from, &self.goal, &self.dropped].into_iter().chain(barred)
    }
}

/// Sets of edges, each as a pair of source states and target states.
pub type Edges<S> = Vec<(S, S)>;

/// Returns { (s,a) ∈ C : some edge is a goal edge }. Cost: one pre-image per distinct goal set.
pub fn winning<E: Engine>(
    engine: &E,
    choices: &E::Choices,
    edge_labels: &[EdgeLabels<E::States>],
) -> Result<E::Choices> {
    edges_into(engine, choices, edge_labels, |labels| Ok(labels.goal.clone()))
}

/// Returns { (s,a) ∈ C : some edge that is not dropped enters X }. Cost: one pre-image per distinct
/// X \ dropped.
pub fn keeping<E: Engine>(
    engine: &E,
    choices: &E::Choices,
    edge_labels: &[EdgeLabels<E::States>],
    x: &E::States,
) -> Result<E::Choices> {
    edges_into(engine, choices, edge_labels, |labels| engine.difference(x, &labels.dropped))
}

/// Returns { (s,a) ∈ C : some plain edge enters X }; without edge labels, all edges are plain. Cost: one
/// pre-image per distinct X \ (goal ∪ dropped).
pub fn plain_edges_into<E: Engine>(
    engine: &E,
    choices: &E::Choices,
    edge_labels: &[EdgeLabels<E::States>],
    x: &E::States,
) -> Result<E::Choices> {
    if edge_labels.is_empty() {
        return engine.pre(choices, x);
    }
    edges_into(engine, choices, edge_labels, |labels| {
        engine.difference(&engine.difference(x, &labels.goal)?, &labels.dropped)
    })
}

/// Returns { (s,a) ∈ C : some edge enters `into(m)`, where m are the edge labels of s }.
fn edges_into<E: Engine>(
    engine: &E,
    choices: &E::Choices,
    edge_labels: &[EdgeLabels<E::States>],
    into: impl Fn(&EdgeLabels<E::States>) -> Result<E::States>,
) -> Result<E::Choices> {
    let edges = edge_labels.iter().map(|labels| Ok((labels.from.clone(), into(labels)?)));
    pairs_into(engine, choices, edges.collect::<Result<_>>()?)
}

/// Returns the dropped edges, grouped by their target set. Cost: no image.
pub fn dropped<E: Engine>(engine: &E, edge_labels: &[EdgeLabels<E::States>]) -> Result<Edges<E::States>> {
    grouped(engine, edge_labels.iter().map(|labels| (labels.from.clone(), labels.dropped.clone())).collect())
}

/// Computes [`Engine::can_win`] where every state is ours: some choice then suffices, so the states with
/// a winning pair are a target. Cost: that of [`Engine::can_reach`].
pub(super) fn reach_winning<E: Engine>(
    engine: &E,
    winning: &E::Choices,
    within: &E::Choices,
    edge_labels: &[EdgeLabels<E::States>],
) -> Result<E::States> {
    let seeds = engine.can_choose(&engine.intersection(within, winning)?)?;
    engine.can_reach(&seeds, within, edge_labels)
}

/// Returns { (s,a) ∈ C : some edge enters X that is not among the dropped ones }, with dropped edges as
/// [`dropped`] returns them. Cost: one pre-image, and one per group of dropped edges.
pub fn kept_into<E: Engine>(
    engine: &E,
    choices: &E::Choices,
    dropped: &[(E::States, E::States)],
    x: &E::States,
) -> Result<E::Choices> {
    let mut found = engine.pre(choices, x)?;
    for (from, into) in dropped {
        let own = engine.choices_in(choices, from)?;
        let kept = engine.pre(&own, &engine.difference(x, into)?)?;
        found = engine.union(&engine.difference(&found, &own)?, &kept)?;
    }
    Ok(found)
}

/// Returns ⋃ over (X, Y) of { (s,a) ∈ C : s ∈ X, succ(s,a) ∩ Y ≠ ∅ }. Cost: one pre-image per
/// distinct non-empty Y with a non-empty X.
pub fn pairs_into<E: Engine>(
    engine: &E,
    choices: &E::Choices,
    pairs: Edges<E::States>,
) -> Result<E::Choices> {
    let mut union = engine.no_choices();
    for (from, into) in grouped(engine, pairs)? {
        let entering = engine.pre(&engine.choices_in(choices, &from)?, &into)?;
        union = engine.union(&union, &entering)?;
    }
    Ok(union)
}

/// Returns the pairs (from, into) without empty sides, where pairs with the same `into` are merged.
/// Cost: no image.
pub fn grouped<E: Engine>(engine: &E, pairs: Edges<E::States>) -> Result<Edges<E::States>> {
    let mut groups: Edges<E::States> = Vec::new();
    for (from, into) in pairs {
        if engine.is_empty(&from)? || engine.is_empty(&into)? {
            continue;
        }
        match position(&groups, |(_, same)| engine.same(same, &into))? {
            Some(group) => groups[group].0 = engine.union(&groups[group].0, &from)?,
            None => groups.push((from, into)),
        }
    }
    Ok(groups)
}

/// Removes `gone` from `choices` and returns the states that lost their last pair.
///
/// Examines only the states of the removed pairs, however large `choices` is. Cost: no image.
fn disallow<E: Engine>(engine: &E, choices: &mut E::Choices, gone: &E::Choices) -> Result<E::States> {
    *choices = engine.difference(choices, gone)?;
    engine.cannot_choose(&engine.sources(gone)?, choices)
}

/// Removes the pairs that enter a lost state from C = `left.choices`. Returns the states that have
/// no pair left; these may include states that are not in `left.states`.
///
/// C contains the pairs of `within` that do not enter a state lost earlier. In systems of many
/// independent parts, the set of all lost states can be a much smaller diagram than the states lost
/// in one round. In that case C is computed from `within` again. Cost: one pre-image.
fn withdraw<E: Engine>(
    engine: &E,
    left: &mut Region<E::States, E::Choices>,
    within: &E::Choices,
    lost: &E::States,
    is_simpler: impl Fn(&E::States, &E::States) -> Result<bool>,
) -> Result<E::States> {
    if is_simpler(&left.states, lost)? {
        let outside = engine.difference(&engine.all_states(), &left.states)?;
        if is_simpler(&outside, lost)? {
            left.choices = engine.difference(within, &engine.pre(within, &outside)?)?;
            return engine.difference(&left.states, &engine.can_choose(&left.choices)?);
        }
    }
    let gone = engine.pre(&left.choices, lost)?;
    disallow(engine, &mut left.choices, &gone)
}

/// Implements [`Engine::almost_surely_win`] by operations on sets.
///
/// Removes only the choices that may step into a lost state. The choices of a lost state lead to no
/// state that can still win, so they can stay, and cached results for the other choices remain
/// valid. States without a remaining choice are lost immediately, before the next backward
/// fixpoint.
pub(super) fn almost_surely_win<E: Engine>(
    engine: &E,
    start: Region<E::States, E::Choices>,
    edge_labels: &[EdgeLabels<E::States>],
) -> Result<Won<E::States, E::Choices>> {
    if let Some(target) = target(engine, edge_labels)? {
        return Ok(Won { region: almost_surely_enter(engine, start, target)?, possible: None });
    }
    let winning = winning(engine, &start.choices, edge_labels)?;
    let within = start.choices.clone();
    let (mut left, mut possible) = (start, None);
    loop {
        let reaching = engine.can_win(&winning, &left.choices, edge_labels)?;
        possible.get_or_insert_with(|| reaching.clone());
        let lost = engine.difference(&left.states, &reaching)?;
        left.states = engine.intersection(&left.states, &reaching)?;
        if engine.is_empty(&lost)? {
            left.choices = engine.choices_in(&left.choices, &left.states)?;
            return Ok(Won { region: left, possible });
        }
        left = engine.remove_attractor(left, &within, &engine.no_states(), edge_labels, lost)?;
    }
}

/// Returns the only target of all edges, if they are goal edges into it or plain: then a game on edges is one on states.
fn target<'l, E: Engine>(
    engine: &E,
    edge_labels: &'l [EdgeLabels<E::States>],
) -> Result<Option<&'l E::States>> {
    Ok(match edge_labels {
        [all]
            if !engine.is_empty(&all.from)? && all.barred.is_empty() && engine.is_empty(&all.dropped)? =>
        {
            Some(&all.goal)
        }
        _ => None,
    })
}

/// Implements [`Engine::almost_surely_win`] if all edges into T are goal edges and no edge is dropped: T is reached
/// almost surely. A state of T itself wins if it has a choice that stays and has an edge.
fn almost_surely_enter<E: Engine>(
    engine: &E,
    start: Region<E::States, E::Choices>,
    target: &E::States,
) -> Result<Region<E::States, E::Choices>> {
    let within = start.choices.clone();
    let mut left = Region { states: engine.union(&start.states, target)?, ..start };
    loop {
        let reaching = engine.can_reach(target, &left.choices, &[])?;
        let lost = engine.difference(&left.states, &reaching)?;
        left.states = engine.intersection(&left.states, &reaching)?;
        if engine.is_empty(&lost)? {
            let ahead = engine.difference(&left.states, target)?;
            let again = engine.can_enter(&engine.choices_in(&left.choices, target)?, &left.states)?;
            let states = engine.union(&ahead, &again)?;
            return Ok(Region { choices: engine.choices_in(&left.choices, &states)?, states });
        }
        left = engine.remove_attractor(left, &within, target, &[], lost)?;
    }
}

/// Computes μX. { s : we can choose a pair of C with a goal edge, or with an edge into X that is not dropped }.
///
/// Cost: that of [`Engine::can_reach`], and one pre-image per distinct goal set; of the goal alone if there is one.
///
/// # Errors
/// A limit of the engine is reached.
pub fn possibly_win<E: Engine>(
    engine: &E,
    within: &E::Choices,
    edge_labels: &[EdgeLabels<E::States>],
) -> Result<E::States> {
    let Some(target) = target(engine, edge_labels)? else {
        return engine.can_win(&winning(engine, within, edge_labels)?, within, edge_labels);
    };
    let reaching = engine.can_reach(target, within, &[])?;
    let again = engine.can_enter(&engine.choices_in(within, target)?, &reaching)?;
    engine.union(&engine.difference(&reaching, target)?, &again)
}

/// The remaining game, and the states that are lost.
type LeftAndLost<E> = (Region<<E as Engine>::States, <E as Engine>::Choices>, <E as Engine>::States);

/// Returns the start of a search for the states that can stay in X by choices of C: the states of X
/// with such a choice, and all others, which are lost.
pub(super) fn confined_to<E: Engine>(
    engine: &E,
    x: &E::States,
    within: &E::Choices,
) -> Result<LeftAndLost<E>> {
    let states = engine.intersection(x, &engine.can_choose(within)?)?;
    let lost = engine.difference(&engine.all_states(), &states)?;
    Ok((Region { states, choices: within.clone() }, lost))
}

/// Implements [`Engine::remove_attractor`] layer by layer.
pub(super) fn remove_attractor<E: Engine>(
    engine: &E,
    mut left: Region<E::States, E::Choices>,
    within: &E::Choices,
    won: &E::States,
    edge_labels: &[EdgeLabels<E::States>],
    mut lost: E::States,
) -> Result<Region<E::States, E::Choices>> {
    while !engine.is_empty(&lost)? {
        lost = remove_layer(engine, &mut left, within, won, edge_labels, &lost, |_, _| Ok(false))?;
    }
    Ok(left)
}

/// Removes the choices that may step into `lost`, and the states that are lost next, which it
/// returns. `is_simpler(x, y)` returns whether operations on x cost less than operations on y,
/// independent of their numbers of states. An engine that cannot tell returns `false`.
pub(super) fn remove_layer<E: Engine>(
    engine: &E,
    left: &mut Region<E::States, E::Choices>,
    within: &E::Choices,
    won: &E::States,
    edge_labels: &[EdgeLabels<E::States>],
    lost: &E::States,
    is_simpler: impl Fn(&E::States, &E::States) -> Result<bool>,
) -> Result<E::States> {
    let stuck = if edge_labels.is_empty() {
        withdraw(engine, left, within, lost, &is_simpler)?
    } else {
        let gone = plain_edges_into(engine, &left.choices, edge_labels, lost)?;
        disallow(engine, &mut left.choices, &gone)?
    };
    let next = engine.intersection(&engine.difference(&stuck, won)?, &left.states)?;
    left.states = engine.difference(&left.states, &next)?;
    Ok(next)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::grouped;
    use crate::engine::Engine;
    use crate::explicit::ExplicitEngine;
    use crate::settings::Settings;
    use meliora_base::error::SourceFile;
    use meliora_lang as lang;

    #[test]
    fn groups_have_no_empty_side_and_each_target_once() {
        let source = SourceFile::new("m", "mdp module m x : [0..3] init 0; [a] true -> (x'=0); endmodule");
        let program = lang::load(&source, &SourceFile::new("constants", "")).unwrap().program;
        let settings = Settings { scope: crate::Scope::All, ..Settings::default() };
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
