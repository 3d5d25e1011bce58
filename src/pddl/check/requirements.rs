//! `:requirements`: the features that a problem uses and declares.

use std::collections::BTreeSet;

use crate::syntax::Node;
use meliora_base::error::{Diagnostic, Severity};

/// A feature with a name in `:requirements`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Requirement {
    Typing,
    Equality,
    Negative,
    Disjunctive,
    Existential,
    Universal,
    Conditional,
    Derived,
    Costs,
    Rewards,
    Preferences,
    OneOf,
    Probabilistic,
}

impl Requirement {
    /// Returns the names that declare the feature, the usual one first.
    fn names(self) -> &'static [&'static str] {
        match self {
            Requirement::Typing => &[":typing", ":adl"],
            Requirement::Equality => &[":equality", ":adl"],
            Requirement::Negative => &[":negative-preconditions", ":adl"],
            Requirement::Disjunctive => &[":disjunctive-preconditions", ":adl"],
            Requirement::Existential => &[":existential-preconditions", ":quantified-preconditions", ":adl"],
            Requirement::Universal => &[":universal-preconditions", ":quantified-preconditions", ":adl"],
            Requirement::Conditional => &[":conditional-effects", ":adl"],
            Requirement::Derived => &[":derived-predicates", ":domain-axioms"],
            Requirement::Costs => &[":action-costs", ":fluents", ":numeric-fluents"],
            Requirement::Rewards => &[":rewards", ":mdp", ":fluents", ":numeric-fluents"],
            Requirement::Preferences => &[":preferences"],
            Requirement::OneOf => &[":non-deterministic", ":nondeterministic", ":oneof"],
            Requirement::Probabilistic => &[":probabilistic-effects", ":mdp"],
        }
    }
}

/// The features that a problem uses.
#[derive(Default)]
pub(super) struct Requirements(BTreeSet<Requirement>);

impl Requirements {
    pub(super) fn add(&mut self, requirement: Requirement) {
        self.0.insert(requirement);
    }

    pub(super) fn has_oneof(&self) -> bool {
        self.0.contains(&Requirement::OneOf)
    }

    /// Returns a note about the features that are used and not declared, if the domain or the problem
    /// declares any.
    pub(super) fn notes(&self, [domain, problem]: [&[Node]; 2]) -> Option<Diagnostic> {
        let is_declaration = |node: &&Node| node.form().is_some_and(|(name, _)| name == ":requirements");
        let all: Vec<&Node> = domain.iter().chain(problem).filter(is_declaration).collect();
        let node = all.first()?;
        let words = all.iter().filter_map(|node| node.list()).flatten();
        let declared: Vec<&str> = words.filter_map(Node::word).collect();
        let is_missing = |used: &&Requirement| !used.names().iter().any(|name| declared.contains(name));
        let missing: Vec<&str> = self.0.iter().filter(is_missing).map(|used| used.names()[0]).collect();
        if missing.is_empty() {
            return None;
        }
        let message =
            format!("`:requirements` does not declare {}, which the problem uses", missing.join(", "));
        Some(node.wrong(message).severity(Severity::Warning).label("read as if it were declared"))
    }
}
