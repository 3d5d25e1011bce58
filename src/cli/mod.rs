//! The command line, one file per subcommand. Only the command prints, reads the environment and ends
//! the process. It reads the clock, too, as `supervise` does; the rest of the library does not.

mod advice;
mod agreement;
mod at;
mod by_name;
mod choose;
#[cfg(test)]
mod commands_page;
mod engines;
mod examples;
mod exit;
mod files;
mod folder;
mod load;
mod options;
mod phases;
mod plan;
mod progress;
mod properties;
mod signals;
mod supervise;
mod sweep;
mod terminal;
mod tips;
mod watch;

mod check;
mod compare;
mod completions;
mod export;
mod export_explicit;
mod generate;
mod info;
mod man;
mod query;
mod reach;
mod regions;
mod report;
mod simulate;
mod spelling;
mod strategy;
mod values;
mod verify;
mod version;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use meliora_model::error::Error;

use exit::Status;
use spelling::Respelled;

/// Exit statuses at the end of `--help`.
const EXIT_STATUS: &str = "Exit status:
  0    done
  1    the answer is no
  2    wrong usage
  3    the model, the preferences or a dump is wrong
  4    out of memory, nodes or time
  130  interrupted";

/// Symbolic model checker for opportunistic planning with incomplete preferences.
///
/// Reads models in PRISM's language (mdp, dtmc, smg), in JANI, or listed state by state (UMB, DRN,
/// .tra), and preferences over objectives. Computes from which states, and how many times in a row, a
/// strategy can improve the most preferred objectives: almost surely (SASI) or with positive
/// probability (SPI).
#[derive(Debug, Parser)]
#[command(name = "meliora", version, long_version = version::long(), propagate_version = true, arg_required_else_help = true)]
#[command(after_help = EXIT_STATUS)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Check(check::CheckArgs),
    Reach(reach::ReachArgs),
    Info(info::InfoArgs),
    Strategy(strategy::StrategyArgs),
    Simulate(simulate::SimulateArgs),
    Values(values::ValuesArgs),
    Report(report::ReportArgs),
    Export(export::ExportArgs),
    Query(query::QueryArgs),
    Verify(verify::VerifyArgs),
    Compare(compare::CompareArgs),
    Generate(generate::GenerateArgs),
    Completions(completions::CompletionsArgs),
    Man(man::ManArgs),
}

/// Returns the command line with its examples.
fn parser() -> clap::Command {
    let constants = |command: clap::Command| command.mut_arg("constants", |arg| arg.help(sweep::CONSTANTS));
    let all = examples::with_examples(Cli::command());
    ["check", "reach", "compare"].into_iter().fold(all, |all, sweeps| all.mut_subcommand(sweeps, constants))
}

/// Runs the command `meliora` with these arguments (the first one is the name of the program), and
/// returns its exit status. This function reads the clock, the environment and files, prints, and
/// handles signals. The process is expected to end after it: a thread may be left behind.
pub(crate) fn command(args: &[OsString]) -> ExitCode {
    let (args, json) = (args.to_vec(), asks_for_json(args));
    watch::run(move || run(&args, json), |error| fail(error, json)).into()
}

fn run(args: &[OsString], json: bool) -> Status {
    signals::prepare();
    let cli = match parsed(args) {
        Ok(cli) => cli,
        Err(error) => return terminal::show_clap(&tips::with_tip(error, args), json),
    };
    let outcome = match cli.command {
        Command::Check(args) => check::run(args),
        Command::Reach(args) => reach::run(args),
        Command::Info(args) => info::run(args),
        Command::Strategy(args) => strategy::run(args),
        Command::Simulate(args) => simulate::run(args),
        Command::Values(args) => values::run(args),
        Command::Report(args) => report::run(args),
        Command::Export(args) => export::run(args),
        Command::Query(args) => query::run(args),
        Command::Verify(args) => verify::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Generate(args) => generate::run(&args),
        Command::Completions(args) => completions::run(&args),
        Command::Man(args) => man::run(&args),
    };
    match outcome {
        Ok(status) => status,
        Err(error) => fail(&error, json),
    }
}

/// Shows an error that ends the run without a report.
fn fail(error: &Error, json: bool) -> Status {
    let failure = advice::failure(error);
    terminal::show_error(error, None);
    if json && !terminal::has_printed() && terminal::print_json(&failure).is_err() {
        return Status::Limit;
    }
    Status::of(error)
}

/// Parses the arguments; older spellings are accepted, with a note.
fn parsed(args: &[OsString]) -> Result<Cli, clap::Error> {
    let args = spelling::in_our_words(args);
    let parse = |args: &[OsString]| {
        parser().try_get_matches_from(args).and_then(|matches| Cli::from_arg_matches(&matches))
    };
    parse(&args).or_else(|error| {
        let respelled = Respelled::of(&args);
        let cli = parse(&respelled.args).map_err(|_| error)?;
        respelled.tell();
        Ok(cli)
    })
}

/// Returns whether the arguments ask for JSON; also works for arguments that do not parse.
fn asks_for_json(args: &[OsString]) -> bool {
    args.iter().skip(1).take_while(|a| *a != "--").any(|a| a == "--json" || a == "--instance")
}
