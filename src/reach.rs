//! Questions about paths: to reach a target, or to satisfy a temporal formula.

use std::sync::Arc;

use crate::engine::Engine;
use crate::engine::regions::{Regions, regions};
use crate::error::{Result, SourceFile};
use crate::lang::ltl::{Formula, Monitoring};
use crate::lang::property::{Bound, Question, Strategies};
use crate::lang::{lower_target, ltl, parse_expression, parse_property};
use crate::model::Program;
use crate::model::expr::ExprId;
use crate::model::temporal::{Begin, Condition};
use crate::planning::temporal;

/// The goal of the paths.
pub enum Goal {
    /// To reach these states.
    Target(ExprId),
    /// To satisfy a temporal formula.
    Formula(Watched),
}

/// A model with the monitors of one formula.
pub struct Watched {
    /// The model with its monitors.
    pub program: Arc<Program>,
    /// The condition on the marks of the monitors.
    pub condition: Condition,
    /// The states where the monitors are fresh.
    pub fresh: ExprId,
}

/// A quantifier over strategies, and a bound on the probability.
pub type Comparison = (Strategies, Bound);

impl Goal {
    /// Turns a formula into a goal: a target, which is added to the program, or monitors next to
    /// the model.
    ///
    /// # Errors
    /// The formula is wrong or not supported.
    pub fn of(program: &mut Program, source: &Arc<SourceFile>, formula: &Formula) -> Result<Self> {
        if let Some(target) = formula.reachability() {
            return Ok(Goal::Target(lower_target(program, source, target)?));
        }
        let mut watched = program.clone();
        let mut watching = Monitoring::new(&mut watched);
        let condition = watching.watch(source, formula, "property")?;
        let fresh = watching.finish(Begin::Everywhere)?;
        Ok(Goal::Formula(Watched { program: Arc::new(watched), condition, fresh }))
    }

    /// Reads a target such as `x = 3`, a formula such as `F x = 3`, or a property such as
    /// `P>=1 [ F x = 3 ]`, which also has a question.
    ///
    /// # Errors
    /// The text is none of these, or not supported; each error has its place.
    pub fn parse(program: &mut Program, source: &Arc<SourceFile>) -> Result<(Self, Option<Question>)> {
        if let Ok(tree) = parse_expression(source) {
            return Ok((Goal::Target(lower_target(program, source, &tree)?), None));
        }
        let is_word = |c: char| c.is_alphanumeric() || c == '_';
        let first = source.text.trim_start().split(|c| !is_word(c)).next();
        if first.is_some_and(|word| ["P", "Pmin", "Pmax"].contains(&word)) {
            let property = parse_property(source)?;
            property.check(program, source)?;
            let goal = Goal::of(program, source, &property.formula)?;
            return Ok((goal, Some(property.question)));
        }
        Ok((Goal::of(program, source, &ltl::parse_formula(source)?)?, None))
    }

    /// Returns the states whose paths are judged: with monitors, the states where these are fresh.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn judged<E: Engine>(&self, engine: &E) -> Result<E::States> {
        match self {
            Goal::Target(_) => Ok(engine.all_states()),
            Goal::Formula(watched) => engine.states_where(watched.fresh),
        }
    }

    /// Computes the four regions over all states, with an engine for the program of the goal; those
    /// with monitors that are not fresh among them. Cost: see
    /// [`regions`] and [`temporal::regions`].
    ///
    /// # Errors
    /// A limit is reached, or a state formula has no value in some state.
    pub fn regions<E: Engine>(&self, engine: &E) -> Result<Regions<E::States>> {
        match self {
            Goal::Target(target) => regions(engine, &engine.states_where(*target)?),
            Goal::Formula(watched) => temporal::regions(engine, &watched.condition),
        }
    }

    /// Returns the regions within the states whose paths are judged.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn restricted<E: Engine>(
        &self,
        engine: &E,
        regions: Regions<E::States>,
    ) -> Result<Regions<E::States>> {
        match self {
            Goal::Target(_) => Ok(regions),
            Goal::Formula(watched) => temporal::judged(engine, watched.fresh, regions),
        }
    }
}

/// Returns whether a property with these regions is true in all initial states.
///
/// # Errors
/// A limit is reached.
pub fn holds<E: Engine>(
    engine: &E,
    (strategies, bound): Comparison,
    found: &Regions<E::States>,
) -> Result<bool> {
    let initial = engine.initial_states();
    let inside = |region| engine.difference(&initial, region);
    let outside = |region| engine.intersection(&initial, region);
    let violating = match (strategies, bound) {
        (Strategies::Some, Bound::One) => inside(&found.pmax_one),
        (Strategies::Some, Bound::Positive) => inside(&found.pmax_positive),
        (Strategies::All, Bound::One) => inside(&found.pmin_one),
        (Strategies::All, Bound::Positive) => inside(&found.pmin_positive),
        // A property is true for every strategy if no strategy violates it, and vice versa.
        (Strategies::Some, Bound::BelowOne) => outside(&found.pmin_one),
        (Strategies::Some, Bound::Zero) => outside(&found.pmin_positive),
        (Strategies::All, Bound::BelowOne) => outside(&found.pmax_one),
        (Strategies::All, Bound::Zero) => outside(&found.pmax_positive),
    };
    engine.is_empty(&violating?)
}
