//! The command line, one file per subcommand. Only the command prints, reads the environment and ends
//! the process. It reads the clock, too, as `supervise` does; the rest of the library does not.

mod advice;
mod asked;
mod by_name;
mod choose;
#[cfg(test)]
mod commands_page;
mod engines;
mod exit;
mod files;
mod folder;
mod load;
mod model_files;
mod node_policy;
mod objective_policy;
mod options;
mod plan;
mod planning;
mod policy;
mod policy_file;
mod progress;
mod progress_line;
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
mod questions;
mod reach;
mod regions;
mod report;
mod shield;
mod simulate;
mod strategy;
mod values;
mod verify;
mod version;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use meliora::sweep::ranges;
use meliora_base::error::Error;

use exit::Status;
use terminal::Form;

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
/// Reads models in PRISM's language (mdp, dtmc, smg), in JANI, as planning problems in PDDL, or listed
/// state by state (UMB, DRN, .tra), and preferences over objectives. Computes from which states, and how many times in a row, a
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
    Shield(shield::ShieldArgs),
    Report(report::ReportArgs),
    Export(export::ExportArgs),
    Query(query::QueryArgs),
    Verify(verify::VerifyArgs),
    Compare(compare::CompareArgs),
    Generate(generate::GenerateArgs),
    Completions(completions::CompletionsArgs),
    Man(man::ManArgs),
}

/// Returns the command line.
fn parser() -> clap::Command {
    let constants = |command: clap::Command| command.mut_arg("constants", |arg| arg.help(sweep::CONSTANTS));
    let sweeps = ["check", "reach", "compare"].into_iter();
    sweeps.fold(Cli::command(), |all, sweeps| all.mut_subcommand(sweeps, constants))
}

/// Runs the command `meliora` with these arguments (the first one is the name of the program), and
/// returns its exit status. This function reads the clock, the environment and files, prints, and
/// handles signals. The process is expected to end after it: a thread may be left behind.
pub(crate) fn command(args: &[OsString]) -> ExitCode {
    let (args, form) = (args.to_vec(), form(args));
    watch::run(move || run(&args, form), |error| fail(error, form)).into()
}

fn run(args: &[OsString], form: Form) -> Status {
    signals::prepare();
    let cli = match parsed(args) {
        Ok(cli) => cli,
        Err(error) => return terminal::show_clap(&tips::with_tip(error, args), form),
    };
    let outcome = match cli.command {
        Command::Check(args) => check::run(args),
        Command::Reach(args) => reach::run(args),
        Command::Info(args) => info::run(args),
        Command::Strategy(args) => strategy::run(args),
        Command::Simulate(args) => simulate::run(args),
        Command::Values(args) => values::run(args),
        Command::Shield(args) => shield::run(args),
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
        Err(error) => fail(&error, form),
    }
}

/// Shows an error that ends the run without a report.
fn fail(error: &Error, form: Form) -> Status {
    let failure = advice::failure(error);
    terminal::show_error(error, None);
    if !terminal::has_printed() && terminal::print_failure(&failure, form).is_err() {
        return Status::Limit;
    }
    Status::for_error(error)
}

/// Parses the arguments, in which options of PRISM may stand for ours.
fn parsed(args: &[OsString]) -> Result<Cli, clap::Error> {
    let args = planning::with_problems(with_options_of_prism(args));
    let matches = parser().try_get_matches_from(args)?;
    Cli::from_arg_matches(&matches)
}

/// Replaces options of PRISM, such as `-const K=4`, by ours. (`-c onst` would give no constant a value.)
fn with_options_of_prism(args: &[OsString]) -> Vec<OsString> {
    const OPTIONS: [(&str, &str); 3] =
        [("-const", "--const"), ("-pf", "--property"), ("-pctl", "--property")];
    let end = args.iter().position(|arg| arg == "--").unwrap_or(args.len());
    let own = |arg: &OsString| {
        let found = OPTIONS.iter().find(|(theirs, _)| arg == theirs);
        found.map_or_else(|| arg.clone(), |(_, own)| own.into())
    };
    args[..end].iter().map(own).chain(args[end..].iter().cloned()).collect()
}

/// Returns the form of results that the arguments ask for; also works for arguments that do not parse.
fn form(args: &[OsString]) -> Form {
    let has = |option: &str| args.iter().skip(1).take_while(|a| *a != "--").any(|a| a == option);
    match (has("--instance"), has("--json")) {
        (true, _) => Form::Instance,
        (_, true) => Form::Json,
        _ => Form::Text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_options_of_prism_are_ours() {
        let args = |text: &str| text.split(' ').map(OsString::from).collect::<Vec<_>>();
        for (theirs, own) in [
            ("m info a -const K=4 -- -const", "m info a --const K=4 -- -const"),
            ("m reach a -pf P>0[...]", "m reach a --property P>0[...]"),
        ] {
            assert_eq!(with_options_of_prism(&args(theirs)), args(own));
        }
    }

    /// Splits a command line as a shell does.
    fn words(line: &str) -> Vec<String> {
        let parts = line.split('\'').enumerate();
        let split = |(index, part): (usize, &str)| match index % 2 {
            0 => part.split_whitespace().map(str::to_owned).collect::<Vec<_>>(),
            _ => vec![part.to_owned()],
        };
        parts.flat_map(split).take_while(|word| word != ">").collect()
    }

    #[test]
    fn every_command_has_examples_that_it_takes() {
        let command = parser();
        for sub in command.get_subcommands().filter(|sub| sub.get_name() != "help") {
            let help = sub.get_after_help().map(ToString::to_string).unwrap_or_default();
            let lines: Vec<&str> = help.lines().map(str::trim).filter(|l| l.starts_with("meliora")).collect();
            assert!(lines.len() >= 2, "{}: {help}", sub.get_name());
            for line in lines {
                let parsed = command.clone().try_get_matches_from(words(line));
                assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
            }
        }
    }
}
