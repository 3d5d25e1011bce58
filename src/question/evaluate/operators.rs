//! Numbers of operators: probabilities and rewards of paths.
//!
//! If one player chooses alone and nothing counts steps, the equations are those of the states between the
//! regions of the formula. All other numbers are computed over a list of all states.

use super::numbers::Operator;
use super::products::Product;
use super::{Evaluator, Number};
use crate::answer::{ASK_QUALITATIVELY, NEITHER};
use meliora_base::error::{Error, Result};
use meliora_base::exact::{Exact, Ratio, Real};
use meliora_base::value::EvalError;
use meliora_engine::Engine;
use meliora_engine::regions::{Regions, Which};
use meliora_equations::vector::{Accumulation, Asked, Until};
use meliora_equations::{Answer, Arena, Extremes};
use meliora_lang::ast::BinaryOp;
use meliora_lang::property::Optimum;
use meliora_lang::property::term::{Accumulated, Path, Single, Step, Term};
use meliora_model::State;
use meliora_model::property::Rewards;
use meliora_model::temporal::{Asks, Condition};
use meliora_quantities::sought::{Compute, Sought};
use num_traits::{Signed, ToPrimitive, Zero};

impl<E: Engine> Evaluator<'_, '_, E> {
    pub(super) fn probability(&self, asked: &Operator<'_, E::States>, path: &Path) -> Result<Vec<Number>> {
        match &path.single {
            Some(single) if !self.engine.is_game() && is_unbounded(single) => {
                self.between(asked, &Sought::Probability(None), single)
            }
            Some(single) => self.stepwise(asked, single),
            None => {
                let product = self.product(asked.term, path, asked.measured.coalition.as_ref())?;
                let (sought, optimum) = (Sought::Probability(product.condition()), asked.measured.optimum);
                let (regions, states) =
                    self.parts_of_product(&product, sought.needed(optimum), &asked.at.list)?;
                let model = (&*product.engine, &*product.program);
                match sought.prepare(model, optimum, &regions, &states, self.is_last)? {
                    Some(compute) => computed(compute, asked.precision),
                    None => self.zero_or_one(asked, &product, &regions, &states),
                }
            }
        }
    }

    /// Returns a number of a formula without bounds, from the regions of the formula.
    fn between(
        &self,
        asked: &Operator<'_, E::States>,
        sought: &Sought<'_, E::States>,
        single: &Single,
    ) -> Result<Vec<Number>> {
        let (optimum, mut regions) = (asked.measured.optimum, Regions::default());
        for &which in sought.needed(optimum) {
            *regions.get_mut(which) = Some(self.region_of_single(self.engine, which, single)?);
        }
        let model = (self.engine, &**self.program);
        match sought.prepare(model, optimum, &regions, &asked.at.list, self.is_last)? {
            Some(compute) => computed(compute, asked.precision),
            None => Err(self.unsupported(asked.term, NEITHER, ASK_QUALITATIVELY)),
        }
    }

    /// Returns the probabilities of a formula with one operator, over all states.
    fn stepwise(&self, asked: &Operator<'_, E::States>, single: &Single) -> Result<Vec<Number>> {
        let all = self.engine.all_states();
        let goal = goal(asked.measured.optimum, self.engine.is_game());
        let goal = if single.negated { goal.opposite() } else { goal };
        let found = match &single.step {
            Step::Now(now) => {
                let now = self.states(now, &all)?;
                asked
                    .at
                    .list
                    .iter()
                    .map(|s| Ok(truth(self.engine.contains(&now, s)?)))
                    .collect::<Result<_>>()?
            }
            Step::Next(target) => {
                let target = self.states(target, &all)?;
                self.in_arena(asked, None, |arena, engine| {
                    Asked::all(arena, goal, asked.precision).next(&arena.members(engine, &target)?)
                })?
            }
            Step::Until { left, right, least, most } => {
                let left = left.as_ref().map(|left| self.states(left, &all)).transpose()?;
                let target = self.states(right, &all)?;
                let decided = (*least == 0).then(|| self.stops(&target, left.as_ref())).transpose()?;
                let through = left.unwrap_or(all);
                self.in_arena(asked, decided.as_ref(), |arena, engine| {
                    let (left, right) = (arena.members(engine, &through)?, arena.members(engine, &target)?);
                    let until = Until { left, right, least: *least, most: *most };
                    Asked::all(arena, goal, asked.precision).probability(&until)
                })?
            }
        };
        Ok(if single.negated { found.iter().map(Number::complemented).collect() } else { found })
    }

    /// Returns the states in which `left U target` is decided; `left` has all states if none are given.
    pub(super) fn stops(&self, target: &E::States, left: Option<&E::States>) -> Result<E::States> {
        match left {
            Some(left) => {
                let outside = self.engine.difference(&self.engine.all_states(), left)?;
                self.engine.union(target, &outside)
            }
            None => Ok(target.clone()),
        }
    }

    /// Computes over a list of states, in which the players of the operator are ours: those that are reached without leaving
    /// `stops`, or all.
    fn in_arena(
        &self,
        asked: &Operator<'_, E::States>,
        stops: Option<&E::States>,
        compute: impl FnOnce(&Arena<'_>, &E) -> Result<Answer>,
    ) -> Result<Vec<Number>> {
        let (game, states) = (self.played(asked.measured)?, &asked.at.list);
        let engine = game.as_ref().unwrap_or(self.engine);
        let own;
        let (arena, numbers): (&Arena<'_>, _) = match (stops, &game) {
            (None, None) => {
                let arena = self.model.arena()?;
                (arena, numbers_of(arena, states))
            }
            (None, Some(game)) => {
                own = Arena::new(game, self.program)?;
                (&own, numbers_of(&own, states))
            }
            (Some(stops), _) => {
                let (reached, numbers) = Arena::reached(engine, self.program, states, stops)?;
                own = reached;
                (&own, numbers)
            }
        };
        self.settle(arena);
        selected(compute(arena, engine)?, &numbers)
    }

    /// Returns the probabilities of a formula of a game that no finite part of a path decides, if they are 0 or 1.
    fn zero_or_one(
        &self,
        asked: &Operator<'_, E::States>,
        product: &Product<E>,
        regions: &Regions<Option<E::States>>,
        states: &[State],
    ) -> Result<Vec<Number>> {
        let (one, positive) = match asked.measured.optimum {
            Optimum::Max => (Which::PmaxOne, Which::PmaxPositive),
            Optimum::Min => (Which::PminOne, Which::PminPositive),
        };
        let (one, positive) = (regions.known(one)?, regions.known(positive)?);
        let value = |state: &State| match (
            product.engine.contains(one, state)?,
            product.engine.contains(positive, state)?,
        ) {
            (true, _) => Ok(truth(true)),
            (_, false) => Ok(truth(false)),
            _ => Err(self.unsupported(asked.term, NEITHER, ASK_QUALITATIVELY)),
        };
        states.iter().map(value).collect()
    }

    pub(super) fn long_run(&self, asked: &Operator<'_, E::States>, states: &Term) -> Result<Vec<Number>> {
        let states = self.states(states, &self.engine.all_states())?;
        let goal = goal(asked.measured.optimum, self.engine.is_game());
        self.in_arena(asked, None, |arena, engine| {
            Asked::all(arena, goal, asked.precision).long_run(&arena.members(engine, &states)?)
        })
    }

    pub(super) fn reward(
        &self,
        asked: &Operator<'_, E::States>,
        rewards: &Rewards,
        accumulated: &Accumulated,
    ) -> Result<Vec<Number>> {
        let structure = rewards.find(self.program);
        let structure = structure.ok_or_else(|| Error::Usage("unknown reward structure".to_owned()))?;
        // The rewards of a number of steps may be negative.
        let (accumulation, steps) = match accumulated {
            Accumulated::Until(path) => return self.reward_until(asked, structure, path),
            Accumulated::Within(steps) => (Accumulation::Within(*steps), Some(*steps)),
            Accumulated::Total => (Accumulation::Total, None),
            Accumulated::Anyway(states) | Accumulated::IfReached(states) => {
                let is_lost = matches!(accumulated, Accumulated::IfReached(_));
                let target = self.states(states, &self.engine.all_states())?;
                let goal = goal(asked.measured.optimum, self.engine.is_game());
                return self.in_arena(asked, Some(&target), |arena, engine| {
                    let target = arena.members(engine, &target)?;
                    let kept = if is_lost { Accumulation::IfReached } else { Accumulation::Anyway };
                    let rewards = arena.rewards(engine, structure)?;
                    Asked::all(arena, goal, asked.precision).reward(&rewards, &kept(target))
                });
            }
            Accumulated::At(steps) => (Accumulation::At(*steps), Some(1)),
            Accumulated::LongRun => (Accumulation::LongRun, Some(1)),
        };
        self.earned(asked, structure, &accumulation, steps)
    }

    /// Returns the reward of all steps, or the rewards of any sign of `steps` steps.
    fn earned(
        &self,
        asked: &Operator<'_, E::States>,
        structure: usize,
        accumulation: &Accumulation,
        steps: Option<u64>,
    ) -> Result<Vec<Number>> {
        let goal = goal(asked.measured.optimum, self.engine.is_game());
        let mut least = Ratio::zero();
        let found = self.in_arena(asked, None, |arena, engine| {
            let rewards = match steps {
                None => arena.rewards(engine, structure)?,
                Some(steps) => {
                    let (rewards, of_step) = arena.rewards_above_least(structure)?;
                    least = of_step * Ratio::from_integer(steps.into());
                    rewards
                }
            };
            // The difference is as exact as both numbers.
            let scale = 1.0 + least.abs().to_f64().unwrap_or(f64::MAX);
            Asked::all(arena, goal, asked.precision / scale).reward(&rewards, accumulation)
        })?;
        if least.is_zero() {
            return Ok(found);
        }
        let least = Number::fraction(&least);
        let moved = |number: &Number| number.arithmetic(BinaryOp::Add, &least);
        let wrong = |e: EvalError| Error::Usage(format!("the reward has no value: {e}"));
        found.iter().map(moved).collect::<Result<_, EvalError>>().map_err(wrong)
    }

    /// Returns the reward until a formula is satisfied.
    fn reward_until(
        &self,
        asked: &Operator<'_, E::States>,
        structure: usize,
        path: &Path,
    ) -> Result<Vec<Number>> {
        let all = self.engine.all_states();
        match &path.single {
            Some(
                single @ Single {
                    negated: false,
                    step: Step::Until { left: None, right, least: 0, most: None },
                },
            ) => {
                let target = self.states(right, &all)?;
                if !self.engine.is_game() {
                    return self.between(asked, &Sought::Reward(structure, &target), single);
                }
                let goal = goal(asked.measured.optimum, true);
                self.in_arena(asked, Some(&target), |arena, engine| {
                    let until = Accumulation::Until(arena.members(engine, &target)?);
                    Asked::all(arena, goal, asked.precision)
                        .reward(&arena.rewards(engine, structure)?, &until)
                })
            }
            Some(Single { negated, step: Step::Now(now) }) => {
                let now = self.states(now, &all)?;
                let value = |state: &State| match self.engine.contains(&now, state)? != *negated {
                    true => Ok(Number::of(Exact::Int(0))),
                    false => Ok(Number::of(Exact::Real(Real::Infinite(false)))),
                };
                asked.at.list.iter().map(value).collect()
            }
            _ => self.reward_in_product(asked, structure, path),
        }
    }

    /// Returns the reward until a monitor accepts.
    fn reward_in_product(
        &self,
        asked: &Operator<'_, E::States>,
        structure: usize,
        path: &Path,
    ) -> Result<Vec<Number>> {
        let path = self.read_to_the_end(path);
        let product = self.product(asked.term, &path, asked.measured.coalition.as_ref())?;
        let engine = &*product.engine;
        let accepted =
            product.condition().map(|condition| accepted(engine, condition)).transpose()?.flatten();
        let Some(accepted) = accepted else {
            let message = "rewards are accumulated until a formula is satisfied, and no finite part of a path \
                satisfies this one";
            return Err(self.unsupported(asked.term, message, "write `R{\"name\"}min=? [ F condition ]`"));
        };
        let (_, states) = self.parts_of_product(&product, &[], &asked.at.list)?;
        let (arena, numbers) = Arena::reached(engine, &product.program, &states, &accepted)?;
        self.settle(&arena);
        let until = Accumulation::Until(arena.members(engine, &accepted)?);
        let goal = goal(asked.measured.optimum, self.engine.is_game());
        let rewards = arena.rewards(engine, structure)?;
        selected(Asked::all(&arena, goal, asked.precision).reward(&rewards, &until)?, &numbers)
    }
}

/// Returns the values that were prepared.
fn computed(mut compute: Compute<'_>, precision: f64) -> Result<Vec<Number>> {
    let found = compute(precision)?;
    found.end.map(|()| found.values.into_iter().map(Number::from).collect())
}

impl<E> Product<E> {
    /// Returns the condition of the paths on the monitors.
    pub(super) fn condition(&self) -> Option<&Condition> {
        match &self.goal.target {
            crate::goal::Target::Formula(condition) => Some(condition),
            crate::goal::Target::States(_) => None,
        }
    }
}

/// Returns the states in which the monitors of co-safe formulas have accepted a condition; `None` if it has
/// other leaves. A monitor that accepts does so in all later states, so a conjunction is satisfied once all of
/// its parts are.
pub(super) fn accepted<E: Engine>(engine: &E, condition: &Condition) -> Result<Option<E::States>> {
    let (mut all, parts, is_all) = match condition {
        Condition::Leaf(Asks::Accept, mark) => return engine.states_where(mark).map(Some),
        Condition::Leaf(..) | Condition::Constant(_) => return Ok(None),
        Condition::All(parts) => (engine.all_states(), parts, true),
        Condition::Any(parts) => (engine.no_states(), parts, false),
    };
    for part in parts {
        let Some(part) = accepted(engine, part)? else { return Ok(None) };
        all = if is_all { engine.intersection(&all, &part)? } else { engine.union(&all, &part)? };
    }
    Ok(Some(all))
}

/// Returns what the players look for.
pub(super) fn goal(optimum: Optimum, is_game: bool) -> Extremes {
    if is_game { Extremes::against(optimum) } else { Extremes::all(optimum) }
}

fn truth(holds: bool) -> Number {
    Number::of(Exact::Int(i64::from(holds)))
}

/// Returns whether a formula has no bounds on the number of steps, and no next step.
fn is_unbounded(single: &Single) -> bool {
    matches!(single.step, Step::Now(_) | Step::Until { least: 0, most: None, .. })
}

/// Returns the numbers of some states of an arena of all.
fn numbers_of(arena: &Arena<'_>, states: &[State]) -> Vec<usize> {
    states.iter().map(|state| arena.number(state)).collect()
}

/// Returns the values at some positions.
fn selected(answer: Answer, positions: &[usize]) -> Result<Vec<Number>> {
    let found = answer.selected(positions);
    found.end.map(|()| found.values.into_iter().map(Number::from).collect())
}
