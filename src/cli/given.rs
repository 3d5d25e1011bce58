//! The options of `meliora reach` that say how its questions are answered.

use super::files::Target;
use super::options::{EngineArgs, ModelArgs};
use super::policy::PlanArgs;
use super::regions::Regions;

/// The arguments for the engine and the answers, and where the regions are written.
pub(super) struct Given<'a> {
    pub(super) model: &'a ModelArgs,
    pub(super) engine: EngineArgs,
    pub(super) out: Option<Regions<'a>>,
    pub(super) precision: f64,
    /// True for one question, whose fields the report has.
    pub(super) is_one: bool,
    /// The plans that are asked for, and where the policy is written.
    pub(super) plan: Option<(&'a PlanArgs, Option<&'a Target>)>,
}
