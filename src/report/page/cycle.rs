//! The section of a page that says why any number of improvements is possible.

use maud::{Markup, html};

use super::super::CheckReport;

/// Renders the cycle of the first initial state; nothing without one.
pub(super) fn section(check: &CheckReport) -> Markup {
    let found = check.cycles.first().and_then(Option::as_ref);
    html! {
        @if let Some(cycle) = found { section #cycle {
            h2 { "Why any number of improvements" }
            p.hint {
                (cycle.title()) ". Each step has the successor that comes closest to the next improvement."
            }
            div.scroll { table.turns { tbody {
                @for [number, action, to, effect] in cycle.rows() { tr {
                    td.n { (number) } td { b { (action) } } td { (to) }
                    td { @if effect.ends_with("gained") { span.good { (effect) } } @else { span.hint { (effect) } } }
                } }
                tr { td {} td colspan="3" { (cycle.end()) } }
            } } }
        } }
    }
}
