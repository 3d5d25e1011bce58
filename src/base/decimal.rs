//! Fractions as decimal numbers.

use num_bigint::BigInt;
use num_traits::{One, Pow, Signed, Zero};

use super::ratio::{MOST_BITS, Ratio, is_short};

/// Largest number of decimal digits, and largest decimal exponent, of a number with at most
/// [`MOST_BITS`] bits.
pub(crate) const MOST_DIGITS: usize = MOST_BITS as usize * 301 / 1000;

/// Maximum number of digits after the decimal point of [`plain`].
const MOST_PLACES: u64 = 60;

/// The reasons why a text is not a decimal number that can be computed with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoDecimal {
    /// The text has another form.
    #[error("it is not a number")]
    Malformed,
    /// The number has too many digits.
    #[error("it has more than {} decimal digits", MOST_DIGITS)]
    TooLong,
}

/// Parses a decimal number such as `0.25` or `1.5e-3`.
///
/// # Errors
/// The text is not one, or the number has more than `MOST_DIGITS` digits.
pub fn decimal(text: &str) -> Result<Ratio, NoDecimal> {
    let (mantissa, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let all_digits = |text: &str| text.bytes().all(|b| b.is_ascii_digit());
    let unsigned = whole.strip_prefix(['-', '+']).unwrap_or(whole);
    let power = exponent.strip_prefix(['-', '+']).unwrap_or(exponent);
    let empty = unsigned.is_empty() && fraction.is_empty();
    if empty || power.is_empty() || ![unsigned, fraction, power].into_iter().all(all_digits) {
        return Err(NoDecimal::Malformed);
    }
    if mantissa.len() > MOST_DIGITS {
        return Err(NoDecimal::TooLong);
    }
    let digits: BigInt = format!("{whole}{fraction}").parse().map_err(|_| NoDecimal::Malformed)?;
    if digits.is_zero() {
        return Ok(Ratio::zero());
    }
    let exponent = exponent.parse::<i64>().map_err(|_| NoDecimal::TooLong)?;
    let exponent = exponent.saturating_sub_unsigned(fraction.len() as u64);
    if exponent.unsigned_abs() > MOST_DIGITS as u64 {
        return Err(NoDecimal::TooLong);
    }
    let power = Pow::pow(BigInt::from(10), exponent.unsigned_abs());
    let exact = if exponent < 0 { Ratio::new(digits, power) } else { Ratio::from(digits * power) };
    if is_short(&exact) { Ok(exact) } else { Err(NoDecimal::TooLong) }
}

/// Returns the shortest decimal that rounds to a double; `None` if the double is not finite.
pub fn shortest(x: f64) -> Option<Ratio> {
    decimal(&format!("{x:e}")).ok()
}

/// Formats the shortest decimal that rounds to a double, with an exponent where it would otherwise
/// have many zeros.
pub fn readable(x: f64) -> String {
    if x == 0.0 || (1e-5..1e16).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

/// Formats a number with at most six significant digits.
pub fn rounded(x: f64) -> String {
    readable(format!("{x:.5e}").parse().unwrap_or(x))
}

/// Returns the integer m and the exponent n of a fraction m / 10^n; `None` if it is not a decimal
/// number.
pub fn scaled(x: &Ratio) -> Option<(BigInt, u64)> {
    let twos = x.denom().trailing_zeros()?;
    let (mut rest, mut fives) = (x.denom() >> twos, 0);
    while !rest.is_one() {
        if !(&rest % 5u8).is_zero() {
            return None;
        }
        (rest, fives) = (rest / 5u8, fives + 1);
    }
    let digits = twos.max(fives);
    Some((x.numer() * (Pow::pow(BigInt::from(10), digits) / x.denom()), digits))
}

/// Formats a fraction: as a decimal number such as `25e-2`, else such as `1/3`.
pub fn text(x: &Ratio) -> String {
    match scaled(x) {
        Some((digits, 0)) => format!("{digits}e0"),
        Some((digits, exponent)) => format!("{digits}e-{exponent}"),
        None => x.to_string(),
    }
}

/// Formats a fraction for users: as a decimal number such as `0.25` if it is one with few zeros, else such
/// as `1/3`.
pub fn plain(x: &Ratio) -> String {
    let Some((digits, exponent)) = scaled(x).filter(|(_, exponent)| *exponent <= MOST_PLACES) else {
        return x.to_string();
    };
    let places = exponent as usize;
    let shown = format!("{:0>width$}", digits.magnitude().to_string(), width = places + 1);
    let (whole, rest) = shown.split_at(shown.len() - places);
    let sign = if digits.is_negative() { "-" } else { "" };
    format!("{sign}{whole}{}{rest}", if places > 0 { "." } else { "" })
}

/// Reads what `text` writes.
pub fn read(text: &str) -> Option<Ratio> {
    let (numerator, denominator) = text.split_once('/').unwrap_or((text, "1"));
    let (n, d) = (decimal(numerator).ok()?, decimal(denominator).ok()?);
    (!d.is_zero()).then(|| n / d)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratio(numerator: i64, denominator: i64) -> Ratio {
        Ratio::new(numerator.into(), denominator.into())
    }

    #[test]
    fn decimals_are_fractions_of_powers_of_ten() {
        for (text, n, d) in [("0.1", 1, 10), ("1.5e-3", 3, 2000), ("12.50", 25, 2), ("2e3", 2000, 1)] {
            assert_eq!(decimal(text), Ok(ratio(n, d)), "{text}");
        }
        for text in ["", "x", "1e", "e1", ".", "1.-5", "1_0", "--1", "inf", "NaN"] {
            assert_eq!(decimal(text), Err(NoDecimal::Malformed), "{text}");
        }
        let long = "7".repeat(MOST_DIGITS + 1);
        for text in ["1e99999", "1e-9223372036854775808", "1e-99999999999999999999", "1e-5000", &long] {
            assert_eq!(decimal(text), Err(NoDecimal::TooLong), "{text}");
        }
        assert_eq!(decimal("0e99999"), Ok(Ratio::zero()));
        assert_eq!(decimal("1e-400").map(|x| x.denom().bits()), Ok(1329));
        assert_eq!(shortest(0.1), Some(ratio(1, 10)));
        assert_eq!(shortest(f64::INFINITY), None);
    }

    #[test]
    fn doubles_far_from_1_have_an_exponent_and_all_keep_their_value() {
        for (x, text) in [
            (0.0, "0"),
            (-0.25, "-0.25"),
            (1.0 / 3.0, "0.3333333333333333"),
            (1e-5, "0.00001"),
            (9.999999999999999e-301, "9.999999999999999e-301"),
            (1e15, "1000000000000000"),
            (-f64::MAX, "-1.7976931348623157e308"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(readable(x), text);
            assert_eq!(text.parse(), Ok(x));
        }
    }

    #[test]
    fn fractions_are_shown_as_users_write_them() {
        for (x, shown) in
            [(ratio(1, 4), "0.25"), (ratio(-7, 1), "-7"), (ratio(-1, 3), "-1/3"), (ratio(1, 1000), "0.001")]
        {
            assert_eq!(plain(&x), shown);
            assert_eq!(read(shown), Some(x));
        }
        let long = decimal("12.34567890123456789012345").unwrap();
        assert_eq!(plain(&long), "12.34567890123456789012345");
        assert!(plain(&decimal("1e-400").unwrap()).starts_with("1/1000"));
    }

    #[test]
    fn fractions_are_written_as_they_are() {
        for (x, written) in [
            (ratio(1, 4), "25e-2"),
            (ratio(-7, 1), "-7e0"),
            (ratio(1, 3), "1/3"),
            (decimal("1e-400").unwrap(), "1e-400"),
            (decimal("0.12345678901234567890123").unwrap(), "12345678901234567890123e-23"),
        ] {
            assert_eq!(text(&x), written);
            assert_eq!(read(written), Some(x));
        }
        assert_eq!(read("1/0"), None);
    }
}
