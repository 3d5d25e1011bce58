//! A checked planning problem before it is grounded: names are numbers, conditions are in negation
//! normal form.

use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use ahash::AHashMap;
use meliora_base::error::{Diagnostic, Result, SourceFile};
use meliora_base::exact::Ratio;
use num_traits::Signed;

/// The number of an object.
pub(crate) type Object = u32;

/// The objects that a variable stands for, in the order of their declaration.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Domain {
    pub(crate) objects: Vec<Object>,
    /// For each object of the problem, whether it belongs to the domain.
    pub(crate) member: Vec<bool>,
}

/// A variable or an object in an atom. Variables are numbered by the depth of their scope: the
/// parameters of an action first, then those of the quantifiers around an atom.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Term {
    Object(Object),
    Variable(usize),
}

impl Term {
    /// Returns the object under values of the variables.
    pub(crate) fn object(self, values: &[Object]) -> Object {
        match self {
            Term::Object(object) => object,
            Term::Variable(at) => values[at],
        }
    }
}

/// Returns the objects of terms; `None` if one is a variable.
pub(crate) fn objects(terms: &[Term]) -> Option<Vec<Object>> {
    let object = |term: &Term| match term {
        Term::Object(object) => Some(*object),
        Term::Variable(_) => None,
    };
    terms.iter().map(object).collect()
}

/// A predicate with its arguments.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Atom {
    pub(crate) predicate: usize,
    pub(crate) arguments: Vec<Term>,
}

/// A condition in negation normal form.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Condition {
    /// An atom holds, or does not.
    Literal(Atom, bool),
    /// Two terms are the same object, or are not.
    Equal(Term, Term, bool),
    And(Vec<Condition>),
    Or(Vec<Condition>),
    /// The condition holds for all values of further variables.
    All(Vec<Arc<Domain>>, Box<Condition>),
    /// The condition holds for some values of further variables.
    Some(Vec<Arc<Domain>>, Box<Condition>),
}

impl Condition {
    /// Returns the condition with terms in place of its free variables, the first `free.len()` ones. Its
    /// quantified variables are numbered again, from `next` on: a condition is evaluated with values for
    /// the variables below `next`, and each quantifier adds the values of its own after them.
    pub(crate) fn with(&self, free: &[Term], next: usize) -> Condition {
        let term = |term: &Term| match *term {
            Term::Variable(at) if at < free.len() => free[at],
            Term::Variable(at) => Term::Variable(at - free.len() + next),
            object @ Term::Object(_) => object,
        };
        let all = |all: &[Condition]| all.iter().map(|inner| inner.with(free, next)).collect();
        let inside = |inner: &Condition| Box::new(inner.with(free, next));
        match self {
            Condition::Literal(atom, is_positive) => {
                let arguments = atom.arguments.iter().map(term).collect();
                Condition::Literal(Atom { predicate: atom.predicate, arguments }, *is_positive)
            }
            Condition::Equal(left, right, is_positive) => {
                Condition::Equal(term(left), term(right), *is_positive)
            }
            Condition::And(inner) => Condition::And(all(inner)),
            Condition::Or(inner) => Condition::Or(all(inner)),
            Condition::All(domains, inner) => Condition::All(domains.clone(), inside(inner)),
            Condition::Some(domains, inner) => Condition::Some(domains.clone(), inside(inner)),
        }
    }
}

/// An effect.
#[derive(Debug, Clone)]
pub(crate) enum Effect {
    /// All effects at the same time.
    And(Vec<Effect>),
    /// Adds a fact, or deletes it.
    Literal(Atom, bool),
    /// The effect under a condition on the state before.
    When(Condition, Box<Effect>),
    /// The effect for all values of further variables.
    All(Vec<Arc<Domain>>, Box<Effect>),
    /// One of the effects.
    OneOf(Vec<Effect>),
    /// One of the effects with its probability; with the remaining probability none.
    Probably(Vec<(Ratio, Effect)>),
    /// Adds to a measure.
    Earn(Amount),
}

impl Effect {
    /// Returns whether some part has several outcomes.
    pub(crate) fn has_alternatives(&self) -> bool {
        match self {
            Effect::OneOf(_) | Effect::Probably(_) => true,
            Effect::Literal(..) | Effect::Earn(_) => false,
            Effect::And(parts) => parts.iter().any(Effect::has_alternatives),
            Effect::When(_, inner) | Effect::All(_, inner) => inner.has_alternatives(),
        }
    }
}

/// A predicate.
#[derive(Debug)]
pub(crate) struct Predicate {
    /// The name as it is declared.
    pub(crate) name: String,
    pub(crate) parameters: Vec<Arc<Domain>>,
    /// True if rules define it.
    pub(crate) is_derived: bool,
    /// True if an effect changes it.
    pub(crate) is_changed: bool,
}

/// A number to which actions add, which is a reward structure of the program.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Measure {
    /// `(total-cost)`
    Cost,
    /// `(reward)`
    Reward,
}

/// The amount that an effect adds to a measure: a number, or a number times the value of a function.
#[derive(Debug, Clone)]
pub(crate) struct Amount {
    pub(crate) measure: Measure,
    pub(crate) number: Ratio,
    /// The number of the function, and its arguments.
    pub(crate) function: Option<(usize, Vec<Term>)>,
}

/// A function whose values never change.
#[derive(Debug)]
pub(crate) struct Function {
    /// The name as it is declared.
    pub(crate) name: String,
    /// The number of arguments.
    pub(crate) arity: usize,
    /// The values that `:init` gives.
    pub(crate) values: AHashMap<Vec<Object>, Ratio>,
}

/// An action schema.
#[derive(Debug)]
pub(crate) struct Action {
    pub(crate) name: String,
    pub(crate) parameters: Vec<Arc<Domain>>,
    pub(crate) precondition: Condition,
    pub(crate) effect: Effect,
    /// Its place in [`Task::source`].
    pub(crate) span: Range<usize>,
}

/// A rule for a derived predicate: the atom over the variables holds if the condition does.
#[derive(Debug)]
pub(crate) struct Axiom {
    pub(crate) predicate: usize,
    pub(crate) parameters: Vec<Arc<Domain>>,
    pub(crate) condition: Condition,
}

/// A planning problem.
#[derive(Debug)]
pub(crate) struct Task {
    /// Both texts, one after the other.
    pub(crate) source: Arc<SourceFile>,
    pub(crate) objects: Vec<String>,
    pub(crate) predicates: Vec<Predicate>,
    pub(crate) functions: Vec<Function>,
    pub(crate) actions: Vec<Action>,
    pub(crate) axioms: Vec<Axiom>,
    /// The facts that hold in every initial state.
    pub(crate) initial: Vec<(usize, Vec<Object>)>,
    /// The further facts of each initial state.
    pub(crate) starts: Vec<Vec<(usize, Vec<Object>)>>,
    /// The goal without preferences; `None` if there are only preferences.
    pub(crate) goal: Option<Condition>,
    pub(crate) preferences: Vec<(String, Condition)>,
    /// The measures that are declared or changed.
    pub(crate) measures: BTreeSet<Measure>,
    /// The reward of the first step into the goal.
    pub(crate) goal_reward: Option<Ratio>,
    /// True if some effect has several outcomes without stated probabilities.
    pub(crate) has_oneof: bool,
}

impl Task {
    /// Returns what an effect of an action adds under values of the variables.
    ///
    /// # Errors
    /// The function has no value for them; a cost is less than 0.
    pub(crate) fn amount(&self, action: &Action, amount: &Amount, values: &[Object]) -> Result<Ratio> {
        let Some((function, terms)) = &amount.function else { return Ok(amount.number.clone()) };
        let Function { name, values: known, .. } = &self.functions[*function];
        let given: Vec<Object> = terms.iter().map(|term| term.object(values)).collect();
        let wrong = |what: &str| {
            let message = format!("the amount `{}` {what}", self.called(name, &given));
            Diagnostic::new(&self.source, action.span.clone(), message)
        };
        let Some(value) = known.get(&given) else {
            return Err(wrong("has no value")
                .help("`(= (FUNCTION OBJECT …) NUMBER)` in `:init` gives one")
                .into());
        };
        if amount.measure == Measure::Cost && value.is_negative() {
            return Err(wrong("is a cost less than 0").into());
        }
        Ok(value * &amount.number)
    }

    /// Formats an atom: `at(robot,kitchen)`, or `raining` without arguments.
    pub(crate) fn atom(&self, predicate: usize, arguments: &[Object]) -> String {
        self.called(&self.predicates[predicate].name, arguments)
    }

    /// Returns whether two ground actions, or two facts, may have one name, as `(do a,b c)` and `(do a b,c)`.
    pub(crate) fn may_double_names(&self) -> bool {
        self.objects.iter().any(|object| object.contains(','))
    }

    /// Formats a name with arguments.
    pub(crate) fn called(&self, name: &str, arguments: &[Object]) -> String {
        if arguments.is_empty() {
            return name.to_owned();
        }
        let names: Vec<&str> = arguments.iter().map(|&o| self.objects[o as usize].as_str()).collect();
        format!("{name}({})", names.join(","))
    }
}
