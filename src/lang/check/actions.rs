//! The actions of a model, and the numbers of commands.

use ahash::AHashMap;

/// Actions in the order of their first occurrence.
#[derive(Default)]
pub struct Actions {
    /// Names for users.
    pub names: Vec<String>,
    index: AHashMap<String, usize>,
    numbers: AHashMap<(usize, Option<usize>), usize>,
}

impl Actions {
    /// Returns the position of an action, which is added if it is new.
    pub fn add(&mut self, name: &str) -> usize {
        if let Some(&index) = self.index.get(name) {
            return index;
        }
        self.names.push(name.to_owned());
        self.index.insert(name.to_owned(), self.names.len() - 1);
        self.names.len() - 1
    }

    pub(crate) fn get(&self, name: &str) -> Option<usize> {
        self.index.get(name).copied()
    }

    /// Returns the number of the next command of a module with an action, from 1 on.
    pub fn next_number(&mut self, module: usize, action: Option<usize>) -> usize {
        let number = self.numbers.entry((module, action)).or_default();
        *number += 1;
        *number
    }
}
