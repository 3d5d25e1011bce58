//! The questions of `meliora reach`, as the command line gives them: a target, properties, those of a file, or those that
//! the model names.

use std::path::Path;

use meliora::{Model, Properties, PropertyFile, Terms};
use meliora_base::error::{Error, SourceFile};
use meliora_engine::NoProgress;
use meliora_lang::{open_constants, outline_properties, parse_properties, refuse_values, split_constants};
use meliora_question::answers::PropertyAnswer;
use meliora_question::{Questions, list};

use super::load;
use super::options::ModelArgs;
use super::progress::TerminalSink;

/// The questions, and an entry of the report for each property; one that cannot be answered has a reason.
pub(super) type Read = (Questions, Vec<PropertyAnswer>);

/// The questions of the command line as texts.
#[derive(Default)]
pub(super) struct Texts<'a> {
    pub(super) target: Option<&'a str>,
    pub(super) properties: &'a [String],
    /// A property file.
    pub(super) file: Option<&'a Path>,
    /// The name of the only property of the file that is asked for.
    pub(super) only: Option<&'a str>,
    /// All properties that the model names.
    pub(super) all_named: bool,
    pub(super) terms: Terms<'a>,
}

impl Texts<'_> {
    /// Returns whether there is one question: a target or a single property.
    pub(super) fn is_one(&self) -> bool {
        self.file.is_none() && !self.all_named && self.properties.len() <= 1
    }

    /// Reads the model and the questions.
    ///
    /// # Errors
    /// A file, the constants, the bounds or an expression is wrong; nothing is asked.
    pub(super) fn read(&self, args: &ModelArgs, sink: &TerminalSink) -> Result<Read, Error> {
        if let Some(file) = self.file {
            return self.read_file(file, args, sink);
        }
        let is_goal = self.target.is_none() && self.properties.is_empty() && !self.all_named;
        let for_goals = is_goal && self.terms.require.is_empty() && !self.terms.stops_at_target;
        self.plan(load::parsed_for(args, for_goals, sink)?)
    }

    /// Plans the questions that are not in a file. Without any, a planning problem is asked for its goal.
    ///
    /// # Errors
    /// Nothing is asked, and the model has no goal that must hold; a question is wrong.
    fn plan(&self, model: Model) -> Result<Read, Error> {
        if let Some(target) = self.target {
            return model.questions(Properties::Target(target), &self.terms);
        }
        if self.all_named {
            if model.properties().next().is_none() {
                return Err(without_question(&model));
            }
            return model.questions(Properties::Named, &self.terms);
        }
        let texts: Vec<&str> = match (self.properties, model.goal_property()) {
            ([], Some(goal)) => vec![goal],
            ([], None) if model.program().planning.is_some() => {
                return Err(Error::Usage(list::NO_GOAL.to_owned()));
            }
            ([], None) => return Err(without_question(&model)),
            (properties, _) => properties.iter().map(String::as_str).collect(),
        };
        model.questions(Properties::Texts(&texts), &self.terms)
    }

    /// Reads the model with the definitions of a property file, and its properties.
    fn read_file(&self, file: &Path, args: &ModelArgs, sink: &TerminalSink) -> Result<Read, Error> {
        let source = load::read(file)?;
        sink.warn_at(&Vec::from_iter(source.encoding_warning()));
        let given = SourceFile::new("--const", args.constants());
        refuse_values(&source, &given)?;
        let mut open = open_constants(&source)?;
        if !open.is_empty() && !args.model.has_stdin() {
            // A constant that both declare is refused at its place in the file.
            let declared = load::document(&args.model)?.constants();
            open.retain(|name| !declared.contains(name));
        }
        let [constants, others] = split_constants(&given, &open)?;
        let model = load::parsed(&args.with_constants(&others.text), sink)?;
        let asked = PropertyFile { source: &source, constants: &constants, only: self.only };
        model.questions(Properties::File(asked), &self.terms)
    }

    /// Checks what the instances of a sweep share.
    ///
    /// # Errors
    /// A question, or a definition of the property file is wrong.
    pub(super) fn check(&self, model: Model) -> Result<(), Error> {
        match self.file {
            Some(file) => {
                let none = SourceFile::new("--const", "");
                parse_properties(&load::read(file)?, &none, &mut model.into_program()).map(drop)
            }
            // The model names them, and each has its own reason if it is not answered.
            None if self.all_named => Ok(()),
            None => self.plan(model).map(drop),
        }
    }

    /// Returns the names of the properties, or their texts where they have no name, if the constants have these values.
    ///
    /// # Errors
    /// A file or a value is wrong; the property file has no property with the name that is asked for, or the value of a
    /// given constant already.
    pub(super) fn titles(&self, args: &ModelArgs, constants: &str) -> Result<Vec<String>, Error> {
        let Some(file) = self.file else {
            if !self.all_named {
                return Ok(self.properties.to_vec());
            }
            let given = load::given("--const", constants, args.bounds());
            let checked = load::document(&args.model)?.load(&given, &NoProgress)?;
            return Ok(checked.properties.into_iter().map(|property| property.name).collect());
        };
        let source = load::read(file)?;
        let given = SourceFile::new("--const", constants);
        refuse_values(&source, &given)?;
        let all = outline_properties(&source)?.into_iter();
        let is_asked = |name: &Option<String>| self.only.is_none_or(|only| name.as_deref() == Some(only));
        let chosen: Vec<_> = all.filter(|(name, _)| is_asked(name)).collect();
        match self.only {
            Some(only) if chosen.is_empty() => Err(list::no_property(&source, only)),
            _ => Ok(chosen.into_iter().map(|(name, text)| name.unwrap_or(text)).collect()),
        }
    }
}

/// Returns the error for `reach` without a question: it lists what the model can be asked.
fn without_question(model: &Model) -> Error {
    let names: Vec<String> = model.properties().map(|name| format!("`{name}`")).collect();
    let message = match names.as_slice() {
        [] => {
            "a question is missing: `--target EXPR`, `--property PROPERTY` or `--properties FILE`; the model \
               itself names no properties"
                .to_owned()
        }
        names => format!(
            "a question is missing; the model names the properties {}: `--property NAME` answers one, \
             `--all-properties` answers all, and `--target EXPR` or `--properties FILE` ask others",
            names.join(", ")
        ),
    };
    Error::Usage(message)
}
