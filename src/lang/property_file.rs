//! Property files in PRISM's format: constants, labels, formulas, and properties with names.
//!
//! A statement ends with a semicolon; a property also ends at the end of a line if its brackets are
//! closed. Each statement is parsed separately, at its place in the file, so an unsupported one
//! does not hide others.

mod defined;
mod statements;

use std::ops::Range;
use std::sync::Arc;

use ahash::{AHashMap, AHashSet};

use super::ast::{ConstDef, Ident, Item, NamedExpr, Span};
use super::check::{Wanted, given_values, lower_condition, lower_value};
use super::parse::{expression_at, items_at};
use super::parse_constants;
use super::property::property_at;
use super::valuation::Binding;
use crate::property::{Named, Property, Term};
pub use crate::refusal::Refusal;
use defined::Kind;
use meliora_base::error::{Diagnostic, Error, Result, SourceFile};
use meliora_base::exact::{Exact, Real};
use meliora_base::progress::NoProgress;
use meliora_base::value::Type;
use meliora_model::Program;
use meliora_model::expr::{ExprId, ExprPool};
use statements::{is_definition, named, statements, word};

/// A property of a file.
#[derive(Debug, Clone)]
pub struct Stated {
    /// Name, if it has one.
    pub name: Option<String>,
    /// Text, without the name.
    pub text: String,
    /// The property, or the reason why it cannot be answered here.
    pub term: Result<Term, Refusal>,
    /// The text that contains it.
    pub source: Arc<SourceFile>,
}

/// Returns the constants that a property file declares without a value.
///
/// # Errors
/// Too many statements.
pub fn open_constants(source: &Arc<SourceFile>) -> Result<Vec<String>> {
    let open = constants(source)?.into_iter().filter(|constant| constant.value.is_none());
    Ok(open.map(|constant| constant.name.name).collect())
}

/// Returns the declarations of constants of a property file.
fn constants(source: &Arc<SourceFile>) -> Result<Vec<ConstDef>> {
    let mut all = Vec::new();
    for range in statements(source)?.into_iter().filter(|r| word(&source.text[r.clone()]) == "const") {
        // Errors in definitions are reported when the file is parsed in full.
        let items = items_at(source, place(&range)).unwrap_or_default();
        all.extend(items.into_iter().filter_map(|item| match item {
            Item::Const(constant) => Some(constant),
            _ => None,
        }));
    }
    Ok(all)
}

/// Refuses given values of constants that have their values in a property file.
///
/// # Errors
/// Such a value; the syntax of the values is wrong; too many statements.
pub fn refuse_values(source: &Arc<SourceFile>, given: &Arc<SourceFile>) -> Result<()> {
    let constants = constants(source)?;
    let wrong = |binding: Binding| {
        let name = &binding.name.name;
        let constant = constants.iter().find(|c| c.name.name == *name && c.value.is_some())?;
        let (line, column) = source.position(constant.name.span.start());
        let message = format!("the constant `{name}` already has a value at {}:{line}:{column}", source.name);
        let help =
            format!("write `const {} {name};` there, and the value can be given here", constant.ty.ty());
        Some(Diagnostic::new(given, binding.name.span.range(), message).help(help))
    };
    let wrong: Vec<Diagnostic> = parse_constants(given)?.into_iter().filter_map(wrong).collect();
    if wrong.is_empty() { Ok(()) } else { Err(Error::Input(wrong)) }
}

/// Refuses a file without a property.
fn some_property(source: &Arc<SourceFile>, properties: &[Range<usize>]) -> Result<()> {
    if !properties.is_empty() {
        return Ok(());
    }
    let wrong = Diagnostic::new(source, 0..0, "the file has no property");
    Err(wrong.help("a property is for example `P>=1 [ F x=3 ]` or `Pmax=? [ F \"goal\" ]`").into())
}

/// Returns the properties of a file as they are written: the name, if it has one, and the text in one
/// line.
///
/// # Errors
/// The file is of another kind or has no property; too many statements.
pub fn outline_properties(source: &Arc<SourceFile>) -> Result<Vec<(Option<String>, String)>> {
    super::mistaken::no_properties(source)?;
    let all = statements(source)?.into_iter();
    let properties: Vec<_> = all.filter(|range| !is_definition(source, range)).collect();
    some_property(source, &properties)?;
    let outline = |range: Range<usize>| {
        let (name, start) = named(&source.text[range.clone()]);
        let words = source.text[range.start + start..range.end].split_whitespace();
        (name, words.collect::<Vec<_>>().join(" "))
    };
    Ok(properties.into_iter().map(outline).collect())
}

/// Parses a property file. Its constants, labels and formulas are added to the program, whose names
/// its properties and all later conditions can use; `given` are values for constants declared without
/// one. A constant without any value is unknown to all properties.
///
/// # Errors
/// A wrong definition; a wrong value; no property; too many statements. The error of a property is returned in
/// its `Stated::term`.
pub fn parse_properties(
    source: &Arc<SourceFile>,
    given: &Arc<SourceFile>,
    program: &mut Program,
) -> Result<Vec<Stated>> {
    super::mistaken::no_properties(source)?;
    let bindings = parse_constants(given)?;
    let labels = program.labels.iter().map(|(name, _)| name.clone()).collect();
    let (added, open, defined) = (AHashSet::new(), AHashMap::new(), AHashSet::new());
    let pool = ExprPool::over(&program.pool);
    let mut file = File { given, bindings, labels, added, open, defined, pool, program };
    let (definitions, properties): (Vec<_>, Vec<_>) =
        statements(source)?.into_iter().partition(|range| is_definition(source, range));
    definitions.into_iter().try_for_each(|range| file.define(source, place(&range)))?;
    some_property(source, &properties)?;
    file.program.inexact = file.program.inexact.take().or(file.pool.inexact.take());
    file.program.pool = std::mem::take(&mut file.pool).into();
    for range in &properties {
        if let (Some(name), start) = named(&source.text[range.clone()]) {
            file.once(source, format!("property \"{name}\""), range.start..range.start + start)?;
        }
    }
    let read: Vec<_> = properties.iter().map(|range| file.read(source, range)).collect();
    let names = read.iter().filter_map(|(name, _, property)| Some((name.clone()?, property.clone().ok()?)));
    let names: Named = names.collect();
    Ok(read.into_iter().map(|property| file.property(source, property, &names)).collect())
}

/// A property with its name and its text; the syntax may be wrong.
type ReadProperty = (Option<String>, String, Result<Property>);

fn place(range: &Range<usize>) -> Span {
    Span::new(range.start, range.end)
}

/// A property file during parsing.
struct File<'a> {
    given: &'a Arc<SourceFile>,
    bindings: Vec<Binding>,
    /// The labels of the model.
    labels: AHashSet<String>,
    /// The constants and formulas of the file.
    added: AHashSet<String>,
    /// Constants without a value, and names that need one, in their quotes, each with the constant.
    open: AHashMap<String, String>,
    /// The labels and named properties of the file.
    defined: AHashSet<String>,
    /// The pool of the definitions, on top of that of the program.
    pool: ExprPool,
    program: &'a mut Program,
}

impl File<'_> {
    /// Adds the definitions of a statement to the program.
    fn define(&mut self, source: &Arc<SourceFile>, place: Span) -> Result<()> {
        for item in items_at(source, place)? {
            match item {
                Item::Label(label) => self.label(source, label)?,
                Item::Formula(formula) => {
                    self.is_new(source, &formula.name)?;
                    self.added.insert(formula.name.name.clone());
                    let name = formula.name.name;
                    let id = self.lowered(source, formula.body);
                    let id = self.unless_open(quoted('`', &name), id)?;
                    self.program.formulas.extend(id.map(|id| (name, id)));
                }
                Item::Const(constant) => self.constant(source, constant)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn label(&mut self, source: &Arc<SourceFile>, label: NamedExpr) -> Result<()> {
        let NamedExpr { name: Ident { name, span }, body } = label;
        if self.labels.contains(&name) {
            let message = format!("the label \"{name}\" is defined twice");
            let wrong = Diagnostic::new(source, span.range(), message).label("defined again");
            let wrong = wrong.note(defined::in_model(self.program, &name, Kind::Label));
            return Err(wrong.help("rename this label, or remove it").into());
        }
        self.once(source, format!("label \"{name}\""), span.range())?;
        let body = expression_at(source, body, &NoProgress)?;
        let target = lower_condition(self.program, &mut self.pool, source, &body);
        let target = self.unless_open(quoted('"', &name), target)?;
        self.program.labels.extend(target.map(|target| (name, target)));
        Ok(())
    }

    fn constant(&mut self, source: &Arc<SourceFile>, constant: ConstDef) -> Result<()> {
        let ConstDef { ty, name, value } = constant;
        self.is_new(source, &name)?;
        self.added.insert(name.name.clone());
        let wanted = [Wanted { name: &name.name, ty: ty.ty(), is_defined: value.is_some(), span: name.span }];
        let bindings: Vec<_> = self.bindings.iter().filter(|b| b.name.name == name.name).cloned().collect();
        let (given, wrong) = given_values(&wanted, self.given, &bindings);
        if !wrong.is_empty() {
            return Err(Error::Input(wrong));
        }
        let name = name.name;
        let value = match (given.first(), value) {
            (Some((_, value)), _) => Some(value.clone()),
            (None, Some(value)) => {
                let value = self.value(source, &name, ty.ty(), value);
                self.unless_open(quoted('`', &name), value)?
            }
            (None, None) => {
                self.open.insert(quoted('`', &name), name.clone());
                None
            }
        };
        self.program.constants.extend(value.map(|value| (name, value)));
        Ok(())
    }

    /// Returns the result of a definition; `None` if it needs a constant without a value. Then its own
    /// name has none, either.
    fn unless_open<T>(&mut self, name: String, defined: Result<T>) -> Result<Option<T>> {
        let error = match defined {
            Ok(defined) => return Ok(Some(defined)),
            Err(error) => error,
        };
        let Error::Input(diagnostics) = &error else { return Err(error) };
        let mut needs = diagnostics.iter().map(|d| self.needs(d));
        let Some(constant) = needs.next().flatten().cloned().filter(|_| needs.all(|c| c.is_some())) else {
            return Err(error);
        };
        self.open.insert(name, constant);
        Ok(None)
    }

    /// Returns the constant without a value because of which a name is unknown.
    fn needs(&self, diagnostic: &Diagnostic) -> Option<&String> {
        let name =
            ["unknown name ", "unknown label "].iter().find_map(|w| diagnostic.message.strip_prefix(w))?;
        self.open.get(name)
    }

    /// Checks that neither the model nor the file uses a name already.
    fn is_new(&self, source: &Arc<SourceFile>, name: &Ident) -> Result<()> {
        let text = &name.name;
        let known = |name: &String| name == text;
        let kind = if self.program.constants.iter().any(|(name, _)| known(name)) {
            Kind::Constant
        } else if self.program.formulas.iter().any(|(name, _)| known(name)) {
            Kind::Formula
        } else if self.program.variables.iter().any(|variable| known(&variable.name)) {
            Kind::Variable
        } else if self.open.contains_key(&quoted('`', text)) {
            Kind::Constant
        } else {
            return Ok(());
        };
        let message = format!("`{text}` is declared already");
        let wrong = Diagnostic::new(source, name.span.range(), message).label("declared again");
        if self.added.contains(text) {
            return Err(wrong.into());
        }
        let wrong = wrong.note(defined::in_model(self.program, text, kind));
        let help = "properties may use the names of the model: remove this declaration, or rename it";
        Err(wrong.help(help).into())
    }

    /// Returns an expression of any type at a place of the file.
    fn lowered(&mut self, source: &Arc<SourceFile>, place: Span) -> Result<ExprId> {
        let body = expression_at(source, place, &NoProgress)?;
        lower_value(self.program, &mut self.pool, source, &body)
    }

    /// Returns the value that the file gives to a constant.
    fn value(&mut self, source: &Arc<SourceFile>, name: &str, ty: Type, value: Span) -> Result<Exact> {
        let id = self.lowered(source, value)?;
        let wrong = |message: String| Diagnostic::new(source, value.range(), message);
        match (self.pool.exact_literal(id), ty) {
            (Some(Exact::Int(i)), Type::Real) => Ok(Exact::Real(Real::from(i))),
            (Some(value), ty) if value.ty() == ty => Ok(value),
            (Some(value), ty) => {
                let message = format!("type error: the constant `{name}` must be of type `{ty}`");
                Err(wrong(message).label(format!("of type `{}`", value.ty())).into())
            }
            (None, _) => Err(wrong(format!("the constant `{name}` must not depend on variables")).into()),
        }
    }

    /// Refuses what the file defines twice.
    fn once(&mut self, source: &Arc<SourceFile>, what: String, place: Range<usize>) -> Result<()> {
        if self.defined.contains(&what) {
            let message = format!("the {what} is defined twice");
            return Err(Diagnostic::new(source, place, message).label("defined again").into());
        }
        self.defined.insert(what);
        Ok(())
    }

    fn read(&mut self, source: &Arc<SourceFile>, range: &Range<usize>) -> ReadProperty {
        let (name, start) = named(&source.text[range.clone()]);
        let range = range.start + start..range.end;
        let text = source.text[range.clone()].trim().to_owned();
        (name, text, property_at(source, place(&range)))
    }

    fn property(
        &mut self,
        source: &Arc<SourceFile>,
        (name, text, property): ReadProperty,
        named: &Named,
    ) -> Stated {
        let term = property.and_then(|property| property.term(self.program, source, named));
        let term = term.map_err(|e| Refusal::new(&self.without_value(e)));
        Stated { name, text, term, source: Arc::clone(source) }
    }

    /// Rewrites an error "unknown name" for a name that needs a constant without a value.
    fn without_value(&self, error: Error) -> Error {
        let Error::Input(mut diagnostics) = error else { return error };
        for diagnostic in &mut diagnostics {
            let Some(open) = self.needs(diagnostic) else { continue };
            diagnostic.message =
                format!("the constant `{open}` has no value: give it with `{} {open}=…`", self.given.name);
            diagnostic.label = "undefined".to_owned();
            diagnostic.help = None;
        }
        Error::Input(diagnostics)
    }
}

/// Returns a name in the quotes that it has in messages.
fn quoted(quote: char, name: &str) -> String {
    format!("{quote}{name}{quote}")
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "// what is asked\nconst int k = 2;\nlabel \"far\" =\n  x >= k;\n\n\"one\": P>=1 [ F \"far\" ];\n\
        P>0 [ F x=9 ] // the last state\n\"two\":\n  Pmax=? [ F \"far\" ]\nR{\"steps\"}min=? [ F x=9 ]; P<1 [ F\n y=1 ]";

    fn none() -> Arc<SourceFile> {
        SourceFile::new("--const", "")
    }

    fn program() -> Program {
        let text = "mdp module m x:[0..9]; [] x<9 -> (x'=x+1); endmodule";
        super::super::load(&SourceFile::new("m", text), &SourceFile::new("c", "")).unwrap().program
    }

    #[test]
    fn what_cannot_be_answered_has_its_reason() {
        let mut program = program();
        let source = SourceFile::new("f.props", FILE);
        let all = parse_properties(&source, &none(), &mut program).unwrap();
        assert!(all.iter().all(|s| Arc::ptr_eq(&s.source, &source)), "the text is there once");
        let names: Vec<Option<&str>> = all.iter().map(|s| s.name.as_deref()).collect();
        assert_eq!(names, [Some("one"), None, Some("two"), None, None]);
        let answered: Vec<bool> = all.iter().map(|s| s.term.is_ok()).collect();
        assert_eq!(answered, [true, true, true, false, false]);
        let refused = |at: usize| all[at].term.as_ref().unwrap_err();
        let unknown = "the model has no reward structure; declare one in the model, or ask for a probability";
        assert_eq!(refused(3), &Refusal { reason: unknown.to_owned(), place: Some((10, 1)) });
        assert!(refused(4).reason.contains("unknown name `y`"));
        assert_eq!(refused(4).place, Some((11, 2)));
        assert!(program.labels.iter().any(|(name, _)| name == "far"));
    }

    #[test]
    fn what_is_defined_twice_is_refused_at_the_second_place() {
        for (text, place, message) in [
            ("\"a\": P>0 [ F x=1 ];\n\"a\": P>0 [ F x=2 ];", (2, 1), "the property \"a\" is defined twice"),
            ("label \"l\" = x=1; label \"l\" = x=2;", (1, 24), "the label \"l\" is defined twice"),
            ("formula f = x=1;\nformula f = x=2;", (2, 9), "`f` is declared already"),
        ] {
            let file = SourceFile::new("f.props", text);
            let Err(Error::Input(found)) = parse_properties(&file, &none(), &mut program()) else { panic!() };
            assert_eq!((found[0].position(), found[0].message.as_str()), (place, message));
        }
    }

    #[test]
    fn a_wrong_definition_is_an_error_at_its_place() {
        let file = SourceFile::new("f.props", "P>0 [ F x=1 ];\nlabel \"l\" = z=1;");
        let Err(Error::Input(found)) = parse_properties(&file, &none(), &mut program()) else { panic!() };
        assert_eq!((found[0].position(), found[0].message.as_str()), ((2, 13), "unknown name `z`"));
    }

    #[test]
    fn a_constant_or_formula_with_the_name_of_something_else_is_an_error() {
        for (text, name) in [
            ("const int x = 2;", "x"),
            ("formula x = 2;", "x"),
            ("const int N; const int N;", "N"),
            ("formula f = x>1; const bool f = true;", "f"),
        ] {
            let file = SourceFile::new("f.props", text);
            let Err(Error::Input(found)) = parse_properties(&file, &none(), &mut program()) else {
                panic!("{text}")
            };
            assert_eq!(found[0].message, format!("`{name}` is declared already"));
        }
    }

    #[test]
    fn other_files_are_told_by_how_they_begin() {
        for (text, what) in
            [("objective A = F x=1;", "a preference file"), ("mdp\nmodule m endmodule", "a model")]
        {
            let file = SourceFile::new("f.props", text);
            let Err(Error::Input(found)) = parse_properties(&file, &none(), &mut program()) else { panic!() };
            assert!(found[0].message.contains(what), "{}", found[0].message);
        }
    }
}
