//! The value after each action: what `P` means for a path that begins with it.

use bitvec::vec::BitVec;

use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_base::interval::{Bounds, Interval};
use meliora_base::number::{Number, Weight};
use meliora_equations::{Arena, Value};
use meliora_model::State;
use meliora_space::weighted::Walker;

/// A state with its actions.
#[derive(Debug, Clone, PartialEq)]
pub struct StateActions {
    /// The values of the variables.
    pub state: State,
    /// The opponent of a game chooses here.
    pub theirs: bool,
    /// The formula is true or false here whatever follows.
    pub decided: bool,
    /// The choices, in the order of the program.
    pub actions: Vec<ActionValue>,
}

/// A choice of a state with its value.
#[derive(Debug, Clone, PartialEq)]
pub struct ActionValue {
    /// The name of the choice; see [`meliora_model::Program::choices`].
    pub name: String,
    /// The value of a path that begins with it.
    pub value: Bounds,
    /// The numbers of the states that it may enter.
    pub next: Vec<usize>,
}

/// Computes the value Σ p(s, a, t) · x(t) of each action a of each state s of an arena, and x(s) in the decided states.
/// `x` are the probabilities after a step. Cost: one pass over the arena, and one evaluation of the commands per state.
///
/// # Errors
/// A limit is reached.
pub fn actions(arena: &Arena<'_>, x: &[Value], decided: &BitVec) -> Result<Vec<StateActions>> {
    let mut meter = arena.meter();
    let walker = Walker::new(arena.program(), arena.sink())?;
    let mut walk = walker.walk();
    let mut all = Vec::with_capacity(arena.states());
    for number in 0..arena.states() {
        meter.step()?;
        let state = arena.state(number);
        let names = walk.names(&walker.codec().known(&state)?)?;
        let choices = arena.choices.of(number as u32);
        meter.take(size_of::<StateActions>() + choices.len() * (size_of::<ActionValue>() + 64))?;
        let action = |choice: usize| ActionValue {
            name: names.get(arena.position(choice)).cloned().unwrap_or_default(),
            value: if decided[number] { bounds(&x[number]) } else { mean(arena, choice, x) },
            next: arena.choices.successors(choice).iter().map(|&to| to as usize).collect(),
        };
        let actions = choices.map(action).collect();
        let theirs = arena.is_theirs(number as u32);
        all.push(StateActions { state, theirs, decided: decided[number], actions });
    }
    Ok(all)
}

/// Returns the values of a condition on states: 1 in those of a set, and 0 in the others.
pub fn indicator(set: &BitVec) -> Vec<Value> {
    set.iter().map(|inside| Value::Finite(Bounds::point(u8::from(*inside)))).collect()
}

/// Returns the mean of `x` after a choice, as a fraction if its terms are.
fn mean(arena: &Arena<'_>, choice: usize, x: &[Value]) -> Bounds {
    let terms: Vec<(&Ratio, Bounds)> = arena
        .outcomes(choice)
        .map(|(to, weight)| (&arena.fractions()[weight as usize], bounds(&x[to as usize])))
        .collect();
    // A mean of equal values is this value, without any rounding.
    if let [(_, first), rest @ ..] = &terms[..]
        && rest.iter().all(|(_, other)| other == first)
    {
        return first.clone();
    }
    let exact = terms.iter().map(|(p, x)| Some(*p * x.exact.as_ref()?)).sum::<Option<Ratio>>();
    let rounded = |sum: Interval, (p, x): &(&Ratio, Bounds)| sum.plus(&Interval::of(p).times(&x.interval));
    let interval = match &exact {
        Some(exact) => Interval::around(exact),
        None => terms.iter().fold(Interval::ZERO, rounded),
    };
    Bounds { interval, exact }.at_most(1.0)
}

/// Returns the bounds of a probability.
fn bounds(value: &Value) -> Bounds {
    match value {
        Value::Finite(bounds) => {
            let mut bounds = bounds.clone().at_most(1.0);
            // The solver does not say that these are exact.
            if bounds.interval == Interval::ZERO || bounds.interval == Interval::ONE {
                bounds.exact = Some(Ratio::from_integer((bounds.interval.lower as u8).into()));
            }
            bounds
        }
        Value::Infinite => Bounds::any(1.0),
    }
}
