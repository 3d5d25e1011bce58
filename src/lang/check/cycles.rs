//! Detection of constants and formulas that depend on themselves.

use super::lowerer::{Lowerer, MAX_ERRORS};
use super::scope::{DefId, NO_RENAMING};

/// Maximum number of definitions of a cycle that are shown.
const MOST_SHOWN: usize = 10;

/// State of a definition in the depth-first search.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Mark {
    New,
    Open,
    Done,
}

impl Lowerer<'_> {
    /// Reports each cycle found by a depth-first search; returns true if there is one.
    pub(super) fn find_cycles(&mut self) -> bool {
        let mut marks = vec![Mark::New; self.scope.definitions.len()];
        let mut found = false;
        for root in 0..marks.len() {
            if self.poll.should_stop() {
                break;
            }
            // The path from the root, each definition with its dependencies not yet visited.
            let mut path: Vec<(DefId, Vec<DefId>)> = Vec::new();
            self.open(root as DefId, &mut marks, &mut path);
            while let Some((at, rest)) = path.last_mut() {
                let Some(next) = rest.pop() else {
                    marks[*at as usize] = Mark::Done;
                    path.pop();
                    continue;
                };
                if marks[next as usize] == Mark::Open {
                    found = true;
                    if self.diagnostics.len() >= MAX_ERRORS {
                        continue;
                    }
                    let start = path.iter().position(|(d, _)| *d == next).unwrap_or(0);
                    let cycle: Vec<DefId> = path[start..].iter().map(|(d, _)| *d).collect();
                    self.report_cycle(&cycle);
                } else {
                    self.open(next, &mut marks, &mut path);
                }
            }
        }
        found
    }

    fn open(&self, definition: DefId, marks: &mut [Mark], path: &mut Vec<(DefId, Vec<DefId>)>) {
        if marks[definition as usize] == Mark::New {
            marks[definition as usize] = Mark::Open;
            let dependencies = self.dependencies(definition, NO_RENAMING);
            path.push((definition, dependencies.into_iter().map(|(d, _)| d).rev().collect()));
        }
    }

    fn report_cycle(&mut self, cycle: &[DefId]) {
        let Some(&first) = cycle.first() else { return };
        let (shown, left_out) = cycle.split_at(cycle.len().min(MOST_SHOWN));
        let name = |d: &DefId| self.scope.definitions[*d as usize].name.to_owned();
        let mut names: Vec<String> = shown.iter().map(name).collect();
        if !left_out.is_empty() {
            names.push(format!("({} more)", left_out.len()));
        }
        names.push(name(&first));
        let kind =
            if self.scope.definitions[first as usize].constant.is_some() { "constant" } else { "formula" };
        let definition = &self.scope.definitions[first as usize];
        let mut diagnostic = self
            .wrong(definition.span, format!("the {kind} `{}` depends on itself", definition.name))
            .note(names.join(" -> "));
        for &d in &shown[1..] {
            diagnostic = diagnostic.related(self.scope.definitions[d as usize].span.range(), "through this");
        }
        self.report(diagnostic);
    }
}
