//! Estimates the width of texts, for drawings that are made without fonts.

/// Maximum number of characters of a drawn name; longer ones are shortened.
pub(super) const LONGEST: usize = 30;

/// Returns the width of a text in units of its font size, for bold type of the widest of the usual
/// sans-serif fonts.
pub(super) fn width(text: &str) -> f64 {
    text.chars().map(letter).sum()
}

fn letter(c: char) -> f64 {
    match c {
        'i' | 'j' | 'l' | 'I' | 'J' | ' ' | ',' | '.' | ':' | ';' | '\'' | '|' | '!' => 0.41,
        'f' | 'r' | 't' | '(' | ')' | '-' | '_' | '"' => 0.52,
        'm' | 'w' | 'M' | 'W' | '%' | '@' => 1.11,
        'A'..='Z' | '+' | '=' | '<' | '>' | '~' | '#' | '&' => 0.85,
        c if c.is_ascii() => 0.72,
        _ => 1.05,
    }
}

/// Returns the text, or its beginning and its end if it has more than `most` characters.
pub(super) fn shortened(text: &str, most: usize) -> String {
    let letters: Vec<char> = text.chars().collect();
    if letters.len() <= most {
        return text.to_owned();
    }
    let head = most * 2 / 3;
    let (head, tail) = (&letters[..head], &letters[letters.len() + head + 1 - most..]);
    head.iter().chain(&['…']).chain(tail).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_keep_their_beginning_and_their_end() {
        let long: String = ('a'..='z').cycle().take(100).collect();
        let short = shortened(&long, LONGEST);
        assert_eq!(short.chars().count(), LONGEST);
        assert!(long.starts_with(short.split('…').next().unwrap()));
        assert!(long.ends_with(short.split('…').nth(1).unwrap()));
        assert_eq!(shortened("goal", LONGEST), "goal");
    }

    #[test]
    fn wide_letters_take_more_room() {
        assert!(width("WWW") > width("aaa") && width("aaa") > width("iii"));
    }
}
