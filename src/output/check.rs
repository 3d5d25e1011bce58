//! The report of `meliora check`.

use serde::Serialize;
use serde_json::{Map, Value as Json};

use super::envelope::{Envelope, Findings, Time};
use super::report::{Counts, ModelSummary, json_state};
use super::{Number, Style, check_text};
use crate::engine::{Count, Scope};
use crate::model::Program;
use crate::model::preference::{ObjectiveSet, Preferences};
use crate::planning::result::{ClassCount, LevelCounts, LevelsEnd, ObjectiveCounts, Prospects};
use crate::planning::{AnalysisResult, Kind, Rank};

/// The results of `check`, in the order of the JSON fields.
#[derive(Debug, Clone, Serialize)]
pub struct CheckFindings {
    /// The model.
    pub model: ModelSummary,
    /// The preference file as the user named it.
    #[serde(skip)]
    pub preferences: String,
    /// The name of the engine.
    pub engine: &'static str,
    /// The valuations that are states.
    pub scope: Scope,
    /// The name of the safety filter.
    pub safety: &'static str,
    /// The value of nothing: the `empty` statement of the preferences.
    pub empty: Option<&'static str>,
    /// The history that objectives judge; present only if it is the whole path.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub history: Option<&'static str>,
    /// Sizes of the model.
    pub counts: Option<Counts>,
    /// The decided objectives, in the order of declaration.
    pub objectives: Vec<ObjectiveReport>,
    /// The classes that occur.
    pub classes: Option<Vec<ClassReport>>,
    /// Sizes of the improvement MDP; `None` with `--safety prefix`.
    pub improvement: Option<ImprovementReport>,
    /// Almost-sure improvements.
    pub sasi: Option<LevelsReport>,
    /// Improvements of positive probability.
    pub spi: Option<LevelsReport>,
    /// The first initial states.
    pub initial: Vec<InitialReport>,
}

/// The report with times and memory.
pub type CheckReport = Envelope<CheckFindings>;

/// The regions of one objective.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ObjectiveReport {
    /// Its name.
    pub name: String,
    /// Number of target states; for a temporal objective, of the states in which it is secured.
    pub target: Number,
    /// Number of states of its monitor, if it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub observer: Option<u64>,
    /// Number of states from which some strategy achieves it almost surely.
    pub almost_sure: Number,
    /// Number of states from which some strategy achieves it with positive probability.
    pub positive: Number,
}

/// One class of states.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ClassReport {
    /// The most preferred objectives, in the order of declaration; empty for `nothing`.
    pub most_preferred: Vec<String>,
    /// Number of states in the class.
    pub states: Number,
}

/// Sizes of the improvement MDP.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ImprovementReport {
    /// Twice the states of the scope.
    pub states: Number,
    /// Twice the kept transitions.
    pub transitions: Number,
    /// The transitions of the model that were not kept.
    pub dropped: Number,
}

/// The sizes of the winning regions.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct LevelsReport {
    /// The sizes, strictly decreasing; the last is that of the fixpoint where it is not empty.
    pub levels: Vec<Number>,
    /// The size of the fixpoint; `None` if `--max-level` or a limit ended the search before it.
    pub unbounded: Option<Number>,
}

/// The results for one initial state.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InitialReport {
    /// Its values by variable.
    pub state: Map<String, Json>,
    /// The most preferred objectives that are sure there.
    pub most_preferred: Vec<String>,
    /// Number of improvements that are guaranteed (SASI rank).
    pub sasi_rank: Option<Rank>,
    /// Number of improvements that are possible (SPI rank).
    pub spi_rank: Option<Rank>,
    /// The actions that the permissive SASI strategy allows there.
    pub sasi_actions: Option<Vec<String>>,
    /// The actions that the permissive SPI strategy allows there.
    pub spi_actions: Option<Vec<String>>,
}

/// Seconds by phase; `None` for an unfinished phase.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct CheckTime {
    /// Reading the model and the preferences.
    pub parse: Option<f64>,
    /// Encoding the model and finding the reachable states.
    pub build: Option<f64>,
    /// The regions of the objectives.
    pub outcomes: Option<f64>,
    /// Classes and improvement MDP.
    pub improvement: Option<f64>,
    /// The SASI levels.
    pub sasi: Option<f64>,
    /// The SPI levels.
    pub spi: Option<f64>,
    /// Everything.
    pub total: f64,
}

impl Time for CheckTime {
    fn total(&mut self) -> &mut f64 {
        &mut self.total
    }
}

impl CheckReport {
    /// Creates a report without results.
    pub fn new(
        model: &str,
        preferences: &str,
        engine: &'static str,
        scope: Scope,
        safety: &'static str,
    ) -> Self {
        Envelope::of(CheckFindings {
            model: ModelSummary::of_path(model),
            preferences: preferences.to_owned(),
            engine,
            scope,
            safety,
            empty: None,
            history: None,
            counts: None,
            objectives: Vec::new(),
            classes: None,
            improvement: None,
            sasi: None,
            spi: None,
            initial: Vec::new(),
        })
    }
}

impl CheckFindings {
    /// Adds a decided objective, in the order of declaration.
    pub fn add_objective(&mut self, preferences: &Preferences, counts: &ObjectiveCounts) {
        let position = |name: &str| preferences.objectives.iter().position(|o| o.name == name);
        let new = objective(preferences, counts);
        let place = self.objectives.iter().position(|o| position(&o.name) > Some(counts.objective));
        self.objectives.insert(place.unwrap_or(self.objectives.len()), new);
    }

    /// Adds a level.
    pub fn add_level(&mut self, kind: Kind, count: &Count) {
        let levels = match kind {
            Kind::Sasi => &mut self.sasi,
            Kind::Spi => &mut self.spi,
        };
        levels.get_or_insert_default().levels.push(count.clone().into());
    }

    /// Copies the results of an analysis.
    pub fn fill(&mut self, preferences: &Preferences, result: &AnalysisResult) {
        self.counts = result.counts.as_ref().map(Counts::from);
        self.objectives = result.objectives.iter().map(|o| objective(preferences, o)).collect();
        let class = |c: &ClassCount| ClassReport {
            most_preferred: names(preferences, &c.most_preferred),
            states: c.states.clone().into(),
        };
        self.classes = result.classes.as_ref().map(|list| list.iter().map(class).collect());
        self.improvement = result.improvement.as_ref().map(|sizes| ImprovementReport {
            states: sizes.states.clone().into(),
            transitions: sizes.transitions.clone().into(),
            dropped: sizes.dropped.clone().into(),
        });
        self.sasi = levels(&result.sasi);
        self.spi = levels(&result.spi);
    }

    /// Copies the results for the first initial states.
    pub fn set_initial(&mut self, program: &Program, preferences: &Preferences, prospects: &[Prospects]) {
        let one = |p: &Prospects| InitialReport {
            state: json_state(program, &p.state),
            most_preferred: names(preferences, &p.most_preferred),
            sasi_rank: p.sasi.as_ref().map(|plan| plan.rank),
            spi_rank: p.spi.as_ref().map(|plan| plan.rank),
            sasi_actions: p.sasi.as_ref().map(|plan| plan.actions.clone()),
            spi_actions: p.spi.as_ref().map(|plan| plan.actions.clone()),
        };
        self.initial = prospects.iter().map(one).collect();
    }
}

fn objective(preferences: &Preferences, counts: &ObjectiveCounts) -> ObjectiveReport {
    let declared = preferences.objectives.get(counts.objective);
    ObjectiveReport {
        name: declared.map(|o| o.name.clone()).unwrap_or_default(),
        target: counts.target.clone().into(),
        observer: declared.and_then(|o| o.monitor()),
        almost_sure: counts.almost_sure.clone().into(),
        positive: counts.positive.clone().into(),
    }
}

fn names(preferences: &Preferences, set: &ObjectiveSet) -> Vec<String> {
    preferences.names(set).into_iter().map(str::to_owned).collect()
}

/// Returns the levels of one kind, or `None` if they were not started.
fn levels(counts: &LevelCounts) -> Option<LevelsReport> {
    if counts.levels.is_empty() && counts.end == LevelsEnd::Open {
        return None;
    }
    Some(LevelsReport {
        levels: counts.levels.iter().cloned().map(Number::from).collect(),
        unbounded: counts.unbounded().map(Number::from),
    })
}

impl Findings for CheckFindings {
    const SCHEMA: &str = "meliora.check/1";
    type Time = CheckTime;

    fn text(report: &CheckReport, style: Style) -> String {
        check_text::render(report, style)
    }
}
