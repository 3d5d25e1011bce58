//! Diagnostics that point at a place in a text, and their rendering.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

use crate::escape;

/// Maximum size of the lines that are shown together, in bytes.
const LARGEST_EXCERPT: usize = 1 << 16;
/// The number of bytes behind a place after which its line may be cut; the terminal shows fewer.
const FAR: usize = 1 << 10;

/// A text with a name, kept for messages that point into it.
#[derive(Debug, PartialEq, Eq)]
pub struct SourceFile {
    /// The path as the user gave it, or a description such as `--target`.
    pub name: String,
    /// The whole text, without a byte order mark. Lines end with `\n` or `\r\n`; a single `\r` has
    /// been replaced by `\n`.
    pub text: String,
    /// The original text, if it differs.
    original: Option<String>,
    /// The place of the first byte that is not UTF-8, if the bytes were read as Latin-1.
    latin1: Option<usize>,
}

impl SourceFile {
    /// Stores a text with its name.
    pub fn new(name: impl Into<String>, text: impl Into<String>) -> Arc<Self> {
        Arc::new(SourceFile::stored(name.into(), text.into(), None))
    }

    fn stored(name: String, text: String, latin1: Option<usize>) -> Self {
        let plain = text.strip_prefix('\u{feff}').unwrap_or(&text);
        match lines_ended(plain) {
            Cow::Borrowed(same) if same.len() == text.len() => {
                SourceFile { name, text, original: None, latin1 }
            }
            read => {
                let read = read.into_owned();
                SourceFile { name, text: read, original: Some(text), latin1 }
            }
        }
    }

    /// Stores a text that was read as Latin-1; `place` is that of its first byte that is not UTF-8.
    pub(crate) fn of_latin1(name: String, text: String, place: usize) -> Arc<Self> {
        Arc::new(SourceFile::stored(name, text, Some(place)))
    }

    /// Returns the warning that the bytes were not UTF-8 and are read as Latin-1; `None` if they were.
    pub fn encoding_warning(self: &Arc<Self>) -> Option<Diagnostic> {
        let place = self.floor(self.latin1?);
        let end = self.floor(place + 2).max(place);
        let message = "the file is not UTF-8, and is read as Latin-1";
        Some(
            Diagnostic::new(self, place..end, message)
                .severity(Severity::Warning)
                .label("the first byte that is not UTF-8"),
        )
    }

    /// Returns the text as it was given.
    pub fn original(&self) -> &str {
        self.original.as_deref().unwrap_or(&self.text)
    }

    /// Returns a part of the text on one line, with single spaces.
    pub fn on_one_line(&self, place: Range<usize>) -> String {
        self.text.get(place).unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ")
    }

    /// Returns line and column of a byte offset, both from 1; columns count characters.
    pub fn position(&self, offset: usize) -> (usize, usize) {
        let offset = self.floor(offset);
        let before = &self.text[..offset];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }

    /// Returns the nearest character boundary at or before `offset`.
    fn floor(&self, offset: usize) -> usize {
        self.text.floor_char_boundary(offset.min(self.text.len()))
    }
}

/// Replaces every `\r` without a following `\n` by `\n`.
fn lines_ended(text: &str) -> Cow<'_, str> {
    let alone = |(at, _): &(usize, &str)| text.as_bytes().get(at + 1) != Some(&b'\n');
    let mut ends = text.match_indices('\r').filter(alone).map(|(at, _)| at).peekable();
    if ends.peek().is_none() {
        return Cow::Borrowed(text);
    }
    let mut ended = String::with_capacity(text.len());
    let mut start = 0;
    for end in ends {
        ended.push_str(&text[start..end]);
        ended.push('\n');
        start = end + 1;
    }
    Cow::Owned(ended + &text[start..])
}

/// The severity of a diagnostic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Severity {
    /// An error.
    #[default]
    Error,
    /// Valid input that is not supported.
    Unsupported,
    /// Suspicious input.
    Warning,
}

/// A message that points at a place in a text.
#[derive(Debug, Clone)]
pub struct Diagnostic {
    /// The severity.
    pub severity: Severity,
    /// The message.
    pub message: String,
    /// The text that it points into.
    pub source: Arc<SourceFile>,
    /// The byte range that it points at.
    pub span: Range<usize>,
    /// The text below the caret.
    pub label: String,
    /// Advice.
    pub help: Option<String>,
    /// Further facts.
    pub notes: Vec<String>,
    /// Other relevant places of the same text, each with the text below it.
    pub related: Vec<(Range<usize>, String)>,
}

impl Diagnostic {
    /// Creates an error at a place.
    pub fn new(source: &Arc<SourceFile>, span: Range<usize>, message: impl Into<String>) -> Self {
        Diagnostic {
            severity: Severity::Error,
            message: bounded(message),
            source: Arc::clone(source),
            span,
            label: String::new(),
            help: None,
            notes: Vec::new(),
            related: Vec::new(),
        }
    }

    /// Sets the severity.
    #[must_use]
    pub fn severity(mut self, severity: Severity) -> Self {
        self.severity = severity;
        self
    }

    /// Sets the text below the caret.
    #[must_use]
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = bounded(label);
        self
    }

    /// Sets the advice.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(bounded(help));
        self
    }

    /// Adds a fact.
    #[must_use]
    pub fn note(mut self, note: impl Into<String>) -> Self {
        self.notes.push(bounded(note));
        self
    }

    /// Adds another place of the same text.
    #[must_use]
    pub fn related(mut self, span: Range<usize>, label: impl Into<String>) -> Self {
        self.related.push((span, bounded(label)));
        self
    }

    /// Returns line and column of the place, both from 1.
    pub fn position(&self) -> (usize, usize) {
        self.source.position(self.span.start)
    }
}

/// Returns a text of a diagnostic, which may quote a long one.
fn bounded(text: impl Into<String>) -> String {
    let text = text.into();
    match escape::bounded(&text) {
        Cow::Owned(cut) => cut,
        Cow::Borrowed(_) => text,
    }
}

/// Renders diagnostics for people: file, line, column, the line itself and a caret.
pub fn render(diagnostics: &[Diagnostic], colour: bool) -> String {
    let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
    let mut text = String::new();
    for (i, diagnostic) in diagnostics.iter().enumerate() {
        if i > 0 {
            text.push('\n');
        }
        let (diagnostic, path) = (shown(diagnostic), escape::line(&diagnostic.source.name));
        let excerpts = Excerpt::all(&diagnostic);
        text.push_str(&renderer.render(&groups(&diagnostic, &path, &excerpts)));
        text.push('\n');
    }
    text
}

/// The lines around some places. The renderer takes memory for each line that it is given, so it
/// is not given the whole text.
struct Excerpt<'d> {
    /// The part of the text.
    range: Range<usize>,
    /// The text without control characters.
    text: Cow<'d, str>,
    /// The places in it, relative to its start.
    places: Vec<(AnnotationKind, Range<usize>, &'d str)>,
}

impl<'d> Excerpt<'d> {
    /// Returns excerpts with all places of a diagnostic, first the one with its main place.
    fn all(diagnostic: &'d Diagnostic) -> Vec<Self> {
        let source = &diagnostic.source;
        let main = (AnnotationKind::Primary, &diagnostic.span, diagnostic.label.as_str());
        let more =
            diagnostic.related.iter().map(|(span, label)| (AnnotationKind::Context, span, label.as_str()));
        let mut excerpts: Vec<Self> = Vec::new();
        for (kind, span, label) in [main].into_iter().chain(more) {
            let span = source.shown(span);
            let lines = source.lines_around(&span);
            let joined = |e: &Self| e.range.start.min(lines.start)..e.range.end.max(lines.end);
            match excerpts.iter_mut().find(|e| joined(e).len() <= LARGEST_EXCERPT) {
                Some(excerpt) => {
                    excerpt.range = joined(excerpt);
                    excerpt.places.push((kind, span, label));
                }
                None => excerpts.push(Excerpt {
                    range: lines,
                    text: Cow::default(),
                    places: vec![(kind, span, label)],
                }),
            }
        }
        for Excerpt { range, text, places } in &mut excerpts {
            *text = without_controls(&source.text[range.clone()]);
            places
                .iter_mut()
                .for_each(|(_, span, _)| *span = span.start - range.start..span.end - range.start);
        }
        excerpts
    }
}

impl SourceFile {
    /// Returns the part of a place that is shown.
    fn shown(&self, span: &Range<usize>) -> Range<usize> {
        let start = self.floor(span.start);
        start..self.floor(span.end.min(start.saturating_add(LARGEST_EXCERPT / 2))).max(start)
    }

    /// Returns the lines of a place. The last one may be cut far behind the place.
    fn lines_around(&self, span: &Range<usize>) -> Range<usize> {
        let line = |at: usize| self.text[..at].rfind('\n').map_or(0, |end| end + 1);
        let start = match line(span.start) {
            // There is nothing to show after the last line.
            end if end == self.text.len() => line(end.saturating_sub(1)),
            start => start,
        };
        let most = self.floor(span.end.saturating_add(FAR));
        start..self.text[span.end..most].find('\n').map_or(most, |end| span.end + end + 1)
    }
}

/// Replaces the control characters that the renderer keeps, U+0080 to U+009F, by a dot with the
/// same number of bytes, so that offsets stay valid.
fn without_controls(text: &str) -> Cow<'_, str> {
    let is_control = |c: char| ('\u{80}'..='\u{9f}').contains(&c);
    if text.contains(is_control) {
        Cow::Owned(text.replace(is_control, "\u{b7}"))
    } else {
        Cow::Borrowed(text)
    }
}

/// Returns the diagnostic with all control sequences in its messages escaped. The renderer escapes
/// most of them in the source text.
fn shown(diagnostic: &Diagnostic) -> Diagnostic {
    let safe = |text: &String| escape::lines(text).into_owned();
    Diagnostic {
        message: safe(&diagnostic.message),
        label: safe(&diagnostic.label),
        help: diagnostic.help.as_ref().map(safe),
        notes: diagnostic.notes.iter().map(safe).collect(),
        related: diagnostic.related.iter().map(|(span, label)| (span.clone(), safe(label))).collect(),
        ..diagnostic.clone()
    }
}

fn groups<'d>(diagnostic: &'d Diagnostic, path: &'d str, excerpts: &'d [Excerpt<'d>]) -> [Group<'d>; 1] {
    let level = match diagnostic.severity {
        Severity::Warning => Level::WARNING,
        Severity::Error | Severity::Unsupported => Level::ERROR,
    };
    let mut group = Group::with_title(level.primary_title(diagnostic.message.as_str()));
    for Excerpt { range, text, places } in excerpts {
        let line = diagnostic.source.position(range.start).0;
        let annotations = places.iter().map(|(kind, span, label)| kind.span(span.clone()).label(*label));
        group = group
            .element(Snippet::source(text.as_ref()).line_start(line).path(path).annotations(annotations));
    }
    for note in &diagnostic.notes {
        group = group.element(Level::NOTE.message(note.as_str()));
    }
    if let Some(help) = &diagnostic.help {
        group = group.element(Level::HELP.message(help.as_str()));
    }
    [group]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_count_characters_and_survive_any_offset() {
        let file = SourceFile::new("m", "aé\nb");
        assert_eq!(file.position(0), (1, 1));
        assert_eq!(file.position(2), (1, 2));
        assert_eq!(file.position(4), (2, 1));
        assert_eq!(file.position(99), (2, 2));
    }

    #[test]
    fn lines_end_with_either_sign_and_marks_of_byte_order_are_no_text() {
        let file = SourceFile::new("m", "\u{feff}a\rb\r\nc\r");
        assert_eq!(file.text, "a\nb\r\nc\n");
        assert_eq!(file.original(), "\u{feff}a\rb\r\nc\r");
        assert_eq!(file.position(2), (2, 1));
        assert_eq!(SourceFile::new("m", "a\r\nb").original(), "a\r\nb");
    }

    #[test]
    fn nothing_in_a_text_reaches_a_terminal_as_an_order() {
        let file = SourceFile::new("m\u{1b}[2J.prism", "x\u{1b}[31m = \u{9b}1m\u{202e}\r\u{7};");
        let diagnostic =
            Diagnostic::new(&file, 0..1, "no `\u{1b}[2J`").label("\u{7}").help("\r").note("\u{9b}");
        let text = render(&[diagnostic.related(3..4, "\u{202e}")], false);
        let bad = text.chars().find(|&c| c != '\n' && !escape::is_shown(c));
        assert_eq!(bad, None, "{text:?}");
    }

    #[test]
    fn the_renderer_is_given_the_lines_of_a_place_and_not_the_whole_text() {
        let lines = "\n".repeat(100_000);
        let file =
            SourceFile::new("m", format!("{lines}first\n{lines}second{}\n{lines}", " ".repeat(10_000)));
        let (first, second) = (100_000, 200_006);
        let diagnostic =
            Diagnostic::new(&file, second..second + 6, "here").related(first..first + 5, "there");
        let excerpts = Excerpt::all(&diagnostic);
        assert!(excerpts.iter().map(|e| e.text.len()).sum::<usize>() < 2_000);
        let text = render(&[diagnostic], false);
        assert!(text.contains("m:200002:1") && text.contains("200002 | second"), "{text}");
        assert!(text.contains("m:100001:1") && text.contains("100001 | first"), "{text}");
        let whole = Diagnostic::new(&file, 0..file.text.len(), "all");
        assert!(Excerpt::all(&whole)[0].text.len() < 1 << 16);
        render(&[whole], false);
    }

    #[test]
    fn a_place_past_the_end_renders() {
        let file = SourceFile::new("m", "ab");
        let text = render(&[Diagnostic::new(&file, 7..9, "gone").label("here").help("try")], false);
        assert!(text.contains("gone") && text.contains("m:1:3"), "{text}");
    }
}
