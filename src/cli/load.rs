//! placeholder
use meliora::error::Diagnostic;
pub(super) fn render(d: &Diagnostic, _color: bool) -> String { d.message.clone() }
