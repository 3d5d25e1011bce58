//! Output to stdout and stderr.

use std::borrow::Cow;
use std::io::{self, BufWriter, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};

use clap::ValueEnum;
use meliora_base::error::{Diagnostic, Error, Limit, render};
use meliora_base::{escape, json};
use meliora_report::sweep::Outcome;
use meliora_report::{Failure, FailureKind, Report, Style};
use serde::Serialize;

use super::advice;
use super::exit::Status;

/// The form of results on standard output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    /// Text for people.
    Text,
    /// One JSON object.
    Json,
    /// The message of an instance to its sweep.
    Instance,
}

/// The use of colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
#[repr(u8)]
pub(super) enum Color {
    /// On a terminal, unless `NO_COLOR` is set
    #[default]
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

/// The value of `--color`, for messages after the options are out of reach.
static COLOR: AtomicU8 = AtomicU8::new(0);

/// True once results have been written.
static PRINTED: AtomicBool = AtomicBool::new(false);

/// True once the reader of standard output has closed the pipe.
static CLOSED: AtomicBool = AtomicBool::new(false);

/// True once a run ends because nobody reads its results.
static UNREAD: AtomicBool = AtomicBool::new(false);

/// Returns whether the reader of standard output has closed the pipe (`| head`).
pub(super) fn is_closed() -> bool {
    CLOSED.load(Ordering::Relaxed)
}

/// Returns the error that ends a run because nobody reads its results: without a message, and with status 0.
pub(super) fn unread() -> Error {
    UNREAD.store(true, Ordering::Relaxed);
    Limit::Interrupted.into()
}

/// Returns whether the run ends because nobody reads its results.
pub(super) fn is_unread() -> bool {
    UNREAD.load(Ordering::Relaxed)
}

/// Returns whether results have been written, perhaps not all.
pub(super) fn has_printed() -> bool {
    PRINTED.load(Ordering::Relaxed)
}

/// Stores the value of `--color`.
pub(super) fn set_color(color: Color) {
    COLOR.store(color as u8, Ordering::Relaxed);
}

fn colored(terminal: bool) -> bool {
    match COLOR.load(Ordering::Relaxed) {
        c if c == Color::Always as u8 => true,
        c if c == Color::Never as u8 => false,
        _ => terminal && !is_set("NO_COLOR") && std::env::var_os("TERM").is_none_or(|t| t != "dumb"),
    }
}

/// Returns whether an environment variable is set and not empty, as no-color.org defines it.
fn is_set(name: &str) -> bool {
    std::env::var_os(name).is_some_and(|value| !value.is_empty())
}

/// Returns the colours and the width of stdout.
pub(super) fn stdout_style() -> Style {
    let terminal = io::stdout().is_terminal();
    let width = terminal.then(terminal_size::terminal_size).flatten().map(|(width, _)| width.0);
    Style { color: colored(terminal), width }
}

/// Returns the colours of stderr.
pub(super) fn stderr_style() -> Style {
    Style { color: colored(io::stderr().is_terminal()), width: None }
}

/// Writes a text for people. A reader that has closed the pipe (`| head`) is not an error.
///
/// # Errors
/// Standard output cannot be written, for example because the disk is full.
pub(super) fn print(text: &str) -> Result<(), Error> {
    print_bytes(stdout_style().finished(text).as_bytes())
}

/// Writes the content of a file as it is.
///
/// # Errors
/// The errors of [`print`].
pub(super) fn print_bytes(content: &[u8]) -> Result<(), Error> {
    print_by(|out| out.write_all(content))
}

/// Writes a report as text.
///
/// # Errors
/// The errors of [`print`].
pub(super) fn print_report(report: &impl Report, style: Style) -> Result<(), Error> {
    print_by(|out| report.write(style, out))
}

fn print_by(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Error> {
    PRINTED.store(true, Ordering::Relaxed);
    let mut out = BufWriter::new(io::stdout().lock());
    match write(&mut out).and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::Limit(Limit::Output { what: format!("standard output: {e}") }))
        }
        Err(_) => {
            CLOSED.store(true, Ordering::Relaxed);
            Ok(())
        }
        Ok(()) => Ok(()),
    }
}

/// Writes one JSON object.
///
/// # Errors
/// The errors of [`print`].
pub(super) fn print_json(value: &impl Serialize) -> Result<(), Error> {
    print_by(|out| {
        json::write_pretty(value, &mut *out)?;
        out.write_all(b"\n")
    })
}

/// Writes an error in JSON, if results have that form.
///
/// # Errors
/// The errors of [`print`].
pub(super) fn print_failure(failure: &Failure, form: Form) -> Result<(), Error> {
    match form {
        Form::Text => Ok(()),
        Form::Json => print_json(failure),
        Form::Instance => print_json(&Outcome::failed(failure)),
    }
}

/// Writes a line to stderr and ignores errors.
pub(super) fn message(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", stderr_style().finished(text));
}

/// Writes messages that point into a text to stderr.
pub(super) fn point(diagnostics: &[Diagnostic]) {
    let text = render(diagnostics, stderr_style().color);
    let _ = writeln!(io::stderr().lock(), "{}", text.trim_end());
}

/// Shows an error on stderr. `progress` says how far the work got.
pub(super) fn show_error(error: &Error, progress: Option<&str>) {
    let style = stderr_style();
    match error {
        Error::Input(diagnostics) if !diagnostics.is_empty() => point(diagnostics),
        _ => message(&format!("{}: {}", style.bad("error"), advice::message(error))),
    }
    if let Some(progress) = progress {
        message(&format!("  {progress}"));
    }
}

/// Shows a bug in this program.
pub(super) fn show_internal(text: &str) {
    let style = stderr_style();
    message(&format!(
        "{}: {text}\n  This is a bug in meliora, not an error in your files.",
        style.bad("internal error")
    ));
}

/// Joins the error and the names that it lists into one line: clap puts the names on separate
/// lines.
fn one_line(text: &str) -> String {
    let wrong: Vec<&str> = text
        .lines()
        .map(str::trim)
        .take_while(|line| {
            !["Usage:", "tip:", "For more information"].iter().any(|end| line.starts_with(end))
        })
        .collect();
    let mut line = wrong.iter().copied().filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
    if line.is_empty() {
        line.push_str("wrong usage");
    }
    line.strip_prefix("error: ").map(str::to_owned).unwrap_or(line)
}

/// Shows the messages of clap: help and version on stdout, usage errors on stderr.
pub(super) fn show_clap(error: &clap::Error, form: Form) -> Status {
    if !error.use_stderr() {
        return match error.print() {
            Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Status::Limit,
            _ => Status::Done,
        };
    }
    let text = error.render().to_string();
    // A message of clap repeats arguments, and is coloured only as it is.
    match escape::lines(&text) {
        Cow::Borrowed(_) => drop(error.print()),
        Cow::Owned(text) => message(text.trim_end()),
    }
    match print_failure(&Failure::new(FailureKind::Usage, one_line(&text)), form) {
        Ok(()) => Status::Usage,
        Err(_) => Status::Limit,
    }
}
