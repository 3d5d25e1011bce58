//! Success within a number of steps: P_k^n, by iterating the equations of P_k from 0.

use ahash::AHashMap;

use crate::graphs::game_graph::LOST;
use crate::graphs::graph::Graph;
use crate::graphs::meter::Meter;
use meliora_base::error::Result;
use meliora_base::interval::Interval;
use meliora_base::number::Weight;

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
        levels: usize,
        steps: usize,
        starts: &[u32],
        meter: &mut Meter<'_>,
    ) -> Result<()> {
        let nodes = graph.nodes();
        meter.take(2 * (levels + 1) * nodes * size_of::<f64>())?;
        let fractions: Vec<Interval> = graph.fractions().iter().map(Interval::around).collect();
        // Lower bounds by k and node.
        let mut x = vec![vec![1.0; nodes]];
        x.extend((0..levels).map(|_| vec![0.0; nodes]));
        for step in 0..=steps {
            meter.progress(&|| format!("step {step} of {steps}"));
            // Junctions take no step: they follow the other nodes.
            for junctions in if step == 0 { vec![true] } else { vec![false, true] } {
                let before = x.clone();
                for (k, x) in x.iter_mut().enumerate().skip(1) {
                    for node in (0..nodes as u32).filter(|&node| graph.is_junction(node) == junctions) {
                        meter.step()?;
                        let values = graph.choices(node).map(|choice| {
                            graph.edges(choice).filter(|edge| edge.to != LOST).fold(
                                Interval::ZERO,
                                |sum, edge| {
                                    let value = before[k - usize::from(edge.counts())][edge.to as usize];
                                    sum.plus(
                                        &fractions[edge.probability() as usize]
                                            .times(&Interval::point(value)),
                                    )
                                },
                            )
                        });
                        let values = values.map(|value| value.lower);
                        let best = if graph.is_theirs(node) { f64::min } else { f64::max };
                        x[node as usize] = values.reduce(best).unwrap_or(0.0);
                    }
                }
            }
            for (&node, k) in starts.iter().flat_map(|node| (1..=levels).map(move |k| (node, k))) {
                self.curves.entry((node, k)).or_default().push(x[k][node as usize]);
            }
        }
        Ok(())
    }
}
