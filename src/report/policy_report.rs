//! The report of `meliora verify` and `meliora simulate` on a policy.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::Serialize;

use super::envelope::{Envelope, Findings, Phase};
use super::header::Header;
use super::promised::{Done, Promised};
use super::verify::Violated;
use super::{Number, Style};
use meliora_base::escape;
use meliora_certify::policy::rules::{PolicyFault, PolicyRun, Visited};
use meliora_model::valuation::Valuation;
use meliora_model::{Program, State};
use meliora_quantities::state_values::Bound;
use meliora_question::number::grouped;

/// Maximum number of steps of the first run that the text shows.
const SHOWN: usize = 60;

/// The results of checking or running a policy.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(rename = "policy")]
pub struct PolicyFindings {
    /// The file of the policy.
    pub policy: String,
    /// `verify`: the policy reaches the goal surely from all initial states, with `--strong` within a bound, or the
    /// strategies of a property `multi(…)` have their values; `null` if unknown, absent with `simulate`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("nullable" = true))]
    pub accepted: Option<Option<bool>>,
    /// The number of states outside the goal that the policy visits; `null` if unknown, or if it is refused.
    pub states: Option<Number>,
    /// The number of states of the goal in which it ends; as `states`.
    pub goal_states: Option<Number>,
    /// The number of steps of the longest path; `null` if no bound exists, or as `states`.
    pub longest: Option<Number>,
    /// The first fault; `null` if there is none, or if it is unknown.
    pub violation: Option<Violated>,
    /// The promise of a policy with memory; absent for other policies, and before it is read.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub promise: Option<Promised>,
    /// The strategies of a property `multi(…)`, with their values; absent for other policies.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub strategies: Vec<StrategyValues>,
    /// The runs of `simulate`; absent with `verify`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runs: Option<PolicyRuns>,
}

/// The values of a strategy of a property `multi(…)`.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct StrategyValues {
    /// The probability with which it is drawn; `null` for a point of a front.
    pub share: Option<f64>,
    /// The number of states that it visits, with its memory.
    pub nodes: u64,
    /// The values of the objectives.
    pub objectives: Vec<ObjectiveValue>,
}

/// The value of an objective under a strategy.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ObjectiveValue {
    /// The text of the objective.
    pub objective: String,
    /// The value that the file claims.
    pub claimed: f64,
    /// Bounds of the value of the strategy; absent with `simulate`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<Bound>,
}

/// The values of an objective in the runs of strategies of which one is drawn at the start.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct MeasuredObjective {
    /// The text of the objective.
    pub objective: String,
    /// The mean of the values that the strategies claim.
    pub claimed: f64,
    /// The mean over the runs; `null` if a reward was given up before it ended, or is infinite.
    pub measured: Option<f64>,
    /// The bounds that contain the true mean with a probability of 0.99; `null` if unknown.
    pub interval: Option<[f64; 2]>,
    /// The runs that were given up before the objective was decided.
    pub open: u64,
}

/// The runs of a policy.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub struct PolicyRuns {
    /// Their number.
    pub runs: u64,
    /// The number of steps after which a run is given up.
    pub limit: u64,
    /// The seed of the random numbers.
    pub seed: u64,
    /// The runs that reached the goal; of a property `multi(…)`, those that decided all objectives; of a policy with
    /// memory, those that did all that it promises at their start.
    pub reached: u64,
    /// The runs that were given up after `limit` steps.
    pub given_up: u64,
    /// The mean number of steps of the runs that reached the goal; `null` if none did.
    pub mean_steps: Option<f64>,
    /// The largest number of these steps; `null` if no run reached the goal.
    pub most_steps: Option<u64>,
    /// The objectives of a property `multi(…)`; absent for other policies.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub objectives: Vec<MeasuredObjective>,
    /// The results of the runs of a policy with memory; absent for other policies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub done: Option<Done>,
    /// The steps of the first run; none of a property `multi(…)`.
    pub first: Vec<PolicyStep>,
    /// The state in which the first run ends.
    pub last: Option<Valuation>,
}

/// A step of a run.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct PolicyStep {
    /// The state before it.
    pub state: Valuation,
    /// The action.
    pub action: String,
}

/// The report with times and memory.
pub type PolicyReport = Envelope<PolicyFindings>;

impl PolicyReport {
    /// Creates a report without results: of a check, or of runs.
    pub fn of_file(header: Header, policy: &str, runs: Option<PolicyRuns>) -> Self {
        let accepted = runs.is_none().then_some(None);
        Envelope::with(
            header,
            PolicyFindings { policy: policy.to_owned(), accepted, runs, ..Default::default() },
        )
    }

    /// Adds the result of a check.
    pub fn set(&mut self, program: &Program, found: Result<Visited, PolicyFault>) {
        let number = |n: usize| Some(Number::from(n as u64));
        self.accepted = Some(Some(found.is_ok()));
        match found {
            Ok(Visited { states, goals, longest }) => {
                (self.states, self.goal_states) = (number(states), number(goals));
                self.longest = longest.and_then(number);
            }
            Err(fault) => self.violate(program, &fault),
        }
    }

    fn violate(&mut self, program: &Program, fault: &PolicyFault) {
        self.refuse(program, &fault.kind.to_string(), Some(&fault.state));
    }

    /// Notes a condition that is violated, unless there is one.
    pub fn refuse(&mut self, program: &Program, condition: &str, state: Option<&State>) {
        self.accepted = self.accepted.map(|_| Some(false));
        let state = state.map(|state| Valuation::new(program, state));
        self.violation.get_or_insert_with(|| Violated { condition: condition.to_owned(), state });
    }

    /// Adds the steps of the first run, each with its action, and the state in which it ends.
    pub fn show_run(&mut self, program: &Program, steps: Vec<(State, String)>, last: &State) {
        if let Some(runs) = &mut self.runs {
            (runs.first, runs.last) = (PolicyStep::all(program, steps), Some(Valuation::new(program, last)));
        }
    }

    /// Adds a run.
    pub fn add(&mut self, program: &Program, run: PolicyRun) {
        let (steps, is_reached) = (run.steps.len() as u64, matches!(run.end, Some(Ok(()))));
        let is_given_up = run.end.is_none();
        if let Some(Err(kind)) = run.end
            && self.violation.is_none()
        {
            self.violate(program, &PolicyFault { state: run.last.clone(), kind });
        }
        let Some(runs) = &mut self.runs else { return };
        if runs.last.is_none() {
            runs.first = PolicyStep::all(program, run.steps);
            runs.last = Some(Valuation::new(program, &run.last));
        }
        runs.count(steps, is_reached, is_given_up);
    }
}

impl PolicyStep {
    /// Names the steps of a run.
    pub(super) fn all(program: &Program, steps: Vec<(State, String)>) -> Vec<Self> {
        let step =
            |(state, action): (State, String)| PolicyStep { state: Valuation::new(program, &state), action };
        steps.into_iter().map(step).collect()
    }
}

impl Findings for PolicyFindings {
    const SCHEMA: &str = "meliora.policy/1";
    const HEADER: (&[&str], &[&str]) = (&["model"], &[]);
    const PHASES: &[Phase] = &[
        Phase::new("parse", "Reading the model and the policy"),
        Phase::new("answer", "Checking or running the policy"),
    ];

    fn body(report: &PolicyReport, style: Style) -> String {
        let mut out = String::new();
        if let (Some(states), Some(goals)) = (&report.states, &report.goal_states) {
            let _ = writeln!(out, "\nstates with an action  {}", states.grouped());
            let _ = writeln!(out, "states of the goal     {}", goals.grouped());
            let how = match &report.longest {
                Some(longest) => {
                    format!("every path reaches the goal after at most {} steps", longest.grouped())
                }
                None => "the goal is reached almost surely; no bound limits the paths".to_owned(),
            };
            let _ = writeln!(out, "\n{}: {how}", style.good("accepted"));
        }
        if let Some(promise) = &report.promise {
            out.push_str(&promise.text(report.accepted == Some(Some(true)), style));
        }
        out.push_str(&strategies(report, style));
        if let Some(runs) = &report.runs {
            out.push_str(&if runs.objectives.is_empty() { runs.text(style) } else { runs.measured(style) });
        }
        if let Some(violation) = &report.violation {
            let _ = writeln!(out, "\n{}: {}", style.bad("refused"), escape::line(&violation.condition));
            if let Some(state) = &violation.state {
                let _ = writeln!(out, "  the first one: {state}");
            }
        }
        out
    }

    fn is_no(&self) -> bool {
        self.violation.is_some()
    }
}

/// Lists the strategies of a property `multi(…)`.
fn strategies(report: &PolicyReport, style: Style) -> String {
    let mut out = String::new();
    for (number, own) in (1..).zip(&report.strategies) {
        let share =
            own.share.map_or_else(String::new, |share| format!(", drawn with probability {share:.6}"));
        let title = format!("Strategy {number}: {} states with memory{share}", grouped(own.nodes));
        let _ = writeln!(out, "\n{}", style.bold(&title));
        for ObjectiveValue { objective, claimed, value } in &own.objectives {
            let _ = writeln!(out, "  {}", escape::line(objective));
            let found = value.as_ref().map(|value| format!("; it is [{}, {}]", value.lower, value.upper));
            let _ = writeln!(out, "    claimed: {claimed}{}", found.unwrap_or_default());
        }
    }
    if report.accepted == Some(Some(true)) && !report.strategies.is_empty() {
        let _ = writeln!(out, "\n{}: each strategy has the values that it claims", style.good("accepted"));
    }
    out
}

impl PolicyRuns {
    /// Counts a run.
    pub(super) fn count(&mut self, steps: u64, is_reached: bool, is_given_up: bool) {
        self.given_up += u64::from(is_given_up);
        if is_reached {
            let sum = self.mean_steps.unwrap_or(0.0) * self.reached as f64 + steps as f64;
            self.reached += 1;
            self.mean_steps = Some(sum / self.reached as f64);
            self.most_steps = self.most_steps.max(Some(steps));
        }
    }

    /// Shows the means of the objectives.
    fn measured(&self, style: Style) -> String {
        let mut out = format!("\n{}\n", style.bold(&format!("{} runs", grouped(self.runs))));
        for own in &self.objectives {
            let _ = writeln!(out, "  {}", escape::line(&own.objective));
            let measured = own.measured.map_or_else(|| "unknown".to_owned(), |x| format!("{x:.6}"));
            let interval = own.interval.map(|[low, high]| format!(" (99 % interval {low:.6} to {high:.6})"));
            let interval = interval.unwrap_or_default();
            let _ = writeln!(out, "    claimed {:.6}, measured {measured}{interval}", own.claimed);
            if own.open > 0 {
                let _ =
                    writeln!(out, "    {} given up after {} steps", grouped(own.open), grouped(self.limit));
            }
        }
        out
    }

    fn text(&self, style: Style) -> String {
        let did = if self.done.is_some() { "kept the promise of the policy" } else { "reach the goal" };
        let title = format!("{} runs, {} {did}", grouped(self.runs), grouped(self.reached));
        let mut out = format!("\n{}\n", style.bold(&title));
        out.extend(self.done.as_ref().map(Done::text));
        if let (Some(mean), Some(most)) = (self.mean_steps, self.most_steps) {
            let _ = writeln!(out, "  steps: {mean:.2} on average, at most {}", grouped(most));
        }
        if self.given_up > 0 {
            let _ =
                writeln!(out, "  {} given up after {} steps", grouped(self.given_up), grouped(self.limit));
        }
        let _ = writeln!(out, "\n  The first run");
        for (number, step) in self.first.iter().take(SHOWN).enumerate() {
            let _ = writeln!(out, "  {:>4}  {}  {}", number + 1, escape::line(&step.action), step.state);
        }
        if self.first.len() > SHOWN {
            let _ = writeln!(out, "  {} further steps", grouped((self.first.len() - SHOWN) as u64));
        }
        if let Some(last) = &self.last {
            let _ = writeln!(out, "   end  {last}");
        }
        out
    }
}
