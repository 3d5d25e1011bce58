//! The names that most files of tests use.

pub(crate) use std::collections::{BTreeMap, BTreeSet};
pub(crate) use std::fs;
pub(crate) use std::path::{Path, PathBuf};
pub(crate) use std::sync::Arc;

pub(crate) use meliora::Model;
pub(crate) use meliora::advanced::symbolic::Thresholds;
pub(crate) use meliora::certify::{Hashes, verify};
pub(crate) use meliora::dump::{Diagram, Dump, Edge, Manifest, read_directory};
pub(crate) use meliora::engine::regions::{Regions, regions};
pub(crate) use meliora::engine::{
    Algebra, AnyEngine, Count, EdgeLabels, Engine, ExplicitEngine, Order, Region, Scope, Settings, Storage,
    SymbolicEngine,
};
pub(crate) use meliora::error::{Error, Limit, SourceFile, render};
pub(crate) use meliora::export::{DumpContent, Inputs, export};
pub(crate) use meliora::lang::{self, Checked, Document};
pub(crate) use meliora::model::exact::Ratio;
pub(crate) use meliora::model::expr::{Binary, ExprId, ExprPool, Unary};
pub(crate) use meliora::model::predicate::{Predicate, Predicates};
pub(crate) use meliora::model::preference::{
    Change, Empty, Goal, History, Objective, Preferences, Preorder, Relation, Statement,
};
pub(crate) use meliora::model::step::{Choice, Step};
pub(crate) use meliora::model::{ModelKind, Program, State, VarId, Variable};
pub(crate) use meliora::planning::{
    Analysis, FiniteMemoryStrategy, InducedModel, Kind, Levels, Options, Rank, RegionSearch, Safety,
    Scheduler, Setup, Shield, Simulation, StrategyKind,
};
pub(crate) use meliora::progress::{NoProgress, ProgressSink};
pub(crate) use meliora::quantities::{Aim, Steps, ValueOptions, Values};
pub(crate) use num_traits::{One, Zero};
pub(crate) use rand::rngs::{ChaCha8Rng, SmallRng};
pub(crate) use rand::{RngExt, SeedableRng};
pub(crate) use serde_json::{Value as Json, json};

pub(crate) use super::brute::Brute;
pub(crate) use super::random_program::{empty_program, random_predicate, random_program};
pub(crate) use super::set_up::{finished, parsed, task};
pub(crate) use crate::cli::common::{Finished, Scratch, executable, run};
pub(crate) use meliora_amount::{share, takes, takes_one_of};
