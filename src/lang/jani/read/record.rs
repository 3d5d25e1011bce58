//! Objects of the format as tables of their keys.

use super::super::json::{Node, Object};
use super::reader::Reader;
use crate::ast::{Ident, Span};

/// A value of the document that can be read.
pub(crate) trait Read<'a>: Sized {
    /// Reads a value; `what` names it in messages. Returns `None` after reporting an error.
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self>;
}

/// A list that is not empty.
#[derive(Debug, Clone)]
pub(crate) struct NonEmpty<T>(pub(crate) Vec<T>);

impl<T> std::ops::Deref for NonEmpty<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.0
    }
}

impl<'a, T: Read<'a>> Read<'a> for NonEmpty<T> {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self> {
        let items = Vec::read(reader, node, what)?;
        if items.is_empty() {
            return reader.fail(node.span(), format!("{what} must not be empty"));
        }
        Some(NonEmpty(items))
    }
}

impl<'a, T: Read<'a>> Read<'a> for Option<T> {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self> {
        T::read(reader, node, what).map(Some)
    }
}

/// Reads every item of an array, all of them before giving up.
impl<'a, T: Read<'a>> Read<'a> for Vec<T> {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self> {
        let item = format!("an item of {what}");
        let nodes = reader.array(node, what)?;
        let items: Vec<_> = nodes.into_iter().map(|node| T::read(reader, node, &item)).collect();
        items.into_iter().collect()
    }
}

impl<'a> Read<'a> for Ident {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self> {
        reader.name(node, what)
    }
}

impl<'a> Read<'a> for bool {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self> {
        reader.truth(node, what)
    }
}

impl<'a> Read<'a> for i64 {
    fn read(reader: &mut Reader<'a>, node: Node<'a>, what: &str) -> Option<Self> {
        reader.whole(node, what)
    }
}

impl<'a> Reader<'a> {
    /// Reads the value of a key; without `default` the key is required.
    pub(crate) fn field<T: Read<'a>>(
        &mut self,
        object: &Object<'a>,
        what: &str,
        key: &str,
        default: Option<T>,
    ) -> Option<T> {
        match (object.get(key), default) {
            (None, Some(default)) => Some(default),
            (None, None) => self.fail(object.start(), format!("{what} has no \"{key}\"")),
            (Some(node), _) => T::read(self, node, &format!("the \"{key}\" of {what}")),
        }
    }

    /// Refuses a key by a message that names the missing feature.
    pub(crate) fn refuse(&mut self, object: &Object<'a>, key: &str, message: &str) {
        if object.get(key).is_some() {
            self.unsupported::<()>(object.key_span(key), message);
        }
    }

    /// Refuses a key whose array is not empty, by a message that names the missing feature.
    pub(crate) fn refuse_items(&mut self, object: &Object<'a>, what: &str, key: &str, message: &str) {
        let Some(node) = object.get(key) else { return };
        let items = self.array(node, &format!("the \"{key}\" of {what}"));
        if items.is_some_and(|items| !items.is_empty()) {
            self.unsupported::<()>(object.key_span(key), message);
        }
    }
}

/// Returns the place of a value, for records that keep it.
pub(crate) fn place(node: Node<'_>) -> Span {
    node.span()
}

/// Defines types of objects by their keys.
///
/// Each record has a name for messages, and for each key a field with its type, and a default
/// unless the key is required. `checks` lists keys whose values are checked and not kept, `refuses`
/// keys of unsupported features with the message, `empties` such keys that may have an empty array,
/// and `ignores` keys without an effect here. A field after `at` is the place of the object.
macro_rules! records {
    ($(
        $(#[$doc:meta])*
        $name:ident = $what:literal {
            $($key:literal => $field:ident: $ty:ty $(= $default:expr)?,)*
        }
        $(checks { $($checked:literal => $check:ty),* })?
        $(refuses { $($refused:literal => $message:literal),* })?
        $(empties { $($emptied:literal => $reason:literal),* })?
        $(ignores { $($ignored:literal),* })?
        $(at $place:ident)?;
    )*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone)]
        pub(crate) struct $name {
            $(pub(crate) $field: $ty,)*
            $(pub(crate) $place: crate::ast::Span,)?
        }

        impl<'a> $crate::jani::read::record::Read<'a> for $name {
            fn read(
                reader: &mut $crate::jani::read::reader::Reader<'a>,
                node: $crate::jani::json::Node<'a>,
                _: &str,
            ) -> Option<Self> {
                let known = [$($key,)* $($($checked,)*)? $($($emptied,)*)? $($($ignored,)*)?];
                let refused: &[&str] = &[$($($refused),*)?];
                let object = reader.object(node, $what, &known, refused)?;
                $($(reader.refuse(&object, $refused, $message);)*)?
                $($(reader.refuse_items(&object, $what, $emptied, $reason);)*)?
                $($(reader.field::<Option<$check>>(&object, $what, $checked, Some(None));)*)?
                $(let $field = reader.field::<$ty>(&object, $what, $key, None$(.or(Some($default)))?);)*
                Some($name { $($field: $field?,)* $($place: $crate::jani::read::record::place(node))? })
            }
        }
    )*};
}
pub(crate) use records;
