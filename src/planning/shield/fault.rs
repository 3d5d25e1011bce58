//! Validation of shields: the conditions that a table must meet whatever model it belongs to.
//!
//! A shield that is read from a file is untrusted. Its promises follow from its table if the table
//! is well formed, every step is known, secure nodes permit only steps to secure nodes that weaken
//! nothing and keep the reference or improve on it, and permitted steps can make the improvements
//! that are ahead, and keep and achieve the objectives that are pursued.

use std::fmt::Display;
use std::hash::Hash;

use ahash::{AHashMap, AHashSet};

use super::by_value::SAFETY;
use super::{Shield, ShieldAction, ShieldNode, ShieldVariable, safe_modes};
use crate::analysis::levels::Kind;
use crate::{Safety, StrategyKind};
use meliora_base::error::ensure;

/// The end of a step in the search for nodes that lead to an end.
enum Leads {
    ToTheEnd,
    /// To a node from which the end may be reached.
    On,
    Elsewhere,
}

/// A condition that holds, or the fault.
pub(super) type Check = Result<(), String>;

impl Shield {
    /// Checks the table. Returns the first fault.
    ///
    /// The kind and the safety mode exist, no name, class, start state or action of a node occurs
    /// twice, and numbers are in range. Every action has a successor, and the state of a successor
    /// tells its node. Nodes of one state have its class, owner and steps. References are those of the
    /// safety mode. Permitted steps of secure nodes enter secure nodes and weaken nothing.
    ///
    /// From nodes with improvements ahead, permitted steps can make the next one; if improvements are
    /// sure, each of them does, or leaves as many ahead. A strategy of the kind `achieve` pursues the same
    /// objectives everywhere. From nodes that pursue objectives, permitted steps keep and can achieve them.
    /// In a node of the opponent all actions are permitted, and each of them leads on. By value, permitted actions are those
    /// of the rule. Cost: linear in the
    /// size of the table, up to the number of actions of a node.
    pub fn fault(&self) -> Option<String> {
        self.check().err()
    }

    fn check(&self) -> Check {
        self.check_modes()?;
        self.check_names()?;
        self.check_classes()?;
        let count = self.nodes.len();
        ensure(self.starts <= count, || format!("{} start states, but {count} nodes", self.starts))?;
        self.each(Self::check_state)?;
        let starts = self.nodes[..self.starts].iter().map(|node| &node.state);
        if let Some(state) = repeated(starts) {
            return Err(format!("two start nodes have the state {}", self.shown(state)));
        }
        self.each(Self::check_numbers)?;
        self.each(Self::check_successors)?;
        self.check_agreement()?;
        if let Some(rule) = &self.rule {
            return self.check_values(rule);
        }
        let is_plain = |node: &ShieldNode| !node.decided && node.actions.iter().all(|a| a.value.is_none());
        self.each(|shield, v| ensure(is_plain(&shield.nodes[v]), || "values without a rule".to_owned()))?;
        self.each(Self::check_reference)?;
        self.each(Self::check_promise)?;
        self.check_progress()?;
        if self.is_sure() {
            self.each(Self::check_sure)?;
        }
        self.check_aims()?;
        self.check_pursuit()
    }

    /// Runs a check of every node; a fault says which node has it.
    pub(super) fn each(&self, check: impl Fn(&Self, usize) -> Check) -> Check {
        (0..self.nodes.len()).try_for_each(|v| check(self, v).map_err(|fault| self.at(v, &fault)))
    }

    fn at(&self, v: usize, fault: &str) -> String {
        let state = &self.nodes[v].state;
        match state.len() == self.variables.len() {
            true => format!("node {v}, {}: {fault}", self.shown(state)),
            false => format!("node {v}: {fault}"),
        }
    }

    /// Formats a state as `s=1,on=0`.
    fn shown(&self, state: &[i64]) -> String {
        let pairs = self.variables.iter().zip(state);
        pairs
            .map(|(variable, value)| format!("{}={value}", plain(&variable.name)))
            .collect::<Vec<_>>()
            .join(",")
    }

    fn check_modes(&self) -> Check {
        let kinds: Vec<&str> = match self.rule {
            Some(_) => vec![SAFETY],
            None => StrategyKind::ALL.iter().map(|kind| kind.name()).collect(),
        };
        one_of("kind", &self.kind, &kinds)?;
        one_of("safety mode", &self.safety, &safe_modes())
    }

    fn check_names(&self) -> Check {
        once("two variables are called", self.variables.iter().map(|variable| &variable.name))?;
        once("two actions are called", &self.actions)?;
        for variable in &self.variables {
            let name = plain(&variable.name);
            once(&format!("two values of the variable `{name}` are called"), &variable.values)?;
            ensure(!variable.boolean || variable.values.is_empty() && variable.low == 0, || {
                format!("the variable `{name}` is Boolean, and has names or a least value")
            })?;
            ensure(variable.monitor.is_none_or(|value| variable.has(value)), || {
                format!("the monitor `{name}` starts with a value that it cannot have")
            })?;
        }
        Ok(())
    }

    fn check_classes(&self) -> Check {
        let count = self.classes.len();
        for class in &self.classes {
            once("a class twice has the objective", class)?;
        }
        if let Some(class) = repeated(&self.classes) {
            return Err(format!("two classes are {{{}}}", plain(&class.join(", "))));
        }
        ensure(self.weakening.len() == count, || {
            format!("{count} classes, but {} lists of weakening classes", self.weakening.len())
        })?;
        for (class, row) in self.weakening.iter().enumerate() {
            let is_well_formed =
                row.is_sorted_by(|a, b| a < b) && row.iter().all(|&other| other < count && other != class);
            ensure(is_well_formed, || {
                format!("the classes to which class {class} weakens are not other classes in ascending order")
            })?;
        }
        Ok(())
    }

    fn check_state(&self, v: usize) -> Check {
        let state = &self.nodes[v].state;
        let (found, wanted) = (state.len(), self.variables.len());
        ensure(found == wanted, || format!("{found} values, but {wanted} variables"))?;
        self.variables.iter().zip(state).try_for_each(|(variable, &value)| {
            ensure(variable.has(value), || format!("`{}` cannot be {value}", plain(&variable.name)))
        })
    }

    fn check_numbers(&self, v: usize) -> Check {
        let (node, classes) = (&self.nodes[v], self.classes.len());
        node.class.map_or(Ok(()), |class| in_range("class", class, classes))?;
        in_range("reference", node.reference, classes)?;
        for action in &node.actions {
            in_range("action", action.action, self.actions.len())?;
            let name = self.name(action);
            ensure(!action.next.is_empty(), || format!("the action `{name}` has no successor"))?;
            action.next.iter().try_for_each(|&to| in_range("successor", to, self.nodes.len()))?;
        }
        once("two entries for the action", node.actions.iter().map(|action| &self.actions[action.action]))?;
        in_range("pick", node.pick, node.actions.len())?;
        let pick = &node.actions[node.pick];
        let forbidden = node.actions.iter().find(|action| node.theirs && !action.permitted);
        if let Some(action) = forbidden {
            return Err(format!("the opponent's action `{}` is not permitted", self.name(action)));
        }
        ensure(pick.permitted, || format!("the action `{}` is picked and not permitted", self.name(pick)))
    }

    /// Checks that a step to a state enters one node, whatever the values of monitors.
    fn check_successors(&self, v: usize) -> Check {
        let mut known = AHashMap::new();
        for &to in self.nodes[v].actions.iter().flat_map(|action| &action.next) {
            let other = *known.entry(self.seen(to)).or_insert(to);
            ensure(other == to, || {
                format!(
                    "the successors {other} and {to} have the same state {}",
                    self.shown(&self.nodes[to].state)
                )
            })?;
        }
        Ok(())
    }

    /// Checks that nodes of one state, which differ in memory, have its class, its owner and its steps. The steps do not
    /// depend on monitors, either.
    fn check_agreement(&self) -> Check {
        let (mut of_state, mut of_seen) = (AHashMap::new(), AHashMap::new());
        for v in 0..self.nodes.len() {
            let node = &self.nodes[v];
            let other = *of_state.entry(node.state.clone()).or_insert(v);
            let is_same = node.class == self.nodes[other].class;
            ensure(is_same && self.steps(v, false) == self.steps(other, false), || {
                self.at(v, &format!("the node {other} of the same state has another class or other steps"))
            })?;
            let other = *of_seen.entry(self.seen(v)).or_insert(v);
            let is_same = node.theirs == self.nodes[other].theirs;
            ensure(is_same && self.steps(v, true) == self.steps(other, true), || {
                self.at(v, &format!("the node {other} of the same state has another owner or other steps"))
            })?;
        }
        Ok(())
    }

    /// Returns the actions of a node with the states that they enter, in an order: all values, or those that are seen.
    fn steps(&self, v: usize, only_seen: bool) -> Vec<(usize, Vec<Vec<i64>>)> {
        let state = |&to: &usize| if only_seen { self.seen(to) } else { self.nodes[to].state.clone() };
        let step = |action: &ShieldAction| {
            let mut next: Vec<Vec<i64>> = action.next.iter().map(state).collect();
            next.sort_unstable();
            next.dedup();
            (action.action, next)
        };
        let mut steps: Vec<_> = self.nodes[v].actions.iter().map(step).collect();
        steps.sort_unstable();
        steps
    }

    /// Returns the values of a node's state that an agent knows: without those of monitors.
    fn seen(&self, v: usize) -> Vec<i64> {
        let values = self.variables.iter().zip(&self.nodes[v].state);
        values.filter(|(variable, _)| variable.monitor.is_none()).map(|(_, &value)| value).collect()
    }

    /// Checks that steps are compared with the state before or, under `prefix`, with a reference that
    /// is kept or becomes the class of the state that is entered.
    fn check_reference(&self, v: usize) -> Check {
        let own = |node: &ShieldNode| match node.class {
            Some(class) => node.reference == class,
            // An unsafe state belongs to no class; nothing is guaranteed there.
            None => self.classes[node.reference].is_empty(),
        };
        let node = &self.nodes[v];
        ensure(own(node) || self.has_reference() && v >= self.starts, || {
            "the reference is not the class of the state".to_owned()
        })?;
        let next = || node.actions.iter().flat_map(|action| &action.next);
        let strange = next().find(|&&to| self.nodes[to].reference != node.reference && !own(&self.nodes[to]));
        strange.map_or(Ok(()), |to| {
            Err(format!("the reference of its successor {to} is neither its own nor that of the successor"))
        })
    }

    fn check_promise(&self, v: usize) -> Check {
        let node = &self.nodes[v];
        ensure(!node.secure || node.class.is_some(), || "an unsafe state is said to be secure".to_owned())?;
        let is_secure = |to: usize| self.nodes[to].secure;
        let mut permitted = node.actions.iter().filter(|action| action.permitted);
        let broken = permitted.find(|action| node.secure && !self.enters(v, action, is_secure));
        broken.map_or(Ok(()), |action| {
            let name = self.name(action);
            Err(format!("the permitted action `{name}` weakens or ends the promise of a secure state"))
        })
    }

    fn has_reference(&self) -> bool {
        self.safety.parse().is_ok_and(Safety::has_reference)
    }

    /// Returns whether a step leaves the reference as it is or, under `prefix`, improves on it: with
    /// another reference, later steps could weaken the one that was promised.
    pub(super) fn keeps_reference(&self, from: &ShieldNode, to: usize) -> bool {
        let to = &self.nodes[to];
        !self.has_reference()
            || to.reference == from.reference
            || to.class.is_some_and(|class| self.may_improve(from.reference, class))
    }

    /// Checks that from each node with k > 0 improvements ahead, permitted steps among nodes with as
    /// many ahead lead to an improvement after which at least k - 1 are ahead.
    fn check_progress(&self) -> Check {
        let able = self.able(Vec::new(), |v, to| {
            let (node, next) = (&self.nodes[v], &self.nodes[to]);
            match self.is_next_improvement(node, next) {
                true => Leads::ToTheEnd,
                false if node.ahead == next.ahead => Leads::On,
                false => Leads::Elsewhere,
            }
        });
        self.each(|shield, v| {
            ensure(able[v] || shield.nodes[v].ahead == Some(0), || {
                "improvements are ahead, but permitted steps cannot make the next one".to_owned()
            })
        })
    }

    /// Returns whether improvements that are ahead are promised to be almost sure.
    fn is_sure(&self) -> bool {
        StrategyKind::ALL.iter().any(|kind| kind.name() == self.kind && kind.levels() == Kind::Sasi)
    }

    /// Checks that where improvements are ahead, each permitted step makes the next one, or leaves as many ahead.
    fn check_sure(&self, v: usize) -> Check {
        let node = &self.nodes[v];
        let goes_on = |&to: &usize| {
            let next = &self.nodes[to];
            node.ahead == next.ahead || self.is_next_improvement(node, next)
        };
        let mut permitted = node.actions.iter().filter(|action| action.permitted && node.ahead != Some(0));
        let lost = permitted.find(|action| !action.next.iter().all(goes_on));
        lost.map_or(Ok(()), |action| {
            let name = self.name(action);
            Err(format!("after the permitted action `{name}`, fewer improvements may be ahead without one"))
        })
    }

    /// Checks that a strategy of the kind `achieve` pursues the same objectives everywhere.
    fn check_aims(&self) -> Check {
        let mut pursuing = (0..self.nodes.len()).filter(|&v| !self.nodes[v].pursues.is_empty());
        let Some(first) = pursuing.next().filter(|_| self.kind == StrategyKind::Achieve.name()) else {
            return Ok(());
        };
        let other = pursuing.find(|&v| self.nodes[v].pursues != self.nodes[first].pursues);
        other.map_or(Ok(()), |v| Err(self.at(v, &format!("the node {first} pursues other objectives"))))
    }

    /// Checks that from each node that pursues objectives, permitted steps lead to nodes that do so,
    /// too, and can lead to one where they are achieved. Nothing is promised about steps after that.
    fn check_pursuit(&self) -> Check {
        let pursues = |node: &ShieldNode| !node.pursues.is_empty();
        let goes_on = |node: &ShieldNode| pursues(node) && !node.achieved;
        for (v, node) in self.nodes.iter().enumerate().filter(|(_, node)| goes_on(node)) {
            let steps = node.actions.iter().filter(|action| action.permitted);
            for (action, &to) in steps.flat_map(|action| action.next.iter().map(move |to| (action, to))) {
                ensure(pursues(&self.nodes[to]), || {
                    let (name, aims) = (self.name(action), plain(&node.pursues.join(" and ")));
                    self.at(v, &format!("after the permitted action `{name}`, {aims} may not be sure"))
                })?;
            }
        }
        let achieved = (0..self.nodes.len()).filter(|&v| self.nodes[v].achieved).collect();
        let able = self.able(achieved, |v, _| match goes_on(&self.nodes[v]) {
            true => Leads::On,
            false => Leads::Elsewhere,
        });
        self.each(|shield, v| {
            ensure(able[v] || !pursues(&shield.nodes[v]), || {
                "objectives are pursued, but permitted steps cannot achieve them".to_owned()
            })
        })
    }

    /// Returns the nodes from which permitted steps lead to the end: some action may lead on, or in a
    /// node of the opponent each. The nodes of `found` are at the end already.
    fn able(&self, mut found: Vec<usize>, leads: impl Fn(usize, usize) -> Leads) -> Vec<bool> {
        let mut able = vec![false; self.nodes.len()];
        let mut led: Vec<Vec<bool>> = self.nodes.iter().map(|node| vec![false; node.actions.len()]).collect();
        let mut before = vec![Vec::new(); self.nodes.len()];
        let mut leading = Vec::new();
        for (v, node) in self.nodes.iter().enumerate() {
            for (at, action) in node.actions.iter().enumerate().filter(|(_, action)| action.permitted) {
                for &to in &action.next {
                    match leads(v, to) {
                        Leads::ToTheEnd => leading.push((v, at)),
                        Leads::On => before[to].push((v, at)),
                        Leads::Elsewhere => {}
                    }
                }
            }
        }
        loop {
            for (v, at) in leading.drain(..) {
                led[v][at] = true;
                if !self.nodes[v].theirs || led[v].iter().all(|led| *led) {
                    found.push(v);
                }
            }
            let Some(v) = found.pop() else { return able };
            if !std::mem::replace(&mut able[v], true) {
                leading.append(&mut before[v]);
            }
        }
    }

    /// Returns whether a step may be an improvement that leaves the others ahead.
    fn is_next_improvement(&self, from: &ShieldNode, to: &ShieldNode) -> bool {
        let Some(class) = to.class else { return false };
        let leaves = match (from.ahead, to.ahead) {
            (_, None) => true,
            (None, Some(_)) => false,
            (Some(k), Some(left)) => left.saturating_add(1) >= k,
        };
        self.may_improve(from.reference, class) && leaves
    }

    /// Returns whether a class may improve on a reference. An empty reference is improved by anything:
    /// the table does not say how `empty` is compared.
    fn may_improve(&self, reference: usize, class: usize) -> bool {
        let weakens = |from: usize, to: usize| self.weakening[from].binary_search(&to).is_ok();
        let improves = match self.classes[reference].is_empty() {
            true => !self.classes[class].is_empty(),
            false => weakens(class, reference),
        };
        improves && !weakens(reference, class)
    }

    pub(super) fn name(&self, action: &ShieldAction) -> String {
        plain(&self.actions[action.action])
    }
}

impl ShieldVariable {
    /// Returns whether the variable can have a value, as far as the table knows.
    fn has(&self, value: i64) -> bool {
        let names = i64::try_from(self.values.len()).unwrap_or(i64::MAX);
        let below = if self.boolean { 2 } else { self.low.saturating_add(names) };
        let is_bounded = self.boolean || names > 0;
        value >= self.low && (!is_bounded || value < below)
    }
}

fn one_of(what: &str, found: &str, all: &[&str]) -> Check {
    ensure(all.contains(&found), || format!("the {what} is `{}`, expected {}", plain(found), either(all)))
}

/// Formats names as "`a` or `b`".
pub(super) fn either(names: &[&str]) -> String {
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(" or ")
}

pub(super) fn in_range(what: &str, number: usize, count: usize) -> Check {
    ensure(number < count, || format!("the {what} {number} is out of range: there are {count}"))
}

/// Checks that no name occurs twice.
fn once<T: Display + Eq + Hash + Copy>(what: &str, names: impl IntoIterator<Item = T>) -> Check {
    repeated(names).map_or(Ok(()), |name| Err(format!("{what} `{}`", plain(&name.to_string()))))
}

/// Returns the first item that occurs a second time.
fn repeated<T: Eq + Hash + Copy>(items: impl IntoIterator<Item = T>) -> Option<T> {
    let mut known = AHashSet::new();
    items.into_iter().find(|&item| !known.insert(item))
}

/// Returns a name of the file without control characters.
fn plain(name: &str) -> String {
    name.escape_debug().to_string()
}
