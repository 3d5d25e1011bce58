//! Evaluates properties that are not one request, over all states of one engine.

use std::sync::Arc;

use ahash::AHashMap;
use meliora_base::error::{Diagnostic, Error, Severity};
use meliora_engine::symbolic::StateSet;
use meliora_engine::{Engine, SymbolicEngine};
use meliora_lang::property::term::Term;
use meliora_lang::refusal::Refusal;
use meliora_model::valuation::Valuation;
use meliora_model::{Program, State};
use meliora_quantities::state_values::Bound;
use meliora_question::evaluate::{Build, Evaluator, Found, Mix, Model, Number, StateValue};
use meliora_question::{Goal, Under};
use meliora_report::mix::{self, Mixed};
use meliora_report::properties::ListedState;

use super::answers::Answering;
use super::shares::Shares;

/// Does more with a property that was evaluated.
type Further<'f, E> = dyn FnMut(&Evaluator<'_, '_, E>, usize, &Term) -> Result<(), Error> + 'f;

impl Answering<'_> {
    /// Evaluates properties over all states, unless their requests decide them. Returns the strategies of `multi`, if
    /// they are asked for.
    ///
    /// # Errors
    /// A limit is hit, or the only property cannot be answered.
    pub(super) fn rest<E: Engine>(
        &self,
        engine: &Arc<E>,
        build: &Build<'_, E>,
        properties: &[usize],
        mix: bool,
    ) -> Result<Option<String>, Error> {
        let is_open =
            |at: &usize| self.asked.plan.holds(&self.asked.program, *at, &self.known.borrow()).is_none();
        let open: Vec<usize> = properties.iter().copied().filter(is_open).collect();
        let mut strategies = None;
        self.evaluated(engine, build, &open, &mut |evaluator, _, term| {
            if mix {
                let find = || mixed(evaluator, term, &self.asked.program);
                strategies = self.job.timed("policy", find, |r, s| r.time.add("policy", s))?;
            }
            Ok(())
        })?;
        Ok(strategies)
    }

    /// Evaluates the properties that are not one request, and returns the states that satisfy each condition.
    ///
    /// # Errors
    /// A limit is hit; the only property is a number or cannot be answered.
    pub(super) fn satisfied(
        &self,
        engine: &Arc<SymbolicEngine>,
        build: &Build<'_, SymbolicEngine>,
        found: &mut dyn FnMut(usize, StateSet),
    ) -> Result<(), Error> {
        let plan = &self.asked.plan;
        let others = (0..plan.properties.len()).filter(|&at| plan.properties[at].request().is_none());
        let others = Vec::from_iter(others);
        self.evaluated(engine, build, &others, &mut |evaluator, at, term| {
            match evaluator.satisfied(term)? {
                Some(states) => found(at, states),
                None => {
                    let text = evaluator.text(term);
                    let message = format!(
                        "`--out` writes sets of states, and `{text}` is a number; `filter(printall, …)` lists its \
                         values"
                    );
                    if self.given.is_one {
                        return Err(Error::Usage(message));
                    }
                    self.job.sink.warn(&message);
                }
            }
            Ok(())
        })
    }

    /// Evaluates properties with one engine. One without an answer leaves the others of a list.
    fn evaluated<E: Engine>(
        &self,
        engine: &Arc<E>,
        build: &Build<'_, E>,
        properties: &[usize],
        further: &mut Further<'_, E>,
    ) -> Result<(), Error> {
        if properties.is_empty() {
            return Ok(());
        }
        let program = &self.asked.program;
        if !self.asked.plan.is_plain {
            return properties.iter().try_for_each(|&at| self.refuse_mixed(at));
        }
        let goal = Goal::reach(program, program.predicate(program.initial), &self.asked.required)?;
        let under = Under::new(&**engine, program, &goal)?;
        self.counted(&**engine, &under, &goal)?;
        let model = Model::new(under.engine(), program, build, self.given.precision);
        let model = model.under(&self.asked.required);
        let mut shares = Shares::of(&self.job.sink, properties.len());
        let mut known = AHashMap::new();
        for &at in properties {
            let property = &self.asked.plan.properties[at];
            let same = known.insert(&property.text, property.position);
            if let Some(same) = same.filter(|_| self.given.out.is_none()) {
                self.job.update(|r| {
                    let same = r.properties[same].clone();
                    r.properties[property.position].take(same);
                });
                shares.next(|| Ok(()))?.ok();
                continue;
            }
            let (position, Some((source, term))) = (property.position, &property.stated) else { continue };
            if let Some(answer) = under.lost(!term.is_condition()) {
                self.job.update(|r| r.answer(position, &answer));
                continue;
            }
            let evaluator = Evaluator::new(&model, source);
            let answer = || shares.next(|| evaluator.answer(term));
            let found = self.job.timed("value", answer, |r, s| r.time.add("value", s));
            if let Ok(Ok(_)) = found {
                further(&evaluator, at, term)?;
            }
            match found {
                Ok(Ok(found)) => self.found(position, under.engine(), found)?,
                Ok(Err(reason)) => self.job.update(|r| r.properties[position].reason = Some(reason)),
                Err(error) if !self.given.is_one && !matches!(error, Error::Limit(_)) => {
                    self.refused(position, &error);
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Refuses a property whose requests have answers that differ from one initial state to another, where the states of
    /// the model do not know the requirements.
    ///
    /// # Errors
    /// It is the only property.
    fn refuse_mixed(&self, at: usize) -> Result<(), Error> {
        let property = &self.asked.plan.properties[at];
        let Some((source, term)) = &property.stated else { return Ok(()) };
        let message = "the initial states differ in the answers to the operators of this property, and under these \
                       requirements each operator is answered for all of them together";
        let wrong = Diagnostic::new(source, term.span.range(), message).severity(Severity::Unsupported);
        let error = Error::from(wrong.help("ask for each operator alone"));
        if self.given.is_one {
            return Err(error);
        }
        self.refused(property.position, &error);
        Ok(())
    }

    /// Notes in the report that a property has no answer.
    fn refused(&self, position: usize, error: &Error) {
        let Refusal { reason, place } = Refusal::of(error);
        self.job.update(|r| {
            let answer = &mut r.properties[position];
            answer.reason = Some(reason);
            (answer.line, answer.column) = place.unzip();
        });
    }

    /// Adds the answer to a property to the report.
    fn found<E: Engine>(&self, position: usize, engine: &E, found: Found<E::States>) -> Result<(), Error> {
        for (which, states) in &found.regions {
            self.size(engine, &[position], (*which, states))?;
        }
        let listed = |(state, value): (State, StateValue)| {
            let state = Valuation::of(&self.asked.program, &state);
            match value {
                StateValue::Holds(holds) => ListedState { state, holds: Some(holds), value: None },
                StateValue::Number(number) => ListedState { state, holds: None, value: Some(bound(&number)) },
            }
        };
        self.job.update(|r| {
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

fn bound(number: &Number) -> Bound {
    Bound { lower: number.lower, upper: number.upper, exact: None }
}
