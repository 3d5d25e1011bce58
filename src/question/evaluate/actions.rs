//! The probability of a formula after each action of each state.

use std::sync::Arc;

use super::operators::goal;
use super::{Evaluator, listed};
use crate::answer::{ASK_QUALITATIVELY, NEITHER};
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_equations::vector::{Asked, Until};
use meliora_equations::{Arena, Extremes, Members, Value};
use meliora_lang::property::Optimum;
use meliora_lang::property::term::{Measure, Measured, Path, Single, Step, Term, TermKind};
use meliora_model::Program;
use meliora_quantities::actions::{StateActions, actions, indicator};
use meliora_quantities::sought::Sought;

/// The probability of a formula after each action of each state.
#[derive(Debug)]
pub struct ActionValues {
    /// The model, or its product with the monitors of the formula.
    pub program: Arc<Program>,
    /// The extreme that we look for.
    pub optimum: Optimum,
    /// The number of steps that the formula looks ahead in each state, if it is bounded.
    pub horizon: Option<u64>,
    /// All states, in the order of their values; those of a product with its monitors.
    pub states: Vec<StateActions>,
}

/// The probabilities of a formula in the states that the actions of each state may enter.
struct After {
    values: Vec<Value>,
    decided: Members,
}

impl<E: Engine> Evaluator<'_, '_, E> {
    /// Returns the best probability of the formula of `Pmin=? [ … ]` or `Pmax=? [ … ]` after each action of each state.
    /// A bounded formula looks ahead the same number of steps in each state, the action among them. With `exact`, the
    /// values are fractions.
    ///
    /// # Errors
    /// The property is none of these, or not supported; a limit is reached.
    pub fn actions(&self, term: &Term, exact: bool) -> Result<ActionValues> {
        let (measured, path) = self.safety(term)?;
        let precision = if exact { 0.0 } else { self.model.precision };
        let Some(single) = &path.single else {
            return self.actions_of_product(term, measured, path, precision);
        };
        let played = self.played(measured)?;
        let engine = played.as_ref().unwrap_or(self.engine);
        let arena = Arena::new(engine, self.program)?;
        let goal = goal(measured.optimum, engine.is_game());
        let goal = if single.negated { goal.opposite() } else { goal };
        let (mut after, horizon) = self.after((&arena, engine), term, single, (goal, precision))?;
        if single.negated {
            after.values.iter_mut().for_each(Value::complement);
        }
        let states = actions(&arena, &after.values, &after.decided)?;
        Ok(ActionValues { program: Arc::clone(self.program), optimum: measured.optimum, horizon, states })
    }

    /// Returns the operator and its formula.
    fn safety<'t>(&self, term: &'t Term) -> Result<(&'t Measured, &'t Path)> {
        let help = "write `Pmin=? [ F \"crash\" ]` or `Pmax=? [ G !\"crash\" ]`";
        let TermKind::Operator(measured) = &term.kind else {
            return Err(self.unsupported(term, "a shield is about one operator `P`", help));
        };
        match &measured.measure {
            _ if measured.bound.is_some() => {
                let message = "the bound of a shield is not a part of the property";
                Err(self.unsupported(term, message, "write `=?`, and give the bound by `--threshold`"))
            }
            Measure::Probability(path) => Ok((measured, path)),
            _ => Err(self.unsupported(term, "a shield is about probabilities, not about rewards", help)),
        }
    }

    /// Returns the values after a step, for a formula without its negation, and its bound.
    fn after(
        &self,
        (arena, engine): (&Arena<'_>, &E),
        term: &Term,
        single: &Single,
        (goal, precision): (Extremes, f64),
    ) -> Result<(After, Option<u64>)> {
        let all = self.engine.all_states();
        let (left, right, most) = match &single.step {
            Step::Now(now) => {
                let now = arena.members(engine, &self.states(now, &all)?)?;
                let decided = Members::repeat(true, arena.states());
                return Ok((After { values: indicator(&now), decided }, Some(0)));
            }
            Step::Next(target) => {
                let target = arena.members(engine, &self.states(target, &all)?)?;
                let decided = Members::repeat(false, arena.states());
                return Ok((After { values: indicator(&target), decided }, Some(1)));
            }
            Step::Until { least, .. } if *least > 0 => {
                let help = "give an upper bound only, such as `F<=10 \"crash\"`";
                return Err(self.unsupported(
                    term,
                    "lower bounds on the steps of a shield are not supported",
                    help,
                ));
            }
            Step::Until { left, right, most, .. } => (left, right, *most),
        };
        let left = left.as_ref().map_or(Ok(all.clone()), |left| self.states(left, &all))?;
        let right = self.states(right, &all)?;
        let (left, right) = (arena.members(engine, &left)?, arena.members(engine, &right)?);
        let decided = right.clone() | !left.clone();
        if most == Some(0) {
            let decided = Members::repeat(true, arena.states());
            return Ok((After { values: indicator(&right), decided }, most));
        }
        // The action is one of the steps.
        let until = Until { left, right, least: 0, most: most.map(|most| most - 1) };
        let found = Asked::all(arena, goal, precision).probability(&until)?;
        found.end?;
        Ok((After { values: found.values, decided }, most))
    }

    /// Returns the values in the product with the monitors of a formula.
    fn actions_of_product(
        &self,
        term: &Term,
        measured: &Measured,
        path: &Path,
        precision: f64,
    ) -> Result<ActionValues> {
        let product = self.product(term, path, measured.coalition.as_ref())?;
        let (engine, program) = (&*product.engine, &product.program);
        let (sought, optimum) = (Sought::Probability(product.condition()), measured.optimum);
        let (regions, _) = self.parts_of_product(&product, sought.needed(optimum), &[])?;
        let states = listed(engine, &engine.all_states())?;
        let Some(mut compute) = sought.prepare((engine, program), optimum, &regions, &states, false)? else {
            return Err(self.unsupported(term, NEITHER, ASK_QUALITATIVELY));
        };
        let found = compute(precision)?;
        found.end?;
        let arena = Arena::new(engine, program)?;
        let undecided = Members::repeat(false, arena.states());
        let mut values = vec![Value::Infinite; arena.states()];
        for (state, value) in states.iter().zip(found.values) {
            values[arena.number(state)] = value;
        }
        let states = actions(&arena, &values, &undecided)?;
        Ok(ActionValues { program: Arc::clone(program), optimum, horizon: None, states })
    }
}
