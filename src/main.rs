//! The `meliora` command: parse the arguments, run, map the outcome to an exit status.

mod cli;

fn main() -> std::process::ExitCode {
    cli::run(&std::env::args_os().collect::<Vec<_>>()).into()
}
