//! Numbers of states in which those that are found together are near to each other.
//!
//! A number has one digit per variable. The variable that most branches change comes first: a breadth-first
//! search advances it evenly, so the states of one layer share its digit. Of the others, those that change
//! often come last, so that values that do not occur together leave large gaps.

use std::cmp::Reverse;

use super::layout::{Bits, Layout};
use meliora_model::Program;

/// Maximum number of digits: with more, a code is hashed in less time.
const MOST_DIGITS: usize = 16;

/// Numbers all valuations of the variables.
#[derive(Debug, Clone)]
pub struct Numbering {
    /// The bits of each variable with several values, and the weight of its digit.
    digits: Vec<(Bits, u64)>,
}

impl Numbering {
    /// Numbers the valuations of a program; `None` if there are 2^64 or more, or too many variables.
    pub(super) fn new(program: &Program, layout: &Layout) -> Option<Self> {
        let mut changes = vec![0_u32; program.variables.len()];
        let branches = program.commands.iter().flat_map(|command| &command.branches);
        branches.flat_map(|branch| &branch.updates).for_each(|(variable, _)| changes[variable.index()] += 1);
        let mut order: Vec<usize> = (0..changes.len()).collect();
        order.sort_by_key(|&variable| Reverse(changes[variable]));
        if let Some((_, others)) = order.split_first_mut() {
            others.reverse();
        }
        let (mut digits, mut weight) = (Vec::new(), 1_u64);
        for field in order.into_iter().rev().map(|variable| layout.field(variable)) {
            if field.values() != 1 {
                digits.push((field.bits(), weight));
                weight = weight.checked_mul(field.values()).filter(|&weight| weight > 0)?;
            }
        }
        (digits.len() <= MOST_DIGITS).then_some(Numbering { digits })
    }

    /// Returns the number of a code.
    pub fn number(&self, code: &[u64]) -> u64 {
        self.digits.iter().map(|(bits, weight)| bits.of(code) * weight).sum()
    }
}
