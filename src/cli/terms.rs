//! Answers the properties of `meliora reach` that are expressions over states.

use std::sync::Arc;

use meliora::reach::evaluate::{Build, Evaluator, Found, Mix, Model, Number, StateValue};
use meliora::reach::{Goal, Under};
use meliora_base::error::Error;
use meliora_engine::symbolic::StateSet;
use meliora_engine::{AnyEngine, Engine, Selection, SymbolicEngine};
use meliora_lang::property::term::{Term, TermKind};
use meliora_lang::refusal::Refusal;
use meliora_model::valuation::Valuation;
use meliora_model::{Program, State};
use meliora_quantities::state_values::Bound;
use meliora_report::ReachReport;
use meliora_report::mix::{self, Mixed};
use meliora_report::properties::ListedState;
use meliora_report::reach::Share;

use super::asked::{Asked, StatedTerm};
use super::engines::{self, Early, Request};
use super::files::Target;
use super::given::Given;
use super::shares::Shares;
use super::supervise::Job;

/// Answers all of them with one engine. A property without an answer leaves the others of a file.
///
/// # Errors
/// A limit is hit, or the only property cannot be answered.
pub(super) fn work(
    job: &Job<ReachReport>,
    given: &Given<'_>,
    selected: &Selection,
    asked: &Asked,
) -> Result<(), Error> {
    if asked.terms.is_empty() {
        return Ok(());
    }
    let target = mix(given, asked)?;
    let answer = |job: &Job<ReachReport>, engine: &Arc<AnyEngine>| {
        let build = |program: &Arc<Program>| {
            let build = || engines::like(engine, program);
            job.timed("build", build, |r, s| r.time.add("build", s))
        };
        let mut strategies = None;
        answered(job, given, engine, &build, asked, &mut |evaluator, stated| {
            if target.is_some() {
                let find = || mixed(evaluator, &stated.term, &asked.program);
                strategies = job.timed("policy", find, |r, s| r.time.add("policy", s))?;
            }
            Ok(())
        })?;
        Ok(strategies)
    };
    let (program, args, selected, early) = (&asked.program, given.model, selected.clone(), Early::default());
    let request = Request { program, args, selected, lists_states: true, early, answer: &answer };
    match (engines::raced(job, &request)?, target) {
        (Some(strategies), Some(target)) => target.write(&strategies),
        (None, Some(_)) => {
            job.sink.warn("no strategies are written: none satisfies the bounds");
            Ok(())
        }
        _ => Ok(()),
    }
}

/// Answers all of them with an engine of diagrams, and returns the states that satisfy each condition, by its position
/// in the report.
///
/// # Errors
/// A limit is hit; the only property is a number or cannot be answered.
pub(super) fn satisfied(
    job: &Job<ReachReport>,
    given: &Given<'_>,
    engine: &Arc<SymbolicEngine>,
    asked: &Asked,
) -> Result<Vec<(usize, StateSet)>, Error> {
    if asked.terms.is_empty() {
        return Ok(Vec::new());
    }
    let build = |program: &Arc<Program>| {
        job.timed(
            "build",
            || engines::symbolic(program, given.model, &job.sink),
            |r, s| r.time.add("build", s),
        )
    };
    let mut found = Vec::new();
    answered(job, given, engine, &build, asked, &mut |evaluator, stated| {
        match evaluator.satisfied(&stated.term)? {
            Some(states) => found.push((stated.position, states)),
            None => {
                let text = evaluator.text(&stated.term);
                let message = format!(
                    "`--out` writes sets of states, and `{text}` is a number; `filter(printall, …)` lists its values"
                );
                if given.is_one {
                    return Err(Error::Usage(message));
                }
                job.sink.warn(&message);
            }
        }
        Ok(())
    })?;
    Ok(found)
}

/// Does more with a property that was answered.
type Further<'f, E> = dyn FnMut(&Evaluator<'_, '_, E>, &StatedTerm) -> Result<(), Error> + 'f;

fn answered<E: Engine>(
    job: &Job<ReachReport>,
    given: &Given<'_>,
    engine: &Arc<E>,
    build: &Build<'_, E>,
    asked: &Asked,
    further: &mut Further<'_, E>,
) -> Result<(), Error> {
    let initial = asked.program.predicate(asked.program.initial);
    let goal = Goal::reach(&asked.program, initial, &asked.required)?;
    let under = Under::new(&**engine, &asked.program, &goal)?;
    counted(job, &**engine, &under, &goal, asked)?;
    let model = Model::new(under.engine(), &asked.program, build, given.precision).under(&asked.required);
    let mut shares = Shares::of(&job.sink, asked.terms.len());
    for stated in &asked.terms {
        let StatedTerm { position, source, term } = stated;
        if let Some(answer) = under.lost(!term.is_condition()) {
            job.update(|r| r.answer(*position, &answer));
            continue;
        }
        let evaluator = Evaluator::new(&model, source);
        let answer = || shares.next(|| evaluator.answer(term));
        let found = job.timed("value", answer, |r, s| r.time.add("value", s));
        if let Ok(Ok(_)) = found {
            further(&evaluator, stated)?;
        }
        match found {
            Ok(Ok(found)) => note(job, given.is_one, *position, (under.engine(), &asked.program), found)?,
            Ok(Err(reason)) => job.update(|r| r.properties[*position].reason = Some(reason)),
            Err(error) if !given.is_one && !matches!(error, Error::Limit(_)) => {
                let Refusal { reason, place } = Refusal::of(&error);
                job.update(|r| {
                    let answer = &mut r.properties[*position];
                    answer.reason = Some(reason);
                    (answer.line, answer.column) = place.unzip();
                });
            }
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

/// Returns the file of `--policy`, for the strategies of one property `multi(…)`.
///
/// # Errors
/// The options are about other questions.
fn mix<'t>(given: &Given<'t>, asked: &Asked) -> Result<Option<&'t Target>, Error> {
    let Some((plan, target)) = given.plan else { return Ok(None) };
    let is_mix = asked.terms.iter().any(|stated| matches!(stated.term.kind, TermKind::Multi(_)));
    match (is_mix && !plan.strong, target) {
        (true, Some(target)) if plan.is_json() || target.is_stdout() => Ok(Some(target)),
        (true, _) => Err(Error::Usage(
            "the strategies of `multi` are written as JSON: give `--policy` a name that ends with .json"
                .to_owned(),
        )),
        (false, _) => Err(Error::Usage(
            "`--strong` and `--policy` are about reaching a target, not about other formulas".to_owned(),
        )),
    }
}

/// Returns the strategies that show the answer as JSON; `None` if there are none.
fn mixed<E: Engine>(
    evaluator: &Evaluator<'_, '_, E>,
    term: &Term,
    program: &Program,
) -> Result<Option<String>, Error> {
    let Mix { strategies: found, great } = evaluator.mix(term)?;
    if found.is_empty() {
        return Ok(None);
    }
    let mixed = found.iter().map(|own| Mixed {
        share: own.share.as_ref(),
        values: &own.values,
        nodes: &own.nodes,
        great: &great,
    });
    let text = evaluator.text(term);
    Ok(Some(mix::json(&text, &mixed.collect::<Vec<_>>(), program)? + "\n"))
}

/// Counts the states, unless another question has done so.
fn counted<E: Engine>(
    job: &Job<ReachReport>,
    engine: &E,
    under: &Under<'_, E>,
    goal: &Goal,
    asked: &Asked,
) -> Result<(), Error> {
    let mut known = false;
    job.update(|r| known = r.counts.is_some());
    if known {
        return Ok(());
    }
    let counts = job.timed("count", || under.counts(goal), |r, s| r.time.add("build", s))?;
    engines::warn_of_states(&job.sink, engine, &asked.program, &counts.deadlocks, asked.overlap.as_ref())?;
    job.update(|r| (r.counts, r.escape) = (Some(counts), under.escape.clone()));
    Ok(())
}

/// Adds the answer to the report.
fn note<E: Engine>(
    job: &Job<ReachReport>,
    is_one: bool,
    position: usize,
    (engine, program): (&E, &Program),
    found: Found<E::States>,
) -> Result<(), Error> {
    for (which, states) in &found.regions {
        let size = engine.count(states)?;
        let share = is_one.then(|| Share::of_initial(engine, states)).transpose()?;
        job.update(|r| {
            if let Some(one) = &mut r.one {
                *one.sizes.get_mut(*which) = Some(size.clone().into());
                *one.initial.get_mut(*which) = share;
            }
            *r.properties[position].sizes.get_mut(*which) = Some(size.clone().into());
        });
    }
    let listed = |(state, value): (State, StateValue)| {
        let state = Valuation::of(program, &state);
        match value {
            StateValue::Holds(holds) => ListedState { state, holds: Some(holds), value: None },
            StateValue::Number(number) => ListedState { state, holds: None, value: Some(bound(&number)) },
        }
    };
    job.update(|r| {
        let answer = &mut r.properties[position];
        answer.holds = found.holds;
        answer.value = found.value.as_ref().map(|number| Some(bound(number)));
        answer.front = found.front;
        answer.values = found.values.map(|all| all.into_iter().map(listed).collect());
        if let Some(one) = &mut r.one {
            one.holds = found.holds;
        }
        r.used(engine.usage());
    });
    Ok(())
}

fn bound(number: &Number) -> Bound {
    Bound { lower: number.lower, upper: number.upper, exact: None }
}
