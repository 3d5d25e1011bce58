//! Modules: variables, commands, updates, renaming.

use super::item::ITEM_WORDS;
use super::parser::{Failed, Parsed, Parser};
use crate::ast::{Assignment, Branch, Command, Expr, Ident, Item, Module, RenamedModule, Span, VarDecl};
use crate::token::{Token, is_property_operator};

impl Parser<'_> {
    /// Parses `module … endmodule`.
    pub(super) fn module(&mut self) -> Parsed<Item> {
        let start = self.advance();
        let name = self.name_outside("the name of a module")?;
        if self.eat(Token::Eq) {
            return self.renamed(name);
        }
        let mut module = Module { name, variables: Vec::new(), commands: Vec::new() };
        loop {
            let before = self.tokens.taken();
            let slip = self.peek_at(1) != Token::Colon && self.slip(&["endmodule"]).is_some();
            if slip || self.at_word("endmodule") {
                self.advance();
                return Ok(Item::Module(Box::new(module)));
            }
            // A keyword before a colon is a variable with a wrong name: that is reported below.
            let item = ITEM_WORDS.contains(&self.text(self.here())) && self.peek_at(1) != Token::Colon;
            if self.peek() == Token::End || item {
                let diagnostic =
                    self.wrong(self.here(), "expected `endmodule`").label("expected `endmodule`");
                self.report(diagnostic.related(start.range(), "this module is not closed"));
                return if self.peek() == Token::End {
                    Err(Failed)
                } else {
                    Ok(Item::Module(Box::new(module)))
                };
            }
            if self.module_part(&mut module).is_err() {
                if self.tokens.taken() == before {
                    self.advance();
                }
                self.recover(&["endmodule", "module"]);
            }
        }
    }

    fn module_part(&mut self, module: &mut Module) -> Parsed<()> {
        if self.peek() == Token::LeftBracket {
            module.commands.push(self.command()?.span);
            return Ok(());
        }
        if self.at_word("invariant") {
            let span = self.advance();
            self.report(self.unsupported(span, "invariants are not supported"));
            self.skip_past("endinvariant");
            return Ok(());
        }
        if self.peek() != Token::Word {
            return Err(self.expected("a variable, a command or `endmodule`"));
        }
        let variable = self.declaration()?;
        if !module.commands.is_empty() {
            let help = "declare the variables of a module before its commands";
            self.report(self.wrong(variable.span, "a variable declared after a command").help(help));
        }
        module.variables.push(variable);
        Ok(())
    }

    /// Parses `x : [low..high] init e;` or `x : bool init e;`.
    pub(super) fn declaration(&mut self) -> Parsed<VarDecl> {
        let name = self.ident("the name of a variable")?;
        let start = name.span;
        self.expect(Token::Colon)?;
        let range = self.variable_type()?;
        let init = if self.eat_word("init") { Some(self.expression()?) } else { None };
        let end = self.expect(Token::Semicolon)?;
        Ok(VarDecl { name, range, init, span: start.to(end) })
    }

    fn variable_type(&mut self) -> Parsed<Option<(Span, Span)>> {
        if self.eat(Token::LeftBracket) {
            let low = self.expression()?;
            self.expect(Token::Dots)?;
            let high = self.expression()?;
            self.expect(Token::RightBracket)?;
            return Ok(Some((low, high)));
        }
        if self.eat_word("bool") {
            return Ok(None);
        }
        let span = self.here();
        let (what, help) = match self.text(span) {
            "int" => ("unbounded integers", "give the variable a range: `[0..10]`"),
            "clock" => ("clocks", "models of type `mdp`, `dtmc` and `smg` are supported"),
            "double" => ("variables of type `double`", "a variable is `bool` or has a range: `[0..10]`"),
            "array" => ("arrays", "a variable is `bool` or has a range: `[0..10]`"),
            _ => return Err(self.expected("a range `[low..high]` or `bool`")),
        };
        self.report(self.unsupported(span, format!("{what} are not supported")).help(help));
        // Recorded; the rest of the declaration is parsed like that of a Boolean.
        self.advance();
        Ok(None)
    }

    /// Parses `[a] guard -> updates;`.
    pub(super) fn command(&mut self) -> Parsed<Command> {
        let start = self.expect(Token::LeftBracket)?;
        let action = if self.peek() == Token::RightBracket { None } else { Some(self.action()?) };
        self.expect(Token::RightBracket)?;
        let guard = self.tree(Self::expression)?;
        self.expect(Token::Arrow)?;
        let mut branches = vec![self.branch()?];
        while self.eat(Token::Plus) {
            branches.push(self.branch()?);
        }
        if self.peek() == Token::Comma {
            let diagnostic = self.wrong(self.here(), "`,` cannot join updates").label("write `&`");
            self.report(diagnostic.help("several updates are written `(x'=1) & (y'=2)`"));
            return Err(Failed);
        }
        branches.shrink_to_fit();
        let end = self.expect(Token::Semicolon)?;
        self.check_probabilities_given(&branches);
        Ok(Command { action, guard, branches, span: start.to(end) })
    }

    /// Checks that the probability is given in every branch, unless there is only one.
    fn check_probabilities_given(&mut self, branches: &[Branch]) {
        if branches.len() < 2 {
            return;
        }
        if let Some(branch) = branches.iter().find(|b| b.probability.is_none()) {
            let help = "write `probability : (x'=…)` in every branch of a command that has several";
            self.report(self.wrong(branch.span, "this branch has no probability").help(help));
        }
    }

    fn branch(&mut self) -> Parsed<Branch> {
        let start = self.here();
        let probability = if self.at_update() { None } else { Some(self.probability()?) };
        let updates = self.updates()?;
        Ok(Branch { probability, updates, span: start.to(self.before()) })
    }

    /// Parses a probability with its `:`; reports an update without a prime.
    fn probability(&mut self) -> Parsed<Expr> {
        let (start, first, before) = (self.here(), self.peek(), self.tokens.taken());
        if first == Token::LeftBracket {
            let diagnostic = self.unsupported(start, "intervals of probabilities are not supported");
            self.report(diagnostic.help("give one probability, such as `0.5 : (x'=1)`"));
            return Err(Failed);
        }
        let probability = self.tree(Self::expression)?;
        let is_number = first != Token::Word && self.tokens.taken() - before == 1;
        if !is_number && matches!(self.peek(), Token::Semicolon | Token::End) {
            let diagnostic = self.wrong(
                start.to(self.before()),
                "this is neither an update nor a probability with its update",
            );
            let help = "an update is written `(x'=…)`, with a probability `0.5 : (x'=…)`";
            self.report(diagnostic.label("a condition or number").help(help));
            return Err(Failed);
        }
        self.expect(Token::Colon)?;
        Ok(probability)
    }

    /// Returns true if an update, not a probability, starts here.
    fn at_update(&self) -> bool {
        if self.at_word("true") {
            return matches!(self.peek_at(1), Token::Semicolon | Token::Plus);
        }
        let bracket = usize::from(self.peek() == Token::LeftParen);
        self.peek_at(bracket) == Token::Word && self.peek_at(bracket + 1) == Token::Prime
    }

    /// Parses `(x'=e) & (y'=e) & …` or `true`.
    fn updates(&mut self) -> Parsed<Vec<Assignment>> {
        if self.eat_word("true") {
            return Ok(Vec::new());
        }
        let mut updates = vec![self.assignment()?];
        while self.eat(Token::And) {
            self.foreign_operator(Token::And);
            updates.push(self.assignment()?);
        }
        updates.shrink_to_fit();
        Ok(updates)
    }

    fn assignment(&mut self) -> Parsed<Assignment> {
        if self.peek() == Token::Word && self.peek_at(1) == Token::Prime {
            let name = self.text(self.here());
            let diagnostic = self.wrong(self.here(), "an update is written in brackets");
            self.report(diagnostic.label("expected `(`").help(format!("write `({name}'=…)`")));
            return Err(Failed);
        }
        if self.at_word("true") {
            let diagnostic = self.wrong(self.here(), "`true` stands alone: it changes nothing");
            self.report(diagnostic.label("not joined with updates").help("leave it out"));
            return Err(Failed);
        }
        if self.peek() != Token::LeftParen {
            return Err(self.expected("an update `(x'=…)` or `true`"));
        }
        self.advance();
        let variable = self.ident("the name of a variable")?;
        self.expect(Token::Prime)?;
        self.expect(Token::Eq)?;
        let value = self.tree(Self::expression)?;
        self.expect(Token::RightParen)?;
        Ok(Assignment { variable, value })
    }

    /// Parses `base [ old=new, … ] endmodule`.
    fn renamed(&mut self, name: Ident) -> Parsed<Item> {
        let base = self.name_outside("the name of a module")?;
        self.expect(Token::LeftBracket)?;
        let renames = self.list(|p| {
            let old = p.renamed_name()?;
            p.expect(Token::Eq)?;
            Ok((old, p.renamed_name()?))
        })?;
        self.expect(Token::RightBracket)?;
        self.expect_word("endmodule")?;
        Ok(Item::Renamed(Box::new(RenamedModule { name, base, renames })))
    }

    /// Parses a name that can be renamed: of a variable, a constant, a formula, an action or a
    /// function.
    fn renamed_name(&mut self) -> Parsed<Ident> {
        if is_property_operator(self.text(self.here())) { self.action() } else { self.function_name() }
    }
}
