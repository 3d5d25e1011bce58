//! Games in pages: the players, whose move it is, and where they stand. The states of ours are
//! square, those of the opponent round; the signs of the players have the same shapes.

use maud::{Markup, html};
use serde_json::{Value as Json, json};

use super::paint::{Paint, SIDE};
use super::words::all_of;
use crate::players::PlayerSummary;
use meliora_base::diagram::Edge;
use meliora_export::projections::{GameView, MoveView, Plane, Projections, View};

/// The radius of the corners of a cell of the opponent.
const ROUND: usize = 17;

/// Returns the radius of the corners of a cell, if they are round.
pub(super) fn corners(is_theirs: bool) -> Option<usize> {
    is_theirs.then_some(ROUND)
}

/// Renders a player with its sign.
pub(super) fn who(name: &str, ours: bool) -> Markup {
    html! { span class=(format!("who {}", side(ours))) { (name) } }
}

/// Returns the class of what belongs to us, or to the opponent.
pub(super) fn side(ours: bool) -> &'static str {
    if ours { "ours" } else { "theirs" }
}

/// Returns the opponent in words: `guard`, `guard and thief`; `None` if there is none.
fn opponent(players: &[PlayerSummary]) -> Option<String> {
    let names: Vec<String> = players.iter().filter(|p| !p.ours).map(|p| p.name.clone()).collect();
    (!names.is_empty()).then(|| all_of(&names))
}

/// Says against whom the results hold.
pub(super) fn promise(players: &[PlayerSummary]) -> Option<String> {
    opponent(players).map(|names| format!("This holds against every strategy of {names}."))
}

/// Explains the shapes in the maps.
pub(super) fn key(players: &[PlayerSummary], paint: &Paint<'_>) -> Markup {
    let others = others(paint.projections);
    let placed = |at: usize| others.iter().any(|(player, _)| *player == at);
    html! {
        p.hint.players {
            @for (at, player) in players.iter().enumerate() {
                (who(&player.name, player.ours))
                @if player.ours { " is ours, and moves in square cells" }
                @else { " is the opponent, and moves in round cells" }
                @if placed(at) { "; its sign also shows where it stands" }
                ". "
            }
        }
    }
}

/// Returns the legend of a separate picture: a sign and its meaning.
pub(super) fn legend(players: &[PlayerSummary]) -> impl Iterator<Item = (&'static str, String)> + '_ {
    players.iter().map(|p| (if p.ours { "■" } else { "●" }, format!("{} moves", p.name)))
}

/// Returns the positions that other pairs of variables give.
fn others(projections: &Projections) -> &[(usize, Plane)] {
    let all = projections.game.as_ref().map_or(&[][..], |game| &game.positions);
    let own = all.iter().take_while(|(_, plane)| *plane == projections.plane).count();
    &all[own..]
}

/// Returns whether the position of the plane is one of ours: it is not the opponent's.
fn is_own_ours(projections: &Projections) -> Option<bool> {
    let game = projections.game.as_ref()?;
    let (player, _) = game.positions.first().filter(|(_, plane)| *plane == projections.plane)?;
    Some(game.players[*player].ours)
}

/// Renders the mark of the position in a run; the script moves it.
pub(super) fn token(projections: &Projections) -> Markup {
    let drawn = match is_own_ours(projections) {
        Some(true) => html! { rect x="8" y="8" width=(SIDE - 16) height=(SIDE - 16) {} },
        Some(false) | None => html! { circle cx=(SIDE / 2) cy=(SIDE / 2) r="13" {} },
    };
    html! { g.token.theirs[is_own_ours(projections) == Some(false)] visibility="hidden" { (drawn) } }
}

/// Renders the other players at their places in a view; the script moves them.
pub(super) fn pieces(
    projections: &Projections,
    view: &View,
    corner: impl Fn(i64, i64) -> Option<(usize, usize)>,
) -> Markup {
    let Some(game) = &projections.game else { return html! {} };
    html! {
        @for (player, plane) in others(projections) {
            @let player = &game.players[*player];
            @let row = plane.row.map(|row| row.index());
            @let place = row.and_then(|row| corner(view[row]?, view[plane.column.index()]?));
            @let (x, y) = place.unwrap_or_default();
            g class=(format!("piece {}", side(player.ours)))
                data-row=[row] data-col=(plane.column.index())
                transform=(format!("translate({x},{y})")) visibility=(if place.is_some() { "visible" } else { "hidden" }) {
                title { (player.name) }
                g.sign transform="translate(30,10)" {
                    @if player.ours { rect x="-9" y="-9" width="18" height="18" {} } @else { circle r="9" {} }
                    text y="4.5" { (player.name.chars().take(1).collect::<String>()) }
                }
            }
        }
    }
}

/// Returns the data of the page's script.
pub(super) fn data(projections: &Projections) -> Option<Json> {
    let GameView { players, moves, .. } = projections.game.as_ref()?;
    let numbers = |edges: &[Edge]| edges.iter().map(|edge| edge.number()).collect::<Vec<_>>();
    let one = |m: &MoveView| {
        json!({
            "choice": m.choice,
            "enabled": m.enabled.number(),
            "improves": [m.improves.number(), m.may_improve.number()],
            "weakens": [m.weakens.number(), m.may_weaken.number()],
            "sasi": numbers(&m.sasi),
            "spi": numbers(&m.spi),
        })
    };
    Some(json!({
        "round": ROUND,
        "players": players.iter().map(|p| json!({"name": p.name, "ours": p.ours, "edge": p.states.number()})).collect::<Vec<_>>(),
        "moves": moves.iter().map(one).collect::<Vec<_>>(),
    }))
}
