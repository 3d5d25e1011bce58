//! The reader of Storm's format DRN: a header, then states with their actions and branches, one per
//! line.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::lines::{Line, lines};
use super::lower::NUMBER;
use super::{Column, Frame, Rewards, Table};
use meliora_base::error::{Result, SourceFile};
use meliora_base::escape::{is_shown, unquoted, unword};
use meliora_base::progress::Poll;
use meliora_base::value::Type;
use meliora_lang::{Actions, Checked};
use meliora_model::ModelKind;
use meliora_model::expr::ExprId;

/// The name of a choice without an action.
const NO_ACTION: &str = "__NOLABEL__";

/// Returns true if a text is meant as DRN: its first line is the type.
pub(crate) fn is_drn(source: &Arc<SourceFile>) -> bool {
    lines(source, "//").next().is_some_and(|line| line.text.starts_with("@type"))
}

/// Reads a model.
///
/// # Errors
/// The text is invalid, or a model that is not supported; a limit.
pub(crate) fn load(frame: &Frame<'_>) -> Result<Checked> {
    frame.refuse_values()?;
    let mut reader = DrnReader {
        table: Table::new(ModelKind::Mdp),
        actions: Actions::default(),
        labels: Actions::default(),
        counts: Vec::new(),
        rewards: Vec::new(),
        reward_names: Actions::default(),
        state_names: Vec::new(),
    };
    let mut all = lines(frame.source, "//");
    reader.header(&mut all, frame)?;
    let mut poll = Poll::new(frame.sink);
    for line in all {
        poll.step()?;
        reader.line(line)?;
    }
    frame.lower(reader.finish(frame)?)
}

struct DrnReader<'s> {
    table: Table,
    actions: Actions,
    /// The numbers of the labels.
    labels: Actions,
    /// The declared numbers of states and choices, with the lines that declare them.
    counts: Vec<(bool, usize, Line<'s>)>,
    rewards: Vec<Rewards>,
    reward_names: Actions,
    /// The names of the states, with the lines that have them.
    state_names: Vec<(&'s str, Line<'s>)>,
}

impl<'s> DrnReader<'s> {
    /// Reads the lines up to `@model`.
    fn header(&mut self, all: &mut impl Iterator<Item = Line<'s>>, frame: &Frame<'_>) -> Result<()> {
        let mut section = "";
        for line in all {
            let Some(key) = line.text.strip_prefix('@') else {
                self.entry(section, line)?;
                continue;
            };
            let (key, value) = key.split_once(':').unwrap_or((key, ""));
            section = key.trim();
            let value = match section {
                "type" => value.trim().to_ascii_uppercase(),
                _ => value.trim().to_owned(),
            };
            match (section, value.as_str()) {
                ("type", "MDP") => self.table.kind = ModelKind::Mdp,
                ("type", "DTMC") => self.table.kind = ModelKind::Dtmc,
                // No writer of the format says whose choices those of a state are.
                ("type", "SMG") => return Err(line.refused("games in this format")),
                ("type", other) => return Err(line.refused(&format!("models of type {other}"))),
                ("value_type", other) if other.contains("interval") => {
                    return Err(line.refused("intervals of probabilities"));
                }
                ("model", _) => return Ok(()),
                _ => {}
            }
        }
        Err(frame.wrong("the text ends before `@model`"))
    }

    fn entry(&mut self, section: &str, line: Line<'s>) -> Result<()> {
        match section {
            "parameters" => return Err(line.refused("parameters")),
            "placeholders" => return Err(line.refused("placeholders")),
            "nr_states" => self.counts.push((true, line.index(line.text)?, line)),
            "nr_choices" => self.counts.push((false, line.index(line.text)?, line)),
            "reward_models" => self.reward_models(line)?,
            "state_names" => self.state_names.push((state_name(line)?, line)),
            _ => {}
        }
        Ok(())
    }

    fn reward_models(&mut self, line: Line<'s>) -> Result<()> {
        for name in line.text.split_whitespace() {
            if self.reward_names.add(name) < self.rewards.len() {
                return Err(line.part(name).wrong(format!("the reward model `{name}` occurs twice")));
            }
            let (states, choices) = (Some(Vec::new()), Some(Vec::new()));
            self.rewards.push(Rewards { name: Some(unword(name).into_owned()), states, choices });
        }
        Ok(())
    }

    /// Reads a line after `@model`.
    fn line(&mut self, line: Line<'s>) -> Result<()> {
        match line.text.split_once(char::is_whitespace).unwrap_or((line.text, "")) {
            ("state", rest) => self.state(line, rest),
            ("action", rest) => self.action(line, rest),
            _ => self.branch(line),
        }
    }

    fn state(&mut self, line: Line<'s>, rest: &str) -> Result<()> {
        let (rest, earned) = self.earned(line, rest)?;
        let mut words = words(line, &rest)?.into_iter();
        let state = self.table.choices.len() - 1;
        let number = words.next().unwrap_or_default();
        if line.index(&number)? != state {
            return Err(line.wrong(format!("state {number} is not in its place, expected state {state}")));
        }
        self.table.choices.push(self.table.action_of.len());
        for (rewards, earned) in self.rewards.iter_mut().zip(earned) {
            rewards.states.get_or_insert_default().push(earned);
        }
        for label in words {
            match label.as_str() {
                "init" => self.table.initial.push(state),
                _ => self.label(label, state),
            }
        }
        Ok(())
    }

    fn label(&mut self, label: String, state: usize) {
        let number = self.labels.add(&label);
        if number == self.table.labels.len() {
            self.table.labels.push((label, Vec::new()));
        }
        self.table.labels[number].1.push(state);
    }

    fn action(&mut self, line: Line<'s>, rest: &str) -> Result<()> {
        if self.table.choices.len() == 1 {
            return Err(line.wrong("an action without a state"));
        }
        // The rewards come last; a bracket inside of a word belongs to the name.
        let starts_word = |at: &usize| !rest[..*at].ends_with(|c: char| !c.is_whitespace());
        let (name, rewards) = rest.split_at(rest.rfind('[').filter(starts_word).unwrap_or(rest.len()));
        let (_, earned) = self.earned(line, rewards)?;
        let name = name.trim();
        let number = (!name.is_empty() && name != NO_ACTION).then(|| self.actions.add(&unword(name)));
        self.table.action_of.push(number);
        self.table.branches.push(self.table.targets.len());
        for (rewards, earned) in self.rewards.iter_mut().zip(earned) {
            rewards.choices.get_or_insert_default().push(earned);
        }
        self.table.end();
        Ok(())
    }

    /// Splits off the rewards in square brackets; those that are left out are 0.
    fn earned(&mut self, line: Line<'s>, rest: &str) -> Result<(String, Vec<ExprId>)> {
        let (before, inside, after) =
            match bracket(rest).map(|at| (&rest[..at], rest[at + 1..].split_once(']'))) {
                None => (rest, "", ""),
                Some((before, Some((inside, after)))) => (before, inside, after),
                Some((_, None)) => return Err(line.wrong("`]` is missing")),
            };
        let mut earned = Vec::new();
        for text in inside.split(',').map(str::trim).filter(|text| !text.is_empty()) {
            earned.push(self.table.number(line.number(text)?));
        }
        if earned.len() > self.rewards.len() {
            let expected = self.rewards.len();
            return Err(line.wrong(format!("{} rewards, expected at most {expected}", earned.len())));
        }
        let zero = self.table.double(0.0);
        earned.resize(self.rewards.len(), zero);
        Ok((format!("{before} {after}"), earned))
    }

    fn branch(&mut self, line: Line<'s>) -> Result<()> {
        let Some((target, weight)) = line.text.split_once(':') else {
            return Err(line.wrong("expected a state, an action, or a branch such as `3 : 0.5`"));
        };
        if self.table.action_of.is_empty() {
            return Err(line.wrong("a branch without an action"));
        }
        if weight.trim_start().starts_with('[') {
            return Err(line.refused("intervals of probabilities"));
        }
        self.table.branch(line.index(target.trim())?, line.number(weight.trim())?);
        Ok(())
    }

    /// Checks the declared numbers.
    fn finish(mut self, frame: &Frame<'_>) -> Result<Table> {
        let (states, choices) = (self.table.states(), self.table.action_of.len());
        for (of_states, declared, line) in self.counts {
            let (found, what) = if of_states { (states, "states") } else { (choices, "choices") };
            if found != declared {
                return Err(line.wrong(format!("the model has {found} {what}, not {declared}")));
            }
        }
        if states == 0 {
            return Err(frame.wrong("the model has no state"));
        }
        self.table.actions = self.actions.names;
        self.table.rewards = self.rewards;
        self.table.columns = named(&self.state_names, states)?;
        Ok(self.table)
    }
}

/// Returns the text in double quotes that is a whole line.
fn state_name(line: Line<'_>) -> Result<&str> {
    let name = line.text.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
    let name = name.filter(|name| !name.is_empty() && name.chars().all(|c| c != '"' && is_shown(c)));
    name.ok_or_else(|| line.wrong("expected the name of a state in double quotes, of visible characters"))
}

/// Returns the variable whose values are the names of the states; none if they have no names.
fn named(names: &[(&str, Line<'_>)], states: usize) -> Result<Vec<Column>> {
    let Some((_, last)) = names.last() else { return Ok(Vec::new()) };
    if names.len() != states {
        return Err(last.wrong(format!("the model has {states} states, but {} names for them", names.len())));
    }
    let mut known = BTreeSet::new();
    if let Some((name, line)) = names.iter().find(|(name, _)| !known.insert(*name)) {
        return Err(line.wrong(format!("two states are called `{name}`")));
    }
    let count = i64::try_from(states).unwrap_or(i64::MAX);
    let names = names.iter().map(|(name, _)| (*name).to_owned()).collect();
    let (name, values) = (NUMBER.to_owned(), (0..count).collect());
    Ok(vec![Column { name, place: None, ty: Type::Int, low: 0, high: count - 1, names, values }])
}

/// Returns the place of the first `[` outside of words in double quotes.
fn bracket(text: &str) -> Option<usize> {
    let mut is_quoted = false;
    text.char_indices().find_map(|(at, c)| {
        is_quoted ^= c == '"';
        (c == '[' && !is_quoted).then_some(at)
    })
}

/// Splits a text into words; a word in double quotes may contain blanks.
fn words(line: Line<'_>, text: &str) -> Result<Vec<String>> {
    let (mut words, mut left) = (Vec::new(), text.trim_start());
    while !left.is_empty() {
        match left.as_bytes()[0] {
            b'!' => return Err(line.refused("rates")),
            b'{' => return Err(line.refused("observations and players")),
            _ => {}
        }
        let (word, rest) = if left.starts_with('"') {
            unquoted(left).ok_or_else(|| line.wrong("`\"` is missing"))?
        } else {
            let (word, rest) = left.split_at(left.find(char::is_whitespace).unwrap_or(left.len()));
            (word.to_owned(), rest)
        };
        words.push(word);
        left = rest.trim_start();
    }
    Ok(words)
}
