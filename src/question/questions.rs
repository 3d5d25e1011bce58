//! Questions about a model, the options of their answers, and the strategies that are wanted, too.

use std::sync::Arc;

use crate::evaluate::Mix;
use crate::goal::Required;
use crate::plan::Plan;
use meliora_engine::{Selection, Settings};
use meliora_lang::property::term::TermKind;
use meliora_model::predicate::Predicate;
use meliora_model::{ModelKind, Program};
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
    pub strategies: Wanted,
}

/// The strategies that are wanted.
#[derive(Debug, Clone, Copy, Default)]
pub struct Wanted {
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
        let overlap = (program.kind == ModelKind::Dtmc).then(|| program.overlap());
        Questions { program: Arc::new(program), plan, required, is_list, overlap }
    }

    /// Returns whether the only question is about several objectives at once.
    pub fn is_multi(&self) -> bool {
        let [only] = &self.plan.properties[..] else { return false };
        matches!(&only.stated, Some((_, term)) if matches!(term.kind, TermKind::Multi(_)))
    }
}
