//! Properties. A qualitative property, such as `P>=1 [ ψ ]`, is answered without numbers: by a set of
//! states. All others ask for a probability or an expected reward, or compare one with a bound.

use std::sync::Arc;

use num_traits::{One, Zero};

use super::ast::{Ident, Span};
use super::ltl::Formula;
use super::parse::{Failed, Parsed, Parser};
use super::players;
use super::refused::FILTERS;
use super::token::Token;
use meliora_base::error::{Diagnostic, Result, SourceFile};
use meliora_base::exact::{Exact, Ratio, Real};
use meliora_base::progress::NoProgress;
pub use meliora_model::Optimum;
use meliora_model::Program;
pub use meliora_model::property::{
    Bound, Inequality, Measure, Over, Quantity, Question, Rewards, Strategies,
};

/// A property.
#[derive(Debug, Clone, PartialEq)]
pub struct Property {
    /// Question.
    pub question: Question,
    /// Place of the operator and its bound.
    pub operator: Span,
    /// Formula on paths.
    pub formula: Formula,
    /// `<<p1,p2>>`: the players of a game who choose to make the property true.
    pub coalition: Option<Coalition>,
}

/// The players in front of a property of a game.
#[derive(Debug, Clone, PartialEq)]
pub struct Coalition {
    /// The players, each by its name or its number; `None` for `*`, all players.
    pub(crate) players: Option<Vec<Ident>>,
    /// Place from `<<` to `>>`.
    pub(crate) span: Span,
}

/// The error for a name or a number that no reward structure has.
const UNKNOWN_REWARDS: &str = "unknown reward structure";

impl Property {
    /// Checks that the question has a meaning for a program.
    ///
    /// # Errors
    /// A reward structure does not exist, or the property of an `mdp` does not say which strategies
    /// it asks about. A property of a game does not name its players, or another one names players.
    pub fn check(&self, program: &Program, source: &Arc<SourceFile>) -> Result<()> {
        self.coalition_in(program, source)?;
        let Question::Quantity(quantity) = &self.question else { return Ok(()) };
        let wrong = |message: &str| Diagnostic::new(source, self.operator.range(), message);
        if quantity.strategies(program).is_none() {
            let help = "write `Pmin=?` or `Pmax=?`, for rewards `Rmin=?` or `Rmax=?`";
            let kind = <&str>::from(program.kind);
            return Err(wrong(&format!("an `{kind}` has a least and a greatest value"))
                .label("which one?")
                .help(help)
                .into());
        }
        match &quantity.measure {
            Measure::Reward(rewards) if rewards.find(program).is_none() => {
                let names = program.rewards.iter().filter_map(|r| r.name.as_ref());
                let names: Vec<_> = names.map(|name| format!("\"{name}\"")).collect();
                let unnamed = program.rewards.len() - names.len();
                let (message, help) = match (names.len(), unnamed) {
                    (0, 0) => (
                        "the model has no reward structure",
                        "declare one in the model, or ask for a probability".to_owned(),
                    ),
                    (0, _) => {
                        let help = "no reward structure of the model has a name: leave out the braces for the first \
                            one, or write its number, `{1}`";
                        (UNKNOWN_REWARDS, help.to_owned())
                    }
                    _ => (UNKNOWN_REWARDS, format!("the reward structures are {}", names.join(", "))),
                };
                Err(wrong(message).label("not in the model").help(help).into())
            }
            _ => Ok(()),
        }
    }
}

impl Property {
    /// Returns the players of a game who choose to make the property true, as an entry per player; `None`
    /// for other models.
    ///
    /// # Errors
    /// A property of a game does not name its players, or another one names players.
    pub fn coalition_in(&self, program: &Program, source: &Arc<SourceFile>) -> Result<Option<Vec<bool>>> {
        let wrong = |message: &str| Diagnostic::new(source, self.operator.range(), message);
        let (game, named) = match (&program.players, &self.coalition) {
            (None, None) => return Ok(None),
            (Some(_), None) => {
                let diagnostic = wrong("a property of a game names the players who choose to make it true");
                return Err(diagnostic.help("write `<<p1>> P>=1 [ … ]` or `<<p1,p2>> Pmax=? [ … ]`").into());
            }
            (game, Some(named)) => (game, named),
        };
        match (game, &named.players) {
            (Some(game), None) => Ok(Some(vec![true; game.list.len()])),
            (_, players) => {
                let names = players.as_deref().unwrap_or(&[]);
                players::coalition(program, source, names, named.span).map(Some)
            }
        }
    }
}

/// Minimum or maximum, as an operator names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Extreme {
    Unnamed,
    Min,
    Max,
}

/// Returns the question of a comparison of a probability with a number. Without a name, the bound
/// must hold for every strategy.
pub(crate) fn compared(extreme: Extreme, comparison: Inequality, value: Ratio) -> Question {
    let bound = match comparison {
        Inequality::Ge if value.is_one() => Bound::One,
        Inequality::Gt if value.is_zero() => Bound::Positive,
        Inequality::Lt if value.is_one() => Bound::BelowOne,
        Inequality::Le if value.is_zero() => Bound::Zero,
        _ => return Question::Quantity(quantity(Measure::Probability, extreme, Some((comparison, value)))),
    };
    // The minimum is at least b if the probability of every strategy is; the maximum, if that of
    // some strategy is.
    let from_below = matches!(bound, Bound::One | Bound::Positive);
    let strategies = match extreme {
        Extreme::Max if from_below => Strategies::Some,
        Extreme::Min if !from_below => Strategies::Some,
        _ => Strategies::All,
    };
    Question::Qualitative(strategies, bound)
}

/// Returns the question of a property of a game: a bound must hold for some strategy of the coalition,
/// whatever the other players do.
fn chosen(question: Question) -> Question {
    match question {
        Question::Qualitative(_, bound) => Question::Qualitative(Strategies::Some, bound),
        Question::Quantity(Quantity { measure, optimum, bound }) => {
            let optimum = match &bound {
                Some((Inequality::Ge | Inequality::Gt, _)) => Some(Optimum::Max),
                Some(_) => Some(Optimum::Min),
                None => optimum,
            };
            Question::Quantity(Quantity { measure, optimum, bound })
        }
    }
}

/// Returns a quantity. A bound without a name must hold for every strategy: a lower bound for the
/// minimum, an upper bound for the maximum.
pub(crate) fn quantity(measure: Measure, extreme: Extreme, bound: Option<(Inequality, Ratio)>) -> Quantity {
    let optimum = match (extreme, &bound) {
        (Extreme::Min, _) => Some(Optimum::Min),
        (Extreme::Max, _) => Some(Optimum::Max),
        (Extreme::Unnamed, Some((Inequality::Ge | Inequality::Gt, _))) => Some(Optimum::Min),
        (Extreme::Unnamed, Some(_)) => Some(Optimum::Max),
        (Extreme::Unnamed, None) => None,
    };
    Quantity { measure, optimum, bound }
}

/// Parses a property such as `P>=1 [ F "done" ]`, `Pmax=? [ a U b ]`, `P>=0.9 [ G !(F x=3) ]` or
/// `R{"cost"}min=? [ F "done" ]`.
///
/// `P` with a bound holds in a state if every strategy satisfies it (PRISM's meaning for MDPs).
/// `Pmin` and `Pmax` compare the minimum and the maximum probability (Storm's forms).
///
/// # Errors
/// A syntax error, or a property that is not supported.
pub fn parse_property(source: &Arc<SourceFile>) -> Result<Property> {
    property_at(source, Span::new(0, source.text.len()), &[])
}

/// Parses a property whose bound may be a constant of a program, as in `P>=p [ F "done" ]`.
///
/// # Errors
/// See [`parse_property`].
pub fn parse_property_of(program: &Program, source: &Arc<SourceFile>) -> Result<Property> {
    property_at(source, Span::new(0, source.text.len()), &program.constants)
}

/// Constants with their values.
type Constants<'a> = &'a [(String, Exact)];

/// Parses a part of a text that is one property; its bound may be one of the constants.
///
/// # Errors
/// See [`parse_property`].
pub(crate) fn property_at(
    source: &Arc<SourceFile>,
    place: Span,
    constants: Constants<'_>,
) -> Result<Property> {
    let mut parser = Parser::of_part(source, place, &NoProgress);
    let parsed = parser.property(constants);
    parser.finish_parsed(parsed)
}

impl Parser<'_> {
    fn property(&mut self, constants: Constants<'_>) -> Parsed<Property> {
        let is_filter = self.text(self.here()) == "filter";
        let property = if is_filter { self.filter(constants)? } else { self.asked(constants)? };
        let ended = self.eat(Token::Semicolon);
        match self.peek() {
            Token::End => Ok(property),
            _ if ended => Err(self.second()),
            _ => Err(self.behind()),
        }
    }

    /// Parses `filter(forall, P>=1 [ … ], "init")` or `filter(range, Pmax=? [ … ], "init")`. The answer
    /// is that of the property inside: whether it holds in all initial states, or the least and the
    /// greatest value in them.
    fn filter(&mut self, constants: Constants<'_>) -> Parsed<Property> {
        let start = self.here();
        self.advance();
        self.expect(Token::LeftParen)?;
        let operator = self.text(self.here()).to_owned();
        if !["forall", "range"].contains(&operator.as_str()) {
            let message = format!("the filter `{operator}` is not supported");
            self.report(self.unsupported(self.here(), message).help(FILTERS));
            return Err(Failed);
        }
        self.advance();
        self.expect(Token::Comma)?;
        let property = self.asked(constants)?;
        let is_value = matches!(&property.question, Question::Quantity(quantity) if quantity.bound.is_none());
        let is_initial =
            self.eat(Token::Comma) && self.peek() == Token::Quoted && self.text(self.here()) == "\"init\"";
        if is_initial && operator == if is_value { "range" } else { "forall" } {
            self.advance();
            self.expect(Token::RightParen)?;
            return Ok(property);
        }
        let message = "of the filters, those of all initial states are supported";
        self.report(self.unsupported(start.to(self.before()), message).help(FILTERS));
        Err(Failed)
    }

    /// Parses an operator with its formula.
    fn asked(&mut self, constants: Constants<'_>) -> Parsed<Property> {
        let coalition = self.coalition()?;
        let start = self.here();
        let (measure, extreme) = self.operator()?;
        let bound = self.bound(constants)?;
        let whole = start.to(self.before());
        if self.peek() != Token::LeftBracket {
            let diagnostic = self.wrong(self.here(), "the formula of a property is written in brackets");
            self.report(diagnostic.label("expected `[`").help("write `P>=1 [ F condition ]`"));
            return Err(Failed);
        }
        self.advance();
        match measure {
            Measure::Reward(_) => self.other_rewards()?,
            Measure::Probability => self.no_rewards()?,
        }
        let formula = self.temporal_formula()?;
        self.expect(Token::RightBracket)?;
        if coalition.is_some() && bound.is_some() && extreme != Extreme::Unnamed {
            let diagnostic = self.wrong(whole, "the players of a coalition say who chooses");
            let help = "write `<<p1>> P>=1 [ … ]`, without `min` or `max`, or ask for the value by `=?`";
            self.report(diagnostic.help(help));
            return Err(Failed);
        }
        let question = self.question(measure, extreme, bound, whole)?;
        let question = if coalition.is_some() { chosen(question) } else { question };
        self.check_rewards(&question, &formula)?;
        Ok(Property { question, operator: whole, formula, coalition })
    }

    /// Parses the players of a game, `<<p1,p2>>`, if they are there.
    fn coalition(&mut self) -> Parsed<Option<Coalition>> {
        if self.peek() == Token::LeftBracket {
            return Err(self.other_players());
        }
        if self.peek() != Token::Lt {
            return Ok(None);
        }
        let start = self.advance();
        self.expect(Token::Lt)?;
        let players = if self.eat(Token::Star) {
            None
        } else if self.peek() == Token::Gt {
            Some(Vec::new())
        } else {
            Some(self.list(Self::player_name)?)
        };
        if self.peek() == Token::Colon {
            return Err(self.other_players());
        }
        self.expect(Token::Gt)?;
        let span = start.to(self.expect(Token::Gt)?);
        Ok(Some(Coalition { players, span }))
    }

    /// Parses the operator before the bound: `P`, `Pmax`, `R{"name"}min` and so on.
    fn operator(&mut self) -> Parsed<(Measure, Extreme)> {
        let span = self.here();
        match self.text(span) {
            word @ ("P" | "Pmin" | "Pmax") => {
                self.advance();
                Ok((Measure::Probability, self.extreme(word)))
            }
            word @ ("R" | "Rmin" | "Rmax") => {
                self.advance();
                let rewards = self.reward_structure()?;
                Ok((Measure::Reward(rewards), self.extreme(word)))
            }
            word @ ("S" | "Smin" | "Smax" | "E" | "A" | "multi") => Err(self.other_operator(word)),
            "" => Err(self.expected("a property such as `P>=1 [ F … ]`")),
            _ if self.slip(&["Pmin", "Pmax", "Rmin", "Rmax", "filter", "multi"]).is_some() => Err(Failed),
            _ => {
                let message = "a property needs a bound on the probability of its formula";
                let help =
                    "write `P>=1 [ … ]` for surely, `P>0 [ … ]` for possibly, `Pmax=? [ … ]` for the value";
                self.report(self.wrong(span, message).label("expected `P>=1 [` or another bound").help(help));
                Err(Failed)
            }
        }
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
    fn bound(&mut self, constants: Constants<'_>) -> Parsed<Option<(Inequality, Ratio)>> {
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
        let span = self.here();
        let value = match self.peek() {
            Token::Int | Token::Real => self.exact(span)?,
            Token::Word => self.value_of(constants)?,
            _ => return Err(self.expected("a number or a constant")),
        };
        self.advance();
        Ok(Some((comparison, value)))
    }

    /// Returns the value of the constant that stands here.
    fn value_of(&mut self, constants: Constants<'_>) -> Parsed<Ratio> {
        let (span, name) = (self.here(), self.text(self.here()));
        let value = constants.iter().find(|(known, _)| known == name).map(|(_, value)| value);
        let diagnostic = match value {
            Some(Exact::Int(value)) => return Ok(Ratio::from_integer((*value).into())),
            Some(Exact::Real(Real::Finite(value))) => return Ok(value.clone()),
            Some(_) => self.wrong(span, format!("the constant `{name}` is not a finite number")),
            None => self.wrong(span, format!("unknown name `{name}`")).label("not a constant"),
        };
        self.report(diagnostic.help("a bound is a number or a constant, as in `P>=0.5` or `P>=p`"));
        Err(Failed)
    }

    /// Returns the question; reports a bound that no probability can have.
    fn question(
        &mut self,
        measure: Measure,
        extreme: Extreme,
        bound: Option<(Inequality, Ratio)>,
        place: Span,
    ) -> Parsed<Question> {
        match (measure, bound) {
            (Measure::Probability, Some((_, value))) if value > Ratio::one() => {
                let value = Real::Finite(value);
                let diagnostic = self.wrong(place, format!("{value} is not a probability"));
                self.report(diagnostic.label("greater than 1").help("a probability is a number from 0 to 1"));
                Err(Failed)
            }
            (Measure::Probability, Some((comparison, value))) => Ok(compared(extreme, comparison, value)),
            (measure, bound) => Ok(Question::Quantity(quantity(measure, extreme, bound))),
        }
    }

    /// Reports rewards that are not accumulated until a target is reached.
    fn check_rewards(&mut self, question: &Question, formula: &Formula) -> Parsed<()> {
        let is_reward = matches!(question, Question::Quantity(Quantity { measure: Measure::Reward(_), .. }));
        if !is_reward || formula.reachability().is_some() {
            return Ok(());
        }
        let message = "rewards are supported until a set of states is reached";
        let help = "write `R{\"name\"}min=? [ F condition ]`";
        self.report(self.unsupported(formula.span, message).label("expected `F condition`").help(help));
        Err(Failed)
    }
}
