//! The players of a game: who owns each module and each action.

use ahash::{AHashMap, AHashSet};

use super::collect::Parts;
use super::lowerer::Lowerer;
use crate::ast::{Ident, Player, PlayerItem, Span, System, SystemKind};
use meliora_base::error::Severity;
use meliora_model::players::{self, Players};
use meliora_model::{Command, ModelKind};

/// The owners of modules or of actions, by name.
type Owners<'a> = AHashMap<&'a str, (usize, Span)>;

impl<'a> Lowerer<'a> {
    /// Returns the players of a game; the first one is ours. Reports players of other models, and
    /// modules and actions that belong to two players or to none.
    pub(super) fn players(
        &mut self,
        kind: Option<(ModelKind, Span)>,
        parts: &Parts<'a>,
        (actions, commands): (&[String], &[Command]),
    ) -> Option<Players> {
        let Some((ModelKind::Smg, place)) = kind else {
            if let Some(player) = parts.players.first() {
                let diagnostic = self.wrong(player.name.span, "only a game has players");
                self.report(diagnostic.help("a game begins with `smg`"));
            }
            return None;
        };
        if parts.players.is_empty() {
            let diagnostic = self.wrong(place, "the game has no player").label("a game");
            self.report(diagnostic.help("write `player NAME module1, [action1] endplayer`"));
            return None;
        }
        if let Some(system) = parts.system {
            self.refuse_other_names(system);
        }
        self.check_names(&parts.players);
        let [modules, of_actions] = self.owners(parts, actions);
        self.check_owned(parts, commands, (&modules, &of_actions), actions);
        let owner = |owners: &Owners<'_>, name: &str| owners.get(name).map(|(player, _)| *player);
        let player = |(at, player): (usize, &&Player)| players::Player {
            name: player.name.name.clone(),
            ours: at == 0,
        };
        Some(Players {
            list: parts.players.iter().enumerate().map(player).collect(),
            of_module: parts.modules.iter().map(|m| owner(&modules, &m.name.name)).collect(),
            of_action: actions.iter().map(|action| owner(&of_actions, action)).collect(),
            span: place.range(),
        })
    }

    fn check_names(&mut self, players: &[&'a Player]) {
        let mut known: AHashMap<&str, Span> = AHashMap::new();
        for Player { name, .. } in players {
            if let Some(first) = known.insert(&name.name, name.span) {
                let message = format!("the player `{}` is defined twice", name.name);
                self.again(name.span, message, first, ["defined again", "defined here first"]);
            }
        }
    }

    /// Returns the owners of modules and of actions. Reports names that are unknown or have two owners.
    fn owners(&mut self, parts: &Parts<'a>, actions: &[String]) -> [Owners<'a>; 2] {
        let [mut modules, mut of_actions] = [Owners::new(), Owners::new()];
        let known_modules: AHashSet<&str> = parts.modules.iter().map(|m| m.name.name.as_str()).collect();
        let known_actions: AHashSet<&str> = actions.iter().map(String::as_str).collect();
        for (player, declared) in parts.players.iter().enumerate() {
            for item in &declared.items {
                let (what, name, is_known, owners) = match item {
                    PlayerItem::Module(name) => {
                        ("module", name, known_modules.contains(&*name.name), &mut modules)
                    }
                    PlayerItem::Action(name) => {
                        ("action", name, known_actions.contains(&*name.name), &mut of_actions)
                    }
                };
                let Ident { name, span } = name;
                if !is_known {
                    self.fail::<()>(*span, format!("unknown {what} `{name}`"));
                } else if let Some((_, first)) = owners.insert(name, (player, *span)) {
                    let message = format!("the {what} `{name}` belongs to two players");
                    self.again(*span, message, first, ["the second one", "the first one"]);
                }
            }
        }
        [modules, of_actions]
    }

    /// Reports commands that belong to no player.
    fn check_owned(
        &mut self,
        parts: &Parts<'a>,
        commands: &[Command],
        (modules, of_actions): (&Owners<'a>, &Owners<'a>),
        actions: &[String],
    ) {
        for command in commands {
            let module = &parts.modules[command.module].name.name;
            let (is_owned, what, item) = match command.action {
                Some(action) => {
                    let name = actions.get(action).map_or("", String::as_str);
                    (of_actions.contains_key(name), format!("the action `{name}`"), format!("[{name}]"))
                }
                None => {
                    let what = format!("the unlabelled commands of the module `{module}`");
                    (modules.contains_key(module.as_str()), what, module.clone())
                }
            };
            // One report for all commands of an owner.
            if !is_owned && command.number == 1 {
                let belong = if command.action.is_some() { "belongs" } else { "belong" };
                let diagnostic = self.wrong(command.span, format!("{what} {belong} to no player"));
                self.report(diagnostic.help(format!("write `player NAME {item} endplayer`")));
            }
        }
    }

    /// Reports operators that give actions other names: which player has a choice would be unclear.
    fn refuse_other_names(&mut self, system: &System) {
        match &system.kind {
            SystemKind::Module(_) => {}
            SystemKind::Full(parts) | SystemKind::Interleaved(parts) => {
                parts.iter().for_each(|part| self.refuse_other_names(part));
            }
            SystemKind::Parallel(a, _, b) => {
                [a, b].into_iter().for_each(|part| self.refuse_other_names(part))
            }
            SystemKind::Hide(..) | SystemKind::Rename(..) => {
                let message = "actions of a game cannot be hidden or renamed in `system … endsystem`";
                let diagnostic = self.wrong(system.span, message).severity(Severity::Unsupported);
                self.report(diagnostic.help("a renamed copy of a module can rename its actions"));
            }
        }
    }
}
