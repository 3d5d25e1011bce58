//! The order of the bits: as declared, computed from the structure of the program, or given by the
//! user.
//!
//! [`Order`] selects the method. [`from_structure`] applies the heuristics: `independent_modules` for modules that move
//! on their own, `command_spans` for other programs of flags, otherwise the declared order. They read guards and
//! updates, the first one through `counters`. [`parse`] reads an order from text.
//! Nothing here uses diagrams.

mod command_spans;
mod counters;
mod independent_modules;
mod text;

use std::cmp::Reverse;
use std::sync::Arc;

use meliora_base::error::{Error, Result, SourceFile};
use meliora_model::{Program, VarId};
pub use text::parse;

/// One bit of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Bit {
    /// The variable.
    pub variable: VarId,
    /// The index of the bit in `value - low`; 0 is the least significant.
    pub index: u32,
}

/// Returns the bits of all variables in the order of declaration, each variable from its most
/// significant bit down.
pub fn declared(program: &Program) -> Vec<Bit> {
    by_variables(program, &program.variable_ids().collect::<Vec<_>>())
}

/// Returns the bits of the variables in the given order, each variable from its most significant
/// bit down.
pub fn by_variables(program: &Program, variables: &[VarId]) -> Vec<Bit> {
    variables.iter().flat_map(|&v| bits_of(program, v)).collect()
}

/// Returns the bits of a variable from the most significant one down.
fn bits_of(program: &Program, variable: VarId) -> impl Iterator<Item = Bit> + use<> {
    let count = program.variables[variable.index()].bits();
    (0..count).rev().map(move |index| Bit { variable, index })
}

/// The method that orders the bits.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Order {
    /// The order computed by [`from_structure`]. Where several ways race, one of them each for other orders; see
    /// [`Selection`](crate::Selection).
    #[default]
    Auto,
    /// The order returned by [`declared`].
    Declared,
    /// The given bits from the root down, every bit of the program once.
    Bits(Vec<Bit>),
    /// The order that [`parse`] reads from this text.
    Text(Arc<SourceFile>),
}

impl Order {
    /// Returns the bits of a program from the root down.
    ///
    /// # Errors
    /// A given order that does not have every bit of the program exactly once; the errors of
    /// [`parse`].
    pub fn bits(&self, program: &Program) -> Result<Vec<Bit>> {
        match self {
            Order::Auto => Ok(auto(program)),
            Order::Declared => Ok(declared(program)),
            Order::Text(source) => parse(program, source),
            Order::Bits(bits) if is_whole(program, bits) => Ok(bits.clone()),
            Order::Bits(_) => {
                Err(Error::Usage("the order must contain every bit of the model exactly once".to_owned()))
            }
        }
    }
}

/// Returns the orders that race, the likeliest first, each once: that of [`from_structure`], the declared variables from
/// the last to the first, and [`large_first`].
///
/// The structure of a program does not tell which is best: on translated planning problems one of the last two often
/// needs a hundred times fewer nodes than the first.
pub(crate) fn candidates(program: &Program) -> Vec<Ordered> {
    let reversed = |variables: &mut Vec<VarId>| variables.reverse();
    let reversed = of_variables(program, "variables from the last to the first", reversed);
    let mut orders: Vec<Ordered> = Vec::new();
    for order in [from_structure(program), reversed, large_first(program)] {
        if orders.iter().all(|known| known.bits != order.bits) {
            orders.push(order);
        }
    }
    orders
}

/// Returns the order of the declared variables in which those with most bits come first.
pub(crate) fn large_first(program: &Program) -> Ordered {
    of_variables(program, "large variables first", |variables| {
        variables.sort_by_key(|v| Reverse(program.variables[v.index()].bits()));
    })
}

/// Returns an order of the variables of the model, with those of monitors above or below them.
fn of_variables(program: &Program, why: &str, arrange: impl FnOnce(&mut Vec<VarId>)) -> Ordered {
    let plain = if program.monitors.is_some() { &program.without_monitors() } else { program };
    let mut variables = Vec::from_iter(plain.variable_ids());
    arrange(&mut variables);
    Ordered {
        bits: beside_monitors(program, by_variables(plain, &variables)),
        why: format!("{why}, which was the first of several orders to end"),
    }
}

/// Returns true if an order has every bit of the program exactly once.
pub(super) fn is_whole(program: &Program, bits: &[Bit]) -> bool {
    let (mut own, mut all) = (bits.to_vec(), declared(program));
    own.sort_unstable();
    all.sort_unstable();
    own == all
}

/// An order and the reason for it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ordered {
    /// The bits from the root down, every bit once.
    pub bits: Vec<Bit>,
    /// The reason for the order, in words.
    pub why: String,
}

/// Returns the order of [`from_structure`].
pub fn auto(program: &Program) -> Vec<Bit> {
    from_structure(program).bits
}

/// Computes an order from the structure of the program.
///
/// Variables stay as declared, since authors write related variables next to each other. There are
/// two exceptions:
///
/// If one module has all variables, or several modules never move together: counters that
/// every step changes come first, then the variables that are assigned, then the other counters, interleaved
/// bit by bit where guards test them together.
///
/// If all variables are flags, and the above leaves them as declared: flags of the same commands, and flags
/// that depend on the same flag, come close to each other, if that shortens their spans. Such
/// programs are often translated from formats in which the order of declaration has no meaning.
///
/// Up to three monitors come above the variables of the model, more come below.
pub fn from_structure(program: &Program) -> Ordered {
    if program.monitors.is_some() {
        let Ordered { bits, why } = from_structure(&program.without_monitors());
        return Ordered { bits: beside_monitors(program, bits), why };
    }
    match independent_modules::by_positions(program) {
        Some(order) if !order.why.is_empty() => order,
        Some(Ordered { bits, .. }) if bits != declared(program) => {
            Ordered { bits, why: "counters below the other variables".to_owned() }
        }
        _ => short_spans(program),
    }
}

/// Returns the declared order, or one with shorter spans for programs of flags.
fn short_spans(program: &Program) -> Ordered {
    let Some(shortened) = command_spans::shortened(program) else {
        return Ordered { bits: declared(program), why: "as declared".to_owned() };
    };
    let why = format!(
        "flags of the same commands close to each other: the spans of all commands and dependencies add up to \
         {} places instead of {} as declared",
        shortened.span, shortened.declared
    );
    Ordered { bits: by_variables(program, &shortened.variables), why }
}

/// Maximum number of monitors above the model; more of them come below it. With four monitors, a
/// run with them below takes about a third of the time, with twelve a sixth. One or two are as fast
/// above, or faster.
const MOST_ON_TOP: usize = 3;

/// Adds the bits of monitors to an order of the bits of the model.
///
/// A few monitors come on top: their values split the states into few parts, each explored once.
/// Many monitors come below the model: then the relation of a step tests the model's variables
/// above all monitors. On top, it would distinguish all sets of monitors that may change.
fn beside_monitors(program: &Program, mut bits: Vec<Bit>) -> Vec<Bit> {
    let Some(monitors) = &program.monitors else { return bits };
    let place = if monitors.variables.len() > MOST_ON_TOP { bits.len() } else { 0 };
    let watching = by_variables(program, &monitors.variables);
    let watching: Vec<Bit> = watching.into_iter().filter(|b| !bits.contains(b)).collect();
    bits.splice(place..place, watching);
    bits
}
