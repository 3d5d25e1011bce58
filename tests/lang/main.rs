//! The languages: what is accepted, what it means, and what is said of mistakes.

mod arithmetic;
mod errors;
mod expressions;
mod meaning;
mod preferences;
mod round_trip;
