//! The arrays: numbers in little-endian order, sets as bits, rows by their starts, and strings.

use num_bigint::{BigInt, BigUint, Sign};
use num_traits::Zero;

use super::archive::Files;
use super::index::{Base, Type};
use meliora_base::error::{Error, Result};
use meliora_base::exact::Ratio;
use meliora_base::real::MOST_BITS;

/// A number as it is stored.
pub(crate) enum Number {
    Double(f64),
    Rational(Ratio),
}

impl Files {
    /// Returns `n` numbers of 64 bits; `None` if the file does not exist.
    ///
    /// # Errors
    /// The file has another size.
    pub(crate) fn words(&self, path: &str, n: usize) -> Result<Option<Vec<u64>>> {
        let cells = self.cells::<8>(path, n)?;
        Ok(cells.map(|cells| cells.into_iter().map(u64::from_le_bytes).collect()))
    }

    /// Returns `n` numbers of 32 bits; `None` if the file does not exist.
    ///
    /// # Errors
    /// The file has another size.
    pub(crate) fn halves(&self, path: &str, n: usize) -> Result<Option<Vec<u32>>> {
        let cells = self.cells::<4>(path, n)?;
        Ok(cells.map(|cells| cells.into_iter().map(u32::from_le_bytes).collect()))
    }

    fn cells<const N: usize>(&self, path: &str, n: usize) -> Result<Option<Vec<[u8; N]>>> {
        let Some(bytes) = self.sized(path, n.checked_mul(N))? else { return Ok(None) };
        Ok(Some(bytes.as_chunks::<N>().0.to_vec()))
    }

    /// Returns the content of a file that must have a certain size.
    fn sized(&self, path: &str, size: Option<usize>) -> Result<Option<&[u8]>> {
        match self.get(path) {
            Some(bytes) if Some(bytes.len()) != size => {
                let expected = size.map_or("more".to_owned(), |size| size.to_string());
                let message = format!("the file has {} bytes, expected {expected}", bytes.len());
                Err(self.wrong(path, &message))
            }
            found => Ok(found),
        }
    }

    /// Returns the members of a set of numbers below `n`; none if the file does not exist.
    ///
    /// # Errors
    /// The file has another size, or bits after the last number.
    pub(crate) fn members(&self, path: &str, n: usize) -> Result<Vec<usize>> {
        let Some(bytes) = self.sized(path, n.div_ceil(64).checked_mul(8))? else { return Ok(Vec::new()) };
        let mut members = Vec::new();
        for (at, byte) in bytes.iter().enumerate().filter(|(_, byte)| **byte != 0) {
            members.extend((0..8).filter(|bit| byte >> bit & 1 == 1).map(|bit| at * 8 + bit));
        }
        match members.last() {
            Some(&last) if last >= n => Err(self.wrong(path, "bits are set after the last entry")),
            _ => Ok(members),
        }
    }

    /// Returns the starts of `n` rows in an array of `total` entries, then `total`. Without a file,
    /// every row has one entry.
    ///
    /// # Errors
    /// The file has another size, or is not a sequence of rows.
    pub(crate) fn rows(&self, path: &str, n: usize, total: usize) -> Result<Vec<usize>> {
        let Some(words) = self.words(path, n + 1)? else {
            let message = format!("the file is missing, although {n} rows have {total} entries");
            return if n == total { Ok((0..=n).collect()) } else { Err(self.wrong(path, &message)) };
        };
        let wrong = || self.wrong(path, &format!("the rows are not consecutive parts of {total} entries"));
        let rows: Option<Vec<usize>> = words.into_iter().map(|w| usize::try_from(w).ok()).collect();
        let rows = rows.ok_or_else(wrong)?;
        let fits = rows.first() == Some(&0) && rows.last() == Some(&total) && rows.is_sorted();
        if fits { Ok(rows) } else { Err(wrong()) }
    }

    /// Returns `n` strings of a folder; `None` if it has none.
    ///
    /// # Errors
    /// One of the two files is missing or has another size; a string is not UTF-8.
    pub(crate) fn strings(&self, folder: &str, n: usize) -> Result<Option<Vec<String>>> {
        let (mapping, strings) = (format!("{folder}/string-mapping.bin"), format!("{folder}/strings.bin"));
        let bytes = match (self.get(&mapping), self.get(&strings)) {
            (None, None) => return Ok(None),
            // An archive may leave out an empty file.
            (Some(_), bytes) => bytes.unwrap_or_default(),
            (None, Some(_)) => return Err(self.wrong(&mapping, "the file is missing")),
        };
        let rows = self.rows(&mapping, n, bytes.len())?;
        let text = |row: &[usize]| String::from_utf8(bytes[row[0]..row[1]].to_vec());
        let all: Result<Vec<String>, _> = rows.windows(2).map(text).collect();
        all.map(Some).map_err(|_| self.wrong(&strings, "a string is not UTF-8"))
    }

    /// Returns `n` numbers of a continuous type; `None` if the file does not exist.
    ///
    /// # Errors
    /// The type is not a number; the file has another size; a denominator is 0.
    pub(crate) fn numbers(&self, path: &str, ty: Type, n: usize) -> Result<Option<Vec<Number>>> {
        let bits = ty.bits() as usize;
        let fits = match ty.base {
            Base::Double => bits == 64,
            Base::Rational => bits > 0 && bits.is_multiple_of(128),
            _ => return Err(self.wrong(path, &format!("numbers of type {} are not supported", ty.base))),
        };
        if !fits {
            return Err(self.wrong(path, &format!("numbers of type {} do not have {bits} bits", ty.base)));
        }
        let Some(bytes) = self.sized(path, n.checked_mul(bits / 8))? else { return Ok(None) };
        let number = |cell: &[u8]| number(ty.base, cell).map_err(|reason| self.wrong(path, &reason));
        bytes.chunks(bits / 8).map(number).collect::<Result<_, Error>>().map(Some)
    }
}

/// Returns the number of a double or a rational.
///
/// # Errors
/// A denominator is 0, or a number has more than [`MOST_BITS`] bits.
pub(crate) fn number(base: Base, cell: &[u8]) -> Result<Number, String> {
    if base == Base::Double {
        let bytes = cell.try_into().map_err(|_| "a double does not have 64 bits".to_owned())?;
        return Ok(Number::Double(f64::from_le_bytes(bytes)));
    }
    let (numerator, denominator) = cell.split_at(cell.len() / 2);
    let denominator = BigUint::from_bytes_le(denominator);
    let numerator = BigInt::from_signed_bytes_le(numerator);
    match numerator.bits().max(denominator.bits()) {
        _ if denominator.is_zero() => Err("a denominator is 0".to_owned()),
        bits if bits > MOST_BITS => {
            Err(format!("a rational number of {bits} bits; at most {MOST_BITS} are supported"))
        }
        _ => Ok(Number::Rational(Ratio::new(numerator, BigInt::from_biguint(Sign::Plus, denominator)))),
    }
}

/// Returns numbers of 64 bits as bytes.
pub fn words(numbers: impl IntoIterator<Item = usize>) -> Vec<u8> {
    numbers.into_iter().flat_map(|n| (n as u64).to_le_bytes()).collect()
}

/// Returns a set of numbers below `n` as bits.
pub fn bits(members: impl IntoIterator<Item = usize>, n: usize) -> Vec<u8> {
    let mut bytes = vec![0u8; n.div_ceil(64) * 8];
    for member in members {
        bytes[member / 8] |= 1 << (member % 8);
    }
    bytes
}

/// Returns strings as the content of `string-mapping.bin` and `strings.bin`.
pub fn strings<'s>(all: impl IntoIterator<Item = &'s str>) -> [Vec<u8>; 2] {
    let (mut ends, mut bytes) = (vec![0], Vec::new());
    for text in all {
        bytes.extend_from_slice(text.as_bytes());
        ends.push(bytes.len());
    }
    [words(ends), bytes]
}

/// Returns the smallest size in bits, a multiple of 128, in which all these fractions fit.
pub fn rational_bits<'r>(all: impl IntoIterator<Item = &'r Ratio>) -> u32 {
    let bits = |r: &Ratio| (r.numer().bits() + 1).max(r.denom().bits());
    let most = all.into_iter().map(bits).max().unwrap_or(1);
    u32::try_from(most.div_ceil(64) * 128).unwrap_or(u32::MAX - 127)
}

/// Returns fractions as bytes, each of a size that [`rational_bits`] returned.
pub fn rationals<'r>(all: impl IntoIterator<Item = &'r Ratio>, bits: u32) -> Vec<u8> {
    let half = bits as usize / 16;
    let mut bytes = Vec::new();
    for ratio in all {
        let mut numerator = ratio.numer().to_signed_bytes_le();
        let sign = if ratio.numer().sign() == Sign::Minus { 0xff } else { 0 };
        numerator.resize(half, sign);
        let mut denominator = ratio.denom().to_biguint().unwrap_or_default().to_bytes_le();
        denominator.resize(half, 0);
        bytes.extend(numerator.into_iter().chain(denominator));
    }
    bytes
}
