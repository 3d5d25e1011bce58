//! Properties of other tools that are not supported: each is refused by name, with advice.

use crate::ast::Span;
use crate::parse::{Failed, Parsed, Parser};
use crate::token::Token;

/// The operators of interval models, whose intervals have an extreme of their own.
const OF_INTERVALS: [&str; 4] = ["minmin", "minmax", "maxmin", "maxmax"];

impl Parser<'_> {
    /// Reports the property of an interval model, or the shield expression of tempest, that begins here.
    pub(super) fn of_other_kind(&mut self) -> Parsed<()> {
        let span = self.here();
        let word = self.text(span);
        if self.peek() == Token::Lt && self.peek_at(1) == Token::Word && self.peek_at(2) == Token::Comma {
            let help = "`meliora shield --property` reads it";
            self.report(self.wrong(span, "a shield expression is not a property").help(help));
            return Err(Failed);
        }
        let is_asked = self.peek_at(1) == Token::Eq && self.peek_at(2) == Token::Question;
        if is_asked && word.strip_prefix(['P', 'R']).is_some_and(|rest| OF_INTERVALS.contains(&rest)) {
            let message = format!("`{word}` is about intervals of probabilities, which are not supported");
            self.report(self.unsupported(span, &message).help("write `Pmin`, `Pmax`, `Rmin` or `Rmax`"));
            return Err(Failed);
        }
        Ok(())
    }

    /// Reports a bound on rewards, `F{"c"}<=3` or `C{"c"}<=3`.
    pub(crate) fn bounded_by_rewards(&mut self, span: Span) -> Failed {
        let message = "bounds on rewards are not supported";
        let help = "count the reward in a variable of the model, and let the condition compare it";
        self.report(self.unsupported(span, message).help(help));
        Failed
    }

    /// Reports another property behind the semicolon.
    pub(super) fn second(&mut self) -> Failed {
        let diagnostic =
            self.wrong(self.here(), "more than one property").label("expected the end of the text");
        self.report(diagnostic.help("ask for each property alone; a file may contain many"));
        Failed
    }

    /// Reports what PRISM permits behind the formula of a property.
    pub(super) fn behind(&mut self) -> Failed {
        let span = self.here();
        if self.peek() != Token::LeftBrace {
            return self.expected("the end of the text");
        }
        let message = "a condition on the states behind a property is not supported";
        let help = "write `filter(state, …, condition)`, or another filter";
        self.report(self.unsupported(span, message).help(help));
        Failed
    }

    /// Reports the coalitions of an equilibrium, `<<p1:p2>>`.
    pub(super) fn several_coalitions(&mut self) -> Failed {
        let message = "equilibria of several coalitions are not supported";
        let help = "PRISM-games computes them; `<<p1>> P>=1 [ … ]` has all other players as the opponent";
        self.report(self.unsupported(self.here(), message).help(help));
        Failed
    }

    /// Reports a reward in the brackets of a probability.
    pub(super) fn no_rewards(&mut self) -> Parsed<()> {
        let span = self.here();
        if !["C", "I", "S", "LRA"].contains(&self.text(span)) {
            return Ok(());
        }
        let message = format!("`{}` is a reward, not a formula on paths", self.text(span));
        let help = "the probability of a formula is asked for by `Pmax=? [ F condition ]`";
        self.report(self.wrong(span, message).label("expected a formula").help(help));
        Err(Failed)
    }

    /// Reports discounted rewards, `C{0.9}`.
    pub(super) fn discounted(&mut self) -> Failed {
        let help = "write `C` or `C<=k`, or let the model end each step with probability 1 minus the factor";
        self.report(self.unsupported(self.here(), "discounted rewards are not supported").help(help));
        Failed
    }

    /// Reports the rewards that only PRISM-games has: `F*`.
    pub(super) fn rewards_of_games(&mut self) -> Parsed<()> {
        let span = self.here();
        if self.text(span) != "F" || self.peek_at(1) != Token::Star {
            return Ok(());
        }
        let message = "rewards of `F*` are not supported";
        let help =
            "where the target is not reached, `F` is infinite, `Fc` keeps the rewards, and `F0` loses them";
        self.report(self.unsupported(span, message).label("expected `F condition`").help(help));
        Err(Failed)
    }
}
