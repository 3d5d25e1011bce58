//! Questions about a model, the options of their answers, and the strategies that are wanted, too.

use std::sync::Arc;

use crate::evaluate::Mix;
use crate::goal::{Required, Target};
use crate::plan::Plan;
use crate::warnings;
use meliora_base::error::{Error, Result};
use meliora_engine::{Selection, Settings};
use meliora_lang::property::term::TermKind;
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_planning::policy::Policy;

/// Questions about a model, with the requests that they need.
pub struct Questions {
    /// The model.
    pub program: Arc<Program>,
    /// The questions, and the requests.
    pub plan: Plan,
    /// The requirements.
    pub required: Vec<Required>,
    /// True if a question without an answer leaves the others: those of a file, or of the model.
    pub is_list: bool,
    /// For a `dtmc`, the states in which several choices are merged into one.
    pub overlap: Option<Predicate>,
}

/// The options of answers.
pub struct Options {
    /// The settings of the engines.
    pub settings: Settings,
    /// The engine.
    pub selected: Selection,
    /// The largest width of a number; see [`crate::evaluate::Model::new`].
    pub precision: f64,
    /// True for one question, an error of which ends the work.
    pub is_one: bool,
    /// The regions of all properties are wanted.
    pub regions: bool,
    /// The strategies that are wanted of the only question.
    pub strategies: WantedStrategies,
}

/// The strategies that are wanted.
#[derive(Debug, Clone, Copy, Default)]
pub struct WantedStrategies {
    /// The states with a strong plan.
    pub strong: bool,
    /// A policy for the target, or the strategies of `multi`.
    pub policy: bool,
}

/// The strategies that were found.
#[derive(Debug, Default)]
pub struct Strategies {
    /// A policy that reaches the target almost surely from all initial states; `None` if there is none.
    pub policy: Option<Policy>,
    /// The strategies that show the answer about several objectives; `None` if these are not asked for.
    pub mix: Option<Mix>,
}

impl Questions {
    /// Combines a model with questions about it; errors in one of a list leave the others.
    pub fn new(mut program: Program, plan: Plan, required: Vec<Required>, is_list: bool) -> Self {
        program.note_inexact(plan.requests.iter().flat_map(|request| request.asking.goal.predicates()));
        let overlap = warnings::overlap(&program);
        Questions { program: Arc::new(program), plan, required, is_list, overlap }
    }

    /// Checks that the only question has the strategies that are wanted.
    ///
    /// # Errors
    /// [`Error::Usage`].
    pub fn check(&self, wanted: WantedStrategies) -> Result<()> {
        let wrong = |message: &str| Err(Error::Usage(message.to_owned()));
        if !wanted.strong && (!wanted.policy || self.is_multi()) {
            return Ok(());
        }
        let only = self.plan.properties.first().filter(|_| self.plan.properties.len() == 1);
        let of_target =
            only.and_then(|only| only.request()).map(|request| &self.plan.requests[request].asking);
        if !of_target.is_some_and(|asking| matches!(asking.goal.target, Target::States(_))) {
            return wrong("policies and strong plans are about reaching a target, not about other formulas");
        }
        if self.program.players.is_some() {
            return wrong(
                "policies and strong plans for a target are about models with one player; in a game, `strategy` \
                 without `--policy` lists the actions",
            );
        }
        if !self.required.is_empty() {
            return wrong("policies and strong plans for a target do not keep requirements: leave these out");
        }
        Ok(())
    }

    /// Returns the text of the only property.
    pub fn text(&self) -> String {
        let stated = self.plan.properties.first().and_then(|only| only.stated.as_ref());
        stated.map(|(source, term)| source.on_one_line(term.span.range())).unwrap_or_default()
    }

    /// Returns whether the only question is about several objectives at once.
    pub fn is_multi(&self) -> bool {
        let [only] = &self.plan.properties[..] else { return false };
        matches!(&only.stated, Some((_, term)) if matches!(term.kind, TermKind::Multi(_)))
    }
}
