//! Policies with memory: `strategy --policy` writes them, `verify` checks them, and `simulate --policy` runs them.

use std::path::PathBuf;
use std::sync::Arc;

use meliora::Task;
use meliora::commands::check::levels;
use meliora::commands::strategies::PolicyNodes;
use meliora_base::error::Error;
use meliora_engine::{AnyEngine, Engine};
use meliora_planning::{Analysis, Phase, Scheduler, StrategyKind};
use meliora_report::StrategyReport;
use meliora_report::strategy::WrittenPolicy;

use super::choose::ChooseArgs;
use super::exit::Status;
use super::files::Target;
use super::options::{EngineArgs, ModelArgs, PreferenceArgs, ShownArgs};
use super::plan::{self, Arguments};
use super::supervise::{Job, supervise};

/// The strategy that is written as a policy.
pub(super) struct NodePolicyWriter {
    pub(super) model: ModelArgs,
    pub(super) preferences: PreferenceArgs,
    pub(super) choose: ChooseArgs,
    pub(super) engine: EngineArgs,
    pub(super) kind: StrategyKind,
    pub(super) scheduler: Scheduler,
    /// True if paths may start in all states of the scope.
    pub(super) all: bool,
    /// Maximum number of nodes.
    pub(super) limit: usize,
    pub(super) policy: PathBuf,
}

impl NodePolicyWriter {
    /// Writes the policy. The input may have been read before.
    ///
    /// # Errors
    /// The input is wrong, no policy keeps the promise, or a limit is hit.
    pub(super) fn write(self, task: Option<Task>, shown: &ShownArgs) -> Result<Status, Error> {
        self.engine.validate(&self.model)?;
        self.choose.validate()?;
        if self.preferences.preferences.as_os_str().is_empty() {
            let message =
                "a policy of this kind is about preferences: name a preference file after the model";
            return Err(Error::Usage(message.to_owned()));
        }
        PolicyNodes::check_safety(self.preferences.options().safety)?;
        let header = self.engine.header(self.preferences.header(&self.model));
        let report = StrategyReport::of_kind(header, self.kind, self.choose.shown());
        let out = Target::new(&self.policy, &self.preferences.inputs(&self.model))?;
        let (limits, shown) = (self.model.limits(), shown.clone());
        supervise(report, limits, &shown, move |job| self.work(job, task, &out))
    }

    fn work(&self, job: &Job<StrategyReport>, task: Option<Task>, out: &Target) -> Result<(), Error> {
        let given = Arguments { model: &self.model, preferences: &self.preferences, engine: &self.engine };
        let task = match task {
            Some(task) => {
                plan::note(job, given, &task);
                task
            }
            None => plan::read(job, given, |_| Ok(()))?.0,
        };
        self.kind.objectives(&task.preferences, self.choose.objective())?;
        let both = [Phase::Sasi, Phase::Spi];
        let (engine, analysis) = plan::raced(job, given, &task, &|job, engine| {
            let analyse = || levels(job, engine, &task, self.preferences.options(), &both);
            let analysis = job.timed("levels", analyse, |r, s| r.time.add("levels", s))?;
            Ok((Arc::clone(engine), analysis))
        })?;
        let write = || self.write_nodes(job, &task, &analysis, out);
        let written = job.timed("answer", write, |r, s| r.time.add("answer", s))?;
        job.update(|r| {
            r.policy = Some(written);
            r.used(engine.usage());
        });
        Ok(())
    }

    fn write_nodes(
        &self,
        job: &Job<StrategyReport>,
        task: &Task,
        analysis: &Analysis<AnyEngine>,
        out: &Target,
    ) -> Result<WrittenPolicy, Error> {
        let objective = self.choose.objective();
        let mut strategy =
            self.choose.wanted(self.kind, task, &job.sink)?.strategy(analysis, &task.program)?;
        let (program, scheduler) = (&*task.program, self.scheduler);
        let nodes = PolicyNodes { program, objective, scheduler, all: self.all, limit: self.limit };
        let mut pieces = out.pieces()?;
        let size = nodes.write(analysis, &mut strategy, &mut |text| pieces.push(text))?;
        pieces.finish()?;
        if !size.promises {
            job.sink.warn("the policy promises nothing: no improvement is ahead in its starts; another `--kind` may do more");
        }
        let file = self.policy.display().to_string();
        Ok(WrittenPolicy { file, starts: size.starts as u64, nodes: size.nodes as u64 })
    }
}
