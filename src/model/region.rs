//! The names of regions, for listing, for dumps and for their checker.

use std::convert::Infallible;
use std::fmt;
use std::str::FromStr;

meliora_base::named! {
    /// The paper's two solution concepts.
    pub enum Kind {
        /// Safe and almost-surely improving.
        Sasi,
        /// Safe and positively improving.
        Spi,
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Kind::Sasi => "SASI",
            Kind::Spi => "SPI",
        })
    }
}

/// The number of a level in a name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum LevelNumber {
    /// The states from which this many improvements are possible, from 1 on.
    Finite(u64),
    /// The states from which any number of improvements is possible.
    Unbounded,
}

/// The class of the states without an almost-sure objective.
pub const NOTHING: &str = "nothing";

/// The name of a region, of a strategy, or of a set that proves them. A class is named by its most
/// preferred objectives, in the order of declaration; see [`members`].
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum RegionName {
    /// `reachable`: all states of the scope.
    Reachable,
    /// `initial`: the initial states.
    Initial,
    /// `deadlock`: the states without an enabled command.
    Deadlock,
    /// `choices`: all enabled choices.
    Choices,
    /// `unsafe`: the states from which the requirements cannot be kept.
    Unsafe,
    /// `bad`: the states of a game in which the opponent can weaken, under `action`.
    Bad,
    /// `player:p`: the states in which a player of a game chooses.
    Player(String),
    /// `target:A`: the target of an objective.
    Target(String),
    /// `positive:A`: the states from which an objective is possible.
    Positive(String),
    /// `almost-sure:A`: the states from which an objective is almost sure.
    AlmostSure(String),
    /// `secured:A:1`: the region of a disjunct, numbered from 1, of an objective over whole paths.
    Secured(String, usize),
    /// `secured:A:1:2`: the part of such a region's certificate for its second recurring mark.
    Recurring(String, usize, usize),
    /// `class:A+B`: the states of a class.
    Class(String),
    /// `safe:A+B`: the states from which a strategy avoids weakening a class forever.
    Safe(String),
    /// `sasi:1`: the states of a level.
    Level(Kind, LevelNumber),
    /// `sasi:1@A+B`: a level with a class as the reference.
    Against(Kind, LevelNumber, String),
    /// `strategy:sasi:1`: the strategy of a region.
    Strategy(Box<RegionName>),
    /// `layers:sasi:1:0`: the states of a region in this layer on the way to its goal.
    Layer(Box<RegionName>, usize),
    /// `refuted:sasi:1:0`: the states outside of a region that this round removes.
    Round(Box<RegionName>, usize),
    /// Any other name, such as one of a question about paths.
    Other(String),
}

use RegionName::*;

/// Returns `A+B`, or `nothing`: the name of a class by its most preferred objectives.
pub fn members(objectives: &[&str]) -> String {
    if objectives.is_empty() { NOTHING.to_owned() } else { objectives.join("+") }
}

impl RegionName {
    /// Returns the name of the strategy of this region.
    pub fn strategy(&self) -> Self {
        Strategy(Box::new(self.clone()))
    }

    /// Returns the name of a layer of this region.
    pub fn layer(&self, layer: usize) -> Self {
        Layer(Box::new(self.clone()), layer)
    }

    /// Returns the name of a round of this region.
    pub fn round(&self, round: usize) -> Self {
        Round(Box::new(self.clone()), round)
    }

    /// Returns the name of a region's part for a recurring mark, from 1 on.
    pub fn recurring(&self, mark: usize) -> Self {
        match self {
            Secured(objective, case) => Recurring(objective.clone(), *case, mark),
            other => other.clone(),
        }
    }

    /// Returns the region of a strategy; of a region, the region itself.
    fn region(&self) -> &Self {
        if let Strategy(region) = self { region } else { self }
    }

    /// Returns the kind, if this is a level or the strategy of one.
    pub fn level_kind(&self) -> Option<Kind> {
        match self.region() {
            Level(kind, _) | Against(kind, ..) => Some(*kind),
            _ => None,
        }
    }

    /// Returns whether a region, or the strategy of one, follows from the model, its states and the
    /// requirements alone, whatever the objectives are.
    pub fn is_of_model(&self) -> bool {
        matches!(self, Reachable | Initial | Deadlock | Choices | Unsafe | Player(_))
    }

    /// Returns whether a region, or the strategy of one, is one of an objective.
    pub fn is_of_objective(&self, objective: &str) -> bool {
        match self.region() {
            Target(own) | Positive(own) | AlmostSure(own) | Secured(own, _) => own == objective,
            _ => false,
        }
    }

    /// Returns true if the name is that of a strategy.
    pub fn is_strategy(&self) -> bool {
        matches!(self, Strategy(_))
    }

    /// Returns true if the name is that of a round.
    pub fn is_round(&self) -> bool {
        matches!(self, Round(..))
    }

    /// Returns the name of the fixpoint of a level: `spi:unbounded` for `spi:3`; none if the name is
    /// not one of a numbered level or of its strategy.
    pub fn unbounded(&self) -> Option<Self> {
        match self {
            Level(kind, LevelNumber::Finite(_)) => Some(Level(*kind, LevelNumber::Unbounded)),
            Strategy(region) => region.unbounded().map(|region| region.strategy()),
            _ => None,
        }
    }
}

impl fmt::Display for LevelNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            LevelNumber::Finite(number) => write!(f, "{number}"),
            LevelNumber::Unbounded => f.write_str("unbounded"),
        }
    }
}

impl fmt::Display for RegionName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reachable => f.write_str("reachable"),
            Initial => f.write_str("initial"),
            Deadlock => f.write_str("deadlock"),
            Choices => f.write_str("choices"),
            Unsafe => f.write_str("unsafe"),
            Bad => f.write_str("bad"),
            Player(player) => write!(f, "player:{player}"),
            Target(objective) => write!(f, "target:{objective}"),
            Positive(objective) => write!(f, "positive:{objective}"),
            AlmostSure(objective) => write!(f, "almost-sure:{objective}"),
            Secured(objective, case) => write!(f, "secured:{objective}:{case}"),
            Recurring(objective, case, mark) => write!(f, "secured:{objective}:{case}:{mark}"),
            Class(class) => write!(f, "class:{class}"),
            Safe(class) => write!(f, "safe:{class}"),
            Level(kind, level) => write!(f, "{}:{level}", kind.name()),
            Against(kind, level, class) => write!(f, "{}:{level}@{class}", kind.name()),
            Strategy(region) => write!(f, "strategy:{region}"),
            Layer(region, layer) => write!(f, "layers:{region}:{layer}"),
            Round(region, round) => write!(f, "refuted:{region}:{round}"),
            Other(name) => f.write_str(name),
        }
    }
}

impl FromStr for RegionName {
    type Err = Infallible;

    /// Reads a name as it is written; a text that is not written for any other name is [`Other`].
    fn from_str(text: &str) -> Result<Self, Infallible> {
        // Numbers are read back only as they are written: without a sign or leading zeros.
        let read = parsed(text).filter(|name| name.to_string() == text);
        Ok(read.unwrap_or_else(|| Other(text.to_owned())))
    }
}

impl From<&str> for RegionName {
    fn from(text: &str) -> Self {
        let Ok(name) = text.parse();
        name
    }
}

fn parsed(text: &str) -> Option<RegionName> {
    let Some((sort, rest)) = text.split_once(':') else {
        return [Reachable, Initial, Deadlock, Choices, Unsafe, Bad]
            .into_iter()
            .find(|name| name.to_string() == text);
    };
    let numbered = || {
        let (region, number) = rest.rsplit_once(':')?;
        Some((Box::new(parsed(region)?), number.parse().ok()?))
    };
    Some(match sort {
        "player" => Player(rest.to_owned()),
        "target" => Target(rest.to_owned()),
        "positive" => Positive(rest.to_owned()),
        "almost-sure" => AlmostSure(rest.to_owned()),
        "class" => Class(rest.to_owned()),
        "safe" => Safe(rest.to_owned()),
        "strategy" => Strategy(Box::new(parsed(rest)?)),
        "layers" => numbered().map(|(region, layer)| Layer(region, layer))?,
        "refuted" => numbered().map(|(region, round)| Round(region, round))?,
        "secured" => secured(&rest.split(':').collect::<Vec<_>>())?,
        _ => level(sort.parse().ok()?, rest)?,
    })
}

fn secured(parts: &[&str]) -> Option<RegionName> {
    match parts {
        [objective, case] => Some(Secured((*objective).to_owned(), case.parse().ok()?)),
        [objective, case, mark] => {
            Some(Recurring((*objective).to_owned(), case.parse().ok()?, mark.parse().ok()?))
        }
        _ => None,
    }
}

fn level(kind: Kind, text: &str) -> Option<RegionName> {
    let (number, class) = text.split_once('@').map_or((text, None), |(number, class)| (number, Some(class)));
    let number = match number {
        "unbounded" => LevelNumber::Unbounded,
        _ => LevelNumber::Finite(number.parse().ok().filter(|number| *number > 0)?),
    };
    Some(match class {
        Some(class) => Against(kind, number, class.to_owned()),
        None => Level(kind, number),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_regions_are_read_as_they_are_written() {
        let finite = |kind, number| Level(kind, LevelNumber::Finite(number));
        let all = [
            (Reachable, "reachable"),
            (Player("p1".into()), "player:p1"),
            (AlmostSure("A".into()).strategy(), "strategy:almost-sure:A"),
            (Secured("A".into(), 1).recurring(2).layer(0), "layers:secured:A:1:2:0"),
            (Class("A+B".into()), "class:A+B"),
            (Against(Kind::Sasi, LevelNumber::Finite(3), "A+B".into()), "sasi:3@A+B"),
            (
                Against(Kind::Spi, LevelNumber::Unbounded, "nothing".into()).round(4),
                "refuted:spi:unbounded@nothing:4",
            ),
            (finite(Kind::Spi, 12).strategy(), "strategy:spi:12"),
            (Other("pmax_one:2".into()), "pmax_one:2"),
            (Other("sasi:03".into()), "sasi:03"),
            (Other("sasi:0".into()), "sasi:0"),
            (Other("layers:reachable".into()), "layers:reachable"),
        ];
        for (name, text) in all {
            assert_eq!(name.to_string(), text);
            assert_eq!(RegionName::from(text), name);
        }
    }

    #[test]
    fn a_level_past_the_last_is_the_fixpoint() {
        let unbounded = |name: &str| RegionName::from(name).unbounded().map(|name| name.to_string());
        assert_eq!(unbounded("sasi:7").as_deref(), Some("sasi:unbounded"));
        assert_eq!(unbounded("strategy:spi:2").as_deref(), Some("strategy:spi:unbounded"));
        for other in ["spi:unbounded", "sasi:0", "sasi:3@A", "class:A", "strategy:bad"] {
            assert_eq!(unbounded(other), None, "{other}");
        }
    }
}
