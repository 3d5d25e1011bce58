//! Features that meet: every test draws cases with all features of models and preferences together.

mod agreement;
#[allow(dead_code, reason = "each program takes a part")]
#[path = "../common/amount.rs"]
mod amount;
mod certificates;
#[path = "../common/coverage.rs"]
mod coverage;
#[path = "../common/graphs.rs"]
mod graphs;
mod joint;
mod likely;
mod plans;
mod promises;
#[path = "../common/random_case.rs"]
mod random_case;
mod stopping;
mod together;
mod values;

use std::sync::Arc;

use meliora::engine::{AnyEngine, Engine, Order, Settings, Storage};
use meliora::model::preference::Preferences;
use meliora::model::{Program, State};
use meliora::planning::{Analysis, FiniteMemoryStrategy, Options, Safety, StrategyKind};

use random_case::RandomCase;

/// Settings for each engine, and for the symbolic one with the declared order.
fn settings(case: &RandomCase) -> [Settings; 3] {
    let one = |storage| Settings { scope: case.scope, storage, memory: 16 << 20, ..Settings::default() };
    let declared = Settings { order: Order::Declared, ..one(Storage::Symbolic) };
    [one(Storage::Symbolic), one(Storage::Explicit), declared]
}

/// A finished analysis with its program.
struct Analysed {
    program: Arc<Program>,
    analysis: Analysis,
}

impl Analysed {
    fn new(
        (program, preferences): (&Arc<Program>, &Arc<Preferences>),
        settings: Settings,
        safety: Safety,
    ) -> Self {
        let engine = AnyEngine::new(Arc::clone(program), settings).unwrap();
        let mut analysis = Analysis::new(&Arc::new(engine), preferences, Options { safety, max_level: None });
        analysis.run(&mut |_| ()).unwrap();
        Analysed { program: Arc::clone(program), analysis }
    }

    /// The analyses of a case by all engines.
    fn all(case: &RandomCase) -> [Self; 3] {
        let (program, preferences) = case.load();
        let given = (&program, &preferences);
        settings(case).map(|settings| Self::new(given, settings, case.safety))
    }

    /// The states of the scope, unsafe ones included.
    fn states(&self) -> Vec<State> {
        let engine = self.analysis.whole_engine();
        engine.list_states(&engine.all_states(), usize::MAX).unwrap()
    }

    /// The states from which the requirements can be kept.
    fn safe_states(&self) -> Vec<State> {
        let mut states = self.states();
        states.retain(|state| !self.analysis.is_unsafe(state).unwrap());
        states
    }

    fn strategy(&self, kind: StrategyKind, objective: Option<usize>) -> FiniteMemoryStrategy {
        let strategy =
            FiniteMemoryStrategy::of_kind(&self.analysis, &self.program, kind, kind.levels(), objective);
        strategy.unwrap().unwrap()
    }

    /// The strategies of all kinds.
    fn strategies(&self) -> Vec<FiniteMemoryStrategy> {
        let of = |kind| self.strategy(kind, None);
        let mut all: Vec<_> = [StrategyKind::Sasi, StrategyKind::Spi, StrategyKind::Plan].map(of).into();
        let objectives = 0..self.analysis.preferences().objectives.len();
        all.extend(objectives.map(|o| self.strategy(StrategyKind::Achieve, Some(o))));
        all
    }
}
