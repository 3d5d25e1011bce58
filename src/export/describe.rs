//! The part of the manifest that describes the model, the preferences and the options, as the export
//! writes it. The check of a dump derives it by code of its own.

use ahash::AHashMap;

use meliora_base::value::Type;
use meliora_dump::Manifest;
use meliora_dump::manifest::{
    self, ChoiceNumber, Choices, Encoding, File, SafetyMode, Source, Tool, Variable,
};
use meliora_engine::Engine;
use meliora_engine::symbolic::{Numbered, SymbolicEngine};
use meliora_model::preference::Preferences;
use meliora_model::valuation::{json, long};
use meliora_model::{CommandId, Program};

/// The texts that an analysis was made from.
#[derive(Debug, Clone)]
pub struct Inputs {
    /// The model: its path, and the SHA-256 of its bytes.
    pub model: (String, String),
    /// The preferences: their path, and the SHA-256 of their bytes.
    pub preferences: (String, String),
}

/// Describes the numbers of the choices. With `paired`, the bits of a choice get names; only sets
/// of choices need them.
pub(crate) fn choices(engine: &SymbolicEngine, paired: bool) -> Choices {
    let bits = if paired { engine.choice_bits() } else { 0 };
    // Names in a model contain no `@`, so these are new.
    let order = (0..bits).rev().map(|bit| format!("choice@{bit}")).collect();
    let program = engine.program();
    let all = engine.numbered_choices();
    let labels: Vec<Option<&String>> = all.iter().map(|n| label(program, n)).collect();
    let mut uses: AHashMap<&String, usize> = AHashMap::new();
    for label in labels.iter().flatten() {
        *uses.entry(label).or_default() += 1;
    }
    let number = |(number, choice): (usize, &Numbered)| {
        let action = labels[number].cloned();
        let several = labels[number].is_some_and(|label| uses[label] > 1);
        let commands = commands(program, choice);
        let name = match (&action, choice) {
            (_, Numbered::Uniform) => "uniform".to_owned(),
            // Here monitors take part, but their commands are not listed.
            (None, _) if commands.is_empty() => "deadlock".to_owned(),
            (Some(action), _) if !several => action.clone(),
            (Some(action), _) => format!("{action}({})", alternatives(&commands)),
            (None, _) => alternatives(&commands),
        };
        ChoiceNumber { number, name, action, commands }
    };
    Choices { order, numbers: all.iter().enumerate().map(number).collect() }
}

fn label<'a>(program: &'a Program, choice: &Numbered) -> Option<&'a String> {
    let Numbered::Combinations { synchronisation, .. } = choice else { return None };
    if commands(program, choice).is_empty() {
        return None;
    }
    program.actions.get(program.synchronisations[*synchronisation].action?)
}

/// Returns the commands of a choice, one list per module that takes part. Monitors take part in
/// every step and are left out.
fn commands(program: &Program, choice: &Numbered) -> Vec<Vec<String>> {
    let monitors = program.monitors.as_ref().map(|o| o.module);
    let watches = |id: &CommandId| Some(program.commands[id.index()].module) == monitors;
    let name = |id: &CommandId| {
        let command = &program.commands[id.index()];
        format!("{}#{}", program.modules[command.module], command.number)
    };
    match choice {
        Numbered::Combinations { commands, .. } => {
            let own = commands.iter().filter(|factor| !factor.iter().any(watches));
            own.map(|factor| factor.iter().map(name).collect()).collect()
        }
        Numbered::Uniform | Numbered::Deadlock => Vec::new(),
    }
}

/// Formats commands as `m1#1|m1#2,m2#1`.
fn alternatives(commands: &[Vec<String>]) -> String {
    commands.iter().map(|factor| factor.join("|")).collect::<Vec<_>>().join(",")
}

/// The subject of a dump: inputs and options, which determine its manifest except for the files.
pub(crate) struct Subject<'a> {
    /// The engine, with the model, the scope and the order of the bits.
    pub engine: &'a SymbolicEngine,
    /// The preferences.
    pub preferences: &'a Preferences,
    /// Paths and hashes of both texts.
    pub inputs: &'a Inputs,
    /// The safety mode.
    pub safety: SafetyMode,
    /// The level after which the search was cut.
    pub max_level: Option<usize>,
}

impl Subject<'_> {
    /// Returns the manifest with these choices and files.
    pub(crate) fn manifest(&self, choices: Choices, regions: File, certificate: Option<File>) -> Manifest {
        let source =
            |(path, sha256): &(String, String)| Source { path: path.clone(), sha256: sha256.clone() };
        let program = self.engine.program();
        let (players, coalition) = players(self.engine);
        Manifest {
            schema: manifest::SCHEMA.to_owned(),
            tool: Tool { name: manifest::TOOL.to_owned(), version: env!("CARGO_PKG_VERSION").to_owned() },
            model: source(&self.inputs.model),
            constants: program.constants.iter().map(|(name, value)| (name.clone(), json(value))).collect(),
            exact: program
                .constants
                .iter()
                .filter_map(|(name, value)| Some((name.clone(), long(value)?)))
                .collect(),
            given: program.given_constants.clone(),
            players,
            coalition,
            preferences: source(&self.inputs.preferences),
            objectives: self.preferences.objectives.iter().map(|o| o.name.clone()).collect(),
            empty: self.preferences.empty.to_string(),
            history: self.preferences.whole_paths().map(str::to_owned),
            questions: Vec::new(),
            requirements: self.preferences.requirements.iter().map(|r| r.text.clone()).collect(),
            scope: self.engine.settings().scope.name().to_owned(),
            safety: self.safety,
            max_level: self.max_level,
            encoding: encoding(self.engine),
            choices,
            regions,
            certificate,
            values: None,
        }
    }
}

/// Returns the names of the players of a game, and of those who we are; none for other models.
pub(crate) fn players(engine: &SymbolicEngine) -> (Vec<String>, Vec<String>) {
    let players = engine.program().players.iter().flat_map(|players| &players.list);
    let all: Vec<String> = players.map(|player| player.name.clone()).collect();
    let ours = members(&all, &engine.coalition());
    (all, ours)
}

/// Returns the names of the players of a coalition, which says of each player whether we are it.
pub(crate) fn members(players: &[String], coalition: &[bool]) -> Vec<String> {
    let ours = players.iter().zip(coalition).filter(|(_, ours)| **ours);
    ours.map(|(name, _)| name.clone()).collect()
}

fn encoding(engine: &SymbolicEngine) -> Encoding {
    let watching = engine.program().monitors.as_ref().map(|o| o.module);
    let variable = |v: &meliora_model::Variable| {
        let boolean = v.ty == Type::Bool;
        let bit = |k: u32| if boolean { v.name.clone() } else { format!("{}.{k}", v.name) };
        Variable {
            name: v.name.clone(),
            ty: if boolean { "bool".to_owned() } else { "int".to_owned() },
            low: v.low,
            high: v.high,
            bits: v.bits(),
            names: (0..v.bits()).map(bit).collect(),
            initial: v.initial,
            values: v.values.clone(),
            facts: engine.program().facts_of(v),
            observer: watching.is_some() && v.module == watching,
        }
    };
    let encoding = engine.encoding();
    Encoding { variables: encoding.variables().iter().map(variable).collect(), order: encoding.names() }
}

/// The names of a choice.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ChoiceNames {
    /// The label, or the commands of a choice without one.
    pub label: String,
    /// The name that no other choice has: the label with the commands, if several choices have it.
    pub own: String,
}

/// Returns the names of each choice by number. The self-loop of deadlocks is last.
pub(crate) fn choice_names(engine: &SymbolicEngine) -> Vec<ChoiceNames> {
    let numbers = choices(engine, false).numbers;
    let names =
        |n: ChoiceNumber| ChoiceNames { label: n.action.unwrap_or_else(|| n.name.clone()), own: n.name };
    numbers.into_iter().map(names).collect()
}
