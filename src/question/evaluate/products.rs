//! Formulas with several temporal operators: they are evaluated in a product with monitors. A nested
//! condition becomes a condition over the variables there.

use std::sync::Arc;

use super::condition::condition_of;
use super::{Evaluator, listed};
use crate::goal::{PathGoal, Target};
use meliora_base::error::Result;
use meliora_base::exact::{Exact, Real};
use meliora_base::value::{Type, Value};
use meliora_engine::Engine;
use meliora_engine::regions::{Regions, Which};
use meliora_lang::ltl::{Formula, FormulaKind};
use meliora_lang::property::term::{Path, Term};
use meliora_model::expr::{Binary, ExprId, Unary};
use meliora_model::predicate::Predicates;
use meliora_model::{Branch, Command, CommandId, ModelKind, Program, State};
use meliora_planning::RegionSearch;
use meliora_planning::Requirements;

/// The regions of a product that are known.
type Known<E> = Regions<Option<<E as Engine>::States>>;

/// A product with monitors, and the goal of its paths.
pub(super) struct Product<E> {
    pub(super) engine: Arc<E>,
    pub(super) program: Arc<Program>,
    pub(super) goal: PathGoal,
}

impl<E: Engine> Evaluator<'_, '_, E> {
    /// Returns the product for a formula, in which the players of a coalition are ours.
    pub(super) fn product(
        &self,
        term: &Term,
        path: &Path,
        coalition: Option<&Vec<bool>>,
    ) -> Result<Product<E>> {
        let (formula, predicates) = self.flattened(path)?;
        let program = Program { pool: predicates.into_pool(), ..Program::clone(self.program) };
        let product = self.watched(term, &Arc::new(program), &formula)?;
        let other = coalition.filter(|coalition| **coalition != product.engine.coalition());
        let played = other.map(|coalition| product.engine.with_coalition(coalition)).transpose()?;
        let engine = played.map_or_else(|| Arc::clone(&product.engine), Arc::new);
        Ok(Product { engine, ..product })
    }

    /// Returns the goal of a formula, with its monitors.
    pub(super) fn goal_of(&self, path: &Path) -> Result<PathGoal> {
        let (formula, predicates) = self.flattened(path)?;
        let program = Program { pool: predicates.into_pool(), ..Program::clone(self.program) };
        PathGoal::of(&program, self.source, &formula, self.model.required)
    }

    /// Builds the product of a program with the monitors of a formula.
    fn watched(&self, term: &Term, program: &Arc<Program>, formula: &Formula) -> Result<Product<E>> {
        let goal = PathGoal::of(program, self.source, formula, self.model.required)?;
        if matches!(goal.target, Target::States(_)) {
            return Err(self.wrong(term, "the formula is decided without monitors").into());
        }
        let program = Arc::clone(goal.program(program));
        let whole = (self.model.build)(&program)?;
        let restricted = Requirements::restrict(&*whole, &goal.requirements)?;
        let engine = restricted.map_or(whole, |(engine, _)| Arc::new(engine));
        Ok(Product { engine, program, goal })
    }

    /// Returns the formula of a path whose nested conditions are conditions over the variables.
    fn flattened(&self, path: &Path) -> Result<(Formula, Predicates)> {
        let (mut formula, mut predicates) = (path.formula.clone(), path.predicates.clone());
        let mut known = Vec::new();
        for nested in &path.nested {
            let states = self.at(&self.states(nested, &self.engine.all_states())?)?;
            known.push(condition_of(self.program, predicates.pool(), &states.list));
        }
        replace(&mut formula, &known);
        Ok((formula, predicates))
    }

    /// Returns a formula in which `true` is a condition that only a state decides: a path satisfies `X true`
    /// once it has a second state, and not before.
    pub(super) fn read_to_the_end(&self, path: &Path) -> Path {
        let mut path = path.clone();
        let Some((variable, range)) = self.program.variable_ids().zip(&self.program.variables).next() else {
            return path;
        };
        let pool = path.predicates.pool();
        let own = pool.var(variable, range.ty);
        let always = match range.ty {
            Type::Bool => {
                let not = pool.unary(Unary::Not, own);
                pool.binary(Binary::Or, own, not)
            }
            _ => {
                let high = pool.value(Value::Int(range.high));
                pool.binary(Binary::Le, own, high)
            }
        };
        let never = pool.unary(Unary::Not, always);
        let decided = |id| match pool.literal(id) {
            Some(Value::Bool(true)) => always,
            Some(Value::Bool(false)) => never,
            _ => id,
        };
        known_of(&mut path.formula, &decided);
        path
    }

    /// Returns a set of listed states.
    pub(super) fn set_where(&self, states: &[State]) -> Result<E::States> {
        self.engine.set_of(&mut states.iter().cloned())
    }

    /// Returns a region of a product as states of the model.
    pub(super) fn region_of_product(&self, product: &Product<E>, which: Which) -> Result<E::States> {
        let engine = &*product.engine;
        let region = product.goal.search(engine)?.region(which)?;
        let judged = engine.intersection(&region, &product.goal.judged(engine)?)?;
        let (variables, mut states) = (self.program.variables.len(), listed(engine, &judged)?);
        states.iter_mut().for_each(|state| state.truncate(variables));
        self.engine.intersection(&self.set_where(&states)?, &self.engine.all_states())
    }

    /// Returns the regions that a number of a product needs, and states of the model as states of the
    /// product.
    pub(super) fn parts_of_product(
        &self,
        product: &Product<E>,
        needed: &[Which],
        states: &[State],
    ) -> Result<(Known<E>, Vec<State>)> {
        let engine: &E = &product.engine;
        let mut search: RegionSearch<'_, E> = product.goal.search(engine)?;
        for which in search.order(needed) {
            search.region(which)?;
        }
        let monitors = product.program.variables.len() - self.program.variables.len();
        let fresh = |state: &State| state.iter().copied().chain(std::iter::repeat_n(0, monitors)).collect();
        Ok((search.known().clone(), states.iter().map(fresh).collect()))
    }

    /// Returns the states of which every path, or some path, satisfies a formula: in the model in which each
    /// successor has a choice of its own, every strategy, or some strategy, satisfies it.
    pub(super) fn paths_of_product(&self, term: &Term, all: bool, path: &Path) -> Result<E::States> {
        if !self.model.required.is_empty() {
            let message = "`A` and `E` with several temporal operators are not supported under requirements";
            return Err(self.unsupported(term, message, "leave out `--require`, or ask for `P>=1` or `P>0`"));
        }
        let (formula, predicates) = self.flattened(path)?;
        let program = Arc::new(of_single_steps(self.program, predicates));
        let product = self.watched(term, &program, &formula)?;
        self.region_of_product(&product, if all { Which::PminOne } else { Which::PmaxOne })
    }
}

/// Replaces the known conditions of a formula.
fn known_of(formula: &mut Formula, replaced: &impl Fn(ExprId) -> ExprId) {
    if let FormulaKind::Known(id) = &mut formula.kind {
        *id = replaced(*id);
    }
    formula.operands_mut().into_iter().for_each(|part| known_of(part, replaced));
}

/// Replaces the nested conditions of a formula.
fn replace(formula: &mut Formula, known: &[ExprId]) {
    if let FormulaKind::Nested(at) = formula.kind {
        formula.kind = FormulaKind::Known(known[at]);
    }
    formula.operands_mut().into_iter().for_each(|part| replace(part, known));
}

/// Returns the program in which each branch of a command is a command of its own, without probabilities:
/// its choices are the steps of the paths.
fn of_single_steps(program: &Program, mut predicates: Predicates) -> Program {
    let mut single = program.clone();
    let pool = predicates.pool();
    let (zero, one) = (Exact::Real(Real::from(0_i64)), Exact::Real(Real::from(1_i64)));
    let (zero, one) = (pool.exact_value(zero), pool.exact_value(one));
    let mut parts: Vec<Vec<CommandId>> = Vec::with_capacity(program.commands.len());
    single.commands.clear();
    for command in &program.commands {
        let mut own = Vec::with_capacity(command.branches.len());
        for branch in &command.branches {
            let possible = pool.binary(Binary::Lt, zero, branch.probability);
            let guard = pool.binary(Binary::And, command.guard, possible);
            let branch = Branch { probability: one, ..branch.clone() };
            own.push(CommandId(u32::try_from(single.commands.len()).unwrap_or(u32::MAX)));
            single.commands.push(Command { guard, branches: [branch].into(), ..command.clone() });
        }
        parts.push(own);
    }
    for factor in single.synchronisations.iter_mut().flat_map(|own| &mut own.factors) {
        *factor = factor.iter().flat_map(|command| parts[command.index()].iter().copied()).collect();
    }
    single.rewards.clear();
    (single.kind, single.players, single.stop) = (ModelKind::Mdp, None, None);
    single.pool = predicates.into_pool();
    single
}
