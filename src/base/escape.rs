//! Escaping of untrusted text: names in files, and names of files, may contain characters that move
//! the cursor, hide words or reverse the writing direction.
//!
//! A name of a program has only characters that are displayed: `meliora_lang` sees to it for every
//! format of models. Each target has one function for what else it cannot contain:
//!
//! | target | function |
//! | --- | --- |
//! | terminal, messages | [`line()`], [`lines`] |
//! | actions in `.tra` and `.drn`, DDDMP | [`word`], [`unword`] |
//! | rewards in `.drn` | [`first_word`], [`unword`] |
//! | labels in `.lab` and `.drn` | [`quoted`], [`unquoted`] |
//! | DOT | [`dot`] |
//! | CSV | [`crate::csv::cell`] |
//! | a value in a state, `x=go` | [`value()`] |
//! | JSON | [`crate::json`] |
//! | HTML | the template language of the pages; data of scripts: [`crate::json::script`] |

use std::borrow::Cow;

/// Returns true if terminals display the character and do nothing else with it.
pub fn is_shown(c: char) -> bool {
    let turns_or_hides = matches!(c,
        '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}'
        | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}');
    !c.is_control() && !turns_or_hides && !is_noncharacter(c)
}

/// Returns true for the characters that Unicode leaves to programs, which use them as marks.
fn is_noncharacter(c: char) -> bool {
    matches!(c, '\u{fdd0}'..='\u{fdef}') || u32::from(c) & 0xfffe == 0xfffe
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

/// Returns a text as a string of the DOT language, with its quotes. Line breaks stay.
pub fn dot(text: &str) -> String {
    format!("\"{}\"", lines(text).replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n"))
}

/// Returns the name of a value as it stands in a state, `x=NAME,y=1`. A name that could be read as
/// something else gets double quotes, and each of its own is doubled: numbers, truth values, and names
/// with commas, quotes, comments or outer blanks.
pub fn value(name: &str) -> Cow<'_, str> {
    match is_plain(name) {
        true => Cow::Borrowed(name),
        false => Cow::Owned(quoted(name)),
    }
}

/// Returns a name in double quotes; each of its own is doubled. [`unquoted`] is the inverse.
pub fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('"', "\"\""))
}

/// Reads a name in double quotes at the beginning of a text; returns it with the rest of the text.
pub fn unquoted(text: &str) -> Option<(String, &str)> {
    let inside = text.strip_prefix('"')?;
    let mut at = 0;
    loop {
        at += inside[at..].find('"')?;
        match inside[at + 1..].starts_with('"') {
            true => at += 2,
            false => return Some((inside[..at].replace("\"\"", "\""), &inside[at + 1..])),
        }
    }
}

/// Returns true for a name that stands for itself up to the next comma.
fn is_plain(name: &str) -> bool {
    name.starts_with(|c: char| c.is_alphabetic() || c == '_')
        && !name.ends_with(char::is_whitespace)
        && !name.contains([',', '"'])
        && !name.contains("//")
        && !matches!(name, "true" | "false")
}

/// Returns a text as one word: `%20` and the like replace the UTF-8 bytes of blanks, of characters
/// that are not displayed, and of `%`, `[` and `]`. [`unword`] is the inverse.
pub fn word(text: &str) -> Cow<'_, str> {
    encoded_where(text, breaks_words)
}

/// Returns a text as one word that can stand at the beginning of a line of `.drn`: there, `{`, `!`, `@`, `/` and `"`
/// have a meaning and are replaced, too. [`unword`] is the inverse.
pub fn first_word(text: &str) -> Cow<'_, str> {
    encoded_where(text, |c| breaks_words(c) || matches!(c, '{' | '!' | '@' | '/' | '"'))
}

/// Replaces some characters by their bytes, such as `%20`.
fn encoded_where(text: &str, is_replaced: fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(is_replaced) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match is_replaced(c) {
            true => c.encode_utf8(&mut [0; 4]).bytes().for_each(|byte| out += &format!("%{byte:02X}")),
            false => out.push(c),
        }
    }
    Cow::Owned(out)
}

/// Returns the text of a word. Where it is not as [`word`] or [`first_word`] writes it, it stays as it is.
pub fn unword(word: &str) -> Cow<'_, str> {
    if !word.contains('%') {
        return Cow::Borrowed(word);
    }
    let (mut out, mut left) = (String::with_capacity(word.len()), word);
    while let Some(at) = left.find('%') {
        out.push_str(&left[..at]);
        left = &left[at..];
        let (c, length) = encoded(left).unwrap_or(('%', 1));
        out.push(c);
        left = &left[length..];
    }
    Cow::Owned(out + left)
}

/// Returns true if a word does not contain the character itself.
fn breaks_words(c: char) -> bool {
    c.is_whitespace() || matches!(c, '%' | '[' | ']') || !is_shown(c)
}

/// Reads a character in the form that [`first_word`] gives it; returns it with the length of the form.
fn encoded(text: &str) -> Option<(char, usize)> {
    let byte = |part: &[u8]| u8::from_str_radix(std::str::from_utf8(part.get(1..)?).ok()?, 16).ok();
    let bytes: Vec<u8> = text.as_bytes().chunks_exact(3).take(4).map_while(byte).collect();
    let first = bytes.utf8_chunks().next()?.valid().chars().next()?;
    let form = first_word(first.encode_utf8(&mut [0; 4])).into_owned();
    (form.len() > 1 && text.starts_with(&form)).then_some((first, form.len()))
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
    fn texts_are_strings_of_dot() {
        assert_eq!(dot("a \"b\" \\N\n\u{1b}é"), r#""a \"b\" \\N\n\\u{1b}é""#);
    }

    #[test]
    fn words_have_no_blanks_and_no_brackets_and_others_stay_as_they_are() {
        assert_eq!(word("go left"), "go%20left");
        assert_eq!(word("\u{1b}[2J\n\u{202e}é"), "%1B%5B2J%0A%E2%80%AEé");
        assert!(matches!(word("l(m1#2,m2#1)"), Cow::Borrowed(_)));
        for other in ["100%", "%2", "%zz", "%41", "%C3%A9", "%FF", "%é2", "%+1", "%E2%80", "%e2%80%ae", "%5b"]
        {
            assert_eq!(unword(other), other);
        }
    }

    #[test]
    fn long_texts_are_cut_in_the_middle() {
        assert_eq!(shortened("short, é"), "short, é");
        let long = shortened(&format!("a{}z", "é".repeat(1000))).into_owned();
        assert!(long.starts_with('a') && long.ends_with('z') && long.chars().count() < 100, "{long}");
    }
}
