//! placeholder
use clap::Args;
use meliora::error::Error;
use super::exit::Status;
/// x
#[derive(Debug, Args)]
pub(super) struct InfoArgs {}
pub(super) fn run(_: InfoArgs) -> Result<Status, Error> { Ok(Status::Done) }
