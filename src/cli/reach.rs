//! placeholder
use clap::Args;
use meliora::error::Error;
use super::exit::Status;
/// x
#[derive(Debug, Args)]
pub(super) struct ReachArgs {}
pub(super) fn run(_: ReachArgs) -> Result<Status, Error> { Ok(Status::Done) }
