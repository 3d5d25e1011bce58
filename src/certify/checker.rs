//! The sets of a dump, and the conditions that they are put to.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{Checked, Violation};
use crate::dump::manifest::{File, Kind};
use crate::dump::{Diagram, Dump, Edge};
use crate::engine::symbolic::{ChoiceSet, Encoding, StateSet, SymbolicEngine};
use crate::engine::{Engine, Settings};
use crate::error::Error;
use crate::model::preference::Preferences;
use crate::model::{Program, State};

/// Why the check ended.
pub(super) enum Stop {
    /// It could not go on.
    Error(Error),
    /// A condition does not hold.
    Violation(Violation),
}

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Stop::Error(error)
    }
}

impl Stop {
    /// A condition does not hold, in this state.
    pub(super) fn violated(condition: impl Into<String>, state: Option<State>) -> Self {
        Stop::Violation(Violation { condition: condition.into(), state })
    }
}

/// The result of a check.
pub(super) type Check<T = ()> = Result<T, Stop>;

/// The sets of a dump over an engine that has only the relations.
pub(super) struct Checker<'a> {
    pub(super) engine: SymbolicEngine,
    pub(super) preferences: &'a Preferences,
    pub(super) dump: &'a Dump,
    pub(super) checked: Vec<Checked>,
    states: BTreeMap<String, StateSet>,
    choices: BTreeMap<String, ChoiceSet>,
}

impl<'a> Checker<'a> {
    /// Rebuilds the relations over the dumped states and loads all sets.
    pub(super) fn new(
        program: &Arc<Program>,
        preferences: &'a Preferences,
        dump: &'a Dump,
        settings: Settings,
    ) -> Check<Self> {
        let manifest = &dump.manifest;
        let Some(order) = Encoding::order_of(program, &manifest.encoding.order) else {
            return Err(Stop::violated("the order of the bits is one of the model's bits", None));
        };
        let Some(all) = manifest.regions.root("reachable").and_then(|r| Edge::new(i64::from(r.node))) else {
            return Err(Stop::violated("the dump has the region `reachable`", None));
        };
        let engine = SymbolicEngine::with_states(Arc::clone(program), order, settings, &dump.regions, all)?;
        let (states, choices) = (BTreeMap::new(), BTreeMap::new());
        let mut checker = Checker { engine, preferences, dump, checked: Vec::new(), states, choices };
        checker.load(&manifest.regions, &dump.regions)?;
        if let (Some(file), Some(diagram)) = (&manifest.certificate, &dump.certificate) {
            checker.load(file, diagram)?;
        }
        Ok(checker)
    }

    fn load(&mut self, file: &File, diagram: &Diagram) -> Check {
        let edge = |node: i32| Edge::new(i64::from(node)).unwrap_or(Edge::FALSE);
        let roots: Vec<_> = file.roots.iter().filter(|r| r.kind == Kind::States).collect();
        let edges: Vec<Edge> = roots.iter().map(|r| edge(r.node)).collect();
        for (root, set) in roots.iter().zip(self.engine.load_states(diagram, &edges)?) {
            self.states.insert(root.name.clone(), set);
        }
        let numbers = self.engine.numbered_choices().len();
        for root in file.roots.iter().filter(|r| r.kind == Kind::Choices) {
            let Some(set) = self.engine.load_choices(diagram, edge(root.node), numbers)? else {
                return Err(Stop::violated(format!("`{}` has only choices of the model", root.name), None));
            };
            self.choices.insert(root.name.clone(), set);
        }
        Ok(())
    }

    /// A set of states that must be there.
    pub(super) fn states(&self, name: &str) -> Check<StateSet> {
        match self.states.get(name) {
            Some(x) => Ok(x.clone()),
            None => Err(Stop::violated(format!("the dump has `{name}`, which this check needs"), None)),
        }
    }

    /// A set of choices that must be there.
    pub(super) fn choices(&self, name: &str) -> Check<ChoiceSet> {
        match self.choices.get(name) {
            Some(c) => Ok(c.clone()),
            None => Err(Stop::violated(format!("the dump has `{name}`, which this check needs"), None)),
        }
    }

    /// Whether there is a set of states of this name.
    pub(super) fn has(&self, name: &str) -> bool {
        self.states.contains_key(name)
    }

    /// `prefix:0`, `prefix:1`, … as far as they go.
    pub(super) fn sequence(&self, prefix: &str) -> Vec<StateSet> {
        (0..).map_while(|j| self.states.get(&format!("{prefix}:{j}")).cloned()).collect()
    }

    /// The sets of states whose names begin so, with the rest of the name.
    pub(super) fn named(&self, prefix: &str) -> Vec<(String, StateSet)> {
        let all = self.states.iter();
        all.filter_map(|(name, x)| Some((name.strip_prefix(prefix)?.to_owned(), x.clone()))).collect()
    }

    /// Notes that a region is what it is said to be.
    pub(super) fn passed(&mut self, region: &str, inside: bool, outside: bool) {
        self.checked.push(Checked { region: region.to_owned(), inside, outside });
    }

    /// X ⊆ Y
    pub(super) fn subset(&self, x: &StateSet, y: &StateSet, condition: impl FnOnce() -> String) -> Check {
        let bad = self.engine.difference(x, y)?;
        if self.engine.is_empty(&bad) {
            return Ok(());
        }
        let example = self.engine.list_states(&bad, 1)?.pop();
        Err(Stop::violated(condition(), example))
    }

    /// X = Y
    pub(super) fn equal(&self, x: &StateSet, y: &StateSet, condition: impl Fn() -> String) -> Check {
        self.subset(x, y, &condition)?;
        self.subset(y, x, &condition)
    }

    /// C = D
    pub(super) fn equal_choices(
        &self,
        c: &ChoiceSet,
        d: &ChoiceSet,
        condition: impl Fn() -> String,
    ) -> Check {
        for (more, less) in [(c, d), (d, c)] {
            let bad = self.engine.sources(&self.engine.without_choices(more, less)?)?;
            self.subset(&bad, &self.engine.no_states(), &condition)?;
        }
        Ok(())
    }

    /// Layer 0 lies in `start`, each later layer in one step of the layer before, and together they
    /// have all of the region.
    pub(super) fn layers(
        &self,
        name: &str,
        region: &StateSet,
        start: &StateSet,
        step: impl Fn(&StateSet) -> Check<StateSet>,
    ) -> Check {
        let layers = self.sequence(&format!("layers:{name}"));
        let mut reached = self.engine.no_states();
        let mut bound = start.clone();
        for (j, layer) in layers.iter().enumerate() {
            let condition = || match j {
                0 => format!("each state of layer 0 of `{name}` is at the goal"),
                _ => format!("each state of layer {j} of `{name}` has a step into layer {}", j - 1),
            };
            self.subset(layer, &bound, condition)?;
            reached = self.engine.union(&reached, layer)?;
            if j + 1 < layers.len() {
                bound = step(layer)?;
            }
        }
        self.subset(region, &reached, || format!("each state of `{name}` is in one of its layers"))
    }

    /// The states: values only; from the initial ones and closed, or all of them.
    pub(super) fn scope(&mut self) -> Check {
        let engine = &self.engine;
        let all = self.states("reachable")?;
        self.subset(&all, &engine.valuations(), || {
            "each state of `reachable` has values in range".to_owned()
        })?;
        for (name, x) in &self.states {
            self.subset(x, &all, || format!("each state of `{name}` is one of `reachable`"))?;
        }
        let initial = engine.initial_states();
        if self.has("initial") {
            self.equal(&self.states("initial")?, &initial, || "`initial` are the initial states".to_owned())?;
        }
        let mut below = true;
        if self.dump.manifest.scope == "all" {
            let condition = || "`reachable` has all valuations, as the scope `all` says".to_owned();
            self.equal(&all, &engine.valuations(), condition)?;
        } else {
            self.subset(&initial, &all, || "each initial state is in `reachable`".to_owned())?;
            let next = engine.successors(&engine.all_choices())?;
            self.subset(&next, &all, || "each successor of a state of `reachable` is in it".to_owned())?;
            below = self.has("layers:reachable:0");
            if below {
                let step =
                    |x: &StateSet| Ok(engine.successors(&engine.choices_in(&engine.all_choices(), x)?)?);
                self.layers("reachable", &all, &initial, step)?;
            }
        }
        if let Some(choices) = self.choices.get("choices") {
            self.equal_choices(choices, &engine.all_choices(), || {
                "`choices` are the enabled ones".to_owned()
            })?;
        }
        if let Some(deadlocks) = self.states.get("deadlock") {
            let condition = || "`deadlock` are the states where nothing is enabled".to_owned();
            self.equal(deadlocks, &engine.deadlock_states(), condition)?;
        }
        self.passed("reachable", below, true);
        Ok(())
    }

    /// The counts in the manifest.
    pub(super) fn counts(&self) -> Check {
        for root in &self.dump.manifest.regions.roots {
            let count = match root.kind {
                Kind::States => self.engine.count_states(&self.states(&root.name)?)?,
                Kind::Choices => self.engine.count_choices(&self.choices(&root.name)?)?,
            };
            if count.to_string() != root.count {
                let condition = format!("`{}` has {} members: it has {count}", root.name, root.count);
                return Err(Stop::violated(condition, None));
            }
        }
        Ok(())
    }
}
