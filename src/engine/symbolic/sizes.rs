//! The sizes of diagrams, and the number of transitions.

use super::encoding::transitions::Piece;
use super::relations::partial_relation::PartialRelation;
use super::store::diagram::Bdd;
use super::{StateSet, SymbolicEngine};
use crate::settings::Count;
use meliora_base::error::Result;

/// The sizes of the diagrams of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DiagramSizes {
    /// The sum of the nodes of all partial relations.
    pub transition: usize,
    /// The nodes of the set of states.
    pub states: usize,
    /// The number of groups of choices.
    pub groups: usize,
}

impl SymbolicEngine {
    /// Returns the sizes of the diagrams.
    pub fn sizes(&self) -> Result<DiagramSizes> {
        let relations = self.transitions.pieces.iter().map(|p| self.store.size(&p.steps.relation));
        Ok(DiagramSizes {
            transition: relations.sum::<Result<_>>()?,
            states: self.store.size(&self.states.0)?,
            groups: self.transitions.guards.len(),
        })
    }

    /// Returns true if the diagram of a set has at least `many` nodes, constants included. Visits
    /// at most `many` nodes.
    ///
    /// # Errors
    /// The set belongs to another engine.
    pub fn has_nodes(&self, x: &StateSet, many: usize) -> Result<bool> {
        self.store.has_nodes(self.diagram_of(x)?, many)
    }

    /// Returns the number of inner nodes of the diagram of a set.
    ///
    /// # Errors
    /// The set belongs to another engine.
    pub fn size(&self, x: &StateSet) -> Result<usize> {
        self.store.size(self.diagram_of(x)?)
    }

    /// Returns the number of triples of one piece with the source in C and the target in X (`None`:
    /// any target).
    pub(super) fn count_piece(&self, piece: &Piece, c: &Bdd, x: Option<&Bdd>) -> Result<Count> {
        let PartialRelation { relation, support } = &piece.steps;
        let unused = (self.encoding.width() - support.len()) as u32;
        match x {
            None => self.store.count_common(relation, c, unused),
            Some(x) => {
                let allowed = self.store.and(relation, c)?;
                self.store.count_common(&allowed, &self.store.primed(support, x)?, unused)
            }
        }
    }
}
