//! The sets of a dump, and the basic conditions that they are checked against.

use std::sync::Arc;

use super::Checked;
use super::condition::Condition;
use super::error::{CheckError, CheckResult};
use super::sets::Sets;
use super::trends::Trends;
use meliora_dump::bounds::Row;
use meliora_dump::manifest::RootKind;
use meliora_dump::{Dump, Manifest};
use meliora_engine::symbolic::{ChoiceSet, Encoding, StateSet, SymbolicEngine};
use meliora_engine::{Algebra, Engine, Settings};
use meliora_model::Program;
use meliora_model::preference::Preferences;
use meliora_model::region::RegionName;

/// The sets of a dump, over an engine that has built only the transition relations.
pub(super) struct Checker<'a> {
    pub(super) engine: SymbolicEngine,
    /// The engines with only the edges of one trend, where the proof uses it.
    trends: Trends,
    pub(super) preferences: &'a Preferences,
    pub(super) manifest: &'a Manifest,
    /// The regions: each set is defined by model, preferences and options.
    pub(super) regions: Sets,
    /// The certificate: the sets that prove the regions correct.
    pub(super) proof: Sets,
    /// The bounds of quantities.
    pub(super) values: Option<&'a [Row]>,
    pub(super) checked: Vec<Checked>,
    /// The regions that the certificate does not prove; it says so.
    pub(super) uncertified: Vec<String>,
}

/// A round of states that are lost for the same reason.
pub(super) struct Round<'a> {
    pub(super) number: usize,
    /// The states that it removes.
    pub(super) lost: &'a StateSet,
    /// The states that were not lost before.
    pub(super) left: &'a StateSet,
    /// The states that are left after it.
    pub(super) rest: &'a StateSet,
    /// The engine whose edges into the round itself count as losing; none if none do.
    pub(super) within: Option<&'a SymbolicEngine>,
}

/// A layer of states after the first one.
pub(super) struct Layer<'a> {
    pub(super) states: &'a StateSet,
    /// The states of earlier layers.
    pub(super) earlier: &'a StateSet,
    /// These and the states of the layer.
    pub(super) until: &'a StateSet,
    /// The engine whose edges into the layer itself count; none if none do.
    pub(super) within: Option<&'a SymbolicEngine>,
}

impl<'a> Checker<'a> {
    /// Rebuilds the relations over the dumped states and loads all sets.
    pub(super) fn new(
        program: &Arc<Program>,
        preferences: &'a Preferences,
        dump: &'a Dump,
        settings: Settings,
    ) -> CheckResult<Self> {
        let manifest = &dump.manifest;
        let Some(order) = Encoding::order_of(program, &manifest.encoding.order) else {
            return Err(CheckError::violated(Condition::Order, None));
        };
        let root = manifest.regions.root("reachable").filter(|r| r.kind == RootKind::States);
        let Some(all) = root.map(|r| r.node) else {
            return Err(CheckError::violated(Condition::HasReachable, None));
        };
        let (Some(file), Some(certificate)) = (&manifest.certificate, &dump.certificate) else {
            return Err(CheckError::violated(Condition::HasCertificate, None));
        };
        let engine = SymbolicEngine::with_states(Arc::clone(program), order, settings, &dump.regions, all)?;
        let regions = Sets::load(&engine, &manifest.regions, &dump.regions)?;
        let proof = Sets::load(&engine, file, certificate)?;
        let (trends, values) = (Trends::new(&engine, manifest)?, dump.values.as_deref());
        let (checked, uncertified) = (Vec::new(), file.uncertified.clone());
        Ok(Checker { engine, trends, preferences, manifest, regions, proof, values, checked, uncertified })
    }

    /// Returns whether the certificate does not prove some region of a sort.
    pub(super) fn lacks(&self, is_meant: impl Fn(&RegionName) -> bool) -> bool {
        self.uncertified.iter().any(|name| is_meant(&RegionName::from(name.as_str())))
    }

    /// Records that a region has passed its checks.
    pub(super) fn passed(&mut self, region: &RegionName) {
        self.checked.push(Checked { region: region.to_string(), inside: true, outside: true });
    }

    /// Checks X ⊆ Y; a violation shows a state of X \ Y.
    pub(super) fn subset(&self, x: &StateSet, y: &StateSet, condition: Condition) -> CheckResult {
        let bad = self.engine.difference(x, y)?;
        if self.engine.is_empty(&bad)? {
            return Ok(());
        }
        let example = self.engine.list_states(&bad, 1)?.pop();
        Err(CheckError::violated(condition, example))
    }

    /// Checks X = Y.
    pub(super) fn equal(&self, x: &StateSet, y: &StateSet, condition: Condition) -> CheckResult {
        self.subset(x, y, condition.clone())?;
        self.subset(y, x, condition)
    }

    /// Checks C = D.
    pub(super) fn equal_choices(&self, c: &ChoiceSet, d: &ChoiceSet, condition: Condition) -> CheckResult {
        for (more, less) in [(c, d), (d, c)] {
            let bad = self.engine.sources(&self.engine.difference(more, less)?)?;
            self.subset(&bad, &self.engine.no_states(), condition.clone())?;
        }
        Ok(())
    }

    /// Checks that the layers of a region are a partition of it, and that each state has a way to
    /// layer 0, which is `start`. `leading` returns the states of a layer with a step that the layer
    /// needs: into an earlier one or, if it has a trend, by a step of the trend into the layer itself.
    /// Paths of such steps end, so they leave the layer.
    pub(super) fn layers(
        &self,
        name: &RegionName,
        region: &StateSet,
        start: &StateSet,
        leading: &dyn Fn(&Layer<'_>) -> CheckResult<StateSet>,
    ) -> CheckResult {
        let engine = &self.engine;
        let (mut open, mut earlier) = (region.clone(), engine.no_states());
        for (j, (layer, trend)) in self.proof.sequence(|j| name.layer(j))?.iter().enumerate() {
            self.some(layer, Condition::LayerNotEmpty { layer: j, region: name.clone() })?;
            let condition = Condition::LayerNew { layer: j, region: name.clone() };
            self.subset(layer, &open, condition)?;
            let until = engine.union(&earlier, layer)?;
            if j == 0 {
                let condition = Condition::FirstLayer { region: name.clone() };
                self.equal(layer, &engine.intersection(start, region)?, condition)?;
                if trend.is_some() {
                    let condition = Condition::FirstLayerTrend { region: name.clone() };
                    return Err(CheckError::violated(condition, None));
                }
            } else {
                let within = trend.map(|trend| self.trends.of_layer(trend)).transpose()?;
                let found = leading(&Layer { states: layer, earlier: &earlier, until: &until, within })?;
                let condition = match trend {
                    None => Condition::LayerLeads { layer: j, region: name.clone() },
                    Some(trend) => {
                        Condition::LayerLeadsByTrend { layer: j, region: name.clone(), trend: trend.name() }
                    }
                };
                self.subset(layer, &found, condition)?;
            }
            open = engine.difference(&open, layer)?;
            earlier = until;
        }
        let condition = Condition::InSomeLayer { region: name.clone() };
        self.subset(&open, &engine.no_states(), condition)
    }

    /// Returns the states of a layer in which we can choose a step that leads on: into an earlier layer,
    /// or by a step of the layer's trend into the layer itself. `into(E, X)` returns the choices of the
    /// layer with a step into X by an edge of the engine E, and those that win at once.
    pub(super) fn leading(
        &self,
        layer: &Layer<'_>,
        into: &dyn Fn(&SymbolicEngine, &StateSet) -> CheckResult<ChoiceSet>,
    ) -> CheckResult<StateSet> {
        let engine = &self.engine;
        let Some(within) = layer.within else { return Ok(engine.can_choose(&into(engine, layer.earlier)?)?) };
        let on = into(within, layer.until)?;
        let found = engine.can_choose(&on)?;
        if engine.is_empty(&engine.difference(layer.states, &found)?)? {
            return Ok(found);
        }
        // Some choices of a state of the opponent may lead on by a step of the trend, and others by any
        // step into an earlier layer.
        Ok(engine.can_choose(&engine.union(&on, &into(engine, layer.earlier)?)?)?)
    }

    /// Checks that layers of a region lead to a target by given choices.
    pub(super) fn leading_to(
        &self,
        name: &RegionName,
        region: &StateSet,
        target: &StateSet,
        choices: &ChoiceSet,
    ) -> CheckResult {
        self.layers(name, region, target, &|layer| {
            let own = self.engine.choices_in(choices, layer.states)?;
            self.leading(layer, &|by, x| Ok(by.pre(&own, x)?))
        })
    }

    /// Checks the rounds that remove states from X. Each round is non-empty and disjoint from
    /// earlier rounds. Calls `check` with each round. Returns the rest of X after the last round.
    pub(super) fn rounds(
        &self,
        name: &RegionName,
        x: &StateSet,
        check: &dyn Fn(&Round<'_>) -> CheckResult,
    ) -> CheckResult<StateSet> {
        let mut left = x.clone();
        for (number, (lost, trend)) in self.proof.sequence(|j| name.round(j))?.iter().enumerate() {
            let within = trend.map(|trend| self.trends.of_round(trend)).transpose()?;
            self.some(lost, Condition::RoundNotEmpty { round: number, region: name.clone() })?;
            let condition = Condition::RoundNew { round: number, region: name.clone() };
            self.subset(lost, &left, condition)?;
            let rest = self.engine.difference(&left, lost)?;
            check(&Round { number, lost, left: &left, rest: &rest, within })?;
            left = rest;
        }
        Ok(left)
    }

    /// Checks X ≠ ∅.
    fn some(&self, x: &StateSet, condition: Condition) -> CheckResult {
        if self.engine.is_empty(x)? { Err(CheckError::violated(condition, None)) } else { Ok(()) }
    }

    /// Checks the states and the enabled choices. All values are in range; the states are all
    /// valuations, or the states reachable from the start states and closed under all choices.
    pub(super) fn scope(&mut self) -> CheckResult {
        let engine = &self.engine;
        let all = self.regions.states(&RegionName::Reachable)?;
        self.subset(&all, &engine.valuations(), Condition::InRange)?;
        for (name, x) in self.regions.all_states().chain(self.proof.all_states()) {
            self.subset(x, &all, Condition::IsReachable { name: name.clone() })?;
        }
        let initial = engine.initial_states();
        let is_proved = !self.lacks(|name| *name == RegionName::Reachable);
        if let Some(start) = engine.beginnings()? {
            self.subset(&start, &all, Condition::HasStart)?;
            let next = engine.post(&engine.all_choices())?;
            self.subset(&next, &all, Condition::HasSuccessors)?;
            if is_proved {
                self.layers(&RegionName::Reachable, &all, &start, &|layer| {
                    let (by, from) = layer.within.map_or((engine, layer.earlier), |by| (by, layer.until));
                    Ok(by.post(&engine.choices_in(&engine.all_choices(), from)?)?)
                })?;
            }
        } else {
            self.equal(&all, &engine.valuations(), Condition::AllValuations)?;
        }
        self.equal(&self.regions.states(&RegionName::Initial)?, &initial, Condition::Initial)?;
        let condition = Condition::EnabledChoices;
        self.equal_choices(&self.regions.choices(&RegionName::Choices)?, &engine.all_choices(), condition)?;
        let condition = Condition::Deadlocks;
        self.equal(&self.regions.states(&RegionName::Deadlock)?, &engine.deadlock_states(), condition)?;
        self.checked.push(Checked {
            region: RegionName::Reachable.to_string(),
            inside: is_proved,
            outside: true,
        });
        for name in [RegionName::Initial, RegionName::Deadlock, RegionName::Choices] {
            self.passed(&name);
        }
        self.players()
    }

    /// Checks the states of each player of a game.
    fn players(&mut self) -> CheckResult {
        let program = Arc::clone(self.engine.program());
        let players = program.players.iter().flat_map(|players| &players.list);
        for (player, states) in players.zip(self.engine.player_states()) {
            let name = RegionName::Player(player.name.clone());
            let condition = Condition::PlayerStates { region: name.clone() };
            self.equal(&self.regions.states(&name)?, &states, condition)?;
            self.passed(&name);
        }
        Ok(())
    }

    /// Returns the choices of the states in which the opponent does not choose; strategies have no
    /// others.
    pub(super) fn ours(&self, c: &ChoiceSet) -> CheckResult<ChoiceSet> {
        let Some(theirs) = self.engine.theirs() else { return Ok(c.clone()) };
        let ours = self.engine.difference(&self.engine.all_states(), &theirs)?;
        Ok(self.engine.choices_in(c, &ours)?)
    }

    /// Checks the counts that the manifest states for both files.
    pub(super) fn counts(&self) -> CheckResult {
        let proof = self.manifest.certificate.iter().flat_map(|file| &file.roots);
        let regions = self.manifest.regions.roots.iter().map(|root| (root, &self.regions));
        for (root, sets) in regions.chain(proof.map(|root| (root, &self.proof))) {
            let count = sets.count(&self.engine, root)?;
            let found = count.to_string();
            if found != root.count {
                let (name, said) = (root.name.clone(), root.count.clone());
                let condition = Condition::Members { name, said, found };
                return Err(CheckError::violated(condition, None));
            }
        }
        Ok(())
    }

    /// Checks that each set of both files was used by some check, except for regions without a proof.
    pub(super) fn nothing_else(&self) -> CheckResult {
        let regions = &self.manifest.regions;
        if let Some(name) = self.uncertified.iter().find(|name| regions.root(name).is_none()) {
            let condition = Condition::UncertifiedRegion { name: name.clone() };
            return Err(CheckError::violated(condition, None));
        }
        let others = self.regions.unknown().find(|name| !self.uncertified.contains(name));
        match others.or_else(|| self.proof.unknown().next()) {
            None => Ok(()),
            Some(name) => Err(CheckError::violated(Condition::NothingElse { name: name.clone() }, None)),
        }
    }
}
