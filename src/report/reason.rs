//! Texts for the reasons why an action is permitted or not.

use super::{ranks, text};
use meliora_model::Program;
use meliora_model::preference::{Change, ObjectiveSet, Preferences};
use meliora_planning::explain::{Action, Explanation, Successor, Verdict};
use meliora_planning::{Kind, Rank, StrategyKind};

/// The program, the preferences and the kind that a text refers to.
#[derive(Clone, Copy)]
pub struct Words<'a> {
    /// The program, which has the names of variables.
    pub program: &'a Program,
    /// The preferences, which have the names of objectives.
    pub preferences: &'a Preferences,
    /// The kind of the strategy.
    pub kind: StrategyKind,
    /// The kind of improvements that it makes.
    pub levels: Kind,
}

impl Words<'_> {
    /// Returns the names of a set, in the order of declaration.
    pub fn names(&self, set: &ObjectiveSet) -> Vec<String> {
        self.preferences.owned_names(set)
    }

    /// Formats the most preferred objectives of a state, or `unsafe`.
    pub(super) fn preferred(&self, is_unsafe: bool, most_preferred: &ObjectiveSet) -> String {
        if is_unsafe {
            "unsafe".to_owned()
        } else {
            format!("most preferred: {}", self.either(most_preferred))
        }
    }

    /// Formats a set as `A, B`, or `nothing`.
    pub(super) fn list(&self, set: &ObjectiveSet) -> String {
        text::names(&self.names(set))
    }

    /// Formats most preferred objectives as `A or B`, or `nothing`.
    pub(super) fn either(&self, set: &ObjectiveSet) -> String {
        text::either(&self.names(set))
    }

    /// Formats the values that differ: `r=3,b=7`, the facts of a planning problem, or `no change`.
    pub(super) fn changed(&self, from: &[i64], to: &[i64]) -> String {
        let pairs = self.program.variables.iter().zip(from.iter().zip(to));
        let differs = |(v, (x, y)): (&meliora_model::Variable, (&i64, &i64))| {
            (x != y).then(|| self.program.reading(v, *y))
        };
        match pairs.filter_map(differs).collect::<Vec<_>>() {
            changed if changed.is_empty() => "no change".to_owned(),
            changed => changed.join(","),
        }
    }

    /// Returns the name of the player who chooses in a state; `None` if the model is not a game, and in
    /// deadlocks.
    pub fn player(&self, at: &Explanation) -> Option<&str> {
        Some(self.name_of(at.owner?.player))
    }

    /// Returns the name of a player.
    pub(super) fn name_of(&self, player: usize) -> &str {
        let players = self.program.players.as_ref().map_or(&[][..], |players| &players.list);
        players.get(player).map_or("the opponent", |player| &player.name)
    }

    /// Returns the reason why the action is permitted or not, or what an action of the opponent leads to.
    pub fn reason(&self, at: &Explanation, action: &Action) -> String {
        if at.is_theirs() {
            return self.answer(at, action);
        }
        let place = |s: &Successor| self.changed(&at.state, &s.state);
        let to = |index: usize| action.successors.get(index);
        match action.verdict {
            Verdict::Improves => format!("always improves: {}", self.goals(action)),
            Verdict::MayImprove => format!("may improve: {}{}", self.goals(action), self.risk(at, action)),
            Verdict::Approaches => format!("comes closer to an improvement{}", self.risk(at, action)),
            Verdict::Stays => "stays in the level, but comes no closer to an improvement".to_owned(),
            Verdict::Weakens(index) => match to(index) {
                Some(s) => self.weakens(s, action, &place(s)),
                None => "weakens".to_owned(),
            },
            Verdict::Unsafe(index) => {
                let place = index.and_then(to).map_or_else(|| "this action".to_owned(), place);
                let kept = self.either(&at.reference);
                let risk = || format!("after {place}, a weakening of {kept} cannot be ruled out");
                format!("not kept: {}", self.threat(&place, action).unwrap_or_else(risk))
            }
            Verdict::Exposes(index) => self.exposes(at, action, index),
            Verdict::Violates(None) => "no action keeps the requirements here".to_owned(),
            Verdict::Violates(Some(index)) => {
                let how = if action.successors.len() == 1 { "leads" } else { "may lead" };
                let place = to(index).map_or_else(String::new, |s| format!(" to {}", place(s)));
                format!("{how}{place}, where no strategy keeps the requirements")
            }
            Verdict::Strays(index) => match to(index) {
                Some(s) => self.strays(at, s, action, &place(s)),
                None => "leaves the states of the level".to_owned(),
            },
            Verdict::Hopeless => match at.memory.level {
                Rank::Finite(1) | Rank::AtLeast(1) => "safe, but no improvement can follow".to_owned(),
                level => format!("safe, but {} cannot follow", ranks::improvements(level)),
            },
            Verdict::NothingAhead => {
                format!("safe, but no improvement is {} from here", ranks::how(self.levels))
            }
            _ => self.achieving(at, action),
        }
    }

    /// Formats what an action of the opponent leads to.
    fn answer(&self, at: &Explanation, action: &Action) -> String {
        let gains = || {
            let improving = action.successors.iter().filter(|s| s.change == Change::Improving);
            self.gains(improving)
        };
        let given_up = at.given_up(action);
        match action.verdict {
            Verdict::Improves => format!("improves: {}", gains()),
            Verdict::MayImprove => format!("may improve: {}", gains()),
            Verdict::Weakens(index) => match action.successors.get(index) {
                Some(s) => self.weakens(s, action, &self.changed(&at.state, &s.state)),
                None => "weakens".to_owned(),
            },
            Verdict::Exposes(index) => self.exposes(at, action, index),
            Verdict::Unsafe(index) => {
                let place = index.and_then(|index| action.successors.get(index));
                let place = place.map(|s| self.changed(&at.state, &s.state)).unwrap_or_default();
                let risk = || format!("a weakening of {} can follow", self.either(&at.reference));
                self.threat(&place, action).unwrap_or_else(risk)
            }
            Verdict::Violates(_) => "may lead to a state where no strategy keeps the requirements".to_owned(),
            Verdict::Lateral if !given_up.is_empty() => format!("may give up {}", self.list(&given_up)),
            Verdict::Lateral => "neither improves nor weakens".to_owned(),
            _ => self.achieving(at, action),
        }
    }

    /// Formats how the opponent can weaken after a successor of an action.
    fn exposes(&self, at: &Explanation, action: &Action, index: usize) -> String {
        let place = action.successors.get(index).map(|s| self.changed(&at.state, &s.state));
        let place = place.unwrap_or_default();
        let risk = || format!("after {place}, the opponent can weaken sooner or later");
        self.threat(&place, action).unwrap_or_else(risk)
    }

    /// Formats how a weakening can follow after an action leads to a place; `None` if it is not known.
    fn threat(&self, place: &str, action: &Action) -> Option<String> {
        let threat = action.threat.as_ref()?;
        let (mut steps, mut last) = (Vec::new(), None);
        for (player, name) in &threat.actions {
            let by = if last == Some(player) {
                String::new()
            } else {
                format!("{} may take ", self.name_of(*player))
            };
            steps.push(format!("{by}{name}"));
            last = Some(player);
        }
        if let (Some(end), true) = (steps.last().cloned(), steps.len() > 3) {
            steps.splice(1.., [format!("{} more steps and {end}", threat.actions.len() - 2)]);
        }
        let lost = self.list(&threat.lost);
        Some(format!("after {place}, {}, which weakens: {lost} lost", steps.join(", then ")))
    }

    /// Formats the pursued objectives as `A and B`; `None` if none is pursued.
    pub fn pursued(&self, at: &Explanation) -> Option<String> {
        (!at.aims.is_empty()).then(|| self.names(&at.aims).join(" and "))
    }

    /// Formats the pursued objectives that are left, or all of them if none is.
    pub(super) fn left(&self, at: &Explanation) -> String {
        self.names(if at.left.is_empty() { &at.aims } else { &at.left }).join(" and ")
    }

    /// Formats the objectives that an action achieves as `C or D`, and says if others are left.
    fn achieves(&self, at: &Explanation, action: &Action) -> String {
        let mut sets: Vec<String> = Vec::new();
        for successor in action.successors.iter().filter(|s| s.goal) {
            let set = self.names(&successor.achieves).join(" and ");
            if !sets.contains(&set) {
                sets.push(set);
            }
        }
        let leaves = action.successors.iter().any(|s| s.goal && s.achieves.len() < at.left.len());
        format!("{}{}", sets.join(" or "), if leaves { "; the rest stays sure" } else { "" })
    }

    /// Returns the reason why an action is permitted or not while an objective is pursued.
    fn achieving(&self, at: &Explanation, action: &Action) -> String {
        let (name, verb) = (self.left(at), if at.left.len() > 1 { "are" } else { "is" });
        let reason = match action.verdict {
            _ if action.permitted && at.is_achieved() => {
                let verb = if at.aims.len() > 1 { "are" } else { "is" };
                return format!("{name} {verb} achieved");
            }
            Verdict::Achieves => format!("achieves {}", self.achieves(at, action)),
            Verdict::MayAchieve if at.left.len() > 1 => format!("may achieve {}", self.achieves(at, action)),
            Verdict::MayAchieve => format!("may achieve {name}, which remains sure"),
            Verdict::Nears => format!("comes closer to {name}"),
            Verdict::Forfeits(index) => {
                let how = if action.successors.len() == 1 { "leads" } else { "may lead" };
                let place = action.successors.get(index).map(|s| self.changed(&at.state, &s.state));
                let place = place.unwrap_or_default();
                let together = if at.left.len() > 1 { " together" } else { "" };
                let otherwise = if at.keeps() { " without steps that may weaken" } else { "" };
                return format!("{how} to {place}, where {name} {verb} not sure{together}{otherwise}");
            }
            Verdict::Unachievable => {
                return "no strategy achieves this almost surely from here".to_owned();
            }
            Verdict::Likeliest => format!("makes {name} as likely as possible"),
            Verdict::PassedOver => format!("does not make {name} more likely than the action that is taken"),
            Verdict::Impossible => format!("no strategy can achieve {name} from here"),
            _ if at.left.len() > 1 => format!("keeps {name} sure together, but comes no closer"),
            _ => format!("keeps {name} sure, but comes no closer to it"),
        };
        match at.given_up(action) {
            given_up if given_up.is_empty() => reason,
            given_up => {
                let how = if action.successors.len() == 1 { "gives" } else { "may give" };
                format!("{reason}; {how} up {}", self.list(&given_up))
            }
        }
    }

    /// Formats the gains of an action by goal edges.
    fn goals(&self, action: &Action) -> String {
        self.gains(action.successors.iter().filter(|s| s.goal))
    }

    /// Formats the gains as `B gained` or `B or C gained`, each gain once.
    fn gains<'s>(&self, successors: impl Iterator<Item = &'s Successor>) -> String {
        let mut gains: Vec<String> = Vec::new();
        for successor in successors {
            let gain = self.either(&successor.gained);
            if !gains.contains(&gain) {
                gains.push(gain);
            }
        }
        format!("{} gained", gains.join(" or "))
    }

    fn weakens(&self, to: &Successor, action: &Action, place: &str) -> String {
        let how = if action.successors.len() == 1 { "weakens" } else { "may weaken" };
        let instead = match to.most_preferred.is_empty() {
            true => String::new(),
            false => format!(" ({} instead)", self.either(&to.most_preferred)),
        };
        format!("{how}: {} lost in {place}{instead}", self.list(&to.lost))
    }

    fn strays(&self, at: &Explanation, to: &Successor, action: &Action, place: &str) -> String {
        let how = if action.successors.len() == 1 { "leads" } else { "may lead" };
        let (sure, level) = (ranks::how(self.levels), at.memory.level);
        if to.improves {
            return format!(
                "{how} to {place}, which improves, but the next improvements are not {sure} there"
            );
        }
        let verb = if ranks::is_one(level) { "is" } else { "are" };
        format!("{how} to {place}, where {} {verb} not {sure}", ranks::improvements(level))
    }

    /// Formats the risk of a permitted action: under SPI it may leave the level.
    fn risk(&self, at: &Explanation, action: &Action) -> String {
        let astray = action.successors.iter().find(|s| !s.dropped && !s.goal && !s.stays);
        let dropped = action.successors.iter().find(|s| s.dropped);
        match (astray, dropped) {
            (Some(s), _) => format!("; may leave the level in {}", self.changed(&at.state, &s.state)),
            (None, Some(s)) => {
                format!("; the branch to {} weakens and is dropped", self.changed(&at.state, &s.state))
            }
            (None, None) => String::new(),
        }
    }
}
