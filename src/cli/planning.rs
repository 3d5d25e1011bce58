//! Planning problems on the command line: two files are one model.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use meliora_pddl::{Parts, parts};

/// The bytes at the beginning of a file that tell whether it is a list.
const HEAD: u64 = 1 << 16;

/// Joins each domain and the problem after it, or the problem and the domain, to one argument.
/// The parts are told by their content; `-` is the missing part.
pub(super) fn with_problems(args: Vec<OsString>) -> Vec<OsString> {
    let of = |arg: &OsString| {
        if arg == "-" {
            return Parts { domain: true, problem: true };
        }
        let text = begins_with_a_list(Path::new(arg)).then(|| fs::read_to_string(arg).ok()).flatten();
        text.map(|text| parts(&text)).unwrap_or_default()
    };
    let fits = |(one, left): (&OsString, Parts), (other, right): (&OsString, Parts)| {
        let is_half = |parts: Parts| parts.domain != parts.problem;
        let is_input = one == "-" || other == "-";
        // A file that does not exist is to be named as such.
        let is_missing = is_half(left) && Path::new(other).extension().is_some_and(|e| e == "pddl");
        (is_missing && !Path::new(other).exists())
            || (is_half(left) && is_half(right) && left.domain != right.domain)
            || (is_input && (is_half(left) || is_half(right)))
    };
    // Each argument with its parts; none of what is joined already, which fits nothing.
    let mut joined: Vec<(OsString, Option<Parts>)> = Vec::with_capacity(args.len());
    for arg in args {
        let parts = of(&arg);
        match joined.pop() {
            Some((last, Some(left))) if fits((&last, left), (&arg, parts)) => {
                // The order has no meaning, and a leading `-` would be taken for an option.
                let (mut first, second) = if last == "-" { (arg, last) } else { (last, arg) };
                first.push(" ");
                first.push(second);
                joined.push((first, None));
            }
            last => {
                joined.extend(last);
                joined.push((arg, Some(parts)));
            }
        }
    }
    joined.into_iter().map(|(arg, _)| arg).collect()
}

/// Returns whether the first character of a file is `(`, after blanks and comments, as in planning problems.
/// Other files may be large, and are not read as a whole.
fn begins_with_a_list(path: &Path) -> bool {
    let mut head = Vec::new();
    let read = path.is_file().then(|| File::open(path).ok()).flatten();
    let Some(Ok(_)) = read.map(|file| file.take(HEAD).read_to_end(&mut head)) else { return false };
    let head = String::from_utf8_lossy(&head);
    let mut lines =
        head.lines().map(str::trim_start).filter(|line| !line.is_empty() && !line.starts_with(';'));
    lines.next().is_some_and(|line| line.starts_with('('))
}
