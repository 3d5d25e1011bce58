//! `meliora completions`: completion scripts for shells.

use clap::Args;
use clap_complete::Shell;
use meliora_base::error::Error;

use super::exit::Status;
use super::terminal;

/// Print a completion script for a shell
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  meliora completions bash > meliora.bash
  meliora completions zsh > _meliora")]
pub(super) struct CompletionsArgs {
    /// Shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Prints the script.
///
/// # Errors
/// Standard output cannot be written.
pub(super) fn run(args: &CompletionsArgs) -> Result<Status, Error> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut super::parser(), "meliora", &mut script);
    terminal::print_bytes(&script)?;
    Ok(Status::Done)
}
