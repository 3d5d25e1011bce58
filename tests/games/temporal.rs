//! Temporal objectives of games: against all memoryless strategies of both sides on the product with
//! the monitors, against the model with one player, and one engine against the other.

use meliora::advanced::lang::ltl::{Monitoring, parse_formula};
use meliora::model::temporal::{Asks, Begin, Condition};
use meliora::planning::AnalysisResult;
use meliora::planning::temporal::judged;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::select;

use super::raw::{Enforced, Raw, Won, loaded, program};
use super::{settings, thresholds};
use crate::common::prelude::*;
use crate::common::random_game::with_turns;

pub(super) const REFUSED: &str = "a temporal formula of a game that combines recurrence and persistence";
/// Products with more pairs of strategies are not enumerated.
const MOST_PAIRS: usize = 2048;

/// A formula over the labels "p" and "q", mostly one that games accept.
pub(super) fn formula() -> impl Strategy<Value = String> {
    let label = || select(vec!["\"p\"", "\"q\"", "(!\"p\")", "(\"p\" & \"q\")"]).prop_map(str::to_owned);
    let unary = (select(vec!["X", "F", "G", "F<=1", "F X", "G X"]), label());
    let binary = (label(), select(vec!["U", "W", "R", "M"]), label());
    let decided = prop_oneof![
        unary.prop_map(|(o, a)| format!("({o} {a})")),
        binary.prop_map(|(a, o, b)| format!("({a} {o} {b})")),
    ];
    let wild = (select(vec!["G F", "F G", "G F", "F G", "G F X"]), label());
    let nested =
        (label(), label(), select(vec!["(G (@ => F #))", "(F (@ & G #))", "(@ U (G #))", "(G (@ | X F #))"]));
    let wild = prop_oneof![
        2 => wild.prop_map(|(o, a)| format!("({o} {a})")),
        1 => nested.prop_map(|(a, b, text)| text.replace('@', &a).replace('#', &b)),
    ];
    prop_oneof![2 => decided, 3 => wild].prop_recursive(2, 4, 2, |inner| {
        let operator = select(vec!["&", "|", "=>", "<=>"]);
        prop_oneof![
            4 => (inner.clone(), operator, inner.clone()).prop_map(|(a, o, b)| format!("({a} {o} {b})")),
            1 => inner.prop_map(|a| format!("(!{a})")),
        ]
    })
}

/// A game of `states` states with up to `choices` choices each, perhaps none, and the labels of the states.
pub(super) fn game(states: usize, choices: usize) -> impl Strategy<Value = (Raw, String)> {
    let state = (any::<bool>(), vec(vec(0..states, 1..=3), 0..=choices));
    let labels = (vec(any::<bool>(), states), vec(any::<bool>(), states));
    (vec(state, states), labels).prop_map(|(all, (p, q))| {
        let (theirs, mut choices): (Vec<bool>, Vec<Vec<Vec<usize>>>) = all.into_iter().unzip();
        for successors in choices.iter_mut().flatten() {
            successors.sort_unstable();
            successors.dedup();
        }
        let label = |name: &str, set: &[bool]| {
            let states = (0..set.len()).filter(|&s| set[s]).map(|s| format!(" | x={s}"));
            format!("label \"{name}\" = false{};\n", states.collect::<String>())
        };
        (Raw { theirs, choices }, label("p", &p) + &label("q", &q))
    })
}

/// The product of a program with the monitors of a formula; `None` for a formula that games refuse.
fn watched(program: &Program, formula: &str) -> Option<(Arc<Program>, Condition)> {
    let source = SourceFile::new("formula", formula);
    let mut watching = Monitoring::new(program);
    let condition = match watching.watch(&source, &parse_formula(&source).unwrap(), "w") {
        Ok(condition) => condition,
        Err(error) => {
            let text = error.to_string();
            assert!(text.contains(REFUSED) || text.contains("cases over its"), "{formula}: {text}");
            return None;
        }
    };
    let product = Arc::new(watching.finish(Begin::Everywhere).unwrap());
    let condition = condition.map(&|mark| product.predicate(mark));
    Some((product, condition))
}

fn listed<E: Engine>(engine: &E, condition: &Condition) -> Regions<Vec<State>> {
    let found = RegionSearch::of_condition(engine, condition).all().unwrap();
    found.map(|x| engine.list_states(&x, usize::MAX).unwrap())
}

/// The regions of the states with fresh monitors; the engines may differ in the others.
fn answers<E: Engine>(engine: &E, product: &Program, condition: &Condition) -> Regions<Vec<State>> {
    let fresh = product.predicate(product.monitors.as_ref().unwrap().fresh);
    let found = RegionSearch::of_condition(engine, condition).all().unwrap();
    let found = judged(engine, &fresh, found).unwrap();
    found.map(|x| engine.list_states(&x, usize::MAX).unwrap())
}

/// The states of a product by their number, as a game.
struct Product {
    states: Vec<State>,
    raw: Raw,
    /// For each mark of the condition, the marked states as bits.
    marked: Vec<(Predicate, u64)>,
}

impl Product {
    /// Returns `None` if there are too many strategies.
    fn new(game: &Raw, product: &Program, engine: &impl Engine, condition: &Condition) -> Option<Self> {
        let states = engine.list_states(&engine.all_states(), usize::MAX).unwrap();
        let number: BTreeMap<&State, usize> = states.iter().zip(0..).collect();
        let owner = |s: &State| game.theirs[s[0] as usize];
        let choices: Vec<Vec<Vec<usize>>> = states
            .iter()
            .map(|s| {
                let steps = product.steps(s).unwrap();
                steps.iter().map(|step| step.successors.iter().map(|(t, _)| number[t]).collect()).collect()
            })
            .collect();
        let raw = Raw { theirs: states.iter().map(owner).collect(), choices };
        let marked = condition.marks().into_iter().map(|mark| {
            let here = engine.list_states(&engine.states_where(&mark).unwrap(), usize::MAX).unwrap();
            let bits = here.iter().fold(0, |bits, s| bits | 1 << number[s]);
            (mark, bits)
        });
        let small = raw.len() <= 40 && raw.pairs() <= MOST_PAIRS;
        let marked = if small { marked.collect() } else { return None };
        Some(Product { raw, marked, states })
    }

    /// Returns whether paths that visit exactly these states infinitely often satisfy a condition.
    fn holds(&self, condition: &Condition, within: u64) -> bool {
        match condition {
            Condition::Constant(value) => *value,
            Condition::All(parts) => parts.iter().all(|part| self.holds(part, within)),
            Condition::Any(parts) => parts.iter().any(|part| self.holds(part, within)),
            Condition::Leaf(asks, mark) => {
                let marked = self.marked.iter().find(|(other, _)| other == mark).unwrap().1;
                matches!(asks, Asks::Accept | Asks::Again) == (marked & within != 0)
            }
        }
    }

    /// The outcome of two strategies: almost all paths end in a bottom component and visit all of it again
    /// and again.
    fn outcome(&self, picks: &[usize], condition: &Condition) -> Enforced {
        let n = self.raw.len();
        let next = |s: usize| self.raw.choices[s][picks[s]].iter().fold(0u64, |bits, t| bits | 1 << t);
        let mut reached: Vec<u64> = (0..n).map(|s| 1 << s | next(s)).collect();
        for via in 0..n {
            for s in 0..n {
                if reached[s] >> via & 1 == 1 {
                    reached[s] |= reached[via];
                }
            }
        }
        let among = |bits: u64| (0..n).filter(move |t| bits >> t & 1 == 1);
        let is_bottom = |s: usize| among(reached[s]).all(|t| reached[t] >> s & 1 == 1);
        let good: Vec<Option<bool>> =
            (0..n).map(|s| is_bottom(s).then(|| self.holds(condition, reached[s]))).collect();
        let ends = |s: usize| among(reached[s]).filter_map(|t| good[t]);
        Enforced {
            surely: (0..n).map(|s| ends(s).all(|good| good)).collect(),
            possibly: (0..n).map(|s| ends(s).any(|good| good)).collect(),
        }
    }

    /// The four regions by enumeration.
    fn regions(&self, condition: &Condition) -> Regions<Vec<State>> {
        let [us, them] = self.raw.enforced_by(|picks| self.outcome(picks, condition));
        let list = |won: &Won| {
            let all = self.states.iter().zip(won).filter(|(_, won)| **won);
            all.map(|(s, _)| s.clone()).collect::<Vec<_>>()
        };
        Regions {
            pmax_one: list(&us.surely),
            pmax_positive: list(&us.possibly),
            pmin_one: list(&them.surely),
            pmin_positive: list(&them.possibly),
        }
    }
}

/// Compares both engines with all strategies; returns false if the product is too large or refused.
fn compare(raw: &Raw, labels: &str, formula: &str) -> bool {
    let Some((product, condition)) = watched(&program(&(raw.text() + labels)), formula) else { return false };
    let explicit = ExplicitEngine::new(product.clone(), settings(Scope::All, thresholds()[0])).unwrap();
    let Some(brute) = Product::new(raw, &product, &explicit, &condition) else { return false };
    let expected = brute.regions(&condition);
    assert_eq!(listed(&explicit, &condition), expected, "{formula}: {raw:?} {labels}");
    let secured = RegionSearch::of_condition(&explicit, &condition).goal().unwrap();
    let reaching = explicit.almost_surely_reach(&secured, &explicit.all_choices()).unwrap().states;
    let reaching = explicit.list_states(&reaching, usize::MAX).unwrap();
    if condition.reaching_suffices().unwrap() {
        assert_eq!(reaching, expected.pmax_one, "{formula}: {raw:?} {labels}");
    } else {
        assert!(reaching.iter().all(|s| expected.pmax_one.contains(s)), "{formula}: {raw:?} {labels}");
    }
    for thresholds in thresholds() {
        let symbolic = SymbolicEngine::new(product.clone(), settings(Scope::All, thresholds)).unwrap();
        assert_eq!(listed(&symbolic, &condition), expected, "{formula}: {raw:?} {labels}");
    }
    true
}

/// In x=0 the opponent stays, or moves on to x=1 without "p"; there chance leads back or to x=2.
fn choice_of_the_opponent(theirs: bool) -> Raw {
    Raw {
        theirs: vec![theirs, false, false],
        choices: vec![vec![vec![0], vec![1]], vec![vec![0, 2]], vec![vec![2]]],
    }
}

#[test]
fn persistence_may_be_won_where_the_opponent_never_lets_us_settle() {
    let labels = "label \"p\" = x!=1;\nlabel \"q\" = x=2;\n";
    for formula in ["F G \"p\"", "G F (!\"p\")", "(F G \"p\") & (F \"q\")", "(G \"p\") | (F \"q\")"] {
        assert!(compare(&choice_of_the_opponent(true), labels, formula), "{formula}");
    }
    let (product, condition) =
        watched(&program(&(choice_of_the_opponent(true).text() + labels)), "F G \"p\"").unwrap();
    let engine = ExplicitEngine::new(product, settings(Scope::All, thresholds()[0])).unwrap();
    let mut search = RegionSearch::of_condition(&engine, &condition);
    let secured = search.goal().unwrap();
    let states = |x: &_| engine.list_states(x, 9).unwrap().iter().map(|s| s[0]).collect::<Vec<_>>();
    let found = search.all().unwrap();
    // x=2 is secured. From the other states, the opponent may stay in x=0, or let us reach x=2.
    assert!(states(&secured).iter().all(|&x| x == 2));
    assert_eq!(states(&engine.all_states()), states(&found.pmax_one));
}

#[test]
fn strategies_refuse_an_objective_where_the_opponent_chooses_how_it_is_satisfied() {
    let text = choice_of_the_opponent(true).text() + "label \"p\" = x!=1;\nlabel \"q\" = x=2;\n";
    for (formula, refused) in [
        ("F G \"p\"", true),
        ("(G \"p\") | (F \"q\")", true),
        ("G F \"q\"", false),
        ("((F \"q\") | (X !\"p\")) & (G (x<3))", false),
    ] {
        let (program, preferences) = loaded(&text, &format!("history = play; objective Goal = {formula};"));
        let engine =
            ExplicitEngine::new(program.clone(), settings(Scope::Reachable, thresholds()[0])).unwrap();
        let (analysis, _) = analysed(engine, &preferences, Safety::Action);
        for (kind, named) in [(StrategyKind::Plan, None), (StrategyKind::Achieve, Some(0))] {
            let strategy = FiniteMemoryStrategy::of_kind(&analysis, &program, kind, Kind::Sasi, named);
            let message = strategy.err().map_or_else(String::new, |error| error.to_string());
            assert_eq!(
                message.contains("that achieves `Goal` is not supported"),
                refused,
                "{formula}: {message}"
            );
        }
    }
}

#[test]
fn all_games_of_two_states() {
    let options: Vec<Vec<Vec<usize>>> = {
        let all = [vec![0], vec![1], vec![0, 1]];
        let two = (0..3).flat_map(|i| (0..i).map(move |j| vec![i, j]));
        let one = (0..3).map(|i| vec![i]);
        one.chain(two)
            .chain([vec![]])
            .map(|of| of.into_iter().map(|i: usize| all[i].clone()).collect())
            .collect()
    };
    let labels = "label \"p\" = x=0;\nlabel \"q\" = x=1;\n";
    let (mut all, mut number) = (0, 0);
    for formula in [
        "G F \"p\"",
        "F G \"p\"",
        "(F \"q\") <=> (G F \"p\")",
        "(X \"q\") => (F G \"p\")",
        "(G \"p\") | (F X \"p\")",
        "G (\"p\" => F \"q\")",
        "(G F \"p\") & (G F \"q\")",
    ] {
        for first in &options {
            for second in &options {
                for owners in 0..4 {
                    all += 1;
                    if !takes_one_of(15, all) {
                        continue;
                    }
                    let theirs = vec![owners & 1 == 1, owners & 2 == 2];
                    let raw = Raw { theirs, choices: vec![first.clone(), second.clone()] };
                    number += usize::from(compare(&raw, labels, formula));
                }
            }
        }
    }
    assert!(number > share(1000) / 3, "{number}");
}

proptest! {
    #![proptest_config(meliora_amount::random(600))]

    #[test]
    fn regions_are_those_of_all_strategies((raw, labels) in game(4, 2), formula in formula()) {
        compare(&raw, &labels, &formula);
    }
}

proptest! {
    #![proptest_config(meliora_amount::random(500))]

    #[test]
    fn both_engines_agree_on_random_games(
        of in vec(0u16..1000, 0..120),
        labels in [vec(0u16..1000, 0..8), vec(0u16..1000, 0..8)],
        formula in formula(),
        bits in any::<u64>(),
        all in any::<bool>(),
    ) {
        let program = labelled(&of, &labels, |program| with_turns(program, bits));
        let Some((product, condition)) = watched(&program, &formula) else { return Ok(()) };
        let scope = if all { Scope::All } else { Scope::Reachable };
        let explicit = ExplicitEngine::new(product.clone(), settings(scope, thresholds()[0])).unwrap();
        for thresholds in thresholds() {
            let symbolic = SymbolicEngine::new(product.clone(), settings(scope, thresholds)).unwrap();
            for coalition in [[true, false], [false, true], [true, true], [false, false]] {
                let (one, other) =
                    (symbolic.with_coalition(&coalition).unwrap(), explicit.with_coalition(&coalition).unwrap());
                let expected = answers(&other, &product, &condition);
                prop_assert_eq!(answers(&one, &product, &condition), expected, "{} {:?}", formula, coalition);
            }
        }
    }
}

/// A random program with the labels "p" and "q".
fn labelled(of: &[u16], labels: &[Vec<u16>; 2], change: impl FnOnce(&mut Program)) -> Program {
    let mut program = random_program(of, false);
    change(&mut program);
    for (name, label) in ["p", "q"].into_iter().zip(labels) {
        let label = random_predicate(&mut program, label);
        program.labels.push((name.to_owned(), label));
    }
    program
}

pub(super) fn analysed<E: Engine>(
    engine: E,
    preferences: &Arc<Preferences>,
    safety: Safety,
) -> (Analysis<E>, AnalysisResult) {
    let options = Options { safety, ..Options::default() };
    let analysis = finished(&Arc::new(engine), preferences, options);
    let result = analysis.result().clone();
    (analysis, result)
}
