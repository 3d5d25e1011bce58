//! The phases of an analysis, and the events that its listener receives.

use std::time::Duration;

use strum::{IntoStaticStr, VariantArray};

use super::levels::Kind;
use super::result::{AnalysisResult, ObjectiveCounts};
use meliora_engine::Count;

/// The phases of an analysis, in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Phase {
    /// Counts the states and transitions of the model.
    Counts,
    /// Computes the winning regions of the objectives, and the classes.
    Outcomes,
    /// Computes the improvement MDP.
    Improvement,
    /// Computes the SASI levels.
    Sasi,
    /// Computes the SPI levels.
    Spi,
}

impl Phase {
    /// All phases in their order.
    pub const ALL: &[Phase] = Phase::VARIANTS;

    /// Returns the phase that computes the levels of a kind.
    pub fn levels(kind: Kind) -> Phase {
        match kind {
            Kind::Sasi => Phase::Sasi,
            Kind::Spi => Phase::Spi,
        }
    }

    /// Returns the phase that must be complete before this one.
    pub(super) fn needs(self) -> Option<Phase> {
        match self {
            Phase::Counts | Phase::Outcomes => None,
            Phase::Improvement => Some(Phase::Outcomes),
            Phase::Sasi | Phase::Spi => Some(Phase::Improvement),
        }
    }

    /// Returns the name in messages.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// An event that the listener of an analysis receives.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// A phase begins.
    Started(Phase),
    /// The winning regions of an objective are known.
    Objective(&'a ObjectiveCounts),
    /// A level is known: its kind, its number (from 1) and its number of states.
    Level(Kind, usize, &'a Count),
    /// A phase is complete, with its duration by [`meliora_model::progress::ProgressSink::clock`]. A phase
    /// that a limit ends has no such event.
    Finished(Phase, Duration),
}

impl AnalysisResult {
    /// Adds the counts of an event.
    pub fn add(&mut self, event: Event<'_>) {
        match event {
            Event::Objective(counts) => {
                self.objectives.push(counts.clone());
                self.objectives.sort_by_key(|o| o.objective);
            }
            Event::Level(Kind::Sasi, _, count) => self.sasi.levels.push(count.clone()),
            Event::Level(Kind::Spi, _, count) => self.spi.levels.push(count.clone()),
            Event::Started(_) | Event::Finished(..) => {}
        }
    }
}
