//! Planning problems on the command line: two files are one model, and the second one is that of `--problem`.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use meliora_pddl::{Parts, parts};

/// The option for the second file.
const SECOND: &str = "--problem";
/// The bytes at the beginning of a file that tell whether it is a list.
const HEAD: u64 = 1 << 16;

/// Names the second of two files that are the halves of a planning problem, in any order: `--problem` stands
/// before it. The halves are told by their content; `-` is the missing one.
pub(super) fn with_problems(args: Vec<OsString>) -> Vec<OsString> {
    let of = |arg: &OsString| {
        if arg == "-" {
            return Parts { domain: true, problem: true };
        }
        let text = begins_with_a_list(Path::new(arg)).then(|| fs::read_to_string(arg).ok()).flatten();
        text.map(|text| parts(&text)).unwrap_or_default()
    };
    let is_half = |parts: Parts| parts.domain != parts.problem;
    let fits = |(one, left): (&OsString, Parts), (other, right): (&OsString, Parts)| {
        let is_input = one == "-" || other == "-";
        // A file that does not exist is to be named as such.
        let is_missing = !other.as_encoded_bytes().starts_with(b"-") && !Path::new(other).exists();
        (is_half(left) && (is_missing || is_half(right) && left.domain != right.domain))
            || (is_input && (is_half(left) || is_half(right)))
    };
    let mut named: Vec<OsString> = Vec::with_capacity(args.len() + 1);
    // The parts of the last argument; none if it has its second half, as it fits nothing then.
    let mut last = Parts::default();
    for arg in args {
        let own = of(&arg);
        if named.last().is_some_and(|before| fits((before, last), (&arg, own))) {
            named.push(SECOND.into());
            last = Parts::default();
        } else {
            last = own;
        }
        named.push(arg);
    }
    named
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
