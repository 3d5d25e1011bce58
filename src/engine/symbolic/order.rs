//! The order of the bits: declared, computed, or the user's.

use super::encoding::Bit;
use crate::model::{Program, VarId};

/// The variables in the order of declaration, each from its most significant bit down.
pub fn declared(program: &Program) -> Vec<Bit> {
    let variables: Vec<VarId> = (0..program.variables.len() as u32).map(VarId).collect();
    by_variables(program, &variables)
}

/// The bits of the variables in the given order, each from its most significant bit down.
pub fn by_variables(program: &Program, variables: &[VarId]) -> Vec<Bit> {
    let bits = |&variable: &VarId| {
        let count = program.variables[variable.index()].bits();
        (0..count).rev().map(move |index| Bit { variable, index })
    };
    variables.iter().flat_map(bits).collect()
}
