//! Values of the format that have their own form: types, names of actions, version and features.

use super::super::json::{Node, Shape};
use super::reader::Reader;
use super::record::{Read, records};
use crate::ast::{Expr, Ident, Span};
use meliora_base::stack;
use meliora_base::value::Type;
use meliora_model::ModelKind;

/// Features that are supported, or have no effect here. Features that only add operators are
/// refused at the operators.
const SUPPORTED: &[&str] = &[
    "arrays",
    "derived-operators",
    "functions",
    "state-exit-rewards",
    "hyperbolic-functions",
    "trigonometric-functions",
    "named-expressions",
    "x-momba-operators",
];

records! {
    /// The form of guards, probabilities and restrictions.
    Exp = "an object with an expression" {
        "exp" => exp: Expr,
    };

    Bounded = "a bounded type" {
        "base" => base: Ident,
        "lower-bound" => low: Option<Expr> = None,
        "upper-bound" => high: Option<Expr> = None,
    }
    ignores { "kind" };
}

/// The type of a constant, a variable or a parameter, with the given bounds of a bounded type.
#[derive(Debug, Clone)]
pub(crate) struct Bounds {
    pub(crate) ty: Type,
    pub(crate) low: Option<Expr>,
    pub(crate) high: Option<Expr>,
    /// The number of arrays around values of the type.
    pub(crate) dimensions: usize,
    pub(crate) span: Span,
}

/// Reads `"bool"`, `"int"`, `"real"`, a bounded type of the last two, or arrays of these.
impl<'a> Read<'a> for Bounds {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, _: &str) -> Option<Self> {
        let span = node.span();
        let kind = match reader.any(node)? {
            Shape::Text(name) => {
                let ty = basic(reader, &Ident { name, span })?;
                return Some(Bounds { ty, low: None, high: None, dimensions: 0, span });
            }
            Shape::Object(object) => reader.field::<Ident>(&object, "a type", "kind", None)?,
            _ => return reader.fail(span, "expected a type"),
        };
        match kind.name.as_str() {
            "bounded" => {
                let Bounded { base, low, high } = Bounded::read(reader, node, "")?;
                let ty = basic(reader, &base)?;
                if ty == Type::Bool {
                    return reader.fail(base.span, "only numbers have bounds");
                }
                Some(Bounds { ty, low, high, dimensions: 0, span })
            }
            "array" => {
                let what = "the type of an array";
                let object = reader.object(node, what, &["kind", "base"], &[])?;
                let base = reader.required(&object, what, "base")?;
                let base = stack::level(|| Bounds::read(reader, base, "the type of elements"))?;
                Some(Bounds { dimensions: base.dimensions + 1, span, ..base })
            }
            "datatype" | "option" => reader.unsupported(kind.span, "datatypes are not supported"),
            other => reader.fail(kind.span, format!("unknown kind of type \"{other}\"")),
        }
    }
}

fn basic(reader: &mut Reader<'_>, name: &Ident) -> Option<Type> {
    match name.name.as_str() {
        "bool" => Some(Type::Bool),
        "int" => Some(Type::Int),
        "real" => Some(Type::Real),
        "clock" => reader.unsupported(name.span, "clocks are not supported"),
        "continuous" => reader.unsupported(name.span, "continuous variables are not supported"),
        other => reader.fail(name.span, format!("unknown type \"{other}\"")),
    }
}

impl<'a> Read<'a> for ModelKind {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self> {
        let kind = reader.name(node, what)?;
        match kind.name.as_str() {
            "mdp" => Some(ModelKind::Mdp),
            "dtmc" => Some(ModelKind::Dtmc),
            "lts" | "ctmc" | "ctmdp" | "ma" | "ta" | "pta" | "sta" | "ha" | "pha" | "sha" | "smg" => {
                let message = format!("models of type `{}` are not supported", kind.name);
                let diagnostic = reader.not_supported(kind.span, message);
                reader.report(diagnostic.help("the types `mdp` and `dtmc` are supported"));
                None
            }
            name => reader.fail(kind.span, format!("unknown model type \"{name}\"")),
        }
    }
}

/// The action of an element in a vector; none is written `null`.
#[derive(Debug, Clone)]
pub(crate) struct Action(pub(crate) Option<Ident>);

impl<'a> Read<'a> for Action {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self> {
        if reader.is_null(node) {
            return Some(Action(None));
        }
        // Storm hides an action by giving it no name.
        let name = reader.name(node, &format!("{what}, an action or null"))?;
        Some(Action((!name.name.is_empty()).then_some(name)))
    }
}

/// The version of the format; only 1 is supported.
pub(super) struct Version;

impl<'a> Read<'a> for Version {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self> {
        match reader.whole(node, what)? {
            1 => Some(Version),
            other => {
                reader.unsupported(node.span(), format!("version {other} of the format is not supported"))
            }
        }
    }
}

/// The name of a supported feature.
pub(super) struct Feature;

impl<'a> Read<'a> for Feature {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self> {
        let feature = reader.name(node, what)?;
        if SUPPORTED.contains(&feature.name.as_str()) {
            return Some(Feature);
        }
        reader.unsupported(feature.span, format!("the feature \"{}\" is not supported", feature.name))
    }
}
