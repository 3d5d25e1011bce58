//! Several objectives at once: `multi(…)`.

use super::following::Objectives;
use super::{At, Evaluator, Number};
use meliora_base::error::{Error, Result};
use meliora_base::exact::Ratio;
use meliora_base::interval::Interval;
use meliora_engine::Engine;
use meliora_equations::several::{Counted, Node, Objective, Part, Several, mixed, several};
use meliora_equations::{Arena, Members, Rewards};
use meliora_lang::property::term::{Accumulated, Measure, Measured, Path, Single, Step, Term, TermKind};
use meliora_lang::property::{Inequality, Optimum};
use meliora_model::State;

/// The sets and rewards of an objective in an arena.
enum Of {
    Until(Option<Members>, Members),
    Recur(Members),
    Total(Rewards),
    Within(Rewards, u32),
    Before(Rewards, Members),
}

/// Strategies that show the answer about several objectives: one of them is drawn at the start, and followed.
#[derive(Debug)]
pub struct Mix {
    /// The strategies; those of a front have no shares.
    pub strategies: Vec<MixedStrategy>,
    /// For each objective, whether it is to be great.
    pub great: Vec<bool>,
}

/// A strategy of a mix.
#[derive(Debug)]
pub struct MixedStrategy {
    /// The probability with which it is drawn; `None` for a point of a front.
    pub share: Option<Ratio>,
    /// The values of the objectives that it guarantees.
    pub values: Vec<Ratio>,
    /// The states that it visits with its memory, the start first.
    pub nodes: Vec<(State, Node)>,
}

/// The formula `left U right`, or its negation; without `left`, all states may be passed.
struct Visited<S> {
    left: Option<S>,
    right: S,
    negated: bool,
}

/// An objective.
pub(super) struct Read {
    of: Of,
    pub(super) optimum: Optimum,
    pub(super) bound: Option<Ratio>,
    /// The number asked for is 1 minus that of the objective.
    pub(super) negated: bool,
}

impl Read {
    /// Returns the objective, or that of which it is the complement.
    pub(super) fn objective(&self) -> Objective<'_> {
        let counted = match &self.of {
            Of::Until(Some(left), right) => Counted::Until(left, right),
            Of::Until(None, right) => Counted::Visit(right),
            Of::Recur(set) => Counted::Recur(set),
            Of::Total(rewards) => Counted::Total(rewards),
            Of::Within(rewards, steps) => Counted::Within(rewards, *steps),
            Of::Before(rewards, set) => Counted::Before(rewards, set),
        };
        let (optimum, bound) = match (self.negated, self.optimum) {
            (false, optimum) => (optimum, self.bound.clone()),
            (true, Optimum::Max) => (Optimum::Min, self.complement()),
            (true, Optimum::Min) => (Optimum::Max, self.complement()),
        };
        Objective { counted, optimum, bound }
    }

    fn complement(&self) -> Option<Ratio> {
        self.bound.clone().map(|bound| Ratio::from_integer(1.into()) - bound)
    }
}

impl<E: Engine> Evaluator<'_, '_, E> {
    /// Returns the states of `within` from which one strategy satisfies all objectives.
    pub(super) fn achieving(&self, term: &Term, all: &[Term], within: &E::States) -> Result<E::States> {
        let at = self.at(within)?;
        let mut satisfied = Vec::new();
        for state in &at.list {
            match self.several(term, all, state, self.model.precision)?.0 {
                Several::Achievable(Some(true)) => satisfied.push(state.clone()),
                Several::Achievable(Some(false)) => {}
                _ => return Err(self.wrong(term, "the bounds of the objectives do not decide this").into()),
            }
        }
        self.engine.set_of(&mut satisfied.into_iter())
    }

    /// Returns the best value of one objective under the others, in listed states.
    pub(super) fn best(
        &self,
        term: &Term,
        all: &[Term],
        at: &At<E::States>,
        exact: bool,
    ) -> Result<Vec<Number>> {
        let precision = if exact { 0.0 } else { self.model.precision };
        let value = |state: &State| match self.several(term, all, state, precision)? {
            (Several::Best(Some(found)), negated) => {
                let found = Number::between(found);
                Ok(if negated { found.complemented() } else { found })
            }
            (Several::Infinite, _) => Ok(Number::between(Interval::point(f64::INFINITY))),
            (Several::Best(None), _) => {
                Err(self.wrong(term, "no strategy satisfies the bounds of the objectives").into())
            }
            (Several::Achievable(_), _) => {
                Err(self.wrong(term, "the bounds of the objectives do not decide this").into())
            }
            _ => Err(self.wrong(term, "the best values of several objectives are not a number").into()),
        };
        at.list.iter().map(value).collect()
    }

    /// Returns the Pareto front of objectives without bounds in the only initial state; `None` for others.
    pub(super) fn front(&self, term: &Term) -> Result<Option<Vec<Vec<f64>>>> {
        let TermKind::Multi(all) = &term.kind else { return Ok(None) };
        if all.iter().filter(|objective| !objective.is_condition()).count() < 2 {
            return Ok(None);
        }
        let initial = self.at(&self.engine.initial_states())?;
        let [state] = initial.list.as_slice() else {
            return Err(self.wrong(term, "a Pareto front is that of one initial state").into());
        };
        match self.several(term, all, state, self.model.precision)?.0 {
            Several::Front(points) => Ok(Some(points)),
            _ => Ok(None),
        }
    }

    /// Returns the strategies that show the answer of a property `multi(…)` in the only initial state; none if no strategy
    /// satisfies its bounds.
    ///
    /// # Errors
    /// The property is another one; there are several initial states; the errors of [`Evaluator::answer`].
    pub fn mix(&self, term: &Term) -> Result<Mix> {
        let Objectives { arena, start, read, .. } = self.objectives(term)?;
        let objectives: Vec<Objective<'_>> = read.iter().map(Read::objective).collect();
        let found = mixed(arena, arena.number(&start), &objectives, self.model.precision);
        let (_, parts) = found.map_err(|error| self.placed(term, error))?;
        let strategy = |part: Part| {
            let value =
                |(x, own): (Ratio, &Read)| if own.negated { Ratio::from_integer(1.into()) - x } else { x };
            MixedStrategy {
                share: part.share,
                values: part.values.into_iter().zip(&read).map(value).collect(),
                nodes: part.nodes.into_iter().map(|node| (arena.state(node.state), node)).collect(),
            }
        };
        let great = read.iter().map(|own| own.optimum == Optimum::Max).collect();
        Ok(Mix { strategies: parts.into_iter().map(strategy).collect(), great })
    }

    /// Reads the objectives.
    pub(super) fn read(&self, arena: &Arena<'_>, all: &[Term], state: &State) -> Result<Vec<Read>> {
        let mut read = Vec::new();
        for objective in all {
            let TermKind::Operator(measured) = &objective.kind else { continue };
            let Some((of, negated)) = self.summed(arena, measured, state)? else {
                return Err(self.of_other_kind(objective));
            };
            let (optimum, bound) = self.wanted(objective, measured)?;
            read.push(Read { of, optimum, bound, negated });
        }
        Ok(read)
    }

    /// Lets an error point at the property.
    fn placed(&self, term: &Term, error: Error) -> Error {
        match error {
            Error::Usage(message) => self.wrong(term, message).into(),
            other => other,
        }
    }

    /// Returns the answer in a state, and whether the number asked for is 1 minus its value.
    fn several(&self, term: &Term, all: &[Term], state: &State, precision: f64) -> Result<(Several, bool)> {
        let arena: &Arena<'_> = self.model.arena()?;
        let read = self.read(arena, all, state)?;
        let objectives: Vec<Objective<'_>> = read.iter().map(Read::objective).collect();
        self.settle(arena);
        let found = several(arena, arena.number(state), &objectives, precision);
        let mut found = found.map_err(|error| self.placed(term, error))?;
        if let Several::Front(points) = &mut found {
            for (at, _) in read.iter().enumerate().filter(|(_, own)| own.negated) {
                points.iter_mut().for_each(|point| point[at] = 1.0 - point[at]);
            }
        }
        Ok((found, read.iter().any(|own| own.bound.is_none() && own.negated)))
    }

    /// Returns what an objective counts, and whether it asks for 1 minus this; `None` for other kinds.
    fn summed(&self, arena: &Arena<'_>, measured: &Measured, state: &State) -> Result<Option<(Of, bool)>> {
        let (structure, accumulated) = match &measured.measure {
            Measure::Probability(path) => return self.followed(arena, path, state),
            Measure::Reward(structure, accumulated) => (structure, accumulated),
            Measure::LongRun(_) => return Ok(None),
        };
        let unknown = || Error::Usage("unknown reward structure".to_owned());
        let structure = structure.find(self.program).ok_or_else(unknown)?;
        let rewards = || arena.rewards(self.engine, structure);
        Ok(match accumulated {
            Accumulated::Total => Some((Of::Total(rewards()?), false)),
            Accumulated::Within(steps) => match u32::try_from(*steps) {
                Ok(steps) => Some((Of::Within(rewards()?, steps), false)),
                Err(_) => None,
            },
            Accumulated::Until(path) if path.recurring.is_none() => {
                match self.visited(path.single.as_ref(), state)? {
                    Some(Visited { left: None, right, negated: false }) => {
                        Some((Of::Before(rewards()?, arena.members(self.engine, &right)?), false))
                    }
                    _ => None,
                }
            }
            _ => None,
        })
    }

    /// Returns the sets of a formula, and whether it is the negation of that over the sets; `None` for other formulas.
    fn followed(&self, arena: &Arena<'_>, path: &Path, state: &State) -> Result<Option<(Of, bool)>> {
        if let Some((term, negated)) = &path.recurring {
            let set = self.states(term, &self.engine.all_states())?;
            return Ok(Some((Of::Recur(arena.members(self.engine, &set)?), *negated)));
        }
        let Some(found) = self.visited(path.single.as_ref(), state)? else { return Ok(None) };
        let members = |set: &E::States| arena.members(self.engine, set);
        let left = found.left.as_ref().map(members).transpose()?;
        Ok(Some((Of::Until(left, members(&found.right)?), found.negated)))
    }

    /// Returns whether an objective is to be great or small, and its bound.
    fn wanted(&self, term: &Term, measured: &Measured) -> Result<(Optimum, Option<Ratio>)> {
        match &measured.bound {
            None => Ok((measured.optimum, None)),
            Some((Inequality::Ge, bound)) => Ok((Optimum::Max, Some(bound.clone()))),
            Some((Inequality::Le, bound)) => Ok((Optimum::Min, Some(bound.clone()))),
            Some(_) => {
                let message = "strict bounds are not supported in `multi`";
                Err(self.unsupported(term, message, "write `>=` or `<=`"))
            }
        }
    }

    /// Returns the parts of a formula that asks to visit states, or of its negation; `None` for other formulas.
    fn visited(&self, single: Option<&Single>, state: &State) -> Result<Option<Visited<E::States>>> {
        let all = self.engine.all_states();
        let Some(Single { negated, step }) = single else { return Ok(None) };
        let (left, right) = match step {
            Step::Until { left, right, least: 0, most: None } => {
                let left = left.as_ref().map(|left| self.states(left, &all)).transpose()?;
                (left, self.states(right, &all)?)
            }
            Step::Now(now) => match self.engine.contains(&self.states(now, &all)?, state)? {
                true => (None, all),
                false => (None, self.engine.no_states()),
            },
            _ => return Ok(None),
        };
        Ok(Some(Visited { left, right, negated: *negated }))
    }

    fn of_other_kind(&self, term: &Term) -> Error {
        let message = "objectives of `multi` are `P` with `F`, `G`, `U`, `G F` or `F G` over states, and `R` with `F`, `C` or `C<=k`";
        self.unsupported(term, message, "PRISM and Storm compute other formulas")
    }
}
