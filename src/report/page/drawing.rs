//! The style of separate drawings, so that they look as in the page.

use maud::{Markup, PreEscaped, html};

use super::palette;

/// Returns the style sheet.
pub(crate) fn style() -> Markup {
    html! { style { (PreEscaped(include_str!("picture.css"))) } }
}

/// Renders the background, so that the drawing is readable on dark pages.
pub(crate) fn paper(width: usize, height: usize) -> Markup {
    html! { rect.paper width=(width) height=(height) {} }
}

/// Returns the colour of a curve by its position.
pub(crate) fn color(position: usize) -> String {
    palette::hex(palette::class(Some(position)))
}
