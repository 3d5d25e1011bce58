//! Errors in the words of the command line: which option helps.

use meliora::error::{Error, Limit, Relief};
use meliora::output::Failure;

/// What is wrong, and what helps.
pub(super) fn message(error: &Error) -> String {
    match error {
        Error::Limit(limit) => format!("{limit}{}", advice(limit)),
        _ => error.to_string(),
    }
}

/// An error as programs read it, with what helps.
pub(super) fn failure(error: &Error) -> Failure {
    let mut failure = Failure::from(error);
    if matches!(error, Error::Limit(_)) {
        failure.message = message(error);
    }
    failure
}

fn advice(limit: &Limit) -> &'static str {
    match limit.relief() {
        Some(Relief::MoreMemory) => "; `--memory` raises the limit",
        Some(Relief::LessMemory) => ": a smaller `--memory`, or a larger `ulimit -v`, helps",
        Some(Relief::System) => ": a larger `ulimit -v` helps",
        Some(Relief::Time) => "; `--timeout` raises the limit",
        Some(Relief::Listed) => "; `--limit` raises it",
        Some(Relief::Symbolic) => "; `--engine symbolic` has no such limit",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_name_the_option_that_helps() {
        let system = |bytes| Limit::System { what: "a table".to_owned(), bytes };
        let said = |limit: Limit| message(&limit.into());
        let what = "a table is full".to_owned();
        assert_eq!(
            said(Limit::Memory { what }),
            "out of memory: a table is full; `--memory` raises the limit"
        );
        let both = "the system refuses a table: a smaller `--memory`, or a larger `ulimit -v`, helps";
        assert_eq!(said(system(Some(1))), both);
        assert_eq!(said(system(None)), "the system refuses a table: a larger `ulimit -v` helps");
        let listed = "too large: more than 7 states to be listed; `--limit` raises it";
        assert_eq!(said(Limit::Listed(7)), listed);
        assert_eq!(said(Limit::Interrupted), "interrupted");
    }
}
