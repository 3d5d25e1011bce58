//! The engines against a reference by the book, their orders, and whether they stop when told to.

#[path = "../common/engines.rs"]
mod common;
mod depth;
mod explicit;
mod faults;
mod interruption;
mod lasso;
mod membership;
mod order;
mod stopping;
mod temporal;
