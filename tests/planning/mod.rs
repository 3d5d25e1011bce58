//! The planning algorithms against literal definitions: on an engine of plain vectors, and on both
//! engines of the library.

mod achieving;
mod choosing;
mod differential;
mod embed;
mod examples;
mod factory;
mod generate;
mod hard_quantities;
mod induced;
mod joint;
mod literal;
mod loaded;
mod names;
mod phases;
mod preorder;
mod projections;
mod quantities;
mod reasons;
mod requirements;
mod restricted;
mod shield_labels;
mod shields;
mod simulations;
mod strategies;
mod tiny;
mod versus_literal;
mod worlds;

use tiny::{Mdp, Tiny};

use crate::common::prelude::*;

/// A model, targets and preferences.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    pub(crate) mdp: Mdp,
    pub(crate) targets: Vec<Vec<usize>>,
    pub(crate) statements: Vec<Statement>,
}

impl Case {
    pub(crate) fn engine(&self) -> Arc<Tiny> {
        Arc::new(Tiny::new(&self.mdp, &self.targets))
    }

    pub(crate) fn preferences(&self, engine: &Tiny, empty: Empty) -> Arc<Preferences> {
        let objective =
            |i: usize| Objective { name: format!("o{i}"), goal: Goal::Reach(engine.target(i)), span: None };
        Arc::new(Preferences {
            objectives: (0..self.targets.len()).map(objective).collect(),
            order: Preorder::new(self.targets.len(), &self.statements).unwrap(),
            empty,
            history: History::State,
            requirements: Vec::new(),
        })
    }
}

/// The finished analysis.
pub(crate) fn analyse(engine: &Arc<Tiny>, preferences: &Arc<Preferences>, safety: Safety) -> Analysis<Tiny> {
    finished(engine, preferences, Options { safety, max_level: None })
}
