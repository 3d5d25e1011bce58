//! Reward structures next to the transitions of PRISM: `.srew` with the rewards of states, and `.trew` with those of
//! transitions. What transitions earn becomes the expected reward of their choice.

use std::sync::Arc;

use num_traits::Zero;

use super::lines::{Line, Part};
use super::{Rewards, Table};
use meliora_base::error::{Result, SourceFile};
use meliora_base::escape::unquoted;
use meliora_base::exact::Ratio;
use meliora_base::progress::Poll;
use meliora_model::ModelKind;
use meliora_model::expr::ExprId;

/// The files of a reward structure: of states, and of transitions.
pub type RewardFiles = [Option<Arc<SourceFile>>; 2];

/// Adds the reward structures of some files to a model.
///
/// # Errors
/// A text is invalid; a limit.
pub(super) fn add(files: &[RewardFiles], table: &mut Table, poll: &mut Poll<'_>) -> Result<()> {
    for [states, transitions] in files {
        let name = states.iter().chain(transitions).find_map(name);
        let states = states.as_ref().map(|file| of_states(file, table, poll)).transpose()?;
        let choices = transitions.as_ref().map(|file| of_choices(file, table, poll)).transpose()?;
        table.rewards.push(Rewards { name, states, choices });
    }
    Ok(())
}

/// Returns the name of a structure: `# Reward structure "cost"`, or with a colon before the name.
fn name(file: &Arc<SourceFile>) -> Option<String> {
    Part::whole(file).all_lines().take_while(|line| line.text.starts_with('#')).find_map(|line| {
        let rest = line.text.strip_prefix("# Reward structure")?;
        unquoted(rest.trim_start_matches(':').trim_start()).map(|(name, _)| name)
    })
}

/// Returns the lines behind the first one, whose first number is that of the states.
fn rows<'s>(file: &'s Arc<SourceFile>, table: &Table) -> Result<impl Iterator<Item = Line<'s>> + use<'s>> {
    let mut all = Part::whole(file).lines("#");
    if let Some(first) = all.next() {
        let (states, count) = (first.text.split_whitespace().next().unwrap_or_default(), table.states());
        if first.index(states)? != count {
            return Err(
                first.wrong(format!("the file has rewards of {states} states, the model has {count}"))
            );
        }
    }
    Ok(all)
}

/// Reads lines such as `3 2.5`: a state and its reward.
fn of_states(file: &Arc<SourceFile>, table: &mut Table, poll: &mut Poll<'_>) -> Result<Vec<ExprId>> {
    let mut earned = vec![Ratio::zero(); table.states()];
    for line in rows(file, table)? {
        poll.step()?;
        let [state, reward] = words(line, "`state reward`")?;
        let state = line.index(state)?;
        let count = earned.len();
        let slot = earned.get_mut(state);
        *slot.ok_or_else(|| line.wrong(format!("state {state} is not one of {count}")))? =
            line.number(reward)?;
    }
    Ok(earned.into_iter().map(|reward| table.number(reward)).collect())
}

/// Reads lines such as `3 0 4 2.5`: a state, a choice (not for a `dtmc`), a target and a reward.
fn of_choices(file: &Arc<SourceFile>, table: &mut Table, poll: &mut Poll<'_>) -> Result<Vec<ExprId>> {
    let mut earned = vec![Ratio::zero(); table.targets.len()];
    for line in rows(file, table)? {
        poll.step()?;
        let (state, choice, target, reward) = match table.kind {
            ModelKind::Dtmc => {
                let [state, target, reward] = words(line, "`state target reward`")?;
                (state, "0", target, reward)
            }
            ModelKind::Mdp | ModelKind::Smg => {
                let [state, choice, target, reward] = words(line, "`state choice target reward`")?;
                // The states of games have their players.
                (state.split(':').next().unwrap_or(state), choice, target, reward)
            }
        };
        let [state, choice, target] = [line.index(state)?, line.index(choice)?, line.index(target)?];
        let row = table.choices.get(state..).and_then(|rest| Some(rest.first()? + choice..*rest.get(1)?));
        let branches = row
            .filter(|row| !row.is_empty())
            .map(|row| table.branches[row.start]..table.branches[row.start + 1]);
        let branch = branches.and_then(|mut all| all.find(|&branch| table.targets[branch] == target));
        let branch = branch.ok_or_else(|| line.wrong("the model has no such transition"))?;
        earned[branch] = line.number(reward)?;
    }
    let earned: Vec<ExprId> = earned.into_iter().map(|reward| table.number(reward)).collect();
    Ok(table.expected(None, &earned))
}

/// Splits a line into words.
fn words<'s, const N: usize>(line: Line<'s>, form: &str) -> Result<[&'s str; N]> {
    let all: Vec<&str> = line.text.split_whitespace().collect();
    all.try_into().map_err(|_| line.wrong(format!("expected {form}")))
}
