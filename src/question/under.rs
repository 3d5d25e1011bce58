//! Questions about the strategies that keep requirements.

use std::sync::Arc;

use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_engine::regions::Regions;
use meliora_lang::property::PropertyKind;
use meliora_model::Program;
use meliora_planning::Requirements;
use meliora_planning::result::{Escape, ModelCounts};

use crate::answer::{Answer, Computing};
use crate::asking::Asking;
use crate::goal::PathGoal;

/// The reason why a quantity has no value.
const UNSAFE: &str = "no strategy keeps the requirements from some initial state";

/// A model under requirements.
pub struct Under<'a, E: Engine> {
    whole: &'a E,
    restricted: Option<(E, Requirements<E>)>,
    /// A path from the first unsafe initial state to a violation.
    pub escape: Option<Escape>,
}

impl<'a, E: Engine> Under<'a, E> {
    /// Restricts a model by the requirements of a goal; `engine` is that of [`PathGoal::program`].
    ///
    /// # Errors
    /// A limit is reached, or a requirement has no value in some state.
    pub fn new(engine: &'a E, model: &Arc<Program>, goal: &PathGoal) -> Result<Self> {
        let restricted = Requirements::restrict(engine, &goal.requirements)?;
        let mut escape = None;
        if let Some((_, requirements)) = &restricted {
            let initial = engine.intersection(&engine.initial_states(), &requirements.unsafe_states)?;
            if let Some(start) = engine.list_states(&initial, 1)?.pop() {
                escape = requirements.escape(engine, goal.program(model), &goal.requirements, &start)?;
            }
        }
        Ok(Under { whole: engine, restricted, escape })
    }

    /// Returns the engine of the model that the requirements leave.
    pub fn engine(&self) -> &E {
        self.restricted.as_ref().map_or(self.whole, |(engine, _)| engine)
    }

    /// Returns the states from which no strategy keeps the requirements; `None` without requirements.
    pub fn unsafe_states(&self) -> Option<&E::States> {
        self.restricted.as_ref().map(|(_, requirements)| &requirements.unsafe_states)
    }

    /// Counts the judged states of the whole model.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn counts(&self, goal: &PathGoal) -> Result<ModelCounts> {
        let judged = goal.judged(self.whole)?;
        let unsafe_states = match &self.restricted {
            None => None,
            Some((_, r)) => Some(self.whole.count(&self.whole.intersection(&judged, &r.unsafe_states)?)?),
        };
        Ok(ModelCounts { unsafe_states, ..ModelCounts::within(self.whole, &judged)? })
    }

    /// Answers a property. If no strategy keeps the requirements initially, a property that holds or
    /// not does not hold, and a quantity has no value.
    ///
    /// # Errors
    /// The errors of [`Asking::answered`].
    pub fn answer(
        &self,
        asking: &Asking,
        model: &Arc<Program>,
        regions: &Regions<Option<E::States>>,
        computing: &Computing<'_>,
    ) -> Result<Answer> {
        match self.unsafe_answer(asking) {
            Some(answer) => Ok(answer),
            None => asking.answered(self.engine(), model, regions, computing),
        }
    }

    /// Answers a property as far as the known regions decide it.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn decided(&self, asking: &Asking, known: &Regions<Option<E::States>>) -> Result<Answer> {
        match self.unsafe_answer(asking) {
            Some(answer) => Ok(answer),
            None => asking.decided(self.engine(), known),
        }
    }

    /// Returns the answer to a property if no strategy keeps the requirements initially.
    fn unsafe_answer(&self, asking: &Asking) -> Option<Answer> {
        let asks_for_value = |question: &PropertyKind| match question {
            PropertyKind::Qualitative(..) => false,
            PropertyKind::Quantity(quantity) => quantity.bound.is_none(),
        };
        match &asking.question {
            None => self.escape.as_ref().map(|_| Answer::of(None)),
            Some(question) => self.lost(asks_for_value(question)),
        }
    }

    /// Returns the answer to a condition, or to a number, if no strategy keeps the requirements initially.
    pub fn lost(&self, is_number: bool) -> Option<Answer> {
        self.escape.as_ref()?;
        Some(if is_number { Answer::without_value(UNSAFE) } else { Answer::of(Some(false)) })
    }
}
