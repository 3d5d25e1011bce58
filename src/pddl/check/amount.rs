//! Numbers: what effects add to the measures, functions whose values never change, and the reward of the goal.

use ahash::AHashMap;
use meliora_base::exact::Ratio;
use num_traits::Signed;

use super::Checker;
use super::requirements::Requirement;
use crate::syntax::Node;
use crate::task::{Amount, Function, Measure, Term, objects};

impl Checker {
    /// Reads `(increase (total-cost) 5)` or `(decrease (reward) (worth ?x))`; refuses other changes of numbers.
    pub(super) fn amount(&mut self, node: &Node, name: &str, parts: &[Node]) -> Option<Amount> {
        let target = parts.first().and_then(measured);
        let (measure, sign) = match (target, name) {
            (Some(measure), "increase") => (measure, 1),
            (Some(Measure::Reward), "decrease") => (Measure::Reward, -1),
            _ => {
                let shown = parts.first().map_or("a number", |part| part.text());
                let wrong = node.wrong(format!("numbers that change, such as `{shown}`, are not supported"));
                return self.report(wrong.help(
                    "`(increase (total-cost) NUMBER)` is, and `increase` or `decrease` of `(reward)`",
                ));
            }
        };
        self.measure(measure);
        let [_, of] = self.exactly(node, parts, name)?;
        if self.alternatives > 0 {
            let wrong = node.wrong("a number that depends on the outcome of `oneof` is not supported");
            return self.report(wrong.help("`probabilistic` states how likely each outcome is"));
        }
        let sign = Ratio::from_integer(sign.into());
        if let Some((function, arguments)) = of.form() {
            let value = self.value_of(of, function, arguments)?;
            self.unused_functions.retain(|(unused, _)| *unused != value.0);
            return Some(Amount { measure, number: sign, function: Some(value) });
        }
        let number = self.ratio(of)?;
        if measure == Measure::Cost && number.is_negative() {
            return self.report(of.wrong("a cost is at least 0"));
        }
        Some(Amount { measure, number: number * sign, function: None })
    }

    /// Notes that the problem uses a measure.
    fn measure(&mut self, measure: Measure) {
        self.measures.insert(measure);
        self.used.add(match measure {
            Measure::Cost => Requirement::Costs,
            Measure::Reward => Requirement::Rewards,
        });
    }

    /// Reads `(:goal-reward 10)`.
    pub(super) fn goal_reward(&mut self, parts: &[Node], node: &Node) {
        self.measure(Measure::Reward);
        let Some([number]) = self.exactly(node, parts, ":goal-reward") else { return };
        if self.goal_reward.is_some() {
            self.report::<()>(node.wrong("the goal has two rewards"));
        }
        self.goal_reward = self.ratio(number);
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
            if let Some(measure) = measured(node) {
                self.measure(measure);
                continue;
            }
            match node.form() {
                Some((_, parameters)) => {
                    let arity = self.placeholders(parameters).len();
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
        if measured(of).is_some() {
            return;
        }
        let (name, arguments) = of.form().unwrap_or((of.word().unwrap_or_default(), &[]));
        let Some((function, terms)) = self.value_of(of, name, arguments) else { return };
        if let (Some(objects), Some(value)) = (objects(&terms), self.ratio(value)) {
            self.functions[function].values.insert(objects, value);
        }
    }
}

/// Returns the measure that `(total-cost)`, `(reward)`, or the word alone names.
fn measured(node: &Node) -> Option<Measure> {
    match node.word().or_else(|| node.form().filter(|(_, parts)| parts.is_empty()).map(|form| form.0)) {
        Some("total-cost") => Some(Measure::Cost),
        Some("reward") => Some(Measure::Reward),
        _ => None,
    }
}
