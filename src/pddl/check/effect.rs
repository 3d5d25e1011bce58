//! Effects.

use ahash::AHashMap;
use num_traits::{One, Signed, Zero};

use super::Checker;
use super::requirements::Requirement;
use crate::syntax::Node;
use crate::task::{Condition, Cost, Effect, Function, Object, Term};
use meliora_base::exact::{Ratio, decimal};
use meliora_base::stack;

/// The function that actions increase.
const COST: &str = "total-cost";

impl Checker {
    /// Reads an effect; the increase of `total-cost` is added to `cost` where it is allowed.
    pub(super) fn effect(&mut self, node: &Node, cost: &mut Option<&mut Cost>) -> Option<Effect> {
        stack::level(|| self.effect_here(node, cost))
    }

    fn effect_here(&mut self, node: &Node, cost: &mut Option<&mut Cost>) -> Option<Effect> {
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
                let all: Vec<_> = parts.iter().map(|part| self.effect(part, cost)).collect();
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
                let inner = self.effect(inner, &mut None);
                Some(Effect::When(condition?, Box::new(inner?)))
            }
            "forall" => {
                self.used.add(Requirement::Conditional);
                let (domains, inner) =
                    self.scoped(node, parts, |checker, inner| checker.effect(inner, &mut None))?;
                Some(Effect::All(domains, Box::new(inner?)))
            }
            "oneof" => {
                self.used.add(Requirement::OneOf);
                if parts.is_empty() {
                    return self
                        .report(node.wrong("`oneof` has no outcome").help("write `(and)` for no change"));
                }
                let all: Vec<_> = parts.iter().map(|part| self.effect(part, &mut None)).collect();
                all.into_iter().collect::<Option<_>>().map(Effect::OneOf)
            }
            "probabilistic" => self.probabilistic(node, parts),
            "increase" | "decrease" | "assign" | "scale-up" | "scale-down" => {
                self.number(node, name, parts, cost)
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
            let (read, effect) = (self.ratio(probability), self.effect(effect, &mut None));
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

    /// Reads a number such as `0.25` or `1/4`.
    fn ratio(&mut self, node: &Node) -> Option<Ratio> {
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

    /// Reads `(increase (total-cost) 5)`, or by the value of a function; refuses other changes of numbers.
    fn number(
        &mut self,
        node: &Node,
        name: &str,
        parts: &[Node],
        cost: &mut Option<&mut Cost>,
    ) -> Option<Effect> {
        let target = parts.first().and_then(|part| part.word().or_else(|| part.form().map(|form| form.0)));
        if name != "increase" || target != Some(COST) {
            let shown = parts.first().map_or("a number", |part| part.text());
            let wrong = node.wrong(format!("numbers that change, such as `{shown}`, are not supported"));
            return self.report(wrong.help("only `(increase (total-cost) NUMBER)` is"));
        }
        self.has_cost = true;
        self.used.add(Requirement::Costs);
        let [_, amount] = self.exactly(node, parts, "increase")?;
        let Some(sum) = cost else {
            return self.report(node.wrong("a cost that depends on the outcome is not supported"));
        };
        if let Some((function, arguments)) = amount.form() {
            let value = self.value_of(amount, function, arguments)?;
            self.unused_functions.retain(|(unused, _)| *unused != value.0);
            sum.values.push(value);
            return Some(Effect::And(Vec::new()));
        }
        let amount = self.ratio(amount)?;
        if amount.is_negative() {
            return self.report(node.wrong("a cost is at least 0"));
        }
        sum.constant += amount;
        Some(Effect::And(Vec::new()))
    }

    /// Reads `(far ?a ?b)`: a function and its arguments.
    fn value_of(&mut self, node: &Node, name: &str, parts: &[Node]) -> Option<(usize, Vec<Term>)> {
        let Some(function) = self.functions.iter().position(|known| known.name.eq_ignore_ascii_case(name))
        else {
            let wrong =
                node.wrong(format!("unknown function `{name}`")).label("not declared in `:functions`");
            return self
                .report(wrong.help("a cost is a number, or the value of a function that never changes"));
        };
        let arity = self.functions[function].arity;
        if parts.len() != arity {
            let message = format!("`{name}` has {arity} arguments, here are {}", parts.len());
            return self.report(node.wrong(message).label("wrong number of arguments"));
        }
        let arguments: Option<Vec<Term>> = parts.iter().map(|part| self.term(part)).collect();
        Some((function, arguments?))
    }

    /// Declares functions: `total-cost`, and those whose values never change.
    pub(super) fn declare_functions(&mut self, parts: &[Node]) {
        for (node, _) in self.typed_list(parts) {
            match node.form() {
                Some((COST, _)) => {
                    self.has_cost = true;
                    self.used.add(Requirement::Costs);
                }
                Some((_, parameters)) => {
                    let arity = self.typed_variables(parameters).len();
                    let name = node.list().and_then(|list| list.first()).map_or("", Node::text).to_owned();
                    self.unused_functions.push((self.functions.len(), node.clone()));
                    self.functions.push(Function { name, arity, values: AHashMap::new() });
                }
                None => {
                    self.report::<()>(node.expected("a function such as `(total-cost)`"));
                }
            }
        }
    }

    /// Reads `(= (far a b) 5)` in `:init`.
    pub(super) fn initial_value(&mut self, node: &Node, parts: &[Node]) {
        let Some([of, value]) = self.exactly(node, parts, "=") else { return };
        let (name, arguments) = of.form().unwrap_or((of.word().unwrap_or_default(), &[]));
        if name == COST {
            return;
        }
        let Some((function, terms)) = self.value_of(of, name, arguments) else { return };
        let objects: Option<Vec<Object>> = terms
            .iter()
            .map(|term| match term {
                Term::Object(object) => Some(*object),
                Term::Variable(_) => None,
            })
            .collect();
        if let (Some(objects), Some(value)) = (objects, self.ratio(value)) {
            self.functions[function].values.insert(objects, value);
        }
    }

    /// Reads the condition of an action, or of a rule; an absent one is always true.
    pub(super) fn optional_condition(&mut self, node: Option<&Node>) -> Option<Condition> {
        node.map_or(Some(Condition::And(Vec::new())), |node| self.condition(node, true))
    }
}
