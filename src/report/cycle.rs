//! The cycle of steps with which any number of improvements is made.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use super::reason::Words;
use super::text::{self, Probability};
use super::{Style, ranks};
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::preference::Preferences;
use meliora_model::valuation::Valuation;
use meliora_model::{Program, State};
use meliora_planning::lasso::{Lasso, LassoStep};
use meliora_planning::{Analysis, Kind, StrategyKind};

/// The maximum number of steps of a cycle that reports contain.
pub const MOST: usize = 1000;
/// The maximum number of steps that texts show one by one.
const SHOWN: usize = 20;

/// Steps that a strategy can repeat, of which at least one is an improvement.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "cycle")]
pub struct Cycle {
    /// The steps, with the successors that come closest to an improvement; at least one of the repeated ones
    /// improves.
    pub steps: Vec<CycleStep>,
    /// The position of the step, from 0, that comes again after the last one.
    pub repeats_from: usize,
    /// The kind of the improvements.
    #[serde(skip)]
    pub kind: Kind,
}

/// A step of a cycle.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct CycleStep {
    /// The values of the state before the step.
    pub state: Valuation,
    /// `opponent`: the opponent chooses the action; absent otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub owner: Option<&'static str>,
    /// The action.
    pub action: String,
    /// The values of the state entered.
    pub to: Valuation,
    /// The probability of this successor.
    pub probability: f64,
    /// The step is an improvement.
    pub improves: bool,
    /// The outcomes that are preferred to one of the reference.
    pub gained: Vec<String>,
    /// The values that change, for texts.
    #[serde(skip)]
    pub changed: String,
}

impl Cycle {
    /// Creates the report of a lasso.
    pub fn new(program: &Program, preferences: &Preferences, kind: Kind, lasso: Lasso) -> Self {
        let words = Words { program, preferences, kind: StrategyKind::from(kind), levels: kind };
        let valuation = |state: &State| Valuation::new(program, state);
        let step = |step: LassoStep| CycleStep {
            state: valuation(&step.state),
            owner: step.is_theirs.then_some("opponent"),
            to: valuation(&step.to),
            probability: step.probability,
            improves: step.improves,
            gained: words.names(&step.gained),
            changed: words.changed(&step.state, &step.to),
            action: step.action,
        };
        let steps = lasso.steps.into_iter().map(step).collect();
        Cycle { steps, repeats_from: lasso.repeats_from, kind }
    }

    /// Returns the cycle behind an unbounded rank of a state, by SASI if there is one; `None` for other ranks, and if it is
    /// too long to be shown. Cost: see [`Analysis::lasso`].
    ///
    /// # Errors
    /// The errors of [`Analysis::lasso`].
    pub fn find<E: Engine>(
        analysis: &Analysis<E>,
        program: &Arc<Program>,
        state: &[i64],
    ) -> Result<Option<Self>> {
        match Cycle::of_kind(analysis, program, Kind::Sasi, state)? {
            None => Cycle::of_kind(analysis, program, Kind::Spi, state),
            found => Ok(found),
        }
    }

    /// Does the same as [`Cycle::find`] for one kind.
    ///
    /// # Errors
    /// The errors of [`Analysis::lasso`].
    pub fn of_kind<E: Engine>(
        analysis: &Analysis<E>,
        program: &Arc<Program>,
        kind: Kind,
        state: &[i64],
    ) -> Result<Option<Self>> {
        let found = analysis.lasso(program, kind, state, MOST)?;
        Ok(found.map(|lasso| Cycle::new(program, analysis.preferences(), kind, lasso)))
    }

    /// Says why the rank is unbounded.
    pub(super) fn title(&self) -> String {
        format!("Any number of improvements is {}, because these steps can repeat", ranks::how(self.kind))
    }

    /// Says what the last step leads to.
    pub(super) fn end(&self) -> String {
        format!("then again from step {}", self.repeats_from + 1)
    }

    /// Returns the steps as rows: the number, the action, the values that change, and the effect. If there
    /// are many, a row stands for all steps until an improvement, or until the step that comes again.
    pub(super) fn rows(&self) -> Vec<[String; 4]> {
        let mut rows = Vec::new();
        let mut position = 0;
        while let Some(step) = self.steps.get(position) {
            let end = position + self.plain_steps(position);
            if self.steps.len() > SHOWN && end > position + 1 {
                let (numbers, to) = (format!("{}–{end}", position + 1), &self.steps[end - 1].to);
                rows.push([numbers, format!("{} …", step.action), format!("to {to}"), String::new()]);
                position = end;
            } else {
                let to = format!("to {}", step.changed);
                rows.push([(position + 1).to_string(), step.action.clone(), to, effect(step)]);
                position += 1;
            }
        }
        rows
    }

    /// Returns the number of steps from this one on before an improvement or the step that comes again.
    fn plain_steps(&self, position: usize) -> usize {
        let rest = self.steps[position..].iter().zip(position..);
        let is_plain = |(step, at): &(&CycleStep, usize)| {
            !step.improves && (*at == position || *at != self.repeats_from)
        };
        rest.take_while(is_plain).count()
    }

    /// Renders the cycle as text below the state where it starts.
    pub(super) fn text(&self, style: Style) -> String {
        let rows: Vec<Vec<String>> = self.rows().into_iter().map(Vec::from).collect();
        let mut out = format!("\n  {}\n", style.bold(&self.title()));
        for line in text::columns(&rows) {
            out += &format!("    {line}\n");
        }
        out + &format!("    {}\n", self.end())
    }
}

/// Describes a step: the opponent's choice, a probability below 1, and the objectives gained.
fn effect(step: &CycleStep) -> String {
    let chance = (step.probability < 1.0).then(|| format!("with {}", Probability(step.probability)));
    let owner = step.owner.map(|owner| format!("by the {owner}"));
    let gain = step.improves.then(|| format!("{} gained", text::either(&step.gained)));
    owner.into_iter().chain(chance).chain(gain).collect::<Vec<_>>().join(", ")
}
