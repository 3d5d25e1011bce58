//! The phases of an analysis, and the events that its listener receives.

use std::time::Duration;

use strum::{IntoStaticStr, VariantArray};

use super::improvement::Sizes;
use super::levels::Kind;
use super::result::{AnalysisResult, ClassCount, LevelCounts, LevelsEnd, ModelCounts, ObjectiveCounts};
use super::run::Analysis;
use meliora_base::error::Result;
use meliora_engine::{Count, Engine};

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
    pub(crate) fn needs(self) -> Option<Phase> {
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

/// An event that the listener of an analysis receives. Together, the events have all results: see
/// [`AnalysisResult::add`].
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// A phase begins.
    Started(Phase),
    /// A part of a phase begins, such as `objective 2 of 5`; empty for a phase without parts.
    Part(Phase, &'a str),
    /// The sizes of the model are known.
    Counts(&'a ModelCounts),
    /// The winning regions of an objective are known.
    Objective(&'a ObjectiveCounts),
    /// The classes are known, or more is known about them.
    Classes(&'a [ClassCount]),
    /// The sizes of the improvement MDP are known.
    Improvement(&'a Sizes),
    /// A level is known: its kind, its number (from 1) and its number of states.
    Level(Kind, usize, &'a Count),
    /// There are no more levels of this kind, for this reason.
    LevelsEnd(Kind, &'a LevelsEnd),
    /// A phase is complete, with its duration by [`meliora_base::progress::ProgressSink::clock`]. A phase
    /// that a limit ends has no such event.
    Finished(Phase, Duration),
}

impl<E: Engine> Analysis<E> {
    /// Runs all phases in the order of [`Phase`]. A call after a limit continues where the last one
    /// ended. Cost: that of the phases; see `WinningRegions::advance`, `Improvement::new` and
    /// `super::levels::next_level`.
    ///
    /// # Errors
    /// A limit of the engine is reached, or a target has no value in some state. Earlier results
    /// stay in [`Analysis::result`].
    pub fn run(&mut self, listener: &mut dyn FnMut(Event<'_>)) -> Result<()> {
        self.run_phases(Phase::ALL, listener)
    }
}

impl Event<'_> {
    /// Returns the part of a phase that begins after the event. `known` objectives of `all` are decided, with the one
    /// of this event.
    pub(crate) fn next_part(self, known: usize, all: usize) -> Option<(Phase, String)> {
        let objective = || (Phase::Outcomes, format!("objective {} of {all}", known + 1));
        match self {
            Event::Started(Phase::Outcomes) => Some(objective()),
            Event::Started(phase @ (Phase::Sasi | Phase::Spi)) => Some((phase, "level 1".to_owned())),
            Event::Started(phase) => Some((phase, String::new())),
            Event::Objective(_) if known < all => Some(objective()),
            Event::Level(kind, number, _) => Some((Phase::levels(kind), format!("level {}", number + 1))),
            _ => None,
        }
    }
}

impl AnalysisResult {
    /// Adds the results of an event.
    pub fn add(&mut self, event: Event<'_>) {
        match event {
            Event::Counts(counts) => self.counts = Some(counts.clone()),
            Event::Objective(counts) => {
                self.objectives.push(counts.clone());
                self.objectives.sort_by_key(|o| o.objective);
            }
            Event::Classes(classes) => self.classes = Some(classes.to_vec()),
            Event::Improvement(sizes) => self.improvement = Some(sizes.clone()),
            Event::Level(kind, _, count) => self.levels_mut(kind).levels.push(count.clone()),
            Event::LevelsEnd(kind, end) => self.levels_mut(kind).end = end.clone(),
            Event::Started(_) | Event::Part(..) | Event::Finished(..) => {}
        }
    }

    /// Adds the results of an event, and passes it on.
    pub(crate) fn tell(&mut self, event: Event<'_>, listener: &mut dyn FnMut(Event<'_>)) {
        self.add(event);
        listener(event);
    }

    /// Returns the levels of a kind.
    pub fn levels(&self, kind: Kind) -> &LevelCounts {
        match kind {
            Kind::Sasi => &self.sasi,
            Kind::Spi => &self.spi,
        }
    }

    fn levels_mut(&mut self, kind: Kind) -> &mut LevelCounts {
        match kind {
            Kind::Sasi => &mut self.sasi,
            Kind::Spi => &mut self.spi,
        }
    }
}
