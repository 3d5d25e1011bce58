//! `meliora verify`: checks a dump as a certificate.

use std::path::{Path, PathBuf};

use clap::Args;
use meliora_base::error::{Error, Limit, SourceFile};
use meliora_certify as certify;
use meliora_dump::Manifest;
use meliora_dump::directory::sha256;
use meliora_dump::manifest::FILE;
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
    let (dump, picture) =
        job.timed("load", || certify::read(load::dump(&args.directory)?, job.sink.as_ref()), |_, _| ())?;
    let manifest = &dump.manifest;
    if !manifest.questions.is_empty() {
        let message = "the dump was written by `meliora reach --out`, which proves nothing: its regions are not \
                       certified; `verify` checks dumps of `meliora export`";
        return Err(wrong(&args.directory, message.to_owned()));
    }
    job.update(|r| r.set_taken(manifest));
    let given = load::given("the constants of the dump", manifest.given_constants(), args.bounds.join(","));
    let coalition = args.coalition.as_deref();
    let task = || {
        let model = load::model(&args.model, coalition, &given, false, &job.sink)?;
        load::preferring(model, preferences, &job.sink)
    };
    let task =
        job.timed("parse", task, |_, _| ()).map_err(|error| explained(error, args, preferences, manifest))?;
    if dump.certificate.is_none() {
        let message = "the dump has no certificate; `meliora export` without `--region` and `--no-certificate` writes one";
        return Err(wrong(&args.directory, message.to_owned()));
    }
    let scope = scope(manifest, &args.directory)?;
    let settings = args.limits.settings(scope, job);
    let model = sha256(task.program.source.original().as_bytes());
    let preferences = sha256(task.source.original().as_bytes());
    let hashes = certify::Hashes { model: &model, preferences: &preferences };
    let verify = || certify::verify(&task.program, &task.preferences, hashes, &dump, settings);
    let mut verdict = job.timed("verify", verify, |_, _| ())?;
    verdict.violation = verdict.violation.or(picture);
    job.update(|r| r.set(&task.program, &verdict));
    // Uncertified regions must not look like success.
    match verdict.uncertified.len() {
        0 => Ok(()),
        _ if verdict.violation.is_some() => Ok(()),
        open => Err(Limit::Uncertified(open).into()),
    }
}

/// Explains an error in a text that is not the one the dump was made from.
fn explained(error: Error, args: &VerifyArgs, preferences: &Path, manifest: &Manifest) -> Error {
    let differs = |source: &SourceFile, expected: &str| sha256(source.original().as_bytes()) != expected;
    let model = load::document(&args.model).is_ok_and(|read| differs(read.source(), &manifest.model.sha256));
    let wishes =
        || load::read(preferences).is_ok_and(|source| differs(&source, &manifest.preferences.sha256));
    let (what, file, made_from) = match error {
        Error::Input(_) if model => ("model", args.model.shown(), &manifest.model.path),
        Error::Input(_) if wishes() => {
            ("preference file", preferences.display().to_string(), &manifest.preferences.path)
        }
        error => return error,
    };
    let made_from = made_from.escape_debug();
    let message = format!(
        "the dump was made from another {what}, `{made_from}`, whose text differs from that of `{file}`"
    );
    wrong(&args.directory, message)
}

fn scope(manifest: &Manifest, directory: &Path) -> Result<Scope, Error> {
    let [reachable, all] = [Scope::Reachable, Scope::All].map(Scope::name);
    let found = manifest.scope.escape_debug();
    let message = || format!("the scope is `{found}`; expected `{reachable}` or `{all}`");
    manifest.scope.parse().map_err(|_| wrong(directory, message()))
}

fn wrong(directory: &Path, message: String) -> Error {
    Error::Dump { file: directory.join(FILE).display().to_string(), line: 0, message }
}
