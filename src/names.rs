//! The names of regions, in one place: those who list them, who write a dump and who check one ask here.
//!
//! `kind` is `sasi` or `spi`, `level` a number from 1 or [`UNBOUNDED`], `class` the name of a class.

use std::fmt::Display;

/// All states of the scope.
pub const REACHABLE: &str = "reachable";
/// The initial states.
pub const INITIAL: &str = "initial";
/// The states in which nothing is enabled.
pub const DEADLOCK: &str = "deadlock";
/// All enabled choices.
pub const CHOICES: &str = "choices";
/// The level of the states from which any number of improvements can be made.
pub const UNBOUNDED: &str = "unbounded";
/// The class of the states without an objective that is sure.
pub const NOTHING: &str = "nothing";

/// `target:A`
pub fn target(objective: &str) -> String {
    format!("target:{objective}")
}

/// `almost-sure:A`
pub fn almost_sure(objective: &str) -> String {
    format!("almost-sure:{objective}")
}

/// `secured:A:1`: where a case, from 1, of what an objective over whole plays asks can be kept to for ever.
pub fn secured(objective: &str, case: usize) -> String {
    format!("secured:{objective}:{case}")
}

/// `secured:A:1:2`: of such a region the steps towards what comes, second of all, again and again.
pub fn recurring(secured: &str, mark: usize) -> String {
    format!("{secured}:{mark}")
}

/// `positive:A`
pub fn positive(objective: &str) -> String {
    format!("positive:{objective}")
}

/// `A+B`, or `nothing`: a class by its most preferred objectives in the order of declaration.
pub fn members(objectives: &[&str]) -> String {
    if objectives.is_empty() { NOTHING.to_owned() } else { objectives.join("+") }
}

/// `class:A+B`
pub fn class(class: &str) -> String {
    format!("class:{class}")
}

/// `sasi:1`
pub fn level(kind: &str, level: impl Display) -> String {
    format!("{kind}:{level}")
}

/// `sasi:1@A+B`: a level with a class as the reference.
pub fn against(level: &str, class: &str) -> String {
    format!("{level}@{class}")
}

/// `strategy:sasi:1`
pub fn strategy(region: &str) -> String {
    format!("strategy:{region}")
}

/// The fixpoint that a level belongs to: `spi:unbounded` for `spi:3`; none for what is no numbered level.
pub fn unbounded_of(name: &str) -> Option<String> {
    let (of, number) = name.rsplit_once(':')?;
    let is_level = matches!(of, "sasi" | "spi" | "strategy:sasi" | "strategy:spi");
    (is_level && number.parse::<u64>().ok()? > 0).then(|| level(of, UNBOUNDED))
}

/// Whether a name is that of a strategy.
pub fn is_strategy(name: &str) -> bool {
    name.starts_with("strategy:")
}

/// `safe:A+B`: where a class need never be weakened.
pub fn safe(class: &str) -> String {
    format!("safe:{class}")
}

/// `layers:sasi:1:0`: the states of a region at this distance from its goal.
pub fn layer(region: &str, distance: usize) -> String {
    format!("layers:{region}:{distance}")
}

/// `refuted:sasi:1:0`: the states outside of a region that are lost in this round.
pub fn refuted(region: &str, round: usize) -> String {
    format!("refuted:{region}:{round}")
}
