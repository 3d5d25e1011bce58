//! Meliora: a symbolic model checker for opportunistic planning with incomplete preferences.
//!
//! It reads a Markov decision process in PRISM's language and a partial preference over reachability
//! objectives, and says from which states, and how often, a play can move on to something preferred to
//! what it is sure of now. The theory is that of A. N. Kulkarni and J. Fu, *Opportunistic Qualitative
//! Planning in Stochastic Systems with Incomplete Preferences over Reachability Objectives* (ACC 2023),
//! "the paper" below. [`tutorial`] goes through a small example step by step.
//!
//! # The map
//!
//! | The paper | here |
//! | --- | --- |
//! | the model: an MDP of which only the support matters | [`lang`] reads it, [`model`] is the flat program, [`engine`] the sets over it |
//! | the preorder on objectives | [`model::preference`], its Hasse diagram [`model::hasse`] |
//! | almost-sure and positive winning regions | [`engine::Engine::almost_surely_reach`], [`engine::Engine::can_reach`], [`planning::winning_regions`] |
//! | outcomes Out(s), most preferred outcomes MP(s) | [`planning::classes`] |
//! | Definition "Improvement MDP" | [`planning::improvement`], in three readings: [`planning::Safety`] |
//! | Algorithm "Level set": levels and ranks of SPI and SASI | [`planning::levels`] |
//! | SPI and SASI strategies | [`planning::strategy`], [`planning::finite_memory`]; why: [`planning::explain`] |
//!
//! # One way through
//!
//! Text becomes a checked program ([`lang`]), flat and free of engines ([`model`]), on which an
//! [`engine`], symbolic or explicit, offers sets of states and of choices; [`planning`] is written once
//! over these. Its results are plain data, which `output` turns into text, JSON and pages. [`export`] and
//! [`dump`] write regions as decision diagrams, [`query`] answers from them without the model, and
//! [`certify`] re-checks them by one-step conditions with none of the code that computed them. [`projections`]
//! lays regions over a plane for pictures, [`generate`] writes models of any size; [`embed`] has owners of
//! models, engines and analyses for other programs and languages. Imports run along this line only. The library never prints, reads the clock or the environment, or ends the process;
//! whatever runs out of memory or time returns [`error::Limit`] and keeps what it found; an
//! [`progress::ProgressSink`] carries the order to stop.
//!
//! # An example
//!
//! The paper's Example 1, asked of both engines. At the start only the first objective is certain; yet
//! the actions b and c are sure to end in something better.
//!
//! ```
//! use meliora::{Kind, Model, Options, Rank, Result, Settings, SourceFile, Storage};
//!
//! # fn main() -> Result<()> {
//! let model = Model::parse("mdp
//!     module toy
//!       s : [0..5] init 0;
//!       [a] s=0 -> 1/2: (s'=1) + 1/2: (s'=5);
//!       [b] s=0 -> 1/2: (s'=2) + 1/2: (s'=3);
//!       [c] s=0 -> 1/2: (s'=3) + 1/2: (s'=4);
//!       [a] s=5 -> (s'=1);
//!       [stay] s>=1 & s<=4 -> true;
//!     endmodule", "")?;
//! let wishes = SourceFile::new("toy.pref", "
//!     objective First  = F (s=1 | s=5);
//!     objective Second = F (s=2 | s=4);
//!     objective Third  = F (s=3);
//!     prefer Second, Third > First;");
//!
//! let explored = |storage| model.explore(Settings { storage, ..Settings::default() });
//! let mut one = explored(Storage::Symbolic)?.prefer(&wishes, Options::default())?;
//! let mut other = explored(Storage::Explicit)?.prefer(&wishes, Options::default())?;
//! one.run(&mut |_| ())?;
//! other.run(&mut |_| ())?;
//! assert_eq!(one.result(), other.result());
//!
//! let start = model.state("s=0")?;
//! assert_eq!(one.most_preferred(&start), ["First"]);
//! assert_eq!(one.rank(Kind::Sasi, &start), Rank::Finite(1));
//! assert_eq!(one.strategy(Kind::Sasi)?.permitted(&start)?, ["b", "c"]);
//! # Ok(())
//! # }
//! ```

mod automata;
pub mod certify;
pub mod diagnostic;
pub mod dump;
pub mod embed;
pub mod engine;
pub mod error;
pub mod escape;
pub mod export;
pub mod generate;
pub mod held;
pub mod lang;
pub mod model;
pub mod names;
#[cfg(feature = "output")]
pub mod output;
pub mod planning;
pub mod progress;
pub mod projections;
pub mod query;
mod random;
mod reading;
mod span;
pub mod tutorial;

pub use embed::{Exploration, Model, Planning, States, Strategy};
pub use engine::{Scope, Settings, Storage};
pub use error::{Error, Limit, Result, SourceFile};
pub use planning::{Kind, Options, Rank, Safety};
pub use progress::ProgressSink;
