//! The engines compared with a reference implementation, their variable orders, and cancellation.

#[allow(dead_code, reason = "each program takes a part")]
#[path = "../common/amount.rs"]
mod amount;
mod attractors;
#[path = "../common/engines.rs"]
mod common;
mod depth;
mod direction;
mod explicit;
mod faults;
mod foreign;
mod interruption;
mod lasso;
mod membership;
mod order;
mod selection;
mod stopping;
mod temporal;
mod threads;
mod trends;
