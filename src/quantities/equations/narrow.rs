//! Lists of small numbers in as few bytes as the greatest of them needs.

/// A list of numbers of 32 bits. All have the width of the greatest one: one, two or four bytes.
#[derive(Debug)]
pub(crate) enum Narrow {
    Bytes(Vec<u8>),
    Shorts(Vec<u16>),
    Words(Vec<u32>),
}

impl Default for Narrow {
    fn default() -> Self {
        Narrow::Bytes(Vec::new())
    }
}

impl Narrow {
    /// Returns the number at a position.
    #[inline]
    pub(crate) fn get(&self, position: usize) -> u32 {
        match self {
            Narrow::Bytes(list) => u32::from(list[position]),
            Narrow::Shorts(list) => u32::from(list[position]),
            Narrow::Words(list) => list[position],
        }
    }

    /// Adds a number. Cost: constant, except where the number is the first that needs more bytes.
    pub(crate) fn push(&mut self, number: u32) {
        match self {
            Narrow::Bytes(list) => match u8::try_from(number) {
                Ok(number) => list.push(number),
                Err(_) => self.push_wider(number),
            },
            Narrow::Shorts(list) => match u16::try_from(number) {
                Ok(number) => list.push(number),
                Err(_) => self.push_wider(number),
            },
            Narrow::Words(list) => list.push(number),
        }
    }

    fn push_wider(&mut self, number: u32) {
        self.widen(number);
        self.push(number);
    }

    /// Adds copies of a number until the list has a length. Cost: see [`Narrow::push`].
    pub(crate) fn extend_to(&mut self, length: usize, number: u32) {
        (self.len()..length).for_each(|_| self.push(number));
    }

    /// Widens all numbers so that one that does not fit can be stored.
    fn widen(&mut self, number: u32) {
        let wider = match self {
            Narrow::Bytes(list) if number <= u32::from(u16::MAX) => {
                Narrow::Shorts(list.iter().map(|&x| u16::from(x)).collect())
            }
            Narrow::Bytes(list) => Narrow::Words(list.iter().map(|&x| u32::from(x)).collect()),
            Narrow::Shorts(list) => Narrow::Words(list.iter().map(|&x| u32::from(x)).collect()),
            Narrow::Words(_) => return,
        };
        *self = wider;
    }

    /// Returns the number of numbers.
    pub(crate) fn len(&self) -> usize {
        match self {
            Narrow::Bytes(list) => list.len(),
            Narrow::Shorts(list) => list.len(),
            Narrow::Words(list) => list.len(),
        }
    }

    /// Returns the bytes of a number.
    pub(crate) fn width(&self) -> usize {
        match self {
            Narrow::Bytes(_) => 1,
            Narrow::Shorts(_) => 2,
            Narrow::Words(_) => 4,
        }
    }
}

/// A number for each position, most of which are equal. It takes no memory as long as all are equal.
#[derive(Debug, Default)]
pub(crate) struct Mostly {
    /// The number at all positions after the end of the list; the first one that was set.
    usual: Option<u32>,
    list: Narrow,
}

impl Mostly {
    /// Sets the number at a position after all those that were set. Cost: constant on average.
    pub(crate) fn set_next(&mut self, position: usize, number: u32) {
        let usual = *self.usual.get_or_insert(number);
        if number != usual {
            self.list.extend_to(position, usual);
            self.list.push(number);
        }
    }

    /// Returns the number at a position, which was set.
    pub(crate) fn get(&self, position: usize) -> u32 {
        match position < self.list.len() {
            true => self.list.get(position),
            false => self.usual.unwrap_or_default(),
        }
    }

    /// Returns the bytes of a number: none as long as all are equal.
    pub(crate) fn width(&self) -> usize {
        if self.list.len() == 0 { 0 } else { self.list.width() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_values_when_the_list_is_widened() {
        let wanted = [0, 255, 256, 7, 65_535, 65_536, u32::MAX, 1];
        let mut list = Narrow::default();
        wanted.iter().for_each(|&number| list.push(number));
        assert_eq!(wanted.to_vec(), (0..8).map(|i| list.get(i)).collect::<Vec<_>>());
        assert_eq!(list.width(), 4);
    }

    #[test]
    fn unusual_numbers_keep_their_positions() {
        let number = |position: usize| [4, 4, 4, 900, 4, 0][position % 6];
        let mut list = Mostly::default();
        list.set_next(0, 4);
        list.set_next(2, 4);
        assert_eq!(list.width(), 0);
        (3..100).filter(|position| position % 4 != 0).for_each(|at| list.set_next(at, number(at)));
        assert!((3..100).filter(|position| position % 4 != 0).all(|at| list.get(at) == number(at)));
        assert_eq!([list.get(0), list.get(2)], [4, 4]);
    }
}
