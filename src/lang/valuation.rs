//! Values for constants and variables as given on the command line: `K=4,N=3`, `r=2,c=2,d=false`.

use std::sync::Arc;

use num_traits::Zero;

use super::ast::{Ident, Span};
use super::parse::{Failed, Parsed, Parser};
use super::token::Token;
use meliora_base::error::{Result, SourceFile};
use meliora_base::escape;
use meliora_base::exact::{Exact, Ratio, Real};
use meliora_base::value::Type;
use meliora_model::{Program, State, Variable};

/// Values that the user gives in addition to a model.
#[derive(Debug, Clone)]
pub struct Given {
    /// Values of undefined constants, such as `K=4,N=3`; may be empty.
    pub constants: Arc<SourceFile>,
    /// Bounds of integers that are unbounded in the model, such as `x=0..7,y=-1..1`; may be empty.
    pub bounds: Arc<SourceFile>,
}

impl Given {
    /// Creates the values of constants, without bounds.
    pub fn constants_only(constants: &Arc<SourceFile>) -> Self {
        Given { constants: Arc::clone(constants), bounds: SourceFile::new("bounds", "") }
    }
}

/// A name with the value given to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Binding {
    /// Name.
    pub name: Ident,
    /// Value.
    pub value: Exact,
    /// Place of the value.
    pub span: Span,
}

/// Parses values for constants, such as `K=4,p=0.5,fast=true`; an empty text gives no values.
///
/// # Errors
/// A syntax error, or a name that occurs twice.
pub fn parse_constants(source: &Arc<SourceFile>) -> Result<Vec<Binding>> {
    let mut parser = Parser::new(source);
    let parsed = parser.bindings(None, false).map(|(bindings, _)| bindings);
    parser.finish_parsed(parsed)
}

/// Splits the values of constants in two texts: those of the constants in `theirs`, and the rest.
///
/// # Errors
/// See [`parse_constants`].
pub fn split_constants(source: &Arc<SourceFile>, theirs: &[String]) -> Result<[Arc<SourceFile>; 2]> {
    let (these, others): (Vec<_>, Vec<_>) =
        parse_constants(source)?.into_iter().partition(|binding| theirs.contains(&binding.name.name));
    let text = |binding: &Binding| &source.text[binding.name.span.start()..binding.span.end()];
    let joined = |all: &[Binding]| all.iter().map(text).collect::<Vec<_>>().join(",");
    Ok([these, others].map(|all| SourceFile::new(source.name.clone(), joined(&all))))
}

/// The value of one variable in a text such as `r=2,c=*,d=false`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// This value is given.
    Given(i64),
    /// The variable is left out and gets its initial value.
    Default(i64),
    /// `*`: any value.
    Any,
}

impl Place {
    /// Returns the value, given or initial; `None` for `*`.
    pub fn value(self) -> Option<i64> {
        match self {
            Place::Given(value) | Place::Default(value) => Some(value),
            Place::Any => None,
        }
    }

    /// Returns the value if it is given.
    pub fn given(self) -> Option<i64> {
        match self {
            Place::Given(value) => Some(value),
            Place::Default(_) | Place::Any => None,
        }
    }
}

/// Parses a state, such as `r=2,c=2,d=false`. Variables left out get their initial value.
///
/// # Errors
/// A syntax error, an unknown or repeated variable, a value of the wrong type or out of range, or a
/// variable left out that has no single initial value.
pub fn parse_state(source: &Arc<SourceFile>, program: &Program) -> Result<State> {
    Ok(places(source, program, false)?.into_iter().filter_map(Place::value).collect())
}

/// Parses a state in which variables may have any value, such as `r=2,c=*`; returns the
/// value or values of each variable of the program.
///
/// # Errors
/// The errors of [`parse_state`].
pub fn parse_states(source: &Arc<SourceFile>, program: &Program) -> Result<Vec<Place>> {
    places(source, program, true)
}

fn places(source: &Arc<SourceFile>, program: &Program, any: bool) -> Result<Vec<Place>> {
    let mut parser = Parser::new(source);
    let (bindings, free) = match parser.bindings(Some(program), any) {
        Ok(bindings) => bindings,
        parsed @ Err(_) => return parser.finish_parsed(parsed).map(|_| Vec::new()),
    };
    let mut places: Vec<Option<Place>> =
        program.variables.iter().map(|v| v.initial.map(Place::Default)).collect();
    for binding in bindings {
        if let Some((index, value)) = parser.variable_value(&binding, program) {
            places[index] = Some(Place::Given(value));
        }
    }
    for name in free {
        if let Some(index) = parser.variable(&name, program) {
            places[index] = Some(Place::Any);
        }
    }
    for (variable, _) in program.variables.iter().zip(&places).filter(|(_, place)| place.is_none()) {
        let message = format!("no value for `{}`, and it has no single initial value", variable.name);
        let end = Span::new(source.text.len(), source.text.len());
        parser.report(parser.wrong(end, message));
    }
    parser.finish(places.into_iter().flatten().collect())
}

impl Parser<'_> {
    /// Parses `name=value,…`, and returns the names with `*` for a value apart, if they are allowed;
    /// the variables of a program give the names that values have.
    fn bindings(&mut self, program: Option<&Program>, any: bool) -> Parsed<(Vec<Binding>, Vec<Ident>)> {
        let (mut bindings, mut free): (Vec<Binding>, Vec<Ident>) = (Vec::new(), Vec::new());
        while self.peek() != Token::End {
            if !bindings.is_empty() || !free.is_empty() {
                self.expect(Token::Comma)?;
            }
            let fact = self.fact(program);
            let name = match &fact {
                Some(fact) => fact.name.clone(),
                None => {
                    let name = match self.atom_variable(program) {
                        Some(name) => name,
                        None => self.ident("a name")?,
                    };
                    self.expect(Token::Eq)?;
                    name
                }
            };
            if let Some(first) =
                bindings.iter().map(|b| &b.name).chain(&free).find(|other| other.name == name.name)
            {
                let diagnostic = self.wrong(name.span, format!("`{}` is given twice", first.name));
                let first = first.span.range();
                self.report(diagnostic.related(first, "given here first"));
            }
            if let Some(fact) = fact {
                bindings.push(fact);
            } else if any && self.eat(Token::Star) {
                free.push(name);
            } else {
                bindings.push(self.binding(name, program)?);
            }
        }
        Ok((bindings, free))
    }

    /// Takes a fact of a planning problem, such as `at(robot,kitchen)`: the value of its variable. `!` stands
    /// before facts alone, which are Boolean variables.
    fn fact(&mut self, program: Option<&Program>) -> Option<Binding> {
        let program = program?;
        let planning = program.planning.as_ref()?;
        let mut depth = 0usize;
        let text = self.rest_of_text();
        let end = text.find(|c: char| {
            depth = (depth + usize::from(c == '(')).saturating_sub(usize::from(c == ')'));
            c == ',' && depth == 0
        });
        let text = text[..end.unwrap_or(text.len())].trim_end();
        let name = text.strip_prefix('!');
        let fact = planning.fact(name.unwrap_or(text))?;
        let variable = &program.variables[fact.variable.index()];
        let value = match (variable.ty, name) {
            (Type::Bool, negated) => Exact::Bool(negated.is_none()),
            (_, None) => Exact::Int(fact.value),
            (_, Some(_)) => return None,
        };
        let start = self.here().start();
        let span = Span::new(start, start + text.len());
        while self.peek() != Token::End && self.here().start() < span.end() {
            self.advance();
        }
        Some(Binding { name: Ident { name: variable.name.clone(), span }, value, span })
    }

    /// Takes the name of a variable that is not an identifier, such as `at(robot)`: all up to `=`.
    fn atom_variable(&mut self, program: Option<&Program>) -> Option<Ident> {
        let text = self.rest_of_text();
        let name = text[..text.find('=')?].trim_end();
        program?.variables.iter().find(|variable| variable.name == name)?;
        let start = self.here().start();
        let span = Span::new(start, start + name.len());
        while self.peek() != Token::End && self.here().start() < span.end() {
            self.advance();
        }
        Some(self.named(span))
    }

    fn binding(&mut self, name: Ident, program: Option<&Program>) -> Parsed<Binding> {
        let start = self.here();
        let variable = program.and_then(|program| program.variables.iter().find(|v| v.name == name.name));
        let names = variable.filter(|variable| !variable.values.is_empty());
        if let Some(value) = names.and_then(|variable| self.named_value(variable)) {
            return Ok(Binding { name, value, span: start.to(self.before()) });
        }
        // Where values are called by numbers, the number of a value would be mistaken for its name.
        let is_number = |name: &String| name.parse::<f64>().is_ok();
        let literal = match names.is_some_and(|variable| variable.values.iter().any(is_number)) {
            true => None,
            false => self.literal()?,
        };
        let Some(value) = literal else {
            return Err(match (names, program) {
                (Some(variable), _) => self.no_such_value(variable),
                (None, Some(program)) if self.variable(&name, program).is_none() => Failed,
                (None, _) => self.expected("a number, `true` or `false`"),
            });
        };
        Ok(Binding { name, value, span: start.to(self.before()) })
    }

    /// Takes a number, a fraction or a truth value; `None` if the next token is none.
    fn literal(&mut self) -> Parsed<Option<Exact>> {
        let negative = self.eat(Token::Minus);
        let span = self.here();
        let text = self.text(span);
        let value = match (self.peek(), text) {
            (Token::Int | Token::Real, _) if self.peek_at(1) == Token::Slash => {
                let x = self.fraction()?;
                Some(Exact::Real(Real::Finite(if negative { -x } else { x })))
            }
            (Token::Word, "true") if !negative => Some(Exact::Bool(true)),
            (Token::Word, "false") if !negative => Some(Exact::Bool(false)),
            (Token::Int, _) => text.parse().ok().map(|i: i64| Exact::Int(if negative { -i } else { i })),
            (Token::Real, _) => {
                let x = self.exact(span)?;
                Some(Exact::Real(Real::Finite(if negative { -x } else { x })))
            }
            _ => None,
        };
        if value.is_some() {
            self.advance();
        }
        Ok(value)
    }

    /// Reads `1/3` up to its denominator.
    fn fraction(&mut self) -> Parsed<Ratio> {
        let numerator = self.exact(self.here())?;
        self.advance();
        self.advance();
        let span = self.here();
        let denominator = match self.peek() {
            Token::Int | Token::Real => self.exact(span)?,
            _ => return Err(self.expected("a number")),
        };
        if denominator.is_zero() {
            self.report(self.wrong(span, "this number divides by 0"));
            return Err(Failed);
        }
        Ok(numerator / denominator)
    }

    /// Takes the name of a value, if the next tokens are one: as it is printed, or else as it is, of
    /// several such names the longest one.
    fn named_value(&mut self, variable: &Variable) -> Option<Exact> {
        let text = self.rest_of_text();
        let length = |name: &str| {
            let after = text.strip_prefix(name)?.trim_start();
            (after.is_empty() || after.starts_with(',')).then(|| text.len() - after.len())
        };
        let names = || (0i64..).zip(&variable.values);
        let printed = names().find_map(|(at, name)| Some((length(&escape::value(name))?, at)));
        let quoted = || names().find_map(|(at, name)| Some((length(&format!("\"{name}\""))?, at)));
        let others = || names().filter_map(|(at, name)| Some((length(name)?, at))).max();
        let (length, at) = printed.or_else(quoted).or_else(others)?;
        let end = self.here().start() + length;
        while self.peek() != Token::End && self.here().start() < end {
            self.advance();
        }
        Some(Exact::Int(variable.low + at))
    }

    /// Reports that a value is none of those that have names.
    fn no_such_value(&mut self, variable: &Variable) -> Failed {
        let span = self.here();
        let given = self.text(span).trim_matches('"');
        let message = format!("`{}` has no value `{given}`", variable.name);
        let names = variable.values.iter().map(|name| escape::quoted(name)).collect::<Vec<_>>();
        let diagnostic = self.wrong(span, message).label("no such value");
        self.report(diagnostic.help(format!("its values are {}", names.join(", "))));
        Failed
    }

    /// Returns the index of a variable; reports a name that is none.
    fn variable(&mut self, ident: &Ident, program: &Program) -> Option<usize> {
        let name = &ident.name;
        let found = program.variables.iter().position(|v| v.name == *name);
        if found.is_none() {
            let known = program.variables.iter().map(|v| v.name.as_str()).collect::<Vec<_>>().join(", ");
            let diagnostic = self.wrong(ident.span, format!("the model has no variable `{name}`"));
            self.report(diagnostic.help(format!("its variables are {known}")));
        }
        found
    }

    /// Returns the index and the value of the variable of a binding; reports one that does not fit.
    fn variable_value(&mut self, binding: &Binding, program: &Program) -> Option<(usize, i64)> {
        let index = self.variable(&binding.name, program)?;
        let name = &binding.name.name;
        let variable = &program.variables[index];
        let value = match (variable.ty, &binding.value) {
            (Type::Bool, Exact::Bool(b)) => i64::from(*b),
            (Type::Int, Exact::Int(i)) => *i,
            (ty, value) => {
                let value = value.rounded();
                let message = format!("`{name}` is of type `{ty}`, and {value} is not");
                self.report(self.wrong(binding.span, message));
                return None;
            }
        };
        if !(variable.low..=variable.high).contains(&value) {
            let message = format!("{value} is outside of the range {}..{}", variable.low, variable.high);
            self.report(self.wrong(binding.span, message).label(format!("the range of `{name}`")));
            return None;
        }
        Some((index, value))
    }
}
