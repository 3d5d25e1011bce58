//! The nodes of a strongly connected component, grouped by the end components in which nothing can
//! be gained or paid.

use bitvec::vec::BitVec;

use crate::graphs::choices::Choices;
use crate::graphs::game_graph::{Edge, LOST};
use crate::graphs::graph::NONE;
use crate::graphs::meter::Meter;
use crate::solvers::components::EndComponents;
use crate::solvers::eliminate::Row;
use crate::solvers::solution::Solution;
use crate::solvers::system::{End, System};
use meliora_base::error::Result;
use meliora_base::exact::Ratio;
use meliora_base::interval::Interval;
use meliora_base::number::{Number, Weight};
use meliora_model::Optimum;

/// The part of the greatest value by which an action must be better, for doubles: more than the error of elimination in
/// most components.
pub(crate) const BETTER: f64 = 1e-12;

/// A number in the rows of a component: a double, or a fraction.
pub(crate) trait Entry: Weight + PartialOrd {
    /// The numbers with which rows are computed.
    type Read: Number;
    /// Returns a fraction of the graph, of which a system has a number of its own.
    fn of_graph<N: Number>(exact: &Ratio, own: &N) -> Self::Read;
    /// Returns the lower and the upper bound of a number; an infinite one is 0 as a fraction.
    fn read<N: Number>(number: &N) -> (Self::Read, Self::Read);
    /// Returns the lower bound of a number.
    fn of(read: &Self::Read) -> Self;
    /// Returns the double; `None` for a fraction.
    fn double(&self) -> Option<f64>;
}

impl Entry for Ratio {
    type Read = Ratio;

    fn of_graph<N: Number>(exact: &Ratio, _: &N) -> Ratio {
        exact.clone()
    }

    fn read<N: Number>(number: &N) -> (Ratio, Ratio) {
        let Interval { lower, upper } = match number.exact() {
            Some(exact) => return (exact.clone(), exact.clone()),
            None => number.bounds(),
        };
        let exact = |x: f64| Ratio::from_float(x).unwrap_or_default();
        (exact(lower), exact(upper))
    }

    fn of(read: &Ratio) -> Self {
        read.clone()
    }

    fn double(&self) -> Option<f64> {
        None
    }
}

impl Entry for f64 {
    type Read = Interval;

    fn of_graph<N: Number>(_: &Ratio, own: &N) -> Interval {
        own.bounds()
    }

    fn read<N: Number>(number: &N) -> (Interval, Interval) {
        let bounds = number.bounds();
        (bounds.low(), bounds.high())
    }

    fn of(read: &Interval) -> Self {
        read.lower
    }

    fn double(&self) -> Option<f64> {
        Some(*self)
    }
}

/// Returns the amount by which an action of doubles must be better if the groups have these values: more than rounding
/// adds up to.
pub(crate) fn slack(x: &[f64]) -> f64 {
    BETTER * greatest(x)
}

/// Returns the greatest distance from 0.
pub(crate) fn greatest<'x>(x: impl IntoIterator<Item = &'x f64>) -> f64 {
    x.into_iter().fold(0.0, |most, x| x.abs().max(most))
}

/// The equation of a choice.
pub(crate) struct Equation<N> {
    /// The edges to other groups, and the probability to leave the component.
    pub(crate) row: Row<N>,
    /// The bounds of the constant.
    pub(crate) low: N,
    pub(crate) high: N,
    /// True if the row has all edges of the choice: none leads back to its group.
    pub(crate) whole: bool,
    /// The greatest upper bound at an exit; infinite if more is gained or paid. Only for intervals.
    pub(crate) most: f64,
    /// The greatest width of the bounds at an exit. Only for intervals.
    pub(crate) width: f64,
}

impl<N: Number> Equation<N> {
    /// Creates the equation of nothing.
    pub(crate) fn empty() -> Self {
        let row = Row { edges: Vec::new(), escape: N::zero() };
        Equation { row, low: N::zero(), high: N::zero(), whole: true, most: 0.0, width: 0.0 }
    }

    /// Forgets the equation; its memory is used again.
    fn clear(&mut self) {
        let mut edges = std::mem::take(&mut self.row.edges);
        edges.clear();
        *self = Equation { row: Row { edges, ..Equation::empty().row }, ..Equation::empty() };
    }

    /// Adds a gain or cost.
    fn gain(&mut self, gain: &N) {
        if !gain.is_zero() {
            self.pay(gain, gain);
            self.most = f64::INFINITY;
        }
    }

    /// Adds an exit with the bounds of its value.
    fn exit(&mut self, p: N, (low, high): (N, N)) {
        self.pay(&p.times(&low), &p.times(&high));
        self.row.escape = self.row.escape.plus(&p);
        if !N::EXACT {
            let value = Interval { lower: low.bounds().lower, upper: high.bounds().upper };
            self.most = self.most.max(value.upper);
            self.width = self.width.max(value.width());
        }
    }

    fn pay(&mut self, low: &N, high: &N) {
        self.low = self.low.plus(low).low();
        self.high = self.high.plus(high).high();
    }
}

/// Sorts edges, and unites those to the same group.
pub(crate) fn unite<N: Weight>(edges: &mut Vec<(u32, N)>) {
    edges.sort_by_key(|edge| edge.0);
    edges.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 = kept.1.plus(&next.1);
        }
        same
    });
}

/// The nodes of a component and their groups: end components in which the leading side alone chooses.
pub(crate) struct Groups<'n> {
    nodes: &'n [u32],
    /// The position of each node of the graph in `nodes`, or [`NONE`].
    position: &'n [u32],
    /// The choices with which nothing is gained or paid and the component is not left.
    free: Choices,
    /// The number of each of these choices in the graph.
    numbers: Vec<u32>,
    found: EndComponents,
    /// True if both sides together can stay in the component forever without any cost.
    pub(crate) may_rest: bool,
}

impl<'n> Groups<'n> {
    /// Finds the groups of a component. Cost: linear for each round of the search for end components.
    pub(crate) fn new<N: Number>(
        system: &System<'_, N>,
        nodes: &'n [u32],
        position: &'n [u32],
        meter: &mut Meter<'_>,
    ) -> Result<Self> {
        // A node with one choice counts as one of the leading side.
        let leads = |&node: &u32| {
            let mut permitted = system.game.choices(node).filter(|&choice| system.permits(choice));
            system.leads(node) || permitted.nth(1).is_none()
        };
        let leads: BitVec = nodes.iter().map(leads).collect();
        let mut groups = Groups::among(system, (nodes, position), &|index| leads[index], meter)?;
        // For the leading side, only a path without any cost is better than one that ends.
        if !leads.all() && system.quantity.leader() == Optimum::Min {
            let both = Groups::among(system, (nodes, position), &|_| true, meter)?;
            groups.may_rest = both.found.count < groups.found.count;
        }
        Ok(groups)
    }

    /// Finds the end components of the free choices of some nodes.
    fn among<N: Number>(
        system: &System<'_, N>,
        (nodes, position): (&'n [u32], &'n [u32]),
        leads: &dyn Fn(usize) -> bool,
        meter: &mut Meter<'_>,
    ) -> Result<Self> {
        let (mut free, mut numbers) = (Choices::default(), Vec::new());
        // Most successors come first, so most choices into nodes without a free choice are left out at once.
        let mut leaves = vec![false; nodes.len()];
        for (index, &node) in nodes.iter().enumerate() {
            meter.step()?;
            let first = numbers.len();
            for choice in system.game.choices(node).filter(|_| leads(index)) {
                let before = free.to.len();
                if is_free(system, choice, position, &mut free.to)
                    && !free.to[before..].iter().any(|&to| leaves[to as usize])
                {
                    free.end_choice();
                    numbers.push(choice);
                } else {
                    free.to.truncate(before);
                }
            }
            leaves[index] = numbers.len() == first;
            free.end_node();
        }
        let found = match numbers.is_empty() {
            true => {
                let group = (0..nodes.len() as u32).collect();
                EndComponents { group, count: nodes.len(), inside: Vec::new() }
            }
            false => free.end_components(meter)?,
        };
        Ok(Groups { nodes, position, free, numbers, found, may_rest: false })
    }

    /// Returns the number of groups.
    pub(crate) fn count(&self) -> usize {
        self.found.count
    }

    /// Returns the bytes of the groups.
    pub(crate) fn bytes(&self) -> usize {
        self.free.bytes() + 5 * self.numbers.len() + 8 * self.nodes.len()
    }

    /// Returns whether a choice of a node stays in its group for certain.
    fn stays(&self, index: usize, choice: u32) -> bool {
        self.free.of(index as u32).any(|c| self.numbers[c] == choice && self.found.inside[c])
    }

    /// Calls `each` with the group and the choice of every action: the permitted choices
    /// that may leave their group, group by group.
    ///
    /// # Errors
    /// A limit is reached.
    pub(crate) fn visit<N: Number>(
        &self,
        system: &System<'_, N>,
        meter: &mut Meter<'_>,
        mut each: impl FnMut(u32, u32),
    ) -> Result<()> {
        for index in self.by_group() {
            let (node, group) = (self.nodes[index as usize], self.found.group[index as usize]);
            for choice in system.game.choices(node) {
                meter.step()?;
                if system.permits(choice) && !self.stays(index as usize, choice) {
                    each(group, choice);
                }
            }
        }
        Ok(())
    }

    /// Returns the extreme that each group looks for.
    pub(crate) fn optima<N: Number>(&self, system: &System<'_, N>) -> Vec<Optimum> {
        let mut members = vec![0u32; self.count()];
        self.found.group.iter().for_each(|&group| members[group as usize] += 1);
        let mut optima = vec![system.quantity.leader(); self.count()];
        for (&node, &group) in self.nodes.iter().zip(&self.found.group) {
            if members[group as usize] == 1 {
                optima[group as usize] = system.optimum(node);
            }
        }
        optima
    }

    /// Returns the positions of the nodes, ordered by groups.
    fn by_group(&self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.nodes.len() as u32).collect();
        if self.count() < self.nodes.len() {
            order.sort_by_key(|&index| self.found.group[index as usize]);
        }
        order
    }

    /// Returns whether the bounds at all exits of the component are finite.
    pub(crate) fn is_bounded<N: Number>(&self, system: &System<'_, N>, solution: &Solution<N>) -> bool {
        let is_finite = |edge: Edge| match system.end(edge, solution) {
            End::Known(value) => value.is_none_or(|value| value.bounds().upper.is_finite()),
            End::Open(_) => true,
        };
        let permitted = |&choice: &u32| system.permits(choice);
        let choices = self.nodes.iter().flat_map(|&node| system.game.choices(node)).filter(permitted);
        choices.flat_map(|choice| system.game.edges(choice)).all(is_finite)
    }

    /// Returns the group of an open node; `None` outside of the component.
    pub(crate) fn group_of(&self, node: u32) -> Option<u32> {
        let position = self.position[node as usize];
        (position != NONE).then(|| self.found.group[position as usize])
    }

    /// Writes the equation of a choice of a node in the group `own`, with the memory of another equation.
    pub(crate) fn write<N: Number, E: Entry>(
        &self,
        system: &System<'_, N>,
        own: u32,
        choice: u32,
        solution: &Solution<N>,
        equation: &mut Equation<E::Read>,
    ) {
        equation.clear();
        if let Some((exact, own)) = system.exact_gain(choice).zip(system.gain(choice)) {
            equation.gain(&E::of_graph(exact, own));
        }
        for edge in system.game.edges(choice) {
            let at = edge.probability() as usize;
            let p = E::of_graph(&system.game.fractions()[at], &system.fractions[at]);
            let is_bonus = system.bonus(edge);
            match system.end(edge, solution) {
                End::Known(value) => {
                    let (mut low, mut high) =
                        value.map_or_else(|| (E::Read::zero(), E::Read::zero()), E::read);
                    if is_bonus {
                        (low, high) = (low.plus(&E::Read::one()), high.plus(&E::Read::one()));
                    }
                    equation.exit(p, (low, high));
                }
                End::Open(to) => {
                    if is_bonus {
                        equation.gain(&p);
                    }
                    match self.group_of(to) {
                        Some(to) if to == own => equation.whole = false,
                        Some(to) => equation.row.edges.push((to, p)),
                        None => equation.row.escape = equation.row.escape.plus(&p),
                    }
                }
            }
        }
        unite(&mut equation.row.edges);
    }

    /// Stores the values of the groups for their nodes, and the choices that attain them.
    pub(crate) fn store<N: Number>(
        &self,
        system: &System<'_, N>,
        values: &[N],
        picks: &[u32],
        solution: &mut Solution<N>,
    ) {
        for (index, &node) in self.nodes.iter().enumerate() {
            let group = self.found.group[index] as usize;
            if system.game.choices(node).contains(&picks[group]) {
                solution.set_pick(node, picks[group]);
            }
            solution.set(node, values[group].clone());
        }
        if self.count() < self.nodes.len() {
            self.approach(solution);
        }
    }

    /// Lets the other nodes of each group move towards the one that leaves it, in sweeps by turns in both directions.
    fn approach<N: Number>(&self, solution: &mut Solution<N>) {
        let Groups { nodes, free, found, numbers, .. } = self;
        let unknown = |&index: &u32| solution.pick(nodes[index as usize]) == NONE;
        let mut open: Vec<u32> = (0..nodes.len() as u32).filter(unknown).collect();
        let mut before = usize::MAX;
        while open.len() < before {
            before = open.len();
            open.retain(|&index| {
                let known = |&to: &u32| solution.pick(nodes[to as usize]) != NONE;
                let leads =
                    |&choice: &usize| found.inside[choice] && free.successors(choice).iter().any(known);
                let choice = free.of(index).find(leads);
                choice.inspect(|&choice| solution.set_pick(nodes[index as usize], numbers[choice])).is_none()
            });
            open.reverse();
        }
    }
}

/// Returns whether nothing is gained or paid by a choice and it stays in the component; adds its
/// successors to `to`.
fn is_free<N: Number>(system: &System<'_, N>, choice: u32, position: &[u32], to: &mut Vec<u32>) -> bool {
    let paid = system.gain(choice).is_some_and(|gain| !gain.is_zero());
    if paid || !system.permits(choice) {
        return false;
    }
    system.game.edges(choice).all(|edge| {
        let stays = edge.to != LOST && !edge.counts() && position[edge.to as usize] != NONE;
        if stays {
            to.push(position[edge.to as usize]);
        }
        stays
    })
}
