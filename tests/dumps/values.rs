//! Bounds of quantities in dumps: honest ones are confirmed, and no edit that makes one false is.

use meliora::dump::bounds::{Bound, Bounds, Row};
use meliora::dump::manifest::ValuesFile;
use meliora::dump::write_directory;
use meliora::export::bounds::{Wanted, add};
use meliora::quantities::{Cost, Earned, Exploration};

use crate::common::prelude::*;

const HASHES: Hashes<'static> = Hashes { model: "m", preferences: "p" };
const LEVELS: usize = 2;

/// End components on the way, cycles of cost 0, a slow exit, and steps that weaken.
const TRAPS: &str = "mdp module m s:[0..12];
      [stop] s<4 | s=12 -> (s'=9); [stop] s=4 -> (s'=6);
      [a] s=0 -> 0.5:(s'=1) + 0.5:(s'=2); [b] s=0 -> (s'=3); [a] s=1 -> (s'=2); [a] s=2 -> (s'=1);
      [b] s=2 -> 0.3:(s'=4) + 0.7:(s'=5); [risk] s=1 -> 0.5:(s'=4) + 0.5:(s'=11);
      [a] s=3 -> 0.999999:(s'=3) + 0.0000004:(s'=4) + 0.0000006:(s'=9);
      [free] s=4 -> true; [c] s=4 -> 1/3:(s'=7) + 2/3:(s'=8); [d] s=4 -> 0.25:(s'=7) + 0.75:(s'=6);
      [free] s=4 -> (s'=10); [free] s=10 -> 0.5:(s'=4) + 0.5:(s'=10); [e] s=10 -> 0.125:(s'=7) + 0.875:(s'=8);
      [a] s=12 -> (s'=4); [end] s>=5 & s<=9 | s=11 -> true;
    endmodule
    rewards \"fuel\" [a] true : 2; [c] true : 9; [e] true : 1/3; endrewards";
const WISHES: &str =
    "objective A = F s=9; objective B = F s=6; objective G = F s=5; objective D = F s=7; objective E = F s=8;
    prefer D > B > A; prefer E > B; prefer G > A;";
/// A walk in which every state reaches every other one, so that large components occur.
const WALK: &str = "mdp module m x:[0..60]; d:bool;
      [w] x>0 & x<60 -> 0.5:(x'=x-1) + 0.5:(x'=x+1); [r] x>0 & x<60 -> 0.3:(x'=x-1) + 0.6:(x'=x+1)&(d'=!d) + 0.1:true;
      [e] x=60 | x=0 -> true; endmodule";
const WALK_WISHES: &str = "objective A = F x=60; objective B = F x=0; prefer A > B; empty = gain;";

/// P_1, C_1, P_2, C_2, … by the arena and the state.
type Truth = BTreeMap<(String, State), Vec<(Ratio, Option<Ratio>)>>;

/// A dump with values, and the true values of its rows.
pub(super) struct Case {
    program: Arc<Program>,
    preferences: Arc<Preferences>,
    pub(super) dump: Dump,
    pub(super) width: f64,
    truth: Truth,
}

fn settings(scope: Scope) -> Settings {
    Settings { scope, memory: 64 << 20, ..Settings::default() }
}

impl Case {
    pub(super) fn of(texts: [&str; 2], scope: Scope, safety: Safety, reward: &str) -> Self {
        Case::new(texts, scope, safety, reward).unwrap()
    }

    /// Returns an error where there are no values.
    pub(super) fn new(
        [model, preferences]: [&str; 2],
        scope: Scope,
        safety: Safety,
        reward: &str,
    ) -> Result<Self, Error> {
        let source = |text: &str| SourceFile::new("text", text);
        let program = lang::load(&source(model), &source("")).unwrap().program;
        let lang::Task { program, preferences } =
            lang::load_preferences(&source(preferences), program).unwrap();
        let preferences = Arc::new(preferences);
        let program = Arc::new(program);
        let engine = Arc::new(SymbolicEngine::new(Arc::clone(&program), settings(scope)).unwrap());
        let analysis = finished(&engine, &preferences, Options { safety, max_level: None });
        let named = |text: &str| (text.to_owned(), text.to_owned());
        let inputs = Inputs { model: named(HASHES.model), preferences: named(HASHES.preferences) };
        let mut dump =
            export(&analysis, &inputs, &DumpContent { wanted: &|_| true, certificate: true }).unwrap();
        let costs: Box<dyn Cost + '_> = match program.reward_structure(Some(reward)) {
            Some(at) => Box::new(Earned { program: &program, structure: &program.rewards[at] }),
            None => Box::new(Steps),
        };
        let wanted = Wanted { levels: LEVELS, reward, costs: &*costs, limit: 10_000 };
        let width = add(&mut dump, &analysis, &wanted)?;
        let truth = truth(&analysis, &program, dump.values.as_ref().unwrap(), &*costs);
        drop(costs);
        drop(analysis);
        Ok(Case { program, preferences, dump, width, truth })
    }

    /// Returns the condition that a dump violates.
    pub(super) fn violated(&self, dump: &Dump) -> Option<String> {
        let scope = if dump.manifest.scope == "all" { Scope::All } else { Scope::Reachable };
        let verdict = verify(&self.program, &self.preferences, HASHES, dump, settings(scope)).unwrap();
        verdict.violation.map(|violation| violation.condition.to_string())
    }

    /// Returns the condition that an edited dump violates.
    #[track_caller]
    pub(super) fn refused(&self, edit: impl FnOnce(&mut Dump)) -> String {
        let mut dump = self.dump.clone();
        edit(&mut dump);
        self.violated(&dump).expect("a forged dump was accepted")
    }

    /// Returns the condition that a dump with an edited row violates.
    #[track_caller]
    pub(super) fn row_refused(&self, state: &[i64], edit: impl FnOnce(&mut Row)) -> String {
        self.refused(|dump| edit(row(dump, state)))
    }

    /// Returns true if all bounds contain the true values.
    pub(super) fn is_true(&self, dump: &Dump) -> bool {
        let contains = |bounds: &Bounds, exact: &Ratio| {
            bounds.lower.exact().is_some_and(|lower| lower <= *exact)
                && bounds.upper.exact().is_none_or(|upper| *exact <= upper)
        };
        dump.values.iter().flatten().all(|row| {
            let Some(truth) = self.truth.get(&(row.arena.clone(), row.state.clone())) else { return false };
            truth.len() == row.probabilities.len()
                && row.probabilities.iter().zip(&row.costs).zip(truth).all(|((p, c), (chance, cost))| {
                    contains(p, chance)
                        && match (c, cost) {
                            (Some(c), Some(cost)) => contains(c, cost),
                            (c, cost) => c.is_none() && cost.is_none(),
                        }
                })
        })
    }
}

/// Computes the exact values of some rows.
fn truth(analysis: &Analysis<SymbolicEngine>, program: &Program, rows: &[Row], costs: &dyn Cost) -> Truth {
    let mut values = Values::new(ValueOptions { levels: LEVELS, exact: true, within: None });
    let states: Vec<State> = rows.iter().map(|row| row.state.clone()).collect();
    let exploration = Exploration::new(values.options(), analysis, program, costs).unwrap();
    exploration.run(&mut values, &states).unwrap();
    values.solve(analysis.engine()).unwrap();
    let arena = |name: &str| {
        let named = |reference: Option<usize>| {
            let class = reference.map(|class| &analysis.classes().unwrap().list[class].most_preferred);
            let names = class.map(|class| analysis.preferences().names(class).join("+"));
            names.map(|name| if name.is_empty() { "nothing".to_owned() } else { name }).unwrap_or_default()
        };
        analysis.improvement().unwrap().arenas.iter().position(|arena| named(arena.reference) == name)
    };
    let known = |row: &Row| {
        let node = values.node(arena(&row.arena), &row.state).unwrap();
        let exact =
            |k| (values.probability(node, k).exact.unwrap(), values.cost(node, k).map(|c| c.exact.unwrap()));
        ((row.arena.clone(), row.state.clone()), (1..=row.costs.len()).map(exact).collect())
    };
    rows.iter().map(known).collect()
}

pub(super) fn row<'d>(dump: &'d mut Dump, state: &[i64]) -> &'d mut Row {
    dump.values.as_mut().unwrap().iter_mut().find(|row| row.state == state).unwrap()
}

pub(super) fn example(name: &str) -> [String; 2] {
    ["prism", "pref"].map(|kind| fs::read_to_string(format!("models/{name}.{kind}")).unwrap())
}

#[test]
fn the_values_of_a_model_under_requirements_are_confirmed() {
    let tempting = "mdp module m s:[0..3] init 0; [b] s=0 -> 1/4:(s'=1)+3/4:(s'=2);
        [a] s=0 -> 1/2:(s'=1)+1/2:(s'=3); endmodule";
    let required = [
        [tempting, "objective A = F s=1; require G !(s=3);"],
        [TRAPS, &format!("{WISHES} require G s!=8; require G s!=11;")],
    ];
    for texts in required {
        for scope in [Scope::Reachable, Scope::All] {
            for &safety in Safety::ALL {
                let case = Case::of(texts, scope, safety, "steps");
                assert_eq!(case.violated(&case.dump), None, "{safety} {scope:?}");
                // The bounds of the whole model are refused, which are greater.
                let [model, wishes] = texts;
                let without = wishes.split(" require").next().unwrap();
                let whole = Case::of([model, without], scope, safety, "steps");
                let condition = case.refused(|dump| dump.values.clone_from(&whole.dump.values));
                assert!(!condition.is_empty(), "{safety} {scope:?}");
            }
        }
    }
}

#[test]
fn every_dump_with_values_is_accepted() {
    for name in ["toy", "drone", "lateral", "lateral_prefix", "robot5x5"] {
        let [model, preferences] = example(name);
        for &safety in Safety::ALL {
            let case = Case::of([&model, &preferences], Scope::Reachable, safety, "steps");
            assert_eq!(case.violated(&case.dump), None, "{name} {safety}");
            assert!(case.width <= 1e-6, "{name} {safety}: {}", case.width);
            assert!(case.is_true(&case.dump), "{name} {safety}");
        }
    }
    for &safety in Safety::ALL {
        for (texts, reward) in
            [([TRAPS, WISHES], "steps"), ([TRAPS, WISHES], "fuel"), ([WALK, WALK_WISHES], "steps")]
        {
            let case = Case::of(texts, Scope::All, safety, reward);
            assert_eq!(case.violated(&case.dump), None, "{safety} {reward}");
            assert!(case.width <= 1e-6, "{safety} {reward}: {}", case.width);
            assert!(case.is_true(&case.dump), "{safety} {reward}");
        }
    }
}

#[test]
fn values_are_read_as_they_were_written() {
    let case = Case::of([TRAPS, WISHES], Scope::All, Safety::Prefix, "fuel");
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("dump");
    write_directory(case.dump.clone(), &path, false, &NoProgress).unwrap();
    let dump = read_directory(&path, true, &NoProgress).unwrap();
    assert_eq!(dump.values, case.dump.values);
    assert_eq!(case.violated(&dump), None);
    // An older dump with values is replaced.
    write_directory(case.dump.clone(), &path, false, &NoProgress).unwrap();
    let file = path.join("values.csv");
    let text = fs::read_to_string(&file).unwrap();
    for changed in [text.replacen("0.", "1.", 1), text[..text.len() - 1].to_owned(), text.clone() + "x\n"] {
        fs::write(&file, changed).unwrap();
        assert!(matches!(read_directory(&path, true, &NoProgress), Err(Error::Dump { .. })));
    }
    fs::remove_file(&file).unwrap();
    assert!(matches!(read_directory(&path, true, &NoProgress), Err(Error::Io { .. })));
}

#[test]
fn each_condition_on_values_fails_alone() {
    let case = Case::of([TRAPS, WISHES], Scope::All, Safety::Action, "fuel");
    let refused = |state: i64, edit: fn(&mut Row)| case.row_refused(&[state], edit);
    assert_eq!(refused(0, |r| r.arena.push('A')), "`A` is an arena of the dump");
    assert_eq!(refused(0, |r| r.state[0] = 9), "each row of `values.csv` is about a state with P_1 > 0");
    assert_eq!(refused(0, |r| r.state[0] = 1), "each state has one row per arena in `values.csv`");
    assert_eq!(
        case.refused(|dump| drop(dump.values.as_mut().unwrap().remove(0))),
        "each of the 7 states with P_1 > 0 has a row in `values.csv`: 6 have one"
    );
    assert_eq!(refused(4, |r| r.probabilities.swap(0, 1)), "P_1 is 1 where 1 improvements are certain");
    assert_eq!(refused(4, |r| r.probabilities[1].upper = double(0.1)), "P_2 is 0 outside of `spi:2`");
    assert_eq!(refused(4, |r| r.costs[0] = None), "C_1 is given exactly where P_1 is 1");
    assert_eq!(
        refused(3, |r| r.costs[0] = Some(between(0.0, 1.0, 1))),
        "C_1 is given exactly where P_1 is 1"
    );
    assert_eq!(
        refused(3, |r| r.probabilities[0].lower = double(0.5)),
        "the bounds of P_1 are finite below and in order"
    );
    assert_eq!(
        refused(4, |r| cost(r).lower = double(f64::INFINITY)),
        "the bounds of C_1 are finite below and in order"
    );
    assert_eq!(refused(3, |r| r.probabilities[0].upper = double(1.5)), "P_1 is at most 1");
    // All three states of an end component say so.
    let above = "some kept choice has at least the lower bound of P_2, and enters a smaller rank";
    let raised = |dump: &mut Dump| {
        (0..3).for_each(|s| row(dump, &[s]).probabilities[1] = between(1.0, 1.0, 9 - s as u32));
    };
    assert_eq!(case.refused(raised), above);
    assert_eq!(refused(0, |r| r.probabilities[1].rank = 1), above);
    assert_eq!(
        refused(3, |r| r.probabilities[0] = between(0.0, 0.399, 0)),
        "no kept choice has more than the upper bound of P_1"
    );
    let cheaper = "some permitted choice costs at most the upper bound of C_1, and enters a smaller rank";
    // States 4 and 10 form a cycle of cost 0.
    let free = |dump: &mut Dump| [4, 10].iter().for_each(|&s| *cost(row(dump, &[s])) = between(0.0, 0.0, 7));
    assert_eq!(case.refused(free), cheaper);
    assert_eq!(refused(4, |r| cost(r).rank = 1), cheaper);
    assert_eq!(
        refused(12, |r| *cost(r) = between(2.5, 2.6, 3)),
        "no permitted choice costs less than the lower bound of C_1"
    );
    let values =
        |edit: fn(&mut ValuesFile)| case.refused(|dump| edit(dump.manifest.values.as_mut().unwrap()));
    assert_eq!(values(|v| v.reward = "gold".to_owned()), "`gold` is a reward structure of the model");
    assert!(values(|v| v.reward = "steps".to_owned()).contains("C_1"));
    assert_eq!(values(|v| v.levels = 3), "each row of `values.csv` has the values of all levels");
    assert_eq!(case.refused(|dump| dump.values = None), "the manifest names `values.csv` if it is there");
}

#[test]
fn certainty_is_shown_where_the_levels_do_not_show_it() {
    let case = Case::of([TRAPS, WISHES], Scope::All, Safety::Transition, "fuel");
    let refused = |state: i64, edit: fn(&mut Row)| case.row_refused(&[state], edit);
    assert_eq!(
        refused(3, |r| r.probabilities[0].upper = double(1.0)),
        "P_1 has bounds of 1, or an upper bound below 1"
    );
    assert_eq!(
        refused(3, |r| *r = Row {
            costs: vec![Some(between(9.0, 9.0, 4)), None],
            probabilities: vec![between(1.0, 1.0, 4), r.probabilities[1].clone()],
            ..r.clone()
        }),
        "some kept choice has at least the lower bound of P_1, and enters a smaller rank"
    );
    assert_eq!(
        refused(0, |r| r.probabilities[0] = between(0.9, 0.99, 2)),
        "C_1 is given exactly where P_1 is 1"
    );
}

pub(super) fn double(x: f64) -> Bound {
    Bound::Double(x)
}

pub(super) fn between(lower: f64, upper: f64, rank: u32) -> Bounds {
    Bounds { lower: double(lower), upper: double(upper), rank }
}

pub(super) fn cost(row: &mut Row) -> &mut Bounds {
    row.costs[0].as_mut().unwrap()
}
