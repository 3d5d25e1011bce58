//! Choices in end components that visit some sets again and again.

use bitvec::vec::BitVec;
use meliora_base::error::Result;

use super::{Accepting, Choices};
use meliora_equations::{Arena, NONE};

/// End components in which a condition can be kept, with the choices that visit its sets one after the other.
pub(super) struct Rounds {
    /// The component of each state, or [`NONE`]: of several, that of the first condition.
    component: Vec<u32>,
    /// The sets that each component visits.
    sets: Vec<Vec<BitVec>>,
    /// The choices by the number of the set that is visited next.
    choices: Vec<Choices>,
}

impl Rounds {
    /// Finds the components of some conditions. Cost: linear for each condition and each of its sets.
    ///
    /// # Errors
    /// The work is cancelled.
    pub(super) fn new(arena: &Arena<'_>, all: &[Accepting]) -> Result<Self> {
        let mut rounds =
            Rounds { component: vec![NONE; arena.states()], sets: Vec::new(), choices: Vec::new() };
        for condition in all {
            rounds.add(arena, condition)?;
        }
        Ok(rounds)
    }

    fn add(&mut self, arena: &Arena<'_>, condition: &Accepting) -> Result<()> {
        let (always, again) = (&condition.always, &condition.again);
        let mut inside = Vec::with_capacity(arena.choices_in_all());
        for state in 0..arena.states() {
            let stays = |choice: usize| {
                always[state] && arena.choices.successors(choice).iter().all(|&to| always[to as usize])
            };
            inside.extend(arena.choices.of(state as u32).map(stays));
        }
        let mut meter = arena.meter();
        let found = arena.choices.end_components_among(inside, &mut meter)?;
        let stays = |state: usize| arena.choices.of(state as u32).any(|choice| found.inside[choice]);
        let mut meets = vec![0u64; found.count];
        for (number, set) in again.iter().enumerate() {
            let met = set.iter_ones().filter(|&state| stays(state));
            met.for_each(|state| meets[found.group[state] as usize] |= 1 << number);
        }
        let all_met = (1u64 << again.len()) - 1;
        let mut numbers = vec![NONE; found.count];
        for state in (0..arena.states()).filter(|&state| stays(state)) {
            let group = found.group[state] as usize;
            if meets[group] == all_met && self.component[state] == NONE {
                if numbers[group] == NONE {
                    numbers[group] = self.sets.len() as u32;
                    self.sets.push(again.clone());
                }
                self.component[state] = numbers[group];
            }
        }
        let own = |state: usize| {
            let number = self.component[state];
            number != NONE && numbers.get(found.group[state] as usize) == Some(&number)
        };
        let kept: BitVec = found.inside.iter().collect();
        for number in 0..again.len().max(1) {
            if self.choices.len() == number {
                self.choices.push(vec![NONE; arena.states()]);
            }
            let nearer =
                again.get(number).map(|set| arena.toward(&kept, set, None, &mut meter)).transpose()?;
            for state in (0..arena.states()).filter(|&state| own(state)) {
                let nearer = nearer.as_ref().map(|all| all[state]).filter(|&choice| choice != NONE);
                let first = || arena.choices.of(state as u32).find(|&choice| kept[choice]);
                let choice = nearer.or_else(|| first().map(|choice| choice as u32));
                self.choices[number][state] = choice.unwrap_or(NONE);
            }
        }
        Ok(())
    }

    /// Returns the states of all components.
    pub(super) fn members(&self) -> BitVec {
        self.component.iter().map(|&component| component != NONE).collect()
    }

    /// Returns the choice of a state of a component in a round.
    pub(super) fn choice(&self, state: usize, round: u32) -> Option<u32> {
        (self.component[state] != NONE).then(|| self.choices[round as usize][state])
    }

    /// Returns the round in which a path enters a state from another one, or begins.
    pub(super) fn entered(&self, from: Option<(usize, u32)>, to: usize) -> u32 {
        let component = self.component[to];
        let Some(sets) = self.sets.get(component as usize).filter(|sets| !sets.is_empty()) else { return 0 };
        let same = from.filter(|(from, _)| self.component[*from] == component);
        let (begin, count) = (same.map_or(0, |(_, round)| round as usize), sets.len());
        let open = (0..count).map(|more| (begin + more) % count).find(|&round| !sets[round][to]);
        open.unwrap_or_default() as u32
    }
}
