//! The strategies, the bounds and the rewards of operators.

use num_traits::{One, Zero};

use super::check::Checker;
use super::operators::{Asked, Coalition, Extreme, Operator};
use super::question::optimum;
use super::{Inequality, Optimum, Rewards};
use crate::ast::{Expr, Node, NodeKind, Span};
use crate::players;
use meliora_base::error::{Diagnostic, Result};
use meliora_base::exact::{Exact, Ratio, Real};
use meliora_model::ModelKind;

/// The error for a name or a number that no reward structure has.
const UNKNOWN_REWARDS: &str = "unknown reward structure";

/// The strategies that an operator is about.
pub(super) struct Strategies {
    pub(super) coalition: Option<Vec<bool>>,
    pub(super) optimum: Option<Optimum>,
    pub(super) bound: Option<(Inequality, Ratio)>,
}

impl Checker<'_> {
    /// Returns the strategies that a property asks about; for a `dtmc` all have the same value.
    pub(super) fn sure_optimum(&self, strategies: &Strategies, operator: &Operator) -> Result<Optimum> {
        let found = strategies.optimum.or((self.program.kind == ModelKind::Dtmc).then_some(Optimum::Max));
        found.ok_or_else(|| {
            let kind = <&str>::from(self.program.kind);
            let wrong = self.wrong(operator.head, format!("an `{kind}` has a least and a greatest value"));
            let help = "write `Pmin=?` or `Pmax=?`, for rewards `Rmin=?` or `Rmax=?`";
            wrong.label("which one?").help(help).into()
        })
    }

    pub(super) fn known_rewards(&self, rewards: &Rewards, head: Span) -> Result<()> {
        if rewards.find(self.program).is_some() {
            return Ok(());
        }
        let names = self.program.rewards.iter().filter_map(|r| r.name.as_ref());
        let names: Vec<_> = names.map(|name| format!("\"{name}\"")).collect();
        let unnamed = self.program.rewards.len() - names.len();
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
        Err(self.wrong(head, message).label("not in the model").help(help).into())
    }

    /// Returns the strategies and the bound of an operator.
    pub(super) fn strategies(
        &mut self,
        operator: &Operator,
        asked: &Asked,
        is_probability: bool,
    ) -> Result<Strategies> {
        let bound = match &asked.bound {
            None => None,
            Some((comparison, e)) => Some((*comparison, self.bound(e, operator.head, is_probability)?)),
        };
        let (coalition, some) = self.players(operator)?;
        if operator.coalition.is_some()
            && coalition.is_some()
            && bound.is_some()
            && asked.extreme != Extreme::Unnamed
        {
            let wrong = self.wrong(operator.head, "the players of a coalition say who chooses");
            let help = "write `<<p1>> P>=1 [ … ]`, without `min` or `max`, or ask for the value by `=?`";
            return Err(wrong.help(help).into());
        }
        let optimum = optimum(asked.extreme, bound.as_ref().map(|(comparison, _)| *comparison), some);
        Ok(Strategies { coalition, optimum, bound })
    }

    /// Returns the players of a game who choose, and whether a bound without `min` or `max` must hold for
    /// some strategy instead of all.
    fn players(&self, operator: &Operator) -> Result<(Option<Vec<bool>>, bool)> {
        let Some(Coalition { players, opposed, span }) = &operator.coalition else {
            // Without players all choose together, as in an `mdp`.
            let all = self.program.players.as_ref().map(|game| vec![true; game.list.len()]);
            return Ok((all, false));
        };
        let names = players.as_deref().unwrap_or(&[]);
        let Some(game) = &self.program.players else {
            if !names.is_empty() {
                players::coalition(self.program, self.source, names, *span)?;
            }
            // All strategies are those of `*`; nobody has none.
            return Ok((None, *opposed == (players.is_some())));
        };
        let mut coalition = match players {
            None => vec![true; game.list.len()],
            Some(names) => players::coalition(self.program, self.source, names, *span)?,
        };
        if *opposed {
            coalition.iter_mut().for_each(|own| *own = !*own);
        }
        Ok((Some(coalition), true))
    }

    /// Returns the value of a bound.
    fn bound(&mut self, e: &Expr, head: Span, is_probability: bool) -> Result<Ratio> {
        let wrong = |message: String| Diagnostic::new(self.source, e.span().range(), message);
        let help = "a bound is a number or a constant, as in `P>=0.5` or `P>=p`";
        let value = match self.constant(e)? {
            Some(Exact::Int(value)) => Ratio::from_integer(value.into()),
            Some(Exact::Real(Real::Finite(value))) => value,
            _ => {
                let what = match e.nodes.as_slice() {
                    [Node { kind: NodeKind::Name(name), .. }] => format!("the constant `{name}`"),
                    _ => "the bound".to_owned(),
                };
                return Err(wrong(format!("{what} is not a finite number")).help(help).into());
            }
        };
        if is_probability && (value > Ratio::one() || value < Ratio::zero()) {
            let (size, value) = (value > Ratio::one(), Real::Finite(value));
            let label = if size { "greater than 1" } else { "less than 0" };
            let diagnostic = self.wrong(head, format!("{value} is not a probability"));
            return Err(diagnostic.label(label).help("a probability is a number from 0 to 1").into());
        }
        Ok(value)
    }
}
