//! The values of some states as a report and as a table.

use super::{Task, Work};
use meliora_base::csv::Lines;
use meliora_base::error::{Limit, Result};
use meliora_engine::{Count, Engine};
use meliora_model::State;
use meliora_planning::Analysis;
use meliora_quantities::by_goal::by_goal;
use meliora_quantities::choose::LEVELS;
use meliora_quantities::cost::{Cost, Costs};
use meliora_quantities::state_values::{StateValues, Width};
use meliora_quantities::{Exploration, ValueOptions, Values};
use meliora_report::ValuesReport;
use meliora_report::values::{heading, rows};

/// The number of states whose values are added before they are computed.
const SOON: usize = 1000;

/// The number of nodes that are explored before values are computed, and the factor by which it grows while the values are
/// not known.
const FIRST: usize = 1 << 14;
const GROWTH: usize = 2;
/// The part of all states after which all are explored: the equations of all parts are at most half of those of all states.
const PART: u64 = 4;

/// The values that are asked for.
#[derive(Debug, Clone)]
pub struct ValuesWanted {
    /// The greatest number of improvements; `None` for the levels found, at most 10.
    pub levels: Option<usize>,
    /// Computes with fractions; for small models.
    pub exact: bool,
    /// The greatest number of steps of the success curves; `None` for no curves.
    pub within: Option<usize>,
    /// The cost of a step.
    pub costs: Costs,
    /// The largest width of a bound, absolute for probabilities, relative above 1 for other numbers.
    pub precision: f64,
    /// Computes also the gains of the first improvement.
    pub by_goal: bool,
    /// True if the states are all of the scope.
    pub everywhere: bool,
    /// The number of states in the report; the table has all.
    pub shown: usize,
}

/// Computes the values of some states and adds them to the report, also those known when a limit ends the work; all of them
/// are added to `lines`, too. Cost: see [`Exploration::run_part`] and [`Values::solve`].
///
/// # Errors
/// A bound is wider than the precision; a reward is wrong in some state; a limit is reached.
pub fn values<E: Engine>(
    work: &dyn Work<ValuesReport>,
    (analysis, task): (&Analysis<E>, &Task),
    states: &[State],
    wanted: &ValuesWanted,
    lines: Option<&mut Lines>,
) -> Result<()> {
    let engine = analysis.engine();
    let costs = wanted.costs.check(engine, &task.program)?;
    Evaluation { work, task, analysis, states, wanted, costs: &*costs }.run(lines)
}

/// The evaluation of states.
struct Evaluation<'a, E: Engine> {
    work: &'a dyn Work<ValuesReport>,
    task: &'a Task,
    analysis: &'a Analysis<E>,
    states: &'a [State],
    wanted: &'a ValuesWanted,
    costs: &'a dyn Cost,
}

impl<E: Engine> Evaluation<'_, E> {
    fn run(&self, lines: Option<&mut Lines>) -> Result<()> {
        let Evaluation { work, task, analysis, states, wanted, costs } = *self;
        let (program, engine) = (&task.program, analysis.engine());
        let levels = wanted.levels.unwrap_or_else(|| Values::levels_found(analysis, LEVELS));
        let mut values = Values::new(ValueOptions { levels, exact: wanted.exact, within: wanted.within });
        let begin = || Exploration::new(values.options(), analysis, program, costs);
        let exploration = work.timed("explore", begin, |r, s| r.time.add("explore", s))?;
        let first = &states[..states.len().min(SOON)];
        let most = engine.count(&engine.all_states())? / PART;
        let solved = loop {
            let nodes = FIRST.max(GROWTH * values.nodes());
            let explore = || match wanted.everywhere {
                true => exploration.everywhere(&mut values),
                false if Count::from(nodes) > most => exploration.run(&mut values, states),
                false => exploration.run_part(&mut values, states, nodes),
            };
            let explored = work.timed("explore", explore, |r, s| r.time.add("explore", s));
            // The work may be left behind while it solves, so the results of the levels are added first, unless that takes
            // long.
            self.fill(&values, first, usize::MAX, None)?;
            explored?;
            let solved = work.timed("solve", || values.solve(engine), |r, s| r.time.add("solve", s));
            if solved.is_err() || values.is_settled() {
                break solved;
            }
            let close = || exploration.close(&mut values, nodes + nodes / 2);
            let closed = work.timed("explore", close, |r, s| r.time.add("explore", s));
            if closed.is_err() || values.is_settled() {
                break closed;
            }
        };
        let widest = self.fill(&values, states, wanted.shown, lines)?;
        solved?;
        if wanted.by_goal {
            work.timed("by goal", || self.add_gains(), |_, _| ())?;
        }
        self.judge(&widest)
    }

    /// Adds the gains of the first improvement of each listed state.
    fn add_gains(&self) -> Result<()> {
        let Evaluation { work, task, analysis, states, wanted, costs } = *self;
        for (position, state) in states.iter().enumerate() {
            let gains = by_goal(analysis, &task.program, state, costs, wanted.precision)?;
            work.update(|r| {
                if let Some(values) = r.states.get_mut(position).filter(|values| !values.is_unsafe) {
                    values.by_goal = Some(gains);
                }
            });
        }
        Ok(())
    }

    /// Refuses bounds that are wider than the precision.
    fn judge(&self, widest: &Width) -> Result<()> {
        let (width, quantity, precision) = (widest.width, widest.quantity(), self.wanted.precision);
        let is_wide = width > precision;
        if !is_wide {
            return Ok(());
        }
        let what = match width.is_finite() {
            true => {
                format!("bounds of {quantity} are {width:e} apart, more than the precision {precision:e}")
            }
            false => format!("no upper bound of {quantity} was found"),
        };
        let what = format!("{what}; `--exact` finds the values of small models");
        Err(Limit::Size { what }.into())
    }

    /// Lists values as far as they are known: those of the first states in the report, all in
    /// `lines`. Returns the widest bound of all.
    fn fill(
        &self,
        values: &Values,
        states: &[State],
        shown: usize,
        mut lines: Option<&mut Lines>,
    ) -> Result<Width> {
        let (mut found, mut more, mut widest) = (Vec::new(), 0, Width::default());
        let required = self.analysis.requirements().is_some();
        if let Some(lines) = &mut lines {
            lines.push(heading(&self.task.program, required));
        }
        StateValues::each(self.analysis, &self.task.program, values, states, &mut |state| {
            widest = widest.or(state.widest());
            if let Some(lines) = &mut lines {
                rows(&state, required).into_iter().for_each(|row| lines.push(row));
            }
            if found.len() < shown {
                found.push(state);
            } else {
                more += 1;
            }
        })?;
        self.work.update(|r| (r.states, r.more) = (found, more));
        Ok(widest)
    }
}
