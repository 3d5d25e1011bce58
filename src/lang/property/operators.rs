//! Parser of the operators of properties: `P`, `R`, `S`, `A`, `E`, the players of a game, filters and
//! several objectives. Each is an operand of an expression.

use crate::ast::{BinaryOp, Expr, Ident, NodeKind, Span};
use crate::ltl::Formula;
use crate::parse::{Failed, Parsed, Parser};
use crate::token::Token;
use meliora_model::property::{Inequality, Rewards};

/// The operators that say which strategies they ask about.
pub(super) const NAMED: [&str; 6] = ["Pmin", "Pmax", "Rmin", "Rmax", "Smin", "Smax"];

/// An operator of a property with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Operator {
    /// `<<p1,p2>>` or `[[p1]]`: the players of a game.
    pub(crate) coalition: Option<Coalition>,
    /// Form of the operator.
    pub(crate) kind: OperatorKind,
    /// Place of the operator and its bound.
    pub(crate) head: Span,
    /// Place of the whole.
    pub(crate) span: Span,
}

/// The forms of operators.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum OperatorKind {
    /// `P>=1 [ φ ]`, `Pmax=? [ φ ]`
    Probability(Asked, Formula),
    /// `R{"name"}max=? [ … ]`
    Reward(Rewards, Asked, Accumulated),
    /// `S=? [ e ]`
    LongRun(Asked, Expr),
    /// `A [ φ ]` if true, else `E [ φ ]`.
    Paths(bool, Formula),
    /// `filter(op, e, states)`
    Filter(Ident, Expr, Option<Expr>),
    /// `multi(…)`
    Multi(Vec<Expr>),
}

/// The strategies and the bound of an operator.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Asked {
    pub(crate) extreme: Extreme,
    /// The comparison; `None` for `=?`.
    pub(crate) bound: Option<(Inequality, Expr)>,
}

/// The rewards that an operator asks for.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Accumulated {
    /// Until a formula is satisfied.
    Until(Formula),
    /// `Fc φ`: until a state is reached, or of all steps.
    Anyway(Expr),
    /// `F0 φ`: until a state is reached, and nothing where none is.
    IfReached(Expr),
    /// `C<=k`
    Within(Expr),
    /// `C`
    Total,
    /// `I=k`
    At(Expr),
    /// `S`
    LongRun,
}

/// The players in front of an operator.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Coalition {
    /// The players, each by its name or its number; `None` for `*`, all players.
    pub(crate) players: Option<Vec<Ident>>,
    /// `[[…]]`: the property holds against every strategy of the players.
    pub(crate) opposed: bool,
    /// Place with the brackets.
    pub(crate) span: Span,
}

/// Minimum or maximum, as an operator names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Extreme {
    Unnamed,
    Min,
    Max,
}

impl Parser<'_> {
    /// Returns whether an operator of properties begins here, and may stand here.
    pub(crate) fn is_operator_of_properties(&self) -> bool {
        let next = self.peek_at(1);
        if !self.in_property {
            return false;
        }
        match self.peek() {
            Token::Lt | Token::LeftBracket => next == self.peek(),
            Token::Word => match self.text(self.here()) {
                "filter" | "multi" => next == Token::LeftParen,
                "A" | "E" => next == Token::LeftBracket,
                "P" | "Pmin" | "Pmax" | "R" | "Rmin" | "Rmax" | "S" | "Smin" | "Smax" => {
                    let signs = [Token::Ge, Token::Gt, Token::Le, Token::Lt, Token::Eq, Token::LeftBrace];
                    let extreme = self.rest().nth(1).is_some_and(|(_, word)| ["min", "max"].contains(&word));
                    signs.contains(&next) || next == Token::LeftBracket || extreme
                }
                _ => false,
            },
            _ => false,
        }
    }

    /// Parses an operator as an operand of an expression.
    pub(crate) fn operator_of_properties(&mut self) -> Parsed<Span> {
        let operator = self.nested_to(crate::parse::MAX_TREE_NESTING, Self::operator_with_players)?;
        let span = operator.span;
        Ok(self.push(span, || NodeKind::Operator(Box::new(operator))))
    }

    fn operator_with_players(&mut self) -> Parsed<Operator> {
        let start = self.here();
        let coalition = self.coalition()?;
        if coalition.is_some() && self.eat(Token::LeftParen) {
            let Operator { kind, head, .. } = self.named_operator()?;
            self.expect(Token::RightParen)?;
            return Ok(Operator { coalition, kind, head, span: start.to(self.before()) });
        }
        let Operator { kind, head, .. } = self.named_operator()?;
        Ok(Operator { coalition, kind, head, span: start.to(self.before()) })
    }

    fn named_operator(&mut self) -> Parsed<Operator> {
        let start = self.here();
        let word = self.text(start);
        match word {
            "filter" => return self.filter(),
            "multi" => return self.multi(),
            _ => {}
        }
        if self.slip(&NAMED).is_some() {
            return Err(Failed);
        }
        let (kind, head) = match word.get(..1) {
            Some("P") => {
                let (asked, head) = self.asked(word)?;
                self.no_rewards()?;
                (OperatorKind::Probability(asked, self.formula_in_brackets()?), head)
            }
            Some("R") => self.reward(word)?,
            Some("S") => {
                let (asked, head) = self.asked(word)?;
                (OperatorKind::LongRun(asked, self.tree(Self::expression)?), head)
            }
            Some("A" | "E") if word.len() == 1 => {
                self.advance();
                self.expect(Token::LeftBracket)?;
                (OperatorKind::Paths(word == "A", self.formula_in_brackets()?), start)
            }
            _ => return Err(self.expected("an operator such as `P>=1 [ F … ]`")),
        };
        let filter = self.old_filter()?;
        self.expect(Token::RightBracket)?;
        let span = start.to(self.before());
        let operator = Operator { coalition: None, kind, head, span };
        let Some((function, states)) = filter else { return Ok(operator) };
        let of = Expr::new(NodeKind::Operator(Box::new(operator)), span);
        let kind = OperatorKind::Filter(function, of, Some(states));
        Ok(Operator { coalition: None, kind, head, span })
    }

    /// Parses the old form of a filter, as in `P=? [ F a {states}{min} ]`, if it is there. Without a function
    /// the filter is `state`.
    fn old_filter(&mut self) -> Parsed<Option<(Ident, Expr)>> {
        let span = self.here();
        if !self.eat(Token::LeftBrace) {
            return Ok(None);
        }
        let states = self.tree(Self::expression)?;
        self.expect(Token::RightBrace)?;
        let mut name = "state";
        while self.eat(Token::LeftBrace) {
            let function = self.function_name()?;
            name = match (name, function.name.as_str()) {
                ("state", "min") => "min",
                ("state", "max") => "max",
                _ => "range",
            };
            self.expect(Token::RightBrace)?;
        }
        Ok(Some((Ident { name: name.to_owned(), span }, states)))
    }

    fn formula_in_brackets(&mut self) -> Parsed<Formula> {
        self.temporal_formula()
    }

    /// Parses the word, the strategies, the bound and the opening bracket.
    fn asked(&mut self, word: &str) -> Parsed<(Asked, Span)> {
        let start = self.advance();
        let extreme = self.extreme(word);
        let bound = self.bound()?;
        let head = start.to(self.before());
        self.opening()?;
        Ok((Asked { extreme, bound }, head))
    }

    fn reward(&mut self, word: &str) -> Parsed<(OperatorKind, Span)> {
        let start = self.advance();
        let rewards = self.reward_structure()?;
        let extreme = self.extreme(word);
        let bound = self.bound()?;
        let head = start.to(self.before());
        self.opening()?;
        let accumulated = self.accumulated()?;
        Ok((OperatorKind::Reward(rewards, Asked { extreme, bound }, accumulated), head))
    }

    fn opening(&mut self) -> Parsed<()> {
        if self.eat(Token::LeftBracket) {
            return Ok(());
        }
        let diagnostic = self.wrong(self.here(), "the formula of a property is written in brackets");
        self.report(diagnostic.label("expected `[`").help("write `P>=1 [ F condition ]`"));
        Err(Failed)
    }

    /// Parses the part between the brackets of a reward.
    fn accumulated(&mut self) -> Parsed<Accumulated> {
        self.rewards_of_games()?;
        let next = self.peek_at(1);
        match self.text(self.here()) {
            "C" if next == Token::RightBracket => {
                self.advance();
                Ok(Accumulated::Total)
            }
            "Fc" => {
                self.advance();
                Ok(Accumulated::Anyway(self.tree(Self::expression)?))
            }
            "F0" => {
                self.advance();
                Ok(Accumulated::IfReached(self.tree(Self::expression)?))
            }
            // The braces have the name of a reward.
            "C" if next == Token::LeftBrace && self.peek_at(2) == Token::Quoted => {
                Err(self.bounded_by_rewards(self.here()))
            }
            "C" if next == Token::LeftBrace => Err(self.discounted()),
            "Cdiscount" => Err(self.discounted()),
            "C" if next == Token::Le => {
                self.advance();
                self.advance();
                Ok(Accumulated::Within(self.tree(Self::expression)?))
            }
            "I" if next == Token::Eq => {
                self.advance();
                self.advance();
                Ok(Accumulated::At(self.tree(Self::expression)?))
            }
            "S" | "LRA" if next == Token::RightBracket => {
                self.advance();
                Ok(Accumulated::LongRun)
            }
            _ => Ok(Accumulated::Until(self.formula_in_brackets()?)),
        }
    }

    /// Parses `filter(op, e, states)`.
    fn filter(&mut self) -> Parsed<Operator> {
        let start = self.advance();
        self.expect(Token::LeftParen)?;
        let place = self.here();
        let function = match self.peek() {
            Token::Plus | Token::And | Token::Or => {
                self.advance();
                self.named(place)
            }
            _ => self.function_name()?,
        };
        self.expect(Token::Comma)?;
        let of = self.tree(Self::expression)?;
        let states = if self.eat(Token::Comma) { Some(self.tree(Self::expression)?) } else { None };
        self.expect(Token::RightParen)?;
        let span = start.to(self.before());
        let kind = OperatorKind::Filter(function, of, states);
        Ok(Operator { coalition: None, kind, head: span, span })
    }

    /// Parses `multi(…)`.
    fn multi(&mut self) -> Parsed<Operator> {
        let start = self.advance();
        self.expect(Token::LeftParen)?;
        let all = self.list(|p| p.tree(Self::expression))?;
        self.expect(Token::RightParen)?;
        let span = start.to(self.before());
        Ok(Operator { coalition: None, kind: OperatorKind::Multi(all), head: span, span })
    }

    /// Parses the players of a game, `<<p1,p2>>` or `[[p1]]`, if they are there.
    fn coalition(&mut self) -> Parsed<Option<Coalition>> {
        let (open, close) = match self.peek() {
            Token::Lt => (Token::Lt, Token::Gt),
            Token::LeftBracket => (Token::LeftBracket, Token::RightBracket),
            _ => return Ok(None),
        };
        let start = self.advance();
        self.expect(open)?;
        let players = if self.eat(Token::Star) {
            None
        } else if self.peek() == close {
            Some(Vec::new())
        } else {
            Some(self.list(Self::player_name)?)
        };
        if self.peek() == Token::Colon {
            return Err(self.several_coalitions());
        }
        self.expect(close)?;
        let span = start.to(self.expect(close)?);
        Ok(Some(Coalition { players, opposed: open == Token::LeftBracket, span }))
    }

    /// Parses `min` or `max`, unless it is part of the operator's word.
    fn extreme(&mut self, word: &str) -> Extreme {
        match word.get(1..) {
            Some("min") => Extreme::Min,
            Some("max") => Extreme::Max,
            _ if self.eat_word("min") => Extreme::Min,
            _ if self.eat_word("max") => Extreme::Max,
            _ => Extreme::Unnamed,
        }
    }

    /// Parses `{"name"}` or `{2}`, if it is there.
    fn reward_structure(&mut self) -> Parsed<Rewards> {
        if !self.eat(Token::LeftBrace) {
            return Ok(Rewards::First);
        }
        let span = self.here();
        let rewards = match (self.peek(), self.text(span).parse::<usize>()) {
            (Token::Quoted, _) => Rewards::Named(self.reference()?.to_owned()),
            (Token::Int, Ok(number)) if number > 0 => {
                self.advance();
                Rewards::Numbered(number)
            }
            _ => return Err(self.expected("the name of a reward structure in quotes, or its number from 1")),
        };
        self.expect(Token::RightBrace)?;
        Ok(rewards)
    }

    /// Parses a bound such as `>=1`, `>0.5` or `<p`, or `=?`, for which it returns `None`.
    fn bound(&mut self) -> Parsed<Option<(Inequality, Expr)>> {
        let start = self.here();
        let comparison = match self.peek() {
            Token::Ge => Inequality::Ge,
            Token::Gt => Inequality::Gt,
            Token::Le => Inequality::Le,
            Token::Lt => Inequality::Lt,
            Token::Eq => {
                self.advance();
                if self.eat(Token::Question) {
                    return Ok(None);
                }
                let span = start.to(self.before());
                let diagnostic = self.wrong(span, "a value is compared by `>=`, `>`, `<=` or `<`");
                let help =
                    "`P>=1 […]` says that it is 1, `P<=0 […]` that it is 0, and `=?` asks for the value";
                self.report(diagnostic.label("not by `=`").help(help));
                return Err(Failed);
            }
            _ => return Err(self.expected("`>=`, `>`, `<=`, `<` or `=?`")),
        };
        self.advance();
        Ok(Some((comparison, self.tree(|p| p.binary(BinaryOp::Add.level()))?)))
    }
}
