//! From a finished analysis to the graph of the solver: the states that kept choices reach from the
//! states asked for.
//!
//! States from which no improvement is possible have the values 0; they are not explored further.
//!
//! Nodes are numbered in the order in which they are found: a breadth-first search. It works in rounds: several
//! threads list the choices of nodes that follow each other, then the graph gets these in the order of the nodes. So
//! the numbers do not depend on the number of threads.

use std::ops::Range;
use std::panic::resume_unwind;
use std::thread;

use crate::equations::cost::Cost;
use crate::equations::facts::Facts;
use crate::equations::graph::{Edge, Graph, NONE};
use crate::equations::listing::{Lister, Missing, Rules, To, View};
use crate::equations::meter::Meter;
use crate::equations::places::{Place, Places};
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_engine::explicit::weighted::Walker;
use meliora_model::State;

/// The greatest number of nodes of a list, and the number of edges after which it ends.
const NODES: usize = 1 << 12;
const EDGES: usize = 1 << 18;
/// The stack of a thread, in bytes: recursion is as deep as expressions.
const STACK: usize = 512 << 20;

/// The work of a thread: its list, and the number in the graph of each of its fractions, or [`NONE`].
struct Worker<'w> {
    lister: Lister<'w>,
    numbers: Vec<u32>,
}

/// The exploration of a graph.
pub(crate) struct Explorer<'a, 'm, E: Engine> {
    rules: Rules<'a, E>,
    graph: &'a mut Graph,
    places: &'a mut Places,
    meter: &'a mut Meter<'m>,
    /// The greatest number of nodes of a list, and the number of edges after which it ends.
    most: (usize, usize),
}

impl<'a, 'm, E: Engine> Explorer<'a, 'm, E> {
    /// Starts to explore a graph.
    ///
    /// # Errors
    /// The states need more than 2048 bits; a limit is reached.
    pub(crate) fn new(
        facts: &'a Facts<'a, E>,
        costs: &'a dyn Cost,
        graph: &'a mut Graph,
        places: &'a mut Places,
        meter: &'a mut Meter<'m>,
    ) -> Result<Self> {
        let rules = Rules::new(facts, costs)?;
        *places = Places::new(rules.codec.clone(), facts.improvement.arenas.len() as u32);
        Ok(Explorer { rules, graph, places, meter, most: (NODES, EDGES) })
    }

    /// Adds the node of a state in its own arena; `None` for states without a class: unsafe states
    /// have no values.
    pub(crate) fn start(&mut self, state: &State) -> Result<Option<u32>> {
        let seen = self.rules.seen(state)?;
        let class = self.rules.facts.class(seen, None)?;
        if class.is_none() {
            return Ok(None);
        }
        let code = self.rules.codec.known(state)?;
        let place = Place::of(self.rules.facts.arena_of(class));
        match self.places.find_code(place, &code) {
            Some(known) => Ok(Some(known)),
            None => self.add(self.rules.missing(place, seen, class)?, &code).map(Some),
        }
    }

    /// Does the same as [`Explorer::start`] for all states with a class, which are listed class by
    /// class and level by level, so that no state is tested for membership. Returns the number of
    /// nodes.
    pub(crate) fn start_everywhere(&mut self) -> Result<u32> {
        let facts = self.rules.facts;
        for (class, states) in (0..).zip(&facts.classes.list).map(|(number, class)| (number, &class.states)) {
            self.start_class(Some(class), states.clone())?;
        }
        self.meter.number(self.graph.nodes())
    }

    fn start_class(&mut self, class: Option<u32>, states: E::States) -> Result<()> {
        let facts = self.rules.facts;
        let (engine, number) = (facts.engine, facts.arena_of(class));
        let all = engine.all_states();
        let restricted = number.map_or(&all, |number| &facts.restricted[number as usize]);
        for (part, rank) in facts.ranked(number, states)? {
            let free = engine.difference(&part, restricted)?;
            let restricted = engine.intersection(&part, restricted)?;
            for (part, unrestricted) in [(free, true), (restricted, false)] {
                let missing = Missing { place: Place::of(number), class, rank, unrestricted };
                for state in engine.list_states(&part, usize::MAX)? {
                    let code = self.rules.codec.known(&state)?;
                    self.add(missing, &code)?;
                }
            }
        }
        Ok(())
    }

    /// Adds the node of a state that is not known.
    fn add(&mut self, missing: Missing, code: &[u64]) -> Result<u32> {
        let Missing { place, class, rank, unrestricted } = missing;
        let node = self.graph.add_node(rank, place.junction, self.meter)?;
        let own = place.arena == self.rules.facts.arena_of(class);
        self.places.add(place, code, (class, own, unrestricted), self.meter)?;
        Ok(node)
    }

    /// Explores all nodes that the nodes so far reach.
    ///
    /// # Errors
    /// A limit is reached, or a command or a cost has no meaning in some state.
    pub(crate) fn run(&mut self) -> Result<()> {
        let settings = self.rules.facts.engine.settings();
        let walker = Walker::new(self.rules.facts.program, &*settings.sink)?;
        let few = settings.thresholds.nodes_for_threads;
        let most = settings.threads.max(1) as usize;
        let (mut workers, mut next, mut bytes): (Vec<Worker<'_>>, _, _) = (Vec::new(), 0, 0);
        while next < self.graph.nodes() {
            let open = self.graph.nodes() - next;
            let threads = if open < few { 1 } else { most };
            while workers.len() < threads {
                let lister = Lister::new(walker.walk(), self.rules.cost.clone(), &*settings.sink);
                workers.push(Worker { lister, numbers: Vec::new() });
            }
            let size = self.most.0.min(open.div_ceil(threads));
            let begin = |at: usize| (next + at * size).min(next + open) as u32;
            let ranges: Vec<Range<u32>> = (0..threads).map(|at| begin(at)..begin(at + 1)).collect();
            let view = View { rules: &self.rules, graph: self.graph, places: self.places };
            let ends = side_by_side(&view, &ranges, self.most.1, &mut workers);
            next = self.append(&ranges, ends, &mut workers)? as usize;
            self.meter.release(bytes);
            bytes = workers.iter().map(|worker| worker.lister.bytes()).sum();
            self.meter.take(bytes)?;
        }
        self.meter.release(bytes);
        self.places.end_exploration();
        Ok(())
    }

    /// Adds what threads have listed, up to the first node that is in no list. Returns this node.
    ///
    /// # Errors
    /// A limit is reached, or one of the lists ended with an error.
    fn append(
        &mut self,
        ranges: &[Range<u32>],
        ends: Vec<Result<()>>,
        workers: &mut [Worker<'_>],
    ) -> Result<u32> {
        let mut next = ranges.first().map_or(0, |range| range.start);
        for ((range, end), worker) in ranges.iter().zip(ends).zip(workers) {
            if next == range.start {
                self.append_list(range.start, worker, Some(range) == ranges.first())?;
                next += worker.lister.nodes.len() as u32;
                end?;
            }
            worker.lister.clear();
        }
        Ok(next)
    }

    /// Adds the choices of the nodes of a list, the first of which is given. The nodes that are missing there are
    /// new if `are_new`.
    fn append_list(
        &mut self,
        first: u32,
        Worker { lister, numbers }: &mut Worker<'_>,
        are_new: bool,
    ) -> Result<()> {
        let mut added = Vec::with_capacity(lister.missing.len());
        for (position, missing) in lister.missing.iter().enumerate() {
            let code = lister.code(position);
            let known = if are_new { None } else { self.places.find_code(missing.place, code) };
            added.push(match known {
                Some(node) => node,
                None => self.add(*missing, code)?,
            });
        }
        let fractions = lister.fractions.list();
        numbers.resize(fractions.len(), NONE);
        let mut number_of = |graph: &mut Graph, own: u32| {
            let number = &mut numbers[own as usize];
            if *number == NONE {
                *number = graph.fraction(fractions[own as usize].clone());
            }
            *number
        };
        let (mut choice, mut edge) = (0, 0);
        for (node, &until) in (first..).zip(&lister.nodes) {
            let nodes = self.graph.nodes();
            self.meter.progress_at(node as usize, &|| format!("{nodes} states"));
            let choices = &lister.choices[choice..until as usize];
            choice = until as usize;
            if choices.is_empty() {
                continue;
            }
            self.graph.begin(node, self.meter)?;
            for &(position, cost, until) in choices {
                let cost = number_of(self.graph, cost);
                self.graph.add_choice(position, cost);
                for &(to, probability, counts) in &lister.edges[edge..until as usize] {
                    let to = match to {
                        To::Node(node) => node,
                        To::Missing(position) => added[position as usize],
                    };
                    let probability = number_of(self.graph, probability);
                    self.graph.add_edge(Edge::new(to, probability, counts));
                }
                edge = until as usize;
            }
            self.graph.end(node, self.meter)?;
        }
        Ok(())
    }
}

/// Lets each worker list the choices of its range of nodes, the first one on this thread. `most` is the number of edges
/// after which a list ends. Returns how each list ended.
fn side_by_side<E: Engine>(
    view: &View<'_, '_, E>,
    ranges: &[Range<u32>],
    most: usize,
    workers: &mut [Worker<'_>],
) -> Vec<Result<()>> {
    thread::scope(|scope| {
        let mut jobs = ranges.iter().cloned().zip(workers);
        let first = jobs.next();
        let others = jobs.map(|(range, worker)| {
            let work = move || view.list(range, most, &mut worker.lister);
            thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work)
        });
        let threads: Vec<_> = others.collect();
        let mut ends: Vec<Result<()>> =
            first.into_iter().map(|(range, worker)| view.list(range, most, &mut worker.lister)).collect();
        // If the system grants no thread, the list is empty, and its nodes belong to the next round.
        let ended = threads.into_iter().map(|thread| match thread {
            Ok(thread) => thread.join().unwrap_or_else(|panic| resume_unwind(panic)),
            Err(_) => Ok(()),
        });
        ends.extend(ended);
        ends
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::equations::cost::{Earned, Steps};
    use meliora_base::error::SourceFile;
    use meliora_engine::symbolic::Thresholds;
    use meliora_engine::{AnyEngine, Settings, Storage};
    use meliora_lang as lang;
    use meliora_planning::{Analysis, Options, Safety};

    /// Two gambles, each of which makes a better objective possible, and a battery.
    const MODEL: &str = "mdp module m x:[0..9] init 4; y:[0..9] init 4; b:[0..15] init 15; k:[0..2]; j:[0..2];
        [t] b>0 & k=0 -> 0.3:(k'=1) + 0.7:(k'=2); [u] b>0 & j=0 -> 0.5:(j'=1)&(b'=b-1) + 0.5:(j'=2)&(b'=b-1);
        [n] b>0 & y<9 -> 0.9:(y'=y+1)&(b'=b-1) + 0.1:(b'=b-1); [s] b>0 & y>0 -> (y'=y-1)&(b'=b-1);
        [e] b>0 & x<9 -> 1-x/99:(x'=x+1)&(b'=b-1) + x/99:(b'=b-1); [w] b>0 & x>0 -> (x'=x-1)&(b'=x=1&y=1?15:b-1);
        [] b=0 -> true; endmodule
        rewards \"r\" [n] true: y/7; [s] true: 1; [e] true: 1; [w] true: 2; endrewards";
    const PREFERENCES: &str = "objective A = F x=0&y=0&k=1; objective B = F x=0&y=0;
        objective C = F x=0&y=0&k=1&j=1; prefer A > B; prefer C > A; empty = bottom;";

    /// Returns all that an exploration finds, node by node.
    fn explored(
        threads: u32,
        safety: Safety,
        storage: Storage,
        most: (usize, usize),
        paid: bool,
    ) -> Vec<String> {
        let none = SourceFile::new("constants", "");
        let mut program = lang::load(&SourceFile::new("model", MODEL), &none).unwrap().program;
        let preferences = SourceFile::new("preferences", PREFERENCES);
        let preferences = lang::load_preferences(&preferences, &mut program).unwrap();
        let program = Arc::new(program);
        let thresholds = Thresholds { nodes_for_threads: 0, ..Thresholds::default() };
        let settings = Settings { threads, storage, thresholds, ..Settings::default() };
        let engine = Arc::new(AnyEngine::new(Arc::clone(&program), settings).unwrap());
        let options = Options { safety, max_level: None };
        let mut analysis = Analysis::new(&engine, &Arc::new(preferences), options);
        analysis.run(&mut |_| ()).unwrap();
        let facts = Facts::new(&analysis, &program, 3).unwrap();
        let (mut graph, mut places, mut meter) = (Graph::default(), Places::default(), Meter::new(&*engine));
        let earned = Earned { program: &program, structure: &program.rewards[0] };
        let costs: &dyn Cost = if paid { &earned } else { &Steps };
        let mut explorer = Explorer::new(&facts, costs, &mut graph, &mut places, &mut meter).unwrap();
        explorer.most = most;
        assert_eq!(explorer.start(&vec![4, 4, 15, 0, 0]).unwrap(), Some(0));
        explorer.run().unwrap();
        drop(explorer);
        let choice = |node: u32, choice: u32| {
            let edges: Vec<_> = graph.edges(choice).collect();
            format!(
                "{} {} {edges:?}",
                graph.position(node, choice),
                graph.fractions()[graph.cost(choice) as usize]
            )
        };
        let node = |node: u32| {
            let choices: Vec<_> = graph.choices(node).map(|own| choice(node, own)).collect();
            let known = (places.state(node), places.arena(node), places.class(node), graph.rank(node));
            let marks = (places.own[node as usize], places.unrestricted[node as usize]);
            format!("{known:?} {marks:?} {} {choices:?}", graph.is_junction(node))
        };
        (0..graph.nodes() as u32).map(node).collect()
    }

    #[test]
    fn nodes_have_the_same_numbers_with_each_number_of_threads() {
        let all = (NODES, EDGES);
        for (&safety, &storage) in Safety::ALL.iter().flat_map(|s| Storage::ALL.iter().map(move |t| (s, t))) {
            let expected = explored(1, safety, storage, all, storage == Storage::Explicit);
            assert!(expected.len() > 1000, "{safety}: {}", expected.len());
            for (threads, most) in [(2, all), (5, all), (1, (7, 3)), (3, (40, 30)), (2, (1, 1))] {
                let found = explored(threads, safety, storage, most, storage == Storage::Explicit);
                assert!(found == expected, "{safety}, {storage:?}, {threads} threads, {most:?}");
            }
        }
    }
}
