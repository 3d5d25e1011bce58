//! Values, ranges and lists of values for constants: `-c K=4,N=2:2:10,p={0.1,0.5}`.

use std::collections::HashMap;

use meliora_base::error::{Error, ensure};

/// Maximum number of instances, and of values of a range; more are taken for a mistake.
const MOST_INSTANCES: usize = 1_000_000;
/// Maximum number of digits after the decimal point of a range.
const MOST_DECIMALS: usize = 15;
/// Maximum number of digits of a bound or step of a range.
const MOST_DIGITS: usize = 30;
/// The form of a range.
const FORM: &str = "a range has the form 1:5, 0:2:10 or 1/3:1/3:1";

/// A constant with its values, as they are written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Range {
    /// Its name.
    pub name: String,
    /// Its values, in the order of the instances.
    pub values: Vec<String>,
    /// True for a range or a list.
    pub varies: bool,
}

/// Splits at commas outside of braces.
pub fn parts(text: &str) -> Vec<&str> {
    let (mut parts, mut start, mut depth) = (Vec::new(), 0, 0usize);
    for (at, c) in text.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                parts.push(&text[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[start..]);
    parts
}

/// Reads all constants of a list.
///
/// # Errors
/// A range has no values or too many.
pub fn parse(text: &str) -> Result<Vec<Range>, Error> {
    if text.trim().is_empty() {
        return Ok(Vec::new());
    }
    parts(text).into_iter().map(range).collect()
}

fn range(part: &str) -> Result<Range, Error> {
    let (name, value) = part.split_once('=').unwrap_or((part, ""));
    let (name, value) = (name.trim().to_owned(), value.trim());
    if let Some(list) = value.strip_prefix('{').and_then(|v| v.strip_suffix('}')) {
        let values: Vec<String> = list.split(',').map(|v| v.trim().to_owned()).collect();
        if values.iter().any(String::is_empty) {
            return Err(wrong(part, "a list has the form {2,4,8}"));
        }
        return Ok(Range { name, values, varies: true });
    }
    let bounds: Vec<&str> = value.split(':').map(str::trim).collect();
    let (low, step, high) = match bounds.as_slice() {
        [_] => return Ok(Range { name, values: vec![value.to_owned()], varies: false }),
        [low, high] => (*low, "1", *high),
        [low, step, high] => (*low, *step, *high),
        _ => return Err(wrong(part, FORM)),
    };
    let values = steps(low, step, high).map_err(|reason| wrong(part, &reason))?;
    Ok(Range { name, values, varies: true })
}

fn wrong(part: &str, reason: &str) -> Error {
    Error::Usage(format!("`--const {part}`: {reason}"))
}

/// Returns low, low + step, … up to high, computed in decimals so that 0.1:0.1:0.3 includes 0.3.
///
/// # Errors
/// The reason why this is not a range, or exceeds a limit.
fn steps(low: &str, step: &str, high: &str) -> Result<Vec<String>, String> {
    if [low, step, high].iter().any(|bound| bound.contains('/')) {
        let bounds = [fraction(low)?, fraction(step)?, fraction(high)?];
        let common =
            bounds.iter().try_fold(1i128, |common, (_, own)| (common / gcd(common, *own)).checked_mul(*own));
        let common = common.ok_or(TOO_LARGE)?;
        let times = |(n, d): (i128, i128)| n.checked_mul(common / d).ok_or(TOO_LARGE);
        let [low, step, high] = bounds.map(times);
        return between(low?, step?, high?, |value| shown_fraction(value, common));
    }
    let digits = [low, step, high].map(|t| t.split_once('.').map_or(0, |(_, d)| d.len()));
    let digits = digits.into_iter().max().unwrap_or(0);
    ensure(digits <= MOST_DECIMALS, || {
        format!("a range has at most {MOST_DECIMALS} digits after the decimal point, not {digits}")
    })?;
    between(scaled(low, digits)?, scaled(step, digits)?, scaled(high, digits)?, |value| shown(value, digits))
}

/// Returns low, low + step, … up to high.
///
/// # Errors
/// There are no such values, or too many.
fn between(low: i128, step: i128, high: i128, show: impl Fn(i128) -> String) -> Result<Vec<String>, String> {
    ensure(step > 0, || "the step of a range is positive".to_owned())?;
    ensure(low <= high, || "the range is empty".to_owned())?;
    let count = high.checked_sub(low).ok_or(TOO_LARGE)? / step + 1;
    ensure(count <= MOST_INSTANCES as i128, || {
        format!("a range has at most {MOST_INSTANCES} values, and this one has {count}")
    })?;
    Ok((0..count).map(|number| show(low + number * step)).collect())
}

/// The error for numbers of a range that cannot be computed with.
const TOO_LARGE: &str = "the numbers of the range have no common denominator below 2^127";

/// Returns the numerator and the positive denominator of a decimal number or a fraction.
fn fraction(text: &str) -> Result<(i128, i128), String> {
    let (numerator, denominator) = text.split_once('/').unwrap_or((text, "1"));
    let digits = [numerator, denominator].map(|t| t.split_once('.').map_or(0, |(_, d)| d.len()));
    let digits = digits[0].max(digits[1]);
    ensure(digits <= MOST_DECIMALS, || FORM.to_owned())?;
    let (n, d) = (scaled(numerator.trim(), digits)?, scaled(denominator.trim(), digits)?);
    ensure(d > 0, || format!("`{text}`: the denominator of a fraction is positive"))?;
    let common = gcd(n, d);
    Ok((n / common, d / common))
}

/// Returns the greatest common divisor; the second number is positive.
fn gcd(a: i128, b: i128) -> i128 {
    let (mut a, mut b) = (a.abs(), b);
    while a > 0 {
        (a, b) = (b % a, a);
    }
    b
}

/// Formats a value divided by the common denominator.
fn shown_fraction(value: i128, denominator: i128) -> String {
    let common = gcd(value, denominator);
    match (value / common, denominator / common) {
        // A value without a fraction stays a real number.
        (whole, 1) => format!("{whole}.0"),
        (numerator, denominator) => format!("{numerator}/{denominator}"),
    }
}

/// Returns a decimal number times 10^`digits`.
fn scaled(text: &str, digits: usize) -> Result<i128, String> {
    let (sign, plain) = text.strip_prefix('-').map_or((1, text), |rest| (-1, rest));
    let (whole, fraction) = plain.split_once('.').unwrap_or((plain, ""));
    let all = format!("{whole}{fraction}{}", "0".repeat(digits - fraction.len()));
    let is_number = all.bytes().all(|b| b.is_ascii_digit()) && !whole.is_empty();
    ensure(is_number, || FORM.to_owned())?;
    ensure(all.len() <= MOST_DIGITS, || {
        format!("`{text}`: numbers of a range have at most {MOST_DIGITS} digits")
    })?;
    all.parse::<i128>().map(|n| sign * n).map_err(|_| FORM.to_owned())
}

fn shown(value: i128, digits: usize) -> String {
    if digits == 0 {
        return value.to_string();
    }
    let unit = 10i128.pow(u32::try_from(digits).unwrap_or(0));
    let sign = if value < 0 { "-" } else { "" };
    let (whole, rest) = (value.abs() / unit, value.abs() % unit);
    let fraction = format!("{rest:0digits$}");
    let fraction = fraction.trim_end_matches('0');
    // A value without a fraction stays a real number.
    format!("{sign}{whole}.{}", if fraction.is_empty() { "0" } else { fraction })
}

/// Returns the number of combinations of values.
///
/// # Errors
/// There are more than 1,000,000.
pub fn count(ranges: &[Range]) -> Result<usize, Error> {
    let count = ranges.iter().try_fold(1usize, |n, r| n.checked_mul(r.values.len()));
    count.filter(|&n| n <= MOST_INSTANCES).ok_or_else(|| {
        let found = ranges.iter().fold(1.0, |n, r| n * r.values.len() as f64);
        Error::Usage(format!("a sweep has at most {MOST_INSTANCES} instances, and this one has {found}"))
    })
}

/// Returns the combination of values at a position; the last constant varies fastest.
pub fn instance(ranges: &[Range], position: usize) -> Vec<&str> {
    let mut left = position;
    let mut values = Vec::with_capacity(ranges.len());
    for range in ranges.iter().rev() {
        values.push(range.values[left % range.values.len()].as_str());
        left /= range.values.len();
    }
    values.reverse();
    values
}

/// Returns the combination of values at a position as `K=4,N=3`.
pub fn constants(ranges: &[Range], position: usize) -> String {
    let named = ranges.iter().zip(instance(ranges, position)).map(|(r, v)| format!("{}={v}", r.name));
    named.collect::<Vec<_>>().join(",")
}

/// The positions of combinations by their values.
pub struct Positions<'r>(Vec<(HashMap<&'r str, usize>, usize)>);

impl<'r> Positions<'r> {
    /// Numbers the combinations of ranges.
    pub fn new(ranges: &'r [Range]) -> Self {
        let numbered = |range: &'r Range| {
            (range.values.iter().map(String::as_str).zip(0..).collect(), range.values.len())
        };
        Positions(ranges.iter().map(numbered).collect())
    }

    /// Returns the position of some values; `None` if they are not a combination of the ranges.
    pub fn get(&self, values: &[&str]) -> Option<usize> {
        if values.len() != self.0.len() {
            return None;
        }
        self.0.iter().zip(values).try_fold(0, |n, ((of, len), value)| Some(n * len + of.get(value)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<String> {
        parse(text).unwrap().remove(0).values
    }

    #[test]
    fn ranges_have_the_values_of_the_experiments_of_prism() {
        assert_eq!(values("N=1:3"), ["1", "2", "3"]);
        assert_eq!(values("N=0:2:5"), ["0", "2", "4"]);
        assert_eq!(values("N={2, 4,8}"), ["2", "4", "8"]);
        assert_eq!(values("p=0.1:0.1:0.3"), ["0.1", "0.2", "0.3"]);
        assert_eq!(values("p=-0.5:0.5:1"), ["-0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(values("b=true"), ["true"]);
    }

    #[test]
    fn ranges_of_fractions_have_exact_values() {
        assert_eq!(values("p=1/3:1/3:1"), ["1/3", "2/3", "1.0"]);
        assert_eq!(values("p=-1/2:1/4:0.25"), ["-1/2", "-1/4", "0.0", "1/4"]);
        assert_eq!(values("p=1/6 : 0.5 : 2"), ["1/6", "2/3", "7/6", "5/3"]);
        assert_eq!(values("p=0.5/1.5:1/2"), ["1/3"]);
        let refused = |text: &str| parse(text).unwrap_err().to_string();
        assert!(refused("p=1/0:1").contains("denominator of a fraction is positive"));
        assert!(refused("p=1/3:0/1:1").contains("positive") && refused("p=2/3:1/3").contains("empty"));
        assert!(refused("p=1/3:x/3:1").contains("1/3:1/3:1"));
        assert!(refused("p=0/1:1/1000000:1").contains("at most 1000000 values"));
        let long = format!("1/{}", "7".repeat(29));
        assert!(refused(&format!("p={long}:1/99999999999999:1")).contains("common denominator"));
    }

    #[test]
    fn what_is_no_range_is_refused() {
        for text in ["N=3:1", "N=1:0:3", "N=1:2:3:4", "N=a:b", "N={1,}", "N={}", "N=0:99999999", "N=1:-1:0"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn limits_of_ranges_are_named() {
        let refused = |text: &str| parse(text).unwrap_err().to_string();
        assert!(refused("N=0:1000000").contains("at most 1000000 values, and this one has 1000001"));
        assert!(refused("p=0:0.0000000000000001:1").contains("at most 15 digits after the decimal point"));
        let long = "1".repeat(31);
        assert!(refused(&format!("N={long}:{long}")).contains("at most 30 digits"));
        assert!(refused("N=3:1").contains("empty") && refused("N=1:0:3").contains("positive"));
        assert_eq!(values("N=1:1000000").len(), 1_000_000);
        let two = parse("N=1:1000,M=1:1001").unwrap();
        let refused = count(&two).unwrap_err().to_string();
        assert!(refused.contains("at most 1000000 instances, and this one has 1001000"), "{refused}");
    }

    #[test]
    fn instances_count_like_an_odometer() {
        let ranges = parse("A=1:2,B=5,C={x,y}").unwrap();
        assert_eq!(ranges.iter().map(|r| r.varies).collect::<Vec<_>>(), [true, false, true]);
        let all: Vec<String> = (0..count(&ranges).unwrap()).map(|i| instance(&ranges, i).join(" ")).collect();
        assert_eq!(all, ["1 5 x", "1 5 y", "2 5 x", "2 5 y"]);
        let positions = Positions::new(&ranges);
        for at in 0..4 {
            assert_eq!(positions.get(&instance(&ranges, at)), Some(at));
        }
        assert_eq!(positions.get(&["1", "6", "x"]), None);
        assert_eq!(positions.get(&["1", "5"]), None);
    }
}
