//! The fields that most reports begin with: the model, and the settings that decide the results.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::{Map, Value as Json};

use super::Style;
use super::text::{aligned, plural, wrapped};
use meliora_base::error::Diagnostic;
use meliora_base::escape;
use meliora_base::value::Type;
use meliora_engine::{Scope, Selection, Storage};
use meliora_model::predicate::Predicate;
use meliora_model::preference::{Empty, Preferences};
use meliora_model::valuation::{json, long_plain};
use meliora_model::{ModelKind, Program};
use meliora_planning::Safety;
use meliora_planning::result::ModelCounts;

/// The inputs and settings of a report; a report leaves out the fields that are `None`.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
pub struct Header {
    /// The model.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "ModelSummary")]
    pub model: Option<ModelSummary>,
    /// The preference file as the user named it.
    #[serde(skip)]
    pub preferences: Option<String>,
    /// The property file as the user named it; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The engine; absent until it is taken.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Storage")]
    pub engine: Option<&'static str>,
    /// Why `--engine auto` has taken this engine; absent with another `--engine`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub engine_reason: Option<String>,
    /// The valuations that are states.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Scope")]
    pub scope: Option<Scope>,
    /// The safety mode.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Safety")]
    pub safety: Option<Safety>,
    /// The value of nothing: the `empty` statement of the preferences; `null` until they are read.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<Empty>")]
    pub empty: Option<Option<&'static str>>,
    /// `play`: objectives are about whole paths; absent with `history = state`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub history: Option<&'static str>,
}

impl Header {
    /// The names of all fields in JSON.
    pub(super) const FIELDS: &[&str] =
        &["model", "file", "engine", "engine_reason", "scope", "safety", "empty", "history"];

    /// Creates a header for a model that is not read yet.
    pub fn of_model(path: &str) -> Self {
        let model = ModelSummary { path: path.to_owned(), ..ModelSummary::default() };
        Header { model: Some(model), ..Header::default() }
    }

    /// Adds the preference file, which is not read yet, and the safety mode.
    pub fn with_preferences(mut self, path: &str, safety: Safety) -> Self {
        (self.preferences, self.safety, self.empty) = (Some(path.to_owned()), Some(safety), Some(None));
        self
    }

    /// Creates the header for a model that an engine has explored.
    pub fn of_engine(program: &Program, storage: Storage, scope: Scope) -> Self {
        let header = Header::of_model(&program.source.name);
        Header { engine: Some(storage.name()), scope: Some(scope), ..header }
    }

    /// Adds the engine that is taken, and why.
    pub fn select(&mut self, selection: &Selection) {
        self.engine = Some(selection.storage.name());
        self.engine_reason.clone_from(&selection.reason);
    }

    /// Adds the contents of the model.
    pub fn read(&mut self, program: &Program) {
        if let Some(model) = &mut self.model {
            model.read(program);
        }
    }

    /// Adds the first expression of some conditions that is not exact, if all of the model are.
    pub fn read_conditions<'p>(&mut self, mut conditions: impl Iterator<Item = &'p Predicate>) {
        if let Some(model) = &mut self.model
            && model.inexact.is_none()
        {
            model.inexact = conditions.find_map(Predicate::inexact).map(place);
        }
    }

    /// Adds the contents of the model and of the preferences.
    pub fn read_both(&mut self, program: &Program, preferences: &Preferences) {
        self.read(program);
        self.empty = self.empty.map(|_| Some(preferences.empty.name()));
    }

    /// Returns whether the model is a game.
    pub(super) fn is_game(&self) -> bool {
        self.is_of(ModelKind::Smg)
    }

    /// Returns whether the model is a Markov chain, whose states have one choice.
    pub(super) fn is_chain(&self) -> bool {
        self.is_of(ModelKind::Dtmc)
    }

    fn is_of(&self, wanted: ModelKind) -> bool {
        let kind = self.model.as_ref().and_then(|model| model.kind);
        kind == Some(wanted.into())
    }

    /// Returns the path of the model.
    pub(crate) fn path(&self) -> &str {
        self.model.as_ref().map_or("", |model| &model.path)
    }

    /// Returns the settings with their names.
    pub(super) fn settings(&self) -> Vec<(&'static str, String)> {
        let reason = self.engine_reason.iter().map(|reason| format!(" ({reason})"));
        let engine = self.engine.map(|name| reason.fold(name.to_owned(), |text, reason| text + &reason));
        let own = |value: Option<&str>| value.map(str::to_owned);
        let all = [
            ("engine", engine),
            ("scope", own(self.scope.map(Scope::name))),
            ("safety", own(self.safety.map(Safety::name))),
            ("empty", own(self.empty.flatten())),
            ("history", own(self.history)),
        ];
        all.into_iter().filter_map(|(name, value)| Some((name, value?))).collect()
    }

    /// Renders the inputs, and the settings that decide the results.
    pub(super) fn title(&self, first: Vec<(&'static str, String)>, style: Style) -> String {
        let files = [Some(self.path()), self.preferences.as_deref(), self.file.as_deref()];
        let files = files.into_iter().flatten().collect::<Vec<_>>().join(" with ");
        let first = first.into_iter().map(|(name, value)| format!("{name} {value}"));
        let settings = self.settings().into_iter().map(|(name, value)| format!("{name} {value}"));
        let mut settings: Vec<String> = first.chain(settings).map(|setting| setting + " ·").collect();
        if let Some(last) = settings.last_mut() {
            last.truncate(last.len() - " ·".len());
        }
        let width = style.width.map_or(usize::MAX, usize::from);
        let settings = wrapped(&settings, "", width);
        let files = style.bold(&escape::line(&files)).to_string();
        match settings.trim_end() {
            "" => files + "\n",
            settings => format!("{files}\n{}\n", style.dim(settings)),
        }
    }

    /// Renders type, variables, constants and sizes of the model; empty until it is read.
    pub(super) fn sizes(&self, counts: Option<&ModelCounts>, style: Style) -> String {
        let Some((model, kind)) = self.model.as_ref().and_then(|m| Some((m, m.kind?))) else {
            return String::new();
        };
        let bits = model.variables.iter().map(|v| v.bits as usize).sum();
        let mut text = format!(
            "\n{}\n  {kind}, {} in {}",
            style.bold("Model"),
            plural(model.variables.len(), "variable"),
            plural(bits, "bit")
        );
        if !model.constants.is_empty() {
            text += &format!(", {}", model.constants());
        }
        text.push('\n');
        if let Some(place) = &model.inexact {
            text += &format!("  a double counts for an exact value at {}\n", escape::line(place));
        }
        if let Some(counts) = counts {
            let mut numbers = vec![("states", &counts.states)];
            numbers.extend(counts.model_states.iter().map(|states| ("without monitors", states)));
            numbers.extend([
                ("choices", &counts.choices),
                ("transitions", &counts.transitions),
                ("deadlocks", &counts.deadlocks),
                ("initial states", &counts.initial),
            ]);
            numbers.extend(counts.unsafe_states.iter().map(|states| ("unsafe", states)));
            text += &aligned(&numbers);
        }
        text
    }
}

/// The model of a report.
#[derive(Debug, Clone, Default, Serialize, JsonSchema)]
#[schemars(rename = "model")]
pub struct ModelSummary {
    /// The file as the user named it.
    pub path: String,
    /// The sort of the model; `null` if unknown.
    #[serde(rename = "type")]
    #[schemars(with = "Option<ModelKind>")]
    pub kind: Option<&'static str>,
    /// The constants given by `--const`: integers, numbers, Booleans; an infinite value is a string.
    pub constants: Map<String, Json>,
    /// The exact values of those that the numbers do not give, such as `1/3`; absent if there are none.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub exact_constants: BTreeMap<String, String>,
    /// The first place where a double counts for an exact value, as `FILE:LINE:COLUMN`; absent if all
    /// values are exact.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inexact: Option<String>,
    /// The variables in the order of declaration, monitors last; empty if unknown.
    pub variables: Vec<VariableSummary>,
}

/// A variable of the model.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct VariableSummary {
    /// Its name.
    pub name: String,
    /// Its type.
    #[serde(rename = "type")]
    #[schemars(extend("enum" = ["int", "bool"]))]
    pub ty: &'static str,
    /// The smallest value; 0 for `bool`.
    pub low: i64,
    /// The largest value; 1 for `bool`.
    pub high: i64,
    /// Number of bits of its encoding.
    pub bits: u32,
    /// The names of its values from `low` on; absent without names.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<String>,
}

fn place(found: &Diagnostic) -> String {
    let (line, column) = found.position();
    format!("{}:{line}:{column}", found.source.name)
}

impl ModelSummary {
    fn read(&mut self, program: &Program) {
        let constant = |name: &String| {
            let value = &program.constants.iter().find(|(n, _)| n == name)?.1;
            Some((name.clone(), json(value)))
        };
        let variable = |v: &meliora_model::Variable| VariableSummary {
            name: v.name.clone(),
            ty: if v.ty == Type::Bool { "bool" } else { "int" },
            low: v.low,
            high: v.high,
            bits: v.bits(),
            values: v.values.clone(),
        };
        self.kind = Some(program.kind.into());
        self.inexact = program.inexact.as_ref().map(place);
        self.constants = program.given_constants.iter().filter_map(constant).collect();
        let given = program.constants.iter().filter(|(name, _)| self.constants.contains_key(name));
        let exact = given.filter_map(|(name, value)| Some((name.clone(), long_plain(value)?)));
        self.exact_constants = exact.collect();
        self.variables = program.variables.iter().map(variable).collect();
    }

    /// Formats the constants as `K=4, N=3`.
    pub(super) fn constants(&self) -> String {
        let shown = |name: &String, value: &Json| {
            self.exact_constants.get(name).cloned().unwrap_or_else(|| value.to_string())
        };
        let constants = self.constants.iter().map(|(name, value)| format!("{name}={}", shown(name, value)));
        constants.collect::<Vec<_>>().join(", ")
    }
}
