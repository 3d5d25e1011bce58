//! Runs the phases of an analysis and shows their progress.

use std::time::Duration;

use meliora_base::error::Error;
use meliora_engine::Engine;
use meliora_planning::{Analysis, Event, Phase};
use meliora_report::envelope::Times;

use super::progress::TerminalSink;

/// Runs phases. `sink` shows the progress, and `listener` receives the events.
///
/// # Errors
/// A limit is hit, or a target has no value in some state.
pub(super) fn run<E: Engine>(
    analysis: &mut Analysis<E>,
    phases: &[Phase],
    sink: &TerminalSink,
    listener: &mut dyn FnMut(Event<'_>),
) -> Result<(), Error> {
    analysis.run_phases(phases, &mut |event| match event {
        Event::Part(phase, part) => sink.report(phase.name(), part.to_owned()),
        Event::Finished(phase, _) => {
            let seconds = sink.finished(phase.name());
            listener(Event::Finished(phase, Duration::from_secs_f64(seconds)));
        }
        event => listener(event),
    })
}

/// Records the time of a phase. Counting is a part of building.
pub(super) fn note(time: &mut Times, event: Event<'_>) {
    if let Event::Finished(phase, took) = event {
        let name = if phase == Phase::Counts { "build" } else { phase.name() };
        time.add(name, took.as_secs_f64());
    }
}
