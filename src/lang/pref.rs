//! Preference files: objectives, preference statements, requirements, and the value of nothing
//! (`empty`).

use std::str::FromStr;
use std::sync::Arc;

use super::ast::{Ident, Span};
use super::ltl::Formula;
use super::parse::{Failed, Parsed, Parser};
use super::token::Token;
use meliora_base::error::{Result, SourceFile};
use meliora_model::preference::{Empty, History, Relation};

/// A preference file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Preferences {
    /// `objective A = F …;` in the order of the file.
    pub objectives: Vec<Objective>,
    /// `require …;` in the order of the file.
    pub requirements: Vec<Formula>,
    /// `prefer …;` in the order of the file.
    pub statements: Vec<Chain>,
    /// `empty = …;`
    pub empty: Option<(Empty, Span)>,
    /// `history = …;`
    pub history: Option<(History, Span)>,
    /// `coalition p1, p3;`: the players of a game that we are.
    pub coalition: Option<(Vec<Ident>, Span)>,
}

/// An objective: a temporal formula to satisfy.
#[derive(Debug, Clone, PartialEq)]
pub struct Objective {
    /// Name.
    pub name: Ident,
    /// Formula on paths.
    pub formula: Formula,
    /// Place of the whole statement.
    pub span: Span,
}

/// `A, B > C >= D ~ E`: each link relates every pair of its two sides.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// Leftmost side.
    pub first: Vec<Ident>,
    /// Links, each with the side to its right; at least one.
    pub links: Vec<(Relation, Vec<Ident>)>,
    /// Place of the whole statement.
    pub span: Span,
}

/// Parses a preference file. Names are resolved later.
///
/// # Errors
/// Returns all syntax errors that can be distinguished.
pub fn parse_preferences(source: &Arc<SourceFile>) -> Result<Preferences> {
    super::mistaken::no_preferences(source)?;
    let mut parser = Parser::new(source);
    let mut preferences = Preferences::default();
    while parser.peek() != Token::End {
        if parser.preference(&mut preferences).is_err() {
            parser.recover(&["objective", "prefer", "require"]);
        }
    }
    parser.finish(preferences)
}

/// The words that statements begin with.
const STATEMENTS: [&str; 6] = ["objective", "prefer", "require", "empty", "history", "coalition"];

impl Parser<'_> {
    fn preference(&mut self, preferences: &mut Preferences) -> Parsed<()> {
        let start = self.here();
        if self.eat_word("objective") {
            let objective = self.objective(start)?;
            preferences.objectives.push(objective);
        } else if self.eat_word("prefer") {
            let chain = self.chain(start)?;
            preferences.statements.push(chain);
        } else if self.eat_word("require") {
            let help = "write `require G (condition);`, or another safe formula";
            let formula = self.path_formula("a requirement", help)?;
            self.expect(Token::Semicolon)?;
            preferences.requirements.push(formula);
        } else if self.eat_word("empty") {
            let names = "`bottom`, `gain` or `incomparable`";
            self.setting(start, names, &mut preferences.empty)?;
        } else if self.eat_word("history") {
            self.setting(start, "`state` or `play`", &mut preferences.history)?;
        } else if self.eat_word("coalition") {
            let names = self.list(Self::player_name)?;
            let span = start.to(self.expect(Token::Semicolon)?);
            self.given_once(start, (names, span), &mut preferences.coalition);
        } else {
            let failed = match self.slip(&STATEMENTS) {
                Some(_) => Failed,
                None => self.expected("`objective`, `prefer`, `require`, `empty`, `history` or `coalition`"),
            };
            self.advance();
            return Err(failed);
        }
        Ok(())
    }

    fn objective(&mut self, start: Span) -> Parsed<Objective> {
        let name = self.objective_name()?;
        self.expect(Token::Eq)?;
        let help = "write `objective NAME = F (condition);`, or another temporal formula";
        let formula = self.path_formula("an objective", help)?;
        let end = self.expect(Token::Semicolon)?;
        Ok(Objective { name, formula, span: start.to(end) })
    }

    /// Parses a formula over paths.
    fn path_formula(&mut self, what: &str, help: &str) -> Parsed<Formula> {
        let place = self.here();
        let formula = self.temporal_formula()?;
        if formula.is_state_formula() {
            let message = format!("{what} is a formula over paths, not over one state");
            self.report(self.wrong(place, message).label("expected `F`, `G`, …").help(help));
            return Err(Failed);
        }
        Ok(formula)
    }

    /// Parses a name of an objective, which may be a keyword of the modelling language, such as `A`
    /// or `F`, and may contain hyphens between its parts, as names in PDDL do: `pills-ward`.
    fn objective_name(&mut self) -> Parsed<Ident> {
        if self.peek() != Token::Word {
            return Err(self.expected("the name of an objective"));
        }
        let mut span = self.advance();
        let is_part = |token| matches!(token, Token::Minus | Token::Word | Token::Int);
        while is_part(self.peek()) && self.here().start() == span.end() {
            span = span.to(self.advance());
        }
        let name = self.text(span).to_owned();
        if ["objective", "prefer", "empty", "history", "nothing", "true", "false"].contains(&name.as_str()) {
            self.report(self.wrong(span, format!("`{name}` cannot be the name of an objective")));
            return Err(Failed);
        }
        Ok(Ident { name, span })
    }

    fn chain(&mut self, start: Span) -> Parsed<Chain> {
        let first = self.side()?;
        let mut links = Vec::new();
        loop {
            let relation = match self.peek() {
                Token::Gt => Relation::Strict,
                Token::Ge => Relation::Weak,
                Token::Tilde => Relation::Indifferent,
                Token::Lt | Token::Le => {
                    let diagnostic = self.wrong(self.here(), "preferences are written from better to worse");
                    self.report(diagnostic.help("write `prefer BETTER > WORSE;`"));
                    return Err(Failed);
                }
                _ if !links.is_empty() => break,
                _ => return Err(self.expected("`>`, `>=` or `~`")),
            };
            self.advance();
            links.push((relation, self.side()?));
        }
        let end = self.expect(Token::Semicolon)?;
        Ok(Chain { first, links, span: start.to(end) })
    }

    fn side(&mut self) -> Parsed<Vec<Ident>> {
        self.list(Self::objective_name)
    }

    /// Parses `keyword = name;`, which may be given once.
    fn setting<T: FromStr>(&mut self, start: Span, names: &str, given: &mut Option<(T, Span)>) -> Parsed<()> {
        self.expect(Token::Eq)?;
        let Ok(value) = self.text(self.here()).parse() else {
            return Err(self.expected(names));
        };
        self.advance();
        let span = start.to(self.expect(Token::Semicolon)?);
        self.given_once(start, (value, span), given);
        Ok(())
    }

    /// Sets a value, which may be given once; `start` is the keyword.
    fn given_once<T>(&mut self, start: Span, (value, span): (T, Span), given: &mut Option<(T, Span)>) {
        if let Some((_, first)) = given {
            let message = format!("`{}` is given twice", self.text(start));
            let diagnostic = self.wrong(span, message).label("given again");
            self.report(diagnostic.related(first.range(), "given here first"));
        }
        *given = Some((value, span));
    }

    /// Parses a player: its name, or its number.
    pub(crate) fn player_name(&mut self) -> Parsed<Ident> {
        match self.peek() {
            Token::Word | Token::Int => {
                let span = self.advance();
                Ok(self.named(span))
            }
            _ => Err(self.expected("the name of a player")),
        }
    }
}
