//! The sets of one file of a dump. Each of the two files has its own name space. A set that no
//! check asks for is undefined, and the dump is refused.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};

use super::condition::Condition;
use super::error::{CheckError, CheckResult};
use meliora_dump::manifest::{File, Root, RootKind};
use meliora_dump::{Diagram, Edge};
use meliora_engine::symbolic::{ChoiceSet, StateSet, SymbolicEngine};
use meliora_engine::{Algebra, Count};
use meliora_model::region::RegionName;
use meliora_model::trend::Trend;

/// A layer or round, with the trend of the steps inside it that count.
pub(super) type Proven = (StateSet, Option<Trend>);

/// The sets of a file by name.
#[derive(Default)]
pub(super) struct Sets {
    states: BTreeMap<String, StateSet>,
    choices: BTreeMap<String, ChoiceSet>,
    /// The trends of the roots that have one.
    trends: BTreeMap<String, Trend>,
    asked: RefCell<BTreeSet<String>>,
}

impl Sets {
    /// Loads all sets of a file, and checks their sizes in nodes against the manifest.
    pub(super) fn load(engine: &SymbolicEngine, file: &File, diagram: &Diagram) -> CheckResult<Self> {
        let trends = file.roots.iter().filter_map(|r| Some((r.name.clone(), r.trend?))).collect();
        let mut sets = Sets { trends, ..Sets::default() };
        let (states, choices): (Vec<&Root>, Vec<&Root>) =
            file.roots.iter().partition(|r| r.kind == RootKind::States);
        let edges: Vec<Edge> = states.iter().map(|r| r.node).collect();
        for (root, set) in states.iter().zip(engine.load_states(diagram, &edges)?) {
            sets.states.insert(root.name.clone(), set);
        }
        let numbers = engine.numbered_choices().len();
        for root in choices {
            let Some(set) = engine.load_choices(diagram, root.node, numbers)? else {
                let condition = Condition::ModelChoices { name: root.name.clone() };
                return Err(CheckError::violated(condition, None));
            };
            sets.choices.insert(root.name.clone(), set);
        }
        let edges: Vec<Edge> = file.roots.iter().map(|r| r.node).collect();
        for (root, nodes) in file.roots.iter().zip(diagram.sizes(&edges)) {
            if root.nodes != nodes {
                let (name, said) = (root.name.clone(), root.nodes);
                let condition = Condition::Nodes { name, said, found: nodes };
                return Err(CheckError::violated(condition, None));
            }
        }
        Ok(sets)
    }

    /// Returns a set of states; a violation if the file does not have it.
    pub(super) fn states(&self, name: &RegionName) -> CheckResult<StateSet> {
        let name = self.asked(name);
        self.states.get(&name).cloned().ok_or_else(|| missing(&name, "states"))
    }

    /// Returns a set of choices; a violation if the file does not have it.
    pub(super) fn choices(&self, name: &RegionName) -> CheckResult<ChoiceSet> {
        let name = self.asked(name);
        self.choices.get(&name).cloned().ok_or_else(|| missing(&name, "choices"))
    }

    /// Remembers that a check asks for a set; returns its name in the file.
    fn asked(&self, name: &RegionName) -> String {
        let name = name.to_string();
        self.asked.borrow_mut().insert(name.clone());
        name
    }

    /// Returns the number of members of the set of a root.
    pub(super) fn count(&self, engine: &SymbolicEngine, root: &Root) -> CheckResult<Count> {
        let name = &root.name;
        match (root.kind, self.states.get(name), self.choices.get(name)) {
            (RootKind::States, Some(x), _) => Ok(engine.count(x)?),
            (RootKind::Choices, _, Some(c)) => Ok(engine.count(c)?),
            (RootKind::States, None, _) => Err(missing(name, "states")),
            (RootKind::Choices, _, None) => Err(missing(name, "choices")),
        }
    }

    /// Returns true if the file has a set of states with this name.
    pub(super) fn has(&self, name: &RegionName) -> bool {
        self.states.contains_key(&name.to_string())
    }

    /// Returns the sets of states named `name(0)`, `name(1)`, … up to the first that is missing,
    /// each with its trend.
    pub(super) fn sequence(&self, name: impl Fn(usize) -> RegionName) -> CheckResult<Vec<Proven>> {
        let names = (0..).map(name).take_while(|name| self.has(name));
        names.map(|name| Ok((self.states(&name)?, self.trends.get(&name.to_string()).copied()))).collect()
    }

    /// Returns all sets of states with their names.
    pub(super) fn all_states(&self) -> impl Iterator<Item = (&String, &StateSet)> {
        self.states.iter()
    }

    /// Returns the names that no check has asked for.
    pub(super) fn unknown(&self) -> impl Iterator<Item = &String> {
        let asked = self.asked.borrow().clone();
        self.states.keys().chain(self.choices.keys()).filter(move |name| !asked.contains(*name))
    }
}

fn missing(name: &str, kind: &'static str) -> CheckError {
    CheckError::violated(Condition::HasSet { name: name.to_owned(), kind }, None)
}
