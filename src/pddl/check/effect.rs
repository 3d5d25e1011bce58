//! Effects.

use num_traits::{One, Signed, Zero};

use super::Checker;
use super::requirements::Requirement;
use crate::syntax::Node;
use crate::task::{Condition, Effect};
use meliora_base::exact::{Ratio, decimal};
use meliora_base::stack;

impl Checker {
    /// Reads an effect.
    pub(super) fn effect(&mut self, node: &Node) -> Option<Effect> {
        stack::level(|| self.effect_here(node))
    }

    fn effect_here(&mut self, node: &Node) -> Option<Effect> {
        let Some((name, parts)) = node.form() else {
            if node.list().is_some_and(<[Node]>::is_empty) {
                return Some(Effect::And(Vec::new()));
            }
            if self.is_bare_atom(node) {
                return self.change(node, true);
            }
            return self.report(node.expected("an effect in brackets"));
        };
        match name {
            "and" => {
                let all: Vec<_> = parts.iter().map(|part| self.effect(part)).collect();
                all.into_iter().collect::<Option<_>>().map(Effect::And)
            }
            "not" => {
                let [inner] = self.exactly(node, parts, "not")?;
                self.change(inner, false)
            }
            "when" => {
                self.used.add(Requirement::Conditional);
                let [condition, inner] = self.exactly(node, parts, "when")?;
                let condition = self.condition(condition, true);
                let inner = self.effect(inner);
                Some(Effect::When(condition?, Box::new(inner?)))
            }
            "forall" => {
                self.used.add(Requirement::Conditional);
                let (domains, inner) = self.scoped(node, parts, |checker, inner| checker.effect(inner))?;
                Some(Effect::All(domains, Box::new(inner?)))
            }
            "oneof" => {
                self.used.add(Requirement::OneOf);
                if parts.is_empty() {
                    return self
                        .report(node.wrong("`oneof` has no outcome").help("write `(and)` for no change"));
                }
                self.alternatives += 1;
                let all: Vec<_> = parts.iter().map(|part| self.effect(part)).collect();
                self.alternatives -= 1;
                all.into_iter().collect::<Option<_>>().map(Effect::OneOf)
            }
            "probabilistic" => self.probabilistic(node, parts),
            "increase" | "decrease" | "assign" | "scale-up" | "scale-down" => {
                self.amount(node, name, parts).map(Effect::Earn)
            }
            _ => self.change(node, true),
        }
    }

    /// Reads a fact that is added or deleted.
    fn change(&mut self, node: &Node, is_added: bool) -> Option<Effect> {
        let atom = self.atom(node)?;
        let predicate = &mut self.predicates[atom.predicate];
        if predicate.is_derived {
            let message = format!("`{}` is derived and cannot be changed", predicate.name);
            return self.report(node.wrong(message).label("defined by `:derived`"));
        }
        predicate.is_changed = true;
        Some(Effect::Literal(atom, is_added))
    }

    fn probabilistic(&mut self, node: &Node, parts: &[Node]) -> Option<Effect> {
        self.used.add(Requirement::Probabilistic);
        let (mut all, mut sum) = (Vec::new(), Ratio::zero());
        for pair in parts.chunks(2) {
            let [probability, effect] = pair else {
                return self
                    .report(node.wrong("`probabilistic` is a list of pairs: a probability and an effect"));
            };
            let (read, effect) = (self.probability(probability), self.effect(effect));
            let read = read?;
            if read.is_negative() || read > Ratio::one() {
                return self.report(probability.wrong("a probability lies between 0 and 1"));
            }
            sum += &read;
            all.push((read, effect?));
        }
        if sum > Ratio::one() {
            let message = format!("the probabilities sum to {sum}, which is more than 1");
            return self.report(node.wrong(message).label("more than 1"));
        }
        Some(Effect::Probably(all))
    }

    /// Reads a probability, which is a number.
    fn probability(&mut self, node: &Node) -> Option<Ratio> {
        let is_function =
            |name: &str| self.functions.iter().any(|known| known.name.eq_ignore_ascii_case(name));
        if let Some((name, _)) = node.form()
            && (matches!(name, "+" | "-" | "*" | "/") || is_function(name))
        {
            let wrong =
                node.wrong(format!("probabilities that are computed, here by `{name}`, are not supported"));
            return self
                .report(wrong.label("expected a number").help("write a number such as `0.25` or `1/4`"));
        }
        self.ratio(node)
    }

    /// Reads a number such as `0.25` or `1/4`.
    pub(super) fn ratio(&mut self, node: &Node) -> Option<Ratio> {
        let word = node.word().unwrap_or_default();
        let read = match word.split_once('/') {
            Some((above, below)) => decimal(above).and_then(|above| Ok((above, decimal(below)?))),
            None => decimal(word).map(|number| (number, Ratio::one())),
        };
        match read {
            Ok((above, below)) if !below.is_zero() => Some(above / below),
            _ => self.report(node.expected("a number")),
        }
    }

    /// Reads the condition of an action, or of a rule; an absent one is always true.
    pub(super) fn optional_condition(&mut self, node: Option<&Node>) -> Option<Condition> {
        node.map_or(Some(Condition::And(Vec::new())), |node| self.condition(node, true))
    }
}
