//! Small tasks that are drawn from bytes, as text and as definitions that are followed literally.

use std::collections::{BTreeMap, BTreeSet};

use meliora_base::exact::Ratio;

use super::drawn_conditions::{Closed, Cond, Fixed, names, object};

/// An atom: the name of its predicate and its objects.
pub(super) type Atom = (&'static str, Vec<usize>);
/// A state: the atoms that hold.
pub(super) type State = BTreeSet<Atom>;
/// An outcome: conditions, and the literals that they guard.
type Outcome = BTreeSet<(BTreeSet<Closed>, bool, Atom)>;

pub(super) const OBJECTS: [&str; 3] = ["a", "b", "c"];
/// The types, each with its objects; the last two are written `object` and `(either s t)`.
pub(super) const TYPES: [(&str, &[usize]); 4] =
    [("s", &[0, 1]), ("t", &[2]), ("object", &[0, 1, 2]), ("(either s t)", &[0, 1, 2])];
/// Predicates that change, with their arities; `fixed` does not change, `linked` is derived.
const CHANGED: [(&str, usize); 4] = [("p", 0), ("q", 1), ("at", 2), ("r", 1)];
const FIXED: (&str, usize) = ("fixed", 1);
const DERIVED: (&str, usize) = ("linked", 1);

/// Bytes that decide all choices; zeros after the last one.
pub(super) struct Tape<'b>(pub(super) std::slice::Iter<'b, u8>);

impl Tape<'_> {
    fn below(&mut self, n: usize) -> usize {
        self.0.next().map_or(0, |&byte| byte as usize) % n
    }

    fn many<T>(&mut self, most: usize, mut one: impl FnMut(&mut Self) -> T) -> Vec<T> {
        let count = self.below(most + 1);
        (0..count).map(|_| one(self)).collect()
    }
}

#[derive(Debug, Clone)]
enum Eff {
    And(Vec<Eff>),
    Atom(&'static str, Vec<usize>, bool),
    When(Cond, Box<Eff>),
    All(usize, Box<Eff>),
    OneOf(Vec<Eff>),
    Probably(Vec<(u32, Eff)>),
    Earn(u32),
}

#[derive(Debug, Clone)]
struct Action {
    parameters: Vec<usize>,
    condition: Cond,
    effect: Eff,
}

#[derive(Debug, Clone)]
pub(super) struct Drawn {
    actions: Vec<Action>,
    rule: Cond,
    initial: State,
    goal: Cond,
    /// A condition of a preference.
    wish: Cond,
}

fn condition(tape: &mut Tape<'_>, depth: usize, with_derived: bool) -> Cond {
    let kinds = if depth == 0 { 3 } else { 9 };
    let inner = |tape: &mut Tape<'_>| Box::new(condition(tape, depth - 1, with_derived));
    match tape.below(kinds) {
        0 | 1 => {
            let all = [CHANGED[0], CHANGED[1], CHANGED[2], CHANGED[3], FIXED, DERIVED];
            let (name, arity) = all[tape.below(all.len() - usize::from(!with_derived))];
            Cond::Atom(name, (0..arity).map(|_| tape.below(12)).collect())
        }
        2 => Cond::Equal(tape.below(12), tape.below(12)),
        3 => Cond::Not(inner(tape)),
        4 => Cond::And(tape.many(3, |tape| *inner(tape))),
        5 => Cond::Or(tape.many(2, |tape| *inner(tape))),
        6 => Cond::Imply(inner(tape), inner(tape)),
        7 => Cond::All(tape.below(TYPES.len()), inner(tape)),
        _ => Cond::Some(tape.below(TYPES.len()), inner(tape)),
    }
}

fn literal(tape: &mut Tape<'_>) -> Eff {
    let (name, arity) = CHANGED[tape.below(CHANGED.len())];
    let arguments = (0..arity).map(|_| tape.below(12)).collect();
    Eff::Atom(name, arguments, tape.below(2) == 0)
}

fn effect(tape: &mut Tape<'_>, depth: usize, has_numbers: bool) -> Eff {
    let inner = |tape: &mut Tape<'_>| effect(tape, depth - 1, has_numbers);
    match tape.below(if depth == 0 { 1 } else { 6 + usize::from(has_numbers) }) {
        0 | 1 => literal(tape),
        2 => Eff::And(tape.many(3, inner)),
        3 => Eff::When(condition(tape, depth.min(2), true), Box::new(inner(tape))),
        4 => Eff::All(tape.below(TYPES.len()), Box::new(inner(tape))),
        6 => Eff::Earn(tape.below(4) as u32),
        _ if has_numbers => Eff::Probably(tape.many(2, |tape| (1 + tape.below(5) as u32, inner(tape)))),
        _ => {
            let mut parts = tape.many(2, inner);
            parts.push(Eff::And(Vec::new()));
            Eff::OneOf(parts)
        }
    }
}

impl Drawn {
    pub(super) fn new(tape: &mut Tape<'_>) -> Self {
        let action = |tape: &mut Tape<'_>| Action {
            parameters: tape.many(2, |tape| tape.below(TYPES.len())),
            condition: Cond::And(tape.many(3, |tape| condition(tape, 1, true))),
            effect: {
                let has_numbers = tape.below(3) == 0;
                Eff::And(vec![effect(tape, 3, has_numbers), effect(tape, 2, has_numbers)])
            },
        };
        let actions = (0..1 + tape.below(3)).map(|_| action(tape)).collect();
        let fact = |tape: &mut Tape<'_>| {
            let all = [CHANGED[0], CHANGED[1], CHANGED[2], CHANGED[3], FIXED];
            let (name, arity) = all[tape.below(all.len())];
            (name, (0..arity).map(|_| tape.below(OBJECTS.len())).collect())
        };
        Drawn {
            actions,
            rule: condition(tape, 1, false),
            initial: tape.many(5, fact).into_iter().collect(),
            goal: condition(tape, 2, true),
            wish: condition(tape, 1, true),
        }
    }

    pub(super) fn texts(&self) -> [String; 2] {
        let mut domain = "(define (domain drawn) (:types s t) (:predicates (p) (q ?x) (at ?x ?y) (r ?x)
            (fixed ?x) (linked ?x))
            (:derived (linked ?v0) (or "
            .to_owned();
        domain += &self.rule.text(1);
        domain += " (exists (?v1) (and (at ?v0 ?v1) (linked ?v1)))))";
        for (number, action) in self.actions.iter().enumerate() {
            let parameters: String = action
                .parameters
                .iter()
                .enumerate()
                .map(|(at, of)| format!("?v{at} - {} ", TYPES[*of].0))
                .collect();
            let scope = action.parameters.len();
            domain += &format!(
                "\n(:action do{number} :parameters ({parameters}) :precondition {} :effect {})",
                action.condition.text(scope),
                action.effect.text(scope)
            );
        }
        let facts: String =
            self.initial.iter().map(|(name, objects)| format!("({name}{})", names(objects, 0))).collect();
        let problem = format!(
            "(define (problem drawn) (:domain drawn) (:objects a b - s c - t) (:init {facts})
            (:goal (and {} (preference wish {}))))",
            self.goal.text(0),
            self.wish.text(0)
        );
        [domain + ")", problem]
    }

    pub(super) fn initial(&self) -> &State {
        &self.initial
    }

    /// Returns the atoms of the derived predicate, as a least fixpoint.
    pub(super) fn derived(&self, state: &State) -> State {
        let mut linked = State::new();
        loop {
            let mut all = state.clone();
            all.extend(linked.iter().cloned());
            let holds = |x: usize| {
                self.rule.holds(&all, &mut vec![x])
                    || (0..3).any(|y| all.contains(&("at", vec![x, y])) && all.contains(&("linked", vec![y])))
            };
            let next: State = (0..3).filter(|&x| holds(x)).map(|x| ("linked", vec![x])).collect();
            if next == linked {
                return linked;
            }
            linked = next;
        }
    }

    fn with_derived(&self, state: &State) -> State {
        let mut all = state.clone();
        all.extend(self.derived(state));
        all
    }

    /// Returns whether the goal and the preference hold.
    pub(super) fn goals(&self, state: &State) -> [bool; 2] {
        let all = self.with_derived(state);
        [self.goal.holds(&all, &mut Vec::new()), self.wish.holds(&all, &mut Vec::new())]
    }

    fn fixed(&self) -> Fixed {
        let mut changed: BTreeSet<&'static str> = [DERIVED.0].into();
        self.actions.iter().for_each(|action| action.effect.changed(&mut changed));
        Fixed { changed, initial: self.initial.clone() }
    }

    /// Returns the applicable actions by name, each with its successors.
    pub(super) fn steps(&self, state: &State) -> BTreeMap<String, (BTreeMap<State, Ratio>, Ratio)> {
        let all = self.with_derived(state);
        let fixed = self.fixed();
        let mut steps = BTreeMap::new();
        for (number, action) in self.actions.iter().enumerate() {
            for values in tuples(&action.parameters) {
                if action.condition.holds(&all, &mut values.clone()) {
                    let shown: Vec<&str> = values.iter().map(|&v| OBJECTS[v]).collect();
                    let name = match shown.is_empty() {
                        true => format!("do{number}"),
                        false => format!("do{number}({})", shown.join(",")),
                    };
                    let earned = action.effect.earned(&values, &all);
                    steps.insert(name, (successors(&action.effect, &values, state, &all, &fixed), earned));
                }
            }
        }
        steps
    }
}

fn tuples(types: &[usize]) -> Vec<Vec<usize>> {
    let mut all = vec![Vec::new()];
    for &of in types {
        let longer = |values: &Vec<usize>| {
            let values = values.clone();
            TYPES[of].1.iter().map(move |&object| values.iter().copied().chain([object]).collect())
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}

fn successors(
    effect: &Eff,
    values: &[usize],
    state: &State,
    all: &State,
    fixed: &Fixed,
) -> BTreeMap<State, Ratio> {
    let mut successors = BTreeMap::new();
    for (probability, outcome) in effect.outcomes(values, fixed) {
        let applies = |(conditions, added, atom): &(BTreeSet<Closed>, bool, Atom)| {
            conditions.iter().all(|c| c.holds(all)).then(|| (*added, atom.clone()))
        };
        let applied: Vec<(bool, Atom)> = outcome.iter().filter_map(applies).collect();
        let mut next = state.clone();
        applied.iter().filter(|(added, _)| !added).for_each(|(_, atom)| {
            next.remove(atom);
        });
        next.extend(applied.into_iter().filter(|(added, _)| *added).map(|(_, atom)| atom));
        *successors.entry(next).or_insert_with(|| Ratio::new(0.into(), 1.into())) += probability;
    }
    successors
}

/// Outcomes with their probabilities.
type Distribution = Vec<(Ratio, Outcome)>;

impl Eff {
    fn text(&self, scope: usize) -> String {
        let list = |all: &[Eff]| all.iter().map(|e| format!(" {}", e.text(scope))).collect::<String>();
        match self {
            Eff::And(all) => format!("(and{})", list(all)),
            Eff::OneOf(all) => format!("(oneof{})", list(all)),
            Eff::Atom(name, arguments, true) => format!("({name}{})", names(arguments, scope)),
            Eff::Atom(name, arguments, false) => format!("(not ({name}{}))", names(arguments, scope)),
            Eff::When(c, inner) => format!("(when {} {})", c.text(scope), inner.text(scope)),
            Eff::All(of, inner) => {
                format!("(forall (?v{scope} - {}) {})", TYPES[*of].0, inner.text(scope + 1))
            }
            Eff::Probably(all) => {
                let pair = |(tenths, e): &(u32, Eff)| format!(" {tenths}/10 {}", e.text(scope));
                format!("(probabilistic{})", all.iter().map(pair).collect::<String>())
            }
            Eff::Earn(amount) => format!("(increase (reward) {amount})"),
        }
    }

    /// Adds the predicates that the effect changes.
    fn changed(&self, all: &mut BTreeSet<&'static str>) {
        match self {
            Eff::Atom(name, ..) => _ = all.insert(name),
            Eff::And(parts) | Eff::OneOf(parts) => parts.iter().for_each(|e| e.changed(all)),
            Eff::When(_, inner) | Eff::All(_, inner) => inner.changed(all),
            Eff::Probably(parts) => parts.iter().for_each(|(_, e)| e.changed(all)),
            Eff::Earn(_) => {}
        }
    }

    /// Returns the distribution: where alternatives have no probabilities, all distinct outcomes have
    /// the same one.
    fn outcomes(&self, values: &[usize], fixed: &Fixed) -> Distribution {
        let raw = self.raw(values, &BTreeSet::new(), fixed);
        if self.has_numbers() {
            return raw;
        }
        let distinct: BTreeSet<Outcome> = raw.into_iter().map(|(_, outcome)| outcome).collect();
        let share = Ratio::new(1.into(), distinct.len().into());
        distinct.into_iter().map(|outcome| (share.clone(), outcome)).collect()
    }

    fn has_numbers(&self) -> bool {
        match self {
            Eff::Probably(_) => true,
            Eff::Atom(..) | Eff::Earn(_) => false,
            Eff::And(all) | Eff::OneOf(all) => all.iter().any(Eff::has_numbers),
            Eff::When(_, inner) | Eff::All(_, inner) => inner.has_numbers(),
        }
    }

    /// Returns the reward of the effect in a state, on average over its outcomes.
    fn earned(&self, values: &[usize], state: &State) -> Ratio {
        let whole = |n: u32| Ratio::from_integer(n.into());
        match self {
            Eff::Earn(amount) => whole(*amount),
            Eff::And(all) => all.iter().map(|e| e.earned(values, state)).sum(),
            Eff::When(condition, _) if !condition.holds(state, &mut values.to_vec()) => whole(0),
            Eff::When(_, e) => e.earned(values, state),
            Eff::All(of, e) => TYPES[*of].1.iter().map(|&o| e.earned(&[values, &[o]].concat(), state)).sum(),
            Eff::Probably(all) => {
                all.iter().map(|(tenths, e)| e.earned(values, state) * whole(*tenths) / whole(10)).sum()
            }
            Eff::Atom(..) | Eff::OneOf(_) => whole(0),
        }
    }

    fn raw(&self, values: &[usize], conditions: &BTreeSet<Closed>, fixed: &Fixed) -> Distribution {
        let one = || Ratio::new(1.into(), 1.into());
        let product = |parts: Vec<Distribution>| {
            parts.into_iter().fold(vec![(one(), Outcome::new())], |all, part| {
                let joined = |(p, x): &(Ratio, Outcome)| {
                    let (p, x) = (p.clone(), x.clone());
                    part.iter().map(move |(q, y)| (&p * q, x.union(y).cloned().collect())).collect::<Vec<_>>()
                };
                all.iter().flat_map(joined).collect()
            })
        };
        match self {
            Eff::Atom(name, arguments, added) => {
                let atom = (*name, arguments.iter().map(|&x| object(x, values)).collect());
                vec![(one(), [(conditions.clone(), *added, atom)].into())]
            }
            Eff::Earn(_) => vec![(one(), Outcome::new())],
            Eff::And(all) => product(all.iter().map(|e| e.raw(values, conditions, fixed)).collect()),
            Eff::When(condition, _) if !condition.closed(values, 0, true).may_hold(fixed) => {
                vec![(one(), Outcome::new())]
            }
            Eff::When(condition, inner) => {
                let more = match condition.closed(values, 0, true) {
                    Closed::And(parts) => parts,
                    other => vec![other],
                };
                inner.raw(values, &conditions.iter().cloned().chain(more).collect(), fixed)
            }
            Eff::All(of, inner) => {
                let each = |&o: &usize| {
                    inner.raw(&values.iter().copied().chain([o]).collect::<Vec<_>>(), conditions, fixed)
                };
                product(TYPES[*of].1.iter().map(each).collect())
            }
            Eff::OneOf(all) => all.iter().flat_map(|e| e.raw(values, conditions, fixed)).collect(),
            Eff::Probably(all) => {
                let tenth = |n: u32| Ratio::new(n.into(), 10.into());
                let mut mixed: Distribution = Vec::new();
                let mut rest = one();
                for (tenths, e) in all {
                    rest -= tenth(*tenths);
                    mixed.extend(
                        e.raw(values, conditions, fixed).into_iter().map(|(p, x)| (p * tenth(*tenths), x)),
                    );
                }
                if rest != tenth(0) {
                    mixed.push((rest, Outcome::new()));
                }
                mixed
            }
        }
    }
}
