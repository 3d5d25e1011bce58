//! Policies of files, checked and run without the code that finds them.

mod mix;
mod nodes;
mod property;
mod rules;

use std::sync::Arc;

use self::mix::Mix;
use self::nodes::Nodes;
use self::property::OfProperty;
use self::rules::Rules;
use super::{Model, Work};
use meliora_base::error::{Error, Result, SourceFile};
use meliora_engine::Settings;
use meliora_lang::property::term::TermKind;
use meliora_model::Program;
use meliora_model::predicate::Predicate;
use meliora_question::list::NO_GOAL;
use meliora_question::{Asking, Target};
use meliora_report::mix::File;
use meliora_report::policy_report::PolicyRuns;
use meliora_report::{PolicyReport, mix as mix_text, node_file};

/// The form of the text of a policy, which says what the policy is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PolicyForm {
    /// A list of rules: it reaches a goal.
    Rules,
    /// Nodes with memory: it is about preferences.
    Nodes,
    /// The strategy of a property, or those of a property `multi(…)`, of which one is drawn.
    Mix,
}

impl PolicyForm {
    /// Returns the form of a text.
    fn recognise(source: &SourceFile) -> Self {
        if node_file::is_nodes(source) {
            PolicyForm::Nodes
        } else if mix_text::is_mix(source) {
            PolicyForm::Mix
        } else {
            PolicyForm::Rules
        }
    }
}

/// The subject of a policy, as far as its file does not name it.
#[derive(Debug, Clone, Default)]
pub struct PolicyAim {
    /// The goal of a list of rules; without it, the goal of the planning problem.
    pub target: Option<Arc<SourceFile>>,
    /// The preferences that a policy with memory is about.
    pub preferences: Option<Arc<SourceFile>>,
    /// Each path of a list of rules reaches the goal within a bound, too.
    pub is_strong: bool,
}

impl PolicyAim {
    /// Checks that the aim fits the form of a policy.
    fn check(&self, form: PolicyForm) -> Result<()> {
        let has_goal = self.is_strong || self.target.is_some();
        let wrong = match (form, &self.preferences) {
            (PolicyForm::Nodes, _) if has_goal => {
                "this policy is about preferences: leave out `--target` and `--strong`"
            }
            (PolicyForm::Nodes, None) => {
                "this policy is about preferences: name the preference file after the model"
            }
            (PolicyForm::Rules | PolicyForm::Mix, Some(_)) => {
                "this policy has a goal of its own, and no preferences: leave out PREFS"
            }
            (PolicyForm::Mix, None) if has_goal => {
                "the strategies of `multi` have objectives of their own: leave out `--target` and `--strong`"
            }
            _ => return Ok(()),
        };
        Err(Error::Usage(wrong.to_owned()))
    }

    /// Returns the states that the target means, or the goal of the planning problem.
    fn goal(&self, program: &Program) -> Result<Predicate> {
        let wrong = |message: &str| Err(Error::Usage(message.to_owned()));
        if program.players.is_some() {
            return wrong("this checks policies of models with one player, and this model is a game");
        }
        let of_problem = || SourceFile::new("the goal", "\"goal\"");
        let target = match (&self.target, &program.planning) {
            (Some(target), _) => Arc::clone(target),
            (None, Some(planning)) if planning.has_goal() => of_problem(),
            (None, Some(_)) => return wrong(NO_GOAL),
            (None, None) => return wrong("this model has no goal of its own: `--target EXPR` gives one"),
        };
        match Asking::target(program, &target, &[])?.goal.target {
            Target::States(goal) => Ok(goal),
            Target::Formula(_) => wrong("`--target` is a condition on states"),
        }
    }
}

/// A policy of a file, with the model that it is for.
pub struct GivenPolicy(Form);

enum Form {
    Rules(Box<Rules>),
    Nodes(Nodes),
    Mix(Mix),
    Property(Box<OfProperty>),
}

impl GivenPolicy {
    /// Reads a policy, and the model that it is for. `model` reads the model; its argument says whether only the goal of a
    /// planning problem matters. The explicit engine follows the strategies of `multi` with these settings. Cost: one test
    /// per initial state.
    ///
    /// # Errors
    /// The text is wrong, or about another model; the aim does not fit it; the model has no initial state, or is a game and
    /// the policy has a goal of its own.
    pub fn read(
        work: &dyn Work<PolicyReport>,
        source: &Arc<SourceFile>,
        aim: &PolicyAim,
        model: impl FnOnce(bool) -> Result<Model>,
        settings: Settings,
    ) -> Result<Self> {
        let form = PolicyForm::recognise(source);
        aim.check(form)?;
        let settings = Settings { keeps_choices: true, keeps_probabilities: true, ..settings };
        let model = model(form == PolicyForm::Rules && aim.target.is_none())?;
        let sink = work.sink();
        Ok(GivenPolicy(match (form, &aim.preferences) {
            (PolicyForm::Nodes, Some(preferences)) => {
                let task = model.task(preferences)?;
                task.warnings().into_iter().for_each(|warning| work.warn(warning));
                work.update(|r| r.header.read(&task.program));
                Form::Nodes(Nodes::new(source, task, &*sink)?)
            }
            (PolicyForm::Mix, _) => {
                let program = model.into_program();
                work.update(|r| r.header.read(&program));
                let file = File::new(source)?;
                let property = property::property(source, &file, &program)?;
                if matches!(property.1.kind, TermKind::Multi(_)) {
                    Form::Mix(Mix::new(source, file, program, settings)?)
                } else {
                    Form::Property(Box::new(OfProperty::new(source, file, property, program, settings)))
                }
            }
            _ => {
                let program = model.into_program();
                work.update(|r| r.header.read(&program));
                let goal = aim.goal(&program)?;
                Form::Rules(Box::new(Rules::new(source, program, (goal, aim.is_strong), &*sink)?))
            }
        }))
    }

    /// Checks the policy; the report says whether it is accepted, or which condition it violates. Cost: one visit of each
    /// state that the policy reaches.
    ///
    /// # Errors
    /// A command has no meaning in a state; a limit is reached.
    pub fn check(&self, work: &dyn Work<PolicyReport>) -> Result<()> {
        match &self.0 {
            Form::Rules(rules) => rules.check(work),
            Form::Nodes(nodes) => nodes.check(work),
            Form::Mix(mix) => mix.work(work, None),
            Form::Property(own) => own.work(work, None),
        }
    }

    /// Runs the policy; the report, which has `runs` already, counts them. Cost: one step of the model per step.
    ///
    /// # Errors
    /// The policy does not start in an initial state; a command has no meaning in a state; a limit is reached.
    pub fn run(&self, work: &dyn Work<PolicyReport>, runs: &PolicyRuns) -> Result<()> {
        match &self.0 {
            Form::Rules(rules) => rules.run(work, runs),
            Form::Nodes(nodes) => nodes.run(work, runs),
            Form::Mix(mix) => mix.work(work, Some(runs)),
            Form::Property(own) => own.work(work, Some(runs)),
        }
    }
}
