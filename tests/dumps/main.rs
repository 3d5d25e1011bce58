//! Files that come from elsewhere: dumps and their proofs, and text of strangers.

#[path = "../common/entry.rs"]
mod entry;
mod files;
mod forger;
mod hostile;
mod verify;
