//! Spellings of options that the parser does not know: older ones, and those of PRISM.

use std::ffi::OsString;

use super::terminal;

/// Options of PRISM that are ours. (`-c onst` would give no constant a value.)
const OF_PRISM: [(&str, &str); 3] = [("-const", "--const"), ("-pf", "--property"), ("-pctl", "--property")];

/// Replaces options of PRISM, such as `-const K=4`, by ours.
pub(super) fn in_our_words(args: &[OsString]) -> Vec<OsString> {
    let is_ours = |a: &OsString| {
        let found = OF_PRISM.iter().find(|(theirs, _)| a == theirs);
        found.map_or_else(|| a.clone(), |(_, ours)| ours.into())
    };
    let end = end_of_options(args);
    args[..end].iter().map(is_ours).chain(args[end..].iter().cloned()).collect()
}

/// Arguments in today's spelling, with a note for each replaced option.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Respelled {
    pub(super) args: Vec<OsString>,
    notes: Vec<String>,
}

impl Respelled {
    /// Replaces the options that had another spelling. To be used if `args` cannot be parsed.
    pub(super) fn of(args: &[OsString]) -> Self {
        let mut found = Respelled::default();
        let command = args.get(1).and_then(|name| name.to_str()).unwrap_or_default();
        let end = end_of_options(args);
        let mut rest = args[..end].iter().cloned();
        while let Some(arg) = rest.next() {
            match (command, arg.to_str().map(|text| text.split_once('=').unwrap_or((text, "")))) {
                ("simulate" | "report", Some(("--strategy", value))) => {
                    let value = given(value).or_else(|| rest.next());
                    found.option("--strategy", value, |value| vec![("--scheduler", value.to_owned())]);
                }
                ("export", Some(("--strategy", value))) => {
                    let value = given(value).or_else(|| rest.next());
                    found.option("--strategy", value, |value| {
                        let (kind, scheduler) = value.split_once(':').unzip();
                        let kind = ("--kind", kind.unwrap_or(value).to_owned());
                        [kind].into_iter().chain(scheduler.map(|s| ("--scheduler", s.to_owned()))).collect()
                    });
                }
                ("strategy", Some(("--csv", ""))) => {
                    found.notes.push("`--csv` needs a file; `--csv -` is standard output".to_owned());
                    found.args.extend([arg, "-".into()]);
                }
                _ => found.args.push(arg),
            }
        }
        found.args.extend(args[end..].iter().cloned());
        found
    }

    /// Replaces an option and its value, if it has one.
    fn option(
        &mut self,
        old: &str,
        value: Option<OsString>,
        new: impl Fn(&str) -> Vec<(&'static str, String)>,
    ) {
        let Some(value) = value.and_then(|value| value.into_string().ok()) else {
            return self.args.push(old.into());
        };
        let new = new(&value);
        let written: Vec<String> = new.iter().map(|(option, value)| format!("{option} {value}")).collect();
        self.notes.push(format!("`{old} {value}` is now written `{}`", written.join(" ")));
        self.args.extend(new.into_iter().flat_map(|(option, value)| [option.into(), value.into()]));
    }

    /// Prints the notes on standard error.
    pub(super) fn tell(&self) {
        let is_quiet = |arg: &OsString| ["-q", "--quiet", "--instance"].iter().any(|quiet| arg == quiet);
        if !self.args.iter().any(is_quiet) {
            self.notes.iter().for_each(|note| terminal::message(&format!("note: {note}")));
        }
    }
}

fn given(value: &str) -> Option<OsString> {
    (!value.is_empty()).then(|| value.into())
}

/// Returns the position of `--`, after which no option comes.
fn end_of_options(args: &[OsString]) -> usize {
    args.iter().position(|arg| arg == "--").unwrap_or(args.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn args(text: &str) -> Vec<OsString> {
        text.split(' ').map(OsString::from).collect()
    }

    #[test]
    fn older_options_have_new_names() {
        for (old, new) in [
            ("m simulate a b --strategy progress", "m simulate a b --scheduler progress"),
            ("m report a b --strategy=permissive", "m report a b --scheduler permissive"),
            ("m export a --strategy spi:progress b", "m export a --kind spi --scheduler progress b"),
            ("m export a b --strategy=sasi", "m export a b --kind sasi"),
            ("m strategy a b --csv --rank 1", "m strategy a b --csv - --rank 1"),
            ("m check a b -- --strategy x", "m check a b -- --strategy x"),
            ("m simulate a b --strategy", "m simulate a b --strategy"),
        ] {
            let found = Respelled::of(&args(old));
            assert_eq!(found.args, args(new));
            assert_eq!(found.notes.is_empty(), old == new, "{old}");
        }
    }

    #[test]
    fn the_options_of_prism_are_ours() {
        assert_eq!(
            in_our_words(&args("m info a -const K=4 -- -const")),
            args("m info a --const K=4 -- -const")
        );
        assert_eq!(in_our_words(&args("m reach a -pf P>0[...]")), args("m reach a --property P>0[...]"));
    }
}
