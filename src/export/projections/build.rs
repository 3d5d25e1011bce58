//! The construction of projections from a finished analysis.

use std::sync::Arc;

use super::directions::Namesakes;
use super::game::{GameSets, Neighbours};
use super::{Direction, Ladder, Plane, Projections, directions, levels};
use crate::describe;
use meliora_base::diagram::{Diagram, Edge};
use meliora_base::error::{Error, Result};
use meliora_engine::symbolic::{ChoiceSet, Set, StateSet, SymbolicEngine};
use meliora_engine::{Algebra, Dumpable, Engine};
use meliora_model::preference::{Goal, ObjectiveSet};
use meliora_model::{Program, VarId};
use meliora_planning::levels::{End, Level};
use meliora_planning::{Analysis, Class, FiniteMemoryStrategy, Kind, strategy};

/// The maximum number of choices for which a page shows the states that permit them.
const MOST_CHOICES: usize = 256;

/// The maximum number of labels that a page shows.
const MOST_LABELS: usize = 64;

/// The sets, in the order in which they become roots.
struct Sets {
    scope: StateSet,
    unsafe_states: Option<StateSet>,
    ladders: [Rungs; 2],
    classes: Vec<(ObjectiveSet, StateSet)>,
    targets: Vec<StateSet>,
    labels: Vec<(String, StateSet)>,
    namesakes: Vec<Namesakes>,
    game: Option<GameSets>,
}

/// The sets of a [`Ladder`].
struct Rungs {
    levels: Vec<StateSet>,
    unbounded: Option<StateSet>,
    open: bool,
    permitted: Vec<StateSet>,
}

/// Builds the projections of a finished analysis over a plane, through a state. If the diagram
/// would have more nodes than `most_nodes`, the permitted choices and the opponent's moves are left out. If that is not
/// enough, the sets are projected onto the plane; then the other variables cannot be fixed.
///
/// Cost: for SPI strategies one pre-image per level and arena. No state is enumerated, except a few
/// samples for the directions of choices.
///
/// # Errors
/// [`meliora_base::error::Error::Usage`] if the sets are not diagrams; a limit is reached.
pub fn build<E: Dumpable>(
    analysis: &Analysis<E>,
    plane: Plane,
    at: &[i64],
    most_nodes: usize,
) -> Result<Projections> {
    let engine = analysis.engine().diagrams()?;
    let names = describe::choice_names(engine);
    let arrows = if names.len() > MOST_CHOICES { 0 } else { names.len() };
    let mut choices = directions::of(engine, plane, names)?;
    let rows_up = directions::rows_up(engine.program(), plane, &choices);
    choices.truncate(arrows);
    let mut sets = Sets::compute(analysis, engine, &choices)?;
    let mut diagram = engine.diagram(&sets.all(), &[])?;
    if diagram.nodes.len() > most_nodes {
        choices.clear();
        sets.namesakes.clear();
        sets.ladders.iter_mut().for_each(|rungs| rungs.permitted.clear());
        sets.game.iter_mut().for_each(GameSets::without_moves);
        diagram = engine.diagram(&sets.all(), &[])?;
    }
    let projected = diagram.nodes.len() > most_nodes;
    if projected {
        sets.project(engine, plane)?;
        diagram = engine.diagram(&sets.all(), &[])?;
    }
    let (roots, mut used) = (std::mem::take(&mut diagram.roots), 0);
    // There is one root per set.
    let mut next = || {
        used += 1;
        roots[used - 1]
    };
    let scope = next();
    let unsafe_states = sets.unsafe_states.map(|_| next());
    let [sasi, spi] = sets.ladders.map(|rungs| rungs.ladder(&mut next));
    for namesakes in sets.namesakes {
        let several = Some(next());
        namesakes.choices.into_iter().for_each(|number| choices[number].several = several);
    }
    Ok(Projections {
        variables: engine.program().variables.clone(),
        facts: engine.program().variables.iter().map(|v| engine.program().facts_of(v)).collect(),
        levels: levels(engine.encoding()),
        plane,
        rows_up,
        at: at.to_vec(),
        scope,
        unsafe_states,
        sasi,
        spi,
        classes: sets.classes.into_iter().map(|(class, _)| (class, next())).collect(),
        targets: sets.targets.iter().map(|_| next()).collect(),
        labels: sets.labels.into_iter().map(|(name, _)| (name, next())).collect(),
        game: sets.game.map(|game| game.view(engine.program(), plane, &engine.coalition(), &mut next)),
        choices,
        projected,
        diagram: Diagram { roots: Vec::new(), ..diagram },
    })
}

/// Returns the states of a target that are marked: those of a temporal goal in which it becomes certain, by
/// the last step or in the beginning, and not all where it is. Cost: one image.
fn marked(engine: &SymbolicEngine, goal: &Goal, target: StateSet) -> Result<StateSet> {
    if matches!(goal, Goal::Reach(_)) {
        return Ok(target);
    }
    let before = engine.difference(&engine.all_states(), &target)?;
    let entered = engine.post(&engine.choices_in(&engine.all_choices(), &before)?)?;
    engine.intersection(&target, &engine.union(&entered, &engine.initial_states())?)
}

impl Sets {
    fn compute<E: Dumpable>(
        analysis: &Analysis<E>,
        engine: &SymbolicEngine,
        named: &[Direction],
    ) -> Result<Self> {
        let choices = named.len();
        let ladder = |kind| Rungs::compute(analysis, engine, kind, choices);
        let ladders = [ladder(Kind::Sasi)?, ladder(Kind::Spi)?];
        let classes = analysis.classes().into_iter().flat_map(|c| &c.list);
        let diagram = |x| analysis.engine().states_diagram(x).cloned();
        let target = |index| match analysis.outcomes().and_then(|outcomes| outcomes.target(index)) {
            Some(x) => marked(engine, &analysis.preferences().objectives[index].goal, diagram(x)?),
            None => Ok(engine.no_states()),
        };
        let objectives = analysis.preferences().objectives.len();
        let unsafe_states = analysis.requirements().map(|r| diagram(&r.unsafe_states)).transpose()?;
        let is_empty = unsafe_states.as_ref().map_or(Ok(true), |states| engine.is_empty(states))?;
        let whole = analysis.whole_engine().diagrams()?;
        let levels = [&*ladders[0].levels, &*ladders[1].levels];
        let game = GameSets::compute(whole, engine, &neighbours(analysis)?, levels, choices)?;
        Ok(Sets {
            scope: engine.all_states(),
            unsafe_states: unsafe_states.filter(|_| !is_empty),
            ladders,
            classes: classes
                .map(|c| Ok((c.most_preferred.clone(), diagram(&c.states)?)))
                .collect::<Result<_>>()?,
            targets: (0..objectives).map(target).collect::<Result<_>>()?,
            labels: labels(whole)?,
            namesakes: directions::namesakes(whole, named)?,
            game,
        })
    }

    /// Returns all sets; [`build`] takes the roots in this order.
    fn all(&self) -> Vec<Set> {
        let mut all = vec![&self.scope];
        all.extend(&self.unsafe_states);
        for rungs in &self.ladders {
            all.extend(rungs.levels.iter().chain(&rungs.unbounded).chain(&rungs.permitted));
        }
        all.extend(self.namesakes.iter().map(|namesakes| &namesakes.several));
        all.extend(self.classes.iter().map(|(_, states)| states));
        all.extend(&self.targets);
        all.extend(self.labels.iter().map(|(_, states)| states));
        all.extend(self.game.iter().flat_map(GameSets::all));
        all.into_iter().cloned().map(Set::States).collect()
    }

    /// Quantifies the variables outside of the plane.
    fn project(&mut self, engine: &SymbolicEngine, plane: Plane) -> Result<()> {
        let onto: Vec<VarId> = plane.row.into_iter().chain([plane.column]).collect();
        let mut all = vec![&mut self.scope];
        all.extend(&mut self.unsafe_states);
        for rungs in &mut self.ladders {
            all.extend(rungs.levels.iter_mut().chain(&mut rungs.unbounded));
        }
        all.extend(self.classes.iter_mut().map(|(_, states)| states));
        all.extend(&mut self.targets);
        all.extend(self.labels.iter_mut().map(|(_, states)| states));
        all.extend(self.game.iter_mut().flat_map(GameSets::projected));
        for set in all {
            *set = engine.projection(set, &onto)?;
        }
        Ok(())
    }
}

impl Rungs {
    fn compute<E: Dumpable>(
        analysis: &Analysis<E>,
        engine: &SymbolicEngine,
        kind: Kind,
        choices: usize,
    ) -> Result<Self> {
        let levels = analysis.levels(kind);
        let permitted = permitted(analysis, engine.program(), kind)?;
        let diagram = |level: &Level<E>| analysis.engine().states_diagram(&level.states).cloned();
        Ok(Rungs {
            levels: levels.found.iter().map(diagram).collect::<Result<_>>()?,
            unbounded: levels.unbounded().map(diagram).transpose()?,
            open: matches!(levels.end, None | Some(End::Cut)),
            permitted: (0..choices).map(|n| engine.numbered(&permitted, n)).collect::<Result<_>>()?,
        })
    }

    fn ladder(self, next: &mut impl FnMut() -> Edge) -> Ladder {
        Ladder {
            levels: self.levels.iter().map(|_| next()).collect(),
            unbounded: self.unbounded.map(|_| next()),
            open: self.open,
            permitted: self.permitted.iter().map(|_| next()).collect(),
        }
    }
}

/// Returns the classes with the states that improve and weaken them.
fn neighbours<E: Dumpable>(analysis: &Analysis<E>) -> Result<Vec<Neighbours>> {
    let diagram = |x: &E::States| analysis.engine().states_diagram(x).cloned();
    let classes = analysis.classes().into_iter().flat_map(|classes| &classes.list);
    let one = |c: &Class<E>| {
        Ok(Neighbours { class: diagram(&c.states)?, better: diagram(&c.better)?, worse: diagram(&c.worse)? })
    };
    classes.map(one).collect()
}

/// Returns the labels of the model with their states, up to [`MOST_LABELS`], without those that have no
/// value in some state.
fn labels(engine: &SymbolicEngine) -> Result<Vec<(String, StateSet)>> {
    let program = engine.program();
    let mut found = Vec::new();
    for (name, id) in program.labels.iter().take(MOST_LABELS) {
        match engine.states_where(&program.predicate(*id)) {
            Ok(states) => found.push((name.clone(), states)),
            Err(Error::Input(_)) => {}
            Err(other) => return Err(other),
        }
    }
    Ok(found)
}

/// Returns the permitted choices of start states, each state at the level of its rank.
fn permitted<E: Dumpable>(analysis: &Analysis<E>, program: &Arc<Program>, kind: Kind) -> Result<ChoiceSet> {
    let engine = analysis.engine();
    let mut all = engine.no_choices();
    let (Some(strategy), Some(classes), Some(improvement)) =
        (FiniteMemoryStrategy::new(analysis, program, kind), analysis.classes(), analysis.improvement())
    else {
        return engine.choices_diagram(&all).cloned();
    };
    let levels = analysis.levels(kind);
    let found = levels.found.iter().enumerate().map(|(k, level)| (Some(k + 1), level));
    for (rank, level) in found.chain(levels.unbounded().map(|level| (None, level))) {
        let permitted = strategy::permitted_at_start(engine, kind, classes, improvement, level)?;
        let here = engine.choices_in(&permitted, &strategy.states_of_rank(rank)?)?;
        all = engine.union(&all, &here)?;
    }
    engine.choices_diagram(&all).cloned()
}
