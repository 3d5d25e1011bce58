//! The reader of PRISM's explicit files: `.tra` with the transitions, and next to it `.sta` with the
//! values and `.lab` with the labels of the states.

use std::sync::Arc;

use ahash::AHashSet;

use super::lines::{Line, lines};
use super::{Column, Frame, Table};
use crate::check::{Actions, Checked};
use meliora_model::ModelKind;
use meliora_model::error::{Error, Result, SourceFile};
use meliora_model::progress::Poll;
use meliora_model::value::Type;

/// Returns true if a text is meant as transitions: its first line has two or three numbers.
pub(crate) fn is_tra(source: &Arc<SourceFile>) -> bool {
    let Some(first) = lines(source, "#").next() else { return false };
    let words: Vec<&str> = first.text.split_whitespace().collect();
    (2..=3).contains(&words.len()) && words.iter().all(|w| w.bytes().all(|b| b.is_ascii_digit()))
}

/// Reads a model; the files of the values and of the labels are optional.
///
/// # Errors
/// A text is invalid; a limit.
pub(crate) fn load(
    frame: &Frame<'_>,
    values: Option<&Arc<SourceFile>>,
    labels: Option<&Arc<SourceFile>>,
) -> Result<Checked> {
    frame.refuse_values()?;
    let mut poll = Poll::new(frame.sink);
    let mut table = transitions(frame, &mut poll)?;
    if let Some(values) = values {
        table.columns = columns(values, table.states(), &mut poll)?;
    }
    match labels {
        Some(labels) => read_labels(labels, &mut table, &mut poll)?,
        None => table.initial.push(0),
    }
    frame.lower(table)
}

/// A line of the file of transitions.
struct Transition<'s> {
    state: usize,
    choice: usize,
    target: usize,
    weight: &'s str,
    action: Option<&'s str>,
}

fn transitions(frame: &Frame<'_>, poll: &mut Poll<'_>) -> Result<Table> {
    let mut all = lines(frame.source, "#");
    let Some(first) = all.next() else { return Err(frame.wrong("the file is empty")) };
    let counts = first.text.split_whitespace().map(|w| first.index(w)).collect::<Result<Vec<_>>>()?;
    // Deadlocks have no line; each state counts for at least one byte of the text.
    if counts[0] == 0 || counts[0] > frame.source.text.len() {
        return Err(first.wrong(format!("the file has no transitions of {} states", counts[0])));
    }
    let is_mdp = counts.len() == 3;
    let mut table = Table::new(if is_mdp { ModelKind::Mdp } else { ModelKind::Dtmc });
    let mut actions = Actions::default();
    let mut last = None;
    for line in all {
        poll.step()?;
        let read = transition(line, is_mdp)?;
        let at = Some((read.state, read.choice));
        if at < last {
            return Err(line.wrong("the transitions are not sorted by state and choice"));
        }
        if read.state >= counts[0] {
            return Err(line.wrong(format!("state {} is not one of {}", read.state, counts[0])));
        }
        let action = read.action.map(|name| actions.add(name));
        if at != last {
            table.choices.resize(read.state + 2, table.action_of.len());
            table.action_of.push(action);
            table.branches.push(0);
            last = at;
        } else if table.action_of.last() != Some(&action) {
            return Err(two_actions(line, &read, &table, &actions));
        }
        table.branch(read.target, line.number(read.weight)?);
    }
    let choices = table.action_of.len();
    table.choices.resize(counts[0] + 1, choices);
    let found = [table.states(), choices, table.targets.len()];
    let found: &[usize] = if is_mdp { &found } else { &[found[0], found[2]] };
    if found != counts {
        return Err(first.wrong(format!("the numbers of this line are {found:?} in the file")));
    }
    table.actions = actions.names;
    Ok(table)
}

/// Returns the error for a choice whose lines have different actions.
fn two_actions(line: Line<'_>, read: &Transition<'_>, table: &Table, actions: &Actions) -> Error {
    let known = table.action_of.last().copied().flatten().map(|action| actions.names[action].as_str());
    let shown =
        |name: Option<&str>| name.map_or("no action".to_owned(), |name| format!("the action `{name}`"));
    let (state, choice) = (read.state, read.choice);
    line.part(read.action.unwrap_or(line.text)).wrong(format!(
        "choice {choice} of state {state} has {} here, and {} in the lines before",
        shown(read.action),
        shown(known)
    ))
}

fn transition<'s>(line: Line<'s>, is_mdp: bool) -> Result<Transition<'s>> {
    let mut words = line.text.split_whitespace();
    let form = if is_mdp { "`state choice target probability action`" } else { "`state target probability`" };
    let mut next = || words.next().ok_or_else(|| line.wrong(format!("expected {form}")));
    let state = line.index(next()?)?;
    let choice = if is_mdp { line.index(next()?)? } else { 0 };
    let target = line.index(next()?)?;
    let weight = next()?;
    let (action, more) = (words.next(), words.next());
    if more.is_some() {
        return Err(line.wrong(format!("expected {form}")));
    }
    Ok(Transition { state, choice, target, weight, action })
}

/// Reads `(x,b)`, then one line such as `0:(3,true)` per state.
fn columns(source: &Arc<SourceFile>, states: usize, poll: &mut Poll<'_>) -> Result<Vec<Column>> {
    let mut columns: Vec<Column> = Vec::new();
    let mut types: Vec<Option<Type>> = Vec::new();
    let mut state = 0;
    for line in lines(source, "#") {
        poll.step()?;
        if columns.is_empty() {
            columns = distinct(line, cells(line, line.text)?, "variable")?.map(column).collect();
            types = vec![None; columns.len()];
            continue;
        }
        let Some((number, rest)) = line.text.split_once(':') else {
            return Err(line.wrong("expected a line such as `0:(3,true)`"));
        };
        let cells: Vec<&str> = cells(line, rest)?.collect();
        if line.index(number.trim())? != state || cells.len() != columns.len() {
            let message = format!("expected {} values of state {state}", columns.len());
            return Err(line.wrong(message));
        }
        for ((cell, column), ty) in cells.into_iter().zip(&mut columns).zip(&mut types) {
            let (value, found) = value(line, cell)?;
            if *ty.get_or_insert(found) != found {
                return Err(line.wrong(format!("`{cell}` has another type than the values before")));
            }
            column.ty = found;
            column.values.push(value);
        }
        state += 1;
    }
    for column in &mut columns {
        let least = column.values.iter().min().copied().unwrap_or_default();
        let most = column.values.iter().max().copied().unwrap_or_default();
        (column.low, column.high) = if column.ty == Type::Bool { (0, 1) } else { (least, most) };
    }
    match lines(source, "#").next() {
        Some(first) if state != states => {
            Err(first.wrong(format!("the file has values of {state} states, the model has {states}")))
        }
        _ => Ok(columns),
    }
}

/// Returns names of a line, each of which must occur once.
fn distinct<'s>(
    line: Line<'s>,
    names: impl Iterator<Item = &'s str>,
    what: &str,
) -> Result<impl Iterator<Item = &'s str>> {
    let (all, mut known) = (names.collect::<Vec<_>>(), AHashSet::new());
    match all.iter().find(|name| !known.insert(**name)) {
        Some(name) => Err(line.part(name).wrong(format!("the {what} `{name}` occurs twice"))),
        None => Ok(all.into_iter()),
    }
}

fn column(name: &str) -> Column {
    let (name, values) = (name.to_owned(), Vec::new());
    Column { name, ty: Type::Int, low: 0, high: 0, names: Vec::new(), values }
}

/// Returns the texts between brackets, which commas separate.
fn cells<'s>(line: Line<'s>, text: &'s str) -> Result<impl Iterator<Item = &'s str>> {
    let inside = text.trim().strip_prefix('(').and_then(|t| t.strip_suffix(')'));
    let inside = inside.ok_or_else(|| line.wrong("expected `(`, texts separated by commas, and `)`"))?;
    Ok(inside.split(',').map(str::trim))
}

fn value(line: Line<'_>, cell: &str) -> Result<(i64, Type)> {
    match (cell, cell.parse::<i64>()) {
        ("true", _) => Ok((1, Type::Bool)),
        ("false", _) => Ok((0, Type::Bool)),
        (_, Ok(value)) if value.unsigned_abs() <= 1 << 53 => Ok((value, Type::Int)),
        _ => Err(line.wrong(format!("`{cell}` is not a Boolean, and not an integer up to 2^53"))),
    }
}

/// Reads `0="init" 1="goal"`, then lines such as `3: 0 1`.
fn read_labels(source: &Arc<SourceFile>, table: &mut Table, poll: &mut Poll<'_>) -> Result<()> {
    let mut all = lines(source, "#");
    let Some(first) = all.next() else { return Ok(()) };
    let mut names = Vec::new();
    for word in first.text.split_whitespace() {
        let parts = word.split_once('=').filter(|(n, _)| n.parse() == Ok(names.len()));
        let name = parts.and_then(|(_, name)| name.strip_prefix('"')?.strip_suffix('"'));
        names.push(name.ok_or_else(|| {
            first.part(word).wrong("expected labels such as `0=\"init\" 1=\"deadlock\" 2=\"goal\"`")
        })?);
    }
    let names = distinct(first, names.into_iter(), "label")?;
    let mut labels: Vec<(String, Vec<usize>)> = names.map(|name| (name.to_owned(), Vec::new())).collect();
    for line in all {
        poll.step()?;
        let Some((state, numbers)) = line.text.split_once(':') else {
            return Err(line.wrong("expected a state with its labels, such as `3: 0 1`"));
        };
        let state = line.index(state.trim())?;
        if state >= table.states() {
            return Err(line.wrong(format!("state {state} is not one of {}", table.states())));
        }
        for number in numbers.split_whitespace() {
            match labels.get_mut(line.index(number)?) {
                Some((_, states)) => states.push(state),
                None => return Err(line.wrong(format!("there is no label {number}"))),
            }
        }
    }
    let initial = labels.iter().position(|(name, _)| name == "init");
    table.initial = initial.map(|at| labels.swap_remove(at).1).unwrap_or_default();
    table.labels = labels;
    Ok(())
}
