//! Properties of PRISM and Storm that are not supported: each is refused by name, with advice.

use super::parse::{Failed, Parsed, Parser, operator};
use super::token::Token;

/// The filters that are supported, for messages.
pub(super) const FILTERS: &str = "write `filter(forall, P>=1 [ … ], \"init\")` or `filter(range, Pmax=? [ … ], \"init\")`; \
                       the regions of `reach` are what `filter(count, …)` counts";

/// The refusal of other rewards of PRISM-games.
const GAME_REWARDS: &str = "of the rewards of PRISM-games, those until a target are supported that are infinite where it is not reached";

/// Returns what to write in place of an operator that is not supported.
fn instead(operator: &str) -> &'static str {
    match operator {
        "E" => "`E [ F a ]` is `Pmax>0 [ F a ]`, some strategy reaches `a` possibly",
        "A" => "`A [ G a ]` is `P>=1 [ G a ]`: no strategy ever leaves `a`",
        "multi" => {
            "ask for each property alone; `jointly` tells which objectives one strategy achieves together"
        }
        _ => "PRISM and Storm compute averages over the long run",
    }
}

impl Parser<'_> {
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
        let (message, help) = match self.peek() {
            Token::LeftBrace => (
                "a condition on the states behind a property is not supported",
                "the answer is that of the initial states; other initial states are given by `init … endinit` \
                 in the model",
            ),
            sign if operator(sign).is_some() || sign == Token::Question => {
                ("properties cannot be operands", "ask for each property alone, and combine the answers")
            }
            _ => return self.expected("the end of the text"),
        };
        self.report(self.unsupported(span, message).help(help));
        Failed
    }

    /// Reports an operator that begins another kind of property.
    pub(super) fn other_operator(&mut self, word: &str) -> Failed {
        let message = format!("properties with `{word}` are not supported");
        self.report(self.unsupported(self.here(), message).help(instead(word)));
        Failed
    }

    /// Reports `[[p1]]`, or the coalitions of an equilibrium, `<<p1:p2>>`.
    pub(super) fn other_players(&mut self) -> Failed {
        let (message, help) = match self.peek() {
            Token::Colon => (
                "equilibria of several coalitions are not supported",
                "write `<<p1>> P>=1 [ … ]`: all other players are the opponent",
            ),
            _ => (
                "properties of the players in `[[…]]` are not supported",
                "write `<<p1>> P>=1 [ … ]`, for the players who choose to make it true",
            ),
        };
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

    /// Reports the rewards that PRISM and PRISM-games have besides those until a target: `C<=k`, `C`,
    /// `I=k`, `S`, `Fc`, `F0` and `F*`.
    pub(super) fn other_rewards(&mut self) -> Parsed<()> {
        let span = self.here();
        let (message, help) = match self.text(span) {
            "Fc" | "F0" => (GAME_REWARDS, "PRISM-games computes them, or write `F condition`"),
            "F" if self.peek_at(1) == Token::Star => {
                (GAME_REWARDS, "PRISM-games computes them, or write `F condition`")
            }
            "C" => (
                "rewards that are accumulated over all steps, or over a number of steps, are not supported",
                "for `C<=k`, count the steps in the model: declare `t : [0..k]`, add `(t'=min(t+1,k))` to each \
                 command, and ask for the rewards until `F t=k`",
            ),
            "I" => (
                "rewards of a single step are not supported",
                "rewards are accumulated until a target: `R{\"name\"}min=? [ F condition ]`",
            ),
            "S" | "LRA" => ("long-run averages are not supported", "PRISM and Storm compute them"),
            _ => return Ok(()),
        };
        self.report(self.unsupported(span, message).label("expected `F condition`").help(help));
        Err(Failed)
    }
}
