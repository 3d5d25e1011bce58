//! The nodes of strategies as lines of JSON. Texts that occur again and again are made once.

use std::fmt::Write;
use std::slice;
use std::sync::Arc;

use ahash::AHashMap;
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_base::progress::NoProgress;
use meliora_model::valuation::Valuation;
use meliora_model::{Program, Variable};
use meliora_question::evaluate::{PolicyNode, PropertyPolicy};
use meliora_space::enabled::Enabled;
use meliora_space::weighted::{Walk, Walker};
use serde::Serialize;

use super::mix;

/// Returns the JSON of a value that always has one.
pub(super) fn text(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_default()
}

/// The source of the names of choices.
pub(super) enum Source<'p> {
    /// The lists of choices that an engine keeps, and the list of each node.
    Kept(&'p Program, &'p Enabled, &'p [u32]),
    /// The guards of a program.
    Walked(Box<Walker<'p>>),
}

impl<'p> Source<'p> {
    /// Compiles a program.
    ///
    /// # Errors
    /// A state does not fit into a code.
    pub(super) fn new(program: &'p Program) -> Result<Self> {
        Ok(Source::Walked(Box::new(Walker::new(program, &NoProgress)?)))
    }

    /// Returns the source for the nodes of a policy.
    ///
    /// # Errors
    /// See [`Source::new`].
    pub(super) fn of_policy(policy: &'p PropertyPolicy, program: &'p Program) -> Result<Self> {
        match policy.nodes.kept_choices() {
            Some((all, of_nodes)) => Ok(Source::Kept(program, all, of_nodes)),
            None => Source::new(program),
        }
    }

    /// Returns the names, each of which is made once.
    pub(super) fn names(&self) -> Names<'_> {
        match self {
            Source::Kept(program, all, of_nodes) => {
                Names::Kept { program, all, of_nodes, known: vec![None; all.lists()] }
            }
            Source::Walked(walker) => Names::Walked { walker, walk: walker.walk() },
        }
    }
}

/// The names of the choices of states.
pub(super) enum Names<'w> {
    Kept { program: &'w Program, all: &'w Enabled, of_nodes: &'w [u32], known: Vec<Option<Vec<String>>> },
    Walked { walker: &'w Walker<'w>, walk: Box<dyn Walk + 'w> },
}

impl Names<'_> {
    /// Returns the names of the choices of a node with a state, by position.
    ///
    /// # Errors
    /// A command has no meaning in the state.
    pub(super) fn of(&mut self, node: usize, state: &[i64]) -> Result<&[String]> {
        match self {
            Names::Walked { walker, walk } => walk.names(&walker.codec().known(state)?),
            Names::Kept { program, all, of_nodes, known } => {
                let list = of_nodes[node];
                Ok(known[list as usize].get_or_insert_with(|| all.names(program, list)))
            }
        }
    }
}

/// Writes nodes.
pub(super) struct NodeLines<'w> {
    names: Names<'w>,
    state: Vec<Entries<'w>>,
    /// The variables of monitors; `None` without monitors.
    memory: Option<Vec<Entries<'w>>>,
    actions: AHashMap<String, String>,
    /// The texts of probabilities by address; known texts stay.
    probabilities: AHashMap<usize, (Arc<Ratio>, String)>,
    digits: itoa::Buffer,
}

impl<'w> NodeLines<'w> {
    pub(super) fn new(names: Names<'w>, variables: &'w [Variable], monitors: Option<&'w [Variable]>) -> Self {
        let all = |of: &'w [Variable]| of.iter().map(Entries::new).collect();
        NodeLines {
            names,
            state: all(variables),
            memory: monitors.map(all),
            actions: AHashMap::new(),
            probabilities: AHashMap::new(),
            digits: itoa::Buffer::new(),
        }
    }

    /// Adds a node, by its number, as the serialisation of a [`mix::NodeEntry`].
    ///
    /// # Errors
    /// A command has no meaning in the state.
    pub(super) fn push(&mut self, number: usize, node: &PolicyNode, out: &mut String) -> Result<()> {
        out.push_str("{\"state\":");
        push_object(&mut self.state, &node.state, out);
        if let Some(memory) = &mut self.memory {
            out.push_str(",\"memory\":");
            push_object(memory, &node.memory, out);
        }
        for (name, count) in [("steps", node.steps), ("round", node.round)] {
            if count > 0 {
                let _ = write!(out, ",\"{name}\":{count}");
            }
        }
        out.push_str(if node.theirs { ",\"other\":true,\"actions\":[" } else { ",\"actions\":[" });
        self.push_actions(number, node, out)?;
        out.push_str("]}");
        Ok(())
    }

    fn push_actions(&mut self, number: usize, node: &PolicyNode, out: &mut String) -> Result<()> {
        if node.choices.is_empty() {
            return Ok(());
        }
        let names = self.names.of(number, &node.state)?;
        for (number, taking) in node.choices.iter().enumerate() {
            let name = names.get(taking.position).map_or("", String::as_str);
            out.push_str(if number > 0 { ",{\"action\":" } else { "{\"action\":" });
            match self.actions.get(name) {
                Some(known) => out.push_str(known),
                None => out.push_str(self.actions.entry(name.to_owned()).or_insert(text(&name))),
            }
            out.push_str(",\"position\":");
            out.push_str(self.digits.format(taking.position));
            out.push_str(",\"successors\":[");
            for (number, (node, p)) in taking.successors.iter().enumerate() {
                out.push_str(if number > 0 { ",{\"node\":" } else { "{\"node\":" });
                out.push_str(self.digits.format(*node));
                out.push_str(",\"probability\":");
                let known = self.probabilities.entry(Arc::as_ptr(p) as usize);
                out.push_str(&known.or_insert_with(|| (Arc::clone(p), text(&mix::number(p)))).1);
                out.push('}');
            }
            out.push_str("]}");
        }
        Ok(())
    }
}

/// The entries of a variable in objects, such as `"x":1`.
struct Entries<'v> {
    variable: &'v Variable,
    known: Vec<Option<String>>,
}

/// Maximum number of values of a variable whose entries are kept.
const MOST_VALUES: i64 = 1 << 16;

impl<'v> Entries<'v> {
    fn new(variable: &'v Variable) -> Self {
        Entries { variable, known: Vec::new() }
    }

    fn push(&mut self, value: i64, out: &mut String) {
        let of = |variable: &Variable| {
            let whole = text(&Valuation::of_variables(slice::from_ref(variable), &[value]));
            whole[1..whole.len() - 1].to_owned()
        };
        let place = value.checked_sub(self.variable.low).filter(|place| (0..MOST_VALUES).contains(place));
        let Some(place) = place.and_then(|place| usize::try_from(place).ok()) else {
            out.push_str(&of(self.variable));
            return;
        };
        if self.known.len() <= place {
            self.known.resize(place + 1, None);
        }
        out.push_str(self.known[place].get_or_insert_with(|| of(self.variable)));
    }
}

fn push_object(entries: &mut [Entries<'_>], values: &[i64], out: &mut String) {
    out.push('{');
    for (number, (entry, &value)) in entries.iter_mut().zip(values).enumerate() {
        if number > 0 {
            out.push(',');
        }
        entry.push(value, out);
    }
    out.push('}');
}
