//! The places where a model defines names.

use crate::ast::{Ident, Item};
use crate::parse::parse_model;
use meliora_model::Program;

/// The kind of a name in the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Constant,
    Formula,
    Label,
    Variable,
}

/// Returns a note that says where the model defines a name. Only texts in PRISM's language have places of
/// all names. The text is parsed once more, since a program has no places of its labels.
pub(super) fn in_model(program: &Program, name: &str, kind: Kind) -> String {
    let source = &program.source;
    let at = match kind {
        Kind::Variable => program.variables.iter().find(|v| v.name == name).map(|v| v.span.start),
        kind => {
            let items = parse_model(source).map(|model| model.items).unwrap_or_default();
            let names = items.into_iter().filter_map(|item| defines(item, kind));
            names.into_iter().find(|ident| ident.name == name).map(|ident| ident.span.start())
        }
    };
    match at {
        Some(at) if at > 0 => {
            let (line, column) = source.position(at);
            format!("the model defines it at {}:{line}:{column}", source.name)
        }
        _ => format!("the model {} defines it", source.name),
    }
}

fn defines(item: Item, kind: Kind) -> Option<Ident> {
    match (item, kind) {
        (Item::Const(constant), Kind::Constant) => Some(constant.name),
        (Item::Formula(named), Kind::Formula) | (Item::Label(named), Kind::Label) => Some(named.name),
        _ => None,
    }
}
