//! The names of regions, defined once for listing, for dumps and for their checker.
//!
//! `kind` is `sasi` or `spi`, `level` a number from 1 or [`UNBOUNDED`], `class` the name of a class.

use std::fmt::Display;

/// All states of the scope.
pub const REACHABLE: &str = "reachable";
/// The initial states.
pub const INITIAL: &str = "initial";
/// The states without an enabled command.
pub const DEADLOCK: &str = "deadlock";
/// All enabled choices.
pub const CHOICES: &str = "choices";
/// The states from which the requirements cannot be kept.
pub const UNSAFE: &str = "unsafe";
/// The states of a game in which the opponent can weaken, under `action`.
pub const BAD: &str = "bad";
/// The level of the states from which any number of improvements is possible.
pub const UNBOUNDED: &str = "unbounded";
/// The class of the states without an almost-sure objective.
pub const NOTHING: &str = "nothing";

/// Returns `player:p`: the states in which a player of a game chooses.
pub fn player(name: &str) -> String {
    format!("player:{name}")
}

/// Returns `target:A`.
pub fn target(objective: &str) -> String {
    format!("target:{objective}")
}

/// Returns `almost-sure:A`.
pub fn almost_sure(objective: &str) -> String {
    format!("almost-sure:{objective}")
}

/// Returns `secured:A:1`: the region of a disjunct, numbered from 1, of an objective over whole
/// paths.
pub fn secured(objective: &str, case: usize) -> String {
    format!("secured:{objective}:{case}")
}

/// Returns `secured:A:1:2`: the part of such a region's certificate for its second recurring mark.
pub fn recurring(secured: &str, mark: usize) -> String {
    format!("{secured}:{mark}")
}

/// Returns `positive:A`.
pub fn positive(objective: &str) -> String {
    format!("positive:{objective}")
}

/// Returns `A+B`, or `nothing`: the name of a class by its most preferred objectives, in the order
/// of declaration.
pub fn members(objectives: &[&str]) -> String {
    if objectives.is_empty() { NOTHING.to_owned() } else { objectives.join("+") }
}

/// Returns `class:A+B`.
pub fn class(class: &str) -> String {
    format!("class:{class}")
}

/// Returns `sasi:1`.
pub fn level(kind: &str, level: impl Display) -> String {
    format!("{kind}:{level}")
}

/// Returns whether the name is that of a level of this kind, or of the strategy of one.
pub fn is_level(name: &str, kind: &str) -> bool {
    let region = name.strip_prefix("strategy:").unwrap_or(name);
    region.strip_prefix(kind).is_some_and(|rest| rest.starts_with(':'))
}

/// Returns whether a region, or the strategy of one, follows from the model, its states and the
/// requirements alone, whatever the objectives are.
pub fn is_of_model(name: &str) -> bool {
    matches!(name, REACHABLE | INITIAL | DEADLOCK | CHOICES | UNSAFE) || name.starts_with("player:")
}

/// Returns whether a region, or the strategy of one, is one of an objective.
pub fn is_of_objective(name: &str, objective: &str) -> bool {
    let region = name.strip_prefix("strategy:").unwrap_or(name);
    let secured = || region.strip_prefix("secured:")?.strip_prefix(objective)?.strip_prefix(':');
    [target(objective), positive(objective), almost_sure(objective)].iter().any(|own| own == region)
        || secured().is_some()
}

/// Returns `sasi:1@A+B`: a level with a class as the reference.
pub fn against(level: &str, class: &str) -> String {
    format!("{level}@{class}")
}

/// Returns `strategy:sasi:1`.
pub fn strategy(region: &str) -> String {
    format!("strategy:{region}")
}

/// Returns the name of the fixpoint of a level: `spi:unbounded` for `spi:3`; none if the name is
/// not one of a numbered level.
pub fn unbounded_of(name: &str) -> Option<String> {
    let (of, number) = name.rsplit_once(':')?;
    let is_level = matches!(of, "sasi" | "spi" | "strategy:sasi" | "strategy:spi");
    (is_level && number.parse::<u64>().ok()? > 0).then(|| level(of, UNBOUNDED))
}

/// Returns true if the name is that of a strategy.
pub fn is_strategy(name: &str) -> bool {
    name.starts_with("strategy:")
}

/// Returns `safe:A+B`: the states from which a strategy avoids weakening a class forever.
pub fn safe(class: &str) -> String {
    format!("safe:{class}")
}

/// Returns `layers:sasi:1:0`: the states of a region in this layer on the way to its goal.
pub fn layer(region: &str, layer: usize) -> String {
    format!("layers:{region}:{layer}")
}

/// Returns `refuted:sasi:1:0`: the states outside of a region that this round removes.
pub fn refuted(region: &str, round: usize) -> String {
    format!("refuted:{region}:{round}")
}

/// Returns true if the name is that of a layer.
pub fn is_layer(name: &str) -> bool {
    name.starts_with("layers:")
}

/// Returns true if the name is that of a round.
pub fn is_round(name: &str) -> bool {
    name.starts_with("refuted:")
}
