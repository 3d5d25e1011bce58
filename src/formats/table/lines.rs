//! Lines of the text formats, with their places.

use std::ops::Range;
use std::sync::Arc;

use num_traits::Zero;

use meliora_base::error::{Diagnostic, Error, Severity, SourceFile};
use meliora_base::escape::shortened;
use meliora_base::exact::{NoDecimal, Ratio, decimal};
use meliora_base::span::Span;

/// A line that is not empty and not a comment.
#[derive(Clone, Copy)]
pub(super) struct Line<'s> {
    source: &'s Arc<SourceFile>,
    start: usize,
    /// The text without blanks around it.
    pub(super) text: &'s str,
}

/// A part of a text.
#[derive(Clone)]
pub(super) struct Part<'s> {
    pub(super) source: &'s Arc<SourceFile>,
    pub(super) range: Range<usize>,
}

impl<'s> Part<'s> {
    /// Returns the whole text.
    pub(super) fn whole(source: &'s Arc<SourceFile>) -> Self {
        Part { source, range: 0..source.text.len() }
    }

    /// Returns the lines that are not empty.
    pub(super) fn all_lines(&self) -> impl Iterator<Item = Line<'s>> + use<'s> {
        let (source, mut start) = (self.source, self.range.start);
        let text = source.text.get(self.range.clone()).unwrap_or_default();
        let all = text.split('\n').map(move |raw| {
            let line = Line { source, start: start + raw.len() - raw.trim_start().len(), text: raw.trim() };
            start += raw.len() + 1;
            line
        });
        all.filter(|line| !line.text.is_empty())
    }

    /// Returns the lines that are not empty and do not start with `comment`.
    pub(super) fn lines(&self, comment: &'static str) -> impl Iterator<Item = Line<'s>> + use<'s> {
        self.all_lines().filter(move |line| !line.text.starts_with(comment))
    }
}

/// Returns the lines of a text that are not empty and do not start with `comment`.
pub(super) fn lines<'s>(
    source: &'s Arc<SourceFile>,
    comment: &'static str,
) -> impl Iterator<Item = Line<'s>> + use<'s> {
    Part::whole(source).lines(comment)
}

impl Line<'_> {
    /// Returns an error at this line.
    pub(super) fn wrong(&self, message: impl Into<String>) -> Error {
        self.diagnostic(message).into()
    }

    /// Returns the part of this line with a text that was taken from it.
    pub(super) fn part<'p>(&self, text: &'p str) -> Line<'p>
    where
        Self: 'p,
    {
        let at = (text.as_ptr() as usize).saturating_sub(self.text.as_ptr() as usize);
        Line { source: self.source, start: self.start + at, text }
    }

    /// Returns an error at this line, for a valid text that is not supported.
    pub(super) fn refused(&self, what: &str) -> Error {
        let diagnostic = self.diagnostic(format!("{what} are not supported"));
        diagnostic.severity(Severity::Unsupported).into()
    }

    /// Returns the position of the first character.
    pub(super) fn start(&self) -> usize {
        self.start
    }

    /// Returns the file and the place of the line in it.
    pub(super) fn place(&self) -> (Arc<SourceFile>, Span) {
        (Arc::clone(self.source), Span::new(self.start, self.start + self.text.len()))
    }

    /// Returns the whole text of the file.
    pub(super) fn whole(&self) -> &str {
        &self.source.text
    }

    pub(super) fn diagnostic(&self, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(self.source, self.start..self.start + self.text.len(), message)
    }

    /// Reads the number of a state or a choice.
    pub(super) fn index(&self, text: &str) -> Result<usize, Error> {
        text.parse().map_err(|_| self.wrong(format!("`{text}` is not a whole number")))
    }

    /// Reads a decimal number or a fraction, exactly.
    pub(super) fn number(&self, text: &str) -> Result<Ratio, Error> {
        let (numerator, denominator) = text.split_once('/').unwrap_or((text, "1"));
        let parts = decimal(numerator.trim()).and_then(|n| Ok((n, decimal(denominator.trim())?)));
        let number = parts.and_then(|(n, d)| if d.is_zero() { Err(NoDecimal::Malformed) } else { Ok(n / d) });
        number.map_err(|reason| match reason {
            NoDecimal::Malformed => self.wrong(format!("`{}` is not a number", shortened(text))),
            NoDecimal::TooLong => self.wrong(format!("`{}`: {reason}", shortened(text))),
        })
    }
}
