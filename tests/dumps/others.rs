//! Dumps of other models and preferences under the manifest of the true one: their sets fit each other, since they were computed.

use proptest::prelude::*;

use crate::common::prelude::*;
use crate::dumps::shop::same_regions;
use crate::dumps::verify::Case;

/// The files of a dump under the manifest of another one.
fn under_the_manifest_of(truth: &Dump, other: &Dump) -> Dump {
    let Manifest { regions, certificate, .. } = other.manifest.clone();
    let manifest = Manifest { regions, certificate, ..truth.manifest.clone() };
    Dump { manifest, ..other.clone() }
}

/// A program with its preferences.
pub(super) fn read(model: &str, preferences: &str) -> (Program, Preferences) {
    let source = SourceFile::new("m.prism", model);
    let program = lang::load(&source, &SourceFile::new("--const", "")).unwrap().program;
    let lang::Task { program, preferences } =
        lang::load_preferences(&SourceFile::new("p.pref", preferences), program).unwrap();
    (program, preferences)
}

pub(super) fn case(model: &str, preferences: &str, scope: Scope, safety: Safety) -> Case {
    let (program, preferences) = read(model, preferences);
    Case::of(program, preferences, scope, safety)
}

/// The set of states of the dump is not closed under the steps of the model, and says nothing of where they lead.
#[test]
fn states_that_only_the_model_reaches_are_missed() {
    let model = |kind: &str, last: u8| {
        let steps = format!("[] s=0 -> (s'=1); [] s=1 -> (s'={last}); [] s=2 -> (s'=2);");
        format!("{kind} module m s:[0..2] init 0; {steps} endmodule")
    };
    let reached = "objective A = F s=1; objective B = F s=2; prefer B > A;";
    let temporal = "objective A = F (s=1 & F s=2); objective B = G F s=1; prefer B > A;";
    for (kind, preferences) in [("mdp", reached), ("mdp", temporal), ("dtmc", reached), ("dtmc", temporal)] {
        for &safety in Safety::ALL {
            let truth = case(&model(kind, 2), preferences, Scope::Reachable, safety);
            let other = case(&model(kind, 1), preferences, Scope::Reachable, safety);
            let forged = under_the_manifest_of(&truth.dump, &other.dump);
            let violation = truth.verify(&forged).unwrap().violation.expect("a false dump was accepted");
            assert_eq!(violation.condition.to_string(), "each successor of a state of `reachable` is in it");
        }
    }
}

/// A branch exists if and only if its exact probability is positive, however near to 0 the double is.
#[test]
fn dumps_with_a_branch_of_probability_0_or_without_a_tiny_one_are_refused() {
    let model = |p: &str| {
        let steps = format!("[a] s=0 -> {p}:(s'=1) + 1-({p}):(s'=2); [b] s=1 -> true; [b] s=2 -> (s'=0);");
        format!("mdp module m s:[0..2] init 0; {steps} endmodule")
    };
    let preferences = "objective A = F s=1; objective B = G F s=2; prefer A > B;";
    for (true_p, other_p) in
        [("(0.1+0.2-0.3)", "1e-400"), ("1e-400", "0"), ("(1-(1-1e-30))", "0"), ("(s+0.1-0.1)", "(s+0.1)")]
    {
        for (safety, scope) in Safety::ALL.iter().flat_map(|&s| [(s, Scope::Reachable), (s, Scope::All)]) {
            let truth = case(&model(true_p), preferences, scope, safety);
            let other = case(&model(other_p), preferences, scope, safety);
            assert_eq!(truth.verify(&truth.dump).unwrap().violation, None);
            let forged = under_the_manifest_of(&truth.dump, &other.dump);
            let violation = truth.verify(&forged).unwrap().violation;
            assert!(violation.is_some(), "{true_p} {other_p} {safety:?} {scope:?}");
        }
    }
}

/// Every successor of monitored states is asked for where planning starts everywhere, too.
#[test]
fn states_of_monitors_that_are_left_out_are_missed() {
    let model =
        |first: &str| format!("mdp module m s:[0..1] init 0; [] s=0 -> {first}; [] s=1 -> (s'=1); endmodule");
    let preferences = "objective A = F (s=0 & X s=1); objective B = F G s=0; prefer B > A;";
    for &safety in Safety::ALL {
        let truth = case(&model("0.5:(s'=1) + 0.5:(s'=0)"), preferences, Scope::All, safety);
        let other = case(&model("(s'=0)"), preferences, Scope::All, safety);
        let forged = under_the_manifest_of(&truth.dump, &other.dump);
        let violation = truth.verify(&forged).unwrap().violation.expect("a false dump was accepted");
        assert_eq!(violation.condition.to_string(), "each successor of a state of `reachable` is in it");
    }
}

/// For each state its choices, each with its successors.
type Table = Vec<Vec<BTreeSet<usize>>>;

fn table() -> impl Strategy<Value = Table> {
    (2usize..6).prop_flat_map(|states| {
        let successors = prop::collection::btree_set(0..states, 1..3);
        prop::collection::vec(prop::collection::vec(successors, 0..3), states)
    })
}

fn text(table: &Table) -> String {
    let mut text = format!("mdp module m s:[0..{}] init 0;\n", table.len() - 1);
    for (state, choices) in table.iter().enumerate() {
        for successors in choices {
            let branch = |to: &usize| format!("1/{}:(s'={to})", successors.len());
            let branches: Vec<String> = successors.iter().map(branch).collect();
            text += &format!("  [] s={state} -> {};\n", branches.join(" + "));
        }
    }
    text + "endmodule"
}

/// A change that gives a similar model, mostly one with fewer successors.
#[derive(Debug, Clone)]
enum Change {
    /// The state is removed from all successors; a choice without another successor gets a self-loop.
    Avoid(usize),
    /// One choice has one successor more or less.
    Toggle(usize, usize, usize),
    /// One choice is removed.
    Drop(usize, usize),
}

impl Change {
    fn of(&self, table: &Table) -> Table {
        let (mut changed, n) = (table.clone(), table.len());
        match *self {
            Change::Avoid(to) => {
                for (state, choice) in
                    changed.iter_mut().enumerate().flat_map(|(s, all)| all.iter_mut().map(move |c| (s, c)))
                {
                    choice.remove(&(to % n));
                    if choice.is_empty() {
                        choice.insert(state);
                    }
                }
            }
            Change::Toggle(state, choice, to) => {
                let choices = &mut changed[state % n];
                let at = choice % choices.len().max(1);
                if let Some(choice) = choices.get_mut(at)
                    && (!choice.remove(&(to % n)) || choice.is_empty())
                {
                    choice.insert(to % n);
                }
            }
            Change::Drop(state, choice) => {
                let choices = &mut changed[state % n];
                if !choices.is_empty() {
                    choices.remove(choice % choices.len());
                }
            }
        }
        changed
    }
}

fn change() -> impl Strategy<Value = Change> {
    prop_oneof![
        2 => any::<usize>().prop_map(Change::Avoid),
        1 => any::<(usize, usize, usize)>().prop_map(|(s, c, t)| Change::Toggle(s, c, t)),
        1 => any::<(usize, usize)>().prop_map(|(s, c)| Change::Drop(s, c)),
    ]
}

/// Three objectives over two sets of states; over whole paths, the third visits its set infinitely often.
fn preferences(targets: &[BTreeSet<usize>; 2], whole_plays: bool, empty: &str) -> String {
    let among = |set: &BTreeSet<usize>| {
        set.iter().map(|s| format!(" | s={s}")).fold("false".to_owned(), |text, next| text + &next)
    };
    let [a, b] = targets.each_ref().map(among);
    let (third, history) = match whole_plays {
        true => (format!("G F ({a})"), "history = play;"),
        false => (format!("F (({a}) & ({b}))"), ""),
    };
    format!(
        "objective A = F ({a}); objective B = F ({b}); objective C = {third};\n\
         prefer B > A; prefer B > C; empty = {empty}; {history}"
    )
}

proptest! {
    #![proptest_config(meliora_amount::random(400))]

    /// An accepted dump has the regions of the true model.
    #[test]
    fn a_dump_of_a_similar_model_is_refused_unless_it_says_the_same(
        table in table(),
        change in change(),
        targets in [prop::collection::btree_set(0usize..4, 0..3), prop::collection::btree_set(0usize..4, 0..3)],
        whole_plays in any::<bool>(),
        all in any::<bool>(),
        safety in prop::sample::select(Safety::ALL),
        empty in prop::sample::select(vec!["bottom", "gain", "incomparable"]),
        other_empty in prop::option::weighted(0.2, Just("gain")),
    ) {
        let scope = if all { Scope::All } else { Scope::Reachable };
        let targets = targets.map(|set| set.into_iter().filter(|s| *s < table.len()).collect());
        let preferences = preferences(&targets, whole_plays, empty);
        let truth = case(&text(&table), &preferences, scope, safety);
        let of_other = self::preferences(&targets, whole_plays, other_empty.unwrap_or(empty));
        let other = case(&text(&change.of(&table)), &of_other, scope, safety);
        let forged = under_the_manifest_of(&truth.dump, &other.dump);
        match truth.verify(&forged) {
            // Choices are numbered by more or fewer bits.
            Err(_) => prop_assert!(!truth.dump.manifest.variables().eq(other.dump.manifest.variables())),
            Ok(verdict) if verdict.violation.is_some() => {}
            Ok(_) => prop_assert!(same_regions(&truth.dump, &forged), "accepted: {}", text(&table)),
        }
    }
}
