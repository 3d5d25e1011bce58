//! The positions of numbered codes, in blocks of numbers that follow each other.
//!
//! A hash table puts each code somewhere else, so that most look-ups wait for memory, several times. States
//! that are found together mostly have numbers near to each other, and share blocks.

use ahash::AHashMap;
use meliora_engine::explicit::weighted::Numbering;

/// The size of a block.
const SIZE: usize = 256;
/// The numbers of codes from which blocks must be filled, and the places per code up to which they are.
const FIRST: usize = 1 << 10;
const SPARSE: usize = 8;

/// The positions of codes by key and number.
#[derive(Debug)]
pub(super) struct Blocks {
    numbering: Numbering,
    /// The blocks by key and by number, divided by their size.
    numbers: AHashMap<(u32, u64), u32>,
    /// The position of each code plus 1; 0 for none.
    list: Vec<[u32; SIZE]>,
}

impl Blocks {
    /// The bytes of a block, and of up to two places in the table.
    pub(super) const BYTES: usize = SIZE * size_of::<u32>() + 2 * size_of::<((u32, u64), u32)>();

    /// Creates an empty list of the codes that are numbered.
    pub(super) fn new(numbering: Numbering) -> Self {
        Blocks { numbering, numbers: AHashMap::default(), list: Vec::new() }
    }

    /// Returns the position of a code.
    pub(super) fn get(&self, key: u32, code: &[u64]) -> Option<u32> {
        let number = self.numbering.number(code);
        let block = *self.numbers.get(&(key, number / SIZE as u64))?;
        self.list[block as usize][number as usize % SIZE].checked_sub(1)
    }

    /// Notes the position of a code; returns whether this began a block.
    pub(super) fn set(&mut self, key: u32, code: &[u64], position: u32) -> bool {
        let number = self.numbering.number(code);
        let (next, list) = (self.list.len() as u32, &mut self.list);
        let block = *self.numbers.entry((key, number / SIZE as u64)).or_insert_with(|| {
            list.push([0; SIZE]);
            next
        });
        list[block as usize][number as usize % SIZE] = position + 1;
        block == next
    }

    /// Returns whether the blocks take much memory for this number of codes.
    pub(super) fn are_sparse(&self, codes: usize) -> bool {
        codes >= FIRST && self.list.len() * SIZE > SPARSE * codes
    }

    /// Returns the bytes of all blocks.
    pub(super) fn bytes(&self) -> usize {
        self.list.len() * Blocks::BYTES
    }
}
