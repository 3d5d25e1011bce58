//! What one thing has of another: borrowed for a while, or held together with others.

use std::ops::Deref;
use std::sync::Arc;

/// A borrowed or a shared value. With a shared one nothing outlives its owner, whatever the language that
/// holds it.
pub enum Held<'a, T> {
    /// Lent by somebody who keeps it.
    Borrowed(&'a T),
    /// Held together with others.
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
