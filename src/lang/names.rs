//! Conversion of the model's names to distinct names of the modelling language, and of all names to
//! names that can be shown.

use std::ops::Range;
use std::sync::Arc;

use ahash::{AHashMap, AHashSet};

use super::check::Checked;
use super::jani;
use super::token::{is_identifier, is_keyword, is_property_operator};
use meliora_base::error::{Diagnostic, Severity, SourceFile};
use meliora_base::escape;
use meliora_base::span::Span;

/// Names in use.
#[derive(Default)]
pub struct Names {
    taken: AHashSet<String>,
    /// Names that are given to those who want exactly them.
    kept: AHashSet<String>,
    /// For each name, the number at which the search for a free name continues.
    next: AHashMap<String, usize>,
    /// The names that had to be changed.
    pub changed: Vec<Changed>,
}

/// A name of a model that had to be changed.
pub struct Changed {
    /// The name in the model.
    pub name: String,
    /// The name in its place.
    pub replacement: String,
    /// The place of the name.
    pub at: Span,
}

impl Names {
    /// Returns a new name as close as possible to the wanted one. Characters that the modelling
    /// language does not allow become `_`, a keyword gets `_` at its end, and a name in use gets a
    /// number.
    pub fn add(&mut self, wanted: &str) -> String {
        let wanted_identifier = identifier(wanted);
        let is_own = wanted_identifier == wanted && self.kept.remove(wanted);
        let name = if is_own { wanted_identifier } else { self.free(&wanted_identifier) };
        self.taken.insert(name.clone());
        name
    }

    /// Same as [`Names::add`]; also records a name that differs from the model's, with its place.
    pub fn add_of_model(&mut self, wanted: &str, at: Span) -> String {
        let name = self.add(wanted);
        if name != wanted {
            self.changed.push(Changed { name: wanted.to_owned(), replacement: name.clone(), at });
        }
        name
    }

    /// Returns a name that may have any characters; one in use gets a number.
    pub(crate) fn distinct(&mut self, wanted: &str) -> String {
        let name = self.free(wanted);
        self.taken.insert(name.clone());
        name
    }

    /// Keeps the identifiers among some names for those who want exactly them.
    pub(crate) fn keep<'n>(&mut self, names: impl Iterator<Item = &'n str>) {
        self.kept.extend(names.filter(|name| identifier(name) == **name).map(str::to_owned));
    }

    /// Returns a name outside of formulas for each wanted one, as [`Names::add`] does; those that models may
    /// have stay as they are.
    pub(crate) fn identifiers<'n>(wanted: impl Iterator<Item = &'n String> + Clone) -> Vec<String> {
        let fits = |name: &&String| is_identifier(name) && (is_property_operator(name) || !is_keyword(name));
        let taken = wanted.clone().filter(fits).cloned().collect();
        let mut names = Names { taken, ..Names::default() };
        let add = |name: &String| if fits(&name) { name.clone() } else { names.add(name) };
        wanted.map(add).collect()
    }

    fn free(&mut self, name: &str) -> String {
        if self.is_free(name) {
            return name.to_owned();
        }
        let number = self.next.entry(name.to_owned()).or_insert(2);
        loop {
            let numbered = format!("{name}_{number}");
            *number += 1;
            if !self.taken.contains(&numbered) && !self.kept.contains(&numbered) {
                return numbered;
            }
        }
    }

    fn is_free(&self, name: &str) -> bool {
        !self.taken.contains(name) && !self.kept.contains(name)
    }
}

/// Returns the replacement of a name as a warning.
pub fn renamed(source: &Arc<SourceFile>, Changed { name, replacement, at }: &Changed) -> Diagnostic {
    let message = format!("`{name}` is renamed to `{replacement}`: it is not a name in PRISM's language");
    Diagnostic::new(source, at.range(), message).severity(Severity::Warning)
}

fn identifier(name: &str) -> String {
    let letter = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '_' };
    let mut identifier: String = name.chars().map(letter).collect();
    if identifier.is_empty() || identifier.starts_with(|c: char| c.is_ascii_digit()) {
        identifier.insert(0, '_');
    }
    if is_keyword(&identifier) {
        identifier.push('_');
    }
    identifier
}

/// Replaces the characters of all names that terminals do not display by escapes such as `\u{1b}`,
/// with a warning. Names stay distinct.
pub fn displayed(mut checked: Checked) -> Checked {
    let program = &mut checked.program;
    let mut changed = Vec::new();
    display(program.actions.iter_mut(), &mut changed);
    display(program.modules.iter_mut(), &mut changed);
    display(program.labels.iter_mut().map(|label| &mut label.0), &mut changed);
    display(program.rewards.iter_mut().filter_map(|rewards| rewards.name.as_mut()), &mut changed);
    display(checked.properties.iter_mut().map(|property| &mut property.name), &mut changed);
    for variable in &mut program.variables {
        display(variable.values.iter_mut(), &mut changed);
    }
    if let Some(first) = changed.first() {
        let others = changed.len() - 1;
        let more = if others == 0 { String::new() } else { format!(" (and {others} more)") };
        let message =
            format!("`{first}`{more}: the name has characters that are not displayed, which are escaped");
        let warning = Diagnostic::new(&program.source, place(&program.source, first), message)
            .severity(Severity::Warning);
        checked.warnings.push(warning);
    }
    checked
}

/// Returns the first place of a name in a model: as a string of JSON, as it is, or as one word.
fn place(source: &SourceFile, name: &str) -> Range<usize> {
    let text = &source.text;
    let find = |written: &str| text.find(written).map(|at| at..at + written.len());
    let found = jani::string_at(text, name).or_else(|| find(name)).or_else(|| find(&escape::word(name)));
    found.unwrap_or_default()
}

fn display<'n>(names: impl Iterator<Item = &'n mut String>, changed: &mut Vec<String>) {
    let is_shown = |name: &&mut String| name.chars().all(escape::is_shown);
    let (kept, others): (Vec<_>, Vec<_>) = names.partition(is_shown);
    if others.is_empty() {
        return;
    }
    let taken = kept.into_iter().map(|name| name.clone()).collect();
    let mut names = Names { taken, ..Names::default() };
    for name in others {
        let shown = names.free(&escape::line(name));
        names.taken.insert(shown.clone());
        changed.push(std::mem::replace(name, shown));
    }
}

#[cfg(test)]
mod tests {
    use super::{Names, display};

    #[test]
    fn names_that_are_not_displayed_are_escaped_and_stay_distinct() {
        let mut names = ["\u{1b}a", "go left", "\\u{1b}a", "\u{202e}\n", "\u{1b}a_2"].map(str::to_owned);
        let mut changed = Vec::new();
        display(names.iter_mut(), &mut changed);
        assert_eq!(names, ["\\u{1b}a_2", "go left", "\\u{1b}a", "\\u{202e}\\n", "\\u{1b}a_2_2"]);
        assert_eq!(changed, ["\u{1b}a", "\u{202e}\n", "\u{1b}a_2"]);
    }

    #[test]
    fn names_become_names_of_the_language_each_once() {
        let mut names = Names::default();
        assert_eq!(names.add("x.y"), "x_y");
        assert_eq!(names.add("x_y"), "x_y_2");
        assert_eq!(names.add("F"), "F_");
        assert_eq!(names.add("2é"), "_2_");
        assert_eq!(names.add("x y"), "x_y_3");
    }
}
