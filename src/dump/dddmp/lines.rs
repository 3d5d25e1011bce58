//! Numbered lines of bounded length.

use std::io::BufRead;

use meliora_base::error::{Error, Result, ensure};

/// The maximum length of a line, in bytes; lists of variables and roots are the longest.
const LONGEST: usize = 64 << 20;

/// The lines of a text, one at a time.
pub(super) struct Lines<'a, R> {
    file: &'a str,
    input: R,
    buffer: Vec<u8>,
    number: usize,
}

impl<'a, R: BufRead> Lines<'a, R> {
    /// Starts before the first line of `input`, which messages call `file`.
    pub(super) fn new(file: &'a str, input: R) -> Self {
        Lines { file, input, buffer: Vec::new(), number: 0 }
    }

    /// Reads the next line; returns false at the end of the text.
    pub(super) fn advance(&mut self) -> Result<bool> {
        self.buffer.clear();
        self.number += 1;
        loop {
            let chunk = match self.input.fill_buf() {
                Ok(chunk) => chunk,
                Err(e) => return Err(Error::Io { path: self.file.to_owned(), message: e.to_string() }),
            };
            let end = chunk.iter().position(|&b| b == b'\n');
            let used = end.unwrap_or(chunk.len());
            if self.buffer.len() + used > LONGEST {
                return Err(self.wrong(format!("the line is longer than {} MiB", LONGEST >> 20)));
            }
            self.buffer.extend_from_slice(&chunk[..used]);
            let at_end = chunk.is_empty();
            self.input.consume(used + usize::from(end.is_some()));
            if end.is_some() || at_end {
                if self.buffer.last() == Some(&b'\r') {
                    self.buffer.pop();
                }
                return Ok(end.is_some() || !self.buffer.is_empty());
            }
        }
    }

    /// Reads the next line; fails at the end of the text with the expected content.
    pub(super) fn expect(&mut self, what: &str) -> Result<()> {
        let is_there = self.advance()?;
        self.ensure(is_there, || format!("expected {what}, found the end of the file"))
    }

    /// Returns the present line.
    pub(super) fn line(&self) -> &[u8] {
        &self.buffer
    }

    /// Returns the words of the present line.
    pub(super) fn words(&self) -> impl Iterator<Item = &[u8]> {
        self.buffer.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty())
    }

    /// Returns an error for the present line if a condition is false.
    pub(super) fn ensure(&self, holds: bool, message: impl FnOnce() -> String) -> Result<()> {
        ensure(holds, || self.wrong(message()))
    }

    /// Returns an error for the present line.
    pub(super) fn wrong(&self, message: impl Into<String>) -> Error {
        Error::Dump { file: self.file.to_owned(), line: self.number, message: message.into() }
    }
}

/// Parses a number with an optional minus sign; none if the word is not a number or has more than
/// 18 digits.
pub(super) fn number(word: &[u8]) -> Option<i64> {
    let (digits, negative) = match word {
        [b'-', rest @ ..] => (rest, true),
        all => (all, false),
    };
    if digits.is_empty() || digits.len() > 18 || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let value = digits.iter().fold(0i64, |n, d| 10 * n + i64::from(d - b'0'));
    Some(if negative { -value } else { value })
}

/// Formats a word for a message: escaped and short.
pub(super) fn shown(word: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(word).chars().take(40).collect();
    text.escape_debug().to_string()
}
