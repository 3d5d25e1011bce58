# The recipes of a change, for `just`; `.ci/run` takes the commands of the first four from here.

# The form of the code.
form:
    cargo fmt --all --check

# Lints, and the documentation, without warnings.
lint:
    cargo clippy --workspace --all-targets --locked -- -D warnings
    RUSTDOCFLAGS='-D warnings' cargo doc --no-deps --locked

# The library without the command, as other programs embed it.
library:
    cargo clippy -p meliora --no-default-features --lib --locked -- -D warnings
    cargo clippy -p meliora --no-default-features --features output,supervise --lib --locked -- -D warnings

# The short programs that show the library.
examples:
    for example in examples/*.rs; do cargo run --quiet --locked --example "$(basename "$example" .rs)"; done

# All tests, with a fifth of the cases of random and exhaustive ones.
test:
    cargo test --locked

# All tests with all their cases.
long:
    MELIORA_TESTS=long cargo test --locked

# The benches; `cargo bench -p meliora-benches --bench engines -- fleet` runs some.
bench:
    cargo bench -p meliora-benches

# Archives and wheels of this machine, in `target/dist`.
release:
    scripts/release.sh --targets host target/dist

# All that a change must pass; `.ci/run --long` takes all cases.
ci:
    .ci/run
