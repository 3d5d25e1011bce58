//! Expressions, with PRISM's precedence.

use super::{Atom, Failed, Maker, Parsed, Parser};
use crate::lang::ast::{ATOM_LEVEL, BinaryOp, Ident, NEG_LEVEL, NOT_LEVEL, Span};
use crate::lang::token::Token;

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

impl<M: Maker> Parser<'_, M> {
    /// Parses `c ? e : c ? e : … e`, or anything that binds tighter.
    pub(crate) fn expression(&mut self) -> Parsed<M::Expr> {
        self.nested(Self::conditional)
    }

    fn conditional(&mut self) -> Parsed<M::Expr> {
        let start = self.here();
        let first = self.binary(0)?;
        if self.peek() != Token::Question {
            return Ok(first);
        }
        let (mut cases, mut condition) = (Vec::new(), first);
        while self.eat(Token::Question) {
            let then = self.expression()?;
            self.expect(Token::Colon)?;
            cases.push((condition, then));
            condition = self.binary(0)?;
        }
        let span = start.to(self.before());
        Ok(self.maker.ite(cases, condition, span))
    }

    /// Parses a chain of operators that bind at least as tightly as `least`.
    pub(crate) fn binary(&mut self, least: u8) -> Parsed<M::Expr> {
        let start = self.here();
        let mut left = self.prefix(least)?;
        // Operands to the right of the current level, the level of the last operator, and the end
        // of the last operand.
        let (mut rest, mut level, mut end) = (Vec::new(), ATOM_LEVEL, self.before());
        while let Some(op) = operator(self.peek()).filter(|op| op.level() >= least) {
            let sign = self.peek();
            self.advance();
            self.foreign_operator(sign);
            if level != op.level() {
                left = self.chained(left, std::mem::take(&mut rest), start.to(end));
            }
            let right =
                if op == BinaryOp::Pow { self.exponent(level)? } else { self.binary(op.level() + 1)? };
            rest.push((op, right));
            (level, end) = (op.level(), self.before());
        }
        Ok(self.chained(left, rest, start.to(end)))
    }

    fn chained(&mut self, left: M::Expr, rest: Vec<(BinaryOp, M::Expr)>, span: Span) -> M::Expr {
        if rest.is_empty() { left } else { self.maker.chain(left, rest, span) }
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
    fn exponent(&mut self, level: u8) -> Parsed<M::Expr> {
        let operator = self.before();
        if level == BinaryOp::Pow.level() {
            let help = "put brackets around one of the two powers";
            self.report(self.wrong(operator, "`^` cannot be chained without brackets").help(help));
        }
        self.prefix(NEG_LEVEL)
    }

    /// Parses signs and negations before an operand.
    fn prefix(&mut self, least: u8) -> Parsed<M::Expr> {
        let start = self.here();
        match self.peek() {
            Token::Bang => {
                self.advance();
                if least > NOT_LEVEL {
                    let message = "`!` binds less tightly than the operator before it";
                    self.report(self.wrong(start, message).help("write the negation in brackets: `(!…)`"));
                }
                let operand = self.nested(|p| p.binary(NOT_LEVEL))?;
                let span = start.to(self.before());
                Ok(self.maker.not(operand, span))
            }
            Token::Minus => {
                self.advance();
                let operand = self.nested(|p| p.binary(NEG_LEVEL))?;
                let span = start.to(self.before());
                Ok(self.maker.neg(operand, span))
            }
            _ => self.atom(),
        }
    }

    pub(crate) fn atom(&mut self) -> Parsed<M::Expr> {
        let span = self.here();
        let atom = match self.peek() {
            Token::Int => self.integer(span)?,
            Token::Real => self.real(span)?,
            Token::Quoted => Atom::Label(self.label_reference()?),
            Token::Word => return self.word(span),
            Token::LeftParen => {
                self.advance();
                let inner = self.expression()?;
                self.expect(Token::RightParen)?;
                return Ok(inner);
            }
            _ => return Err(self.expected("an expression")),
        };
        Ok(self.maker.atom(atom, span))
    }

    fn integer(&mut self, span: Span) -> Parsed<Atom<'static>> {
        self.advance();
        let Ok(value) = self.text(span).parse() else {
            self.report(self.wrong(span, "this integer does not fit 64 bits"));
            return Err(Failed);
        };
        Ok(Atom::Int(value))
    }

    fn real(&mut self, span: Span) -> Parsed<Atom<'static>> {
        self.advance();
        self.finite(span).map(Atom::Real)
    }

    /// Returns the value of a literal with a point or an exponent.
    pub(crate) fn finite(&mut self, span: Span) -> Parsed<f64> {
        match self.text(span).parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => {
                let message = format!("`{}` is too large for a double", self.text(span));
                self.report(self.wrong(span, message).help("the largest is about 1.8e308"));
                Err(Failed)
            }
        }
    }

    /// Parses an atom that starts with a word: a literal, a name or a function.
    fn word(&mut self, span: Span) -> Parsed<M::Expr> {
        let atom = match self.text(span) {
            "true" => Atom::Bool(true),
            "false" => Atom::Bool(false),
            "func" => return self.old_function(span),
            name @ ("min" | "max") => {
                self.advance();
                return self.call(Ident { name: name.to_owned(), span });
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
                return Err(Failed);
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
                return Err(Failed);
            }
            _ => {
                let ident = self.ident("the name of a variable, constant or formula")?;
                if self.peek() == Token::LeftParen {
                    return self.call(ident);
                }
                return Ok(self.maker.atom(Atom::Name(&ident.name), span));
            }
        };
        self.advance();
        Ok(self.maker.atom(atom, span))
    }

    /// Parses the rest of `f(e, …)` after the name.
    fn call(&mut self, function: Ident) -> Parsed<M::Expr> {
        let start = function.span;
        self.expect(Token::LeftParen)?;
        let arguments = self.arguments()?;
        let span = start.to(self.before());
        Ok(self.maker.call(function, arguments, span))
    }

    /// Parses `func(f, e, …)`.
    fn old_function(&mut self, start: Span) -> Parsed<M::Expr> {
        self.advance();
        self.expect(Token::LeftParen)?;
        let function = self.function_name()?;
        self.expect(Token::Comma)?;
        let arguments = self.arguments()?;
        let span = start.to(self.before());
        Ok(self.maker.call(function, arguments, span))
    }

    /// Parses a name, or one of the two functions that are keywords.
    pub(crate) fn function_name(&mut self) -> Parsed<Ident> {
        let span = self.here();
        if self.at_word("min") || self.at_word("max") {
            self.advance();
            return Ok(Ident { name: self.text(span).to_owned(), span });
        }
        self.ident("a name")
    }

    fn arguments(&mut self) -> Parsed<Vec<M::Expr>> {
        let mut arguments = vec![self.expression()?];
        while self.eat(Token::Comma) {
            arguments.push(self.expression()?);
        }
        self.expect(Token::RightParen)?;
        Ok(arguments)
    }
}
