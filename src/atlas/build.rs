//! From a finished analysis to an atlas.

use super::{Atlas, Ladder, Plane, directions, levels};
use crate::dump::{Diagram, Edge};
use crate::engine::Engine;
use crate::engine::symbolic::{Set, StateSet, SymbolicEngine};
use crate::error::Result;
use crate::export;
use crate::model::preference::ObjectiveSet;
use crate::model::{Program, VarId};
use crate::planning::levels::End;
use crate::planning::{Analysis, Kind, Playbook, strategy};

type Of<'a> = Analysis<'a, SymbolicEngine>;

/// The most choices for which a page tells where they are permitted.
const MOST_CHOICES: usize = 256;

/// The sets in the order in which they become roots.
struct Sets {
    scope: StateSet,
    ladders: [Rungs; 2],
    classes: Vec<(ObjectiveSet, StateSet)>,
    targets: Vec<StateSet>,
}

/// The sets of a [`Ladder`].
struct Rungs {
    levels: Vec<StateSet>,
    unbounded: Option<StateSet>,
    open: bool,
    permitted: Vec<StateSet>,
}

/// The atlas of a finished analysis over a plane, through a state. Where its diagram would have more
/// nodes than `most_nodes`, the other variables are confined to their values in that state.
///
/// # Errors
/// A limit. Cost: for SPI strategies a pre-image a level and part; no state is enumerated but a few
/// samples that tell in which direction a choice leads.
pub fn build(
    engine: &SymbolicEngine,
    analysis: &Of<'_>,
    plane: Plane,
    at: &[i64],
    most_nodes: usize,
) -> Result<Atlas> {
    let names = export::choice_labels(engine);
    let names = if names.len() > MOST_CHOICES { Vec::new() } else { names };
    let mut sets = Sets::of(engine, analysis, names.len())?;
    let mut diagram = engine.diagram(&sets.all(), &[])?;
    let confined = diagram.nodes.len() > most_nodes;
    if confined {
        sets = sets.within(engine, &slice(engine, plane, at)?)?;
        diagram = engine.diagram(&sets.all(), &[])?;
    }
    let program = engine.program();
    let choices = directions::of(engine, plane, names)?;
    let mut roots = std::mem::take(&mut diagram.roots).into_iter();
    let mut next = || roots.next().unwrap_or(Edge::FALSE);
    let scope = next();
    let [sasi, spi] = sets.ladders.map(|rungs| rungs.ladder(&mut next));
    Ok(Atlas {
        variables: program.variables.clone(),
        levels: levels(engine.encoding()),
        plane,
        rows_up: directions::rows_up(program, plane, &choices),
        at: at.to_vec(),
        scope,
        sasi,
        spi,
        classes: sets.classes.into_iter().map(|(class, _)| (class, next())).collect(),
        targets: sets.targets.iter().map(|_| next()).collect(),
        choices,
        confined,
        diagram: Diagram { roots: Vec::new(), ..diagram },
    })
}

/// The states that differ from `at` in the variables of the plane alone.
fn slice(engine: &SymbolicEngine, plane: Plane, at: &[i64]) -> Result<StateSet> {
    let outside = |v: &VarId| Some(*v) != plane.row && *v != plane.column;
    let others = (0..at.len() as u32).map(VarId).filter(outside);
    engine.slice(&others.map(|v| (v, at[v.index()])).collect::<Vec<_>>())
}

impl Sets {
    fn of(engine: &SymbolicEngine, analysis: &Of<'_>, choices: usize) -> Result<Self> {
        let program: &Program = engine.program();
        let ladder = |kind| Rungs::of(engine, analysis, program, kind, choices);
        let ladders = [ladder(Kind::Sasi)?, ladder(Kind::Spi)?];
        let classes = analysis.classes().into_iter().flat_map(|c| &c.list);
        let target = |index| analysis.outcomes()?.target(index).cloned();
        let objectives = analysis.preferences().objectives.len();
        Ok(Sets {
            scope: engine.all_states(),
            ladders,
            classes: classes.map(|c| (c.most_preferred.clone(), c.states.clone())).collect(),
            targets: (0..objectives).map(|i| target(i).unwrap_or_else(|| engine.no_states())).collect(),
        })
    }

    /// All sets; [`build`] takes the roots in this order.
    fn all(&self) -> Vec<Set> {
        let mut all = vec![&self.scope];
        for rungs in &self.ladders {
            all.extend(rungs.levels.iter().chain(&rungs.unbounded).chain(&rungs.permitted));
        }
        all.extend(self.classes.iter().map(|(_, states)| states));
        all.extend(&self.targets);
        all.into_iter().cloned().map(Set::States).collect()
    }

    fn within(mut self, engine: &SymbolicEngine, x: &StateSet) -> Result<Self> {
        let mut all = vec![&mut self.scope];
        for rungs in &mut self.ladders {
            all.extend(rungs.levels.iter_mut().chain(&mut rungs.unbounded).chain(&mut rungs.permitted));
        }
        all.extend(self.classes.iter_mut().map(|(_, states)| states));
        all.extend(&mut self.targets);
        for set in all {
            *set = engine.intersection(set, x)?;
        }
        Ok(self)
    }
}

impl Rungs {
    fn of(
        engine: &SymbolicEngine,
        analysis: &Of<'_>,
        program: &Program,
        kind: Kind,
        choices: usize,
    ) -> Result<Self> {
        let levels = analysis.levels(kind);
        let permitted = permitted(engine, analysis, program, kind)?;
        Ok(Rungs {
            levels: levels.found.iter().map(|level| level.states.clone()).collect(),
            unbounded: levels.unbounded().map(|level| level.states.clone()),
            open: matches!(levels.end, None | Some(End::Cut)),
            permitted: (0..choices).map(|number| engine.numbered(&permitted, number)).collect(),
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

/// What the permissive strategies permit where planning starts, each state at the level of its rank.
fn permitted(
    engine: &SymbolicEngine,
    analysis: &Of<'_>,
    program: &Program,
    kind: Kind,
) -> Result<<SymbolicEngine as Engine>::Choices> {
    let mut all = engine.no_choices();
    let (Some(book), Some(classes), Some(improvement)) =
        (Playbook::new(analysis, program, kind), analysis.classes(), analysis.improvement())
    else {
        return Ok(all);
    };
    let levels = analysis.levels(kind);
    let found = levels.found.iter().enumerate().map(|(k, level)| (Some(k + 1), level));
    for (rank, level) in found.chain(levels.unbounded().map(|level| (None, level))) {
        let permitted = strategy::permitted_at_start(engine, kind, classes, improvement, level)?;
        let here = engine.choices_in(&permitted, &book.states_of_rank(rank)?)?;
        all = engine.union_choices(&all, &here)?;
    }
    Ok(all)
}
