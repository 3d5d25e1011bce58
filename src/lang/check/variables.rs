//! Variables: ranges, initial values, and the set of initial states.

use super::collect::{Declared, Parts};
use super::lowerer::{Lowerer, Operand};
use super::scope::NO_RENAMING;
use crate::ast::{BinaryOp, Span};
use meliora_base::value::{Type, Value};
use meliora_model::expr::{Binary, ExprId};
use meliora_model::{VarId, Variable};

/// Maximum absolute value of a bound of a range, such that every value is exact as a double.
const MAX_BOUND: i64 = 1 << 53;

impl<'a> Lowerer<'a> {
    /// Returns all variables, with constant ranges and initial values.
    pub(super) fn variables(&mut self, parts: &Parts<'a>) -> Option<Vec<Variable>> {
        let all: Vec<_> = parts.variables.iter().map(|v| self.variable(v, parts)).collect();
        all.into_iter().collect()
    }

    fn variable(&mut self, declared: &Declared<'a>, parts: &Parts<'a>) -> Option<Variable> {
        let declaration = declared.declaration;
        let (ty, low, high) = match &declaration.range {
            None => (Type::Bool, 0, 1),
            Some((low, high)) => {
                let span = low.to(*high);
                let low = self.integer(*low, declared, "the lower bound of the range");
                let high = self.integer(*high, declared, "the upper bound of the range");
                let (low, high) = (low?, high?);
                self.check_range(low, high, span, &declared.name)?;
                (Type::Int, low, high)
            }
        };
        let initial = self.initial_value(declared, ty, (low, high), parts)?;
        let (name, module) = (declared.name.clone(), declared.module);
        Some(Variable {
            name,
            ty,
            low,
            high,
            module,
            initial,
            values: Vec::new(),
            span: declaration.span.range(),
        })
    }

    pub(crate) fn check_range(&mut self, low: i64, high: i64, span: Span, name: &str) -> Option<()> {
        if low > high {
            return self.fail(span, format!("the range {low}..{high} of `{name}` is empty"));
        }
        if low < -MAX_BOUND || high > MAX_BOUND {
            return self.fail(span, format!("the range {low}..{high} of `{name}` exceeds 2^53"));
        }
        Some(())
    }

    /// Evaluates a constant integer in a declaration.
    fn integer(&mut self, e: Span, declared: &Declared<'a>, what: &str) -> Option<i64> {
        let id = self.typed(&e, declared.env, Type::Int, what)?;
        match self.constant_value(id, e, what)? {
            Value::Int(i) => Some(i),
            _ => None,
        }
    }

    /// Returns the initial value, by default the smallest; `Some(None)` if `init … endinit` defines
    /// it.
    #[allow(clippy::option_option)]
    fn initial_value(
        &mut self,
        declared: &Declared<'a>,
        ty: Type,
        (low, high): (i64, i64),
        parts: &Parts<'a>,
    ) -> Option<Option<i64>> {
        let Some(init) = declared.declaration.init else {
            return Some(if parts.init.is_some() { None } else { Some(low) });
        };
        if let Some(block) = parts.init {
            let message = "a variable cannot have an initial value together with `init … endinit`";
            let diagnostic = self.wrong(init, message);
            self.report(diagnostic.related(block.range(), "the initial states are given here"));
            return None;
        }
        let what = format!("the initial value of `{}`", declared.name);
        let id = self.typed(&init, declared.env, ty, &what)?;
        self.value_in_range(id, init, &what, (low, high)).map(Some)
    }

    /// Returns the value of a constant expression as a value of a variable.
    pub(crate) fn value_in_range(
        &mut self,
        id: ExprId,
        span: Span,
        what: &str,
        (low, high): (i64, i64),
    ) -> Option<i64> {
        let value = match self.constant_value(id, span, what)? {
            Value::Bool(b) => i64::from(b),
            Value::Int(i) => i,
            Value::Real(_) => return None,
        };
        if !(low..=high).contains(&value) {
            return self.fail(span, format!("{what}, {value}, is outside of its range {low}..{high}"));
        }
        Some(value)
    }

    /// Returns the condition that holds exactly in the initial states.
    pub(super) fn initial(&mut self, parts: &Parts<'a>, variables: &Option<Vec<Variable>>) -> Option<ExprId> {
        if let Some(condition) = parts.init {
            return self.condition(&condition, NO_RENAMING, "the condition of `init … endinit`");
        }
        let conditions = self.initial_values(variables.as_ref()?);
        self.balanced(BinaryOp::And, conditions)
    }

    /// Returns for each variable with an initial value the condition that it has this value.
    pub(crate) fn initial_values(&mut self, variables: &[Variable]) -> Vec<Operand> {
        let mut conditions = Vec::new();
        for (index, variable) in variables.iter().enumerate() {
            let Some(value) = variable.initial else { continue };
            let id = self.pool.var(VarId(u32::try_from(index).unwrap_or(u32::MAX)), variable.ty);
            let value = match variable.ty {
                Type::Bool => Value::Bool(value != 0),
                _ => Value::Int(value),
            };
            let value = self.pool.value(value);
            conditions.push((self.pool.binary(Binary::Eq, id, value), Span::default()));
        }
        conditions
    }
}
