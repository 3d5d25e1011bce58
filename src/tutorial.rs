//! A tutorial from two texts to regions, strategies, runs and a dump. Each step is a test.
//!
//! The model is [`MODEL`], the paper's Example 1. At `s=0` three actions are enabled. `a` reaches
//! the first objective surely; `b` and `c` reach the second or the third with probability 1/2 each.
//! Both are preferred to the first, and incomparable with each other. [`GAMBLE`] is a second model,
//! for which the safety modes give different results.
//!
//! # 1. Reading
//!
//! A [`SourceFile`](meliora_base::error::SourceFile) is a text with a name, so that errors can show their
//! place. [`lang::load`](meliora_lang::load) reads a model with its constants.
//! [`lang::load_preferences`](meliora_lang::load_preferences) reads preferences over it. The targets of the
//! objectives are conditions, which leave the program as it is.
//!
//! ```
//! use meliora::error::{Error, SourceFile};
//! use meliora::{lang, tutorial};
//!
//! # fn main() -> Result<(), Error> {
//! let none = SourceFile::new("constants", "");
//! let program = lang::load(&SourceFile::new("toy.prism", tutorial::MODEL), &none)?.program;
//! let wishes = SourceFile::new("toy.pref", tutorial::WISHES);
//! let lang::Task { program, preferences } = lang::load_preferences(&wishes, program)?;
//! assert_eq!(program.variables[0].name, "s");
//! assert_eq!(preferences.objectives.len(), 3);
//!
//! // A mistake has a place, and often advice.
//! let wrong = SourceFile::new("wrong.pref", "objective Fourth = F (t = 4);");
//! match lang::load_preferences(&wrong, program) {
//!     Err(Error::Input(mistakes)) => assert_eq!(mistakes[0].position(), (1, 23)),
//!     _ => panic!("there is no variable t"),
//! }
//! # Ok(())
//! # }
//! ```
//!
//! # 2. Preferences
//!
//! A preference file generates a preorder. MP(s) are the most preferred of the objectives that are
//! almost surely achievable from s. A step improves, weakens or does neither; this follows from the
//! MP of its two ends.
//!
//! ```
//! # use meliora::error::{Error, SourceFile};
//! # use meliora::{lang, tutorial};
//! use meliora::model::preference::{Change, ObjectiveSet};
//!
//! # fn main() -> Result<(), Error> {
//! # let none = SourceFile::new("constants", "");
//! # let program = lang::load(&SourceFile::new("toy.prism", tutorial::MODEL), &none)?.program;
//! # let lang::Task { program, preferences } = lang::load_preferences(&SourceFile::new("toy.pref", tutorial::WISHES), program)?;
//! let (first, second, third) = (0, 1, 2);
//! let sure: ObjectiveSet = [first, second, third].into_iter().collect();
//! assert_eq!(preferences.names(&preferences.most_preferred(&sure)), ["Second", "Third"]);
//!
//! let set = |i: usize| ObjectiveSet::from_iter([i]);
//! assert_eq!(preferences.change(&set(first), &set(third)), Change::Improving);
//! assert_eq!(preferences.change(&set(third), &set(first)), Change::Weakening);
//! assert_eq!(preferences.change(&set(second), &set(third)), Change::Lateral);
//! // The value of nothing is stated separately: `empty = bottom` by default.
//! assert_eq!(preferences.change(&set(first), &ObjectiveSet::new()), Change::Weakening);
//! # Ok(())
//! # }
//! ```
//!
//! # 3. Engines and regions
//!
//! An [`Engine`](meliora_engine::Engine) provides sets of states and sets of choices with their
//! operations. The [symbolic](meliora_engine::SymbolicEngine) engine stores them as decision diagrams,
//! the [explicit](meliora_engine::ExplicitEngine) engine as bit vectors over an enumeration. Code that is
//! generic over the trait runs on both.
//!
//! ```
//! # use std::sync::Arc;
//! # use meliora::error::{Error, Result, SourceFile};
//! # use meliora::{lang, tutorial};
//! use meliora::engine::ExplicitEngine;
//! use meliora::engine::regions::{pmax_one, pmax_positive};
//! use meliora::engine::SymbolicEngine;
//! use meliora::engine::{Count, Engine, Settings};
//! use meliora::model::predicate::Predicate;
//!
//! /// Counts the states that reach a target almost surely, and those that can reach it.
//! fn sizes<E: Engine>(engine: &E, target: &Predicate) -> Result<[Count; 2]> {
//!     let target = engine.states_where(target)?;
//!     let (surely, possibly) = (pmax_one(engine, &target)?, pmax_positive(engine, &target)?);
//!     Ok([engine.count(&surely)?, engine.count(&possibly)?])
//! }
//!
//! # fn main() -> Result<(), Error> {
//! # let none = SourceFile::new("constants", "");
//! # let program = lang::load(&SourceFile::new("toy.prism", tutorial::MODEL), &none)?.program;
//! # let lang::Task { program, preferences } = lang::load_preferences(&SourceFile::new("toy.pref", tutorial::WISHES), program)?;
//! let program = Arc::new(program);
//! let symbolic = SymbolicEngine::new(program.clone(), Settings::default())?;
//! let explicit = ExplicitEngine::new(program.clone(), Settings::default())?;
//! let third = preferences.objectives[2].target().expect("an objective of the form F condition");
//! assert_eq!(sizes(&symbolic, third)?, [Count::from(1u32), Count::from(2u32)]);
//! assert_eq!(sizes(&explicit, third)?, sizes(&symbolic, third)?);
//! # Ok(())
//! # }
//! ```
//!
//! # 4. The complete analysis
//!
//! [`Analysis`](meliora_planning::Analysis) computes winning regions, classes, the improvement MDP
//! and the levels. It reports results to a listener as events, and keeps them if a limit ends the
//! work.
//!
//! ```
//! # use std::sync::Arc;
//! # use meliora::engine::SymbolicEngine;
//! # use meliora::engine::Settings;
//! # use meliora::error::{Error, SourceFile};
//! # use meliora::{lang, tutorial};
//! use meliora::planning::{Analysis, Event, Kind, Options, Rank};
//!
//! # fn main() -> Result<(), Error> {
//! # let none = SourceFile::new("constants", "");
//! # let program = lang::load(&SourceFile::new("toy.prism", tutorial::MODEL), &none)?.program;
//! # let lang::Task { program, preferences } = lang::load_preferences(&SourceFile::new("toy.pref", tutorial::WISHES), program)?;
//! # let preferences = Arc::new(preferences);
//! # let program = Arc::new(program);
//! # let engine = Arc::new(SymbolicEngine::new(program.clone(), Settings::default())?);
//! let mut analysis = Analysis::new(&engine, &preferences, Options::default());
//! let mut heard = Vec::new();
//! analysis.run(&mut |event| {
//!     if let Event::Level(kind, k, states) = event {
//!         heard.push(format!("{kind} {k}: {states}"));
//!     }
//! })?;
//! // From one state, the start, one improvement is almost sure, and a second is impossible.
//! assert_eq!(heard, ["SASI 1: 1", "SPI 1: 1"]);
//! assert_eq!(analysis.levels(Kind::Sasi).rank(&engine, &[0])?, Rank::Finite(1));
//! assert_eq!(analysis.levels(Kind::Sasi).rank(&engine, &[3])?, Rank::Finite(0));
//! # Ok(())
//! # }
//! ```
//!
//! # 5. Strategies and explanations
//!
//! A [`FiniteMemoryStrategy`](meliora_planning::FiniteMemoryStrategy) combines the strategies of all
//! levels. It explains each action of a state: if it is permitted, its results, and the reason.
//!
//! ```
//! # use std::sync::Arc;
//! # use meliora::engine::SymbolicEngine;
//! # use meliora::engine::Settings;
//! # use meliora::error::{Error, SourceFile};
//! # use meliora::{lang, tutorial};
//! # use meliora::planning::{Analysis, Kind, Options};
//! use meliora::planning::{Scheduler, FiniteMemoryStrategy, Setup, Simulation};
//! use meliora::planning::explain::Verdict;
//!
//! # fn main() -> Result<(), Error> {
//! # let none = SourceFile::new("constants", "");
//! # let program = lang::load(&SourceFile::new("toy.prism", tutorial::MODEL), &none)?.program;
//! # let lang::Task { program, preferences } = lang::load_preferences(&SourceFile::new("toy.pref", tutorial::WISHES), program)?;
//! # let preferences = Arc::new(preferences);
//! # let program = Arc::new(program);
//! # let engine = Arc::new(SymbolicEngine::new(program.clone(), Settings::default())?);
//! # let mut analysis = Analysis::new(&engine, &preferences, Options::default());
//! # analysis.run(&mut |_| ())?;
//! # let missing = || Error::Usage("the levels are known".into());
//! let mut strategy = FiniteMemoryStrategy::new(&analysis, &program, Kind::Sasi).ok_or_else(missing)?;
//! let start = [0];
//! let at = strategy.explain(&start, strategy.start(&start)?)?;
//! let said: Vec<(&str, bool, Verdict)> =
//!     at.actions.iter().map(|a| (a.name.as_str(), a.permitted, a.verdict)).collect();
//! // `a` leads to states without further improvement: the first of its successors is one.
//! assert_eq!(said[0], ("a", false, Verdict::Strays(0)));
//! assert_eq!(said[1], ("b", true, Verdict::Improves));
//! assert_eq!(said[2], ("c", true, Verdict::Improves));
//!
//! // Random runs under the strategy satisfy its guarantee. The same seed gives the same runs.
//! let setup = Setup { scheduler: Scheduler::Permissive, runs: 100, steps: 50, seed: 1 };
//! let tally = Simulation::new(&mut strategy, setup).run(&start)?;
//! assert_eq!(tally.fewer_than(1), 0);
//! assert_eq!(tally.weakened_step, 0);
//! # Ok(())
//! # }
//! ```
//!
//! # 6. Safety modes
//!
//! In [`GAMBLE`] bronze is certain, and can be staked for gold. Under
//! [`Safety::Transition`](meliora_planning::Safety::Transition), the paper's definition to the
//! letter, the losing branch is dropped, and the gamble counts as sure. Under
//! [`Safety::Action`](meliora_planning::Safety::Action) the gamble is not kept, because the real
//! system may lose it.
//!
//! ```
//! # use std::sync::Arc;
//! # use meliora::engine::ExplicitEngine;
//! # use meliora::engine::Settings;
//! # use meliora::error::{Error, SourceFile};
//! # use meliora::{lang, tutorial};
//! use meliora::planning::{Analysis, Kind, Options, Rank, Safety};
//!
//! # fn main() -> Result<(), Error> {
//! # let none = SourceFile::new("constants", "");
//! let program = lang::load(&SourceFile::new("lateral.prism", tutorial::GAMBLE), &none)?.program;
//! let wishes = SourceFile::new("lateral.pref", tutorial::STAKES);
//! let lang::Task { program, preferences } = lang::load_preferences(&wishes, program)?;
//! let preferences = Arc::new(preferences);
//! let engine = Arc::new(ExplicitEngine::new(Arc::new(program), Settings::default())?);
//! let rank = |safety: Safety| -> Result<Rank, Error> {
//!     let mut analysis = Analysis::new(&engine, &preferences, Options { safety, max_level: None });
//!     analysis.run(&mut |_| ())?;
//!     analysis.levels(Kind::Sasi).rank(&engine, &[0])
//! };
//! assert_eq!(rank(Safety::Transition)?, Rank::Finite(1));
//! assert_eq!(rank(Safety::Action)?, Rank::Finite(0));
//! assert_eq!(rank(Safety::Prefix)?, Rank::Finite(0));
//! # Ok(())
//! # }
//! ```
//!
//! # 7. Limits
//!
//! Every limit is an answer. The program often asks a [`ProgressSink`](meliora_engine::ProgressSink)
//! if it may continue. Results from before a stop are kept.
//!
//! ```
//! # use std::sync::Arc;
//! # use meliora::engine::SymbolicEngine;
//! # use meliora::error::{Error, SourceFile};
//! # use meliora::{lang, tutorial};
//! # use meliora::planning::{Analysis, Options, Phase};
//! use std::sync::atomic::{AtomicBool, Ordering};
//! use meliora::engine::{ProgressSink, Settings};
//! use meliora::error::Limit;
//!
//! #[derive(Default)]
//! struct Button(AtomicBool);
//!
//! impl ProgressSink for Button {
//!     fn stop(&self) -> Option<Limit> {
//!         self.0.load(Ordering::Relaxed).then_some(Limit::Interrupted)
//!     }
//! }
//!
//! # fn main() -> Result<(), Error> {
//! # let none = SourceFile::new("constants", "");
//! # let program = lang::load(&SourceFile::new("toy.prism", tutorial::MODEL), &none)?.program;
//! # let lang::Task { program, preferences } = lang::load_preferences(&SourceFile::new("toy.pref", tutorial::WISHES), program)?;
//! # let preferences = Arc::new(preferences);
//! let button = Arc::new(Button::default());
//! let settings = Settings { sink: button.clone(), ..Settings::default() };
//! # let program = Arc::new(program);
//! let engine = Arc::new(SymbolicEngine::new(program.clone(), settings)?);
//! let mut analysis = Analysis::new(&engine, &preferences, Options::default());
//! analysis.run_phase(Phase::Counts, &mut |_| ())?;
//! button.0.store(true, Ordering::Relaxed);
//! assert!(matches!(analysis.run(&mut |_| ()), Err(Error::Limit(Limit::Interrupted))));
//! assert!(analysis.result().counts.is_some());
//!
//! // The analysis continues from there.
//! button.0.store(false, Ordering::Relaxed);
//! analysis.run(&mut |_| ())?;
//! assert_eq!(analysis.result().sasi.levels.len(), 1);
//! # Ok(())
//! # }
//! ```
//!
//! # 8. Dumps
//!
//! [`export`](meliora_export) and [`dump`](meliora_dump) write regions as decision diagrams that
//! other programs can read. [`Archive`](meliora_query::Archive) answers queries from such a dump
//! without the model.
//!
//! ```
//! # use std::sync::Arc;
//! # use meliora::engine::SymbolicEngine;
//! # use meliora::engine::{Count, Settings, NoProgress};
//! # use meliora::error::{Error, SourceFile};
//! # use meliora::{lang, tutorial};
//! # use meliora::planning::{Analysis, Options};
//! use meliora::dump::directory::{sha256, write_directory};
//! use meliora::export::{Inputs, DumpContent, export};
//! use meliora::query::Archive;
//!
//! # fn main() -> Result<(), Error> {
//! # let none = SourceFile::new("constants", "");
//! # let program = lang::load(&SourceFile::new("toy.prism", tutorial::MODEL), &none)?.program;
//! # let lang::Task { program, preferences } = lang::load_preferences(&SourceFile::new("toy.pref", tutorial::WISHES), program)?;
//! # let preferences = Arc::new(preferences);
//! # let program = Arc::new(program);
//! # let engine = Arc::new(SymbolicEngine::new(program.clone(), Settings::default())?);
//! # let mut analysis = Analysis::new(&engine, &preferences, Options::default());
//! # analysis.run(&mut |_| ())?;
//! # let scratch = tempfile::tempdir().map_err(|e| Error::Usage(e.to_string()))?;
//! # let folder = scratch.path().join("dump");
//! let inputs = Inputs {
//!     model: ("toy.prism".into(), sha256(tutorial::MODEL.as_bytes())),
//!     preferences: ("toy.pref".into(), sha256(tutorial::WISHES.as_bytes())),
//! };
//! let all = DumpContent { wanted: &|_| true, certificate: true };
//! write_directory(export(&analysis, &inputs, &all)?, &folder, false, &NoProgress)?;
//!
//! let archive = Archive::open(&folder, Some("s <= 1"), Settings::default())?;
//! let better = archive.select("reachable & !sasi:1")?;
//! assert_eq!(archive.count(&better)?, Count::from(1u32));
//! # Ok(())
//! # }
//! ```

/// The paper's Example 1.
pub const MODEL: &str = include_str!("../models/toy.prism");
/// The preferences over it.
pub const WISHES: &str = include_str!("../models/toy.pref");
/// A model in which a certain objective can be staked.
pub const GAMBLE: &str = include_str!("../models/lateral.prism");
/// The preferences over it.
pub const STAKES: &str = include_str!("../models/lateral.pref");
