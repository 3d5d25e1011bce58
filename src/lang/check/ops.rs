//! Operators and functions, with PRISM's types, and the nodes that they become.

use super::lowerer::{Lowerer, Operand};
use crate::ast::{BinaryOp, Function, NodeKind, Span};
use meliora_base::exact::{Exact, Real};
use meliora_base::value::{Type, Value};
use meliora_model::expr::{Binary, ExprId, Node, Unary};

/// Maximum height of an expression after substitution of formulas.
pub(super) const MAX_HEIGHT: u16 = 10_000;

impl Lowerer<'_> {
    /// Checks the height of a new node, and records its place if it has no value. Such a node is an
    /// error only if it may be evaluated.
    fn made(&mut self, id: ExprId, span: Span) -> Option<ExprId> {
        if self.height(id) > MAX_HEIGHT {
            let message =
                format!("this expression nests more than {MAX_HEIGHT} operators, formulas included");
            return self.fail(span, message);
        }
        if self.pool.fault(id).is_some() {
            self.faults.entry(id).or_insert(span);
        }
        Some(id)
    }

    /// Returns the height of a node; the heights of its operands must be known.
    fn height(&mut self, id: ExprId) -> u16 {
        if self.heights.len() <= id.index() {
            self.heights.resize(id.index() + 1, 0);
        }
        if self.heights[id.index()] == 0 {
            let known = |e: ExprId| self.heights.get(e.index()).copied().unwrap_or(0);
            self.heights[id.index()] = 1 + match self.pool.node(id) {
                Node::Literal(_) | Node::Var(_) => 0,
                Node::Unary(_, a) => known(a),
                Node::Binary(_, a, b) => known(a).max(known(b)),
                Node::Ite(c, a, b) => known(c).max(known(a)).max(known(b)),
            };
        }
        self.heights[id.index()]
    }

    fn unary(&mut self, op: Unary, a: ExprId, span: Span) -> Option<ExprId> {
        let made = self.pool.unary(op, a);
        self.made(made, span)
    }

    pub(crate) fn node(&mut self, op: Binary, a: ExprId, b: ExprId, span: Span) -> Option<ExprId> {
        let mut made = self.pool.binary(op, a, b);
        if matches!(op, Binary::Pow | Binary::Log) && self.pool.ty(made) == Type::Real {
            let operands = [a, b].map(|e| self.pool.exact_literal(e).map(Exact::into_real));
            if let [Some(x), Some(y)] = &operands
                && let Some(near) = Real::near(op, x, y)
            {
                made = self.pool.exact_value(Exact::Real(near));
                self.round_at(span);
            } else if self.pool.literal(made).is_none() && !self.is_rational(op, b) {
                self.round_at(span);
            }
        }
        self.made(made, span)
    }

    /// Returns whether powers with this exponent are fractions: it is an integer.
    fn is_rational(&self, op: Binary, exponent: ExprId) -> bool {
        let is_whole = match self.pool.node(exponent) {
            Node::Literal(_) => self.pool.eval_exact(exponent, &[]).is_ok_and(|n| n.is_integer()),
            node => matches!(node, Node::Unary(Unary::ToReal, _)),
        };
        op == Binary::Pow && is_whole
    }

    pub(crate) fn made_real(&mut self, id: ExprId, span: Span) -> Option<ExprId> {
        match self.pool.ty(id) {
            Type::Int => self.unary(Unary::ToReal, id, span),
            _ => Some(id),
        }
    }

    pub(crate) fn expect_type(&mut self, id: ExprId, ty: Type, span: Span, what: &str) -> Option<ExprId> {
        match (self.pool.ty(id), ty) {
            (found, wanted) if found == wanted => Some(id),
            (Type::Int, Type::Real) => self.made_real(id, span),
            (found, wanted) => {
                let mut diagnostic = self
                    .wrong(span, format!("type error: {what} must be of type `{wanted}`"))
                    .label(format!("of type `{found}`"));
                if (found, wanted) == (Type::Real, Type::Int) {
                    diagnostic =
                        diagnostic.help("`floor`, `ceil` and `round` return integers; `/` never does");
                }
                self.report(diagnostic);
                None
            }
        }
    }

    /// Returns the value of an operator for checked operands; `conditional` is the name of `?:`.
    pub(crate) fn operation(
        &mut self,
        kind: &NodeKind,
        operands: Vec<Operand>,
        span: Span,
        conditional: &str,
    ) -> Option<ExprId> {
        match (kind, operands.as_slice()) {
            (NodeKind::Not, &[(a, at)]) => self.not(a, at),
            (NodeKind::Neg, &[(a, at)]) => self.neg(a, at, span),
            (NodeKind::Binary(op), &[a, b]) => self.binary(*op, a, b, span),
            (NodeKind::Join(op, _), _) => self.balanced(*op, operands),
            (NodeKind::Ite, &[(c, at), a, b]) => {
                let c = self.expect_type(c, Type::Bool, at, &format!("the condition of {conditional}"))?;
                self.ite(c, a, b)
            }
            (NodeKind::Apply(function, _), _) => self.apply(*function, &operands, span),
            _ => self.fail(span, "wrong number of operands"),
        }
    }

    fn not(&mut self, a: ExprId, span: Span) -> Option<ExprId> {
        let a = self.expect_type(a, Type::Bool, span, "the operand of `!`")?;
        self.unary(Unary::Not, a, span)
    }

    fn neg(&mut self, a: ExprId, operand: Span, span: Span) -> Option<ExprId> {
        self.expect_number((a, operand), "the operand of `-`")?;
        self.unary(Unary::Neg, a, span)
    }

    fn expect_number(&mut self, (id, span): Operand, what: &str) -> Option<()> {
        if self.pool.ty(id) != Type::Bool {
            return Some(());
        }
        let mut diagnostic = self.wrong(span, format!("type error: {what} must be a number"));
        if ["`<`", "`<=`", "`>`", "`>=`"].iter().any(|sign| what.ends_with(sign)) {
            diagnostic = diagnostic.help("comparisons are joined by `&`: `0<=x & x<=1`");
        }
        self.report(diagnostic.label("of type `bool`"));
        None
    }

    /// Returns both operands as numbers of one type.
    fn numbers(&mut self, a: Operand, b: Operand, what: &str) -> Option<(ExprId, ExprId)> {
        let (left, right) = (self.expect_number(a, what), self.expect_number(b, what));
        left.and(right)?;
        self.same_numbers(a, b)
    }

    fn same_numbers(&mut self, a: Operand, b: Operand) -> Option<(ExprId, ExprId)> {
        if self.pool.ty(a.0) == self.pool.ty(b.0) {
            return Some((a.0, b.0));
        }
        Some((self.made_real(a.0, a.1)?, self.made_real(b.0, b.1)?))
    }

    fn reals(&mut self, a: Operand, b: Operand, what: &str) -> Option<(ExprId, ExprId)> {
        self.numbers(a, b, what)?;
        Some((self.made_real(a.0, a.1)?, self.made_real(b.0, b.1)?))
    }

    fn booleans(&mut self, a: Operand, b: Operand, what: &str) -> Option<()> {
        let left = self.expect_type(a.0, Type::Bool, a.1, what);
        let right = self.expect_type(b.0, Type::Bool, b.1, what);
        left.and(right).map(|_| ())
    }

    /// Returns `a & b & …` or `a | b | …` as a balanced tree; the order of evaluation stays. Without
    /// operands it is the neutral element.
    pub(crate) fn balanced(&mut self, op: BinaryOp, mut row: Vec<Operand>) -> Option<ExprId> {
        let what = format!("an operand of `{}`", op.symbol());
        let checked =
            row.iter().filter(|&&(e, s)| self.expect_type(e, Type::Bool, s, &what).is_some()).count();
        if checked < row.len() {
            return None;
        }
        let node = if op == BinaryOp::And { Binary::And } else { Binary::Or };
        while row.len() > 1 {
            // In place, since there may be millions of operands.
            let half = row.len() / 2;
            for at in 0..half {
                let ((a, start), (b, end)) = (row[2 * at], row[2 * at + 1]);
                row[at] = (self.node(node, a, b, start.to(end))?, start.to(end));
            }
            // An operand without a partner is kept for the next round.
            if row.len() > 2 * half {
                row[half] = row[2 * half];
            }
            row.truncate(row.len().div_ceil(2));
        }
        match row.first() {
            Some(whole) => Some(whole.0),
            None => self.literal(Value::Bool(op == BinaryOp::And)),
        }
    }

    pub(crate) fn binary(&mut self, op: BinaryOp, a: Operand, b: Operand, span: Span) -> Option<ExprId> {
        let what = format!("an operand of `{}`", op.symbol());
        match op {
            BinaryOp::Implies => {
                self.booleans(a, b, &what)?;
                let not = self.unary(Unary::Not, a.0, a.1)?;
                self.node(Binary::Or, not, b.0, span)
            }
            BinaryOp::Iff => {
                self.booleans(a, b, &what)?;
                self.node(Binary::Eq, a.0, b.0, span)
            }
            BinaryOp::Eq | BinaryOp::Ne => self.equality(op, a, b, span),
            BinaryOp::Div => {
                let (x, y) = self.reals(a, b, &what)?;
                self.node(Binary::Div, x, y, span)
            }
            _ => {
                let (x, y) = self.numbers(a, b, &what)?;
                let (node, x, y) = match op {
                    BinaryOp::Lt => (Binary::Lt, x, y),
                    BinaryOp::Le => (Binary::Le, x, y),
                    BinaryOp::Gt => (Binary::Lt, y, x),
                    BinaryOp::Ge => (Binary::Le, y, x),
                    BinaryOp::Add => (Binary::Add, x, y),
                    BinaryOp::Sub => (Binary::Sub, x, y),
                    BinaryOp::Mul => (Binary::Mul, x, y),
                    BinaryOp::Pow => (Binary::Pow, x, y),
                    BinaryOp::And => (Binary::And, x, y),
                    _ => (Binary::Or, x, y),
                };
                self.node(node, x, y, span)
            }
        }
    }

    fn equality(&mut self, op: BinaryOp, a: Operand, b: Operand, span: Span) -> Option<ExprId> {
        let (ta, tb) = (self.pool.ty(a.0), self.pool.ty(b.0));
        if (ta == Type::Bool) != (tb == Type::Bool) {
            let diagnostic = self.wrong(span, format!("type error: `{ta}` and `{tb}` cannot be compared"));
            self.report(diagnostic.label(format!("`{}` between `{ta}` and `{tb}`", op.symbol())));
            return None;
        }
        let (x, y) = self.same_numbers(a, b)?;
        let equal = self.node(Binary::Eq, x, y, span)?;
        if op == BinaryOp::Eq { Some(equal) } else { self.unary(Unary::Not, equal, span) }
    }

    /// Returns `c ? a : b`.
    pub(crate) fn ite(&mut self, c: ExprId, a: Operand, b: Operand) -> Option<ExprId> {
        let (ta, tb) = (self.pool.ty(a.0), self.pool.ty(b.0));
        let span = a.1.to(b.1);
        if (ta == Type::Bool) != (tb == Type::Bool) {
            return self
                .fail(span, format!("type error: the branches of `?` are of types `{ta}` and `{tb}`"));
        }
        let (x, y) = self.same_numbers(a, b)?;
        let made = self.pool.ite(c, x, y);
        self.made(made, span)
    }

    /// Returns `f(e, …)` for a function of PRISM's language.
    pub(super) fn call(&mut self, name: &str, at: Span, args: &[Operand], span: Span) -> Option<ExprId> {
        if let Some(function) = Function::named(name) {
            return self.apply(function, args, span);
        }
        let diagnostic = match name {
            "multi" => self
                .wrong(at, "the function `multi` is not supported")
                .severity(meliora_base::error::Severity::Unsupported)
                .label("not supported")
                .note("`multi` combines properties and cannot occur in a model"),
            _ => self
                .wrong(at, format!("unknown function `{name}`"))
                .help("the functions are min, max, floor, ceil, round, pow, mod and log"),
        };
        self.report(diagnostic);
        None
    }

    fn apply(&mut self, function: Function, args: &[Operand], span: Span) -> Option<ExprId> {
        let name = function.name();
        let what = format!("an argument of `{name}`");
        match (function, args) {
            (Function::Min, [_, ..]) => self.extreme(Binary::Min, args, &what, span),
            (Function::Max, [_, ..]) => self.extreme(Binary::Max, args, &what, span),
            (Function::Floor, &[a]) => self.rounded(Unary::Floor, a, &what, span),
            (Function::Ceil, &[a]) => self.rounded(Unary::Ceil, a, &what, span),
            (Function::Round, &[a]) => self.rounded(Unary::Round, a, &what, span),
            (Function::Abs | Function::Sign | Function::Truncate, &[a]) => self.by_sign(function, a, span),
            (Function::Pow, &[a, b]) => {
                let (x, y) = self.numbers(a, b, &what)?;
                self.node(Binary::Pow, x, y, span)
            }
            (Function::Log, &[a, b]) => {
                let (x, y) = self.reals(a, b, &what)?;
                self.node(Binary::Log, x, y, span)
            }
            (Function::Mod, &[a, b]) => {
                let x = self.expect_type(a.0, Type::Int, a.1, &what);
                let y = self.expect_type(b.0, Type::Int, b.1, &what);
                self.node(Binary::Mod, x?, y?, span)
            }
            _ => {
                let takes = match function {
                    Function::Min | Function::Max => "at least 1 argument",
                    Function::Pow | Function::Log | Function::Mod => "2 arguments",
                    _ => "1 argument",
                };
                self.fail(span, format!("`{name}` needs {takes}, not {}", args.len()))
            }
        }
    }

    /// Returns the minimum or the maximum of any number of arguments; real if one of them is real.
    fn extreme(&mut self, op: Binary, args: &[Operand], what: &str, span: Span) -> Option<ExprId> {
        let checked: Vec<_> = args.iter().map(|&a| self.expect_number(a, what)).collect();
        checked.into_iter().collect::<Option<()>>()?;
        let real = args.iter().any(|a| self.pool.ty(a.0) == Type::Real);
        let mut result = None;
        for &(id, at) in args {
            let id = if real { self.made_real(id, at)? } else { id };
            result = Some(match result {
                None => id,
                Some(before) => self.node(op, before, id, span)?,
            });
        }
        result
    }

    /// Returns a rounded number; an integer is unchanged.
    fn rounded(&mut self, op: Unary, a: Operand, what: &str, span: Span) -> Option<ExprId> {
        self.expect_number(a, what)?;
        if self.pool.ty(a.0) == Type::Int { Some(a.0) } else { self.unary(op, a.0, span) }
    }

    /// Returns a function that JANI defines by the sign of its argument.
    fn by_sign(&mut self, function: Function, a: Operand, span: Span) -> Option<ExprId> {
        let zero = (self.literal(Value::Int(0))?, a.1);
        let minus = if function == Function::Abs { self.neg(a.0, a.1, span)? } else { zero.0 };
        let negative = self.binary(BinaryOp::Lt, a, zero, a.1)?;
        let (low, high) = match function {
            Function::Abs => ((minus, span), a),
            Function::Sign => {
                let positive = self.binary(BinaryOp::Gt, a, zero, a.1)?;
                let [minus, plus] = [-1, 1].map(|i| self.literal(Value::Int(i)));
                ((minus?, span), (self.ite(positive, (plus?, span), (zero.0, span))?, span))
            }
            _ => {
                let up = self.apply(Function::Ceil, &[a], span)?;
                ((up, span), (self.apply(Function::Floor, &[a], span)?, span))
            }
        };
        self.ite(negative, low, high)
    }
}
