//! Error messages with the option of the command line that helps.

use meliora_model::error::{Error, Limit, Relief};
use meliora_report::Failure;

/// Returns the message of an error, with the option that helps.
pub(super) fn message(error: &Error) -> String {
    match error {
        Error::Limit(limit) => format!("{limit}{}", advice(limit)),
        _ => error.to_string(),
    }
}

/// Returns an error for JSON, with the option that helps.
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
        Some(Relief::LessMemory) => "; use a smaller `--memory` or a larger `ulimit -v`",
        Some(Relief::System) => "; use a larger `ulimit -v`",
        Some(Relief::Time) => "; `--timeout` raises the limit",
        Some(Relief::Listed) => "; `--limit` raises the limit",
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
        let both = "the system does not provide a table; use a smaller `--memory` or a larger `ulimit -v`";
        assert_eq!(said(system(Some(1))), both);
        assert_eq!(said(system(None)), "the system does not provide a table; use a larger `ulimit -v`");
        let listed = "too large: more than 7 states to list; `--limit` raises the limit";
        assert_eq!(said(Limit::Listed(7)), listed);
        assert_eq!(said(Limit::Interrupted), "interrupted");
    }
}
