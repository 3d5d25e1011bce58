//! Levels of an analysis as sets of states, and ranks over a plane.

use super::{Analysis, Projection, States};
use meliora_base::error::{Error, Result};
use meliora_export::projections::Plane;
use meliora_model::VarId;
use meliora_planning::levels::End;
use meliora_planning::{Kind, Rank};

impl Analysis {
    /// Returns W_k, the states of rank `k` or more: all safe states for `k` = 0; past the last level the fixpoint,
    /// which may be empty.
    ///
    /// ```
    /// # use meliora::{Kind, Model, Options, Settings, SourceFile};
    /// let text = "mdp module m x : [0..3]; [] x<3 -> (x'=x+1); [] x=3 -> true; endmodule";
    /// let wishes = SourceFile::new("wishes", "objective A = F x=1; objective B = F x=3; prefer B > A;");
    /// let mut found = Model::parse(text, "")?.explore(Settings::default())?.prefer(&wishes, Options::default())?;
    /// found.run(&mut |_| ())?;
    /// for k in 0..4 {
    ///     let exactly = found.at_least(Kind::Sasi, k)?.difference(&found.at_least(Kind::Sasi, k + 1)?)?;
    ///     assert_eq!(found.exactly(Kind::Sasi, k)?.count()?, exactly.count()?);
    /// }
    /// assert!(found.unbounded(Kind::Sasi)?.is_some_and(|states| states.is_empty().unwrap_or(false)));
    /// # Ok::<(), meliora::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Usage`] if the level was not searched.
    pub fn at_least(&self, kind: Kind, k: usize) -> Result<States> {
        let Some(index) = k.checked_sub(1) else { return Ok(self.safe_states()) };
        let found = self.level_states(kind);
        match found.get(index) {
            Some(states) => Ok(states.clone()),
            None => self.unbounded(kind)?.ok_or_else(|| {
                Error::Usage(format!("level {k} was not searched: {} are known", found.len()))
            }),
        }
    }

    /// Returns W_k \ W_(k+1), the states of rank `k`.
    ///
    /// # Errors
    /// The errors of [`Analysis::at_least`]; a limit is reached.
    pub fn exactly(&self, kind: Kind, k: usize) -> Result<States> {
        self.at_least(kind, k)?.difference(&self.at_least(kind, k + 1)?)
    }

    /// Returns the states of unbounded rank; `None` if the search ended before it found them.
    ///
    /// # Errors
    /// A limit is reached.
    pub fn unbounded(&self, kind: Kind) -> Result<Option<States>> {
        match &self.levels(kind).end {
            Some(End::Empty) => {
                let all = self.safe_states();
                all.difference(&all).map(Some)
            }
            Some(End::Unbounded(_)) => Ok(self.level_states(kind).pop()),
            Some(End::Cut) | None => Ok(None),
        }
    }

    /// Returns for each cell of a plane the greatest rank of its safe states with the values in `fixed`, next to the
    /// projection of these states; `None` for a cell without them. Cost: one [`States::projection`] per level.
    ///
    /// # Errors
    /// The errors of [`States::projection`].
    pub fn greatest_ranks(
        &self,
        kind: Kind,
        plane: Plane,
        fixed: &[(VarId, i64)],
    ) -> Result<(Projection, Vec<Option<Rank>>)> {
        let scope = self.safe_states().projection(plane, fixed)?;
        let mut ranks: Vec<Option<Rank>> =
            scope.cells.iter().map(|&there| there.then_some(Rank::Finite(0))).collect();
        let found = self.level_states(kind);
        let unbounded = matches!(self.levels(kind).end, Some(End::Unbounded(_)));
        for (index, level) in found.iter().enumerate() {
            let is_last = index + 1 == found.len();
            let rank = if unbounded && is_last { Rank::Unbounded } else { Rank::Finite(index + 1) };
            let projection = level.projection(plane, fixed)?;
            for (cell, _) in ranks.iter_mut().zip(projection.cells).filter(|(_, there)| *there) {
                *cell = Some(rank);
            }
        }
        Ok((scope, ranks))
    }
}
