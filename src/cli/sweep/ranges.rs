//! Values, ranges and lists of values for constants: `-c K=4,N=2:2:10,p={0.1,0.5}`.

use meliora_model::error::Error;

/// Maximum number of instances; more are taken for a mistake.
const MOST_INSTANCES: usize = 1_000_000;
/// Maximum number of digits after the decimal point of a range.
const MOST_DIGITS: usize = 15;

/// A constant with its values, as they are written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Range {
    pub(crate) name: String,
    pub(crate) values: Vec<String>,
    /// True for a range or a list.
    pub(crate) varies: bool,
}

/// Splits at commas outside of braces.
pub(crate) fn parts(text: &str) -> Vec<&str> {
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
pub(crate) fn parse(text: &str) -> Result<Vec<Range>, Error> {
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
        _ => return Err(wrong(part, "a range has the form 1:5 or 0:2:10")),
    };
    let values = steps(low, step, high).ok_or_else(|| wrong(part, "a range has the form 1:5 or 0:2:10"))?;
    if values.is_empty() {
        return Err(wrong(part, "the range is empty"));
    }
    Ok(Range { name, values, varies: true })
}

fn wrong(part: &str, reason: &str) -> Error {
    Error::Usage(format!("`--const {part}`: {reason}"))
}

/// Returns low, low + step, … up to high, computed in decimals so that 0.1:0.1:0.3 includes 0.3.
/// Returns `None` if this is not a range or has too many values.
fn steps(low: &str, step: &str, high: &str) -> Option<Vec<String>> {
    let digits = [low, step, high].map(|t| t.split_once('.').map_or(0, |(_, d)| d.len()));
    let digits = digits.into_iter().max().filter(|&d| d <= MOST_DIGITS)?;
    let [low, step, high] = [scaled(low, digits)?, scaled(step, digits)?, scaled(high, digits)?];
    if step <= 0 || (high - low) / step >= MOST_INSTANCES as i128 {
        return None;
    }
    let mut values = Vec::new();
    let mut value = low;
    while value <= high {
        values.push(shown(value, digits));
        value += step;
    }
    Some(values)
}

fn scaled(text: &str, digits: usize) -> Option<i128> {
    let (sign, plain) = text.strip_prefix('-').map_or((1, text), |rest| (-1, rest));
    let (whole, fraction) = plain.split_once('.').unwrap_or((plain, ""));
    let all = format!("{whole}{fraction}{}", "0".repeat(digits - fraction.len()));
    let is_number = all.len() <= 30 && all.bytes().all(|b| b.is_ascii_digit()) && !whole.is_empty();
    if is_number { all.parse::<i128>().ok().map(|n| sign * n) } else { None }
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

/// Returns every combination of values; the last constant varies fastest.
///
/// # Errors
/// There are more than [`MOST_INSTANCES`].
pub(crate) fn instances(ranges: &[Range]) -> Result<Vec<Vec<String>>, Error> {
    let count = ranges.iter().try_fold(1usize, |n, r| n.checked_mul(r.values.len()));
    if count.is_none_or(|n| n > MOST_INSTANCES) {
        return Err(Error::Usage(format!("a sweep has at most {MOST_INSTANCES} instances")));
    }
    let mut all = vec![Vec::new()];
    for range in ranges {
        let longer = |prefix: &Vec<String>| {
            let prefix = prefix.clone();
            range.values.iter().map(move |v| prefix.iter().chain([v]).cloned().collect::<Vec<_>>())
        };
        all = all.iter().flat_map(longer).collect();
    }
    Ok(all)
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
    fn what_is_no_range_is_refused() {
        for text in ["N=3:1", "N=1:0:3", "N=1:2:3:4", "N=a:b", "N={1,}", "N={}", "N=0:99999999", "N=1:-1:0"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn instances_count_like_an_odometer() {
        let ranges = parse("A=1:2,B=5,C={x,y}").unwrap();
        assert_eq!(ranges.iter().map(|r| r.varies).collect::<Vec<_>>(), [true, false, true]);
        let all: Vec<String> = instances(&ranges).unwrap().iter().map(|i| i.join(" ")).collect();
        assert_eq!(all, ["1 5 x", "1 5 y", "2 5 x", "2 5 y"]);
    }
}
