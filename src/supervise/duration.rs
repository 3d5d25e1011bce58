//! Durations such as `30s`.

use std::time::Duration;

/// Reads a duration: `1h 30m`, `500ms`, or a plain number of seconds.
///
/// # Errors
/// The text is not a duration, or its duration is 0.
pub fn parse_duration(text: &str) -> Result<Duration, String> {
    let parsed = match text.trim().parse::<f64>() {
        Ok(seconds) => Duration::try_from_secs_f64(seconds).map_err(|e| e.to_string()),
        Err(_) => humantime::parse_duration(text).map_err(|e| e.to_string()),
    };
    match parsed {
        Ok(duration) if duration.is_zero() => Err("a time limit must be longer than 0".to_owned()),
        Ok(duration) => Ok(duration),
        Err(e) => Err(format!("{e}; a duration is written as 500ms, 30s, 5m or 1h30m")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_have_units_or_are_seconds() {
        assert_eq!(parse_duration("500ms"), Ok(Duration::from_millis(500)));
        assert_eq!(parse_duration("2"), Ok(Duration::from_secs(2)));
        assert_eq!(parse_duration("1h 1m"), Ok(Duration::from_secs(3660)));
        for text in ["0", "-1", "soon", "1 apple", "inf", "nan"] {
            assert!(parse_duration(text).is_err(), "{text}");
        }
    }
}
