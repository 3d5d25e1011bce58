//! The choices of states and the successors of choices in compressed sparse rows.

use std::ops::Range;
use std::sync::OnceLock;

use super::meter::{Array, Meter};
use meliora_base::error::{Limit, Result};

/// The choices of each state and the successors of each choice.
#[derive(Debug)]
pub struct Graph {
    /// Start of the choices of each state, with one more entry for the end.
    choices: Array<u32>,
    /// Start of the successors of each choice, with one more entry for the end.
    rows: Array<u32>,
    /// The successors, each once per choice.
    successors: Array<u32>,
    meter: Meter,
    predecessors: OnceLock<Predecessors>,
}

/// The reversed graph.
#[derive(Debug)]
pub struct Predecessors {
    /// Start of the predecessors of each state, with one more entry for the end.
    rows: Array<u32>,
    /// The choices that may lead to each state.
    choices: Array<u32>,
    /// The state of each choice; `None` if every state has one choice, which then has the state's
    /// number.
    owners: Option<Owners>,
}

/// The states of the choices, in blocks of 16: the state of the first choice of each block, and in four
/// bits for each choice how many states later its own is. Fixpoints look states up by choices more often
/// than anything else; 6 bits per choice stay in the caches where 32 do not.
#[derive(Debug)]
struct Owners {
    first: Array<u32>,
    later: Array<u64>,
}

impl Owners {
    /// Returns the block of a choice, and where its bits begin.
    #[inline]
    fn place(choice: usize) -> (usize, usize) {
        (choice / 16, choice % 16 * 4)
    }
}

impl Graph {
    /// Creates a graph without states.
    pub fn new(meter: &Meter) -> Result<Self> {
        let mut graph = Graph {
            choices: Array::new(meter),
            rows: Array::new(meter),
            successors: Array::new(meter),
            meter: meter.clone(),
            predecessors: OnceLock::new(),
        };
        graph.choices.push(0)?;
        graph.rows.push(0)?;
        Ok(graph)
    }

    /// Adds successors to the current choice.
    #[inline]
    pub fn extend(&mut self, states: &[u32]) -> Result<()> {
        match states {
            // Most choices have one successor: a push takes less time than a call to copy memory.
            &[state] => self.successors.push(state),
            _ => self.successors.extend(states),
        }
    }

    /// Ends the current choice; repeated successors count once.
    pub fn end_choice(&mut self) -> Result<()> {
        let start = self.rows.last().copied().unwrap_or(0) as usize;
        let own = &mut self.successors[start..];
        if own.len() > 1 {
            own.sort_unstable();
            let kept = start + keep_once(own);
            self.successors.truncate(kept);
        }
        self.end_row()
    }

    /// Ends the current choice, whose successors are each once.
    #[inline]
    pub(crate) fn end_row(&mut self) -> Result<()> {
        let end = u32::try_from(self.successors.len()).map_err(|_| Limit::Size {
            what: "more than 4294967295 transitions for the explicit engine".into(),
        })?;
        self.rows.push(end)
    }

    /// Ends the current state.
    #[inline]
    pub fn end_state(&mut self) -> Result<()> {
        self.choices.push(self.rows.len() as u32 - 1)
    }

    /// Frees unused capacity.
    pub fn shrink(&mut self) {
        self.choices.shrink();
        self.rows.shrink();
        self.successors.shrink();
    }

    /// Returns the number of states.
    pub fn states(&self) -> usize {
        self.choices.len() - 1
    }

    /// Returns the number of choices.
    pub fn choices(&self) -> usize {
        self.rows.len() - 1
    }

    /// Returns the choices of a state.
    #[inline]
    pub fn choices_of(&self, state: usize) -> Range<usize> {
        self.choices[state] as usize..self.choices[state + 1] as usize
    }

    /// Returns the choices of states that follow each other.
    #[inline]
    pub fn choices_of_range(&self, states: Range<usize>) -> Range<usize> {
        self.choices[states.start] as usize..self.choices[states.end] as usize
    }

    /// Returns the successors of a choice.
    #[inline]
    pub fn successors_of(&self, choice: usize) -> &[u32] {
        &self.successors[self.rows[choice] as usize..self.rows[choice + 1] as usize]
    }

    /// Returns the number of successors of some choices that follow each other.
    #[inline]
    pub fn transitions_of(&self, choices: Range<usize>) -> usize {
        (self.rows[choices.end] - self.rows[choices.start]) as usize
    }

    /// Returns the reversed graph if it is built already.
    pub fn known_predecessors(&self) -> Option<&Predecessors> {
        self.predecessors.get()
    }

    /// Returns the reversed graph, which is built on first use.
    ///
    /// # Errors
    /// The memory limit is reached.
    pub fn predecessors(&self) -> Result<&Predecessors> {
        if let Some(known) = self.predecessors.get() {
            return Ok(known);
        }
        let built = self.reverse()?;
        Ok(self.predecessors.get_or_init(|| built))
    }

    fn reverse(&self) -> Result<Predecessors> {
        let mut rows = Array::filled(&self.meter, self.states() + 1, 0u32)?;
        for &state in self.successors.iter() {
            rows[state as usize] += 1;
        }
        let mut end = 0;
        for row in rows.iter_mut() {
            end += *row;
            *row = end;
        }
        let mut choices = Array::filled(&self.meter, self.successors.len(), 0u32)?;
        // From the last choice to the first, so that predecessors are in order.
        for choice in (0..self.choices()).rev() {
            for &state in self.successors_of(choice) {
                let row = &mut rows[state as usize];
                *row -= 1;
                choices[*row as usize] = choice as u32;
            }
        }
        Ok(Predecessors { rows, choices, owners: self.owners()? })
    }

    fn owners(&self) -> Result<Option<Owners>> {
        if self.choices() == self.states() {
            return Ok(None);
        }
        let blocks = Owners::place(self.choices()).0 + 1;
        let (mut first, mut later) =
            (Array::filled(&self.meter, blocks, 0u32)?, Array::filled(&self.meter, blocks, 0u64)?);
        for state in 0..self.states() {
            for choice in self.choices_of(state) {
                let (block, place) = Owners::place(choice);
                if place == 0 {
                    first[block] = state as u32;
                }
                later[block] |= (state as u64 - u64::from(first[block])) << place;
            }
        }
        Ok(Some(Owners { first, later }))
    }
}

impl Predecessors {
    /// Returns the choices that may lead to a state, in order.
    #[inline]
    pub fn of(&self, state: usize) -> &[u32] {
        &self.choices[self.rows[state] as usize..self.rows[state + 1] as usize]
    }

    /// Returns the state of a choice.
    #[inline]
    pub fn owner(&self, choice: u32) -> u32 {
        match &self.owners {
            Some(Owners { first, later }) => {
                let (block, place) = Owners::place(choice as usize);
                first[block] + (later[block] >> place & 15) as u32
            }
            None => choice,
        }
    }
}

/// Moves each distinct number of a sorted list to the front and returns how many there are.
fn keep_once(sorted: &mut [u32]) -> usize {
    let mut kept = 1;
    for at in 1..sorted.len() {
        if sorted[at] != sorted[kept - 1] {
            sorted[kept] = sorted[at];
            kept += 1;
        }
    }
    kept
}
