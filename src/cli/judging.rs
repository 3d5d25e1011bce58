//! Answers to a question about the initial states alone, which counts no states.

use std::sync::Arc;

use meliora::reach::{Asking, Target, Under, check_start};
use meliora_base::error::Error;
use meliora_engine::regions::Regions;
use meliora_engine::{Engine, Guided};
use meliora_lang::property::{Bound, Over, Question, Strategies};
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_quantities::answer::Answer;
use meliora_report::reach::Share;

use super::asked::Asked;
use super::given::Given;

/// The answer to a property, without counts.
pub(super) struct Judged {
    pub(super) answer: Answer,
    /// The share of the initial states in each region that was needed.
    pub(super) initial: Regions<Option<Share>>,
    /// See [`meliora_engine::Usage::peak_nodes`].
    pub(super) peak_nodes: u64,
}

/// Returns the question if it is one about the initial states alone: a single property that holds or not, without
/// a strong plan. In a `dtmc`, the states are needed to warn of those in which several choices are merged.
pub(super) fn without_counts<'a>(
    given: &Given<'_>,
    asked: &Asked,
    questions: &[(&'a Asking, usize)],
) -> Option<&'a Asking> {
    let [(asking, _)] = questions else { return None };
    let holds_or_not =
        matches!((&asking.question, asking.over), (Some(Question::Qualitative(..)), Over::All));
    let is_plain = asking.goal.requirements.is_empty() && asked.overlap.is_none();
    let is_alone = given.is_one && given.plan.is_none_or(|(plan, _)| !plan.strong);
    (is_alone && holds_or_not && is_plain).then_some(*asking)
}

/// Returns the target if the question is whether some strategy reaches it almost surely.
pub(super) fn target(asking: &Asking) -> Option<&Predicate> {
    let is_sure = matches!(asking.question, Some(Question::Qualitative(Strategies::Some, Bound::One)));
    match &asking.goal.target {
        Target::States(target) if is_sure && asking.coalition.is_none() => Some(target),
        _ => None,
    }
}

/// Answers a question of [`without_counts`].
///
/// # Errors
/// A limit is hit; the target has no value in some state of the engine; there is no initial state.
pub(super) fn judge<E: Engine>(
    engine: &E,
    asking: &Asking,
    asked: &Arc<Program>,
    program: &Program,
) -> Result<Judged, Error> {
    check_start(engine, program)?;
    let played = asking.played(engine)?;
    let engine = played.as_ref().unwrap_or(engine);
    let under = Under::new(engine, asked, &asking.goal)?;
    let mut search = asking.goal.search(engine)?;
    let mut initial = Regions::default();
    for which in search.order(&asking.needed(asked)) {
        *initial.get_mut(which) = Some(Share::of_initial(engine, &search.region(which)?)?);
    }
    let answer = under.decided(asking, asked, search.known())?;
    Ok(Judged { answer, initial, peak_nodes: engine.usage().peak_nodes })
}

/// Returns the answer of a guided search.
pub(super) fn guided(search: &Guided) -> Judged {
    let [all, lost] = search.initial();
    let share = match search.answer() {
        Some(true) => Some(Share::All),
        // The search ends with the first initial state that is lost.
        Some(false) if lost == all => Some(Share::None),
        _ => None,
    };
    let initial = Regions { pmax_one: share, ..Regions::default() };
    Judged { answer: Answer::of(search.answer()), initial, peak_nodes: 0 }
}
