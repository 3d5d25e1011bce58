//! The parts of a model file outside of modules.

use super::parser::{Failed, Parsed, Parser};
use crate::ast::{
    ConstDef, ConstType, Ident, Item, Model, NamedExpr, Player, PlayerItem, RewardItem, Rewards, Span,
};
use crate::token::{BUILT_IN_LABELS, Token};
use meliora_model::ModelKind;

/// Keywords that start a part of a model file: after an error, parsing continues at one of them.
pub(super) const ITEM_WORDS: &[&str] = &[
    "module",
    "const",
    "formula",
    "label",
    "global",
    "rewards",
    "system",
    "mdp",
    "dtmc",
    "nondeterministic",
    "probabilistic",
    "smg",
    "player",
    "observables",
    "observable",
];

/// Keywords of other types of model, with their descriptions.
const FOREIGN: &[(&str, &str)] = &[
    ("ctmc", "continuous-time Markov chains (`ctmc`)"),
    ("stochastic", "continuous-time Markov chains (`stochastic`)"),
    ("pta", "probabilistic timed automata (`pta`)"),
    ("pomdp", "partially observable models (`pomdp`)"),
    ("popta", "partially observable timed automata (`popta`)"),
    ("csg", "concurrent stochastic games (`csg`)"),
    ("tsg", "timed games (`tsg`)"),
    ("tptg", "timed games (`tptg`)"),
    ("ma", "Markov automata (`ma`)"),
    ("ctmdp", "continuous-time Markov decision processes (`ctmdp`)"),
    ("lts", "labelled transition systems (`lts`)"),
    ("imdp", "interval models (`imdp`)"),
    ("idtmc", "interval models (`idtmc`)"),
    ("ipomdp", "interval models (`ipomdp`)"),
    ("invariant", "invariants"),
];

impl<'a> Parser<'a> {
    /// Parses a whole model file.
    pub(crate) fn model(&mut self) -> Model {
        let mut model = Model { kind: None, items: Vec::new() };
        while self.peek() != Token::End {
            let before = self.tokens.taken();
            if self.part(&mut model).is_err() {
                // Makes progress even if the failure is at the first token of a part.
                if self.tokens.taken() == before {
                    self.advance();
                }
                self.recover(ITEM_WORDS);
            }
        }
        model
    }

    fn part(&mut self, model: &mut Model) -> Parsed<()> {
        let span = self.here();
        let word = self.part_word(span);
        let item = match word {
            "mdp" | "nondeterministic" => return self.model_type(model, ModelKind::Mdp),
            "dtmc" | "probabilistic" => return self.model_type(model, ModelKind::Dtmc),
            "smg" => return self.model_type(model, ModelKind::Smg),
            "const" | "rate" | "prob" => Item::Const(self.constant()?),
            "formula" => Item::Formula(self.formula()?),
            "label" => Item::Label(self.label()?),
            "global" => {
                self.advance();
                Item::Global(Box::new(self.declaration()?))
            }
            "module" => self.module()?,
            "rewards" => Item::Rewards(Box::new(self.rewards()?)),
            "init" => Item::Init(self.init()?),
            "system" => Item::System(Box::new(self.system()?)),
            "player" => Item::Player(Box::new(self.player()?)),
            "observables" => return self.observables(),
            "observable" => return self.observable(),
            _ => return self.foreign_part(span, word),
        };
        model.items.push(item);
        Ok(())
    }

    /// Returns the keyword with which a part starts, corrected if misspelt.
    fn part_word(&mut self, span: Span) -> &'a str {
        let word = if self.peek() == Token::Word { self.text(span) } else { "" };
        let is_known = ITEM_WORDS.contains(&word) || FOREIGN.iter().any(|(foreign, _)| *foreign == word);
        if is_known { word } else { self.slip(ITEM_WORDS).unwrap_or(word) }
    }

    fn model_type(&mut self, model: &mut Model, kind: ModelKind) -> Parsed<()> {
        let span = self.advance();
        match model.kind {
            Some((_, first)) => {
                let diagnostic = self.wrong(span, "the model type is given twice").label("given again");
                self.report(diagnostic.related(first.range(), "given here first"));
            }
            None => model.kind = Some((kind, span)),
        }
        Ok(())
    }

    /// Reports a part that an `mdp` or `dtmc` cannot have.
    fn foreign_part(&mut self, span: Span, word: &str) -> Parsed<()> {
        let Some((_, what)) = FOREIGN.iter().find(|(w, _)| *w == word) else {
            return Err(self.expected("`mdp`, `dtmc`, `smg`, `module`, or another part of a model"));
        };
        let help = "models of type `mdp`, `dtmc` and `smg` are supported";
        self.report(self.unsupported(span, format!("{what} are not supported")).help(help));
        self.advance();
        if word == "invariant" {
            self.skip_past("endinvariant");
        }
        Ok(())
    }

    /// Skips `observables x, y endobservables`: it describes the view of a player of a `pomdp`, not
    /// the model.
    fn observables(&mut self) -> Parsed<()> {
        self.advance();
        if self.eat_word("endobservables") {
            return Ok(());
        }
        self.list(|p| p.ident("the name of a variable"))?;
        self.expect_word("endobservables").map(|_| ())
    }

    /// Skips `observable "name" = expression;`.
    fn observable(&mut self) -> Parsed<()> {
        self.advance();
        self.quoted()?;
        self.body().map(|_| ())
    }

    /// Skips everything up to and including a word, or up to the end.
    pub(super) fn skip_past(&mut self, word: &str) {
        while self.peek() != Token::End && !self.eat_word(word) {
            self.advance();
        }
    }

    fn constant(&mut self) -> Parsed<ConstDef> {
        let is_old = self.at_word("rate") || self.at_word("prob");
        self.advance();
        let ty = match self.text(self.here()) {
            _ if is_old => Some(ConstType::Double),
            "int" => Some(ConstType::Int),
            "double" => Some(ConstType::Double),
            "bool" => Some(ConstType::Bool),
            _ => None,
        };
        if ty.is_some() && !is_old {
            self.advance();
        }
        let name = self.ident("the name of a constant")?;
        let value = if self.eat(Token::Eq) { Some(self.expression()?) } else { None };
        self.expect(Token::Semicolon)?;
        Ok(ConstDef { ty: ty.unwrap_or(ConstType::Int), name, value })
    }

    /// Parses `= expression;`.
    fn body(&mut self) -> Parsed<Span> {
        self.expect(Token::Eq)?;
        let body = self.expression()?;
        self.expect(Token::Semicolon)?;
        Ok(body)
    }

    fn formula(&mut self) -> Parsed<NamedExpr> {
        self.advance();
        let name = self.ident("the name of a formula")?;
        let body = self.body()?;
        Ok(NamedExpr { name, body })
    }

    fn label(&mut self) -> Parsed<NamedExpr> {
        self.advance();
        if self.peek() == Token::Word {
            let span = self.here();
            let name = self.text(span);
            let help = format!("write `\"{name}\"`");
            self.report(self.wrong(span, "the name of a label is written in double quotes").help(help));
            return Err(Failed);
        }
        let name = self.quoted()?;
        if BUILT_IN_LABELS.contains(&name.name.as_str()) {
            let message = format!("the label \"{}\" is built in and cannot be defined", name.name);
            self.report(self.wrong(name.span, message));
        }
        let body = self.body()?;
        Ok(NamedExpr { name, body })
    }

    fn init(&mut self) -> Parsed<Span> {
        self.advance();
        let condition = self.expression()?;
        self.expect_word("endinit")?;
        Ok(condition)
    }

    /// Parses `player p1 module1, [action1] endplayer`.
    fn player(&mut self) -> Parsed<Player> {
        self.advance();
        let name = self.ident("the name of a player")?;
        let items = if self.at_word("endplayer") { Vec::new() } else { self.list(Self::player_item)? };
        self.expect_word("endplayer")?;
        Ok(Player { name, items })
    }

    fn player_item(&mut self) -> Parsed<PlayerItem> {
        if !self.eat(Token::LeftBracket) {
            return self.ident("a module, or an action in brackets, `[a]`").map(PlayerItem::Module);
        }
        let action = self.action()?;
        self.expect(Token::RightBracket)?;
        Ok(PlayerItem::Action(action))
    }

    fn rewards(&mut self) -> Parsed<Rewards> {
        let start = self.advance();
        let name = self.reward_name();
        let mut items = Vec::new();
        while !self.at_word("endrewards") {
            if self.peek() == Token::End {
                return Err(self.expected("`endrewards`"));
            }
            match self.reward_item() {
                Ok(item) => items.push(item),
                Err(Failed) => self.recover(&["endrewards", "module"]),
            }
            if self.at_word("module") {
                return Err(self.expected("`endrewards`"));
            }
        }
        let end = self.advance();
        Ok(Rewards { name, items, span: start.to(end) })
    }

    /// Parses a name in quotes, if there is one.
    fn reward_name(&mut self) -> Option<Ident> {
        if self.peek() == Token::Quoted { self.quoted().ok() } else { None }
    }

    fn reward_item(&mut self) -> Parsed<RewardItem> {
        let action = if self.eat(Token::LeftBracket) {
            let name = if self.peek() == Token::RightBracket { None } else { Some(self.action()?) };
            self.expect(Token::RightBracket)?;
            Some(name)
        } else {
            None
        };
        let guard = self.expression()?;
        if self.peek() != Token::Colon {
            let found = self.text(self.here());
            let diagnostic = self.wrong(self.here(), format!("expected `:`, found `{found}`"));
            let help = "a reward is written `[action] condition : number;` or `condition : number;`, the name of \
                        a structure in quotes: `rewards \"name\"`";
            self.report(diagnostic.label("expected `:`").help(help));
            return Err(Failed);
        }
        self.advance();
        let value = self.expression()?;
        self.expect(Token::Semicolon)?;
        Ok(RewardItem { action, guard, value })
    }
}
