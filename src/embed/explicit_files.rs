//! Models state by state, for other programs.

use std::str::FromStr;
use std::sync::Arc;

use super::dump_files::DumpValues;
use super::results::strategy_of;
use meliora_base::error::Result;
use meliora_engine::Engine;
use meliora_export::bounds::{self, Wanted};
use meliora_export::explicit::{
    Graph, Quantities, action_table, drn, explored, induced, prism, refuse_drn, umb,
};
use meliora_model::Program;
use meliora_planning::{Analysis, Scheduler, StrategyKind};
use meliora_quantities::Values;
use meliora_quantities::choose::LEVELS;

/// The strategy whose induced model is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Induced {
    /// The kind of the strategy.
    pub kind: StrategyKind,
    /// The permitted actions that it takes.
    pub scheduler: Scheduler,
}

impl FromStr for Induced {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let (kind, scheduler) = text.split_once(':').unwrap_or((text, Scheduler::Permissive.name()));
        let wrong =
            || "expected a kind of strategy, such as `sasi`, or with a scheduler `sasi:progress`".to_owned();
        let (kind, scheduler) = (kind.parse().map_err(|_| wrong())?, scheduler.parse().map_err(|_| wrong())?);
        Ok(Induced { kind, scheduler })
    }
}

impl Induced {
    /// Returns the name of the induced model: `sasi:progress`.
    pub fn name(self) -> String {
        format!("{}:{}", self.kind.name(), self.scheduler.name())
    }
}

/// The format of the files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ExplicitFormat {
    /// PRISM's `.tra`, `.sta` and `.lab`
    Explicit,
    /// Storm's `.drn`
    Drn,
    /// UMB's `.umb`
    Umb,
}

impl ExplicitFormat {
    /// All formats.
    pub const ALL: &[ExplicitFormat] = &[ExplicitFormat::Explicit, ExplicitFormat::Drn, ExplicitFormat::Umb];

    /// Returns its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            ExplicitFormat::Explicit => "explicit",
            ExplicitFormat::Drn => "drn",
            ExplicitFormat::Umb => "umb",
        }
    }
}

impl FromStr for ExplicitFormat {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let found = ExplicitFormat::ALL.iter().copied().find(|format| format.name() == text);
        found.ok_or_else(|| "expected `explicit`, `drn` or `umb`".to_owned())
    }
}

/// The files that are wanted.
#[derive(Debug, Clone)]
pub struct ExplicitFiles {
    /// The format.
    pub format: ExplicitFormat,
    /// The strategy whose induced model is written; `None` for the model itself.
    pub strategy: Option<Induced>,
    /// The objective of the strategy.
    pub objective: Option<String>,
    /// The maximum number of states.
    pub limit: usize,
}

impl ExplicitFiles {
    /// Refuses a format that has no games, for a game.
    ///
    /// # Errors
    /// The format has no games.
    pub fn refuse_game(&self, program: &Program) -> Result<()> {
        // The progress strategy leaves an mdp of the opponent's choices.
        let is_mdp = self.strategy.is_some_and(|strategy| strategy.scheduler == Scheduler::Progress);
        if self.format == ExplicitFormat::Drn && !is_mdp { refuse_drn(program) } else { Ok(()) }
    }

    /// Lists the states of the model, or of the induced model. Cost: one step of the model per state.
    ///
    /// # Errors
    /// The objective does not fit the strategy; there are more states than the limit; another limit.
    pub fn graph<E: Engine>(&self, analysis: &Analysis<E>, program: &Arc<Program>) -> Result<Graph> {
        let Some(Induced { kind, scheduler }) = self.strategy else {
            return explored(analysis, program, self.limit);
        };
        let objectives = kind.objectives(analysis.preferences(), self.objective.as_deref())?;
        let mut strategy = strategy_of(analysis, program, kind, kind.levels(), &objectives)?;
        induced(analysis, program, &mut strategy, scheduler, self.limit)
    }

    /// Computes the values of the states.
    ///
    /// # Errors
    /// A reward is wrong in some state; a limit is reached.
    pub fn values<E: Engine>(
        &self,
        analysis: &Analysis<E>,
        program: &Program,
        graph: &Graph,
        DumpValues { levels, reward, costs, limit, .. }: DumpValues<'_>,
    ) -> Result<Quantities> {
        let costs = costs.check(analysis.engine(), program)?;
        let levels = levels.unwrap_or_else(|| Values::levels_found(analysis, LEVELS));
        let wanted = Wanted { levels, reward, costs: &*costs, limit };
        Ok(Quantities::of(graph, &bounds::compute(analysis, program, &wanted)?, &wanted))
    }

    /// Returns the names of the files, in the order of [`ExplicitFiles::contents`].
    pub fn names(&self) -> Vec<String> {
        let stem = self.strategy.map_or("model".to_owned(), |s| s.name().replace(':', "-"));
        let table = self.strategy.map(|_| "csv");
        let formats: &[&str] = match self.format {
            ExplicitFormat::Drn => &["drn"],
            ExplicitFormat::Umb => &["umb"],
            ExplicitFormat::Explicit => &["tra", "sta", "lab"],
        };
        formats.iter().copied().chain(table).map(|extension| format!("{stem}.{extension}")).collect()
    }

    /// Returns the contents of the files.
    ///
    /// # Errors
    /// The format has no games; a limit is reached.
    pub fn contents<E: Engine>(
        &self,
        graph: &Graph,
        analysis: &Analysis<E>,
        program: &Program,
        quantities: Option<&Quantities>,
    ) -> Result<Vec<Vec<u8>>> {
        let mut contents = match self.format {
            ExplicitFormat::Drn => {
                vec![drn(graph, program, &*analysis.engine().settings().sink)?.into_bytes()]
            }
            ExplicitFormat::Umb => vec![umb(graph, analysis, program, quantities)?],
            ExplicitFormat::Explicit => {
                let all = prism(graph);
                [all.tra, all.sta, all.lab].map(String::into_bytes).into()
            }
        };
        contents.extend(self.strategy.map(|_| action_table(graph).into_bytes()));
        Ok(contents)
    }
}
