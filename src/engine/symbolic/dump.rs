//! Conversion of the store's diagrams to plain data and back.

use ahash::{AHashMap, AHashSet};
use oxidd::{Function, HasLevel, InnerNode, Manager, Node};
use std::sync::Arc;

use super::encoding::Encoding;
use super::encoding::transitions::Numbered;
use super::store::Store;
use super::store::diagram::{self, Bdd, ManagerOf};
use super::{Bit, ChoiceSet, Explored, StateSet, SymbolicEngine, draft};
use crate::settings::Settings;
use meliora_base::diagram::{Diagram, Edge};
use meliora_base::error::{Error, Result};
use meliora_base::progress::ProgressSink;
use meliora_model::{ModelKind, Program, VarId};

/// A set to be dumped.
#[derive(Clone)]
pub enum Set {
    /// A set of states.
    States(StateSet),
    /// A set of choices.
    Choices(ChoiceSet),
}

impl SymbolicEngine {
    /// Builds an engine whose scope is a set of states given as a diagram over the bits of `order`.
    /// The commands are translated, but nothing is explored. Bit patterns that do not encode values
    /// are left out.
    ///
    /// Cost: no image; the relations are built.
    ///
    /// # Errors
    /// The errors of [`SymbolicEngine::new`], for the given states.
    pub fn with_states(
        program: Arc<Program>,
        order: Vec<Bit>,
        settings: Settings,
        diagram: &Diagram,
        states: Edge,
    ) -> Result<Self> {
        let offset = diagram.variables.len().saturating_sub(order.len()) as u32;
        let given = |store: &Store| Ok(load(store, diagram, offset, &[states])?.swap_remove(0));
        Explored::with(program, order, settings, Some(&given))?.engine()
    }

    /// Returns all valuations of the declared variables, in the scope or not: every bit pattern in
    /// which each variable is within its range.
    pub fn valuations(&self) -> StateSet {
        StateSet(self.domain.clone())
    }

    /// Returns the states in which the paths of the scope begin, in the scope or not: the initial
    /// states, or, for a monitored program with the scope `all`, every valuation with fresh
    /// monitors. Returns `None` if the scope is the set of all valuations.
    ///
    /// Cost: no image.
    pub fn beginnings(&self) -> Result<Option<StateSet>> {
        let (scope, initial) = (self.settings.scope, &self.initial.0);
        let found =
            draft::beginnings(&self.program, &self.encoding, &self.store, scope, initial, &self.domain)?;
        Ok(found.map(StateSet))
    }

    /// Returns the number of bits of a choice number: ⌈log₂⌉ of the number of groups, with one more
    /// group for the self-loops of deadlocks.
    pub fn choice_bits(&self) -> u32 {
        usize::BITS - (self.enabled.len() - 1).leading_zeros()
    }

    /// Returns the choices that each number stands for, from 0; the last number is the self-loop of
    /// deadlocks. In each state at most one choice of each number is enabled.
    pub fn numbered_choices(&self) -> Vec<Numbered> {
        let mut all = match self.program.kind {
            ModelKind::Dtmc => vec![Numbered::Uniform; self.enabled.len() - 1],
            ModelKind::Mdp | ModelKind::Smg => self.transitions.combinations(&self.program),
        };
        all.push(Numbered::Deadlock);
        all
    }

    /// Returns the sets as one diagram with one root per set. The first variables, named by
    /// `choice_bits`, encode the number of a choice, most significant bit first. The bits of the
    /// states follow in their order.
    ///
    /// Cost: linear in the nodes of the sets.
    ///
    /// # Errors
    /// A limit, more nodes than the format can number, or a set that belongs to another engine.
    pub fn diagram(&self, sets: &[Set], choice_bits: &[String]) -> Result<Diagram> {
        let variables = choice_bits.iter().cloned().chain(self.encoding.names()).collect();
        let mut diagram = Diagram { variables, ..Diagram::default() };
        let functions: Vec<&Bdd> = sets.iter().flat_map(functions).collect();
        if !functions.iter().all(|f| self.store.owns(f)) {
            return Err(Error::ForeignSet);
        }
        let (offset, width) = (choice_bits.len() as u32, self.encoding.width());
        let edges = store_in(&mut diagram, offset, width, &functions, &*self.settings.sink)?;
        let mut edges = edges.into_iter();
        let mut leaves: Vec<Vec<Edge>> =
            sets.iter().map(|set| edges.by_ref().take(functions_of(set)).collect()).collect();
        for level in (0..choice_bits.len() as u32).rev() {
            let mut unique = AHashMap::new();
            for (set, row) in sets.iter().zip(&mut leaves) {
                if matches!(set, Set::Choices(_)) {
                    *row = paired(&mut diagram, &mut unique, level, row)?;
                }
            }
        }
        diagram.roots = leaves.iter().map(|row| row.first().copied().unwrap_or(Edge::FALSE)).collect();
        Ok(diagram)
    }

    /// Loads sets of states from a diagram whose last variables are the bits of the states in their
    /// order.
    ///
    /// Cost: one if-then-else per node.
    ///
    /// # Errors
    /// A limit; an arc to a missing node, or to a set that depends on choices.
    pub fn load_states(&self, diagram: &Diagram, edges: &[Edge]) -> Result<Vec<StateSet>> {
        let offset = diagram.variables.len().saturating_sub(self.encoding.width()) as u32;
        Ok(load(&self.store, diagram, offset, edges)?.into_iter().map(StateSet).collect())
    }

    /// Loads a set of choices with numbers below `numbers`; returns `None` if it has members with
    /// other numbers.
    ///
    /// Cost: one if-then-else per node.
    ///
    /// # Errors
    /// A limit, or an arc to a missing node.
    pub fn load_choices(&self, diagram: &Diagram, edge: Edge, numbers: usize) -> Result<Option<ChoiceSet>> {
        let offset = diagram.variables.len().saturating_sub(self.encoding.width()) as u32;
        let leaf = |number: usize| {
            (0..offset).fold(edge, |at, level| {
                let (then, otherwise) = diagram.cofactors(at, level);
                if number >> (offset - 1 - level) & 1 == 1 { then } else { otherwise }
            })
        };
        let numbered = 1usize.checked_shl(offset).unwrap_or(usize::MAX);
        if (numbers..numbered).any(|number| leaf(number) != Edge::FALSE) {
            return Ok(None);
        }
        let leaves: Vec<Edge> = (0..numbers).map(leaf).collect();
        Ok(Some(ChoiceSet(Arc::new(load(&self.store, diagram, offset, &leaves)?))))
    }

    /// Returns the states that have the choice of this number in the set; empty for an unknown
    /// number.
    ///
    /// # Errors
    /// The set belongs to another engine.
    pub fn numbered(&self, choices: &ChoiceSet, number: usize) -> Result<StateSet> {
        let states = self.diagrams_of(choices)?.get(number).cloned();
        Ok(StateSet(states.unwrap_or_else(|| self.store.zero())))
    }

    /// Returns all choices of this number, enabled or not.
    pub fn only(&self, number: usize) -> ChoiceSet {
        let mut only = vec![self.store.zero(); self.enabled.len()];
        if let Some(all) = only.get_mut(number) {
            *all = self.store.one();
        }
        ChoiceSet(Arc::new(only))
    }

    /// Returns the valuations that agree with a state of X on these variables: ∃ the others . X.
    ///
    /// Cost: one quantification.
    ///
    /// # Errors
    /// A limit, or a set that belongs to another engine.
    pub fn projection(&self, x: &StateSet, onto: &[VarId]) -> Result<StateSet> {
        let others: Vec<VarId> = self.program.variable_ids().filter(|v| !onto.contains(v)).collect();
        Ok(StateSet(self.store.exists(self.diagram_of(x)?, &self.encoding.bits_of(&self.store, &others)?)?))
    }

    /// Returns X × {0, …, numbers - 1}: the same states for each number, whether or not the choice
    /// is enabled.
    ///
    /// # Errors
    /// The set belongs to another engine.
    pub fn repeated(&self, x: &StateSet, numbers: usize) -> Result<ChoiceSet> {
        Ok(ChoiceSet(Arc::new(vec![self.diagram_of(x)?.clone(); numbers])))
    }
}

fn functions(set: &Set) -> Vec<&Bdd> {
    match set {
        Set::States(x) => vec![&x.0],
        Set::Choices(c) => c.0.iter().collect(),
    }
}

fn functions_of(set: &Set) -> usize {
    functions(set).len()
}

type Unique = AHashMap<(Edge, Edge), Edge>;

/// Builds one level of the tree over the bits of choice numbers: joins neighbours in pairs. A last
/// function without a neighbour is joined with the constant false.
fn paired(diagram: &mut Diagram, unique: &mut Unique, level: u32, row: &[Edge]) -> Result<Vec<Edge>> {
    let pair = |pair: &[Edge]| {
        let (even, odd) = (pair[0], pair.get(1).copied().unwrap_or(Edge::FALSE));
        make(diagram, unique, level, odd, even)
    };
    row.chunks(2).map(pair).collect()
}

/// Returns the function `level ? then : otherwise`; equal functions share one node.
fn make(diagram: &mut Diagram, unique: &mut Unique, level: u32, then: Edge, otherwise: Edge) -> Result<Edge> {
    if then == otherwise {
        return Ok(then);
    }
    let flip = then.is_complemented();
    let key = (then.complement_if(flip), otherwise.complement_if(flip));
    let edge = match unique.get(&key) {
        Some(&edge) => edge,
        None => *unique.entry(key).or_insert(diagram.push(level, key.0, key.1)?),
    };
    Ok(edge.complement_if(flip))
}

/// Adds functions over the present bits to a diagram, level by level from the deepest.
fn store_in(
    diagram: &mut Diagram,
    offset: u32,
    width: usize,
    functions: &[&Bdd],
    sink: &dyn ProgressSink,
) -> Result<Vec<Edge>> {
    let Some(first) = functions.first() else { return Ok(Vec::new()) };
    first.with_manager_shared(|m, _| {
        let roots: Vec<diagram::Edge<'_, '_>> = functions.iter().map(|f| f.as_edge(m)).collect();
        let levels = by_level(m, &roots, width);
        let mut known = AHashMap::new();
        for (level, nodes) in levels.iter().enumerate().rev() {
            if let Some(limit) = sink.stop() {
                return Err(limit.into());
            }
            let mut unique = AHashMap::new();
            for &node in nodes {
                let Node::Inner(inner) = m.get_node(node) else { continue };
                let (then, otherwise) = (arc(m, &known, inner.child(0)), arc(m, &known, inner.child(1)));
                let edge = make(diagram, &mut unique, offset + level as u32, then, otherwise)?;
                known.insert(node.node_id(), edge);
            }
        }
        Ok(roots.iter().map(|&root| arc(m, &known, root)).collect())
    })
}

/// Returns the inner nodes below some roots, by the position of their bit.
fn by_level<'a, 'id>(
    m: &'a ManagerOf<'id>,
    roots: &[diagram::Edge<'a, 'id>],
    width: usize,
) -> Vec<Vec<diagram::Edge<'a, 'id>>> {
    let mut levels = vec![Vec::new(); width];
    let mut seen = AHashSet::new();
    let mut stack = roots.to_vec();
    stack.reverse();
    while let Some(edge) = stack.pop() {
        let Node::Inner(inner) = m.get_node(edge) else { continue };
        if seen.insert(edge.node_id()) {
            levels[inner.level() as usize / 2].push(edge);
            stack.extend([inner.child(1), inner.child(0)]);
        }
    }
    levels
}

/// Returns the new edge for an edge to a terminal or to a node that was already converted.
fn arc<'id>(m: &ManagerOf<'id>, known: &AHashMap<usize, Edge>, edge: diagram::Edge<'_, 'id>) -> Edge {
    use oxidd_rules_bdd::simple::BDDTerminal;
    use std::borrow::Borrow;
    match m.get_node(edge) {
        Node::Terminal(t) if *t.borrow() == BDDTerminal::True => Edge::TRUE,
        Node::Terminal(_) => Edge::FALSE,
        // Children are on deeper levels, which were converted before.
        Node::Inner(_) => known[&edge.node_id()],
    }
}

/// Loads functions from a diagram; `offset` variables precede the bits of the states.
fn load(store: &Store, diagram: &Diagram, offset: u32, edges: &[Edge]) -> Result<Vec<Bdd>> {
    store.deep(|| load_deep(store, diagram, offset, edges))
}

fn load_deep(store: &Store, diagram: &Diagram, offset: u32, edges: &[Edge]) -> Result<Vec<Bdd>> {
    let wanted = wanted(diagram, edges);
    let mut built: Vec<[Option<Bdd>; 2]> = Vec::with_capacity(diagram.nodes.len());
    let get = |built: &[[Option<Bdd>; 2]], edge: Edge| match edge.id().checked_sub(2) {
        None if edge.is_complemented() => Ok(store.zero()),
        None => Ok(store.one()),
        Some(n) => {
            let both = built.get(n).and_then(|b| b[usize::from(edge.is_complemented())].clone());
            both.ok_or_else(|| missing(edge))
        }
    };
    for (node, wanted) in diagram.nodes.iter().zip(&wanted) {
        let mut both = [None, None];
        for (flip, slot) in both.iter_mut().enumerate().filter(|(flip, _)| wanted[*flip]) {
            // A function over the bits of choices has no states; an arc to it is an error.
            let Some(position) = node.level.checked_sub(offset) else { continue };
            let bit = store.literal(2 * position, true)?;
            let then = get(&built, node.then.complement_if(flip == 1))?;
            let otherwise = get(&built, node.otherwise.complement_if(flip == 1))?;
            *slot = Some(store.ite(&bit, &then, &otherwise)?);
        }
        built.push(both);
    }
    edges.iter().map(|&edge| get(&built, edge)).collect()
}

/// Returns the error for an arc that does not lead to a set of states of the diagram.
fn missing(edge: Edge) -> Error {
    Error::Usage(format!("the arc {} does not lead to a set of states of the diagram", edge.number()))
}

/// Returns two flags per node: the given edges need its function, and they need its complement.
fn wanted(diagram: &Diagram, edges: &[Edge]) -> Vec<[bool; 2]> {
    let mut wanted = vec![[false; 2]; diagram.nodes.len()];
    let mark = |wanted: &mut Vec<[bool; 2]>, edge: Edge| {
        if let Some(flags) = edge.id().checked_sub(2).and_then(|n| wanted.get_mut(n)) {
            flags[usize::from(edge.is_complemented())] = true;
        }
    };
    edges.iter().for_each(|&edge| mark(&mut wanted, edge));
    for (index, node) in diagram.nodes.iter().enumerate().rev() {
        for flip in [false, true] {
            if wanted[index][usize::from(flip)] {
                mark(&mut wanted, node.then.complement_if(flip));
                mark(&mut wanted, node.otherwise.complement_if(flip));
            }
        }
    }
    wanted
}

impl Encoding {
    /// Returns the bits with these names in this order; `None` unless each bit occurs exactly once.
    pub fn order_of(program: &Program, names: &[String]) -> Option<Vec<Bit>> {
        let declared = super::order::declared(program);
        let known = Encoding::new(program, declared.clone()).names();
        let of: AHashMap<&String, Bit> = known.iter().zip(declared).collect();
        let order: Vec<Bit> = names.iter().map(|n| of.get(n).copied()).collect::<Option<_>>()?;
        super::order::is_whole(program, &order).then_some(order)
    }
}
