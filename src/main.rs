//! The `meliora` command: hands the arguments to the library, which returns the exit status.

fn main() -> std::process::ExitCode {
    meliora::command(&std::env::args_os().collect::<Vec<_>>())
}
