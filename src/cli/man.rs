//! `meliora man`: the manual page.

use clap::Args;
use clap_mangen::Man;
use meliora::error::Error;

use super::exit::Status;
use super::terminal;

/// Write the manual page in roff, of the program or of one command
#[derive(Debug, Args)]
pub(super) struct ManArgs {
    /// The command to describe
    #[arg(value_name = "COMMAND")]
    command: Option<String>,
}

/// Writes the page to stdout.
///
/// # Errors
/// There is no such command; standard output could not be written.
pub(super) fn run(args: &ManArgs) -> Result<Status, Error> {
    let mut program = super::command();
    program.build();
    let page = match &args.command {
        None => program,
        Some(name) => match program.find_subcommand(name) {
            Some(command) => command.clone(),
            None => return Err(Error::Usage(format!("there is no command `{name}` to describe"))),
        },
    };
    let mut text = Vec::new();
    if let Err(e) = Man::new(page).render(&mut text) {
        return Err(Error::Io { path: "standard output".to_owned(), message: e.to_string() });
    }
    terminal::print(&String::from_utf8_lossy(&text))?;
    Ok(Status::Done)
}
