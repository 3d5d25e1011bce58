//! Values of random arenas against all pure strategies, with fractions.

use std::sync::Arc;

use bitvec::vec::BitVec;
use meliora_amount::share;
use meliora_base::error::SourceFile;
use meliora_base::exact::Ratio;
use meliora_base::random::Draw;
use meliora_engine::{AnyEngine, Settings, Storage};
use meliora_model::{Optimum, Program};
use num_traits::{One, ToPrimitive, Zero};

use crate::vector::{Accumulation, Asked, Until};
use crate::{Answer, Arena, Extremes, Value};

/// A choice: its reward besides the reward of its state, and its successors with weights.
pub(super) type Choice = (i64, Vec<(usize, i64)>);

/// A random game.
#[derive(Debug)]
pub(super) struct Made {
    pub(super) choices: Vec<Vec<Choice>>,
    pub(super) theirs: Vec<bool>,
    pub(super) of_state: Vec<i64>,
}

/// A strategy: the choice of each state.
pub(super) type Pure = Vec<usize>;

impl Made {
    pub(super) fn draw(draw: &mut Draw, kind: &str) -> Self {
        let n = 2 + draw.below(4);
        let choices = |draw: &mut Draw| {
            let count = if kind == "dtmc" { 1 } else { 1 + draw.below(3) };
            let choice = |draw: &mut Draw| {
                let mut edges: Vec<(usize, i64)> = Vec::new();
                for _ in 0..1 + draw.below(3) {
                    let to = draw.below(n);
                    if edges.iter().all(|edge| edge.0 != to) {
                        edges.push((to, 1 + draw.below(3) as i64));
                    }
                }
                ([0, 0, 1, 3][draw.below(4)], edges)
            };
            (0..count).map(|_| choice(draw)).collect()
        };
        Made {
            choices: (0..n).map(|_| choices(draw)).collect(),
            theirs: (0..n).map(|_| kind == "smg" && draw.below(2) == 0).collect(),
            of_state: (0..n).map(|_| [0, 0, 1][draw.below(3)]).collect(),
        }
    }

    /// Returns the same choices, which earn nothing.
    fn without_gains(&self) -> Self {
        let choices = self.choices.iter().map(|own| own.iter().map(|choice| (0, choice.1.clone())).collect());
        Made { choices: choices.collect(), theirs: self.theirs.clone(), of_state: vec![0; self.states()] }
    }

    pub(super) fn states(&self) -> usize {
        self.choices.len()
    }

    /// Returns the model as text; the number of a choice of a state is that of its label.
    pub(super) fn text(&self, kind: &str) -> String {
        let (mut text, mut rewards) = (format!("{kind}\n"), "rewards \"r\"\n".to_owned());
        if kind == "smg" {
            text += "player p m, [a0], [a1], [a2] endplayer player q [b0], [b1], [b2] endplayer\n";
        }
        text += &format!("module m s:[0..{}];\n", self.states() - 1);
        for (s, choices) in self.choices.iter().enumerate() {
            rewards += &format!("s={s}: {};\n", self.of_state[s]);
            for (at, (gain, edges)) in choices.iter().enumerate() {
                let label = format!("{}{at}", if self.theirs[s] { "b" } else { "a" });
                let sum: i64 = edges.iter().map(|edge| edge.1).sum();
                let edges: Vec<String> =
                    edges.iter().map(|(to, weight)| format!("{weight}/{sum}:(s'={to})")).collect();
                text += &format!("[{label}] s={s} -> {};\n", edges.join(" + "));
                rewards += &format!("[{label}] s={s}: {gain};\n");
            }
        }
        if kind == "smg" {
            (0..3).for_each(|at| text += &format!("[a{at}] false -> true; [b{at}] false -> true;\n"));
        }
        text += "endmodule\n";
        text + &rewards + "endrewards\ninit true endinit\n"
    }

    /// Returns all pure strategies of a side; states of the other side take their first choice.
    pub(super) fn strategies(&self, of: impl Fn(usize) -> bool) -> Vec<Pure> {
        let mut all = vec![vec![]];
        for s in 0..self.states() {
            let count = if of(s) { self.choices[s].len() } else { 1 };
            all = all
                .into_iter()
                .flat_map(|pure: Pure| (0..count).map(move |at| [&pure[..], &[at]].concat()))
                .collect();
        }
        all
    }

    /// Returns the value over all pairs of strategies; `of_chain` returns that of a chain, `None` if it is infinite.
    fn value(&self, goal: Extremes, of_chain: &dyn Fn(&Pure) -> Vec<Option<Ratio>>) -> Vec<Option<Ratio>> {
        let greatest = |s: usize| if self.theirs[s] { goal.theirs } else { goal.ours } == Optimum::Max;
        let better = |a: &Option<Ratio>, b: &Option<Ratio>| match (a, b) {
            (Some(a), Some(b)) => a < b,
            (Some(_), None) => true,
            (None, _) => false,
        };
        let join = |a: Vec<Option<Ratio>>, b: Vec<Option<Ratio>>, max: bool| {
            a.into_iter().zip(b).map(|(a, b)| if better(&a, &b) == max { b } else { a }).collect()
        };
        let (max, min) = (self.strategies(greatest), self.strategies(|s| !greatest(s)));
        let both = |a: &Pure, b: &Pure| {
            (0..self.states()).map(|s| if greatest(s) { a[s] } else { b[s] }).collect::<Pure>()
        };
        let least = |a: &Pure| {
            let chains = min.iter().map(|b| of_chain(&both(a, b)));
            chains.reduce(|x, y| join(x, y, false)).unwrap()
        };
        max.iter().map(least).reduce(|x, y| join(x, y, true)).unwrap()
    }

    /// Returns the averages over the long run.
    fn averages(&self, goal: Extremes) -> Vec<Option<Ratio>> {
        self.value(goal, &|pure| self.average(pure).into_iter().map(Some).collect())
    }

    fn row(&self, s: usize, pure: &Pure) -> Vec<Ratio> {
        let mut row = vec![Ratio::zero(); self.states()];
        let edges = &self.choices[s][pure[s]].1;
        let sum: i64 = edges.iter().map(|edge| edge.1).sum();
        edges.iter().for_each(|&(to, weight)| row[to] += Ratio::new(weight.into(), sum.into()));
        row
    }

    fn gain(&self, s: usize, pure: &Pure) -> Ratio {
        Ratio::from_integer((self.of_state[s] + self.choices[s][pure[s]].0).into())
    }

    /// Returns the states from which some path of a chain reaches a set through others.
    fn reaching(&self, pure: &Pure, target: &[bool], left: &[bool]) -> Vec<bool> {
        let mut found = target.to_vec();
        for _ in 0..self.states() {
            for s in (0..self.states()).filter(|&s| left[s]) {
                found[s] |= self.choices[s][pure[s]].1.iter().any(|edge| found[edge.0]);
            }
        }
        found
    }

    /// Returns the solution x = gain + P x on the states inside, where x is given elsewhere.
    fn solve(&self, pure: &Pure, inside: &[bool], given: &[Ratio], gain: bool) -> Vec<Ratio> {
        let n = self.states();
        let mut rows: Vec<Vec<Ratio>> = Vec::new();
        for s in 0..n {
            let mut row = vec![Ratio::zero(); n + 1];
            row[s] = Ratio::one();
            if inside[s] {
                self.row(s, pure).into_iter().enumerate().for_each(|(to, p)| row[to] -= p);
                row[n] = if gain { self.gain(s, pure) } else { Ratio::zero() };
            } else {
                row[n] = given[s].clone();
            }
            rows.push(row);
        }
        eliminated(rows)
    }

    pub(super) fn until(&self, pure: &Pure, target: &[bool], left: &[bool]) -> Vec<Option<Ratio>> {
        let positive = self.reaching(pure, target, left);
        let inside: Vec<bool> = (0..self.states()).map(|s| positive[s] && !target[s]).collect();
        let given: Vec<Ratio> =
            target.iter().map(|&inside| if inside { Ratio::one() } else { Ratio::zero() }).collect();
        self.solve(pure, &inside, &given, false).into_iter().map(Some).collect()
    }

    pub(super) fn reward_until(&self, pure: &Pure, target: &[bool]) -> Vec<Option<Ratio>> {
        let every = vec![true; self.states()];
        let reach = self.until(pure, target, &every);
        let sure: Vec<bool> = reach.iter().map(|p| *p == Some(Ratio::one())).collect();
        let inside: Vec<bool> = (0..self.states()).map(|s| sure[s] && !target[s]).collect();
        let found = self.solve(pure, &inside, &vec![Ratio::zero(); self.states()], true);
        found.into_iter().zip(sure).map(|(x, sure)| sure.then_some(x)).collect()
    }

    /// Returns whether each state is in a component that a chain never leaves.
    fn recurrent(&self, pure: &Pure) -> Vec<bool> {
        let (n, every) = (self.states(), vec![true; self.states()]);
        let to = |t: usize| {
            let only: Vec<bool> = (0..n).map(|s| s == t).collect();
            self.reaching(pure, &only, &every)
        };
        let reach: Vec<Vec<bool>> = (0..n).map(to).collect();
        (0..n).map(|s| (0..n).all(|t| !reach[t][s] || reach[s][t])).collect()
    }

    /// Returns the states in components that a chain never leaves and that have a state in a set.
    pub(super) fn recurring(&self, pure: &Pure, set: &dyn Fn(usize) -> bool) -> Vec<bool> {
        let (n, every) = (self.states(), vec![true; self.states()]);
        let recurrent = self.recurrent(pure);
        let inside: Vec<bool> = (0..n).map(|s| recurrent[s] && set(s)).collect();
        let reaching = self.reaching(pure, &inside, &every);
        (0..n).map(|s| recurrent[s] && reaching[s]).collect()
    }

    pub(super) fn total(&self, pure: &Pure) -> Vec<Option<Ratio>> {
        self.total_until(pure, &vec![false; self.states()])
    }

    /// Returns the rewards until some states, and those of all steps where these are not reached.
    fn total_until(&self, pure: &Pure, target: &[bool]) -> Vec<Option<Ratio>> {
        let (n, left) = (self.states(), target.iter().map(|inside| !inside).collect::<Vec<_>>());
        let (recurrent, ending) =
            (self.recurrent(pure), self.reaching(pure, target, &vec![true; self.states()]));
        let stays = |s: usize| recurrent[s] && !ending[s];
        let recurring: Vec<bool> = (0..n).map(|s| stays(s) && !self.gain(s, pure).is_zero()).collect();
        let infinite = self.reaching(pure, &recurring, &left);
        let inside: Vec<bool> = (0..n).map(|s| !infinite[s] && left[s] && !stays(s)).collect();
        let found = self.solve(pure, &inside, &vec![Ratio::zero(); n], true);
        found.into_iter().zip(infinite).map(|(x, infinite)| (!infinite).then_some(x)).collect()
    }

    /// Returns the averages over the long run: g with g = P g, and g + h = gain + P h for some h.
    fn average(&self, pure: &Pure) -> Vec<Ratio> {
        let (n, recurrent) = (self.states(), self.recurrent(pure));
        let every = vec![true; n];
        let mut found = vec![Ratio::zero(); n];
        for s in (0..n).filter(|&s| recurrent[s]) {
            // The stationary probabilities of the component of s.
            let only: Vec<bool> = (0..n).map(|t| t == s).collect();
            let back = self.reaching(pure, &only, &every);
            let own = |t: usize| recurrent[t] && back[t];
            let mut rows: Vec<Vec<Ratio>> = Vec::new();
            for t in 0..n {
                let mut row = vec![Ratio::zero(); n + 1];
                row[t] = Ratio::one();
                if t == s {
                    (0..n).filter(|&t| own(t)).for_each(|t| row[t] = Ratio::one());
                    row[n] = Ratio::one();
                } else if own(t) {
                    (0..n).filter(|&from| own(from)).for_each(|from| row[from] -= &self.row(from, pure)[t]);
                }
                rows.push(row);
            }
            let stationary = eliminated(rows);
            found[s] = (0..n).map(|t| &stationary[t] * self.gain(t, pure)).sum();
        }
        let inside: Vec<bool> = recurrent.iter().map(|recurrent| !recurrent).collect();
        self.solve(pure, &inside, &found, false)
    }

    /// Returns the optimum after some steps, state by state and step by step.
    fn after(
        &self,
        goal: Extremes,
        state: usize,
        steps: u64,
        value: &dyn Fn(usize, u64) -> Option<Ratio>,
        gains: bool,
    ) -> Ratio {
        if let Some(value) = value(state, steps) {
            return value;
        }
        let of = |(gain, edges): &Choice| {
            let sum: i64 = edges.iter().map(|edge| edge.1).sum();
            let first = if gains { self.of_state[state] + gain } else { 0 };
            edges.iter().fold(Ratio::from_integer(first.into()), |x, &(to, weight)| {
                x + Ratio::new(weight.into(), sum.into()) * self.after(goal, to, steps - 1, value, gains)
            })
        };
        let greatest = if self.theirs[state] { goal.theirs } else { goal.ours } == Optimum::Max;
        let all = self.choices[state].iter().map(of);
        if greatest { all.max() } else { all.min() }.unwrap()
    }
}

/// Solves linear equations.
fn eliminated(mut rows: Vec<Vec<Ratio>>) -> Vec<Ratio> {
    let n = rows.len();
    for at in 0..n {
        let pivot = (at..n).find(|&row| !rows[row][at].is_zero()).expect("one solution");
        rows.swap(at, pivot);
        let divisor = rows[at][at].clone();
        rows[at].iter_mut().for_each(|x| *x /= &divisor);
        let row = rows[at].clone();
        for other in (0..n).filter(|&other| other != at) {
            let factor = rows[other][at].clone();
            rows[other].iter_mut().zip(&row).for_each(|(x, y)| *x -= &factor * y);
        }
    }
    rows.into_iter().map(|row| row[n].clone()).collect()
}

pub(super) fn load(text: &str) -> Program {
    let read = |name, text: &str| SourceFile::new(name, text);
    meliora_lang::load(&read("model", text), &read("constants", ""))
        .unwrap_or_else(|e| panic!("{e:?} {text}"))
        .program
}

fn check(what: &str, found: &Answer, expected: &[Option<Ratio>], is_exact: bool) {
    assert!(found.end.is_ok(), "{what}: {:?}", found.end);
    assert_eq!(found.values.len(), expected.len());
    for (state, (value, expected)) in found.values.iter().zip(expected).enumerate() {
        match (value, expected) {
            (Value::Infinite, None) => {}
            (Value::Finite(bounds), Some(expected)) if is_exact => {
                assert_eq!(bounds.exact.as_ref(), Some(expected), "{what}, state {state}");
            }
            (Value::Finite(bounds), Some(expected)) => {
                let near = expected.to_f64().unwrap();
                let (lower, upper) = (bounds.interval.lower, bounds.interval.upper);
                let contains = Ratio::from_float(lower).unwrap() <= *expected
                    && Ratio::from_float(upper).unwrap() >= *expected;
                assert!(
                    contains && upper - lower <= 1e-6 * near.max(1.0),
                    "{what}, state {state}: {near} {bounds:?}"
                );
            }
            other => panic!("{what}, state {state}: {other:?}"),
        }
    }
}

/// Asks an arena, given its members of sets of states.
type Ask<'a> = dyn Fn(&Arena<'_>, &dyn Fn(&BitVec) -> BitVec) -> Answer + 'a;

/// A question to an arena.
struct ArenaQuestion<'a> {
    made: &'a Made,
    arena: &'a Arena<'a>,
    engine: &'a AnyEngine,
    goal: Extremes,
    precision: f64,
    what: String,
}

impl ArenaQuestion<'_> {
    fn check(&self, name: &str, found: &Answer, expected: &[Option<Ratio>]) {
        check(&format!("{} {:?} {name}", self.what, self.goal), found, expected, self.precision == 0.0);
    }

    /// Checks the value of each state in the arena of the states that it reaches before some others.
    fn alone(&self, name: &str, stops: &BitVec, expected: &[Option<Ratio>], ask: &Ask<'_>) {
        let set = |members: &BitVec| self.arena.set(self.engine, members).unwrap();
        for state in 0..self.made.states() {
            let (start, program) = ([self.arena.state(state)], self.arena.program);
            let (own, numbers) = Arena::reached(self.engine, program, &start, &set(stops)).unwrap();
            let found = ask(&own, &|members| own.members(self.engine, &set(members)).unwrap());
            self.check(name, &found.selected(&numbers), &expected[state..=state]);
        }
    }

    /// Returns the optimum after some steps in all states; see [`Made::after`].
    fn after(
        &self,
        steps: u64,
        value: &dyn Fn(usize, u64) -> Option<Ratio>,
        gains: bool,
    ) -> Vec<Option<Ratio>> {
        let of = |s| Some(self.made.after(self.goal, s, steps, value, gains));
        (0..self.made.states()).map(of).collect()
    }

    fn probabilities(&self, target: &[bool], left: &[bool]) {
        let ArenaQuestion { made, arena, goal, precision, .. } = self;
        let until = |least, most| Until { left: bits(left), right: bits(target), least, most };
        let expected = made.value(*goal, &|pure| made.until(pure, target, left));
        let asked = Asked::all(arena, *goal, *precision);
        self.check("until", &asked.probability(&until(0, None)).unwrap(), &expected);
        self.alone("until", &(bits(target) | !bits(left)), &expected, &|own, members| {
            let until = Until::unbounded(members(&bits(left)), members(&bits(target)));
            Asked::all(own, *goal, *precision).probability(&until).unwrap()
        });
        for (least, most) in [(0, 3), (2, 3), (0, 0), (1, 1)] {
            let value =
                |s: usize, to_go: u64| match (most - to_go >= least && target[s], left[s] && to_go > 0) {
                    (true, _) => Some(Ratio::one()),
                    (_, false) => Some(Ratio::zero()),
                    _ => None,
                };
            let found = asked.probability(&until(least, Some(most))).unwrap();
            self.check(&format!("[{least},{most}]"), &found, &self.after(most, &value, false));
        }
        let found = asked.next(&bits(target)).unwrap();
        let inside =
            |s: usize, to_go: u64| (to_go == 0).then(|| if target[s] { Ratio::one() } else { Ratio::zero() });
        self.check("next", &found, &self.after(1, &inside, false));
    }

    fn rewards(&self, target: &[bool]) {
        let ArenaQuestion { made, arena, goal, precision, .. } = self;
        let rewards = arena.rewards(self.engine, 0).unwrap();
        let asked = Asked::all(arena, *goal, *precision);
        let ask = |accumulation| asked.reward(&rewards, &accumulation).unwrap();
        let expected = made.value(*goal, &|pure| made.reward_until(pure, target));
        self.check("F", &ask(Accumulation::Until(bits(target))), &expected);
        self.alone("F", &bits(target), &expected, &|own, members| {
            let until = Accumulation::Until(members(&bits(target)));
            Asked::all(own, *goal, *precision).reward(&own.rewards(self.engine, 0).unwrap(), &until).unwrap()
        });
        let nothing = |_: usize, to_go: u64| (to_go == 0).then(Ratio::zero);
        self.check("C<=3", &ask(Accumulation::Within(3)), &self.after(3, &nothing, true));
        let last = |s: usize, to_go: u64| (to_go == 0).then(|| Ratio::from_integer(made.of_state[s].into()));
        self.check("I=2", &ask(Accumulation::At(2)), &self.after(2, &last, false));
        self.check("C", &ask(Accumulation::Total), &made.value(*goal, &|pure| made.total(pure)));
        let expected = made.value(*goal, &|pure| made.total_until(pure, target));
        self.check("Fc", &ask(Accumulation::Anyway(bits(target))), &expected);
        let differs = |s: usize| made.theirs[s] && made.choices[s].len() > 1;
        if goal.ours != goal.theirs && (0..made.states()).any(differs) {
            let refused = asked.reward(&rewards, &Accumulation::LongRun);
            assert!(refused.is_err_and(|error| error.to_string().contains("against an opponent")));
        } else {
            self.check("S", &ask(Accumulation::LongRun), &made.averages(*goal));
        }
    }
}

fn bits(set: &[bool]) -> BitVec {
    set.iter().copied().collect()
}

fn asked(
    made: &Made,
    (arena, engine): (&Arena<'_>, &AnyEngine),
    draw: &mut Draw,
    (precision, what): (f64, &str),
) {
    let target: Vec<bool> = (0..made.states()).map(|_| draw.below(3) == 0).collect();
    let left: Vec<bool> = (0..made.states()).map(|_| draw.below(5) > 0).collect();
    let optimum = [Optimum::Max, Optimum::Min];
    for goal in optimum.into_iter().flat_map(|ours| [Extremes::against(ours), Extremes::all(ours)]) {
        let what = format!("{what} {target:?} {left:?}");
        let asked = ArenaQuestion { made, arena, engine, goal, precision, what };
        asked.probabilities(&target, &left);
        asked.rewards(&target);
    }
    for goal in optimum.map(Extremes::all) {
        let only =
            Made { of_state: target.iter().map(|&inside| inside.into()).collect(), ..made.without_gains() };
        let found = Asked::all(arena, goal, precision).long_run(&bits(&target)).unwrap();
        check(&format!("{what} {goal:?} S"), &found, &only.averages(goal), precision == 0.0);
    }
}

/// The position of a choice, and its successors with their probabilities.
type Listed = (usize, Vec<(u32, Ratio)>);

/// Returns the choices of each state.
fn steps(arena: &Arena<'_>) -> Vec<Vec<Listed>> {
    let outcomes = |choice: usize| {
        let exact = |(to, p): (u32, u32)| (to, arena.fractions()[p as usize].clone());
        (arena.position(choice), arena.outcomes(choice).map(exact).collect())
    };
    (0..arena.states()).map(|state| arena.choices.of(state as u32).map(outcomes).collect()).collect()
}

fn agree(kind: &str, seeds: usize) {
    for seed in 0..share(seeds) as u64 {
        let draw = &mut Draw::new(seed);
        let made = Made::draw(draw, kind);
        let (program, mut listed) = (load(&made.text(kind)), Vec::new());
        let explicit = Storage::Explicit;
        for (storage, keeps, precision) in
            [(explicit, true, 1e-6), (explicit, false, 1e-6), (Storage::Symbolic, false, 0.0)]
        {
            let settings =
                Settings { storage, keeps_choices: keeps, keeps_probabilities: keeps, ..Settings::default() };
            let engine = AnyEngine::new(Arc::new(program.clone()), settings).unwrap();
            let arena = Arena::new(&engine, &program).unwrap();
            assert_eq!(arena.states(), made.states());
            let half: BitVec = (0..made.states()).map(|s| s % 2 == 0).collect();
            let set = arena.set(&engine, &half).unwrap();
            assert_eq!(arena.members(&engine, &set).unwrap(), half);
            listed.push(steps(&arena));
            let what = format!("seed {seed}, {kind}, {storage:?}\n{}", made.text(kind));
            assert_eq!(listed.first(), listed.last(), "{what}");
            if keeps || precision == 0.0 {
                asked(&made, (&arena, &engine), draw, (precision, &what));
            }
        }
    }
}

#[test]
fn values_of_games_are_those_over_all_pure_strategies() {
    agree("smg", 30);
}

#[test]
fn values_of_mdps_are_those_over_all_pure_strategies() {
    agree("mdp", 30);
}

#[test]
fn values_of_chains_are_those_of_linear_equations() {
    agree("dtmc", 30);
}
