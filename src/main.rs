//! The `meliora` command: parses the arguments, runs, and maps the result to an exit status.

mod cli;

fn main() -> std::process::ExitCode {
    cli::run(&std::env::args_os().collect::<Vec<_>>()).into()
}
