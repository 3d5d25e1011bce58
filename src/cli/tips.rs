//! Tips for command lines that cannot be parsed, for users who expect something else.

use std::ffi::OsString;
use std::path::Path;

use clap::error::{ContextKind, ContextValue, ErrorKind};

/// Words that are no commands, with what to write instead.
const OTHER_COMMANDS: &[(&str, &str)] = &[
    ("sweep", "a range of a constant makes a sweep, as in `meliora check MODEL PREFS -c N=1:5`"),
    ("explain", "`meliora strategy MODEL PREFS` explains the actions of a state"),
    ("plan", "`meliora strategy MODEL PREFS --kind plan` shows a plan"),
    ("prism", "`meliora reach MODEL --property PROPERTY` answers properties of PRISM"),
];

/// Options of `export` whose values a dump contains.
const OF_DUMP: &[&str] = &["--scope", "--safety", "--order"];

/// Adds a tip to an error of the parser, if there is one.
pub(super) fn with_tip(mut error: clap::Error, args: &[OsString]) -> clap::Error {
    let words: Vec<&str> = args.iter().skip(1).map(|arg| arg.to_str().unwrap_or_default()).collect();
    let tip = match error.kind() {
        ErrorKind::InvalidSubcommand => of_command(words.first().copied().unwrap_or_default()),
        ErrorKind::UnknownArgument => of_argument(&words, &unknown(&error)),
        ErrorKind::MissingRequiredArgument => of_preferences(&error),
        _ => None,
    };
    if let Some(tip) = tip {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    error
}

fn of_command(word: &str) -> Option<&'static str> {
    if Path::new(word).is_file() {
        return Some("a file comes after a command, as in `meliora check MODEL PREFS`");
    }
    OTHER_COMMANDS.iter().find(|(other, _)| *other == word).map(|(_, tip)| *tip)
}

/// Returns the argument that the parser does not know.
fn unknown(error: &clap::Error) -> String {
    match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::String(text)) => text.split(['=', ' ']).next().unwrap_or_default().to_owned(),
        _ => String::new(),
    }
}

fn of_argument(words: &[&str], unknown: &str) -> Option<&'static str> {
    match words.first().copied().unwrap_or_default() {
        first if first.starts_with('-') => {
            Some("options come after the command, as in `meliora check MODEL PREFS -c N=3`")
        }
        "reach" if Path::new(unknown).is_file() => {
            Some("a file of properties is given by `--properties FILE`, preferences to `check`")
        }
        "verify" if OF_DUMP.contains(&unknown) => {
            Some("`verify` uses the constants, the scope, the safety and the order of the dump")
        }
        "check" | "values" | "strategy" | "simulate"
            if ["--property", "--properties", "--target"].contains(&unknown) =>
        {
            Some("`meliora reach MODEL` answers targets and properties")
        }
        _ => None,
    }
}

/// Explains the preferences to users who have only a model.
fn of_preferences(error: &clap::Error) -> Option<&'static str> {
    let missing = match error.get(ContextKind::InvalidArg) {
        Some(ContextValue::Strings(all)) => all.iter().any(|name| name == "<PREFS>"),
        _ => false,
    };
    missing.then_some(
        "preferences are a file such as `objective A = F x=1; objective B = F x=2; prefer A > B;`; `meliora reach` \
         needs none",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tip(text: &str) -> String {
        let args: Vec<OsString> = text.split(' ').map(OsString::from).collect();
        let error = super::super::parser().try_get_matches_from(&args).unwrap_err();
        with_tip(error, &args).render().to_string()
    }

    #[test]
    fn usual_mistakes_have_a_tip() {
        for (text, said) in [
            ("m sweep a -c N=1:3", "a range of a constant makes a sweep"),
            ("m explain a b", "`meliora strategy MODEL PREFS`"),
            ("m Cargo.toml b", "a file comes after a command"),
            ("m -c N=3 check a b", "options come after the command"),
            ("m reach a Cargo.toml", "given by `--properties FILE`"),
            ("m verify d a b --scope all", "of the dump"),
            ("m check a b --property P>0[F(x=1)]", "answers targets and properties"),
            ("m check a", "preferences are a file"),
            ("m strategy a --rank 1", "preferences are a file"),
        ] {
            assert!(tip(text).contains(said), "{text}: {}", tip(text));
        }
        for text in ["m chek a b", "m check a b --foo", "m reach a b", "m query"] {
            assert!(!tip(text).contains("meliora check MODEL"), "{text}: {}", tip(text));
        }
    }
}
