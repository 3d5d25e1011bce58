//! Errors for commands without a meaning in some state, with the same messages for both engines.

use std::ops::Range;

use super::predicate::Predicate;
use super::step::{MOST_WAYS, StepError};
use super::{CommandId, Program};
use crate::players::Unlisted;
use crate::step::Choice;
use meliora_base::decimal::readable;
use meliora_base::error::{Diagnostic, Error, Limit, Result, Severity};
use meliora_base::exact::Real;

/// Returns the error for a state in which [`Program::steps`] fails.
pub fn in_state(program: &Program, state: &[i64]) -> Error {
    match program.steps(state) {
        Err(fault) => error(program, &fault, state),
        Ok(_) => initial(program, state),
    }
}

/// Returns the error for a predicate without a value in a state.
pub fn in_predicate(program: &Program, predicate: &Predicate, state: &[i64]) -> Error {
    let reason = match predicate.eval(state) {
        Err(reason) => reason.to_string(),
        Ok(_) => "it has no value".to_owned(),
    };
    let message = format!("the expression has no value in the state {}: {reason}", program.show_state(state));
    diagnostic(program, 0..0, message, String::new(), None).into()
}

/// Returns the error for one fault in one state.
pub fn error(program: &Program, fault: &StepError, state: &[i64]) -> Error {
    let at = program.show_state(state);
    match fault.clone() {
        StepError::Eval(id, reason) => {
            let message = format!("{} has no value in the state {at}: {reason}", title(program, id));
            diagnostic(program, span(program, id), message, reason.to_string(), None).into()
        }
        StepError::Probability(id, sum) => {
            let sum = shown(&sum);
            let message = format!("the probabilities of {} give {sum} in the state {at}", title(program, id));
            let help =
                "probabilities lie between 0 and 1 and sum to 1 (within 1e-5) wherever the guard holds";
            let label = format!("gives {sum}");
            diagnostic(program, span(program, id), message, label, Some(help.to_owned())).into()
        }
        StepError::OutOfRange(id, variable, value) => {
            let declared = &program.variables[variable.index()];
            let name = &declared.name;
            let message = format!("{} sets `{name}` to {value} in the state {at}", title(program, id));
            let label = format!("`{name}` becomes {value}, outside [{}..{}]", declared.low, declared.high);
            let help = format!("strengthen the guard, bound the update, or widen the range of `{name}`");
            diagnostic(program, span(program, id), message, label, Some(help)).into()
        }
        StepError::TooMany => {
            let what = format!(
                "the synchronised commands have more than {MOST_WAYS} combinations of branches in the state {at}"
            );
            Limit::Size { what }.into()
        }
    }
}

/// Returns the error for a state of a game in which two players have a choice, or which has several choices and
/// none of a player.
///
/// # Errors
/// A command has no meaning in the state, or it has too many choices.
pub fn of_two_players(program: &Program, state: &[i64]) -> Result<Error> {
    let choices = program.choices(state).map_err(|fault| error(program, &fault, state))?;
    let mut moves: Vec<(usize, String, Range<usize>)> = Vec::new();
    let mut alone: Vec<(String, Range<usize>)> = Vec::new();
    for (choice, name) in choices {
        let Choice::Combination { synchronisation, commands } = choice else { continue };
        let synchronisation = &program.synchronisations[synchronisation];
        let player = program.player_of(synchronisation);
        let (Some(player), Some(&command)) = (player, commands.first()) else { continue };
        if program.unlisted(synchronisation) == Some(Unlisted::Alone) {
            alone.push((name, span(program, command)));
        } else if moves.iter().all(|(other, ..)| *other != player) {
            moves.push((player, name, span(program, command)));
        }
    }
    if moves.is_empty() && alone.len() > 1 {
        return Ok(of_no_player(program, state, &alone));
    }
    let named = |(player, action, _): &(usize, String, _)| {
        let list = program.players.as_ref().map_or(&[][..], |players| &players.list);
        format!("`{}` by `{action}`", list.get(*player).map_or("?", |player| player.name.as_str()))
    };
    let all = moves.iter().map(named).collect::<Vec<_>>().join(" and ");
    let message = format!("several players may move in the state {}: {all}", program.show_state(state));
    let spans = |at: usize| moves.get(at).map_or(0..0, |(_, _, span)| span.clone());
    let label = |at: usize| moves.get(at).map_or_else(String::new, |(_, name, _)| format!("`{name}`"));
    let help = "in a turn-based game each state belongs to one player: let guards say whose turn it is";
    let found = diagnostic(program, spans(1), message, label(1), Some(help.to_owned()));
    Ok(found.related(spans(0), format!("{} is enabled, too", label(0))).into())
}

/// Returns the error for a state with several choices that belong to no player.
fn of_no_player(program: &Program, state: &[i64], alone: &[(String, Range<usize>)]) -> Error {
    let all = alone.iter().map(|(name, _)| format!("`{name}`")).collect::<Vec<_>>().join(" and ");
    let at = program.show_state(state);
    let message = format!("several choices belong to no player in the state {at}: {all}");
    let help =
        "write `player NAME module1, [action1] endplayer`; a single choice there belongs to the first player";
    let span = |at: usize| alone.get(at).map_or(0..0, |(_, span)| span.clone());
    let found = diagnostic(program, span(1), message, "of no player".to_owned(), Some(help.to_owned()));
    found.related(span(0), "of no player, too").into()
}

/// Formats a number that is not a probability, or a wrong sum, by the nearest double, which may be
/// 0 or 1.
fn shown(number: &Real) -> String {
    match number.to_f64() {
        0.0 if !number.is_zero() => "a number just below 0".to_owned(),
        1.0 if *number != Real::from(1) => "a number just above 1".to_owned(),
        near => readable(near),
    }
}

/// Returns the warning about probabilities found by [`Program::rounded_in`].
pub fn rounded(program: &Program, id: CommandId, sum: f64, state: &[i64]) -> Diagnostic {
    let at = program.show_state(state);
    let message = format!("the probabilities of {} sum to {sum} in the state {at}", title(program, id));
    let help = "sums within 1e-5 of 1 are treated as 1; fractions such as 1/3 are exact";
    diagnostic(program, span(program, id), message, "not 1".to_owned(), Some(help.to_owned()))
        .severity(Severity::Warning)
}

/// Returns the error for an expression of the initial states that has no value.
fn initial(program: &Program, state: &[i64]) -> Error {
    let at = program.show_state(state);
    let message = format!("the expression for the initial states has no value in the state {at}");
    diagnostic(program, 0..0, message, String::new(), None).into()
}

/// Returns a short description of a command, such as "command 2 of `m` for [a]".
fn title(program: &Program, id: CommandId) -> String {
    let command = &program.commands[id.index()];
    let module = &program.modules[command.module];
    if program.monitors.as_ref().is_some_and(|o| o.module == command.module) {
        return "a state formula of a temporal objective".to_owned();
    }
    if program.stop == Some(id) {
        return "the condition of the states where paths stop".to_owned();
    }
    match command.action {
        Some(action) => format!("command {} of `{module}` for [{}]", command.number, program.actions[action]),
        None => format!("command {} of `{module}` without a label", command.number),
    }
}

fn span(program: &Program, id: CommandId) -> Range<usize> {
    program.commands[id.index()].span.range()
}

fn diagnostic(
    program: &Program,
    span: Range<usize>,
    message: String,
    label: String,
    help: Option<String>,
) -> Diagnostic {
    Diagnostic { label, help, ..Diagnostic::new(&program.source, span, message) }
}
