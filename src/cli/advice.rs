//! Error messages with the option of the command line that helps.

use meliora::supervise::memory::{AddressLimit, address_limit};
use meliora_base::error::{Error, Limit, Relief};
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

fn advice(limit: &Limit) -> String {
    let said = match limit.relief() {
        Some(relief @ (Relief::LessMemory | Relief::System)) => return of_system(relief, address_limit()),
        Some(Relief::MoreMemory) => "; `--memory` raises the limit",
        Some(Relief::Time) => "; `--timeout` raises the limit",
        Some(Relief::Listed) => "; `--limit` raises the limit",
        Some(Relief::Export) => {
            "; a larger `--timeout` or `--memory` of `export` may certify them, \
             and `--no-certificate` writes the regions alone"
        }
        Some(Relief::Symbolic) => "; `--engine symbolic` has no such limit",
        _ => "",
    };
    said.to_owned()
}

/// Returns the advice where the system refuses memory, with the limit of the process if there is one.
fn of_system(relief: Relief, limit: Option<AddressLimit>) -> String {
    let smaller = (relief == Relief::LessMemory).then_some("a smaller `--memory`");
    let (reason, larger) = match limit {
        Some(AddressLimit { bytes, option }) => {
            let (addresses, mib) = (if option == 'd' { "data" } else { "address space" }, bytes >> 20);
            let reason = format!(": the {addresses} of this process is limited to {mib} MiB");
            (reason, Some(format!("a larger `ulimit -{option}`")))
        }
        None => (String::new(), None),
    };
    let reliefs: Vec<&str> = smaller.into_iter().chain(larger.as_deref()).collect();
    if reliefs.is_empty() { reason } else { format!("{reason}; use {}", reliefs.join(" or ")) }
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
        assert!(said(system(Some(1))).starts_with("the system does not provide a table"));
        assert!(said(system(Some(1))).contains("; use a smaller `--memory`"));
        let listed = "too large: more than 7 states to list; `--limit` raises the limit";
        assert_eq!(said(Limit::Listed(7)), listed);
        assert_eq!(said(Limit::Interrupted), "interrupted");
    }

    #[test]
    fn memory_that_the_system_refuses_names_the_limit_of_the_process() {
        let limit = |bytes, option| Some(AddressLimit { bytes, option });
        for (relief, limit, wanted) in [
            (Relief::LessMemory, None, "; use a smaller `--memory`"),
            (Relief::System, None, ""),
            (
                Relief::LessMemory,
                limit(6 << 30, 'v'),
                ": the address space of this process is limited to 6144 MiB; use a smaller `--memory` or a \
                 larger `ulimit -v`",
            ),
            (
                Relief::System,
                limit(1 << 30, 'd'),
                ": the data of this process is limited to 1024 MiB; use a larger `ulimit -d`",
            ),
        ] {
            assert_eq!(of_system(relief, limit), wanted);
        }
    }
}
