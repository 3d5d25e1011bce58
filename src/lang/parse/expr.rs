//! Expressions, with PRISM's precedence.

use num_traits::ToPrimitive;

use super::parser::{Failed, Parsed, Parser};
use crate::ast::{BinaryOp, Function, Ident, NEG_LEVEL, NOT_LEVEL, NodeKind, Span};
use crate::token::Token;
use meliora_base::escape::shortened;
use meliora_base::exact::{Ratio, Real, decimal};
use meliora_base::value::Value;

/// Returns the operator of a token.
pub(crate) fn operator(token: Token) -> Option<BinaryOp> {
    Some(match token {
        Token::Implies => BinaryOp::Implies,
        Token::Iff => BinaryOp::Iff,
        Token::Or => BinaryOp::Or,
        Token::And => BinaryOp::And,
        Token::Eq => BinaryOp::Eq,
        Token::Ne => BinaryOp::Ne,
        Token::Lt => BinaryOp::Lt,
        Token::Le => BinaryOp::Le,
        Token::Gt => BinaryOp::Gt,
        Token::Ge => BinaryOp::Ge,
        Token::Plus => BinaryOp::Add,
        Token::Minus => BinaryOp::Sub,
        Token::Star => BinaryOp::Mul,
        Token::Slash => BinaryOp::Div,
        Token::Caret => BinaryOp::Pow,
        _ => return None,
    })
}

impl Parser<'_> {
    /// Parses `c ? e : c ? e : … e`, or anything that binds tighter; returns its place.
    pub(crate) fn expression(&mut self) -> Parsed<Span> {
        self.nested(Self::conditional)
    }

    fn conditional(&mut self) -> Parsed<Span> {
        let start = self.here();
        let (mut thens, mut last) = (Vec::new(), self.binary(0)?);
        while self.eat(Token::Question) {
            thens.push(self.expression()?);
            self.expect(Token::Colon)?;
            last = self.binary(0)?;
        }
        let whole = start.to(self.before());
        while let Some(then) = thens.pop() {
            let span = if thens.is_empty() { whole } else { then.to(last) };
            last = self.push(span, || NodeKind::Ite);
        }
        Ok(last)
    }

    /// Parses a chain of operators that bind at least as tightly as `least`.
    pub(crate) fn binary(&mut self, least: u8) -> Parsed<Span> {
        let start = self.here();
        // The place of the first operand of the current level, the operator before, the number of
        // operands, and the end of the last one.
        let (mut first, mut last, mut count) = (self.prefix(least)?, None, 1);
        let mut end = self.before();
        while let Some(op) = operator(self.peek()).filter(|op| op.level() >= least) {
            let sign = self.peek();
            self.advance();
            self.foreign_operator(sign);
            if let Some(before) = last.filter(|before: &BinaryOp| before.level() != op.level()) {
                (first, count) = (self.chained(before, count, start.to(end)), 1);
            }
            let right = if op == BinaryOp::Pow { self.exponent(last)? } else { self.binary(op.level() + 1)? };
            if !matches!(op, BinaryOp::And | BinaryOp::Or) {
                self.push(first.to(right), || NodeKind::Binary(op));
            }
            (last, count, end) = (Some(op), count + 1, self.before());
        }
        Ok(last.map_or(first, |op| self.chained(op, count, start.to(end))))
    }

    /// Ends a chain of operators of one level.
    fn chained(&mut self, op: BinaryOp, count: u32, span: Span) -> Span {
        match op {
            BinaryOp::And | BinaryOp::Or => self.push(span, || NodeKind::Join(op, count)),
            _ => {
                self.widen(span);
                span
            }
        }
    }

    /// Reports `&&`, `==` and other operators of other languages, and continues after them.
    pub(crate) fn foreign_operator(&mut self, sign: Token) {
        let ours = match (sign, self.peek()) {
            (Token::And, Token::And) => "&",
            (Token::Or, Token::Or) => "|",
            (Token::Eq, Token::Eq) => "=",
            (Token::Ne, Token::Eq) | (Token::Lt, Token::Gt) => "!=",
            (Token::Eq, Token::Lt) => "<=",
            _ => return,
        };
        let span = self.before().to(self.here());
        if self.before().end() == self.here().start() {
            let diagnostic = self.wrong(span, format!("`{}` is not an operator", self.text(span)));
            self.report(diagnostic.label(format!("write `{ours}`")));
            self.advance();
        }
    }

    /// Parses the exponent after `^`; a chain of powers is refused, since tools read it
    /// differently.
    fn exponent(&mut self, last: Option<BinaryOp>) -> Parsed<Span> {
        let operator = self.before();
        if last == Some(BinaryOp::Pow) {
            let help = "put brackets around one of the two powers";
            self.report(self.wrong(operator, "`^` cannot be chained without brackets").help(help));
        }
        self.prefix(NEG_LEVEL)
    }

    /// Parses signs and negations before an operand.
    fn prefix(&mut self, least: u8) -> Parsed<Span> {
        let start = self.here();
        match self.peek() {
            Token::Bang => {
                self.advance();
                if least > NOT_LEVEL {
                    let message = "`!` binds less tightly than the operator before it";
                    self.report(self.wrong(start, message).help("write the negation in brackets: `(!…)`"));
                }
                self.nested(|p| p.binary(NOT_LEVEL))?;
                Ok(self.push(start.to(self.before()), || NodeKind::Not))
            }
            Token::Minus => {
                self.advance();
                self.nested(|p| p.binary(NEG_LEVEL))?;
                Ok(self.push(start.to(self.before()), || NodeKind::Neg))
            }
            _ => self.atom(),
        }
    }

    pub(crate) fn atom(&mut self) -> Parsed<Span> {
        let span = self.here();
        match self.peek() {
            Token::Int => {
                self.advance();
                let Ok(value) = self.text(span).parse() else {
                    self.report(self.wrong(span, "this integer does not fit 64 bits"));
                    return Err(Failed);
                };
                Ok(self.push(span, || NodeKind::Literal(Value::Int(value))))
            }
            Token::Real => {
                self.advance();
                let value = self.finite(span)?;
                Ok(self.push(span, || NodeKind::Literal(Value::Real(value))))
            }
            Token::Quoted => {
                let name = self.reference()?;
                Ok(self.push(span, || NodeKind::Label(name.into())))
            }
            Token::Word if self.is_operator_of_properties() => self.operator_of_properties(),
            Token::Lt | Token::LeftBracket if self.is_operator_of_properties() => {
                self.operator_of_properties()
            }
            Token::Word => self.word(span),
            Token::LeftParen => {
                self.advance();
                let inner = self.expression()?;
                self.expect(Token::RightParen)?;
                Ok(inner)
            }
            _ => Err(self.expected("an expression")),
        }
    }

    /// Returns the double nearest to a literal with a point or an exponent. Lowering reads its exact
    /// value, which is checked here.
    fn finite(&mut self, span: Span) -> Parsed<f64> {
        self.exact(span).map(|exact| Real::Finite(exact).to_f64())
    }

    /// Returns the exact value of a literal with a point or an exponent.
    pub(crate) fn exact(&mut self, span: Span) -> Parsed<Ratio> {
        let text = shortened(self.text(span)).into_owned();
        let diagnostic = match decimal(self.text(span)) {
            Ok(exact) if exact.to_f64().is_some_and(f64::is_finite) => return Ok(exact),
            Ok(_) => {
                let message = format!("`{text}` is too large for a double");
                self.wrong(span, message).help("the largest is about 1.8e308")
            }
            Err(reason) => self.wrong(span, format!("`{text}` cannot be computed with: {reason}")),
        };
        self.report(diagnostic);
        Err(Failed)
    }

    /// Parses an atom that starts with a word: a literal, a name or a function.
    fn word(&mut self, span: Span) -> Parsed<Span> {
        match self.text(span) {
            word @ ("true" | "false") => {
                self.advance();
                Ok(self.push(span, || NodeKind::Literal(Value::Bool(word == "true"))))
            }
            "func" => self.old_function(span),
            "min" | "max" => {
                self.advance();
                self.call(span)
            }
            word @ ("P" | "Pmin" | "Pmax" | "R" | "Rmin" | "Rmax" | "S" | "E" | "A" | "filter")
                if matches!(
                    self.peek_at(1),
                    Token::Ge
                        | Token::Gt
                        | Token::Le
                        | Token::Lt
                        | Token::Eq
                        | Token::LeftBracket
                        | Token::LeftParen
                ) =>
            {
                let message = format!("the operator `{word}` of properties cannot stand in an expression");
                let help = "a target or an objective is only the formula within the brackets of a property";
                self.report(self.wrong(span, message).help(help));
                Err(Failed)
            }
            word @ ("X" | "F" | "G")
                if matches!(
                    self.peek_at(1),
                    Token::Word | Token::LeftParen | Token::Quoted | Token::Bang | Token::Int
                ) =>
            {
                let message = format!("the temporal operator `{word}` cannot stand in an expression");
                let help = "temporal formulas are allowed in properties, `P>=1 [ … ]`, and in objectives";
                self.report(self.wrong(span, message).help(help));
                Err(Failed)
            }
            _ => {
                self.word_that_names("the name of a variable, constant or formula")?;
                let name = self.text(span);
                // Behind a number of steps the formula may begin with a bracket, as in `F<=T (x=1)`.
                let is_call = !self.in_steps || Function::named(name).is_some();
                if is_call && self.peek() == Token::LeftParen {
                    return self.call(span);
                }
                Ok(self.push(span, || NodeKind::Name(name.into())))
            }
        }
    }

    /// Parses the rest of `f(e, …)` after the name.
    fn call(&mut self, name: Span) -> Parsed<Span> {
        self.expect(Token::LeftParen)?;
        let function = self.named(name);
        self.arguments(name, function)
    }

    /// Parses `func(f, e, …)`.
    fn old_function(&mut self, start: Span) -> Parsed<Span> {
        self.advance();
        self.expect(Token::LeftParen)?;
        let function = self.function_name()?;
        self.expect(Token::Comma)?;
        self.arguments(start, function)
    }

    /// Parses the arguments of a call, and its closing bracket.
    fn arguments(&mut self, start: Span, function: Ident) -> Parsed<Span> {
        let count = self.list(Self::expression)?.len() as u32;
        self.expect(Token::RightParen)?;
        Ok(self.push(start.to(self.before()), || NodeKind::Call(Box::new(function), count)))
    }

    /// Parses a name, or one of the two functions that are keywords.
    pub(crate) fn function_name(&mut self) -> Parsed<Ident> {
        let span = self.here();
        if self.at_word("min") || self.at_word("max") {
            self.advance();
            return Ok(self.named(span));
        }
        self.ident("a name")
    }
}
