//! Properties of a model, answered as the command does.

use std::sync::Arc;

use super::Model;
use super::kept::Kept;
#[cfg(feature = "output")]
use super::policy_text::{PolicyForm, whole_text, write_opponent, write_policy};
use super::questions::{Properties, Terms};
use meliora_base::error::{Error, Limit, Result};
use meliora_engine::{Selection, Settings, Usage};
use meliora_model::Program;
use meliora_quantities::PRECISION;
use meliora_question::answers::OneQuestion;
use meliora_question::{Answers, Options, Questions, Strategies, WantedStrategies, Warning, pipeline};

/// Requirements and wishes next to properties, and the engine that answers these.
#[derive(Debug, Clone)]
pub struct Ask {
    /// Safe formulas that every strategy must keep: `G p`.
    pub require: Vec<String>,
    /// The states behind those that decide the only question are not explored; the answer is the same.
    pub stops_at_target: bool,
    /// The largest width of a number, relative to the number above 1.
    pub precision: f64,
    /// The strategies that are wanted of the only property.
    pub strategies: WantedStrategies,
    /// The engine; [`Selection::open`] lets several ways race.
    pub engine: Selection,
}

impl Default for Ask {
    fn default() -> Self {
        let (require, stops_at_target, strategies) = Default::default();
        Ask { require, stops_at_target, precision: PRECISION, strategies, engine: Selection::open() }
    }
}

/// The answers to properties.
#[derive(Debug)]
pub struct AskResult {
    /// The answers, as far as they are known.
    pub answers: Answers,
    /// The strategies that were asked for.
    pub strategies: Strategies,
    /// The warnings.
    pub warnings: Vec<Warning>,
    /// The resources that the engine has used.
    pub usage: Option<Usage>,
    /// The limit that has ended the work before all properties had an answer.
    pub limit: Option<Limit>,
    /// The model, with the constants of a property file.
    pub program: Arc<Program>,
    /// The text of the only property.
    pub text: String,
}

#[cfg(feature = "output")]
impl AskResult {
    /// Returns the policy, or the strategies of `multi`, as JSON: what `meliora reach --policy` writes and `verify` checks.
    /// `None` if there are none, or they are not asked for.
    ///
    /// # Errors
    /// A command has no meaning in some state.
    pub fn policy_json(&self) -> Result<Option<String>> {
        let of = (&*self.text, &self.strategies);
        whole_text(|write| write_policy(of, &self.program, PolicyForm::Json, write))
    }

    /// Returns the strategy of the opponent as [`AskResult::policy_json`] does.
    ///
    /// # Errors
    /// A command has no meaning in some state.
    pub fn opponent_json(&self) -> Result<Option<String>> {
        let of = (&*self.text, &self.strategies);
        whole_text(|write| write_opponent(of, &self.program, PolicyForm::Json, write))
    }
}

impl Model {
    /// Answers properties: conditions on states, whose operators ask for
    /// probabilities, rewards, several objectives. Requests about the initial states are answered before all states are
    /// known where one of several ways can do so. Properties share their regions. One that is not answered has a reason if
    /// it is one of several; see [`Answers`].
    ///
    /// ```
    /// use meliora::{Ask, Model, Properties, Settings};
    ///
    /// let model = Model::parse("mdp
    ///     module walk
    ///       x : [0..3] init 0;
    ///       [left] x=0 -> 1/4: (x'=1) + 3/4: (x'=3);
    ///       [right] x=0 -> (x'=2);
    ///       [stay] x>0 -> true;
    ///     endmodule", "")?;
    /// let asked = Properties::Texts(&["Pmax=? [ F x=1 ]", "!(Pmax>=1 [ F x=1 ]) & Pmax>=1 [ F x=2 ]"]);
    /// let found = model.ask(asked, &Ask::default(), Settings::default())?.answers;
    /// let value = found.properties[0].value.clone().flatten().unwrap();
    /// assert!(value.lower <= 0.25 && 0.25 <= value.upper);
    /// assert_eq!(found.properties[1].holds, Some(true));
    /// # Ok::<(), meliora::Error>(())
    /// ```
    ///
    /// # Errors
    /// A text is wrong, each error with its place; the only property cannot be answered; the errors of
    /// [`Model::explore`], save that a limit leaves the answers so far.
    pub fn ask(&self, properties: Properties<'_>, ask: &Ask, settings: Settings) -> Result<AskResult> {
        let (is_one, stops_at_target) = (properties.is_one(), ask.stops_at_target);
        let terms = Terms { require: &ask.require, stops_at_target, ..Terms::default() };
        terms.check_stop(is_one, settings.scope)?;
        if stops_at_target && ask.strategies != WantedStrategies::default() {
            let message = "a strategy is about all states that it visits: ask without `stop_at_target`";
            return Err(Error::Usage(message.to_owned()));
        }
        let (questions, properties) = self.clone().questions(properties, &terms)?;
        questions.check(ask.strategies)?;
        let (selected, precision, strategies) = (ask.engine.clone(), ask.precision, ask.strategies);
        let options = Options { settings, selected, precision, is_one, regions: false, strategies };
        let one = is_one.then(OneQuestion::default);
        answered(&questions, Answers { one, properties, stops_at_target, ..Answers::default() }, &options)
    }
}

/// Answers questions; a limit leaves the answers so far.
fn answered(questions: &Questions, answers: Answers, options: &Options) -> Result<AskResult> {
    let kept = Kept::new(answers, Arc::clone(&options.settings.sink));
    let (strategies, limit) = match pipeline::answer(&kept, options, questions) {
        Ok(strategies) => (strategies, None),
        Err(Error::Limit(limit)) => (Strategies::default(), Some(limit)),
        Err(error) => return Err(error),
    };
    let ((answers, warnings), usage) = (kept.known(), kept.usage());
    let (program, text) = (Arc::clone(&questions.program), questions.text());
    Ok(AskResult { answers, strategies, warnings, usage, limit, program, text })
}
