//! Questions to a dump without the model and the preferences.
//!
//! - [`Archive`]: an open dump.
//! - [`Selected`]: the value of a region expression, and [`Member`]: one of its states.
//!
//! # An example
//!
//! A dump of the states x = 0, 1, 2, 3 has a region `low` with x = 0 and x = 1. `meliora export`
//! writes such dumps.
//!
//! ```
//! use meliora_engine::Settings;
//! use meliora_query::Archive;
//! # use meliora_dump::{Diagram, Dump, Edge, write_directory};
//! # use meliora_engine::NoProgress;
//! # use serde_json::{from_value, json};
//!
//! # let mut regions = Diagram { variables: vec!["x.1".into(), "x.0".into()], ..Diagram::default() };
//! # let high = regions.push(0, Edge::TRUE, Edge::FALSE)?;
//! # regions.roots = vec![Edge::TRUE, high.complement()];
//! # let root = |name: &str, root: usize, count: &str| json!({
//! #     "name": name, "kind": "states", "root": root, "node": regions.roots[root].number(),
//! #     "nodes": root, "count": count,
//! # });
//! # let source = json!({"path": "m", "sha256": "0".repeat(64)});
//! # let manifest = from_value(json!({
//! #     "schema": "meliora.dump/1", "tool": {"name": "meliora", "version": "0"},
//! #     "model": source, "constants": {}, "given": [], "preferences": source, "objectives": [],
//! #     "empty": "bottom", "scope": "all", "safety": "action", "max_level": null,
//! #     "encoding": {
//! #         "variables": [{
//! #             "name": "x", "type": "int", "low": 0, "high": 3, "bits": 2, "names": ["x.0", "x.1"],
//! #             "initial": 0,
//! #         }],
//! #         "order": ["x.1", "x.0"],
//! #     },
//! #     "choices": {"order": [], "numbers": []},
//! #     "regions": {
//! #         "path": "regions.dddmp", "sha256": "", "nodes": 0,
//! #         "roots": [root("reachable", 0, "4"), root("low", 1, "2")],
//! #     },
//! #     "certificate": null,
//! # })).unwrap();
//! # let directory = std::env::temp_dir().join(format!("meliora-query-{}", std::process::id()));
//! # let dump = Dump { manifest, regions, certificate: None, values: None };
//! # write_directory(dump, &directory, false, &NoProgress)?;
//! let archive = Archive::open(&directory, Some("x != 3"), Settings::default())?;
//! let others = archive.select("reachable & !low")?;
//! assert_eq!(archive.count(&others)?, 1u32.into());
//! assert_eq!(archive.list(&others, 10)?[0].state, [2]);
//! assert!(archive.member(&others, &archive.state("x=1")?)?.is_none());
//! # std::fs::remove_dir_all(&directory).unwrap();
//! # Ok::<(), meliora_base::error::Error>(())
//! ```

mod program;
mod region;

use std::path::Path;
use std::sync::Arc;

use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_base::progress::Poll;
use meliora_dump::manifest::{FILE, Root, RootKind};
use meliora_dump::{Dump, Manifest, read_directory};
use meliora_engine::symbolic::{ChoiceSet, Encoding, StateSet, SymbolicEngine};
use meliora_engine::{Algebra, Count, Engine, Settings};
use meliora_lang as lang;
use meliora_model::predicate::Predicate;
use meliora_model::{Program, State};
use region::Region;

/// An open dump that answers queries.
pub struct Archive {
    name: String,
    dump: Dump,
    engine: SymbolicEngine,
    condition: Option<Predicate>,
}

/// The value of a region expression.
#[derive(Clone)]
pub enum Selected {
    /// States.
    States(StateSet),
    /// Pairs of states and choices, by the numbers of the choices.
    Choices(ChoiceSet),
}

/// A state of a selection.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Member {
    /// The state.
    pub state: State,
    /// The names of its choices, if the selection is a set of choices.
    pub choices: Option<Vec<String>>,
}

impl Archive {
    /// Opens the dump in a directory. `condition` is an expression over its variables and constants
    /// that restricts all answers. Cost: linear in the nodes of `reachable`.
    ///
    /// # Errors
    /// The dump or the condition is invalid; a limit is reached.
    pub fn open(directory: &Path, condition: Option<&str>, settings: Settings) -> Result<Self> {
        let name = directory.join(FILE).display().to_string();
        let dump = read_directory(directory, false, settings.sink.as_ref())?;
        let program = Arc::new(program::rebuild(&name, &dump.manifest)?);
        let condition = condition.map(|text| lower(&program, text)).transpose()?;
        let order = Encoding::order_of(&program, &dump.manifest.encoding.order);
        let order =
            order.ok_or_else(|| wrong(&name, "the names of the bits are not those of the variables"))?;
        let all = dump.manifest.regions.root("reachable");
        let all = all.ok_or_else(|| wrong(&name, "the region `reachable` is missing"))?;
        let engine = SymbolicEngine::with_states(program, order, settings, &dump.regions, all.node)?;
        Ok(Archive { name, dump, engine, condition })
    }

    /// Returns the manifest.
    pub fn manifest(&self) -> &Manifest {
        &self.dump.manifest
    }

    /// Returns the variables, as a program without commands.
    pub fn program(&self) -> &Arc<Program> {
        self.engine.program()
    }

    /// Evaluates an expression of regions: names joined by `&`, `|`, `!` and brackets. The
    /// complement `!` is taken within `reachable`, for choices within `choices`. In an expression
    /// with choices, a set of states stands for all enabled choices of its states.
    ///
    /// # Errors
    /// A syntax error or an unknown name, with its place; a limit is reached.
    pub fn select(&self, expression: &str) -> Result<Selected> {
        let source = SourceFile::new("the region", expression);
        let names: Vec<&str> = self.dump.manifest.regions.roots.iter().map(|r| r.name.as_str()).collect();
        // A dump of some regions, or of some levels, does not say which level is the last.
        let manifest = &self.dump.manifest;
        let levels_end = manifest.certificate.is_some() && manifest.max_level.is_none();
        let selected = self.evaluate(&region::parse(&source, &names, levels_end)?)?;
        match &self.condition {
            None => Ok(selected),
            Some(condition) => {
                let states = Selected::States(self.engine.states_where(condition)?);
                self.both(&selected, &states)
            }
        }
    }

    fn evaluate(&self, region: &Region) -> Result<Selected> {
        match region {
            Region::Name(position) => match self.dump.manifest.regions.roots.get(*position) {
                Some(root) => self.load(root),
                None => Ok(Selected::States(self.engine.no_states())),
            },
            Region::Not(of) => self.complement(&self.evaluate(of)?),
            Region::And(row) => self.row(row, |a, b| self.both(a, b)),
            Region::Or(row) => self.row(row, |a, b| self.either(a, b)),
        }
    }

    /// Joins the operands of an operator from left to right.
    fn row(
        &self,
        row: &[Region],
        join: impl Fn(&Selected, &Selected) -> Result<Selected>,
    ) -> Result<Selected> {
        let mut parts = row.iter().map(|part| self.evaluate(part));
        let first = parts.next().unwrap_or_else(|| Ok(Selected::States(self.engine.no_states())));
        parts.try_fold(first?, |left, right| join(&left, &right?))
    }

    fn load(&self, root: &Root) -> Result<Selected> {
        match root.kind {
            RootKind::States => {
                let set = self.engine.load_states(&self.dump.regions, &[root.node])?.swap_remove(0);
                // Patterns that are not values, and states out of scope, do not count as members.
                Ok(Selected::States(self.engine.intersection(&set, &self.engine.all_states())?))
            }
            RootKind::Choices => {
                let numbers = self.dump.manifest.choices.numbers.len();
                let set = self.engine.load_choices(&self.dump.regions, root.node, numbers)?;
                let set = set.ok_or_else(|| {
                    wrong(
                        &self.name,
                        &format!("`{}` has choices that the manifest does not number", root.name),
                    )
                })?;
                Ok(Selected::Choices(self.engine.choices_in(&set, &self.engine.all_states())?))
            }
        }
    }

    fn complement(&self, of: &Selected) -> Result<Selected> {
        Ok(match of {
            Selected::States(x) => Selected::States(self.engine.difference(&self.engine.all_states(), x)?),
            Selected::Choices(c) => Selected::Choices(self.engine.difference(&self.enabled()?, c)?),
        })
    }

    fn both(&self, a: &Selected, b: &Selected) -> Result<Selected> {
        Ok(match (a, b) {
            (Selected::States(x), Selected::States(y)) => Selected::States(self.engine.intersection(x, y)?),
            (Selected::Choices(c), Selected::States(x)) | (Selected::States(x), Selected::Choices(c)) => {
                Selected::Choices(self.engine.choices_in(c, x)?)
            }
            (Selected::Choices(c), Selected::Choices(d)) => {
                Selected::Choices(self.engine.intersection(c, d)?)
            }
        })
    }

    fn either(&self, a: &Selected, b: &Selected) -> Result<Selected> {
        Ok(match (a, b) {
            (Selected::States(x), Selected::States(y)) => Selected::States(self.engine.union(x, y)?),
            (Selected::Choices(c), Selected::States(x)) | (Selected::States(x), Selected::Choices(c)) => {
                let all = self.engine.choices_in(&self.enabled()?, x)?;
                Selected::Choices(self.engine.union(c, &all)?)
            }
            (Selected::Choices(c), Selected::Choices(d)) => Selected::Choices(self.engine.union(c, d)?),
        })
    }

    /// Returns all enabled choices; a dump with strategies contains them.
    fn enabled(&self) -> Result<ChoiceSet> {
        let root = self.dump.manifest.regions.root("choices");
        let root =
            root.ok_or_else(|| wrong(&self.name, "the region `choices` is missing, which this query needs"))?;
        match self.load(root)? {
            Selected::Choices(c) => Ok(c),
            Selected::States(_) => Err(wrong(&self.name, "`choices` is a set of states")),
        }
    }

    /// Returns the number of states, or of pairs of states and choices.
    pub fn count(&self, selected: &Selected) -> Result<Count> {
        match selected {
            Selected::States(x) => self.engine.count(x),
            Selected::Choices(c) => self.engine.count(c),
        }
    }

    /// Parses a state written as `x=1,b=true`; missing variables get their initial values.
    ///
    /// # Errors
    /// A syntax error, an unknown variable, a value out of range.
    pub fn state(&self, text: &str) -> Result<State> {
        lang::parse_state(&SourceFile::new("the state", text), self.engine.program())
    }

    /// Returns the state as a member of the selection; none if it is not in it.
    pub fn member(&self, selected: &Selected, state: &[i64]) -> Result<Option<Member>> {
        let choices = match selected {
            Selected::States(x) => return Ok(self.engine.contains(x, state)?.then(|| self.plain(state))),
            Selected::Choices(c) => c,
        };
        let mut names = Vec::new();
        for choice in &self.dump.manifest.choices.numbers {
            if self.engine.contains(&self.engine.numbered(choices, choice.number)?, state)? {
                names.push(choice.name.clone());
            }
        }
        Ok((!names.is_empty()).then(|| Member { state: state.to_vec(), choices: Some(names) }))
    }

    fn plain(&self, state: &[i64]) -> Member {
        Member { state: state.to_vec(), choices: None }
    }

    /// Lists up to `limit` states in the order of their values.
    pub fn list(&self, selected: &Selected, limit: usize) -> Result<Vec<Member>> {
        let states = match selected {
            Selected::States(x) => x.clone(),
            Selected::Choices(c) => self.engine.sources(c)?,
        };
        let mut members = Vec::new();
        let mut poll = Poll::new(self.engine.settings().sink.as_ref());
        for state in self.engine.list_states(&states, limit)? {
            poll.step()?;
            members.extend(self.member(selected, &state)?);
        }
        Ok(members)
    }
}

fn wrong(file: &str, message: &str) -> Error {
    Error::Dump { file: file.to_owned(), line: 0, message: message.to_owned() }
}

/// Parses the condition.
fn lower(program: &Program, text: &str) -> Result<Predicate> {
    let source = SourceFile::new("the condition", text);
    if let Some(at) = text.find('"') {
        let diagnostic =
            Diagnostic::new(&source, at..text.len(), "a dump does not contain the labels of the model");
        return Err(diagnostic.help("name a region instead, such as `initial` or `deadlock`").into());
    }
    let tree = lang::parse_expression(&source)?;
    lang::lower_target(program, &source, &tree)
}
