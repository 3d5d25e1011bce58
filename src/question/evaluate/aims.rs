//! The strategy of one operator in the arena of the model, or of the model with the monitors of the formula.

use meliora_base::error::{Error, Result};
use meliora_base::exact::Ratio;
use meliora_base::value::EvalError;
use meliora_engine::Engine;
use meliora_equations::vector::{Accumulation, Until};
use meliora_equations::{Arena, Extremes, Members, Rewards};
use meliora_lang::ast::BinaryOp;
use meliora_lang::property::Optimum;
use meliora_lang::property::term::{Accumulated, Measure, Measured, Path, Single, Step, Term};
use meliora_model::temporal::{Asks, Condition};
use meliora_model::{Program, State};
use meliora_quantities::optimal::{Accepting, Aim, Optimal, attained, optimal};
use num_traits::Zero;

use super::chain::PolicyNodes;
use super::operators::{accepted, goal};
use super::optimal::Played;
use super::{Evaluator, Number};
use crate::answer::{ASK_QUALITATIVELY, NEITHER};
use crate::goal::PathGoal;
use crate::strategies::MOST_STATES;

/// An aim in the states of an arena.
enum Wanted {
    Until(Until),
    Recur(Vec<Accepting>),
    /// With the least reward, to which the others are the differences.
    Reward(Box<Rewards>, Accumulation, Ratio),
}

impl Wanted {
    fn aim(&self) -> Aim<'_> {
        match self {
            Wanted::Until(until) => Aim::Until(until),
            Wanted::Recur(all) => Aim::Recur(all),
            Wanted::Reward(rewards, accumulation, _) => Aim::Reward(rewards, accumulation),
        }
    }

    /// Adds the least rewards to a number of differences.
    fn moved(&self, number: Number) -> Result<Number> {
        let Wanted::Reward(_, accumulation, least) = self else { return Ok(number) };
        let steps = if let Accumulation::Within(steps) = accumulation { *steps } else { 1 };
        if least.is_zero() {
            return Ok(number);
        }
        let least = Number::fraction(&(least * Ratio::from_integer(steps.into())));
        let wrong = |e: EvalError| Error::Usage(format!("the reward has no value: {e}"));
        number.arithmetic(BinaryOp::Add, &least).map_err(wrong)
    }
}

/// The states that an operator names.
struct Named<S> {
    /// The target.
    target: Option<S>,
    /// The states that a path may visit before it, if not all.
    left: Option<S>,
    /// States in which every path is decided.
    stops: S,
}

/// The strategy of an arena.
pub(super) struct Found {
    pub(super) nodes: PolicyNodes,
    /// The optimal values of the initial states.
    pub(super) optima: Vec<Number>,
    /// The values that the strategy attains there.
    pub(super) values: Vec<Number>,
}

impl<E: Engine> Evaluator<'_, '_, E> {
    /// Computes the strategy from the initial states.
    pub(super) fn found(&self, played: &Played<'_>, precision: f64) -> Result<Found> {
        let measured = &played.measured;
        let starts = self.at(&self.engine.initial_states())?.list;
        let path = match &measured.measure {
            Measure::Probability(path) if path.single.is_none() => Path::clone(path),
            Measure::Reward(_, Accumulated::Until(path)) if target(path).is_none() => {
                self.read_to_the_end(path)
            }
            _ => {
                let game = self.played(measured)?;
                let engine = game.as_ref().unwrap_or(self.engine);
                let named = self.named(measured)?;
                let (arena, starts) = Arena::reached(engine, self.program, &starts, &named.stops)?;
                let goal = goal(measured.optimum, engine.is_game());
                let (wanted, is_negated) = self.wanted_of(played, &arena, &named)?;
                return Of {
                    arena: &arena,
                    variables: self.program.variables.len(),
                    is_watched: false,
                    starts: &starts,
                    precision: self.model.precision,
                }
                .found(&wanted, (goal, is_negated), precision);
            }
        };
        if let Some(PathGoal { watched: Some(watched), .. }) = self.model.goal {
            let (game, condition) = (self.played(measured)?, played.condition.as_ref());
            let engine = game.as_ref().unwrap_or(self.engine);
            return self.found_in_product(played, (engine, &watched.program, condition), &starts, precision);
        }
        let product = self.product(played.term, &path, measured.coalition.as_ref())?;
        let (_, starts) = self.parts_of_product(&product, &[], &starts)?;
        let product = (&*product.engine, &*product.program, product.condition());
        self.found_in_product(played, product, &starts, precision)
    }

    /// Computes the strategy of a formula from some states of the model with its monitors.
    fn found_in_product(
        &self,
        played: &Played<'_>,
        (engine, program, condition): (&E, &Program, Option<&Condition>),
        starts: &[State],
        precision: f64,
    ) -> Result<Found> {
        let (arena, starts) = Arena::reached(engine, program, starts, &engine.no_states())?;
        let (wanted, is_negated) = self.wanted_of_product(played, engine, condition, &arena)?;
        let goal = goal(played.measured.optimum, engine.is_game());
        Of {
            arena: &arena,
            variables: self.program.variables.len(),
            is_watched: true,
            starts: &starts,
            precision: self.model.precision,
        }
        .found(&wanted, (goal, is_negated), precision)
    }

    /// Returns the states that an operator without monitors names.
    fn named(&self, measured: &Measured) -> Result<Named<E::States>> {
        let (wanted, left, is_decided) = match &measured.measure {
            Measure::LongRun(states) => (Some(states), None, false),
            Measure::Reward(_, Accumulated::Anyway(states) | Accumulated::IfReached(states)) => {
                (Some(states), None, true)
            }
            Measure::Reward(_, Accumulated::Until(path)) => (target(path), None, true),
            Measure::Reward(..) => (None, None, false),
            Measure::Probability(path) => match path.single.as_ref().map(|single| &single.step) {
                Some(Step::Now(states)) => (Some(states), None, true),
                Some(Step::Next(states)) => (Some(states), None, false),
                Some(Step::Until { left, right, least, .. }) => (Some(right), left.as_ref(), *least == 0),
                None => (None, None, false),
            },
        };
        let all = self.engine.all_states();
        let states = |term: Option<&Term>| term.map(|term| self.states(term, &all)).transpose();
        let (target, left) = (states(wanted)?, states(left)?);
        let stops = match target.as_ref().filter(|_| is_decided) {
            Some(target) => self.stops(target, left.as_ref())?,
            None => self.engine.no_states(),
        };
        Ok(Named { target, left, stops })
    }

    /// Returns the aim of an operator without monitors, and whether its probability is 1 minus the one that is asked for.
    fn wanted_of(
        &self,
        played: &Played<'_>,
        arena: &Arena<'_>,
        named: &Named<E::States>,
    ) -> Result<(Wanted, bool)> {
        let members = |set: &Option<E::States>, all: bool| match set {
            Some(set) => arena.members(self.engine, set),
            None => Ok(Members::repeat(all, arena.states())),
        };
        let (target, left) = (members(&named.target, false)?, || members(&named.left, true));
        Ok(match &played.measured.measure {
            Measure::LongRun(_) => (
                Wanted::Reward(
                    Box::new(Rewards::of_set(arena, &target)),
                    Accumulation::LongRun,
                    Ratio::default(),
                ),
                false,
            ),
            Measure::Probability(path) => match &path.single {
                Some(single) => (Wanted::Until(until(single, target, left()?)), single.negated),
                None => return Err(self.unsupported(played.term, NEITHER, ASK_QUALITATIVELY)),
            },
            Measure::Reward(rewards, accumulated) => {
                let unknown = || Error::Usage("unknown reward structure".to_owned());
                let structure = rewards.find(self.program).ok_or_else(unknown)?;
                let accumulation = match accumulated {
                    Accumulated::Until(_) => Accumulation::Until(target),
                    Accumulated::Anyway(_) => Accumulation::Anyway(target),
                    Accumulated::IfReached(_) => Accumulation::IfReached(target),
                    Accumulated::Within(steps) => Accumulation::Within(*steps),
                    Accumulated::Total => Accumulation::Total,
                    Accumulated::At(steps) => Accumulation::At(*steps),
                    Accumulated::LongRun => Accumulation::LongRun,
                };
                let (rewards, least) = match accumulation {
                    Accumulation::Until(_)
                    | Accumulation::Anyway(_)
                    | Accumulation::IfReached(_)
                    | Accumulation::Total => (arena.rewards(self.engine, structure)?, Ratio::default()),
                    _ => arena.rewards_above_least(structure)?,
                };
                (Wanted::Reward(Box::new(rewards), accumulation, least), false)
            }
        })
    }

    /// Returns the same for an operator with monitors.
    fn wanted_of_product(
        &self,
        played: &Played<'_>,
        engine: &E,
        condition: Option<&Condition>,
        arena: &Arena<'_>,
    ) -> Result<(Wanted, bool)> {
        let unsupported = || self.unsupported(played.term, NEITHER, ASK_QUALITATIVELY);
        let condition = condition.ok_or_else(unsupported)?;
        let until = |condition: &Condition| -> Result<Option<Members>> {
            accepted(engine, condition)?.map(|set| arena.members(engine, &set)).transpose()
        };
        if let Measure::Reward(rewards, _) = &played.measured.measure {
            let structure = rewards.find(self.program).ok_or_else(unsupported)?;
            let target = until(condition)?.ok_or_else(unsupported)?;
            return Ok((
                Wanted::Reward(
                    Box::new(arena.rewards(engine, structure)?),
                    Accumulation::Until(target),
                    Ratio::default(),
                ),
                false,
            ));
        }
        let reach = |right| Until::unbounded(Members::repeat(true, arena.states()), right);
        if engine.is_game() {
            return match (condition.only_asks(Asks::Accept), condition.only_asks(Asks::Avoid)) {
                (true, _) => Ok((Wanted::Until(reach(until(condition)?.ok_or_else(unsupported)?)), false)),
                (_, true) => {
                    let violated = until(&condition.negated())?.ok_or_else(unsupported)?;
                    Ok((Wanted::Until(reach(violated)), true))
                }
                _ => Err(unsupported()),
            };
        }
        // The least probability is 1 minus the greatest one of the negation.
        let is_negated = played.measured.optimum == Optimum::Min;
        let condition = if is_negated { condition.negated() } else { condition.clone() };
        let mut all = Vec::new();
        for disjunct in condition.disjuncts()? {
            let mut always = Members::repeat(true, arena.states());
            for (mark, holds) in &disjunct.always {
                let own = arena.members(engine, &engine.states_where(mark)?)?;
                always &= if *holds { own } else { !own };
            }
            let set = |mark| arena.members(engine, &engine.states_where(mark)?);
            all.push(Accepting { always, again: disjunct.again.iter().map(set).collect::<Result<_>>()? });
        }
        Ok((Wanted::Recur(all), is_negated))
    }
}

/// Returns the target if a formula is to reach some states, at once or later.
pub(super) fn target(path: &Path) -> Option<&Term> {
    match path.single.as_ref()? {
        Single { negated: false, step: Step::Until { left: None, right, least: 0, most: None } } => {
            Some(right)
        }
        _ => None,
    }
}

/// Returns an operator as an until formula with these sets; `left` has all states if none are named.
fn until(single: &Single, target: Members, left: Members) -> Until {
    let of = |left: Members, least: u64, most: Option<u64>| Until { left, right: target, least, most };
    match &single.step {
        Step::Now(_) => of(Members::repeat(false, left.len()), 0, None),
        Step::Next(_) => of(left, 1, Some(1)),
        Step::Until { least, most, .. } => of(left, *least, *most),
    }
}

/// The arena of a model, or of one with monitors.
struct Of<'a> {
    arena: &'a Arena<'a>,
    /// The number of variables of the model.
    variables: usize,
    /// True with monitors.
    is_watched: bool,
    /// The numbers of the initial states.
    starts: &'a [usize],
    /// The precision of the values that are attained.
    precision: f64,
}

impl Of<'_> {
    fn found(&self, wanted: &Wanted, (goal, is_negated): (Extremes, bool), precision: f64) -> Result<Found> {
        let goal = if is_negated { goal.opposite() } else { goal };
        let mut found: Optimal = optimal(self.arena, &wanted.aim(), goal, precision)?;
        if self.is_watched {
            // Only the monitors know that a path is decided.
            found.never_ends();
        }
        let nodes = found.nodes(self.arena, self.starts, MOST_STATES)?;
        let count = self.starts.len();
        let attained = attained(self.arena, &wanted.aim(), goal, (&nodes, count), self.precision)?;
        let asked = |number: Number| -> Result<Number> {
            let number = if is_negated { number.complemented() } else { number };
            wanted.moved(number)
        };
        let optimum = |&number: &usize| asked(Number::between(found.values[number]));
        let optima = self.starts.iter().map(optimum).collect::<Result<_>>()?;
        let values = attained.into_iter().map(|value| asked(value.into())).collect::<Result<_>>()?;
        Ok(Found { nodes: PolicyNodes::new(nodes, (self.variables, self.is_watched)), optima, values })
    }
}
