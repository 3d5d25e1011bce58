//! The delete relaxation of a program: rules that add facts and remove none.
//!
//! Each outcome of a command is a rule (the all-outcomes determinisation), whose conditions are facts of the guard.
//! Whatever a program reaches, its relaxation reaches, too: conditions have at most the facts that they need, and an
//! update whose new value is not known adds all facts of its variable.

use std::rc::Rc;

use ahash::AHashMap;

use super::facts::{Condition, Fact, Facts, all};
use meliora_base::error::Result;
use meliora_base::exact::Exact;
use meliora_base::progress::Poll;
use meliora_base::value::Value;
use meliora_model::expr::{ExprId, Node};
use meliora_model::predicate::Predicate;
use meliora_model::{Branch, CommandId, Program, Synchronisation, VarId};
use meliora_space::index::NOBODY;

/// Lists, one after the other.
#[derive(Default)]
pub(super) struct Lists {
    ends: Vec<u32>,
    items: Vec<u32>,
}

/// The rules of a program and a target.
pub(super) struct Relaxation {
    /// For each variable the lowest value, and the first list of its values in `passed`.
    variables: Vec<(i64, usize)>,
    /// The facts of each value of each variable.
    passed: Lists,
    pub(super) facts: usize,
    /// For each fact, the rules that have it as a condition.
    pub(super) uses: Lists,
    /// For each rule, the number of its conditions.
    pub(super) conditions: Vec<u32>,
    /// For each rule, the facts that it adds.
    pub(super) effects: Lists,
    /// For each rule the facts of its conditions.
    pub(super) needs: Lists,
    /// For each rule its command; [`NOBODY`] for an implication, which does not count as a step.
    pub(super) commands: Vec<u32>,
    /// The fact of the target.
    pub(super) target: Fact,
    /// The synchronisations of each command.
    pub(super) synchronisations: Lists,
    /// The facts that a variable has a value.
    equal: AHashMap<Fact, (u32, i64)>,
}

/// A rule in the making.
struct Rule {
    conditions: Rc<[Fact]>,
    effects: Vec<Effect>,
    command: u32,
    /// It says where the command is enabled, so it counts without effects.
    is_first: bool,
}

/// The facts that a rule adds.
enum Effect {
    /// The facts of a value of a variable.
    Value(u32, i64),
    /// All facts of a variable.
    Any(u32),
}

impl Lists {
    fn push(&mut self, list: impl IntoIterator<Item = u32>) {
        self.items.extend(list);
        self.ends.push(self.items.len() as u32);
    }

    /// Returns a list.
    #[inline]
    pub(super) fn of(&self, at: usize) -> &[u32] {
        let start = at.checked_sub(1).map_or(0, |before| self.ends[before]) as usize;
        &self.items[start..self.ends[at] as usize]
    }
}

impl Relaxation {
    /// Creates the relaxation of a program with a target.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(super) fn new(program: &Program, target: &Predicate, poll: &mut Poll<'_>) -> Result<Self> {
        let mut builder = Builder { program, facts: Facts::new(program, target.pool()), rules: Vec::new() };
        for synchronisation in &program.synchronisations {
            builder.synchronisation(synchronisation, poll)?;
        }
        let target = builder.facts.of(target.id(), true);
        let fact = builder.facts.count;
        builder.facts.count += 1;
        builder.facts.implied.extend(target.map(|condition| (condition, fact)));
        builder.finish(fact, poll)
    }

    /// Adds the facts of a state.
    pub(super) fn facts_of(&self, values: &[i64], into: &mut Vec<Fact>) {
        for (&(low, first), value) in self.variables.iter().zip(values) {
            if first != usize::MAX {
                into.extend_from_slice(self.passed.of(first + value.wrapping_sub(low) as usize));
            }
        }
    }
}

impl Relaxation {
    /// Lists facts that hold at most in any state after an outcome of a command: those of the values that its guard and
    /// its updates give, and all of the other variables.
    pub(super) fn after(&self, program: &Program, id: CommandId, branch: &Branch) -> Vec<Fact> {
        let mut known: Vec<Option<i64>> = vec![None; program.variables.len()];
        let rule = self.commands.iter().position(|&command| command == id.0);
        for fact in rule.into_iter().flat_map(|rule| self.needs.of(rule)) {
            if let Some(&(variable, value)) = self.equal.get(fact) {
                known[variable as usize] = Some(value);
            }
        }
        for &(variable, new) in &branch.updates {
            let old = known[variable.index()];
            known[variable.index()] = match program.pool.node(new) {
                Node::Literal(Value::Bool(value)) => Some(i64::from(value)),
                Node::Literal(Value::Int(value)) => Some(value),
                Node::Var(same) if same == variable => old,
                _ => None,
            };
        }
        let mut facts = Vec::new();
        for ((variable, &(low, first)), known) in program.variables.iter().zip(&self.variables).zip(known) {
            let count = (variable.high.wrapping_sub(low) as usize).saturating_add(1);
            let values = match known {
                _ if first == usize::MAX => continue,
                Some(value) => {
                    let at = first + value.wrapping_sub(low) as usize;
                    at..at + 1
                }
                None => first..first + count,
            };
            values.for_each(|at| facts.extend_from_slice(self.passed.of(at)));
        }
        facts
    }
}

/// Returns a fact with the variable and the value that it is about.
fn equation((&(variable, value, _), &fact): (&(u32, i64, bool), &Fact)) -> (Fact, (u32, i64)) {
    (fact, (variable, value))
}

/// Returns the branches of a command, those of probability 0 left out.
pub(super) fn outcomes(program: &Program, id: CommandId) -> impl Iterator<Item = &Branch> {
    let is_zero = |branch: &Branch| {
        let probability = program.pool.exact_literal(branch.probability).map(Exact::into_real);
        probability.is_some_and(|probability| probability.is_zero())
    };
    program.commands[id.index()].branches.iter().filter(move |branch| !is_zero(branch))
}

struct Builder<'p> {
    program: &'p Program,
    facts: Facts<'p>,
    rules: Vec<Rule>,
}

impl Builder<'_> {
    /// Adds the rules of a synchronisation. Each command adds its own effects, where some command
    /// of each other factor is enabled.
    fn synchronisation(&mut self, of: &Synchronisation, poll: &mut Poll<'_>) -> Result<()> {
        let mut enabled = Vec::new();
        if of.factors.len() > 1 {
            for factor in &of.factors {
                let guards: Vec<Condition> = factor.iter().map(|c| self.guard(*c)).collect();
                enabled.push(self.facts.any(&guards));
            }
        }
        for (at, factor) in of.factors.iter().enumerate() {
            let others = enabled.iter().enumerate().filter(|&(other, _)| other != at);
            let others: Vec<Condition> = others.map(|(_, condition)| condition.clone()).collect();
            for &command in factor {
                poll.step()?;
                let condition = all(&[std::slice::from_ref(&self.guard(command)), &others[..]].concat());
                if let Some(condition) = condition {
                    self.command(command, &condition);
                }
            }
        }
        Ok(())
    }

    fn guard(&mut self, command: CommandId) -> Condition {
        self.facts.of(self.program.commands[command.index()].guard, true)
    }

    fn command(&mut self, id: CommandId, condition: &Rc<[Fact]>) {
        let begin = self.rules.len();
        for branch in outcomes(self.program, id) {
            let first = self.rules.len();
            let is_first = first == begin;
            self.rules.push(Rule {
                conditions: Rc::clone(condition),
                effects: Vec::new(),
                command: id.0,
                is_first,
            });
            for &(variable, new) in &branch.updates {
                self.update(first, variable, new, condition);
            }
        }
    }

    /// Adds what an update adds: to the rule of the outcome where it has no condition of its own, else as another
    /// rule.
    fn update(&mut self, outcome: usize, variable: VarId, new: ExprId, condition: &Rc<[Fact]>) {
        let pool = self.facts.pool;
        match pool.node(new) {
            Node::Var(same) if same == variable => {}
            Node::Literal(value) => self.rules[outcome].effects.push(effect(variable, value)),
            Node::Ite(when, then, otherwise) => {
                let conditions = [(when, true, then), (when, false, otherwise)];
                for (when, holds, new) in conditions {
                    let when = all(&[Some(Rc::clone(condition)), self.facts.of(when, holds)]);
                    if let Some(when) = when {
                        self.conditional(outcome, variable, new, (&when, condition));
                    }
                }
            }
            _ => self.computed(outcome, variable, new, condition),
        }
    }

    /// Adds an update under a condition, which is at least as strong as that of the outcome.
    fn conditional(
        &mut self,
        outcome: usize,
        variable: VarId,
        new: ExprId,
        (when, condition): (&Rc<[Fact]>, &Rc<[Fact]>),
    ) {
        if when == condition {
            return self.update(outcome, variable, new, condition);
        }
        let own = self.rules.len();
        let command = self.rules[outcome].command;
        self.rules.push(Rule { conditions: Rc::clone(when), effects: Vec::new(), command, is_first: false });
        self.update(own, variable, new, when);
    }

    /// Adds an update that computes a value: one rule for each value of the variable that it reads. If it reads
    /// several, or one with too many values, the new value may be any.
    fn computed(&mut self, outcome: usize, variable: VarId, new: ExprId, condition: &Rc<[Fact]>) {
        let read = self.facts.pool.support(new);
        let [read] = read.as_slice() else {
            return self.rules[outcome].effects.push(Effect::Any(variable.0));
        };
        if !self.facts.has_values(read.0) {
            return self.rules[outcome].effects.push(Effect::Any(variable.0));
        }
        let (low, high) =
            (self.program.variables[read.index()].low, self.program.variables[read.index()].high);
        let mut state = vec![0; self.program.variables.len()];
        let command = self.rules[outcome].command;
        for value in low..=high {
            state[read.index()] = value;
            let Ok(found) = self.facts.pool.eval(new, &state) else { continue };
            let when = all(&[Some(Rc::clone(condition)), self.facts.value(read.0, value, true)]);
            if let Some(conditions) = when {
                let effects = vec![effect(variable, found)];
                self.rules.push(Rule { conditions, effects, command, is_first: false });
            }
        }
    }

    fn finish(self, target: Fact, poll: &mut Poll<'_>) -> Result<Relaxation> {
        let Builder { program, facts, rules } = self;
        let mut found = Relaxation {
            variables: Vec::new(),
            passed: Lists::default(),
            facts: facts.count as usize,
            uses: Lists::default(),
            conditions: Vec::new(),
            effects: Lists::default(),
            needs: Lists::default(),
            commands: Vec::new(),
            target,
            synchronisations: synchronisations(program),
            equal: facts.values.iter().filter(|((.., holds), _)| *holds).map(equation).collect(),
        };
        for (variable, lists) in program.variables.iter().zip(&facts.passed) {
            let first = if lists.is_empty() { usize::MAX } else { found.passed.ends.len() };
            found.variables.push((variable.low, first));
            lists.iter().for_each(|list| found.passed.push(list.iter().copied()));
        }
        for Rule { conditions, effects, command, is_first } in rules {
            poll.step()?;
            let mut added = Vec::new();
            for effect in effects {
                match effect {
                    Effect::Value(variable, value) => added.extend(facts.passed_by(variable, value)),
                    Effect::Any(variable) => added.extend(facts.passed[variable as usize].iter().flatten()),
                }
            }
            added.retain(|fact| conditions.binary_search(fact).is_err());
            if is_first || !added.is_empty() {
                found.add(&conditions, added, command);
            }
        }
        for (conditions, fact) in &facts.implied {
            found.add(conditions, vec![*fact], NOBODY);
        }
        found.invert();
        Ok(found)
    }
}

impl Relaxation {
    fn add(&mut self, conditions: &[Fact], mut effects: Vec<Fact>, command: u32) {
        effects.sort_unstable();
        effects.dedup();
        self.conditions.push(conditions.len() as u32);
        self.needs.push(conditions.iter().copied());
        self.effects.push(effects);
        self.commands.push(command);
    }

    fn invert(&mut self) {
        let mut uses = vec![Vec::new(); self.facts];
        for rule in 0..self.conditions.len() {
            self.needs.of(rule).iter().for_each(|&fact| uses[fact as usize].push(rule as u32));
        }
        uses.into_iter().for_each(|list| self.uses.push(list));
    }
}

/// Returns the synchronisations of each command.
fn synchronisations(program: &Program) -> Lists {
    let mut of_commands = vec![Vec::new(); program.commands.len()];
    for (synchronisation, number) in program.synchronisations.iter().zip(0..) {
        let commands = synchronisation.factors.iter().flatten();
        commands.for_each(|command| of_commands[command.index()].push(number));
    }
    let mut lists = Lists::default();
    of_commands.into_iter().for_each(|list| lists.push(list));
    lists
}

fn effect(variable: VarId, value: Value) -> Effect {
    match value {
        Value::Bool(value) => Effect::Value(variable.0, i64::from(value)),
        Value::Int(value) => Effect::Value(variable.0, value),
        Value::Real(_) => Effect::Any(variable.0),
    }
}
