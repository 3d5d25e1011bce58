//! The stack of recursions over nested input.

/// The stack that a level of nesting may need, in bytes; if less is left, the stack grows.
const LEFT: usize = 128 << 10;
/// The size by which the stack grows, in bytes.
const MORE: usize = 4 << 20;

/// Runs one level of a recursion whose depth depends on the input, on a new stack if little is left
/// of this one.
pub fn level<T>(recursion: impl FnOnce() -> T) -> T {
    stacker::maybe_grow(LEFT, MORE, recursion)
}
