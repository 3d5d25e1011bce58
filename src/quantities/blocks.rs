//! The positions of numbered codes, in blocks of numbers that follow each other.
//!
//! A hash table puts each code somewhere else, so that most look-ups wait for memory, several times. States
//! that are found together mostly have numbers near to each other, and share blocks. Blocks are found in pages, so
//! that few pages have to be found in a table.

use ahash::AHashMap;
use meliora_engine::explicit::weighted::Numbering;

/// The number of codes of a block, and of blocks of a page.
const SIZE: usize = 64;
const PAGE: usize = 1024;
/// The bytes that all blocks may take, and those that they may take besides for each code.
const FREE: usize = 16 << 20;
const SPARSE: usize = 16;

/// The positions of codes by key and number.
#[derive(Debug)]
pub(super) struct Blocks {
    numbering: Numbering,
    /// The pages by key and by number, divided by the size of a page in codes.
    numbers: AHashMap<(u32, u64), u32>,
    /// The number of each block plus 1; 0 for none.
    pages: Vec<[u32; PAGE]>,
    /// The position of each code plus 1; 0 for none.
    list: Vec<[u32; SIZE]>,
}

impl Blocks {
    const BLOCK: usize = size_of::<[u32; SIZE]>();
    /// The bytes of a page, and of up to two places in the table.
    const PAGE: usize = size_of::<[u32; PAGE]>() + 2 * size_of::<((u32, u64), u32)>();

    /// Creates an empty list of the codes that are numbered.
    pub(super) fn new(numbering: Numbering) -> Self {
        Blocks { numbering, numbers: AHashMap::default(), pages: Vec::new(), list: Vec::new() }
    }

    /// Returns the position of a code.
    pub(super) fn get(&self, key: u32, code: &[u64]) -> Option<u32> {
        let (page, block, place) = split(self.numbering.number(code));
        let page = *self.numbers.get(&(key, page))?;
        let block = self.pages[page as usize][block].checked_sub(1)?;
        self.list[block as usize][place].checked_sub(1)
    }

    /// Notes the position of a code; returns the bytes that this takes.
    pub(super) fn set(&mut self, key: u32, code: &[u64], position: u32) -> usize {
        let (page, block, place) = split(self.numbering.number(code));
        let Blocks { numbers, pages, list, .. } = self;
        let mut bytes = 0;
        let page = *numbers.entry((key, page)).or_insert_with(|| {
            pages.push([0; PAGE]);
            bytes += Blocks::PAGE;
            pages.len() as u32 - 1
        });
        let block = &mut pages[page as usize][block];
        if *block == 0 {
            list.push([0; SIZE]);
            bytes += Blocks::BLOCK;
            *block = list.len() as u32;
        }
        list[*block as usize - 1][place] = position + 1;
        bytes
    }

    /// Returns whether the blocks take much memory for this number of codes.
    pub(super) fn are_sparse(&self, codes: usize) -> bool {
        self.bytes() > FREE + SPARSE * codes
    }

    /// Returns the bytes of all blocks.
    pub(super) fn bytes(&self) -> usize {
        self.list.len() * Blocks::BLOCK + self.pages.len() * Blocks::PAGE
    }
}

/// Returns the page of a number, the block within the page, and the place within the block.
fn split(number: u64) -> (u64, usize, usize) {
    let (block, place) = (number / SIZE as u64, number as usize % SIZE);
    (block / PAGE as u64, block as usize % PAGE, place)
}
