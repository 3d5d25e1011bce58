//! Durations such as `30s`.

use std::time::Duration;

/// Reads a duration: `1h 30m`, `500ms`, or a plain number of seconds.
///
/// # Errors
/// The text is not a duration, or its duration is 0.
pub fn parse_duration(text: &str) -> Result<Duration, String> {
    let parsed = match text.trim().parse::<f64>() {
        Ok(seconds) => Duration::try_from_secs_f64(seconds).map_err(|e| e.to_string()),
        Err(_) => with_units(text).ok_or_else(|| "this is not a duration".to_owned()),
    };
    match parsed {
        Ok(duration) if duration.is_zero() => Err("a time limit must be longer than 0".to_owned()),
        Ok(duration) => Ok(duration),
        Err(e) => Err(format!("{e}; a duration is written as 500ms, 30s, 5m or 1h30m")),
    }
}

/// Reads numbers with units, such as `1h 30m`, and adds them up.
fn with_units(text: &str) -> Option<Duration> {
    let (mut rest, mut sum) = (text.trim(), Duration::ZERO);
    while !rest.is_empty() {
        let (number, after) = rest.split_at(rest.find(|c: char| !c.is_ascii_digit())?);
        let after = after.trim_start();
        let end = after.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(after.len());
        let millis = match &after[..end] {
            "ms" => 1,
            "s" | "sec" => 1000,
            "m" | "min" => 60 * 1000,
            "h" => 3600 * 1000,
            "d" => 24 * 3600 * 1000,
            _ => return None,
        };
        let length = number.parse::<u64>().ok()?.checked_mul(millis)?;
        sum = sum.checked_add(Duration::from_millis(length))?;
        rest = after[end..].trim_start();
    }
    Some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_have_units_or_are_seconds() {
        assert_eq!(parse_duration("500ms"), Ok(Duration::from_millis(500)));
        assert_eq!(parse_duration("2"), Ok(Duration::from_secs(2)));
        assert_eq!(parse_duration("1h 1m"), Ok(Duration::from_secs(3660)));
        assert_eq!(parse_duration("2 min 5s"), Ok(Duration::from_secs(125)));
        for text in ["0", "-1", "soon", "1 apple", "inf", "nan", "", "1h30", "5m-", "99999999999999999999d"] {
            assert!(parse_duration(text).is_err(), "{text}");
        }
    }
}
