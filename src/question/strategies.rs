//! Strategies for a target: policies, and the states with a strong plan. The strategies of one operator.

use std::sync::Arc;

use crate::evaluate::{self, Evaluator, Model, PropertyPolicy};
use crate::goal::PathGoal;
use crate::number::Number;
use crate::plan::{Planned, Request};
use crate::questions::{Options, Questions};
use meliora_base::decimal::readable;
use meliora_base::error::{Error, Result};
use meliora_base::progress::ProgressSink;
use meliora_certify::policy::rules::{Rules, Taken};
use meliora_engine::{Engine, ExplicitEngine, Guided};
use meliora_lang::property::term::{Measure, Path, TermKind};
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_planning::policy::{Policy, PolicyEntry, strong_region};

/// Maximum number of states of a policy: each takes about as much memory as a line of its text.
pub const MOST_STATES: usize = 1_000_000;

/// Returns a policy that reaches a target almost surely from the initial states; `None` if there is none. The engine may
/// know states that are not reachable.
///
/// # Errors
/// A limit is reached.
pub(crate) fn policy<E: Engine>(engine: &E, program: &Program, target: &Predicate) -> Result<Option<Policy>> {
    let found = Policy::find(engine, program, &engine.states_where(target)?, MOST_STATES)?;
    found.map(|found| checked(found, program, target, &*engine.settings().sink)).transpose()
}

/// Returns the policy of a guided search; `None` if it has found that there is none.
///
/// # Errors
/// A limit is reached.
pub(crate) fn of_search(
    search: &Guided,
    program: &Program,
    target: &Predicate,
    sink: &dyn ProgressSink,
) -> Result<Option<Policy>> {
    if search.answer() != Some(true) {
        return Ok(None);
    }
    checked(Policy::of_search(search, program, MOST_STATES)?, program, target, sink).map(Some)
}

/// Checks a policy state by state, from the initial states, by the code of certificates.
fn checked(found: Policy, program: &Program, goal: &Predicate, sink: &dyn ProgressSink) -> Result<Policy> {
    let mut rules = Rules::default();
    for PolicyEntry { state, action, position, .. } in &found.entries {
        rules.add_state(state, Taken { action: action.clone(), position: *position });
    }
    match rules.check(program, goal, &found.initial, false, sink)? {
        Ok(_) => Ok(found),
        Err(fault) => Err(Error::Usage(format!("{}: {}", fault.kind, program.show_state(&fault.state)))),
    }
}

/// Returns whether a strong plan for a target exists from all initial states, and the number of states with one.
///
/// # Errors
/// A limit is reached.
pub(crate) fn strong<E: Engine>(engine: &E, target: &Predicate) -> Result<(bool, Number)> {
    let region = strong_region(engine, &engine.states_where(target)?)?;
    let outside = engine.difference(&engine.initial_states(), &region)?;
    Ok((engine.is_empty(&outside)?, Number::from(engine.count(&region)?)))
}

/// The strategies of one operator that are asked for.
#[derive(Default)]
pub(crate) struct Optimal {
    /// The strategy of the only property, and that of the opponent; `None` where no strategy satisfies the property, or has
    /// a finite value.
    pub(crate) both: [Option<PropertyPolicy>; 2],
    /// The number that the operator asks for in each initial state, once our strategy is found.
    pub(crate) optima: Option<Vec<evaluate::Number>>,
}

/// Returns the formula of a property for a probability, if its request has monitors.
fn watched_path<'p>(property: &'p Planned, requests: &[Request]) -> Option<&'p Path> {
    let (at, (_, term)) = (property.request()?, property.stated.as_ref()?);
    let TermKind::Operator(measured) = &term.kind else { return None };
    let Measure::Probability(path) = &measured.measure else { return None };
    requests[at].asking.goal.watched.is_some().then_some(&**path)
}

/// Returns whether a property is one operator that is answered over the states of the model as well, although its request has
/// monitors.
pub(crate) fn needs_no_monitors(property: &Planned, requests: &[Request]) -> bool {
    watched_path(property, requests).is_some_and(|path| path.single.is_some())
}

/// Returns the goal with monitors whose states the strategy of the only property needs, if it is the only one of some
/// requests.
pub(crate) fn watched_goal<'q>(asked: &'q Questions, requests: &[usize]) -> Option<&'q PathGoal> {
    let ([property], [only]) = (&asked.plan.properties[..], requests) else { return None };
    let path = watched_path(property, &asked.plan.requests)?;
    let is_own = property.request() == Some(*only) && path.single.is_none();
    is_own.then_some(&asked.plan.requests[*only].asking.goal)
}

/// Returns whether some requests are answered in the states that a strategy of the only property needs, if one is wanted.
pub(crate) fn has_states(asked: &Questions, options: &Options, requests: &[usize]) -> bool {
    let is_plain = |at: &usize| asked.plan.requests[*at].asking.goal.watched.is_none();
    let has_all = || requests.iter().all(is_plain) || watched_goal(asked, requests).is_some();
    asked.wants_optimal(options.strategies) && has_all()
}

/// Returns the warning about a strategy that does not attain the optimum.
pub(crate) fn missed(found: &PropertyPolicy) -> String {
    format!(
        "the strategy attains {}, and the optimum is {}: no strategy was found that is closer",
        readable(found.value.interval.middle()),
        readable(found.optimum.middle()),
    )
}

/// Computes the strategy of the only property, and that of the opponent, as they are asked for. The engine is that of the
/// model, or of a goal with monitors.
///
/// # Errors
/// The property has no strategy of this kind; a limit is reached.
pub(crate) fn optimal(
    asked: &Questions,
    (engine, goal): (&Arc<ExplicitEngine>, Option<&PathGoal>),
    options: &Options,
) -> Result<Optimal> {
    let build = |program: &Arc<Program>| {
        ExplicitEngine::new(Arc::clone(program), engine.settings().clone()).map(Arc::new)
    };
    let [Planned { stated: Some((source, term)), .. }] = &asked.plan.properties[..] else {
        return Err(Error::Usage("`--policy` is about one property".to_owned()));
    };
    let model = Model::new(&**engine, &asked.program, &build, options.precision).under(&asked.required);
    let model = model.watched(goal);
    let evaluator = Evaluator::new(&model, source);
    let mut optima = None;
    let mut find = |is_wanted: bool, of_opponent: bool| -> Result<Option<PropertyPolicy>> {
        if !is_wanted {
            return Ok(None);
        }
        let played = evaluator.played_by(term, of_opponent)?;
        let found = evaluator.policy(&played, of_opponent)?;
        if !of_opponent {
            optima = Some(found.optima.clone());
        }
        let is_lost = !found.is_great && found.value.interval.lower.is_infinite();
        Ok(Some(found).filter(|found| !is_lost && played.satisfies(&found.value) != Some(false)))
    };
    let both = [find(options.strategies.policy, false)?, find(options.strategies.opponent, true)?];
    Ok(Optimal { both, optima })
}
