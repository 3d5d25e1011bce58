//! The questions about a model, as they are read: a target, properties, those of a file, or those that the model names.

use std::sync::Arc;

use super::Model;
use meliora_base::error::{Error, Result, SourceFile};
use meliora_engine::Scope;
use meliora_lang as lang;
use meliora_model::Program;
use meliora_question::answers::PropertyAnswer;
use meliora_question::list::{self, Listed};
use meliora_question::plan::Plan;
use meliora_question::{Asking, Questions, Stopping};

/// The questions.
#[derive(Debug, Clone, Copy)]
pub enum Properties<'a> {
    /// A condition on states that is to be reached.
    Target(&'a str),
    /// Texts, and names of those that the model names.
    Texts(&'a [&'a str]),
    /// The same, where one that cannot be read has a reason, as in a file.
    Each(&'a [&'a str]),
    /// Properties of a file in PRISM's language.
    File(PropertyFile<'a>),
    /// All that the model names.
    Named,
}

/// The properties of a file.
#[derive(Debug, Clone, Copy)]
pub struct PropertyFile<'a> {
    /// The text.
    pub source: &'a Arc<SourceFile>,
    /// Values for its constants: `K=4`, or the empty text.
    pub constants: &'a Arc<SourceFile>,
    /// The name of the only property that is asked for.
    pub only: Option<&'a str>,
}

/// The conditions of the questions.
#[derive(Debug, Clone, Copy, Default)]
pub struct Terms<'a> {
    /// Safe formulas that every strategy must keep: `G p`.
    pub require: &'a [String],
    /// The states behind those that decide the question, one target or property, are not explored: the answer in the
    /// initial states is the same.
    pub stops_at_target: bool,
    /// The regions of all properties are wanted.
    pub regions: bool,
    /// The text before the names of options in errors: `--` on a command line.
    pub prefix: &'a str,
}

impl Terms<'_> {
    /// Checks that paths can stop where the question is decided.
    ///
    /// # Errors
    /// [`Error::Usage`].
    pub fn check_stop(&self, is_one: bool, scope: Scope) -> Result<()> {
        let [stop, require, scope_all] =
            ["stop-at-target", "require", "scope all"].map(|name| self.option(name));
        let (other, why) = if !self.stops_at_target {
            return Ok(());
        } else if !is_one {
            return Err(self.stops_nowhere());
        } else if !self.require.is_empty() {
            (require, "which must be kept behind the target, too")
        } else if scope == Scope::All {
            (scope_all, "in which every valuation is a state")
        } else {
            return Ok(());
        };
        Err(Error::Usage(format!("`{stop}` cannot be used with `{other}`, {why}; leave out one of the two")))
    }

    fn stops_nowhere(&self) -> Error {
        let [stop, target, property] = ["stop-at-target", "target", "property"].map(|name| self.option(name));
        Error::Usage(format!(
            "`{stop}` needs one `{target}` or one `{property}`, since each question is decided in other states"
        ))
    }

    /// Returns an option as the caller writes it.
    fn option(&self, name: &str) -> String {
        if self.prefix.is_empty() { name.replace(['-', ' '], "_") } else { format!("{}{name}", self.prefix) }
    }
}

impl Properties<'_> {
    /// Returns whether this is one question, an error of which ends the work.
    pub fn is_one(&self) -> bool {
        matches!(self, Properties::Target(_) | Properties::Texts([_]) | Properties::Each([_]))
    }
}

impl Model {
    /// Returns the question of a planning problem: whether a plan reaches its goal almost surely; `None` if there is no
    /// goal that must hold.
    pub fn goal_property(&self) -> Option<&'static str> {
        list::of_goal(self.program())
    }

    /// Returns the names of the properties that the model names.
    pub fn properties(&self) -> impl Iterator<Item = &str> {
        self.properties.iter().map(|property| property.name.as_str())
    }

    /// Reads and plans questions. Returns them with an entry for each property: those that cannot be answered have a
    /// reason.
    ///
    /// # Errors
    /// A text is wrong, each error with its place; no state decides the question at which paths stop.
    pub fn questions(
        self,
        properties: Properties<'_>,
        terms: &Terms<'_>,
    ) -> Result<(Questions, Vec<PropertyAnswer>)> {
        if terms.stops_at_target {
            return self.stopping_at(properties, terms);
        }
        let (mut program, named) = self.into_parts();
        let required = list::required(&terms.option("require"), terms.require.iter().map(String::as_str))?;
        let name = terms.option("property");
        let plan = match properties {
            Properties::Target(text) => {
                let source = SourceFile::new(terms.option("target"), text);
                Plan::of(Asking::target(&program, &source, &required)?, text)
            }
            Properties::Texts(texts) => {
                let texts = texts.iter().copied();
                list::planned((&program, &named), (&name, texts), &required, terms.regions)?
            }
            Properties::Each(_) | Properties::File(_) | Properties::Named => {
                let all = match properties {
                    Properties::File(file) => file.listed(&mut program)?,
                    Properties::Each(texts) => list::each((&program, &named), (&name, texts)),
                    _ => list::named(&program, &named),
                };
                let (plan, entries) = list::list(&program, &required, terms.regions, all.into_iter())?;
                return Ok((Questions::new(program, plan, required, true), entries));
            }
        };
        Ok(opened(Questions::new(program, plan, required, false)))
    }

    fn stopping_at(
        self,
        properties: Properties<'_>,
        terms: &Terms<'_>,
    ) -> Result<(Questions, Vec<PropertyAnswer>)> {
        let (program, named) = self.into_parts();
        let (program, plan) = match properties {
            Properties::Target(text) => {
                let source = SourceFile::new(terms.option("target"), text);
                let Stopping { program, asking } = Stopping::target(&program, &source)?;
                (program, Plan::of(asking, text))
            }
            Properties::Texts([text]) | Properties::Each([text]) => {
                Stopping::property((&program, &named), (&terms.option("property"), text))?
            }
            _ => return Err(terms.stops_nowhere()),
        };
        Ok(opened(Questions::new(program, plan, Vec::new(), false)))
    }
}

/// Returns questions with an entry without an answer for each.
fn opened(questions: Questions) -> (Questions, Vec<PropertyAnswer>) {
    let texts = questions.plan.properties.iter().map(|property| property.text.clone());
    let entries = texts.map(|text| PropertyAnswer::open(None, text, None)).collect();
    (questions, entries)
}

impl PropertyFile<'_> {
    /// Returns the properties that are asked for; the program gets the definitions of the file.
    ///
    /// # Errors
    /// A definition is wrong; no property has the name.
    fn listed(&self, program: &mut Program) -> Result<Vec<Listed>> {
        let mut stated = lang::parse_properties(self.source, self.constants, program)?;
        if let Some(only) = self.only {
            stated.retain(|stated| stated.name.as_deref() == Some(only));
            if stated.is_empty() {
                return Err(list::no_property(self.source, only));
            }
        }
        Ok(stated.into_iter().map(Listed::from).collect())
    }
}
