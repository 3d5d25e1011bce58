//! placeholder
use clap::Args;
use meliora::error::Error;
use super::exit::Status;
/// x
#[derive(Debug, Args)]
pub(super) struct CompareArgs {}
pub(super) fn run(_: CompareArgs) -> Result<Status, Error> { Ok(Status::Done) }
