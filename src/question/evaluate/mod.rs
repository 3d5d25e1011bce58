//! Properties as expressions over states, evaluated bottom-up: a condition is a set of states, a number
//! is an interval for each state that is asked for.
//!
//! - `sets`: conditions.
//! - `numbers`: numbers of states, and `number` with their arithmetic.
//! - `operators`: the numbers of `P`, `R` and `S`.
//! - `paths`: the regions of formulas on paths.
//! - `products`: formulas that need monitors, and the models in which these are evaluated.
//! - `several`: several objectives at once.
//! - `following`: strategies for them that files state.
//! - `optimal`, `aims`: the strategy of one operator, and the value of a strategy by its `chain`;
//!   `running`: runs of it.
//! - `actions`: probabilities after each action.
//! - `filters`: functions of the values in several states.

mod actions;
mod aims;
mod chain;
mod condition;
mod filters;
mod following;
mod number;
mod numbers;
mod operators;
mod optimal;
mod paths;
mod products;
mod running;
mod sets;
mod several;

use std::cell::OnceCell;
use std::ops::Range;
use std::sync::Arc;

pub use actions::ActionValues;
pub use chain::{PolicyNode, PolicyNodes};
pub use following::{Following, Nodes, Objectives, StrategyFault, StrategyFaultKind};
use meliora_base::error::{Diagnostic, Error, Result, Severity, SourceFile};
use meliora_base::interval::Interval;
use meliora_engine::Engine;
use meliora_engine::regions::Which;
use meliora_equations::Arena;
use meliora_equations::vector::{MOST_STATES, too_many_states};
use meliora_lang::property::term::{Filter, FilterFunction, Term, TermKind};
use meliora_model::{Program, State};
pub use number::Number;
pub use optimal::{Played, PropertyPolicy, attains};
pub use running::{PropertyRun, PropertyRuns};
pub(crate) use sets::sign;
pub use several::{Mix, MixedStrategy};

use crate::goal::{PathGoal, Required};

/// Builds the engine of a program: the model with monitors, or with one choice per successor.
pub type Build<'a, E> = dyn Fn(&Arc<Program>) -> Result<Arc<E>> + 'a;

/// The states of a program, and how to compute with them.
pub struct Model<'a, E: Engine> {
    engine: &'a E,
    program: &'a Arc<Program>,
    build: &'a Build<'a, E>,
    precision: f64,
    /// The requirements that the engine keeps, conditions on states.
    required: &'a [Required],
    /// The list of the states, once a number has needed it.
    arena: OnceCell<Arena<'a>>,
    /// The place of the only property, one operator, and the numbers that it asks for in the initial states, if they are
    /// known.
    optima: Option<(Range<usize>, &'a [Number])>,
    /// The goal of the only property, if the engine is that of the model with its monitors.
    goal: Option<&'a PathGoal>,
}

impl<'a, E: Engine> Model<'a, E> {
    /// Creates a model from its engine. `build` builds the engines of other models that are needed; the
    /// bounds of numbers are at most `precision` wide where they can be computed so.
    pub fn new(engine: &'a E, program: &'a Arc<Program>, build: &'a Build<'a, E>, precision: f64) -> Self {
        let arena = OnceCell::new();
        Model { engine, program, build, precision, required: &[], arena, optima: None, goal: None }
    }

    /// Says that the engine is that of the model with the monitors of a goal. Then the strategy of its formula is the only
    /// thing to ask for.
    #[must_use]
    pub(crate) fn watched(self, goal: Option<&'a PathGoal>) -> Self {
        Model { goal, ..self }
    }

    /// Says which numbers the only property, one operator, asks for in the initial states.
    #[must_use]
    pub(crate) fn knowing(self, term: &Term, optima: Option<&'a [Number]>) -> Self {
        Model { optima: optima.map(|optima| (term.span.range(), optima)), ..self }
    }

    /// Says that the engine is that of a model under requirements `G p`.
    #[must_use]
    pub fn under(self, required: &'a [Required]) -> Self {
        Model { required, ..self }
    }

    /// Returns the list of the states. Cost: one evaluation of the commands per state, once.
    ///
    /// # Errors
    /// The states do not fit into the memory limit; another limit is reached.
    fn arena(&self) -> Result<&Arena<'a>> {
        if let Some(arena) = self.arena.get() {
            return Ok(arena);
        }
        let arena = Arena::new(self.engine, self.program)?;
        Ok(self.arena.get_or_init(|| arena))
    }
}

/// Evaluates properties of one text in the states of a model.
pub struct Evaluator<'m, 'a, E: Engine> {
    model: &'m Model<'a, E>,
    engine: &'a E,
    program: &'a Arc<Program>,
    source: &'m Arc<SourceFile>,
    /// True if nothing is asked of the engine after this property.
    is_last: bool,
}

/// A region of a formula, with its states.
pub type Region<S> = (Which, S);

/// The answer to a property.
#[derive(Debug, Clone)]
pub struct PropertyResult<S> {
    /// The regions of the formula, if the property is one operator for a probability.
    pub regions: Vec<Region<S>>,
    /// The condition holds in all initial states; `None` for a number.
    pub holds: Option<bool>,
    /// The range of the number over the initial states, or the value of a filter; `None` for a condition.
    pub value: Option<Number>,
    /// The points of a Pareto front, if the property asks for one.
    pub front: Option<Vec<Vec<f64>>>,
    /// The values of states, if the property lists them.
    pub values: Option<Vec<(State, StateValue)>>,
}

/// A value in a state.
#[derive(Debug, Clone, PartialEq)]
pub enum StateValue {
    /// Truth of the condition.
    Holds(bool),
    /// The number.
    Number(Number),
}

/// States with a list of them.
struct At<S> {
    set: S,
    list: Vec<State>,
}

/// The values that a filter lists, and its numbers in the initial states.
type Listed = (Option<Vec<(State, StateValue)>>, Option<Vec<Number>>);

impl<'m, 'a, E: Engine> Evaluator<'m, 'a, E> {
    /// Creates an evaluator for the properties of a text.
    pub fn new(model: &'m Model<'a, E>, source: &'m Arc<SourceFile>) -> Self {
        Evaluator { model, engine: model.engine, program: model.program, source, is_last: false }
    }

    /// Says whether nothing is asked of the engine after the next property.
    #[must_use]
    pub(crate) fn last(self, is_last: bool) -> Self {
        Evaluator { is_last, ..self }
    }

    /// Ends the other ways of a race: the states that have equations are known, and these are the same on each way.
    fn settle(&self, arena: &Arena<'_>) {
        if self.is_last {
            arena.settle();
        }
    }

    /// Returns the text of a property on one line.
    pub fn text(&self, term: &Term) -> String {
        self.source.on_one_line(term.span.range())
    }

    /// Returns the states that satisfy a condition; `None` for a number.
    ///
    /// # Errors
    /// The errors of [`Evaluator::answer`].
    pub fn satisfied(&self, term: &Term) -> Result<Option<E::States>> {
        term.is_condition().then(|| self.states(term, &self.engine.all_states())).transpose()
    }

    /// Answers a property in the initial states.
    ///
    /// # Errors
    /// A limit is reached; a part is not supported, or has no value in some state; the bounds of a number do
    /// not decide a comparison.
    pub fn answer(&self, term: &Term) -> Result<PropertyResult<E::States>> {
        let initial = self.engine.initial_states();
        let regions = self.regions(term)?;
        if let Some(front) = self.front(term)? {
            return Ok(PropertyResult {
                regions,
                holds: None,
                value: None,
                values: None,
                front: Some(front),
            });
        }
        if let Some(holds) = self.qualitative(term, &regions)? {
            return Ok(PropertyResult {
                holds: Some(holds),
                values: None,
                value: None,
                front: None,
                regions,
            });
        }
        let (values, known) = match &term.kind {
            TermKind::Filter(filter) => self.listed(filter)?,
            _ => (None, None),
        };
        if let TermKind::Operator(measured) = &term.kind
            && measured.bound.is_some()
        {
            let (holds, value) = self.compared_value(term, measured, &self.at(&initial)?)?;
            return Ok(PropertyResult { holds: Some(holds), value, values, front: None, regions });
        }
        if term.is_condition() {
            let satisfied = self.states(term, &initial)?;
            let holds = self.engine.is_empty(&self.engine.difference(&initial, &satisfied)?)?;
            return Ok(PropertyResult { holds: Some(holds), values, value: None, front: None, regions });
        }
        let of_initial = match known {
            Some(known) => known,
            None => self.narrow(term, &self.at(&initial)?)?,
        };
        let value = of_initial.into_iter().reduce(|all, x| all.range(&x));
        if value.as_ref().is_some_and(Number::is_undefined) {
            return Err(self.wrong(term, "the number is undefined, as is 0 divided by 0").into());
        }
        Ok(PropertyResult { holds: None, value, values, front: None, regions })
    }

    /// Returns the values that a filter lists, and its numbers in the initial states, if it has them there: each number is
    /// computed once.
    fn listed(&self, filter: &Filter) -> Result<Listed> {
        use FilterFunction::{Argmax, Argmin, Print, Printall};
        let prints = matches!(filter.function, Print | Printall);
        if !prints && !matches!(filter.function, Argmin | Argmax) {
            return Ok((None, None));
        }
        let mut set = self.chosen(filter)?;
        if !prints {
            set = self.extreme_states(filter, &set)?;
        }
        if filter.of.is_condition() {
            let satisfied = self.states(&filter.of, &set)?;
            let listed = if filter.function == Print { &satisfied } else { &set };
            let values = self.at(listed)?.list.into_iter().map(|state| {
                let holds = self.engine.contains(&satisfied, &state)?;
                Ok((state, StateValue::Holds(holds)))
            });
            return Ok((Some(values.collect::<Result<_>>()?), None));
        }
        let initial = self.engine.initial_states();
        let at = self.at(&if prints { self.engine.union(&set, &initial)? } else { set.clone() })?;
        let (mut values, mut of_initial) = (Vec::new(), Vec::new());
        let numbers = self.narrow(&filter.of, &at)?;
        for (state, x) in at.list.into_iter().zip(numbers) {
            if prints && self.engine.contains(&initial, &state)? {
                of_initial.push(x.clone());
            }
            let is_shown = filter.function != Print || x.interval != Interval::ZERO;
            if is_shown && self.engine.contains(&set, &state)? {
                values.push((state, StateValue::Number(x)));
            }
        }
        Ok((Some(values), prints.then_some(of_initial)))
    }

    /// Lists some states.
    fn at(&self, set: &E::States) -> Result<At<E::States>> {
        Ok(At { set: set.clone(), list: listed(self.engine, set)? })
    }

    /// Returns an error at the place of a term.
    fn wrong(&self, term: &Term, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(self.source, term.span.range(), message)
    }

    /// Returns the error for a part that is not supported.
    fn unsupported(&self, term: &Term, message: impl Into<String>, help: &str) -> Error {
        self.wrong(term, message).severity(Severity::Unsupported).label("not supported").help(help).into()
    }
}

/// Lists the states of a set.
pub(crate) fn listed<E: Engine>(engine: &E, set: &E::States) -> Result<Vec<State>> {
    let list = engine.list_states(set, MOST_STATES + 1)?;
    if list.len() > MOST_STATES {
        return Err(too_many_states().into());
    }
    Ok(list)
}
