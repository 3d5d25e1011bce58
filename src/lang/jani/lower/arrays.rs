//! Arrays: a variable per element, and an index as a case distinction.

use super::super::read::model::{Assignment, Target, Variable as Declaration};
use super::super::read::types::Bounds;
use super::scope::{Known, Meaning, Place, Slot, Transient};
use super::state::Lowering;
use crate::ast::{BinaryOp, Comprehension, Expr, Ident, Span};
use crate::check::Lowered;
use ahash::AHashMap;
use meliora_base::error::Severity;
use meliora_base::value::{Binary, Type, Unary, Value};
use meliora_model::expr::{ExprId, Node};
use meliora_model::{VarId, Variable};

/// Maximum length of an array.
const MOST_ELEMENTS: i64 = 1 << 16;

/// The value of an expression.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Parts {
    /// A number or a Boolean.
    One(ExprId),
    /// An array.
    Many(Vec<Parts>),
}

/// A declared array.
pub(super) struct Array {
    /// The variables of its elements; the initial values of the elements of a transient array.
    parts: Parts,
    /// For a transient array, the position of its first element in [`Lowering::transients`]; the others follow.
    pub(super) transients: Option<usize>,
}

/// The value of an expression with its place, or `None` after reporting that it is wrong.
pub(super) type Read = (Option<Parts>, Span);

/// An element that an assignment may change.
pub(super) struct Element {
    pub(super) slot: Slot,
    pub(super) ty: Type,
    /// Its position in each array around it, with the length of this array.
    pub(super) path: Vec<(usize, usize)>,
}

impl Parts {
    /// Returns the number of arrays in each other.
    fn depth(&self) -> usize {
        match self {
            Parts::One(_) => 0,
            Parts::Many(parts) => 1 + parts.first().map_or(0, Parts::depth),
        }
    }

    /// Replaces the elements.
    pub(super) fn map(&self, of: &mut impl FnMut(ExprId) -> Option<ExprId>) -> Option<Parts> {
        Some(match self {
            Parts::One(id) => Parts::One(of(*id)?),
            Parts::Many(parts) => Parts::Many(parts.iter().map(|part| part.map(of)).collect::<Option<_>>()?),
        })
    }

    /// Returns the part at a position; `None` if there is none.
    fn at(&self, path: &[(usize, usize)]) -> Option<&Parts> {
        match (path, self) {
            ([], _) => Some(self),
            ([(at, length), rest @ ..], Parts::Many(parts)) if parts.len() == *length => parts[*at].at(rest),
            _ => None,
        }
    }

    /// Lists the positions of the elements.
    fn paths(&self, before: &[(usize, usize)], all: &mut Vec<(Vec<(usize, usize)>, ExprId)>) {
        match self {
            Parts::One(id) => all.push((before.to_vec(), *id)),
            Parts::Many(parts) => {
                for (at, part) in parts.iter().enumerate() {
                    let path: Vec<_> = before.iter().copied().chain([(at, parts.len())]).collect();
                    part.paths(&path, all);
                }
            }
        }
    }
}

impl<'a> Lowering<'a> {
    /// Returns the only part of a value that is not an array.
    pub(super) fn scalar(&mut self, (read, span): Read) -> Lowered {
        match read {
            Some(Parts::One(id)) => (Some(id), span),
            Some(Parts::Many(_)) => {
                (self.lowerer.fail(span, "an array cannot stand here: a number or a Boolean is needed"), span)
            }
            None => (None, span),
        }
    }

    /// Checks the types of all elements of a value, and that it has the given number of arrays in each other.
    pub(super) fn expect(&mut self, (read, span): Read, wanted: &Bounds, what: &str) -> Option<Parts> {
        let (parts, dimensions) = (read?, wanted.dimensions);
        if parts.depth() != dimensions {
            let wanted = match dimensions {
                0 => "no array".to_owned(),
                1 => "an array".to_owned(),
                _ => format!("an array with {dimensions} indices"),
            };
            return self.lowerer.fail(span, format!("type error: {what} must be {wanted}"));
        }
        parts.map(&mut |id| self.lowerer.expect_type(id, wanted.ty, span, what))
    }

    /// Declares the variables of an array; its initial value gives the length.
    pub(super) fn array(
        &mut self,
        declared: &'a Declaration,
        name: &str,
        instance: Option<usize>,
    ) -> Meaning {
        let transients = declared.transient.then_some(self.transients.len());
        let made = match declared.transient {
            true => self.transient_elements(declared, instance),
            false => self.array_elements(declared, name, instance),
        };
        self.arrays.push(Array { parts: made.unwrap_or_else(|| Parts::Many(Vec::new())), transients });
        Meaning::Array(self.arrays.len() - 1)
    }

    /// Returns the initial value of an array with its place, which gives the length.
    fn initial_elements(
        &mut self,
        declared: &'a Declaration,
        instance: Option<usize>,
    ) -> Option<(Parts, String)> {
        let Some(initial) = &declared.initial else {
            let message = "an array without an initial value, which gives its length, is not supported";
            let diagnostic = self.lowerer.wrong(declared.name.span, message).severity(Severity::Unsupported);
            self.lowerer.report(diagnostic.label("not supported"));
            return None;
        };
        let what = format!("the initial value of `{}`", declared.name.name);
        let read = self.value(initial, Place { instance, ..Place::default() });
        Some((self.expect(read, &declared.ty, &what)?, what))
    }

    /// Declares the elements of a transient array. Each has its initial value in every state; edges may assign others
    /// that later assignments read.
    fn transient_elements(&mut self, declared: &'a Declaration, instance: Option<usize>) -> Option<Parts> {
        let (parts, what) = self.initial_elements(declared, instance)?;
        let span = declared.name.span;
        parts.map(&mut |id| {
            let Some(value) = self.lowerer.pool.literal(id) else {
                return self.lowerer.fail(span, format!("{what} must be constant"));
            };
            let id = self.lowerer.pool.value(value);
            let (given, state) = (Vec::new(), Known::Done(Some(id)));
            self.transients.push(Transient { variable: declared, instance, given, state, element: Some(id) });
            Some(id)
        })
    }

    fn array_elements(
        &mut self,
        declared: &'a Declaration,
        name: &str,
        instance: Option<usize>,
    ) -> Option<Parts> {
        let range = self.range(declared, name, instance)?;
        let (parts, what) = self.initial_elements(declared, instance)?;
        let place = declared.initial.as_ref().map_or(declared.name.span, Expr::span);
        let mut elements = Vec::new();
        parts.paths(&[], &mut elements);
        let mut made = Vec::with_capacity(elements.len());
        for (path, id) in elements {
            let initial = self.lowerer.value_in_range(id, place, &what, range)?;
            let positions: String = path.iter().map(|(at, _)| format!("_{at}")).collect();
            let (ty, (low, high)) = (declared.ty.ty, range);
            let own = self.names.add(&format!("{name}{positions}"));
            let variable = self.add(Variable {
                name: own,
                ty,
                low,
                high,
                module: instance,
                initial: Some(initial),
                values: Vec::new(),
                span: declared.name.span.range(),
            });
            made.push(self.lowerer.pool.var(variable, ty));
        }
        let mut made = made.into_iter();
        parts.map(&mut |_| made.next())
    }

    /// Returns the elements of an array.
    pub(super) fn elements_in(&self, array: usize) -> Vec<Element> {
        let mut elements = Vec::new();
        self.arrays[array].parts.paths(&[], &mut elements);
        let element = |(at, (path, id))| {
            let slot = self.slot(array, at, id)?;
            let ty = match slot {
                Slot::Transient(t) => self.transients[t].variable.ty.ty,
                Slot::Variable(_) => self.lowerer.pool.ty(id),
            };
            Some(Element { slot, ty, path })
        };
        elements.into_iter().enumerate().filter_map(element).collect()
    }

    /// Returns the elements of an array after assignments.
    pub(super) fn elements_of(&self, array: usize, place: Place<'_>) -> Option<Parts> {
        let mut all = 0..;
        let mut current = |id: ExprId| {
            let slot = self.slot(array, all.next()?, id)?;
            Some(place.current.and_then(|c| c.get(&slot)).copied().unwrap_or(id))
        };
        self.arrays[array].parts.map(&mut current)
    }

    /// Returns the variable of the element at a position of an array.
    fn slot(&self, array: usize, at: usize, id: ExprId) -> Option<Slot> {
        match (self.arrays[array].transients, self.lowerer.pool.node(id)) {
            (Some(first), _) => Some(Slot::Transient(first + at)),
            (None, Node::Var(v)) => Some(Slot::Variable(v)),
            (None, _) => None,
        }
    }

    /// Reads `{"op": "ac"}`.
    pub(super) fn comprehension(
        &mut self,
        made: &Comprehension,
        place: Place<'_>,
        span: Span,
    ) -> Option<Parts> {
        let Comprehension { variable, length, body } = made;
        let length_value = self.constant(length, place, Type::Int, "the length of an array")?;
        let count = match length_value {
            Value::Int(count) if (0..=MOST_ELEMENTS).contains(&count) => count,
            _ => {
                let message = format!("the length of an array must be a number from 0 to {MOST_ELEMENTS}");
                return self.lowerer.fail(length.span(), message);
            }
        };
        let mut parts = Vec::new();
        for at in 0..count {
            let at = Parts::One(self.lowerer.pool.value(Value::Int(at)));
            let outer = place.parameters.into_iter().flatten().map(|(name, value)| (*name, value.clone()));
            let parameters: AHashMap<&str, Parts> = outer.chain([(variable.name.as_str(), at)]).collect();
            let inside = Place { parameters: Some(&parameters), ..place };
            parts.push(self.value(body, inside).0?);
        }
        self.uniform(parts, span)
    }

    /// Returns an array, whose elements have arrays of the same depth inside.
    pub(super) fn uniform(&mut self, parts: Vec<Parts>, span: Span) -> Option<Parts> {
        if parts.iter().any(|part| part.depth() != parts[0].depth()) {
            return self.lowerer.fail(span, "the elements of an array must have the same type");
        }
        Some(Parts::Many(parts))
    }

    /// Returns an index, which has no value outside of an array.
    fn index(&mut self, (id, span): (ExprId, Span), length: usize) -> Option<ExprId> {
        let id = self.lowerer.expect_type(id, Type::Int, span, "an index")?;
        let length = self.lowerer.literal(Value::Int(length as i64))?;
        self.lowerer.node(Binary::Index, id, length, span)
    }

    /// Returns the element of an array at an index.
    pub(super) fn selected(&mut self, array: Parts, index: (ExprId, Span), span: Span) -> Option<Parts> {
        let Parts::Many(parts) = array else {
            return self.lowerer.fail(span, "only an array has elements");
        };
        let at = self.index(index, parts.len())?;
        if let Some(Value::Int(at)) = self.lowerer.pool.literal(at) {
            return parts.into_iter().nth(usize::try_from(at).ok()?);
        }
        let Some(last) = parts.last().cloned() else {
            return self.lowerer.fail(span, "an array without elements has no index");
        };
        // The comparison with 0 comes first and evaluates the index, also for one element.
        let most = parts.len().saturating_sub(1).max(1);
        let cases = parts.into_iter().enumerate().take(most).rev();
        cases
            .into_iter()
            .try_fold(last, |found, (position, part)| self.guarded(at, position, (part, found), span))
    }

    /// Returns one part if an index has a value, else the other one, element by element.
    fn guarded(
        &mut self,
        index: ExprId,
        position: usize,
        (then, otherwise): (Parts, Parts),
        span: Span,
    ) -> Option<Parts> {
        let position = self.lowerer.pool.value(Value::Int(position as i64));
        let here = self.lowerer.pool.binary(Binary::Eq, index, position);
        self.either((here, span), then, otherwise, span)
    }

    /// Returns `c ? a : b` element by element.
    pub(super) fn either(
        &mut self,
        condition: (ExprId, Span),
        then: Parts,
        otherwise: Parts,
        span: Span,
    ) -> Option<Parts> {
        match (then, otherwise) {
            (Parts::One(a), Parts::One(b)) => {
                self.lowerer.ite(condition.0, (a, span), (b, span)).map(Parts::One)
            }
            (Parts::Many(a), Parts::Many(b)) if a.len() == b.len() => {
                let both = a.into_iter().zip(b).map(|(a, b)| self.either(condition, a, b, span));
                both.collect::<Option<_>>().map(Parts::Many)
            }
            _ => {
                let message =
                    "arrays of different lengths are not supported where a state chooses between them";
                let diagnostic = self.lowerer.wrong(span, message).severity(Severity::Unsupported);
                self.lowerer.report(diagnostic.label("not supported"));
                None
            }
        }
    }

    /// Returns the elements that an assignment may change.
    pub(super) fn targets(&mut self, instance: usize, to: &Target) -> Option<Vec<Element>> {
        let name = &to.name;
        let whole = |slot, ty| vec![Element { slot, ty, path: Vec::new() }];
        let found = match self.meaning(&name.name, Some(instance)) {
            Some(Meaning::Variable(v, ty)) => whole(Slot::Variable(v), ty),
            Some(Meaning::Transient(t)) => whole(Slot::Transient(t), self.transients[t].variable.ty.ty),
            Some(Meaning::Array(array)) => self.elements_in(array),
            Some(Meaning::Constant(_)) => return self.not_assigned(name, "it is a constant"),
            None => return self.not_assigned(name, "it is unknown"),
        };
        if found.iter().any(|element| element.path.len() < to.indices.len()) {
            return self
                .lowerer
                .fail(name.span, format!("`{}` has fewer arrays in each other than indices", name.name));
        }
        Some(found)
    }

    fn not_assigned<T>(&mut self, name: &Ident, why: &str) -> Option<T> {
        self.lowerer.fail(name.span, format!("`{}` cannot be assigned: {why}", name.name))
    }

    /// Returns the condition that the indices of an assignment are those of an element; `None` for a whole variable.
    #[allow(clippy::option_option)]
    pub(super) fn hits(
        &mut self,
        assignment: &Assignment,
        element: &[(usize, usize)],
        place: Place<'_>,
    ) -> Option<Option<ExprId>> {
        let mut all = Vec::new();
        for (e, &(position, length)) in assignment.variable.indices.iter().zip(element) {
            let id = self.typed(e, place, Type::Int, "an index")?;
            let at = self.index((id, e.span()), length)?;
            let position = self.lowerer.pool.value(Value::Int(position as i64));
            all.push((self.lowerer.pool.binary(Binary::Eq, at, position), e.span()));
        }
        if all.is_empty() {
            return Some(None);
        }
        self.lowerer.balanced(BinaryOp::And, all).map(Some)
    }

    /// Returns the part of an assigned value for an element.
    pub(super) fn part(
        &mut self,
        value: &Parts,
        path: &[(usize, usize)],
        at: (&str, Span),
    ) -> Option<ExprId> {
        match value.at(path) {
            Some(Parts::One(id)) => Some(*id),
            _ => {
                let wanted = if path.is_empty() { "no array" } else { "an array of the same length" };
                self.lowerer.fail(at.1, format!("type error: {} must be {wanted}", at.0))
            }
        }
    }

    /// Returns a condition that has no value where it and another one are true at the same time.
    pub(super) fn apart(&mut self, here: ExprId, before: Option<ExprId>, span: Span) -> Option<ExprId> {
        let pool = &mut self.lowerer.pool;
        // An index of an array without elements has no value. The variable keeps it from being a constant.
        let first = pool.var(VarId(0), self.variables[0].ty);
        let (zero, one) = (pool.value(Value::Int(0)), pool.value(Value::Int(1)));
        let index = if self.variables[0].ty == Type::Bool { pool.ite(first, zero, one) } else { first };
        let twice = pool.binary(Binary::Index, index, zero);
        let twice = pool.binary(Binary::Eq, twice, zero);
        let conflict = match before {
            Some(before) => {
                let not = pool.unary(Unary::Not, before);
                pool.binary(Binary::Or, not, twice)
            }
            None => twice,
        };
        self.lowerer.balanced(BinaryOp::And, vec![(here, span), (conflict, span)])
    }
}
