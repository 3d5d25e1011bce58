//! Detection of files given in place of others, from their first words.

use std::sync::Arc;

use super::token::{Token, tokens};
use meliora_base::error::{Diagnostic, Error, Result, Severity, SourceFile};

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
    let begin = Beginning::new(source);
    let found = match begin.first_word() {
        Some(word) if PREFERENCE_WORDS.contains(&word) => {
            Some(("this is a preference file, not a model", "the preference file comes after the model"))
        }
        _ if begin.is_properties() => Some(("this is a list of properties, not a model", CHECKED)),
        _ => begin.explicit(),
    };
    found.map_or(Ok(()), |(message, help)| Err(begin.refuse(message, help)))
}

/// Refuses a text given as preferences that is clearly something else, or begins with definitions.
///
/// # Errors
/// The text is a model or a list of properties, or a preference file that defines names.
pub(super) fn no_preferences(source: &Arc<SourceFile>) -> Result<()> {
    let begin = Beginning::new(source);
    let word = begin.first_word().unwrap_or_default();
    let is_model = MODEL_WORDS.contains(&word) || begin.is_jani();
    let (message, help) = if begin.is_properties() {
        ("this is a list of properties, not a preference file", CHECKED)
    } else if DEFINITIONS.contains(&word) && begin.has_word(&["objective", "prefer"]) {
        (
            "a preference file does not define constants, formulas and labels",
            "define the name in the model; preferences can use all names of the model",
        )
    } else if is_model {
        ("this is a model, not a preference file", "the model comes before the preferences")
    } else {
        return Ok(());
    };
    Err(begin.refuse(message, help))
}

/// Refuses a text given as properties that is clearly something else.
///
/// # Errors
/// The text is a preference file or a model.
pub(super) fn no_properties(source: &Arc<SourceFile>) -> Result<()> {
    let begin = Beginning::new(source);
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

/// First words of definitions, which models and lists of properties have.
const DEFINITIONS: &[&str] = &["const", "formula", "label"];

/// The command for a list of properties, for messages.
const CHECKED: &str = "`meliora reach MODEL --properties FILE` checks it";

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
    fn new(source: &'a Arc<SourceFile>) -> Self {
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

    /// Returns true for a list of properties: it begins with one, with the name of one, or with definitions
    /// that one follows, and not a part of a model.
    fn is_properties(&self) -> bool {
        let first = self.tokens.first().map(|(token, _)| *token);
        let second = self.tokens.get(1).map(|(token, _)| *token);
        let is_named = (first, second) == (Some(Token::Quoted), Some(Token::Colon));
        let defines = self.first_word().is_some_and(|word| DEFINITIONS.contains(&word));
        let no_model = || !self.has_word(&["module", "mdp", "dtmc", "smg", "objective", "prefer"]);
        is_named || self.is_property(0) || (defines && no_model() && self.some_property())
    }

    fn some_property(&self) -> bool {
        (0..self.tokens.len()).any(|at| self.is_property(at))
    }

    /// Returns true if a property begins at this token: at the start of a statement, an operator with a
    /// bound or a bracket.
    fn is_property(&self, at: usize) -> bool {
        let signs = [
            Token::Ge,
            Token::Gt,
            Token::Le,
            Token::Lt,
            Token::Eq,
            Token::LeftParen,
            Token::LeftBracket,
            Token::LeftBrace,
        ];
        let is_operator = self
            .tokens
            .get(at)
            .is_some_and(|(token, word)| *token == Token::Word && PROPERTY_WORDS.contains(word));
        let before = at.checked_sub(1).and_then(|at| self.tokens.get(at)).map(|(token, _)| *token);
        let starts = before.is_none_or(|token| matches!(token, Token::Semicolon | Token::Colon));
        let next = self.tokens.get(at + 1);
        starts
            && is_operator
            && next.is_some_and(|(token, word)| signs.contains(token) || ["min", "max"].contains(word))
    }

    fn has_word(&self, words: &[&str]) -> bool {
        self.tokens.iter().any(|(token, word)| *token == Token::Word && words.contains(word))
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
            _ if self.first_word() == Some("digraph") => Some((
                "this is a graph for pictures (DOT), not a model",
                "name the file that it was made from",
            )),
            _ if self.is_strategy() => {
                let help = "PRISM writes the model that a strategy leaves with \
                            `-exportstrat FILE.tra:type=induced`; `meliora simulate` and `strategy` choose their own";
                Some(("this is a strategy that PRISM exported, not a model", help))
            }
            [Token::LeftParen, Token::Word, Token::Comma | Token::RightParen, ..] => {
                Some(("this is a list of states (`.sta`), not a model", help))
            }
            _ => None,
        }
    }

    /// Recognises lines such as `(0,true):north`, `(0,1),0=north` or `3:1`: a state with its action.
    fn is_strategy(&self) -> bool {
        let line = self.text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'));
        let Some(line) = line else { return false };
        let is_value = |value: &str| ["true", "false"].contains(&value) || value.parse::<i64>().is_ok();
        if let Some((values, rest)) = line.strip_prefix('(').and_then(|line| line.split_once(')')) {
            let of_values = values.split(',').all(|value| is_value(value.trim()));
            return of_values && (rest.starts_with(':') || rest.starts_with(',') || rest.starts_with('='));
        }
        let is_number =
            |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit() || b == b',');
        let is_choice = |text: &str| !text.is_empty() && !text.contains([' ', '(', '"']);
        line.split_once([':', '=']).is_some_and(|(state, choice)| is_number(state) && is_choice(choice))
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
