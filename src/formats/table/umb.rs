//! The reader of UMB archives.

use ahash::{AHashMap, AHashSet};

use super::{Frame, Rewards, Table, numbered_players, valuations};
use crate::umb::archive::Files;
use crate::umb::binary::Number;
use crate::umb::index::{Annotation, Base, Index, TransitionSystem, Type};
use crate::umb::{
    self, ACTION_NAMES, ACTION_OF_CHOICE, BRANCH_TO_PROBABILITY, BRANCH_TO_TARGET, CHOICE_TO_BRANCHES, INDEX,
    STATE_IS_INITIAL, STATE_TO_CHOICES, STATE_TO_PLAYER,
};
use meliora_base::error::{Limit, Result};
use meliora_base::progress::Poll;
use meliora_lang::{Actions, Checked};
use meliora_model::ModelKind;
use meliora_model::expr::ExprId;

/// A number of states, choices and branches that needs no data.
const FEW: u64 = 1 << 12;

/// Reads an unpacked archive.
///
/// # Errors
/// The archive is not a model, or a model that is not supported; a limit.
pub(crate) fn load(files: &Files, frame: &Frame<'_>) -> Result<Checked> {
    frame.refuse_values()?;
    let bytes = files.get(INDEX).ok_or_else(|| files.wrong(INDEX, "the archive has no such file"))?;
    let index: Index = serde_json::from_slice(bytes).map_err(|e| files.wrong(INDEX, &e.to_string()))?;
    if index.format_version != 1 {
        let message = format!("version {} of the format is not supported", index.format_version);
        return Err(files.wrong(INDEX, &message));
    }
    let reader = UmbReader { files, index: &index };
    frame.lower(reader.table(frame)?)
}

struct UmbReader<'f> {
    files: &'f Files,
    index: &'f Index,
}

impl UmbReader<'_> {
    fn system(&self) -> &TransitionSystem {
        &self.index.transition_system
    }

    fn table(&self, frame: &Frame<'_>) -> Result<Table> {
        let system = self.system();
        let mut table = Table::new(self.kind()?);
        let [states, choices, branches] = self.sizes()?;
        table.choices = self.files.rows(STATE_TO_CHOICES, states, choices)?;
        table.branches = self.files.rows(CHOICE_TO_BRANCHES, choices, branches)?;
        table.targets = self.targets(branches)?;
        table.probabilities = self.probabilities(&mut table, branches)?;
        table.initial = self.files.members(STATE_IS_INITIAL, states)?;
        if table.initial.len() as u64 != system.initial_states {
            let message = format!("{} states, the index says {}", table.initial.len(), system.initial_states);
            return Err(self.files.wrong(STATE_IS_INITIAL, &message));
        }
        self.players(&mut table, states)?;
        self.actions(&mut table, choices)?;
        self.labels(&mut table)?;
        self.rewards(&mut table)?;
        if let Some(description) = self.index.valuations.get("states") {
            let mut poll = Poll::new(frame.sink);
            match valuations::columns(self.files, description, states, &mut poll)? {
                Some(columns) => table.columns = columns,
                None => {
                    table.warnings.push("the state variables are left out: there are too many".to_owned())
                }
            }
        }
        Ok(table)
    }

    /// Refuses kinds of models that are not supported.
    fn kind(&self) -> Result<ModelKind> {
        let system = self.system();
        let is_interval = system.branch_probability_type.is_some_and(Type::is_interval);
        let what = if system.time != "discrete" {
            format!("models with time \"{}\"", system.time)
        } else if system.observations > 0 {
            "models with partial observability".to_owned()
        } else if is_interval {
            "intervals of probabilities".to_owned()
        } else if system.branch_probability_type.is_none() && system.branches != system.choices {
            "choices with several branches and no probabilities".to_owned()
        } else {
            return Ok(match system.players {
                0 => ModelKind::Dtmc,
                1 => ModelKind::Mdp,
                _ => ModelKind::Smg,
            });
        };
        Err(self.files.wrong(INDEX, &format!("{what} are not supported")))
    }

    /// Returns the numbers of states, choices and branches. Files that are left out stand for
    /// default values; the numbers may still not exceed the size of the archive.
    fn sizes(&self) -> Result<[usize; 3]> {
        let system = self.system();
        let sizes = [system.states, system.choices, system.branches];
        let most = self.files.bytes().max(FEW);
        if sizes.iter().any(|n| *n > most) || u64::from(system.players) > most {
            let [states, choices, branches] = sizes;
            let (name, players) = (self.files.name(), system.players);
            let what = format!(
                "{name}: {states} states, {choices} choices, {branches} branches and {players} players, \
                 without data for them"
            );
            return Err(Limit::Size { what }.into());
        }
        Ok(sizes.map(|n| usize::try_from(n).unwrap_or(usize::MAX)))
    }

    /// Reads the players of a game, and the player of each state. Without a file, all
    /// states belong to the first player.
    fn players(&self, table: &mut Table, states: usize) -> Result<()> {
        let count = self.system().players;
        let owners = self.files.halves(STATE_TO_PLAYER, states)?.unwrap_or_default();
        if let Some((state, owner)) = owners.iter().enumerate().find(|(_, owner)| **owner >= count) {
            let message = format!("state {state} belongs to player {owner}, counted from 0, of {count}");
            return Err(self.files.wrong(STATE_TO_PLAYER, &message));
        }
        let names = self.system().player_names.clone().unwrap_or_else(|| numbered_players(count as usize));
        if names.len() != count as usize {
            let message = format!("{} player names of {count} players", names.len());
            return Err(self.files.wrong(INDEX, &message));
        }
        let mut known = AHashSet::new();
        if let Some(twice) = names.iter().find(|name| !known.insert(name.as_str())) {
            return Err(self.files.wrong(INDEX, &format!("two players have the name `{twice}`")));
        }
        if table.kind == ModelKind::Smg {
            table.owners = owners.into_iter().map(|owner| owner as usize).collect();
            table.players = names;
        }
        Ok(())
    }

    fn targets(&self, branches: usize) -> Result<Vec<usize>> {
        let Some(words) = self.files.words(BRANCH_TO_TARGET, branches)? else { return Ok(vec![0; branches]) };
        Ok(words.into_iter().map(|w| usize::try_from(w).unwrap_or(usize::MAX)).collect())
    }

    fn probabilities(&self, table: &mut Table, branches: usize) -> Result<Vec<ExprId>> {
        let Some(ty) = self.system().branch_probability_type else {
            return Ok(vec![table.double(1.0); branches]);
        };
        let found = self.numbers(table, BRANCH_TO_PROBABILITY, ty, branches)?;
        found.ok_or_else(|| self.files.wrong(BRANCH_TO_PROBABILITY, "the file is missing"))
    }

    /// Returns numbers as literals, doubles with their exact values.
    fn numbers(&self, table: &mut Table, path: &str, ty: Type, n: usize) -> Result<Option<Vec<ExprId>>> {
        let Some(numbers) = self.files.numbers(path, ty, n)? else { return Ok(None) };
        let literal = |number| match number {
            Number::Double(x) => table.double(x),
            Number::Rational(ratio) => table.number(ratio),
        };
        Ok(Some(numbers.into_iter().map(literal).collect()))
    }

    /// Reads the actions of choices. The empty name stands for no action.
    fn actions(&self, table: &mut Table, choices: usize) -> Result<()> {
        let count = self.system().choice_actions as usize;
        if count == 0 {
            table.action_of = vec![None; choices];
            return Ok(());
        }
        let numbers = self.files.halves(ACTION_OF_CHOICE, choices)?.unwrap_or_else(|| vec![0; choices]);
        let names = self.files.strings(ACTION_NAMES, count)?;
        let mut actions = Actions::default();
        let known: Vec<Option<usize>> =
            names.iter().flatten().map(|name| (!name.is_empty()).then(|| actions.add(name))).collect();
        table.actions = actions.names;
        for number in numbers {
            let number = number as usize;
            if number >= count {
                let message = format!("the action {number} is not one of {count}");
                return Err(self.files.wrong(ACTION_OF_CHOICE, &message));
            }
            table.action_of.push(match names {
                Some(_) => known[number],
                None => Some(number),
            });
        }
        if names.is_none() {
            let most = table.action_of.iter().flatten().max().map_or(0, |n| n + 1);
            table.actions = (0..most).map(|n| n.to_string()).collect();
        }
        Ok(())
    }

    /// Returns the annotations of a group with their identifiers and names.
    fn group(&self, group: &str) -> Result<Vec<(&String, String, &Annotation)>> {
        let mut known: AHashMap<&str, &str> = AHashMap::new();
        let mut all = Vec::new();
        for (id, annotation) in self.index.annotations.get(group).iter().flat_map(|group| &group.0) {
            let name = annotation.alias.as_ref().unwrap_or(id);
            if let Some(other) = known.insert(name, id) {
                let message = format!("`{other}` and `{id}` of \"{group}\" have the same name `{name}`");
                return Err(self.files.wrong(INDEX, &message));
            }
            all.push((id, name.clone(), annotation));
        }
        Ok(all)
    }

    /// Reads the atomic propositions.
    fn labels(&self, table: &mut Table) -> Result<()> {
        for (id, name, annotation) in self.group("aps")? {
            let of_states = annotation.applies_to.iter().all(|of| of == "states");
            if !of_states || annotation.ty.base != Base::Bool {
                let message = format!("the atomic proposition {id} is not a Boolean of states");
                return Err(self.files.wrong(INDEX, &message));
            }
            let path = umb::annotation("aps", id, "states") + "/values.bin";
            let states = self.files.members(&path, table.states())?;
            table.labels.push((name, states));
        }
        Ok(())
    }

    /// Reads the rewards. What branches earn becomes the expected reward of the choice.
    fn rewards(&self, table: &mut Table) -> Result<()> {
        let sizes = [table.states(), table.branches.len() - 1, table.targets.len()];
        for (id, name, annotation) in self.group("rewards")? {
            if annotation.probability_type.is_some() {
                return Err(self
                    .files
                    .wrong(INDEX, &format!("the reward {id}: distributions are not supported")));
            }
            let mut rewards = Rewards { name: Some(name), states: None, choices: None };
            let mut of_branches = None;
            for of in &annotation.applies_to {
                let (slot, n) = match of.as_str() {
                    "states" => (&mut rewards.states, sizes[0]),
                    "choices" => (&mut rewards.choices, sizes[1]),
                    "branches" => (&mut of_branches, sizes[2]),
                    _ => return Err(self.files.wrong(INDEX, &format!("the reward {id} applies to {of}"))),
                };
                let path = umb::annotation("rewards", id, of) + "/values.bin";
                *slot = self.numbers(table, &path, annotation.ty, n)?;
            }
            if let Some(earned) = of_branches {
                rewards.choices = Some(table.expected(rewards.choices.as_deref(), &earned));
            }
            table.rewards.push(rewards);
        }
        Ok(())
    }
}
