//! Files of policies with memory, as JSON: nodes, each a state with what the policy remembers there, and the actions that
//! it takes. What the fields promise is said, and checked, by [`meliora_certify::policy::nodes`].

use std::sync::Arc;

use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_certify::policy::rules::Taken;
use meliora_certify::policy::{Aim, Node, NodePolicy, Promise, Taking};
use meliora_dump::manifest::SafetyMode;
use meliora_model::Program;
use meliora_model::preference::{ObjectiveSet, Preferences};
use meliora_model::valuation::Valuation;
use meliora_planning::explain::{Action, Explanation};
use meliora_planning::induced_model;
use meliora_planning::{Rank, StrategyKind};

use super::policy_file::place;

/// The format, and its version.
const FORMAT: &str = "meliora policy 1";
const UNBOUNDED: &str = "unbounded";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    promise: PromiseEntry,
    starts: usize,
    nodes: Vec<NodeEntry>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PromiseEntry {
    kind: String,
    safety: String,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    objectives: Vec<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct NodeEntry {
    state: Valuation,
    most_preferred: Vec<String>,
    /// Absent if it is `most_preferred`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reference: Option<Vec<String>>,
    ahead: Ahead,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pursues: Vec<String>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    commits: bool,
    actions: Vec<ActionEntry>,
}

/// A number of improvements, or `unbounded`.
#[derive(Serialize, Deserialize)]
#[serde(untagged)]
enum Ahead {
    Number(usize),
    Name(String),
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ActionEntry {
    action: String,
    /// The position among the choices of the state, if another one has the same name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    position: Option<usize>,
    next: Vec<usize>,
}

/// The names that nodes contain.
#[derive(Clone, Copy)]
pub struct NodeWords<'w> {
    /// The program.
    pub program: &'w Program,
    /// The preferences.
    pub preferences: &'w Preferences,
}

impl NodeWords<'_> {
    /// Returns the text before the nodes, for a strategy that starts in some states.
    pub fn head(self, kind: StrategyKind, safety: &str, objectives: &ObjectiveSet, starts: usize) -> String {
        let promise = PromiseEntry {
            kind: kind.name().to_owned(),
            safety: safety.to_owned(),
            objectives: self.preferences.owned_names(objectives),
        };
        let promise = text(&promise);
        format!(
            "{{\"format\": \"{FORMAT}\",\n \"promise\": {promise},\n \"starts\": {starts},\n \"nodes\": ["
        )
    }

    /// Returns the text of a node; `is_first` says that it is the first one.
    pub fn node(self, node: &induced_model::Node, is_first: bool) -> String {
        let induced_model::Node { at, next } = node;
        let names = |set: &ObjectiveSet| self.preferences.owned_names(set);
        let entry = NodeEntry {
            state: Valuation::new(self.program, &at.state),
            most_preferred: names(&at.most_preferred),
            reference: (at.reference != at.most_preferred).then(|| names(&at.reference)),
            ahead: match at.memory.level {
                Rank::Finite(k) | Rank::AtLeast(k) => Ahead::Number(k),
                Rank::Unbounded => Ahead::Name(UNBOUNDED.to_owned()),
            },
            pursues: names(&at.aims),
            commits: at.commits(),
            actions: (0..next.len()).filter_map(|action| self.action(at, action, &next[action])).collect(),
        };
        format!("{}\n  {}", if is_first { "" } else { "," }, text(&entry))
    }

    /// Returns an action of a node; `None` if the strategy does not take it.
    fn action(self, at: &Explanation, position: usize, next: &[Option<usize>]) -> Option<ActionEntry> {
        let next = next.iter().copied().collect::<Option<Vec<_>>>()?;
        let name = &at.actions[position].name;
        let is_same = |other: &&Action| self.program.is_same_name(name, &other.name);
        let is_doubled = at.actions.iter().filter(is_same).count() > 1;
        Some(ActionEntry { action: name.clone(), position: is_doubled.then_some(position), next })
    }

    /// Returns the text after the nodes.
    pub fn tail(self) -> &'static str {
        "\n ]}\n"
    }
}

/// Returns JSON; the keys are strings and the values plain, so this cannot fail.
fn text(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

/// Returns whether a text is that of a policy with memory.
pub fn is_nodes(source: &SourceFile) -> bool {
    #[derive(Deserialize)]
    struct Head {
        #[serde(rename = "format")]
        _format: IgnoredAny,
    }
    // A list would be read as the fields of a structure. The format comes first, so a file that is damaged later is
    // known by it, too.
    let Some(begin) = source.text.trim_start().strip_prefix('{') else { return false };
    begin.trim_start().starts_with("\"format\"") || serde_json::from_str::<Head>(&source.text).is_ok()
}

/// Reads a policy with memory.
///
/// # Errors
/// The text is wrong; it names a state, an objective or a node that does not exist; the place is that of the node, or
/// none.
pub fn read(source: &Arc<SourceFile>, program: &Program, preferences: &Preferences) -> Result<NodePolicy> {
    let file: File = serde_json::from_str(&source.text).map_err(|error| {
        let wrong = Diagnostic::new(source, place(source, &error), error.to_string());
        wrong.help("expected a file of `strategy --policy`")
    })?;
    let wrong = |message: String| Error::from(Diagnostic::new(source, 0..0, message));
    let reader = NodeReader { program, preferences, count: file.nodes.len() };
    if file.format != FORMAT {
        return Err(wrong(format!("the format is `{}`, not `{FORMAT}`", file.format.escape_debug())));
    }
    let promise = reader.promise(&file.promise).map_err(wrong)?;
    if file.starts == 0 || file.starts > file.nodes.len() {
        return Err(wrong(format!("{} starts of {} nodes", file.starts, file.nodes.len())));
    }
    let node = |(number, entry): (usize, &NodeEntry)| {
        reader.node(entry).map_err(|message| wrong(format!("node {number}: {message}")))
    };
    let nodes = file.nodes.iter().enumerate().map(node).collect::<Result<_>>()?;
    Ok(NodePolicy { promise, starts: file.starts, nodes })
}

type Read<T> = std::result::Result<T, String>;

struct NodeReader<'r> {
    program: &'r Program,
    preferences: &'r Preferences,
    /// The number of nodes.
    count: usize,
}

impl NodeReader<'_> {
    fn promise(&self, entry: &PromiseEntry) -> Read<Promise> {
        let aim = entry.kind.parse::<Aim>();
        let aim =
            aim.map_err(|_| format!("the kind `{}` of a policy is unknown", entry.kind.escape_debug()))?;
        let modes = [SafetyMode::Prefix, SafetyMode::Action];
        let safety = modes.into_iter().find(|mode| mode.name() == entry.safety);
        let expected = || {
            let found = entry.safety.escape_debug();
            format!("the safety of a policy is `prefix` or `action`, not `{found}`")
        };
        Ok(Promise { aim, safety: safety.ok_or_else(expected)?, objectives: self.set(&entry.objectives)? })
    }

    fn set(&self, names: &[String]) -> Read<ObjectiveSet> {
        let mut set = ObjectiveSet::new();
        for name in names {
            let found = self.preferences.objectives.iter().position(|objective| objective.name == *name);
            let found = found.ok_or_else(|| format!("no objective is called `{}`", name.escape_debug()))?;
            if set.contains(found) {
                return Err(format!("the objective `{name}` stands twice"));
            }
            set.insert(found);
        }
        Ok(set)
    }

    fn node(&self, entry: &NodeEntry) -> Read<Node> {
        let state = entry.state.state(self.program);
        let state = state.ok_or_else(|| format!("`{}` is not a state of the model", entry.state))?;
        let most_preferred = self.set(&entry.most_preferred)?;
        let reference = match &entry.reference {
            Some(reference) => self.set(reference)?,
            None => most_preferred.clone(),
        };
        let ahead = match &entry.ahead {
            Ahead::Number(k) => Some(*k),
            Ahead::Name(name) if name == UNBOUNDED => None,
            Ahead::Name(_) => return Err(format!("`ahead` is a number or `{UNBOUNDED}`")),
        };
        let actions = entry.actions.iter().map(|action| self.taking(action)).collect::<Read<_>>()?;
        let (pursues, commits) = (self.set(&entry.pursues)?, entry.commits);
        Ok(Node { state, most_preferred, reference, ahead, pursues, commits, actions })
    }

    fn taking(&self, entry: &ActionEntry) -> Read<Taking> {
        match entry.next.iter().find(|&&next| next >= self.count) {
            Some(next) => Err(format!("the node {next} does not exist: they are counted from 0")),
            None => {
                let taken = Taken { action: entry.action.clone(), position: entry.position };
                Ok(Taking { taken, next: entry.next.clone() })
            }
        }
    }
}
