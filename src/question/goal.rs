//! Goals of paths: to reach a target, or to satisfy a temporal formula.

use std::sync::Arc;

use meliora_base::error::{Result, SourceFile};
use meliora_engine::Engine;
use meliora_engine::regions::Regions;
use meliora_lang::lower_target;
use meliora_lang::ltl::{Formula, Monitoring};
use meliora_model::Program;
use meliora_model::expr::ExprId;
use meliora_model::predicate::Predicate;
use meliora_model::preference::Requirement;
use meliora_model::temporal::{Begin, Condition};
use meliora_planning::{RegionSearch, temporal};

/// The name of the monitors of requirements.
const REQUIREMENT: &str = "require";

/// The goal of the paths, and what every strategy must keep.
pub struct PathGoal {
    /// The goal of the paths.
    pub target: Target,
    /// The requirements, as states of the model in which the question is answered.
    pub requirements: Vec<Requirement>,
    /// The model with monitors, if the goal or a requirement needs some.
    pub watched: Option<Watched>,
}

/// The condition on paths.
pub enum Target {
    /// To reach these states.
    States(Predicate),
    /// To satisfy a temporal formula.
    Formula(Condition),
}

/// A model with monitors.
pub struct Watched {
    /// The model with its monitors.
    pub program: Arc<Program>,
    /// The states where the monitors are fresh.
    pub fresh: Predicate,
}

/// A safe formula that every strategy must keep, with its text.
pub type Required = (Arc<SourceFile>, Formula);

impl PathGoal {
    /// Returns the model in which the question is answered: `plain`, or that with monitors.
    pub fn program<'a>(&'a self, plain: &'a Arc<Program>) -> &'a Arc<Program> {
        self.watched.as_ref().map_or(plain, |watched| &watched.program)
    }

    /// Turns a formula into a goal: a target, or a condition on monitors next to the model.
    ///
    /// # Errors
    /// The formula is wrong or not supported, or a requirement is not a safe formula.
    pub fn of(
        program: &Program,
        source: &Arc<SourceFile>,
        formula: &Formula,
        required: &[Required],
    ) -> Result<Self> {
        if let Some(target) = formula.known_target() {
            return PathGoal::reach(program, program.predicate(target), required);
        }
        if let Some(target) = formula.reachability() {
            let target = lower_target(program, source, target)?;
            return PathGoal::reach(program, target, required);
        }
        let mut watching = Monitoring::new(program);
        let condition = watching.watch(source, formula, "property")?;
        let requirements = requirements(&mut watching, required)?;
        let watched = Watched::of(watching.finish(Begin::Everywhere)?);
        let of = |id| watched.program.predicate(id);
        Ok(PathGoal {
            target: Target::Formula(condition.map(&of)),
            requirements: requirements.into_iter().map(|r| r.map(&of)).collect(),
            watched: Some(watched),
        })
    }

    /// Makes a target a goal.
    ///
    /// # Errors
    /// A requirement is wrong, or not a safe formula.
    pub fn reach(program: &Program, target: Predicate, required: &[Required]) -> Result<Self> {
        let mut watching = Monitoring::new(program);
        let requirements = requirements(&mut watching, required)?;
        let (watched, predicates) = if requirements.iter().all(|r| r.monitor.is_none()) {
            (None, watching.without_monitors())
        } else {
            let watched = Watched::of(watching.finish(Begin::Everywhere)?);
            let predicates = watched.program.predicates();
            (Some(watched), predicates)
        };
        let requirements = requirements.into_iter().map(|r| r.map(&|id| predicates.get(id))).collect();
        Ok(PathGoal { target: Target::States(target), requirements, watched })
    }

    /// Returns the conditions of the target and of the requirements; those on marks of monitors, which
    /// belong to the product, are left out.
    pub fn predicates(&self) -> impl Iterator<Item = &Predicate> {
        let target = match &self.target {
            Target::States(target) => Some(target),
            Target::Formula(_) => None,
        };
        target.into_iter().chain(self.requirements.iter().map(|requirement| &requirement.kept))
    }

    /// Returns the states whose paths are judged: with monitors, the states where these are fresh.
    pub fn judged<E: Engine>(&self, engine: &E) -> Result<E::States> {
        match &self.watched {
            None => Ok(engine.all_states()),
            Some(watched) => engine.states_where(&watched.fresh),
        }
    }

    /// Begins the search for regions over all states, with an engine for the program of the
    /// goal; states with monitors that are not fresh are among them. Cost: no image.
    ///
    /// # Errors
    /// A limit is reached, or a state formula has no value in some state.
    pub fn search<'a, E: Engine>(&'a self, engine: &'a E) -> Result<RegionSearch<'a, E>> {
        Ok(match &self.target {
            Target::States(target) => RegionSearch::of_target(engine, engine.states_where(target)?),
            Target::Formula(condition) => RegionSearch::of_condition(engine, condition),
        })
    }

    /// Returns the regions within the states whose paths are judged.
    pub fn restricted<E: Engine>(
        &self,
        engine: &E,
        regions: Regions<E::States>,
    ) -> Result<Regions<E::States>> {
        match &self.watched {
            None => Ok(regions),
            Some(watched) => temporal::judged(engine, &watched.fresh, regions),
        }
    }
}

impl Watched {
    fn of(product: Program) -> Self {
        let fresh = product.monitors.as_ref().map_or(product.initial, |monitors| monitors.fresh);
        Watched { fresh: product.predicate(fresh), program: Arc::new(product) }
    }
}

/// Reads requirements, for which monitors are added if some need one.
fn requirements(watching: &mut Monitoring<'_>, required: &[Required]) -> Result<Vec<Requirement<ExprId>>> {
    watching.require(required.iter().map(|(source, formula)| (source, formula)), REQUIREMENT)
}
