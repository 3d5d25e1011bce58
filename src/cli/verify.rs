//! `meliora verify`: checks a dump as a certificate.

use std::path::{Path, PathBuf};

use clap::Args;
use meliora::commands::GivenDump;
use meliora_base::error::{Error, Limit};
use meliora_engine::Scope;
use meliora_report::VerifyReport;

use super::exit::Status;
use super::load;
use super::model_files::ModelFiles;
use super::options::ShownArgs;
use super::policy_file;
use super::query::LimitArgs;
use super::supervise::{Job, supervise};

/// Check a dump against the model by one-step conditions, without the fixpoint code; or check a policy
///
/// A policy is a file that `reach --policy` or a planner for FOND problems has written. Each state that it
/// visits needs an enabled action, and the goal must stay reachable. The strategies of a property `multi(…)`
/// must have the values that they claim. A policy of `strategy --policy` must keep its promise: the
/// improvements, the objectives that it achieves, and that no step weakens its reference.
///
/// Uses the constants, scope, safety and variable order of the dump, and says so; in a game, every choice of the
/// opponent is checked. If a condition is violated,
/// prints the first one and ends with exit status 1. If the certificate leaves out regions, because a limit ended
/// `export`, names them and ends with exit status 4.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  meliora verify toy.dump models/toy.prism models/toy.pref
  meliora verify toy.dump models/toy.prism models/toy.pref --json
  meliora verify policy.txt models/responders.pddl
  meliora verify policy.json models/robot5x5.prism models/robot5x5.pref")]
pub(super) struct VerifyArgs {
    /// Directory of the dump, or file of a policy
    #[arg(value_name = "DIR")]
    directory: PathBuf,

    #[command(flatten)]
    model: ModelFiles,

    /// Preference file that the dump or the policy was made from; none for a policy of `reach`
    #[arg(value_name = "PREFS")]
    preferences: Option<PathBuf>,

    #[command(flatten)]
    policy: super::policy_file::PolicyArgs,

    /// Check that the policy is strong, too: every path reaches the goal within a bound
    #[arg(long)]
    strong: bool,

    /// Bounds of integers that are unbounded in a JANI model, the same as for `export` (repeatable)
    #[arg(long, value_name = "NAME=LOW..HIGH,…")]
    bounds: Vec<String>,

    /// Players of a game who we are, the same as for `export` [default: those of the preference file,
    /// else the first player]
    #[arg(long, value_name = "PLAYER,…")]
    coalition: Option<String>,

    #[command(flatten)]
    limits: LimitArgs,
    #[command(flatten)]
    shown: ShownArgs,
}

/// Runs the command.
///
/// # Errors
/// The dump or the input is wrong, or a limit is hit.
pub(super) fn run(args: VerifyArgs) -> Result<Status, Error> {
    let is_policy = args.preferences.is_none() || args.directory.is_file();
    let Some(preferences) = args.preferences.clone().filter(|_| !is_policy) else {
        let checked = policy_file::PolicyFile {
            policy: args.directory,
            preferences: args.preferences,
            coalition: args.coalition,
            model: args.model,
            constants: args.policy.constants.join(","),
            bounds: args.bounds.join(","),
            target: args.policy.target,
            limits: args.limits.limits(),
        };
        return checked.check(args.strong, &args.shown);
    };
    if args.strong || args.policy.is_given() {
        let message = "`--strong`, `--target` and `--const` are for policies; a dump is verified with the constants of \
                       the dump";
        return Err(Error::Usage(message.to_owned()));
    }
    let report = VerifyReport::of_directory(&args.directory.display().to_string());
    let (limits, shown) = (args.limits.limits(), args.shown.clone());
    supervise(report, limits, &shown, move |job| work(job, &args, &preferences))
}

fn work(job: &Job<VerifyReport>, args: &VerifyArgs, preferences: &Path) -> Result<(), Error> {
    let read = || GivenDump::read(load::dump(&args.directory)?, job.sink.as_ref());
    let dump = job.timed("load", read, |_, _| ())?;
    let manifest = dump.manifest();
    job.update(|r| r.set_taken(manifest));
    let given = load::given("the constants of the dump", manifest.given_constants(), args.bounds.join(","));
    let coalition = args.coalition.as_deref();
    let task = || {
        let model = load::model(&args.model, coalition, &given, false, &job.sink)?;
        load::preferring(model, preferences, &job.sink)
    };
    let task =
        job.timed("parse", task, |_, _| ()).map_err(|error| explained(error, args, preferences, &dump))?;
    let settings = args.limits.settings(Scope::default(), job);
    let verdict = job.timed("verify", || dump.check(&task, settings), |_, _| ())?;
    job.update(|r| r.set(&task.program, &verdict));
    // Uncertified regions must not look like success.
    match verdict.uncertified.len() {
        0 => Ok(()),
        _ if verdict.violation.is_some() => Ok(()),
        open => Err(Limit::Uncertified(open).into()),
    }
}

/// Explains an error in a text that is not the one the dump was made from.
fn explained(error: Error, args: &VerifyArgs, preferences: &Path, dump: &GivenDump) -> Error {
    let Error::Input(_) = error else { return error };
    let model = || dump.made_from("model", load::document(&args.model).ok()?.source());
    let wishes = || dump.made_from("preference file", &*load::read(preferences).ok()?);
    model().or_else(wishes).unwrap_or(error)
}
