//! The prospects of states: their most preferred objectives, ranks and permitted actions.

use super::improvement::Improvement;
use super::levels::{Kind, Levels, Rank};
use super::result::{Escape, Plan, Prospects};
use super::run::Analysis;
use super::safety::Safety;
use super::winning_regions::ObjectiveRegions;
use crate::strategies::strategy;
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_model::step::Choice;
use meliora_model::valuation::Valuation;
use meliora_model::{Program, State, fault};

impl<E: Engine> Analysis<E> {
    /// Returns the prospects of a state of the scope, as far as they are known.
    ///
    /// At states of unknown rank, the actions are those of the greatest level found. Cost: that of
    /// [`strategy::winning_choices`] for the state alone.
    ///
    /// # Errors
    /// A limit of the engine is reached, or a command has no meaning in the state.
    pub fn prospects(&self, program: &Program, state: &[i64]) -> Result<Prospects> {
        let choices = program.choices(state).map_err(|fault| fault::error(program, &fault, state))?;
        let most_preferred = self.most_preferred(state)?;
        let names = |set: &_| self.preferences().owned_names(set);
        let engine = self.whole_engine();
        let is_theirs = match engine.theirs() {
            Some(theirs) => engine.contains(&theirs, state)?,
            None => false,
        };
        // The opponent's moves are neither permitted nor forbidden.
        let choices = if is_theirs { Vec::new() } else { choices };
        Ok(Prospects {
            state: state.to_vec(),
            owner: is_theirs.then_some("opponent"),
            values: Valuation::new(program, state),
            escape: self.escape(program, state)?,
            sure: self.sure(state)?,
            possible: self.objectives_at(state, |regions| &regions.positive)?,
            most_preferred: most_preferred.into_iter().map(str::to_owned).collect(),
            jointly: match self.joint() {
                Some(joint) => joint.of_state(self, state)?.map(|sets| sets.iter().map(names).collect()),
                None => None,
            },
            sasi: self.plan(Kind::Sasi, state, &choices)?,
            spi: self.plan(Kind::Spi, state, &choices)?,
        })
    }

    /// Returns the prospects of the first `limit` initial states. Cost: that of
    /// [`Analysis::prospects`] per state.
    ///
    /// # Errors
    /// The errors of [`Analysis::prospects`].
    pub fn initial_prospects(&self, program: &Program, limit: usize) -> Result<Vec<Prospects>> {
        let engine = self.engine();
        let states: Vec<State> = engine.list_states(&engine.initial_states(), limit)?;
        states.iter().map(|state| self.prospects(program, state)).collect()
    }

    /// Returns a shortest path from an unsafe state to the violation of a requirement; `None` for
    /// other states, and before the requirements are known. Cost: see `Requirements::escape`.
    ///
    /// # Errors
    /// The errors of `Requirements::escape`.
    pub fn escape(&self, program: &Program, state: &[i64]) -> Result<Option<Escape>> {
        let Some(requirements) = self.requirements() else { return Ok(None) };
        requirements.escape(self.whole_engine(), program, &self.preferences().requirements, state)
    }

    /// Returns the ranks [SASI, SPI] of states under another safety mode, with the classes of this analysis;
    /// empty before they are known. Cost: that of [`Improvement::new`] and of all levels.
    ///
    /// # Errors
    /// A limit of the engine is reached.
    pub fn ranks_under(&self, safety: Safety, states: &[State]) -> Result<Vec<[Rank; 2]>> {
        let Some(classes) = self.classes() else { return Ok(Vec::new()) };
        let engine = self.engine();
        let improvement = Improvement::new(engine, classes, safety)?;
        let mut both = [Kind::Sasi, Kind::Spi].map(Levels::new);
        for levels in &mut both {
            while levels.advance(engine, classes, &improvement, self.options().max_level)? {}
        }
        let ranks = |state: &State| {
            let [sasi, spi] = &both;
            Ok([sasi.rank(engine, state)?, spi.rank(engine, state)?])
        };
        states.iter().map(ranks).collect()
    }

    /// Returns the names of the objectives in Out(s), which some strategy achieves almost surely from a
    /// state; `None` before all regions are known. Cost: no image.
    ///
    /// # Errors
    /// The errors of [`Engine::contains`].
    pub fn sure(&self, state: &[i64]) -> Result<Option<Vec<String>>> {
        self.objectives_at(state, |regions| &regions.almost_sure)
    }

    /// Returns the names of the objectives of which a region contains the state; `None` before all
    /// regions are known. Cost: no image.
    fn objectives_at(
        &self,
        state: &[i64],
        region: fn(&ObjectiveRegions<E>) -> &E::States,
    ) -> Result<Option<Vec<String>>> {
        let mut names = Vec::new();
        for (position, objective) in self.preferences().objectives.iter().enumerate() {
            let regions = self.outcomes().and_then(|outcomes| outcomes.get(position));
            let Some(regions) = regions else { return Ok(None) };
            if self.engine().contains(region(regions), state)? {
                names.push(objective.name.clone());
            }
        }
        Ok(Some(names))
    }

    /// Returns the plan of a kind; `None` before its levels are searched for.
    fn plan(&self, kind: Kind, state: &[i64], choices: &[(Choice, String)]) -> Result<Option<Plan>> {
        let (Some(classes), Some(improvement)) = (self.classes(), self.improvement()) else {
            return Ok(None);
        };
        let (engine, levels) = (self.engine(), self.levels(kind));
        if levels.found.is_empty() && levels.end.is_none() {
            return Ok(None);
        }
        let rank = levels.rank(engine, state)?;
        let mut actions = Vec::new();
        if let Some(level) = levels.level(rank) {
            let own = engine.singleton(state)?;
            let permitted = strategy::permitted_in(engine, kind, classes, improvement, level, &own)?;
            for (choice, name) in choices {
                if engine.contains_choice(&permitted, state, choice)? {
                    actions.push(name.clone());
                }
            }
        }
        Ok(Some(Plan { rank, actions, gains: Vec::new() }))
    }
}
