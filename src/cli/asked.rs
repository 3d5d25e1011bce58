//! Questions about a model, as they are read.

use std::sync::Arc;

use meliora::reach::{Asking, Required};
use meliora_base::error::SourceFile;
use meliora_lang::property::Term;
use meliora_model::Program;
use meliora_model::predicate::Predicate;

/// The question of a planning problem: whether a strong cyclic plan exists.
pub(super) const GOAL: &str = "Pmax>=1 [ F \"goal\" ]";

/// The refusal of a question that means the goal of a problem without one.
pub(super) const NO_GOAL: &str = "this problem has preferences and no goal that must hold: `--target EXPR` gives one, and `check` judges the preferences";

/// A model with questions about it.
pub(super) struct Asked {
    /// The model.
    pub(super) program: Arc<Program>,
    /// The questions that are one operator, in the order of the command line.
    pub(super) questions: Vec<Stated>,
    /// The other properties.
    pub(super) terms: Vec<StatedTerm>,
    /// The requirements, which the other properties keep.
    pub(super) required: Vec<Required>,
    /// True if a question without an answer leaves the others: those of a file, or of the model.
    pub(super) is_list: bool,
    /// See [`super::load::Loaded::overlap`].
    pub(super) overlap: Option<Predicate>,
}

impl Stated {
    /// Returns whether this is the question of a planning problem.
    pub(super) fn is_goal(&self, program: &Program) -> bool {
        program.planning.is_some() && self.text == GOAL
    }
}

impl Asked {
    pub(super) fn new(
        mut program: Program,
        questions: Vec<Stated>,
        is_list: bool,
        overlap: Option<Predicate>,
    ) -> Self {
        note_inexact(&mut program, questions.iter().flat_map(|q| q.asking.goal.predicates()));
        Asked {
            program: Arc::new(program),
            questions,
            terms: Vec::new(),
            required: Vec::new(),
            is_list,
            overlap,
        }
    }
}

/// A property that is an expression over states, with its text.
pub(super) struct StatedTerm {
    /// The position in the report.
    pub(super) position: usize,
    /// The text that it points into.
    pub(super) source: Arc<SourceFile>,
    /// The property.
    pub(super) term: Term,
}

/// A question with its text.
pub(super) struct Stated {
    /// The position in the report.
    pub(super) position: usize,
    /// The text.
    pub(super) text: String,
    /// The question.
    pub(super) asking: Asking,
}

/// Lets reports name an expression of the conditions that is not exact, if all of the model are.
pub(super) fn note_inexact<'p>(program: &mut Program, mut conditions: impl Iterator<Item = &'p Predicate>) {
    if program.inexact.is_none() {
        program.inexact = conditions.find_map(Predicate::inexact).cloned();
    }
}
