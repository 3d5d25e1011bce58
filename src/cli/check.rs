//! placeholder
use clap::Args;
use meliora::error::Error;
use super::exit::Status;
/// x
#[derive(Debug, Args)]
pub(super) struct CheckArgs {}
pub(super) fn run(_: CheckArgs) -> Result<Status, Error> { Ok(Status::Done) }
