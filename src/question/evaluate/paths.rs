//! Regions of formulas on paths.

use super::Evaluator;
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_engine::regions::{Which, deciding};
use meliora_engine::until::{self, Bounds, Until};
use meliora_lang::property::term::{Measure, Measured, Path, Single, Step, Term, TermKind};
use meliora_quantities::sought::needed;

/// A formula with at most one temporal operator over sets of states.
enum Sets<S> {
    Now(S),
    Next(S),
    Until(S, S, Bounds),
}

impl<E: Engine> Evaluator<'_, '_, E> {
    /// Returns the engine of a game in which the players of an operator are ours.
    pub(super) fn played(&self, measured: &Measured) -> Result<Option<E>> {
        let other = measured.coalition.as_ref().filter(|coalition| **coalition != self.engine.coalition());
        other.map(|coalition| self.engine.with_coalition(coalition)).transpose()
    }

    /// Returns the regions that a property needs which is one operator for a probability, in the order of
    /// their usual cost; none for other properties.
    pub(super) fn regions(&self, term: &Term) -> Result<Vec<(Which, E::States)>> {
        let TermKind::Operator(measured) = &term.kind else { return Ok(Vec::new()) };
        let Measure::Probability(path) = &measured.measure else { return Ok(Vec::new()) };
        let needed = match measured.qualitative() {
            Some((strategies, likely)) => vec![deciding(strategies, likely).0],
            None => needed(false, measured.optimum).to_vec(),
        };
        let mut order = Vec::new();
        for which in needed {
            let chain = std::iter::successors(Some(which), |which| self.basis(*which));
            let missing: Vec<Which> = chain.take_while(|which| !order.contains(which)).collect();
            order.extend(missing.into_iter().rev());
        }
        order.into_iter().map(|which| Ok((which, self.region(term, measured, which, path)?))).collect()
    }

    /// Returns the region that is computed before another one, so that the reports have both.
    fn basis(&self, which: Which) -> Option<Which> {
        match which {
            Which::PminPositive if self.engine.is_markov_chain() => Some(Which::PmaxPositive),
            Which::PminOne if self.engine.is_markov_chain() => Some(Which::PmaxOne),
            _ if self.engine.is_game() => None,
            Which::PmaxOne => Some(Which::PmaxPositive),
            Which::PminPositive => Some(Which::PminOne),
            _ => None,
        }
    }

    /// Returns whether a property that is decided by one of its regions holds in the initial states; `None`
    /// for other properties.
    pub(super) fn qualitative(&self, term: &Term, regions: &[(Which, E::States)]) -> Result<Option<bool>> {
        let TermKind::Operator(measured) = &term.kind else { return Ok(None) };
        let Some((strategies, likely)) = measured.qualitative() else { return Ok(None) };
        let (which, inside) = deciding(strategies, likely);
        let Some((_, region)) = regions.iter().find(|(known, _)| *known == which) else { return Ok(None) };
        let initial = self.engine.initial_states();
        let violating = match inside {
            true => self.engine.difference(&initial, region)?,
            false => self.engine.intersection(&initial, region)?,
        };
        self.engine.is_empty(&violating).map(Some)
    }

    /// Returns a region of a formula, over all states.
    pub(super) fn region(
        &self,
        term: &Term,
        measured: &Measured,
        which: Which,
        path: &Path,
    ) -> Result<E::States> {
        let Some(single) = &path.single else {
            let product = self.product(term, path, measured.coalition.as_ref())?;
            return self.region_of_product(&product, which);
        };
        let played = self.played(measured)?;
        self.region_of_single(played.as_ref().unwrap_or(self.engine), which, single)
    }

    /// Returns a region of a formula with one operator. That of a negation is the rest of another one.
    pub(super) fn region_of_single(&self, engine: &E, which: Which, single: &Single) -> Result<E::States> {
        let sets = self.sets(&single.step)?;
        let region = |which: Which| match &sets {
            Sets::Now(now) => Ok(now.clone()),
            Sets::Next(target) => until::next(engine, which, target),
            Sets::Until(through, target, bounds) => {
                until::until(engine, which, Until { through, target, bounds: *bounds })
            }
        };
        let other = match which {
            _ if !single.negated => return region(which),
            Which::PmaxOne => Which::PminPositive,
            Which::PmaxPositive => Which::PminOne,
            Which::PminOne => Which::PmaxPositive,
            Which::PminPositive => Which::PmaxOne,
        };
        engine.difference(&engine.all_states(), &region(other)?)
    }

    fn sets(&self, step: &Step) -> Result<Sets<E::States>> {
        let all = self.engine.all_states();
        Ok(match step {
            Step::Now(now) => Sets::Now(self.states(now, &all)?),
            Step::Next(target) => Sets::Next(self.states(target, &all)?),
            Step::Until { left, right, least, most } => {
                let through = match left {
                    Some(left) => self.states(left, &all)?,
                    None => all.clone(),
                };
                let bounds = Bounds { least: *least, most: *most };
                Sets::Until(through, self.states(right, &all)?, bounds)
            }
        })
    }

    /// Returns the states of which every path, or some path, satisfies a formula.
    pub(super) fn states_of_paths(&self, term: &Term, all: bool, path: &Path) -> Result<E::States> {
        let Some(Single { negated, step }) = &path.single else {
            return self.paths_of_product(term, all, path);
        };
        let engine = self.engine;
        let found = match self.sets(step)? {
            Sets::Now(now) => now,
            Sets::Next(target) => until::next_on_paths(engine, all != *negated, &target)?,
            Sets::Until(through, target, bounds) => {
                let formula = Until { through: &through, target: &target, bounds };
                until::until_on_paths(engine, all != *negated, formula)?
            }
        };
        if *negated { engine.difference(&engine.all_states(), &found) } else { Ok(found) }
    }
}
