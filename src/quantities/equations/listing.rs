//! The graph of all states of an engine that stores them by number. It has the successors already, so that commands are
//! evaluated only where a choice has several ones.

use std::sync::Arc;

use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_engine::membership::Numbers;
use meliora_space::enabled::Enabled;
use meliora_space::weighted::{Steps, Walker};

use super::game_graph::Edge;
use super::graph::{Graph, NONE, Rank};
use super::meter::Meter;

/// The states of an arena in their engine.
pub(super) struct Numbered {
    /// Their numbers.
    pub(super) of_state: Vec<u32>,
    /// Their choices by commands, if the engine keeps these.
    pub(super) choices: Option<Arc<Enabled>>,
}

/// The states of an engine in the order of their values.
pub(super) struct Listed {
    pub(super) graph: Graph,
    /// Their codes, one after the other.
    pub(super) codes: Vec<u64>,
    /// Their numbers in the engine.
    pub(super) numbers: Numbered,
}

/// Returns the graph of the states of an engine in the order of their values; `None` if the engine does not
/// have the successors of the program. The first set of `numbers` is that of the states. Cost: linear, and one evaluation of
/// the commands per state with a choice of several successors.
///
/// # Errors
/// A limit is reached; a probability has no value.
pub(super) fn listed(
    numbers: &dyn Numbers,
    walker: &Walker<'_>,
    meter: &mut Meter<'_>,
) -> Result<Option<Listed>> {
    let inside = (0..numbers.states() as u32).filter(|&number| numbers.marks(number) & 1 == 1);
    // The first words of codes decide most comparisons, without access to the others.
    let first = |number: u32| numbers.code(number).first().copied().unwrap_or_default();
    let mut order: Vec<(u64, u32)> = inside.map(|number| (first(number), number)).collect();
    meter.take(order.len() * size_of::<(u64, u32)>())?;
    // Codes compare as the values do.
    order.sort_unstable_by(|(first, a), (other, b)| {
        first.cmp(other).then_with(|| numbers.code(*a).cmp(numbers.code(*b)))
    });
    meter.release(order.len() * size_of::<(u64, u32)>());
    let order: Vec<u32> = order.into_iter().map(|(_, number)| number).collect();
    meter.take((order.len() + numbers.states()) * size_of::<u32>())?;
    let mut place = vec![NONE; numbers.states()];
    order.iter().zip(0..).for_each(|(&number, node)| place[number as usize] = node);
    let mut graph = Graph::default();
    let (free, sure) = (graph.fraction(Ratio::default()), graph.fraction(Ratio::from_integer(1.into())));
    let (mut walk, mut steps, mut codes, mut to) = (walker.walk(), Steps::default(), Vec::new(), Vec::new());
    let choices = order.iter().map(|&number| numbers.choices(number)).sum();
    graph.reserve(order.len(), choices);
    codes.reserve_exact(order.first().map_or(0, |&number| numbers.code(number).len()) * order.len());
    for (&number, node) in order.iter().zip(0..) {
        meter.step()?;
        meter.progress_at(node as usize, &|| format!("{node} states"));
        let code = numbers.code(number);
        meter.take(size_of_val(code))?;
        codes.extend_from_slice(code);
        graph.add_node(Rank::default(), false, meter)?;
        graph.begin(node, meter)?;
        let is_certain = numbers.is_certain(number);
        if !is_certain {
            let known = numbers.kept_choices().map(|kept| kept.key(kept.list(number as usize)));
            walk.steps_by(code, known, &mut graph.game.fractions, &mut steps)?;
        }
        for position in 0..numbers.choices(number) {
            numbers.successors(number, position, &mut to);
            let weights = if is_certain { std::slice::from_ref(&sure) } else { steps.weights(position) };
            if to.len() != weights.len() {
                return Ok(None);
            }
            if to.iter().any(|&to| place[to as usize] == NONE) {
                continue;
            }
            graph.add_choice(position as u32, free);
            for (&to, &weight) in to.iter().zip(weights) {
                graph.add_edge(Edge::new(place[to as usize], weight, false));
            }
        }
        graph.end(node, meter)?;
    }
    graph.finish();
    meter.release(numbers.states() * size_of::<u32>());
    let numbers = Numbered { of_state: order, choices: numbers.kept_choices().cloned() };
    Ok(Some(Listed { graph, codes, numbers }))
}
