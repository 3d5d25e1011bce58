//! Files from other sources: dumps with their proofs, and untrusted text.

#[allow(dead_code, reason = "each program takes a part")]
#[path = "../common/amount.rs"]
mod amount;
mod archives;
mod conditions;
mod corpus;
#[path = "../common/entry.rs"]
mod entry;
mod exchange;
mod files;
mod former;
mod games;
mod hostile;
mod limited;
#[path = "../common/factory.rs"]
mod machines;
mod mutation;
mod names;
mod others;
mod outside;
mod plays;
#[path = "../common/random_game.rs"]
mod random_game;
#[allow(unreachable_pub, reason = "what tests of engines share, too")]
#[path = "../common/random_program.rs"]
mod random_program;
mod requirements;
mod statements;
mod turns;
mod values;
mod values_of_games;
mod verify;
