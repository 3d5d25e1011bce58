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

/// The way an argument looks as a file of a planning problem.
#[derive(Clone, Copy)]
enum Looks {
    /// `-`, which may be either half.
    Input,
    /// A name that ends with `.pddl`, without a file.
    Missing,
    /// Another name without a file.
    Absent,
    /// A file in PDDL by its name or its first character, with the parts that begin in it.
    File(Parts),
    /// An option, or another file.
    Other,
}

impl Looks {
    fn guess(arg: &OsString) -> Self {
        let path = Path::new(arg);
        let is_named = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("pddl"));
        if arg == "-" {
            Looks::Input
        } else if arg.as_encoded_bytes().starts_with(b"-") {
            Looks::Other
        } else if !path.exists() {
            if is_named { Looks::Missing } else { Looks::Absent }
        } else if is_named && path.is_file() || begins_with_a_list(path) {
            Looks::File(fs::read_to_string(path).map(|text| parts(&text)).unwrap_or_default())
        } else {
            Looks::Other
        }
    }

    fn is_half(self) -> bool {
        matches!(self, Looks::File(parts) if parts.domain != parts.problem)
    }

    /// Returns whether this file and the next one are meant as the halves of a problem. A half with mistakes
    /// is one, too, and a file that does not exist, so that the error is about that.
    fn pairs_with(self, next: Looks) -> bool {
        match (self, next) {
            (Looks::File(one), Looks::File(other)) => [one, other].iter().all(|p| !(p.domain && p.problem)),
            (Looks::Missing, Looks::File(_)) => true,
            (Looks::File(_), Looks::Missing | Looks::Absent | Looks::Input) => self.is_half(),
            (Looks::Input, Looks::File(_)) => next.is_half(),
            _ => false,
        }
    }
}

/// Names the second of two files that are the halves of a planning problem, in any order: `--problem` stands
/// before it. The halves are told by their content; `-` is the missing one.
pub(super) fn with_problems(args: Vec<OsString>) -> Vec<OsString> {
    let mut named: Vec<OsString> = Vec::with_capacity(args.len() + 1);
    // How the last argument looks; as another file once it has its second half.
    let mut last = Looks::Other;
    for arg in args {
        let own = Looks::guess(&arg);
        if last.pairs_with(own) {
            named.push(SECOND.into());
            last = Looks::Other;
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
