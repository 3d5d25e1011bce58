//! Models and preferences written in a test, with the explicit engine.

use crate::common::prelude::*;

pub(crate) struct Loaded {
    pub(crate) program: Arc<Program>,
    pub(crate) preferences: Arc<Preferences>,
    pub(crate) engine: Arc<ExplicitEngine>,
}

impl Loaded {
    pub(crate) fn new(model: &str, preferences: &str) -> Self {
        let (program, preferences) = task(model, preferences);
        let engine = Arc::new(ExplicitEngine::new(program.clone(), Settings::default()).unwrap());
        Loaded { program, preferences, engine }
    }

    /// An analysis of which nothing is computed yet.
    pub(crate) fn fresh(&self, options: Options) -> Analysis<ExplicitEngine> {
        Analysis::new(&self.engine, &self.preferences, options)
    }

    /// The finished analysis.
    pub(crate) fn analyse(&self, safety: Safety, max_level: Option<usize>) -> Analysis<ExplicitEngine> {
        let mut analysis = self.fresh(Options { safety, max_level });
        analysis.run(&mut |_| ()).unwrap();
        analysis
    }
}

/// A model with two random steps, which may take several attempts: from 0 to 1 or 2, from there to
/// 3 or 4. Both outcomes of a step are preferred to those of the step before.
pub(crate) fn ladder() -> Loaded {
    Loaded::new(
        "mdp module m x : [0..4] init 0;\n\
         [] x=0 -> 0.3:(x'=1) + 0.3:(x'=2) + 0.4: true;\n\
         [] x=1 | x=2 -> 0.3:(x'=3) + 0.3:(x'=4) + 0.4: true; endmodule",
        "objective A = F x=1; objective B = F x=2; objective C = F x=3; objective D = F x=4;\n\
         prefer C > A; prefer C > B; prefer D > A; prefer D > B;",
    )
}
