//! Plans and strategies that achieve an objective: the chain that they induce almost surely reaches
//! the promised states.

use meliora::engine::{AnyEngine, Engine, Scope};
use meliora::model::preference::Goal;
use meliora::planning::{Analysis, InducedModel, Rank, Safety, Scheduler, StrategyKind, temporal};
use proptest::test_runner::Config;

use crate::Analysed;
use crate::coverage::draw_until;
use crate::graphs::{Set, bottom_components, chain, edges};
use crate::random_case::{RandomCase, random_case};

/// Counts of the checks, so that a test that checks nothing fails.
#[derive(Debug, Default)]
struct Seen {
    achieved: usize,
    kept: usize,
    improved: usize,
}

struct Check<'a> {
    analysis: &'a Analysis<AnyEngine>,
    kind: StrategyKind,
    objective: Option<usize>,
}

impl Check<'_> {
    /// Checks the chain from a state of the scope in which the kind promises to achieve something.
    fn chain(&self, unfolded: &InducedModel, seen: &mut Seen) {
        assert!(unfolded.complete);
        let edges = edges(unfolded);
        seen.improved += usize::from(edges.iter().flatten().any(|(_, improves)| *improves));
        for component in bottom_components(&chain(&edges), 0, &Set::new()) {
            self.component(unfolded, &component, seen);
        }
    }

    /// Checks the nodes that a run visits infinitely often, or the one where it ends.
    fn component(&self, unfolded: &InducedModel, component: &Set, seen: &mut Seen) {
        let first = &unfolded.nodes[*component.first().unwrap()].at;
        let Some(objective) = first.pursued() else {
            let unbounded = first.memory.level == Rank::Unbounded;
            let nothing = first.most_preferred.is_empty();
            assert!(self.kind == StrategyKind::Plan && (nothing || unbounded), "{first:?}");
            return;
        };
        for &node in component {
            let at = &unfolded.nodes[node].at;
            assert_eq!(at.pursued(), Some(objective));
            match self.kind {
                StrategyKind::Plan => assert!(at.most_preferred.contains(objective), "{at:?}"),
                _ => assert_eq!(self.objective, Some(objective)),
            }
        }
        if first.is_achieved() {
            assert_eq!(component.len(), 1);
            seen.achieved += 1;
        } else {
            self.kept(unfolded, component, objective);
            seen.kept += 1;
        }
    }

    /// Checks the acceptance condition on the nodes that are visited infinitely often.
    fn kept(&self, unfolded: &InducedModel, component: &Set, objective: usize) {
        let engine = self.analysis.engine();
        let Goal::Satisfy { condition, .. } = &self.analysis.preferences().objectives[objective].goal else {
            panic!("a target is reached almost surely");
        };
        let all = |set: &<AnyEngine as Engine>::States, some: bool| {
            let holds = |node: &usize| engine.contains(set, &unfolded.nodes[*node].at.state).unwrap();
            if some { component.iter().any(holds) } else { component.iter().all(holds) }
        };
        let accepted = condition.disjuncts().unwrap().iter().any(|disjunct| {
            all(&temporal::allowed(engine, disjunct).unwrap(), false)
                && disjunct.again.iter().all(|mark| all(&engine.states_where(mark).unwrap(), true))
        });
        assert!(accepted, "objective {objective} is not satisfied forever: {component:?}");
    }
}

fn check(case: &RandomCase, seen: &mut Seen) {
    let [symbolic, explicit, _] = Analysed::all(case);
    for of in [symbolic, explicit] {
        let objectives = of.analysis.preferences().objectives.len();
        let achieve = (0..objectives).map(|o| (StrategyKind::Achieve, Some(o)));
        let plans = [None, Some(objectives - 1)].map(|named| (StrategyKind::Plan, named));
        for (kind, objective) in achieve.chain(plans) {
            let mut strategy = of.strategy(kind, objective);
            let mut starts = of.safe_states();
            if kind == StrategyKind::Achieve {
                let sure = &of.analysis.outcomes().unwrap().get(objective.unwrap()).unwrap().almost_sure;
                starts.retain(|state| of.analysis.engine().contains(sure, state).unwrap());
            }
            for start in starts.iter().take(12) {
                for scheduler in [Scheduler::Progress, Scheduler::Permissive] {
                    let starts = std::slice::from_ref(start);
                    let unfolded = InducedModel::unfold(&mut strategy, starts, scheduler, 10_000).unwrap();
                    Check { analysis: &of.analysis, kind, objective }.chain(&unfolded, seen);
                }
            }
        }
    }
}

#[test]
fn a_sure_objective_is_achieved_by_its_strategy() {
    let config = Config { source_file: Some(file!()), ..crate::amount::random(80) };
    let enough = |seen: &Seen| seen.achieved > 500 && seen.kept > 500;
    draw_until(&config, &random_case(), enough, |case, seen| check(&case, seen));
}

// Few random models have guaranteed improvements.
#[test]
fn plans_improve_and_then_achieve() {
    // From 0, chance decides between 1 and 2, where different objectives are sure.
    let model = "mdp module m s : [0..3]; [] s=0 -> 1/2: (s'=1) + 1/2: (s'=2); [] s=1 -> true; [] s=2 -> true; \
                 endmodule init true endinit";
    for (history, more) in [("state", ""), ("play", "objective o2 = G !(s=2);")] {
        let wishes =
            format!("history = {history}; objective o0 = F s=1; objective o1 = F (s=2 | s=3); {more}");
        let (model, scope, safety) = (model.to_owned(), Scope::All, Safety::Action);
        let case = RandomCase { model, preferences: wishes, formulas: Vec::new(), scope, safety };
        let mut seen = Seen::default();
        check(&case, &mut seen);
        assert!(seen.achieved > 0 && seen.improved > 0, "{case:?}: {seen:?}");
    }
}
