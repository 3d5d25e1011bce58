//! The cells and rows of `values.csv`, also together with sets that the dump does not need.

use meliora::dump::bounds::{Bound, Bounds, Row};
use meliora::dump::manifest::{Root, RootKind};
use meliora::dump::write_directory;

use super::{Counts, GAME, SIDES, each, least};
use crate::common::prelude::*;
use crate::dumps::shop::sealed;
use crate::dumps::values::{Case, example};
use crate::dumps::values_of_games::{CYCLES, GOALS};

fn double(x: f64) -> Bound {
    Bound::Double(x)
}

fn between(lower: f64, upper: f64, rank: u32) -> Bounds {
    Bounds { lower: double(lower), upper: double(upper), rank }
}

/// Writes an edited dump, with all hashes, sizes and counts right, and reads it again; returns the
/// condition that it violates. An accepted dump must be true.
#[track_caller]
fn violated(case: &Case, edit: impl FnOnce(&mut Dump)) -> Option<String> {
    let mut dump = case.dump.clone();
    edit(&mut dump);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("dump");
    write_directory(sealed(dump), &path, false, &NoProgress).unwrap();
    let dump = match read_directory(&path, true, &NoProgress) {
        Ok(dump) => dump,
        Err(error) => return Some(error.to_string()),
    };
    let violated = case.violated(&dump);
    assert!(violated.is_some() || case.is_true(&dump), "accepted: {:?}", dump.values);
    violated
}

/// Adds a set of states to the certificate: that of another root.
fn add(dump: &mut Dump, name: &str, like: Edge) {
    let file = dump.manifest.certificate.as_mut().unwrap();
    let root = file.roots.iter().find(|root| root.kind == RootKind::States).unwrap();
    let root = Root { name: name.to_owned(), node: like, trend: None, dot: None, ..root.clone() };
    file.roots.push(root);
}

fn node(dump: &Dump, name: &str) -> Edge {
    dump.manifest.certificate.as_ref().unwrap().root(name).unwrap().node
}

fn row<'d>(dump: &'d mut Dump, arena: &str, state: i64) -> &'d mut Row {
    let rows = dump.values.as_mut().unwrap();
    rows.iter_mut().find(|row| row.arena == arena && row.state == [state]).unwrap()
}

/// P_2 is 1/6 at the base, and P_3 is 0. A level of unbounded ranks is added in which the base is.
#[test]
fn a_level_that_is_not_proved_confirms_no_bound() {
    let [model, preferences] = example("drone");
    let case = Case::of([&model, &preferences], Scope::Reachable, Safety::Prefix, "steps");
    assert_eq!(violated(&case, |_| ()), None);
    let certain = |dump: &mut Dump| {
        let base = node(dump, "layers:reachable:0");
        add(dump, "sasi:unbounded@Shore", base);
        let row = row(dump, "Shore", 0);
        row.probabilities[1] = between(1.0, 1.0, 0);
        row.costs[1] = Some(between(0.0, f64::INFINITY, 9));
    };
    let condition = "`sasi:unbounded@Shore` belongs to a dump with these options";
    assert_eq!(violated(&case, certain).as_deref(), Some(condition));
    let third = |dump: &mut Dump| {
        certain(dump);
        let base = node(dump, "layers:reachable:0");
        add(dump, "spi:unbounded@Shore", base);
        dump.manifest.values.as_mut().unwrap().levels = 3;
        for row in dump.values.iter_mut().flatten() {
            let is_base = row.arena == "Shore" && row.state == [0];
            row.probabilities.push(if is_base { between(1.0, 1.0, 0) } else { between(0.0, 0.0, 0) });
            row.costs.push(is_base.then(|| between(0.0, f64::INFINITY, 9)));
        }
    };
    assert_eq!(violated(&case, third).as_deref(), Some(condition));
}

/// From the side of class B, which C would improve on and A would not, C can be reached; no strategy from a
/// state of class A can come there. The value of the side in the arena of A is not among the statements
/// of a dump, and a row for it cannot be proved.
#[test]
fn a_row_whose_levels_are_not_proved_is_refused() {
    let model = "mdp module m s:[0..4];
        [go] s=0 -> (s'=1); [on] s=3 -> (s'=1); [up] s=1 -> (s'=2); [stay] s=2 | s=4 -> true; endmodule";
    let wishes = "objective A = F s=1; objective B = F s=2; objective C = F s=3; prefer B > A;";
    let case = Case::of([model, wishes], Scope::All, Safety::Prefix, "steps");
    assert_eq!(violated(&case, |_| ()), None);
    let rows = case.dump.values.clone().unwrap();
    for state in 0..=4 {
        for arena in ["A", "B", "C", "A+C", "B+C", "A+B", "nothing"] {
            for (lower, upper) in [(0.0, 0.0), (1.0, 1.0)] {
                let more = Row {
                    arena: arena.to_owned(),
                    state: vec![state],
                    probabilities: vec![between(1.0, 1.0, 1), between(lower, upper, 2)],
                    costs: vec![Some(between(0.0, f64::INFINITY, 9)), None],
                };
                if rows.iter().all(|row| (&row.arena, &row.state) != (&more.arena, &more.state)) {
                    violated(&case, |dump| dump.values.as_mut().unwrap().push(more));
                }
            }
        }
    }
}

/// Against the opponent the value is 3/10 at 1; with its choices taken as ours it would be 2/5.
#[test]
fn values_of_a_game_without_its_opponent_are_refused() {
    let case = Case::of([CYCLES, GOALS], Scope::All, Safety::Action, "steps");
    assert_eq!(violated(&case, |_| ()), None);
    let module = CYCLES.split_once("module").unwrap().1;
    let mdp = Case::of([&format!("mdp module{module}"), GOALS], Scope::All, Safety::Action, "steps");
    let condition =
        "each choice of the opponent has at least the lower bound of P_1, and enters a smaller rank";
    let values = |dump: &mut Dump| dump.values.clone_from(&mdp.dump.values);
    assert_eq!(violated(&case, values).as_deref(), Some(condition));
}

/// The cases whose tables are edited.
fn cases() -> Vec<Case> {
    let [model, preferences] = example("drone");
    let of = |safety| Case::of([&model, &preferences], Scope::Reachable, safety, "steps");
    let game = Case::of([GAME, SIDES], Scope::Reachable, Safety::Action, "steps");
    Safety::ALL.iter().map(|&safety| of(safety)).chain([game]).collect()
}

/// Other numbers in a cell with a bound.
fn numbers(old: &Bound) -> Vec<Bound> {
    let some = [0.0, 1.0, 0.5, f64::INFINITY].map(double).into_iter();
    some.chain([Bound::from(Ratio::new(1.into(), 6.into()))]).filter(|new| new != old).collect()
}

/// The bounds of a quantity of a row.
type Pick = fn(&mut Row, usize) -> Option<&mut Bounds>;

#[test]
fn each_cell_and_row_of_values_is_proved() {
    let mut counts = Counts::new();
    const PICKS: [(&str, Pick); 2] =
        [("p_k", |row, k| row.probabilities.get_mut(k)), ("c_k", |row, k| row.costs.get_mut(k)?.as_mut())];
    for case in cases() {
        let rows = case.dump.values.clone().unwrap();
        let edited = |edit: &dyn Fn(&mut Vec<Row>)| {
            violated(&case, |dump| edit(dump.values.as_mut().unwrap())).is_some()
        };
        for (at, row) in rows.iter().enumerate() {
            for k in 0..row.probabilities.len() {
                for (name, pick) in PICKS {
                    if !counts.takes(&format!("{name}_lower")) {
                        continue;
                    }
                    let Some(bounds) = pick(&mut row.clone(), k).cloned() else {
                        let added = |rows: &mut Vec<Row>| rows[at].costs[k] = Some(between(0.0, 9.0, 9));
                        counts.record(&format!("{name}_lower"), &[edited(&added)]);
                        continue;
                    };
                    let lower = numbers(&bounds.lower)
                        .into_iter()
                        .map(|new| edited(&|rows| pick(&mut rows[at], k).unwrap().lower = new.clone()));
                    counts.record(&format!("{name}_lower"), &lower.collect::<Vec<_>>());
                    let upper = numbers(&bounds.upper)
                        .into_iter()
                        .map(|new| edited(&|rows| pick(&mut rows[at], k).unwrap().upper = new.clone()));
                    counts.record(&format!("{name}_upper"), &upper.collect::<Vec<_>>());
                    let ranks = [0, 1, 2, 9, u32::MAX]
                        .map(|new| edited(&|rows| pick(&mut rows[at], k).unwrap().rank = new));
                    counts.record(&format!("{name}_rank"), &ranks);
                }
            }
            let arenas = ["", "Shore", "Ridge", "Wreck", "Cabin", "nothing"].map(|arena| {
                let other = |rows: &mut Vec<Row>| rows[at].arena = arena.to_owned();
                edited(&other)
            });
            counts.record("arena", &arenas);
            let states = Vec::from_iter((-1..=7).map(|at_| edited(&|rows| rows[at].state = vec![at_])));
            counts.record("variables", &states);
            let whole = [edited(&|rows| drop(rows.remove(at))), edited(&|rows| rows.push(rows[at].clone()))];
            assert!(whole[1]);
            counts.record("rows", &whole);
        }
    }
    let [statements, edits, refused] = counts.close();
    assert!(statements > least(100) && refused * 10 > edits * 6, "{statements} {edits} {refused}");
}

/// Each level that the certificate does not have is added with all states, and each probability is made
/// what the level would say: 0 or 1.
#[test]
fn no_level_that_is_added_confirms_a_value() {
    let (mut number, mut edits, mut refused) = (0_usize, 0, 0);
    for case in cases() {
        let file = case.dump.manifest.certificate.as_ref().unwrap();
        let all = node(&case.dump, "layers:reachable:1");
        for class in ["Shore", "Wreck", "nothing"] {
            for level in ["sasi:2", "sasi:3", "sasi:unbounded", "spi:3", "spi:4", "spi:unbounded"] {
                let name = format!("{level}@{class}");
                if file.root(&name).is_some() {
                    continue;
                }
                for at in 0..case.dump.values.as_ref().unwrap().len() {
                    for value in [0.0, 1.0] {
                        number += 1;
                        if !number.is_multiple_of(each()) {
                            continue;
                        }
                        let violated = violated(&case, |dump| {
                            add(dump, &name, all);
                            let row = &mut dump.values.as_mut().unwrap()[at];
                            row.probabilities[1] = between(value, value, 0);
                            row.costs[1] = (value == 1.0).then(|| between(0.0, f64::INFINITY, 9));
                        });
                        (edits, refused) = (edits + 1, refused + usize::from(violated.is_some()));
                    }
                }
            }
        }
    }
    println!("{edits} edits, {refused} refused");
    assert!(edits > least(200) && refused == edits, "{edits} {refused}");
}
