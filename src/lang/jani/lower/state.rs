//! State of lowering a model.

use std::sync::Arc;

use ahash::AHashMap;

use super::super::read::model::Model;
use super::arrays::{Array, Parts};
use super::scope::{Declared, Earned, Instance, Level, Transient};
use crate::check::{Actions, Lowerer, Scope};
use crate::names::Names;
use meliora_base::error::{Diagnostic, SourceFile};
use meliora_base::exact::Exact;
use meliora_base::progress::ProgressSink;
use meliora_model::Variable;
use meliora_model::expr::ExprPool;

/// The texts that define a model.
pub(crate) struct Inputs<'i> {
    pub(crate) source: &'i Arc<SourceFile>,
    /// Values of constants, such as `K=4,N=3`.
    pub(crate) constants: &'i Arc<SourceFile>,
    /// Bounds of integers, such as `x=0..7,y=-1..1`.
    pub(crate) bounds: &'i Arc<SourceFile>,
}

/// Maximum number of functions searched for the variables that an expression reads.
pub(super) const MOST_FUNCTIONS_DEEP: usize = 1_000;

/// State of lowering a model.
pub(super) struct Lowering<'a> {
    pub(super) lowerer: Lowerer<'a>,
    pub(super) model: &'a Model,
    /// Names of constants and variables; `modules` has the names of automata.
    pub(super) names: Names,
    pub(super) modules: Names,
    pub(super) actions: Actions,
    pub(super) globals: Level<'a>,
    pub(super) instances: Vec<Instance<'a>>,
    /// Groups of elements that are multiplied out, with the name of the module for each group.
    pub(super) joint_modules: Vec<(Vec<usize>, String)>,
    pub(super) variables: Vec<Variable>,
    pub(super) transients: Vec<Transient<'a>>,
    pub(super) arrays: Vec<Array>,
    pub(super) functions: Vec<Declared<'a>>,
    pub(super) constant_values: Vec<(String, Exact)>,
    /// Constants without a value yet; the flag says that the reason was reported.
    pub(super) pending: AHashMap<&'a str, bool>,
    /// Bounds for unbounded variables; the flag says that they were used.
    pub(super) bounds: AHashMap<String, (i64, i64, bool)>,
    /// Name of the option that gives bounds.
    pub(super) bounds_by: &'a str,
    /// Results of functions by stage, function and arguments; the stage is 0 before all
    /// assignments.
    pub(super) called: AHashMap<(usize, usize, Vec<Parts>), Option<Parts>>,
    pub(super) stage: usize,
    pub(super) stages: usize,
    /// Number of nested definitions being read.
    pub(super) depth: usize,
    pub(super) warnings: Vec<Diagnostic>,
    /// Rewards of steps.
    pub(super) earned: Earned,
}

impl<'a> Lowering<'a> {
    pub(super) fn new(
        model: &'a Model,
        inputs: &Inputs<'a>,
        bounds: Vec<(String, i64, i64)>,
        sink: &'a dyn ProgressSink,
    ) -> Self {
        Lowering {
            lowerer: Lowerer::new(inputs.source, Scope::default(), ExprPool::default(), sink),
            model,
            names: Names::default(),
            modules: Names::default(),
            actions: Actions::default(),
            globals: Level::default(),
            instances: Vec::new(),
            joint_modules: Vec::new(),
            variables: Vec::new(),
            transients: Vec::new(),
            arrays: Vec::new(),
            functions: Vec::new(),
            constant_values: Vec::new(),
            pending: AHashMap::new(),
            bounds: bounds.into_iter().map(|(name, low, high)| (name, (low, high, false))).collect(),
            bounds_by: &inputs.bounds.name,
            called: AHashMap::new(),
            stage: 0,
            stages: 0,
            depth: 0,
            warnings: Vec::new(),
            earned: Earned::default(),
        }
    }

    /// Returns the position of an action, which is added if it is new.
    pub(super) fn action(&mut self, name: &str) -> usize {
        self.actions.add(name)
    }
}
