//! The uses of solutions.
//!
//! | module | contents |
//! | --- | --- |
//! | [`exploration`], [`values`], [`state_values`], [`all_states`] | the results of an analysis: [`Values`](crate::Values), also as plain data |
//! | [`choose`], `likely`, `ties` | strategies that attain the values |
//! | [`by_goal`] | how likely the first improvement gains each objective |
//! | [`optimal`] | strategies that attain the optimum of one operator |
//! | [`outlook`] | what a strategy promises |
//! | [`confirmed`] | bounds that one step confirms, for certificates |
//! | [`path_values`], [`sought`] | probabilities of formulas and rewards until a target, without preferences |
//! | [`several`], [`followed`] | several objectives at once; strategies for them, followed |
//! | [`actions`] | the value after each action, from those of all states |
//! | [`vector`] | numbers of all states of an [`Arena`](crate::equations::arena::Arena) |

pub mod actions;
pub mod all_states;
pub mod by_goal;
pub mod choose;
pub mod confirmed;
pub mod exploration;
pub mod followed;
pub(crate) mod likely;
pub mod optimal;
pub mod outlook;
pub mod path_values;
pub mod several;
pub mod sought;
pub mod state_values;
pub(crate) mod ties;
pub mod values;
pub mod vector;
