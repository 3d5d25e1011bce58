//! The answers of guided searches are those of the explicit engine, and their policies are closed.

use std::sync::Arc;

use meliora_lang as lang;
use proptest::prelude::*;

use super::{Guided, Guiding};
use crate::engine::{Algebra, Engine};
use crate::explicit::{ExplicitEngine, Exploration};
use crate::settings::Settings;
use meliora_base::error::SourceFile;
use meliora_base::value::Value;
use meliora_model::predicate::Predicate;
use meliora_model::{Program, State};

/// Conditions over the variables of a module.
const CONDITIONS: &str = "x=0; x=3; x!=2; x<2; x>=1; y=1; !(y=2); b; !b; true; true; x=1|y=0; x<y; (b & y<2)|x=3; \
    b ? x>0 : y=1";
/// Updates; all new values are in the ranges.
const UPDATES: &str = "(x'=0); (x'=3); (x'=1)&(b'=true); (x'=min(x+1,3)); (x'=max(x-1,0)); (y'=x=3 ? 0 : 2); (y'=1); \
    (b'=!b); (b'=y=2); true; (x'=y); (y'=min(x,2))&(b'=false); (x'=b ? 2 : (y=0 ? 3 : x)); (x'=y+(b?1:0))";
const TARGETS: &str = "x=3; x=3 & b; y=2 & !b; x=2 | y=1; x+y=5; x<y & b; x=3 & alive; b & alive & y=2";

/// Draws a model with a synchronised module and its target.
fn model(of: &[u16], is_synchronised: bool) -> (String, &'static str) {
    let mut of = of.iter().copied();
    let mut pick = move |list: &'static str| {
        let list: Vec<&str> = list.split("; ").collect();
        list[usize::from(of.next().unwrap_or(0)) % list.len()].trim()
    };
    let mut commands = String::new();
    for at in 0..5 {
        let label = if is_synchronised && at < 2 { "s" } else { "" };
        commands += &format!(
            "[{label}] alive & ({}) & ({}) -> 0.5 : {} + 0.3 : {} + 0.2 : {};\n",
            pick(CONDITIONS),
            pick(CONDITIONS),
            pick(UPDATES),
            pick(UPDATES),
            // An outcome that is lost in some states, and often wherever the command is enabled.
            pick("true; (x'=1); (y'=0); (alive'=false); (alive'=x>1)")
        );
    }
    let other = if is_synchronised {
        "module n z : [0..1] init 0; [s] z=0 -> (z'=1); [s] x>0 -> 0.5 : (z'=0) + 0.5 : true; endmodule"
    } else {
        ""
    };
    let text = format!(
        "mdp module m x : [0..3] init 0; y : [0..2] init 0; b : bool init false; alive : bool init true;\n\
         {commands}endmodule {other}"
    );
    (text, pick(TARGETS))
}

/// Reads a model with a target.
fn read(text: &str, target: &str) -> (Arc<Program>, Predicate) {
    let program = lang::load(&SourceFile::new("m", text), &SourceFile::new("constants", "")).unwrap().program;
    let target = SourceFile::new("target", target);
    let target = lang::lower_target(&program, &target, &lang::parse_expression(&target).unwrap()).unwrap();
    (program.into(), target)
}

/// Prepares a search; `None` for models that it is not made for.
fn guided(program: &Arc<Program>, target: &Predicate) -> Option<Guided> {
    let mut exploration = Exploration::new(Arc::clone(program), Settings::default().limits()).unwrap();
    exploration.begin().unwrap();
    Guided::new(&exploration, target).unwrap()
}

/// Runs a search in turns of some steps.
fn answer(guided: &mut Guided, steps: u64) -> bool {
    loop {
        if let Some(answer) = guided.run(guided.work() + steps).unwrap() {
            return answer;
        }
    }
}

fn is_in(target: &Predicate, state: &State) -> bool {
    target.eval(state) == Ok(Value::Bool(true))
}

/// Checks by the program that a policy is closed, and that the target stays reachable.
fn check(program: &Program, target: &Predicate, initial: &[State], policy: &[Guiding]) {
    let known = |state: &State| policy.iter().position(|own| own.state == *state);
    let mut open: Vec<State> = initial.to_vec();
    let (mut seen, mut near) = (Vec::new(), vec![false; policy.len()]);
    let mut next = vec![Vec::new(); policy.len()];
    while let Some(state) = open.pop() {
        if is_in(target, &state) || seen.contains(&state) {
            continue;
        }
        let at = known(&state).expect("a state without a choice");
        let steps = program.steps(&state).unwrap();
        let step =
            steps.iter().find(|step| step.choice == policy[at].choice).expect("a choice that is not enabled");
        assert_eq!(step.name, policy[at].name);
        next[at] = step.successors.iter().map(|(to, _)| to.clone()).collect();
        open.extend(next[at].iter().cloned());
        seen.push(state);
    }
    assert_eq!(seen.len(), policy.len());
    for round in 1..=policy.len() {
        let before = near.clone();
        for at in 0..policy.len() {
            near[at] |= next[at].iter().any(|to| is_in(target, to) || known(to).is_some_and(|to| before[to]));
            assert_eq!(near[at], policy[at].distance <= round, "the distance of {:?}", policy[at]);
        }
    }
    assert!(near.iter().all(|near| *near));
}

/// Compares a search with the explicit engine, and checks that lost states are lost.
fn compare(text: &str, target: &str, steps: u64) {
    let (program, target) = read(text, target);
    let Some(mut search) = guided(&program, &target) else { panic!("not made for {text}") };
    let engine = ExplicitEngine::new(Arc::clone(&program), Settings::default()).unwrap();
    let goal = engine.states_where(&target).unwrap();
    let region = engine.almost_surely_reach(&goal, &engine.all_choices()).unwrap().states;
    let initial = engine.initial_states();
    let expected = engine.is_empty(&engine.difference(&initial, &region).unwrap()).unwrap();
    let found = answer(&mut search, steps);
    assert_eq!(found, expected, "{text}");
    for (state, standing) in search.part.standing.iter().enumerate().filter(|(_, standing)| standing.is_lost)
    {
        let values = search.task.values(search.part.index.code(state));
        assert!(!engine.contains(&region, &values).unwrap(), "{values:?} {standing:?} {text}");
    }
    if found {
        let initial = engine.list_states(&initial, 100).unwrap();
        check(&program, &target, &initial, &search.policy().unwrap());
    }
}

proptest! {
    #![proptest_config(meliora_amount::random(512))]

    #[test]
    fn answers_are_those_of_all_states(
        of in proptest::collection::vec(any::<u16>(), 30),
        is_synchronised: bool,
        steps in 1..40u64,
    ) {
        let (text, target) = model(&of, is_synchronised);
        compare(&text, target, steps);
    }
}

#[test]
fn a_policy_is_repaired_where_an_outcome_is_lost() {
    // The short way may break; the long one is safe.
    let text = "mdp module m x : [0..9] init 0; broken : bool init false;
        [] x=0 & !broken -> 0.5 : (x'=9) + 0.5 : (broken'=true);
        [] x<8 & !broken -> 0.5 : (x'=x+1) + 0.5 : true;
        [] x=8 -> (x'=9);
        [] x>0 & x<9 & broken -> (x'=x-1); endmodule";
    compare(text, "x=9", u64::MAX / 2);
    let (program, target) = read(text, "x=9");
    let mut search = guided(&program, &target).unwrap();
    assert!(answer(&mut search, 1));
    assert_eq!(search.policy().unwrap().len(), 9);
}

#[test]
fn most_states_are_not_explored_where_estimates_lead_to_the_target() {
    let flags: String = (0..60).map(|i| format!("b{i} : bool init false;")).collect();
    let set: String = (0..60).map(|i| format!("[] !b{i} -> 0.5 : (b{i}'=true) + 0.5 : true;")).collect();
    let all = (0..60).map(|i| format!("b{i}")).collect::<Vec<_>>().join("&");
    let (program, target) = read(&format!("mdp module m {flags} {set} endmodule"), &all);
    let mut search = guided(&program, &target).unwrap();
    assert!(answer(&mut search, 100));
    assert_eq!(search.policy().unwrap().len(), 60);
    assert!(search.part.standing.len() <= 61 * 60, "{}", search.part.standing.len());
}

#[test]
fn a_short_way_that_is_always_fatal_is_left_once() {
    // From each of the many places, three bad steps are nearer than the good ones at the far end.
    let flags: String = (0..12).map(|i| format!("b{i} : bool init false;")).collect();
    let toggle: String = (0..12).map(|i| format!("[] alive -> (b{i}'=!b{i});")).collect();
    let text = format!(
        "mdp module m alive : bool init true; g : [0..3] init 0; x : [0..20] init 0; {flags} {toggle}
        [] alive & g<3 & g=0 -> 0.5 : (g'=1) + 0.5 : (alive'=false);
        [] alive & g=1 -> 0.5 : (g'=2) + 0.5 : (alive'=false);
        [] alive & g=2 -> 0.5 : (g'=3) + 0.5 : (alive'=false);
        [] alive & x<20 -> (x'=x+1); [] alive & x=20 & g<3 -> (g'=g+1); endmodule"
    );
    let (program, target) = read(&text, "g=3");
    let mut search = guided(&program, &target).unwrap();
    assert!(answer(&mut search, 100));
    check(&program, &target, &search.initial_states(), &search.policy().unwrap());
    assert!(search.guide.fatal.iter().filter(|is| **is).count() == 3);
    assert!(search.part.standing.len() < 1000, "{}", search.part.standing.len());
}

#[test]
fn a_barrier_of_estimates_is_crossed_where_many_states_look_better() {
    // By the relaxation, one move in each direction leads to the next cell of the diagonal. But the cells between are
    // left only after nine steps, which look like a detour from each of the many settings of 16 flags.
    let flags: String = (0..16).map(|i| format!("b{i} : bool init false; ")).collect();
    let toggle: String = (0..16).map(|i| format!("[] true -> (b{i}'=!b{i});\n")).collect();
    let text = format!(
        "mdp module m x : [0..2] init 0; y : [0..2] init 0; d : [0..9] init 0; {flags} {toggle}
        [] x=y & x<2 -> 0.5 : (x'=x+1)&(d'=0) + 0.5 : true; [] x=y & y<2 -> 0.5 : (y'=y+1)&(d'=0) + 0.5 : true;
        [] x!=y & d<9 -> (d'=d+1); [] x=1 & y=0 & d=9 -> (y'=1); [] x=0 & y=1 & d=9 -> (x'=1);
        [] x=2 & y=1 & d=9 -> (y'=2); [] x=1 & y=2 & d=9 -> (x'=2); endmodule"
    );
    let (program, target) = read(&text, "x=2 & y=2");
    let mut search = guided(&program, &target).unwrap();
    assert!(answer(&mut search, 100));
    check(&program, &target, &search.initial_states(), &search.policy().unwrap());
    assert!(search.part.standing.len() < 10_000, "{}", search.part.standing.len());
}

#[test]
fn a_path_is_known_from_all_states_that_agree_in_what_it_needs() {
    // The counter k and the flag b matter to no command on the way, z only to the first one.
    let text = "mdp module m x : [0..9] init 0; k : [0..6] init 0; z : [0..2] init 0; b : bool init false;
        [] x=0 & z<2 -> 0.5 : (x'=1)&(z'=2) + 0.5 : (k'=min(k+1,6));
        [] x>0 & x<9 -> 0.5 : (x'=x+1)&(b'=!b) + 0.5 : (x'=0)&(z'=1)&(k'=min(k+1,6)); endmodule";
    compare(text, "x=9", 1);
    let (program, target) = read(text, "x=9");
    let mut search = guided(&program, &target).unwrap();
    assert!(answer(&mut search, 1));
    let needed = |values: [i64; 4], search: &mut Guided| {
        let state = search.advice.find(&values)?;
        Some(search.advice.needs[&state].iter().map(|variable| variable.0).collect::<Vec<_>>())
    };
    assert_eq!(needed([0, 6, 0, 1], &mut search), Some(vec![0, 2]));
    assert_eq!(needed([5, 6, 2, 1], &mut search), Some(vec![0]));
    assert_eq!(needed([0, 6, 2, 1], &mut search), None);
}

#[test]
fn all_initial_states_count() {
    let text = "mdp global x : [0..2]; module m b : bool; [] x=1 -> (b'=true); [] x=2 -> 0.5 : (b'=true) + 0.5 : true; \
        endmodule init x>0 & !b endinit";
    compare(text, "b", 3);
    compare(&text.replace("x>0", "true"), "b", 3);
}

#[test]
fn programs_with_states_that_must_be_checked_are_left_to_others() {
    let of = |text: &str| {
        let (program, target) = read(text, "x=2");
        guided(&program, &target).is_some()
    };
    let guard = |guard: &str| format!("mdp module m x : [0..2] init 0; [] {guard} -> (x'=x+1); endmodule");
    assert!(of(&guard("x<2")) && of(&guard("x!=2 & x>0")) && of(&guard("!(x>=2)")) && of(&guard("x=1")));
    assert!(!of(&guard("x<=2")) && !of(&guard("true")));
    assert!(!of(&guard("x<2").replace("mdp", "dtmc")));
    assert!(!of("mdp module m x : [0..2] init 0; [] true -> x/4 : (x'=0) + 1-x/4 : (x'=1); endmodule"));
}
