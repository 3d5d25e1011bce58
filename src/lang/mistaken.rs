//! Detection of files given in place of others, from their first words.

use std::sync::Arc;

use super::token::{Token, tokens};
use meliora_model::error::{Diagnostic, Error, Result, Severity, SourceFile};

/// Length of the prefix that is inspected, in bytes.
const BEGINNING: usize = 1 << 12;

/// First words of preference files.
const PREFERENCE_WORDS: &[&str] = &["objective", "prefer", "empty", "history", "require", "coalition"];
/// First words of models.
const MODEL_WORDS: &[&str] = &[
    "mdp",
    "dtmc",
    "ctmc",
    "pomdp",
    "smg",
    "player",
    "nondeterministic",
    "probabilistic",
    "module",
    "const",
    "formula",
    "global",
];
/// First words of properties, before a bound or a bracket.
const PROPERTY_WORDS: &[&str] = &["P", "Pmin", "Pmax", "R", "Rmin", "Rmax", "S", "filter", "multi"];

/// Refuses a text given as a model that is clearly something else.
///
/// # Errors
/// The text is a preference file, a list of properties, or a model in another language.
pub(super) fn no_model(source: &Arc<SourceFile>) -> Result<()> {
    let begin = Beginning::of(source);
    let found = match begin.first_word() {
        Some(word) if PREFERENCE_WORDS.contains(&word) => {
            Some(("this is a preference file, not a model", "the preference file comes after the model"))
        }
        Some(word) if PROPERTY_WORDS.contains(&word) && begin.second_is_bound() => Some((
            "this is a list of properties, not a model",
            "`meliora reach MODEL --properties FILE` checks it",
        )),
        _ => begin.explicit(),
    };
    found.map_or(Ok(()), |(message, help)| Err(begin.refuse(message, help)))
}

/// Refuses a text given as preferences that is clearly a model.
///
/// # Errors
/// The text is a model.
pub(super) fn no_preferences(source: &Arc<SourceFile>) -> Result<()> {
    let begin = Beginning::of(source);
    let is_model = begin.first_word().is_some_and(|word| MODEL_WORDS.contains(&word)) || begin.is_jani();
    let help = "the model comes before the preferences";
    if is_model { Err(begin.refuse("this is a model, not a preference file", help)) } else { Ok(()) }
}

/// Refuses a text given as properties that is clearly something else.
///
/// # Errors
/// The text is a preference file or a model.
pub(super) fn no_properties(source: &Arc<SourceFile>) -> Result<()> {
    let begin = Beginning::of(source);
    let (message, help) = match begin.first_word() {
        Some(word) if PREFERENCE_WORDS.contains(&word) => {
            ("this is a preference file, not a list of properties", WRITTEN)
        }
        // Definitions occur in models and in property files.
        Some(word) if MODEL_WORDS.contains(&word) && !["const", "formula"].contains(&word) => {
            ("this is a model, not a list of properties", WRITTEN)
        }
        None if begin.is_jani() => (
            "this is a JANI model, not a list of properties",
            "`--property NAME` answers a property of the model by its name",
        ),
        _ => return Ok(()),
    };
    Err(begin.refuse(message, help))
}

/// The form of properties, for messages.
const WRITTEN: &str = "properties are written `\"name\": P>=1 [ F condition ];`";

/// The first tokens of a text.
struct Beginning<'a> {
    source: &'a Arc<SourceFile>,
    text: &'a str,
    tokens: Vec<(Token, &'a str)>,
    start: usize,
}

impl<'a> Beginning<'a> {
    fn of(source: &'a Arc<SourceFile>) -> Self {
        let text = &source.text[..source.text.floor_char_boundary(BEGINNING)];
        let all = tokens(text);
        let start = all.first().map_or(0, |(_, span)| span.start());
        let tokens = all.into_iter().map(|(token, span)| (token, text.get(span.range()).unwrap_or("")));
        Beginning { source, text, tokens: tokens.collect(), start }
    }

    fn first_word(&self) -> Option<&'a str> {
        self.tokens.first().filter(|(token, _)| *token == Token::Word).map(|(_, text)| *text)
    }

    fn is_jani(&self) -> bool {
        self.tokens.first() == Some(&(Token::LeftBrace, "{"))
    }

    fn second_is_bound(&self) -> bool {
        let signs =
            [Token::Ge, Token::Gt, Token::Le, Token::Lt, Token::Eq, Token::LeftParen, Token::LeftBracket];
        self.tokens.get(1).is_some_and(|(token, text)| signs.contains(token) || ["min", "max"].contains(text))
    }

    /// Recognises a file that belongs to an explicit model but is not the model itself.
    fn explicit(&self) -> Option<(&'static str, &'static str)> {
        let help =
            "name the file of transitions (`.tra`); the files of states and labels next to it are read, too";
        let kinds: Vec<Token> = self.tokens.iter().take(4).map(|(token, _)| *token).collect();
        match kinds[..] {
            [Token::Int, Token::Eq, Token::Quoted, ..] => {
                Some(("this is a list of labels (`.lab`), not a model", help))
            }
            [Token::LeftParen, Token::Word, Token::Comma | Token::RightParen, ..] => {
                Some(("this is a list of states (`.sta`), not a model", help))
            }
            _ => None,
        }
    }

    fn refuse(&self, message: &str, help: &str) -> Error {
        let end =
            self.text[self.start..].find(char::is_whitespace).map_or(self.text.len(), |n| self.start + n);
        Diagnostic::new(self.source, self.start..end, message)
            .severity(Severity::Unsupported)
            .help(help)
            .into()
    }
}
