//! The `meliora` command.
fn main() {}
