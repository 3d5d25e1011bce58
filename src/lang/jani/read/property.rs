//! Properties: those that ask for the probability of a formula on paths, or for the expected reward
//! until a state set is reached, and reasons against the others.

use super::super::json::{Node, Shape};
use super::reader::Reader;
use super::record::{Read, records};
use crate::ast::{Expr, Ident, Span};
use crate::refusal::Refusal;

/// A part of a property, or the reason why a well-formed property is not supported.
pub(super) type Asks<T> = Option<Result<T, String>>;

pub(super) const NO_PROBABILITY: &str =
    "it does not ask for a probability, or a reward to reach a set of states";

/// Keys of expected values at one moment.
pub(super) const INSTANTS: &[&str] = &["step-instant", "time-instant", "reward-instants"];

/// The moments at which rewards are accumulated. In a discrete-time model no time passes in a state.
const MOMENTS: &[&str] = &["steps", "exit", "time"];

records! {
    /// A property that could be read.
    Readable = "a property" {
        "name" => name: Ident,
        "expression" => asks: Asked,
    };
}

/// A property of the model, or the reason against it.
#[derive(Debug, Clone)]
pub(crate) struct Property {
    pub(crate) name: String,
    /// The place of the name, or of the property without a name.
    pub(crate) span: Span,
    pub(crate) asks: Result<Expressed, Refusal>,
}

/// The properties of a model.
#[derive(Debug, Clone, Default)]
pub(crate) struct Properties(Vec<Property>);

impl std::ops::Deref for Properties {
    type Target = [Property];

    fn deref(&self) -> &[Property] {
        &self.0
    }
}

impl<'a> Read<'a> for Properties {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self> {
        let all = reader.array(node, what)?.into_iter().enumerate();
        all.map(|(index, node)| property(reader, node, index)).collect::<Option<_>>().map(Properties)
    }
}

/// Reads a property. Errors in it are the reason against it: they leave the model and the other properties.
fn property<'a>(reader: &mut Reader<'a>, node: Node<'a>, index: usize) -> Option<Property> {
    let told = reader.told();
    if let Some(Readable { name, asks }) = Readable::read(reader, node, "a property") {
        let Ident { name, span } = name;
        return Some(Property { name, span, asks: asks.map_err(Refusal::without_place) });
    }
    let wrong = reader.take_back(told)?;
    let told = reader.told();
    let name = match reader.any(node) {
        Some(Shape::Object(object)) => {
            object.get("name").and_then(|name| Ident::read(reader, name, "the name of a property"))
        }
        _ => None,
    };
    reader.take_back(told);
    let unnamed = || Ident { name: format!("properties[{index}]"), span: node.span() };
    let Ident { name, span } = name.unwrap_or_else(unnamed);
    Some(Property { name, span, asks: Err(Refusal::at(&wrong)) })
}

/// The property, or the reason why it is not supported.
pub(crate) type Asked = Result<Expressed, String>;

/// A property as an expression over states.
#[derive(Debug, Clone)]
pub(crate) struct Expressed {
    pub(crate) expression: Expr,
    /// The rewards to which its operators refer by numbers from 1.
    pub(crate) rewards: Vec<Reward>,
}

/// A reward that is accumulated.
#[derive(Debug, Clone)]
pub(crate) struct Reward {
    pub(crate) value: Expr,
    /// With every step: the value after its assignments.
    pub(crate) steps: bool,
    /// At the end of a stay in a state: the value in the state.
    pub(crate) exit: bool,
}

impl<'a> Read<'a> for Asked {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, _: &str) -> Option<Self> {
        reader.expressed(node)
    }
}

/// Returns the reason why a property is not supported.
pub(super) fn no<T>(reason: &str) -> Asks<T> {
    Some(Err(reason.to_owned()))
}

impl<'a> Reader<'a> {
    /// Reads the moments at which rewards are accumulated.
    pub(super) fn moments(&mut self, node: Node<'a>) -> Option<Vec<String>> {
        let moments = Vec::<Ident>::read(self, node, "the moments of rewards")?;
        if let Some(Ident { name, span }) = moments.iter().find(|m| !MOMENTS.contains(&m.name.as_str())) {
            return self.fail(*span, format!("unknown moment \"{name}\" of a reward"));
        }
        Some(moments.into_iter().map(|moment| moment.name).collect())
    }
}
