//! Lists of small numbers in as few bytes as the greatest of them needs.

/// A list of numbers of 32 bits. All have the width of the greatest one: one, two or four bytes, or none if all are equal.
#[derive(Debug)]
pub enum Narrow {
    /// All numbers are equal.
    Same {
        /// The number.
        number: u32,
        /// The length of the list.
        count: usize,
    },
    /// Numbers of one byte.
    Bytes(Vec<u8>),
    /// Numbers of two bytes.
    Shorts(Vec<u16>),
    /// Numbers of four bytes.
    Words(Vec<u32>),
}

impl Default for Narrow {
    fn default() -> Self {
        Narrow::Same { number: 0, count: 0 }
    }
}

impl Narrow {
    /// Returns the number at a position.
    #[inline]
    pub fn get(&self, position: usize) -> u32 {
        match self {
            Narrow::Same { number, .. } => *number,
            Narrow::Bytes(list) => u32::from(list[position]),
            Narrow::Shorts(list) => u32::from(list[position]),
            Narrow::Words(list) => list[position],
        }
    }

    /// Adds a number. Cost: constant, except where the number is the first that needs more bytes.
    #[inline]
    pub fn push(&mut self, number: u32) {
        match self {
            Narrow::Same { number: same, count } if *same == number => *count += 1,
            Narrow::Bytes(list) if number <= u32::from(u8::MAX) => list.push(number as u8),
            _ => self.push_any(number),
        }
    }

    /// Replaces the number at a position. Cost: as [`Narrow::push`].
    pub(crate) fn set(&mut self, position: usize, number: u32) {
        self.widen(number);
        match self {
            Narrow::Same { .. } => {}
            Narrow::Bytes(list) => list[position] = number as u8,
            Narrow::Shorts(list) => list[position] = number as u16,
            Narrow::Words(list) => list[position] = number,
        }
    }

    fn push_any(&mut self, number: u32) {
        self.widen(number);
        match self {
            Narrow::Same { number: same, count } => (*same, *count) = (number, *count + 1),
            Narrow::Bytes(list) => list.push(number as u8),
            Narrow::Shorts(list) => list.push(number as u16),
            Narrow::Words(list) => list.push(number),
        }
    }

    /// Widens all numbers if one does not fit that is to be stored.
    fn widen(&mut self, number: u32) {
        *self = match self {
            Narrow::Same { number: same, count } if *count > 0 && *same != number => {
                let greatest = number.max(*same);
                match (u8::try_from(greatest), u16::try_from(greatest)) {
                    (Ok(_), _) => Narrow::Bytes(vec![*same as u8; *count]),
                    (_, Ok(_)) => Narrow::Shorts(vec![*same as u16; *count]),
                    _ => Narrow::Words(vec![*same; *count]),
                }
            }
            Narrow::Bytes(list) if number > u32::from(u16::MAX) => {
                Narrow::Words(list.iter().map(|&x| u32::from(x)).collect())
            }
            Narrow::Bytes(list) if number > u32::from(u8::MAX) => {
                Narrow::Shorts(list.iter().map(|&x| u16::from(x)).collect())
            }
            Narrow::Shorts(list) if number > u32::from(u16::MAX) => {
                Narrow::Words(list.iter().map(|&x| u32::from(x)).collect())
            }
            _ => return,
        };
    }

    /// Returns the number of numbers.
    pub(crate) fn len(&self) -> usize {
        match self {
            Narrow::Same { count, .. } => *count,
            Narrow::Bytes(list) => list.len(),
            Narrow::Shorts(list) => list.len(),
            Narrow::Words(list) => list.len(),
        }
    }

    /// Returns the bytes of a number.
    pub fn width(&self) -> usize {
        match self {
            Narrow::Same { .. } => 0,
            Narrow::Bytes(_) => 1,
            Narrow::Shorts(_) => 2,
            Narrow::Words(_) => 4,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the numbers of a list after each of them is added, and the width at the end.
    fn keeps(wanted: &[u32], width: usize) {
        let mut list = Narrow::default();
        for (count, &number) in (1..).zip(wanted) {
            list.push(number);
            assert_eq!(wanted[..count], (0..list.len()).map(|i| list.get(i)).collect::<Vec<_>>());
        }
        assert_eq!(list.width(), width);
    }

    #[test]
    fn numbers_keep_their_values_when_the_list_is_widened() {
        keeps(&[7, 7, 7], 0);
        keeps(&[7, 7, 8], 1);
        keeps(&[300, 300, 7], 2);
        keeps(&[0, 0, 65_536, 1], 4);
        keeps(&[0, 255, 256, 7, 65_535, 65_536, u32::MAX, 1], 4);
    }
}
