//! The order of the bits: as declared, computed from the structure of the program, or given by the
//! user.

mod grid_world;
mod module_copies;

use std::ops::Range;
use std::sync::Arc;

use ahash::AHashSet;

use super::encoding::Bit;
use crate::error::{Diagnostic, Error, Result, SourceFile};
use crate::model::expr::{Binary, ExprId, Node};
use crate::model::value::Type;
use crate::model::{Command, Program, VarId};

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
    /// The order computed by [`from_structure`].
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
/// If one module has all variables, or several modules are independent of each other: counters that
/// every step changes come first, then flags, then positions interleaved bit by bit.
///
/// If three or more copies of a module advance their clocks together: the variables declared before
/// the clocks come first, then the clocks and the variables after them, those of equal role next to
/// each other.
///
/// Up to three monitors come above the variables of the model, more come below.
pub fn from_structure(program: &Program) -> Ordered {
    if program.monitors.is_some() {
        let Ordered { bits, why } = from_structure(&program.without_monitors());
        return Ordered { bits: beside_monitors(program, bits), why };
    }
    if let Some(variables) = module_copies::by_roles(program) {
        let why = "copies of a module whose clocks advance together: the clocks next to each other";
        return Ordered { bits: by_variables(program, &variables), why: why.to_owned() };
    }
    match grid_world::by_positions(program) {
        Some(order) if !order.why.is_empty() => order,
        Some(Ordered { bits, .. }) if bits != declared(program) => {
            Ordered { bits, why: "flags above the variables that move".to_owned() }
        }
        _ => Ordered { bits: declared(program), why: "as declared".to_owned() },
    }
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

/// Returns the integer variables that some update changes by a sum or difference.
fn counters(program: &Program, commands: &[&Command]) -> AHashSet<VarId> {
    let updates = commands.iter().flat_map(|c| &c.branches).flat_map(|b| &b.updates);
    let counted =
        updates.filter(|(v, e)| program.variables[v.index()].ty == Type::Int && counts(program, *v, *e));
    counted.map(|(v, _)| *v).collect()
}

/// Returns the counters that guards only compare by `<` and `<=`, or with an end of their range.
fn thresholds(program: &Program, commands: &[&Command], counters: &AHashSet<VarId>) -> AHashSet<VarId> {
    let mut counters = counters.clone();
    // Shared subexpressions of guards are visited once.
    let mut seen = AHashSet::new();
    for command in commands {
        let mut stack = vec![command.guard];
        while let Some(e) = stack.pop() {
            if !seen.insert(e) {
                continue;
            }
            match program.pool.node(e) {
                Node::Binary(Binary::Eq, a, b) if is_inner(program, a, b) => {
                    for v in program.pool.support(e) {
                        counters.remove(&v);
                    }
                }
                Node::Binary(_, a, b) => stack.extend([a, b]),
                Node::Unary(_, a) => stack.push(a),
                Node::Ite(c, a, b) => stack.extend([c, a, b]),
                Node::Literal(_) | Node::Var(_) => {}
            }
        }
    }
    counters
}

/// Maximum number of nodes searched in an update. A counter's sum is near the root, and large
/// shared formulas are not searched repeatedly.
const MOST_NODES: usize = 100;

/// Returns true if the first nodes of the expression have a sum or difference of the variable
/// itself.
fn counts(program: &Program, variable: VarId, e: ExprId) -> bool {
    let (mut stack, mut seen) = (vec![e], AHashSet::new());
    while let Some(e) = stack.pop() {
        if seen.len() == MOST_NODES || !seen.insert(e) {
            continue;
        }
        match program.pool.node(e) {
            Node::Binary(Binary::Add | Binary::Sub, a, b)
                if [a, b].iter().any(|&o| program.pool.node(o) == Node::Var(variable)) =>
            {
                return true;
            }
            Node::Binary(_, a, b) => stack.extend([a, b]),
            Node::Unary(_, a) => stack.push(a),
            Node::Ite(c, a, b) => stack.extend([c, a, b]),
            Node::Literal(_) | Node::Var(_) => {}
        }
    }
    false
}

/// Returns true if an equation compares something other than a variable and an end of its range:
/// two variables, or a variable and an inner value. Counters are not used that way.
fn is_inner(program: &Program, a: ExprId, b: ExprId) -> bool {
    let end = |v: ExprId, c: ExprId| match (program.pool.node(v), program.pool.literal(c)) {
        (Node::Var(v), Some(c)) => {
            let variable = &program.variables[v.index()];
            c.to_f64() == variable.low as f64 || c.to_f64() == variable.high as f64
        }
        _ => false,
    };
    !end(a, b) && !end(b, a)
}

/// Maximum number of errors that are reported.
const MOST_ERRORS: usize = 20;

/// Reads an order from text: names of variables or of bits (`x.2`), separated by white space or
/// commas, with `//` comments as in models. Every variable of the model must occur exactly once.
///
/// # Errors
/// Unknown, repeated and missing names, each with its position.
pub fn parse(program: &Program, source: &Arc<SourceFile>) -> Result<Vec<Bit>> {
    let mut order: Vec<Bit> = Vec::new();
    let mut seen: AHashSet<Bit> = AHashSet::new();
    let mut errors = Vec::new();
    for (span, name) in words(&source.text) {
        if errors.len() == MOST_ERRORS {
            break;
        }
        match named(program, name) {
            None => {
                errors.push(wrong(source, span, format!("`{name}` is not a variable or bit of the model")))
            }
            Some(bits) => {
                for bit in bits {
                    if seen.insert(bit) {
                        order.push(bit);
                    } else {
                        errors.push(wrong(
                            source,
                            span.clone(),
                            format!("`{name}` occurs twice in the order"),
                        ));
                        break;
                    }
                }
            }
        }
    }
    // An order for a model need not name its monitors.
    order = beside_monitors(program, order);
    seen.extend(&order);
    let missing: Vec<Bit> = declared(program).into_iter().filter(|b| !seen.contains(b)).collect();
    if let (Some(first), true) = (missing.first(), errors.is_empty()) {
        let name = &program.variables[first.variable.index()].name;
        let end = source.text.len();
        errors.push(wrong(source, end..end, format!("bit {} of `{name}` is not in the order", first.index)));
    }
    if errors.is_empty() { Ok(order) } else { Err(Error::Input(errors)) }
}

/// Returns the bits that a word names: all bits of a variable, or one.
fn named(program: &Program, name: &str) -> Option<Vec<Bit>> {
    if let Some(variable) = program.variable(name) {
        return Some(by_variables(program, &[variable]));
    }
    let (variable, index) = name.rsplit_once('.')?;
    let (variable, index) = (program.variable(variable)?, index.parse().ok()?);
    (index < program.variables[variable.index()].bits()).then(|| vec![Bit { variable, index }])
}

fn words(text: &str) -> Vec<(Range<usize>, &str)> {
    let mut words = Vec::new();
    let mut offset = 0;
    for line in text.split_inclusive('\n') {
        let code = line.split("//").next().unwrap_or_default();
        let separator = |c: char| c.is_whitespace() || c == ',';
        for word in code.split(separator).filter(|w| !w.is_empty()) {
            let start = offset + (word.as_ptr() as usize - line.as_ptr() as usize);
            words.push((start..start + word.len(), word));
        }
        offset += line.len();
    }
    words
}

fn wrong(source: &Arc<SourceFile>, span: Range<usize>, message: String) -> Diagnostic {
    let help = "`meliora info MODEL` prints an order in this format".to_owned();
    Diagnostic { help: Some(help), ..Diagnostic::new(source, span, message) }
}
