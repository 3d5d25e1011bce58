//! Questions about a model, the options of their answers, and the strategies that are wanted, too.

use std::sync::Arc;

use crate::asking::Asking;
use crate::evaluate::{Mix, PropertyPolicy};
use crate::goal::{Required, Target};
use crate::plan::Plan;
use crate::warnings;
use meliora_base::error::{Error, Result};
use meliora_engine::{Selection, Settings};
use meliora_lang::property::term::TermKind;
use meliora_model::predicate::Predicate;
use meliora_model::{ModelKind, Program};
use meliora_planning::policy::Policy;

/// Questions about a model, with the requests that they need.
pub struct Questions {
    /// The model.
    pub program: Arc<Program>,
    /// The questions, and the requests.
    pub plan: Plan,
    /// The requirements.
    pub required: Vec<Required>,
    /// True if a question without an answer leaves the others: those of a file, or of the model.
    pub is_list: bool,
    /// For a `dtmc`, the states in which several choices are merged into one.
    pub overlap: Option<Predicate>,
}

/// The options of answers.
#[derive(Clone)]
pub struct Options {
    /// The settings of the engines.
    pub settings: Settings,
    /// The engine.
    pub selected: Selection,
    /// The largest width of a number; see [`crate::evaluate::Model::new`].
    pub precision: f64,
    /// True for one question, an error of which ends the work.
    pub is_one: bool,
    /// The regions of all properties are wanted.
    pub regions: bool,
    /// The strategies that are wanted of the only question.
    pub strategies: WantedStrategies,
}

/// The strategies that are wanted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WantedStrategies {
    /// The states with a strong plan.
    pub strong: bool,
    /// A policy for the target, the strategies of `multi`, or the strategy of one operator.
    pub policy: bool,
    /// The strategy of the opponent, of one operator in a game.
    pub opponent: bool,
}

/// The strategies that were found.
#[derive(Debug, Default)]
pub struct Strategies {
    /// A policy that reaches the target almost surely from all initial states; `None` if there is none.
    pub policy: Option<Policy>,
    /// The strategies that show the answer about several objectives; `None` if these are not asked for.
    pub mix: Option<Mix>,
    /// The strategy that attains the optimum of one operator; `None` if it is not asked for, or if there is none.
    pub optimal: Option<PropertyPolicy>,
    /// The strategy of the opponent; as `optimal`.
    pub opponent: Option<PropertyPolicy>,
}

/// The kinds of policies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PolicyKind {
    /// Rules that reach a target almost surely.
    Rules,
    /// Strategies for several objectives.
    Mix,
    /// The strategy that attains the optimum of one operator.
    Optimal,
}

impl Questions {
    /// Combines a model with questions about it; errors in one of a list leave the others.
    pub fn new(mut program: Program, plan: Plan, required: Vec<Required>, is_list: bool) -> Self {
        program.note_inexact(plan.requests.iter().flat_map(|request| request.asking.goal.predicates()));
        let overlap = warnings::overlap(&program);
        Questions { program: Arc::new(program), plan, required, is_list, overlap }
    }

    /// Returns whether strategies of one operator are wanted.
    pub(crate) fn wants_optimal(&self, wanted: WantedStrategies) -> bool {
        self.policy_kind() == PolicyKind::Optimal && (wanted.policy || wanted.opponent)
    }

    /// Checks that the only question has the strategies that are wanted.
    ///
    /// # Errors
    /// [`Error::Usage`].
    pub fn check(&self, wanted: WantedStrategies) -> Result<()> {
        let wrong = |message: &str| Err(Error::Usage(message.to_owned()));
        let kind = self.policy_kind();
        if wanted.opponent && kind != PolicyKind::Optimal {
            return wrong(
                "the strategy of the opponent is that of one property of a game, such as `<<p1>> Pmax=? [ F a ]`",
            );
        }
        if self.wants_optimal(wanted) {
            self.check_optimal().or_else(wrong)?;
        }
        if !wanted.strong && (!wanted.policy || kind != PolicyKind::Rules) {
            return Ok(());
        }
        if !self.only().is_some_and(|asking| matches!(asking.goal.target, Target::States(_))) {
            return wrong("strong plans are about reaching a target, not about other formulas");
        }
        if self.program.players.is_some() {
            return wrong(
                "policies and strong plans for a target are about models with one player; in a game, `strategy` \
                 without `--policy` lists the actions",
            );
        }
        if !self.required.is_empty() {
            return wrong("policies and strong plans for a target do not keep requirements: leave these out");
        }
        Ok(())
    }

    /// Checks that the only property is an operator whose strategy can be asked for. Returns the reason if it is not.
    fn check_optimal(&self) -> std::result::Result<(), &'static str> {
        let stated = self.plan.properties.first().and_then(|only| only.stated.as_ref());
        if !stated.is_some_and(|(_, term)| matches!(term.kind, TermKind::Operator(_))) {
            return Err(
                "the strategy of a property is that of one operator, such as `Pmax=? [ F a ]` or `R{\"cost\"}min=? [ F a ]`: \
                 ask for that alone",
            );
        }
        if self.program.kind == ModelKind::Dtmc {
            return Err("a `dtmc` has no choices, and so no strategies");
        }
        if !self.required.is_empty() {
            return Err(
                "strategies of properties do not keep requirements: leave these out, or add them to the formula",
            );
        }
        Ok(())
    }

    /// Returns the request that is the only question.
    fn only(&self) -> Option<&Asking> {
        let [only] = &self.plan.properties[..] else { return None };
        only.request().map(|request| &self.plan.requests[request].asking)
    }

    /// Returns the kind of the policy of the only question.
    pub fn policy_kind(&self) -> PolicyKind {
        // A `dtmc` has one policy.
        let is_chain = self.program.kind == ModelKind::Dtmc;
        let has_rules = |asking: &Asking| {
            let is_sure = asking.reached_surely().is_some() || (is_chain && asking.is_about_certainty());
            asking.question.is_none() || is_sure
        };
        match self.only() {
            _ if self.is_multi() => PolicyKind::Mix,
            Some(asking) if has_rules(asking) && asking.coalition.is_none() => PolicyKind::Rules,
            _ => PolicyKind::Optimal,
        }
    }

    /// Returns the text of the only property.
    pub fn text(&self) -> String {
        let stated = self.plan.properties.first().and_then(|only| only.stated.as_ref());
        stated.map(|(source, term)| source.on_one_line(term.span.range())).unwrap_or_default()
    }

    /// Returns whether the only question is about several objectives at once.
    pub fn is_multi(&self) -> bool {
        let [only] = &self.plan.properties[..] else { return false };
        matches!(&only.stated, Some((_, term)) if matches!(term.kind, TermKind::Multi(_)))
    }
}
