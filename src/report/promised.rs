//! The promise of a policy with memory, and the results of its runs.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::Serialize;

use super::policy_report::{PolicyReport, PolicyStep};
use super::{Number, Style, ranks, text};
use meliora_certify::policy::{Accepted, Aim, Node, NodePolicy, NodeRun};
use meliora_model::Program;
use meliora_model::preference::{ObjectiveSet, Preferences};
use meliora_model::valuation::Valuation;
use meliora_planning::Rank;
use meliora_question::number::grouped;

/// Maximum number of starts in a report.
const MOST_STARTS: usize = 16;

/// The promise of a policy with memory.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Promised {
    /// Its aim: `sasi`, `spi`, `plan` or `achieve`.
    pub kind: String,
    /// The comparison of steps: `prefix` or `action`.
    pub safety: String,
    /// The objectives that it achieves, or that a plan pursues where they are most preferred.
    pub objectives: Vec<String>,
    /// The number of nodes.
    pub nodes: u64,
    /// The number of nodes in which a plan has committed to an objective, and may give up others.
    pub committed: u64,
    /// The number of states of the model that the check listed; `null` if it did not end, and with `simulate`.
    pub listed: Option<Number>,
    /// The number of starts.
    pub start_count: u64,
    /// The starts, 16 at most.
    pub starts: Vec<PromisedStart>,
}

/// The promise of a policy from a state on.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct PromisedStart {
    /// The state.
    pub state: Valuation,
    /// Its most preferred objectives.
    pub most_preferred: Vec<String>,
    /// The number of improvements.
    pub improvements: Rank,
    /// The objectives that it pursues from the start on.
    pub pursues: Vec<String>,
}

/// The results of the runs of a policy with memory.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub struct Done {
    /// The mean number of improvements of a run.
    pub mean_improvements: f64,
    /// The runs in which a step weakened its reference.
    pub weakened: u64,
}

impl Promised {
    /// Returns what a policy promises.
    pub fn new(policy: &NodePolicy, program: &Program, preferences: &Preferences) -> Self {
        let names = |set: &ObjectiveSet| preferences.owned_names(set);
        let start = |node: &Node| PromisedStart {
            state: Valuation::new(program, &node.state),
            most_preferred: names(&node.most_preferred),
            improvements: node.ahead.map_or(Rank::Unbounded, Rank::Finite),
            pursues: names(&node.pursues),
        };
        Promised {
            kind: policy.promise.aim.name().to_owned(),
            safety: policy.promise.safety.name().to_owned(),
            objectives: names(&policy.promise.objectives),
            nodes: policy.nodes.len() as u64,
            committed: policy.nodes.iter().filter(|node| node.commits).count() as u64,
            listed: None,
            start_count: policy.starts as u64,
            starts: policy.nodes[..policy.starts].iter().take(MOST_STARTS).map(start).collect(),
        }
    }

    /// Adds the result of a check that accepts the policy.
    pub fn accept(&mut self, accepted: &Accepted) {
        self.listed = Some(Number::from(accepted.states as u64));
    }

    /// Lists what the policy promises.
    pub(super) fn text(&self, is_accepted: bool, style: Style) -> String {
        let mut out = String::new();
        let nodes = grouped(self.nodes);
        let title =
            format!("Policy of the kind {}, safety {}, {nodes} states with memory", self.kind, self.safety);
        let _ = writeln!(out, "\n{}", style.bold(&title));
        for start in &self.starts {
            let _ = writeln!(out, "  from {}: {}", start.state, self.from(start));
        }
        if self.start_count > self.starts.len() as u64 {
            let _ = writeln!(
                out,
                "  and {} further starts",
                grouped(self.start_count - self.starts.len() as u64)
            );
        }
        if self.committed > 0 {
            let _ = writeln!(
                out,
                "  in {} of them it has committed to its objective, and may give up others",
                grouped(self.committed)
            );
        }
        if let Some(listed) = self.listed.as_ref().filter(|_| is_accepted) {
            let compared = match self.kind == Aim::Achieve.name() {
                true => "",
                false => ", and no step weakens its reference",
            };
            let listed = listed.grouped();
            let _ = writeln!(
                out,
                "\n{}: the policy keeps its promise from each start{compared}\n{listed} states of the model were listed",
                style.good("accepted"),
            );
        }
        out
    }

    /// Says what a start is promised.
    fn from(&self, start: &PromisedStart) -> String {
        let how = if self.kind == Aim::Spi.name() { "possible" } else { "almost sure" };
        let over = text::goal(&start.most_preferred);
        let mut all = Vec::new();
        if self.kind != Aim::Achieve.name() {
            all.push(format!("{} over {over}, {how}", ranks::improvements(start.improvements)));
        }
        if !start.pursues.is_empty() {
            all.push(format!("achieves {} almost surely", start.pursues.join(" and ")));
        } else if self.kind == Aim::Plan.name() && start.improvements != Rank::Finite(0) {
            all.push("then achieves a most preferred objective almost surely".to_owned());
        }
        all.join("; ")
    }
}

impl PolicyReport {
    /// Adds a run of a policy with memory.
    pub fn add_run(&mut self, program: &Program, run: NodeRun) {
        let Some(runs) = &mut self.runs else { return };
        let (steps, done) = (run.steps.len() as u64, runs.done.get_or_insert_default());
        done.mean_improvements += run.improvements as f64 / runs.runs as f64;
        done.weakened += u64::from(run.weakens);
        runs.count(steps, run.is_kept, run.is_given_up);
        if runs.last.is_none() {
            runs.first = PolicyStep::all(program, run.steps);
            runs.last = Some(Valuation::new(program, &run.last));
        }
    }
}

impl Done {
    pub(super) fn text(&self) -> String {
        let weakened = match self.weakened {
            0 => "no step weakened its reference".to_owned(),
            n => format!("in {} runs, a step weakened its reference", grouped(n)),
        };
        format!("  improvements: {:.2} on average; {weakened}\n", self.mean_improvements)
    }
}
