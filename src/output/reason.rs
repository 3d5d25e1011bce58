//! Why an action is permitted or not, in words.

use super::{ranks, text};
use crate::model::Program;
use crate::model::preference::{ObjectiveSet, Preferences};
use crate::planning::explain::{Action, Explanation, Successor, Verdict};
use crate::planning::{Kind, Rank};

/// What the words are about.
#[derive(Clone, Copy)]
pub(super) struct Words<'a> {
    pub(super) program: &'a Program,
    pub(super) preferences: &'a Preferences,
    pub(super) kind: Kind,
}

impl Words<'_> {
    /// The names of a set, in the order of declaration.
    pub(super) fn names(&self, set: &ObjectiveSet) -> Vec<String> {
        self.preferences.names(set).into_iter().map(str::to_owned).collect()
    }

    /// `A, B`, or `nothing`.
    pub(super) fn list(&self, set: &ObjectiveSet) -> String {
        text::names(&self.names(set))
    }

    /// The values that differ: `r=3,b=7`, or `no change`.
    pub(super) fn changed(&self, from: &[i64], to: &[i64]) -> String {
        let pairs = self.program.variables.iter().zip(from.iter().zip(to));
        let differs = |(v, (x, y)): (&crate::model::Variable, (&i64, &i64))| {
            (x != y).then(|| format!("{}={}", v.name, v.show(*y)))
        };
        match pairs.filter_map(differs).collect::<Vec<_>>() {
            changed if changed.is_empty() => "no change".to_owned(),
            changed => changed.join(","),
        }
    }

    /// Why the action is permitted or not.
    pub(super) fn reason(&self, at: &Explanation, action: &Action) -> String {
        let place = |s: &Successor| self.changed(&at.state, &s.state);
        let to = |index: usize| action.successors.get(index);
        match action.verdict {
            Verdict::Improves => format!("improves whatever happens: {}", self.gains(action)),
            Verdict::MayImprove => format!("may improve: {}{}", self.gains(action), self.risk(at, action)),
            Verdict::Approaches => format!("comes closer to an improvement{}", self.risk(at, action)),
            Verdict::Stays => "stays, but makes no progress".to_owned(),
            Verdict::Weakens(index) => match to(index) {
                Some(s) => self.weakens(s, action, &place(s)),
                None => "weakens".to_owned(),
            },
            Verdict::Unsafe(index) => {
                let place = index.and_then(to).map_or_else(|| "here".to_owned(), place);
                let kept = self.list(&at.reference);
                format!("not kept: from {place} on, it is not sure that {kept} can be kept from weakening")
            }
            Verdict::Strays(index) => match to(index) {
                Some(s) => self.strays(at, s, action, &place(s)),
                None => "leaves the states from where it improves".to_owned(),
            },
            Verdict::Hopeless => match at.memory.level {
                Rank::Finite(1) | Rank::AtLeast(1) => "safe, but no improvement can follow".to_owned(),
                level => format!("safe, but {} can not follow", ranks::improvements(level)),
            },
            Verdict::NothingAhead => {
                format!("safe, but no improvement is {} from here", ranks::how(self.kind).0)
            }
        }
    }

    /// `B gained in r=2,c=0, C gained in …`; places with the same gain are told together.
    fn gains(&self, action: &Action) -> String {
        let mut gains: Vec<String> = Vec::new();
        for successor in action.successors.iter().filter(|s| s.goal) {
            let gain = self.list(&successor.gained);
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
            false => format!(" ({} instead)", self.list(&to.most_preferred)),
        };
        format!("{how}: {} lost in {place}{instead}", self.list(&to.lost))
    }

    fn strays(&self, at: &Explanation, to: &Successor, action: &Action, place: &str) -> String {
        let how = if action.successors.len() == 1 { "ends" } else { "may end" };
        let (sure, level) = (ranks::how(self.kind).0, at.memory.level);
        if to.improves {
            return format!("{how} in {place}: that improves, but what has to follow is not {sure} there");
        }
        let verb = if ranks::is_one(level) { "is" } else { "are" };
        format!("{how} in {place}, where {} {verb} not {sure}", ranks::improvements(level))
    }

    /// Under SPI a permitted action may lead astray.
    fn risk(&self, at: &Explanation, action: &Action) -> String {
        let astray = action.successors.iter().find(|s| !s.dropped && !s.goal && !s.stays);
        let dropped = action.successors.iter().find(|s| s.dropped);
        match (astray, dropped) {
            (Some(s), _) => format!("; may go astray in {}", self.changed(&at.state, &s.state)),
            (None, Some(s)) => format!(
                "; the branch into {}, which weakens, is left out of account",
                self.changed(&at.state, &s.state)
            ),
            (None, None) => String::new(),
        }
    }
}
