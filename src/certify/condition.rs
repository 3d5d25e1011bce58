//! The conditions of a dump, with their parameters. Their texts are made where they are shown.

use std::fmt::{Display, Formatter, Result};

use meliora_model::region::RegionName;

/// Declares the conditions, each with its parameters and its text.
macro_rules! conditions {
    ($($name:ident $({ $($field:ident: $type:ty),+ })? => $text:literal $(, $argument:expr)*;)+) => {
        /// A condition of a dump.
        #[derive(Debug, Clone, PartialEq, Eq)]
        #[expect(missing_docs, reason = "the text of a condition says what its parameters are")]
        pub enum Condition {
            $(#[doc = $text] $name $({ $($field: $type),+ })?,)+
        }

        impl Display for Condition {
            fn fmt(&self, f: &mut Formatter<'_>) -> Result {
                match self {
                    $(Condition::$name $({ $($field),+ })? => write!(f, $text $(, $argument)*),)+
                }
            }
        }
    };
}

conditions! {
    // Inputs and manifest
    Hash { what: &'static str, now: String, then: String } =>
        "the SHA-256 of the {what} is the one that the dump was made from: it is {now}, the dump says {}",
        then.escape_debug();
    Players { expected: Vec<String>, said: Vec<String> } =>
        "the players of the model are {}: the dump says {}", named(expected), named(said);
    Coalition { expected: Vec<String>, said: Vec<String> } =>
        "the coalition is {}: the dump was made for {}; `--coalition {}` checks it for these players",
        named(expected), named(said), said.join(",").escape_debug();
    Field { path: String, expected: String, said: String } => "`{path}` is {expected}: the manifest says {said}";
    Json { problem: String } => "the manifest can be written as JSON: {problem}";
    NoTransitionSafety => "a game is not analysed with safety `transition`";
    NoTemporalObjectives => "a dump of a game has no temporal objectives";
    // Files and sets
    Order => "the order contains exactly the bits of the model";
    HasReachable => "the dump has the region `reachable`";
    HasCertificate => "the dump has a certificate";
    Picture { name: String } => "the DOT file that the manifest names for `{name}` is its picture";
    ModelChoices { name: String } => "`{name}` has only choices of the model";
    Nodes { name: String, said: usize, found: usize } => "`{name}` has {said} nodes: it has {found}";
    Members { name: String, said: String, found: String } =>
        "`{name}` has {} members: it has {found}", said.escape_debug();
    HasSet { name: String, kind: &'static str } =>
        "the dump has `{name}`, a set of {kind}, which this check needs";
    UncertifiedRegion { name: String } =>
        "the certificate leaves out regions of the dump only: `{}` is none", name.escape_debug();
    NothingElse { name: String } => "`{name}` belongs to a dump with these options";
    // Trends
    NoTrend { name: String } => "`{name}` has no trend: it is neither a layer nor a round";
    TrendOfProof => "only layers and rounds have a trend";
    OrderOfVariables =>
        "the certificate orders each variable of the model once if a layer or round has a trend, else none";
    OrderOfRounds =>
        "an order of rounds has each variable of the model once, and only rounds with a trend have one";
    OrderInCertificate => "only the certificate orders the variables";
    OrderOfValues { variable: String } => "an order of the values of `{variable}` has each of them once";
    // Layers and rounds
    LayerNotEmpty { layer: usize, region: RegionName } => "layer {layer} of `{region}` has a state";
    LayerNew { layer: usize, region: RegionName } =>
        "layer {layer} of `{region}` has further states of this region";
    FirstLayer { region: RegionName } => "layer 0 of `{region}` are the states at its goal";
    FirstLayerTrend { region: RegionName } => "layer 0 of `{region}` has no trend";
    LayerLeads { layer: usize, region: RegionName } =>
        "each state in layer {layer} of `{region}` has a step into an earlier layer";
    LayerLeadsByTrend { layer: usize, region: RegionName, trend: &'static str } =>
        "each state in layer {layer} of `{region}` has a {trend} step into this layer or an earlier one";
    InSomeLayer { region: RegionName } => "each state of `{region}` is in one of its layers";
    RoundNotEmpty { round: usize, region: RegionName } => "round {round} of `{region}` has a state";
    RoundNew { round: usize, region: RegionName } =>
        "no state lost in round {round} of `{region}` was lost before";
    RoundSafeStep { round: usize, region: RegionName } =>
        "no state lost in round {round} of `{region}` has a safe step out of the round";
    RoundTarget { round: usize, region: RegionName } =>
        "no state lost in round {round} of `{region}` is in the target";
    RoundAgain { round: usize, region: RegionName } =>
        "paths that stay in round {round} of `{region}` violate a condition that must hold infinitely often";
    RoundAvoided { round: usize, region: RegionName } =>
        "each state lost in round {round} of `{region}` {}, or must risk an earlier round", is_bad(region);
    OutsideLost { region: RegionName } => "each state outside of {} is lost in some round", avoiding(region);
    // States and choices
    InRange => "each state of `reachable` has values in range";
    IsReachable { name: String } => "each state of `{name}` is one of `reachable`";
    HasStart => "each state in which paths start is in `reachable`";
    HasSuccessors => "each successor of a state of `reachable` is in it";
    AllValuations => "`reachable` contains all valuations, as the scope `all` requires";
    Initial => "`initial` are the initial states";
    EnabledChoices => "`choices` are the enabled ones";
    Deadlocks => "`deadlock` are the states where nothing is enabled";
    PlayerStates { region: RegionName } => "`{region}` are the states in which this player chooses";
    Constants => "a second evaluation gives the same constants";
    StateChoices => "each state has the choices that a second evaluation finds";
    StateOwner =>
        "each state of a game belongs to the player to whom a second evaluation gives its choices";
    Branches => "each choice has the branches whose probability is positive by a second evaluation";
    Distribution => "the probabilities of each enabled command sum to 1 by a second evaluation";
    // Winning regions and classes
    HasViolations => "each state that violates a requirement is in `unsafe`";
    StaysIn { region: RegionName } => "each state of {} has a choice that stays in it", avoiding(region);
    StayingChoices { region: RegionName } =>
        "`{}` are the choices that stay in `{region}`", region.strategy();
    TargetStates { region: RegionName } => "`{region}` are the states in which the target holds";
    SecuredStates { region: RegionName } => "`{region}` are the states in which the objective is secured";
    HasTarget { region: RegionName } => "each state of the target is in `{region}`";
    HasSteps { region: RegionName } => "each state with a step into `{region}` is in it";
    Always { region: RegionName } =>
        "each state of `{region}` satisfies the conditions that must always hold there";
    ClassStates { region: RegionName } => "`{region}` are the states with these most preferred outcomes";
    EmptyClass { region: RegionName } => "`{region}` has no state";
    BadStates { region: RegionName } =>
        "each state in which the opponent can weaken, or step into `{region}`, is in it";
    NotWeakening { region: RegionName } => "no state of `{region}` weakens the class";
    // Levels
    MaxLevel { max: usize } => "the search for levels stopped at the maximum level {max}";
    LevelSmaller { region: RegionName } => "`{region}` has a state, and fewer than the level below";
    LevelWithin { region: RegionName } => "each state of `{region}` is in the level below";
    LastLevel { region: RegionName } => "`{region}` is the last level";
    NoChoices { region: RegionName } =>
        "`{}` has no choice, as `{region}` has no state", region.strategy();
    NoWinner { region: RegionName } => "no state wins `{region}`";
    WonByClasses { region: RegionName } => "`{region}` is what its reference classes win";
    PermittedByClasses { region: RegionName } => "`{region}` is what its reference classes permit";
    KeptChoices { region: RegionName } => "`strategy:{region}` are the kept choices that keep winning";
    HasStepsTowards { region: RegionName } => "each state with a step towards `{region}` is in it";
    // Values
    ValuesNamed => "the manifest names `values.csv` if it is there";
    ValueLevels => "the values have no more levels than the dump";
    RewardStructure { name: String } => "`{}` is a reward structure of the model", name.escape_debug();
    ArenaOfDump { name: String } => "`{}` is an arena of the dump", name.escape_debug();
    AllLevels => "each row of `values.csv` has the values of all levels";
    PossibleRow => "each row of `values.csv` is about a state with P_1 > 0";
    KnownZero { level: usize } => "the levels say whether P_{level} is 0 in each row";
    OneRow => "each state has one row per arena in `values.csv`";
    AllRows { states: String, rows: usize } =>
        "each of the {states} states with P_1 > 0 has a row in `values.csv`: {rows} have one";
    NeededRow => "each state with P_1 > 0 that a row depends on has a row in `values.csv`";
    ZeroOutside { level: usize } => "P_{level} is 0 outside of `spi:{level}`";
    OneInside { level: usize } => "P_{level} is 1 where {level} improvements are certain";
    BelowOne { level: usize } => "P_{level} has bounds of 1, or an upper bound below 1";
    CostIfCertain { level: usize } => "C_{level} is given exactly where P_{level} is 1";
    OrderedBounds { what: &'static str, level: usize } =>
        "the bounds of {what}_{level} are finite below and in order";
    AtMostOne { level: usize } => "P_{level} is at most 1";
    UpperProbability { level: usize, theirs: bool } =>
        "{} more than the upper bound of P_{level}",
        if *theirs { "some choice of the opponent has no" } else { "no kept choice has" };
    LowerProbability { level: usize, theirs: bool } =>
        "{} at least the lower bound of P_{level}, and enters a smaller rank",
        if *theirs { "each choice of the opponent has" } else { "some kept choice has" };
    LowerCost { level: usize, theirs: bool } =>
        "{} less than the lower bound of C_{level}",
        if *theirs { "some choice of the opponent does not cost" } else { "no permitted choice costs" };
    UpperCost { level: usize, theirs: bool } =>
        "{} costs at most the upper bound of C_{level}, and enters a smaller rank",
        if *theirs { "each choice of the opponent is permitted," } else { "some permitted choice" };
}

/// Formats names for a list.
fn named(names: &[String]) -> String {
    match names {
        [] => "none".to_owned(),
        names => names.iter().map(|name| format!("`{}`", name.escape_debug())).collect::<Vec<_>>().join(", "),
    }
}

/// Formats the states from which bad states are avoided, by the region that the rounds are of.
fn avoiding(region: &RegionName) -> String {
    match region {
        RegionName::Unsafe => format!("the complement of `{region}`"),
        _ => format!("`{region}`"),
    }
}

/// Says what a bad state does, by the region that the rounds are of.
fn is_bad(region: &RegionName) -> &'static str {
    if *region == RegionName::Unsafe { "violates a requirement" } else { "weakens" }
}
