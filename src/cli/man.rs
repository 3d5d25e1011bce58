//! `meliora man`: manual pages.

use clap::Args;
use clap_mangen::Man;
use meliora_base::error::Error;

use super::exit::Status;
use super::terminal;

/// The program and its version, at the foot of the page.
const SOURCE: &str = concat!("meliora ", env!("CARGO_PKG_VERSION"));

/// Print the manual page of the program or of one command, in roff
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  meliora man > meliora.1
  meliora man check > meliora-check.1")]
pub(super) struct ManArgs {
    /// Command to describe
    #[arg(value_name = "COMMAND")]
    command: Option<String>,
}

/// Prints the page.
///
/// # Errors
/// The command does not exist, or standard output cannot be written.
pub(super) fn run(args: &ManArgs) -> Result<Status, Error> {
    let mut program = super::parser();
    program.build();
    let page = match &args.command {
        None => program,
        Some(name) => match program.find_subcommand(name) {
            Some(command) => command.clone(),
            None => {
                return Err(Error::Usage(format!(
                    "unknown command `{name}`; `meliora --help` lists the commands"
                )));
            }
        },
    };
    let mut text = Vec::new();
    if let Err(e) = Man::new(page).source(SOURCE).render(&mut text) {
        return Err(Error::Io { path: "standard output".to_owned(), message: e.to_string() });
    }
    terminal::print_bytes(&text)?;
    Ok(Status::Done)
}
