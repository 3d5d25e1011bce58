//! Colours and width of text for people.

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
        self.paint("1", text)
    }

    /// Formats less important text.
    pub fn dim(self, text: &str) -> String {
        self.paint("2", text)
    }

    /// Formats a success.
    pub fn good(self, text: &str) -> String {
        self.paint("32", text)
    }

    /// Formats a warning.
    pub fn warn(self, text: &str) -> String {
        self.paint("1;33", text)
    }

    /// Formats a failure.
    pub fn bad(self, text: &str) -> String {
        self.paint("1;31", text)
    }

    fn paint(self, code: &str, text: &str) -> String {
        if self.color { format!("\u{1b}[{code}m{text}\u{1b}[0m") } else { text.to_owned() }
    }
}
