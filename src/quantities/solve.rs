//! The equations of probabilities, costs and expected numbers, level by level, component by
//! component.
//!
//! With v(s') = P_{k-1}(s') if the step to s' improves, P_k(s') if not, and 0 if it is lost:
//! P_k(s) = max over kept choices a of Σ p(s,a,s') · v(s'), the least solution. C_k is the least
//! cost + Σ p · w(s') over the choices that keep k improvements certain, with w from C_{k-1} and C_k
//! in the same way. N has 1 + N(s') on improving steps.

use std::ops::Range;

use bitvec::vec::BitVec;

use super::component::{Component, Optimum, Sense};
use super::components::{self, Components, Successors};
use super::doubles;
use super::feedback;
use super::graph::{Graph, LOST};
use super::groups::{AsFractions, AsTheyAre, Groups};
use super::iterate::{self, Found, Sparse};
use super::meter::Meter;
use super::number::{Interval, Number};
use super::order::{self, Order};
use super::pace::Patience::{self, Little, Much};
use super::solution::Solution;
use super::system::{End, Quantity, System};
use meliora_model::error::{Error, Limit, Result};
use meliora_model::exact::Ratio;

/// The number of groups up to which elimination is as fast as iteration; see [`crate`].
const SMALL: usize = 1000;
/// The number of groups up to which iteration is given up early, so that elimination with doubles is tried: in
/// larger components both attempts cost much.
const HASTY: usize = 2_000_000;
/// The number of edges per group from which elimination fills in all rows, so that it is slower.
const DENSE: usize = 8;
/// The number of groups up to which a component is solved by intervals at once, and with fractions if its
/// bounds are wide.
pub(super) const FEW: usize = 100;

/// The number of nodes up to which bounds are passed on after a limit is reached: this must not delay
/// the end noticeably.
const PASSED_ON: usize = 1 << 22;

/// No choice, or no position.
pub(super) const NONE: u32 = u32::MAX;

/// A method for components; see [`crate`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum How {
    /// Policy iteration on the few groups through which all cycles pass.
    Feedback,
    /// Policy iteration by elimination with intervals or fractions.
    Eliminate,
    /// Policy iteration by elimination with doubles.
    Confirm(Patience),
    /// Optimistic value iteration.
    Iterate(Patience),
}

/// Returns an order of a large graph for [`System::order`]; `None` if none is found.
///
/// # Errors
/// A limit is reached.
pub(super) fn order(graph: &Graph, meter: &mut Meter<'_>) -> Result<Option<Order>> {
    if graph.nodes() <= order::SMALL {
        return Ok(None);
    }
    let order = Order::new(graph, meter)?;
    meter.take(order.as_ref().map_or(0, |_| graph.nodes() * size_of::<u32>()))?;
    Ok(order)
}

impl<N: Number> System<'_, N> {
    /// Solves the equations of all open nodes, the components that others depend on first.
    ///
    /// # Errors
    /// A limit is reached; then all nodes have bounds, as far as those found before the limit show
    /// them.
    pub(super) fn solve(&self, solution: &mut Solution<N>, meter: &mut Meter<'_>) -> Result<()> {
        if !solution.has_equations() {
            return Ok(());
        }
        let nodes = self.graph.nodes();
        let scratch = nodes * 3 * size_of::<u32>();
        let search = nodes * components::SEARCH + self.graph.edges_in_all() / 8;
        meter.take(search)?;
        let found = self.components(meter)?;
        meter.release(search - scratch);
        let mut position = vec![NONE; nodes];
        for number in 0..found.count() {
            meter.progress_at(number, &|| format!("component {} of {}", number + 1, found.count()));
            let end = self.next(found.get(number), &mut position, solution, meter);
            if end.is_err() {
                self.pass_on(&found, number, solution);
                return end;
            }
        }
        meter.release(scratch);
        Ok(())
    }

    /// Solves the equations of a component; `position` has a place for each node.
    fn next(
        &self,
        component: &[u32],
        position: &mut [u32],
        solution: &mut Solution<N>,
        meter: &mut Meter<'_>,
    ) -> Result<()> {
        if !self.is_open(component[0]) {
            return Ok(());
        }
        meter.step()?;
        if let [node] = *component {
            return self.single(node, solution);
        }
        let place = |nodes: &[u32], position: &mut [u32]| {
            nodes.iter().zip(0..).for_each(|(&node, at)| position[node as usize] = at);
        };
        let end = self.ordered(component, position, meter).and_then(|ordered| {
            let nodes = ordered.as_deref().unwrap_or(component);
            place(nodes, position);
            self.component(nodes, position, solution, meter)
        });
        component.iter().for_each(|&node| position[node as usize] = NONE);
        end.map_err(|e| self.explained(e, component.len()))
    }

    /// Returns the nodes of a large component in an order of their own, if they have one and the graph has none.
    fn ordered(
        &self,
        component: &[u32],
        position: &mut [u32],
        meter: &mut Meter<'_>,
    ) -> Result<Option<Vec<u32>>> {
        match self.order.is_some() || component.len() <= order::SMALL {
            true => Ok(None),
            false => Order::within(self.graph, component, position, meter),
        }
    }

    /// Bounds the nodes without values, from a component on, by one step per node, which holds for any bounds of their
    /// successors. Their best choices remain unknown.
    fn pass_on(&self, components: &Components, first: usize, solution: &mut Solution<N>) {
        let Ok(anything) = self.anything() else { return };
        if components.from(first).len() > PASSED_ON {
            return;
        }
        for component in components.iter().skip(first) {
            let open = |&node: &u32| self.is_open(node) && !solution.knows(node);
            let open: Vec<u32> = component.iter().copied().filter(open).collect();
            open.iter().for_each(|&node| solution.set(node, anything.clone()));
            for &node in &open {
                // Fails only for exact numbers, which have no bounds.
                let _ = self.single(node, solution);
                solution.set_pick(node, NONE);
            }
        }
    }

    /// Returns the strongly connected components of the open nodes and of those that they reach; each
    /// comes after those that it reaches.
    ///
    /// # Errors
    /// A limit is reached.
    pub(super) fn components(&self, meter: &mut Meter<'_>) -> Result<Components> {
        let dependencies = Dependencies::new(self);
        if let Some(order) = self.order {
            return order.components(&dependencies, |node| self.is_open(node), meter);
        }
        let open = (0..self.graph.nodes() as u32).filter(|&node| self.is_open(node));
        Ok(components::components(&dependencies, open))
    }

    /// Solves the equation of a node that is a component of its own.
    fn single(&self, node: u32, solution: &mut Solution<N>) -> Result<()> {
        let mut best: Option<(N, N, u32)> = None;
        for choice in self.graph.choices(node) {
            let Some(q) = self.alone(choice, solution) else { continue };
            let (low, high) = (q.low(), q.high());
            best = Some(match best {
                None => (low, high, choice),
                Some((a, b, pick)) => match self.sense() {
                    Sense::Max => {
                        let pick = if low.exceeds(&a) { choice } else { pick };
                        (a.or_greater(low), b.or_greater(high), pick)
                    }
                    Sense::Min => {
                        let pick = if b.exceeds(&high) { choice } else { pick };
                        (a.or_smaller(low), b.or_smaller(high), pick)
                    }
                },
            });
        }
        let (value, pick) = match best {
            Some((low, high, pick)) => (N::between(&low, &high), pick),
            None => (self.anything()?, NONE),
        };
        solution.set(node, value);
        solution.set_pick(node, pick);
        Ok(())
    }

    /// Returns the value of a choice whose successors are known, except for a self-loop; `None` if
    /// it is not permitted or never left.
    fn alone(&self, choice: u32, solution: &Solution<N>) -> Option<N> {
        if !self.permits(choice) {
            return None;
        }
        let (mut sum, mut leaving, mut whole) = (self.own_constant(choice), N::zero(), true);
        for edge in self.graph.edges(choice) {
            let p = &self.fractions[edge.probability() as usize];
            if self.bonus(edge) {
                sum = sum.plus(p);
            }
            match self.end(edge, solution) {
                End::Known(value) => {
                    sum = sum.plus(&p.times(&value));
                    leaving = leaving.plus(p);
                }
                End::Open(_) => whole = false,
            }
        }
        match whole {
            true => Some(sum),
            false => (!leaving.is_zero()).then(|| sum.over(&leaving)),
        }
    }

    /// Solves the equations of a component.
    pub(super) fn component(
        &self,
        nodes: &[u32],
        position: &[u32],
        solution: &mut Solution<N>,
        meter: &mut Meter<'_>,
    ) -> Result<()> {
        let groups = Groups::new(self, nodes, position, meter)?;
        meter.take(groups.bytes())?;
        let end = if N::EXACT {
            self.eliminate(&groups, solution, meter).map(drop)
        } else {
            self.in_turn(nodes, &groups, solution, meter)
        };
        meter.release(groups.bytes());
        end
    }

    /// Solves a component by one method after the other while they leave wide bounds. All results are bounds,
    /// so the narrower ones count, also if a limit ends a method.
    fn in_turn(
        &self,
        nodes: &[u32],
        groups: &Groups<'_>,
        solution: &mut Solution<N>,
        meter: &mut Meter<'_>,
    ) -> Result<()> {
        let (mut known, mut sparse): (Option<Vec<N>>, Option<Sparse>) = (None, None);
        let mut end = Ok(());
        for how in self.methods(nodes, groups) {
            // A method takes the nodes of the component from those that are not known.
            nodes.iter().for_each(|&node| solution.know(node, false));
            let done = self.attempt(how, groups, &mut sparse, solution, meter);
            for (&node, bounds) in nodes.iter().zip(known.iter().flatten()) {
                solution.set(node, solution.stored(node).within(bounds));
            }
            if !matches!(done, Ok(false)) {
                end = done.map(drop);
                break;
            }
            known = Some(nodes.iter().map(|&node| solution.stored(node).clone()).collect());
        }
        meter.release(sparse.map_or(0, |sparse| sparse.bytes()));
        end
    }

    /// Returns the methods for a component in the order in which they are tried.
    fn methods(&self, nodes: &[u32], groups: &Groups<'_>) -> Vec<How> {
        let edges = || nodes.iter().map(|&node| self.graph.edges_of(node).len()).sum::<usize>();
        let fastest = match groups.count() {
            ..=FEW => How::Eliminate,
            ..=SMALL if edges() < DENSE * groups.count() => How::Confirm(Much),
            _ => How::Feedback,
        };
        let iterate = if groups.count() <= HASTY { How::Iterate(Little) } else { How::Iterate(Much) };
        let first = self.first.unwrap_or(fastest);
        let second = (first == How::Feedback).then_some(iterate);
        let others: &[How] = match second.unwrap_or(first) {
            How::Feedback => &[],
            How::Eliminate => &[How::Iterate(Much), How::Confirm(Much)],
            How::Confirm(_) => &[How::Eliminate, How::Iterate(Much)],
            How::Iterate(Little) => {
                &[How::Confirm(Little), How::Iterate(Much), How::Confirm(Much), How::Eliminate]
            }
            How::Iterate(Much) => &[How::Confirm(Much), How::Eliminate],
        };
        [&[first], second.as_slice(), others].concat()
    }

    /// Solves a component by one method; `sparse` has its rows if a method has needed them. Returns false if the
    /// bounds, which are stored, are wide.
    fn attempt(
        &self,
        how: How,
        groups: &Groups<'_>,
        sparse: &mut Option<Sparse>,
        solution: &mut Solution<N>,
        meter: &mut Meter<'_>,
    ) -> Result<bool> {
        if how != How::Eliminate && sparse.is_none() {
            let rows = sparse.insert(Sparse::new(self, groups, solution, meter)?);
            meter.take(rows.bytes())?;
        }
        let top = matches!(self.quantity, Quantity::Probability(_)).then_some(1.0);
        let (found, end) = match (how, sparse) {
            (How::Eliminate, _) | (_, None) => return self.eliminate(groups, solution, meter),
            (How::Feedback, Some(sparse)) => match feedback::solve(sparse, top, meter) {
                Ok(Some(found)) => (found, Ok(true)),
                other => (Found::nothing(groups.count()), other.map(|_| false)),
            },
            (How::Iterate(patience), Some(sparse)) => iterate::solve(sparse, top, patience, meter),
            (How::Confirm(patience), Some(sparse)) => match doubles::solve(sparse, patience, meter) {
                Ok(Some(found)) => (found, Ok(true)),
                Ok(None) => (Found::nothing(groups.count()), Ok(false)),
                // Iteration needs no more memory.
                Err(Error::Limit(Limit::Memory { .. })) if patience == Little => {
                    (Found::nothing(groups.count()), Ok(false))
                }
                Err(e) => (Found::nothing(groups.count()), Err(e)),
            },
        };
        self.keep(found, groups, solution)?;
        end
    }

    /// Stores bounds of the groups.
    fn keep(&self, found: Found, groups: &Groups<'_>, solution: &mut Solution<N>) -> Result<()> {
        let rounded = |x: &f64| N::rounded(Interval::point(*x));
        let low = found.low.iter().filter_map(rounded).collect();
        let high = found.high.iter().map(|x| rounded(&x.unwrap_or(self.most()))).collect();
        groups.store(self, Some(&Optimum { low, high, picks: found.picks }), solution)
    }

    /// Solves a component by elimination, and again with fractions if the bounds are wide; returns
    /// false if the bounds, which are stored, are still wide and may become narrow.
    fn eliminate(
        &self,
        groups: &Groups<'_>,
        solution: &mut Solution<N>,
        meter: &mut Meter<'_>,
    ) -> Result<bool> {
        let actions = groups.actions::<N, AsTheyAre>(self, solution, meter)?;
        let component = Component { sense: self.sense(), actions };
        let bytes: usize =
            component.actions.iter().flatten().map(|a| (a.row.edges.len() + 4) * (N::BYTES + 4)).sum();
        meter.take(bytes)?;
        let end = component.solve(meter);
        meter.release(bytes);
        let mut optimum = end?;
        // Exact numbers outside of the doubles have wide bounds only where these are shown.
        let mut wide = !N::EXACT && optimum.as_ref().is_none_or(Optimum::is_wide) && component.is_bounded();
        if wide
            && groups.count() <= FEW
            && let Some(exact) = self.exactly(groups, solution, meter)?
        {
            (optimum, wide) = (Some(exact), false);
        }
        groups.store(self, optimum.as_ref(), solution)?;
        Ok(!wide)
    }

    /// Solves a component with the exact probabilities and the bounds of its exits as fractions.
    fn exactly(
        &self,
        groups: &Groups<'_>,
        solution: &Solution<N>,
        meter: &mut Meter<'_>,
    ) -> Result<Option<Optimum<N>>> {
        let Some(found) = self.fractions_of(groups, solution, meter)? else { return Ok(None) };
        let rounded = |x: &Ratio| N::rounded(Interval::around(x));
        let low = found.low.iter().filter_map(|x| rounded(x).map(|x| x.low()));
        let high = found.high.iter().map(|x| x.as_ref().and_then(rounded).map(|x| x.high()));
        Ok(Some(Optimum { low: low.collect(), high: high.collect(), picks: found.picks }))
    }

    /// Returns the exact solution of a component, where the bounds of its exits are fractions; `None`
    /// if one of these is infinite, or some group cannot leave the component.
    pub(super) fn fractions_of(
        &self,
        groups: &Groups<'_>,
        solution: &Solution<N>,
        meter: &mut Meter<'_>,
    ) -> Result<Option<Optimum<Ratio>>> {
        if !groups.is_bounded(self, solution) {
            return Ok(None);
        }
        let actions = groups.actions::<N, AsFractions>(self, solution, meter)?;
        Component::<Ratio> { sense: self.sense(), actions }.solve(meter)
    }

    /// Adds to the error of an exact computation where it ended.
    fn explained(&self, error: Error, nodes: usize) -> Error {
        match error {
            Error::Limit(Limit::Memory { what }) if N::EXACT => {
                let what = format!(
                    "{what}: exact values of {} in {nodes} states that reach each other; without `--exact`, bounds are found",
                    self.quantity
                );
                Limit::Memory { what }.into()
            }
            other => other,
        }
    }
}

/// The dependencies between open nodes.
struct Dependencies<'g> {
    graph: &'g Graph,
    /// True for each edge that is followed.
    followed: BitVec,
}

impl<'g> Dependencies<'g> {
    fn new<N: Number>(system: &System<'g, N>) -> Self {
        let graph = system.graph;
        let mut followed = BitVec::repeat(false, graph.edges_in_all());
        let counted = system.quantity == Quantity::Number;
        for node in (0..graph.nodes() as u32).filter(|&node| system.is_open(node)) {
            for choice in graph.choices(node).filter(|&choice| system.permits(choice)) {
                for (position, edge) in (choice as usize..).zip(graph.edges(choice)) {
                    let follows = edge.to != LOST && (!edge.counts() || counted) && system.is_open(edge.to);
                    followed.set(position, follows);
                }
            }
        }
        Dependencies { graph, followed }
    }
}

impl Successors for Dependencies<'_> {
    fn nodes(&self) -> usize {
        self.graph.nodes()
    }

    fn positions(&self, node: u32) -> Range<u32> {
        self.graph.edges_of(node)
    }

    fn at(&self, position: u32) -> Option<u32> {
        self.followed[position as usize].then(|| self.graph.target(position))
    }
}
