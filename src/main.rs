//! The `meliora` command.

mod cli;

fn main() -> std::process::ExitCode {
    cli::command(&std::env::args_os().collect::<Vec<_>>())
}
