//! Compares the results of two engines: first the numbers, then the regions state by state, then the
//! strategies at some states.

use std::collections::BTreeSet;
use std::sync::Arc;

use meliora_base::error::Result;
use meliora_base::progress::ProgressSink;
use meliora_engine::{Engine, Storage};
use meliora_model::preference::{Goal, ObjectiveSet};
use meliora_model::{Program, State};
use meliora_planning::explain::{Action, Explanation};
use meliora_planning::regions::regions;
use meliora_planning::{Analysis, Class, FiniteMemoryStrategy, Kind, StrategyKind};

use crate::embed::results::strategy_of;
use meliora_report::CheckReport;
use meliora_report::check::CheckFindings;
use serde_json::Value as Json;

/// Maximum number of initial states at which strategies are compared.
const INITIAL: usize = 16;
/// Maximum number of states of each rank and each class at which strategies are compared.
const OF_EACH: usize = 2;
/// Maximum number of ranks, of classes and of objectives for the comparison of strategies.
const GROUPS: usize = 16;
/// The sink is asked after this number of states.
const STRIDE: usize = 1024;

/// The result of a comparison.
pub(super) struct Agreement {
    /// The number of compared values in the reports of `check`, and of other comparisons.
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
    sink: &dyn ProgressSink,
) -> Result<Agreement> {
    let mut tally = Tally::default();
    // The rest of the reports names the engine, its time and its memory.
    let mine = CheckReport::of_analysis(left, program, Storage::Symbolic, "")?.findings;
    let theirs = CheckReport::of_analysis(right, program, Storage::Explicit, "")?.findings;
    tally.compare("", Some(&json(&mine)), Some(&json(&theirs)));
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
    /// Compares two values at a place and keeps the first difference.
    fn compare(&mut self, place: &str, left: Option<&Json>, right: Option<&Json>) {
        match (left, right) {
            (Some(Json::Object(a)), Some(Json::Object(b))) => {
                let others = b.keys().filter(|name| !a.contains_key(*name));
                let dot = if place.is_empty() { "" } else { "." };
                for name in a.keys().chain(others) {
                    self.compare(&format!("{place}{dot}{name}"), a.get(name), b.get(name));
                }
            }
            (Some(Json::Array(a)), Some(Json::Array(b))) => {
                for index in 0..a.len().max(b.len()) {
                    let (x, y) = (a.get(index), b.get(index));
                    let name = x.and_then(|x| x["name"].as_str());
                    let name = name.map_or_else(|| index.to_string(), str::to_owned);
                    self.compare(&format!("{place}[{name}]"), x, y);
                }
            }
            _ => {
                self.compared += 1;
                if left != right && self.difference.is_none() {
                    let [left, right] = [left, right].map(shown);
                    self.difference = Some(format!("{place}: symbolic {left}, explicit {right}"));
                }
            }
        }
    }
}

/// Returns the results of a report as JSON.
fn json(report: &CheckFindings) -> Json {
    // The keys are strings and the values plain, so the conversion cannot fail.
    serde_json::to_value(report).unwrap_or_default()
}

/// Formats a value, which may be absent.
fn shown(value: Option<&Json>) -> String {
    match value {
        None => "none".to_owned(),
        Some(Json::String(text)) => text.clone(),
        Some(value) => value.to_string(),
    }
}

/// Compares what the strategies of all kinds say about some states: their actions with successors.
/// Returns the number of states.
fn actions<E: Engine, F: Engine>(
    tally: &mut Tally,
    left: &Analysis<E>,
    right: &Analysis<F>,
    program: &Arc<Program>,
) -> Result<u64> {
    let states = selected(left)?;
    let achieve = aims(left).into_iter().map(|aim| (StrategyKind::Achieve, aim));
    let others =
        [StrategyKind::Sasi, StrategyKind::Spi, StrategyKind::Plan].map(|kind| (kind, ObjectiveSet::new()));
    let supported = |(kind, aim): &(StrategyKind, ObjectiveSet)| {
        FiniteMemoryStrategy::check_achieved(left, *kind, aim).is_ok()
    };
    for (kind, aim) in others.into_iter().chain(achieve).filter(supported) {
        let levels = kind.levels();
        let mut mine = strategy_of(left, program, kind, levels, &aim)?;
        let mut theirs = strategy_of(right, program, kind, levels, &aim)?;
        for state in &states {
            let (mine, theirs) = (explained(&mut mine, state)?, explained(&mut theirs, state)?);
            if mine != theirs {
                let strategy = format!("{kind} {}", left.preferences().names(&aim).join(","));
                let (strategy, at) = (strategy.trim_end(), program.show_state(state));
                tally.difference =
                    Some(format!("strategy {strategy} at {at}: {}", difference(&mine, &theirs)));
                return Ok(states.len() as u64);
            }
        }
    }
    Ok(states.len() as u64)
}

/// Returns the first objectives, each alone, and two targets of each of the first classes together.
fn aims<E: Engine>(analysis: &Analysis<E>) -> BTreeSet<ObjectiveSet> {
    let objectives = &analysis.preferences().objectives;
    let alone = (0..objectives.len().min(GROUPS)).map(|objective| std::iter::once(objective).collect());
    let classes = analysis.classes().into_iter().flat_map(|classes| &classes.list).take(GROUPS);
    let targets = |class: &Class<E>| -> ObjectiveSet {
        let is_target = |&objective: &usize| matches!(objectives[objective].goal, Goal::Reach(_));
        class.most_preferred.iter().filter(is_target).take(2).collect()
    };
    alone.chain(classes.map(targets).filter(|pair| pair.len() == 2)).collect()
}

/// Returns the first initial states, and the first states of each rank and of each class.
fn selected<E: Engine>(analysis: &Analysis<E>) -> Result<BTreeSet<State>> {
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

fn explained<E: Engine>(strategy: &mut FiniteMemoryStrategy<E>, state: &[i64]) -> Result<Explanation> {
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
    sink: &dyn ProgressSink,
) -> Result<u64> {
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

    use meliora_base::error::SourceFile;
    use meliora_base::progress::NoProgress;
    use meliora_engine::ExplicitEngine;
    use meliora_engine::Settings;
    use meliora_lang as lang;
    use meliora_planning::Options;
    use serde_json::json;

    use super::*;

    /// Returns the difference that is found between two different inputs.
    fn difference(left: (&str, &str), right: (&str, &str)) -> String {
        let read = |(model, preferences): (&str, &str)| {
            let none = SourceFile::new("constants", "");
            let program = lang::load(&SourceFile::new("m", model), &none).unwrap().program;
            let question = lang::load_preferences(&SourceFile::new("p", preferences), program).unwrap();
            let program = Arc::new(question.program);
            let engine = ExplicitEngine::new(program.clone(), Settings::default()).unwrap();
            (program, Arc::new(engine), Arc::new(question.preferences))
        };
        let (left, right) = (read(left), read(right));
        let mut a = Analysis::new(&left.1, &left.2, Options::default());
        let mut b = Analysis::new(&right.1, &right.2, Options::default());
        a.run(&mut |_| ()).unwrap();
        b.run(&mut |_| ()).unwrap();
        compare(&a, &b, &left.0, 100, &NoProgress).unwrap().difference.unwrap_or_default()
    }

    const RING: &str = "mdp module m x : [0..3] init 0; [] true -> (x'=mod(x+1,4)); endmodule";
    const LINE: &str = "mdp module m x : [0..3] init 0; [] x<3 -> (x'=x+1); endmodule";
    const AT_1: &str = "objective A = F x=1;";

    #[test]
    fn the_first_difference_is_named() {
        assert_eq!(difference((RING, AT_1), (RING, AT_1)), "");
        let counts = difference((LINE, AT_1), (RING, AT_1));
        assert_eq!(counts, "counts.deadlocks: symbolic 1, explicit 0");
        let larger = difference((RING, AT_1), (RING, "objective A = F x<2;"));
        assert_eq!(larger, "objectives[A].target: symbolic 1, explicit 2");
    }

    #[test]
    fn every_field_of_the_results_is_compared() {
        let report = json!({
            "counts": {"states": "2"}, "classes": [{"states": "1"}, {"states": "1"}], "improvement": null,
        });
        let found = |change: fn(&mut Json)| {
            let (mut other, mut tally) = (report.clone(), Tally::default());
            change(&mut other);
            tally.compare("", Some(&report), Some(&other));
            assert!(tally.compared >= 4);
            tally.difference.unwrap_or_default()
        };
        assert_eq!(found(|_| ()), "");
        assert_eq!(found(|r| r["improvement"] = json!("1")), "improvement: symbolic null, explicit 1");
        assert_eq!(found(|r| r["new"] = json!(1)), "new: symbolic none, explicit 1");
        let shorter = found(|r| r["classes"] = json!([{"states": "1"}]));
        assert_eq!(shorter, "classes[1]: symbolic {\"states\":\"1\"}, explicit none");
        assert_eq!(found(|r| r["counts"] = json!({})), "counts.states: symbolic 2, explicit none");
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
