//! The reader of explicit files of PRISM and of Storm: `.tra` with the transitions, and next to it `.sta` with the values
//! (only PRISM) and `.lab` with the labels of the states, `.srew` and `.trew` with rewards.

use std::sync::Arc;

use ahash::AHashSet;

use super::earned::{self, RewardFiles};
use super::lines::{Line, Part, lines};
use super::sections::Sections;
use super::{Column, Frame, Table, numbered_players};
use meliora_base::error::{Error, Result, Severity, SourceFile};
use meliora_base::escape::{quoted, unquoted, unword};
use meliora_base::progress::Poll;
use meliora_base::value::Type;
use meliora_lang::{Actions, Checked};
use meliora_model::ModelKind;

/// Returns true if a text is meant as transitions: its first line has two to four numbers, of which
/// the first may be followed by the number of players, as in `5:2 7 9`. Four are those of a POMDP. In files of Storm, it
/// is the kind of the model, and the second line has numbers.
pub(crate) fn is_tra(source: &Arc<SourceFile>) -> bool {
    let mut all = lines(source, "#");
    let Some(first) = all.next() else { return false };
    let words: Vec<&str> = first.text.split_whitespace().collect();
    let is_number = |word: &&str| word.bytes().all(|b| b.is_ascii_digit());
    match words.as_slice() {
        ["mdp" | "dtmc"] => {
            let second = all.next().map(|line| line.text.split_whitespace().take(2).collect::<Vec<_>>());
            second.is_some_and(|words| words.len() == 2 && words.iter().all(is_number))
        }
        [_, _] | [_, _, _, _] => words.iter().all(is_number),
        [states, others @ ..] if others.len() == 2 => {
            let (states, players) = split_player(states);
            [states].iter().chain(&players).chain(others).all(is_number)
        }
        _ => false,
    }
}

/// Reads a model; the files of the values, of the labels and of rewards are optional.
///
/// # Errors
/// A text is invalid; a limit.
pub(crate) fn load(
    frame: &Frame<'_>,
    values: Option<&Arc<SourceFile>>,
    labels: Option<&Arc<SourceFile>>,
    rewards: &[RewardFiles],
) -> Result<Checked> {
    frame.refuse_values()?;
    let mut poll = Poll::new(frame.sink);
    let sections = Sections::find(frame.source);
    let mut table = transitions(frame, &sections, &mut poll)?;
    if let Some(values) = sections.states.or(values.map(Part::whole)) {
        table.columns = columns(&values, table.states(), &mut poll)?;
    }
    match sections.labels.or(labels.map(Part::whole)) {
        Some(labels) => read_labels(&labels, &mut table, &mut poll)?,
        None => table.initial.push(0),
    }
    earned::add(rewards, &mut table, &mut poll)?;
    if let Some(name) = sections.unread {
        table.warnings.push(format!("a section `# {name}` is not read: it has no effect here"));
    }
    frame.lower(table)
}

/// A line of the file of transitions.
struct Transition<'s> {
    state: usize,
    player: usize,
    choice: usize,
    target: usize,
    weight: &'s str,
    action: Option<&'s str>,
}

/// Splits a word such as `5:2` of a game.
fn split_player(word: &str) -> (&str, Option<&str>) {
    word.split_once(':').map_or((word, None), |(before, after)| (before, Some(after)))
}

/// The numbers of the first line.
struct Counts {
    kind: ModelKind,
    states: usize,
    /// The number of players of a game.
    players: Option<usize>,
    /// The numbers of choices (not for a `dtmc`) and of transitions; none in files of Storm.
    others: Vec<usize>,
}

impl Counts {
    /// Counts the states of a file of Storm: those up to the greatest number.
    fn of_storm<'s>(first: Line<'s>, transitions: impl Iterator<Item = Line<'s>>) -> Result<Self> {
        let kind = if first.text == "dtmc" { ModelKind::Dtmc } else { ModelKind::Mdp };
        let mut states = 0;
        for line in transitions {
            let read = transition(line, kind)?;
            states = states.max(read.state + 1).max(read.target + 1);
        }
        // Deadlocks have no line.
        if states > first.whole().len() {
            return Err(first.wrong(format!("the file has no transitions of {states} states")));
        }
        Ok(Counts { kind, states, players: None, others: Vec::new() })
    }

    fn read(first: Line<'_>) -> Result<Self> {
        let mut words = first.text.split_whitespace();
        let (states, players) = split_player(words.next().unwrap_or_default());
        let states = first.index(states)?;
        let players = players.map(|players| first.index(players)).transpose()?;
        let others: Vec<usize> = words.map(|word| first.index(word)).collect::<Result<_>>()?;
        let kind = match (players, others.len()) {
            (Some(_), _) => ModelKind::Smg,
            (None, 2) => ModelKind::Mdp,
            (None, _) => ModelKind::Dtmc,
        };
        let counts = Counts { kind, states, players, others };
        // Deadlocks have no line, and players need no state; each counts for at least one byte of the text.
        let most = first.whole().len();
        match counts {
            Counts { others, .. } if others.len() > 2 => {
                Err(first.refused("models with observations (POMDPs)"))
            }
            Counts { states, .. } if states == 0 || states > most => {
                Err(first.wrong(format!("the file has no transitions of {states} states")))
            }
            Counts { players: Some(players), .. } if players == 0 || players > most => {
                Err(first.wrong(format!("the file has no transitions of {players} players")))
            }
            counts => Ok(counts),
        }
    }
}

fn transitions(frame: &Frame<'_>, sections: &Sections<'_>, poll: &mut Poll<'_>) -> Result<Table> {
    let mut all = sections.transitions.lines("#");
    let Some(first) = all.next() else { return Err(frame.wrong("the file has no transitions")) };
    let counts = match first.text {
        "mdp" | "dtmc" => Counts::of_storm(first, sections.transitions.lines("#").skip(1))?,
        _ => Counts::read(first)?,
    };
    sections.check(counts.kind)?;
    let mut table = Table::new(counts.kind);
    if let Some(players) = counts.players {
        table.players = numbered_players(players);
        table.owners = vec![0; counts.states];
    }
    let mut actions = Actions::default();
    let mut last: Option<(usize, usize)> = None;
    for line in all {
        poll.step()?;
        let read = transition(line, table.kind)?;
        let at = Some((read.state, read.choice));
        if at < last {
            return Err(line.wrong("the transitions are not sorted by state and choice"));
        }
        if read.state >= counts.states {
            return Err(line.wrong(format!("state {} is not one of {}", read.state, counts.states)));
        }
        if table.kind == ModelKind::Smg {
            let is_first = last.is_none_or(|(state, _)| state < read.state);
            own(line, &read, is_first, &mut table)?;
        }
        let action = read.action.map(|name| actions.add(&unword(name)));
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
    table.choices.resize(counts.states + 1, choices);
    let with_choices = (table.kind != ModelKind::Dtmc).then_some(choices);
    let found = [Some(table.states()), with_choices, Some(table.targets.len())];
    let found: Vec<usize> = found.into_iter().flatten().collect();
    if !counts.others.is_empty() && found[1..] != counts.others {
        return Err(first.wrong(format!("the numbers of this line are {found:?} in the file")));
    }
    table.actions = actions.names;
    Ok(table)
}

/// Records the player of a state of a game.
fn own(line: Line<'_>, read: &Transition<'_>, is_first: bool, table: &mut Table) -> Result<()> {
    let (state, player, count) = (read.state, read.player, table.players.len());
    if player >= count {
        return Err(line.wrong(format!("player {player}, counted from 0, is not one of {count}")));
    }
    let known = std::mem::replace(&mut table.owners[state], player);
    if !is_first && known != player {
        let message =
            format!("state {state} belongs to player {player} here, and to {known} in the lines before");
        return Err(line.wrong(message));
    }
    Ok(())
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

/// Returns the error for a line with all transitions of a choice.
fn in_rows(line: Line<'_>) -> Error {
    let message = "lines with several transitions of a choice are not supported";
    let help = "export the model from PRISM without `-exportrows`, one transition in each line";
    line.diagnostic(message).severity(Severity::Unsupported).help(help).into()
}

fn transition<'s>(line: Line<'s>, kind: ModelKind) -> Result<Transition<'s>> {
    let mut words = line.text.split_whitespace();
    let form = match kind {
        ModelKind::Dtmc => "`state target probability`",
        ModelKind::Mdp => "`state choice target probability action`",
        ModelKind::Smg => "`state:player choice target probability action`",
    };
    let wrong = || line.wrong(format!("expected {form}"));
    let mut next = || words.next().ok_or_else(wrong);
    let (state, player) = match kind {
        ModelKind::Smg => next()?.split_once(':').ok_or_else(wrong)?,
        ModelKind::Mdp | ModelKind::Dtmc => (next()?, "0"),
    };
    let (state, player) = (line.index(state)?, line.index(player)?);
    let choice = if kind == ModelKind::Dtmc { 0 } else { line.index(next()?)? };
    let target = next()?;
    if target.contains(':') {
        return Err(in_rows(line));
    }
    let target = line.index(target)?;
    let weight = next()?;
    let (action, more) = (words.next(), words.next());
    if more.is_some() {
        return Err(wrong());
    }
    Ok(Transition { state, player, choice, target, weight, action })
}

/// Reads `(x,b)`, then one line such as `0:(3,true)` per state.
fn columns(part: &Part<'_>, states: usize, poll: &mut Poll<'_>) -> Result<Vec<Column>> {
    let mut columns: Vec<Column> = Vec::new();
    let mut types: Vec<Option<Type>> = Vec::new();
    let mut state = 0;
    for line in part.lines("#") {
        poll.step()?;
        if columns.is_empty() {
            let names = distinct(line, cells(line, line.text)?, "variable")?;
            columns = names.map(|name| column(line, name)).collect();
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
    match part.lines("#").next() {
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

fn column(line: Line<'_>, name: &str) -> Column {
    let (place, name, values) = (Some(line.part(name).place()), name.to_owned(), Vec::new());
    Column { name, place, ty: Type::Int, low: 0, high: 0, names: Vec::new(), values }
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

/// Returns the names of a line such as `0="init" 1="at goal"`, in which the numbers count from 0.
fn label_names(line: Line<'_>) -> Result<Vec<String>> {
    let (mut names, mut left) = (Vec::new(), line.text);
    while !left.is_empty() {
        let number = left.split_once('=').filter(|(number, _)| number.trim().parse() == Ok(names.len()));
        let Some((name, rest)) = number.and_then(|(_, rest)| unquoted(rest)) else {
            let message = "expected labels such as `0=\"init\" 1=\"deadlock\" 2=\"goal\"`";
            return Err(line.part(left).wrong(message));
        };
        names.push(name);
        left = rest.trim_start();
    }
    Ok(names)
}

/// Reads `0="init" 1="goal"`, then lines such as `3: 0 1`; of Storm, `init goal` between `#DECLARATION` and `#END`, then
/// lines such as `3 init goal`.
fn read_labels(part: &Part<'_>, table: &mut Table, poll: &mut Poll<'_>) -> Result<()> {
    let mut all = part.lines("#");
    let Some(first) = all.next() else { return Ok(()) };
    let of_storm = !first.text.contains('=');
    let names = match of_storm {
        true => first.text.split_whitespace().map(str::to_owned).collect(),
        false => label_names(first)?,
    };
    let mut known = AHashSet::new();
    if let Some(name) = names.iter().find(|name| !known.insert(name.as_str())) {
        let again = first.text.rfind(&quoted(name)).map_or(first.text, |at| &first.text[at + 1..]);
        return Err(first.part(again).wrong(format!("the label `{name}` occurs twice")));
    }
    let mut labels: Vec<(String, Vec<usize>)> = names.into_iter().map(|name| (name, Vec::new())).collect();
    for line in all {
        poll.step()?;
        let (between, form) = if of_storm { (' ', "3 init") } else { (':', "3: 0 1") };
        let Some((state, own)) = line.text.split_once(between) else {
            return Err(line.wrong(format!("expected a state with its labels, such as `{form}`")));
        };
        let state = line.index(state.trim())?;
        if state >= table.states() {
            return Err(line.wrong(format!("state {state} is not one of {}", table.states())));
        }
        for label in own.split_whitespace() {
            let at = match of_storm {
                true => labels.iter().position(|(name, _)| name == label).unwrap_or(usize::MAX),
                false => line.index(label)?,
            };
            match labels.get_mut(at) {
                Some((_, states)) => states.push(state),
                None => return Err(line.wrong(format!("the label {label} is not in the first line"))),
            }
        }
    }
    let initial = labels.iter().position(|(name, _)| name == "init");
    let initial = initial.map(|at| labels.remove(at).1).filter(|states| !states.is_empty());
    let Some(initial) = initial else {
        let help = "the initial states have the label \"init\"; without a file of labels, state 0 is initial";
        return Err(first.diagnostic("no state is labelled \"init\"").help(help).into());
    };
    (table.initial, table.labels) = (initial, labels);
    Ok(())
}
