//! The variable order heuristic for programs whose order of declaration says little, such as
//! networks of flags sorted by name.
//!
//! A relation is evaluated on all levels between its first and its last variable, and a level of a
//! diagram distinguishes the values above it that matter below. The heuristic therefore reduces the
//! total span of two kinds of groups: the variables of each command, and each variable with those
//! that commands change depending on it. The span of a group is the distance between its first and
//! its last variable. Networks need fewer nodes with both kinds than with either alone.
//!
//! FORCE places each variable at the mean place of its groups, and each group at the mean place of
//! its variables, until this no longer helps (Aloul, Markov, Sakallah, FORCE: a fast and
//! easy-to-implement variable-ordering heuristic, GLSVLSI 2003). Then each variable moves to the
//! place with the least total span, as in sifting. The search starts from the declared order and
//! from a few shuffled ones.

use ahash::AHashSet;

use meliora_base::random::Draw;
use meliora_model::expr::Node;
use meliora_model::{Command, Program, VarId};

/// Number of orders from which the search starts, of rounds of FORCE without a smaller span after which it ends, and
/// of rounds of moving each variable once.
const ROUNDS: usize = 10;

/// Maximum number of steps of one round from all starts, and maximum number of nodes of all guards
/// and updates.
const MOST_STEPS: usize = 1 << 25;

/// The order with a short total span, and the total spans.
pub(super) struct Shortened {
    pub(super) variables: Vec<VarId>,
    pub(super) span: usize,
    pub(super) declared: usize,
}

/// Returns an order whose total span is at least a fifth below that of the declared order. Returns
/// `None` if it finds none, if the search would take too long, or if a variable has several bits.
///
/// Programs with integers stay as declared: in the PRISM benchmark suite, spans up to half as long
/// gave larger diagrams more often than smaller ones.
pub(super) fn shortened(program: &Program) -> Option<Shortened> {
    if program.variables.iter().any(|v| v.bits() > 1) {
        return None;
    }
    let hypergraph = Hypergraph::new(program)?;
    // Variables without a group come below all others.
    let (grouped, alone): (Vec<usize>, Vec<usize>) =
        (0..program.variables.len()).partition(|&v| !hypergraph.at[v].is_empty());
    let hypergraph = hypergraph.of_grouped(&grouped);
    let before = hypergraph.span(&Vec::from_iter(0..grouped.len()));
    let (span, order) = hypergraph.shortest()?;
    let order = order.into_iter().map(|v| grouped[v]).chain(alone);
    let variables = order.map(|v| VarId(v as u32)).collect();
    (5 * span <= 4 * before && span < before).then_some(Shortened { variables, span, declared: before })
}

/// The groups of variables that belong close to each other.
struct Hypergraph {
    /// The variables of each group, sorted. Groups with the same variables count once.
    edges: Vec<Vec<usize>>,
    /// The edges of each variable.
    at: Vec<Vec<usize>>,
}

impl Hypergraph {
    /// Creates the hypergraph of a program, unless that takes too long.
    fn new(program: &Program) -> Option<Self> {
        let mut steps = MOST_STEPS;
        let mut edges = Vec::new();
        let mut dependent = vec![AHashSet::new(); program.variables.len()];
        for command in &program.commands {
            let (read, written) = (read(program, command, &mut steps)?, written(command));
            steps = steps.checked_sub(read.len() * written.len())?;
            read.iter().for_each(|&v| dependent[v].extend(&written));
            edges.push([read, written].concat());
        }
        let dependent = dependent.into_iter().enumerate();
        edges.extend(dependent.map(|(v, changed)| changed.into_iter().chain([v]).collect()));
        for edge in &mut edges {
            edge.sort_unstable();
            edge.dedup();
        }
        edges.retain(|edge| edge.len() > 1);
        edges.sort_unstable();
        edges.dedup();
        let mut at = vec![Vec::new(); program.variables.len()];
        for (number, edge) in edges.iter().enumerate() {
            edge.iter().for_each(|&v| at[v].push(number));
        }
        Some(Hypergraph { edges, at })
    }

    /// Returns the hypergraph over these variables, those of all edges, numbered in this order.
    fn of_grouped(&self, variables: &[usize]) -> Hypergraph {
        let place = places_among(self.at.len(), variables);
        let edges = self.edges.iter().map(|edge| edge.iter().map(|&v| place[v]).collect()).collect();
        Hypergraph { edges, at: variables.iter().map(|&v| self.at[v].clone()).collect() }
    }

    /// Returns the order with the least total span from all starts, with this span; `None` if one
    /// start takes too long.
    fn shortest(&self) -> Option<(usize, Vec<usize>)> {
        let variables = self.at.len();
        let each = variables + self.edges.iter().map(Vec::len).sum::<usize>();
        let starts = MOST_STEPS / variables.checked_mul(each)?.max(1);
        let mut draw = Draw::new(0);
        let found = (0..starts.min(ROUNDS)).map(|start| {
            let mut order = Vec::from_iter(0..variables);
            if start > 0 {
                draw.shuffle(&mut order);
            }
            let order = self.moved(self.force(order));
            (self.span(&order), order)
        });
        found.min_by_key(|(span, _)| *span)
    }

    /// Returns the total span of an order.
    fn span(&self, order: &[usize]) -> usize {
        let place = places(order);
        let span = |edge: &Vec<usize>| {
            let places = || edge.iter().map(|&v| place[v]);
            places().max().zip(places().min()).map_or(0, |(last, first)| last - first)
        };
        self.edges.iter().map(span).sum()
    }

    /// Returns the order with the least total span that FORCE finds from the given one.
    fn force(&self, mut order: Vec<usize>) -> Vec<usize> {
        let mut best = (self.span(&order), order.clone());
        let mut since = 0;
        while since < ROUNDS {
            let place = places(&order);
            let centres =
                Vec::from_iter(self.edges.iter().map(|edge| mean(edge.iter().map(|&v| place[v] as f64))));
            let wish = |v: usize| match self.at[v].as_slice() {
                [] => place[v] as f64,
                edges => mean(edges.iter().map(|&e| centres[e])),
            };
            let wishes = Vec::from_iter((0..order.len()).map(wish));
            order.sort_by(|&v, &w| wishes[v].total_cmp(&wishes[w]));
            let span = self.span(&order);
            since += 1;
            if span < best.0 {
                best = (span, order.clone());
                since = 0;
            }
        }
        best.1
    }

    /// Moves each variable to the place with the least total span, until this no longer helps.
    /// Variables of many commands come first.
    fn moved(&self, mut order: Vec<usize>) -> Vec<usize> {
        let mut variables = Vec::from_iter(0..order.len());
        variables.sort_by_key(|&v| std::cmp::Reverse(self.at[v].len()));
        for _ in 0..ROUNDS {
            let before = order.clone();
            for &variable in &variables {
                self.place(&mut order, variable);
            }
            if order == before {
                break;
            }
        }
        order
    }

    /// Moves one variable to the place with the least total span.
    ///
    /// The total span is the sum, over all cuts between neighbours, of the number of edges on both
    /// sides. If the variable comes after the first k others, the cuts before it have it below
    /// them, and the cuts after it have it above them.
    fn place(&self, order: &mut Vec<usize>, variable: usize) {
        let Some(now) = order.iter().position(|&v| v == variable) else { return };
        order.remove(now);
        let below = self.cuts(order, None);
        let above = self.cuts(order, Some(variable));
        let mut total: isize = above.iter().sum();
        let mut totals = vec![total];
        for k in 1..=order.len() {
            total += below[k] - above[k - 1];
            totals.push(total);
        }
        let best = (0..totals.len()).min_by_key(|&k| (totals[k], k.abs_diff(now))).unwrap_or(now);
        order.insert(best, variable);
    }

    /// Returns for each k the number of edges with variables among the first k and with others; a
    /// given variable counts among the first ones.
    fn cuts(&self, order: &[usize], given: Option<usize>) -> Vec<isize> {
        let mut inside = vec![0; self.edges.len()];
        let mut cut = 0;
        let mut add = |variable: usize| {
            for &edge in &self.at[variable] {
                cut += isize::from(inside[edge] == 0);
                inside[edge] += 1;
                cut -= isize::from(inside[edge] == self.edges[edge].len());
            }
            cut
        };
        let first = given.map_or(0, &mut add);
        std::iter::once(first).chain(order.iter().map(|&v| add(v))).collect()
    }
}

/// Returns the place of each variable in an order.
fn places(order: &[usize]) -> Vec<usize> {
    places_among(order.len(), order)
}

/// Returns the place of each variable in an order of some of them; 0 for the others.
fn places_among(variables: usize, order: &[usize]) -> Vec<usize> {
    let mut places = vec![0; variables];
    order.iter().enumerate().for_each(|(place, &v)| places[v] = place);
    places
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

/// Returns the variables that a command reads. Returns `None` if that takes more than the remaining
/// steps.
fn read(program: &Program, command: &Command, steps: &mut usize) -> Option<Vec<usize>> {
    let mut all = Vec::new();
    let (mut stack, mut seen) = (vec![command.guard], AHashSet::new());
    for branch in &command.branches {
        stack.push(branch.probability);
        stack.extend(branch.updates.iter().map(|(_, e)| *e));
    }
    while let Some(e) = stack.pop() {
        if seen.insert(e) {
            *steps = steps.checked_sub(1)?;
            match program.pool.node(e) {
                Node::Var(v) => all.push(v.index()),
                _ => stack.extend(program.pool.operands(e)),
            }
        }
    }
    Some(all)
}

/// Returns the variables that a command changes.
fn written(command: &Command) -> Vec<usize> {
    let updates = command.branches.iter().flat_map(|branch| &branch.updates);
    updates.map(|(variable, _)| variable.index()).collect()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use meliora_base::error::SourceFile;
    use meliora_lang as lang;

    fn hypergraph(size: usize, edges: Vec<Vec<usize>>) -> Hypergraph {
        let mut at = vec![Vec::new(); size];
        for (number, edge) in edges.iter().enumerate() {
            edge.iter().for_each(|&v| at[v].push(number));
        }
        Hypergraph { edges, at }
    }

    #[test]
    fn variables_without_a_group_cost_nothing_and_come_last() {
        let others: String = (0..5000).map(|i| format!("z{i}:bool;")).collect();
        let text = format!(
            "mdp module m a:bool; {others} b:bool; c:bool; d:bool; e:bool; [] a & e -> (a'=false); \
                            [] b & c -> (b'=false); [] d & e -> (d'=false); endmodule"
        );
        let none = SourceFile::new("constants", "");
        let program = lang::load(&SourceFile::new("m", text), &none).unwrap().program;
        let found = shortened(&program).unwrap();
        let names: Vec<&str> =
            found.variables.iter().map(|v| program.variables[v.index()].name.as_str()).collect();
        assert_eq!((found.declared, found.span), (10, 5));
        assert_eq!((names.len(), names[5], names[5004]), (5005, "z0", "z4999"));
    }

    #[test]
    fn groups_are_the_variables_of_commands_and_a_variable_with_those_that_depend_on_it() {
        let text = "mdp module network a : bool; b : bool; c : bool; d : bool;\n\
                    [] a != b -> (b'=a); [] a != c -> (c'=a); [] c & d -> (d'=false); endmodule";
        let none = SourceFile::new("constants", "");
        let program = lang::load(&SourceFile::new("m", text), &none).unwrap().program;
        let edges = Hypergraph::new(&program).unwrap().edges;
        // Flag a with its commands' flags b and c; flag c with itself and d, as the third command.
        assert_eq!(edges, [vec![0, 1], vec![0, 1, 2], vec![0, 2], vec![2, 3]]);
    }

    proptest! {
        #[test]
        fn a_variable_moves_to_the_place_with_the_least_span(
            edges in prop::collection::btree_set(prop::collection::btree_set(0..8_usize, 2..5), 1..12),
            variable in 0..8_usize,
        ) {
            let graph = hypergraph(8, edges.into_iter().map(|e| e.into_iter().collect()).collect());
            let mut order = Vec::from_iter(0..8);
            graph.place(&mut order, variable);
            let spans = (0..8).map(|place| {
                let mut other = order.clone();
                other.retain(|&v| v != variable);
                other.insert(place, variable);
                graph.span(&other)
            });
            prop_assert_eq!(graph.span(&order), spans.min().unwrap());
        }

        #[test]
        fn no_single_move_shortens_the_span_found(
            edges in prop::collection::btree_set(prop::collection::btree_set(0..8_usize, 2..5), 1..12),
        ) {
            let graph = hypergraph(8, edges.into_iter().map(|e| e.into_iter().collect()).collect());
            let forced = graph.force(Vec::from_iter(0..8));
            prop_assert!(graph.span(&forced) <= graph.span(&Vec::from_iter(0..8)));
            let found = graph.moved(forced.clone());
            prop_assert!(graph.span(&found) <= graph.span(&forced));
            for variable in 0..8 {
                let mut other = found.clone();
                graph.place(&mut other, variable);
                prop_assert_eq!(graph.span(&other), graph.span(&found));
            }
        }
    }
}
