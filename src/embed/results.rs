//! Methods of an analysis for owned sets and strategies.

use std::sync::Arc;

use super::{Analysis, Exploration, States};
use meliora_base::error::{Error, Result};
use meliora_engine::{AnyEngine, Engine};
use meliora_model::Program;
use meliora_model::preference::ObjectiveSet;
use meliora_model::region::RegionName;
use meliora_planning as planning;
use meliora_planning::joint::{Joint, MOST, is_too_large};
use meliora_planning::regions::regions;
use meliora_planning::{Class, FiniteMemoryStrategy, Kind, StrategyKind};
use meliora_quantities::Choose;

/// The most preferred objectives of a class, and the sets of them that are achieved together.
type JointlyAchieved = (Vec<String>, Vec<(Vec<String>, States)>);

impl Analysis {
    /// Returns the states that are analysed: the explored ones, or with `history = play` those of
    /// the product with the monitors. Unsafe states are among them.
    pub fn exploration(&self) -> Exploration {
        Exploration::new(AnyEngine::clone(self.whole_engine()), self.named.clone())
    }

    /// Returns the states that are analysed without the unsafe ones: those of the classes.
    pub fn safe_states(&self) -> States {
        States::new(self.whole_engine(), self.engine().all_states())
    }

    /// Returns the program, with the targets of the preferences.
    pub fn program(&self) -> &Arc<Program> {
        self.engine().program()
    }

    /// Returns the names of the regions known so far: `unsafe` (under requirements), `target:A`, `almost-sure:A`, `positive:A`,
    /// `class:A+B`, `bad` (of a game), `sasi:1`, …
    pub fn region_names(&self) -> Vec<String> {
        regions(self).into_iter().map(|(name, _)| name.to_string()).collect()
    }

    /// Returns the region with a name, if it is known.
    pub fn region(&self, name: impl Into<RegionName>) -> Option<States> {
        let name = name.into();
        let (_, set) = regions(self).into_iter().find(|(own, _)| *own == name)?;
        Some(States::new(self.whole_engine(), set.clone()))
    }

    /// Returns the states of the levels W_1 ⊋ W_2 ⊋ … of one kind that are known.
    pub fn level_states(&self, kind: Kind) -> Vec<States> {
        let found = &self.levels(kind).found;
        found.iter().map(|level| States::new(self.whole_engine(), level.states.clone())).collect()
    }

    /// Computes which sets of at least two most preferred objectives of each class one strategy
    /// achieves together, almost surely: the objectives of the class, and each set with the states of
    /// the class from which it is achieved, larger sets first. Cost: see `Joint::new`.
    ///
    /// # Errors
    /// The errors of `Joint::new`; [`Error::Usage`] if a class has more than 10 most preferred
    /// objectives.
    pub fn jointly(&self) -> Result<Vec<JointlyAchieved>> {
        let names = |set: &ObjectiveSet| self.preferences().owned_names(set);
        let classes = || self.classes().into_iter().flat_map(|classes| &classes.list);
        if let Some(large) = classes().find(|class| is_too_large(&class.most_preferred)) {
            return Err(Error::Usage(format!(
                "sets of jointly achieved objectives are computed for classes of at most {MOST} objectives; \
                 this one has more: {}",
                names(&large.most_preferred).join(", ")
            )));
        }
        let joint = Joint::new(self)?;
        let of_class = |class: &Class<AnyEngine>| {
            let sets = joint.of_class(self.engine(), class)?.into_iter().flatten();
            let sets = sets.map(|(set, states)| (names(&set), States::new(self.whole_engine(), states)));
            Ok((names(&class.most_preferred), sets.collect()))
        };
        classes().map(of_class).collect()
    }

    /// Returns the strategies of one kind, which do not borrow from the analysis.
    ///
    /// # Errors
    /// [`Error::Usage`] before the levels of this kind were computed.
    pub fn strategy(&self, kind: Kind) -> Result<FiniteMemoryStrategy> {
        let missing = || Error::Usage("strategies need the levels; run the analysis first".to_owned());
        FiniteMemoryStrategy::new(self, self.program(), kind).ok_or_else(missing)
    }

    /// Returns the strategy of a kind, before values are attached to it. [`StrategyKind::Achieve`]
    /// needs the name of an objective, or several as `C,D`, and [`StrategyKind::Plan`] accepts one. Cost:
    /// one pre-image per objective; for several, one almost-sure fixpoint per subset.
    ///
    /// # Errors
    /// [`Error::Usage`] if the objective does not fit, or before the levels of this kind were computed;
    /// a limit is reached.
    pub fn strategy_of(
        &self,
        kind: StrategyKind,
        choose: Choose,
        objectives: Option<&str>,
    ) -> Result<FiniteMemoryStrategy> {
        let objectives = kind.objectives(self.preferences(), objectives)?;
        strategy_of(self, self.program(), kind, choose.levels(kind), &objectives)
    }
}

/// Returns the strategy of an analysis whose levels are known; see [`Analysis::strategy_of`].
///
/// # Errors
/// The errors of [`Analysis::strategy_of`].
pub fn strategy_of<E: Engine>(
    analysis: &planning::Analysis<E>,
    program: &Arc<Program>,
    kind: StrategyKind,
    levels: Kind,
    objectives: &ObjectiveSet,
) -> Result<FiniteMemoryStrategy<E>> {
    let missing = || Error::Usage(format!("the levels of {levels} are not known; run the analysis first"));
    FiniteMemoryStrategy::of_kind(analysis, program, kind, levels, objectives.iter())?.ok_or_else(missing)
}
