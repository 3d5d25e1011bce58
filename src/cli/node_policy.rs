//! Policies with memory: `strategy --policy` writes them, `verify` checks them, and `simulate --policy` runs them.

use std::path::PathBuf;
use std::sync::Arc;

use meliora_base::error::{Error, Limit};
use meliora_engine::{Algebra, AnyEngine, Engine};
use meliora_model::{Program, State};
use meliora_planning::induced_model::Unfolding;
use meliora_planning::{Analysis, FiniteMemoryStrategy, Phase, Rank, Scheduler, StrategyKind};
use meliora_report::StrategyReport;
use meliora_report::node_file::NodeWords;
use meliora_report::strategy::WrittenPolicy;

use super::choose::ChooseArgs;
use super::exit::Status;
use super::files::Target;
use super::load::Question;
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
    pub(super) fn write(self, question: Option<Question>, shown: &ShownArgs) -> Result<Status, Error> {
        self.engine.validate(&self.model)?;
        self.choose.validate()?;
        if self.preferences.preferences.as_os_str().is_empty() {
            let message =
                "a policy of this kind is about preferences: name a preference file after the model";
            return Err(Error::Usage(message.to_owned()));
        }
        if self.preferences.options().safety.drops_successors() {
            let message = "under `--safety transition`, actions of the strategy may weaken, so no policy is written: \
                           choose `prefix` or `action`";
            return Err(Error::Usage(message.to_owned()));
        }
        let header = self.engine.header(self.preferences.header(&self.model));
        let report = StrategyReport::of_kind(header, self.kind, self.choose.shown());
        let out = Target::new(&self.policy, &self.preferences.inputs(&self.model))?;
        let (limits, shown) = (self.model.limits(), shown.clone());
        supervise(report, limits, &shown, move |job| self.work(job, question, &out))
    }

    fn work(&self, job: &Job<StrategyReport>, question: Option<Question>, out: &Target) -> Result<(), Error> {
        let given = Arguments { model: &self.model, preferences: &self.preferences, engine: &self.engine };
        let question = match question {
            Some(question) => {
                plan::note(job, given, &question);
                question
            }
            None => plan::read(job, given, |_| Ok(()))?.0,
        };
        self.kind.objectives(&question.preferences, self.choose.objective())?;
        let levels = [Phase::Sasi, Phase::Spi];
        let (engine, analysis) = plan::raced(job, given, &question, &|job, engine| {
            let levels = || plan::analysis(engine, &question, &self.preferences, &levels, &job.sink);
            let analysis = job.timed("levels", levels, |r, s| r.time.add("levels", s))?;
            Ok((Arc::clone(engine), analysis))
        })?;
        let write = || self.unfold(job, &question, &analysis, out);
        let written = job.timed("answer", write, |r, s| r.time.add("answer", s))?;
        job.update(|r| {
            r.policy = Some(written);
            r.used(engine.usage());
        });
        Ok(())
    }

    /// Returns the states in which paths may start: the initial states, which must be among those from which the
    /// strategy does something sure, or all of these.
    ///
    /// # Errors
    /// The requirements cannot be kept from an initial state, or the objective is not sure there; a limit.
    fn starts(
        &self,
        analysis: &Analysis<AnyEngine>,
        program: &Program,
        strategy: &FiniteMemoryStrategy<AnyEngine>,
    ) -> Result<Vec<State>, Error> {
        let (whole, engine) = (analysis.whole_engine(), analysis.engine());
        let none = |state: &State, why: &str| {
            let state = program.show_state(state);
            Error::Usage(format!("no policy is written: {why} from the initial state {state}"))
        };
        let initial = whole.initial_states();
        if let Some(state) = whole.list_states(&whole.difference(&initial, &engine.all_states())?, 1)?.first()
        {
            return Err(none(state, "no strategy keeps the requirements"));
        }
        let listed = |set| engine.list_states(set, self.limit);
        let starts = if self.all { listed(&engine.all_states())? } else { listed(&initial)? };
        if self.kind != StrategyKind::Achieve {
            return Ok(starts);
        }
        let mut sure = Vec::with_capacity(starts.len());
        for state in starts {
            if strategy.start(&state)?.pursuit.is_some() {
                sure.push(state);
            } else if whole.contains(&initial, &state)? {
                let aim = self.choose.objective().unwrap_or_default();
                return Err(none(&state, &format!("`{aim}` is not sure")));
            }
        }
        Ok(sure)
    }

    fn unfold(
        &self,
        job: &Job<StrategyReport>,
        Question { program, preferences, .. }: &Question,
        analysis: &Analysis<AnyEngine>,
        out: &Target,
    ) -> Result<WrittenPolicy, Error> {
        let mut strategy = self.choose.strategy(analysis, program, self.kind)?;
        let starts = self.starts(analysis, program, &strategy)?;
        let words = NodeWords { program, preferences };
        let mut pieces = out.pieces()?;
        let safety = self.preferences.options().safety.name();
        pieces.push(&words.head(self.kind, safety, strategy.objectives(), starts.len()))?;
        let (mut nodes, mut idle) = (0, 0);
        let mut unfolding = Unfolding::new(&mut strategy, &starts, self.scheduler, self.limit)?;
        while let Some(node) = unfolding.next_node()? {
            if !unfolding.complete {
                return Err(Limit::Listed(self.limit as u64).into());
            }
            idle += u64::from(
                nodes < starts.len() && node.at.memory.level == Rank::Finite(0) && node.at.aims.is_empty(),
            );
            pieces.push(&words.node(&node, nodes == 0))?;
            nodes += 1;
        }
        pieces.push(words.tail())?;
        pieces.finish()?;
        if idle == starts.len() as u64 {
            job.sink.warn("the policy promises nothing: no improvement is ahead in its starts; another `--kind` may do more");
        }
        Ok(WrittenPolicy {
            file: self.policy.display().to_string(),
            starts: starts.len() as u64,
            nodes: nodes as u64,
        })
    }
}
