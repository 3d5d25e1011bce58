//! Filters: functions of the values in several states.

use std::cmp::Ordering;

use super::{At, Evaluator, Number};
use meliora_base::error::Result;
use meliora_base::exact::{Exact, Ratio};
use meliora_engine::Engine;
use meliora_lang::ast::BinaryOp;
use meliora_lang::property::term::{Filter, FilterFunction, Term};

impl<E: Engine> Evaluator<'_, '_, E> {
    /// Returns the states that a filter is about.
    pub(super) fn chosen(&self, filter: &Filter) -> Result<E::States> {
        let all = self.engine.all_states();
        match &filter.states {
            Some(states) => self.states(states, &all),
            None => Ok(all),
        }
    }

    /// Returns the truth of a filter over a condition.
    pub(super) fn truth(&self, term: &Term, filter: &Filter) -> Result<bool> {
        let chosen = self.chosen(filter)?;
        let among = match filter.function {
            FilterFunction::State | FilterFunction::First => self.one(term, filter, &chosen)?.set,
            _ => chosen,
        };
        let satisfied = self.states(&filter.of, &among)?;
        match filter.function {
            FilterFunction::Exists => Ok(!self.engine.is_empty(&satisfied)?),
            _ => self.engine.is_empty(&self.engine.difference(&among, &satisfied)?),
        }
    }

    /// Returns the only state, or the first one.
    fn one(&self, term: &Term, filter: &Filter, chosen: &E::States) -> Result<At<E::States>> {
        let mut list = self.engine.list_states(chosen, 2)?;
        let name = <&str>::from(filter.function);
        let message = match list.len() {
            0 => format!("no state satisfies the condition of the filter `{name}`"),
            2 if filter.function == FilterFunction::State => {
                "several states satisfy the condition of the filter `state`".to_owned()
            }
            _ => {
                list.truncate(1);
                return Ok(At { set: self.engine.singleton(&list[0])?, list });
            }
        };
        let examples: Vec<String> = list.iter().map(|state| self.program.show_state(state)).collect();
        let label = if examples.is_empty() { "none".to_owned() } else { examples.join("; ") };
        Err(self.wrong(term, message).label(label).into())
    }

    /// Returns the value of a filter in listed states; the same in all, unless the filter prints.
    pub(super) fn filtered(
        &self,
        term: &Term,
        filter: &Filter,
        at: &At<E::States>,
        exact: bool,
    ) -> Result<Vec<Number>> {
        use FilterFunction::{Count, First, Print, Printall, State};
        let value = match filter.function {
            Print | Printall => return self.numbers(&filter.of, at, exact),
            Count => self.counted(&self.states(&filter.of, &self.chosen(filter)?)?)?,
            State | First => {
                let one = self.one(term, filter, &self.chosen(filter)?)?;
                return Ok(vec![self.numbers(&filter.of, &one, exact)?.swap_remove(0); at.list.len()]);
            }
            _ => self.folded(term, filter, exact)?,
        };
        Ok(vec![value; at.list.len()])
    }

    fn folded(&self, term: &Term, filter: &Filter, exact: bool) -> Result<Number> {
        use FilterFunction::{Avg, Max, Min, Sum};
        let chosen = self.at(&self.chosen(filter)?)?;
        let values = self.numbers(&filter.of, &chosen, exact)?;
        let add = |x: &Number, y: &Number| {
            x.arithmetic(BinaryOp::Add, y).map_err(|e| self.wrong(term, e.to_string()).into())
        };
        let Some((first, rest)) = values.split_first() else {
            if filter.function == Sum {
                return Ok(Number::of(Exact::Int(0)));
            }
            let name = <&str>::from(filter.function);
            let message = format!("no state satisfies the condition of the filter `{name}`");
            return Err(self.wrong(term, message).into());
        };
        match filter.function {
            Min | Max => Ok(rest.iter().fold(first.clone(), |x, y| x.extreme(y, filter.function == Max))),
            Sum => rest.iter().try_fold(first.clone(), |x, y| add(&x, y)),
            Avg => {
                let sum = rest.iter().try_fold(first.clone(), |x, y| add(&x, y))?;
                let count = Number::fraction(&Ratio::from_integer(values.len().into()));
                sum.arithmetic(BinaryOp::Div, &count).map_err(|e| self.wrong(term, e.to_string()).into())
            }
            _ => Ok(rest.iter().fold(first.clone(), |x, y| x.range(y))),
        }
    }

    /// Returns the states with the least or the greatest value.
    pub(super) fn extreme_states(&self, filter: &Filter, chosen: &E::States) -> Result<E::States> {
        let at = self.at(chosen)?;
        let greatest = filter.function == FilterFunction::Argmax;
        let mut values = self.numbers(&filter.of, &at, false)?;
        if !are_ordered(&values) {
            values = self.numbers(&filter.of, &at, true)?;
        }
        let Some(best) = values.iter().cloned().reduce(|x, y| x.extreme(&y, greatest)) else {
            return Ok(self.engine.no_states());
        };
        let is_best = |x: &Number| x.compare(&best).map_or(x == &best, |order| order == Ordering::Equal);
        let states = at.list.iter().zip(&values).filter(|(_, x)| is_best(x));
        self.set_where(&states.map(|(state, _)| state.clone()).collect::<Vec<_>>())
    }

    /// Returns the number of some states.
    fn counted(&self, states: &E::States) -> Result<Number> {
        let whole = self.engine.count(states)?;
        Ok(Number::fraction(&Ratio::from_integer(whole.into())))
    }
}

/// Returns whether the bounds of some values decide how each two compare.
fn are_ordered(values: &[Number]) -> bool {
    let mut sorted: Vec<&Number> = values.iter().collect();
    sorted.sort_by(|x, y| x.interval.lower.total_cmp(&y.interval.lower));
    sorted.windows(2).all(|two| two[0].compare(two[1]).is_some())
}
