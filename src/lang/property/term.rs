//! Properties as expressions over the states of a program: sets of states, and numbers.

use super::formulas::is_bounded;
use crate::ast::{BinaryOp, Function, Span};
use crate::ltl::{Formula, FormulaKind};
use meliora_base::exact::Ratio;
use meliora_base::value::Type;
use meliora_model::expr::ExprId;
use meliora_model::predicate::{Predicate, Predicates};
use meliora_model::property::{Inequality, Rewards};
use meliora_model::{Optimum, Program};

/// A property over the states of a program: a condition, or a number.
#[derive(Debug, Clone)]
pub struct Term {
    /// Form of the term.
    pub kind: TermKind,
    /// The type of its value.
    pub ty: Type,
    /// Place in the text.
    pub span: Span,
}

/// The forms of terms.
#[derive(Debug, Clone)]
pub enum TermKind {
    /// An expression over the variables.
    State(Predicate),
    /// `!φ`
    Not(Box<Term>),
    /// `-x`
    Neg(Box<Term>),
    /// `φ & ψ & …` if true, else `φ | ψ | …`.
    Join(bool, Vec<Term>),
    /// `=>`, `<=>`, a comparison, or arithmetic.
    Binary(BinaryOp, Box<[Term; 2]>),
    /// `c ? x : y`
    Ite(Box<[Term; 3]>),
    /// A function of numbers.
    Apply(Function, Vec<Term>),
    /// An operator over paths.
    Operator(Box<Measured>),
    /// `A [ φ ]` if true, else `E [ φ ]`.
    Paths(bool, Box<Path>),
    /// A function of the values in several states.
    Filter(Box<Filter>),
    /// `multi(…)`
    Multi(Vec<Term>),
}

/// An operator that asks for a number over paths, or compares one with a bound.
#[derive(Debug, Clone)]
pub struct Measured {
    /// The players of a game who choose to make the property true, as an entry per player.
    pub coalition: Option<Vec<bool>>,
    /// The number.
    pub measure: Measure,
    /// The strategies.
    pub optimum: Optimum,
    /// The comparison; `None` for the number itself.
    pub bound: Option<(Inequality, Ratio)>,
}

/// The number that an operator asks for.
#[derive(Debug, Clone)]
pub enum Measure {
    /// The probability of a formula.
    Probability(Box<Path>),
    /// The probability of some states in the long run.
    LongRun(Term),
    /// A reward.
    Reward(Rewards, Accumulated),
}

/// The rewards that an operator asks for.
#[derive(Debug, Clone)]
pub enum Accumulated {
    /// Until a formula is satisfied.
    Until(Box<Path>),
    /// Until one of some states is reached, or of all steps if none is.
    Anyway(Term),
    /// Until one of some states is reached, and nothing if none is.
    IfReached(Term),
    /// Rewards of the first steps.
    Within(u64),
    /// Rewards of all steps.
    Total,
    /// Reward of the state after some steps.
    At(u64),
    /// The average of a step in the long run.
    LongRun,
}

/// A formula on paths over conditions of a pool.
#[derive(Debug, Clone)]
pub struct Path {
    /// This formula with at most one temporal operator; `None` if it has more.
    pub single: Option<Single>,
    /// The condition that recurs if this formula is `G F φ`, and whether the formula is the negation, `F G !φ`.
    pub recurring: Option<(Term, bool)>,
    /// The formula. Its conditions are [known](crate::ltl::FormulaKind::Known) in the pool or
    /// [nested](crate::ltl::FormulaKind::Nested).
    pub formula: Formula,
    /// The pool of its conditions.
    pub predicates: Predicates,
    /// The nested conditions.
    pub nested: Vec<Term>,
}

impl Path {
    /// Returns the target if the formula is `F target` without bounds and operators in the target.
    pub fn target(&self) -> Option<Predicate> {
        self.formula.known_target().map(|target| self.predicates.get(target))
    }

    /// Returns whether the formula is one temporal operator with bounds on the number of steps.
    pub fn is_bounded(&self) -> bool {
        is_bounded(&self.formula)
    }

    /// Returns a program whose pool contains the conditions of the formula.
    pub fn over(&self, program: &Program) -> Program {
        Program { pool: self.predicates.clone().into_pool(), ..program.clone() }
    }

    /// Returns whether another path has the same formula over the same conditions, none of them nested. Two different
    /// formulas can still mean the same.
    pub fn is_same(&self, other: &Path) -> bool {
        let mut conditions = [Vec::new(), Vec::new()];
        let forms = [(self, 0), (other, 1)].map(|(path, at)| form(&path.formula, &mut conditions[at]));
        let [own, theirs] = conditions;
        let alike = |(&a, &b)| self.predicates.get(a).is_same(&other.predicates.get(b));
        self.nested.is_empty() && forms[0] == forms[1] && own.iter().zip(&theirs).all(alike)
    }
}

/// A formula with at most one temporal operator, or its negation.
#[derive(Debug, Clone)]
pub struct Single {
    /// The formula is negated.
    pub negated: bool,
    /// The operator.
    pub step: Step,
}

/// A temporal operator to which the others are reduced.
#[derive(Debug, Clone)]
pub enum Step {
    /// A condition on the first state.
    Now(Term),
    /// `X φ`
    Next(Term),
    /// `φ U ψ` with bounds on the number of steps; no left side stands for `true`.
    Until {
        /// φ
        left: Option<Term>,
        /// ψ
        right: Term,
        /// The least number of steps.
        least: u64,
        /// The greatest number of steps.
        most: Option<u64>,
    },
}

/// A function of the values in some states.
#[derive(Debug, Clone)]
pub struct Filter {
    /// The function.
    pub function: FilterFunction,
    /// The values.
    pub of: Term,
    /// The states; `None` for all.
    pub states: Option<Term>,
}

/// The functions of filters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, strum::EnumString, strum::IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum FilterFunction {
    /// The least value.
    Min,
    /// The greatest value.
    Max,
    /// The sum of the values.
    #[strum(serialize = "sum", serialize = "+")]
    Sum,
    /// The average of the values.
    Avg,
    /// The number of states that satisfy the condition.
    Count,
    /// The least and the greatest value.
    Range,
    /// The condition holds in all states.
    #[strum(serialize = "forall", serialize = "&")]
    Forall,
    /// The condition holds in some state.
    #[strum(serialize = "exists", serialize = "|")]
    Exists,
    /// The value of the only state.
    State,
    /// The value of the first state.
    First,
    /// The states with the least value.
    Argmin,
    /// The states with the greatest value.
    Argmax,
    /// The values in the states where they are not zero or false.
    Print,
    /// The values in all states.
    Printall,
}

impl Term {
    /// Returns whether the term is a condition.
    pub fn is_condition(&self) -> bool {
        self.ty == Type::Bool
    }
}

/// Returns a formula without places, whose conditions are their positions in a list.
fn form(formula: &Formula, conditions: &mut Vec<ExprId>) -> Formula {
    fn without_places(formula: &mut Formula, conditions: &mut Vec<ExprId>) {
        formula.span = Span::default();
        if let FormulaKind::Known(id) = formula.kind {
            formula.kind = FormulaKind::Nested(conditions.len());
            conditions.push(id);
        }
        for bound in formula.bounds_mut() {
            bound.nodes.iter_mut().for_each(|node| node.span = Span::default());
        }
        formula.operands_mut().into_iter().for_each(|part| without_places(part, conditions));
    }
    let mut form = formula.clone();
    without_places(&mut form, conditions);
    form
}
