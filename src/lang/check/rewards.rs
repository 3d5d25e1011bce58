//! Reward structures. Errors in them do not prevent other uses of a model: they are warnings, until
//! the structure is used.

use ahash::AHashMap;

use super::actions::Actions;
use super::collect::Parts;
use super::lowerer::Lowerer;
use super::scope::NO_RENAMING;
use crate::ast::{Ident, RewardItem, Rewards, Span};
use meliora_base::error::{Diagnostic, Severity};
use meliora_base::slip::is_slip;
use meliora_base::value::Type;
use meliora_model::rewards::{self, Earner, RewardStructure};

impl<'a> Lowerer<'a> {
    /// Lowers all reward structures; `actions` are those of the composed model.
    pub(super) fn rewards(&mut self, parts: &Parts<'a>, actions: &[String]) -> Vec<RewardStructure> {
        let mut known = Actions::default();
        for action in actions {
            known.add(action);
        }
        let mut names: AHashMap<&str, Span> = AHashMap::new();
        parts.rewards.iter().map(|rewards| self.reward_structure(rewards, &known, &mut names)).collect()
    }

    fn reward_structure(
        &mut self,
        rewards: &'a Rewards,
        actions: &Actions,
        names: &mut AHashMap<&'a str, Span>,
    ) -> RewardStructure {
        let told = self.diagnostics.len();
        if let Some(name) = &rewards.name
            && let Some(first) = names.insert(&name.name, name.span)
        {
            let message = format!("the reward structure \"{}\" is defined twice", name.name);
            let diagnostic = self.wrong(name.span, message).label("defined again");
            self.report(diagnostic.related(first.range(), "defined here first"));
        }
        let items = rewards.items.iter().map(|item| self.reward_item(item, actions)).collect::<Vec<_>>();
        RewardStructure {
            name: rewards.name.as_ref().map(|name| name.name.clone()),
            items: items.into_iter().flatten().collect(),
            errors: self.diagnostics.split_off(told),
            span: rewards.span,
        }
    }

    fn reward_item(&mut self, item: &RewardItem, actions: &Actions) -> Option<rewards::RewardItem> {
        let earner = match &item.action {
            None => Some(Earner::State),
            Some(None) => Some(Earner::Action(None)),
            Some(Some(action)) => self.rewarded_action(action, actions),
        };
        let guard = self.condition(&item.guard, NO_RENAMING, "the guard of a reward");
        let value = self.typed(&item.value, NO_RENAMING, Type::Real, "a reward");
        let span = item.guard.to(item.value);
        Some(rewards::RewardItem { earner: earner?, guard: guard?, value: value?, span })
    }

    fn rewarded_action(&mut self, action: &Ident, actions: &Actions) -> Option<Earner> {
        if let Some(known) = actions.get(&action.name) {
            return Some(Earner::Action(Some(known)));
        }
        let diagnostic = self.wrong(action.span, format!("unknown action `{}`", action.name));
        let similar = actions.names.iter().find(|known| is_slip(known, &action.name));
        let diagnostic = match similar {
            Some(similar) => diagnostic.help(format!("did you mean `{similar}`?")),
            None => diagnostic,
        };
        self.report(diagnostic);
        None
    }
}

/// Returns the errors of reward structures as warnings.
pub(crate) fn warnings(structures: &[RewardStructure]) -> Vec<Diagnostic> {
    let errors = structures.iter().flat_map(|s| &s.errors);
    errors
        .map(|e| e.clone().severity(Severity::Warning).note("the reward structure cannot be used"))
        .collect()
}
