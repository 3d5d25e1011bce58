//! Compositions of modules: `system … endsystem`.

use super::parser::{Failed, MAX_TREE_NESTING, Parsed, Parser};
use crate::ast::{Ident, Span, System, SystemKind};
use crate::token::Token;

/// The operators between two compositions.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Join {
    Full,
    Interleaved,
    Parallel,
}

impl Parser<'_> {
    /// Parses `system … endsystem`.
    pub(super) fn system(&mut self) -> Parsed<System> {
        self.advance();
        if self.peek() == Token::Quoted {
            let span = self.here();
            self.report(self.unsupported(span, "named `system` blocks are not supported"));
            return Err(Failed);
        }
        let system = self.composition()?;
        self.expect_word("endsystem")?;
        Ok(system)
    }

    fn composition(&mut self) -> Parsed<System> {
        self.nested_to(MAX_TREE_NESTING, Self::composition_inner)
    }

    /// Parses operands joined by one operator; different operators need brackets.
    fn composition_inner(&mut self) -> Parsed<System> {
        let start = self.here();
        let first = self.hidden_or_renamed()?;
        let Some(join) = self.join_here() else { return Ok(first) };
        let kind = if join == Join::Parallel {
            self.advance();
            self.advance();
            let actions = self.actions(Token::RightBracket)?;
            self.expect(Token::Or)?;
            SystemKind::Parallel(Box::new(first), actions, Box::new(self.hidden_or_renamed()?))
        } else {
            self.operands(first, join)?
        };
        if self.join_here().is_some() {
            let diagnostic =
                self.wrong(self.here(), "compositions of different kinds, or several `|[…]|`, in a row");
            self.report(diagnostic.help("put brackets around the parts"));
            return Err(Failed);
        }
        Ok(System { kind, span: start.to(self.before()) })
    }

    fn operands(&mut self, first: System, join: Join) -> Parsed<SystemKind> {
        let mut operands = vec![first];
        while self.join_here() == Some(join) {
            for _ in 0..if join == Join::Full { 2 } else { 3 } {
                self.advance();
            }
            operands.push(self.hidden_or_renamed()?);
        }
        Ok(if join == Join::Full { SystemKind::Full(operands) } else { SystemKind::Interleaved(operands) })
    }

    /// Returns the next operator: `||`, `|||` or `|[`.
    fn join_here(&self) -> Option<Join> {
        match (self.peek(), self.peek_at(1), self.peek_at(2)) {
            (Token::Or, Token::Or, Token::Or) => Some(Join::Interleaved),
            (Token::Or, Token::Or, _) => Some(Join::Full),
            (Token::Or, Token::LeftBracket, _) => Some(Join::Parallel),
            _ => None,
        }
    }

    /// Parses a module or a composition in brackets, with the hidings and renamings that follow it.
    fn hidden_or_renamed(&mut self) -> Parsed<System> {
        let start = self.here();
        let mut system = if self.eat(Token::LeftParen) {
            let inner = self.composition()?;
            self.expect(Token::RightParen)?;
            inner
        } else {
            let name = self.name_outside("the name of a module")?;
            System { kind: SystemKind::Module(name.name), span: name.span }
        };
        for suffix in 0.. {
            if !matches!(self.peek(), Token::Slash | Token::LeftBrace) {
                break;
            }
            if suffix == MAX_TREE_NESTING {
                self.report(self.wrong(self.here(), "too many hidings and renamings in a row"));
                return Err(Failed);
            }
            system = self.suffix(system, start)?;
        }
        Ok(system)
    }

    /// Parses `/ {a,b}` or `{a<-b,c<-d}`.
    fn suffix(&mut self, system: System, start: Span) -> Parsed<System> {
        let kind = if self.eat(Token::Slash) {
            self.expect(Token::LeftBrace)?;
            SystemKind::Hide(Box::new(system), self.actions(Token::RightBrace)?)
        } else {
            self.expect(Token::LeftBrace)?;
            let renames = self.list(|p| {
                let old = p.action()?;
                p.rename_arrow()?;
                Ok((old, p.action()?))
            })?;
            self.expect(Token::RightBrace)?;
            SystemKind::Rename(Box::new(system), renames)
        };
        Ok(System { kind, span: start.to(self.before()) })
    }

    /// Parses `<-`, which the lexer cannot distinguish from the two operators of `x<-1`.
    fn rename_arrow(&mut self) -> Parsed<()> {
        if (self.peek(), self.peek_at(1)) != (Token::Lt, Token::Minus) {
            return Err(self.expected("`<-`"));
        }
        self.advance();
        self.advance();
        Ok(())
    }

    /// Parses `a,b,…` and the closing token.
    fn actions(&mut self, close: Token) -> Parsed<Vec<Ident>> {
        let actions = self.list(Self::action)?;
        self.expect(close)?;
        Ok(actions)
    }
}
