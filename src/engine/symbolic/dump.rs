//! Diagrams as plain data: out of the store, and back into it.

use ahash::{AHashMap, AHashSet};
use oxidd::{Function, HasLevel, InnerNode, Manager, Node};
use std::sync::Arc;

use super::diagram::{self, Bdd, ManagerOf};
use super::encoding::Encoding;
use super::store::Store;
use super::transitions::Numbered;
use super::{Bit, ChoiceSet, StateSet, SymbolicEngine, build, draft};
use crate::dump::{Diagram, Edge};
use crate::engine::{Engine, ProgressSink, Settings};
use crate::error::Result;
use crate::model::{ModelKind, Program, VarId};

/// A set to be dumped.
#[derive(Clone)]
pub enum Set {
    /// Of states.
    States(StateSet),
    /// Of choices.
    Choices(ChoiceSet),
}

impl SymbolicEngine {
    /// An engine whose scope is a set of states given as a diagram over the bits of `order`: the
    /// commands become relations, but nothing is explored. Patterns that are no values are left out.
    ///
    /// # Errors
    /// As [`SymbolicEngine::new`], for the states given. Cost: no image; the relations are built.
    pub fn with_states(
        program: Arc<Program>,
        order: Vec<Bit>,
        settings: Settings,
        diagram: &Diagram,
        states: Edge,
    ) -> Result<Self> {
        let offset = diagram.variables.len().saturating_sub(order.len()) as u32;
        let given = |store: &Store| {
            let mut loaded = load(store, diagram, offset, &[states])?;
            Ok(loaded.pop().unwrap_or_else(|| store.zero()))
        };
        build::build(program, order, settings, Some(&given))
    }

    /// All valuations of the declared variables, states of the scope or not: every bit pattern in which
    /// each variable is within its range.
    pub fn valuations(&self) -> StateSet {
        StateSet(self.domain.clone())
    }

    /// The states in which plays of the scope begin, states of it or not: the initial ones, or with monitors
    /// in the scope `all` every valuation in which these are fresh; none where all valuations are the scope.
    ///
    /// # Errors
    /// A limit. Cost: no image.
    pub fn beginnings(&self) -> Result<Option<StateSet>> {
        let sets = (&self.initial.0, &self.domain);
        let found = draft::beginnings(&self.program, &self.encoding, &self.store, self.settings.scope, sets)?;
        Ok(found.map(StateSet))
    }

    /// How many bits number the choices: ⌈log₂⌉ of the number of groups, deadlocks' self-loops included.
    pub fn choice_bits(&self) -> u32 {
        usize::BITS - (self.enabled.len() - 1).leading_zeros()
    }

    /// What the numbers of choices mean, from 0; the last one is the self-loop of deadlocks. Of the choices
    /// with one number at most one is enabled in a state.
    pub fn numbered_choices(&self) -> Vec<Numbered> {
        let mut all = match self.program.kind {
            ModelKind::Dtmc => vec![Numbered::Uniform; self.enabled.len() - 1],
            ModelKind::Mdp => self.transitions.combinations(&self.program),
        };
        all.push(Numbered::Deadlock);
        all
    }

    /// The sets as one diagram, a root each. With `choice_bits` of them, the first variables number
    /// the choices (most significant bit first); then follow the bits of the states in their order.
    ///
    /// # Errors
    /// More nodes than the format numbers. Cost: linear in the nodes of the sets.
    pub fn diagram(&self, sets: &[Set], choice_bits: &[String]) -> Result<Diagram> {
        let variables = choice_bits.iter().cloned().chain(self.encoding.names()).collect();
        let mut diagram = Diagram { variables, ..Diagram::default() };
        let functions: Vec<&Bdd> = sets.iter().flat_map(functions).collect();
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

    /// Sets of states out of a diagram whose last variables are the bits of the states in their order.
    ///
    /// # Errors
    /// A limit. Cost: one if-then-else a node.
    pub fn load_states(&self, diagram: &Diagram, edges: &[Edge]) -> Result<Vec<StateSet>> {
        let offset = diagram.variables.len().saturating_sub(self.encoding.width()) as u32;
        Ok(load(&self.store, diagram, offset, edges)?.into_iter().map(StateSet).collect())
    }

    /// A set of choices with the first `numbers` numbers; none where it has members with others.
    ///
    /// # Errors
    /// A limit. Cost: one if-then-else a node.
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

    /// The states with the choice of this number; empty where there is no such number.
    pub fn numbered(&self, choices: &ChoiceSet, number: usize) -> StateSet {
        StateSet(choices.0.get(number).cloned().unwrap_or_else(|| self.store.zero()))
    }

    /// All choices with this number, enabled or not.
    pub fn only(&self, number: usize) -> ChoiceSet {
        let mut only = vec![self.store.zero(); self.enabled.len()];
        if let Some(all) = only.get_mut(number) {
            *all = self.store.one();
        }
        ChoiceSet(Arc::new(only))
    }

    /// The states of the scope in which some variables have these values.
    ///
    /// # Errors
    /// A limit. Cost: a conjunction a bit.
    pub fn slice(&self, fixed: &[(VarId, i64)]) -> Result<StateSet> {
        let mut slice = self.states.0.clone();
        for &(variable, value) in fixed {
            let declared = &self.program.variables[variable.index()];
            if !(declared.low..=declared.high).contains(&value) {
                return Ok(self.no_states());
            }
            let offset = value.wrapping_sub(declared.low) as u64;
            for (index, &position) in self.encoding.positions(variable).iter().enumerate() {
                let bit = self.store.literal(2 * position, offset >> index & 1 == 1)?;
                slice = self.store.and(&bit, &slice)?;
            }
        }
        Ok(StateSet(slice))
    }

    /// The valuations that agree with a state of X on these variables: ∃ the others . X.
    ///
    /// # Errors
    /// A limit. Cost: one quantification.
    pub fn projection(&self, x: &StateSet, onto: &[VarId]) -> Result<StateSet> {
        let others: Vec<VarId> = self.program.variable_ids().filter(|v| !onto.contains(v)).collect();
        Ok(StateSet(self.store.exists(&x.0, &self.encoding.bits_of(&self.store, &others)?)?))
    }

    /// X × {0, …, numbers - 1}: for each number the same states, whether the choice is enabled or not.
    pub fn repeated(&self, x: &StateSet, numbers: usize) -> ChoiceSet {
        ChoiceSet(Arc::new(vec![x.0.clone(); numbers]))
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

/// One level of the tree over the bits of choices: neighbours become one; a last one alone gets a
/// neighbour that is never there.
fn paired(diagram: &mut Diagram, unique: &mut Unique, level: u32, row: &[Edge]) -> Result<Vec<Edge>> {
    let pair = |pair: &[Edge]| {
        let (even, odd) = (pair[0], pair.get(1).copied().unwrap_or(Edge::FALSE));
        make(diagram, unique, level, odd, even)
    };
    row.chunks(2).map(pair).collect()
}

/// The function `level ? then : otherwise`, each once.
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

/// The inner nodes below some roots by the position of their bit.
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

/// The arc for an edge whose node is known or a terminal.
fn arc<'id>(m: &ManagerOf<'id>, known: &AHashMap<usize, Edge>, edge: diagram::Edge<'_, 'id>) -> Edge {
    use oxidd_rules_bdd::simple::BDDTerminal;
    use std::borrow::Borrow;
    match m.get_node(edge) {
        Node::Terminal(t) if *t.borrow() == BDDTerminal::True => Edge::TRUE,
        Node::Terminal(_) => Edge::FALSE,
        Node::Inner(_) => known.get(&edge.node_id()).copied().unwrap_or(Edge::FALSE),
    }
}

/// Functions out of a diagram; `offset` variables stand above the bits of the states.
fn load(store: &Store, diagram: &Diagram, offset: u32, edges: &[Edge]) -> Result<Vec<Bdd>> {
    store.deep(|| load_deep(store, diagram, offset, edges))
}

fn load_deep(store: &Store, diagram: &Diagram, offset: u32, edges: &[Edge]) -> Result<Vec<Bdd>> {
    let wanted = wanted(diagram, edges);
    let mut built: Vec<[Option<Bdd>; 2]> = Vec::with_capacity(diagram.nodes.len());
    let get = |built: &[[Option<Bdd>; 2]], edge: Edge| match edge.id().checked_sub(2) {
        None if edge.is_complemented() => store.zero(),
        None => store.one(),
        Some(n) => {
            let both = built.get(n).and_then(|b| b[usize::from(edge.is_complemented())].clone());
            both.unwrap_or_else(|| store.zero())
        }
    };
    for (node, wanted) in diagram.nodes.iter().zip(&wanted) {
        let mut both = [None, None];
        for (flip, slot) in both.iter_mut().enumerate().filter(|(flip, _)| wanted[*flip]) {
            let Some(position) = node.level.checked_sub(offset) else { continue };
            let bit = store.literal(2 * position, true)?;
            let then = get(&built, node.then.complement_if(flip == 1));
            let otherwise = get(&built, node.otherwise.complement_if(flip == 1));
            *slot = Some(store.ite(&bit, &then, &otherwise)?);
        }
        built.push(both);
    }
    Ok(edges.iter().map(|&edge| get(&built, edge)).collect())
}

/// For each node whether its function and whether its complement is part of one of these.
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
    /// The bits with these names in this order; none unless each bit is there once.
    pub fn order_of(program: &Program, names: &[String]) -> Option<Vec<Bit>> {
        let declared = super::order::declared(program);
        let known = Encoding::new(program, declared.clone()).names();
        let of: AHashMap<&String, Bit> = known.iter().zip(declared).collect();
        let order: Vec<Bit> = names.iter().map(|n| of.get(n).copied()).collect::<Option<_>>()?;
        super::order::is_whole(program, &order).then_some(order)
    }
}
