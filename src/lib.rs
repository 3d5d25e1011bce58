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
//! | almost-sure and positive winning regions | [`engine::Engine::almost_surely_reach`], [`engine::Engine::can_reach`], [`planning::outcomes`] |
//! | outcomes Out(s), most preferred outcomes MP(s) | [`planning::classes`] |
//! | Definition "Improvement MDP" | [`planning::improvement`], in three readings: [`planning::Safety`] |
//! | Algorithm "Level set": levels and ranks of SPI and SASI | [`planning::levels`] |
//! | SPI and SASI strategies | [`planning::strategy`], [`planning::playbook`]; why: [`planning::explain`] |
//!
//! # One way through
//!
//! Text becomes a checked program ([`lang`]), flat and free of engines ([`model`]), on which an
//! [`engine`], symbolic or explicit, offers sets of states and of choices; [`planning`] is written once
//! over these. Its results are plain data, which [`output`] turns into text, JSON and pages. [`export`] and
//! [`dump`] write regions as decision diagrams, [`query`] answers from them without the model, and
//! [`certify`] re-checks them by one-step conditions with none of the code that computed them. [`atlas`]
//! lays regions over a plane for pictures, [`generate`] writes models of any size. Imports run along
//! this line only. The library never prints, reads the clock or the environment, or ends the process;
//! whatever runs out of memory or time returns [`error::Limit`] and keeps what it found; an
//! [`observer::Observer`] carries the order to stop.
//!
//! # An example
//!
//! The paper's Example 1, asked of both engines. At the start only the first objective is certain; yet
//! the actions b and c are sure to end in something better.
//!
//! ```
//! use std::sync::Arc;
//!
//! use meliora::engine::Settings;
//! use meliora::engine::explicit::ExplicitEngine;
//! use meliora::engine::symbolic::{SymbolicEngine, order};
//! use meliora::error::{Error, SourceFile};
//! use meliora::lang;
//! use meliora::planning::{Analysis, Options, Rank};
//!
//! # fn main() -> Result<(), Error> {
//! let model = SourceFile::new("toy.prism", "mdp
//!     module toy
//!       s : [0..5] init 0;
//!       [a] s=0 -> 1/2: (s'=1) + 1/2: (s'=5);
//!       [b] s=0 -> 1/2: (s'=2) + 1/2: (s'=3);
//!       [c] s=0 -> 1/2: (s'=3) + 1/2: (s'=4);
//!       [a] s=5 -> (s'=1);
//!       [stay] s>=1 & s<=4 -> true;
//!     endmodule");
//! let wishes = SourceFile::new("toy.pref", "
//!     objective First  = F (s=1 | s=5);
//!     objective Second = F (s=2 | s=4);
//!     objective Third  = F (s=3);
//!     prefer Second, Third > First;");
//! let mut program = lang::load(&model, &SourceFile::new("constants", ""))?.program;
//! let preferences = lang::load_preferences(&wishes, &mut program)?;
//! let program = Arc::new(program);
//!
//! let symbolic = SymbolicEngine::new(program.clone(), order::auto(&program), 1, Settings::default())?;
//! let explicit = ExplicitEngine::new(program.clone(), Settings::default())?;
//! let mut one = Analysis::new(&symbolic, &preferences, Options::default());
//! let mut other = Analysis::new(&explicit, &preferences, Options::default());
//! one.run(&mut |_| ())?;
//! other.run(&mut |_| ())?;
//! assert_eq!(one.result(), other.result());
//!
//! let start = one.prospects(&program, &[0])?;
//! assert_eq!(preferences.names(&start.most_preferred), ["First"]);
//! let sasi = start.sasi.ok_or_else(|| Error::Usage("the levels are known".into()))?;
//! assert_eq!(sasi.rank, Rank::Finite(1));
//! assert_eq!(sasi.actions, ["b", "c"]);
//! # Ok(())
//! # }
//! ```

pub mod atlas;
pub mod certify;
pub mod diagnostic;
pub mod dump;
pub mod engine;
pub mod error;
pub mod escape;
pub mod export;
pub mod generate;
pub mod lang;
pub mod model;
pub mod observer;
pub mod output;
pub mod planning;
pub mod query;
mod random;
pub mod tutorial;
