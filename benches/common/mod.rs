//! The measured cases: the families of `models/` at sizes that take milliseconds, and a grid world.

#![allow(dead_code, unreachable_pub, reason = "each bench file uses a part")]

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use criterion::Criterion;
use meliora::engine::ExplicitEngine;
use meliora::engine::SymbolicEngine;
use meliora::engine::{Algebra, Engine, Scope, Settings};
use meliora::error::SourceFile;
use meliora::generate::{self, Choices, Parameters};
use meliora::lang;
use meliora::model::Program;
use meliora::model::preference::Preferences;
use meliora::planning::{Analysis, Options};

/// For each family its constants and the scope.
const FAMILIES: [(&str, &str, Scope); 8] = [
    ("chain", "N=100", Scope::Reachable),
    ("fleet", "L=1", Scope::Reachable),
    ("line", "K=1", Scope::Reachable),
    ("network", "K=20,M=5", Scope::Reachable),
    ("rescue", "H=3", Scope::Reachable),
    ("ring", "N=12,T=9", Scope::Reachable),
    ("robot5x5", "", Scope::All),
    ("scramble", "cells=97", Scope::Reachable),
];

/// A model with preferences and a scope.
pub struct Case {
    pub name: String,
    pub program: Arc<Program>,
    pub preferences: Arc<Preferences>,
    pub scope: Scope,
}

impl Case {
    fn new(name: String, model: String, preferences: String, constants: &str, scope: Scope) -> Self {
        let constants = SourceFile::new("constants", constants);
        let program = lang::load(&SourceFile::new(&name, model), &constants).unwrap().program;
        let source = SourceFile::new(&name, preferences);
        let lang::Task { program, preferences } = lang::load_preferences(&source, program).unwrap();
        Case { name, program: Arc::new(program), preferences: Arc::new(preferences), scope }
    }

    fn settings(&self) -> Settings {
        Settings { scope: self.scope, memory: 512 << 20, ..Settings::default() }
    }

    /// The symbolic engine as `meliora check` makes it.
    pub fn symbolic(&self) -> Arc<SymbolicEngine> {
        self.symbolic_in(self.scope)
    }

    /// The symbolic engine in another scope.
    pub fn symbolic_in(&self, scope: Scope) -> Arc<SymbolicEngine> {
        let settings = Settings { scope, ..self.settings() };
        Arc::new(SymbolicEngine::new(self.program.clone(), settings).unwrap())
    }

    /// The explicit engine.
    pub fn explicit(&self) -> Arc<ExplicitEngine> {
        Arc::new(ExplicitEngine::new(self.program.clone(), self.settings()).unwrap())
    }

    /// An analysis with nothing computed yet.
    pub fn analysis<E: Engine>(&self, engine: &Arc<E>) -> Analysis<E> {
        Analysis::new(engine, &self.preferences, Options::default())
    }

    /// Returns the number of states. Prints it, and the memory that each engine needs for everything.
    pub fn announce(&self) -> u64 {
        let (symbolic, explicit) = (self.symbolic(), self.explicit());
        self.analysis(&symbolic).run(&mut |_| ()).unwrap();
        self.analysis(&explicit).run(&mut |_| ()).unwrap();
        let states = explicit.count(&explicit.all_states()).unwrap();
        let (left, right) = (symbolic.usage(), explicit.usage());
        println!(
            "{}: {states} states; at most, symbolic: {} nodes, {} bytes; explicit: {} bytes",
            self.name, left.peak_nodes, left.bytes, right.bytes
        );
        u64::try_from(states).unwrap()
    }
}

/// All cases.
pub fn cases() -> Vec<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models");
    let read = |name: &str, end: &str| std::fs::read_to_string(folder.join(format!("{name}.{end}"))).unwrap();
    let family = |&(name, constants, scope): &(&str, &str, Scope)| {
        let (model, preferences) = (read(name, "prism"), read(name, "pref"));
        Case::new(format!("{name} {constants}").trim().to_owned(), model, preferences, constants, scope)
    };
    FAMILIES.iter().map(family).chain([gridworld(12, 4)]).collect()
}

/// A grid world of the standing family.
pub fn gridworld(side: usize, items: usize) -> Case {
    let choices = Choices { seed: 1, ..Choices::default() };
    let world = generate::gridworld(&Parameters::new(side, side, items), &choices).unwrap();
    let name = format!("gridworld {side}x{side}, {items} items");
    Case::new(name, world.model, world.preferences, "", Scope::Reachable)
}

/// Short runs: most cases take milliseconds and vary little.
pub fn config() -> Criterion {
    Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
}
