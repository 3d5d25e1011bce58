//! Phases of an analysis with their positions.

use meliora_engine::Engine;
use meliora_model::error::Result;
use meliora_planning::{Analysis, Event, Phase};

/// Runs phases, and passes their events to `listener`. `report` receives each phase and its parts:
/// `outcomes`, `objective 2 of 5`.
///
/// # Errors
/// The errors of [`Analysis::run_phases`].
pub fn run_phases<E: Engine>(
    analysis: &mut Analysis<E>,
    phases: &[Phase],
    report: &dyn Fn(&'static str, String),
    listener: &mut dyn FnMut(Event<'_>),
) -> Result<()> {
    let (mut known, all) = (analysis.result().objectives.len(), analysis.preferences().objectives.len());
    let mut listen = |event: Event<'_>| {
        listener(event);
        match event {
            Event::Started(Phase::Outcomes) => {
                report(Phase::Outcomes.name(), format!("objective {} of {all}", known + 1));
            }
            Event::Started(phase @ (Phase::Sasi | Phase::Spi)) => report(phase.name(), "level 1".to_owned()),
            Event::Started(phase) => report(phase.name(), String::new()),
            Event::Objective(_) => {
                known += 1;
                if known < all {
                    report(Phase::Outcomes.name(), format!("objective {} of {all}", known + 1));
                }
            }
            Event::Level(kind, number, _) => report(kind.name(), format!("level {}", number + 1)),
            Event::Finished(..) => {}
        }
    };
    analysis.run_phases(phases, &mut listen)
}
