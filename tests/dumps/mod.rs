//! Files from other sources: dumps with their proofs, and untrusted text.

mod archives;
mod conditions;
mod corpus;
mod exchange;
mod files;
mod former;
mod games;
mod hostile;
mod left_out;
mod limited;
mod names;
mod others;
mod outside;
mod plays;
mod requirements;
mod shop;
mod statements;
mod turns;
mod values;
mod values_of_games;
mod verify;
