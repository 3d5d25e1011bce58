//! The choices of a game that no player lists: they belong to the player who has other choices in the state.
//!
//! This player depends on the state. So each synchronisation stands in the program once per player,
//! and once for the states in which no player has a choice; its guard contains the case.

use super::lowerer::Lowerer;
use super::system::MAX_SYNCHRONISATIONS;
use meliora_base::value::{Binary, Unary};
use meliora_model::expr::ExprId;
use meliora_model::players::{Players, Unlisted};
use meliora_model::{Command, CommandId, Synchronisation};

impl Lowerer<'_> {
    /// Gives a player to the choices that no player lists. Reports a game that becomes too large.
    pub(super) fn share_unlisted(
        &mut self,
        players: &Players,
        commands: &mut Vec<Command>,
        synchronisations: &mut Vec<Synchronisation>,
    ) -> Option<()> {
        let of: Vec<_> = synchronisations.iter().map(|own| listed(players, commands, own)).collect();
        if of.iter().all(Option::is_some) {
            return Some(());
        }
        let mut cases = Vec::new();
        for player in 0..players.list.len() {
            let own = synchronisations.iter().zip(&of).filter(|(_, owner)| **owner == Some(player));
            let guards: Vec<_> = own.map(|(own, _)| own.enabled_where(&mut self.pool, commands)).collect();
            cases.extend(
                (!guards.is_empty())
                    .then(|| Case { player: Some(player), condition: self.pool.joined(Binary::Or, guards) }),
            );
        }
        let some = self.pool.joined(Binary::Or, cases.iter().map(|case| case.condition).collect());
        cases.push(Case { player: None, condition: self.pool.unary(Unary::Not, some) });
        let size = synchronisations.len().saturating_mul(cases.len());
        if size > MAX_SYNCHRONISATIONS {
            let message =
                format!("more than {MAX_SYNCHRONISATIONS} synchronisations, because no player lists some");
            return self.fail(crate::ast::Span::new(players.span.start, players.span.end), message);
        }
        let (all, mut made) = (std::mem::take(synchronisations), Copies::default());
        for (own, owner) in all.into_iter().zip(of) {
            if owner.is_some() {
                synchronisations.push(own);
                continue;
            }
            for &case in &cases {
                synchronisations.push(made.copy(self, commands, &own, case));
            }
        }
        made.without_originals(commands, synchronisations);
        Some(())
    }
}

/// Returns the player who lists a synchronisation.
fn listed(players: &Players, commands: &[Command], own: &Synchronisation) -> Option<usize> {
    match own.action {
        Some(action) => *players.of_action.get(action)?,
        None => *players.of_module.get(commands[own.factors.first()?.first()?.index()].module)?,
    }
}

/// The states in which a player has other choices, or none has.
#[derive(Clone, Copy)]
struct Case {
    player: Option<usize>,
    condition: ExprId,
}

/// The commands that stand in the program once per case.
#[derive(Default)]
struct Copies(ahash::AHashMap<(CommandId, Option<usize>), CommandId>);

impl Copies {
    /// Returns a synchronisation for one case: that of a player, or of none.
    fn copy(
        &mut self,
        lowerer: &mut Lowerer<'_>,
        commands: &mut Vec<Command>,
        own: &Synchronisation,
        Case { player, condition }: Case,
    ) -> Synchronisation {
        let mut own = own.clone();
        for id in own.factors.first_mut().into_iter().flatten() {
            *id = *self.0.entry((*id, player)).or_insert_with(|| {
                let old = &commands[id.index()];
                let guard = lowerer.pool.binary(Binary::And, old.guard, condition);
                let unlisted = Some(player.map_or(Unlisted::Alone, |player| Unlisted::With(player as u32)));
                let copy = Command { guard, unlisted, ..old.clone() };
                commands.push(copy);
                CommandId(commands.len() as u32 - 1)
            });
        }
        own
    }

    /// Removes the commands that have copies, if no synchronisation has them any more.
    fn without_originals(self, commands: &mut Vec<Command>, synchronisations: &mut [Synchronisation]) {
        let mut kept = vec![true; commands.len()];
        self.0.keys().for_each(|(original, _)| kept[original.index()] = false);
        let used = synchronisations.iter().flat_map(|own| own.factors.iter().flatten());
        used.for_each(|id| kept[id.index()] = true);
        let mut next = 0;
        let number = |&is_kept: &bool| {
            let number = CommandId(next);
            next += u32::from(is_kept);
            number
        };
        let numbers: Vec<CommandId> = kept.iter().map(number).collect();
        for id in synchronisations.iter_mut().flat_map(|own| own.factors.iter_mut().flatten()) {
            *id = numbers[id.index()];
        }
        let mut kept = kept.into_iter();
        commands.retain(|_| kept.next() == Some(true));
    }
}
