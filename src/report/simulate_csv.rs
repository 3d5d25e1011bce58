//! Simulated runs as lines of comma-separated values.

use super::ranks;
use super::simulate::SimulateFindings;
use meliora_base::csv::{self, Lines};
use meliora_model::Program;
use meliora_model::preference::{ObjectiveSet, Preferences};
use meliora_model::valuation::Valuation;
use meliora_planning::Rank;
use meliora_planning::tally::{Trace, Turn, Wait};

/// The texts of the model and the preferences that runs refer to.
#[derive(Clone, Copy)]
pub struct RunLines<'a> {
    /// The program.
    pub program: &'a Program,
    /// The preferences.
    pub preferences: &'a Preferences,
}

/// A state where runs start.
pub struct RunStart<'a> {
    /// Its number among the starting states, from 1.
    pub number: usize,
    /// The state.
    pub state: &'a [i64],
    /// The names of its most preferred objectives.
    pub most_preferred: Vec<&'a str>,
    /// Its rank.
    pub rank: Rank,
}

impl RunLines<'_> {
    /// Returns the heading: the start, the run and the step, the variables, and what led there.
    pub fn heading(self) -> String {
        let variables = self.program.variables.iter().map(|variable| variable.name.as_str());
        let columns = ["action", "probability", "most_preferred", "rank", "event"];
        let of_games = self.program.players.iter().flat_map(|_| ["owner", "player"]);
        csv::lines([["start", "run", "step"].into_iter().chain(variables).chain(columns).chain(of_games)])
    }

    /// Returns the lines of a run: one for the state where it starts, as step 0, and one for each step
    /// with the state entered.
    pub fn rows(self, start: &RunStart<'_>, trace: &Trace) -> String {
        let mut lines = Lines::default();
        let of_game = self.program.players.is_some();
        let of = |step: usize, state: &[i64]| {
            let values: Vec<String> = Valuation::new(self.program, state).cells().collect();
            [start.number.to_string(), trace.run.to_string(), step.to_string()].into_iter().chain(values)
        };
        let begin = [
            String::new(),
            String::new(),
            start.most_preferred.join("+"),
            ranks::cell(start.rank),
            self.achieved(&trace.achieved).join("; "),
        ];
        lines.push(of(0, start.state).chain(begin).chain(vec![String::new(); if of_game { 2 } else { 0 }]));
        for (step, turn) in (1..).zip(&trace.turns) {
            let cells = [
                turn.action.clone(),
                turn.probability.to_string(),
                self.preferences.names(&turn.most_preferred).join("+"),
                ranks::cell(turn.rank),
                self.events(turn).join("; "),
            ];
            lines.push(of(step, &turn.state).chain(cells).chain(self.owner(turn)));
        }
        lines.text()
    }

    /// Returns who chose the action: two cells for a game, none for other models.
    fn owner(self, turn: &Turn) -> Vec<String> {
        let Some(players) = &self.program.players else { return Vec::new() };
        let Some(owner) = turn.owner else { return vec![String::new(); 2] };
        let player = players.list.get(owner.player).map_or("", |player| &player.name);
        vec![if owner.ours { "ours" } else { "opponent" }.to_owned(), player.to_owned()]
    }

    /// Returns what the step did.
    fn events(self, turn: &Turn) -> Vec<String> {
        let mut events = Vec::new();
        if let Some(objective) = turn.commits {
            events.push(format!("commits to {}", self.preferences.objectives[objective].name));
        }
        for (is_one, event) in [
            (turn.improves, "improvement"),
            (turn.weakens_step, "weakening"),
            (turn.weakens_start, "weakens the start"),
            (turn.is_unsafe, "unsafe"),
        ] {
            events.extend(is_one.then(|| event.to_owned()));
        }
        events.extend(self.preferences.names(&turn.gives_up).iter().map(|name| format!("gives up {name}")));
        events.extend(self.achieved(&turn.achieved));
        events
    }

    fn achieved(self, objectives: &ObjectiveSet) -> Vec<String> {
        self.preferences.names(objectives).iter().map(|name| format!("achieves {name}")).collect()
    }
}

impl SimulateFindings {
    /// Returns lines of comma-separated values with a heading: for each starting state and each number
    /// of improvements from 0 on, the runs that made at least this number, and the steps until then.
    pub fn statistics(&self, program: &Program) -> String {
        let variables = program.variables.iter().map(|variable| variable.name.as_str());
        let columns = ["rank", "improvements", "runs", "steps_least", "steps_mean", "steps_most"];
        let mut lines = Lines::default();
        lines.push(variables.chain(columns));
        for start in &self.starts {
            let none = Wait { runs: self.runs, least: 0, most: 0, total: 0 };
            for (number, wait) in [none].iter().chain(&start.tally.waits).enumerate() {
                let mean = wait.total as f64 / wait.runs.max(1) as f64;
                let cells = [number.to_string(), wait.runs.to_string(), wait.least.to_string()];
                let cells = cells.into_iter().chain([mean.to_string(), wait.most.to_string()]);
                lines.push(start.state.cells().chain([ranks::cell(start.tally.rank)]).chain(cells));
            }
        }
        lines.text()
    }
}
