//! Shields by value.

use std::sync::Arc;

use super::Model;
use super::kept::Kept;
use meliora_base::error::Result;
use meliora_engine::{AnyEngine, Selection, Settings};
use meliora_planning::Shield;
use meliora_quantities::PRECISION;
use meliora_question::race::{Early, Raced};
use meliora_question::shield::{ShieldQuestion, Threshold};

impl Model {
    /// Computes how safe each action of each state is, and permits those that are safe enough: the shield of a property
    /// such as `Pmin=? [ F "crash" ]` or `Pmax=? [ G !"crash" ]` and a threshold, or of a shield expression
    /// `<name, PreSafety, lambda=0.9> Pmax=? [ G !"crash" ]`, which has one. The safety of an action is the best probability
    /// of the formula after it, for `Pmin` 1 minus it. In a game these hold against every strategy of the opponent.
    ///
    /// ```
    /// use meliora::engine::Selection;
    /// use meliora::question::shield::Threshold;
    /// use meliora::{Model, Settings};
    ///
    /// let model = Model::parse("mdp
    ///     module walk
    ///       x : [0..2] init 0;
    ///       [slow] x=0 -> 0.9: (x'=1) + 0.1: (x'=2);
    ///       [fast] x=0 -> 0.6: (x'=1) + 0.4: (x'=2);
    ///       [stay] x>0 -> true;
    ///     endmodule", "")?;
    /// let threshold = Threshold::parse("0.9", false).unwrap();
    /// let shield = model.shield("Pmin=? [ F x=2 ]", Some(threshold), 100, Selection::open(), Settings::default())?;
    /// assert_eq!(shield.nodes[0].actions[0].permitted, true);
    /// assert_eq!(shield.nodes[0].actions[1].permitted, false);
    /// # Ok::<(), meliora::Error>(())
    /// ```
    ///
    /// # Errors
    /// The errors of [`ShieldQuestion::read`] and [`ShieldQuestion::answer`].
    pub fn shield(
        &self,
        property: &str,
        threshold: Option<Threshold>,
        limit: usize,
        engine: Selection,
        settings: Settings,
    ) -> Result<Shield> {
        let program = self.program();
        let question = ShieldQuestion::read((program, &self.properties), ("property", property), threshold)?;
        let answer = |_: &Kept<()>, engine: &Arc<AnyEngine>| {
            question.answer(engine, program, PRECISION, limit).map(|(shield, _)| shield)
        };
        let kept = Kept::new((), Arc::clone(&settings.sink));
        let settings = &Settings { keeps_choices: true, keeps_probabilities: true, ..settings };
        let early = Early::default();
        Raced { program, settings, selected: engine, lists_states: true, early, answer: &answer }.run(&kept)
    }
}
