//! Temporal formulas on models with a single path: both engines against the definition of LTL on that path.

use Formula::{Binary, Label, Unary};
use meliora::advanced::lang::ltl::{Monitoring, parse_formula};
use meliora::model::temporal::{Begin, Condition};
use proptest::prelude::*;

use crate::common::prelude::*;

/// A formula over the labels "p" and "q"; X has one operand, which is the first.
#[derive(Debug, Clone)]
enum Formula {
    Label(&'static str),
    Unary(&'static str, Box<Formula>),
    Binary(&'static str, Box<Formula>, Box<Formula>),
}

impl Formula {
    fn text(&self) -> String {
        match self {
            Label(name @ ("true" | "false")) => (*name).to_owned(),
            Label(name) => format!("\"{name}\""),
            Unary(operator, a) => format!("({operator} {})", a.text()),
            Binary(operator, a, b) => format!("({} {operator} {})", a.text(), b.text()),
        }
    }
}

fn formula() -> impl Strategy<Value = Formula> {
    let leaf = prop::sample::select(vec!["p", "p", "p", "q", "q", "q", "true", "false"]);
    leaf.prop_map(Label).prop_recursive(5, 12, 2, |inner| {
        let one = || inner.clone().prop_map(Box::new);
        let unary = prop::sample::select(vec![
            "!", "X", "F", "G", "G F", "F G", "G", "F<=0", "F<=1", "F<2", "F=2", "G<=2", "G>=1", "F>0",
            "G[1,2]",
        ]);
        let binary = prop::sample::select(vec!["&", "|", "=>", "<=>", "U", "W", "R", "M", "U<=1", "U[1,2]"]);
        prop_oneof![
            3 => (unary, one()).prop_map(|(operator, a)| Unary(operator, a)),
            2 => (binary, one(), one()).prop_map(|(operator, a, b)| Binary(operator, a, b)),
        ]
    })
}

/// A path: for each step whether p and q hold, and where the loop starts.
#[derive(Debug, Clone)]
struct Lasso {
    letters: Vec<(bool, bool)>,
    back: usize,
    /// True if a last state that only leads to itself is a deadlock.
    stuck: bool,
}

impl Lasso {
    fn after(&self, at: usize) -> usize {
        if at + 1 < self.letters.len() { at + 1 } else { self.back }
    }

    /// The states in which a label holds, as an expression.
    fn label(&self, holds: impl Fn(&(bool, bool)) -> bool) -> String {
        let states = (0..self.letters.len()).filter(|&i| holds(&self.letters[i]));
        states.map(|i| format!(" | s={i}")).fold("false".to_owned(), |text, next| text + &next)
    }

    fn program(&self) -> Program {
        let last = self.letters.len();
        let stuck = self.stuck && self.back + 1 == last;
        let steps =
            (0..last - usize::from(stuck)).map(|i| format!("  [] s={i} -> (s'={});\n", self.after(i)));
        let text = format!(
            "mdp\nmodule m\n  s : [0..{last}] init 0;\n{}endmodule\nlabel \"p\" = {};\nlabel \"q\" = {};\n",
            steps.collect::<String>(),
            self.label(|letter| letter.0),
            self.label(|letter| letter.1)
        );
        parsed(text)
    }

    /// Returns for each step whether a formula holds from there on, by the definition of LTL.
    fn meaning(&self, f: &Formula) -> Vec<bool> {
        let n = self.letters.len();
        let each = |f: &dyn Fn(usize) -> bool| (0..n).map(f).collect::<Vec<bool>>();
        let not = |x: Vec<bool>| x.into_iter().map(|v| !v).collect::<Vec<bool>>();
        let always = vec![true; n];
        let (operator, a, b) = match f {
            Label("p") => return each(&|i| self.letters[i].0),
            Label("q") => return each(&|i| self.letters[i].1),
            Label(name) => return each(&|_| *name == "true"),
            Unary(operator, a) => (*operator, self.meaning(a), always.clone()),
            Binary(operator, a, b) => (*operator, self.meaning(a), self.meaning(b)),
        };
        let within = |a: &[bool], least: usize, most: usize| self.until(&always, a, Some((least, most)));
        match operator {
            "!" => not(a),
            "X" => each(&|i| a[self.after(i)]),
            "F" => self.until(&always, &a, None),
            "G" => not(self.until(&always, &not(a), None)),
            "G F" => not(self.until(&always, &not(self.until(&always, &a, None)), None)),
            "F G" => self.until(&always, &not(self.until(&always, &not(a), None)), None),
            "F<=0" => within(&a, 0, 0),
            "F<=1" | "F<2" => within(&a, 0, 1),
            "F=2" => within(&a, 2, 2),
            "F>0" => within(&a, 1, usize::MAX),
            "G>=1" => not(within(&not(a), 1, usize::MAX)),
            "G<=2" => not(within(&not(a), 0, 2)),
            "G[1,2]" => not(within(&not(a), 1, 2)),
            "&" => each(&|i| a[i] && b[i]),
            "|" => each(&|i| a[i] || b[i]),
            "=>" => each(&|i| !a[i] || b[i]),
            "<=>" => each(&|i| a[i] == b[i]),
            "U" => self.until(&a, &b, None),
            "U<=1" => self.until(&a, &b, Some((0, 1))),
            "U[1,2]" => self.until(&a, &b, Some((1, 2))),
            "R" => not(self.until(&not(a), &not(b), None)),
            // a M b is b U (a & b).
            "M" => self.until(&b, &each(&|i| a[i] && b[i]), None),
            // a W b is (a U b) or G a.
            "W" => {
                let (until, ever) = (self.until(&a, &b, None), not(self.until(&always, &not(a), None)));
                each(&|i| until[i] || ever[i])
            }
            other => panic!("{other} has no meaning here"),
        }
    }

    /// Computes a U b; `steps` bounds the number of steps to b from below and above.
    fn until(&self, a: &[bool], b: &[bool], steps: Option<(usize, usize)>) -> Vec<bool> {
        let (least, most) = steps.unwrap_or((0, usize::MAX));
        let holds = |start: usize| {
            let mut at = start;
            for step in 0..=most.min(least + 2 * a.len()) {
                if step >= least && b[at] {
                    return true;
                }
                if !a[at] {
                    return false;
                }
                at = self.after(at);
            }
            false
        };
        (0..a.len()).map(holds).collect()
    }
}

fn lasso() -> impl Strategy<Value = Lasso> {
    prop::collection::vec(any::<(bool, bool)>(), 1..6)
        .prop_flat_map(|letters| (Just(letters.clone()), 0..letters.len(), any::<bool>()))
        .prop_map(|(letters, back, stuck)| Lasso { letters, back, stuck })
}

/// Pmax = 1, Pmax > 0, Pmin = 1, Pmin > 0 of a property, each as the number of states of `start`.
fn counts<E: Engine>(engine: &E, condition: &Condition, start: &E::States) -> [String; 4] {
    let found = RegionSearch::of_condition(engine, condition).all().unwrap();
    [&found.pmax_one, &found.pmax_positive, &found.pmin_one, &found.pmin_positive]
        .map(|x| engine.count(&engine.intersection(x, start).unwrap()).unwrap().to_string())
}

/// Returns the verdicts in the initial state, or in all states: those in which monitors, if there are any,
/// are fresh.
fn judged<E: Engine>(
    engine: &E,
    condition: &Condition,
    fresh: Option<&Predicate>,
    initial: bool,
) -> [String; 4] {
    let start = match fresh {
        _ if initial => engine.initial_states(),
        Some(fresh) => engine.states_where(fresh).unwrap(),
        None => engine.all_states(),
    };
    counts(engine, condition, &start)
}

/// The condition of a formula; none where the formula exceeds a limit.
pub(crate) fn watched(
    watching: &mut Monitoring<'_>,
    source: &Arc<SourceFile>,
    formula: &meliora::advanced::lang::ltl::Formula,
) -> Option<Condition<ExprId>> {
    match watching.watch(source, formula, "w") {
        Ok(condition) => Some(condition),
        Err(error) => {
            let text = error.to_string();
            let is_limit = matches!(error, Error::Limit(_)) || text.contains("cases over its");
            assert!(is_limit, "{}: {text}", source.text);
            None
        }
    }
}

/// The answers of both engines: in the initial state, or in all states. None where the formula exceeds a limit.
fn answers(program: Program, formula: &str, initial: bool) -> Option<[[String; 4]; 2]> {
    let source = SourceFile::new("formula", formula);
    let mut watching = Monitoring::new(&program);
    let condition = watched(&mut watching, &source, &parse_formula(&source).unwrap())?;
    let program = watching.finish(Begin::Everywhere).unwrap();
    let condition = condition.map(&|mark| program.predicate(mark));
    let fresh = program.monitors.as_ref().map(|monitors| program.predicate(monitors.fresh));
    let (symbolic, explicit) = engines(program);
    let fresh = fresh.as_ref();
    Some([judged(&*symbolic, &condition, fresh, initial), judged(&*explicit, &condition, fresh, initial)])
}

fn engines(program: Program) -> (Arc<SymbolicEngine>, Arc<ExplicitEngine>) {
    let program = Arc::new(program);
    let settings = Settings { memory: 16 << 20, ..Settings::default() };
    let symbolic = SymbolicEngine::new(Arc::clone(&program), settings.clone()).unwrap();
    (Arc::new(symbolic), Arc::new(ExplicitEngine::new(program, settings).unwrap()))
}

/// Returns for both engines whether an objective over whole paths is among the most preferred ones at the
/// start.
fn achievable(program: Program, formula: &str) -> [bool; 2] {
    let text = format!("objective A = X ({formula}); history = play;\n");
    let lang::Task { program, preferences } =
        lang::load_preferences(&SourceFile::new("p", text.as_str()), program).unwrap();
    let preferences = Arc::new(preferences);
    let (symbolic, explicit) = engines(program.clone());
    [at_start(&symbolic, &program, &preferences), at_start(&explicit, &program, &preferences)]
}

fn at_start<E: Engine>(engine: &Arc<E>, program: &Program, preferences: &Arc<Preferences>) -> bool {
    let analysis = finished(engine, preferences, Options { safety: Safety::Action, max_level: None });
    !analysis.initial_prospects(program, 1).unwrap()[0].most_preferred.is_empty()
}

proptest! {
    #![proptest_config(crate::common::amount::random(600))]

    #[test]
    fn formulas_hold_where_the_definition_says(f in formula(), path in lasso()) {
        let expected = usize::from(path.meaning(&f)[0]).to_string();
        let Some(found) = answers(path.program(), &f.text(), true) else { return Ok(()) };
        for answer in found.iter().flatten() {
            prop_assert_eq!(answer, &expected, "{}", f.text());
        }
        let next = path.meaning(&f)[path.after(0)];
        let found = achievable(path.program(), &f.text());
        prop_assert_eq!(found, [next, next], "history = play: {}", f.text());
    }
}

/// Obligations that are fulfilled in the step in which the next one comes up.
#[test]
fn what_is_owed_may_be_fulfilled_as_new_obligations_come_up() {
    let text = "mdp\nmodule m\n  s : [0..1] init 0;\n  [] true -> (s'=0);\n  [] true -> (s'=1);\nendmodule\n\
        label \"p\" = s=1;\n";
    let program = load(text);
    for (formula, expected) in [
        ("G ((X p) => (F p))", ["2", "2", "2", "2"]),
        ("G ((F p) | (X !p))", ["2", "2", "2", "2"]),
        ("G (X ((F p) | (F !p)))", ["2", "2", "2", "2"]),
        ("G ((X F p) | (X X F !p))", ["2", "2", "2", "2"]),
        ("G ((F p) | (X X !p))", ["2", "2", "2", "2"]),
        ("X (F ((G !p) & (X p)))", ["0", "0", "0", "0"]),
        ("F (G ((!p) & (X p)))", ["0", "0", "0", "0"]),
        ("(G F p) & (G ((X p) => (F p)))", ["2", "2", "0", "0"]),
        ("(F ((G>=1 !p) & (X p))) | !(F !p)", ["1", "1", "0", "0"]),
        ("(X F ((G !p) & (!p | (p R p)))) | (X p)", ["2", "2", "0", "0"]),
    ] {
        let formula = formula.replace('p', "\"p\"");
        let found = answers(program.clone(), &formula, false).unwrap();
        assert_eq!(found, [expected, expected].map(|row| row.map(String::from)), "{formula}");
    }
}

fn load(model: &str) -> Program {
    parsed(model)
}

/// One of two recurrences loses states while the other one is unchanged in its first round.
#[test]
fn each_recurrence_is_asked_for_again_when_another_one_loses_states() {
    let model = "mdp module m s:[0..2] init 0; [a] s=0 -> 0.5:(s'=1) + 0.5:(s'=2); [b] s=0 -> true;
        [] s=1 -> (s'=0); [] s=2 -> true; endmodule";
    for (formula, expected) in
        [("(G F s!=1) & (G F (s>0 & s<2))", ["0", "0", "0", "0"]), ("G F s!=1", ["3", "3", "3", "3"])]
    {
        let found = answers(load(model), formula, false).unwrap();
        assert_eq!(found, [expected, expected].map(|row| row.map(String::from)), "{formula}");
    }
}

#[test]
fn brackets_of_arithmetic_stand_beside_temporal_formulas() {
    let model = "mdp module m s:[0..3] init 0; [] s<3 -> (s'=s+1); endmodule";
    for formula in [
        "((s+1)*2=2) & (F s=3)",
        "(s+1)*2=2 & (F s=3)",
        "(F s=3) & (s+1)*2=2",
        "((s+1)*2=2 & (F s=3))",
        "(2*(s+1)=2) & (X ((s+1)*(1+1)=4))",
    ] {
        let found = answers(load(model), formula, false).unwrap();
        assert_eq!(found, [["1"; 4], ["1"; 4]].map(|row| row.map(String::from)), "{formula}");
    }
}

/// An objective may have the name of a variable: its monitor gets another one.
#[test]
fn an_objective_may_be_called_as_a_variable_is() {
    let program = load("mdp module m s:[0..1] init 0; [] true -> (s'=1-s); endmodule");
    let text = SourceFile::new("p", "objective s = G (s=0 => X s=1);");
    let lang::Task { program, preferences } = lang::load_preferences(&text, program).unwrap();
    let preferences = Arc::new(preferences);
    let names: std::collections::BTreeSet<&String> = program.variables.iter().map(|v| &v.name).collect();
    assert_eq!(names.len(), program.variables.len(), "{names:?}");
    let (symbolic, explicit) = engines(program.clone());
    assert!(at_start(&symbolic, &program, &preferences) && at_start(&explicit, &program, &preferences));
}

#[test]
fn bounds_and_constants_have_their_meaning() {
    let model = "mdp module m s:[0..3] init 0; [] s<3 -> (s'=s+1); endmodule";
    for (formula, states) in [
        ("F<=0 s=0", "1"),
        ("G<=0 s=0", "1"),
        ("(s<2) U[2,5] true", "1"),
        ("!((s<2) U[2,5] true)", "3"),
        ("((F s=3) & (G s>0)) | false", "3"),
        ("((F s=0) | (G s>1)) & true", "3"),
        ("!(((F s=3) & (G s>0)) | false)", "1"),
    ] {
        let found = answers(load(model), formula, false).unwrap();
        assert_eq!(found, [[states; 4], [states; 4]].map(|row| row.map(String::from)), "{formula}");
    }
}
