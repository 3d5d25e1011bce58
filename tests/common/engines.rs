//! Helpers shared by the tests of the engines.

#![allow(dead_code, unreachable_pub, reason = "each test file uses a part")]

pub mod agreement;
pub mod brute;
pub mod random_program;
