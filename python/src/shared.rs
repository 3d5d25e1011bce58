//! A planning that is shared between threads.

use std::sync::Mutex;

use meliora::Result;
use meliora::embed::Planning;
use meliora::planning::{AnalysisResult, Event, Phase};

use crate::watch::lock;
use crate::worker::Teller;

/// A planning, and its results while it runs.
pub(crate) struct Shared {
    pub(crate) planning: Mutex<Planning>,
    pub(crate) known: Mutex<AnalysisResult>,
}

impl Shared {
    /// Computes all incomplete phases; `known` receives each result at once.
    pub(crate) fn run(&self, teller: &Teller<'_>) -> Result<()> {
        let mut planning = lock(&self.planning);
        let objectives = planning.preferences().objectives.len();
        for &phase in Phase::ALL {
            let found = {
                let known = lock(&self.known).objectives.len();
                let mut hear = |event: Event<'_>| self.hear(event, teller, known, objectives);
                planning.run_phase(phase, &mut hear)
            };
            *lock(&self.known) = planning.result().clone();
            found?;
        }
        Ok(())
    }

    fn hear(&self, event: Event<'_>, teller: &Teller<'_>, known: usize, objectives: usize) {
        lock(&self.known).add(event);
        match event {
            Event::Started(phase) => {
                let part = match phase {
                    Phase::Outcomes => format!("objective {} of {objectives}", known + 1),
                    Phase::Sasi | Phase::Spi => "level 1".to_owned(),
                    Phase::Counts | Phase::Improvement => String::new(),
                };
                teller.turn_to(phase.name(), part);
            }
            Event::Objective(_) => {
                let done = lock(&self.known).objectives.len();
                if done < objectives {
                    teller.turn_to(Phase::Outcomes.name(), format!("objective {} of {objectives}", done + 1));
                }
            }
            Event::Level(kind, number, _) => {
                teller.turn_to(kind.name(), format!("level {}", number + 1));
            }
            Event::Finished(..) => {}
        }
    }
}
