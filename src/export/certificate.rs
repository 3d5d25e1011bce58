//! The sets of the certificate, which let a checker confirm regions one step at a time.
//!
//! Layers confirm the states inside: each has a way to an earlier layer. Removal rounds refute the
//! states outside: each must risk to reach states removed earlier, or never reaches the goal.

use std::collections::VecDeque;

use super::layers::{Proof, Trends, layers, of_all_players, rounds};
use super::regions::{class_name, numbered};
use super::removal::Removal;
use super::{Named, whole_paths};
use meliora_base::error::{Error, Limit, Result};
use meliora_engine::edge_labels::{pairs_into, winning};
use meliora_engine::symbolic::{StateSet, SymbolicEngine};
use meliora_engine::{Algebra, EdgeLabels, Engine};
use meliora_model::region::{LevelNumber, RegionName};
use meliora_planning::improvement::Arena;
use meliora_planning::levels::{End, entering};
use meliora_planning::winning_regions::ObjectiveRegions;
use meliora_planning::{Analysis, Kind, strategy};

type Of<'a> = Analysis<SymbolicEngine>;

/// The sets of a certificate, and the trends that they use.
pub(super) struct Certificate {
    pub(super) named: Vec<Named>,
    pub(super) trends: Trends,
    /// The names of the regions that it does not prove.
    pub(super) uncertified: Vec<String>,
    /// The first limit that ended a part.
    pub(super) limit: Option<Limit>,
}

impl Certificate {
    /// Computes the certificate of some regions, part by part; see [`super::certify`].
    pub(super) fn new(
        analysis: &Of<'_>,
        regions: &[String],
        share: &mut dyn FnMut(Option<usize>),
    ) -> Result<Self> {
        let engine = analysis.whole_engine();
        let trends = Trends::new(engine)?;
        let mut own = Certificate { named: Vec::new(), trends, uncertified: Vec::new(), limit: None };
        let (mut open, mut failed) = (VecDeque::from(Part::all(analysis)), Vec::new());
        while let Some(part) = open.pop_front() {
            share(Some(1 + open.len()));
            let mut named = Vec::new();
            let end = part.prove(analysis, &own.trends, &mut named);
            share(None);
            match end {
                // The limit of the part, not of the work.
                Err(Error::Limit(limit)) if engine.settings().sink.stop().is_none() => {
                    failed.push(part);
                    // Their proofs would show nothing.
                    open.retain(|other| !other.depends_on(part));
                    own.limit.get_or_insert(limit);
                }
                end => end.map(|()| own.named.append(&mut named))?,
            }
        }
        let is_needed = |name: &&String| {
            let name = RegionName::from(name.as_str());
            failed.iter().any(|part| part.is_needed_for(analysis, &name))
        };
        own.uncertified = regions.iter().filter(is_needed).cloned().collect();
        Ok(own)
    }
}

/// A part of a certificate.
#[derive(Clone, Copy)]
enum Part {
    /// `reachable`.
    Reachable,
    /// `unsafe`, on which the regions of all objectives depend.
    Unsafe,
    /// The regions of an objective, on which classes and levels depend.
    Objective(usize),
    /// The regions on which the levels of both kinds depend.
    Arenas,
    /// The levels of a kind.
    Levels(Kind),
}

impl Part {
    /// Returns all parts, each after those that it depends on.
    fn all(analysis: &Of<'_>) -> Vec<Self> {
        let objectives = (0..analysis.preferences().objectives.len()).map(Part::Objective);
        let levels = Kind::ALL.iter().copied().map(Part::Levels);
        [Part::Reachable, Part::Unsafe]
            .into_iter()
            .chain(objectives)
            .chain([Part::Arenas])
            .chain(levels)
            .collect()
    }

    /// Returns whether this part shows nothing without another one.
    fn depends_on(self, other: Self) -> bool {
        match other {
            Part::Reachable | Part::Levels(_) => false,
            Part::Unsafe => matches!(self, Part::Objective(_) | Part::Arenas | Part::Levels(_)),
            Part::Objective(_) => matches!(self, Part::Arenas | Part::Levels(_)),
            Part::Arenas => matches!(self, Part::Levels(_)),
        }
    }

    /// Adds the sets of the part.
    fn prove(self, analysis: &Of<'_>, trends: &Trends, named: &mut Vec<Named>) -> Result<()> {
        let (whole, engine) = (analysis.whole_engine(), analysis.engine());
        match self {
            Part::Reachable => {
                if let Some(start) = whole.beginnings()? {
                    layers(named, &RegionName::Reachable, trends.forward(whole, start)?);
                }
            }
            Part::Unsafe => {
                if let Some(requirements) = analysis.requirements() {
                    let violating = whole.difference(&whole.all_states(), &requirements.kept)?;
                    rounds(named, &RegionName::Unsafe, risk_rounds(whole, trends, violating)?.1);
                }
            }
            Part::Objective(index) => {
                whole_paths::witnesses(engine, trends, analysis, index, named)?;
                if let Some(outcome) = analysis.outcomes().and_then(|o| o.get(index)) {
                    let name = &analysis.preferences().objectives[index].name;
                    outcome_layers(engine, trends, name, outcome, named)?;
                }
            }
            Part::Arenas => {
                bad_layers(engine, trends, analysis, named)?;
                if analysis.improvement().is_some_and(|i| i.safety.has_reference()) {
                    safe_regions(engine, trends, analysis, named)?;
                }
            }
            Part::Levels(kind) => levels(engine, trends, analysis, kind, named)?,
        }
        Ok(())
    }

    /// Returns whether the proof of a region needs this part.
    fn is_needed_for(self, analysis: &Of<'_>, name: &RegionName) -> bool {
        match self {
            Part::Reachable => *name == RegionName::Reachable,
            Part::Unsafe => !name.is_of_model() || *name == RegionName::Unsafe,
            Part::Objective(own) => {
                let mut all = analysis.preferences().objectives.iter().enumerate();
                let is_other = all.any(|(index, o)| index != own && name.is_of_objective(&o.name));
                !is_other && !name.is_of_model()
            }
            Part::Arenas => *name == RegionName::Bad || name.level_kind().is_some(),
            Part::Levels(kind) => name.level_kind() == Some(kind),
        }
    }
}

fn outcome_layers(
    engine: &SymbolicEngine,
    trends: &Trends,
    name: &str,
    outcome: &ObjectiveRegions<SymbolicEngine>,
    named: &mut Vec<Named>,
) -> Result<()> {
    let positive = trends.backward(engine, &outcome.target, &engine.all_choices())?;
    layers(named, &RegionName::Positive(name.to_owned()), positive);
    let staying = engine.pre_within(&engine.all_choices(), &outcome.almost_sure)?;
    let staying = engine.choices_in(&staying, &outcome.almost_sure)?;
    let almost_sure = trends.backward(engine, &outcome.target, &staying)?;
    let region = RegionName::AlmostSure(name.to_owned());
    layers(named, &region, almost_sure);
    rounds(named, &region, lost_rounds(engine, trends, outcome)?);
    Ok(())
}

/// Computes the states that do not reach a target almost surely, in rounds of attractor removal:
/// the states that cannot reach the target by the choices that avoid all removed states, and those
/// that must risk to enter them.
fn lost_rounds(
    engine: &SymbolicEngine,
    trends: &Trends,
    outcome: &ObjectiveRegions<SymbolicEngine>,
) -> Result<Proof> {
    let mut removal = Removal::new(engine, trends).with_won(&outcome.target);
    let mut reaching = outcome.positive.clone();
    loop {
        let lost = engine.difference(&removal.left, &reaching)?;
        if !removal.remove(lost)? {
            return Ok(removal.rounds);
        }
        reaching = engine.can_reach(&outcome.target, &removal.choices, &[])?;
    }
}

/// Adds, for a game under `action`, the layers in which the opponent can weaken: by one of its choices
/// at once, or by one that may step into an earlier layer.
fn bad_layers(
    engine: &SymbolicEngine,
    trends: &Trends,
    analysis: &Of<'_>,
    named: &mut Vec<Named>,
) -> Result<()> {
    let (Some(bad), Some(classes)) = (analysis.bad(), analysis.classes()) else { return Ok(()) };
    let own = engine.choices_in(&engine.all_choices(), bad)?;
    let worse = classes.list.iter().map(|class| (class.states.clone(), class.worse.clone()));
    let weakening = engine.sources(&pairs_into(engine, &own, worse.collect())?)?;
    let towards = trends.of_all_players()?.backward(&of_all_players(engine)?, &weakening, &own)?;
    layers(named, &RegionName::Bad, towards);
    Ok(())
}

/// Adds, under `prefix`, the states from which a strategy can avoid weakening each class forever,
/// and the rounds that remove all others.
fn safe_regions(
    engine: &SymbolicEngine,
    trends: &Trends,
    analysis: &Of<'_>,
    named: &mut Vec<Named>,
) -> Result<()> {
    for class in analysis.classes().iter().flat_map(|c| &c.list) {
        let name = RegionName::Safe(class_name(analysis.preferences(), &class.most_preferred));
        let (safe, lost) = risk_rounds(engine, trends, class.worse.clone())?;
        named.push(Named::states(name.clone(), &safe));
        rounds(named, &name, lost);
    }
    Ok(())
}

/// Computes the states from which a strategy avoids the bad states forever, and the other states in
/// rounds: the bad states first, then those in which every choice may lead to a removed state.
fn risk_rounds(engine: &SymbolicEngine, trends: &Trends, bad: StateSet) -> Result<(StateSet, Proof)> {
    let mut removal = Removal::new(engine, trends);
    removal.remove(bad)?;
    Ok((removal.left, removal.rounds))
}

fn levels(
    engine: &SymbolicEngine,
    trends: &Trends,
    analysis: &Of<'_>,
    kind: Kind,
    named: &mut Vec<Named>,
) -> Result<()> {
    let Some(improvement) = analysis.improvement() else { return Ok(()) };
    let all = numbered(analysis, kind);
    for (index, arena) in improvement.arenas.iter().enumerate() {
        let mut before = arena.states.clone();
        for (label, level) in &all {
            let Some(game) = level.games.get(index) else { continue };
            let name = name_in(analysis, arena, kind, *label);
            let choices = strategy::winning_choices(engine, kind, game)?;
            if arena.reference.is_some() {
                named.push(Named::states(name.clone(), &game.states));
                named.push(Named::choices(name.strategy(), &strategy::ours(engine, &choices)?));
            }
            let winning = winning(engine, &choices, &game.edge_labels)?;
            let goal = engine.can_choose(&winning)?;
            let towards = trends.towards(engine, &goal, &winning, &choices, &game.edge_labels)?;
            layers(named, &name, towards);
            if kind == Kind::Sasi {
                let (_, lost) = level_rounds(engine, trends, arena, &game.edge_labels, &before)?;
                rounds(named, &name, lost);
                before = game.states.clone();
            }
        }
        if matches!(analysis.levels(kind).end, Some(End::Empty)) {
            last_level(engine, trends, analysis, kind, arena, &before, named)?;
        }
    }
    Ok(())
}

/// Adds the proof that the level after the last one is empty. Under `prefix`, states of other
/// classes may win it in an arena without counting for it; those states get a root of their own.
fn last_level(
    engine: &SymbolicEngine,
    trends: &Trends,
    analysis: &Of<'_>,
    kind: Kind,
    arena: &Arena<SymbolicEngine>,
    before: &StateSet,
    named: &mut Vec<Named>,
) -> Result<()> {
    let found = &analysis.levels(kind).found;
    let number = LevelNumber::Finite(found.len() as u64 + 1);
    let name = name_in(analysis, arena, kind, number);
    let entered = found.last().map_or_else(|| engine.all_states(), |level| level.states.clone());
    let edge_labels = entering(engine, arena, &entered)?;
    let left = match kind {
        Kind::Sasi => {
            let (left, lost) = level_rounds(engine, trends, arena, &edge_labels, before)?;
            rounds(named, &name, lost);
            left
        }
        Kind::Spi => {
            let winning = winning(engine, &engine.all_choices(), &edge_labels)?;
            engine.can_win(&winning, &arena.choices, &edge_labels)?
        }
    };
    if arena.reference.is_some() {
        named.push(Named::states(name, &left));
    }
    Ok(())
}

/// Returns the name of a level in an arena, with the reference class if there is one.
fn name_in(analysis: &Of<'_>, arena: &Arena<SymbolicEngine>, kind: Kind, number: LevelNumber) -> RegionName {
    match arena.reference.and_then(|c| analysis.classes()?.list.get(c)) {
        Some(class) => {
            RegionName::Against(kind, number, class_name(analysis.preferences(), &class.most_preferred))
        }
        None => RegionName::Level(kind, number),
    }
}

/// Computes the rounds that remove the states of `before` that do not win a SASI level, and the
/// states that are left. States outside of `before` count as removed.
fn level_rounds(
    engine: &SymbolicEngine,
    trends: &Trends,
    arena: &Arena<SymbolicEngine>,
    edge_labels: &[EdgeLabels<StateSet>],
    before: &StateSet,
) -> Result<(StateSet, Proof)> {
    let winning = winning(engine, &engine.all_choices(), edge_labels)?;
    let mut removal = Removal::new(engine, trends).within(before, &arena.choices, edge_labels)?;
    loop {
        let reaching = engine.can_win(&winning, &removal.choices, edge_labels)?;
        let lost = engine.difference(&removal.left, &reaching)?;
        if !removal.remove(lost)? {
            return Ok((removal.left, removal.rounds));
        }
    }
}
