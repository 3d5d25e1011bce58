//! The choices and the states that are found are those of the program.

use meliora_lang as lang;
use proptest::prelude::*;

use super::Limits;
use super::explore::{Exploration, Space};
use super::weighted::{Fractions, Steps, Walker};
use meliora_base::error::SourceFile;
use meliora_base::progress::NoProgress;
use meliora_model::{Program, State, step};

/// Conditions: most compare a counter with a literal, some compare counters with each other or with sums, some are long
/// disjunctions, and two of these have no value in some states.
const CONDITIONS: &str = "b>0; b=0; b<=7; b>=20; b!=5; d<3; d=16; d>=1; x=0; x<2; x>=1; true; \
    b>0 | d=2; b<d; b+x<9; b=x; mod(d,3)=1; \
    b=1 & d=2 | b=1 & d=3 | b=4 & d<5 | b=9 | d=7 & x=1 | d=7 & x=2; \
    !(b=0 & d=1 | b=0 & (d=3 | d=4 | d>=12) | b=2 & (x=0 | x=1) | b=5 & x>0 | b=31); \
    (b=3 | b=5 | b=6 | b=9 | b=8) & (d=1 | d=2 | d=3 | d=4 & x=1); \
    b=2 | b=3 | b=4 | b=5 | d=6 | d=7 | d=8 | d=9 | x>1; b=7 | b=8 | b=9 | b=10 | mod(b,d)=1; \
    b=2 | b=4 | b>6 & b<9 | b>11 & b<=14 | mod(b,5)=3 | b=20 & b!=x | b=21; \
    b=2 | b=4 | b>6 & b<9 | b>11 & b<=14 | mod(b,5)=3 | mod(8,b)=2 | b=20 | b=21";
/// New values of the variables, some of which are out of range in some states.
const OF_B: &str = "b; b-1; b+1; b-2+x; x+b; 31; 5-x; d>3 ? 31 : b-1; x=1 ? b : 4; \
    b>5 ? b-3 : b+2; min(b+3,31); d; -b+31; b=0 ? 0 : (x<2 ? b-1 : b); floor(b/2)";
const OF_D: &str = "d; d+1; d-1; 16; d=16 ? 0 : d+1; max(d-2,0); b>9 ? d-1 : 3; 16-d; d-(b>4 ? 1 : 0); b";
const OF_X: &str = "x; 2-x; 0; 1; b>3 ? 1 : 2; mod(d,3); x<2 ? x+1 : 0";
/// Probabilities of the first of two branches.
const CHANCES: &str = "1/2; 1/3; 0; x/2; b>5 ? 1/2 : 1/4; b/31; d=0 ? 1 : 0.3; 1";

/// Writes a model from random numbers.
fn model(kind: &str, of: &[u16]) -> String {
    let mut of = of.iter().copied();
    let mut pick = move |list: &'static str| {
        let list: Vec<&str> = list.split("; ").collect();
        list[usize::from(of.next().unwrap_or(0)) % list.len()]
    };
    let mut command = |label: &str, updates: &[(&str, &'static str)]| {
        let guard = format!("{} & ({})", pick(CONDITIONS), pick(CONDITIONS));
        let mut branch = || {
            let update = |(name, values): &(&str, &'static str)| format!("({name}'={})", pick(values));
            updates.iter().map(update).collect::<Vec<_>>().join(" & ")
        };
        let (first, second) = (branch(), branch());
        let chance = pick(CHANCES);
        format!("[{label}] {guard} -> ({chance}) : {first} + 1-({chance}) : {second};\n")
    };
    let [first, second] =
        [(["", "", "s"], &[("x", OF_X), ("b", OF_B)][..]), (["s", "s", ""], &[("d", OF_D)])]
            .map(|(labels, updates)| labels.map(|label| command(label, updates)).concat());
    format!(
        "{kind} module m x : [0..2]; b : [0..31];\n{first}endmodule module n d : [0..16];\n{second}endmodule"
    )
}

/// The choices of a state with their successors, unless a command has no meaning there.
type Choices = Result<Vec<(String, Vec<(State, String)>)>, ()>;

fn of_program(program: &Program, state: &State) -> Choices {
    let steps = program.exact_steps(state).map_err(|_| ())?;
    let successors = |step: step::Step<_>| {
        let exact = |(to, p): (State, _)| (to, format!("{p:?}"));
        (format!("{:?}", step.choice), step.successors.into_iter().map(exact).collect())
    };
    Ok(steps.into_iter().map(successors).collect())
}

/// Compares all valuations, several times.
fn compare(kind: &str, of: &[u16]) {
    let text = model(kind, of);
    let program =
        lang::load(&SourceFile::new("m", &text), &SourceFile::new("constants", "")).unwrap().program;
    let values = (0..3).flat_map(|x| (0..32).flat_map(move |b| (0..17).map(move |d| vec![x, b, d])));
    let states: Vec<State> = values.collect();
    let expected: Vec<Choices> = states.iter().map(|state| of_program(&program, state)).collect();
    let (mut fractions, walker) = (Fractions::default(), Walker::new(&program, &NoProgress).unwrap());
    let codec = walker.codec().clone();
    let (mut walk, mut steps) = (walker.walk(), Steps::default());
    for round in 0..4 {
        for at in 0..states.len() {
            // Each round has its own order.
            let at = at * [1, 7, 101, 1009][round] % states.len();
            let code = codec.encode(&states[at]).unwrap();
            let found = walk.steps(&code, &mut fractions, &mut steps).map_err(drop);
            let choice = |position: usize| {
                let exact = |(to, p): (&[u64], u32)| {
                    (codec.decode(to), format!("{:?}", fractions.list()[p as usize]))
                };
                (format!("{:?}", walk.taken(position).choice), steps.of(position).map(exact).collect())
            };
            let found: Choices = found.map(|()| (0..steps.choices()).map(choice).collect());
            assert_eq!(found, expected[at], "{:?} of {text}", states[at]);
            if let Ok(expected) = found {
                walk.enable(&code).unwrap();
                let taken = (0..expected.len()).map(|at| format!("{:?}", walk.taken(at).choice));
                assert!(
                    taken.eq(expected.into_iter().map(|(choice, _)| choice)),
                    "{:?} of {text}",
                    states[at]
                );
                let names = program.choices(&states[at]).unwrap().into_iter().map(|(_, name)| name);
                assert_eq!(walk.names(&code).unwrap(), Vec::from_iter(names), "{:?} of {text}", states[at]);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn choices_are_those_of_each_state(
        of in proptest::collection::vec(0u16..1000, 0..60),
        chain in any::<bool>(),
    ) {
        compare(if chain { "dtmc" } else { "mdp" }, &of);
    }
}

/// The number of states that an exploration reaches, and that of the program's own steps.
fn reached(text: &str) -> (usize, usize) {
    let source = SourceFile::new("m", text);
    let program = lang::load(&source, &SourceFile::new("constants", "")).unwrap().program;
    let start: State = program.variables.iter().map(|v| v.initial.unwrap()).collect();
    let (mut seen, mut open) = (std::collections::BTreeSet::from([start.clone()]), vec![start]);
    while let Some(state) = open.pop() {
        let steps = program.exact_steps(&state).unwrap();
        for (to, _) in steps.into_iter().flat_map(|step| step.successors) {
            if seen.insert(to.clone()) {
                open.push(to);
            }
        }
    }
    let limits = Limits { keeps_choices: true, keeps_probabilities: true, ..Limits::default() };
    let (task, explored) = Exploration::new(program.into(), limits).unwrap().finish().unwrap();
    let (kept, weighed) = (explored.choices.unwrap(), explored.probabilities.unwrap());
    let Space::Indexed(index) = explored.space else { panic!("{text}") };
    let walker = Walker::new(&task.program, &NoProgress).unwrap();
    let (mut walk, mut fractions) = (walker.walk(), Fractions::default());
    for number in 0..explored.graph.states() {
        let (state, program) = (task.values(index.code(number)), &task.program);
        let names = program.choices(&state).unwrap().into_iter().map(|(_, name)| name);
        let list = kept.list(number);
        assert_eq!(kept.names(program, list), Vec::from_iter(names), "{state:?} of {text}");
        let mut steps = Steps::default();
        walk.steps(index.code(number), &mut fractions, &mut steps).unwrap();
        let choices = explored.graph.choices_of(number);
        assert_eq!(choices.len(), steps.choices());
        for (position, choice) in choices.enumerate() {
            let expected =
                steps.of(position).map(|(to, p)| (to.to_vec(), fractions.list()[p as usize].clone()));
            let all = weighed.fractions().list();
            let own = explored.graph.successors_of(choice).iter().zip(weighed.of(choice));
            let own = own.map(|(&to, &p)| (index.code(to as usize).to_vec(), all[p as usize].clone()));
            assert_eq!(Vec::from_iter(own), Vec::from_iter(expected), "{state:?} of {text}");
        }
    }
    (explored.graph.states(), seen.len())
}

#[test]
fn commands_that_need_a_value_of_a_wide_variable_are_found_in_every_state() {
    // The first x has more values than a table has cells, so that rows are kept for the values of k alone.
    for high in [999_999, 100] {
        for labels in [["s"; 4], ["a", "b", "c", "d"], ["", "", "a", "a"]] {
            let [a, b, c, d] = labels;
            let text = format!(
                "mdp module m x:[0..{high}]; k:[0..2]; [walk] true -> (x'=mod(2*x+3,101)); \
                 [{a}] x=2 & k=0 -> (k'=1); [{b}] x=4 & k=1 & x<9 -> (k'=2); [{c}] k=1 & x=2 -> (k'=0); \
                 [{d}] x=7 & k!=1 -> 0.5: (k'=1) + 0.5: (k'=0); endmodule"
            );
            let (found, expected) = reached(&text);
            assert_eq!(found, expected, "{text}");
            assert!(expected > 250, "{expected}");
        }
    }
}

#[test]
fn an_exploration_counts_the_guards_of_states_with_many() {
    let work = |commands: usize| {
        let many: String = (0..commands).map(|i| format!("[] y>{i} -> (y'=0);\n")).collect();
        let text = format!(
            "mdp module m x : [0..3] init 0; y : [0..1000] init 0; [] x<3 -> (x'=x+1); {many} endmodule"
        );
        let program = lang::load(&SourceFile::new("m", text), &SourceFile::new("c", "")).unwrap().program;
        let exploration = Exploration::new(program.into(), Limits::default()).unwrap();
        exploration.all_work().unwrap()
    };
    assert_eq!(work(14), work(0));
    // Where x is 1 or 2, the guards are those where it is 0, and looked up together.
    assert_eq!(work(799), work(0) + 2 * 50);
}

/// Returns the condition that two variables are in one of some cells, from an offset on.
fn cells(count: usize, offset: usize) -> String {
    let cell = |i: usize| format!("x={} & y={}", (7 * i + offset) % 30, (11 * i + offset) % count);
    Vec::from_iter((0..count).map(cell)).join(" | ")
}

/// Conditions over more than 2^16 valuations were computed in each state: on a map of 512 x 512 cells, that took 20 times as
/// long as all else.
#[test]
fn long_conditions_over_two_wide_variables_are_computed_once() {
    let text = |width: usize, count: usize| {
        let (a, b) = (cells(count, 0), cells(count, 1));
        format!(
            "mdp module m x : [0..{width}] init 0; y : [0..{width}] init 0; [] x<30 & !({a}) -> (x'=x+1); \
             [] y<30 & !({b}) -> (y'=y+1); [] x>0 -> (x'=0); endmodule"
        )
    };
    let (found, expected) = reached(&text(299, 90));
    assert_eq!(found, expected);
    let results = |width: usize, count: usize| -> Vec<usize> {
        let source = SourceFile::new("m", text(width, count));
        let program = lang::load(&source, &SourceFile::new("c", "")).unwrap().program;
        let exploration = Exploration::new(program.into(), Limits::default()).unwrap();
        exploration.task.prepared.code.memos.iter().map(|memo| memo.size).collect()
    };
    assert_eq!(results(299, 90), [300 * 300; 2]);
    // The results of both would be too many.
    assert_eq!(results(2999, 800), [3000 * 3000]);
}
