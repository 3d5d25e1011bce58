//! The values of state variables in a UMB archive.
//!
//! Booleans and integers become variables of these types. Strings, fractions, and variables that
//! only some states have become variables whose values have names.

use std::collections::BTreeSet;

use super::Column;
use crate::umb::archive::Files;
use crate::umb::binary::{Number, number};
use crate::umb::index::{Base, Class, Field, Valuations, Variable};
use crate::umb::{INDEX, STATE_VALUATIONS};
use meliora_base::error::Result;
use meliora_base::progress::Poll;
use meliora_base::value::Type;

/// Maximum absolute value of a variable, such that every value is exact as a double.
const MOST: i128 = 1 << 53;
/// The name of the value of a variable in states that do not have it.
const NONE: &str = "none";

/// Maximum number of variables; states with more are told apart by their numbers.
const MOST_VARIABLES: usize = 500;

/// Reads the values of `n` states; `None` if there are too many variables.
///
/// # Errors
/// The files do not fit the description; a type is not supported; a limit.
pub(super) fn columns(
    files: &Files,
    of: &Valuations,
    n: usize,
    poll: &mut Poll<'_>,
) -> Result<Option<Vec<Column>>> {
    if of.classes.iter().flat_map(variables).count() > MOST_VARIABLES {
        return Ok(None);
    }
    for class in &of.classes {
        let mut known = BTreeSet::new();
        if let Some(twice) = variables(class).find(|variable| !known.insert(&variable.name)) {
            let message = format!("the variable `{}` occurs twice in a class", twice.name);
            return Err(files.wrong(INDEX, &message));
        }
    }
    let path = format!("{STATE_VALUATIONS}/valuations.bin");
    let strings = match of.strings {
        Some(count) => files.strings(STATE_VALUATIONS, count as usize)?.unwrap_or_default(),
        None => Vec::new(),
    };
    let reader = ValuationReader { files, path: &path, strings: &strings };
    let rows = reader.rows(of, n)?;
    let mut names: Vec<&str> = Vec::new();
    for variable in of.classes.iter().flat_map(variables) {
        if !names.contains(&variable.name.as_str()) {
            names.push(&variable.name);
        }
    }
    names.into_iter().map(|name| reader.column(of, name, &rows, poll)).collect::<Result<_>>().map(Some)
}

fn variables(class: &Class) -> impl Iterator<Item = &Variable> {
    class.variables.iter().filter_map(|field| match field {
        Field::Variable(variable) => Some(variable),
        Field::Padding { .. } => None,
    })
}

/// The bytes of the values of one state, and the number of its class.
type Row<'f> = (usize, &'f [u8]);

struct ValuationReader<'f> {
    files: &'f Files,
    path: &'f str,
    strings: &'f [String],
}

impl<'f> ValuationReader<'f> {
    /// Divides the file of all values.
    fn rows(&self, of: &Valuations, n: usize) -> Result<Vec<Row<'f>>> {
        let mut left = self.files.get(self.path).unwrap_or_default();
        let classes_path = format!("{STATE_VALUATIONS}/valuation-to-class.bin");
        let classes = self.files.halves(&classes_path, n)?;
        let mut rows = Vec::new();
        for state in 0..n {
            let class = classes.as_ref().map_or(0, |c| c[state] as usize);
            let wrong = || self.files.wrong(&classes_path, &format!("there is no class {class}"));
            let bits = of
                .classes
                .get(class)
                .ok_or_else(wrong)?
                .variables
                .iter()
                .map(Field::bits)
                .fold(0, u64::saturating_add);
            if !bits.is_multiple_of(8) {
                let message = format!("values of {bits} bits are not whole bytes");
                return Err(self.files.wrong(INDEX, &message));
            }
            let size = usize::try_from(bits / 8).unwrap_or(usize::MAX);
            let Some((row, others)) = left.split_at_checked(size) else {
                let message = format!("the values end before those of state {state}");
                return Err(self.files.wrong(self.path, &message));
            };
            rows.push((class, row));
            left = others;
        }
        if left.is_empty() { Ok(rows) } else { Err(self.files.wrong(self.path, "the file is too long")) }
    }

    /// Returns the variable of a name, with its values.
    fn column(&self, of: &Valuations, name: &str, rows: &[Row<'_>], poll: &mut Poll<'_>) -> Result<Column> {
        let places: Vec<Option<(u64, &Variable)>> =
            of.classes.iter().map(|class| place(class, name)).collect();
        let mut kinds = places.iter().map(|p| p.and_then(|(_, variable)| kind(variable)));
        let first = kinds.next().flatten();
        match first.filter(|ty| kinds.all(|kind| kind == Some(*ty))) {
            Some(ty) => self.plain(name, ty, &places, rows, poll),
            None => self.named(name, &places, rows, poll),
        }
    }

    /// Returns a Boolean or an integer that all states have.
    fn plain(
        &self,
        name: &str,
        ty: Type,
        places: &[Option<(u64, &Variable)>],
        rows: &[Row<'_>],
        poll: &mut Poll<'_>,
    ) -> Result<Column> {
        let mut values = Vec::with_capacity(rows.len());
        for &(class, row) in rows {
            poll.step()?;
            let Some((at, variable)) = places[class] else { continue };
            let value = match ty {
                Type::Bool => i128::from(unsigned(row, at, variable.ty.bits()) != 0),
                _ => integer(row, at, variable),
            };
            if value.abs() > MOST {
                let message = format!("the value {value} of the variable {name} exceeds 2^53");
                return Err(self.files.wrong(self.path, &message));
            }
            values.push(i64::try_from(value).unwrap_or_default());
        }
        let least = values.iter().copied().min().unwrap_or_default();
        let most = values.iter().copied().max().unwrap_or_default();
        let small = |bound: &i64| i128::from(*bound).abs() <= MOST;
        let declared = |f: fn(&Variable) -> Option<i64>| places.iter().flatten().filter_map(move |p| f(p.1));
        let (low, high) = match ty {
            Type::Bool => (0, 1),
            _ => (
                declared(|v| v.lower).filter(small).min().map_or(least, |low| low.min(least)),
                declared(|v| v.upper).filter(small).max().map_or(most, |high| high.max(most)),
            ),
        };
        Ok(Column { name: name.to_owned(), place: None, ty, low, high, names: Vec::new(), values })
    }

    /// Returns a variable whose values have names.
    fn named(
        &self,
        name: &str,
        places: &[Option<(u64, &Variable)>],
        rows: &[Row<'_>],
        poll: &mut Poll<'_>,
    ) -> Result<Column> {
        let mut shown = Vec::with_capacity(rows.len());
        for &(class, row) in rows {
            poll.step()?;
            shown.push(match places[class] {
                Some((at, variable)) => self.show(row, at, variable)?,
                None => NONE.to_owned(),
            });
        }
        let names: Vec<String> = shown.iter().collect::<BTreeSet<_>>().into_iter().cloned().collect();
        let number = |text: &String| i64::try_from(names.partition_point(|n| n < text)).unwrap_or_default();
        let values = shown.iter().map(number).collect();
        let high = i64::try_from(names.len()).unwrap_or(i64::MAX) - 1;
        Ok(Column { name: name.to_owned(), place: None, ty: Type::Int, low: 0, high, names, values })
    }

    /// Formats a value.
    fn show(&self, row: &[u8], at: u64, variable: &Variable) -> Result<String> {
        let at = match variable.is_optional {
            true if unsigned(row, at, 1) == 0 => return Ok(NONE.to_owned()),
            true => at + 1,
            false => at,
        };
        let bits = variable.ty.bits();
        let refused = |what: &str| {
            let message = format!("the variable {}: {what}", variable.name);
            self.files.wrong(INDEX, &message)
        };
        match variable.ty.base {
            Base::Bool if (1..=64).contains(&bits) => Ok((unsigned(row, at, bits) != 0).to_string()),
            Base::Int | Base::Uint if (1..=64).contains(&bits) => Ok(integer(row, at, variable).to_string()),
            Base::String if bits == 64 => {
                let index = usize::try_from(unsigned(row, at, bits)).unwrap_or(usize::MAX);
                let text = self.strings.get(index);
                text.cloned().ok_or_else(|| refused(&format!("there is no string {index}")))
            }
            Base::Double | Base::Rational if bits > 0 && bits.is_multiple_of(16) && bits <= 1 << 16 => {
                match number(variable.ty.base, &cell(row, at, bits)) {
                    Ok(Number::Double(x)) => Ok(format!("{x:?}")),
                    Ok(Number::Rational(ratio)) => Ok(ratio.to_string()),
                    Err(reason) => Err(refused(&reason)),
                }
            }
            base => Err(refused(&format!("{base} of {bits} bits is not supported"))),
        }
    }
}

/// Returns the position of a variable in the bits of a class.
fn place<'c>(class: &'c Class, name: &str) -> Option<(u64, &'c Variable)> {
    let mut at = 0;
    for field in &class.variables {
        match field {
            Field::Variable(variable) if variable.name == name => return Some((at, variable)),
            _ => at = u64::saturating_add(at, field.bits()),
        }
    }
    None
}

/// Returns the type of a variable that needs no names for its values.
fn kind(variable: &Variable) -> Option<Type> {
    match variable.ty.base {
        _ if variable.is_optional || !(1..=64).contains(&variable.ty.bits()) => None,
        Base::Bool => Some(Type::Bool),
        Base::Int | Base::Uint => Some(Type::Int),
        _ => None,
    }
}

/// Returns the number of some bits, at most 64.
fn unsigned(row: &[u8], at: u64, bits: u32) -> u64 {
    let bit = |i: u64| row.get(usize::try_from(i / 8).unwrap_or(usize::MAX)).map_or(0, |b| b >> (i % 8) & 1);
    (0..u64::from(bits)).fold(0, |all, i| all | u64::from(bit(at + i)) << i)
}

/// Returns the actual value of an integer of at most 64 bits.
fn integer(row: &[u8], at: u64, variable: &Variable) -> i128 {
    let bits = variable.ty.bits();
    let stored = unsigned(row, at, bits);
    let value = match variable.ty.base {
        Base::Int if bits > 0 && stored >> (bits - 1) & 1 == 1 => i128::from(stored) - (1 << bits),
        _ => i128::from(stored),
    };
    value + i128::from(variable.offset.unwrap_or(0))
}

/// Returns some bits as bytes.
fn cell(row: &[u8], at: u64, bits: u32) -> Vec<u8> {
    (0..u64::from(bits / 8)).map(|byte| unsigned(row, at + 8 * byte, 8) as u8).collect()
}
