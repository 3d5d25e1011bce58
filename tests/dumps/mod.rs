//! Files from other sources: dumps with their proofs, and untrusted text.

mod archives;
mod conditions;
mod corpus;
mod exchange;
mod files;
mod former;
mod games;
mod hostile;
mod limited;
mod mutation;
mod names;
mod others;
mod outside;
mod plays;
mod requirements;
mod statements;
mod turns;
mod values;
mod values_of_games;
mod verify;
