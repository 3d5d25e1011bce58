//! Values that are borrowed or shared.

use std::ops::Deref;
use std::sync::Arc;

/// A borrowed or a shared value. A shared value lives as long as any of its owners, also when
/// another language holds it.
pub enum Held<'a, T> {
    /// A reference to a value of another owner.
    Borrowed(&'a T),
    /// A shared value.
    Shared(Arc<T>),
}

impl<T> Clone for Held<'_, T> {
    fn clone(&self) -> Self {
        match self {
            Held::Borrowed(value) => Held::Borrowed(value),
            Held::Shared(value) => Held::Shared(Arc::clone(value)),
        }
    }
}

impl<T> Deref for Held<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        match self {
            Held::Borrowed(value) => value,
            Held::Shared(value) => value,
        }
    }
}

impl<'a, T> From<&'a T> for Held<'a, T> {
    fn from(value: &'a T) -> Self {
        Held::Borrowed(value)
    }
}

impl<'a, T> From<&'a Arc<T>> for Held<'a, T> {
    fn from(value: &'a Arc<T>) -> Self {
        Held::Borrowed(value)
    }
}

impl<T> From<Arc<T>> for Held<'_, T> {
    fn from(value: Arc<T>) -> Self {
        Held::Shared(value)
    }
}
