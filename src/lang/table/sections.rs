//! The sections of PRISM's explicit files: a file of transitions, or one file (`.pexp`) in which states,
//! labels and rewards follow the transitions. A heading such as `# States` begins each of them.

use std::sync::Arc;

use super::lines::{Line, Part};
use meliora_model::ModelKind;
use meliora_model::error::{Result, SourceFile};

/// The parts of a file.
pub(super) struct Sections<'s> {
    /// The heading of the transitions, `# Transitions (MDP)`.
    heading: Option<Line<'s>>,
    pub(super) transitions: Part<'s>,
    pub(super) states: Option<Part<'s>>,
    pub(super) labels: Option<Part<'s>>,
    /// The name in the heading of the first section that is not read.
    pub(super) unread: Option<&'static str>,
}

/// Returns true if a file has the values or the labels of its states, too.
pub(crate) fn has_states(source: &Arc<SourceFile>) -> bool {
    let sections = Sections::of(source);
    sections.states.or(sections.labels).is_some()
}

impl<'s> Sections<'s> {
    /// Finds the sections of a file. What comes before the first heading are transitions.
    pub(super) fn of(source: &'s Arc<SourceFile>) -> Self {
        let part = |range| Part { source, range };
        let mut sections =
            Sections { heading: None, transitions: part(0..0), states: None, labels: None, unread: None };
        let (mut name, mut start) = ("Transitions", 0);
        for line in part(0..source.text.len()).all_lines() {
            let Some(next) = heading(line.text) else { continue };
            sections.add(name, part(start..line.start()));
            if next == "Transitions" {
                sections.heading = Some(line);
            }
            (name, start) = (next, line.start() + line.text.len());
        }
        sections.add(name, part(start..source.text.len()));
        sections
    }

    fn add(&mut self, name: &'static str, part: Part<'s>) {
        match name {
            // Comments may stand before the heading.
            "Transitions" => self.transitions = part,
            "States" => self.states = Some(part),
            "Labels" => self.labels = Some(part),
            _ => {
                self.unread.get_or_insert(name);
            }
        }
    }

    /// Checks that the heading of the transitions names the type that the numbers of the first line have.
    ///
    /// # Errors
    /// The type is another one, or not supported.
    pub(super) fn check_type(&self, found: ModelKind) -> Result<()> {
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
        Err(heading
            .wrong(format!("this heading names the type {name}, but the first line is that of a {found}")))
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
