//! Conversion of the model's names to distinct names of the modelling language.

use ahash::{AHashMap, AHashSet};

use super::token::is_keyword;

/// Names in use.
#[derive(Default)]
pub(crate) struct Names {
    taken: AHashSet<String>,
    /// For each name, the number at which the search for a free name continues.
    next: AHashMap<String, usize>,
    /// Names that had to be changed, with their replacements.
    pub(crate) changed: Vec<(String, String)>,
}

impl Names {
    /// Returns a new name as close as possible to the wanted one. Characters that the modelling
    /// language does not allow become `_`, a keyword gets `_` at its end, and a name in use gets a
    /// number.
    pub(crate) fn add(&mut self, wanted: &str) -> String {
        let name = self.free(&identifier(wanted));
        self.taken.insert(name.clone());
        name
    }

    /// Same as [`Names::add`]; also records a name that differs from the model's.
    pub(crate) fn add_of_model(&mut self, wanted: &str) -> String {
        let name = self.add(wanted);
        if name != wanted {
            self.changed.push((wanted.to_owned(), name.clone()));
        }
        name
    }

    /// Returns a name for each wanted one, as [`Names::add`] does; identifiers stay as they are.
    pub(crate) fn identifiers<'n>(wanted: impl Iterator<Item = &'n String> + Clone) -> Vec<String> {
        let is_identifier = |name: &&String| identifier(name) == **name;
        let taken = wanted.clone().filter(is_identifier).cloned().collect();
        let mut names = Names { taken, ..Names::default() };
        let add = |name: &String| if is_identifier(&name) { name.clone() } else { names.add(name) };
        wanted.map(add).collect()
    }

    fn free(&mut self, name: &str) -> String {
        if !self.taken.contains(name) {
            return name.to_owned();
        }
        let number = self.next.entry(name.to_owned()).or_insert(2);
        loop {
            let numbered = format!("{name}_{number}");
            *number += 1;
            if !self.taken.contains(&numbered) {
                return numbered;
            }
        }
    }
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

#[cfg(test)]
mod tests {
    use super::Names;

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
