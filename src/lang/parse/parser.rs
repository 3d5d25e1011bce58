//! The state of the parser, and the steps that all parts of the grammar share.

use std::sync::Arc;

use crate::ast::{Expr, Ident, Node, NodeKind, Span};
use crate::token::{Token, Tokens, is_identifier, is_keyword, is_property_operator};
use meliora_base::error::{Diagnostic, Error, Result, Severity, SourceFile};
use meliora_base::progress::{NoProgress, Poll, ProgressSink};
use meliora_base::slip::is_slip;
use meliora_base::stack;

/// Maximum nesting of brackets, conditionals and signs in expressions.
const MAX_NESTING: usize = 10_000;

/// Maximum nesting of temporal formulas and of compositions of modules, whose trees are read by
/// recursion.
pub(crate) const MAX_TREE_NESTING: usize = 200;

/// Maximum number of errors reported.
const MAX_ERRORS: usize = 20;

/// The part being parsed is wrong; the diagnostic has been recorded.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Failed;

/// The result of a parsing function.
pub(crate) type Parsed<T> = std::result::Result<T, Failed>;

/// The state of a parser: a position in the tokens, and the errors so far.
pub(crate) struct Parser<'a> {
    source: &'a Arc<SourceFile>,
    pub(super) tokens: Tokens<'a>,
    depth: usize,
    diagnostics: Vec<Diagnostic>,
    poll: Poll<'a>,
    /// Nodes of the expressions being read, in post-order; `None` if only places are wanted.
    nodes: Option<Vec<Node>>,
    /// Operators of properties may stand in expressions.
    pub(crate) in_property: bool,
    /// The bound on the number of steps of an operator is being read.
    pub(crate) in_steps: bool,
}

impl<'a> Parser<'a> {
    /// Creates a parser of a text.
    pub(crate) fn new(source: &'a Arc<SourceFile>) -> Self {
        Parser::of_part(source, Span::new(0, source.text.len()), &NoProgress)
    }

    /// Creates a parser of a part of a text.
    pub(crate) fn of_part(source: &'a Arc<SourceFile>, part: Span, sink: &'a dyn ProgressSink) -> Self {
        let mut poll = Poll::new(sink);
        let tokens = Tokens::new(&source.text, part, &mut poll);
        Parser {
            source,
            tokens,
            depth: 0,
            diagnostics: Vec::new(),
            poll,
            nodes: Some(Vec::new()),
            in_property: false,
            in_steps: false,
        }
    }

    /// Returns a parser that makes no expressions, only places.
    pub(super) fn places(self) -> Self {
        Parser { nodes: None, ..self }
    }

    /// Adds a node, whose operands are the last ones.
    pub(crate) fn push(&mut self, span: Span, kind: impl FnOnce() -> NodeKind) -> Span {
        if let Some(nodes) = &mut self.nodes {
            nodes.push(Node { kind: kind(), span });
        }
        span
    }

    /// Widens the place of the last node, to include brackets around its operands.
    pub(super) fn widen(&mut self, span: Span) {
        if let Some(root) = self.nodes.as_mut().and_then(|nodes| nodes.last_mut()) {
            root.span = span;
        }
    }

    /// Returns the expression that `read` parses; without nodes if only places are wanted.
    pub(crate) fn tree(&mut self, read: impl FnOnce(&mut Self) -> Parsed<Span>) -> Parsed<Expr> {
        let from = self.nodes.as_ref().map_or(0, Vec::len);
        read(self)?;
        Ok(Expr { nodes: self.nodes.as_mut().map_or_else(Vec::new, |nodes| nodes.split_off(from)) })
    }

    /// Returns the value, unless an error was recorded.
    ///
    /// # Errors
    /// The recorded errors; a limit.
    pub(crate) fn finish<T>(self, value: T) -> Result<T> {
        self.poll.check()?;
        if self.diagnostics.is_empty() { Ok(value) } else { Err(Error::Input(self.diagnostics)) }
    }

    /// Same as [`Parser::finish`], for a value that exists only if no error was recorded.
    ///
    /// # Errors
    /// See [`Parser::finish`].
    pub(crate) fn finish_parsed<T>(self, parsed: Parsed<T>) -> Result<T> {
        self.poll.check()?;
        match parsed {
            Ok(value) => self.finish(value),
            Err(Failed) => Err(Error::Input(self.diagnostics)),
        }
    }

    pub(crate) fn peek(&self) -> Token {
        self.peek_at(0)
    }

    pub(crate) fn peek_at(&self, ahead: usize) -> Token {
        self.tokens.at(ahead).0
    }

    /// Returns the place of the next token.
    pub(crate) fn here(&self) -> Span {
        self.tokens.at(0).1
    }

    /// Returns all tokens from the next one on, with their texts; [`Token::End`] is the last.
    pub(crate) fn rest(&self) -> impl Iterator<Item = (Token, &'a str)> + '_ {
        self.tokens.rest().map(|(token, span)| (token, self.text(span)))
    }

    /// Returns the place of the token before the next one.
    pub(crate) fn before(&self) -> Span {
        self.tokens.before().unwrap_or_default()
    }

    pub(crate) fn text(&self, span: Span) -> &'a str {
        self.source.text.get(span.range()).unwrap_or("")
    }

    /// Returns the text from the next token on.
    pub(crate) fn rest_of_text(&self) -> &'a str {
        self.source.text.get(self.here().start()..).unwrap_or("")
    }

    /// Takes the next token and returns its place. At the end of the text, and after cancellation,
    /// the next token is [`Token::End`].
    pub(crate) fn advance(&mut self) -> Span {
        let span = self.here();
        self.tokens.take(&mut self.poll);
        span
    }

    pub(crate) fn eat(&mut self, token: Token) -> bool {
        let there = self.peek() == token;
        if there {
            self.advance();
        }
        there
    }

    pub(crate) fn expect(&mut self, token: Token) -> Parsed<Span> {
        match token {
            _ if self.peek() == token => Ok(self.advance()),
            Token::Semicolon | Token::RightParen | Token::RightBracket if self.line_is_over() => {
                Err(self.missing(token.describe()))
            }
            _ => Err(self.expected(token.describe())),
        }
    }

    /// Returns true if the next token is on a later line than the one before it, or is the end.
    fn line_is_over(&self) -> bool {
        let between = self.before().end()..self.here().start();
        self.tokens.before().is_some()
            && (self.peek() == Token::End || self.source.text[between].contains('\n'))
    }

    /// Records that something is missing after the previous token.
    fn missing(&mut self, what: &str) -> Failed {
        let end = self.before().end();
        let place = Span::new(end, end);
        self.report(self.wrong(place, format!("{what} is missing")).label(format!("expected {what}")));
        Failed
    }

    /// Returns true if the next token is this word.
    pub(crate) fn at_word(&self, word: &str) -> bool {
        self.peek() == Token::Word && self.text(self.here()) == word
    }

    pub(crate) fn eat_word(&mut self, word: &str) -> bool {
        let there = self.at_word(word);
        if there {
            self.advance();
        }
        there
    }

    pub(crate) fn expect_word(&mut self, word: &str) -> Parsed<Span> {
        if self.at_word(word) || self.slip(&[word]).is_some() {
            return Ok(self.advance());
        }
        Err(self.expected(&format!("`{word}`")))
    }

    /// Returns the word that the next token misspells, if it is one of these words, and reports the
    /// misspelling.
    pub(crate) fn slip<'w>(&mut self, words: &[&'w str]) -> Option<&'w str> {
        let (token, span) = (self.peek(), self.here());
        let found = self.text(span);
        let meant = words.iter().copied().find(|word| token == Token::Word && is_slip(word, found))?;
        if words.contains(&found) {
            return None;
        }
        let diagnostic = self.wrong(span, format!("`{found}` is not a keyword"));
        self.report(diagnostic.label(format!("did you mean `{meant}`?")));
        Some(meant)
    }

    /// Parses a name that is not a keyword.
    pub(crate) fn ident(&mut self, what: &str) -> Parsed<Ident> {
        self.word_that_names(what).map(|span| self.named(span))
    }

    /// Same as [`Parser::ident`], but returns only the place.
    pub(super) fn word_that_names(&mut self, what: &str) -> Parsed<Span> {
        let name = self.text(self.here());
        if self.peek() == Token::Word && is_keyword(name) {
            let message = format!("`{name}` is a keyword and cannot be {what}");
            self.report(self.wrong(self.here(), message).label("a keyword of the PRISM language"));
            return Err(Failed);
        }
        if self.peek() == Token::Word { Ok(self.advance()) } else { Err(self.expected(what)) }
    }

    /// Returns the name at a place.
    pub(crate) fn named(&self, span: Span) -> Ident {
        Ident { name: self.text(span).to_owned(), span }
    }

    /// Parses one or more items with commas between them.
    pub(crate) fn list<T>(&mut self, item: impl Fn(&mut Self) -> Parsed<T>) -> Parsed<Vec<T>> {
        let mut items = vec![item(self)?];
        while self.eat(Token::Comma) {
            items.push(item(self)?);
        }
        Ok(items)
    }

    /// Parses the name of an action.
    pub(crate) fn action(&mut self) -> Parsed<Ident> {
        self.name_outside("the name of an action")
    }

    /// Parses a name that properties do not use. Letters such as `S` and `A` are operators only in
    /// properties and cannot be meant here. They may be such names, as in Storm (PRISM refuses them).
    pub(crate) fn name_outside(&mut self, what: &str) -> Parsed<Ident> {
        let span = self.here();
        if self.peek() == Token::Word && is_property_operator(self.text(span)) {
            self.advance();
            return Ok(self.named(span));
        }
        self.ident(what)
    }

    /// Parses a name in double quotes; keywords are permitted, as in `"init"`.
    pub(crate) fn quoted(&mut self) -> Parsed<Ident> {
        let span = self.expect(Token::Quoted)?;
        let name = self.text(span).trim_matches('"').to_owned();
        if !is_identifier(&name) {
            let help = "a name has letters, digits and `_`, and does not start with a digit";
            self.report(self.wrong(span, format!("\"{name}\" is not a name")).help(help));
            return Err(Failed);
        }
        Ok(Ident { name, span })
    }

    /// Parses a reference to a label or a reward structure, which may have any name: those of JANI
    /// models do.
    pub(crate) fn reference(&mut self) -> Parsed<&'a str> {
        let span = self.expect(Token::Quoted)?;
        Ok(self.text(span).trim_matches('"'))
    }

    /// Returns an error at a place.
    pub(crate) fn wrong(&self, span: Span, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(self.source, span.range(), message)
    }

    /// Returns an error for a construct of PRISM that this program does not support.
    pub(crate) fn unsupported(&self, span: Span, message: impl Into<String>) -> Diagnostic {
        self.wrong(span, message).severity(Severity::Unsupported).label("not supported")
    }

    pub(crate) fn report(&mut self, diagnostic: Diagnostic) {
        if self.diagnostics.len() < MAX_ERRORS {
            self.diagnostics.push(diagnostic);
        }
    }

    /// Returns help on constructs that other languages write differently.
    fn other_languages(&self, found: &str, what: &str) -> Option<&'static str> {
        Some(match found {
            "and" | "AND" => "conjunction is written `&`",
            "or" | "OR" => "disjunction is written `|`",
            "not" | "NOT" => "negation is written `!`",
            "->" if what != "an expression" => "`->` ends a guard; implication is written `=>`",
            "U" | "W" => "temporal formulas are allowed in properties, `P>=1 [ … ]`, and in objectives",
            "/" if self.peek_at(1) == Token::Star => "a comment begins with `//` and ends with its line",
            "'" => "`x'` is the new value of `x`; it is allowed only in updates, `(x'=…)` after `->`",
            ":" if self.peek_at(1) == Token::Eq => "a new value is given by `=`, as in `(x'=1)`",
            _ if ["not", "NOT"].contains(&self.text(self.before())) => "negation is written `!`",
            _ if self.text(self.before()) == "if" => "a choice is written `condition ? value : other`",
            _ => return None,
        })
    }

    /// Records that something else was expected here.
    pub(crate) fn expected(&mut self, what: &str) -> Failed {
        let span = self.here();
        let diagnostic = match self.peek() {
            Token::End => self.wrong(span, format!("expected {what}, found the end of the text")),
            Token::Wrong => self.nonsense(span),
            _ => {
                let found = self.text(span);
                let keyword = if is_keyword(found) { "the keyword " } else { "" };
                let diagnostic = self.wrong(span, format!("expected {what}, found {keyword}`{found}`"));
                match self.other_languages(found, what) {
                    Some(help) => diagnostic.help(help),
                    None => diagnostic,
                }
            }
        };
        let label = if self.peek() == Token::Wrong { String::new() } else { format!("expected {what}") };
        self.report(diagnostic.label(label));
        Failed
    }

    fn nonsense(&self, span: Span) -> Diagnostic {
        let text = self.text(span);
        let start = self.source.text[..span.start()].rfind('\n').map_or(0, |end| end + 1);
        let line = self.source.text[start..].lines().next().unwrap_or("");
        match text.chars().next() {
            Some('"') => self.wrong(span, "a quote without its partner on the same line"),
            Some('#') if line.matches('#').count() > 1 => {
                self.wrong(span, "the PRISM preprocessor (`#…#`) is not supported")
            }
            Some('#') => self.wrong(span, "`#` does not start a comment").help("comments start with `//`"),
            Some('%') => {
                self.wrong(span, "`%` is not an operator").help("the remainder is written `mod(a, b)`")
            }
            Some(sign) => {
                let diagnostic = self.wrong(span, format!("unexpected `{text}`"));
                match ascii(sign) {
                    Some(ours) => diagnostic.help(format!("write `{ours}`")),
                    None => diagnostic,
                }
            }
            None => self.wrong(span, format!("unexpected `{text}`")),
        }
    }

    /// Runs `read` one level deeper in an expression, unless that exceeds the maximum.
    pub(crate) fn nested<T>(&mut self, read: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        self.nested_to(MAX_NESTING, read)
    }

    /// Runs `read` one level deeper, unless that exceeds a maximum.
    pub(crate) fn nested_to<T>(
        &mut self,
        most: usize,
        read: impl FnOnce(&mut Self) -> Parsed<T>,
    ) -> Parsed<T> {
        // The whole expression is a level, too.
        if self.depth > most {
            let span = self.here();
            let message = format!("nested more than {most} levels deep");
            let help = "give parts of the expression names with `formula`";
            self.report(self.wrong(span, message).label("too deep").help(help));
            return Err(Failed);
        }
        self.depth += 1;
        let result = stack::level(|| read(self));
        self.depth -= 1;
        result
    }

    /// Skips everything up to and including the next `;`, or up to a word in `stops`, or the end.
    pub(crate) fn recover(&mut self, stops: &[&str]) {
        loop {
            match self.peek() {
                Token::End => return,
                Token::Semicolon => {
                    self.advance();
                    return;
                }
                Token::Word if stops.contains(&self.text(self.here())) => return,
                _ => {
                    self.advance();
                }
            }
        }
    }
}

/// Returns the operator for a mathematical sign.
fn ascii(sign: char) -> Option<&'static str> {
    Some(match sign {
        '≤' => "<=",
        '≥' => ">=",
        '≠' => "!=",
        '∧' => "&",
        '∨' => "|",
        '¬' => "!",
        '⇒' => "=>",
        '→' => "->",
        '⇔' => "<=>",
        '′' | '’' => "'",
        _ => return None,
    })
}
