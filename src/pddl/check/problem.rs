//! The problem: initial facts, the goal, preferences and the metric.

use super::Checker;
use super::initial::Fact;
use super::requirements::Requirement;
use crate::syntax::Node;
use crate::task::{Condition, Measure};
use meliora_base::error::Severity;
use meliora_model::planning::GOAL;

/// The initial facts and the goals.
#[derive(Default)]
pub(super) struct Goals {
    pub(super) initial: Vec<Fact>,
    pub(super) starts: Vec<Vec<Fact>>,
    pub(super) goal: Option<Condition>,
    pub(super) preferences: Vec<(String, Condition)>,
}

impl Checker {
    /// Reads `:init`, `:goal` and `:metric` of a problem.
    pub(super) fn goals(&mut self, problem: &[Node]) -> Goals {
        let (initial, starts, first) = self.initial(problem);
        let mut goals = Goals { initial, starts, ..Goals::default() };
        let mut is_given = false;
        self.named(problem, ":goal", |checker, parts, node| {
            if is_given {
                checker.report::<()>(node.wrong("the problem has two goals").help("join them by `and`"));
            }
            is_given = true;
            checker.goal(parts, node, &mut goals);
        });
        if !is_given && let Some(last) = problem.last() {
            let wrong = last.wrong("the problem has no goal");
            if self.measures.contains(&Measure::Reward) {
                let note = wrong.severity(Severity::Warning).label("only its rewards can be asked about");
                self.faults.notes.push(note);
            } else {
                self.report::<()>(wrong.help("add `(:goal condition)`"));
            }
        }
        self.begin_by(first, &mut goals);
        self.named(problem, ":goal-reward", |checker, parts, node| checker.goal_reward(parts, node));
        self.named(problem, ":metric", |checker, parts, node| checker.metric(parts, node));
        goals
    }

    fn goal(&mut self, parts: &[Node], node: &Node, goals: &mut Goals) {
        let Some([whole]) = self.exactly(node, parts, ":goal") else { return };
        let split: Vec<&Node> = match whole.form() {
            Some(("and", parts)) => parts.iter().collect(),
            _ => vec![whole],
        };
        let mut hard = Vec::new();
        let mut is_hard = split.is_empty();
        for part in split {
            if let Some(("preference", parts)) = part.form() {
                self.preference(part, parts, goals);
            } else {
                is_hard = true;
                hard.extend(self.condition(part, true));
            }
        }
        goals.goal = is_hard.then_some(Condition::And(hard));
    }

    fn preference(&mut self, node: &Node, parts: &[Node], goals: &mut Goals) {
        self.used.add(Requirement::Preferences);
        let [name, body] = match parts {
            [name, body] if name.word().is_some() => [name, body],
            _ => {
                let wrong = node.expected("`(preference NAME condition)`");
                self.report::<()>(wrong.help("the name is that of an objective, which `prefer` can name"));
                return;
            }
        };
        let shown = name.text().to_owned();
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if !shown.chars().all(is_name) || shown.starts_with(|c: char| c.is_ascii_digit() || c == '-') {
            let wrong = name.wrong(format!("the name `{shown}` cannot be that of an objective"));
            self.report::<()>(wrong.help("use letters, digits, `-` and `_`"));
        }
        let is_taken = |known: &str| known.eq_ignore_ascii_case(&shown);
        if is_taken(GOAL) || goals.preferences.iter().any(|(known, _)| is_taken(known)) {
            let message = format!("the objective `{shown}` is declared twice");
            self.report::<()>(
                name.wrong(message).help("each preference needs a name of its own, other than `goal`"),
            );
        }
        let condition = self.condition(body, true);
        goals.preferences.extend(condition.map(|condition| (shown, condition)));
    }

    /// Reads the metric, which is not used: weights are no order.
    fn metric(&mut self, parts: &[Node], node: &Node) {
        let mut open: Vec<&Node> = parts.iter().collect();
        let mut has_weights = false;
        let mut unused = None;
        while let Some(part) = open.pop() {
            open.extend(part.list().into_iter().flatten());
            match part.word() {
                Some("is-violated") => has_weights = true,
                Some("total-time") => unused = Some(part),
                _ => {}
            }
        }
        if let Some(part) = unused {
            let note =
                part.wrong("the metric is not used: problems have no time").severity(Severity::Warning);
            self.faults.notes.push(note);
        }
        if has_weights {
            let message = "the weights of preferences are not used: they are not an order of the objectives";
            let note = node.wrong(message).severity(Severity::Warning);
            let help = "write the order in a preference file: `prefer fed > clean;`";
            self.faults.notes.push(note.help(help));
        }
    }
}
