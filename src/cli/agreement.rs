//! Compares the results of two engines: first the numbers, then the regions state by state, then the
//! strategies at some states.

use std::collections::BTreeSet;
use std::sync::Arc;

use meliora_engine::{Engine, ProgressSink};
use meliora_model::error::Error;
use meliora_model::{Program, State};
use meliora_planning::explain::{Action, Explanation};
use meliora_planning::regions::regions;
use meliora_planning::{Analysis, FiniteMemoryStrategy, Kind, StrategyKind};

use super::plan;
use super::progress::TerminalSink;

/// Maximum number of initial states whose ranks and permitted actions are compared.
const INITIAL: usize = 16;
/// Maximum number of states of each rank and each class at which strategies are compared.
const OF_EACH: usize = 2;
/// Maximum number of ranks, of classes and of objectives for the comparison of strategies.
const GROUPS: usize = 16;
/// The sink is asked after this number of states.
const STRIDE: usize = 1024;

/// The result of a comparison.
pub(super) struct Agreement {
    /// The number of compared counts, classes, levels and ranks.
    pub(super) compared: u64,
    /// The number of states at which the strategies were compared; `None` after a difference.
    pub(super) strategies: Option<u64>,
    /// The number of states that were looked up; `None` if there were too many.
    pub(super) membership: Option<u64>,
    /// The first difference.
    pub(super) difference: Option<String>,
}

/// Compares two finished analyses of one program; `left` is that of the symbolic engine. `most` is
/// the maximum number of states for the comparison of memberships.
///
/// # Errors
/// A limit is hit.
pub(super) fn compare<E: Engine, F: Engine>(
    left: &Analysis<E>,
    right: &Analysis<F>,
    program: &Arc<Program>,
    most: u32,
    sink: &TerminalSink,
) -> Result<Agreement, Error> {
    let mut tally = Tally::default();
    results(&mut tally, left, right);
    let prospects = (left.initial_prospects(program, INITIAL)?, right.initial_prospects(program, INITIAL)?);
    tally.check(
        || "ranks and permitted actions of the initial states".to_owned(),
        &prospects.0,
        &prospects.1,
    );
    let mut membership = None;
    if tally.difference.is_none() && few(left, most) {
        membership = Some(state_by_state(&mut tally, left, right, program, sink)?);
    }
    let mut strategies = None;
    if tally.difference.is_none() {
        strategies = Some(actions(&mut tally, left, right, program)?);
    }
    let Tally { compared, difference } = tally;
    Ok(Agreement { compared, strategies, membership, difference })
}

fn few<E: Engine>(analysis: &Analysis<E>, most: u32) -> bool {
    analysis.result().counts.as_ref().is_some_and(|c| c.states <= most.into())
}

#[derive(Default)]
struct Tally {
    compared: u64,
    difference: Option<String>,
}

impl Tally {
    /// Compares one item and keeps the first difference.
    fn check<T: PartialEq + std::fmt::Debug>(&mut self, name: impl Fn() -> String, left: &T, right: &T) {
        self.compared += 1;
        if left != right && self.difference.is_none() {
            self.difference = Some(format!("{}: symbolic {left:?}, explicit {right:?}", name()));
        }
    }
}

/// Compares all counts, classes and levels.
fn results<E: Engine, F: Engine>(tally: &mut Tally, left: &Analysis<E>, right: &Analysis<F>) {
    let (a, b) = (left.result(), right.result());
    if let (Some(a), Some(b)) = (&a.counts, &b.counts) {
        tally.check(|| "states".to_owned(), &a.states, &b.states);
        tally.check(|| "choices".to_owned(), &a.choices, &b.choices);
        tally.check(|| "transitions".to_owned(), &a.transitions, &b.transitions);
        tally.check(|| "deadlocks".to_owned(), &a.deadlocks, &b.deadlocks);
        tally.check(|| "initial states".to_owned(), &a.initial, &b.initial);
        if a.unsafe_states.is_some() || b.unsafe_states.is_some() {
            tally.check(|| "unsafe states".to_owned(), &a.unsafe_states, &b.unsafe_states);
        }
    }
    tally.check(|| "number of objectives".to_owned(), &a.objectives.len(), &b.objectives.len());
    for (a, b) in a.objectives.iter().zip(&b.objectives) {
        let name = |what: &str| format!("{what} states of `{}`", a.name);
        tally.check(|| name("target"), &a.target, &b.target);
        tally.check(|| name("almost-sure"), &a.almost_sure, &b.almost_sure);
        tally.check(|| name("positive"), &a.positive, &b.positive);
    }
    let classes = (a.classes.as_deref().unwrap_or_default(), b.classes.as_deref().unwrap_or_default());
    tally.check(|| "number of classes".to_owned(), &classes.0.len(), &classes.1.len());
    for (a, b) in classes.0.iter().zip(classes.1) {
        let name = || format!("class {{{}}}", a.most_preferred.join(", "));
        tally.check(name, &(&a.most_preferred, &a.states), &(&b.most_preferred, &b.states));
    }
    tally.check(|| "improvement MDP".to_owned(), &a.improvement, &b.improvement);
    for (kind, a, b) in [(Kind::Sasi, &a.sasi, &b.sasi), (Kind::Spi, &a.spi, &b.spi)] {
        tally.check(|| format!("number of {kind} levels"), &a.levels.len(), &b.levels.len());
        for (index, (a, b)) in a.levels.iter().zip(&b.levels).enumerate() {
            tally.check(|| format!("states of {kind} level {}", index + 1), a, b);
        }
        tally.check(|| format!("end of the {kind} levels"), &a.end, &b.end);
    }
}

/// Compares what the strategies of all kinds say about some states: their actions with successors.
/// Returns the number of states.
fn actions<E: Engine, F: Engine>(
    tally: &mut Tally,
    left: &Analysis<E>,
    right: &Analysis<F>,
    program: &Arc<Program>,
) -> Result<u64, Error> {
    let states = selected(left)?;
    let objectives = 0..left.preferences().objectives.len().min(GROUPS);
    let achieve = objectives.map(|objective| (StrategyKind::Achieve, Some(objective)));
    let others = [StrategyKind::Sasi, StrategyKind::Spi, StrategyKind::Plan].map(|kind| (kind, None));
    for (kind, objective) in others.into_iter().chain(achieve) {
        let levels = kind.levels();
        let mut mine = plan::finite_memory(left, program, kind, levels, objective)?;
        let mut theirs = plan::finite_memory(right, program, kind, levels, objective)?;
        for state in &states {
            let (mine, theirs) = (explained(&mut mine, state)?, explained(&mut theirs, state)?);
            if mine != theirs {
                let name = objective.map(|o| format!(" {}", left.preferences().objectives[o].name));
                let strategy = format!("{kind}{}", name.unwrap_or_default());
                let at = program.show_state(state);
                tally.difference =
                    Some(format!("strategy {strategy} at {at}: {}", difference(&mine, &theirs)));
                return Ok(states.len() as u64);
            }
        }
    }
    Ok(states.len() as u64)
}

/// Returns the first initial states, and the first states of each rank and of each class.
fn selected<E: Engine>(analysis: &Analysis<E>) -> Result<BTreeSet<State>, Error> {
    let engine = analysis.engine();
    let mut states: BTreeSet<State> =
        engine.list_states(&engine.initial_states(), INITIAL)?.into_iter().collect();
    for kind in [Kind::Sasi, Kind::Spi] {
        let levels = analysis.levels(kind);
        let found = levels.found.iter().chain(levels.unbounded()).map(|level| &level.states);
        let mut sets = vec![engine.all_states()];
        sets.extend(found.take(GROUPS).cloned());
        for (index, own) in sets.iter().enumerate() {
            let of_rank = match sets.get(index + 1) {
                Some(above) => engine.difference(own, above)?,
                None => own.clone(),
            };
            states.extend(engine.list_states(&of_rank, OF_EACH)?);
        }
    }
    for class in analysis.classes().into_iter().flat_map(|classes| &classes.list).take(GROUPS) {
        states.extend(engine.list_states(&class.states, OF_EACH)?);
    }
    Ok(states)
}

fn explained<E: Engine>(strategy: &mut FiniteMemoryStrategy<E>, state: &[i64]) -> Result<Explanation, Error> {
    let memory = strategy.start(state)?;
    strategy.explain(state, memory)
}

/// Describes the first difference between two explanations of one state.
fn difference(left: &Explanation, right: &Explanation) -> String {
    let flags = |a: &Action| {
        let Action { kept, permitted, progress, verdict, .. } = a;
        format!("kept {kept}, permitted {permitted}, progress {progress}, {}", verdict.name())
    };
    for (a, b) in left.actions.iter().zip(&right.actions) {
        let name = &a.name;
        if flags(a) != flags(b) {
            return format!("action `{name}`: symbolic {}; explicit {}", flags(a), flags(b));
        }
        if let Some((x, y)) = a.successors.iter().zip(&b.successors).find(|(x, y)| x != y) {
            return format!("a successor of action `{name}`: symbolic {x:?}, explicit {y:?}");
        }
    }
    let others = |x: &Explanation| (x.memory, x.most_preferred.clone(), x.achieved.clone(), x.pick);
    format!("symbolic {:?}, explicit {:?}", others(left), others(right))
}

/// Compares the membership of every state in every region; equal ranks follow. Returns the number
/// of states.
fn state_by_state<E: Engine, F: Engine>(
    tally: &mut Tally,
    left: &Analysis<E>,
    right: &Analysis<F>,
    program: &Program,
    sink: &TerminalSink,
) -> Result<u64, Error> {
    let (mine, theirs) = (regions(left), regions(right));
    let all = left.whole_engine().all_states();
    let states = left.whole_engine().list_states(&all, usize::MAX)?;
    for (index, state) in states.iter().enumerate() {
        if index % STRIDE == 0
            && let Some(limit) = sink.stop()
        {
            return Err(limit.into());
        }
        for ((name, mine), (_, theirs)) in mine.iter().zip(&theirs) {
            let (mine, theirs) =
                (left.engine().contains(mine, state)?, right.engine().contains(theirs, state)?);
            if mine != theirs && tally.difference.is_none() {
                let at = program.show_state(state);
                tally.difference = Some(format!("{name} at {at}: symbolic {mine}, explicit {theirs}"));
            }
        }
    }
    Ok(states.len() as u64)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use meliora_engine::ExplicitEngine;
    use meliora_engine::Settings;
    use meliora_lang as lang;
    use meliora_model::error::SourceFile;
    use meliora_planning::Options;

    use super::super::options::{Color, ShownArgs};
    use super::*;

    /// Returns the difference that is found between two different inputs.
    fn difference(left: (&str, &str), right: (&str, &str)) -> String {
        let read = |(model, preferences): (&str, &str)| {
            let none = SourceFile::new("constants", "");
            let mut program = lang::load(&SourceFile::new("m", model), &none).unwrap().program;
            let preferences = lang::load_preferences(&SourceFile::new("p", preferences), &mut program);
            let program = Arc::new(program);
            let engine = ExplicitEngine::new(program.clone(), Settings::default()).unwrap();
            (program, Arc::new(engine), Arc::new(preferences.unwrap()))
        };
        let (left, right) = (read(left), read(right));
        let mut a = Analysis::new(&left.1, &left.2, Options::default());
        let mut b = Analysis::new(&right.1, &right.2, Options::default());
        a.run(&mut |_| ()).unwrap();
        b.run(&mut |_| ()).unwrap();
        let shown = ShownArgs { json: false, verbose: 0, quiet: true, color: Color::Never };
        let sink = TerminalSink::new(&Arc::default(), &shown);
        compare(&a, &b, &left.0, 100, &sink).unwrap().difference.unwrap_or_default()
    }

    const RING: &str = "mdp module m x : [0..3] init 0; [] true -> (x'=mod(x+1,4)); endmodule";
    const LINE: &str = "mdp module m x : [0..3] init 0; [] x<3 -> (x'=x+1); endmodule";
    const AT_1: &str = "objective A = F x=1;";

    #[test]
    fn the_first_difference_is_named() {
        assert_eq!(difference((RING, AT_1), (RING, AT_1)), "");
        let counts = difference((LINE, AT_1), (RING, AT_1));
        assert!(counts.starts_with("deadlocks: symbolic 1, explicit 0"), "{counts}");
        let larger = difference((RING, AT_1), (RING, "objective A = F x<2;"));
        assert!(larger.starts_with("target states of `A`: symbolic 1, explicit 2"), "{larger}");
    }

    #[test]
    fn sets_of_the_same_size_are_compared_state_by_state() {
        let moved = difference((RING, AT_1), (RING, "objective A = F x=2;"));
        assert_eq!(moved, "target:A at x=1: symbolic true, explicit false");
    }

    #[test]
    fn strategies_are_compared_beyond_the_initial_states() {
        let leads = |x: u8, y: u8| {
            format!(
                "mdp module m x : [0..3] init 0; [] x=0 -> (x'=1); [a] x=1 -> (x'={x}); [b] x=1 -> (x'={y}); endmodule"
            )
        };
        let found =
            difference((&leads(2, 3), "objective A = F x=2;"), (&leads(3, 2), "objective A = F x=2;"));
        assert!(found.starts_with("strategy SASI at x=1: action `a`: symbolic kept true"), "{found}");
    }
}
