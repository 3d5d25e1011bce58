//! The offers of participants: their enabled commands, and what these add to a code. Many states share one.

use ahash::{AHashMap, RandomState};

use super::program::Factor;
use super::states::fixed;

/// Maximum number of offers that are kept.
const MOST_KEPT: usize = 1 << 12;
/// Maximum number of places of all tables before a state is entered.
const FREE_PLACES: usize = 1 << 16;
/// The number of places by which each state that is entered raises it.
const PLACES_PER_STATE: u64 = 2;

/// The enabled commands of a participant, and their effects once they are needed.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) struct Offer<const W: usize> {
    pub(crate) commands: Vec<u32>,
    /// The end of each command in `effects`.
    pub(crate) ends: Vec<u32>,
    /// The differences that the branches of the commands add to the code.
    pub(crate) effects: Vec<[u64; W]>,
    pub(crate) has_effects: bool,
}

impl<const W: usize> Offer<W> {
    fn new() -> Self {
        Offer { commands: Vec::new(), ends: Vec::new(), effects: Vec::new(), has_effects: false }
    }

    pub(crate) fn clear(&mut self) {
        self.commands.clear();
        self.clear_effects();
    }

    pub(crate) fn clear_effects(&mut self) {
        self.ends.clear();
        self.effects.clear();
        self.has_effects = false;
    }

    /// Returns the effects of a command, by its position.
    pub(crate) fn effects_of(&self, position: usize) -> &[[u64; W]] {
        let start = position.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.effects[start as usize..self.ends[position] as usize]
    }
}

/// The offer of a participant in the current state.
#[derive(Debug, Clone, Copy)]
struct Current<const W: usize> {
    /// The number of the state for which it is valid.
    stamp: u64,
    number: u32,
    place: u32,
    /// The bits of the code on which the place depends. A kept offer is valid in all states with them.
    bits: [u64; W],
}

/// The offers of the participants in the current state, and those of earlier states by place.
pub(crate) struct Offers<'a, const W: usize> {
    factors: &'a [Factor],
    /// For each participant, the bits of a code on which its place depends.
    masks: Vec<[u64; W]>,
    /// For each participant, one more than the number of the kept offer of each place, or 0 if that is not known; empty
    /// before there is a table.
    tables: Vec<Vec<u16>>,
    /// One offer per participant for the current state alone, and after these the offers that are kept.
    all: Vec<Offer<W>>,
    current: Vec<Current<W>>,
    /// The numbers of kept offers, by their hash.
    numbers: AHashMap<u64, u16>,
    hasher: RandomState,
    /// The number of places of all tables.
    places: usize,
    /// The number of the current state.
    now: u64,
    /// Its code.
    code: [u64; W],
}

impl<'a, const W: usize> Offers<'a, W> {
    /// Begins without offers of some participants.
    pub(crate) fn new(factors: &'a [Factor]) -> Self {
        let count = factors.len();
        Offers {
            factors,
            masks: factors.iter().map(|factor| fixed(&factor.mask)).collect(),
            tables: vec![Vec::new(); count],
            all: vec![Offer::new(); count],
            current: vec![Current { stamp: 0, number: 0, place: 0, bits: [0; W] }; count],
            numbers: AHashMap::new(),
            hasher: RandomState::with_seeds(1, 2, 3, 4),
            places: 0,
            now: 0,
            code: [0; W],
        }
    }

    /// Moves to another state, given its code.
    #[inline]
    pub(crate) fn next_state(&mut self, code: [u64; W]) {
        self.now += 1;
        self.code = code;
    }

    /// Returns the offer of a participant in the current state, if it is known.
    #[inline]
    pub(crate) fn known(&self, participant: usize) -> Option<&Offer<W>> {
        let current = self.current[participant];
        (current.stamp == self.now).then(|| &self.all[current.number as usize])
    }

    /// Looks up the offer of a participant that is not known in the current state, by its values. Returns whether it
    /// is known then.
    #[inline]
    pub(crate) fn look_up(&mut self, participant: usize, values: &[i64]) -> bool {
        let mut bits = self.masks[participant];
        bits.iter_mut().zip(&self.code).for_each(|(bits, word)| *bits &= word);
        let (first, current) = (self.factors.len() as u32, &mut self.current[participant]);
        // States that follow each other differ in few participants.
        if current.number >= first && current.bits == bits {
            current.stamp = self.now;
            return true;
        }
        let Some(classes) = &self.factors[participant].classes else { return false };
        if self.tables[participant].is_empty() && !self.begin_table(participant, classes.size) {
            return false;
        }
        let place = classes.place(values);
        let entry = self.tables[participant][place];
        let (stamp, number) = match entry {
            0 => (0, 0),
            kept => (self.now, first + u32::from(kept) - 1),
        };
        self.current[participant] = Current { stamp, number, place: place as u32, bits };
        entry != 0
    }

    fn begin_table(&mut self, participant: usize, size: usize) -> bool {
        let most = (FREE_PLACES as u64).saturating_add(PLACES_PER_STATE.saturating_mul(self.now));
        let fits = (self.places + size) as u64 <= most;
        if fits {
            self.places += size;
            self.tables[participant] = vec![0; size];
        }
        fits
    }

    /// Takes room for an offer of a participant, which is empty or as in the current state.
    pub(crate) fn room(&mut self, participant: usize) -> Offer<W> {
        let mut room = std::mem::replace(&mut self.all[participant], Offer::new());
        let Current { stamp, number, .. } = self.current[participant];
        match (stamp == self.now, number as usize) {
            (true, own) if own == participant => room.clear_effects(),
            (true, kept) => {
                room.clear();
                room.commands.extend_from_slice(&self.all[kept].commands);
            }
            (false, _) => room.clear(),
        }
        room
    }

    /// Sets the offer of a participant in the current state; `is_steady` if it is the same in all states of the place.
    pub(crate) fn set(&mut self, participant: usize, offer: Offer<W>, is_steady: bool) {
        self.all[participant] = offer;
        let Current { place, bits, .. } = self.current[participant];
        let mut number = participant;
        if is_steady
            && !self.tables[participant].is_empty()
            && let Some(kept) = self.keep(participant)
        {
            self.tables[participant][place as usize] = kept + 1;
            number = self.factors.len() + usize::from(kept);
        }
        self.current[participant] = Current { stamp: self.now, number: number as u32, place, bits };
    }

    /// Keeps the offer of a participant in the current state, and returns its number; `None` if there are too many.
    fn keep(&mut self, participant: usize) -> Option<u16> {
        let (own, first) = (&self.all[participant], self.factors.len());
        let hash = self.hasher.hash_one(own);
        match self.numbers.get(&hash) {
            Some(&known) => (self.all[first + usize::from(known)] == *own).then_some(known),
            None if self.all.len() - first == MOST_KEPT => None,
            None => {
                let number = (self.all.len() - first) as u16;
                self.all.push(own.clone());
                self.numbers.insert(hash, number);
                Some(number)
            }
        }
    }
}
