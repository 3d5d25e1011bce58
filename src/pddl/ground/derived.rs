//! Derived facts: each one with the disjunction of its rules.

use super::reach::Reached;
use super::{Atoms, Ground, GroundAtom, Meaning};
use crate::task::Task;
use meliora_base::error::Result;
use meliora_base::progress::{Poll, ProgressSink};

/// Grounds the rules of derived predicates, whose reachable facts get a meaning.
///
/// # Errors
/// A limit.
pub(super) fn ground(
    task: &Task,
    reached: &Reached,
    atoms: &mut Atoms,
    sink: &dyn ProgressSink,
) -> Result<Vec<(GroundAtom, Ground)>> {
    let mut poll = Poll::new(sink);
    let mut all: Vec<GroundAtom> = Vec::new();
    for (number, _) in task.predicates.iter().enumerate().filter(|(_, p)| p.is_derived) {
        for row in reached.rows(number) {
            let meaning = Meaning::Derived(u32::try_from(all.len()).unwrap_or(u32::MAX));
            all.push((number, row.to_vec()));
            atoms.insert(number, row, meaning);
        }
    }
    let mut grounded = Vec::with_capacity(all.len());
    for (predicate, row) in all {
        poll.step()?;
        let fits = |axiom: &&crate::task::Axiom| {
            let mut members = axiom.parameters.iter().zip(&row);
            axiom.predicate == predicate && members.all(|(domain, &object)| domain.member[object as usize])
        };
        let rules = task.axioms.iter().filter(fits);
        let bodies: Vec<Ground> =
            rules.map(|axiom| atoms.ground(&axiom.condition, &mut row.clone())).collect();
        grounded.push(((predicate, row), Ground::join(false, bodies)));
    }
    Ok(grounded)
}
