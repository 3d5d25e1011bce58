//! The exploration of the states whose values are asked for.

use meliora_base::error::{Error, Result};
use meliora_base::exact::Ratio;
use meliora_engine::Engine;
use meliora_model::{Program, State};
use meliora_planning::levels::End;
use meliora_planning::{Analysis, Kind};

use num_traits::Zero;

use crate::cost::Cost;
use crate::explore::Explorer;
use crate::facts::Facts;
use crate::values::{ValueOptions, Values};
use meliora_equations::Meter;

/// The exploration of the states that others reach by kept choices.
pub struct Exploration<'a, E: Engine> {
    analysis: &'a Analysis<E>,
    facts: Facts<'a, E>,
    costs: &'a dyn Cost,
}

impl<'a, E: Engine> Exploration<'a, E> {
    /// Prepares the exploration with what an analysis knows. Cost: under `transition`, that of the SASI levels of `action`.
    ///
    /// # Errors
    /// A limit is reached, or the levels of the analysis are not known.
    pub fn new(
        options: ValueOptions,
        analysis: &'a Analysis<E>,
        program: &'a Program,
        costs: &'a dyn Cost,
    ) -> Result<Self> {
        if let Some(known) = cut(analysis).filter(|&known| known < options.levels) {
            let message = format!("the analysis ended at level {known}; quantities need {}", options.levels);
            return Err(Error::Usage(message));
        }
        let facts = Facts::new(analysis, program, options.levels)?;
        Ok(Exploration { analysis, facts, costs })
    }

    /// Finds the states that kept choices reach from some states of the scope; unsafe states are left
    /// out. To be called once, before [`Values::solve`]. Cost: one evaluation of the commands, and some membership tests,
    /// per state.
    ///
    /// # Errors
    /// A limit is reached, or a command or a cost has no meaning in some state.
    pub fn run(&self, values: &mut Values, starts: &[State]) -> Result<()> {
        self.explore(values, None, |explorer| self.nodes(explorer, starts))
    }

    /// Does the same as [`Exploration::run`], but ends with that many nodes; the next call continues where the fewest
    /// steps to an improvement are lost, or where the best choices lead. Fractions, curves, and values of games need all nodes at once. Between the calls, [`Values::solve`] finds
    /// bounds, and [`Values::is_settled`] tells whether they are narrow.
    ///
    /// # Errors
    /// The errors of [`Exploration::run`].
    pub fn run_part(&self, values: &mut Values, starts: &[State], nodes: usize) -> Result<()> {
        let options = values.options();
        if options.exact || options.within.is_some() || self.analysis.engine().theirs().is_some() {
            return self.run(values, starts);
        }
        self.explore(values, Some(nodes), |explorer| self.nodes(explorer, starts))
    }

    /// Explores further where the best choices lead, until choices that are followed end in the part that was explored, or it
    /// has that many nodes; then their values bound those of the whole. To be called after [`Values::solve`], before the next
    /// part. Cost: that of the nodes, and the equations of these choices.
    ///
    /// # Errors
    /// The errors of [`Exploration::run`].
    pub fn close(&self, values: &mut Values, nodes: usize) -> Result<()> {
        if values.is_settled() || values.starts.iter().all(|&start| values.graph.steps(start) == 0) {
            return Ok(());
        }
        let mut meter = Meter::settled(self.analysis.engine());
        meter.take(values.graph.bytes() + values.places.bytes())?;
        let Values { graph, places, found, .. } = values;
        let mut explorer = Explorer::new(&self.facts, self.costs, graph, places, &mut meter)?;
        let end = explorer.close(found, nodes);
        drop(explorer);
        graph.finish();
        end?;
        found.judge(graph, &mut meter)
    }

    /// Adds the nodes of some states; unsafe states have none.
    fn nodes(&self, explorer: &mut Explorer<'_, '_>, states: &[State]) -> Result<Vec<u32>> {
        let mut nodes = Vec::with_capacity(states.len());
        for state in states {
            nodes.extend(explorer.start(state)?);
        }
        Ok(nodes)
    }

    /// Does the same as [`Exploration::run`] for all states of the analysis, which are those of the
    /// scope that are not unsafe. Cost: one evaluation of the commands per state; membership tests only
    /// for states in arenas that are not their own.
    ///
    /// # Errors
    /// The errors of [`Exploration::run`].
    pub fn everywhere(&self, values: &mut Values) -> Result<()> {
        self.explore(values, None, |explorer| {
            let mut nodes = Vec::new();
            for (number, class) in (0..).zip(&self.facts.classes.list) {
                for state in self.analysis.engine().list_states(&class.states, usize::MAX)? {
                    nodes.push(explorer.start_in(number, &state)?);
                }
            }
            Ok(nodes)
        })
    }

    /// Explores from some nodes, at least `part` nodes if that is given.
    fn explore(
        &self,
        values: &mut Values,
        part: Option<usize>,
        start: impl FnOnce(&mut Explorer<'_, '_>) -> Result<Vec<u32>>,
    ) -> Result<()> {
        let mut meter = Meter::settled(self.analysis.engine());
        meter.take(values.graph.bytes() + values.places.bytes())?;
        let (graph, places) = (&mut values.graph, &mut values.places);
        if part.is_some() {
            graph.be_part(self.costs.constant().unwrap_or_else(Ratio::zero));
        }
        let mut explorer = Explorer::new(&self.facts, self.costs, graph, places, &mut meter)?;
        let starts = start(&mut explorer);
        let missing = values.found.take_missing(explorer.graph());
        let end = starts.and_then(|starts| {
            values.starts = starts;
            match part {
                Some(nodes) => {
                    // The values of most states need few nodes, and no distances.
                    if missing.is_some() {
                        explorer.measure(&values.starts)?;
                    }
                    // Without distances, the best choices show where more nodes are needed.
                    let has_steps = values.starts.iter().any(|&start| explorer.graph().steps(start) > 0);
                    let near = missing.filter(|_| !has_steps);
                    explorer.extend(near.as_ref().unwrap_or(&values.starts), nodes)
                }
                None => explorer.run(),
            }
        });
        drop(explorer);
        values.graph.finish();
        end
    }
}

/// Returns the level at which an analysis was cut, if it was: nothing is known beyond it.
fn cut<E: Engine>(analysis: &Analysis<E>) -> Option<usize> {
    let cut = |&kind: &Kind| {
        let levels = analysis.levels(kind);
        matches!(levels.end, Some(End::Cut)).then_some(levels.found.len())
    };
    Kind::ALL.iter().filter_map(cut).min()
}
