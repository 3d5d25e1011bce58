//! Success within a number of steps: P_k^n, by iterating the equations of P_k from 0.

use ahash::AHashMap;

use crate::equations::graph::{Edge, Graph, LOST};
use crate::equations::meter::Meter;
use crate::equations::number::Interval;
use meliora_base::error::Result;

/// The curves of some nodes.
#[derive(Debug, Default)]
pub(crate) struct Horizon {
    /// P_k^0, P_k^1, … by node and k.
    curves: AHashMap<(u32, usize), Vec<f64>>,
}

impl Horizon {
    /// Returns the curve of a node for k improvements, as far as it is known.
    pub(crate) fn curve(&self, node: u32, k: usize) -> Option<&[f64]> {
        self.curves.get(&(node, k)).map(Vec::as_slice)
    }

    /// Computes the curves of some nodes up to `steps`. Cost: one pass over the graph per step and
    /// level.
    ///
    /// # Errors
    /// A limit is reached; the curves end there.
    pub(crate) fn run(
        &mut self,
        graph: &Graph,
        (levels, steps): (usize, usize),
        starts: &[u32],
        meter: &mut Meter<'_>,
    ) -> Result<()> {
        meter.take(2 * (levels + 1) * graph.nodes() * size_of::<f64>())?;
        let probabilities: Vec<f64> = graph.fractions().iter().map(|p| Interval::around(p).lower).collect();
        let mut x = vec![vec![1.0; graph.nodes()]];
        x.extend((0..levels).map(|_| vec![0.0; graph.nodes()]));
        let mut table = Table { graph, probabilities, x };
        table.settle(meter)?;
        self.note(&table, levels, starts);
        for step in 1..=steps {
            meter.progress(&|| format!("step {step} of {steps}"));
            table.step(meter)?;
            self.note(&table, levels, starts);
        }
        Ok(())
    }

    fn note(&mut self, table: &Table<'_>, levels: usize, starts: &[u32]) {
        for &node in starts {
            for k in 1..=levels {
                self.curves.entry((node, k)).or_default().push(table.x[k][node as usize]);
            }
        }
    }
}

/// Lower bounds of P_k^n for one n, by k and node.
struct Table<'g> {
    graph: &'g Graph,
    probabilities: Vec<f64>,
    x: Vec<Vec<f64>>,
}

impl Table<'_> {
    /// Goes from n to n + 1.
    fn step(&mut self, meter: &mut Meter<'_>) -> Result<()> {
        let mut next = vec![self.x[0].clone()];
        for k in 1..self.x.len() {
            let mut values = vec![0.0; self.graph.nodes()];
            for node in 0..self.graph.nodes() as u32 {
                meter.step()?;
                if !self.graph.is_junction(node) {
                    values[node as usize] = self.best(node, k);
                }
            }
            next.push(values);
        }
        self.x = next;
        self.settle(meter)
    }

    /// Computes the values of junctions, which take no step.
    fn settle(&mut self, meter: &mut Meter<'_>) -> Result<()> {
        for k in 1..self.x.len() {
            for node in 0..self.graph.nodes() as u32 {
                meter.step()?;
                if self.graph.is_junction(node) {
                    self.x[k][node as usize] = self.best(node, k);
                }
            }
        }
        Ok(())
    }

    fn best(&self, node: u32, k: usize) -> f64 {
        self.graph.choices(node).map(|choice| self.value(choice, k)).fold(0.0, f64::max)
    }

    fn value(&self, choice: u32, k: usize) -> f64 {
        let term = |edge: Edge| match edge.to {
            LOST => 0.0,
            to => {
                let (p, x) = (
                    self.probabilities[edge.probability() as usize],
                    self.x[k - usize::from(edge.counts())][to as usize],
                );
                // Products with 1 and 0 are exact; all others are rounded down.
                if p == 1.0 || x == 1.0 || x == 0.0 { p * x } else { (p * x).next_down().max(0.0) }
            }
        };
        let terms = self.graph.edges(choice).map(term);
        terms.fold(0.0, |sum, x| {
            if sum == 0.0 {
                x
            } else if x == 0.0 {
                sum
            } else {
                (sum + x).next_down()
            }
        })
    }
}
