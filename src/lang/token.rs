//! Tokens of the PRISM language, of preference files and of properties.

use std::collections::VecDeque;

use logos::Logos;

use super::ast::Span;
use meliora_base::progress::{NoProgress, Poll};

/// Defines the kinds of tokens; each sign is given with its text.
macro_rules! tokens {
    ($($name:ident $text:literal,)*) => {
        /// Kind of a token; its text is found through its span.
        #[derive(Logos, Debug, Clone, Copy, PartialEq, Eq)]
        #[logos(skip r"[ \t\r\n\f]+")]
        #[logos(skip(r"//[^\r\n]*", allow_greedy = true))]
        pub(crate) enum Token {
            /// A keyword or a name.
            #[regex("[A-Za-z_][A-Za-z0-9_]*")]
            Word,
            /// An integer literal.
            #[regex("[0-9]+")]
            Int,
            /// A literal with a point or an exponent.
            #[regex(r"[0-9]*\.[0-9]+([eE][+-]?[0-9]+)?|[0-9]+[eE][+-]?[0-9]+")]
            Real,
            /// A name in double quotes.
            #[regex("\"[^\"\r\n]*\"")]
            Quoted,
            $(
                #[doc = concat!("`", $text, "`")]
                #[token($text)]
                $name,
            )*
            /// A character that does not begin a token, or a quote without its partner.
            Wrong,
            /// The end of the text.
            End,
        }

        impl Token {
            /// Returns the name of this kind of token for messages about an expected token.
            pub(crate) fn describe(self) -> &'static str {
                match self {
                    Token::Word => "a name",
                    Token::Int => "an integer",
                    Token::Real => "a number",
                    Token::Quoted => "a name in double quotes",
                    Token::Wrong => "a token",
                    Token::End => "the end of the text",
                    $(Token::$name => concat!("`", $text, "`"),)*
                }
            }
        }
    };
}

tokens! {
    Bang "!",
    And "&",
    Or "|",
    Implies "=>",
    Iff "<=>",
    Arrow "->",
    Colon ":",
    Semicolon ";",
    Comma ",",
    Dots "..",
    LeftParen "(",
    RightParen ")",
    LeftBracket "[",
    RightBracket "]",
    LeftBrace "{",
    RightBrace "}",
    Eq "=",
    Ne "!=",
    Lt "<",
    Le "<=",
    Gt ">",
    Ge ">=",
    Plus "+",
    Minus "-",
    Star "*",
    Slash "/",
    Caret "^",
    Prime "'",
    Question "?",
    Tilde "~",
}

/// Number of tokens of lookahead. A list of all tokens would need many times the memory of the
/// text.
const AHEAD: usize = 3;

/// The tokens of a text, in order. Never fails: unreadable text becomes [`Token::Wrong`]. After the
/// last token, and after cancellation, every token is [`Token::End`].
pub(crate) struct Tokens<'t> {
    lexer: logos::Lexer<'t, Token>,
    /// The part of the text that is read.
    part: Span,
    /// Lookahead: tokens made but not taken yet; empty at the end of the text.
    made: VecDeque<(Token, Span)>,
    before: Option<Span>,
    /// Number of tokens taken.
    taken: usize,
}

impl<'t> Tokens<'t> {
    /// Starts reading the tokens of a part of a text, with their places in the whole text.
    pub(crate) fn new(text: &'t str, part: Span, poll: &mut Poll<'_>) -> Self {
        let lexer = Token::lexer(text.get(part.range()).unwrap_or(""));
        let mut tokens = Tokens { lexer, part, made: VecDeque::new(), before: None, taken: 0 };
        tokens.fill(poll);
        tokens
    }

    fn fill(&mut self, poll: &mut Poll<'_>) {
        while self.made.len() < AHEAD
            && let Some(token) = self.fetch(poll)
        {
            self.made.push_back(token);
        }
    }

    /// Returns a token not taken yet, with its place; 0 is the next one.
    pub(crate) fn at(&self, ahead: usize) -> (Token, Span) {
        debug_assert!(ahead < AHEAD, "so far ahead nothing was made");
        self.made.get(ahead).copied().unwrap_or(self.end())
    }

    /// Returns all tokens not taken yet, up to [`Token::End`]. Tokens beyond the lookahead are made
    /// again on every call.
    pub(crate) fn rest(&self) -> impl Iterator<Item = (Token, Span)> + '_ {
        let mut behind = self.lexer.clone();
        let more = std::iter::from_fn(move || read(&mut behind, self.part));
        self.made.iter().copied().chain(more).chain([self.end()])
    }

    fn end(&self) -> (Token, Span) {
        (Token::End, Span::new(self.part.end(), self.part.end()))
    }

    /// Returns the place of the last token taken.
    pub(crate) fn before(&self) -> Option<Span> {
        self.before
    }

    /// Returns the number of tokens taken.
    pub(crate) fn taken(&self) -> usize {
        self.taken
    }

    /// Takes the next token, unless it is the end.
    pub(crate) fn take(&mut self, poll: &mut Poll<'_>) {
        let Some((_, span)) = self.made.pop_front() else { return };
        self.before = Some(span);
        self.taken += 1;
        self.fill(poll);
        if poll.should_stop() {
            self.made.clear();
        }
    }

    fn fetch(&mut self, poll: &mut Poll<'_>) -> Option<(Token, Span)> {
        if poll.should_stop() {
            return None;
        }
        let (token, mut span) = read(&mut self.lexer, self.part)?;
        // A run of unreadable bytes gets only one message.
        while token == Token::Wrong && !poll.should_stop() {
            let behind = self.lexer.clone();
            match read(&mut self.lexer, self.part) {
                Some((Token::Wrong, next)) if next.start() == span.end() => span = span.to(next),
                _ => {
                    self.lexer = behind;
                    break;
                }
            }
        }
        Some((token, span))
    }
}

fn read(lexer: &mut logos::Lexer<'_, Token>, part: Span) -> Option<(Token, Span)> {
    let token = lexer.next()?.unwrap_or(Token::Wrong);
    let range = lexer.span();
    Some((token, Span::new(part.start() + range.start, part.start() + range.end)))
}

/// Returns all tokens of a short text, including [`Token::End`].
pub(crate) fn tokens(text: &str) -> Vec<(Token, Span)> {
    let mut poll = Poll::new(&NoProgress);
    Tokens::new(text, Span::new(0, text.len()), &mut poll).rest().collect()
}

/// Returns true for a keyword of PRISM, which cannot name anything in a model.
pub(crate) fn is_keyword(word: &str) -> bool {
    matches!(
        word,
        "A" | "bool"
            | "clock"
            | "const"
            | "ctmc"
            | "C"
            | "double"
            | "dtmc"
            | "E"
            | "endinit"
            | "endinvariant"
            | "endmodule"
            | "endobservables"
            | "endrewards"
            | "endsystem"
            | "false"
            | "formula"
            | "filter"
            | "func"
            | "F"
            | "global"
            | "G"
            | "init"
            | "invariant"
            | "I"
            | "int"
            | "label"
            | "max"
            | "mdp"
            | "min"
            | "module"
            | "X"
            | "nondeterministic"
            | "observable"
            | "observables"
            | "of"
            | "Pmax"
            | "Pmin"
            | "P"
            | "pomdp"
            | "popta"
            | "probabilistic"
            | "prob"
            | "pta"
            | "rate"
            | "rewards"
            | "Rmax"
            | "Rmin"
            | "R"
            | "S"
            | "stochastic"
            | "system"
            | "true"
            | "U"
            | "W"
    )
}

/// Labels that all models have: the initial states, and those in which no command is enabled.
pub const BUILT_IN_LABELS: [&str; 2] = ["init", "deadlock"];

/// Returns true if `word` is a keyword only because of its meaning in properties.
pub(crate) fn is_property_operator(word: &str) -> bool {
    matches!(word, "A" | "C" | "E" | "F" | "G" | "I" | "P" | "R" | "S" | "U" | "W" | "X")
}

/// Returns true if `text` has the form of a name.
pub(crate) fn is_identifier(text: &str) -> bool {
    let mut chars = text.chars();
    chars.next().is_some_and(|c| c == '_' || c.is_ascii_alphabetic())
        && chars.all(|c| c == '_' || c.is_ascii_alphanumeric())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(text: &str) -> Vec<Token> {
        tokens(text).into_iter().map(|(token, _)| token).collect()
    }

    #[test]
    fn ranges_are_not_numbers() {
        assert_eq!(kinds("0..5"), [Token::Int, Token::Dots, Token::Int, Token::End]);
        assert_eq!(kinds("0.5..1e3"), [Token::Real, Token::Dots, Token::Real, Token::End]);
        assert_eq!(kinds(".5 1.e"), [Token::Real, Token::Int, Token::Wrong, Token::Word, Token::End]);
    }

    #[test]
    fn the_longest_operator_wins() {
        assert_eq!(
            kinds("<=> <= <- =>"),
            [Token::Iff, Token::Le, Token::Lt, Token::Minus, Token::Implies, Token::End]
        );
        assert_eq!(kinds("x'=1 // end"), [Token::Word, Token::Prime, Token::Eq, Token::Int, Token::End]);
    }

    #[test]
    fn characters_that_begin_no_word_become_one_token() {
        assert_eq!(kinds("@@é x"), [Token::Wrong, Token::Word, Token::End]);
        assert_eq!(kinds("\"abc"), [Token::Wrong, Token::End]);
    }
}
