//! A state under a strategy, in the JSON and the text of `strategy`.

use serde_json::{Value as Json, json};

use super::choose::{Attains, Choosing};
use super::reason::Words;
use meliora_model::preference::ObjectiveSet;
use meliora_model::valuation::Valuation;
use meliora_planning::explain::{Action, Successor};
use meliora_planning::{Explanation, InducedModel, Rank};

/// The explanation of a state, with the words for its results.
pub struct StateReport<'a> {
    /// The texts of the model and the preferences.
    pub words: Words<'a>,
    /// The state and its actions.
    pub at: Explanation,
    /// The number of guaranteed (SASI) and of possible (SPI) improvements.
    pub ranks: [Rank; 2],
    /// The choice among permitted actions.
    pub choosing: Choosing,
    /// The value that the strategy attains, if the choice depends on values.
    pub attains: Option<Attains>,
    /// The paths under the progress strategy, if they were computed.
    pub unfolded: Option<InducedModel>,
}

impl StateReport<'_> {
    /// Returns the action that the strategy takes; `None` at level 0.
    pub(crate) fn picked_action(&self) -> Option<&Action> {
        self.at.actions.get(self.at.pick?)
    }

    /// Returns the first action that makes progress; `None` at level 0.
    pub(crate) fn progress_action(&self) -> Option<&Action> {
        self.at.actions.iter().find(|action| action.progress)
    }

    /// Returns whether the strategy commits to an objective that is still to be achieved.
    pub(crate) fn commits(&self) -> bool {
        self.at.commits() && !self.at.is_achieved()
    }

    /// Returns the objectives that the next step of the strategy may give up.
    pub(crate) fn gives_up(&self) -> ObjectiveSet {
        self.picked_action().map(|action| self.at.given_up(action)).unwrap_or_default()
    }

    /// Returns the JSON object of the state.
    pub(crate) fn json(&self) -> Json {
        let (words, at, [sasi, spi]) = (self.words, &self.at, self.ranks);
        let mut json = json!({
            "state": Valuation::of(words.program, &at.state),
            "most_preferred": words.names(&at.most_preferred),
            "sasi_rank": sasi,
            "spi_rank": spi,
            "progress_action": self.progress_action().map(|action| &action.name),
            "chosen_action": self.picked_action().map(|action| &action.name),
            "attains": self.attains,
            "actions": at.actions.iter().map(|action| self.action(action)).collect::<Vec<_>>(),
            "longest_play": self.unfolded.as_ref().and_then(InducedModel::longest_path),
        });
        if words.kind.achieves() {
            json["pursues"] = json!(words.pursued(at));
            json["achieved"] = json!(words.names(&at.achieved));
            json["commits"] = json!(self.commits());
            json["gives_up"] = json!(words.names(&self.gives_up()));
        }
        marked(json, at.is_unsafe)
    }

    fn action(&self, action: &Action) -> Json {
        json!({
            "name": action.name,
            "kept": action.kept,
            "permitted": action.permitted,
            "progress": action.progress,
            "verdict": action.verdict.name(),
            "reason": self.words.reason(&self.at, action),
            "successors": action.successors.iter().map(|s| self.successor(s)).collect::<Vec<_>>(),
        })
    }

    fn successor(&self, successor: &Successor) -> Json {
        let words = self.words;
        let json = json!({
            "state": Valuation::of(words.program, &successor.state),
            "probability": successor.probability,
            "most_preferred": words.names(&successor.most_preferred),
            "change": successor.change.name(),
            "gained": words.names(&successor.gained),
            "lost": words.names(&successor.lost),
            "rank": successor.rank,
            "dropped": successor.dropped,
            "goal": successor.goal,
        });
        marked(json, successor.is_unsafe)
    }
}

/// Adds `"unsafe": true` to the object of an unsafe state.
fn marked(mut json: Json, is_unsafe: bool) -> Json {
    if let (Json::Object(fields), true) = (&mut json, is_unsafe) {
        fields.insert("unsafe".to_owned(), Json::Bool(true));
    }
    json
}
