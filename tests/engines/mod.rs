//! The engines compared with a reference implementation, their variable orders, and cancellation.

mod attractors;
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
