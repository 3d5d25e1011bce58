//! Tokens of the PRISM language, of preference files and of properties.

use logos::Logos;

use super::ast::Span;
use crate::observer::Poll;

/// What a piece of text is; the text itself is found through its span.
#[derive(Logos, Debug, Clone, Copy, PartialEq, Eq)]
#[logos(skip r"[ \t\r\n\f]+")]
#[logos(skip(r"//[^\r\n]*", allow_greedy = true))]
pub enum Token {
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
    /// `!`
    #[token("!")]
    Bang,
    /// `&`
    #[token("&")]
    And,
    /// `|`
    #[token("|")]
    Or,
    /// `=>`
    #[token("=>")]
    Implies,
    /// `<=>`
    #[token("<=>")]
    Iff,
    /// `->`
    #[token("->")]
    Arrow,
    /// `:`
    #[token(":")]
    Colon,
    /// `;`
    #[token(";")]
    Semicolon,
    /// `,`
    #[token(",")]
    Comma,
    /// `..`
    #[token("..")]
    Dots,
    /// `(`
    #[token("(")]
    LeftParen,
    /// `)`
    #[token(")")]
    RightParen,
    /// `[`
    #[token("[")]
    LeftBracket,
    /// `]`
    #[token("]")]
    RightBracket,
    /// `{`
    #[token("{")]
    LeftBrace,
    /// `}`
    #[token("}")]
    RightBrace,
    /// `=`
    #[token("=")]
    Eq,
    /// `!=`
    #[token("!=")]
    Ne,
    /// `<`
    #[token("<")]
    Lt,
    /// `<=`
    #[token("<=")]
    Le,
    /// `>`
    #[token(">")]
    Gt,
    /// `>=`
    #[token(">=")]
    Ge,
    /// `+`
    #[token("+")]
    Plus,
    /// `-`
    #[token("-")]
    Minus,
    /// `*`
    #[token("*")]
    Star,
    /// `/`
    #[token("/")]
    Slash,
    /// `^`
    #[token("^")]
    Caret,
    /// `'`
    #[token("'")]
    Prime,
    /// `?`
    #[token("?")]
    Question,
    /// `~`, in preference files.
    #[token("~")]
    Tilde,
    /// A character that begins no token, or a quote without its partner.
    Wrong,
    /// The end of the text.
    End,
}

impl Token {
    /// How a message calls a token of this kind that was expected.
    pub fn describe(self) -> &'static str {
        match self {
            Token::Word => "a name",
            Token::Int => "an integer",
            Token::Real => "a number",
            Token::Quoted => "a name in double quotes",
            Token::Wrong => "a token",
            Token::End => "the end of the text",
            punctuation => punctuation.symbol(),
        }
    }

    fn symbol(self) -> &'static str {
        match self {
            Token::Bang => "`!`",
            Token::And => "`&`",
            Token::Or => "`|`",
            Token::Implies => "`=>`",
            Token::Iff => "`<=>`",
            Token::Arrow => "`->`",
            Token::Colon => "`:`",
            Token::Semicolon => "`;`",
            Token::Comma => "`,`",
            Token::Dots => "`..`",
            Token::LeftParen => "`(`",
            Token::RightParen => "`)`",
            Token::LeftBracket => "`[`",
            Token::RightBracket => "`]`",
            Token::LeftBrace => "`{`",
            Token::RightBrace => "`}`",
            Token::Eq => "`=`",
            Token::Ne => "`!=`",
            Token::Lt => "`<`",
            Token::Le => "`<=`",
            Token::Gt => "`>`",
            Token::Ge => "`>=`",
            Token::Plus => "`+`",
            Token::Minus => "`-`",
            Token::Star => "`*`",
            Token::Slash => "`/`",
            Token::Caret => "`^`",
            Token::Prime => "`'`",
            Token::Question => "`?`",
            _ => "`~`",
        }
    }
}

/// Splits a text into tokens; the last one is [`Token::End`]. Never fails: what cannot be read
/// becomes [`Token::Wrong`]. Ends early when that is asked for.
pub(crate) fn tokens(text: &str, poll: &mut Poll<'_>) -> Vec<(Token, Span)> {
    let mut all: Vec<(Token, Span)> = Vec::new();
    for (token, range) in Token::lexer(text).spanned() {
        if poll.is_over() {
            break;
        }
        let span = Span { start: range.start, end: range.end };
        let token = token.unwrap_or(Token::Wrong);
        match all.last_mut() {
            // One message for a run of bytes that mean nothing.
            Some((Token::Wrong, before)) if token == Token::Wrong && before.end == span.start => {
                before.end = span.end;
            }
            _ => all.push((token, span)),
        }
    }
    all.push((Token::End, Span { start: text.len(), end: text.len() }));
    all
}

/// The words that PRISM keeps for itself.
const KEYWORDS: &[&str] = &[
    "A",
    "bool",
    "clock",
    "const",
    "ctmc",
    "C",
    "double",
    "dtmc",
    "E",
    "endinit",
    "endinvariant",
    "endmodule",
    "endobservables",
    "endrewards",
    "endsystem",
    "false",
    "formula",
    "filter",
    "func",
    "F",
    "global",
    "G",
    "init",
    "invariant",
    "I",
    "int",
    "label",
    "max",
    "mdp",
    "min",
    "module",
    "X",
    "nondeterministic",
    "observable",
    "observables",
    "of",
    "Pmax",
    "Pmin",
    "P",
    "pomdp",
    "popta",
    "probabilistic",
    "prob",
    "pta",
    "rate",
    "rewards",
    "Rmax",
    "Rmin",
    "R",
    "S",
    "stochastic",
    "system",
    "true",
    "U",
    "W",
];

/// Whether PRISM keeps `word` for itself, so that it can name nothing in a model.
pub fn is_keyword(word: &str) -> bool {
    KEYWORDS.contains(&word)
}

/// Whether `word` is a keyword only for its meaning in properties.
pub fn is_property_operator(word: &str) -> bool {
    matches!(word, "A" | "C" | "E" | "F" | "G" | "I" | "P" | "R" | "S" | "U" | "W" | "X")
}

/// Whether `text` has the form of a name.
pub fn is_identifier(text: &str) -> bool {
    let mut chars = text.chars();
    chars.next().is_some_and(|c| c == '_' || c.is_ascii_alphabetic())
        && chars.all(|c| c == '_' || c.is_ascii_alphanumeric())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observer::Unobserved;

    fn kinds(text: &str) -> Vec<Token> {
        tokens(text, &mut Poll::new(&Unobserved)).into_iter().map(|(t, _)| t).collect()
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
    fn nonsense_becomes_one_token() {
        assert_eq!(kinds("@@é x"), [Token::Wrong, Token::Word, Token::End]);
        assert_eq!(kinds("\"abc"), [Token::Wrong, Token::End]);
    }
}
