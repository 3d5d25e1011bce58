//! Tables with bars that compare sizes.

use maud::{Markup, html};

use super::super::check::{CheckReport, LevelsReport};
use super::super::text;
use super::Number;
use super::words::{percent, share};

fn whole(check: &CheckReport) -> Number {
    check.counts.as_ref().map(|c| c.states.clone()).unwrap_or_default()
}

/// Renders a number of states with its share of all states.
fn cell(part: &Number, whole: &Number, class: &str) -> Markup {
    let percent = percent(part, whole);
    html! {
        td.n { (part.grouped()) }
        td.bar title=(share(percent)) {
            span class=(class) style=(format!("width:{percent:.2}%")) {}
        }
    }
}

/// Renders the objectives with the sizes of their regions.
pub(super) fn objectives(check: &CheckReport) -> Markup {
    let whole = whole(check);
    html! {
        table {
            thead { tr {
                th { "objective" } th.n { "target" }
                th colspan="2" { "almost sure in" } th colspan="2" { "possible in" }
            } }
            tbody { @for o in &check.objectives { tr {
                th { (o.name) } td.n { (o.target.grouped()) }
                (cell(&o.almost_sure, &whole, "sure"))
                (cell(&o.positive, &whole, "possible"))
            } } }
        }
    }
}

/// Renders the classes with their sizes.
pub(super) fn classes(check: &CheckReport) -> Markup {
    let whole = whole(check);
    html! {
        table {
            thead { tr { th { "sure" } th colspan="2" { "states" } } }
            tbody { @for class in check.classes.iter().flatten() { tr {
                th { (text::names(&class.most_preferred)) }
                (cell(&class.states, &whole, "plain"))
            } } }
        }
    }
}

/// Renders the SASI and SPI levels side by side, one line per number of improvements.
pub(super) fn levels(check: &CheckReport) -> Markup {
    let none = LevelsReport::default();
    let (sasi, spi) = (check.sasi.as_ref().unwrap_or(&none), check.spi.as_ref().unwrap_or(&none));
    let whole = whole(check);
    let at = |levels: &LevelsReport, k: usize| {
        levels.levels.get(k).or(levels.unbounded.as_ref()).map(|n| (n.clone(), k))
    };
    html! {
        table {
            thead { tr {
                th { "improvements" } th colspan="2" { "guaranteed (SASI)" } th colspan="2" { "possible (SPI)" }
            } }
            tbody {
                @for k in 0..sasi.levels.len().max(spi.levels.len()) { tr {
                    th { (k + 1) " or more" }
                    (level(at(sasi, k).map(|l| l.0), &whole, "sure"))
                    (level(at(spi, k).map(|l| l.0), &whole, "possible"))
                } }
                tr {
                    th { "any number" }
                    (level(sasi.unbounded.clone(), &whole, "sure"))
                    (level(spi.unbounded.clone(), &whole, "possible"))
                }
            }
        }
    }
}

fn level(states: Option<Number>, whole: &Number, class: &str) -> Markup {
    match states {
        Some(states) => cell(&states, whole, class),
        None => html! { td.n { "?" } td.bar {} },
    }
}

/// Renders the sizes of the model and the improvement MDP.
pub(super) fn sizes(check: &CheckReport) -> Markup {
    let mut rows: Vec<(&str, String)> = Vec::new();
    if let Some(counts) = &check.counts {
        rows.extend([
            ("states", counts.states.grouped()),
            ("choices", counts.choices.grouped()),
            ("transitions", counts.transitions.grouped()),
            ("deadlocks", counts.deadlocks.grouped()),
            ("initial states", counts.initial.grouped()),
        ]);
    }
    if let Some(improvement) = &check.improvement {
        rows.push(("improvement MDP: states", improvement.states.grouped()));
        rows.push(("improvement MDP: transitions", improvement.transitions.grouped()));
        rows.push(("transitions dropped", improvement.dropped.grouped()));
    }
    html! { table { tbody { @for (name, number) in rows { tr { th { (name) } td.n { (number) } } } } } }
}

/// Renders the time of each phase.
pub(super) fn times(check: &CheckReport) -> Markup {
    let time = &check.time;
    let phases = [
        ("parse", time.parse),
        ("build", time.build),
        ("outcomes", time.outcomes),
        ("improvement", time.improvement),
        ("SASI levels", time.sasi),
        ("SPI levels", time.spi),
    ];
    let most = phases.iter().filter_map(|(_, t)| *t).fold(1e-9, f64::max);
    html! {
        table { tbody { @for (name, seconds) in phases { @if let Some(seconds) = seconds { tr {
            th { (name) }
            td.n { (text::seconds(seconds)) }
            td.bar { span.plain style=(format!("width:{:.2}%", 100.0 * seconds / most)) {} }
        } } } } }
        p.hint {
            (text::seconds(time.total)) " in total"
            @if check.memory.peak_nodes > 0 { ", " (Number::from(check.memory.peak_nodes).grouped()) " nodes" }
            @if check.memory.peak_rss_bytes > 0 {
                ", " (text::bytes(check.memory.peak_rss_bytes)) " of memory"
            }
        }
    }
}
