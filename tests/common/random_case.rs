//! Random models with preferences, as texts, that draw all features together. A feature that is
//! added here is met by every test that draws cases.

#![allow(dead_code, unreachable_pub, reason = "each user takes a part")]

use std::fmt;
use std::sync::Arc;

use meliora::engine::Scope;
use meliora::error::SourceFile;
use meliora::lang;
use meliora::model::Program;
use meliora::model::preference::Preferences;
use meliora::planning::Safety;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

/// A case: texts, and options of the analysis.
#[derive(Clone)]
pub struct RandomCase {
    pub model: String,
    pub preferences: String,
    /// The formulas of the objectives, without labels.
    pub formulas: Vec<String>,
    pub scope: Scope,
    pub safety: Safety,
}

impl fmt::Debug for RandomCase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}, {}\n{}{}", self.scope, self.safety, self.model, self.preferences)
    }
}

impl RandomCase {
    pub fn load(&self) -> (Arc<Program>, Arc<Preferences>) {
        let none = SourceFile::new("--const", "");
        let model = SourceFile::new("m.prism", self.model.as_str());
        let program = lang::load(&model, &none).unwrap().program;
        let preferences = SourceFile::new("m.pref", self.preferences.as_str());
        let lang::Question { program, preferences } = lang::load_preferences(&preferences, program).unwrap();
        (Arc::new(program), Arc::new(preferences))
    }
}

/// The meaning of the label "l".
const LABEL: &str = "(s=1)";

/// The reward structure of every model.
pub const REWARDS: &str = "r";

/// State formulas.
const ATOMS: [&str; 7] = ["s=0", "s=2", "s>1", "b", "s!=1", "s=2 & !b", "\"l\""];

/// Formulas over whole paths, where `P` and `Q` stand for state formulas.
const PATHS: [&str; 23] = [
    "F (P)",
    "F ((P) & X (Q))",
    "F ((P) & F (Q))",
    "(P) U (Q)",
    "F<=2 (P)",
    "X (P)",
    "G (P)",
    "(P) W (Q)",
    "G F (P)",
    "G ((P) => F (Q))",
    "F G (P)",
    "F ((P) & G (Q))",
    "(G F (P)) & (F (Q))",
    "(F (P)) & (F (Q))",
    "(F G (P)) | (G (Q))",
    "(P) M (Q)",
    "(P) U (G (Q))",
    "(F (P)) W (Q)",
    "G ((P) | F G (Q))",
    "F ((P) & G F (Q))",
    "G ((P) => ((Q) U (G !(P))))",
    "F (!(P) <=> G (Q))",
    "G<=1 (F ((P) & G (Q)))",
];

/// Safe formulas over whole paths.
const SAFE: [&str; 4] = ["G ((P) | !(Q))", "(P) W (Q)", "G ((P) => X !(Q))", "G<=1 (P)"];

/// Ways to share probability among successors, as the parts of the first ones; each of the others
/// takes the same part of the rest.
const SHARES: [&[&str]; 6] = [&[], &["0.1"], &["1/3"], &["0"], &["1/4", "0.25"], &["2/3"]];

/// A choice: its action, its share, and where it leads: a state, and whether `b` is negated.
type Choice = (&'static str, usize, Vec<(usize, bool)>);

fn choice() -> impl Strategy<Value = Choice> {
    let action = select(&["", "a", "b"][..]);
    (action, 0..SHARES.len(), vec((0..6usize, prop::bool::weighted(0.2)), 1..=3))
}

/// One of some formulas, with state formulas in it.
fn formula(forms: &'static [&'static str]) -> impl Strategy<Value = String> {
    let parts = (select(forms), select(&ATOMS[..]), select(&ATOMS[..]));
    parts.prop_map(|(form, p, q)| form.replace('P', p).replace('Q', q))
}

/// A formula over whole paths, sometimes with two parts.
fn path() -> impl Strategy<Value = String> {
    let two = (formula(&PATHS), formula(&PATHS), select(&["&", "|", "=>"][..]));
    prop_oneof![
        6 => formula(&PATHS),
        1 => two.prop_map(|(one, other, operator)| format!("({one}) {operator} ({other})")),
    ]
}

/// The parts of a model: its kind, the choices of each state, the initial states, and whether
/// a second module joins.
type Model = (&'static str, Vec<Vec<Choice>>, Vec<usize>, bool);

fn model() -> impl Strategy<Value = Model> {
    let kind = prop_oneof![3 => Just("mdp"), 1 => Just("dtmc")];
    (kind, vec(vec(choice(), 0..=3), 3..=6), vec(0..6usize, 0..=2), any::<bool>())
}

/// Preferences, with formulas over whole paths or with states that are to be reached. An objective has
/// a place; those with greater places may be preferred to others.
fn preferences(is_play: bool) -> impl Strategy<Value = (Vec<String>, String)> {
    let goal = if is_play { path().boxed() } else { formula(&["F (P)"]).boxed() };
    let safe = formula(if is_play { &SAFE } else { &SAFE[..1] });
    let objectives = vec((goal, 0..3usize), 1..=3);
    let statements = vec((0..3usize, 0..3usize, select(&[">", ">=", "~"][..])), 0..=4);
    let requirements = prop_oneof![Just(Vec::new()), vec(safe, 1..=2)];
    let empty = select(&["bottom", "gain", "incomparable"][..]);
    (objectives, statements, requirements, empty).prop_map(move |(objectives, statements, safe, empty)| {
        let (formulas, places): (Vec<String>, Vec<usize>) = objectives.into_iter().unzip();
        let history = if is_play { "play" } else { "state" };
        let mut text = format!("history = {history}; empty = {empty};\n");
        for (i, formula) in formulas.iter().enumerate() {
            text += &format!("objective o{i} = {formula};\n");
        }
        text += &order(&places, &statements);
        safe.iter().for_each(|formula| text += &format!("require {formula};\n"));
        (formulas.into_iter().map(|formula| formula.replace("\"l\"", LABEL)).collect(), text)
    })
}

/// Any case.
pub fn random_case() -> impl Strategy<Value = RandomCase> {
    let wishes = any::<bool>().prop_flat_map(preferences);
    let scope = select(&[Scope::Reachable, Scope::All][..]);
    let safety = select(&[Safety::Action, Safety::Transition, Safety::Prefix][..]);
    (model(), wishes, scope, safety).prop_map(|(model, (formulas, preferences), scope, safety)| RandomCase {
        model: text(&model),
        preferences,
        formulas,
        scope,
        safety,
    })
}

/// Statements that agree with the places of the objectives, so that none contradicts the others.
fn order(places: &[usize], statements: &[(usize, usize, &str)]) -> String {
    let mut text = String::new();
    for &(i, j, relation) in statements {
        let (i, j) = (i % places.len(), j % places.len());
        let fits = match relation {
            ">" => places[i] > places[j],
            ">=" => places[i] >= places[j],
            _ => places[i] == places[j],
        };
        if fits && i != j {
            text += &format!("prefer o{i} {relation} o{j};\n");
        }
    }
    text
}

/// Writes a model: a state variable, a flag, perhaps a module that joins the action `a`, and rewards.
fn text((kind, states, initial, synchronised): &Model) -> String {
    let last = states.len() - 1;
    let mut text = format!("{kind}\nmodule m\n  s : [0..{last}]; b : bool;\n");
    for (s, choices) in states.iter().enumerate() {
        for (action, share, successors) in choices {
            text += &format!("  [{action}] s={s} -> {};\n", branches(SHARES[*share], successors, last));
        }
    }
    text += "endmodule\n";
    if *synchronised {
        text += "module n\n  t : [0..1];\n  [a] t=0 -> 1/2: (t'=1) + 1/2: true;\n  [a] t=1 -> (t'=0);\nendmodule\n";
    }
    // Other variables may start with any value, so there are several initial states.
    let initial: Vec<String> = initial.iter().map(|s| format!("s={}", s.min(&last))).collect();
    let initial = if initial.is_empty() { "s=0 & !b".to_owned() } else { initial.join(" | ") };
    text += &format!("init {initial} endinit\nlabel \"l\" = {LABEL};\n");
    let of_action = if text.contains("[a]") { "[a] true : 3; " } else { "" };
    text + &format!("rewards \"{REWARDS}\" s=0 : 2; b : 1/2; {of_action}endrewards\n")
}

fn branches(share: &[&str], successors: &[(usize, bool)], last: usize) -> String {
    let share = &share[..share.len().min(successors.len() - 1)];
    let rest = share.iter().fold("1".to_owned(), |rest, part| rest + "-" + part);
    let others = successors.len() - share.len();
    let branch = |(i, (to, negates)): (usize, &(usize, bool))| {
        let p = share.get(i).map_or_else(|| format!("({rest})/{others}"), |part| (*part).to_owned());
        let negation = if *negates { " & (b'=!b)" } else { "" };
        format!("{p}: (s'={}){negation}", to.min(&last))
    };
    successors.iter().enumerate().map(branch).collect::<Vec<_>>().join(" + ")
}
