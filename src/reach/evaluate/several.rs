//! Several objectives at once: `multi(…)`.

use super::operators::position;
use super::{At, Evaluator, Number};
use meliora_base::error::{Error, Result};
use meliora_base::exact::Ratio;
use meliora_engine::Engine;
use meliora_lang::property::term::{Accumulated, Measure, Measured, Single, Step, Term, TermKind};
use meliora_lang::property::{Inequality, Optimum};
use meliora_model::State;
use meliora_quantities::equations::arena::Arena;
use meliora_quantities::several::{Counted, Objective, Several, several};

/// The positions of the sets or of the rewards of an objective.
enum Of {
    Until(usize, usize),
    Recur(usize),
    Total(usize),
    Within(usize, u32),
}

/// An objective.
struct Read {
    of: Of,
    optimum: Optimum,
    bound: Option<Ratio>,
    /// The number asked for is 1 minus that of the objective.
    negated: bool,
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
                let found = Number::between(found.lower, found.upper);
                Ok(if negated { found.complemented() } else { found })
            }
            (Several::Best(None), _) => {
                Err(self.wrong(term, "no strategy satisfies the bounds of the objectives").into())
            }
            _ => Err(self.wrong(term, "the best values of two objectives are not a number").into()),
        };
        at.list.iter().map(value).collect()
    }

    /// Returns the Pareto front of two objectives without bounds in the only initial state; `None` for others.
    pub(super) fn front(&self, term: &Term) -> Result<Option<Vec<[f64; 2]>>> {
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

    /// Returns the answer in a state, and whether the number asked for is 1 minus its value.
    fn several(&self, term: &Term, all: &[Term], state: &State, precision: f64) -> Result<(Several, bool)> {
        let arena: &Arena<'_> = self.model.arena()?;
        let (mut sets, mut rewards, mut read) = (Vec::new(), Vec::new(), Vec::new());
        for objective in all {
            let TermKind::Operator(measured) = &objective.kind else { continue };
            let (optimum, bound) = self.wanted(objective, measured)?;
            match &measured.measure {
                Measure::Probability(path) => {
                    let (targets, negated) = match (&path.recurring, path.single.as_ref()) {
                        (Some((term, negated)), _) => {
                            (vec![self.states(term, &self.engine.all_states())?], *negated)
                        }
                        (None, single) => match self.visited(single, state)? {
                            Some((passed_and_visited, negated)) => (Vec::from(passed_and_visited), negated),
                            None => return Err(self.of_other_kind(objective)),
                        },
                    };
                    for target in &targets {
                        sets.push(arena.members(self.engine, target)?);
                    }
                    let last = sets.len() - 1;
                    let of = if targets.len() == 1 { Of::Recur(last) } else { Of::Until(last - 1, last) };
                    let flipped = if optimum == Optimum::Max { Optimum::Min } else { Optimum::Max };
                    let optimum = if negated { flipped } else { optimum };
                    let one = Ratio::from_integer(1.into());
                    let bound = bound.map(|bound| if negated { one - bound } else { bound });
                    read.push(Read { of, optimum, bound, negated });
                }
                Measure::Reward(structure, accumulated) => {
                    let unknown = || Error::Usage("unknown reward structure".to_owned());
                    let structure = structure.find(self.program).ok_or_else(unknown)?;
                    let of = match accumulated {
                        Accumulated::Total => Of::Total(rewards.len()),
                        Accumulated::Within(steps) => {
                            let steps = u32::try_from(*steps).map_err(|_| self.of_other_kind(objective))?;
                            Of::Within(rewards.len(), steps)
                        }
                        _ => return Err(self.of_other_kind(objective)),
                    };
                    rewards.push(arena.rewards(self.engine, structure)?);
                    read.push(Read { of, optimum, bound, negated: false });
                }
                _ => return Err(self.of_other_kind(objective)),
            }
        }
        let objective = |own: &Read| {
            let counted = match own.of {
                Of::Until(left, right) => Counted::Until(&sets[left], &sets[right]),
                Of::Recur(at) => Counted::Recur(&sets[at]),
                Of::Total(at) => Counted::Total(&rewards[at]),
                Of::Within(at, steps) => Counted::Within(&rewards[at], steps),
            };
            Objective { counted, optimum: own.optimum, bound: own.bound.clone() }
        };
        let objectives: Vec<Objective<'_>> = read.iter().map(objective).collect();
        let negated = read.iter().any(|own| own.bound.is_none() && own.negated);
        let open = read.iter().filter(|own| own.bound.is_none()).count();
        if negated && open > 1 {
            return Err(self.unsupported(term, "a Pareto front of `G` is not supported", "ask for `F`"));
        }
        Ok((several(arena, position(arena, state), &objectives, precision)?, negated))
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

    /// Returns the states through which a formula asks to visit others, these, and whether the formula is negated; `None`
    /// for other formulas.
    fn visited(&self, single: Option<&Single>, state: &State) -> Result<Option<([E::States; 2], bool)>> {
        let all = self.engine.all_states();
        let Some(Single { negated, step }) = single else { return Ok(None) };
        let (left, right) = match step {
            Step::Until { left, right, least: 0, most: None } => {
                let left = left.as_ref().map(|left| self.states(left, &all)).transpose()?;
                (left.unwrap_or_else(|| all.clone()), self.states(right, &all)?)
            }
            Step::Now(now) => match self.engine.contains(&self.states(now, &all)?, state)? {
                true => (all.clone(), all),
                false => (all, self.engine.no_states()),
            },
            _ => return Ok(None),
        };
        Ok(Some(([left, right], *negated)))
    }

    fn of_other_kind(&self, term: &Term) -> Error {
        let message = "objectives of `multi` are `P` with `F`, `G`, `U`, `G F` or `F G` over states, and `R` with `C` or `C<=k`";
        self.unsupported(term, message, "PRISM and Storm compute other formulas")
    }
}
