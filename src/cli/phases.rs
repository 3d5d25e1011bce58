//! Runs the phases of an analysis and shows their progress.

use meliora::engine::Engine;
use meliora::error::Error;
use meliora::output::envelope::Times;
use meliora::planning::{Analysis, Event, Phase};

use super::watch::Watch;

/// Runs phases. `watch` shows the progress, and `hear` receives the events.
///
/// # Errors
/// A limit is hit, or a target has no value in some state.
pub(super) fn run<E: Engine>(
    analysis: &mut Analysis<E>,
    phases: &[Phase],
    watch: &Watch,
    hear: &mut dyn FnMut(Event<'_>),
) -> Result<(), Error> {
    let (mut known, all) = (0, analysis.preferences().objectives.len());
    let mut listen = |event: Event<'_>| {
        match event {
            Event::Started(phase) => {
                watch.enter(phase.name());
                match phase {
                    Phase::Outcomes => watch.turn_to(format!("objective 1 of {all}")),
                    Phase::Sasi | Phase::Spi => watch.turn_to("level 1".to_owned()),
                    Phase::Counts | Phase::Improvement => {}
                }
            }
            Event::Objective(_) => {
                known += 1;
                if known < all {
                    watch.turn_to(format!("objective {} of {all}", known + 1));
                }
            }
            Event::Level(_, number, _) => watch.turn_to(format!("level {}", number + 1)),
            Event::Finished(phase, took) => watch.leave(phase.name(), took.as_secs_f64()),
        }
        hear(event);
    };
    phases.iter().try_for_each(|&phase| analysis.run_phase(phase, &mut listen))
}

/// Records the time of a phase. Counting is a part of building.
pub(super) fn note(time: &mut Times, event: Event<'_>) {
    if let Event::Finished(phase, took) = event {
        let name = if phase == Phase::Counts { "build" } else { phase.name() };
        time.add(name, took.as_secs_f64());
    }
}
