//! From an analysis or a property to equations, and the uses of their solutions; see [the crate](crate).

pub mod actions;
pub mod all_states;
pub mod by_goal;
pub(crate) mod chain;
pub mod choose;
pub mod confirmed;
pub mod cost;
pub mod exploration;
pub(crate) mod explore;
pub(crate) mod facts;
pub mod followed;
pub mod optimal;
pub mod outlook;
pub(crate) mod places;
pub mod sought;
pub mod state_values;
pub mod values;
