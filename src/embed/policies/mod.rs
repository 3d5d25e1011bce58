//! Policies of files, checked and run without the code that finds them.

mod mix;
mod nodes;
mod rules;

use std::sync::Arc;

use self::mix::Mix;
use self::nodes::Nodes;
use self::rules::Rules;
use super::{Task, Work};
use meliora_base::error::{Result, SourceFile};
use meliora_base::progress::ProgressSink;
use meliora_engine::Settings;
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_report::policy_report::PolicyRuns;
use meliora_report::{PolicyReport, mix as mix_text, node_file};

/// The form of the text of a policy, which says what the policy is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PolicyForm {
    /// A list of rules: it reaches a goal.
    Rules,
    /// Nodes with memory: it is about preferences.
    Nodes,
    /// Strategies for the objectives of a property `multi(…)`, of which one is drawn.
    Mix,
}

impl PolicyForm {
    /// Returns the form of a text.
    pub fn of(source: &SourceFile) -> Self {
        if node_file::is_nodes(source) {
            PolicyForm::Nodes
        } else if mix_text::is_mix(source) {
            PolicyForm::Mix
        } else {
            PolicyForm::Rules
        }
    }
}

/// A policy of a file, with the model that it is for.
pub struct GivenPolicy(Form);

enum Form {
    Rules(Box<Rules>),
    Nodes(Nodes),
    Mix(Mix),
}

impl GivenPolicy {
    /// Reads a list of rules that reaches a goal. Cost: one test per initial state.
    ///
    /// # Errors
    /// The text is wrong, or about another model; the model has no initial state.
    pub fn rules(
        source: &Arc<SourceFile>,
        program: Program,
        goal: Predicate,
        sink: &dyn ProgressSink,
    ) -> Result<Self> {
        Rules::new(source, program, goal, sink).map(|rules| GivenPolicy(Form::Rules(Box::new(rules))))
    }

    /// Reads a policy with memory.
    ///
    /// # Errors
    /// The text is wrong, or about another model.
    pub fn nodes(source: &Arc<SourceFile>, task: Task, sink: &dyn ProgressSink) -> Result<Self> {
        Nodes::new(source, task, sink).map(Form::Nodes).map(GivenPolicy)
    }

    /// Reads the strategies of a property `multi(…)`, which the explicit engine follows with these settings.
    ///
    /// # Errors
    /// The text is wrong, or about another model; the model is a game.
    pub fn mix(source: &Arc<SourceFile>, program: Program, settings: Settings) -> Result<Self> {
        Mix::new(source, program, settings).map(Form::Mix).map(GivenPolicy)
    }

    /// Checks the policy; the report says whether it is accepted, or which condition it violates. `is_strong`: each path
    /// of a list of rules reaches the goal within a bound, too. Cost: one visit of each state that the policy reaches.
    ///
    /// # Errors
    /// A command has no meaning in a state; a limit is reached.
    pub fn check(&self, work: &dyn Work<PolicyReport>, is_strong: bool) -> Result<()> {
        match &self.0 {
            Form::Rules(rules) => rules.check(work, is_strong),
            Form::Nodes(nodes) => nodes.check(work),
            Form::Mix(mix) => mix.work(work, None),
        }
    }

    /// Runs the policy; the report counts the runs. Cost: one step of the model per step.
    ///
    /// # Errors
    /// The policy does not start in an initial state; a command has no meaning in a state; a limit is reached.
    pub fn run(&self, work: &dyn Work<PolicyReport>, runs: &PolicyRuns) -> Result<()> {
        match &self.0 {
            Form::Rules(rules) => rules.run(work, runs),
            Form::Nodes(nodes) => nodes.run(work, runs),
            Form::Mix(mix) => mix.work(work, Some(runs)),
        }
    }
}
