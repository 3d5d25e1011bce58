//! Meliora: a symbolic model checker for opportunistic planning with incomplete preferences.
//!
//! It reads a Markov decision process in PRISM's language and a partial preference over objectives.
//! It computes the states from which a strategy can improve, and how many times: in an improvement,
//! the path reaches a state from which objectives are certain that are preferred to those certain
//! before. The theory is that of A. N. Kulkarni and J. Fu, *Opportunistic Qualitative Planning in
//! Stochastic Systems with Incomplete Preferences over Reachability Objectives* (ACC 2023), "the
//! paper" below. [`tutorial`] explains a small example step by step.
//!
//! # From the paper to the modules
//!
//! | The paper | here |
//! | --- | --- |
//! | the model: an MDP, of which only the support matters | [`lang`] reads it, [`model`] is the flat program, [`engine`] computes with sets of its states |
//! | the preorder on objectives | [`model::preference`] |
//! | almost-sure and positive winning regions | [`engine::Engine::almost_surely_reach`], [`engine::Engine::can_reach`], [`planning::winning_regions`] |
//! | outcomes Out(s), most preferred outcomes MP(s) | [`planning::classes`] |
//! | Definition "Improvement MDP" | [`planning::improvement`], in three readings: [`planning::Safety`] |
//! | Algorithm "Level set": levels and ranks of SPI and SASI | [`planning::levels`] |
//! | SPI and SASI strategies | [`planning::strategy`], [`planning::finite_memory`]; explanations: [`planning::explain`] |
//! | (beyond the paper) how likely improvements are, how soon, at what cost | [`quantities`] |
//!
//! # Architecture
//!
//! [`lang`] parses and checks texts; the result is a flat program that does not depend on an engine
//! ([`model`]). An [`engine`], symbolic or explicit, provides sets of states and of choices. The
//! algorithms of [`planning`] are written once over these sets. Their results are plain data, which
//! `output` formats as text, JSON and pages. [`export`] and [`dump`] write regions as decision
//! diagrams. [`query`] answers queries from a dump without the model. [`certify`] re-checks a dump
//! by one-step conditions, and shares no code with the computation. [`projections`] are maps of
//! regions over two variables, and [`generate`] writes models of any size. Each of these
//! modules shows a crate, and imports between crates form no cycle.
//!
//! Most programs need the types on this page only: a [`Model`] is read from a text and explored; an
//! [`Exploration`] answers with sets of states ([`States`]) and prepares an [`Analysis`], which has
//! the results under preferences and returns [`Strategy`]s. None of them borrows, and clones share
//! their results. `sweep` (feature `output`) has the rows of many instances. [`advanced`] has the sets of each engine, variable orders and thresholds.
//!
//! The library never prints, reads the clock or the environment, or ends the process; only the
//! command does (feature `cli`). A computation that runs out of memory or time returns
//! [`error::Limit`] and keeps its results. A [`progress::ProgressSink`] cancels the work. One
//! thread does all work of an engine. A [`Selection`](engine::Selection) that is open lets several engines race, each in
//! a thread that ends with the answer; as many run at once as [`Settings::threads`] says. Only `supervise`, a feature for
//! the command and the Python package, keeps threads, and measures time and memory.
//!
//! # The crates
//!
//! | crate | contents | uses |
//! | --- | --- | --- |
//! | [`meliora_base`] | errors with places, text, files, exact numbers, diagrams as data | |
//! | [`meliora_model`] | flat programs and preferences | base |
//! | [`meliora_dump`] | the format of dumps | model |
//! | `meliora_ltl` | deterministic monitors for temporal formulas | model |
//! | [`meliora_lang`] | languages of models, preferences and properties | model, ltl |
//! | [`meliora_formats`] | model files by their content, models state by state | lang |
//! | `meliora_space` | the states of a program, listed one by one | model |
//! | [`meliora_engine`] | sets of states and of choices, symbolic and explicit | model, space |
//! | [`meliora_query`] | questions to a dump | lang, engine, dump |
//! | [`meliora_planning`] | the algorithms of the paper | engine |
//! | [`meliora_equations`] | Markov decision processes and games as graphs, and solvers of their equations | engine, space |
//! | [`meliora_quantities`] | probabilities, costs and numbers of improvements | planning, equations, dump |
//! | [`meliora_question`] | properties, the requests that they need, and their answers | planning, quantities, equations, lang |
//! | [`meliora_certify`] | the check of a dump | engine, dump |
//! | [`meliora_export`] | from an analysis to files, and projections | planning, quantities, formats |
//! | [`meliora_generate`] | grid worlds | model |
//! | `meliora_report` | results as text, JSON and pages (feature `output`) | all but generate |
//!
//! # An example
//!
//! The paper's Example 1, analysed with both engines. At the start only the first objective is
//! certain, but the actions b and c almost surely lead to a preferred one.
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
//! assert_eq!(one.most_preferred(&start)?, ["First"]);
//! assert_eq!(one.rank(Kind::Sasi, &start)?, Rank::Finite(1));
//! assert_eq!(one.strategy(Kind::Sasi)?.permitted(&start)?, ["b", "c"]);
//! # Ok(())
//! # }
//! ```
//!
//! # Five calls
//!
//! A check, a question about paths, a strategy in a loop, a dump, and many instances. The calls are those of the command;
//! each selects the engine as the command does.
//!
//! ```
//! use meliora::commands::check::Extras;
//! use meliora::engine::Selection;
//! use meliora::{Ask, Kind, Model, Options, Properties, Rank, Result, Settings, SourceFile};
//!
//! # fn main() -> Result<()> {
//! let text = "mdp
//!     const int N;
//!     module chain
//!       x : [0..N+1] init 0;
//!       [go] x<N -> 1/2: (x'=x+1) + 1/2: (x'=x);
//!       [leave] x=0 -> (x'=N+1);
//!       [stay] x>=N -> true;
//!     endmodule";
//! let wishes = SourceFile::new("chain.pref", "
//!     objective Out = F x=N+1;
//!     objective End = F x=N;
//!     objective On  = F (x=1 | x=N+1);
//!     prefer End > Out;");
//! let model = Model::parse(text, "N=3")?;
//!
//! // The report of `meliora check`, with partial results if a limit ends the work.
//! let task = model.clone().task(&wishes)?;
//! let found = task.check(Options::default(), Extras::default(), Selection::open(), &Settings::default())?;
//! assert!(found.limit.is_none() && found.report.initial[0].sasi.is_some());
//!
//! // The answers of `meliora reach --property`.
//! let asked = Properties::Texts(&["Pmin=? [ F x=3 ]", "Pmax>=1 [ F x=3 ]"]);
//! let answers = model.ask(asked, &Ask::default(), Settings::default())?.answers;
//! assert_eq!(answers.properties[1].holds, Some(true));
//!
//! // A strategy that a program follows, one state after the other.
//! let (analysis, _) =
//!     model.check_by_any(&wishes, Options::default(), Settings::default(), &|_| ())?;
//! let mut strategy = analysis.strategy(Kind::Sasi)?;
//! let mut state = model.state("x=0")?;
//! let mut memory = strategy.start(&state)?;
//! loop {
//!     let at = strategy.explain(&state, memory)?;
//!     let Some(pick) = at.pick else { break };
//!     let next = &at.actions[pick].successors[0];
//!     (state, memory) = (next.state.clone(), next.next);
//! }
//! assert_eq!(strategy.rank(&state)?, Rank::Finite(0));
//!
//! // A dump with a certificate, and its check.
//! let directory = std::env::temp_dir().join(format!("meliora-{}", std::process::id()));
//! analysis.export(&wishes, &directory)?;
//! let (_, verdict) = model.verify(&wishes, &directory, Settings::default())?;
//! assert!(verdict.violation.is_none());
//! # std::fs::remove_dir_all(&directory).ok();
//!
//! // Many instances.
//! for n in 1..=3_u32 {
//!     let task = Model::parse(text, &format!("N={n}"))?.task(&wishes)?;
//!     let (options, extras) = (Options::default(), Extras::default());
//!     let report = task.check(options, extras, Selection::open(), &Settings::default())?.report;
//!     assert_eq!(report.result.counts.as_ref().unwrap().states, (n + 2).into());
//! }
//! # Ok(())
//! # }
//! ```

pub mod advanced;
mod embed;
#[cfg(feature = "supervise")]
pub mod supervise;
pub mod tutorial;

#[doc(inline)]
pub use embed::{
    Analysis, Ask, AskResult, Exploration, Listing, Missed, Model, NamedStates, Position, Projection,
    Properties, PropertyFile, Reached, Record, RecordedRun, ShieldTable, States, Task, Terms, Wanted,
};
#[doc(inline)]
#[cfg(feature = "output")]
pub use embed::{Drawing, sweep};
#[doc(inline)]
pub use meliora_base::error::{Diagnostic, Error, Limit, Relief, Result, SourceFile};
#[doc(inline)]
pub use meliora_base::progress::{CancellationToken, NoProgress, ProgressSink};
#[doc(inline)]
pub use meliora_base::{error, progress};
#[doc(inline)]
pub use meliora_engine::{AnyEngine, Count, Order, Scope, Settings, Storage, Usage};
#[doc(inline)]
pub use meliora_export::projections;
#[doc(inline)]
pub use meliora_model::{Program, State};
#[doc(inline)]
pub use meliora_planning::{
    AnalysisResult, Event, Explanation, FiniteMemoryStrategy as Strategy, Kind, Opponent, Options, Phase,
    Rank, Safety, Scheduler, Setup, Shield, StrategyKind,
};
#[doc(inline)]
pub use meliora_quantities::{Achiever, Choose, Chooser, ValuedRule};

/// The check of a dump, from [`meliora_certify`].
pub mod certify {
    #[doc(inline)]
    pub use meliora_certify::{
        Checked, Condition, Hashes, INFORMATIVE, Verdict, Violation, pictures, read, verify,
    };
}

/// The format of dumps, from [`meliora_dump`].
pub mod dump {
    #[doc(inline)]
    pub use meliora_dump::{
        Diagram, Dump, Edge, Manifest, Members, Node, bounds, dddmp, directory, dot, manifest,
        read_directory, write_directory,
    };
}

/// Sets of states and of choices, symbolic and explicit, from [`meliora_engine`].
pub mod engine {
    #[doc(inline)]
    pub use meliora_engine::{
        Algebra, AnyEngine, Count, Dumpable, EdgeLabels, Engine, ExplicitEngine, Guided, Guiding, NoProgress,
        Order, ProgressSink, RacedQuestion, Racer, Region, Scope, Selection, Settings, Storage,
        SymbolicEngine, Usage, regions,
    };
}

/// From an analysis to files, from [`meliora_export`].
pub mod export {
    #[doc(inline)]
    pub use meliora_export::{
        DumpContent, Inputs, bounds, certify, explicit, export, read_shield, write_shield,
    };
}

/// Grid worlds, from [`meliora_generate`].
pub mod generate {
    #[doc(inline)]
    pub use meliora_generate::{
        Choices, Empty, Generated, LARGEST_BATTERY, MOST_ITEMS, MOST_ROBOTS, Parameters, from_map, gridworld,
    };
}

/// The readers of models and preferences, from [`meliora_lang`] and [`meliora_formats`].
pub mod lang {
    #[doc(inline)]
    pub use meliora_formats::{Document, load, load_given, load_with_progress};
    #[doc(inline)]
    pub use meliora_lang::{
        Checked, Given, Task, flat, implied_objectives, load_preferences, lower_target, outline_preferences,
        outline_preferences_for, parse_coalition, parse_constants, parse_expression, parse_model,
        parse_preferences, parse_property, parse_state,
    };
}

/// The work of the subcommands, as calls with a report that grows: partial results are there whenever a limit ends the
/// work.
pub mod commands {
    #[doc(inline)]
    pub use crate::embed::{GivenDump, listed, strategy_of};
    #[doc(inline)]
    #[cfg(feature = "output")]
    pub use crate::embed::{
        GivenPolicy, Kept, PageRun, PolicyAim, Work, check, compare, dump_files, explicit_files,
        induced_files, policy_text, region_dump, strategies, values,
    };
}

/// Flat programs and preferences, from [`meliora_model`]; values and diagrams, from [`meliora_base`].
pub mod model {
    #[doc(inline)]
    pub use meliora_base::{diagram, exact, members, real, value};
    #[doc(inline)]
    pub use meliora_model::{
        Branch, Command, CommandId, ModelKind, Optimum, Program, State, Synchronisation, VarId, Variable,
        expr, fault, hasse, players, predicate, preference, property, step, temporal, trend, valuation,
    };
}

/// Results as text, JSON and pages, from [`meliora_report`].
#[cfg(feature = "output")]
pub mod output {
    #[doc(inline)]
    pub use meliora_report::columns::Row;
    #[doc(inline)]
    pub use meliora_report::{
        CheckReport, CompareReport, Failure, Header, Number, PolicyReport, ReachReport, Report, Style, check,
        choose, page, policy_report, reason, schema,
    };
}

/// The algorithms of the paper, from [`meliora_planning`].
pub mod planning {
    #[doc(inline)]
    pub use meliora_planning::{
        Analysis, AnalysisResult, Class, Classes, Event, Explanation, FiniteMemoryStrategy, Improvement,
        InducedModel, Kind, Lasso, Levels, Memory, Opponent, Options, Phase, Rank, RegionSearch,
        Requirements, Safety, Sample, Scheduler, Setup, Shield, ShieldAction, ShieldNode, ShieldVariable,
        Simulation, StrategyKind, Threat, ValueRule, classes, explain, finite_memory, improvement,
        induced_model, joint, lasso, levels, region_search, regions, requirements, result, shield, simulate,
        strategy, tally, temporal, winning_regions,
    };
}

/// Probabilities, costs and numbers of improvements, from [`meliora_quantities`].
pub mod quantities {
    #[doc(inline)]
    pub use meliora_quantities::{
        Achiever, Aim, Bounds, ChoiceValues, Choose, Chooser, Cost, Earned, Exploration, Interval, Node,
        Steps, ValueOptions, ValuedRule, Values, all_states, choose, confirmed, cost, outlook, state_values,
        values,
    };

    /// The values of the states of an arena.
    pub mod path_values {
        #[doc(inline)]
        pub use meliora_equations::{Answer, Value};
    }
}

/// Properties and their answers, from [`meliora_question`].
pub mod question {
    pub use crate::embed::Kept;
    #[doc(inline)]
    pub use meliora_question::{
        Answer, Answers, Asking, Job, Listener, Options, PathGoal, PolicyKind, Questions, Required, Stopping,
        Strategies, Target, Under, WantedStrategies, Warning, answers, check_start, evaluate, list, pipeline,
        plan, race, regions, shield,
    };
}

/// Questions to a dump, from [`meliora_query`].
pub mod query {
    #[doc(inline)]
    pub use meliora_query::{Archive, Member, Selected};
}
