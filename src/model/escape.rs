//! Escaping of untrusted text for display: names in files, and names of files, may contain
//! characters that move the cursor, hide words or reverse the writing direction.

use std::borrow::Cow;

/// Returns true if terminals display the character and do nothing else with it.
pub fn is_shown(c: char) -> bool {
    let turns_or_hides = matches!(c,
        '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}'
        | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}');
    !c.is_control() && !turns_or_hides
}

/// Escapes a text to one line: escapes such as `\n` and `\u{1b}` replace characters that are not
/// displayed.
pub fn line(text: &str) -> Cow<'_, str> {
    escaped(text, is_shown)
}

/// Escapes a text but keeps its line breaks.
pub fn lines(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c == '\n' || is_shown(c))
}

/// Maximum number of characters of a message, and of an offending text in one.
const MOST_SHOWN: [usize; 2] = [4000, 60];

/// Returns an offending text for a message: of a long one, the beginning and the end.
pub fn shortened(text: &str) -> Cow<'_, str> {
    cut(text, MOST_SHOWN[1])
}

/// Returns a message: of a long one, the beginning and the end.
pub(crate) fn bounded(text: &str) -> Cow<'_, str> {
    cut(text, MOST_SHOWN[0])
}

fn cut(text: &str, most: usize) -> Cow<'_, str> {
    if text.len() <= most {
        return Cow::Borrowed(text);
    }
    let (head, tail) = (text.floor_char_boundary(most / 2), text.ceil_char_boundary(text.len() - most / 2));
    let left_out = text[head..tail].chars().count();
    Cow::Owned(format!("{}… ({left_out} characters) …{}", &text[..head], &text[tail..]))
}

fn escaped(text: &str, keep: impl Fn(char) -> bool) -> Cow<'_, str> {
    if text.chars().all(&keep) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            c if keep(c) => out.push(c),
            '\n' | '\r' | '\t' => out.extend(c.escape_default()),
            c => out.extend(c.escape_unicode()),
        }
    }
    Cow::Owned(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn characters_that_move_or_hide_or_turn_text_are_spelled_out() {
        assert_eq!(line("a \u{1b}[2J\u{9b}b\r\n"), "a \\u{1b}[2J\\u{9b}b\\r\\n");
        assert_eq!(lines("é\n\u{202e}x"), "é\n\\u{202e}x");
        assert!(matches!(line("plain, é, ≥"), Cow::Borrowed(_)));
    }

    #[test]
    fn long_texts_are_cut_in_the_middle() {
        assert_eq!(shortened("short, é"), "short, é");
        let long = shortened(&format!("a{}z", "é".repeat(1000))).into_owned();
        assert!(long.starts_with('a') && long.ends_with('z') && long.chars().count() < 100, "{long}");
    }
}
