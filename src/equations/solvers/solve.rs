//! The equations of probabilities, costs and expected numbers, level by level, component by
//! component.
//!
//! With v(s') = P_{k-1}(s') if the step to s' improves, P_k(s') if not, and 0 if it is lost:
//! P_k(s) = max over kept choices a of Σ p(s,a,s') · v(s'), the least solution. C_k is the least
//! cost + Σ p · w(s') over the choices that keep k improvements certain, with w from C_{k-1} and C_k
//! in the same way. N has 1 + N(s') on improving steps.

use bitvec::vec::BitVec;

use crate::graphs::game_graph::LOST;
use crate::graphs::graph::{Graph, NONE};
use crate::graphs::meter::{Meter, Stop, Turn};
use crate::solvers::components::{self, Components, Successors};
use crate::solvers::groups::Groups;
use crate::solvers::policies::Policies;
use crate::solvers::rows::{GroupBounds, Rows};
use crate::solvers::solution::Solution;
use crate::solvers::system::{Quantity, System};
use meliora_base::error::{Error, Limit, Result};
use meliora_base::exact::Ratio;
use meliora_base::interval::Interval;
use meliora_base::number::Number;
use meliora_model::Optimum;

/// Solves the equations of a graph, with the solution of the level below and the fractions of the graph. Returns the
/// solution, as far as it is known, and an error if a limit was reached.
pub(crate) fn solved<N: Number>(
    graph: &Graph,
    quantity: Quantity,
    (below, fractions): (Option<&Solution<N>>, &[N]),
    meter: &mut Meter<'_>,
) -> Result<(Solution<N>, Result<()>)> {
    let system = System::new(graph, quantity, below, fractions);
    let mut solution = system.start(meter)?;
    let end = system.solve(&mut solution, meter);
    Ok((solution, end))
}

impl<N: Number> System<'_, N> {
    /// Solves the equations of all open nodes, the components that others depend on first.
    ///
    /// # Errors
    /// A limit is reached; then all nodes have bounds, as far as those found before the limit show
    /// them.
    pub(crate) fn solve(&self, solution: &mut Solution<N>, meter: &mut Meter<'_>) -> Result<()> {
        if !solution.has_equations() {
            return Ok(());
        }
        let bytes = self.game.choices_in_all() / 8;
        meter.take(bytes)?;
        let found = self.permitted();
        self.with_found(&found).solve_all(solution, meter)?;
        meter.release(bytes);
        Ok(())
    }

    fn solve_all(&self, solution: &mut Solution<N>, meter: &mut Meter<'_>) -> Result<()> {
        let nodes = self.game.states();
        let scratch = nodes * 3 * size_of::<u32>();
        let search = nodes * components::SEARCH + self.game.edges_in_all() / 8;
        meter.take(search)?;
        let found = self.components();
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
        component.iter().zip(0..).for_each(|(&node, at)| position[node as usize] = at);
        let end = self.component(component, position, solution, meter);
        component.iter().for_each(|&node| position[node as usize] = NONE);
        end.map_err(|e| self.explained(e, component.len()))
    }

    /// Bounds the nodes without values, from a component on, by one step per node, which holds for any bounds of their
    /// successors. Their best choices remain unknown.
    fn pass_on(&self, components: &Components, first: usize, solution: &mut Solution<N>) {
        let Ok(anything) = self.anything() else { return };
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
    pub(crate) fn components(&self) -> Components {
        let (game, counted) = (self.game, self.quantity == Quantity::Number);
        let open = || (0..game.states() as u32).filter(|&node| self.is_open(node));
        let mut followed = BitVec::<usize>::repeat(false, game.edges_in_all());
        let followed_of = |node: u32| game.choices(node).filter(move |&choice| self.follows(node, choice));
        for position in open().flat_map(followed_of).flat_map(|choice| game.positions(choice..choice + 1)) {
            let edge = game.edge(position);
            let follows = edge.to != LOST && (!edge.counts() || counted) && self.is_open(edge.to);
            followed.set(position as usize, follows);
        }
        let positions = |node: u32| game.edges_of(node);
        let at = |position: u32| followed[position as usize].then(|| game.choices.to[position as usize]);
        components::components(&Successors { nodes: game.states(), positions, at }, open())
    }

    /// Solves the equation of a node that is a component of its own.
    fn single(&self, node: u32, solution: &mut Solution<N>) -> Result<()> {
        let (mut best, greatest): (Option<(N, u32)>, _) = (None, self.optimum(node) == Optimum::Max);
        let side = |x: &N| if greatest { x.low() } else { x.high() };
        for choice in self.game.choices(node) {
            let Some(q) = self.alone(choice, solution) else { continue };
            best = Some(match best {
                None => (q, choice),
                Some((best, pick)) => {
                    let pick = if side(&q).beats(&side(&best), greatest) { choice } else { pick };
                    (best.extreme(q, greatest), pick)
                }
            });
        }
        let (value, pick) = match best {
            Some(best) => best,
            None => (self.anything()?, NONE),
        };
        solution.set(node, value);
        solution.set_pick(node, pick);
        Ok(())
    }

    /// Returns the value of a choice whose successors are known, except for a self-loop; `None` if
    /// it is not permitted or never left.
    fn alone(&self, choice: u32, solution: &Solution<N>) -> Option<N> {
        match self.parts(choice, solution)? {
            (sum, _, true) => Some(sum),
            (sum, leaving, false) => (!leaving.is_zero()).then(|| sum.over(&leaving)),
        }
    }

    /// Solves the equations of a component.
    pub(crate) fn component(
        &self,
        nodes: &[u32],
        position: &[u32],
        solution: &mut Solution<N>,
        meter: &mut Meter<'_>,
    ) -> Result<()> {
        let before = meter.bytes();
        let groups = Groups::new(self, nodes, position, meter)?;
        meter.take(groups.bytes())?;
        let rows = Rows::new(self, &groups, solution, meter)?;
        meter.take(rows.bytes())?;
        // A method takes the nodes of the component from those that are not known.
        let end = match N::EXACT {
            true => self.exact(&groups, &rows, solution, meter),
            false => {
                let (GroupBounds { low, high, picks }, end) = self.in_turns(&groups, &rows, solution, meter);
                let most = self.most();
                let bounds =
                    |(&lower, &upper): (&f64, &f64)| N::rounded(Interval { lower, upper: upper.min(most) });
                let values: Vec<N> = low.iter().zip(&high).filter_map(bounds).collect();
                groups.store(self, &values, &picks, solution);
                end
            }
        };
        meter.release_to(before);
        end
    }

    /// Finds the exact values of a component; doubles tell where to begin.
    fn exact(
        &self,
        groups: &Groups<'_>,
        rows: &Rows<f64>,
        solution: &mut Solution<N>,
        meter: &mut Meter<'_>,
    ) -> Result<()> {
        let seen = match Policies::new(rows).bounds(&[], usize::MAX, meter) {
            Ok(found) => found.picks,
            Err(Stop::Limit(error)) if !matches!(error, Error::Limit(Limit::Memory { .. })) => {
                return Err(error);
            }
            Err(_) => Vec::new(),
        };
        match self.fractions_of(groups, solution, &seen, usize::MAX, meter) {
            Ok(GroupBounds { low, picks, .. }) => {
                let values: Vec<N> = low.iter().map(N::of).collect();
                groups.store(self, &values, &picks, solution);
                Ok(())
            }
            Err(Stop::Limit(error)) => Err(error),
            Err(_) => self.anything().map(drop),
        }
    }

    /// Returns the exact solution of a component, where the bounds of its exits are fractions. `seen` has choices that
    /// are probably the best, if some are known.
    ///
    /// # Errors
    /// Some of these bounds is infinite, or some group cannot leave the component; it takes more work than `budget`; a
    /// limit is reached.
    pub(crate) fn fractions_of(
        &self,
        groups: &Groups<'_>,
        solution: &Solution<N>,
        seen: &[u32],
        budget: usize,
        meter: &mut Meter<'_>,
    ) -> Turn<GroupBounds<Ratio>> {
        if !N::EXACT && !groups.is_bounded(self, solution) {
            return Err(Stop::Never);
        }
        let (rows, before) = (Rows::<Ratio>::new(self, groups, solution, meter)?, meter.bytes());
        let taken = meter.take(rows.bytes()).map_err(Stop::from);
        let end = taken.and_then(|()| Policies::new(&rows).exact(seen, budget, meter));
        meter.release_to(before);
        end
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
