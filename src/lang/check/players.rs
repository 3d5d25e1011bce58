//! The players of a game: who owns each module and each action.

use ahash::{AHashMap, AHashSet};

use super::collect::Parts;
use super::lowerer::Lowerer;
use crate::ast::{Ident, Player, PlayerItem, Span, System, SystemKind};
use meliora_base::error::Severity;
use meliora_model::ModelKind;
use meliora_model::players::{self, Players};

/// The owners of modules or of actions, by name.
type Owners<'a> = AHashMap<&'a str, (usize, Span)>;

impl<'a> Lowerer<'a> {
    /// Returns the players of a game; the first one is ours. Reports players of other models, and
    /// modules and actions that belong to two players.
    pub(super) fn players(
        &mut self,
        kind: Option<(ModelKind, Span)>,
        parts: &Parts<'a>,
        actions: &[String],
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
