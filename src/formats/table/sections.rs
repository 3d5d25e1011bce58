//! The sections of PRISM's explicit files: a file of transitions, or one file (`.pexp`) in which states,
//! labels and rewards follow the transitions. A heading such as `# States` begins each of them.

use std::sync::Arc;

use super::lines::{Line, Part};
use meliora_base::error::{Result, SourceFile};
use meliora_model::ModelKind;

/// The parts of a file.
pub(super) struct Sections<'s> {
    /// The heading of the transitions, `# Transitions (MDP)`.
    heading: Option<Line<'s>>,
    pub(super) transitions: Part<'s>,
    pub(super) states: Option<Part<'s>>,
    pub(super) labels: Option<Part<'s>>,
    /// The name in the heading of the first section that is not read.
    pub(super) unread: Option<&'static str>,
    /// The heading of a section that the file has already.
    again: Option<Line<'s>>,
}

/// Returns true if a file has the values or the labels of its states, too.
pub(crate) fn has_states(source: &Arc<SourceFile>) -> bool {
    let sections = Sections::find(source);
    sections.states.or(sections.labels).is_some()
}

impl<'s> Sections<'s> {
    /// Finds the sections of a file. Lines before the first heading are transitions.
    pub(super) fn find(source: &'s Arc<SourceFile>) -> Self {
        let part = |range| Part { source, range };
        let (transitions, states, labels) = (part(0..0), None, None);
        let mut sections = Sections { heading: None, transitions, states, labels, unread: None, again: None };
        let (mut name, mut start, mut begin) = ("Transitions", 0, None);
        for line in part(0..source.text.len()).all_lines() {
            let Some(next) = heading(line.text) else { continue };
            sections.add(name, part(start..line.start()), begin);
            if next == "Transitions" {
                sections.heading = Some(line);
            }
            (name, start, begin) = (next, line.start() + line.text.len(), Some(line));
        }
        sections.add(name, part(start..source.text.len()), begin);
        sections
    }

    fn add(&mut self, name: &'static str, part: Part<'s>, begin: Option<Line<'s>>) {
        let known = match name {
            // Comments may stand before the heading.
            "Transitions" => Some(std::mem::replace(&mut self.transitions, part)),
            "States" => self.states.replace(part),
            "Labels" => self.labels.replace(part),
            _ => {
                self.unread.get_or_insert(name);
                None
            }
        };
        if known.is_some_and(|part| part.lines("#").next().is_some()) {
            self.again = self.again.or(begin);
        }
    }

    /// Checks that no section occurs twice, and that the heading of the transitions names the type that the
    /// numbers of the first line have.
    ///
    /// # Errors
    /// A section occurs twice; the type is another one, or not supported.
    pub(super) fn check(&self, found: ModelKind) -> Result<()> {
        if let Some(again) = self.again {
            return Err(again.wrong("this section occurs twice"));
        }
        let Some(heading) = self.heading else { return Ok(()) };
        let name = heading.text.split_once('(').and_then(|(_, rest)| rest.strip_suffix(')'));
        let Some(name) = name.map(str::trim) else { return Ok(()) };
        let named = match name.to_ascii_uppercase().as_str() {
            "MDP" => ModelKind::Mdp,
            "DTMC" => ModelKind::Dtmc,
            "SMG" => ModelKind::Smg,
            _ => return Err(heading.refused(&format!("models of type {name}"))),
        };
        if named == found {
            return Ok(());
        }
        let found = <&str>::from(found);
        let but = format!("but the first line has the numbers of the type `{found}`");
        Err(heading.wrong(format!("this heading names the type {name}, {but}")))
    }
}

/// Returns the name of the section that a line begins.
fn heading(line: &str) -> Option<&'static str> {
    const NAMES: [&str; 5] = ["Transitions", "States", "Labels", "Observations", "Reward structure"];
    let text = line.strip_prefix("# ")?;
    NAMES.into_iter().find(|name| {
        text.strip_prefix(name)
            .is_some_and(|rest| rest.is_empty() || rest.starts_with(" (") || rest.starts_with(" \""))
    })
}
