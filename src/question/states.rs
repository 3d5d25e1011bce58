//! Evaluates properties that are not one request, over all states of one engine.

use std::sync::Arc;

use ahash::AHashMap;

use crate::answering::Answering;
use crate::answers::ListedState;
use crate::evaluate::{Build, Evaluator, Mix, Model, PropertyResult, StateValue};
use crate::goal::PathGoal;
use crate::listener::Shares;
use crate::plan::Planned;
use crate::under::Under;
use crate::warnings::Warning;
use meliora_base::error::{Diagnostic, Error, Result, Severity};
use meliora_engine::symbolic::StateSet;
use meliora_engine::{Engine, SymbolicEngine};
use meliora_lang::property::term::Term;
use meliora_lang::refusal::Refusal;
use meliora_model::State;
use meliora_model::valuation::Valuation;

/// Does more with a property that was evaluated.
type Further<'f, E> = dyn FnMut(&Evaluator<'_, '_, E>, usize, &Term) -> Result<()> + 'f;

impl Answering<'_> {
    /// Evaluates properties over all states, unless their requests decide them. Returns the strategies of `multi`, if
    /// they are asked for.
    ///
    /// # Errors
    /// A limit is hit, or the only property cannot be answered.
    pub(crate) fn rest<E: Engine>(
        &self,
        engine: &Arc<E>,
        build: &Build<'_, E>,
        properties: &[usize],
        mix: bool,
    ) -> Result<Option<Mix>> {
        let is_open =
            |at: &usize| self.asked.plan.holds(&self.asked.program, *at, &self.known.borrow()).is_none();
        let open: Vec<usize> = properties.iter().copied().filter(is_open).collect();
        let mut strategies = None;
        self.evaluated(engine, build, &open, &mut |evaluator, _, term| {
            if mix {
                strategies = Some(self.listener.timed(("policy", "policy"), || evaluator.mix(term))?);
            }
            Ok(())
        })?;
        Ok(strategies)
    }

    /// Evaluates the properties that are not one request, and returns the states that satisfy each condition.
    ///
    /// # Errors
    /// A limit is hit; the only property is a number or cannot be answered.
    pub(crate) fn satisfied(
        &self,
        engine: &Arc<SymbolicEngine>,
        build: &Build<'_, SymbolicEngine>,
        found: &mut dyn FnMut(usize, StateSet),
    ) -> Result<()> {
        let plan = &self.asked.plan;
        let others = (0..plan.properties.len()).filter(|&at| plan.properties[at].request().is_none());
        let others = Vec::from_iter(others);
        self.evaluated(engine, build, &others, &mut |evaluator, at, term| {
            match evaluator.satisfied(term)? {
                Some(states) => found(at, states),
                None => {
                    let text = evaluator.text(term);
                    let message = format!(
                        "only sets of states are regions, and `{text}` is a number; `filter(printall, …)` lists its \
                         values"
                    );
                    if self.options.is_one {
                        return Err(Error::Usage(message));
                    }
                    self.listener.warn(Warning::Text(message));
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
    ) -> Result<()> {
        if properties.is_empty() {
            return Ok(());
        }
        let program = &self.asked.program;
        if !self.asked.plan.is_plain {
            return properties.iter().try_for_each(|&at| self.refuse_mixed(at));
        }
        let goal = PathGoal::reach(program, program.predicate(program.initial), &self.asked.required)?;
        let under = Under::new(&**engine, program, &goal)?;
        self.counted(&**engine, &under, &goal)?;
        let optima = self.optima.and_then(|find| find());
        let model = Model::new(under.engine(), program, build, self.options.precision);
        let mut model = model.under(&self.asked.required);
        if let [Planned { stated: Some((_, term)), .. }] = &self.asked.plan.properties[..] {
            model = model.knowing(term, optima.as_deref());
        }
        let mut shares = Shares::of(self.listener, properties.len());
        let mut known = AHashMap::new();
        let last = properties.last();
        for at in properties {
            let is_last = last == Some(at);
            let (at, property) = (*at, &self.asked.plan.properties[*at]);
            let same = known.insert(&property.text, property.position);
            if let Some(same) = same.filter(|_| !self.options.regions) {
                self.listener.update(|r| {
                    let same = r.properties[same].clone();
                    r.properties[property.position].take(same);
                });
                shares.next(|| Ok(()))?.ok();
                continue;
            }
            let (position, Some((source, term))) = (property.position, &property.stated) else { continue };
            if let Some(answer) = under.lost(!term.is_condition()) {
                self.listener.update(|r| r.answer(position, &answer));
                continue;
            }
            let evaluator = Evaluator::new(&model, source).last(is_last);
            let answer = || shares.next(|| evaluator.answer(term));
            let found = self.listener.timed(("value", "value"), answer);
            if let Ok(Ok(_)) = found {
                further(&evaluator, at, term)?;
            }
            match found {
                Ok(Ok(found)) => self.found(position, under.engine(), found)?,
                Ok(Err(reason)) => self.listener.update(|r| r.properties[position].reason = Some(reason)),
                Err(error) if !self.options.is_one && !matches!(error, Error::Limit(_)) => {
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
    fn refuse_mixed(&self, at: usize) -> Result<()> {
        let property = &self.asked.plan.properties[at];
        let Some((source, term)) = &property.stated else { return Ok(()) };
        let message = "the initial states differ in the answers to the operators of this property, and under these \
                       requirements each operator is answered for all of them together";
        let wrong = Diagnostic::new(source, term.span.range(), message).severity(Severity::Unsupported);
        let error = Error::from(wrong.help("ask for each operator alone"));
        if self.options.is_one {
            return Err(error);
        }
        self.refused(property.position, &error);
        Ok(())
    }

    /// Notes in the report that a property has no answer.
    fn refused(&self, position: usize, error: &Error) {
        let Refusal { reason, place } = Refusal::new(error);
        self.listener.update(|r| {
            let answer = &mut r.properties[position];
            answer.reason = Some(reason);
            (answer.line, answer.column) = place.unzip();
        });
    }

    /// Adds the answer to a property to the report.
    fn found<E: Engine>(&self, position: usize, engine: &E, found: PropertyResult<E::States>) -> Result<()> {
        for (which, states) in &found.regions {
            self.size(engine, &[position], (*which, states))?;
        }
        let listed = |(state, value): (State, StateValue)| {
            let state = Valuation::new(&self.asked.program, &state);
            match value {
                StateValue::Holds(holds) => ListedState { state, holds: Some(holds), value: None },
                StateValue::Number(number) => {
                    ListedState { state, holds: None, value: Some(number.interval.into()) }
                }
            }
        };
        self.listener.update(|r| {
            let answer = &mut r.properties[position];
            answer.holds = found.holds;
            answer.value = found.value.as_ref().map(|number| Some(number.interval.into()));
            answer.front = found.front;
            answer.values = found.values.map(|all| all.into_iter().map(listed).collect());
            if let Some(one) = &mut r.one {
                one.holds = found.holds;
            }
        });
        self.listener.used(engine.usage());
        Ok(())
    }
}
