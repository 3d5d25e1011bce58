//! The operators of the engine interface on bit sets.

use super::almost_sure::{Entering, Plain, Table};
use super::marks::Marks;
use super::{ChoiceSet, ExplicitEngine, Space, StateSet};
use crate::edge_labels::{self, EdgeLabels};
use crate::engine::{Algebra, Engine, Region, Won};
use crate::membership::Membership;
use crate::settings::{Count, Settings, Usage};
use meliora_base::error::{Error, Result};
use meliora_base::progress::Poll;
use meliora_model::predicate::Predicate;
use meliora_model::step::Choice;
use meliora_model::{ModelKind, State, VarId, fault};
use meliora_space::compile::Compiler;
use meliora_space::expand;
use meliora_space::known::Known;
use meliora_space::machine::Machine;
use meliora_space::set::{BitSet, set, test};

macro_rules! algebra_of {
    ($set:ident) => {
        impl Algebra<$set> for ExplicitEngine {
            fn union(&self, x: &$set, y: &$set) -> Result<$set> {
                Ok($set(self.bits(x)?.zip(self.bits(y)?, |a, b| a | b)?))
            }

            fn intersection(&self, x: &$set, y: &$set) -> Result<$set> {
                Ok($set(self.bits(x)?.zip(self.bits(y)?, |a, b| a & b)?))
            }

            fn difference(&self, x: &$set, y: &$set) -> Result<$set> {
                Ok($set(self.bits(x)?.zip(self.bits(y)?, |a, b| a & !b)?))
            }

            fn is_empty(&self, x: &$set) -> Result<bool> {
                Ok(self.bits(x)?.is_empty())
            }

            fn same(&self, x: &$set, y: &$set) -> Result<bool> {
                Ok(self.bits(x)?.same(self.bits(y)?))
            }

            fn count(&self, x: &$set) -> Result<Count> {
                Ok(self.bits(x)?.count().into())
            }
        }
    };
}

algebra_of!(StateSet);
algebra_of!(ChoiceSet);

impl Engine for ExplicitEngine {
    type States = StateSet;
    type Choices = ChoiceSet;

    fn all_states(&self) -> StateSet {
        StateSet(self.every_state.clone())
    }

    fn no_states(&self) -> StateSet {
        StateSet(BitSet::empty(&self.meter, self.graph.states()))
    }

    fn initial_states(&self) -> StateSet {
        StateSet(self.initial.clone())
    }

    fn deadlock_states(&self) -> StateSet {
        StateSet(self.deadlocks.clone())
    }

    fn is_markov_chain(&self) -> bool {
        self.program.kind == ModelKind::Dtmc
    }

    fn drawing_states(&self) -> Option<Count> {
        Some(Count::from(self.drawing))
    }

    fn rounded_state(&self) -> Option<&State> {
        self.rounded.as_ref()
    }

    fn states_where(&self, predicate: &Predicate) -> Result<StateSet> {
        predicate.check(&self.program)?;
        let mut poll = Poll::new(&*self.settings.sink);
        let mut compiler = Compiler::new(&self.program, predicate.pool(), &[predicate.id()], &mut poll)?;
        let start = compiler.condition(predicate.id()).start;
        let code = compiler.finish();
        let mut machine = Machine::new(&code);
        let support = predicate.pool().support(predicate.id());
        let mut known = Known::new(self.layout.mask(support.iter().map(|v| v.index())));
        let mut holds = BitSet::empty(&self.meter, self.graph.states());
        let words = holds.words_mut();
        for state in self.every_state.iter() {
            self.tick()?;
            let evaluate = |packed: &[u64]| {
                for v in &support {
                    machine.regs[v.index()] = self.layout.value(packed, v.index());
                }
                machine.next_state();
                machine.run(&code, start)
            };
            match self.with_code(state, |code| known.get(code, evaluate)) {
                Ok(true) => set(words, state),
                Ok(false) => {}
                Err(_) => return Err(fault::in_predicate(&self.program, predicate, &self.values(state))),
            }
        }
        Ok(StateSet(holds))
    }

    fn all_choices(&self) -> ChoiceSet {
        ChoiceSet(self.every_choice.clone())
    }

    fn no_choices(&self) -> ChoiceSet {
        ChoiceSet(BitSet::empty(&self.meter, self.graph.choices()))
    }

    fn restricted_to(&self, region: &Region<StateSet, ChoiceSet>) -> Result<Self> {
        let (every_state, every_choice) =
            (self.bits(&region.states)?.clone(), self.bits(&region.choices)?.clone());
        Ok(ExplicitEngine { every_state, every_choice, ..self.clone() })
    }

    fn choices_in(&self, c: &ChoiceSet, x: &StateSet) -> Result<ChoiceSet> {
        Ok(ChoiceSet(self.choices_of_states(self.bits(c)?, self.bits(x)?)?))
    }

    fn sources(&self, c: &ChoiceSet) -> Result<StateSet> {
        let choices = self.bits(c)?.words();
        let mut found = BitSet::empty(&self.meter, self.graph.states());
        let words = found.words_mut();
        for state in 0..self.graph.states() {
            if self.graph.choices_of(state).any(|choice| test(choices, choice)) {
                set(words, state);
            }
        }
        Ok(StateSet(found))
    }

    fn can_choose(&self, c: &ChoiceSet) -> Result<StateSet> {
        Ok(StateSet(self.without_escapes(self.sources(c)?.0, self.bits(c)?)?))
    }

    fn theirs(&self) -> Option<StateSet> {
        self.opponent().map(|theirs| StateSet(theirs.clone()))
    }

    fn player_states(&self) -> Vec<StateSet> {
        self.states_by_player()
    }

    fn coalition(&self) -> Vec<bool> {
        self.game.as_ref().map_or_else(Vec::new, |game| game.coalition.clone())
    }

    fn with_coalition(&self, coalition: &[bool]) -> Result<Self> {
        self.played_by(coalition)
    }

    fn pre(&self, c: &ChoiceSet, x: &StateSet) -> Result<ChoiceSet> {
        Ok(ChoiceSet(self.choices_into(self.bits(c)?, self.bits(x)?)?))
    }

    fn post(&self, c: &ChoiceSet) -> Result<StateSet> {
        let mut found = BitSet::empty(&self.meter, self.graph.states());
        let words = found.words_mut();
        for choice in self.bits(c)?.iter() {
            self.tick()?;
            for &s in self.graph.successors_of(choice) {
                set(words, s as usize);
            }
        }
        Ok(StateSet(found))
    }

    fn can_reach(
        &self,
        target: &StateSet,
        within: &ChoiceSet,
        edge_labels: &[EdgeLabels<StateSet>],
    ) -> Result<StateSet> {
        let (target, within) = (self.bits(target)?, self.bits(within)?);
        self.check_owned(edge_labels)?;
        let plain = edge_labels.iter().all(|labels| labels.dropped.0.is_empty());
        Ok(StateSet(match (self.opponent(), plain) {
            (None, true) => self.attract(target, within, &Entering(target.words()))?,
            (None, false) => self.attract(target, within, &Table::new(self, edge_labels)?)?,
            (Some(_), true) => self.attract_in_game(target, None, within, &Entering(target.words()))?,
            (Some(_), false) => {
                self.attract_in_game(target, None, within, &Table::new(self, edge_labels)?)?
            }
        }))
    }

    fn can_win(
        &self,
        winning: &ChoiceSet,
        within: &ChoiceSet,
        edge_labels: &[EdgeLabels<StateSet>],
    ) -> Result<StateSet> {
        if self.opponent().is_none() {
            return edge_labels::reach_winning(self, winning, within, edge_labels);
        }
        let (winning, within) = (self.bits(winning)?, self.bits(within)?);
        self.check_owned(edge_labels)?;
        let rules = Table::new(self, edge_labels)?;
        let nothing = BitSet::empty(&self.meter, self.graph.states());
        Ok(StateSet(self.attract_in_game(&nothing, Some(winning), within, &rules)?))
    }

    fn remove_attractor(
        &self,
        left: Region<StateSet, ChoiceSet>,
        within: &ChoiceSet,
        won: &StateSet,
        edge_labels: &[EdgeLabels<StateSet>],
        lost: StateSet,
    ) -> Result<Region<StateSet, ChoiceSet>> {
        let Region { states, choices } = left;
        let left = Region { states: self.bits(&states)?.copy()?, choices: self.bits(&choices)?.copy()? };
        self.bits(within)?;
        self.check_owned(edge_labels)?;
        let (won, lost) = (self.bits(won)?, self.bits(&lost)?);
        let Region { states, choices } = match edge_labels.is_empty() {
            true => self.without_attractor(left, won, lost, &Plain)?,
            false => self.without_attractor(left, won, lost, &Table::new(self, edge_labels)?)?,
        };
        Ok(Region { states: StateSet(states), choices: ChoiceSet(choices) })
    }

    fn stay_within(&self, x: &StateSet, within: &ChoiceSet) -> Result<Region<StateSet, ChoiceSet>> {
        let Region { states, choices } = self.remain(self.bits(x)?, self.bits(within)?)?;
        Ok(Region { states: StateSet(states), choices: ChoiceSet(choices) })
    }

    fn almost_surely_reach(
        &self,
        target: &StateSet,
        within: &ChoiceSet,
    ) -> Result<Region<StateSet, ChoiceSet>> {
        let goal = self.bits(target)?;
        // States without a pair are lost.
        let alive = self.union(&self.can_choose(within)?, target)?;
        let lost = self.difference(&self.all_states(), &alive)?;
        let outside = self.bits(&alive)?.zip(goal, |alive, t| alive & !t)?;
        let choices = self.choices_of_states(self.bits(within)?, &outside)?;
        let (Region { states, choices }, _) =
            self.pursue(&outside, choices, (&Entering(goal.words()), goal), &lost.0)?;
        let states = states.zip(goal, |x, t| x | t)?;
        Ok(Region { states: StateSet(states), choices: ChoiceSet(choices) })
    }

    fn almost_surely_win(
        &self,
        start: Region<StateSet, ChoiceSet>,
        edge_labels: &[EdgeLabels<StateSet>],
    ) -> Result<Won<StateSet, ChoiceSet>> {
        self.check_owned(edge_labels)?;
        self.bits(&start.choices)?;
        let (states, choices, lost) = (self.bits(&start.states)?, start.choices.0, self.no_states().0);
        let (Region { states, choices }, possible) = match edge_labels {
            // All edges of the game have these labels.
            [all] if all.dropped.0.is_empty() && states.zip(&all.from.0, |x, y| x & !y)?.is_empty() => {
                self.pursue(states, choices, (&Entering(all.goal.0.words()), &all.goal.0), &lost)?
            }
            _ => {
                let rules = Table::new(self, edge_labels)?;
                let mut goal = self.no_states().0;
                rules.add_goal(&mut goal);
                self.pursue(states, choices, (&rules, &goal), &lost)?
            }
        };
        let region = Region { states: StateSet(states), choices: ChoiceSet(choices) };
        Ok(Won { region, possible: possible.map(StateSet) })
    }

    fn count_model_states(&self, x: &StateSet) -> Result<Option<Count>> {
        let x = self.bits(x)?;
        let Some(monitors) = &self.program.monitors else { return Ok(None) };
        let mut seen = ahash::AHashSet::new();
        for state in x.iter() {
            self.tick()?;
            let mut code: Vec<u64> = Vec::new();
            self.with_code(state, |own| code.extend_from_slice(own));
            for variable in &monitors.variables {
                let field = self.layout.field(variable.index());
                let value = self.layout.value(&code, variable.index());
                field.add(&mut code, value, 0);
            }
            seen.insert(code);
        }
        Ok(Some(seen.len().into()))
    }

    fn count_transitions(&self, c: &ChoiceSet, x: &StateSet) -> Result<Count> {
        let (c, x) = (self.bits(c)?, self.bits(x)?);
        let (choices, states) = (self.graph.choices(), self.graph.states());
        if c.count() == choices as u64 && x.count() == states as u64 {
            return Ok(self.graph.transitions_of(0..choices).into());
        }
        let words = x.words();
        let mut total: u64 = 0;
        for choice in c.iter() {
            self.tick()?;
            let inside = self.graph.successors_of(choice).iter().filter(|&&s| test(words, s as usize));
            total += inside.count() as u64;
        }
        Ok(total.into())
    }

    fn list_states(&self, x: &StateSet, limit: usize) -> Result<Vec<State>> {
        let x = self.bits(x)?;
        if limit == 0 {
            return Ok(Vec::new());
        }
        let ordered: Vec<usize> = match &*self.space {
            Space::Every(_) => x.iter().take(limit).collect(),
            Space::Indexed(index) => {
                let mut all: Vec<usize> = x.iter().collect();
                // Codes compare as the values do.
                if let Some(last) = limit.checked_sub(1).filter(|&last| last < all.len()) {
                    all.select_nth_unstable_by_key(last, |&s| index.code(s));
                    all.truncate(limit);
                }
                all.sort_unstable_by_key(|&s| index.code(s));
                all
            }
        };
        Ok(ordered.into_iter().map(|s| self.values(s)).collect())
    }

    fn singleton(&self, state: &[i64]) -> Result<StateSet> {
        let mut only = BitSet::empty(&self.meter, self.graph.states());
        if let Some(state) = self.number(state).filter(|&s| self.every_state.has(s)) {
            set(only.words_mut(), state);
        }
        Ok(StateSet(only))
    }

    fn set_of(&self, states: &mut dyn Iterator<Item = State>) -> Result<StateSet> {
        let mut set_of = BitSet::empty(&self.meter, self.graph.states());
        let numbers = states.filter_map(|state| self.number(&state));
        numbers.filter(|&s| self.every_state.has(s)).for_each(|s| set(set_of.words_mut(), s));
        Ok(StateSet(set_of))
    }

    fn slice(&self, fixed: &[(VarId, i64)]) -> Result<StateSet> {
        let fits = |state: &[i64]| fixed.iter().all(|&(variable, value)| state[variable.index()] == value);
        self.filter(&self.all_states(), &mut |state| fits(state))
    }

    fn contains(&self, x: &StateSet, state: &[i64]) -> Result<bool> {
        let x = self.bits(x)?;
        Ok(self.number(state).is_some_and(|s| x.has(s)))
    }

    fn membership<'e>(&'e self, sets: &[&StateSet]) -> Result<Box<dyn Membership + 'e>> {
        let sets = sets.iter().map(|x| self.bits(*x).cloned()).collect::<Result<_>>()?;
        Ok(Box::new(Marks { engine: self, sets }))
    }

    fn contains_choice(&self, c: &ChoiceSet, state: &[i64], choice: &Choice) -> Result<bool> {
        let c = self.bits(c)?;
        let Some(state) = self.number(state) else { return Ok(false) };
        let position = self.position(state, choice)?;
        Ok(position.is_some_and(|p| c.has(self.graph.choices_of(state).start + p)))
    }

    fn usage(&self) -> Usage {
        Usage { bytes: self.meter.peak(), ..Usage::default() }
    }

    fn settings(&self) -> &Settings {
        &self.settings
    }
}

impl ExplicitEngine {
    /// Returns the bits of a set of this engine.
    ///
    /// # Errors
    /// The set belongs to another engine.
    pub(super) fn bits<'s>(&self, x: &'s impl AsRef<BitSet>) -> Result<&'s BitSet> {
        let bits = x.as_ref();
        if bits.is_of(&self.meter) { Ok(bits) } else { Err(Error::ForeignSet) }
    }

    /// Checks that edge labels have sets of this engine only.
    ///
    /// # Errors
    /// A set belongs to another engine.
    fn check_owned(&self, edge_labels: &[EdgeLabels<StateSet>]) -> Result<()> {
        let mut sets = edge_labels.iter().flat_map(EdgeLabels::sets);
        sets.try_for_each(|x| self.bits(x).map(drop))
    }

    /// Returns the number of a state; `None` outside the scope.
    pub(super) fn number(&self, values: &[i64]) -> Option<usize> {
        self.space.find(&self.layout.encode(values)?)
    }

    /// Returns the values of a state.
    pub(super) fn values(&self, state: usize) -> State {
        let mut values = vec![0; self.program.variables.len()];
        self.with_code(state, |code| self.layout.decode(code, &mut values));
        values
    }

    #[inline]
    pub(super) fn with_code<T>(&self, state: usize, read: impl FnOnce(&[u64]) -> T) -> T {
        match &*self.space {
            Space::Indexed(index) => read(index.code(state)),
            Space::Every(_) => read(&[state as u64]),
        }
    }

    /// Returns the position of `choice` among the choices of a state, from 0; `None` if it is not
    /// enabled.
    ///
    /// # Errors
    /// A command has no meaning in the state.
    fn position(&self, state: usize, choice: &Choice) -> Result<Option<usize>> {
        // With monitors, the self-loop of a deadlock is a command of theirs.
        let stuck = self.deadlocks.has(state) && !self.prepared.steps_alone();
        let (wanted, commands) = match choice {
            Choice::Deadlock => return Ok(stuck.then_some(0)),
            Choice::Uniform => return Ok((self.prepared.is_uniform() && !stuck).then_some(0)),
            Choice::Combination { synchronisation, commands } => (*synchronisation, commands),
        };
        if self.prepared.is_uniform() {
            return Ok(None);
        }
        let mut stepper = expand::stepper(&self.prepared, self.layout.words());
        self.with_code(state, |code| stepper.enter(&self.layout, code));
        let found = stepper.position(wanted, &mut commands.iter().map(|command| command.0));
        found.map_err(|broken| broken.error(&self.program, &self.values(state)))
    }
}
