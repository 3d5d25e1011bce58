//! The progress line on stderr, which only a terminal shows.

use std::io::{self, IsTerminal, Write};
use std::time::{Duration, Instant};

/// The interval between two drawings.
const INTERVAL: Duration = Duration::from_millis(50);
/// The width of a terminal that does not tell its own.
const WIDTH: usize = 80;
/// The characters that turn during the work.
const TURNING: [char; 4] = ['|', '/', '-', '\\'];

/// A line that is drawn again and again at the same place.
pub(super) struct ProgressLine {
    is_terminal: bool,
    /// The time of the last drawing.
    drawn: Option<Instant>,
    turns: usize,
    /// The number of characters on the terminal.
    shown: usize,
}

impl ProgressLine {
    pub(super) fn new() -> Self {
        ProgressLine { is_terminal: io::stderr().is_terminal(), drawn: None, turns: 0, shown: 0 }
    }

    /// Draws the line, unless it was drawn just before.
    pub(super) fn draw(&mut self, elapsed: Duration, text: &str) {
        let now = Instant::now();
        if !self.is_terminal || self.drawn.is_some_and(|last| now.duration_since(last) < INTERVAL) {
            return;
        }
        self.drawn = Some(now);
        self.turns += 1;
        let turning = TURNING[self.turns % TURNING.len()];
        // The last column stays free: some terminals begin a new line after it.
        let room =
            terminal_size::terminal_size_of(io::stderr()).map_or(WIDTH, |(width, _)| width.0.into()) - 1;
        let line = format!("{turning} {}s {text}", elapsed.as_secs());
        self.write(&line.chars().take(room).collect::<String>());
    }

    /// Removes the line.
    pub(super) fn clear(&mut self) {
        if self.shown > 0 {
            self.write("");
            self.drawn = None;
        }
    }

    /// Replaces the text; blanks cover the rest of the old one.
    fn write(&mut self, line: &str) {
        let length = line.chars().count();
        let rest = " ".repeat(self.shown.saturating_sub(length));
        let back = if length == 0 { "\r" } else { "" };
        let mut out = io::stderr().lock();
        let _ = write!(out, "\r{line}{rest}{back}").and_then(|()| out.flush());
        self.shown = length;
    }
}
