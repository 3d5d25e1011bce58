//! Planning problems on the command line: two files are one model.

use std::ffi::OsString;
use std::path::Path;

use meliora_pddl::{Parts, parts};

/// Joins each domain and the problem after it, or the problem and the domain, to one argument.
/// The parts are told by their content; `-` is the missing part.
pub(super) fn with_problems(args: Vec<OsString>) -> Vec<OsString> {
    let of = |arg: &OsString| {
        if arg == "-" {
            return Parts { domain: true, problem: true };
        }
        let text = Path::new(arg).is_file().then(|| std::fs::read_to_string(arg).ok()).flatten();
        text.map(|text| parts(&text)).unwrap_or_default()
    };
    let fits = |one: &OsString, other: &OsString| {
        let (left, right) = (of(one), of(other));
        let is_half = |parts: Parts| parts.domain != parts.problem;
        let is_input = one == "-" || other == "-";
        (is_half(left) && is_half(right) && left.domain != right.domain)
            || (is_input && (is_half(left) || is_half(right)))
    };
    let mut joined: Vec<OsString> = Vec::with_capacity(args.len());
    let mut is_joined = false;
    for arg in args {
        match joined.last_mut() {
            Some(last) if !is_joined && fits(last, &arg) => {
                // The order has no meaning, and a leading `-` would be taken for an option.
                let (first, second) = if last == "-" { (arg, last.clone()) } else { (last.clone(), arg) };
                *last = first;
                last.push(" ");
                last.push(second);
                is_joined = true;
            }
            _ => {
                joined.push(arg);
                is_joined = false;
            }
        }
    }
    joined
}
