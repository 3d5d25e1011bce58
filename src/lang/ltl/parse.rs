//! Parser of formulas, with PRISM's precedence: `U`, `W`, `R` and `M` bind least. Next are `X`, `F`
//! and `G`, whose operand extends as far as possible, then the operators of expressions.
//!
//! PRISM requires brackets around an operand of `&`, `|`, `!` or `=>` that has a temporal operator.
//! Here they are optional where the text is unambiguous: at the end of a bracket, as in
//! `F (a & F b)`.

use std::sync::Arc;

use super::formula::{Formula, FormulaKind, Steps};
use crate::ast::{BinaryOp, Expr, NOT_LEVEL};
use crate::parse::{Failed, MAX_TREE_NESTING, Parsed, Parser, operator};
use crate::token::Token;
use meliora_base::error::{Result, SourceFile};

/// Maximum number of operators of a formula outside of its state formulas.
pub(crate) const MOST_OPERATORS: usize = 1_000;

/// Parses a text that is one formula.
///
/// # Errors
/// A syntax error; operators that are not supported; a formula that is too large.
pub fn parse_formula(source: &Arc<SourceFile>) -> Result<Formula> {
    let mut parser = Parser::new(source);
    let parsed = parser.temporal_formula().and_then(|f| parser.expect(Token::End).map(|_| f));
    parser.finish_parsed(parsed)
}

/// Operators before their operand, and between two operands.
const PREFIX: [&str; 3] = ["X", "F", "G"];
const INFIX: [&str; 4] = ["U", "W", "R", "M"];

/// The signs of other tools, and ours.
const FOREIGN: [(&str, &str); 4] = [("->", "=>"), ("<->", "<=>"), ("[]", "G"), ("<>", "F")];

impl Parser<'_> {
    /// Parses a formula with at most `MOST_OPERATORS` operators.
    pub(crate) fn temporal_formula(&mut self) -> Parsed<Formula> {
        let formula = self.unbounded_formula()?;
        let (mut operators, mut open) = (0, vec![&formula]);
        while let Some(next) = open.pop() {
            let operands = next.operands();
            operators += operands.len().saturating_sub(1).max(usize::from(!operands.is_empty()));
            open.extend(operands);
        }
        if operators > MOST_OPERATORS {
            let message = format!("a formula of {operators} operators, more than {MOST_OPERATORS}");
            let help = "give names to state formulas with `formula` or `label` in the model";
            self.report(self.wrong(formula.span, message).label("too large").help(help));
            return Err(Failed);
        }
        Ok(formula)
    }

    /// Parses `φ U ψ`, or anything that binds tighter.
    fn unbounded_formula(&mut self) -> Parsed<Formula> {
        self.nested_to(MAX_TREE_NESTING, |p| {
            let start = p.here();
            let left = p.unary(true)?;
            let Some(word) = p.infix() else {
                return if p.foreign_sign().is_some() { Err(p.foreign()) } else { Ok(left) };
            };
            p.advance();
            let steps = p.steps(word)?;
            let right = p.unary(true)?;
            if p.infix().is_some() {
                let message = format!("`{word}` cannot be chained without brackets");
                p.report(p.wrong(p.here(), message).help("write `(a U b) U c` or `a U (b U c)`"));
                return Err(Failed);
            }
            let span = start.to(p.before());
            let (left, right) = (Box::new(left), Box::new(right));
            let kind = match word {
                "U" => FormulaKind::Until(steps, left, right),
                "W" => FormulaKind::Weak(steps, left, right),
                "R" => FormulaKind::Release(steps, left, right),
                _ => FormulaKind::Strong(left, right),
            };
            Ok(Formula { kind, span })
        })
    }

    /// Returns the operator after an operand.
    fn infix(&self) -> Option<&'static str> {
        let found = INFIX.into_iter().find(|word| self.at_word(word))?;
        let is_name = found == "M" && !self.rest().nth(1).is_some_and(begins_operand);
        (!is_name).then_some(found)
    }

    /// Returns all tokens from the start of an operand on, each with its temporal operator.
    ///
    /// PRISM has no `M`, so models use the name: it is an operator between two operands alone. `R` is one
    /// behind an operand; elsewhere it begins a reward. The formulas of operators of properties, in square
    /// brackets, are not part of the operand.
    fn operators(&self) -> impl Iterator<Item = (Token, Option<&'static str>)> + '_ {
        let (mut ended, mut nested) = (false, 0_usize);
        self.rest().zip(self.rest().skip(1).chain([(Token::End, "")])).map(move |((token, word), next)| {
            let operator = match token {
                Token::Word => PREFIX.into_iter().chain(INFIX).find(|o| *o == word),
                _ => None,
            };
            match token {
                Token::LeftBracket => nested += 1,
                Token::RightBracket => nested = nested.saturating_sub(1),
                _ => {}
            }
            let operator = operator.filter(|o| match *o {
                _ if nested > 0 => false,
                "M" => ended && begins_operand(next),
                "R" => ended,
                _ => true,
            });
            ended = operator.is_none()
                && matches!(
                    token,
                    Token::Word
                        | Token::Int
                        | Token::Real
                        | Token::Quoted
                        | Token::RightParen
                        | Token::RightBracket
                );
            (token, operator)
        })
    }

    /// Parses `X φ`, `F φ`, `G φ`, or anything that binds tighter; `bare` permits temporal operands
    /// without brackets.
    fn unary(&mut self, bare: bool) -> Parsed<Formula> {
        match self.prefix_word() {
            None if self.foreign_sign().is_some() => Err(self.foreign()),
            None if self.is_state_formula() => {
                let start = self.here();
                let e = self.tree(Self::expression)?;
                Ok(Formula { span: start.to(self.before()), kind: FormulaKind::State(e) })
            }
            None => self.boolean(0, bare),
            Some(word) => self.prefixed(word, |p| p.unary(false)),
        }
    }

    fn prefix_word(&self) -> Option<&'static str> {
        PREFIX.into_iter().find(|word| self.at_word(word))
    }

    fn prefixed(
        &mut self,
        word: &'static str,
        operand: impl FnOnce(&mut Self) -> Parsed<Formula>,
    ) -> Parsed<Formula> {
        let start = self.advance();
        let steps = self.steps(word)?;
        if matches!(self.peek(), Token::Semicolon | Token::End | Token::RightParen | Token::RightBracket) {
            let operator = start.to(self.before());
            let text = self.text(operator);
            let diagnostic = self.wrong(operator, format!("`{text}` has no operand"));
            self.report(diagnostic.label("expected a condition").help(format!("write `{text} (condition)`")));
            return Err(Failed);
        }
        let operand = Box::new(self.nested_to(MAX_TREE_NESTING, operand)?);
        let span = start.to(self.before());
        let kind = match word {
            "X" => FormulaKind::Next(operand),
            "F" => FormulaKind::Eventually(steps, operand),
            _ => FormulaKind::Always(steps, operand),
        };
        Ok(Formula { kind, span })
    }

    /// Returns true if no temporal operator comes before the end of this bracket or the next `U`,
    /// `W`, `R` or `M`.
    fn is_state_formula(&self) -> bool {
        let mut depth = 0_usize;
        for (token, operator) in self.operators() {
            match (token, operator) {
                (Token::End | Token::Semicolon, _) => return true,
                (Token::LeftParen | Token::LeftBracket, _) => depth += 1,
                (Token::RightParen | Token::RightBracket, _) if depth == 0 => return true,
                (Token::RightParen | Token::RightBracket, _) => depth -= 1,
                (_, Some(word)) => return depth == 0 && INFIX.contains(&word),
                _ => {}
            }
        }
        true
    }

    /// Returns true if the bracket that opens `ahead` tokens from here contains a temporal
    /// operator.
    fn brackets_formula(&self, ahead: usize) -> bool {
        let mut depth = 0_usize;
        for (token, operator) in self.operators().skip(ahead) {
            match (token, operator) {
                (Token::End | Token::Semicolon, _) => return false,
                (Token::LeftParen | Token::LeftBracket, _) => depth += 1,
                (Token::RightParen | Token::RightBracket, _) if depth <= 1 => return false,
                (Token::RightParen | Token::RightBracket, _) => depth -= 1,
                (_, Some(_)) => return true,
                _ => {}
            }
        }
        false
    }

    /// Parses a chain of `<=>`, `=>`, `|` and `&` that bind at least as tightly as `least`.
    fn boolean(&mut self, least: u8, bare: bool) -> Parsed<Formula> {
        let start = self.here();
        let mut left = self.operand(bare)?;
        let mut last = None;
        while let Some(op) =
            operator(self.peek()).filter(|op| (least..=BinaryOp::And.level()).contains(&op.level()))
        {
            let sign = self.peek();
            let place = self.advance();
            self.foreign_operator(sign);
            if last == Some(op) && matches!(op, BinaryOp::Implies | BinaryOp::Iff) {
                let message = format!("`{}` cannot be chained without brackets", op.symbol());
                self.report(self.wrong(place, message).help("put brackets around one of the two"));
                return Err(Failed);
            }
            let right = self.boolean(op.level() + 1, bare)?;
            // Brackets around the operands belong to the text of the whole.
            let span = start.to(self.before());
            left = Formula { kind: joined(left, op, right, last == Some(op)), span };
            last = Some(op);
        }
        Ok(left)
    }

    /// Returns the sign of another tool that stands here, and ours.
    fn foreign_sign(&self) -> Option<(&'static str, &'static str)> {
        let text = self.rest_of_text();
        FOREIGN.into_iter().find(|(theirs, _)| text.starts_with(theirs))
    }

    fn foreign(&mut self) -> Failed {
        let (theirs, ours) = self.foreign_sign().unwrap_or_default();
        let diagnostic = self.wrong(self.here(), format!("`{theirs}` is not an operator"));
        self.report(diagnostic.label(format!("write `{ours}`")));
        Failed
    }

    /// Parses a bracket that contains a temporal operator, its negation, or an expression.
    fn operand(&mut self, bare: bool) -> Parsed<Formula> {
        let start = self.here();
        let bangs = self.rest().take_while(|(token, _)| *token == Token::Bang).count();
        let (behind, word) = self.rest().nth(bangs).unwrap_or((Token::End, ""));
        let is_bracket = behind == Token::LeftParen && self.brackets_formula(bangs);
        let is_bare = behind == Token::Word && PREFIX.contains(&word);
        if !is_bracket && !is_bare {
            let e = self.tree(|p| p.binary(NOT_LEVEL))?;
            return Ok(Formula { span: start.to(self.before()), kind: FormulaKind::State(e) });
        }
        (0..bangs).for_each(|_| {
            self.advance();
        });
        let mut formula = if is_bracket { self.bracketed()? } else { self.bare(bare)? };
        // Two negations cancel.
        if bangs % 2 == 1 {
            formula = Formula { kind: FormulaKind::Not(Box::new(formula)), span: start.to(self.before()) };
        }
        Ok(formula)
    }

    fn bracketed(&mut self) -> Parsed<Formula> {
        self.advance();
        let formula = self.unbounded_formula()?;
        self.expect(Token::RightParen)?;
        let follows = operator(self.peek()).filter(|op| op.level() > BinaryOp::And.level());
        if follows.is_some() || self.peek() == Token::Question {
            let message = format!("a temporal formula cannot be an operand of `{}`", self.text(self.here()));
            self.report(
                self.wrong(self.here(), message).label("only `!`, `&`, `|`, `=>` and `<=>` join formulas"),
            );
            return Err(Failed);
        }
        Ok(formula)
    }

    /// Parses `F b` without brackets after `&`, `|`, `=>` or `!`; accepted only before the end of a
    /// bracket or of the text.
    fn bare(&mut self, allowed: bool) -> Parsed<Formula> {
        let start = self.here();
        let Some(word) = self.prefix_word() else { return Err(self.expected("a formula")) };
        let formula = self.prefixed(word, |p| p.bare_operand())?;
        let ends =
            matches!(self.peek(), Token::End | Token::Semicolon | Token::RightParen | Token::RightBracket);
        if allowed && ends {
            return Ok(formula);
        }
        let text = self.text(start.to(self.before()));
        let message = format!("`{word}` can be read in more than one way here");
        let help = format!("put brackets around the parts that belong together, such as `({text})`");
        self.report(self.wrong(start, message).label("needs brackets").help(help));
        Err(Failed)
    }

    fn bare_operand(&mut self) -> Parsed<Formula> {
        match self.prefix_word() {
            Some(word) => self.prefixed(word, |p| p.bare_operand()),
            None => self.operand(false),
        }
    }

    /// Parses an optional step bound after an operator, such as `<=10` or `[2,5]`.
    fn steps(&mut self, word: &str) -> Parsed<Steps> {
        let start = self.here();
        let mut steps = Steps::default();
        match self.peek() {
            // The players of a nested operator.
            Token::Lt | Token::LeftBracket if self.is_operator_of_properties() => return Ok(steps),
            sign @ (Token::Le | Token::Lt) => {
                self.advance();
                steps.most = Some((self.step_bound()?, sign == Token::Lt));
            }
            sign @ (Token::Ge | Token::Gt) => {
                self.advance();
                steps.least = Some((self.step_bound()?, sign == Token::Gt));
            }
            Token::Eq => {
                self.advance();
                let bound = self.step_bound()?;
                steps = Steps { least: Some((bound.clone(), false)), most: Some((bound, false)) };
            }
            Token::LeftBracket => {
                self.advance();
                steps.least = Some((self.tree(Self::expression)?, false));
                self.expect(Token::Comma)?;
                steps.most = Some((self.tree(Self::expression)?, false));
                self.expect(Token::RightBracket)?;
            }
            Token::LeftBrace => return Err(self.bounded_by_rewards(start)),
            _ => return Ok(steps),
        }
        if matches!(word, "X" | "M") {
            let span = start.to(self.before());
            let message = format!("`{word}` with a bound on the number of steps is not supported");
            let help = "`F`, `G`, `U`, `W` and `R` accept such bounds";
            self.report(self.unsupported(span, message).help(help));
            return Err(Failed);
        }
        Ok(steps)
    }

    /// Parses a number of steps; one in front of `+`, `-`, `*` or `/` has the operator, too.
    fn step_bound(&mut self) -> Parsed<Expr> {
        self.in_steps = true;
        let bound = self.tree(|p| p.binary(BinaryOp::Add.level()));
        self.in_steps = false;
        bound
    }
}

/// Returns true if a token can follow `M` as an operator.
fn begins_operand((token, word): (Token, &str)) -> bool {
    match token {
        Token::Word => !["U", "W", "R"].contains(&word),
        _ => matches!(token, Token::Int | Token::Real | Token::Quoted | Token::LeftParen | Token::Bang),
    }
}

/// Returns `left op right`, flattened if it continues a chain of `&` or `|`.
fn joined(left: Formula, op: BinaryOp, right: Formula, goes_on: bool) -> FormulaKind {
    match (op, left.kind) {
        (BinaryOp::And, FormulaKind::And(mut all)) if goes_on => {
            all.push(right);
            FormulaKind::And(all)
        }
        (BinaryOp::Or, FormulaKind::Or(mut all)) if goes_on => {
            all.push(right);
            FormulaKind::Or(all)
        }
        (op, kind) => {
            let left = Formula { kind, span: left.span };
            match op {
                BinaryOp::And => FormulaKind::And(vec![left, right]),
                BinaryOp::Or => FormulaKind::Or(vec![left, right]),
                BinaryOp::Implies => FormulaKind::Implies(Box::new(left), Box::new(right)),
                _ => FormulaKind::Iff(Box::new(left), Box::new(right)),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meliora_base::error::Error;

    fn read(text: &str) -> std::result::Result<Formula, String> {
        parse_formula(&SourceFile::new("formula", text)).map_err(|e| match e {
            Error::Input(all) => all[0].message.clone(),
            other => other.to_string(),
        })
    }

    #[test]
    fn brackets_may_be_left_out_where_nothing_can_be_misread() {
        for (short, long) in [
            ("F (a & F b)", "F (a & (F b))"),
            ("G (a => F b)", "G (a => (F b))"),
            ("!c U b", "(!c) U (b)"),
            ("F G a", "F (G a)"),
            ("G !p", "G (!p)"),
            ("F a & b", "F (a & b)"),
            ("a & b U c | d", "(a & b) U (c | d)"),
            ("!(F a) & b", "(!(F a)) & b"),
            ("!!(F a)", "F a"),
            ("F<=3 x=1", "F<=3 (x=1)"),
            ("x=1 & (F y>2) & (G z)", "(x=1) & (F (y>2)) & (G (z))"),
            ("a => G F b", "a => (G (F b))"),
            ("(a | X b) U c", "(a | (X b)) U c"),
            ("!c M b", "(!c) M (b)"),
            ("F<=3 M", "F<=3 (M)"),
            ("F M=2 & b", "F ((M=2) & b)"),
            ("a M M", "(a) M (M)"),
            ("M U b", "(M) U (b)"),
            ("(M>1) M F b", "(M>1) M (F b)"),
        ] {
            assert_eq!(read(short), read(long), "{short}");
            assert!(read(short).is_ok(), "{short}: {:?}", read(short));
        }
    }

    #[test]
    fn what_can_be_misread_or_has_no_meaning_is_refused() {
        for text in [
            "F a & F b",
            "G a => F b",
            "a & F b & c",
            "a & F b U c",
            "a U b U c",
            "(F a) => (F b) => (F c)",
            "(F a) + 1 = 2",
            "(F a) ? b : c",
            "x = (F a)",
            "X<=2 a",
            "a M<=2 b",
            "a M b M c",
            "a M",
            "a && F b",
            "a -> F b",
            "a <-> F b",
            "a -> b U c",
            "[] a",
            "F <> a",
            "<>(a)",
            "F<= a",
            "F",
            "a U",
            "(F a",
            "F [1,2 a",
            "G (P>=1 [ F a ])",
        ] {
            assert!(read(text).is_err(), "{text}: {:?}", read(text));
        }
    }

    #[test]
    fn size_and_depth_are_bounded() {
        let many = format!("(F a){}", " & (F a)".repeat(10_000));
        assert!(
            read(&many).unwrap_err().contains("10000 operators")
                || read(&many).unwrap_err().contains("operators")
        );
        let chain = format!("(F a){}", " => (F a)".repeat(10_000));
        assert!(read(&chain).is_err());
        for opening in ["(", "F ", "!(F ", "X ", "(a & F "] {
            let deep = format!("{}a", opening.repeat(10_000));
            assert!(read(&deep).unwrap_err().contains("nested"), "{opening}");
        }
    }
}
