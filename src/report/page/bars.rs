//! Tables with bars that compare sizes.

use maud::{Markup, html};

use super::super::check::CheckReport;
use super::super::text::{self, grouped};
use super::game;
use super::words::{percent, share};
use meliora_engine::Count;
use meliora_planning::AnalysisResult;

fn whole(result: &AnalysisResult) -> Count {
    result.counts.as_ref().map(|c| c.states.clone()).unwrap_or_default()
}

/// Returns the number of unsafe states, if there are some.
fn unsafe_states(result: &AnalysisResult) -> Option<&Count> {
    result.counts.as_ref()?.unsafe_states.as_ref().filter(|states| **states != Count::ZERO)
}

/// Renders a number of states with its share of all states.
fn cell(part: &Count, whole: &Count, class: &str) -> Markup {
    let percent = percent(part, whole);
    html! {
        td.n { (grouped(part)) }
        td.bar title=(share(percent)) {
            span class=(class) style=(format!("width:{percent:.2}%")) {}
        }
    }
}

/// Renders the objectives with the sizes of their regions.
pub(super) fn objectives(result: &AnalysisResult) -> Markup {
    let whole = whole(result);
    html! {
        table {
            thead { tr {
                th { "objective" } th.n { "target" }
                th colspan="2" { "almost sure in" } th colspan="2" { "possible in" }
            } }
            tbody { @for o in &result.objectives { tr {
                th { (o.name) } td.n { (grouped(&o.target)) }
                (cell(&o.almost_sure, &whole, "sure"))
                (cell(&o.positive, &whole, "possible"))
            } } }
        }
    }
}

/// Renders the classes with their sizes.
pub(super) fn classes(result: &AnalysisResult) -> Markup {
    let whole = whole(result);
    html! {
        table {
            thead { tr { th { "most preferred" } th colspan="2" { "states" } } }
            tbody { @for class in result.classes.iter().flatten() { tr {
                th { (text::either(&class.most_preferred)) }
                (cell(&class.states, &whole, "plain"))
            } }
            @if let Some(states) = unsafe_states(result) { tr {
                th { "unsafe: no strategy keeps the requirements" }
                (cell(states, &whole, "plain"))
            } } }
        }
    }
}

/// Renders the SASI and SPI levels side by side, one line per number of improvements.
pub(super) fn levels(result: &AnalysisResult) -> Markup {
    let (sasi, spi, whole) = (&result.sasi, &result.spi, whole(result));
    html! {
        table {
            thead { tr {
                th { "improvements" } th colspan="2" { "guaranteed (SASI)" } th colspan="2" { "possible (SPI)" }
            } }
            tbody {
                @for k in 1..=sasi.levels.len().max(spi.levels.len()) { tr {
                    th { (k) " or more" }
                    (level(sasi.size(k), &whole, "sure"))
                    (level(spi.size(k), &whole, "possible"))
                } }
                tr {
                    th { "any number" }
                    (level(sasi.unbounded(), &whole, "sure"))
                    (level(spi.unbounded(), &whole, "possible"))
                }
            }
        }
    }
}

fn level(states: Option<Count>, whole: &Count, class: &str) -> Markup {
    match states {
        Some(states) => cell(&states, whole, class),
        None => html! { td.n { "?" } td.bar {} },
    }
}

/// Renders the sizes of the model and the improvement MDP.
pub(super) fn sizes(check: &CheckReport) -> Markup {
    let (result, mut rows): (_, Vec<(&str, String)>) = (&check.result, Vec::new());
    if let Some(counts) = &result.counts {
        rows.extend([
            ("states", grouped(&counts.states)),
            ("choices", grouped(&counts.choices)),
            ("transitions", grouped(&counts.transitions)),
            ("deadlocks", grouped(&counts.deadlocks)),
            ("initial states", grouped(&counts.initial)),
        ]);
        rows.extend(unsafe_states(result).map(|states| ("unsafe states", grouped(states))));
    }
    if let Some(improvement) = &result.improvement {
        rows.push(("improvement MDP: states", grouped(&improvement.states)));
        rows.push(("improvement MDP: transitions", grouped(&improvement.transitions)));
        rows.push(("transitions dropped", grouped(&improvement.dropped)));
    }
    html! { table { tbody {
        @for (name, number) in rows { tr { th { (name) } td.n { (number) } } }
        @for player in &check.players { tr { th { "moves of " (game::who(&player.name, player.ours)) } td.n { (player.states.grouped()) } } }
    } } }
}

/// Renders the time of each phase.
pub(super) fn times(check: &CheckReport) -> Markup {
    let time = &check.time;
    let phases: Vec<_> = time.phases().filter_map(|(name, seconds)| Some((name, seconds?))).collect();
    let most = phases.iter().map(|phase| phase.1).fold(1e-9, f64::max);
    html! {
        table { tbody { @for (name, seconds) in phases { tr {
            th { (name) @if name.starts_with('S') { " levels" } }
            td.n { (text::seconds(seconds)) }
            td.bar { span.plain style=(format!("width:{:.2}%", 100.0 * seconds / most)) {} }
        } } } }
        p.hint {
            (text::seconds(time.total)) " in total"
            @if check.memory.peak_nodes > 0 { ", " (grouped(check.memory.peak_nodes)) " nodes" }
            @if check.memory.peak_rss_bytes > 0 {
                ", " (text::bytes(check.memory.peak_rss_bytes)) " of memory"
            }
        }
    }
}
