//! Colours and width of text for people.

use meliora_base::escape;

/// The marks of colours while a text is put together, with their sequences. Texts from files contain
/// no such characters that have an effect: [`Style::finished`] writes only these sequences.
const MARKS: [(char, &str); 6] = [
    (END, "\u{1b}[0m"),
    ('\u{fdd1}', "\u{1b}[1m"),
    ('\u{fdd2}', "\u{1b}[2m"),
    ('\u{fdd3}', "\u{1b}[32m"),
    ('\u{fdd4}', "\u{1b}[1;33m"),
    ('\u{fdd5}', "\u{1b}[1;31m"),
];
/// The mark of the end of a colour.
const END: char = '\u{fdd0}';

/// The layout of text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Style {
    /// True if escape sequences are written.
    pub color: bool,
    /// Maximum number of columns; `None` if the output is not a terminal.
    pub width: Option<u16>,
}

impl Style {
    /// A style without colours and without a maximum width.
    pub const PLAIN: Style = Style { color: false, width: None };

    /// Formats a heading.
    pub(crate) fn bold(self, text: &str) -> String {
        self.paint('\u{fdd1}', text)
    }

    /// Formats less important text.
    pub fn dim(self, text: &str) -> String {
        self.paint('\u{fdd2}', text)
    }

    /// Formats a success.
    pub fn good(self, text: &str) -> String {
        self.paint('\u{fdd3}', text)
    }

    /// Formats a warning.
    pub fn warn(self, text: &str) -> String {
        self.paint('\u{fdd4}', text)
    }

    /// Formats a failure.
    pub fn bad(self, text: &str) -> String {
        self.paint('\u{fdd5}', text)
    }

    fn paint(self, mark: char, text: &str) -> String {
        if self.color { format!("{mark}{text}{END}") } else { text.to_owned() }
    }

    /// Returns a whole text as a terminal may show it: escapes such as `\u{1b}` replace all characters
    /// that are not displayed, except for line breaks and the colours of this style.
    pub fn finished(self, text: &str) -> String {
        if !self.color {
            return escape::lines(text).into_owned();
        }
        let sequence = |c: char| MARKS.iter().find(|(mark, _)| *mark == c).map(|(_, sequence)| *sequence);
        let mut out = String::with_capacity(text.len() + 16);
        for part in text.split_inclusive(|c| sequence(c).is_some()) {
            let mark = part.chars().next_back().and_then(|c| Some((c.len_utf8(), sequence(c)?)));
            let (length, sequence) = mark.unwrap_or((0, ""));
            out += &escape::lines(&part[..part.len() - length]);
            out += sequence;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_colours_of_this_program_reach_a_terminal() {
        let style = Style { color: true, width: None };
        let text = style.bold("a\u{1b}[2J\u{9b}") + &style.bad("\u{202e}\n") + "\u{fdef}é";
        let expected = "\u{1b}[1ma\\u{1b}[2J\\u{9b}\u{1b}[0m\u{1b}[1;31m\\u{202e}\n\u{1b}[0m\\u{fdef}é";
        assert_eq!(style.finished(&text), expected);
        assert_eq!(Style::PLAIN.finished("\u{fdd1}a\u{1b}[1m"), "\\u{fdd1}a\\u{1b}[1m");
        assert_eq!(style.finished("\u{1b}[1ma"), "\\u{1b}[1ma");
    }
}
