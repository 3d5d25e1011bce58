//! `:init`: facts, several initial states by `oneof`, and a first random step by `probabilistic`.

use super::Checker;
use super::problem::Goals;
use crate::syntax::Node;
use crate::task::{Action, Atom, Condition, Effect, Object, Predicate, objects};

/// A predicate with its objects.
pub(super) type Fact = (usize, Vec<Object>);

/// Maximum number of initial states that `oneof` may describe.
const MOST_STARTS: usize = 1 << 12;
/// The action of the first random step, and the fact that it has been taken.
const START: &str = "start";
const STARTED: &str = "started";

impl Checker {
    /// Reads `:init`: the facts of all initial states, the further ones of each of them, and the effects of the first
    /// step.
    pub(super) fn initial(&mut self, problem: &[Node]) -> (Vec<Fact>, Vec<Vec<Fact>>, Vec<Effect>) {
        let (mut always, mut starts, mut first) = (Vec::new(), vec![Vec::new()], Vec::new());
        self.named(problem, ":init", |checker, parts, _| {
            let mut open: Vec<&Node> = parts.iter().rev().collect();
            while let Some(part) = open.pop() {
                match part.form() {
                    Some(("and", parts)) => open.extend(parts.iter().rev()),
                    Some(("=", values)) => checker.initial_value(part, values),
                    Some(("probabilistic", _)) => first.extend(checker.effect(part)),
                    _ => match checker.alternatives_of(part).as_slice() {
                        [only] => always.extend_from_slice(only),
                        several => starts = checker.product(part, &starts, several),
                    },
                }
            }
        });
        for (predicate, _) in starts.iter().flatten() {
            self.predicates[*predicate].is_changed = true;
        }
        starts.iter_mut().for_each(|start| start.sort_unstable());
        starts.sort_unstable();
        starts.dedup();
        (always, starts, first)
    }

    /// Returns the sets of facts that a part of `:init` allows.
    fn alternatives_of(&mut self, node: &Node) -> Vec<Vec<Fact>> {
        match node.form() {
            Some(("not", _)) => vec![Vec::new()],
            Some((name @ ("or" | "unknown" | "invariant"), _)) if !self.predicate_of.contains_key(name) => {
                self.refuse_incomplete(node, name);
                vec![Vec::new()]
            }
            Some((name @ ("probabilistic" | "="), _)) => {
                let wrong = node.wrong(format!("`{name}` cannot stand in a `oneof` of `:init`"));
                self.report::<()>(
                    wrong.help("write it outside of `oneof`: it is the same in all initial states"),
                );
                vec![Vec::new()]
            }
            Some(("and", parts)) => {
                // Facts that stand alone are added once, not in each product.
                let (mut always, mut all) = (Vec::new(), vec![Vec::new()]);
                for part in parts {
                    match self.alternatives_of(part).as_slice() {
                        [only] => always.extend_from_slice(only),
                        several => all = self.product(part, &all, several),
                    }
                }
                all.iter_mut().for_each(|facts| facts.extend_from_slice(&always));
                all
            }
            Some(("oneof", parts)) => {
                if parts.is_empty() {
                    self.report::<()>(node.wrong("`oneof` has no alternative"));
                }
                parts.iter().flat_map(|part| self.alternatives_of(part)).collect()
            }
            _ => vec![self.initial_fact(node).into_iter().collect()],
        }
    }

    /// Refuses a part of `:init` that leaves facts open. Such problems have many of them, so each name is reported once.
    fn refuse_incomplete(&mut self, node: &Node, name: &str) {
        let message = format!("incomplete initial states, here by `{name}`, are not supported");
        if self.faults.errors.iter().all(|known| known.message != message) {
            let help = "list the initial states by `oneof`: all facts of each one are known";
            self.report::<()>(node.wrong(message).help(help));
        }
    }

    /// Returns all unions of two sets of facts. After an error nobody needs them.
    fn product(&mut self, node: &Node, left: &[Vec<Fact>], right: &[Vec<Fact>]) -> Vec<Vec<Fact>> {
        if !self.faults.errors.is_empty() {
            return left.to_vec();
        }
        if left.len() * right.len() > MOST_STARTS {
            self.report::<()>(node.wrong(format!("`:init` has more than {MOST_STARTS} initial states")));
            return left.to_vec();
        }
        left.iter().flat_map(|left| right.iter().map(|right| [&left[..], right].concat())).collect()
    }

    fn initial_fact(&mut self, node: &Node) -> Option<Fact> {
        let atom = self.atom(node)?;
        if self.predicates[atom.predicate].is_derived {
            return self.report(node.wrong("a derived fact cannot stand in `:init`"));
        }
        Some((atom.predicate, objects(&atom.arguments)?))
    }

    /// Lets every path begin with one action that has these effects, if there are any. No other action is possible, and
    /// no goal holds, before.
    pub(super) fn begin_by(&mut self, mut effects: Vec<Effect>, goals: &mut Goals) {
        if effects.is_empty() {
            return;
        }
        let predicate = self.predicates.len();
        let unique = |name: &str, is_taken: &dyn Fn(&str) -> bool| {
            let mut name = name.to_owned();
            while is_taken(&name) {
                name.push('_');
            }
            name
        };
        let started = |holds| Condition::Literal(Atom { predicate, arguments: Vec::new() }, holds);
        let also = |condition: &mut Condition| {
            let before = std::mem::replace(condition, Condition::And(Vec::new()));
            *condition = Condition::And(vec![started(true), before]);
        };
        let name = unique(STARTED, &|name| self.predicate_of.contains_key(name));
        self.predicates.push(Predicate { name, parameters: Vec::new(), is_derived: false, is_changed: true });
        self.actions.iter_mut().for_each(|action| also(&mut action.precondition));
        goals.goal.iter_mut().for_each(also);
        goals.preferences.iter_mut().for_each(|(_, condition)| also(condition));
        effects.push(Effect::Literal(Atom { predicate, arguments: Vec::new() }, true));
        let known = |name: &str| self.actions.iter().any(|action| action.name.eq_ignore_ascii_case(name));
        self.actions.push(Action {
            name: unique(START, &known),
            parameters: Vec::new(),
            precondition: started(false),
            effect: Effect::And(effects),
            span: 0..0,
        });
    }
}
